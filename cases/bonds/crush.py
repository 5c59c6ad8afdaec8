"""Crushes an agglomerate of bonded spheres: `python3 cases/bonds/crush.py`, with the Python that scripts/python-environment prints.

Packs spheres in a can, cuts a ball out of the packing, crushes it at two strengths of its bonds, prints the table, and draws force
and broken bonds over the way of the piston into crush.png."""
import subprocess
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
RESULTS = Path("results/bonds")
RADIUS, SPEED = 5e-3, 0.05
STRENGTHS = {"0.5 MPa": (5e5, 1e6), "1 MPa": (1e6, 2e6)}


def run(case):
    subprocess.run([ROOT / "scripts/run", case], check=True)


def ball(packing, table):
    """Writes the spheres of the last state of a packing that lie in a ball at its middle; returns their number, the solid fraction,
    and the heights (m) of plates that touch the ball."""
    with h5py.File(packing / "particles.vtkhdf") as file:
        group = file["VTKHDF"]
        first, count = group["Steps/PointOffsets"][-1], group["NumberOfPoints"][-1]
        points = group["Points"][first : first + count]
        grain = group["PointData/radius"][first]
    middle = np.array([0, 0, np.median(points[:, 2])])
    inside = points[np.linalg.norm(points - middle, axis=1) < RADIUS - grain] - middle
    pd.DataFrame(inside, columns=["x", "y", "z"]).to_csv(table, index=False)
    core = np.linalg.norm(points - middle, axis=1) < 0.7 * RADIUS
    plates = inside[:, 2].min() - grain, inside[:, 2].max() + grain
    return len(inside), core.sum() * (grain / (0.7 * RADIUS)) ** 3, plates


def crush(name, strengths, plates):
    """Crushes the ball between plates at these heights with bonds of these strengths; returns the time series."""
    text = (HERE / "crush.toml").read_text()
    directory = RESULTS / f"crush-{name.replace(' ', '-')}"
    changes = [("tensile_strength = 1e6", f"tensile_strength = {strengths[0]:g}")]
    changes += [("shear_strength = 2e6", f"shear_strength = {strengths[1]:g}")]
    changes += [('path = "ball.csv"', f'path = "{(RESULTS / "ball.csv").resolve()}"')]
    changes += [('directory = "results/bonds/crush"', f'directory = "{directory}"')]
    changes += [(f"point = [0, 0, {given}]", f"point = [0, 0, {height:.9g}]") for given, height in zip((-0.004736387, 0.004788787), plates)]
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    case = RESULTS / f"{directory.name}.toml"
    case.write_text(text)
    if not (directory / "series.csv").exists():
        run(case)
    return pd.read_csv(directory / "series.csv", comment="#")


def main():
    RESULTS.mkdir(parents=True, exist_ok=True)
    if not (RESULTS / "pack/series.csv").exists():
        run(HERE / "pack.toml")
    count, fraction, plates = ball(RESULTS / "pack", RESULTS / "ball.csv")
    print(f"{count} spheres, solid fraction {fraction:.3f}")
    figure, axes = plt.subplots(2, 1, sharex=True, figsize=(6, 5))
    for name, strengths in STRENGTHS.items():
        series = crush(name, strengths, plates)
        way = 1e3 * SPEED * series.time
        force = series.piston_fz.rolling(5, center=True).mean()
        anvil = -series.anvil_fz.rolling(5, center=True).mean()
        peak = force.idxmax()
        total = series.bonds.iloc[0]
        nominal = 0.9 * force[peak] / (2 * RADIUS) ** 2
        print(
            f"{name}: {total:.0f} bonds; peak {force[peak]:.2f} N at {way[peak]:.3f} mm, 0.9 F/d2 = {nominal / 1e6:.3f} MPa; "
            f"broken {series.broken_bonds[peak] / total:.1%} at the peak, {series.broken_bonds.iloc[-1] / total:.1%} at the end"
        )
        axes[0].plot(way, force, label=f"{name}, piston")
        axes[0].plot(way, anvil, ":", label=f"{name}, anvil")
        axes[1].plot(way, 100 * series.broken_bonds / total, label=name)
    axes[0].set_ylabel("force (N)")
    axes[0].legend()
    axes[1].set(xlabel="way of the piston (mm)", ylabel="broken bonds (%)")
    figure.tight_layout()
    figure.savefig(HERE / "crush.png", dpi=110)


if __name__ == "__main__":
    main()
