"""K of simple cubic arrays of spheres at many solid fractions and resolutions: `python3 cases/array-sphere/convergence.py
[--across 8 16 32] [--resolved KEYS] [--jobs N]` runs what is missing, prints the table, and draws errors over resolution
into errors.png."""
import argparse
import math
import os
import re
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
import sweep

# Solid fraction and K of Zick and Homsy (1982), table 2; the last is the array whose spheres touch.
FOUND = {0.027: 2.008, 0.064: 2.810, 0.125: 4.292, 0.216: 7.442, 0.343: 15.40, 0.45: 28.1, math.pi / 6: 42.1}
SPEED = 1e-3


def radius(fraction):
    """Radius of the sphere in a unit cube."""
    return (3 * fraction / (4 * math.pi)) ** (1 / 3)


def case(fraction, cells, resolved, folder):
    """The array at another solid fraction, on other cells, with further keys of fluid.resolved."""
    text = (HERE / "array.toml").read_text()
    text = text.replace("radius = 0.37221", f"radius = {radius(fraction)!r}")
    text = text.replace("[21, 21, 21]", f"[{cells}, {cells}, {cells}]")
    if resolved:
        text = text.replace('{ motion = "fixed" }', f'{{ motion = "fixed", {resolved} }}')
    return text.replace('"results/array-sphere/array"', f'"{folder / "run"}"')


def friction(fraction, run):
    """K = F/(6 pi mu a U) from the pressure gradient that the flow takes, eq. 7.16 of the thesis; and its last change."""
    gradients = [float(row["drive_x"]) for row in sweep.table(run / "series.csv")]
    scale = radius(fraction) ** 2 / (4.5 * fraction * SPEED)
    return gradients[-1] * scale, abs(gradients[-1] / gradients[-2] - 1)


def order(coarse, fine, limit, ratio):
    """Order of convergence towards a known limit."""
    return math.log(abs(coarse - limit) / abs(fine - limit)) / math.log(ratio)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--across", nargs="+", type=int, default=[8, 16, 32], help="cells across the diameter, about")
    nearest = lambda text: min(FOUND, key=lambda fraction: abs(fraction - float(text)))
    parser.add_argument("--fractions", nargs="+", type=nearest, default=list(FOUND), help="solid fractions of the table")
    parser.add_argument("--resolved", default="", help="keys of fluid.resolved, such as 'method = \"multiplier\"'")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args()
    points = {}
    for fraction in options.fractions:
        for across in options.across:
            cells = round(across / (2 * radius(fraction)))
            words = re.findall(r"[\w.]+", options.resolved)
            folder = sweep.RESULTS / "array-sphere" / ("-".join(words) or "default") / f"{fraction:.4f}-{cells}"
            points[fraction, across] = (cells, folder)
    runs = [(case(f, cells, options.resolved, folder), folder) for (f, _), (cells, folder) in points.items()]
    sweep.run_all(runs, options.jobs)
    figure, axis = plt.subplots(figsize=(6, 4), layout="constrained")
    print(f"{'phi':>6} {'K':>7}  cells across: K (error) ... order")
    for fraction in options.fractions:
        known = FOUND[fraction]
        line, across, errors, values = f"{fraction:6.3f} {known:7.3f} ", [], [], []
        for wanted in options.across:
            cells, folder = points[fraction, wanted]
            if not (folder / "done").exists():
                continue
            value, change = friction(fraction, folder / "run")
            across.append(2 * radius(fraction) * cells)
            values.append(value)
            errors.append(abs(value / known - 1))
            line += f" {across[-1]:5.2f}: {value:.4f} ({100 * (value / known - 1):+.2f} %)"
            line += "" if change < 1e-4 else f" not steady, {change:.0e}"
        if len(values) > 1:
            line += f"  order {order(values[-2], values[-1], known, across[-1] / across[-2]):.2f}"
        print(line)
        axis.loglog(across, errors, "o-", label=f"{fraction:.3f}")
    axis.loglog([8, 32], [0.2, 0.2 / 4**1.3], "k:", label="order 1.3")
    axis.loglog([8, 32], [0.2, 0.2 / 4**2], "k--", label="order 2")
    axis.set(xlabel="cells across the diameter", ylabel="error of K")
    axis.legend(fontsize="small")
    if not options.resolved:
        figure.savefig(HERE / "errors.png", dpi=110)


if __name__ == "__main__":
    main()
