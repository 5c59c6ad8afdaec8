#!/usr/bin/env python3
"""Contact laws on settled spheres, grains-mpi beside LAMMPS' `granular`: microseconds per particle and step.

The beds of bench_spheres.py, 14,000 spheres and 25,000 tiled 2 x 2, under Hertz with Mindlin's spring, and under JKR with
rolling (sds) and twisting (Marshall). The floor of the second is Hertzian, as LAMMPS of 2022 gives NaN under JKR at walls.
Program and peer take turns on one rank.

    scaling/bench_laws.py --peers DIR      # states DIR/state/b14.csv.gz, b100.csv.gz; lmp
"""

import argparse
import shutil
import statistics
import tempfile
from pathlib import Path

from bench_spheres import lammps_data, make_bed
from benchmark import BINARY, DENSITY, DT, FLOOR, FRICTION, GLASS, RADIUS, RESTITUTION, bench, machine, mpi, run, segments, spread, table

YOUNG, POISSON, SURFACE_ENERGY = 4e9, 0.25, 0.01

MATERIALS = f"""\
[[material]]
name = "glass"
density = {DENSITY}
youngs_modulus = {YOUNG}
poissons_ratio = {POISSON}
surface_energy = {SURFACE_ENERGY}

[[material]]
name = "floor"
youngs_modulus = {YOUNG}
poissons_ratio = {POISSON}
"""

CONTACT = """
[[contact]]
between = ["glass", "{other}"]
restitution = {restitution}
friction = {friction}
{law}
"""

HERTZ = """\
normal = { kind = "hertz" }
tangential = { kind = "mindlin", memory = "displacement_rescaled" }"""

JKR = """\
normal = { kind = "jkr", tear = "load" }
tangential = { kind = "mindlin", memory = "displacement_rescaled" }
rolling_friction = 0.1
rolling = { kind = "sds", stiffness = 2e4, dashpot = 0.05 }
twisting = "marshall\""""

HERTZ_OF_PEER = f"hertz/material {YOUNG} {RESTITUTION} {POISSON} tangential mindlin_rescale NULL 1.0 {FRICTION} damping tsuji"
JKR_OF_PEER = (
    f"jkr {YOUNG} {RESTITUTION} {POISSON} {SURFACE_ENERGY} tangential mindlin_rescale NULL 1.0 {FRICTION} "
    "rolling sds 2e4 0.05 0.1 twisting marshall damping tsuji"
)

# Name, our law between spheres, and LAMMPS' between spheres; the floor is Hertzian.
LAWS = [
    ("Hertz-Mindlin", HERTZ, HERTZ_OF_PEER),
    ("JKR, Mindlin, sds, Marshall", JKR, JKR_OF_PEER),
]

DECK = """\
units si
atom_style sphere
newton on off
boundary p p f
processors * * 1
comm_modify vel yes
read_data {data}
neighbor {skin} bin
neigh_modify every 1 delay 0 check yes
pair_style granular
pair_coeff * * {law}
fix fall all gravity 9.81 vector 0 0 -1
fix move all nve/sphere
fix floor all wall/gran granular {wall} zplane 0.0 NULL
timestep {dt}
thermo 1000000
thermo_modify lost error norm no
run {warm}
run {steps}
run {steps}
run {steps}
"""


def write_case(bed, law, name):
    """The bed's case under another law."""
    contacts = [("glass", law), ("floor", HERTZ)]
    text = MATERIALS + "".join(
        CONTACT.format(other=other, restitution=RESTITUTION, friction=FRICTION, law=rule) for other, rule in contacts
    )
    floor = FLOOR.replace('material = "glass"', 'material = "floor"')
    path = bed.case.with_name(f"{bed.name}-{name}.toml")
    path.write_text(bed.case.read_text().replace(GLASS, text).replace(FLOOR, floor))
    return path


def write_deck(bed, law, name, warm, steps):
    """LAMMPS' input of the bed; a skin of 0.05 radii is the fastest found."""
    data = bed.positions.with_suffix(".data")
    if not data.exists():
        lammps_data(bed, data)
    path = bed.case.with_name(f"in.{bed.name}-{name}")
    path.write_text(
        DECK.format(data=data, skin=0.05 * RADIUS, law=law, wall=HERTZ_OF_PEER, dt=DT, warm=warm, steps=steps)
    )
    return path


def measure(bed, options):
    """Rows of the table: both programs in turns for every law."""
    steps = max(100, 8_000_000 // bed.count)
    peer = shutil.which(options.lammps)
    for number, (name, law, of_peer) in enumerate(LAWS):
        case = write_case(bed, law, str(number))
        deck = write_deck(bed, of_peer, str(number), options.warm, steps)
        own, other = [], []
        for _ in range(options.rounds):
            own += bench(options.binary, case, 1, options.warm, steps, options.timeout)
            if peer:
                other += segments(run(mpi(1, [peer, "-in", deck, "-log", "none"]), options.timeout), steps)
        ratio = f"{statistics.median(own) / statistics.median(other):.2f}" if other else "-"
        yield [f"{bed.count} spheres", name, spread(own), spread(other) if other else "-", ratio]


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peers", type=Path, required=True, help="folder with state/b14.csv.gz and state/b100.csv.gz")
    parser.add_argument("--lammps", default="lmp", help="LAMMPS program")
    parser.add_argument("--binary", type=Path, default=BINARY, help="grains-mpi program")
    parser.add_argument("--rounds", type=int, default=2, help="times that program and peer take turns")
    parser.add_argument("--warm", type=int, default=300, help="steps before timing")
    parser.add_argument("--timeout", type=float, default=600, help="longest time of one run (s)")
    return parser.parse_args()


def main():
    options = arguments()
    print(machine())
    rows = []
    with tempfile.TemporaryDirectory() as name:
        for label, file, tiles in [("small", "b14.csv.gz", 1), ("large", "b100.csv.gz", 2)]:
            bed = make_bed(label, options.peers / "state" / file, tiles, Path(name))
            rows += measure(bed, options)
    print(table(["bed", "law", "grains-mpi", "LAMMPS", "ratio"], rows))


if __name__ == "__main__":
    main()
