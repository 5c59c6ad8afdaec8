#!/usr/bin/env python3
"""Settled spheres, grains-mpi beside a peer: microseconds per particle and step, as a Markdown table.

A bed of spheres (1.5 mm, linear spring with tangential history), periodic in x and y (0.06 m) on a plane,
starts from positions in CSV files (x,y,z,r; also .csv.gz): 14,000 spheres as they are, 25,000 spheres tiled
2 x 2 to 100,000. Peer and program take turns, as a machine's speed drifts. The peer is LAMMPS with the deck of
a folder given by --peers, or any command given by --peer that prints lines `us_per_particle_step VALUE` or
those of LAMMPS, `Loop time of ...`, with {ranks}, {warm}, {steps} and {positions} filled in.

    scaling/bench_spheres.py --peers DIR                 # states DIR/state/b14.csv.gz, b100.csv.gz; lmp
    scaling/bench_spheres.py --small a.csv --large b.csv --peer 'mpirun -n {ranks} ./peer {positions} {steps}'
"""

import argparse
import csv
import gzip
import math
import shlex
import shutil
import statistics
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

from benchmark import (
    BINARY, DAMPING_RATIO, DENSITY, DT, FLOOR, FRICTION, GLASS, RADIUS, RESTITUTION, STIFFNESS, STIFFNESS_RATIO, bench,
    machine, mpi, run, segments, spread, table,
)

EDGE = 0.06  # m, of the periodic box before tiling

CASE = """\
name = "settled spheres"

[domain]
lower = [0, 0, -0.001]
upper = [{edge:g}, {edge:g}, {top:.4f}]
periodic = [true, true, false]

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
place = {{ kind = "file", path = "{positions}" }}

{floor}"""


@dataclass
class Bed:
    """A benchmark: its files and what was measured, in microseconds per particle and step."""

    name: str
    count: int
    edge: float  # of the box (m)
    top: float  # of the box (m)
    positions: Path
    case: Path
    own: dict = field(default_factory=dict)  # ranks -> segments
    peer: dict = field(default_factory=dict)


def read_positions(path):
    """Rows (x, y, z, r) in metres."""
    opener = gzip.open if path.suffix == ".gz" else open
    with opener(path, "rt", newline="") as file:
        return [tuple(float(row[key]) for key in ("x", "y", "z", "r")) for row in csv.DictReader(file)]


def make_bed(name, source, tiles, folder):
    """Writes the positions, repeated `tiles` times along x and y, and the case file."""
    single = read_positions(source)
    shifts = [(EDGE * i, EDGE * j) for i in range(tiles) for j in range(tiles)]
    rows = [(x + i, y + j, z, r) for i, j in shifts for x, y, z, r in single]
    positions, case = folder / f"{name}.csv", folder / f"{name}.toml"
    with open(positions, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["x", "y", "z", "radius"])
        writer.writerows(rows)
    bed = Bed(name, len(rows), EDGE * tiles, max(z for _, _, z, _ in rows) + 0.02, positions, case)
    case.write_text(
        CASE.format(
            edge=bed.edge, top=bed.top, positions=positions.name, dt=DT, radius=RADIUS, glass=GLASS, floor=FLOOR,
        )
    )
    return bed


def lammps_data(bed, path):
    """Writes the bed as a LAMMPS data file; two atom types, as the deck's walls expect."""
    rows = [row.split(",") for row in bed.positions.read_text().split()[1:]]
    with open(path, "w") as file:
        file.write(f"settled spheres\n\n{len(rows)} atoms\n2 atom types\n\n")
        for axis, low, high in (("x", 0, bed.edge), ("y", 0, bed.edge), ("z", -0.001, bed.top)):
            file.write(f"{low} {high:.12g} {axis}lo {axis}hi\n")
        file.write("\nAtoms\n\n")
        for k, (x, y, z, r) in enumerate(rows, 1):
            file.write(f"{k} 1 {2 * float(r):.9g} {DENSITY} {x} {y} {z}\n")


def damping_rate(reduced_mass):
    """Rate in F = m gamma v (1/s), twice that of the spring-dashpot: -2 ln(e) w0 / sqrt(pi^2 + ln(e)^2)."""
    log = math.log(RESTITUTION)
    return -2 * log * math.sqrt(STIFFNESS / reduced_mass) / math.hypot(math.pi, log)


