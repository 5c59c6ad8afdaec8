#!/usr/bin/env python3
"""What particles of very different sizes cost, as a Markdown table.

Beds of spheres of one size, of two sizes 10:1 of equal volume, and of a few a hundred times as large as the rest, at
random at first, then falling and settling in a box periodic in x and y. What counts is the time per contact: a
grid of cells as wide as the largest sphere would make every small one look through thousands.

    scaling/sizes.py --ranks 1 2
"""

import argparse
import csv
import math
import random
import re
import statistics
import tempfile
from pathlib import Path

from bench_spheres import CASE
from benchmark import BINARY, DT, FLOOR, GLASS, RADIUS, machine, mpi, run, segments, spread, table

SPACING = 2.1  # of the lattice of the small ones, over their radius
# Large over small radius, large ones, small ones, and the width of the box over the small radius.
BEDS = [(1, 0, 40_000, 84), (10, 40, 40_000, 84), (100, 1, 300_000, 630)]


def places(ratio, large, small, width):
    """Centres and radii of all spheres over the small radius."""
    chance, rows = random.Random(1), []
    height = 1.3 * ((large * ratio**3 + small) * SPACING**3) / width**2 + 2 * ratio
    while len(rows) < large:
        x, y, z = chance.uniform(0, width), chance.uniform(0, width), chance.uniform(ratio, height - ratio)
        if all(math.hypot(apart(x, a, width), apart(y, b, width), z - c) > 2 * ratio for a, b, c, _ in rows):
            rows.append((x, y, z, ratio))
    big, n, k = list(rows), int(width / SPACING), 0
    while len(rows) < large + small:
        x, y, z = ((i + 0.5) * width / n for i in (k % n, k // n % n, k // n**2))
        z *= SPACING * n / width
        k += 1
        if all(math.hypot(apart(x, a, width), apart(y, b, width), z - c) > ratio + 1 for a, b, c, _ in big):
            rows.append((x + chance.uniform(0, 0.05), y + chance.uniform(0, 0.05), z, 1))
    return rows


def apart(a, b, period):
    """Distance along a periodic axis."""
    return abs((a - b + 0.5 * period) % period - 0.5 * period)


def write_case(folder, bed):
    """Writes case and positions."""
    rows = places(*bed)
    with open(folder / "bed.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["x", "y", "z", "radius"])
        writer.writerows([f"{RADIUS * value:.9g}" for value in row] for row in rows)
    top = RADIUS * (max(z + r for _, _, z, r in rows) + 1)
    (folder / "case.toml").write_text(
        CASE.format(
            edge=RADIUS * bed[3], top=top, positions="bed.csv", dt=DT, glass=GLASS, radius=RADIUS, floor=FLOOR,
        )
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", type=Path, default=BINARY, help="grains-mpi program")
    parser.add_argument("--ranks", type=int, nargs="+", default=[1], help="numbers of ranks")
    parser.add_argument("--warm", type=int, default=30_000, help="steps before timing 40,000 spheres; fewer if there are more")
    parser.add_argument("--steps", type=int, default=300, help="steps per segment")
    parser.add_argument("--timeout", type=float, default=3600, help="longest time of one run (s)")
    options = parser.parse_args()
    before, rows, first = machine(), [], {}
    for bed in BEDS:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            write_case(folder, bed)
            warm = options.warm * 40_000 // (bed[1] + bed[2])
            for ranks in options.ranks:
                command = [options.binary, "bench", folder / "case.toml", "--warm", warm, "--steps", options.steps]
                output = run(mpi(ranks, command), options.timeout)
                contacts = float(re.search(r"^contacts_per_particle (\S+)", output, re.M)[1])
                times = segments(output, options.steps)
                row = [f"{bed[0]}:1", f"{bed[1]:,} + {bed[2]:,}", ranks, f"{contacts:.2f}", spread(times)]
                if contacts < 0.1:
                    rows.append([*row, "-", "-"])
                    continue
                per_contact = statistics.median(times) / contacts
                first.setdefault(ranks, per_contact)
                rows.append([*row, f"{per_contact:.4f}", f"{per_contact / first[ranks]:.2f}"])
    print(f"{before}. Microseconds per sphere and step, median (least–largest), and per contact.\n")
    print(table(["radii", "large + small", "ranks", "contacts per sphere", "time", "per contact", "over one size"], rows))


if __name__ == "__main__":
    main()
