#!/usr/bin/env python3
"""Rebuilds and waits of ranks that rebuild their lists apart from each other: counted beside a simulation of their rule. Needs NumPy.

Spheres fly about in a periodic box, too few to meet often: the fastest of a rank decides how long its lists last,

    n = min(h, a / (v dt)),

h being the steps that lists are meant to last, a the largest way that a particle may go, and v its speed. Their velocities are drawn from a
Maxwell distribution. The simulation moves the same spheres, without collisions, and follows what ranks tell each other, as `dem/rebuild_times.rs` has it: a rank tells
its neighbours of a rebuild four steps before; a neighbour joins it if half of its own lists' life is over, or if it holds particles
that are to go there.

    scaling/rebuilds.py --ranks 2 8 27 64 125 216
"""

import argparse
import itertools
import math
import os
import random
from pathlib import Path

import numpy

from benchmark import BINARY, DT, RADIUS, ROOT, table
from exchange import layout
from model import AT_REST, FAST
from project import bench, random_case, random_places
from study import write_csv

HORIZON = 80  # steps that lists are meant to last
AHEAD = 4  # steps by which a rebuild is announced
REQUEST = 2  # steps until a rebuild that neighbours are asked for
STRAY_STEPS = 8  # steps for which a sphere beyond a border must have room
STRAY_SHARE = 0.25  # of its allowance, that it may be beyond
DEVIATION = 0.0015  # of a component of the velocity: radii per step
SPREAD = 1.0  # of the ranks: their deviations are up to 2^SPREAD times as large or small
FRACTION = 0.0002  # solid


def edge(count):
    """Edge of the subdomain of a rank (radii)."""
    return (count * 4 / 3 * math.pi / FRACTION) ** (1 / 3)


def gas(grid, count):
    """Places (radii) and velocities (radii per step) of the spheres of all ranks."""
    chance, width = random.Random(3), edge(count)
    upper = [n * width for n in grid]
    places = random_places(count * math.prod(grid), [0.0] * 3, [x * RADIUS for x in upper])
    places = numpy.array(places) / RADIUS
    hotter = numpy.array([2 ** chance.uniform(-SPREAD, SPREAD) for _ in range(math.prod(grid))])
    velocities = numpy.array([[chance.gauss(0, DEVIATION) for _ in range(3)] for _ in places])
    return places, velocities * hotter[rank_at(places, grid, width), None]


