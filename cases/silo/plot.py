#!/usr/bin/env python3
"""Discharge of the silo: time, steady rate, and a picture of both beside the experiment."""

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from silo import arguments, read_series, read_silo, time_when_passed

# González-Montellano et al. (2011), mean of three experiments.
EXPERIMENT_BEADS = 14000
EXPERIMENT_TIME = 29.27  # s
EXPERIMENT_RATE = EXPERIMENT_BEADS / EXPERIMENT_TIME  # beads/s

# The rate counts as steady between these shares of the discharge.
STEADY = (0.2, 0.8)


def steady_rate(series, beads):
    """Slope of the straight line through the beads passed (beads/s) while the flow is steady, or None."""
    middle = series[series.passed.between(STEADY[0] * beads, STEADY[1] * beads)]
    if len(middle) < 3:
        return None
    return float(np.polyfit(middle.time, middle.passed, 1)[0])


def mass_flow(series, width):
    """Mass flow (kg/s) over windows of `width` (s), and the middles of the windows (s)."""
    edges = np.arange(series.time.iloc[0], series.time.iloc[-1], width)
    passed = np.interp(edges, series.time, series.mass)
    return 0.5 * (edges[1:] + edges[:-1]), np.diff(passed) / width


def compare(name, value, reference, unit):
    return f"{name:<22} {value:8.2f} {unit:<8} experiment {reference:.2f} ({100 * (value / reference - 1):+.1f} %)"


def report(silo, series):
    """Prints the figures; the time of the experiment holds for its number of beads only."""
    is_full = silo.beads == EXPERIMENT_BEADS
    emptied = time_when_passed(series, silo.beads)
    if emptied is None:
        passed, time = int(series.passed.iloc[-1]), series.time.iloc[-1]
        print(f"not empty yet: {passed} of {silo.beads} beads by t = {time:g} s")
    elif is_full:
        print(compare("discharge time", emptied - silo.removal, EXPERIMENT_TIME, "s"))
    else:
        print(f"{'discharge time':<22} {emptied - silo.removal:8.2f} s")
    rate = steady_rate(series, silo.beads)
    if rate is not None:
        print(compare("steady rate", rate, EXPERIMENT_RATE, "beads/s"))


def draw(silo, series, path):
    time = series.time - silo.removal
    bead = series.mass.iloc[-1] / max(series.passed.iloc[-1], 1)
    figure, (flow, total) = plt.subplots(2, 1, sharex=True, figsize=(7, 6.5), layout="constrained")

    since = series[time >= 0].assign(time=time[time >= 0])
    mean = EXPERIMENT_RATE * bead
    highest = mean
    if len(since) > 1:
        width = max(since.time.iloc[-1] / 60, 0.05)
        middles, rates = mass_flow(since, width)
        flow.plot(middles, rates, label=f"grains-mpi, means over {width:.2g} s")
        highest = max(mean, rates.max(initial=0.0))
    flow.axhline(mean, color="C3", ls="--", label=f"experiment, mean: {EXPERIMENT_RATE:.0f} beads/s")
    flow.set(ylabel="mass flow (kg/s)", ylim=(0, 1.15 * highest))
    flow.legend(loc="lower center")

    total.plot(since.time, since.passed, label="grains-mpi")
    if silo.beads == EXPERIMENT_BEADS:
        total.axvline(EXPERIMENT_TIME, color="C3", ls="--", label=f"experiment: empty after {EXPERIMENT_TIME} s")
    total.axhline(silo.beads, color="0.7", lw=1, label=f"{silo.beads} beads")
    total.set(xlabel="time since the plate was removed (s)", ylabel="beads discharged", ylim=(0, None))
    total.legend(loc="lower right")
    figure.savefig(path, dpi=150)
    print(f"picture in {path}")


def main():
    options = arguments(__doc__, "discharge.png").parse_args()
    silo = read_silo(options.case, options.results)
    series = read_series(silo)
    report(silo, series)
    draw(silo, series, options.output or silo.results / "discharge.png")


if __name__ == "__main__":
    main()
