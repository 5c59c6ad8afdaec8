#!/usr/bin/env python3
"""A fluid alone: nanoseconds per cell and step, and iterations, as Markdown tables.

The lid-driven cavity at Reynolds 100 and a Courant number of 0.25 in N x N x N cells, the pressure by each method of
the program, beside OpenFOAM's icoFoam (two pressure solves per step, to 1e-6 relative), in turns. Then weak scaling:
cavities that are stretched along x with the number of ranks.

    scaling/bench_fluid.py --peers DIR          # script DIR/openfoam/make_case.py; blockMesh, icoFoam
    scaling/bench_fluid.py --cells 32 64 128 --methods fast conjugate_gradients petsc
"""

import argparse
import os
import re
import shutil
import statistics
import sys
import tempfile
from pathlib import Path

from benchmark import BINARY, machine, mpi, run, spread, table

CASE = """\
name = "cavity"
gravity = [0, 0, 0]

[domain]
lower = [0, 0, 0]
upper = [{length}, 1, 1]

[time]
end = 1000
dt = {dt}

[fluid]
density = 1
viscosity = 0.01
cells = [{length_cells}, {cells}, {cells}]
pressure = {{ method = "{method}", tolerance = 1e-6 }}

[[fluid.boundary]]
face = "+z"
kind = "wall"
velocity = [1, 0, 0]
"""


def own(options, folder, cells, method, ranks, length=1):
    """Nanoseconds per cell and step of each segment, and iterations per step."""
    case = folder / "cavity.toml"
    case.write_text(CASE.format(cells=cells, length_cells=length * cells, length=length, dt=0.25 / cells, method=method))
    steps = max(5, int(options.work / cells**3))
    command = [options.binary, "bench", case, "--warm", 3, "--steps", steps, "--segments", 3]
    output = run(mpi(ranks, command), options.timeout)
    rows = re.findall(r"^fluid_ns_per_cell_step (\S+) .* iterations (\d+)$", output, re.M)
    if not rows:
        raise SystemExit(f"no timing in the output:\n{output[-2000:]}")
    return [float(time) for time, _ in rows], int(rows[-1][1]) / steps


def peer(options, folder, cells):
    """Nanoseconds per cell and step of icoFoam, of the steps after the first two."""
    home, steps = folder / f"openfoam-{cells}", max(5, int(options.work / 10 / cells**3))
    if not home.exists():
        run([sys.executable, options.peers / "openfoam/make_case.py", home, cells, steps], options.timeout)
        run(["blockMesh", "-case", home], options.timeout)
    output = run(["icoFoam", "-case", home], options.timeout)
    times = [float(time) for time in re.findall(r"^ExecutionTime = (\S+) s", output, re.M)]
    return 1e9 * (times[-1] - times[1]) / (len(times) - 2) / cells**3


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peers", type=Path, help="folder with openfoam/make_case.py")
    parser.add_argument("--binary", type=Path, default=BINARY, help="grains-mpi program")
    parser.add_argument("--cells", type=int, nargs="+", default=[32, 64, 128], help="cells along an edge")
    parser.add_argument("--methods", nargs="+", default=["fast", "conjugate_gradients", "petsc"])
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--rounds", type=int, default=2, help="times that program and peer take turns")
    parser.add_argument("--work", type=float, default=2e7, help="cells times steps of a segment")
    parser.add_argument("--timeout", type=float, default=600, help="longest time of one run (s)")
    options = parser.parse_args()
    # Where Debian keeps what OpenFOAM asks for.
    os.environ.setdefault("WM_PROJECT_DIR", "/usr/share/openfoam")
    beside = options.peers and shutil.which("icoFoam")
    if not beside:
        print("no peer measured: icoFoam or its script is missing", file=sys.stderr)
    before, rows, weak = machine(), [], []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for cells in options.cells:
            points = [(method, ranks) for method in options.methods for ranks in options.ranks]
            found, others = {point: ([], 0) for point in points}, []
            for _ in range(options.rounds):
                for method, ranks in points:
                    times, iterations = own(options, folder, cells, method, ranks)
                    found[method, ranks] = (found[method, ranks][0] + times, iterations)
                if beside:
                    others.append(peer(options, folder, cells))
            for (method, ranks), (times, iterations) in found.items():
                ratio = f"{statistics.median(others) / statistics.median(times):.1f}" if others else "-"
                rows.append([f"{cells}³", method, ranks, spread(times, 1), f"{iterations:.1f}", ratio])
            if others:
                rows.append([f"{cells}³", "icoFoam", 1, spread(others, 1), "-", "1"])
        cells = sorted(options.cells)[len(options.cells) // 2]
        for method in options.methods:
            base = None
            for ranks in options.ranks:
                times, iterations = own(options, folder, cells, method, ranks, length=ranks)
                per_rank = ranks * statistics.median(times)
                base = base or per_rank
                weak.append([f"{ranks * cells} x {cells} x {cells}", method, ranks, spread([ranks * t for t in times], 1),
                             f"{iterations:.1f}", f"{base / per_rank:.2f}"])
    print(f"{before}. Nanoseconds per cell and step: median (least–largest).\n")
    print(table(["cells", "pressure", "ranks", "time", "iterations", "icoFoam / grains-mpi"], rows))
    print("\nWeak scaling, nanoseconds per step and cell of one rank.\n")
    print(table(["cells", "pressure", "ranks", "time", "iterations", "efficiency"], weak))


if __name__ == "__main__":
    main()
