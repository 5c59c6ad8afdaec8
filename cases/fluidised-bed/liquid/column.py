"""Pressure drop, void fraction and height of the liquid-fluidised column, and a picture of it.

Usage: python3 column.py [results folder]
"""

import math
import sys
from pathlib import Path

import h5py
import matplotlib
import numpy as np
import pandas as pd

matplotlib.use("Agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).resolve().parent
RESULTS = Path(sys.argv[1]) if len(sys.argv) > 1 else Path("results/fluidised-bed/liquid")
COUNT, DIAMETER, DENSITY = 72400, 3.087e-3, 3585.9
WATER, VISCOSITY, VELOCITY, TUBE, GRAVITY = 997.0, 8.3536e-4, 0.157033, 0.1, 9.81
FROM = 4.0

section = math.pi / 4 * TUBE**2
solid = COUNT * math.pi / 6 * DIAMETER**3
weight = solid * (DENSITY - WATER) * GRAVITY / section

series = pd.read_csv(RESULTS / "series.csv", comment="#")
late = series[series.time >= FROM]
drop = late.pressure_drop.mean()
print(f"pressure drop {drop:.1f} Pa of {weight:.1f} Pa ({100 * (drop / weight - 1):+.2f} %)")
print(f"momentum not accounted for {late.momentum_imbalance.abs().max():.1e} N s")

with h5py.File(RESULTS / "particles.vtkhdf") as file:
    steps = file["VTKHDF/Steps"]
    offsets, times = steps["PointOffsets"][:], steps["Values"][:]
    counts = file["VTKHDF/NumberOfPoints"][:]
    at = [file["VTKHDF/Points"][o : o + n] for o, n in zip(offsets, counts)]
    speeds = file["VTKHDF/PointData/velocity"][offsets[-1] : offsets[-1] + counts[-1]]

edges = np.arange(0, 1.1001, 0.02)
middle = 0.5 * (edges[1:] + edges[:-1])
sample = [z[:, 2] for z, t in zip(at, times) if t >= FROM]
solids = np.mean([np.histogram(z, edges)[0] for z in sample], axis=0) * solid / COUNT / (section * 0.02)
tops = [np.quantile(z, 0.99) for z in sample]
# The height of a bed of one void fraction whose centre of mass is where that of the particles is.
height = 2 * np.mean([z.mean() for z in sample])
void = 1 - solid / (section * height)


def richardson_zaki():
    """Void fraction by Richardson and Zaki 1954, with the terminal velocity that they correct for the tube."""
    nu = VISCOSITY / WATER
    speed = 0.4
    for _ in range(100):
        reynolds = speed * DIAMETER / nu
        drag = 24 / reynolds * (1 + 0.15 * reynolds**0.687) if reynolds < 1000 else 0.44
        speed = math.sqrt(4 * GRAVITY * DIAMETER * (DENSITY / WATER - 1) / (3 * drag))
    exponent = (4.45 + 18 * DIAMETER / TUBE) * reynolds**-0.1 if reynolds < 200 else (
        4.45 * reynolds**-0.1 if reynolds < 500 else 2.39
    )
    inside = speed * 10 ** (-DIAMETER / TUBE)
    return (VELOCITY / inside) ** (1 / exponent)


expected = richardson_zaki()
print(f"height {height:.4f} m, 99 % of the beads below {np.mean(tops):.3f} m, void fraction {void:.4f}")
print(f"Richardson and Zaki: {expected:.4f}, height {solid / section / (1 - expected):.4f} m")

figure, (left, right, picture) = plt.subplots(1, 3, figsize=(9, 6), width_ratios=[1.2, 1, 0.35])
left.plot(series.time, series.pressure_drop / 1e3, lw=0.7)
left.axhline(weight / 1e3, color="k", ls="--", label="buoyant weight / section")
left.set(xlabel="time (s)", ylabel="pressure drop (kPa)", ylim=(0, 6))
left.legend()
right.plot(1 - solids, middle)
right.axvline(expected, color="k", ls="--", label="Richardson and Zaki")
right.set(xlabel="void fraction (-)", ylabel="height (m)", ylim=(0, 1.1))
right.legend()
slab = np.abs(at[-1][:, 1]) < 2 * DIAMETER
dots = picture.scatter(*at[-1][slab][:, [0, 2]].T, s=2, c=speeds[slab][:, 2], cmap="coolwarm", vmin=-0.15, vmax=0.15)
picture.set(aspect="equal", xlim=(-0.052, 0.052), ylim=(0, 1.1), xlabel="x (m)", xticks=[-0.05, 0.05], yticklabels=[])
figure.colorbar(dots, ax=picture, label="velocity upwards (m/s)")
figure.tight_layout()
figure.savefig(HERE / "column.png", dpi=110)