def rank_at(places, grid, width):
    """Ranks whose subdomains, of this width, hold places (radii)."""
    return numpy.ravel_multi_index(tuple((places // width).astype(int).T), grid, mode="wrap")


def counted(spheres, ranks, options):
    """What a run counts per rank and step."""
    grid, sigma = layout(ranks), DEVIATION * RADIUS / DT
    folder = options.out / "project" / f"rebuilds-{ranks}"
    folder.mkdir(parents=True, exist_ok=True)
    rows = numpy.hstack([spheres[0] * RADIUS, spheres[1] * RADIUS / DT]).tolist()
    write_csv(folder / "places.csv", ["x", "y", "z", "vx", "vy", "vz"], rows)
    upper = [n * edge(options.count) * RADIUS for n in grid]
    text = random_case(upper, grid, [True] * 3, f"impact_speed = {8 * 2**SPREAD * sigma}\n")
    found = bench(text, ranks, options.warm, options.steps, options, f"rebuilds-{ranks}").per_rank
    mean = lambda name: found[name][0]
    per_step = 1 / (3 * options.steps)
    return {"rebuilds": mean("rebuilds") * per_step, "of borders": mean("border_rebuilds") * per_step, "waits": mean("waits")}


def neighbours(grid):
    """The neighbours of each rank of a periodic grid."""
    places = list(itertools.product(*map(range, grid)))
    number = {place: k for k, place in enumerate(places)}
    around = lambda place: {number[tuple((p + d) % n for p, d, n in zip(place, direction, grid))]
                            for direction in itertools.product((-1, 0, 1), repeat=3)}
    return [around(place) - {k} for k, place in enumerate(places)]


class Ranks:
    """Ranks and the lists of their spheres, which fly freely; lengths in radii, times in steps."""

    def __init__(self, spheres, grid, count):
        self.places, self.velocities = spheres
        self.grid, self.width, self.near = grid, edge(count), neighbours(grid)
        self.speeds = numpy.linalg.norm(self.velocities, axis=1)
        self.nominal = numpy.clip(HORIZON * self.speeds, AT_REST, FAST)
        self.owner = rank_at(self.places, grid, self.width)
        self.ways = numpy.zeros_like(self.places)  # from the references
        self.allowances = self.nominal.copy()
        ranks = len(self.near)
        self.stray = numpy.array([STRAY_STEPS * self.speeds[self.owner == k].max() for k in range(ranks)])
        # How far any sphere may act beyond a border, less its radius.
        self.room = (self.nominal + numpy.maximum(STRAY_SHARE * self.nominal, self.stray[self.owner])).max()
        self.since, self.lifetime = numpy.zeros(ranks), numpy.full(ranks, math.inf)
        self.plan, self.next_look = numpy.full(ranks, math.inf), numpy.ones(ranks)
        self.holds, self.asks = [set() for _ in range(ranks)], [set() for _ in range(ranks)]
        for k in range(ranks):
            self.choose(k, 0)

    def choose(self, k, step):
        """References and allowances of the spheres of a rank, and what is told of those beyond its borders."""
        own = numpy.flatnonzero(self.owner == k)
        stray = self.stray[k] = STRAY_STEPS * self.speeds[own].max()
        allowances = numpy.minimum(self.nominal[own], min(self.room / (1 + STRAY_SHARE), self.room - stray))
        corner = numpy.array(numpy.unravel_index(k, self.grid)) * self.width
        upper = numpy.array(self.grid) * self.width
        # From the middle of the subdomain, by the shortest way around.
        middle = corner + 0.5 * self.width
        from_middle = (self.places[own] - middle + 0.5 * upper) % upper - 0.5 * upper
        ways = from_middle - numpy.clip(from_middle, -0.5 * self.width, 0.5 * self.width)
        beyond = numpy.linalg.norm(ways, axis=1)
        can_wait = beyond + 2 * stray <= self.room
        end = numpy.where(can_wait, self.room - stray, self.room)
        self.ways[own] = ways
        self.allowances[own] = numpy.where(beyond > 0, numpy.minimum(allowances + beyond, end), allowances)
        there = rank_at(self.places[own], self.grid, self.width)
        self.holds[k], self.asks[k] = set(there[beyond > 0]), set(there[(beyond > 0) & ~can_wait])
        self.since[k], self.next_look[k] = 0, 1
        self.plan[k] = step + REQUEST if self.asks[k] else math.inf

    def left(self, k):
        """Steps that the lists of a rank can still be used."""
        own = self.owner == k
        ways, velocities, speeds = self.ways[own], self.velocities[own], self.speeds[own]
        along = (ways * velocities).sum(axis=1)
        room = self.allowances[own] ** 2 - (ways**2).sum(axis=1)
        return ((numpy.sqrt(along**2 + speeds**2 * numpy.maximum(room, 0)) - along) / speeds**2).min()

    def step(self, step):
        """Which ranks rebuild their lists in a step, and which take new clones of neighbours meanwhile."""
        rebuilds = self.plan <= step
        told = numpy.where(rebuilds, math.inf, self.plan)
        for k in numpy.flatnonzero(rebuilds):
            own = self.owner == k
            used = (numpy.linalg.norm(self.ways[own], axis=1) / self.allowances[own]).max()
            self.lifetime[k] = self.since[k] / used
        there = rank_at(self.places, self.grid, self.width)
        goes = rebuilds[self.owner] & rebuilds[there]
        self.owner[goes] = there[goes]
        for k in numpy.flatnonzero(rebuilds):
            self.choose(k, step)
        borders = numpy.array([not rebuilds[k] and any(rebuilds[list(near)]) for k, near in enumerate(self.near)])
        for k, near in enumerate(self.near):
            for other in near:
                joins = 2 * self.since[k] >= self.lifetime[k] or other in self.holds[k] or k in self.asks[other]
                if step < told[other] < math.inf and joins:
                    self.plan[k] = min(self.plan[k], told[other])
        self.places = (self.places + self.velocities) % (numpy.array(self.grid) * self.width)
        self.ways += self.velocities
        self.since += 1
        # The nearer the end, the oftener it is looked for.
        for k in numpy.flatnonzero(numpy.isinf(self.plan) & (self.since >= self.next_look)):
            left = self.left(k)
            if left <= AHEAD:
                self.plan[k] = step + 1 + max(left // 1, 1)
            else:
                self.next_look[k] = self.since[k] + max(left // 2, 1)
        return rebuilds, borders


def simulated(spheres, grid, count, warm, steps):
    """What the rule gives per rank and step."""
    ranks = Ranks(spheres, grid, count)
    counts = {"rebuilds": 0, "of borders": 0, "waits": 0}
    for step in range(warm + steps):
        rebuilds, borders = ranks.step(step)
        if step >= warm:
            partners = numpy.array([any(rebuilds[list(near)]) for near in ranks.near])
            counts["rebuilds"] += rebuilds.sum()
            counts["of borders"] += borders.sum()
            # One for updates or what is told instead, one for spheres that change hands, one for new clones.
            counts["waits"] += len(rebuilds) + 2 * (rebuilds & partners).sum() + borders.sum()
    return {name: total / (len(ranks.near) * steps) for name, total in counts.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", type=Path, default=BINARY, help="grains-mpi program")
    parser.add_argument("--out", type=Path, default=ROOT / "results/scaling", help="folder of cases and tables")
    parser.add_argument("--timeout", type=float, default=7200, help="longest time of one run (s)")
    parser.add_argument("--ranks", type=int, nargs="+", default=[2, 8, 27, 64])
    parser.add_argument("--count", type=int, default=500, help="spheres per rank")
    parser.add_argument("--warm", type=int, default=100, help="steps before counting")
    parser.add_argument("--steps", type=int, default=400, help="steps of each of three segments")
    options = parser.parse_args()
    rows = []
    for ranks in options.ranks:
        spheres = gas(layout(ranks), options.count)
        model = simulated(spheres, layout(ranks), options.count, options.warm, 3 * options.steps)
        for name, told in counted(spheres, ranks, options).items():
            off = f"{100 * (model[name] / told - 1):+.1f} %" if told else "-"
            rows.append([ranks, name, f"{model[name]:.4f}", f"{told:.4f}", off])
    header = ["ranks", "per rank and step", "model", "counted", "off by"]
    print(f"{options.count} spheres per rank that fly about.\n\n{table(header, rows)}")
    write_csv(options.out / "project/rebuilds.csv", header, rows)


if __name__ == "__main__":
    main()
