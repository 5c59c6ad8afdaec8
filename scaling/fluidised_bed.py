#!/usr/bin/env python3
"""Weak scaling of a fluidised bed (Rakotonirina 2016, section 5.4.3, fig. 5.23).

300,000 beads per rank on a cubic lattice that touches, 50 x 20 x 300 diameters in a box five times as high, periodic
across; the numbers of table 5.6 with beads of 1 mm in air: Re 79.33, Fr 6.927e-3, density ratio 2083. From 16 ranks on
four of them share the depth, and the bed grows along x. With fewer beads it shrinks in all directions.

The source times the particles only, from t = 1785 d/U on (1.5 s here). So does S(n) here, by the phases of rank 0, and
the fluid is told apart; but the timing begins after --warm steps from the lattice, when the bed is still rising: give
--warm 300000 for the bubbling bed. The source's S(n) is relative to a node of 16 cores.

    scaling/fluidised_bed.py --ranks 1 2 --count 5000
"""

from study import Study, System, grid, main

CELL = 2.5e-3  # m, of the fluid: 2.5 diameters
DIAMETER = 1e-3  # m
PER_NODE = 16  # cores of a node of the source

CASE = """\
name = "fluidised bed"
seed = 3

[domain]
lower = [0, 0, 0]
upper = [{x:.6f}, {y:.6f}, {z:.6f}]
periodic = [true, true, false]
ranks = [{px}, {py}, 1]

[time]
end = 10
dt = 5e-6
impact_speed = 0.5

[[material]]
name = "glass"
density = 2500

[[contact]]
between = ["glass", "glass"]
normal_stiffness = 1000
restitution = 0.9
friction = 0.1

[[shape]]
name = "bead"
kind = "sphere"
radius = 0.5e-3

[[insert]]
name = "bed"
particles = [{{ shape = "bead", material = "glass" }}]
count = {count}
place = {{ kind = "lattice", lower = [0, 0, 0.0005], upper = [{x:.6f}, {y:.6f}, {bed:.6f}], spacing = 1e-3 }}

[[wall]]
name = "distributor"
material = "glass"
kind = "plane"
point = [0, 0, 0]
normal = [0, 0, 1]

[fluid]
density = 1.2
viscosity = 1.8e-5
cells = [{cx}, {cy}, {cz}]
coupling = {{ drag = "beetstra", model = "B", kernel = {{ kind = "smooth" }} }}

[[fluid.boundary]]
face = "-z"
kind = "inlet"
velocity = [0, 0, "1.19 * (2 + step(t - 1.5)) / 3"]

[[fluid.boundary]]
face = "+z"
kind = "outlet"
"""


def shape(count):
    """Cells of a rank along x and y, both even, and layers of beads."""
    scale = (count / 300000) ** (1 / 3)
    cx, cy = 2 * max(3, round(10 * scale)), 2 * max(3, round(4 * scale))
    return cx, cy, max(4, round(count / (6.25 * cx * cy)))


def per_rank(count):
    """Beads of a rank that has about so many."""
    cx, cy, layers = shape(count)
    return cx * 5 // 2 * (cy * 5 // 2) * layers


def bed(count, ranks):
    """The lattice of all ranks."""
    cx, cy, layers = shape(count)
    px, py = (ranks // 4, 4) if ranks >= PER_NODE and ranks % 4 == 0 else grid(ranks)
    text = CASE.format(
        x=px * cx * CELL, y=py * cy * CELL, z=5 * layers * DIAMETER, px=px, py=py, cx=px * cx, cy=py * cy, cz=2 * layers,
        count=per_rank(count) * ranks, bed=0.0006 + layers * DIAMETER,
    )
    return text, None


# Table 5.7.
NODES = [1, 2, 4, 8, 16, 48]
SIZES = [(200, 4.8), (400, 9.6), (800, 19.2), (1600, 38.4), (3200, 76.8), (9600, 230.4)]

STUDY = Study(
    name="fluidised-bed",
    title="Fluidised bed, time of the particles",
    ranks=[PER_NODE * nodes for nodes in NODES],
    warm=20000, steps=20000,
    with_fluid=True,
    systems=[System(kind="beads", count=300000, case=bed, actual=per_rank, source={16: 1.0, 768: 0.91})],
    published=[
        ("Rakotonirina (2016), table 5.7; the text gives S = 0.91 of 48 nodes relative to one.",
         ["nodes", "cores", "length over diameter", "particles (million)"],
         [(nodes, PER_NODE * nodes, length, million) for nodes, (length, million) in zip(NODES, SIZES)]),
    ],
)

if __name__ == "__main__":
    main(STUDY)
