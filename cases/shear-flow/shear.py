"""Stress and temperature of sheared spheres beside kinetic theory: `python3 cases/shear-flow/shear.py [RESULTS]` reads
series.csv of `scripts/run cases/shear-flow/shear.toml`, prints the table, and draws the approach to the steady state."""
import argparse
import math
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import pandas as pd

DIAMETER, DENSITY, RATE = 1e-3, 2500, 10
# Garzó and Dufty (1999) to Navier-Stokes order, with the steady temperature of the balance of energy.
THEORY = {"T / (γ d)²": 1.236, "P / ρ (γ d)²": 1.419, "τ / ρ (γ d)²": 0.393}


def reduced(series):
    """The three figures at all times."""
    unit = (RATE * DIAMETER) ** 2
    pressure = (series.stress_xx + series.stress_yy + series.stress_zz) / 3
    columns = [series.granular_temperature / unit, pressure / (DENSITY * unit), -series.stress_xz / (DENSITY * unit)]
    return pd.DataFrame(dict(zip(THEORY, columns)))


def error_of_mean(values, blocks=10):
    """Standard error by block means."""
    length = len(values) // blocks
    means = [values[k * length : (k + 1) * length].mean() for k in range(blocks)]
    return pd.Series(means).std() / math.sqrt(blocks)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results", nargs="?", default="results", type=Path)
    parser.add_argument("--from-strain", type=float, default=10, help="strain from which means are taken")
    arguments = parser.parse_args()
    series = pd.read_csv(arguments.results / "series.csv", comment="#")
    strain, values = RATE * series.time, reduced(series)
    steady = values[strain > arguments.from_strain]
    for name, expected in THEORY.items():
        mean, error = steady[name].mean(), error_of_mean(steady[name].to_numpy())
        print(f"{name:14} {mean:.3f} ± {error:.3f}, theory {expected} ({100 * (mean / expected - 1):+.1f} %)")
    figure, axes = plt.subplots(figsize=(6, 3.5))
    for k, (name, expected) in enumerate(THEORY.items()):
        axes.plot(strain, values[name], color=f"C{k}", label=name)
        axes.axhline(expected, color=f"C{k}", linestyle="--")
    axes.set(xlabel="strain γ t", ylim=(0, 2))
    axes.legend()
    figure.tight_layout()
    figure.savefig(Path(__file__).parent / "stress.png", dpi=100)


if __name__ == "__main__":
    main()
