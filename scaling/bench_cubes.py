#!/usr/bin/env python3
"""Settled cubes beside settled spheres of a peer: microseconds per particle and step, as a Markdown table.

2,000 cubes of the volume of a sphere of 1.5 mm fall with random orientations into a box that is periodic in x and
y (0.03 m) and come to rest on a plane. The step is then timed from their checkpoint, in turns with LAMMPS and its
14,000 spheres (see bench_spheres.py).

    scaling/bench_cubes.py --peers DIR       # state DIR/state/b14.csv.gz, deck DIR/lammps/in.b1; lmp
    scaling/bench_cubes.py                   # without a peer
"""

import argparse
import math
import shutil
import statistics
import tempfile
from pathlib import Path

from bench_spheres import lammps_command, make_bed
from benchmark import BINARY, DT, FLOOR, GLASS, RADIUS, machine, mpi, run, segments, spread, table

COUNT = 2000
EDGE = RADIUS * (4 / 3 * math.pi) ** (1 / 3)  # m
BOX = 0.03  # m, along x and y
SPACING = 1.02 * math.sqrt(3) * EDGE  # m: no two cubes can touch
HEIGHT = SPACING * (math.ceil(COUNT / math.floor(BOX / SPACING) ** 2) + 0.1)  # m

CASE = f"""\
name = "settled cubes"
gravity = [0, 0, -9.81]

[domain]
lower = [0, 0, -0.001]
upper = [{BOX}, {BOX}, {HEIGHT + 0.01:.4f}]
periodic = [true, true, false]

[time]
end = 0.5
dt = {DT}

{GLASS}
[[shape]]
name = "cube"
kind = "box"
edges = [{EDGE:.6g}, {EDGE:.6g}, {EDGE:.6g}]

[[insert]]
name = "cubes"
particles = [{{ shape = "cube", material = "glass" }}]
count = {COUNT}
orientation = "random"
place = {{ kind = "lattice", lower = [0, 0, 0], upper = [{BOX}, {BOX}, {HEIGHT:.4f}], spacing = {SPACING:.6g} }}
velocity = [0, 0, -0.5]

{FLOOR}
[output]
directory = "settled"
particles = 0
series = 0.01
checkpoint = 0.05
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peers", type=Path, help="folder with state/b14.csv.gz and lammps/in.b1")
    parser.add_argument("--lammps", default="lmp", help="LAMMPS program")
    parser.add_argument("--binary", type=Path, default=BINARY, help="grains-mpi program")
    parser.add_argument("--folder", type=Path, help="where cubes that have settled are kept for the next time")
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2], help="numbers of ranks")
    parser.add_argument("--rounds", type=int, default=2, help="times that program and peer take turns")
    parser.add_argument("--steps", type=int, default=1500, help="steps per segment")
    parser.add_argument("--timeout", type=float, default=1800, help="longest time of one run (s)")
    options = parser.parse_args()
    before = machine()
    with tempfile.TemporaryDirectory() as name:
        folder = options.folder or Path(name)
        folder.mkdir(parents=True, exist_ok=True)
        case = folder / "cubes.toml"
        case.write_text(CASE)
        binary = options.binary.resolve()
        if not list(folder.glob("settled/checkpoint-*.h5")):
            run(mpi(max(options.ranks), [binary, case.name]), options.timeout, folder)
        peers = options.peers and shutil.which(options.lammps)
        bed = make_bed("small", options.peers / "state/b14.csv.gz", 1, Path(name)) if peers else None
        own, peer = {n: [] for n in options.ranks}, {n: [] for n in options.ranks}
        for _ in range(options.rounds):
            for n in options.ranks:
                command = [binary, "bench", case.name, "--restart", "latest", "--steps", options.steps]
                own[n] += segments(run(mpi(n, command), options.timeout, folder), options.steps)
                if bed:
                    deck = options.peers / "lammps/in.b1"
                    peer[n] += segments(run(lammps_command(options.lammps, deck, bed, n, 300, 1000), 600), 1000)
    print(f"{before}. Microseconds per particle and step: median (least–largest).\n")
    header = ["ranks", "grains-mpi, 2,000 cubes", "peer, 14,000 spheres", "cube / sphere", "speed-up"]
    rows = []
    for n in options.ranks:
        cost = statistics.median(own[n])
        ratio = f"{cost / statistics.median(peer[n]):.2f}" if peer[n] else "-"
        gain = f"{statistics.median(own[1]) / cost:.2f}" if 1 in own else "-"
        rows.append([n, spread(own[n]), spread(peer[n]) if peer[n] else "-", ratio, gain])
    print(table(header, rows))


if __name__ == "__main__":
    main()
