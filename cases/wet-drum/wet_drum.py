"""A drum with dry and with wet beads: `python cases/wet-drum/wet_drum.py [--tensions 0 0.0364 ...]` with the Python that
scripts/python-environment prints. Turns the drum at each surface tension (N/m), goes on where it was stopped, prints the
table of what there is, and draws it into angles.png. With --ends the dry drum with ends."""
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

BEAD, DENSITY = 2.975e-3, 1768
BRIDGE = 'attraction = { kind = "liquid_bridge", volume = 2.6e-10, surface_tension = 0.0728 }\n'
# Time from which means are taken (s), and into how many parts it is cut for their errors.
FROM, BLOCKS = 1.2, 5


def folder(tension):
    return sweep.RESULTS / "wet-drum" / ("ends" if tension is None else f"{tension:g}")


def case(tension):
    """The case with bridges of a surface tension (N/m); none of zero; the drum with ends of None."""
    if tension is None:
        text = (HERE / "ends.toml").read_text()
        changes = [("results/wet-drum/ends", f"{folder(tension) / 'run'}")]
    else:
        text = (HERE / "drum.toml").read_text()
        bridge = BRIDGE.replace("0.0728", f"{tension}") if tension else ""
        changes = [(BRIDGE, bridge), ("results/wet-drum/0.0728", f"{folder(tension) / 'run'}")]
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    return text


def bond(tension):
    """Pull of a bridge between touching beads over the weight of a bead: Willett's fit at V/R³ = 0.00987 and contact."""
    return 0.8719 * 2 * np.pi * BEAD * tension / (DENSITY * 4 / 3 * np.pi * BEAD**3 * 9.81)


def states(run):
    """Time (s), centres (m) and velocities (m/s) of every stored state from FROM on."""
    with h5py.File(run / "particles.vtkhdf") as file:
        group = file["VTKHDF"]
        times, offsets = group["Steps/Values"][:], group["Steps/PointOffsets"][:]
        ends = np.append(offsets[1:], len(group["Points"]))
        for time, first, end in zip(times, offsets, ends):
            if time >= FROM:
                yield time, group["Points"][first:end], group["PointData/velocity"][first:end]


def surface(places, radius, highest):
    """Mean height of the highest beads at up to eight places across a drum of a radius (m), where there are so many."""
    x, _, z = places.T
    columns = [(at, z[abs(x - at) < 3e-3]) for at in np.linspace(-radius / 2, radius / 2, 8)]
    return zip(*[(at, np.sort(column)[-highest:].mean()) for at, column in columns if len(column) >= highest])


def angle_and_speed(places, velocity, radius, highest):
    """Angle of the surface (degrees), and mean speed of the beads on its middle (m/s)."""
    slope, middle = np.polyfit(*map(np.array, surface(places, radius, highest)), 1)
    x, _, z = places.T
    top = (abs(x) < radius / 5) & (z > middle + slope * x - 1.5 * BEAD)
    return np.degrees(np.arctan(-slope)), np.linalg.norm(velocity[top], axis=1).mean()


def measured(tension):
    """Means of angle (degrees) and speed (m/s), their standard errors from parts of the time, and how they vary."""
    if tension is None:
        # As in the calibration: the ten highest of 22.5 mm at either end.
        seen, drum = lambda p: abs(p[:, 1] - 0.0925) > 0.07, (0.069, 10)
    else:
        seen, drum = lambda p: slice(None), (0.045, 4)
    rows = [angle_and_speed(p[seen(p)], v[seen(p)], *drum) for _, p, v in states(folder(tension) / "run")]
    parts = np.array([part.mean(axis=0) for part in np.array_split(np.array(rows), BLOCKS)])
    return np.mean(rows, axis=0), parts.std(axis=0, ddof=1) / BLOCKS**0.5, np.std(rows, axis=0)


def draw(found):
    """Angle and speed of the surface over the Bond number."""
    bonds, angle, error, speed, speed_error = found[np.argsort(found[:, 0])].T
    figure, left = plt.subplots(figsize=(6, 3.5))
    left.errorbar(bonds, angle, error, fmt="o-", capsize=3)
    left.set(xlabel="Bond number", ylabel="angle of the surface (degrees)")
    right = left.twinx()
    right.errorbar(bonds, speed, speed_error, fmt="s--", color="C1", capsize=3)
    right.set_ylabel("speed of the surface (m/s)", color="C1")
    figure.tight_layout()
    figure.savefig(HERE / "angles.png", dpi=100)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tensions", nargs="+", type=float, default=[0, 0.0182, 0.0364, 0.0728])
    parser.add_argument("--ends", action="store_true", help="the dry drum with ends instead")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--no-runs", action="store_true", help="the table of what there is")
    options = parser.parse_args()
    tensions = [None] if options.ends else options.tensions
    if not options.no_runs:
        sweep.run_all([(case(tension), folder(tension)) for tension in tensions], options.jobs)
    print(f"{'tension':>7} {'Bond':>5} {'angle':>6} {'error':>6} {'varies':>6} {'fit':>6} {'speed':>6} {'error':>6}")
    found = []
    for tension in tensions:
        if (folder(tension) / "done").exists():
            (angle, speed), (error, speed_error), (varies, _) = measured(tension)
            fit = sweep.analyse("drum", folder(tension), "--time", f"{FROM}:99")
            fit = sum(float(row["angle"]) for row in fit) / len(fit)
            number = bond(tension or 0)
            print(f"{tension or 0:>7.4f} {number:>5.2f} {angle:>6.1f} {error:>6.2f} {varies:>6.1f} {fit:>6.1f} {speed:>6.3f} {speed_error:>6.4f}")
            found.append((number, angle, error, speed, speed_error))
    if found and not options.ends:
        draw(np.array(found))


if __name__ == "__main__":
    main()
