"""Nusselt number and largest velocities of de Vahl Davis' cavity: python3 nusselt.py [results folder] [picture]"""

import sys
import tomllib
from pathlib import Path

import h5py
import numpy as np

results = Path(sys.argv[1] if len(sys.argv) > 1 else "results/heated-cavity")
case = tomllib.loads((results / "case.resolved.toml").read_text())
nx, _, nz = case["fluid"]["cells"]
length = case["domain"]["upper"][0]
scalar = case["fluid"]["scalar"][0]
hot, cold = (boundary["value"] for boundary in scalar["boundary"])
diffusivity = scalar["conductivity"] / (case["fluid"]["density"] * scalar["heat_capacity"])
with h5py.File(results / "fluid.vtkhdf") as file:
    cells = file["VTKHDF/CellData"]
    temperature = cells["temperature"][-1].reshape(nz, nx)
    velocity = cells["velocity"][-1].reshape(nz, nx, 3) * length / diffusivity
theta = (temperature - cold) / (hot - cold)
width = length / nx
# The flux through every section of cells, and at the hot wall: with the parabola through the wall and two cells.
wall = np.mean((8 * 1.0 - 9 * theta[:, 0] + theta[:, 1]) / (3 * width)) * length
u = velocity[..., 0]
between = 0.5 * (theta[:, 1:] + theta[:, :-1]) * 0.5 * (u[:, 1:] + u[:, :-1]) - np.diff(theta, axis=1) * nx
sections = between.mean(axis=0)
middle = lambda field, axis: 0.5 * (np.take(field, nx // 2 - 1, axis) + np.take(field, nx // 2, axis))
print(f"Nusselt number at the hot wall {wall:.4f}, of the section in the middle {sections[nx // 2 - 1]:.4f}")
print(f"largest u on the vertical middle {middle(u, 1).max():.3f}, largest w on the horizontal {middle(velocity[..., 2], 0).max():.3f}")
if len(sys.argv) > 2:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    x = (np.arange(nx) + 0.5) / nx
    figure, axes = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
    axes[0].contourf(x, x, theta, 20)
    axes[0].set_title("temperature")
    speed = np.hypot(u, velocity[..., 2])
    axes[1].contourf(x, x, speed, 20)
    axes[1].streamplot(x, x, u, velocity[..., 2], color="w", linewidth=0.5, density=1.2, arrowsize=0.5)
    axes[1].set_title("speed and streamlines")
    for axis in axes:
        axis.set_aspect("equal")
    figure.savefig(sys.argv[2], dpi=120)
