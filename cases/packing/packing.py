"""Porosity of packings of equal volumes in a box periodic in x and y (thesis table 3.3):
`python3 cases/packing/packing.py [--seeds N] [--ratio Q] [--width MM] [--friction MU] [--jobs J] [SHAPE ...]`."""
import argparse
import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import sweep

CASE = (Path(__file__).parent / "spheres.toml").read_text()
SPHERE = '''kind = "sphere"
radius = 1.5e-3'''


def shapes(diameter=3e-3, ratio=5):
    """Bodies of the volume of a sphere of a diameter (m), as keys of a [[shape]]; crosses of beams `ratio` times as long as
    wide."""
    volume = math.pi / 6 * diameter**3
    cylinder = (4 * volume / math.pi) ** (1 / 3)
    cube = volume ** (1 / 3)
    tetrahedron = (volume * 27 / (8 * math.sqrt(3))) ** (1 / 3)
    return {
        "spheres": f'kind = "sphere"\nradius = {diameter / 2}',
        "cylinders": f'kind = "cylinder"\nradius = {cylinder / 2!r}\nheight = {cylinder!r}',
        "cubes": f'kind = "box"\nedges = [{cube!r}, {cube!r}, {cube!r}]',
        "tetrahedra": f'kind = "regular"\nsolid = "tetrahedron"\ncircumradius = {tetrahedron!r}',
        "crosses-2d": cross(2, ratio, volume),
        "crosses-3d": cross(3, ratio, volume),
    }


def cross(dimensions, ratio, volume):
    """Cross of 2 or 3 square beams, q = `ratio` times as long as wide: V = w^3 (2 q - 1) or w^3 (3 q - 2)."""
    width = (volume / (2 * ratio - 1 if dimensions == 2 else 3 * ratio - 2)) ** (1 / 3)
    return f'kind = "cross"\nbeams = {dimensions}\nbeam_width = {width!r}\nbeam_length = {ratio * width!r}'


# Table 3.3.
SOURCE = {
    "spheres": 0.3818, "cylinders": 0.3858, "cubes": 0.3959, "tetrahedra": 0.4746, "crosses-2d": 0.6946,
    "crosses-3d": 0.7963,
}


def case(name, keys, seed, width, friction, folder):
    """The case of one bed in a box of a width (mm)."""
    text = CASE.replace(SPHERE, keys).replace("seed = 1\n", f"seed = {seed}\n")
    text = text.replace("0.018, 0.018", f"{width / 1e3:g}, {width / 1e3:g}").replace("friction = 0.55", f"friction = {friction:g}")
    if width < 18:
        # Beds in narrower boxes are higher.
        for height in (0.14, 0.135, 0.138):
            text = text.replace(f"{height:g}]", f"{height * (18 / width) ** 2:.4f}]")
    text = text.replace('name = "packing of spheres"', f'name = "packing of {name}, seed {seed}"')
    if name != "spheres":
        # Corners meet for shorter than spheres do; still for ten steps.
        text = text.replace("dt = 3e-6", "dt = 3e-6\naccept_coarse_dt = true")
    if name.startswith("crosses"):
        text = text.replace("0.14]", "0.34]").replace("0.135]", "0.33]").replace("0.138]", "0.333]")
        # The first tips hit the floor from 0.33 m.
        text = text.replace("[output]", "[limits]\noverlap = 0.3\n\n[output]")
    return text.replace('directory = "results/packing"', f'directory = "{folder / "run"}"')


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("shape", nargs="*", choices=[*SOURCE, []], help="shapes to pack, all by default")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--ratio", type=float, default=5, help="length over width of the beams of crosses")
    parser.add_argument("--width", type=float, default=18, help="of the box (mm), at least twice the longest body")
    parser.add_argument("--friction", type=float, default=0.55, help="coefficient of friction")
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    names = arguments.shape or list(SOURCE)
    wide = f"-{arguments.width:g}-mm" if arguments.width != 18 else ""
    rough = f"-mu{arguments.friction:g}" if arguments.friction != 0.55 else ""
    suffix = lambda name: (f"-q{arguments.ratio:g}" if name.startswith("crosses") else "") + wide + rough
    folder = lambda name, seed: sweep.RESULTS / "packing" / f"{name}{suffix(name)}-{seed}"
    seeds = range(1, arguments.seeds + 1)
    runs = []
    for seed in seeds:
        for name in names:
            keys = shapes(ratio=arguments.ratio)[name]
            runs.append((case(name, keys, seed, arguments.width, arguments.friction, folder(name, seed)), folder(name, seed)))
    sweep.run_all(runs, arguments.jobs)
    print(f"{'shape':<12} {'thesis':>7} {'here':>7} {'spread':>7} {'inside':>7} {'spread':>7}   each seed")
    for name in names:
        done = [folder(name, seed) for seed in seeds if (folder(name, seed) / "done").exists()]
        # The thesis's box, from the floor to the highest body; then without a tenth of the bed at either end.
        whole, inside = ([void_fraction(f, *crop) for f in done] for crop in (["--crop", 0], []))
        (mean, spread), (mean_in, spread_in) = statistics(whole), statistics(inside)
        each = " ".join(f"{x:.4f}" for x in whole)
        print(f"{name:<12} {SOURCE[name]:>7.4f} {mean:>7.4f} {spread:>7.4f} {mean_in:>7.4f} {spread_in:>7.4f}   {each}")


def void_fraction(folder, *options):
    """Void fraction of a bed at its last time."""
    return float(sweep.analyse("void-fraction", folder, *options)[0]["void_fraction"])


def statistics(values):
    """Mean and standard deviation, NaN where there are too few values."""
    mean = sum(values) / len(values) if values else math.nan
    spread = math.sqrt(sum((x - mean) ** 2 for x in values) / (len(values) - 1)) if len(values) > 1 else math.nan
    return mean, spread


if __name__ == "__main__":
    main()
