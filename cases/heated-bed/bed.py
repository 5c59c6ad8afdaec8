"""Effective conductivity of a settled bed: settles beads, lets them conduct, and compares with Zehner, Bauer and Schluender.

    python3 cases/heated-bed/bed.py [conductivity of the beads (W/(m K)) ...]

from the top of the repository, with `grains-mpi` in the path or in GRAINS_MPI.
"""

import csv
import os
import re
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np

HERE = Path(__file__).parent
PROGRAM = os.environ.get("GRAINS_MPI", "grains-mpi")
GAS, RADIUS, AREA = 0.026, 1e-3, 4e-4


def run(case):
    subprocess.run(["mpirun", "-n", "2", PROGRAM, str(case)], check=True, stdout=subprocess.DEVNULL)


def series(name):
    with open(f"results/{name}/series.csv") as lines:
        rows = list(csv.reader(line for line in lines if not line.startswith("#")))
    return {column: np.array([float(row[k]) for row in rows[1:]]) for k, column in enumerate(rows[0])}


def snapshot(name):
    with h5py.File(f"results/{name}/particles.vtkhdf") as file:
        root = file["VTKHDF"]
        count = root["NumberOfPoints"][-1]
        fields = root["PointData"]
        temperature = fields["temperature"][-count:] if "temperature" in fields else None
        return root["Points"][-count:], temperature


def bauer_schluender(ratio, voids):
    """k_e/k_g of spheres whose conductivity is `ratio` that of the gas, without flattened contacts or radiation."""
    solid = 1 - voids
    form = 1.25 * (solid / voids) ** (10 / 9)
    n = 1 - form / ratio
    inner = (1 - 1 / ratio) * form / n**2 * np.log(ratio / form) - (form + 1) / 2 - (form - 1) / n
    return 1 - np.sqrt(solid) + np.sqrt(solid) * 2 / n * inner


def main():
    if not Path("results/settle/particles.vtkhdf").exists():
        run(HERE / "settle.toml")
    height = 0.065 - series("settle")["plate_displacement"][-1]
    text = (HERE / "conduct.toml").read_text().replace("point = [0, 0, 0.016]", f"point = [0, 0, {height:.12g}]")
    lattice = re.search(r"count = .*\nplace = .*\n", text).group()
    text = text.replace(lattice, f'place = {{ kind = "file", path = "{Path("results/settle/particles.vtkhdf").resolve()}" }}\n')
    for conductivity in [float(word) for word in sys.argv[1:]] or [1.0, 15.0, 100.0]:
        name = f"conduct-{conductivity:g}"
        own = text.replace("conductivity = 1\n", f"conductivity = {conductivity}\n")
        case = HERE / f".{name}.toml"
        case.write_text(own.replace("[output]", f'[output]\ndirectory = "results/{name}"'))
        try:
            run(case)
        finally:
            case.unlink()
        rows = series(name)
        flows = rows["floor_heat_flow"][-1], -rows["plate_heat_flow"][-1]
        points, temperature = snapshot(name)
        z = points[:, 2]
        inside = (z > 6 * RADIUS) & (z < height - 6 * RADIUS)
        slope = np.polyfit(z[inside], temperature[inside], 1)[0]
        found = -np.mean(flows) / (AREA * slope)
        # Solid volume between two planes well inside.
        low, high = 6 * RADIUS, height - 6 * RADIUS
        below = lambda h: np.pi * np.clip(h, 0, 2 * RADIUS) ** 2 * (RADIUS - np.clip(h, 0, 2 * RADIUS) / 3)
        solid = (below(high - z + RADIUS) - below(low - z + RADIUS)).sum() / (AREA * (high - low))
        theory = bauer_schluender(conductivity / GAS, 1 - solid)
        lost = np.abs(rows["particle_heat_unaccounted"]).max() / rows["particle_heat_content"][0]
        print(
            f"k {conductivity:g} W/(m K): void fraction {1 - solid:.4f}, heat in and out {flows[0]:.6g}, {flows[1]:.6g} W, "
            f"k_e/k_g {found / GAS:.3f}, Bauer and Schluender {theory:.3f} ({100 * (found / GAS / theory - 1):+.1f} %), "
            f"unaccounted {lost:.1e}"
        )


if __name__ == "__main__":
    main()
