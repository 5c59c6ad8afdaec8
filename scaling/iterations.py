#!/usr/bin/env python3
"""Iterations of the program's own pressure solver over resolution, geometry and ranks, as a Markdown table.

A closed box with a moving lid, a bed of beads in a round column whose wall cuts the cells (averaged flow), and eight
fixed spheres in a periodic box (resolved flow), in N x N x N cells, the pressure to 1e-8 by conjugate gradients with
multigrid. Iterations are counted, so more ranks than cores do no harm.

    scaling/iterations.py --cells 32 64 96 --ranks 1 2 4 8 16 64
"""

import argparse
import re
import sys
import tempfile
from pathlib import Path

from benchmark import BINARY, run, table

PRESSURE = 'pressure = { method = "conjugate_gradients", tolerance = 1e-8 }'

BOX = """\
gravity = [0, 0, 0]
[domain]
lower = [0, 0, 0]
upper = [1, 1, 1]
[time]
end = 1000
dt = {dt}
[fluid]
density = 1
viscosity = 0.01
cells = [{n}, {n}, {n}]
{pressure}
[[fluid.boundary]]
face = "+z"
kind = "wall"
velocity = [1, 0, 0]
"""

COLUMN = """\
[domain]
lower = [0, 0, 0]
upper = [0.02, 0.02, 0.02]
balance = false
[time]
end = 1000
dt = 1e-6
impact_speed = 0.3
accept_coarse_dt = true
[[material]]
name = "glass"
density = 2500
[[contact]]
between = ["glass", "glass"]
normal_stiffness = 100
restitution = 0.8
friction = 0.3
[[shape]]
name = "bead"
kind = "sphere"
radius = 1e-4
[[insert]]
name = "bed"
particles = [{{ shape = "bead", material = "glass" }}]
count = 8000
place = {{ kind = "lattice", lower = [0.0035, 0.0035, 0.001], upper = [0.0165, 0.0165, 0.012], spacing = 5e-4, noise = 0.05 }}
[[wall]]
name = "column"
material = "glass"
kind = "cylinder"
center = [0.01, 0.0101, 0.01]
axis = [0, 0, 1]
radius = 0.0095
fluid = "particles"
[fluid]
density = 1.2
viscosity = 1.8e-5
cells = [{n}, {n}, {n}]
{pressure}
coupling = {{ drag = "beetstra", particle_steps = 5 }}
[[fluid.boundary]]
face = "-z"
kind = "inlet"
velocity = [0, 0, 0.3]
[[fluid.boundary]]
face = "+z"
kind = "outlet"
"""

ARRAY = """\
gravity = [0, 0, 0]
[domain]
lower = [0, 0, 0]
upper = [1, 1, 1]
periodic = [true, true, true]
[time]
end = 1000
[[material]]
name = "solid"
density = 2000
[[shape]]
name = "ball"
kind = "sphere"
radius = 0.2
[[insert]]
name = "array"
particles = [{{ shape = "ball", material = "solid" }}]
count = 8
place = {{ kind = "lattice", lower = [0, 0, 0], upper = [1, 1, 1], spacing = 0.5, noise = 0.02 }}
[fluid]
density = 1
viscosity = 1
cells = [{n}, {n}, {n}]
{pressure}
resolved = {{ motion = "fixed" }}
drive = {{ kind = "mean_velocity", velocity = [1, 0, 0], axes = [true, false, false] }}
"""

CASES = {
    "closed box with a lid": (BOX, 1),
    "bed in a round column": (COLUMN, 5),
    "array of spheres, resolved": (ARRAY, 1),
}


def count(options, folder, name, cells, ranks):
    """Iterations per step of the fluid."""
    text, particle_steps = CASES[name]
    case = folder / "case.toml"
    case.write_text(text.format(n=cells, dt=0.25 / cells, pressure=PRESSURE))
    steps = [particle_steps * s for s in (options.warm, options.steps)]
    command = ["mpirun", "--oversubscribe", "--mca", "mpi_yield_when_idle", 1, "-n", ranks]
    command += [options.binary, "bench", case, "--warm", steps[0], "--steps", steps[1], "--segments", 1]
    output = run(command, options.timeout)
    found = re.search(r"^fluid_ns_per_cell_step .* steps (\d+) iterations (\d+)$", output, re.M)
    if not found:
        raise SystemExit(f"no iterations in the output:\n{output[-2000:]}")
    return int(found[2]) / int(found[1])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", type=Path, default=BINARY, help="grains-mpi program")
    parser.add_argument("--cells", type=int, nargs="+", default=[32, 64, 96], help="cells along an edge")
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2, 4, 8, 16, 64])
    parser.add_argument("--warm", type=int, default=3, help="steps of the fluid before those that are counted")
    parser.add_argument("--steps", type=int, default=5, help="steps of the fluid that are counted")
    parser.add_argument("--timeout", type=float, default=600, help="longest time of one run (s)")
    options = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as name:
        for case in CASES:
            for cells in options.cells:
                counts = [count(options, Path(name), case, cells, ranks) for ranks in options.ranks]
                rows.append([case, f"{cells}³", *(f"{c:.1f}" for c in counts)])
                print(*rows[-1], file=sys.stderr)
    print("Iterations per step.\n")
    print(table(["flow", "cells", *(f"{r} rank{'s' if r > 1 else ''}" for r in options.ranks)], rows))


if __name__ == "__main__":
    main()
