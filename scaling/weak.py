#!/usr/bin/env python3
"""Weak scaling of beds of spheres that grow with the number of ranks.

Each rank has its own square column of a bed that is periodic in x and y. The spheres start on a lattice with gaps of a
hundredth and are in contact after the warm-up.

    scaling/weak.py --ranks 1 2 4 --count 4000
"""

from benchmark import DT, FLOOR, GLASS, RADIUS
from study import Study, System, grid, main

SPACING = 2.02 * RADIUS  # m
ASPECT = 2  # height of a rank's column over its width
BELOW = 0.001  # m, of the box below the floor
ABOVE = 4 * SPACING  # m, of the box above the lattice

CASE = """\
name = "weak scaling"

[domain]
lower = [0, 0, -{below}]
upper = [{x:.5f}, {y:.5f}, {top:.5f}]
periodic = [true, true, false]
ranks = {layout}
balance = false
{keys}
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


def column(count):
    """Spheres along the width and height of a column of about `count`."""
    width = max(4, round((count / ASPECT) ** (1 / 3)))
    return width, max(1, round(count / width**2))


def per_rank(count):
    """Spheres of a column of about `count`."""
    width, height = column(count)
    return width * width * height


def bed(count, layout, keys=""):
    """The case of a bed of layout[0] x layout[1] columns, layout[2] of them on top of each other; more keys of [domain]."""
    width, height = column(count)
    x, y, z = (n * across * SPACING for n, across in zip(layout, (width, width, height)))
    return CASE.format(
        x=x, y=y, height=z, below=BELOW, top=z + ABOVE, layout=list(layout), keys=keys, radius=RADIUS, spacing=SPACING,
        count=per_rank(count) * layout[0] * layout[1] * layout[2], dt=DT, glass=GLASS, floor=FLOOR,
    )


def spheres(count, warm):
    case = lambda number, ranks: (bed(number, (*grid(ranks), 1)), None)
    return System(kind="spheres", count=per_rank(count), case=case, actual=per_rank, warm=warm)


STUDY = Study(
    name="weak",
    title="Weak scaling of settled spheres",
    ranks=[1, 2, 4, 8, 16, 32, 64, 128, 256, 512],
    warm=8000, steps=6000,
    systems=[spheres(4000, 8000), spheres(100000, 20000)],
)

if __name__ == "__main__":
    main(STUDY)
