"""Angles of repose of spheres and cubes, with and without rolling resistance and cohesion: `python cases/angle-of-repose/
angle_of_repose.py [--seeds 1 2 3] [--laws LAW ...]` with the Python that scripts/python-environment prints. Runs what is
missing, goes on where it was stopped, prints the table of what there is, and draws it into angles-SHAPE.png."""
import argparse
import sys
from pathlib import Path

import h5py
import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
import sweep

RADIUS = 1e-3
# Half the length of the plate and width of the heap (m), by the case.
EXTENT = {"spheres": (0.04, 0.01), "cubes": (0.03, 0.008)}
ROLLING = ("friction = 0.4\n", "friction = 0.4\nrolling_friction = 0.1\n")
JKR = ('normal = { kind = "hertz" }', 'normal = { kind = "jkr" }\nwork_of_adhesion = 0.04')


def friction(coefficient):
    return ("friction = 0.4", f"friction = {coefficient}")


def rolling(coefficient):
    return ("rolling_friction = 0.1", f"rolling_friction = {coefficient}")


LAWS = {"neither": [], "rolling": [ROLLING], "cohesion": [JKR], "both": [ROLLING, JKR]}
TRENDS = {
    "μ 0.2": [ROLLING, friction(0.2)],
    "μ 0.8": [ROLLING, friction(0.8)],
    "μ_r 0.05": [ROLLING, rolling(0.05)],
    "μ_r 0.2": [ROLLING, rolling(0.2)],
    "stiffer": [ROLLING, ("softening = 2e4", "softening = 2e3")],
}
VARIANTS = {("spheres", name): changes for name, changes in (LAWS | TRENDS).items()}
VARIANTS |= {("cubes", name): changes for name, changes in LAWS.items()}


def folder(shape, law, seed):
    return sweep.RESULTS / "angle-of-repose" / f"{shape}-{law.replace(' ', '-')}-{seed}"


def case(shape, law, seed):
    text = (HERE / f"{shape}.toml").read_text().replace("seed = 1", f"seed = {seed}")
    directory = f'"{folder(shape, law, seed) / "run"}"'
    for old, new in VARIANTS[shape, law] + [(f'"results/angle-of-repose/{shape}"', directory)]:
        assert old in text, old
        text = text.replace(old, new)
    return text


def places(run):
    """Centres of the last state (m)."""
    with h5py.File(run / "particles.vtkhdf") as file:
        group = file["VTKHDF"]
        first = group["Steps/PointOffsets"][-1]
        return group["Points"][first:]


def surface(run, half, width):
    """Distance and height of the heap over a plate of a half length: mean over columns two radii square of their highest
    centres (m)."""
    x, y, z = places(run).T
    above = (abs(x) < half) & (z > 0)
    bins, strips = round(half / RADIUS), round(width / (2 * RADIUS))
    column = np.clip(((x[above] + half) / (2 * RADIUS)).astype(int), 0, bins - 1)
    strip = np.clip((y[above] / (2 * RADIUS)).astype(int), 0, strips - 1)
    highest = np.zeros((bins, strips))
    np.maximum.at(highest, (column, strip), z[above])
    return (np.arange(bins) + 0.5) * 2 * RADIUS - half, highest.mean(axis=1)


def flanks(shape, law, seed):
    """Angle (degrees) and standard error of a line through either flank, from 0.15 of the height to where it first reaches 0.85
    from the edge of the plate inwards; none of a flank that is no slope: upright beside a slot in which beads have jammed, or broken off in steps,
    so that the line is off by more than 10 degrees."""
    at, height = surface(folder(shape, law, seed) / "run", *EXTENT[shape])
    found = []
    for inwards in (slice(None), slice(None, None, -1)):
        x, z = abs(at[inwards]), height[inwards]
        top = np.argmax(z > 0.85 * height.max())
        x, z = x[:top][z[:top] > 0.15 * height.max()], z[:top][z[:top] > 0.15 * height.max()]
        if len(x) < 4:
            continue
        (slope, _), covariance = np.polyfit(x, z, 1, cov=True)
        angle = np.degrees(np.arctan(-slope))
        error = np.degrees(np.sqrt(covariance[0, 0]) / (1 + slope**2))
        if error < 10:
            found.append((angle, error))
    return found


def draw(found, shape, seed):
    """Surfaces of the heaps of a shape and a seed, under the four laws."""
    figure, panel = plt.subplots(figsize=(6, 2.5))
    for law in LAWS:
        if (shape, law) in found and (folder(shape, law, seed) / "done").exists():
            at, height = surface(folder(shape, law, seed) / "run", *EXTENT[shape])
            label = f"{law}: {np.mean([angle for angle, _ in found[shape, law]]):.0f}°"
            panel.plot(at / (2 * RADIUS), height / (2 * RADIUS), label=label)
    panel.set(xlabel="distance / diameter", ylabel="height / diameter", title=shape, aspect="equal", ylim=(0, None))
    panel.legend(loc="center left", bbox_to_anchor=(1, 0.5), frameon=False)
    figure.tight_layout()
    figure.savefig(HERE / f"angles-{shape}.png", dpi=100)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3])
    parser.add_argument("--shapes", nargs="+", default=list(EXTENT), choices=list(EXTENT))
    parser.add_argument("--laws", nargs="+", default=[*LAWS, *TRENDS], choices=[*LAWS, *TRENDS], metavar="LAW")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--no-runs", action="store_true", help="the table of what there is")
    options = parser.parse_args()
    chosen = [(shape, law) for shape, law in VARIANTS if shape in options.shapes and law in options.laws]
    points = [(*variant, seed) for seed in options.seeds for variant in chosen]
    if not options.no_runs:
        sweep.run_all([(case(*point), folder(*point)) for point in points], options.jobs)
    found = {}
    for *variant, seed in points:
        if (folder(*variant, seed) / "done").exists():
            found.setdefault(tuple(variant), []).extend(flanks(*variant, seed))
    print(f"{'':<18} {'flanks':>6} {'angle':>6} {'deviation':>9} {'error of one fit':>16}")
    for (shape, law), of_flanks in found.items():
        angle, error = np.array(of_flanks).T
        print(f"{shape + ', ' + law:<18} {len(angle):>6} {angle.mean():>6.1f} {angle.std(ddof=min(1, len(angle) - 1)):>9.1f} {error.mean():>16.1f}")
    for shape in {shape for shape, _ in found}:
        draw(found, shape, options.seeds[0])


if __name__ == "__main__":
    main()
