"""Height profiles of the deposits of both sizes, scaled by the length of their reservoir: `python3 cases/dam-break/profiles.py`
prints how far they lie apart and draws profiles.png."""
import csv
import subprocess
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import sweep

LENGTHS = {"size1": 0.025, "size2": 0.05}


def profile(name):
    """x/L and h/L of a deposit at the last time."""
    run = sweep.RESULTS / "dam-break" / name
    out = run / "analysis-last"
    command = [sweep.PROGRAM, "analyse", "run-out", run, "--length", LENGTHS[name], "--time", "last", "--output", out]
    subprocess.run([str(c) for c in command], check=True, stdout=subprocess.DEVNULL, env=sweep.environment())
    rows = sweep.table(out / "run-out-profile.csv")
    return [(float(r["x_over_length"]), float(r["height_over_length"])) for r in rows]


def height(points, x):
    """h/L at x/L by linear interpolation."""
    for (a, p), (b, q) in zip(points, points[1:]):
        if a <= x <= b:
            return p + (q - p) * (x - a) / (b - a)
    return 0.0


def main():
    one, two = profile("size1"), profile("size2")
    places = [0.25 + 0.25 * k for k in range(44)]
    apart = [abs(height(one, x) - height(two, x)) for x in places]
    highest = max(h for _, h in one)
    print(f"h/L of the two sizes: mean difference {sum(apart) / len(apart):.3f}, largest {max(apart):.3f}, highest h/L {highest:.3f}")
    figure, axes = plt.subplots(figsize=(7, 2.6), layout="constrained")
    for points, label in ((one, "size 1, L = 25 mm"), (two, "size 2, L = 50 mm")):
        axes.plot([x for x, _ in points], [h for _, h in points], label=label)
    axes.set(xlabel="x/L", ylabel="h/L", xlim=(0, 13), ylim=(0, None))
    axes.legend()
    figure.savefig(Path(__file__).parent / "profiles.png", dpi=120)


if __name__ == "__main__":
    main()
