"""Pressure drop of a packed bed of spheres against Carman's: `python3 cases/packed-bed/packed_bed.py [--across 16 24]
[--seeds 1 2]` packs, lets water through, and prints void fraction and Blake-Kozeny-Carman coefficient of the middle."""
import argparse
import os
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
import sweep

DIAMETER, WIDTH, SPEED, VISCOSITY = 2e-3, 8e-3, 5e-5, 1e-3
LOWER, UPPER = 0.008, 0.019


def packing(seed, folder):
    """The case of the packing with another seed."""
    text = (HERE / "packing.toml").read_text().replace("seed = 1", f"seed = {seed}")
    return text.replace('"results/packed-bed/packing"', f'"{folder / "run"}"')


def flow(across, bed, folder):
    """The case of the flow through a packing, on other cells."""
    text = (HERE / "spheres.toml").read_text()
    start, end = text.index("count = 192\n"), text.index("\n[fluid]")
    text = text[:start] + f'place = {{ kind = "file", path = "{bed / "run/particles.vtkhdf"}" }}\n' + text[end:]
    text = text.replace("[64, 64, 240]", str([4 * across, 4 * across, 15 * across]))
    return text.replace('"results/packed-bed/spheres"', f'"{folder / "run"}"')


def coefficient(rows, void):
    """alpha = (dp/H) eps^3 d^2 / ((1 - eps)^2 mu u), errata R16-51, and the last change of the drop."""
    drops = [float(row["lower_pressure"]) - float(row["upper_pressure"]) for row in rows]
    gradient = drops[-1] / (UPPER - LOWER)
    alpha = gradient * void**3 * DIAMETER**2 / ((1 - void) ** 2 * VISCOSITY * SPEED)
    return gradient, alpha, abs(drops[-1] / drops[-2] - 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--across", nargs="+", type=int, default=[16], help="cells across a sphere")
    parser.add_argument("--seeds", nargs="+", type=int, default=[1])
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args()
    home = sweep.RESULTS / "packed-bed"
    bed = lambda seed: home / f"packing-{seed}"
    folder = lambda seed, across: home / f"spheres-{seed}-{across}"
    points = [(seed, across) for seed in options.seeds for across in options.across]
    sweep.run_all([(packing(seed, bed(seed)), bed(seed)) for seed in options.seeds], options.jobs)
    sweep.run_all([(flow(a, bed(s), folder(s, a)), folder(s, a)) for s, a in points], options.jobs)
    for seed, across in points:
        run = folder(seed, across)
        if not (run / "done").exists():
            continue
        lower, upper = f"0,0,{LOWER}", f"{WIDTH},{WIDTH},{UPPER}"
        row = sweep.analyse("void-fraction", bed(seed), "--lower", lower, "--upper", upper, "--crop", "0")[0]
        void = float(row["void_fraction"])
        gradient, alpha, change = coefficient(sweep.table(run / "run/series.csv"), void)
        print(f"seed {seed}, {across} cells across: void fraction {void:.4f}, {gradient:.4f} Pa/m, alpha {alpha:.1f}"
              f" ({100 * (alpha / 180 - 1):+.1f} % of Carman's 180), last change {change:.0e}")


if __name__ == "__main__":
    main()
