"""Flow through the tubes of 19 mm of ../fixed-bed, resolved: `python3 cases/reactor-tube/reactor_tube.py [--shapes CYL TL QL]
[--across 10 16] [--reynolds 0.1]` loads each tube, lets water through, and prints void fraction, pressure drop and α beside
Ergun's equation and that of Eisfeld and Schnitzlein (2001) with the tube. `--picture` draws flows and void profiles."""
import argparse
import math
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent), str(HERE.parent / "fixed-bed")]
import fixed_bed
import sweep

TUBE, RATIO, WINDOW, SEED = 19.0, 2.0, 6.0, 1  # mm, length over diameter, mm
RADIUS, CLEARANCE, VISCOSITY, DENSITY = TUBE / 2e3, 0.4e-3, 1e-3, 1000.0
NAMES = {"CYL": "cylinders", "TL": "trilobes", "QL": "quadralobes"}
# K1, k1 and k2 of Eisfeld and Schnitzlein (2001), of cylinders and of all particles.
EISFELD = {"CYL": (190.0, 2.00, 0.77), "TL": (155.0, 1.42, 0.83), "QL": (155.0, 1.42, 0.83)}


def flow_diameter(shape):
    """Diameter (m) that sets the velocity: 6 V/A of cylinders; of lobes that about them, 1.15 to 1.21 times 6 V/A."""
    d, length = fixed_bed.LENGTH / RATIO / 1e3, fixed_bed.LENGTH / 1e3
    return 6 * (math.pi / 4 * d**2 * length) / (math.pi / 2 * d**2 + math.pi * d * length) if shape == "CYL" else d


def flow(shape, across, reynolds, loaded, height, folder):
    """The case of the flow through a loaded tube up to a height (m), on cells of which as many go across a particle."""
    text = (HERE / "flow.toml").read_text()
    diameter = fixed_bed.LENGTH / RATIO
    text = text.replace('kind = "cylinder"\nradius = 0.75e-3\nheight = 3e-3', fixed_bed.keys(shape, diameter), 1)
    start, end = text.index("count = 112\n"), text.index("\n[[wall]]")
    text = text[:start] + f'place = {{ kind = "file", path = "{loaded}" }}\n' + text[end:]
    cell = diameter / 1e3 / across
    wide = 2 * math.ceil((RADIUS + CLEARANCE) / cell)
    below, above = math.ceil(5e-3 / cell), math.ceil((height + 6e-3) / cell)
    half = wide * cell / 2
    text = text.replace("lower = [-0.0099, -0.0099, -0.006]", f"lower = [{-half!r}, {-half!r}, {-below * cell!r}]")
    text = text.replace("upper = [0.0099, 0.0099, 0.03]", f"upper = [{half!r}, {half!r}, {above * cell!r}]")
    text = text.replace("[132, 132, 240]", f"[{wide}, {wide}, {below + above}]")
    velocity = reynolds * VISCOSITY / DENSITY / flow_diameter(shape)
    text = text.replace("1.6e-8", repr(velocity * math.pi * RADIUS**2))
    return text.replace('"results/reactor-tube/lattice"', f'"{folder / "run"}"')


def eisfeld(shape, void, diameter, reynolds):
    """f = (Δp/H) ε³ d²/((1 − ε)² μ u) in the tube at Re' = ρ u d/(μ (1 − ε))."""
    k1, c1, c2 = EISFELD[shape]
    ratio = 2 * RADIUS / diameter
    a = 1 + 2 / (3 * ratio * (1 - void))
    b = (c1 / ratio**2 + c2) ** 2
    return k1 * a**2 + a / b * reynolds


def height(shape):
    """Height (m) that a bed stays below."""
    volume = 1000 * math.pi / 4 * (fixed_bed.LENGTH / RATIO) ** 2 * fixed_bed.LENGTH * fixed_bed.FRACTION[shape]
    return volume / 0.54 / (math.pi / 4 * TUBE**2) / 1e3


