"""The bed of Mueller with seeds of three shapes of one volume: `python3 cases/fluidised-bed/mueller/mueller.py [--jobs N]
[SHAPE ...]` runs what is missing, goes on where it was stopped, prints the mean pressure drops, and draws profiles of the void
fraction and of the seeds' velocity into profiles.png."""
import argparse
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
import sweep

CASE = (Path(__file__).parent / "spheres.toml").read_text()
SPHERE = 'kind = "sphere"\nradius = 0.6e-3'
RESULTS = sweep.RESULTS / "fluidised-bed/mueller"
# Seeds of 1.2 mm; the longer ones are 1.5 times as long as thick.
SHAPES = {
    "spheres": SPHERE,
    "superellipsoids": 'kind = "superellipsoid"\nsemi_axes = [0.6e-3, 0.6e-3, 0.6e-3]',
    "ellipsoids": 'kind = "superellipsoid"\nsemi_axes = [0.7862e-3, 0.5242e-3, 0.5242e-3]',
}
WEIGHT = 186.17  # Pa, buoyant weight of 9240 seeds over 4.4 cm2
FROM = 5.0  # s
PANELS = [
    ("16.4", "void_fraction", "void fraction"),
    ("31.2", "void_fraction", "void fraction"),
    ("15", "solid_velocity_z", "seeds upwards (m/s)"),
    ("25", "solid_velocity_z", "seeds upwards (m/s)"),
    ("35", "solid_velocity_z", "seeds upwards (m/s)"),
]


def case(name, folder):
    """The case with seeds of a shape."""
    text = CASE.replace(SPHERE, SHAPES[name]).replace("bed of Mueller, spheres", f"bed of Mueller, {name}")
    # The lattice of the spheres is too narrow for the long ones.
    if name == "ellipsoids":
        text = text.replace("0.08], spacing = 1.23e-3", "0.16], spacing = 1.61e-3")
    return text.replace('"results/fluidised-bed/mueller/spheres"', f'"{folder / "run"}"')


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("shape", nargs="*", choices=[*SHAPES, []], help="shapes of the seeds, all by default")
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    names = options.shape or list(SHAPES)
    sweep.run_all([(case(name, RESULTS / name), RESULTS / name) for name in names], options.jobs)
    voids = {}
    figure, axes = plt.subplots(1, len(PANELS), figsize=(15, 3), layout="constrained")
    for run in [RESULTS / name / "run" for name in SHAPES]:
        if not (run / "series.csv").exists():
            continue
        late = [r for r in sweep.table(run / "series.csv") if float(r["time"]) >= FROM]
        if not late:
            print(f"{run.parent.name}: has not come to {FROM} s")
            continue
        # A row has the pressure of one step of the fluid, which is an impulse if the step was cut short.
        weight = [float(r["fluid_dt"]) for r in late]
        mean = lambda key: sum(w * float(r[key]) for w, r in zip(weight, late)) / sum(weight)
        drop, base = mean("pressure_drop"), -mean("distributor_fz") / 4.4e-4
        print(f"{run.parent.name}: pressure drop {drop:.2f} Pa ({100 * (drop / WEIGHT - 1):+.2f} % of the weight), "
              f"on the distributor {base:.2f} Pa, least void fraction {min(float(r['min_void_fraction']) for r in late):.3f}")
        for axis, (height, key, label) in zip(axes, PANELS):
            rows = sweep.table(run / f"profile-height-{height}-mm-mean.csv")
            axis.plot([1e3 * float(r["x"]) for r in rows], [float(r[key]) for r in rows], label=run.parent.name)
            if key == "void_fraction":
                voids.setdefault(run.parent.name, []).extend(float(r[key]) for r in rows)
            axis.set(title=f"{height} mm", xlabel="x (mm)", ylabel=label)
    for name, profile in voids.items():
        if name != "spheres" and "spheres" in voids:
            off = [abs(a / b - 1) for a, b in zip(profile, voids["spheres"])]
            print(f"{name}: mean void fraction off that of the spheres by {100 * sum(off) / len(off):.2f} % on average, "
                  f"{100 * max(off):.2f} % at most")
    axes[0].legend()
    figure.savefig(Path(__file__).parent / "profiles.png", dpi=110)


if __name__ == "__main__":
    main()
