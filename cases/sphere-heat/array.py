"""Nusselt numbers of spheres at random beside Sun's and Deen's correlations: `python3 cases/sphere-heat/array.py [--across 12]
[--void 0.7 0.6] [--reynolds 10 50] [--seeds 2]` runs what is missing. Spheres in the middle of the array count, with the void fraction there."""
import argparse
import math
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
import sweep


def case(across, void, reynolds, seed, folder):
    text = (HERE / "array.toml").read_text()
    # Centres fill a length of 9: their number density tells the void fraction between.
    count = round((1 - void) * 9 * 16 / (math.pi / 6))
    text = text.replace("count = 83", f"count = {count}").replace("seed = 1\n", f"seed = {seed}\n")
    text = text.replace("[162, 48, 48]", str([27 * across // 2, 4 * across, 4 * across]))
    text = text.replace("viscosity = 0.02", f"viscosity = {1 / reynolds!r}").replace("conductivity = 20", f"conductivity = {1000 / reynolds!r}")
    return text.replace('"results/sphere-heat/array"', f'"{folder / "run"}"')


def sun(e, re):
    return (-0.46 + 1.77 * e + 0.69 * e**2) / e**3 + (1.37 - 2.4 * e + 1.2 * e**2) * re**0.7


def deen(e, re):
    return (7 - 10 * e + 5 * e**2) * (1 + 0.17 * re**0.2) + (1.33 - 2.31 * e + 1.16 * e**2) * re**0.7


def within(place):
    """Volume of a sphere at a coordinate that lies between the ends of what counts."""
    cap = lambda h: math.pi * h**2 * (1.5 - h) / 3
    low, high = (min(max(end - place + 0.5, 0.0), 1.0) for end in ENDS)
    return cap(high) - cap(low)


ENDS = 2.0, 8.0


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--across", nargs="+", type=int, default=[12])
    parser.add_argument("--void", nargs="+", type=float, default=[0.7])
    parser.add_argument("--reynolds", nargs="+", type=int, default=[10, 50])
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    points = [(a, v, r) for a in options.across for v in options.void for r in options.reynolds]
    folder = lambda a, v, r, s: sweep.RESULTS / "sphere-heat" / f"array-{a}-{v:g}-{r}-{s}"
    seeds = range(1, options.seeds + 1)
    sweep.run_all([(case(*p, s, folder(*p, s)), folder(*p, s)) for p in points for s in seeds], options.jobs)
    print(f"{'cells':>5} {'void':>5} {'Re':>4} {'Nu':>14}   {'Sun':>6} {'Deen':>6}")
    for point in points:
        # Of each array: heat of the spheres over the sum of their differences of temperature; d = 1.
        found, solid = [], []
        for seed in seeds:
            where = folder(*point, seed)
            if (where / "done").exists():
                sweep.analyse("nusselt", where, "--axis", "x")
                rows = sweep.table(where / "analysis/nusselt-particles.csv")
                counted = [row for row in rows if ENDS[0] <= float(row["position"]) <= ENDS[1]]
                heat = -sum(float(row["rate"]) for row in counted)
                found.append(heat * point[2] / 1000 / math.pi / sum(301 - float(row["mixed"]) for row in counted))
                solid.append(sum(within(float(row["position"])) for row in rows) / (16 * (ENDS[1] - ENDS[0])))
        if found:
            mean = sum(found) / len(found)
            error = math.sqrt(sum((x - mean) ** 2 for x in found) / max(len(found) - 1, 1) / len(found))
            across, _, reynolds = point
            void = 1 - sum(solid) / len(solid)
            print(f"{across:>5} {void:>5.3f} {reynolds:>4} {mean:>6.2f} +- {error:<4.2f}   {sun(void, reynolds):>6.2f} {deen(void, reynolds):>6.2f}")


if __name__ == "__main__":
    main()
