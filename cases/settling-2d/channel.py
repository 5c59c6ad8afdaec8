"""Disc, square and triangle in a plane channel four diameters wide, and a pair of discs (Wachs et al. 2009):
`python3 cases/settling-2d/channel.py [--shapes disc square triangle pair] [--across 32]` runs what is missing, prints speeds,
frequencies and turns, and draws paths and vorticity into channel.png."""
import argparse
import math
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

SIDE, EDGE = math.sqrt(math.pi / 4), math.sqrt(math.pi / math.sqrt(3))
SQUARE = f'kind = "box"\nedges = [{SIDE!r}, 1, {SIDE!r}]'
CORNERS = [(-EDGE / 2, -EDGE / math.sqrt(12)), (EDGE / 2, -EDGE / math.sqrt(12)), (0, EDGE / math.sqrt(3))]
TRIANGLE = f'kind = "hull"\nvertices = {[[x, y, z] for y in (-0.5, 0.5) for x, z in CORNERS]}'
DISC = 'kind = "cylinder"\nradius = 0.5\nheight = 1'
# Polygons are slower: by the second all fall at about the Reynolds number of the source.
VISCOSITY = {"disc": "1.8182e-3", "square": "1e-3", "triangle": "1e-3", "pair": "1.8182e-3"}


def case(shape, across, folder):
    """The channel with another body, on other cells."""
    text = (HERE / "channel.toml").read_text()
    text = text.replace("[128, 1, 1920]", str([4 * across, 1, 60 * across]))
    text = text.replace('"results/settling-2d/disc"', f'"{folder / "run"}"')
    text = text.replace("1.8182e-3", VISCOSITY[shape])
    if shape in ("square", "triangle"):
        text = text.replace(DISC, {"square": SQUARE, "triangle": TRIANGLE}[shape])
        # A little turned, as the disc is a little off the middle.
        text = text.replace("[0.70710678, 0.70710678, 0, 0]", "[0.99875, 0, 0.05, 0]")
    if shape == "pair":
        start = text.index("[[insert]]")
        below, end = text[start:].replace('"body"\npar', '"lower"\npar').replace("58]", "56]"), text.index("[[wall]]")
        text = text[:end] + below.replace("[0.05,", "[-0.05,")[: end - start + 1] + text[end:]
    return text


def track(run):
    """Times, places and turns about y of the bodies: arrays (states), (states, bodies, 3), (states, bodies)."""
    with h5py.File(run / "particles.vtkhdf") as file:
        group = file["VTKHDF"]
        steps = group["Steps"]
        times, starts = steps["Values"][:], steps["PointOffsets"][:]
        counts = group["NumberOfPoints"][:]
        points, spin = group["Points"][:], group["PointData/angular_velocity"][:]
        ids = group["PointData/id"][:]
        velocity = group["PointData/velocity"][:]
    order = [start + np.argsort(ids[start : start + n]) for start, n in zip(starts, counts)]
    order = np.array([o for o in order if len(o) == max(counts)])
    turned = np.concatenate([[np.zeros(max(counts))], np.cumsum(spin[order][1:, :, 1] * np.diff(times)[:, None], axis=0)])
    return times, points[order], velocity[order], turned


def vorticity(run, time):
    """∂u/∂z − ∂w/∂x in the cells at the state nearest to a time, its time and cell width."""
    with h5py.File(run / "fluid.vtkhdf") as file:
        group = file["VTKHDF"]
        times = group["Steps/Values"][:]
        step = np.abs(times - time).argmin()
        velocity = group["CellData/velocity"][step][:, 0]
        width = np.diff(file["grid/x"][:2])[0]
    return (np.gradient(velocity[..., 0], width, axis=0) - np.gradient(velocity[..., 2], width, axis=1)), times[step], width


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shapes", nargs="+", default=["disc", "square", "triangle", "pair"])
    parser.add_argument("--across", type=int, default=32, help="cells across the disc")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args()
    folder = lambda shape: sweep.RESULTS / "settling-2d" / f"{shape}-{options.across}"
    sweep.run_all([(case(s, options.across, folder(s)), folder(s)) for s in options.shapes], options.jobs)
    shown = [s for s in options.shapes if (folder(s) / "run/particles.vtkhdf").exists()]
    figure, axes = plt.subplots(2, len(shown), figsize=(2.6 * len(shown), 9), layout="constrained", squeeze=False)
    for k, shape in enumerate(shown):
        times, places, velocity, turned = track(folder(shape) / "run")
        falling = (places[:, :, 2].min(axis=1) > 2) & (times > 15)
        speed = -velocity[falling, :, 2].mean()
        sideways = velocity[falling, 0, 0]
        spectrum = np.abs(np.fft.rfft(sideways - sideways.mean()))
        frequency = np.fft.rfftfreq(len(sideways), np.diff(times).mean())[spectrum.argmax()]
        print(
            f"{shape}: mean speed {speed:.3f}, Reynolds number {speed / float(VISCOSITY[shape]):.0f}, swings sideways by"
            f" {sideways.std() * math.sqrt(2):.3f} U with frequency {frequency:.3f}, Strouhal number {frequency / speed:.3f},"
            f" turned by {np.degrees(np.ptp(turned[falling], axis=0)).max():.0f} degrees at most"
        )
        for body in range(places.shape[1]):
            axes[0, k].plot(places[:, body, 0], places[:, body, 2])
        axes[0, k].set(title=shape, xlim=(-2, 2), ylim=(0, 60), aspect="equal")
        height = places[falling].mean(axis=1)[:, 2]
        late = times[falling][np.abs(height - 12).argmin()]
        field, time, width = vorticity(folder(shape) / "run", late)
        middle = places[np.abs(times - time).argmin(), :, 2].mean()
        low = max(int((middle - 3) / width), 0)
        part = field[low : low + int(16 / width)]
        axes[1, k].imshow(part, origin="lower", cmap="RdBu", vmin=-4, vmax=4, extent=(-2, 2, low * width, low * width + 16))
        axes[1, k].set(title=f"t = {time:.1f}")
    figure.savefig(HERE / "channel.png", dpi=110)


if __name__ == "__main__":
    main()
