"""Friction coefficients of periodic arrays of trilobes, quadralobes and cylinders of one volume and length (Rakotonirina 2016,
table 7.1): `python3 cases/array-lobes/array_lobes.py [--across 32]` runs what is missing and prints K over the solid fraction,
along and across; `--convergence` K of lobes as long as wide and five times as long, on three grids, with Richardson's limits.
Draws into friction.png and convergence.png."""
import argparse
import math
import os
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
import sweep

# Diameters over the length of particles of one volume, table 7.1; a trilobe's box holds them all.
DIAMETERS = {"trilobe": 0.414, "quadralobe": 0.405, "cylinder": 0.349}
LOBES = {"trilobe": 3, "quadralobe": 4}
FRACTIONS = [0.2, 0.34, 0.45, 0.545]
GRIDS = [16, 24, 36]


def section(shape):
    """Section over that of the circumscribed cylinder."""
    return (DIAMETERS["cylinder"] / DIAMETERS[shape]) ** 2


def case(shape, ratio, fraction, along, across, folder):
    """One particle of length 1 (ratio 0: of table 7.1, else as many times as long as wide) in a box like the one about it."""
    diameter = 1 / ratio if ratio else DIAMETERS[shape]
    widest = diameter if ratio else DIAMETERS["trilobe"]
    volume = math.pi / 4 * diameter**2 * section(shape)
    stretch = (volume / (fraction * widest**2)) ** (1 / 3)
    sides = [stretch * widest, stretch * widest, stretch]
    cells = [round(across * side / widest) for side in sides]
    end = 0.35 * sides[0] ** 2
    text = (HERE / "lobes.toml").read_text()
    keys = f'kind = "lobes"\nlobes = {LOBES.get(shape)}\ndiameter = {diameter!r}\nlength = 1\narea_fraction = {section(shape)!r}'
    if shape == "quadralobe":
        # Its lobes lie on the diagonals of the box, as the areas that the thesis states.
        text = text.replace('orientation = "aligned"', "orientation = [0.92388, 0, 0, 0.38268]")
    if shape == "cylinder":
        keys = f'kind = "cylinder"\nradius = {diameter / 2!r}\nheight = 1'
    for old, new in (
        ("[0.4874, 0.4874, 1.1774]", repr(sides)),
        ('kind = "lobes"\nlobes = 3\ndiameter = 0.414\nlength = 1\narea_fraction = 0.7106', keys),
        ("[0.2437, 0.2437, 0.5887]", repr([side / 2 for side in sides])),
        ("[38, 38, 91]", repr(cells)),
        ("0.08", repr(end)),
        ("0.004", repr(end / 20)),
        ("[1e-3, 0, 0], axes = [true, false, false]", "[0, 0, 1e-3], axes = [false, false, true]" if along else None),
    ):
        assert text.count(old), old
        text = text.replace(old, new) if new else text
    return text.replace('"results/array-lobes/array"', f'"{folder / "run"}"')


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--across", type=int, default=32, help="cells across a trilobe")
    parser.add_argument("--convergence", action="store_true")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args()
    if options.convergence:
        points = [
            (shape, ratio, fraction, along, across)
            for shape in LOBES
            for ratio in (1, 5)
            for fraction in (0.45,)
            for along in (False, True)
            for across in GRIDS
        ]
    else:
        points = [(s, 0, f, along, options.across) for along in (False, True) for f in FRACTIONS for s in DIAMETERS]
    folder = lambda s, r, f, along, n: sweep.RESULTS / "array-lobes" / f"{s}-{r}-{f}-{'along' if along else 'across'}-{n}"
    sweep.run_all([(case(*p, folder(*p)), folder(*p)) for p in points], options.jobs)
    known = {}
    for point in points:
        if (folder(*point) / "done").exists():
            rows = sweep.analyse("friction", folder(*point))
            known[point] = float(rows[-1]["friction"])
            change = known[point] / float(rows[-2]["friction"]) - 1
            if abs(change) > 1e-4:
                print(f"{point}: not steady, {change:.0e}")
    figure, axes = plt.subplots(1, 2, figsize=(9, 4), layout="constrained")
    for axis, along in zip(axes, (False, True)):
        axis.set(title="along the axis" if along else "across the axis")
        if options.convergence:
            for shape, ratio, fraction, _, _ in dict.fromkeys(p[:3] + (0, 0) for p in points):
                found = [known[shape, ratio, fraction, along, n] for n in GRIDS]
                order = math.log(abs((found[1] - found[0]) / (found[2] - found[1]))) / math.log(1.5)
                limit = found[2] + (found[2] - found[1]) / (1.5**order - 1) if order > 0 else math.nan
                errors = [100 * (k / limit - 1) for k in found]
                print(
                    f"{shape}, {ratio} times as long as wide, {'along' if along else 'across'}, solid fraction {fraction}: K"
                    f" {', '.join(f'{k:.3f} ({e:+.1f} %)' for k, e in zip(found, errors))}; limit {limit:.3f}, order {order:.2f}"
                )
                axis.loglog(GRIDS, [abs(e) for e in errors], "o-", label=f"{shape} {ratio}, {fraction}")
            axis.loglog([16, 36], [20, 20 * (16 / 36) ** 1.3], "k:", label="order 1.3")
            axis.set(xlabel="cells across", ylabel="error of K (%)")
        else:
            for shape in DIAMETERS:
                found = [known[shape, 0, f, along, options.across] for f in FRACTIONS]
                print(f"{shape}, {'along' if along else 'across'}: " + ", ".join(f"{k:.2f}" for k in found))
                axis.semilogy(FRACTIONS, found, "o-", label=shape)
            axis.set(xlabel="solid fraction", ylabel="K")
    axes[1].legend(fontsize="x-small")
    figure.savefig(HERE / ("convergence.png" if options.convergence else "friction.png"), dpi=110)


if __name__ == "__main__":
    main()
