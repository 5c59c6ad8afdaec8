#!/usr/bin/env python3
"""Settled beds of many shapes beside settled spheres of a peer: microseconds per particle and step, as Markdown.

2,000 bodies of the volume of a sphere of 1.5 mm fall with random orientations into a box that is periodic in x and
y and come to rest on a plane. The step is then timed from their checkpoint, in turns with LAMMPS and its
14,000 spheres (see bench_spheres.py).

    scaling/bench_shapes.py --peers DIR --folder DIR   # state DIR/state/b14.csv.gz, deck DIR/lammps/in.b1; lmp
    scaling/bench_shapes.py cube trilobe               # some shapes, without a peer
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
VOLUME = 4 / 3 * math.pi * RADIUS**3  # m3
EDGE = VOLUME ** (1 / 3)  # m
LOBE = (VOLUME / (0.69 * math.pi / 4 * 2)) ** (1 / 3)  # m, diameter of a trilobe twice as long


def superellipsoid(ratios, exponent):
    """Keys of a superellipsoid of semi-axes in the given ratios, |x|^p + |y|^p + |z|^p = 1, and its longest half."""
    eps = 2 / exponent
    beta = lambda x, y: math.gamma(x) * math.gamma(y) / math.gamma(x + y)
    unit = 2 * math.prod(ratios) * eps * eps * beta(eps / 2 + 1, eps) * beta(eps / 2, eps / 2)
    axes = [r * (VOLUME / unit) ** (1 / 3) for r in ratios]
    reach = max(axes) if exponent == 2 else math.sqrt(sum(a * a for a in axes))
    return f'kind = "superellipsoid"\nsemi_axes = {axes}\neps = [{eps}, {eps}]', reach


def cross(dimensions, ratio=5):
    """Keys of a cross of square beams, `ratio` times as long as wide, and half of its largest extent."""
    width = (VOLUME / (2 * ratio - 1 if dimensions == 2 else 3 * ratio - 2)) ** (1 / 3)
    keys = f'kind = "cross"\nbeams = {dimensions}\nbeam_width = {width!r}\nbeam_length = {ratio * width!r}'
    return keys, width * math.sqrt(ratio**2 + 2) / 2


# Keys of a [[shape]], and the radius (m) that holds it.
SHAPES = {
    "cube": (f'kind = "box"\nedges = [{EDGE!r}, {EDGE!r}, {EDGE!r}]', EDGE * math.sqrt(3) / 2),
    "icosahedron": ('kind = "regular"\nsolid = "icosahedron"\ncircumradius = 1.77308e-3', 1.774e-3),
    "cylinder": (f'kind = "cylinder"\nradius = {EDGE / math.pi ** (1 / 3) / 2 ** (1 / 3)!r}\n'
                 f'height = {2 * EDGE / math.pi ** (1 / 3) / 2 ** (1 / 3)!r}', EDGE),
    "ellipsoid 2:1:1": superellipsoid([2, 1, 1], 2),
    "block, exponent 8": superellipsoid([1, 1, 1], 8),
    "trilobe": (f'kind = "lobes"\nlobes = 3\ndiameter = {LOBE!r}\nlength = {2 * LOBE!r}\narea_fraction = 0.69',
                LOBE * math.sqrt(5) / 2),
    "3-D cross": cross(3),
}

CASE = """\
name = "settled bed"
gravity = [0, 0, -9.81]

[domain]
lower = [0, 0, -0.001]
upper = [{box}, {box}, {top:.4f}]
periodic = [true, true, false]

[time]
end = 0.4
dt = {dt}
# The long ones could meet for shorter than the usual; in a settled bed they do not.
accept_coarse_dt = true

{glass}
[[shape]]
name = "body"
{keys}

[[insert]]
name = "bodies"
particles = [{{ shape = "body", material = "glass" }}]
count = {count}
orientation = "random"
place = {{ kind = "lattice", lower = [0, 0, 0], upper = [{box}, {box}, {height:.4f}], spacing = {spacing:.6g} }}
velocity = [0, 0, -0.5]

