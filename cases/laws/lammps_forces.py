#!/usr/bin/env python3
"""Forces of LAMMPS' granular laws on pairs of spheres, written to lammps_forces.csv.

The test `cargo test -p grains-verification --test lammps` compares our laws with them. Needs `lmp` (Debian: lammps).

    cases/laws/lammps_forces.py
"""

import csv
import random
import subprocess
import tempfile
from pathlib import Path

PAIRS = 24
YOUNG, POISSON, SURFACE_ENERGY, DENSITY = 1e8, 0.3, 0.05, 2500.0
LAWS = {
    "hooke": "hooke 1e4 0.2 tangential linear_nohistory 0.7 1e6 damping velocity",
    "hertz": f"hertz/material {YOUNG} 0.6 {POISSON} tangential mindlin NULL 0.7 1e6 damping tsuji",
    "hertz_couples": f"hertz/material {YOUNG} 0.6 {POISSON} tangential mindlin NULL 0.7 1e6 "
    "rolling sds 200 0.03 1e6 twisting marshall damping tsuji",
    "dmt": f"dmt {YOUNG} 0 {POISSON} {SURFACE_ENERGY} tangential linear_nohistory 0 0 damping velocity",
    "jkr": f"jkr {YOUNG} 0 {POISSON} {SURFACE_ENERGY} tangential mindlin NULL 0 0 damping viscoelastic",
}
DECK = """units si
atom_style sphere
boundary f f f
comm_modify vel yes
read_data pairs.data
neighbor 1e-3 bin

pair_style granular
pair_coeff * * {law}
fix move all nve/sphere
timestep 1e-15
dump out all custom 1 forces.txt id x y z vx vy vz omegax omegay omegaz radius fx fy fz tqx tqy tqz
dump_modify out sort id format float %.17g
run 0
"""


def states(seed):
    """Rows (position, velocity, spin, radius) of spheres, two and two in contact."""
    random.seed(seed)

    def vector(size):
        return [random.uniform(-size, size) for _ in range(3)]

    rows = []
    for k in range(PAIRS):
        radii = [random.uniform(1e-3, 3e-3) for _ in range(2)]
        direction = vector(1)
        norm = sum(x * x for x in direction) ** 0.5
        overlap = 10 ** random.uniform(-5, -1.8) * min(radii)
        at = [0.03 * (k + 1), 0.01, 0.01]
        way = (sum(radii) - overlap) / norm
        other = [x + way * d for x, d in zip(at, direction)]
        for position, radius in zip((at, other), radii):
            rows.append((position, vector(0.5), vector(200), radius))
    return rows


def data_file(rows):
    length = 0.03 * (PAIRS + 2)
    text = f"pairs\n\n{len(rows)} atoms\n1 atom types\n\n0 {length} xlo xhi\n-0.05 0.05 ylo yhi\n-0.05 0.05 zlo zhi\n\n"
    text += "Atoms\n\n"
    for k, (x, _, _, radius) in enumerate(rows, 1):
        text += f"{k} 1 {2 * radius!r} {DENSITY} {x[0]!r} {x[1]!r} {x[2]!r}\n"
    text += "\nVelocities\n\n"
    for k, (_, v, w, _) in enumerate(rows, 1):
        text += f"{k} " + " ".join(repr(value) for value in v + w) + "\n"
    return text


def forces(law, folder):
    """Rows of the dump: state, force and torque of every sphere."""
    (folder / "in.pairs").write_text(DECK.format(law=law))
    subprocess.run(["lmp", "-in", "in.pairs", "-log", "none", "-screen", "none"], cwd=folder, check=True)
    lines = (folder / "forces.txt").read_text().splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith("ITEM: ATOMS"))
    return [line.split() for line in lines[first + 1 :]]


def main():
    columns = "law id x y z vx vy vz wx wy wz radius fx fy fz tx ty tz".split()
    with open(Path(__file__).with_name("lammps_forces.csv"), "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        for seed, (name, law) in enumerate(LAWS.items()):
            with tempfile.TemporaryDirectory() as folder:
                (Path(folder) / "pairs.data").write_text(data_file(states(seed)))
                writer.writerows([name, *row] for row in forces(law, Path(folder)))


if __name__ == "__main__":
    main()
