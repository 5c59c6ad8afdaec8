#!/usr/bin/env python3
"""Weak scaling of silos that discharge, one per rank (Rakotonirina 2016, section 5.4.1).

*Separate* silos stand far enough apart that no rank has a clone; *merged* ones share a silo, and each rank has one of
its hoppers. The source does not say how a silo holds 2,000 or 100,000 particles. Here the beads (13.8 mm), the opening
(57 mm) and the angle of the hopper stay those of the silo of 14,000, and its width goes with the cube root of their
number, so that all are filled to the same height over width. Cubes have the beads' volume. A silo is filled once behind
a closed opening; the copies open when timing begins.

    scaling/silos.py --ranks 1 2 --kinds '2,000 spheres'
"""

import math

from copies import Copies
from study import Stage, Study, System, grid, main

DIAMETER = 0.0138  # m, of a bead
VOLUME = math.pi / 6 * DIAMETER**3  # m3
EDGE = VOLUME ** (1 / 3)  # m, of a cube
OPENING = 0.057  # m
SLOPE = math.tan(math.radians(62.5))
DT = 1e-5  # s
SKIN = 0.4  # largest reach of a particle over its bounding radius, the program's default

# Name in the case: keys of the shape, and diameter of the bounding sphere (m).
SHAPES = {
    "spheres": (f'kind = "sphere"\nradius = {DIAMETER / 2:g}', DIAMETER),
    "cubes": (f'kind = "box"\nedges = [{EDGE:.6e}, {EDGE:.6e}, {EDGE:.6e}]', EDGE * math.sqrt(3)),
}

CASE = """\
name = "{name}"
seed = 2016
gravity = [0, 0, -9.81]

[domain]
lower = {lower}
upper = {upper}
{ranks}balance = false

[time]
end = {end}
dt = {dt}
impact_speed = 3

[[material]]
name = "glass"
density = 2500

[[material]]
name = "wall"

# Table 5.1, with a tangential spring, as in cases/silo.
[[contact]]
between = ["glass", "glass"]
normal_stiffness = 7.2e5
restitution = 0.75
friction = 0.3

[[contact]]
between = ["glass", "wall"]
normal_stiffness = 1e6
restitution = 0.62
friction = 0.3

[[shape]]
name = "grain"
{keys}

[[insert]]
name = "grains"
particles = [{{ shape = "grain", material = "glass" }}]
place = {place}
{walls}
[output]
directory = "settled"
particles = {end}
series = 0.01
checkpoint = 0.05
{stop}"""

WALL = """
[[wall]]
name = "{name}"
material = "wall"
kind = "polygons"
vertices = [
{vertices}
]
faces = [
{faces}
]
"""

