"""Balance of momentum of a stirred tank, its power number and a picture.

Usage: python3 balance.py [results folder] [picture]
"""

import csv
import sys
import tomllib
from pathlib import Path

import h5py
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

RESULTS = Path(sys.argv[1]) if len(sys.argv) > 1 else Path("results/stirred-tank")
with open(RESULTS / "case.resolved.toml", "rb") as file:
    case = tomllib.load(file)
walls = {wall["name"]: wall for wall in case["wall"]}
paddle, tank = walls["paddle"], 2 * walls["tank"]["radius"]
spin = paddle["motion"]["angular_velocity"]
size = np.subtract(paddle["upper"], paddle["lower"])
width, height, turns = size[0], size[2], spin / (2 * np.pi)
density, viscosity = case["fluid"]["density"], case["fluid"]["viscosity"]

with open(RESULTS / "series.csv") as file:
    rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
column = lambda name: np.array([float(row[name]) for row in rows])
times = column("time")
loads = {name: np.array([column(f"{name}_flow_{what}") for what in ("fx", "fy", "tz")]) for name in walls}
total = sum(loads.values())
# Loads are those of steps that end at the times of the rows.
given = np.concatenate([np.zeros((3, 1)), np.cumsum(total[:, 1:] * np.diff(times), axis=1)], axis=1)

with h5py.File(RESULTS / "fluid.vtkhdf") as file:
    states = file["VTKHDF/Steps/Values"][:]
    velocity = file["VTKHDF/CellData/velocity"][:]
    void = file["VTKHDF/CellData/void_fraction"][:]
    nodes = [file[f"grid/{axis}"][:] for axis in "xyz"]
x, y, z = (0.5 * (n[1:] + n[:-1]) for n in nodes)
mass = density * void * np.prod([n[1] - n[0] for n in nodes])
moment = x * velocity[..., 1] - y[:, None] * velocity[..., 0]
held = np.array([(mass * what).sum((1, 2, 3)) for what in (velocity[..., 0], velocity[..., 1], moment)])

taken = np.array([np.interp(states, times, -g) for g in given])
exchanged = np.trapezoid(np.abs(loads["tank"][2]) + np.abs(loads["floor"][2]), times)
print(f"{round(tank / (nodes[0][1] - nodes[0][0]))} cells across the tank, Reynolds number {density * turns * width**2 / viscosity:.3g}")
print("time (s): angular momentum of the fluid, less what walls took (N m s), difference over all that went to the tank")
for time, has, got, both in zip(states, held[2], taken[2], held[2] - taken[2]):
    print(f"   {time:.2f}: {has:.6f} {got:.6f} {both / exchanged:+.2%}")
print(f"largest difference of momentum along x, y: {np.abs(held - taken)[:2].max():.2e} N s of {(mass[-1] * np.abs(velocity[-1, ..., 0])).sum():.2e}")
late = times > times[-1] - 0.5 / turns
means = {name: load[2, late].mean() for name, load in loads.items()}
print("mean torque of the last half turn (N m):", ", ".join(f"{name} {mean:.5f}" for name, mean in means.items()))
jitter = loads["paddle"][2, late].std() / abs(means["paddle"])
number = -means["paddle"] * spin / (density * turns**3 * width**5)
outside = (means["tank"] + means["floor"]) * spin / (density * turns**3 * width**5)
print(f"power number {number:.3f} by the paddle (jitter {jitter:.0%}), {outside:.3f} by tank and floor")

# Nagata 1975, two flat blades, liquid as deep as the tank is wide.
b, d, reynolds = height / tank, width / tank, density * turns * width**2 / viscosity
a = 14 + b * (670 * (d - 0.6) ** 2 + 185)
turbulent = 10 ** (1.3 - 4 * (b - 0.5) ** 2 - 1.14 * d)
power = 1.1 + 4 * b - 2.5 * (d - 0.5) ** 2 - 7 * b**4
ratio = (1000 + 1.2 * reynolds**0.66) / (1000 + 3.2 * reynolds**0.66)
print(f"Nagata: {a / reynolds + turbulent * ratio**power:.3f} ({a:.1f}/Re + {turbulent * ratio**power:.3f})")

if len(sys.argv) > 2:
    figure, axes = plt.subplots(1, 2, figsize=(9, 4))
    level = np.abs(z - 0.5).argmin()
    plane = np.linalg.norm(velocity[-1, level], axis=-1)
    show = np.where(void[-1, level] < 0.5, np.nan, plane)
    image = axes[0].pcolormesh(nodes[0], nodes[1], show, cmap="viridis")
    every = max(1, len(x) // 18)
    axes[0].quiver(x[::every], y[::every], *(velocity[-1, level, ::every, ::every, a] for a in (0, 1)), color="w", width=3e-3)
    axes[0].set(aspect="equal", xlabel="x (m)", ylabel="y (m)", title=f"z = {z[level]:.2f} m, t = {states[-1]:.2f} s")
    figure.colorbar(image, ax=axes[0], label="speed (m/s)")
    axes[1].plot(states, held[2], "k.", label="held by the fluid")
    axes[1].plot(times, -given[2], label="less what walls took")
    axes[1].set(xlabel="t (s)", ylabel="angular momentum (N m s)")
    axes[1].legend()
    figure.tight_layout()
    figure.savefig(sys.argv[2], dpi=100)
