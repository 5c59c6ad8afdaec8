"""Pressure drop against velocity of a run of bed.toml beside the law of the fixed bed and the weight of the bed:
`python3 cases/fluidised-bed/minimum-fluidisation/curve.py [RUN]` prints a table and draws curve.png."""
import csv
import math
import subprocess
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
import sweep

DIAMETER, SOLID, DENSITY, VISCOSITY, GRAVITY = 1e-3, 2500, 1.2, 1.8e-5, 9.81
COUNT, SECTION = 9000, 1e-4
WEIGHT = COUNT * math.pi / 6 * DIAMETER**3 * (SOLID - DENSITY) * GRAVITY / SECTION  # Pa


def velocity(time):
    """Superficial velocity (m/s) of the case at a time (s)."""
    return 0.02 + 0.2 * max(0.0, time - 0.4)


def beetstra(eps, reynolds):
    """Resistance of Beetstra et al. (2007) at a void fraction and superficial Reynolds number (thesis 5.16)."""
    phi = 1 - eps
    creeping = 10 * phi / eps**2 + eps**2 * (1 + 1.5 * math.sqrt(phi))
    top = 1 / eps + 3 * eps * phi + 8.4 * reynolds**-0.343
    bottom = 1 + 10 ** (3 * phi) * reynolds ** (-(1 + 4 * phi) / 2)
    return creeping + 0.413 * reynolds / (24 * eps**2) * top / bottom


def law(eps, u):
    """Pressure gradient (Pa/m) of a bed at a superficial velocity (m/s)."""
    reynolds = DENSITY * u * DIAMETER / VISCOSITY
    return 18 * VISCOSITY * (1 - eps) / eps / DIAMETER**2 * u * beetstra(eps, reynolds)


def minimum(eps):
    """Velocity (m/s) at which the law carries the bed."""
    low, high = 1e-3, 10.0
    while high - low > 1e-9:
        middle = (low + high) / 2
        low, high = (middle, high) if law(eps, middle) < (1 - eps) * (SOLID - DENSITY) * GRAVITY else (low, middle)
    return low


def draw(found, eps, height):
    """Draws the curve with the law of the fixed bed and the weight."""
    figure, axes = plt.subplots(figsize=(7, 3.2), layout="constrained")
    axes.plot(*zip(*found), linewidth=0.8, label="drop")
    slow = [0.01 * k for k in range(1, 54)]
    axes.plot(slow, [law(eps, u) * height for u in slow], "--", label="Beetstra, fixed bed")
    axes.axhline(WEIGHT, color="grey", linestyle=":", label="weight over section")
    axes.set(xlabel="superficial velocity (m/s)", ylabel="pressure drop (Pa)", xlim=(0, None), ylim=(0, None))
    axes.legend()
    figure.savefig(Path(__file__).parent / "curve.png", dpi=110)


def main():
    run = Path(sys.argv[1]) if len(sys.argv) > 1 else sweep.RESULTS / "fluidised-bed/minimum-fluidisation"
    out = run / "analysis"
    # The bed at rest under the first breath of air; its ends are left out.
    command = [sweep.PROGRAM, "analyse", "void-fraction", run, "--time", "0.4", "--output", out]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=sweep.environment())
    eps = float(sweep.table(out / "void-fraction.csv")[0]["void_fraction"])
    height = COUNT * math.pi / 6 * DIAMETER**3 / SECTION / (1 - eps)
    rows = sweep.table(run / "series.csv")
    found = [(velocity(float(r["time"])), float(r["pressure_drop"])) for r in rows if float(r["time"]) >= 0.4]
    expected = minimum(eps)
    draw(found, eps, height)
    print(f"void fraction {eps:.4f}, height {1e3 * height:.2f} mm, weight over section {WEIGHT:.2f} Pa")
    print(f"minimum fluidisation by the law {expected:.4f} m/s")
    print(f"{'velocity':>9} {'drop':>8} {'law':>8}")
    for wanted in [0.05 * k for k in range(1, 18)]:
        near = [p for u, p in found if abs(u - wanted) < 0.01]
        if near:
            print(f"{wanted:>9.2f} {sum(near) / len(near):>8.2f} {min(law(eps, wanted) * height, WEIGHT):>8.2f}")
    plateau = [p for u, p in found if u > 1.15 * expected]
    if plateau:
        mean = sum(plateau) / len(plateau)
        # The kink is where the curve of the fixed bed, scaled to what was found below it, reaches the plateau.
        below = [p / (law(eps, u) * height) for u, p in found if 0.5 * expected < u < 0.9 * expected]
        scale = sum(below) / len(below)
        kink = next(u for u in (1e-4 * k for k in range(1, 30000)) if scale * law(eps, u) * height >= mean)
        print(f"plateau {mean:.2f} Pa ({100 * (mean / WEIGHT - 1):+.2f} %), fixed bed {100 * (scale - 1):+.2f} % of the law, "
              f"kink at {kink:.4f} m/s ({100 * (kink / expected - 1):+.2f} %)")


if __name__ == "__main__":
    main()