# Of a frustum whose vertices are two rings of four, as frustum() gives them.
SIDES = [[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]


def width(count):
    """Width of the silo of so many particles (m)."""
    return 0.25 * (count / 14000) ** (1 / 3)


def least(count):
    """No fewer than a silo wider than its opening holds."""
    return max(count, 400)


def hopper_height(length):
    return (length - OPENING) / 2 * SLOPE


def ring(center, x, y, z):
    """The corners of a rectangle of half-widths x, y (m)."""
    return [(center[0] + sx * x, center[1] + sy * y, z) for sx, sy in [(-1, -1), (1, -1), (1, 1), (-1, 1)]]


def wall(name, bodies):
    """A wall of several bodies: (vertices, faces) each."""
    vertices, faces = [], []
    for corners, sides in bodies:
        faces += [[len(vertices) + k for k in face] for face in sides]
        vertices += corners
    lines = lambda rows: ",\n".join(f"    [{', '.join(f'{x:.7g}' for x in row)}]" for row in rows)
    return WALL.format(name=name, vertices=lines(vertices), faces=lines(faces))


def hopper(center, length):
    """The inclined sides of one hopper."""
    return ring(center, OPENING / 2, OPENING / 2, 0.0) + ring(center, length / 2, length / 2, hopper_height(length)), SIDES


def prism(center, x, y, low, high, floor=False):
    """Upright sides around a rectangle, and a floor if wanted."""
    return ring(center, x, y, low) + ring(center, x, y, high), SIDES + ([[0, 1, 2, 3]] if floor else [])


def case(kind, length, lower, upper, ranks, place, walls, end, stop):
    box = lambda corner: f"[{', '.join(f'{x:.7g}' for x in corner)}]"
    return CASE.format(
        name=kind, lower=box(lower), upper=box(upper), ranks=f"ranks = {list(ranks)}\n" if ranks else "", dt=DT,
        keys=SHAPES[kind][0], place=place, walls="".join(walls), end=end, stop=stop,
    )


def lattice(kind, count):
    """Where a silo is filled from: spacing, half-width, lower and upper end (m)."""
    length, spacing = width(count), 1.06 * SHAPES[kind][1]
    across = int((length - 1e-4) / spacing)
    low = hopper_height(length) + 0.005
    return spacing, across * spacing / 2 + 1e-6, low, low + spacing * (math.ceil(count / across**2) + 0.1)


def filling(kind, count):
    """The run that fills one silo."""
    length, (spacing, half, low, high) = width(count), lattice(kind, count)
    place = (f'{{ kind = "lattice", lower = [{-half:.6f}, {-half:.6f}, {low:.6f}], upper = [{half:.6f}, {half:.6f}, {high:.6f}],'
             f" spacing = {spacing:.6f}, noise = 0.02 }}\ncount = {count}")
    top, side, center = high + 0.02, length / 2 + 0.01, (0.0, 0.0)
    walls = [
        wall("silo", [hopper(center, length), prism(center, length / 2, length / 2, hopper_height(length), top)]),
        wall("plate", [(ring(center, 0.035, 0.035, -0.001), [[0, 1, 2, 3]])]),
    ]
    stop = f"\n[stop]\nkinetic_energy_below = {count * 5e-8:.3e}\nafter = 0.5\n"
    text = case(kind, length, (-side, -side, -0.02), (side, side, top), None, place, walls, 2, stop)
    return [Stage(f"silo-{kind}-{count}", text)]


def discharge(kind, count, ranks, merged):
    """The silos of all ranks with open hoppers, and the copies they are filled with."""
    length = width(count)
    (nx, ny), height = grid(ranks), hopper_height(length)
    # Cubes may stand in towers in the corners: as high as they were dropped from is enough.
    bottom, top = -4 * length, lattice(kind, count)[3] + 0.02
    # Between separate bins two ranges on either side of the border, so that no particle comes near it.
    pitch = length if merged else 2 * length + 4 * (1 + SKIN) * SHAPES[kind][1]
    centers = [(i * pitch, j * pitch) for j in range(ny) for i in range(nx)]
    lower = (-pitch / 2, -pitch / 2, bottom - 0.01)
    upper = ((nx - 0.5) * pitch, (ny - 0.5) * pitch, top)
    silos = [hopper(center, length) for center in centers]
    if merged:
        middle, x, y = ((nx - 1) * pitch / 2, (ny - 1) * pitch / 2), nx * pitch / 2, ny * pitch / 2
        silos.append(prism(middle, x, y, height, top))
        bins = [prism(middle, x, y, bottom, height, floor=True)]
    else:
        silos += [prism(center, length / 2, length / 2, height, top) for center in centers]
        bins = [prism(center, length, length, bottom, 0.0, floor=True) for center in centers]
    walls = [wall("silos", silos), wall("bins", bins)]
    place = '{ kind = "file", path = "bed.h5" }'
    text = case(kind, length, lower, upper, (nx, ny, 1), place, walls, 10, "")
    return text, Copies((nx, ny, 1), (pitch, pitch, 0.0))


def system(kind, count, merged, source, time):
    return System(
        kind=f"{kind}, {'merged' if merged else 'separate'}", count=count, actual=least,
        stages=lambda number: filling(kind, number),
        case=lambda number, ranks: discharge(kind, number, ranks, merged), source=source, source_time=time,
    )


# Table 5.3; the total times give 6.0, 10.6, 12.6, 23.9 and 36.6 us.
REFERENCE = [
    ("2,000 spheres", "59 min 56 s", 6), ("14,000 spheres", "12 h 24 min 27 s", 10), ("100,000 spheres", "104 h 41 min 12 s", 12),
    ("2,000 cubes", "3 h 58 min 32 s", 24), ("10,000 cubes", "30 h 30 min 16 s", 36),
]
# What the text tells of fig. 5.11.
TOLD = [
    ("100,000 spheres", "separate", "up to 256", "about 0.85"), ("100,000 spheres", "merged", "256", "0.78"),
    ("cubes", "separate", "up to 256", "more than of as many spheres"),
]

STUDY = Study(
    name="silos",
    title="Silos that discharge, one per rank",
    ranks=[1, 2, 4, 8, 16, 32, 64, 128, 256],
    warm=3000, steps=30000,
    systems=[
        system("spheres", 2000, False, {}, "6"),
        system("spheres", 14000, False, {}, "10"),
        system("spheres", 100000, False, {1: 1.0, 256: 0.85}, "12"),
        system("cubes", 2000, False, {}, "24"),
        system("spheres", 2000, True, {}, "6"),
        system("spheres", 14000, True, {}, "10"),
        system("spheres", 100000, True, {1: 1.0, 256: 0.78}, "12"),
        system("cubes", 10000, True, {}, "36"),
    ],
    published=[
        ("Rakotonirina (2016), table 5.3: 300,000 steps of one silo on one core.",
         ["silo", "in all", "us per particle and step"], REFERENCE),
        ("Rakotonirina (2016), section 5.4.1: what the text says of fig. 5.11.", ["load", "silos", "ranks", "S(n)"], TOLD),
    ],
)

if __name__ == "__main__":
    main(STUDY)
