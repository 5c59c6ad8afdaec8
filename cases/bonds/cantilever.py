"""Deflection and frequency of cantilever.toml beside a Timoshenko beam with lumped masses: `python3 cases/bonds/cantilever.py`, after
`scripts/run cases/bonds/cantilever.toml`."""
import h5py
import numpy as np

BEADS, RADIUS, DENSITY, YOUNG, POISSON, GRAVITY, FACTOR = 19, 1e-3, 2500, 2e7, 0.25, 9.81, 0.9


def theory():
    """Static deflection of the tip (m) and first frequency (Hz) of point masses with rotary inertia on a beam without mass."""
    x = 2 * RADIUS * np.arange(1, BEADS + 1)
    area = np.pi * RADIUS**2
    second = area * RADIUS**2 / 4
    bending, shearing = YOUNG * second, FACTOR * YOUNG / (2 * (1 + POISSON)) * area
    mass = DENSITY * 4 / 3 * np.pi * RADIUS**3
    i, j = np.meshgrid(x, x, indexing="ij")
    near, far = np.minimum(i, j), np.maximum(i, j)
    deflection = near**2 * (3 * far - near) / (6 * bending) + near / shearing
    slope = np.where(i <= j, i * (2 * j - i), j**2) / (2 * bending)
    flexibility = np.block([[deflection, slope.T], [slope, near / bending]])
    inertia = np.r_[np.full(BEADS, mass), np.full(BEADS, 0.4 * mass * RADIUS**2)]
    slowest = np.linalg.eigvals(flexibility * inertia).real.max()
    return mass * GRAVITY * deflection[-1].sum(), 1 / (2 * np.pi * np.sqrt(slowest))


def main():
    with h5py.File("results/bonds/cantilever/particles.vtkhdf") as file:
        group = file["VTKHDF"]
        time, count = group["Steps/Values"][:], BEADS + 1
        ids = group["PointData/id"][:].reshape(len(time), count)
        height = group["Points"][:, 2].reshape(len(time), count)[ids == BEADS]
    frequencies = np.linspace(10, 40, 6001)
    waves = [np.c_[np.ones_like(time), np.cos(w), np.sin(w)] for w in 2 * np.pi * frequencies[:, None] * time]
    fits = [np.linalg.lstsq(wave, height, rcond=None) for wave in waves]
    best = np.argmin([fit[1][0] for fit in fits])
    deflection, frequency = theory()
    print(f"mean deflection {-1e3 * fits[best][0][0]:.4f} mm, beam {1e3 * deflection:.4f} mm")
    print(f"frequency {frequencies[best]:.3f} Hz, beam {frequency:.3f} Hz")
    halves = [np.ptp(half) for half in np.array_split(height, 2)]
    print(f"swing in the first half of the run {1e3 * halves[0]:.4f} mm, in the second {1e3 * halves[1]:.4f} mm")


if __name__ == "__main__":
    main()
