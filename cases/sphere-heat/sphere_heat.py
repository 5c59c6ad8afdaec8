"""Nusselt numbers of a sphere at Prandtl number 0.71: `python3 cases/sphere-heat/sphere_heat.py [--across 10 16] [--reynolds 50 100]`
runs what is missing and prints them beside four sources."""
import argparse
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
import sweep

# Yuge, Whitaker, Feng, CBS (as collected by Lewis and Nithiarasu).
SOURCES = {50: (5.486, 5.176, 5.419, 5.218), 100: (6.930, 6.615, 6.985, 6.659), 200: (8.972, 8.722, 9.190, 8.760)}


def case(across, reynolds, folder):
    text = (HERE / "sphere.toml").read_text()
    text = text.replace("[100, 80, 80]", f"[{10 * across}, {8 * across}, {8 * across}]")
    text = text.replace("viscosity = 0.02", f"viscosity = {1 / reynolds!r}")
    text = text.replace("28.169014084507044", repr(1000 / reynolds / 0.71))
    return text.replace('"results/sphere-heat/10-50"', f'"{folder / "run"}"')


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--across", nargs="+", type=int, default=[10, 16], help="cells across the sphere")
    parser.add_argument("--reynolds", nargs="+", type=int, default=[50, 100], choices=list(SOURCES))
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    points = [(a, r) for a in options.across for r in options.reynolds]
    folder = lambda a, r: sweep.RESULTS / "sphere-heat" / f"{a}-{r}"
    sweep.run_all([(case(*p, folder(*p)), folder(*p)) for p in points], options.jobs)
    print(f"{'cells':>5} {'Re':>4} {'Nu':>7}   Yuge, Whitaker, Feng, CBS; off their span")
    for across, reynolds in points:
        if not (folder(across, reynolds) / "done").exists():
            continue
        rows = sweep.table(folder(across, reynolds) / "run/series.csv")
        # q/(k π d ΔT), with k = ρ c U d/(Re Pr).
        found = float(rows[-1]["temperature_from_particles"]) * reynolds * 0.71 / 1000 / 3.141592653589793
        low, high = min(SOURCES[reynolds]), max(SOURCES[reynolds])
        off = found / high - 1 if found > high else min(found / low - 1, 0)
        print(f"{across:>5} {reynolds:>4} {found:>7.3f}   {SOURCES[reynolds]} {100 * off:+.1f} %")


if __name__ == "__main__":
    main()
