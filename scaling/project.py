#!/usr/bin/env python3
"""A billion spheres on many ranks, as model.py expects it: Markdown tables and a picture.

`--measure` times a few beds on one rank, and messages on two, and writes the constants. `--check` counts clones, messages
and bytes of small beds on many ranks, which may be more than cores, beside the model. Without either the constants
are used for a projection.

    scaling/project.py --measure
    scaling/project.py --check --ranks 2 4 8 16 27 64
    scaling/project.py
"""

import argparse
import itertools
import json
import math
import os
import random
import statistics
from pathlib import Path

from benchmark import BINARY, DT, GLASS, RADIUS, ROOT, machine, run, table
from exchange import layout
from model import (
    AT_REST, FAST, NOISE, TERMS, Bed, Constants, Network, counts, brick, counts, imbalance_by_chance, layouts, mean_and_most, row, scaling, step,
)
from study import launch, number, parse, picture, write_csv
from weak import bed as settling_bed, per_rank

DIAMETER = 2 * RADIUS
SETTLED = 0.6  # solid fraction of a settled bed
SPHERES = 10**9
RANKS = [1024, 10_240, 102_400]  # whole nodes
# Grids of ranks, and which of them share a node.
ARRANGEMENTS = {"columns": ("columns", brick), "blocks": ("blocks", brick), "blocks, a row per node": ("blocks", row)}
DEPTH = 10  # width over height of the bed that is projected

# Latencies are round figures as quoted for such networks; what they decide, agreement, is little beside bandwidth.
NETWORKS = [
    Network("HDR InfiniBand", 1.2e-6 + 4 * 0.13e-6, 25e9,
            "200 Gb/s per port; 1.2 us between nodes at one switch, as osu_latency finds with ConnectX-6 adapters, and 130 ns,"
            " as the makers give for Quantum switches, for each of four more switches in a fat tree of three levels"),
    Network("Slingshot-11", 1.6e-6 + 2 * 0.35e-6, 25e9,
            "200 Gb/s per adapter; 1.6 us, as LUMI expects of osu_latency (Lumi-supercomputer/reframe, issue 7), and 350 ns, as"
            " De Sensi et al. (SC20) find for a switch, for each of two more switches of a dragonfly"),
]

RANDOM = """\
name = "random spheres"
seed = 5
gravity = [0, 0, 0]

[domain]
lower = [0, 0, 0]
upper = [{x:.6f}, {y:.6f}, {z:.6f}]
periodic = {periodic}
ranks = {layout}
balance = false

[time]
end = 10
dt = {dt}
{keys}
{glass}
[[shape]]
name = "bead"
kind = "sphere"
radius = {radius}

[[insert]]
name = "spheres"
particles = [{{ shape = "bead", material = "glass" }}]
place = {{ kind = "file", path = "places.csv" }}
"""


def random_case(upper, grid, periodic, keys=""):
    """The case of spheres whose places are in places.csv; more keys of [time]."""
    x, y, z = upper
    periodic = json.dumps(periodic)
    return RANDOM.format(x=x, y=y, z=z, periodic=periodic, layout=list(grid), dt=DT, keys=keys, glass=GLASS, radius=RADIUS)


def random_places(count, lower, upper):
    """Centres (m) of spheres at random that do not touch, periodic across x and y."""
    chance, cells, places = random.Random(5), {}, []
    across = [int((hi - lo) / DIAMETER) for lo, hi in zip(lower, upper)]
    while len(places) < count:
        place = [chance.uniform(lo, hi) for lo, hi in zip(lower, upper)]
        cell = [min(int((x - lo) / (hi - lo) * n), n - 1) for x, lo, hi, n in zip(place, lower, upper, across)]
        around = itertools.product(*((c - 1, c, c + 1) for c in cell))
        others = (other for i, j, k in around for other in cells.get((i % across[0], j % across[1], k), ()))
        apart = lambda a, b: [math.remainder(x - y, hi - lo) if axis < 2 else x - y
                              for axis, (x, y, lo, hi) in enumerate(zip(a, b, lower, upper))]
        if all(math.hypot(*apart(place, other)) > DIAMETER for other in others):
            cells.setdefault(tuple(cell), []).append(place)
            places.append(place)
    return places


