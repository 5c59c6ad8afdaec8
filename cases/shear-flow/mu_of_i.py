"""Friction of a dense flow over its inertial number, μ(I): `python3 cases/shear-flow/mu_of_i.py [--fractions 0.5 ...]` shears
random packings of rough spheres at several solid fractions, prints the table, and draws it into mu_of_i.png.

At a given solid fraction stress grows with the square of the rate: the fraction sets the inertial number I = γ d √(ρ/P)."""
import argparse
import math
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))
import sweep

DIAMETER, DENSITY, RATE, COUNT = 1e-3, 2500, 10, 600
# Strain from which means are taken, and at the end.
STEADY, END = 5, 15
# Jop, Forterre and Pouliquen (2006), glass beads: static and limiting friction, inertial number between.
GLASS = 0.38, 0.64, 0.28


def packing(edge, seed=1):
    """Centres of spheres that do not overlap in a periodic box, by moving apart what overlaps."""
    random = np.random.default_rng(seed)
    places = random.uniform(0, edge, (COUNT, 3))
    for step in range(20000):
        between = places[:, None] - places[None]
        between -= edge * np.round(between / edge)
        distance = np.linalg.norm(between, axis=2) + DIAMETER * np.eye(COUNT)
        overlap = np.maximum(1.0005 * DIAMETER - distance, 0) * (1 - np.eye(COUNT))
        if overlap.max() < 4e-4 * DIAMETER:
            return places % edge
        places += 0.4 * (between * (overlap / distance)[:, :, None]).sum(axis=1)
    raise RuntimeError("too dense to pack like this")


def case(fraction, folder):
    """Text of a case, whose particles are in a file beside it."""
    edge = (COUNT * math.pi / 6 * DIAMETER**3 / fraction) ** (1 / 3)
    folder.mkdir(parents=True, exist_ok=True)
    table = folder / "packing.csv"
    if not table.exists():
        pd.DataFrame(packing(edge), columns=["x", "y", "z"]).to_csv(table, index=False)
    text = (HERE / "shear.toml").read_text()
    corner = f"{edge:.9g}"
    start = text.index("place = ")
    text = text[:start] + f'place = {{ kind = "file", path = "{table}" }}\n' + text[text.index("\n", start) + 1 :]
    changes = [("0.012039, 0.012039, 0.012039", f"{corner}, {corner}, {corner}"), ("friction = 0", "friction = 0.5")]
    changes += [("restitution = 0.9", "restitution = 0.7"), ("count = 1000\n", ""), ("end = 3", f"end = {END / RATE}")]
    changes += [('directory = "results"', f'directory = "{folder / "run"}"'), ("checkpoint = 1", "checkpoint = 0.5")]
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    return text


def measured(folder):
    """Inertial number, friction, pressure over that of unit inertial number, and ratio of normal stresses."""
    series = pd.read_csv(folder / "run/series.csv", comment="#")
    steady = series[RATE * series.time > STEADY].mean()
    pressure = (steady.stress_xx + steady.stress_yy + steady.stress_zz) / 3
    inertial = RATE * DIAMETER * math.sqrt(DENSITY / pressure)
    return inertial, -steady.stress_xz / pressure


def law(inertial):
    static, limit, between = GLASS
    return static + (limit - static) / (1 + between / inertial)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fractions", nargs="*", type=float, default=[0.5, 0.53, 0.55, 0.56, 0.57, 0.58])
    parser.add_argument("--jobs", type=int, default=2)
    arguments = parser.parse_args()
    folders = {fraction: sweep.RESULTS / f"mu_of_i/{fraction}" for fraction in arguments.fractions}
    sweep.run_all([(case(fraction, folder), folder) for fraction, folder in folders.items()], arguments.jobs)
    found = {fraction: measured(folder) for fraction, folder in folders.items()}
    for fraction, (inertial, friction) in found.items():
        print(f"{fraction:.3f}: I {inertial:.4f}, μ {friction:.3f}; glass beads {law(inertial):.3f}")
    figure, axes = plt.subplots(figsize=(6, 3.5))
    inertial, friction = zip(*sorted(found.values()))
    axes.semilogx(inertial, friction, "o-", label="here")
    line = np.geomspace(0.5 * inertial[0], 2 * inertial[-1], 50)
    axes.semilogx(line, law(line), "--", label="glass beads, Jop et al. 2006")
    axes.set(xlabel="inertial number I", ylabel="friction μ = τ/P")
    axes.legend()
    figure.tight_layout()
    figure.savefig(HERE / "mu_of_i.png", dpi=100)


if __name__ == "__main__":
    main()
