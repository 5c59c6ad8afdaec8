"""Discharge of the hopper without air, with air and with its top shut, and pictures of the pressure.

`python3 cases/gas-hopper/hopper.py [folder of the results] [time from which, time until which rates are taken (s)]`, with h5py and matplotlib.
"""

import csv
import sys
from pathlib import Path

import h5py
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).resolve().parent
RESULTS = Path(sys.argv[1]) if len(sys.argv) > 1 else Path("results/gas-hopper")
FROM, UNTIL = (float(x) for x in sys.argv[2:4]) if len(sys.argv) > 3 else (0.1, 0.16)
GRAVITY, BEAD, ORIFICE, RADIUS, DENSITY = 9.81, 0.3e-3, 3e-3, 3e-3, 2500.0
STATES = {"alone": "without air", "open": "air, top open", "shut": "air, top shut"}


def series(name):
    with open(RESULTS / name / "series.csv") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    return lambda column: np.array([float(row[column]) for row in rows])


with h5py.File(RESULTS / "filled" / "particles.vtkhdf") as file:
    count = file["VTKHDF/NumberOfPoints"][-1]
    at = file["VTKHDF/Points"][-count:]
in_bin = (at[:, 2] > 6e-3) & (at[:, 2] < 9e-3)
bulk = DENSITY * in_bin.sum() * np.pi / 6 * BEAD**3 / (np.pi * RADIUS**2 * 3e-3)
print(f"bulk density {bulk:.0f} kg/m3 in the bin")
for k in (1.4, 1.5):
    print(f"Beverloo, k = {k}: {0.58 * bulk * GRAVITY**0.5 * (ORIFICE - k * BEAD) ** 2.5 * 1e3:.3f} g/s")

figure, axes = plt.subplots(1, 4, figsize=(13, 4), width_ratios=(1.4, 1, 1, 1.2))
rates = {}
for name, label in STATES.items():
    if not (RESULTS / name / "series.csv").exists():
        continue
    table = series(name)
    time, mass = table("time"), table("orifice_mass")
    between = (time >= FROM) & (time <= UNTIL)
    rates[name] = np.polyfit(time[between], mass[between], 1)[0]
    against = f", {rates[name] / rates['alone']:.3f} of that without air"
    print(f"{label}: {rates[name] * 1e3:.3f} g/s over {FROM} to {UNTIL} s{against}")
    axes[0].plot(time, mass * 1e3, label=label)
axes[0].set(xlabel="t (s)", ylabel="mass through the orifice (g)")
axes[0].legend()

for axis, name in zip(axes[1:3], ("open", "shut")):
    with h5py.File(RESULTS / name / "fluid.vtkhdf") as file:
        times = file["VTKHDF/Steps/Values"][:]
        chosen = np.flatnonzero((times >= FROM - 1e-9) & (times <= UNTIL + 1e-9))
        pressure = file["VTKHDF/CellData/pressure"][chosen].mean(0)
        x, y, z = (file[f"grid/{axis}"][:] for axis in "xyz")
        solid = file["VTKHDF/CellData/void_fraction"][chosen].min(0) < 0.02
    middle = len(y) // 2 - 1
    pair = slice(middle, middle + 2)
    plane = np.where(solid[:, pair].all(1), np.nan, pressure[:, pair].mean(1))
    largest = np.nanmax(np.abs(plane))
    image = axis.pcolormesh(x * 1e3, z * 1e3, plane, cmap="RdBu_r", vmin=-largest, vmax=largest)
    axis.plot(*np.transpose([(r, h) for h, r in ((0, 3), (2.7, 3), (3, 1.5), (5.598, 3), (20.4, 3))]), "k", lw=0.8)
    axis.plot(*np.transpose([(-r, h) for h, r in ((0, 3), (2.7, 3), (3, 1.5), (5.598, 3), (20.4, 3))]), "k", lw=0.8)
    axis.set(aspect="equal", xlabel="x (mm)", ylabel="z (mm)", title=STATES[name])
    figure.colorbar(image, ax=axis, label="pressure (Pa)")
    line = pressure[:, pair, len(x) // 2 - 1 : len(x) // 2 + 1].mean((1, 2))
    heights = 0.5 * (z[1:] + z[:-1])
    axes[3].plot(line, heights * 1e3, label=STATES[name])
    print(f"{STATES[name]}: lowest pressure on the axis {line.min():.2f} Pa at {heights[line.argmin()] * 1e3:.1f} mm, at the top {line[-1]:.2f} Pa")
axes[3].axhline(3, color="k", lw=0.5)
axes[3].set(xlabel="pressure on the axis (Pa)", ylabel="z (mm)")
axes[3].legend()
figure.tight_layout()
figure.savefig(HERE / "hopper.png", dpi=90)
