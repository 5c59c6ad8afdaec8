"""Sedimentation of 300 triangles (Wachs et al. 2009): `python3 cases/settling-2d/triangles.py` places them at random, runs
triangles.toml, prints how they settle, and draws triangles.png."""
import math
import sys
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
import sweep

COUNT, WIDTH, HEIGHT, GAP = 300, 24, 49, 0.05
CORNERS = np.array([(-0.67340, -0.38879), (0.67340, -0.38879), (0, 0.77757)])


def turned(center, angle):
    """Corners (x, z) of a triangle turned about y."""
    c, s = math.cos(angle), math.sin(angle)
    return center + CORNERS @ np.array([[c, -s], [s, c]])


def apart(a, b):
    """Whether a side of one of two triangles parts them by a gap."""
    for p, q in ((a, b), (b, a)):
        sides = np.roll(p, -1, axis=0) - p
        normals = np.stack([sides[:, 1], -sides[:, 0]], axis=1) / np.linalg.norm(sides, axis=1)[:, None]
        if np.any(np.min(normals @ q.T, axis=1) - np.sum(normals * p, axis=1) > GAP):
            return True
    return False


def placed(seed):
    """Rows x, y, z, qw, qx, qy, qz of triangles at random that are apart."""
    random, rows, polygons = np.random.default_rng(seed), [], []
    while len(rows) < COUNT:
        center, angle = random.uniform((0.85, 0.85), (WIDTH - 0.85, HEIGHT - 0.85)), random.uniform(0, 2 * math.pi)
        new = turned(center, angle)
        near = [p for r, p in zip(rows, polygons) if math.hypot(r[0] - center[0], r[2] - center[1]) < 1.6 + GAP]
        if all(apart(new, other) for other in near):
            rows.append((center[0], 0, center[1], math.cos(angle / 2), 0, math.sin(angle / 2), 0))
            polygons.append(new)
    return rows


def main():
    folder = sweep.RESULTS / "settling-2d" / "triangles"
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "triangles.csv", "w") as file:
        file.write("x,y,z,qw,qx,qy,qz\n")
        file.writelines(",".join(map(repr, map(float, row))) + "\n" for row in placed(1))
    case = (HERE / "triangles.toml").read_text()
    start, end = case.index("count = 300"), case.index("\n\n[[wall]]")
    case = case[:start] + f'place = {{ kind = "file", path = "{folder / "triangles.csv"}" }}' + case[end:]
    case = case.replace('"results/settling-2d/triangles"', f'"{folder / "run"}"')
    sweep.run_all([(case, folder)], 1)
    with h5py.File(folder / "run/particles.vtkhdf") as file, h5py.File(folder / "run/fluid.vtkhdf") as fluid:
        group = file["VTKHDF"]
        times, starts = group["Steps/Values"][:], group["Steps/PointOffsets"][:]
        part = lambda name, step: group[name][starts[step] : starts[step] + COUNT]
        speeds = np.array([-part("PointData/velocity", step)[:, 2].mean() for step in range(len(times))])
        heights = np.array([part("Points", step)[:, 2].mean() for step in range(len(times))])
        tops = np.array([part("Points", step)[:, 2].max() for step in range(len(times))])
        early = (times > 1) & (times < 5)
        print(f"settle at {speeds[early].mean():.3f} U_c from t = 1 to 5; mean height {heights[0]:.2f} to {heights[-1]:.2f},")
        print(f"highest centre {tops[-1]:.2f}, mean speed {speeds[-1]:.1e} at t = {times[-1]:g}")
        series = sweep.table(folder / "run/series.csv")
        print(f"largest overlap {max(float(row['max_overlap']) for row in series):.4f} of the inscribed radius")
        figure, axes = plt.subplots(1, 5, figsize=(13, 6), layout="constrained", width_ratios=[1, 1, 1, 1, 1.4])
        for axis, time in zip(axes, (0, times[-1] / 6, times[-1] / 3, times[-1])):
            step = np.abs(times - time).argmin()
            shown = np.abs(fluid["VTKHDF/Steps/Values"][:] - times[step]).argmin()
            w = fluid["VTKHDF/CellData/velocity"][shown][:, 0, :, 2]
            picture = axis.imshow(w, origin="lower", extent=(0, WIDTH, 0, HEIGHT), cmap="RdBu_r", vmin=-3, vmax=3)
            q = part("PointData/orientation_wxyz", step)
            angles = 2 * np.arctan2(q[:, 2], q[:, 0])
            bodies = [turned(p[[0, 2]], a) for p, a in zip(part("Points", step), angles)]
            axis.add_collection(PolyCollection(bodies, facecolors="0.25", edgecolors="none"))
            axis.set(title=f"t = {times[step]:.1f}", xlim=(0, WIDTH), ylim=(0, HEIGHT), aspect="equal")
        figure.colorbar(picture, ax=axes[3], label="vertical velocity / U_c")
        axes[4].plot(times, speeds)
        axes[4].set(xlabel="t U_c / D", ylabel="mean settling speed / U_c")
        figure.savefig(HERE / "triangles.png", dpi=100)


if __name__ == "__main__":
    main()
