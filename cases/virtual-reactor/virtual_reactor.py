"""A virtual reactor: catalysts are loaded into a tube, gas flows through them and reacts inside. `python3
cases/virtual-reactor/virtual_reactor.py [--shapes CYL TL QL] [--across 10] [--reynolds 5]` runs what is missing and prints void
fraction, pressure drop, Sherwood number, effectiveness and conversion per shape; `--picture` draws them."""
import argparse
import math
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent), str(HERE.parent / "fixed-bed")]
import fixed_bed
import sweep

TUBE, RATIO, WINDOW, COUNT = 12.0, 2.0, 4.0, 240  # mm, length over diameter, mm, particles
RADIUS, CLEARANCE = TUBE / 2e3, 0.3e-3
VISCOSITY, DENSITY, DIFFUSIVITY, INSIDE, RATE = 3e-5, 1.0, 4e-5, 4e-6, 50.0
NAMES = {"CYL": "cylinders", "TL": "trilobes", "QL": "quadralobes"}


def loading(shape, seed, folder):
    """The case that loads the tube."""
    text = fixed_bed.case(shape, RATIO, TUBE, WINDOW, seed, folder).replace("count = 1000", f"count = {COUNT}")
    return text.replace("end = 0.6\n", "end = 0.4\n")


def flow(shape, across, reynolds, loaded, folder):
    """The case of the flow through a loaded tube, on cells of which as many go across a particle."""
    text = (HERE / "reactor.toml").read_text()
    diameter = fixed_bed.LENGTH / RATIO
    text = text.replace('kind = "cylinder"\nradius = 0.75e-3\nheight = 3e-3', fixed_bed.keys(shape, diameter), 1)
    start, end = text.index("count = 18\n"), text.index("\n[[wall]]")
    text = text[:start] + f'place = {{ kind = "file", path = "{loaded}" }}\n' + text[end:]
    cell = diameter / 1e3 / across
    wide = 2 * math.ceil((RADIUS + CLEARANCE) / cell)
    volume = COUNT * math.pi / 4 * diameter**2 * fixed_bed.LENGTH * fixed_bed.FRACTION[shape]
    height = volume / 0.5 / (math.pi / 4 * TUBE**2) / 1e3
    below, above = math.ceil(3e-3 / cell), math.ceil((height + 3e-3) / cell)
    half = wide * cell / 2
    text = text.replace("lower = [-0.0063, -0.0063, -0.004]", f"lower = [{-half!r}, {-half!r}, {-below * cell!r}]")
    text = text.replace("upper = [0.0063, 0.0063, 0.016]", f"upper = [{half!r}, {half!r}, {above * cell!r}]")
    text = text.replace("[84, 84, 134]", f"[{wide}, {wide}, {below + above}]")
    velocity = reynolds * VISCOSITY / DENSITY / (diameter / 1e3)
    text = text.replace("1.885e-5", repr(velocity * math.pi * RADIUS**2))
    return text.replace('"results/virtual-reactor/lattice"', f'"{folder / "run"}"')


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shapes", nargs="+", default=list(NAMES), choices=list(NAMES))
    parser.add_argument("--across", type=int, default=10, help="cells across a particle")
    parser.add_argument("--reynolds", type=float, default=5.0, help="Reynolds number of the superficial velocity and the diameter")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--only-load", action="store_true")
    options = parser.parse_args()
    folder = lambda shape, what: sweep.RESULTS / "virtual-reactor" / f"{shape}-{what}"
    loads = [(s, folder(s, "loaded")) for s in options.shapes]
    sweep.run_all([(loading(s, 1, f), f) for s, f in loads], options.jobs)
    if options.only_load:
        return
    cases = []
    for shape, where in loads:
        to = folder(shape, f"{options.across}-{options.reynolds:g}")
        cases.append((flow(shape, options.across, options.reynolds, where / "run/particles.vtkhdf", to), to))
    sweep.run_all(cases, options.jobs)


if __name__ == "__main__":
    main()
