#!/usr/bin/env python3
"""What borders between ranks that move to the work gain, as a Markdown table.

Beds of spheres that leave some ranks little to do: a dam that breaks into a channel eight times as long as it is wide, a
silo that is half full, a fluidised bed in the lower quarter of its column and a drum, all cut across gravity, each with `domain.balance` off and on.
The work of the busiest rank over the mean counts particles, pairs and cells, so that more ranks than cores tell it too; times
are told where every rank has a core of its own.

    scaling/balance.py --ranks 2 4 8
"""

import argparse
import math
import os
import re
import subprocess
import tempfile
from pathlib import Path

from benchmark import BINARY, DT, ENVIRONMENT, GLASS, RADIUS, machine, table

SPACING = 2.02 * RADIUS  # m

CASE = """\
name = "{name}"

[domain]
lower = {lower}
upper = {upper}
periodic = [{periodic}]
ranks = {ranks}
balance = {balance}

[time]
end = {end}
dt = {dt}

{glass}
[[shape]]
name = "bead"
kind = "sphere"
radius = {radius}

[[insert]]
name = "bed"
particles = [{{ shape = "bead", material = "glass" }}]
count = {count}
place = {{ kind = "lattice", lower = {bed_lower}, upper = {bed_upper}, spacing = {spacing:g}, noise = 0.004 }}
{walls}
[output]
directory = "results"
particles = 0
series = {end}
checkpoint = 0
"""

WALL = """
[[wall]]
name = "{name}"
material = "glass"
{kind}
"""


def plane(name, point, normal):
    return WALL.format(name=name, kind=f'kind = "plane"\npoint = {point}\nnormal = {normal}')


FLOOR = plane("floor", [0, 0, 0], [0, 0, 1])
ENDS = plane("left", [0, 0, 0], [1, 0, 0]) + plane("right", [0.48, 0, 0], [-1, 0, 0])
TURN = 'motion = { kind = "rotation", point = [0, 0, 0], axis = [0, 1, 0], angular_velocity = 6 }'
DRUM = WALL.format(name="drum", kind=f'kind = "cylinder"\ncenter = [0, 0.06, 0]\naxis = [0, 1, 0]\nradius = 0.06\n{TURN}')

AIR = """
[fluid]
density = 1.2
viscosity = 1.8e-5
cells = [10, 10, 60]
coupling = { drag = "beetstra", model = "B", kernel = { kind = "smooth" } }

[[fluid.boundary]]
face = "-z"
kind = "inlet"
velocity = [0, 0, 2.5]

[[fluid.boundary]]
face = "+z"
kind = "outlet"
"""

# Corners of box and bed (m), periodic axes, the axis that is cut, walls.
CASES = {
    "dam break": ([-0.001, 0, -0.001], [0.481, 0.12, 0.12], [0, 0, 0], [0.06, 0.12, 0.09], "false, true, false", 0, FLOOR + ENDS),
    "half-full silo": ([0, 0, -0.001], [0.06, 0.06, 0.36], [0, 0, 0], [0.06, 0.06, 0.18], "true, true, false", 2, FLOOR),
    "fluidised bed": ([0, 0, 0], [0.06, 0.06, 0.36], [0, 0, 0.0015], [0.06, 0.06, 0.0925], "true, true, false", 2, FLOOR + AIR),
    "drum": ([-0.061, 0, -0.061], [0.061, 0.12, 0.061], [-0.039, 0, -0.044], [0.039, 0.12, 0.006], "false, true, false", 2, DRUM),
}


def run(options, name, ranks, balance, folder):
    """Work of the busiest rank over the mean, moves of borders, particles of the fullest rank, spheres, and seconds."""
    lower, upper, bed_lower, bed_upper, periodic, axis, walls = CASES[name]
    grid = [ranks if a == axis else 1 for a in range(3)]
    count = math.prod(int((high - low) / SPACING) for low, high in zip(bed_lower, bed_upper))
    (folder / "case.toml").write_text(
        CASE.format(
            name=name, lower=lower, upper=upper, periodic=periodic, ranks=grid, balance=str(balance).lower(),
            end=options.steps * DT, dt=DT, glass=GLASS, radius=RADIUS, bed_lower=bed_lower, bed_upper=bed_upper,
            spacing=SPACING, count=count, walls=walls,
        )
    )
    place = ["--bind-to", "core"] if ranks <= len(os.sched_getaffinity(0)) else ["--oversubscribe", "--mca", "mpi_yield_when_idle", "1"]
    command = ["mpirun", "-n", str(ranks), *place, str(options.binary.resolve()), "case.toml"]
    done = subprocess.run(command, cwd=folder, env=os.environ | ENVIRONMENT, capture_output=True, text=True, timeout=3600)
    if done.returncode:
        raise SystemExit(done.stdout[-1000:] + done.stderr[-1000:])
    pattern = r"particles per rank: .* to (\d+); the busiest rank worked ([\d.]+) times the mean; borders moved (\d+) times"
    fullest, work, moves = re.search(pattern, done.stdout).groups()
    phases = re.findall(r"^  [a-z ]+? {2,}[\d.]+ +([\d.]+)", done.stdout, flags=re.M)
    spheres = re.search(r"^particles: (\d+) inserted", done.stdout, re.M)[1]
    return float(work), int(moves), int(fullest), int(spheres), sum(map(float, phases))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", type=Path, default=BINARY, help="grains-mpi program")
    parser.add_argument("--cases", nargs="+", choices=list(CASES), default=list(CASES))
    parser.add_argument("--ranks", nargs="+", type=int, default=[2, 4, 8])
    parser.add_argument("--steps", type=int, default=20_000)
    options = parser.parse_args()
    before, rows = machine(), []
    for name in options.cases:
        for ranks in options.ranks:
            found = []
            for balance in (False, True):
                with tempfile.TemporaryDirectory() as folder:
                    found.append(run(options, name, ranks, balance, Path(folder)))
            (off, _, full, spheres, seconds), (on, moves, fullest, _, quick) = found
            times = [f"{seconds:.1f}", f"{quick:.1f}", f"{seconds / quick:.2f}"]
            if ranks > len(os.sched_getaffinity(0)):
                times = ["-"] * 3
            rows.append([name, f"{spheres:,}", ranks, f"{off:.2f}", f"{on:.2f}", moves, full, fullest, *times])
    print(f"{before}. {options.steps} steps.\n")
    head = ["case", "spheres", "ranks", "work, fixed", "moving", "moves", "fullest rank, fixed", "moving", "time (s), fixed", "moving", "gain"]
    print(table(head, rows))


if __name__ == "__main__":
    main()
