"""Porosity of packings of equal volumes in a box periodic in x and y (thesis table 3.3), and bed heights in a
cylinder of 50 mm (thesis fig. 3.14): `python3 cases/packing/packing.py [--seeds N] [SHAPE ...]`."""
import argparse
import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import sweep

CASE = (Path(__file__).parent / "spheres.toml").read_text()
DIAMETER = 3e-3
VOLUME = math.pi / 6 * DIAMETER**3
SPHERE = '''kind = "sphere"
radius = 1.5e-3'''


def shapes():
    """Bodies of the volume of a sphere of 3 mm, as keys of a [[shape]]."""
    cylinder = (4 * VOLUME / math.pi) ** (1 / 3)
    cube = VOLUME ** (1 / 3)
    tetrahedron = (VOLUME * 27 / (8 * math.sqrt(3))) ** (1 / 3)
    return {
        "spheres": SPHERE,
        "cylinders": f'kind = "cylinder"\nradius = {cylinder / 2!r}\nheight = {cylinder!r}',
        "cubes": f'kind = "box"\nedges = [{cube!r}, {cube!r}, {cube!r}]',
        "tetrahedra": f'kind = "regular"\nsolid = "tetrahedron"\ncircumradius = {tetrahedron!r}',
        "crosses-2d": cross(2, 5),
        "crosses-3d": cross(3, 5),
    }


def cross(dimensions, ratio):
    """Cross of 2 or 3 square beams, `ratio` times as long as wide: V = w^3 (2 q - 1) or w^3 (3 q - 2)."""
    width = (VOLUME / (2 * ratio - 1 if dimensions == 2 else 3 * ratio - 2)) ** (1 / 3)
    return f'kind = "cross"\nbeams = {dimensions}\nbeam_width = {width!r}\nbeam_length = {ratio * width!r}'


# Table 3.3.
SOURCE = {
    "spheres": 0.3818, "cylinders": 0.3858, "cubes": 0.3959, "tetrahedra": 0.4746, "crosses-2d": 0.6946,
    "crosses-3d": 0.7963,
}


def case(name, keys, seed, folder):
    """The case of one bed."""
    text = CASE.replace(SPHERE, keys).replace("seed = 1\n", f"seed = {seed}\n")
    text = text.replace('name = "packing of spheres"', f'name = "packing of {name}, seed {seed}"')
    if name != "spheres":
        # Corners meet for shorter than spheres do; still for ten steps.
        text = text.replace("dt = 3e-6", "dt = 3e-6\naccept_coarse_dt = true")
    if name.startswith("crosses"):
        text = text.replace("0.14]", "0.34]").replace("0.135]", "0.33]").replace("0.138]", "0.333]")
    return text.replace('directory = "results/packing"', f'directory = "{folder / "run"}"')


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("shape", nargs="*", choices=[*SOURCE, []], help="shapes to pack, all by default")
    parser.add_argument("--seeds", type=int, default=3)
    arguments = parser.parse_args()
    names = arguments.shape or list(SOURCE)
    folder = lambda name, seed: sweep.RESULTS / "packing" / f"{name}-{seed}"
    seeds = range(1, arguments.seeds + 1)
    runs = [(case(n, shapes()[n], s, folder(n, s)), folder(n, s)) for s in seeds for n in names]
    sweep.run_all(runs)
    print(f"{'shape':<12} {'thesis':>7} {'here':>7} {'spread':>7}   each seed")
    for name in names:
        found = []
        for seed in seeds:
            if (folder(name, seed) / "done").exists():
                rows = sweep.analyse("void-fraction", folder(name, seed))
                found.append(float(rows[0]["void_fraction"]))
        mean = sum(found) / len(found) if found else math.nan
        spread = math.sqrt(sum((x - mean) ** 2 for x in found) / (len(found) - 1)) if len(found) > 1 else math.nan
        each = " ".join(f"{x:.4f}" for x in found)
        print(f"{name:<12} {SOURCE[name]:>7.4f} {mean:>7.4f} {spread:>7.4f}   {each}")


if __name__ == "__main__":
    main()
