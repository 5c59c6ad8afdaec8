"""A virtual reactor: catalysts are loaded into a tube, gas flows through them and reacts inside. `python3
cases/virtual-reactor/virtual_reactor.py [--shapes CYL TL QL] [--across 10] [--reynolds 5]` runs what is missing and prints void
fraction, pressure drop, Sherwood number, effectiveness and conversion per shape; `--picture` draws them."""
import argparse
import math
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent), str(HERE.parent / "fixed-bed")]
import fixed_bed
import sweep

TUBE, RATIO, WINDOW, COUNT = 12.0, 2.0, 4.0, 240  # mm, length over diameter, mm, particles
RADIUS, CLEARANCE = TUBE / 2e3, 0.3e-3
VISCOSITY, DENSITY, DIFFUSIVITY, INSIDE, RATE = 3e-5, 1.0, 4e-5, 4e-6, 50.0
NAMES = {"CYL": "cylinders", "TL": "trilobes", "QL": "quadralobes"}


def loading(shape, seed, folder):
    """The case that loads the tube."""
    text = fixed_bed.case(shape, RATIO, TUBE, WINDOW, seed, folder).replace("count = 1000", f"count = {COUNT}")
    return text.replace("end = 0.6\n", "end = 0.4\n")


def flow(shape, across, reynolds, loaded, folder):
    """The case of the flow through a loaded tube, on cells of which as many go across a particle."""
    text = (HERE / "reactor.toml").read_text()
    diameter = fixed_bed.LENGTH / RATIO
    text = text.replace('kind = "cylinder"\nradius = 0.75e-3\nheight = 3e-3', fixed_bed.keys(shape, diameter), 1)
    start, end = text.index("count = 18\n"), text.index("\n[[wall]]")
    text = text[:start] + f'place = {{ kind = "file", path = "{loaded}" }}\n' + text[end:]
    cell = diameter / 1e3 / across
    wide = 2 * math.ceil((RADIUS + CLEARANCE) / cell)
    volume = COUNT * math.pi / 4 * diameter**2 * fixed_bed.LENGTH * fixed_bed.FRACTION[shape]
    height = volume / 0.5 / (math.pi / 4 * TUBE**2) / 1e3
    below, above = math.ceil(3e-3 / cell), math.ceil((height + 3e-3) / cell)
    half = wide * cell / 2
    text = text.replace("lower = [-0.0063, -0.0063, -0.004]", f"lower = [{-half!r}, {-half!r}, {-below * cell!r}]")
    text = text.replace("upper = [0.0063, 0.0063, 0.016]", f"upper = [{half!r}, {half!r}, {above * cell!r}]")
    text = text.replace("[84, 84, 134]", f"[{wide}, {wide}, {below + above}]")
    velocity = reynolds * VISCOSITY / DENSITY / (diameter / 1e3)
    text = text.replace("1.885e-5", repr(velocity * math.pi * RADIUS**2))
    return text.replace('"results/virtual-reactor/lattice"', f'"{folder / "run"}"')


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shapes", nargs="+", default=list(NAMES), choices=list(NAMES))
    parser.add_argument("--across", type=int, default=10, help="cells across a particle")
    parser.add_argument("--reynolds", type=float, default=5.0, help="Reynolds number of the superficial velocity and the diameter")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--picture", action="store_true", help="draw reactor.png")
    options = parser.parse_args()
    folder = lambda shape, what: sweep.RESULTS / "virtual-reactor" / f"{shape}-{what}"
    loads = [(s, folder(s, "loaded")) for s in options.shapes]
    sweep.run_all([(loading(s, 1, f), f) for s, f in loads], options.jobs)
    cases = []
    for shape, where in loads:
        to = folder(shape, f"{options.across}-{options.reynolds:g}")
        cases.append((flow(shape, options.across, options.reynolds, where / "run/particles.vtkhdf", to), to))
    sweep.run_all(cases, options.jobs)
    found = [result(shape, to) for (shape, _), (_, to) in zip(loads, cases) if (to / "done").exists()]
    print(
        f"{'shape':<12} {'void':>6} {'d (mm)':>7} {'dp/H (Pa/m)':>11} {'Re':>5} {'Sh':>6} {'Gunn':>6} {'modulus':>7} {'pellet':>7} {'with film':>9} "
        f"{'in bed':>7} {'conversion':>10} {'per dp':>7}"
    )
    for r in found:
        print(
            f"{NAMES[r['shape']]:<12} {r['void']:>6.4f} {r['diameter'] * 1e3:>7.3f} {r['gradient']:>11.1f} {r['reynolds']:>5.2f} {r['sherwood']:>6.2f} "
            f"{r['gunn']:>6.2f} {r['modulus']:>7.3f} {r['inside']:>7.3f} {r['series']:>9.3f} {r['effectiveness']:>7.3f} {r['conversion']:>10.4f} "
            f"{r['per_drop']:>7.4f}"
        )
    if options.picture:
        picture(found, folder, f"{options.across}-{options.reynolds:g}")


