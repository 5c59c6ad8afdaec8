"""The lid-driven cavity at Reynolds 100, 400 and 1000 beside the tables of Ghia et al. (1982), as numbers and as
cavity.png: `python3 cases/cavity/cavity.py`; with other cells along an edge than 128: `cavity.py 256`. At Reynolds 1000 also beside
converged values."""
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
import sweep

# Reynolds number and the time after which the flow no longer changes.
RUNS = {100: 20, 400: 40, 1000: 60}
LINES = [("y", "u", "velocity_x"), ("x", "v", "velocity_y")]
MISPRINT = ("v", 400, 0.9063)


def table(path):
    """Rows of a CSV file, as numbers."""
    return [{key: float(value) for key, value in row.items()} for row in sweep.table(path)]


def cubic(places, values, x):
    """Value at x of the cubic through the four nearest of evenly spaced points."""
    s = (x - places[0]) / (places[1] - places[0])
    low = min(max(int(s // 1) - 1, 0), len(places) - 4)
    total = 0.0
    for q in range(low, low + 4):
        weight = 1.0
        for r in range(low, low + 4):
            weight *= (s - r) / (q - r) if r != q else 1.0
        total += weight * values[q]
    return total


def with_cells(text, cells):
    """The case on so many cells along an edge, with points at their centres."""
    text = text.replace("cells = [128, 128, 1]", f"cells = [{cells}, {cells}, 1]").replace("points = 128", f"points = {cells}")
    return text.replace("0.00390625", repr(0.5 / cells)).replace("0.99609375", repr(1 - 0.5 / cells))


def main():
    cells = int(sys.argv[1]) if len(sys.argv) > 1 else 128
    ghia, converged = table(HERE / "ghia.csv"), table(HERE / "converged.csv")
    text = with_cells((HERE / "cavity.toml").read_text(), cells)
    figure, axes = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    for reynolds, end in RUNS.items():
        folder = sweep.RESULTS / "cavity" / f"{reynolds}-{cells}"
        case = text.replace("viscosity = 1e-3", f"viscosity = {1 / reynolds!r}").replace("end = 60", f"end = {end}")
        sweep.run(case.replace('"results/cavity"', f'"{folder / "run"}"'), folder)
        worst = off = (0.0, "")
        for axis, (along, velocity, column) in zip(axes, LINES):
            rows = table(folder / "run" / f"profile-{velocity}-of-{along}.csv")
            rows = [row for row in rows if row["time"] == rows[-1]["time"]]
            places, values = [row[along] for row in rows], [row[column] for row in rows]
            points = [(row[along], row[f"{velocity}_{reynolds}"]) for row in ghia]
            line = axis.plot(places, values, label=f"Re {reynolds}")[0]
            axis.plot(*zip(*points), "o", color=line.get_color(), markersize=3)
            axis.set(xlabel=along, ylabel=velocity)
            for x, wanted in points:
                if 0 < x < 1 and (velocity, reynolds, x) != MISPRINT:
                    worst = max(worst, (abs(cubic(places, values, x) - wanted), f"{velocity}({x})"))
            for row in converged if reynolds == 1000 else []:
                difference = abs(cubic(places, values, row[along]) - row[f"{velocity}_1000"])
                off = max(off, (difference, f"{velocity}({row[along]})"))
        beside = f"; from converged values {off[0]:.4f} at {off[1]}" if off[1] else ""
        print(f"Re {reynolds}: largest difference {worst[0]:.4f} at {worst[1]}{beside}")
    axes[0].legend()
    figure.savefig(HERE / "cavity.png", dpi=100)


if __name__ == "__main__":
    main()
