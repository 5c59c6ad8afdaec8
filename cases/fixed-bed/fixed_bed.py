"""Void fraction of fixed beds of cylinders, trilobes and quadralobes (thesis chapter 4) against its correlations:
`python3 cases/fixed-bed/fixed_bed.py [--ratios 2] [--seeds 3] [--tube-seeds 5] [--windows 6] [--tubes 0 19] [--shapes CYL TL QL]`.
Runs what is missing, two at a time, and goes on where it was stopped; prints the table of what there is."""
import argparse
import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import sweep

CASE = (Path(__file__).parent / "bed.toml").read_text()
LENGTH = 3.0  # mm
FRACTION = {"CYL": 1.0, "TL": 0.69, "QL": 0.74}


def keys(shape, diameter):
    """Keys of a [[shape]] of a diameter (mm)."""
    if shape == "CYL":
        return f'kind = "cylinder"\nradius = {diameter / 2e3!r}\nheight = {LENGTH / 1e3!r}'
    lobes = {"TL": 3, "QL": 4}[shape]
    return (f'kind = "lobes"\nlobes = {lobes}\ndiameter = {diameter / 1e3!r}\nlength = {LENGTH / 1e3!r}\n'
            f'area_fraction = {FRACTION[shape]}')


def correlation(shape, ratio, tube):
    """The thesis's void fraction at a length over diameter, in a periodic box (tube 0) or a tube (mm)."""
    if tube == 0:
        return 0.289 + 0.033 * ratio if shape == "CYL" else 0.314 + 0.049 * ratio  # 4.9, 4.10
    a, b, c = {"CYL": (0.315, 0.0244, 0.141), "QL": (0.33, 0.0328, 0.212), "TL": (0.345, 0.0289, 0.15)}[shape]
    return a + b * ratio + c * LENGTH / tube  # 4.11, 4.13, 4.14


def case(shape, ratio, tube, window, seed, folder):
    """The case of one bed."""
    diameter = LENGTH / ratio
    text = CASE.replace('kind = "cylinder"\nradius = 0.75e-3\nheight = 3e-3', keys(shape, diameter))
    half = window / 2e3
    text = text.replace("[-0.003, -0.003, 0.085]", f"[{-half}, {-half}, 0.085]")
    text = text.replace("[0.003, 0.003, 0.085]", f"[{half}, {half}, 0.085]")
    text = text.replace("seed = 1\n", f"seed = {seed}\n").replace('"results/fixed-bed"', f'"{folder / "run"}"')
    # Four times the volume at rest, and the way down; above the window room for those that meet in falling and are thrown up.
    volume = 1000 * math.pi / 4 * diameter**2 * LENGTH * FRACTION[shape]
    section = 18.0**2 if tube == 0 else math.pi / 4 * tube**2
    top = (0.03 + volume / 0.5 / section / 1e3)
    text = text.replace("0.085", f"{top:.4f}").replace("0.09]", f"{top + 0.02:.4f}]")
    if tube:
        radius = tube / 2e3
        text = text.replace("-0.009, -0.009, 0]", f"{-radius - 5e-4}, {-radius - 5e-4}, 0]")
        text = text.replace("0.009, 0.009,", f"{radius + 5e-4}, {radius + 5e-4},")
        text = text.replace("periodic = [true, true, false]", "periodic = [false, false, false]")
        text = text.replace("[output]", f'''[[wall]]
name = "tube"
material = "catalyst"
kind = "cylinder"
center = [0, 0, 0]
axis = [0, 0, 1]
radius = {radius}

[output]''')
    return text


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shapes", nargs="+", default=["CYL", "TL", "QL"], choices=list(FRACTION))
    parser.add_argument("--ratios", nargs="+", type=float, default=[2.0], help="lengths over diameter")
    parser.add_argument("--seeds", type=int, default=3, help="seeds in the periodic box")
    parser.add_argument("--tube-seeds", type=int, default=5, help="seeds in tubes")
    parser.add_argument("--windows", nargs="+", type=float, default=[6.0], help="edges of the window (mm)")
    parser.add_argument("--tubes", nargs="+", type=float, default=[0, 19], help="diameters (mm), 0 for the periodic box")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    points = [(s, r, t, w) for t in options.tubes for r in options.ratios for w in options.windows for s in options.shapes]
    folder = lambda s, r, t, w, k: sweep.RESULTS / "fixed-bed" / f"{s}-{r:g}-{'box' if t == 0 else f'D{t:g}'}-w{w:g}-{k}"
    seeds = lambda t: range(1, 1 + (options.seeds if t == 0 else options.tube_seeds))
    # The first seed of every point, then the second ...
    runs = [(*p, k) for k in range(1, 1 + max(options.seeds, options.tube_seeds)) for p in points if k in seeds(p[2])]
    sweep.run_all([(case(*r, folder(*r)), folder(*r)) for r in runs], options.jobs)
    print(f"{'shape':<6} {'L/d':>5} {'vessel':>8} {'window':>7} {'thesis':>7} {'here':>7} {'spread':>7}   each seed")
    for p in points:
        found = []
        for k in seeds(p[2]):
            if (folder(*p, k) / "done").exists():
                extra = ["--cylinder", f"0,0,{p[2] / 2e3}"] if p[2] else []
                found.append(float(sweep.analyse("void-fraction", folder(*p, k), *extra)[0]["void_fraction"]))
        mean = sum(found) / len(found) if found else math.nan
        spread = math.sqrt(sum((x - mean) ** 2 for x in found) / (len(found) - 1)) if len(found) > 1 else math.nan
        vessel = "periodic" if p[2] == 0 else f"D {p[2]:g}"
        print(f"{p[0]:<6} {p[1]:>5g} {vessel:>8} {p[3]:>7g} {correlation(*p[:3]):>7.4f} {mean:>7.4f} {spread:>7.4f}   "
              + " ".join(f"{x:.4f}" for x in found))


if __name__ == "__main__":
    main()
