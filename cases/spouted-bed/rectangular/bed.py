"""Mean speed of the beads over the width of the spouted bed at three heights, beside the experiment, and a picture.

Usage: python3 bed.py [results folder] [time from which it averages, s]
"""

import sys
from pathlib import Path

import h5py
import matplotlib
import numpy as np
import pandas as pd

matplotlib.use("Agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).resolve().parent
RESULTS = Path(sys.argv[1]) if len(sys.argv) > 1 else Path("results/spouted-bed/rectangular")
FROM = float(sys.argv[2]) if len(sys.argv) > 2 else 1.5
BED, HEIGHTS, WINDOW = 0.2, (0.15, 0.45, 0.75), 4e-3

yue = pd.read_csv(HERE / "yue2020.csv", comment="#")
edges = np.arange(-0.14, 0.1401, 0.007)
middle = 0.5 * (edges[1:] + edges[:-1])
speeds = {h: [] for h in HEIGHTS}
with h5py.File(RESULTS / "particles.vtkhdf") as file:
    steps = file["VTKHDF/Steps"]
    offsets, times, counts = steps["PointOffsets"][:], steps["Values"][:], file["VTKHDF/NumberOfPoints"][:]
    for offset, count, time in zip(offsets, counts, times):
        if time < FROM:
            continue
        at = file["VTKHDF/Points"][offset : offset + count]
        speed = np.linalg.norm(file["VTKHDF/PointData/velocity"][offset : offset + count], axis=1)
        for h in HEIGHTS:
            near = np.abs(at[:, 2] - h * BED) < WINDOW / 2
            sums, number = (np.histogram(at[near, 0], edges, weights=w)[0] for w in (speed[near], None))
            speeds[h].append(np.divide(sums, number, where=number > 0, out=np.full(len(middle), np.nan)))
print(f"{len(speeds[HEIGHTS[0]])} states from {FROM} to {times[-1]:.2f} s")

figure, axes = plt.subplots(1, 4, figsize=(13, 3.6))
for axis, h in zip(axes, HEIGHTS):
    mean = np.nanmean(speeds[h], axis=0)
    both = 0.5 * (mean + mean[::-1])
    seen = yue[yue.height_over_bed == h]
    error = np.interp(seen.x_mm / 1e3, middle, mean) - seen.speed
    near = seen.x_mm.abs() < 28
    print(f"H/H0 = {h}: rms difference {np.sqrt((error[near] ** 2).mean()):.3f} m/s within 28 mm of the middle, "
          f"{np.sqrt((error[~near] ** 2).mean()):.3f} beyond")
    for x in (3.5, 10.5, 17.5, 24.5):
        sides = [seen.speed.iloc[(seen.x_mm - s * x).abs().argmin()] for s in (-1, 1)]
        print(f"   |x| = {x:4.1f} mm: here {np.interp(x / 1e3, middle, both):.3f}, there {sides[0]:.3f} and {sides[1]:.3f} m/s")
    axis.plot(middle * 1e3, mean, label="grains-mpi")
    axis.plot(seen.x_mm, seen.speed, "k.", label="Yue et al. 2020")
    axis.set(title=f"H/H0 = {h}", xlabel="x (mm)", ylabel="speed (m/s)", ylim=(0, 1.2))
axes[0].legend()
late = slice(offsets[-1], offsets[-1] + counts[-1])
with h5py.File(RESULTS / "particles.vtkhdf") as file:
    at, velocity = file["VTKHDF/Points"][late], file["VTKHDF/PointData/velocity"][late]
front = at[:, 1] < 5e-3
dots = axes[3].scatter(at[front, 0], at[front, 2], s=0.4, c=np.linalg.norm(velocity[front], axis=1), vmax=1, cmap="viridis")
axes[3].set(aspect="equal", xlim=(-0.14, 0.14), ylim=(-0.04, 0.4), xlabel="x (m)", title=f"t = {times[-1]:.2f} s")
figure.colorbar(dots, ax=axes[3], label="speed (m/s)")
figure.tight_layout()
figure.savefig(HERE / "bed.png", dpi=110)
