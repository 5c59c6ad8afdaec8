"""What a step costs on many ranks: a model of counts, from geometry, and of times, from a few constants.

**Counts.** The box is cut into equal subdomains L wide. A particle of diameter d is cloned to the neighbours beyond each
border that is nearer than

    w = d (1 + (s + 1.25 s_max) / 2),

s being how far it may go before lists are rebuilt, over its radius (0.025 at rest, 0.4 if fast), and s_max the
largest s of all particles; the quarter is for particles beyond a border that have not changed hands yet. In a direction (a, b, c) of the 26 goes what lies within w of each border that the direction
names,

    clones = density * sum over directions of |layer of the direction, where there are particles|,

which for a cube deep in the bed is N ((1 + 2 w/L)^3 - 1). A neighbour gets one message per step, of 9 numbers (72 bytes)
per sphere and 13 (104 bytes) per body, after 2 about the sender's lists. Clones across a periodic axis of one rank need no message.

**Imbalance.** The number of particles in a subdomain varies by sqrt(N S0), S0 = (1 - phi)^4 / (1 + 2 phi)^2 that of hard
spheres at rest at random (Percus and Yevick 1958) at the solid fraction phi; the fullest of P ranks is off by the mean
of the largest of P normal numbers (Blom 1958). Where the bed does not fill the box, geometry comes first.

**Times** of a step of the busiest rank:

    work       N (c(N) + c_list / n)               c of one rank, caches included; c_list of a rebuild every n steps
    clones     clones c_clone                      packing and unpacking
    messages   L + m o + B / b                     latency L (s), m messages, o (s) each; B bytes that leave the node, of
                                                   all its ranks, through its adapter of b (B/s)
    agreement  ceil(log2 P) o / 4                  its messages, every fourth step; nobody waits for them
    rebuild    3 (L + m o + B / b) / n             notices, migration, and clones with all their constants (23 numbers), of
                                                   lengths not known before
    noise      sum tau min(1, 2 (f T)^(1/4))       what ranks lose to interrupts of duration tau (s) that come f times per
                                                   second and core, in a step of T (s) otherwise

Messages overlap with each other, and with contacts of owned particles among each other if MPI carries them on in the
meantime: both cases are given. Of pairs d apart in any direction the two are on one side of the borders of an axis with the
probability 1 - d / 2 L; P being the product of these, P / (2 - P) of the pairs that a rank works on are of owned particles. Pairs of a particle and a clone are worked on by both
sides; c(N) is that of a bed that is periodic across, where the same holds, so that it is in the work. Each rank rebuilds its
lists every n steps, whatever others do.

**Noise** is what a rank loses that waits for its 26 neighbours alone. What an interrupt delays, others of the same step hide: the end
of a step is the longest path through the ranks and steps before it, which meets one interrupt per k steps where the cone
of ranks that k steps reach, 2 k^4 of them, holds one. Of 24^3 ranks that were simulated so, 2 (f T)^(1/4) is between 1.0 and 1.8
times what is lost from f T = 1e-5 to 1e-2 (`noise.py`). If all waited for each other it would be 1 - exp(-P f T).
"""

import itertools
import math
from dataclasses import dataclass
from statistics import NormalDist

# How far a particle may go before lists are rebuilt, over its radius, at rest and at most: the program's defaults.
AT_REST, FAST = 0.025, 0.4
# What is kept for particles that have not changed hands yet, over that.
STRAYS = 1.25
# Steps between two agreements.
AGREEMENT_EVERY = 4
NUMBERS = {"sphere": 9, "body": 13}  # per clone in an update
NOTICE = 2  # numbers per message besides
DIRECTIONS = [d for d in itertools.product((-1, 0, 1), repeat=3) if any(d)]


@dataclass
class Bed:
    """Spheres in a part of a box that is cut into equal subdomains."""

    lower: tuple  # of the box (m)
    upper: tuple
    filled_lower: tuple  # of the part with particles (m)
    filled_upper: tuple
    periodic: tuple  # per axis
    layout: tuple  # ranks per axis
    particles: int
    diameter: float  # m
    solid_fraction: float
    reaches: tuple = (AT_REST, FAST)  # of most particles, and of the fastest

    def ranks(self):
        return math.prod(self.layout)

    def density(self):
        """Particles per volume of the part they fill (1/m3)."""
        return self.particles / math.prod(hi - lo for lo, hi in zip(self.filled_lower, self.filled_upper))

    def subdomain(self, axis):
        return (self.upper[axis] - self.lower[axis]) / self.layout[axis]

    def layer(self):
        """Distance from a border within which particles are cloned (m)."""
        own, largest = self.reaches
        return self.diameter * (1 + (own + STRAYS * largest) / 2)


