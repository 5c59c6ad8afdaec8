"""Spheres of ten Cate et al. (2002) settling in a tank: `python3 cases/settling-sphere/settling.py [--across 8 16] [--jobs N]`
runs what is missing, prints the largest speeds beside those measured, and draws speed and gap over time into speed.png.
With --creeping: E1 under a hundredth of its weight, released at half the height, beside the theory of slow flow in a square duct."""
import argparse
import os
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
import sweep

# Density and viscosity of the oil, end of the run, and the largest speed measured (m/s).
RUNS = {"E1": (970, 0.373, 4.5, 0.0360), "E2": (965, 0.212, 2.6, 0.0572),
        "E3": (962, 0.113, 1.8, 0.0873), "E4": (960, 0.058, 1.4, 0.1222)}
DIAMETER = 0.015
MASS, GRAVITY = 1120 * 3.14159265 / 6 * DIAMETER**3, 9.81


def case(name, across, folder):
    """The case with another oil, on other cells."""
    density, viscosity, end, _ = RUNS[name]
    cells = [round(length * across / DIAMETER + 0.3) for length in (0.1, 0.1, 0.16)]
    text = (HERE / "e1.toml").read_text().replace("E1", name).replace("cells = [54, 54, 86]", f"cells = {cells}")
    text = text.replace("density = 970", f"density = {density}").replace("viscosity = 0.373", f"viscosity = {viscosity}")
    return text.replace("end = 4.5", f"end = {end}").replace('"results/settling-sphere/e1-8"', f'"{folder / "run"}"')


def creeping(across, folder):
    """E1 so slow that inertia does not matter, far from floor and lid."""
    text = case("E1", across, folder).replace("end = 4.5", "end = 2").replace('name = "', f'gravity = [0, 0, {-GRAVITY / 100}]\nname = "', 1)
    return text.replace("0.12], upper", "0.0725], upper").replace("0.135], spacing", "0.0875], spacing")


def compare_creeping(cells, jobs):
    """Largest speeds over that of Stokes without walls."""
    folder = lambda across: sweep.RESULTS / "settling-sphere" / f"creeping-{across}"
    sweep.run_all([(creeping(across, folder(across)), folder(across)) for across in cells], jobs)
    density, viscosity, *_ = RUNS["E1"]
    stokes = (1120 - density) * GRAVITY / 100 * DIAMETER**2 / (18 * viscosity)
    # Happel and Bart (1974), to first order in the radius over half the width of the duct.
    theory = 1 - 1.903266 * 0.15
    for across in cells:
        rows = sweep.table(folder(across) / "run" / "series.csv")
        largest = max(-float(row["momentum_z"]) / MASS for row in rows)
        print(f"creeping, {across} cells: {largest / stokes:.4f} of Stokes' speed, theory of a duct {theory:.4f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--across", nargs="+", type=int, default=[8, 16], help="cells across the diameter")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--creeping", action="store_true", help="E1 so slow that inertia does not matter")
    options = parser.parse_args()
    if options.creeping:
        return compare_creeping(options.across, options.jobs)
    folder = lambda name, across: sweep.RESULTS / "settling-sphere" / f"{name}-{across}"
    points = [(name, across) for name in RUNS for across in options.across]
    sweep.run_all([(case(*point, folder(*point)), folder(*point)) for point in points], options.jobs)
    figure, axes = plt.subplots(1, 2, figsize=(10, 3.5), layout="constrained")
    for name, across in points:
        run = folder(name, across) / "run"
        if not (run / "series.csv").exists():
            continue
        rows = sweep.table(run / "series.csv")
        times = [float(row["time"]) for row in rows]
        speeds = [-float(row["momentum_z"]) / MASS for row in rows]
        gaps = [float(row["potential"]) / (MASS * GRAVITY) - DIAMETER / 2 for row in rows]
        measured = RUNS[name][3]
        largest = max(speeds)
        print(f"{name}, {across} cells: {largest:.4f} m/s, measured {measured:.4f} ({100 * (largest / measured - 1):+.1f} %)")
        style = {"color": f"C{list(RUNS).index(name)}", "linestyle": "-" if across == max(options.across) else "--"}
        axes[0].plot(times, speeds, label=f"{name}, {across} cells", **style)
        axes[1].semilogy(times, [max(gap, 1e-6) / DIAMETER for gap in gaps], **style)
    for name, (*_, measured) in RUNS.items():
        axes[0].axhline(measured, color="k", linestyle=":", linewidth=1)
    axes[0].set(xlim=(0, 6.5), xlabel="time (s)", ylabel="speed (m/s); dotted: measured")
    axes[1].set(xlabel="time (s)", ylabel="gap to the floor over the diameter")
    axes[0].legend(fontsize="small")
    figure.savefig(HERE / "speed.png", dpi=110)


if __name__ == "__main__":
    main()