{floor}
[output]
directory = "settled"
particles = 0
series = 0.01
checkpoint = 0.05
"""


def settle(name, folder, binary, ranks, timeout):
    """The folder of a bed of a shape, settled now or by an earlier call."""
    keys, reach = SHAPES[name]
    spacing = 2.04 * reach
    box = max(0.03, 10.2 * reach)
    height = spacing * (math.ceil(COUNT / math.floor(box / spacing) ** 2) + 0.1)
    place = folder / name.replace(" ", "-").replace(",", "").replace(":", "")
    place.mkdir(parents=True, exist_ok=True)
    values = dict(box=box, height=height, top=height + 0.01, dt=DT, count=COUNT, spacing=spacing, keys=keys)
    (place / "bed.toml").write_text(CASE.format(glass=GLASS, floor=FLOOR, **values))
    if not (place / "done").exists():
        begun = ["--restart", "latest"] if list(place.glob("settled/checkpoint-*.h5")) else []
        run(mpi(ranks, [binary, "bed.toml", *begun]), timeout, place)
        (place / "done").touch()
    return place


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("shape", nargs="*", help=f"of {', '.join(SHAPES)}; all by default")
    parser.add_argument("--peers", type=Path, help="folder with state/b14.csv.gz and lammps/in.b1")
    parser.add_argument("--lammps", default="lmp", help="LAMMPS program")
    parser.add_argument("--binary", type=Path, default=BINARY, help="grains-mpi program")
    parser.add_argument("--folder", type=Path, help="where beds that have settled are kept for the next time")
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2], help="numbers of ranks")
    parser.add_argument("--rounds", type=int, default=2, help="times that program and peer take turns")
    parser.add_argument("--steps", type=int, default=1000, help="steps per segment")
    parser.add_argument("--timeout", type=float, default=7200, help="longest time of one run (s)")
    options = parser.parse_args()
    unknown = [name for name in options.shape if name not in SHAPES]
    if unknown:
        parser.error(f"unknown shape {unknown[0]}: of {', '.join(SHAPES)}")
    before = machine()
    names = options.shape or list(SHAPES)
    with tempfile.TemporaryDirectory() as temporary:
        binary = options.binary.resolve()
        folder = (options.folder or Path(temporary)).resolve()
        beds = {name: settle(name, folder, binary, max(options.ranks), options.timeout) for name in names}
        peers = options.peers and shutil.which(options.lammps)
        bed = make_bed("small", options.peers / "state/b14.csv.gz", 1, Path(temporary)) if peers else None
        own, peer = {(name, n): [] for name in names for n in options.ranks}, {n: [] for n in options.ranks}
        for _ in range(options.rounds):
            for n in options.ranks:
                if bed:
                    deck = options.peers / "lammps/in.b1"
                    peer[n] += segments(run(lammps_command(options.lammps, deck, bed, n, 300, 1000), 600), 1000)
                for name in names:
                    command = [binary, "bench", "bed.toml", "--restart", "latest", "--steps", options.steps]
                    own[name, n] += segments(run(mpi(n, command), options.timeout, beds[name]), options.steps)
    print(f"{before}. Microseconds per particle and step: median (least–largest).\n")
    rows = []
    for name in names:
        for n in options.ranks:
            cost = statistics.median(own[name, n])
            ratio = f"{cost / statistics.median(peer[n]):.2f}" if peer[n] else "-"
            gain = f"{statistics.median(own[name, 1]) / cost:.2f}" if (name, 1) in own else "-"
            rows.append([name, n, spread(own[name, n]), ratio, gain])
    for n in options.ranks:
        if peer[n]:
            rows.append(["LAMMPS, 14,000 spheres", n, spread(peer[n]), "1", "-"])
    print(table(["shape", "ranks", "time", "in units of LAMMPS' sphere", "speed-up"], rows))


if __name__ == "__main__":
    main()