def random_bed(count, grid, solid_fraction=0.2, filled=0.85):
    """Spheres at rest at random in the lower part of a box of cubes, one per rank: the case, and what the model takes."""
    edge = (count * math.pi / 6 / solid_fraction) ** (1 / 3) * DIAMETER
    # A periodic axis of one rank needs room for two ranges.
    edge = max(edge, 2.1 * (1 + FAST) * DIAMETER)
    upper = tuple(n * edge for n in grid)
    top, total = filled * upper[2], count * math.prod(grid)
    fraction = total * math.pi / 6 * DIAMETER**3 / (upper[0] * upper[1] * (top - RADIUS))
    model = Bed((0.0, 0.0, 0.0), upper, (0.0, 0.0, RADIUS), (upper[0], upper[1], top), (True, True, False), grid, total,
                DIAMETER, fraction, (AT_REST, AT_REST))
    return random_case(upper, grid, [True, True, False]), model


def bench(text, ranks, warm, steps, options, name):
    """What `bench` finds of a case."""
    folder = options.out / "project" / name
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "case.toml").write_text(text)
    command = [options.binary.resolve(), "bench", "case.toml", "--warm", warm, "--steps", steps, "--segments", 3]
    output = run(launch(ranks, command, ranks > len(os.sched_getaffinity(0))), options.timeout, folder)
    (folder / "bench.txt").write_text(output)
    return parse(output)


def check(options):
    """Counted beside predicted."""
    rows = []
    for ranks in options.ranks:
        text, model = random_bed(options.count, layout(ranks))
        places = random_places(model.particles, model.filled_lower, model.filled_upper)
        folder = options.out / "project" / f"check-{ranks}"
        folder.mkdir(parents=True, exist_ok=True)
        write_csv(folder / "places.csv", ["x", "y", "z"], places)
        found = bench(text, ranks, 1, 3, options, f"check-{ranks}")
        predicted = mean_and_most(model)
        alike = predicted["owned"][1] / predicted["owned"][0]
        chance = imbalance_by_chance(predicted["owned"][1], ranks, model.solid_fraction)
        predicted["imbalance"] = (alike * chance, None)
        for name, (mean, _) in predicted.items():
            counted = found.imbalance() if name == "imbalance" else found.per_rank.get(name, (None,))[0]
            digits = 3 if name == "imbalance" else 1
            off = f"{100 * (mean / counted - 1):+.1f} %" if counted else "-"
            rows.append([ranks, " x ".join(map(str, model.layout)), name, number(mean, digits), number(counted, digits), off])
    header = ["ranks", "grid", "mean per rank", "model", "counted", "off by"]
    print(f"{options.count} spheres per rank at random.\n\n{table(header, rows)}")
    write_csv(options.out / "project/check.csv", header, rows)


def seconds(found, *names):
    """Time of phases per particle and step (s), the median of the segments."""
    return 1e-6 * statistics.median(sum(phases[name] for name in names) for phases in found.phases)


