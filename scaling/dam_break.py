#!/usr/bin/env python3
"""Weak scaling of a dam break in slices, one per rank along the width (Rakotonirina 2016, section 5.4.2, fig. 5.19).

101,850 icosahedra in a reservoir 125 mm long, in a slice 21.875 mm wide, periodic across; ten blocks of them settle as
one and are stacked, the stack settles again, and every rank gets a copy. The gate is gone when timing begins, so that
the first steps of the collapse are timed, as in the source. With fewer particles length and height shrink alike.

    scaling/dam_break.py --ranks 1 2 --count 2000
"""

import math

from copies import Copies
from study import Stage, Study, System, main

COUNT = 101850
WIDTH = 0.021875  # m, of a slice
LENGTH = 0.125  # m, of the reservoir
REACH = 1.774e-3  # m, circumradius of a grain, rounded up
FRACTION = 0.55  # of solid in a settled bed, at least
BLOCKS = 10

CASE = """\
name = "dam break"
seed = 7

[domain]
lower = [-0.005, 0, -0.005]
upper = [{right:.6f}, {width:.6f}, {top:.6f}]
periodic = [false, true, false]
{ranks}balance = false

[time]
end = {end}
dt = 2.5e-6
impact_speed = 2

[[material]]
name = "grain"
density = 2500

[[material]]
name = "box"

[[material]]
name = "gate"

# Table 5.4, with a tangential spring, as in cases/dam-break.
[[contact]]
between = ["grain", "grain"]
normal_stiffness = 1e5
restitution = 0.75
friction = 0.5

[[contact]]
between = ["grain", "box"]
normal_stiffness = 1e5
restitution = 0.75
friction = 0.5

[[contact]]
between = ["grain", "gate"]
normal_stiffness = 1e5
restitution = 0.75
friction = 0

# Of the volume of a sphere of 3 mm.
[[shape]]
name = "grain"
kind = "regular"
solid = "icosahedron"
circumradius = 1.77308e-3

[[insert]]
name = "grains"
particles = [{{ shape = "grain", material = "grain" }}]
place = {place}

[[wall]]
name = "floor"
material = "box"
kind = "plane"
point = [0, 0, 0]
normal = [0, 0, 1]

[[wall]]
name = "back"
material = "box"
kind = "plane"
point = [0, 0, 0]
normal = [1, 0, 0]
{gate}
[output]
directory = "settled"
particles = {end}
series = 0.01
checkpoint = 0.01
"""

GATE = """
[[wall]]
name = "gate"
material = "gate"
kind = "plane"
point = [{length:.6f}, 0, 0]
normal = [-1, 0, 0]
"""


def blocks(count):
    """Blocks that are stacked to a column of so many."""
    return BLOCKS if count >= 20000 else 1


def whole(count):
    """So many as equal blocks hold, and no fewer than make a column three grains long."""
    return max(count, 800) // blocks(count) * blocks(count)


def length(count):
    return LENGTH * math.sqrt(count / COUNT)


def case(slices, reservoir, right, top, ranks, place, end, gate):
    return CASE.format(
        right=right, width=slices * WIDTH, top=top, ranks=f"ranks = [1, {ranks}, 1]\n" if ranks else "", end=end,
        place=place, gate=GATE.format(length=reservoir) if gate else "",
    )


def height(count):
    """Height of a settled column (m), rather too much."""
    return count * 4 / 3 * math.pi * 1.5e-3**3 / FRACTION / length(count) / WIDTH


FILE = '{ kind = "file", path = "bed.h5" }'


def settling(count):
    """The block, and the stack of blocks."""
    reservoir, block = length(count), count // blocks(count)
    spacing = 2.02 * REACH
    per_layer = int(reservoir / spacing) * int(WIDTH / spacing)
    top = spacing * (math.ceil(block / per_layer) + 0.1)
    place = (f'{{ kind = "lattice", lower = [0, 0, 0], upper = [{reservoir:.6f}, {WIDTH:.6f}, {top:.6f}],'
             f" spacing = {spacing:.6g} }}\ncount = {block}")
    right = reservoir + 0.005
    stages = [Stage(f"dam-block-{count}", case(1, reservoir, right, top + 0.01, 0, place, 0.35, True))]
    if blocks(count) > 1:
        # Blocks are dropped by their uneven tops, one or two grains each.
        top = 1.1 * height(count) + blocks(count) * 4 * REACH
        text = case(1, reservoir, right, top, 0, FILE, 0.1, True)
        stages.append(Stage(f"dam-column-{count}", text, Copies((1, 1, blocks(count)))))
    return stages


def collapse(count, ranks):
    """The slices of all ranks, without the gate."""
    reservoir = length(count)
    top = 1.1 * height(count) + blocks(count) * 4 * REACH + 0.02
    text = case(ranks, reservoir, 6 * reservoir, top, ranks, FILE, 10, False)
    return text, Copies((1, ranks, 1), (0.0, WIDTH, 0.0))


# Table 5.5.
CORES = [1, 16, 32, 64, 128, 256, 512]
PARTICLES = [101850, 1627500, 3255000, 6510000, 13020000, 26040000, 52080000]

STUDY = Study(
    name="dam-break",
    title="Dam break in slices",
    ranks=CORES,
    warm=100, steps=20000,
    systems=[System(kind="icosahedra", count=COUNT, case=collapse, stages=settling, actual=whole, source={1: 1.0, 512: 0.93})],
    published=[
        ("Rakotonirina (2016), table 5.5, and what the text says of fig. 5.19: S(512) of about 0.93, and hardly less beyond"
         " 256 cores than before.",
         ["cores", "width (m)", "particles"], [(n, f"{n * WIDTH:g}", f"{total:,}") for n, total in zip(CORES, PARTICLES)]),
    ],
)

if __name__ == "__main__":
    main(STUDY)
