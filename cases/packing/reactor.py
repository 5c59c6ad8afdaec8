"""Bed heights of 250 bodies of equal volume and six shapes in a cylinder of 50 mm (thesis fig. 3.14):
`python3 cases/packing/reactor.py [--ratio Q] [--jobs J] [SHAPE ...]`."""
import argparse
from pathlib import Path

import packing
import sweep

CASE = (Path(__file__).parent / "reactor.toml").read_text()
SPHERE = 'kind = "sphere"\nradius = 0.004'


def case(name, keys, folder):
    """The case of one bed."""
    assert SPHERE in CASE
    text = CASE.replace(SPHERE, keys).replace("reactor of spheres", f"reactor of {name}")
    # Corners meet for shorter than spheres do, still for ten steps; thin and sharp ones must not sink in by a fifth.
    if name.startswith("cross") or name == "tetrahedra":
        text = text.replace("dt = 1.4e-5", "dt = 5e-6\naccept_coarse_dt = true").replace("4e4", "1.6e5")
    elif name != "spheres":
        text = text.replace("dt = 1.4e-5", "dt = 1e-5\naccept_coarse_dt = true")
    return text.replace('"results/packing/reactor"', f'"{folder / "run"}"')


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("shape", nargs="*", choices=[*packing.SOURCE, []], help="shapes to pack, all by default")
    parser.add_argument("--ratio", type=float, default=5, help="length over width of the beams of crosses")
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    names = arguments.shape or list(packing.SOURCE)
    shapes = packing.shapes(8e-3, arguments.ratio)
    suffix = lambda name: f"-q{arguments.ratio:g}" if name.startswith("crosses") and arguments.ratio != 5 else ""
    folder = lambda name: sweep.RESULTS / "packing" / f"reactor-{name}{suffix(name)}"
    sweep.run_all([(case(n, shapes[n], folder(n)), folder(n)) for n in names], arguments.jobs)
    print(f"{'shape':<12} {'height (mm)':>11} {'porosity':>9}")
    for name in names:
        if (folder(name) / "done").exists():
            row = sweep.analyse("void-fraction", folder(name), "--crop", 0)[0]
            print(f"{name:<12} {1e3 * float(row['to']):>11.1f} {float(row['void_fraction']):>9.3f}")


if __name__ == "__main__":
    main()