def slope(rows, ends):
    """Rate (1/m) at which the mixed value falls along z between two coordinates, by least squares of its logarithm."""
    points = [(float(row["position"]), math.log(float(row["mixed"]))) for row in rows if ends[0] <= float(row["position"]) <= ends[1]]
    x, y = ([p[k] for p in points] for k in (0, 1))
    mean = sum(x) / len(x), sum(y) / len(y)
    return -sum((a - mean[0]) * (b - mean[1]) for a, b in points) / sum((a - mean[0]) ** 2 for a in x)


def result(shape, to):
    """What one run says of a shape."""
    bed = {key: float(value) for key, value in sweep.analyse("bed", to)[0].items()}
    ends = bed["from"], bed["to"]
    for what in ("sherwood", "effectiveness"):
        sweep.analyse(what, to)
    of = lambda what: sweep.table(to / f"analysis/{what}-axial.csv")
    void, d, u = bed["void_fraction"], bed["diameter"], bed["superficial_velocity"]
    # a k_m = u × slope with a = 6 (1 − ε)/d.
    sherwood = u * slope(of("sherwood"), ends) * d / (6 * (1 - void)) * d / DIFFUSIVITY
    effectiveness = u * slope(of("effectiveness"), ends) / (RATE * (1 - void))
    modulus = d / 6 * math.sqrt(RATE / INSIDE)
    inside = (1 / math.tanh(3 * modulus) - 1 / (3 * modulus)) / modulus
    re, sc = bed["reynolds"], VISCOSITY / DENSITY / DIFFUSIVITY
    gunn = (7 - 10 * void + 5 * void**2) * (1 + 0.7 * re**0.2 * sc ** (1 / 3)) + (1.33 - 2.4 * void + 1.2 * void**2) * re**0.7 * sc ** (1 / 3)
    series = 1 / (1 / inside + RATE * d / 6 / (sherwood * DIFFUSIVITY / d))
    mixed = [float(row["mixed"]) for row in of("effectiveness")]
    return {
        "shape": shape, "void": void, "diameter": d, "gradient": bed["pressure_gradient"], "reynolds": re, "sherwood": sherwood, "gunn": gunn,
        "modulus": modulus, "inside": inside, "series": series, "effectiveness": effectiveness, "conversion": 1 - mixed[-1] / mixed[0],
        # What reacts per volume of the bed and concentration, over the pressure gradient.
        "per_drop": effectiveness * RATE * (1 - void) / bed["pressure_gradient"],
    }


def picture(found, folder, label):
    """The reactant in the middle plane of each tube, and what each shape turns over per pressure drop."""
    import h5py
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, len(found) + 1, figsize=(2.6 * len(found) + 3.6, 5.2), width_ratios=[1] * len(found) + [1.25])
    for axis, r in zip(axes, found):
        with h5py.File(folder(r["shape"], label) / "run/fluid.vtkhdf") as file:
            cells = file["VTKHDF/CellData"]
            value, void = cells["reactant"][-1], cells["void_fraction"][-1]
        middle, wide = value.shape[1] // 2, value.shape[2]
        cut = value[:, middle].copy()
        across = [(k + 0.5) / wide * 2 * (RADIUS + CLEARANCE) - RADIUS - CLEARANCE for k in range(wide)]
        cut[:, [abs(x) > RADIUS for x in across]] = math.nan
        image = axis.imshow(cut, origin="lower", vmin=0, vmax=1, cmap="magma")
        axis.contour(void[:, middle], levels=[0.5], colors="w", linewidths=0.4)
        axis.set_title(NAMES[r["shape"]])
        axis.set_axis_off()
    figure.colorbar(image, ax=axes[:-1], shrink=0.6, pad=0.02, label="reactant / that at the inlet")
    bars = axes[-1]
    best = max(r["per_drop"] for r in found)
    bars.bar([NAMES[r["shape"]] for r in found], [r["per_drop"] / best for r in found], color="0.35")
    bars.set(ylabel="turnover per pressure drop / that of the best", ylim=(0, 1.05))
    bars.tick_params(axis="x", rotation=30)
    figure.savefig(HERE / "reactor.png", dpi=80, bbox_inches="tight")


if __name__ == "__main__":
    main()
