"""Picture of the errors of all contact laws: `python3 cases/laws/errors.py [OUT.png]` runs `grains-mpi verify`."""
import os
import re
import subprocess
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

# What is exact in double precision is drawn here.
FLOOR = 1e-16


def main():
    out = sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent / "errors.png"
    text = subprocess.run([os.environ.get("GRAINS_MPI", "grains-mpi"), "verify"], check=True, capture_output=True, text=True).stdout
    # Law and quantity stand two spaces or more apart; unit, found, exact, error and allowed are the last words.
    lines = [line for line in text.splitlines()[1:] if re.match(r"\S.*(\s+\S*\de[-+]?\d+){2}$", line)]
    rows = [(re.split(r" {2,}", line)[0], *map(float, line.split()[-2:])) for line in lines]
    laws = list(dict.fromkeys(row[0] for row in rows))
    figure, axes = plt.subplots(figsize=(7, 5.2), layout="constrained")
    places = [-laws.index(row[0]) for row in rows]
    axes.plot([max(row[1], FLOOR) for row in rows], places, "o", color="#0072B2", ms=4, alpha=0.7)
    axes.plot([row[2] for row in rows], places, "|", color="#D55E00", ms=9)
    axes.set(xscale="log", xlabel=f"relative error (dots, {FLOOR:g} at least) and what is allowed (bars)")
    axes.set_yticks([-k for k in range(len(laws))], laws)
    axes.grid(axis="x", alpha=0.3)
    figure.savefig(out, dpi=110)
    print(f"{len(rows)} rows, {len(laws)} laws: {out}")


if __name__ == "__main__":
    main()
