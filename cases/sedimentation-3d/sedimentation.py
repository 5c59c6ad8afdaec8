"""Spheres and cubes that settle in a closed box (Wachs et al. 2009): `python3 cases/sedimentation-3d/sedimentation.py
[--shapes spheres cubes] [--share 1]` runs what is missing, prints how they settle, and draws settling speed over time and the
velocity of the fluid in planes into sedimentation.png."""
import argparse
import os
import sys
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
import sweep

SPHERE = 'kind = "sphere"\nradius = 0.5'
SOURCE_END = 30
EDGE = (np.pi / 6) ** (1 / 3)


def case(shape, share, folder):
    """The box with another shape, or a share of it as wide and deep."""
    text = (HERE / "spheres.toml").read_text().replace('"results/sedimentation-3d/spheres"', f'"{folder / "run"}"')
    if shape == "cubes":
        text = text.replace(SPHERE, f'kind = "box"\nedges = [{EDGE!r}, {EDGE!r}, {EDGE!r}]')
        # As they come they would find no room for the last ones.
        text = text.replace("count = 1528", 'count = 1528\norientation = "aligned"')
        text += '\n[contact_points]\nfaces = "patch"\n'
    side = round(14 * share**0.5)
    for old, new in (("[14, 14,", f"[{side}, {side},"), ("[140, 140,", f"[{10 * side}, {10 * side},"), ("13.5, 13.5", f"{side - 0.5}, {side - 0.5}")):
        text = text.replace(old, new)
    return text.replace("count = 1528", f"count = {round(1528 * side**2 / 14**2)}")


def rows(run):
    """Time, mean settling speed and mean height of the particles at every snapshot."""
    with h5py.File(run / "particles.vtkhdf") as file:
        group = file["VTKHDF"]
        steps, counts = group["Steps"], group["NumberOfPoints"][:]
        found = []
        for time, start, count in zip(steps["Values"][:], steps["PointOffsets"][:], counts):
            part = slice(start, start + count)
            velocity, height = group["PointData/velocity"][part, 2], group["Points"][part, 2]
            found.append((time, -velocity.mean(), height.mean(), height.max()))
    return np.array(found)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shapes", nargs="+", default=["spheres", "cubes"], choices=["spheres", "cubes"])
    parser.add_argument("--share", type=float, default=1, help="of the 1528 particles and the section of the box")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args()
    folder = lambda shape: sweep.RESULTS / "sedimentation-3d" / f"{shape}-{options.share:g}"
    sweep.run_all([(case(s, options.share, folder(s)), folder(s)) for s in options.shapes], options.jobs)
    shown = [s for s in options.shapes if (folder(s) / "done").exists()]
    figure, axes = plt.subplots(1, 1 + 3 * len(shown), figsize=(4 + 6 * len(shown), 4.4), layout="constrained", squeeze=False)
    for k, shape in enumerate(shown):
        run = folder(shape) / "run"
        found = rows(run)
        axes[0, 0].plot(found[:, 0], found[:, 1], label=shape)
        early = (found[:, 0] > 1) & (found[:, 0] < 3)
        series = sweep.table(run / "series.csv")
        at = lambda time: found[np.abs(found[:, 0] - time).argmin()]
        print(
            f"{shape}: settle at {found[early, 1].mean():.3f} U_c from t = 1 to 3; mean height {found[0, 2]:.2f} at first,"
            f" {at(SOURCE_END)[2]:.2f} at t = {SOURCE_END}, {found[-1, 2]:.2f} at t = {found[-1, 0]:g}, where they settle at"
            f" {found[-1, 1]:.4f} U_c and the highest centre is at {found[-1, 3]:.2f}; largest overlap"
            f" {max(float(r['max_overlap']) for r in series):.4f} of the radius"
        )
        with h5py.File(run / "fluid.vtkhdf") as file:
            times = file["VTKHDF/Steps/Values"][:]
            for n, time in enumerate((5.0, 12.5, found[-1, 0])):
                step = np.abs(times - time).argmin()
                velocity = file["VTKHDF/CellData/velocity"][step]
                solid = file["VTKHDF/CellData/void_fraction"][step]
                middle = velocity.shape[1] // 2
                width, height = velocity.shape[2] / 10, velocity.shape[0] / 10
                axis = axes[0, 1 + 3 * k + n]
                picture = axis.imshow(velocity[:, middle, :, 2], origin="lower", extent=(0, width, 0, height), cmap="RdBu_r", vmin=-2, vmax=2)
                axis.contour(solid[:, middle], [0.5], colors="k", linewidths=0.6, extent=(0, width, 0, height))
                axis.set(title=f"{shape}, t = {times[step]:.1f}")
    axes[0, 0].set(xlabel="t U_c / D", ylabel="mean settling speed / U_c")
    axes[0, 0].legend()
    if shown:
        figure.colorbar(picture, ax=axes[0, -1], label="vertical velocity / U_c")
    figure.savefig(HERE / "sedimentation.png", dpi=110)


if __name__ == "__main__":
    main()
