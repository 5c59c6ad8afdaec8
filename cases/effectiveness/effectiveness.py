"""Effectiveness of shapes with a first-order reaction inside, without a film, over the Thiele modulus (V/A) sqrt(k/D):
`python3 cases/effectiveness/effectiveness.py [--across 32 48] [--shapes slab cylinder sphere trilobe quadralobe]` runs what is
missing and prints a table; slab, long cylinder and sphere beside their closed forms. `--picture` draws the curves."""
import argparse
import math
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
import sweep

MODULI = (0.1, 0.3, 1.0, 3.0, 10.0, 20.0)
LOBES = 'kind = "lobes"\nlobes = {}\ndiameter = 1\nlength = 1\narea_fraction = {}'
# A hollow cylinder, bored to half its diameter: a ring of hulls.
SECTORS, BORE = 24, 0.5


def sectors():
    """The hulls of a hollow cylinder as long as wide; corners lie where the polygon has the section of the circle."""
    turn = 2 * math.pi / SECTORS
    stretch = math.sqrt(turn / math.sin(turn))
    corner = lambda r, k, z: [r * stretch * math.cos(k * turn), r * stretch * math.sin(k * turn), z]
    hull = lambda k: [corner(r, k + e, z) for r in (0.5 * BORE, 0.5) for e in (0, 1) for z in (-0.5, 0.5)]
    return ", ".join(f'{{ kind = "hull", vertices = {hull(k)} }}' for k in range(SECTORS))


# Keys of the shape, and whether it is a section of something endless.
SHAPES = {
    "slab": ('kind = "box"\nedges = [1, SPAN, 1]', 1),
    "cylinder": ('kind = "cylinder"\nradius = 0.5\nheight = 1', 2),
    "sphere": ('kind = "sphere"\nradius = 0.5', 3),
    "short cylinder": ('kind = "cylinder"\nradius = 0.5\nheight = 1', 3),
    "trilobe": (LOBES.format(3, 0.69), 3),
    "quadralobe": (LOBES.format(4, 0.74), 3),
    "hollow cylinder": (f'kind = "glued"\nparts = [{sectors()}]', 3),
}


def bessel(n, x):
    """Modified Bessel function I_n(x) exp(-x), by its integral."""
    steps = 4000
    angles = [(k + 0.5) * math.pi / steps for k in range(steps)]
    return sum(math.exp(x * (math.cos(a) - 1)) * math.cos(n * a) for a in angles) / steps


EXACT = {
    "slab": lambda m: math.tanh(m) / m,
    "cylinder": lambda m: bessel(1, 2 * m) / bessel(0, 2 * m) / m,
    "sphere": lambda m: (1 / math.tanh(3 * m) - 1 / (3 * m)) / m,
}


def volume_and_area(shape):
    """Volume and area of the shape; of endless ones per unit of length or section, from their definition."""
    if shape == "slab":
        return 1.0, 2.0
    if shape == "cylinder":
        return math.pi / 4, math.pi
    if shape == "sphere":
        return math.pi / 6, math.pi
    if shape == "short cylinder":
        return math.pi / 4, 1.5 * math.pi
    if shape == "hollow cylinder":
        section = math.pi / 4 * (1 - BORE**2)
        return section, 2 * section + math.pi * (1 + BORE)
    # Lobes of one unit: section and outline of circles of radius r about the corners of a polygon, and of that polygon.
    lobes, fraction = {"trilobe": (3, 0.69), "quadralobe": (4, 0.74)}[shape]
    section = fraction * math.pi / 4
    area = outline(lobes, section)
    return section, area + 2 * section


def outline(lobes, section):
    """Outline of the lobes that fill a section within a circle of radius 0.5."""
    def measure(r):
        c = 0.5 - r
        side = 2 * c * math.sin(math.pi / lobes)
        # Half the angle of each circle that lies in its neighbours or the polygon between.
        hidden = math.acos(min(side / 2 / r, 1.0))
        inner = math.pi * (lobes - 2) / lobes
        free = 2 * math.pi - inner - 2 * hidden
        polygon = lobes / 4 * side**2 / math.tan(math.pi / lobes)
        chords = lobes * 0.5 * r**2 * math.sin(2 * hidden) if side < 2 * r else 0.0
        return lobes * 0.5 * r**2 * free + polygon + chords, lobes * r * free
    low, high = 0.05, 0.49
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if measure(middle)[0] < section else (low, middle)
    return measure(low)[1]


