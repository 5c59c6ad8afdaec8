"""Picture of a plane through the fluid of runs, one panel each: `python cases/slice.py OUT.png RUN[@TIME][=LABEL] ... [--field F]`,
with the Python that scripts/python-environment prints. A RUN is an output directory; the last state, if no time (s) is given. The
plane cuts the axis of `--normal` in the middle of the domain, or at `--at` (m). `--field speed` colours by the magnitude of the
velocity, `--field vorticity` by its curl along the normal. All panels have one scale."""
import argparse
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np


def plane(run, time, field, axis, at):
    """Nodes of the two axes of the plane (m), values of its cells, the time (s), and the names of the axes and the unit."""
    with h5py.File(run / "fluid.vtkhdf") as file:
        group = file["VTKHDF"]
        times = group["Steps/Values"][:]
        step = len(times) - 1 if time is None else np.abs(times - time).argmin()
        nodes = [file["grid"][name][:] for name in "xyz"]
        centres = (nodes[axis][1:] + nodes[axis][:-1]) / 2
        place = np.abs(centres - (nodes[axis].mean() if at is None else at)).argmin()
        # Cells z, y, x.
        cut = [step, slice(None), slice(None), slice(None)]
        cut[3 - axis] = place
        stored = group["CellData"]["velocity" if field in ("speed", "vorticity") else field]
        cells, unit = stored[tuple(cut)], stored.attrs["unit"]
        axes = [a for a in range(3) if a != axis]
    if field == "speed":
        cells = np.linalg.norm(cells, axis=-1)
    elif field == "vorticity":
        first, second = axes
        middle = [(nodes[a][1:] + nodes[a][:-1]) / 2 for a in axes]
        unit = "1/s"
        sign = -1 if axis == 1 else 1
        cells = sign * (np.gradient(cells[..., second], middle[0], axis=1) - np.gradient(cells[..., first], middle[1], axis=0))
    return [nodes[a] for a in axes], cells, float(times[step]), ["xyz"[a] for a in axes], unit


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("run", nargs="+", help="RUN[@TIME][=LABEL]")
    parser.add_argument("--field", default="speed")
    parser.add_argument("--normal", default="y", choices="xyz")
    parser.add_argument("--at", type=float, help="place of the plane (m)")
    parser.add_argument("--window", help="LOW,HIGH of the horizontal and LOW,HIGH of the vertical axis (m)")
    parser.add_argument("--range", help="LOW,HIGH of the colours")
    parser.add_argument("--log", action="store_true", help="colours by the logarithm")
    parser.add_argument("--columns", type=int, default=1)
    parser.add_argument("--width", type=float, default=8, help="inches of the picture")
    parser.add_argument("--solid", default="void_fraction", help="a field that is 0 in bodies, which are left grey")
    options = parser.parse_args()
    axis = "xyz".index(options.normal)
    shown = []
    for text in options.run:
        text, _, label = text.partition("=")
        run, _, time = text.partition("@")
        time = float(time) if time else None
        nodes, cells, at, names, unit = plane(Path(run), time, options.field, axis, options.at)
        try:
            _, solid, *_ = plane(Path(run), time, options.solid, axis, options.at)
            cells = np.where(solid < 0.5, np.nan, cells)
        except KeyError:
            pass
        shown.append((nodes, cells, label or f"t = {at:.3g} s", names))
    if options.range:
        low, high = (float(x) for x in options.range.split(","))
    else:
        low, high = np.nanquantile(np.concatenate([cells.ravel() for _, cells, *_ in shown]), [0.005, 0.995])
    if options.field == "vorticity" and not options.range:
        low, high = -max(-low, high), max(-low, high)
    columns = min(options.columns, len(shown))
    rows = -(-len(shown) // columns)
    nodes = shown[0][0]
    ends = [float(x) for x in options.window.split(",")] if options.window else [f(n) for n in nodes for f in (np.min, np.max)]
    ratio = (ends[3] - ends[2]) / (ends[1] - ends[0])
    norm = matplotlib.colors.LogNorm(low, high) if options.log else matplotlib.colors.Normalize(low, high)
    figure, axes = plt.subplots(
        rows, columns, squeeze=False, figsize=(options.width, rows * (options.width / columns * 0.85 * ratio + 0.55)), layout="constrained"
    )
    colours = plt.get_cmap("RdBu_r" if options.field == "vorticity" else "viridis").with_extremes(bad="0.6")
    for panel, (nodes, cells, label, names) in zip(axes.flat, shown):
        drawn = panel.pcolormesh(*nodes, cells, norm=norm, cmap=colours, rasterized=True)
        panel.set(aspect="equal", xlim=ends[:2], ylim=ends[2:], title=label, xlabel=f"{names[0]} (m)", ylabel=f"{names[1]} (m)")
    figure.colorbar(drawn, ax=axes, label=f"{options.field.replace('_', ' ')} ({unit})", shrink=0.8)
    figure.savefig(options.out, dpi=110)


if __name__ == "__main__":
    main()
