"""Pressure drop of packed beds of spheres and lobes: `python3 cases/packed-bed/packed_bed.py [--beds spheres trilobes-40
trilobes quadralobes] [--across 16 24] [--seeds 1 2] [--reynolds 1]` packs, lets water through, and prints what `grains-mpi
analyse bed` finds in the middle of each bed."""
import argparse
import os
import statistics
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
import sweep

VISCOSITY, DENSITY = 1e-3, 1000
# Particles in beds that are lobes; the diameter (m) about one, the floor, top and width of the box with the fluid (m), the
# Reynolds number of the diameter and the inlet.
SPHERES = {"diameter": 2e-3, "floor": 4e-3, "top": 0.03, "width": 8e-3, "reynolds": 0.1, "count": 192}
LOBES = {"diameter": 1.6e-3, "floor": 4e-3, "top": 0.038, "width": 8e-3, "reynolds": 1, "count": 250, "lobes": 3}
BEDS = {
    "spheres": SPHERES,
    "wide-spheres": SPHERES | {"width": 0.012, "count": 432},
    "trilobes-40": LOBES | {"count": 40, "floor": 4.8e-3, "top": 0.016, "reynolds": 0.1},
    "trilobes": LOBES,
    "quadralobes": LOBES | {"lobes": 4},
}


def packing(bed, seed, folder):
    """The case of a packing."""
    lobes = bed.get("lobes")
    text = (HERE / ("lobes-packing.toml" if lobes else "spheres-packing.toml")).read_text()
    text = text.replace("seed = 1", f"seed = {seed}").replace("0.008", f"{bed['width']}")
    text = text.replace("[0, 0, 0.004]", f"[0, 0, {bed['floor']}]")
    text = text.replace(f"count = {250 if lobes else 192}", f"count = {bed['count']}")
    if lobes == 4:
        text = text.replace("lobes = 3", "lobes = 4").replace("area_fraction = 0.69", "area_fraction = 0.74")
    start = text.index('directory = "') + len('directory = "')
    return text[:start] + str(folder / "run") + text[text.index('"', start) :]


def flow(bed, across, reynolds, packed, folder):
    """The case of the flow through a packing, on cells of which as many go across a particle."""
    text = (HERE / "flow.toml").read_text()
    if bed.get("lobes"):
        body = (HERE / "lobes-packing.toml").read_text() if bed["lobes"] == 3 else packing(bed, 1, folder)
        shape = body[body.index("[[shape]]") : body.index("[[insert]]")]
        text = text[: text.index("[[shape]]")] + shape + text[text.index("[[insert]]") :]
        text = text.replace('"bead"', '"catalyst"').replace('"glass"', '"catalyst"')
    start, end = text.index("count = 192\n"), text.index("\n[fluid]")
    text = text[:start] + f'place = {{ kind = "file", path = "{packed / "run/particles.vtkhdf"}" }}\n' + text[end:]
    cell = bed["diameter"] / across
    text = text.replace("[0.008, 0.008, 0.03]", str([bed["width"], bed["width"], bed["top"]]))
    text = text.replace("[64, 64, 240]", str([round(bed[k] / cell) for k in ("width", "width", "top")]))
    text = text.replace("5e-5", repr(reynolds * VISCOSITY / DENSITY / bed["diameter"]))
    return text.replace('"results/packed-bed/spheres"', f'"{folder / "run"}"')


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--beds", nargs="+", default=["spheres"], choices=list(BEDS))
    parser.add_argument("--across", nargs="+", type=int, default=[16], help="cells across a sphere or lobed particle")
    parser.add_argument("--seeds", nargs="+", type=int, default=[1])
    parser.add_argument("--reynolds", nargs="+", type=float, help="Reynolds numbers; those of BEDS by default")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args()
    home = sweep.RESULTS / "packed-bed"
    packed = lambda bed, seed: home / f"packing-{bed}-{seed}"
    points = [
        (bed, seed, across, reynolds)
        for bed in options.beds
        for seed in options.seeds
        for across in options.across
        for reynolds in options.reynolds or [BEDS[bed]["reynolds"]]
    ]
    folder = lambda bed, seed, across, reynolds: home / f"{bed}-{seed}-{across}-{reynolds:g}"
    packings = {(bed, seed) for bed, seed, *_ in points}
    sweep.run_all([(packing(BEDS[b], s, packed(b, s)), packed(b, s)) for b, s in sorted(packings)], options.jobs)
    flows = [(flow(BEDS[b], a, r, packed(b, s), folder(b, s, a, r)), folder(b, s, a, r)) for b, s, a, r in points]
    sweep.run_all(flows, options.jobs)
    alphas = {}
    for point in points:
        run = folder(*point)
        if not (run / "done").exists():
            continue
        bed, seed, across, reynolds = point
        # Forty particles are too few to leave any out.
        row = sweep.analyse("bed", run, *(["--crop", "0"] if bed == "trilobes-40" else []))[0]
        layers = sweep.table(run / "analysis/bed-axial.csv")
        energy = [float(row["fluid_kinetic"]) for row in sweep.table(run / "run/series.csv")]
        print(
            f"{bed}, seed {seed}, {across} cells across, Reynolds number {reynolds:g}: void fraction"
            f" {float(row['void_fraction']):.4f}, {float(row['pressure_gradient']):.5g} Pa/m, alpha {float(row['alpha']):.1f},"
            f" tortuosity {float(row['tortuosity']):.3f}; inlet to outlet"
            f" {float(layers[0]['pressure']) - float(layers[-1]['pressure']):.5g} Pa; last change {energy[-1] / energy[-2] - 1:.0e}"
        )
        alphas.setdefault((bed, across, reynolds), []).append(float(row["alpha"]))
    for (bed, across, reynolds), found in alphas.items():
        if len(found) > 1:
            error = statistics.stdev(found) / len(found) ** 0.5
            print(f"{bed}, {across} cells, {reynolds:g}: alpha {statistics.mean(found):.1f} +- {error:.1f}")


if __name__ == "__main__":
    main()