@dataclass
class Counts:
    """What a rank has and sends in a step."""

    owned: float
    clones: float  # periodic images of its own particles included
    remote: float  # clones sent to other ranks
    neighbours: int  # other ranks
    messages: float
    off_node: float  # clones sent to other nodes
    inner: float = 1.0  # share of the pairs that are of owned particles

    def bytes(self, kind="sphere"):
        return 8 * (NUMBERS[kind] * self.remote + NOTICE * self.neighbours)


def neighbour(bed, place, direction):
    """Place in the grid of ranks of a neighbour, or None beyond a closed face."""
    moved = [p + d for p, d in zip(place, direction)]
    if any(not bed.periodic[a] and not 0 <= moved[a] < bed.layout[a] for a in range(3)):
        return None
    return tuple(p % n for p, n in zip(moved, bed.layout))


def grids(ranks):
    """All (px, py, pz) with px py pz = ranks."""
    for px in (n for n in range(1, ranks + 1) if ranks % n == 0):
        for py in (n for n in range(1, ranks // px + 1) if ranks // px % n == 0):
            yield px, py, ranks // px // py


def layouts(ranks, lengths):
    """Grids of ranks of least surface for a box (m): columns, cut across x and y only, and blocks."""
    surface = lambda grid: sum(n / length for n, length in zip(grid, lengths))
    return {
        "columns": min((grid for grid in grids(ranks) if grid[2] == 1), key=surface),
        "blocks": min(grids(ranks), key=surface),
    }


def row(bed, ranks_per_node):
    """Places of a node in the middle that holds ranks in a row, x fastest, as the program numbers them."""
    nx, ny, nz = bed.layout
    middle = (nz // 2 * ny + ny // 2) * nx + nx // 2
    first = middle // ranks_per_node * ranks_per_node
    return {(k % nx, k // nx % ny, k // (nx * ny)) for k in range(first, min(first + ranks_per_node, nx * ny * nz))}


def brick(bed, ranks_per_node):
    """Places of a node in the middle, a brick of ranks of minimum surface, as the program places them; in a row where none fills the grid."""
    surface = lambda edges: sum(1 / (e * bed.subdomain(a)) for a, e in enumerate(edges) if e < bed.layout[a])
    fitting = [edges for edges in grids(ranks_per_node) if all(n % e == 0 for e, n in zip(edges, bed.layout))]
    edges = min(fitting, key=surface, default=None)
    if edges is None:
        return row(bed, ranks_per_node)
    first = [n // 2 // e * e for e, n in zip(edges, bed.layout)]
    return set(itertools.product(*(range(at, min(at + e, n)) for at, e, n in zip(first, edges, bed.layout))))


def counts(bed, place, node=frozenset()):
    """Counts of the rank at a place of the grid, which shares a node with the places `node`."""

    def inside(axis, side):
        """Length of the filled part of the subdomain (0) or of its layer at a border (-1, 1) (m)."""
        low = bed.lower[axis] + place[axis] * bed.subdomain(axis)
        high = low + bed.subdomain(axis)
        layer = min(bed.layer(), high - low)
        low, high = {-1: (low, low + layer), 0: (low, high), 1: (high - layer, high)}[side]
        return max(0.0, min(high, bed.filled_upper[axis]) - max(low, bed.filled_lower[axis]))

    lengths = [{side: inside(axis, side) for side in (-1, 0, 1)} for axis in range(3)]
    of = lambda direction: bed.density() * math.prod(lengths[a][direction[a]] for a in range(3))
    found = Counts(of((0, 0, 0)), 0.0, 0.0, 0, 0.0, 0.0)
    others = {}
    for direction in DIRECTIONS:
        there = neighbour(bed, place, direction)
        if there is None:
            continue
        found.clones += of(direction)
        if there != place:
            others[there] = others.get(there, 0.0) + of(direction)
            found.remote += of(direction)
            if there not in node:
                found.off_node += of(direction)
    found.neighbours = len(others)
    shared = [axis for axis in range(3) if bed.periodic[axis] or bed.layout[axis] > 1]
    together = math.prod(1 - bed.diameter / (2 * bed.subdomain(axis)) for axis in shared)
    found.inner = together / (2 - together)
    found.messages = len(others)
    return found


def kinds_of_place(bed):
    """Places of the grid, and how many ranks are like each. Closed axes of more than eight ranks must be filled."""
    axes = []
    for n, periodic in zip(bed.layout, bed.periodic):
        if periodic:
            axes.append([(n // 2, n)])
        elif n > 8:
            axes.append([(0, 1), (n // 2, n - 2), (n - 1, 1)])
        else:
            axes.append([(k, 1) for k in range(n)])
    for choice in itertools.product(*axes):
        yield tuple(at for at, _ in choice), math.prod(times for _, times in choice)


def mean_and_most(bed):
    """Counts per rank: name -> (mean, largest), the imbalance by chance not included."""
    found = [(counts(bed, place), times) for place, times in kinds_of_place(bed)]
    whole = sum(times for _, times in found)
    names = {"owned": lambda c: c.owned, "clones": lambda c: c.clones, "neighbours": lambda c: c.neighbours,
             "messages": lambda c: c.messages, "bytes": lambda c: c.bytes(), "inner_pairs": lambda c: c.inner}
    return {name: (sum(of(c) * times for c, times in found) / whole, max(of(c) for c, _ in found)) for name, of in names.items()}


def imbalance_by_chance(per_rank, ranks, solid_fraction):
    """Particles of the fullest rank over the mean (-), where all subdomains are alike."""
    if ranks == 1:
        return 1.0
    s0 = (1 - solid_fraction) ** 4 / (1 + 2 * solid_fraction) ** 2
    largest = NormalDist().inv_cdf((ranks - 0.375) / (ranks + 0.25))
    return 1 + largest * math.sqrt(s0 / per_rank)


@dataclass
class Network:
    """What connects the nodes."""

    name: str
    latency: float  # s, one way, of a small message between far nodes
    bandwidth: float  # B/s, of a node's adapter, one way
    source: str


@dataclass
class Constants:
    """What was measured on one rank or two."""

    work: list  # (particles per rank, s per particle and step without lists, clones and agreement), ascending
    rebuild: float  # s per particle and rebuild
    clone: float  # s per clone and step
    message: float  # s per message
    contacts: float = 0.86  # share of contacts in the work
    particle_bytes: float = 400.0  # memory per particle, lists included

    def cost(self, particles):
        """Time per particle and step (s), linear in the logarithm of the number, constant beyond what was measured."""
        x = math.log(particles)
        points = [(math.log(n), c) for n, c in self.work]
        if x <= points[0][0]:
            return points[0][1]
        for (x0, c0), (x1, c1) in zip(points, points[1:]):
            if x <= x1:
                return c0 + (c1 - c0) * (x - x0) / (x1 - x0)
        return points[-1][1]


# (rate per core (1/s), duration (s)): the tick of the clock, and whatever else the system does. Assumed, not measured.
NOISE = [(250.0, 2e-6), (0.1, 100e-6)]
TERMS = ["work", "clones", "messages", "agreement", "rebuild", "noise"]


def step(bed, constants, network, ranks_per_node, steps_per_rebuild, nodes=brick, overlap=False, noise=NOISE):
    """Terms of the time of a step (s) of the busiest rank; `nodes` is row or brick.

    With `overlap` messages travel while contacts away from the borders are worked on.
    """
    ranks = bed.ranks()
    rank = max((counts(bed, place) for place, _ in kinds_of_place(bed)), key=lambda c: c.owned + c.clones)
    owned = rank.owned * imbalance_by_chance(rank.owned, ranks, bed.solid_fraction)
    node = nodes(bed, ranks_per_node)
    leaving = sum(counts(bed, place, node).off_node for place in node)
    off_node = leaving * 8 * NUMBERS["sphere"] / network.bandwidth
    agreeing = math.ceil(math.log2(ranks)) * constants.message / AGREEMENT_EVERY
    work = owned * (constants.cost(owned) + constants.rebuild / steps_per_rebuild)
    handling = rank.messages * constants.message
    travelling = network.latency + off_node if rank.neighbours else 0.0
    inner = work * constants.contacts * rank.inner if overlap else 0.0
    terms = {
        "work": work,
        "clones": rank.clones * constants.clone,
        "messages": handling + max(0.0, travelling - inner),
        "agreement": agreeing,
        "rebuild": 3 * (handling + travelling) / steps_per_rebuild if rank.neighbours else 0.0,
    }
    undisturbed = sum(terms.values())
    # A rank alone is disturbed as well, but that is in its work.
    lost = lambda chance: min(1.0, 2 * chance**0.25, 1 - math.exp(-ranks * chance))
    terms["noise"] = sum(tau * lost(f * undisturbed) for f, tau in noise) if ranks > 1 else 0.0
    return terms


def scaling(bed, terms, constants, steps_per_rebuild):
    """S(n): time of as many particles on one rank alone, over that of the step."""
    mean = bed.particles / bed.ranks()
    return mean * (constants.cost(mean) + constants.rebuild / steps_per_rebuild) / sum(terms.values())