def measure(options):
    """Writes the constants of this machine."""
    work, rebuild, clone, memory = [], [], [], []
    for count in options.sizes:
        text, spheres = settling_bed(count, (1, 1, 1)), per_rank(count)
        falling = bench(text, 1, 0, 1000, options, f"falling-{count}")
        steps = max(100, 3_000_000 // count)
        settled = bench(text, 1, 8000 if count <= 10000 else 20000, steps, options, f"settled-{count}")
        if falling.rebuilds:
            rebuild.append(1000 * 1e-6 * falling.phases[-1]["neighbour lists"] / falling.rebuilds)
        apart = seconds(settled, "neighbour lists", "clone update", "agreement of ranks")
        contacts = seconds(settled, "particle contacts", "wall contacts")
        contacts /= contacts + seconds(settled, "motion")
        work.append((spheres, 1e-6 * statistics.median(settled.times) - apart))
        clone.append(seconds(settled, "clone update") * spheres / settled.clones)
        if "memory_bytes" in settled.per_rank:
            memory.append(settled.per_rank["memory_bytes"][0] / (spheres + settled.clones))
        print(f"{spheres} spheres: {1e6 * work[-1][1]:.4f} us per sphere and step", flush=True)
    if not rebuild:
        raise SystemExit("no list was rebuilt within 3000 steps of the fall: nothing to measure rebuilds by")
    # Two ranks with next to nothing to do: what is not copying is one message, latency included.
    pair = bench(settling_bed(64, (2, 1, 1)), 2, 1000, 20000, options, "pair")
    message = seconds(pair, "clone update") * pair.particles - pair.clones * clone[0]
    constants = dict(machine=machine(), work=work, rebuild=statistics.median(rebuild), clone=statistics.median(clone),
                     message=max(0.0, message), contacts=contacts, particle_bytes=memory[-1] if memory else 400.0)
    options.constants.write_text(json.dumps(constants, indent=1) + "\n")
    print(f"{constants['machine']}: {options.constants}")


def read_constants(path):
    if not path.exists():
        raise SystemExit(f"{path}: no constants yet; measure them by scaling/project.py --measure")
    values = json.loads(path.read_text())
    named = values.pop("machine")
    return named, Constants(**values)


def bed_of(spheres, grid_name, ranks):
    """A settled bed, closed on all sides, DEPTH times as wide as high, and its grid of ranks."""
    width = (spheres * math.pi / 6 / SETTLED * DEPTH) ** (1 / 3) * DIAMETER
    upper = (width, width, width / DEPTH)
    origin = (0.0, 0.0, 0.0)
    return Bed(origin, upper, origin, upper, (False,) * 3, layouts(ranks, upper)[grid_name], spheres, DIAMETER, SETTLED)


def projected(spheres, arrangement, ranks, constants, network, options, overlap=False):
    """The bed and the terms of its step."""
    name, nodes = ARRANGEMENTS[arrangement]
    bed = bed_of(spheres, name, ranks)
    return bed, step(bed, constants, network, options.ranks_per_node, options.rebuild_steps, nodes, overlap)


def first_to_break(spheres, arrangement, constants, network, options):
    """The term that is the first to take a tenth of the step as ranks double, and on how many."""
    for ranks in (2**k for k in range(1, 21)):
        _, terms = projected(spheres, arrangement, ranks, constants, network, options)
        term = max(TERMS[1:], key=terms.get)
        if terms[term] > 0.1 * sum(terms.values()):
            return term, ranks
    return "none", "-"


def project(options):
    """Tables and picture of the projection."""
    named, constants = read_constants(options.constants)
    ranks_asked, spheres = options.ranks or RANKS, options.spheres
    header = ["network", "arrangement", "grid", "ranks", "spheres per rank", "clones over own", "step (us)", "S(n)",
              "with overlap", *TERMS]
    rows, breaks, curves = [], [], []
    for network in NETWORKS:
        for arrangement in ARRANGEMENTS:
            points, hidden_points = {}, {}
            for ranks in ranks_asked:
                bed, terms = projected(spheres, arrangement, ranks, constants, network, options)
                whole, middle = sum(terms.values()), counts(bed, tuple(n // 2 for n in bed.layout))
                points[ranks] = scaling(bed, terms, constants, options.rebuild_steps)
                _, hidden = projected(spheres, arrangement, ranks, constants, network, options, overlap=True)
                hidden_points[ranks] = scaling(bed, hidden, constants, options.rebuild_steps)
                rows.append([network.name, arrangement, " x ".join(map(str, bed.layout)), f"{ranks:,}", f"{spheres / ranks:,.0f}",
                             f"{middle.clones / middle.owned:.2f}", f"{1e6 * whole:,.0f}", f"{points[ranks]:.2f}", f"{hidden_points[ranks]:.2f}",
                             *(f"{100 * terms[term] / whole:.1f} %" for term in TERMS)])
            # The networks hardly differ: one in the picture.
            if network is NETWORKS[0]:
                curves += [(arrangement, points, False), (f"{arrangement}, overlapped", hidden_points, True)]
            breaks.append([network.name, arrangement, *first_to_break(spheres, arrangement, constants, network, options)])
    print(f"{spheres:,} spheres. Constants of {named}. {options.ranks_per_node} ranks per node, lists rebuilt every"
          f" {options.rebuild_steps} steps.\n\n{table(header, rows)}\n")
    print(table(["network", "arrangement", "first to take a tenth of the step", "on ranks"], breaks) + "\n")
    storage = []
    for ranks in ranks_asked:
        bed = bed_of(spheres, "blocks", ranks)
        middle = counts(bed, tuple(n // 2 for n in bed.layout))
        size = spheres * options.checkpoint_bytes
        bytes_per_sphere = options.particle_bytes or constants.particle_bytes
        storage.append([f"{ranks:,}", f"{(middle.owned + middle.clones) * bytes_per_sphere / 1e6:,.1f}", f"{size / 1e9:,.0f}",
                        f"{size / options.file_system / 1e9:.1f}"])
    print(table(["ranks", "memory per rank (MB)", "checkpoint (GB)", f"s at {options.file_system:g} GB/s"], storage) + "\n")
    print("\n".join(f"{network.name}: {network.source}." for network in NETWORKS))
    noise = ", ".join(f"{1e6 * tau:g} us {f:g} times per second and core" for f, tau in NOISE)
    print(f"Noise: {noise}; assumed.")
    folder = options.out / "project"
    folder.mkdir(parents=True, exist_ok=True)
    write_csv(folder / "projection.csv", header, rows)
    picture(folder / "projection.svg", curves, f"{spheres:,} spheres, {NETWORKS[0].name}, by the model")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--measure", action="store_true", help="write the constants of this machine")
    what.add_argument("--check", action="store_true", help="count on many ranks, beside the model")
    parser.add_argument("--constants", type=Path, default=ROOT / "results/scaling/constants.json")
    parser.add_argument("--binary", type=Path, default=BINARY, help="grains-mpi program")
    parser.add_argument("--out", type=Path, default=ROOT / "results/scaling", help="folder of cases and tables")
    parser.add_argument("--timeout", type=float, default=7200, help="longest time of one run (s)")
    parser.add_argument("--ranks", type=int, nargs="+", help="of the projection, or of the check")
    parser.add_argument("--sizes", type=int, nargs="+", default=[1000, 4000, 16000, 64000, 250000], help="spheres, to measure")
    parser.add_argument("--count", type=int, default=500, help="spheres per rank, to check")
    parser.add_argument("--spheres", type=int, default=SPHERES, help="of the projection")
    parser.add_argument("--ranks-per-node", type=int, default=128)
    parser.add_argument("--rebuild-steps", type=float, default=60, help="steps between rebuilds; lists are meant to last 80, but ranks join their neighbours")
    parser.add_argument("--particle-bytes", type=float, help="memory per particle (B); as measured, or 400")
    parser.add_argument("--checkpoint-bytes", type=float, default=400, help="of a sphere with its contacts (B)")
    parser.add_argument("--file-system", type=float, default=100, help="bandwidth of writing (GB/s)")
    options = parser.parse_args()
    options.constants.parent.mkdir(parents=True, exist_ok=True)
    if options.measure:
        measure(options)
    elif options.check:
        options.ranks = options.ranks or [2, 4, 8, 16, 27, 64]
        check(options)
    else:
        project(options)


if __name__ == "__main__":
    main()
