#!/usr/bin/env python3
"""Weak scaling: beds that grow with the number of ranks, as a Markdown table.

Each rank has its own N spheres: a square column of a bed that is periodic in x and y. They start on a lattice
with gaps of a hundredth and are in contact after the warm-up. The efficiency is the time of a step on one rank
over that on all; it is 1 if the neighbours cost nothing.

    scaling/weak.py --ranks 1 2 4 --count 4000
"""

import argparse
import os
import statistics
import tempfile
from pathlib import Path

from benchmark import BINARY, DT, FLOOR, GLASS, RADIUS, bench, machine, spread, table

SPACING = 2.02 * RADIUS  # m
ASPECT = 2  # height of a rank's column over its width

CASE = """\
name = "weak scaling"

[domain]
lower = [0, 0, -0.001]
upper = [{x:.5f}, {y:.5f}, {top:.5f}]
periodic = [true, true, false]
ranks = [{px}, {py}, 1]

[time]
end = 10
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
place = {{ kind = "lattice", lower = [0, 0, 0], upper = [{x:.5f}, {y:.5f}, {height:.5f}], spacing = {spacing:g}, noise = 0.004 }}

{floor}"""


def grid(ranks):
    """The most nearly square px x py = ranks."""
    py = max(n for n in range(1, int(ranks**0.5) + 1) if ranks % n == 0)
    return ranks // py, py


def column(count):
    """Spheres along the width and height of a column of about `count`."""
    width = max(4, round((count / ASPECT) ** (1 / 3)))
    return width, max(1, round(count / width**2))


def write_case(path, ranks, count):
    """Writes the case for a number of ranks; returns the spheres per rank."""
    (px, py), (width, height) = grid(ranks), column(count)
    per_rank = width * width * height
    x, y, z = (n * SPACING for n in (px * width, py * width, height))
    path.write_text(
        CASE.format(
            x=x, y=y, height=z, top=z + 4 * SPACING, px=px, py=py, radius=RADIUS, spacing=SPACING,
            count=per_rank * ranks, dt=DT, glass=GLASS, floor=FLOOR,
        )
    )
    return per_rank


def main():
    cores = len(os.sched_getaffinity(0))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", type=Path, default=BINARY, help="grains-mpi program")
    parser.add_argument("--ranks", type=int, nargs="+", help="numbers of ranks; powers of 2 by default")
    parser.add_argument("--count", type=int, default=4000, help="spheres per rank, about")
    parser.add_argument("--warm", type=int, default=8000, help="steps before timing, until the bed has fallen")
    parser.add_argument("--steps", type=int, default=2000, help="steps per segment")
    parser.add_argument("--timeout", type=float, default=600, help="longest time of one run (s)")
    options = parser.parse_args()
    ranks = options.ranks or [2**k for k in range(cores.bit_length()) if 2**k <= cores]
    if max(ranks) > cores:
        parser.error(f"{max(ranks)} ranks on {cores} cores would time the waiting for cores")

    before, base, rows = machine(), None, []
    with tempfile.TemporaryDirectory() as name:
        for n in ranks:
            case = Path(name) / f"weak-{n}.toml"
            per_rank = write_case(case, n, options.count)
            measured = bench(options.binary, case, n, options.warm, options.steps, options.timeout)
            per_step = [n * us for us in measured]
            base = base or statistics.median(per_step)
            efficiency = base / statistics.median(per_step)
            rows.append([n, per_rank, per_rank * n, spread(per_step), f"{efficiency:.2f}"])
    print(f"{before}. Microseconds per step and sphere of one rank: median (least–largest).\n")
    print(table(["ranks", "spheres per rank", "spheres", "time", "efficiency"], rows))


if __name__ == "__main__":
    main()
