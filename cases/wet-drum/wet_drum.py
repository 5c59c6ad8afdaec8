"""A drum with dry and with wet beads: `python cases/wet-drum/wet_drum.py [--tensions 0 0.0364 ...]` with the Python that
scripts/python-environment prints. Turns the drum at each surface tension (N/m), goes on where it was stopped, prints the
table of what there is, and draws it into angles.png. With --long the drum of the calibration; otherwise a slice of it, periodic."""
import argparse
import sys
from pathlib import Path

import h5py
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
import sweep

CASE = (HERE / "drum.toml").read_text()
RADIUS, BEAD, DENSITY, VOLUME = 0.069, 2.975e-3, 1768, 2.6e-10
LAW = 'rolling = { kind = "constant" }\n'
# A slice of the drum, periodic along its axis instead of between its ends.
SLICE = [
    ("lower = [-0.07, -0.001, -0.07]\nupper = [0.07, 0.186, 0.07]", "lower = [-0.07, 0, -0.07]\nupper = [0.07, 0.048, 0.07]\nperiodic = [false, true, false]"),
    ("count = 6000", "count = 1557"),
    ("lower = [-0.047, 0.001, -0.045], upper = [0.047, 0.184, 0.045]", "lower = [-0.047, 0, -0.045], upper = [0.047, 0.048, 0.045]"),
    ("height = 0.185\n", ""),
]
FROM, BLOCKS = 2.0, 5


def folder(tension, long):
    return sweep.RESULTS / "wet-drum" / f"{tension:g}{'-long' if long else ''}"


def case(tension, long):
    """The case with bridges of a surface tension (N/m); none of zero."""
    bridge = f'attraction = {{ kind = "liquid_bridge", volume = {VOLUME}, surface_tension = {tension} }}\n'
    text = CASE
    for old, new in [] if long else SLICE:
        assert old in text, old
        text = text.replace(old, new)
    text = text.replace(LAW, LAW + bridge) if tension else text
    return text.replace('"results/wet-drum/dry"', f'"{folder(tension, long) / "run"}"')


def bond(tension):
    """Pull of a bridge between touching beads over the weight of a bead: Willett's fit at V/R³ = 0.00987 and contact."""
    return 0.8719 * 2 * np.pi * BEAD * tension / (DENSITY * 4 / 3 * np.pi * BEAD**3 * 9.81)


def states(run):
    """Time (s), centres (m) and velocities (m/s) of every stored state from FROM on."""
    with h5py.File(run / "particles.vtkhdf") as file:
        group = file["VTKHDF"]
        times, offsets = group["Steps/Values"][:], group["Steps/PointOffsets"][:]
        ends = np.append(offsets[1:], len(group["Points"]))
        for time, first, end in zip(times, offsets, ends):
            if time >= FROM:
                yield time, group["Points"][first:end], group["PointData/velocity"][first:end]


def surface(places, long):
    """Mean height of the ten highest beads at eight places across the drum (m), in the long one near its ends."""
    x, _, z = places[(abs(places[:, 1] - 0.0925) > 0.07) | (not long)].T
    at = np.linspace(-RADIUS / 2, RADIUS / 2, 8)
    return at, np.array([np.sort(z[abs(x - here) < 3e-3])[-10:].mean() for here in at])


def angle_and_speed(places, velocity, long):
    """Angle of the surface (degrees), and mean speed of the beads on its middle (m/s)."""
    slope, middle = np.polyfit(*surface(places, long), 1)
    x, _, z = places.T
    top = (abs(x) < RADIUS / 5) & (z > middle + slope * x - 1.5 * BEAD)
    return np.degrees(np.arctan(-slope)), np.linalg.norm(velocity[top], axis=1).mean()


def measured(tension, long):
    """Means and standard errors of angle (degrees) and speed (m/s), from blocks in time."""
    rows = np.array([angle_and_speed(p, v, long) for _, p, v in states(folder(tension, long) / "run")])
    blocks = np.array([block.mean(axis=0) for block in np.array_split(rows, BLOCKS)])
    return rows.mean(axis=0), blocks.std(axis=0, ddof=1) / BLOCKS**0.5, rows.std(axis=0)


def draw(found):
    """Angle and speed of the surface over the Bond number."""
    bonds, angle, error, speed, speed_error = found[np.argsort(found[:, 0])].T
    figure, left = plt.subplots(figsize=(6, 3.5))
    left.errorbar(bonds, angle, error, fmt="o-", capsize=3)
    left.set(xlabel="Bond number", ylabel="angle of the surface (degrees)")
    right = left.twinx()
    right.errorbar(bonds, speed, speed_error, fmt="s--", color="C1", capsize=3)
    right.set_ylabel("speed of the surface (m/s)", color="C1")
    figure.tight_layout()
    figure.savefig(HERE / "angles.png", dpi=100)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tensions", nargs="+", type=float, default=[0, 0.0182, 0.0364, 0.0728, 0.1456])
    parser.add_argument("--long", action="store_true")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--no-runs", action="store_true", help="the table of what there is")
    options = parser.parse_args()
    points = [(tension, options.long) for tension in options.tensions]
    if not options.no_runs:
        sweep.run_all([(case(*point), folder(*point)) for point in points], options.jobs)
    print(f"{'tension':>7} {'Bond':>5} {'angle':>6} {'error':>6} {'varies':>6} {'whole':>6} {'speed':>6} {'error':>6}")
    found = []
    for point in points:
        if (folder(*point) / "done").exists():
            (angle, speed), (error, speed_error), (varies, _) = measured(*point)
            whole = sweep.analyse("drum", folder(*point), "--time", f"{FROM}:99")
            whole = sum(float(row["angle"]) for row in whole) / len(whole)
            print(f"{point[0]:>7.4f} {bond(point[0]):>5.2f} {angle:>6.1f} {error:>6.2f} {varies:>6.1f} {whole:>6.1f} {speed:>6.3f} {speed_error:>6.4f}")
            found.append((bond(point[0]), angle, error, speed, speed_error))
    if not options.long:
        draw(np.array(found))


if __name__ == "__main__":
    main()