def case(shape, across, folder):
    text = (HERE / "effectiveness.toml").read_text()
    keys, axes = SHAPES[shape]
    text = text.replace('kind = "sphere"\nradius = 0.5', keys)
    half, wide = extent(across)
    # One cell along what is endless; a slab spans the periodic box.
    cells = [wide if axis < max(axes, 2) else 1 for axis in range(3)]
    text = text.replace("SPAN", repr(2 * half * (1 - 1e-6)))
    text = text.replace("0.005, 0.002]", f"{0 if axes < 2 else 0.005}, {0 if axes < 3 else 0.002}]")
    text = text.replace("[-0.65, -0.65, -0.65]", str([-half] * 3)).replace("[0.65, 0.65, 0.65]", str([half] * 3))
    text = text.replace("[false, false, false]", str([False, axes < 2, axes < 3]).lower()).replace("[21, 21, 21]", str(cells))
    text = text.replace("max_dt = 4e-3", f"max_dt = {2 / across**2}")
    volume, area = volume_and_area(shape)
    start, end = text.index("[[fluid.scalar]]"), text.index("[output]")
    scalar = text[start:end]
    scalars = [
        scalar.replace('"rate"', f'"m{k}"').replace("rate = 9", f"rate = {(m * area / volume) ** 2!r}") for k, m in enumerate(MODULI)
    ]
    text = text[:start] + "".join(scalars) + text[end:]
    return text.replace('"results/effectiveness/sphere"', f'"{folder / "run"}"')


def extent(across):
    """Half of the edge of the box, and the cells along it."""
    wide = round(1.3 * across)
    return wide / across / 2, wide


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shapes", nargs="+", default=list(SHAPES), choices=list(SHAPES))
    parser.add_argument("--across", nargs="+", type=int, default=[32])
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--picture", action="store_true")
    options = parser.parse_args()
    folder = lambda s, a: sweep.RESULTS / "effectiveness" / f"{s.replace(' ', '-')}-{a}"
    points = [(s, a) for a in options.across for s in options.shapes]
    sweep.run_all([(case(*p, folder(*p)), folder(*p)) for p in points], options.jobs)
    print(f"{'shape':<15} {'cells':>5} " + " ".join(f"{m:>16g}" for m in MODULI))
    curves = {}
    for shape, across in points:
        where = folder(shape, across)
        if not (where / "done").exists():
            continue
        last = sweep.table(where / "run/series.csv")[-1]
        volume, area = volume_and_area(shape)
        # The part of what is endless that lies in the box.
        edge = 2 * extent(across)[0]
        depth = {1: edge**2, 2: edge, 3: 1.0}[SHAPES[shape][1]]
        rates = [(m * area / volume) ** 2 * volume * depth for m in MODULI]
        found = [float(last[f"m{k}_reaction"]) / rate for k, rate in enumerate(rates)]
        curves[shape] = found
        exact = EXACT.get(shape)
        told = [f"{x:.4f} {100 * (x / exact(m) - 1):+6.2f} %" if exact else f"{x:.4f}" for x, m in zip(found, MODULI)]
        print(f"{shape:<15} {across:>5} " + " ".join(f"{t:>16}" for t in told))
    if options.picture:
        picture(curves)


def picture(curves):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axis = plt.subplots(figsize=(6, 4.2))
    moduli = [0.1 * 200 ** (k / 100) for k in range(101)]
    for shape, exact in EXACT.items():
        axis.loglog(moduli, [exact(m) for m in moduli], lw=1, label=f"{shape}, closed form")
    for marker, (shape, found) in zip("os^vDx", curves.items()):
        axis.loglog(MODULI, found, marker, ms=5, fillstyle="none", label=shape)
    axis.set(xlabel="Thiele modulus (V/A) √(k/D)", ylabel="effectiveness")
    axis.legend(fontsize=7)
    figure.tight_layout()
    figure.savefig(HERE / "effectiveness.png", dpi=90)


if __name__ == "__main__":
    main()
