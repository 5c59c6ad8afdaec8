#!/usr/bin/env python3
"""Strong scaling of 2,000 ellipsoids (Srinivasan 2019, section 4.2.1, tables 4-4 and 4-5).

The bed of cases/superellipsoid-scaling, settled once by GJK at 4000 N/m, and timed as it is, and at the source's
40 N/m with its 400 surface vertices per body. The source timed 2.6 s from the fall of eight blocks on; here it is the
settled bed. Vertices let bodies sink, so that only the first steps after the change are timed.

    scaling/ellipsoids.py --ranks 1 2
"""

import re

from benchmark import ROOT
from copies import Copies
from study import Stage, Study, System, main

CASE = (ROOT / "cases/superellipsoid-scaling/ellipsoids.toml").read_text()
# The stiffness of the source, at which vertices find bodies that overlap.
SOFT = [
    ("normal_stiffness = 4000", "normal_stiffness = 40"),
    ("dt = 1.2e-6", "dt = 1.2e-5"),
    ("impact_speed = 1\n", "impact_speed = 0.02\n"),
    ("semi_axes", "surface_vertices = { per_direction = 20 }\nsemi_axes"),
]


def replaced(text, pairs):
    for old, new in pairs:
        if old not in text:
            raise SystemExit(f"ellipsoids.toml no longer has: {old}")
        text = text.replace(old, new)
    return text


def settling(count):
    """The run that settles them."""
    end = re.search(r"^end = (\S+)", CASE, re.M)[1]
    pairs = [
        ("count = 2000", f"count = {count}"), ('"results/superellipsoid-scaling"', '"settled"'),
        ("particles = 0\n", f"particles = {end}\n"),
    ]
    return [Stage(f"ellipsoids-{count}", replaced(CASE, pairs))]


def settled(vertices):
    def case(count, ranks):
        text = re.sub(r'place = \{ kind = "lattice".*', 'place = { kind = "file", path = "bed.h5" }', CASE)
        text = replaced(text, [("count = 2000", f"count = {count}"), *(SOFT if vertices else [])])
        return text + ("\n[limits]\noverlap = 0.5\n" if vertices else ""), Copies()

    return case


# Table 4-5: processors -> wall-clock time (s).
SECONDS = {1: 213323, 2: 110241, 4: 56907, 8: 29716}
SPEED_UP = {ranks: SECONDS[1] / seconds for ranks, seconds in SECONDS.items()}

STUDY = Study(
    name="ellipsoids",
    title="Strong scaling of 2,000 ellipsoids",
    ranks=list(SECONDS),
    warm=2000, steps=9000,
    is_strong=True,
    systems=[
        System(kind="ellipsoids by GJK", count=2000, case=settled(False), stages=settling, source=SPEED_UP),
        System(kind="ellipsoids by 400 vertices", count=2000, case=settled(True), stages=settling, source=SPEED_UP,
               warm=100, steps=150),
    ],
    published=[
        ("Srinivasan (2019), table 4-5: 2.6 s of 2000 ellipsoids with 400 vertices each.",
         ["processors", "wall-clock time (s)", "speed-up", "efficiency"],
         [(n, seconds, f"{SPEED_UP[n]:.3f}", f"{SPEED_UP[n] / n:.4f}") for n, seconds in SECONDS.items()]),
    ],
)

if __name__ == "__main__":
    main(STUDY)
