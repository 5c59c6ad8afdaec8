"""Mean pressure drop of the bed of Mueller and profiles of its void fraction and of the seeds' velocity, of one run or several
side by side: `python3 cases/fluidised-bed/mueller/profiles.py [RUN ...]` prints a table and draws profiles.png."""
import csv
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
import sweep

RESULTS = sweep.RESULTS / "fluidised-bed/mueller"
WEIGHT = 186.17  # Pa, buoyant weight of 9240 seeds over 4.4 cm2
FROM = 5.0  # s
PANELS = [
    ("16.4", "void_fraction", "void fraction"),
    ("31.2", "void_fraction", "void fraction"),
    ("15", "solid_velocity_z", "seeds upwards (m/s)"),
    ("25", "solid_velocity_z", "seeds upwards (m/s)"),
    ("35", "solid_velocity_z", "seeds upwards (m/s)"),
]


def table(path):
    """Rows of a CSV file with comments."""
    with open(path) as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def main():
    runs = [Path(a) for a in sys.argv[1:]] or sorted(p for p in RESULTS.iterdir() if (p / "series.csv").exists())
    figure, axes = plt.subplots(1, len(PANELS), figsize=(15, 3), layout="constrained")
    for run in runs:
        late = [r for r in table(run / "series.csv") if float(r["time"]) >= FROM]
        if not late:
            print(f"{run.name}: has not come to {FROM} s")
            continue
        mean = lambda key: sum(float(r[key]) for r in late) / len(late)
        drop, base = mean("pressure_drop"), -mean("distributor_fz") / 4.4e-4
        print(f"{run.name}: pressure drop {drop:.2f} Pa ({100 * (drop / WEIGHT - 1):+.2f} % of the weight), "
              f"on the distributor {base:.2f} Pa, least void fraction {min(float(r['least_void_fraction']) for r in late):.3f}")
        for axis, (height, key, label) in zip(axes, PANELS):
            rows = table(run / f"profile-height-{height}-mm-mean.csv")
            axis.plot([1e3 * float(r["x"]) for r in rows], [float(r[key]) for r in rows], label=run.name)
            axis.set(title=f"{height} mm", xlabel="x (mm)", ylabel=label)
    axes[0].legend()
    figure.savefig(Path(__file__).parent / "profiles.png", dpi=110)


if __name__ == "__main__":
    main()
