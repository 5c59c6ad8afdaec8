#!/usr/bin/env python3
"""How evenly planes can cut a heap that moves, and what a second level of cuts would gain, as a Markdown table.

Runs the dam break of balance.py once, and counts the spheres of each rank at its snapshots for grids of ranks: borders that
stay; planes across the whole box at the quantiles along each axis, as the program moves them; and cuts at the quantiles of each slab, then of
each column of it, which no plane of the others must follow. No subdomain is thinner than the program allows.

    scaling/cuts.py --grids 16x1x1 4x2x2
"""

import argparse
import os
import subprocess
from pathlib import Path

import h5py
import numpy as np

import balance
from benchmark import BINARY, DT, ENVIRONMENT, GLASS, RADIUS, table

# Smallest width of a subdomain (m): two spheres with their skin.
MIN_WIDTH = 2.5 * RADIUS
TIMES = [0.02, 0.06, 0.1, 0.14]  # s


def snapshots(binary, folder):
    """Positions of the spheres (m) at times (s)."""
    lower, upper, bed_lower, bed_upper, periodic, _, walls = balance.CASES["dam break"]
    count = int(np.prod([int((high - low) / balance.SPACING) for low, high in zip(bed_lower, bed_upper)]))
    text = balance.CASE.format(
        name="dam break", lower=lower, upper=upper, periodic=periodic, ranks=[1, 1, 1], balance="false",
        end=TIMES[-1], dt=DT, glass=GLASS, radius=RADIUS, bed_lower=bed_lower, bed_upper=bed_upper,
        spacing=balance.SPACING, count=count, walls=walls,
    )
    text = text.replace("particles = 0\n", "particles = 0.02\n")
    case, file = folder / "case.toml", folder / "results/particles.vtkhdf"
    if not (file.exists() and case.read_text() == text):
        folder.mkdir(parents=True, exist_ok=True)
        case.write_text(text)
        subprocess.run([binary.resolve(), "case.toml"], cwd=folder, env=os.environ | ENVIRONMENT, check=True, stdout=subprocess.DEVNULL)
    with h5py.File(file) as opened:
        group = opened["VTKHDF"]
        values, first, points = group["Steps/Values"][:], group["Steps/PointOffsets"][:], group["NumberOfPoints"][:]
        for time in TIMES:
            step = int(np.abs(values - time).argmin())
            yield values[step], group["Points"][first[step] : first[step] + points[step]]


def borders(values, parts, low, high):
    """Borders at the quantiles of values, none closer than the smallest width."""
    cuts = np.quantile(values, np.arange(1, parts) / parts) if len(values) else np.linspace(low, high, parts + 1)[1:-1]
    for k in range(parts - 1):
        cuts[k] = max(cuts[k], (cuts[k - 1] if k else low) + MIN_WIDTH)
    for k in reversed(range(parts - 1)):
        cuts[k] = min(cuts[k], (cuts[k + 1] if k < parts - 2 else high) - MIN_WIDTH)
    return cuts


def of_planes(points, grid, corners, moves):
    """Spheres of the fullest rank over the mean, with planes across the whole box."""
    place = 0
    for axis, parts in enumerate(grid):
        low, high = corners[0][axis], corners[1][axis]
        cuts = borders(points[:, axis], parts, low, high) if moves else np.linspace(low, high, parts + 1)[1:-1]
        place = place * parts + np.searchsorted(cuts, points[:, axis], side="right")
    counts = np.bincount(place, minlength=np.prod(grid))
    return counts.max() / counts.mean()


def of_slabs(points, grid, corners, order=(0, 1, 2)):
    """The same, with the slabs along the first axis cut each at its own quantiles."""
    axis, rest = order[0], order[1:]
    cuts = borders(points[:, axis], grid[axis], corners[0][axis], corners[1][axis])
    slab = np.searchsorted(cuts, points[:, axis], side="right")
    parts = [points[slab == k] for k in range(grid[axis])]
    fullest = max((of_slabs(part, grid, corners, rest) if rest else len(part)) for part in parts)
    return fullest if len(order) < 3 else fullest / (len(points) / np.prod(grid))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", type=Path, default=BINARY, help="grains-mpi program")
    parser.add_argument("--grids", nargs="+", default=["16x1x1", "8x2x1", "4x4x1", "4x2x2", "2x2x4", "8x4x2", "4x4x4"])
    parser.add_argument("--out", type=Path, default=Path("results/scaling/cuts"))
    options = parser.parse_args()
    corners = balance.CASES["dam break"][:2]
    rows = []
    for time, points in snapshots(options.binary, options.out):
        for name in options.grids:
            grid = tuple(int(n) for n in name.split("x"))
            fixed, planes = (of_planes(points, grid, corners, moves) for moves in (False, True))
            slabs = of_slabs(points, grid, corners)
            rows.append([f"{time:.2f}", " x ".join(map(str, grid)), f"{fixed:.2f}", f"{planes:.2f}", f"{slabs:.2f}", f"{planes / slabs:.2f}"])
    print(table(["time (s)", "ranks", "fixed borders", "planes that move", "second level", "gain"], rows))


if __name__ == "__main__":
    main()