def pictures(runs):
    """Speed in the middle plane of each tube, and the void fraction over the distance from its wall."""
    import h5py
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, len(runs) + 1, figsize=(3.2 * len(runs) + 4.2, 5.6), width_ratios=[1] * len(runs) + [1.3])
    for axis, (shape, folder, _) in zip(axes, runs):
        with h5py.File(folder / "run/fluid.vtkhdf") as file:
            cells = file["VTKHDF/CellData"]
            velocity, void = cells["velocity"][-1], cells["void_fraction"][-1]
        middle = velocity.shape[1] // 2
        speed = ((velocity[:, middle] ** 2).sum(axis=-1)) ** 0.5
        superficial = velocity[3, :, :, 2].sum() * (4 / math.pi) / (velocity.shape[1] * velocity.shape[2])
        speed[void[:, middle] < 0.5] = math.nan
        axis.imshow(speed / superficial, origin="lower", vmin=0, vmax=8, cmap="viridis")
        axis.set_title(NAMES[shape])
        axis.set_axis_off()
    for shape, _, loading in runs:
        rows = sweep.table(loading / "analysis/void-fraction-radial.csv")
        axes[-1].plot(
            [(RADIUS - float(row["radius"])) * 1e3 / (fixed_bed.LENGTH / RATIO) for row in rows],
            [float(row["void_fraction"]) for row in rows],
            label=NAMES[shape],
        )
    axes[-1].set(xlabel="distance from the wall / diameter of a particle", ylabel="void fraction", ylim=(0.2, 1), xlim=(0, 5))
    axes[-1].legend()
    figure.tight_layout()
    figure.savefig(HERE / "tubes.png", dpi=70)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shapes", nargs="+", default=list(NAMES), choices=list(NAMES))
    parser.add_argument("--across", nargs="+", type=int, default=[10], help="cells across a particle")
    parser.add_argument("--reynolds", nargs="+", type=float, default=[0.1], help="Reynolds numbers ρ u d/μ")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--picture", action="store_true", help="draw tubes.png")
    options = parser.parse_args()
    loading = lambda shape: sweep.RESULTS / "fixed-bed" / f"{shape}-{RATIO:g}-D{TUBE:g}-w{WINDOW:g}-{SEED}"
    loadings = [(s, loading(s)) for s in options.shapes]
    sweep.run_all([(fixed_bed.case(s, RATIO, TUBE, WINDOW, SEED, f), f) for s, f in loadings], options.jobs)
    points = [(s, a, r) for a in options.across for s in options.shapes for r in options.reynolds]
    folder = lambda s, a, r: sweep.RESULTS / "reactor-tube" / f"{s}-{a}-{r:g}"
    cases = []
    for shape, across, reynolds in points:
        loaded, to = loading(shape) / "run/particles.vtkhdf", folder(shape, across, reynolds)
        cases.append((flow(shape, across, reynolds, loaded, height(shape), to), to))
    sweep.run_all(cases, options.jobs)
    print(f"{'shape':<12} {'cells':>5} {'Re':>6} {'void fraction':>13} {'dp/H (Pa/m)':>12} {'f':>7} {'Ergun':>7} {'with tube':>9} {'tortuosity':>10}")
    for point in points:
        if not (folder(*point) / "done").exists():
            continue
        row = {key: float(value) for key, value in sweep.analyse("bed", folder(*point))[0].items()}
        void, reynolds = row["void_fraction"], row["ergun_reynolds"]
        print(
            f"{NAMES[point[0]]:<12} {point[1]:>5} {row['reynolds']:>6.3g} {void:>13.4f} {row['pressure_gradient']:>12.5g} {row['alpha']:>7.1f}"
            f" {150 + 1.75 * reynolds:>7.1f} {eisfeld(point[0], void, row['diameter'], reynolds):>9.1f} {row['tortuosity']:>10.3f}"
        )
    if options.picture:
        for _, where in loadings:
            sweep.analyse("void-fraction", where, "--cylinder", f"0,0,{RADIUS}", "--radial", "axis", "--bins", 60)
        pictures([(s, folder(s, options.across[-1], options.reynolds[0]), f) for s, f in loadings])


if __name__ == "__main__":
    main()