def lammps_command(lammps, deck, bed, ranks, warm, steps):
    """LAMMPS' gran/hooke/history with the same physics; the settings are the fastest found for it."""
    mass = DENSITY * 4 / 3 * math.pi * RADIUS**3
    pair, wall = damping_rate(mass / 2), damping_rate(mass)
    data = bed.positions.with_suffix(".data")
    if not data.exists():
        lammps_data(bed, data)
    variables = dict(
        data=data, style="hooke/history", newton="on", delay=0, skin=0.05 * RADIUS, nwarm=warm, nrun=steps, dt=DT,
        kn=STIFFNESS, kt=STIFFNESS_RATIO * STIFFNESS, mu=FRICTION,
        gn=pair, gt=DAMPING_RATIO * pair, gnw=wall, gtw=DAMPING_RATIO * wall,
    )
    options = [text for key, value in variables.items() for text in ("-var", key, str(value))]
    return mpi(ranks, [lammps, "-in", deck, "-log", "none", *options])


def peer_command(options, bed, ranks, steps):
    """Command line of the peer, or None."""
    if options.peer:
        filled = options.peer.format(ranks=ranks, warm=options.warm, steps=steps, positions=bed.positions)
        return shlex.split(filled)
    if options.deck and shutil.which(options.lammps):
        return lammps_command(options.lammps, options.deck, bed, ranks, options.warm, steps)
    return None


def measure(bed, options):
    """Takes turns with the peer, on each number of ranks, for some rounds."""
    steps = options.steps or max(100, 14_000_000 // bed.count)
    for _ in range(options.rounds):
        for ranks in options.ranks:
            own = bench(options.binary, bed.case, ranks, options.warm, steps, options.timeout)
            bed.own.setdefault(ranks, []).extend(own)
            command = peer_command(options, bed, ranks, steps)
            if command:
                bed.peer.setdefault(ranks, []).extend(segments(run(command, options.timeout), steps))


def rows(beds, ranks):
    """Rows of the table: medians with their spread, ratio to the peer, gain over one rank."""
    for bed in beds:
        for n in ranks:
            own = statistics.median(bed.own[n])
            peer, ratio = "-", "-"
            if n in bed.peer:
                peer, ratio = spread(bed.peer[n]), f"{own / statistics.median(bed.peer[n]):.2f}"
            gain = f"{statistics.median(bed.own[1]) / own:.2f}" if 1 in bed.own else "-"
            yield [f"{bed.count} spheres", n, spread(bed.own[n]), peer, ratio, gain]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peers", type=Path, help="folder with state/b14.csv.gz, state/b100.csv.gz and lammps/in.b1")
    parser.add_argument("--small", type=Path, help="positions of the small bed")
    parser.add_argument("--large", type=Path, help="positions of the bed that is tiled 2 x 2")
    parser.add_argument("--deck", type=Path, help="LAMMPS input; that of --peers by default")
    parser.add_argument("--lammps", default="lmp", help="LAMMPS program")
    parser.add_argument("--peer", help="command line of another peer")
    parser.add_argument("--binary", type=Path, default=BINARY, help="grains-mpi program")
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2], help="numbers of ranks")
    parser.add_argument("--rounds", type=int, default=2, help="times that program and peer take turns")
    parser.add_argument("--warm", type=int, default=300, help="steps before timing")
    parser.add_argument("--steps", type=int, help="steps per segment; about 14 million particle steps by default")
    parser.add_argument("--timeout", type=float, default=600, help="longest time of one run (s)")
    options = parser.parse_args()
    if options.peers:
        options.small = options.small or options.peers / "state/b14.csv.gz"
        options.large = options.large or options.peers / "state/b100.csv.gz"
        options.deck = options.deck or options.peers / "lammps/in.b1"
    if not (options.small or options.large):
        parser.error("give --peers DIR, or positions by --small or --large")
    return options


def main():
    options = arguments()
    before = machine()
    with tempfile.TemporaryDirectory() as name:
        sources = [("small", options.small, 1), ("large", options.large, 2)]
        beds = [make_bed(label, path, tiles, Path(name)) for label, path, tiles in sources if path]
        for bed in beds:
            measure(bed, options)
    if not any(bed.peer for bed in beds):
        print("no peer measured: lmp or its deck is missing", file=sys.stderr)
    print(f"{before}. Microseconds per particle and step: median (least–largest).\n")
    header = ["case", "ranks", "grains-mpi", "peer", "grains-mpi / peer", "speed-up"]
    print(table(header, rows(beds, options.ranks)))


if __name__ == "__main__":
    main()
