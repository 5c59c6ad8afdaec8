#!/usr/bin/env python3
"""What holds each loop back: arithmetic, bandwidth or latency; a Markdown table, on one core.

Per loop: time of a step; instructions, and bytes that come from beyond the first and the second cache, by valgrind's
simulation of caches of this machine's sizes (difference of two numbers of steps); how much longer a step takes while a
second copy runs on the other core, which shares what lies beyond the second cache. Beside it what one core can do, by
limits.rs: cycles, streaming, loads that wait for each other.

    scaling/limits.py --peers DIR --folder DIR    # state DIR/state/b14.csv.gz, b100.csv.gz; valgrind, rustc, lscpu
"""

import argparse
import os
import re
import shutil
import statistics
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import bench_fluid
from bench_shapes import SHAPES, settle
from bench_spheres import make_bed
from benchmark import BINARY, ENVIRONMENT, ROOT, machine, run, table

LINE = 64  # bytes of a cache line
SETTLING = ROOT / "cases/sedimentation-3d/spheres.toml"


@dataclass
class Loop:
    """A case whose step is looked at, and how many steps of the particles are timed and simulated."""

    folder: Path
    case: str
    steps: int
    of_fluid: bool = False  # looked at per cell and step of the fluid, else per particle and step
    options: tuple = ("--warm", "100")

    def command(self, binary, steps, segments):
        """The command of a benchmark of so many steps."""
        return [str(x) for x in [binary, "bench", self.case, *self.options, "--steps", steps, "--segments", segments]]

    def segments(self, output, steps):
        """Nanoseconds per unit and step, and units times steps, of the segments of so many steps in the output of a benchmark."""
        if self.of_fluid:
            found = re.findall(r"^fluid_ns_per_cell_step (\S+) exchange (\S+) cells (\d+) steps (\d+)", output, re.M)
            read = [(float(flow) + float(exchange), int(cells) * int(n)) for flow, exchange, cells, n in found]
        else:
            found = re.findall(r"^us_per_particle_step\s+(\S+) particles (\d+)", output, re.M)
            read = [(1e3 * float(time), int(particles) * steps) for time, particles in found]
        if not read:
            raise SystemExit(f"no timing in the output:\n{output[-2000:]}")
        return read


def spheres(options, folder, thousands, tiles, steps):
    """Settled spheres, in tiles of a peer's state."""
    make_bed(thousands, options.peers / f"state/b{thousands}.csv.gz", tiles, folder)
    return Loop(folder, f"{thousands}.toml", steps)


def bodies(options, folder, shape):
    """A settled bed of a shape."""
    bed = settle(shape, folder, options.binary, 1, options.timeout)
    return Loop(bed, "bed.toml", 60, options=("--restart", "latest", "--warm", "100"))


def cavity(_, folder, method):
    """A fluid alone."""
    case = f"cavity-{method}.toml"
    (folder / case).write_text(bench_fluid.CASE.format(cells=64, length_cells=64, length=1, dt=0.25 / 64, method=method))
    return Loop(folder, case, 4, of_fluid=True, options=("--warm", "3"))


def settling(_, folder):
    """125 spheres that settle, resolved with ten cells across each."""
    text = SETTLING.read_text()
    for old, new in (("[14, 14,", "[4, 4,"), ("[140, 140,", "[40, 40,"), ("13.5, 13.5", "3.5, 3.5"), ("count = 1528", "count = 125")):
        text = text.replace(old, new)
    (folder / "resolved.toml").write_text(text)
    return Loop(folder, "resolved.toml", 60, of_fluid=True, options=("--warm", "300"))


# The loops of the table in README.md, and what prepares each.
LOOPS = {
    "14,000 spheres": lambda options, folder: spheres(options, folder, "14", 1, 100),
    "100,000 spheres": lambda options, folder: spheres(options, folder, "100", 2, 20),
    **{shape: lambda options, folder, shape=shape: bodies(options, folder, shape) for shape in SHAPES},
    "fluid, 64³, transforms": lambda options, folder: cavity(options, folder, "fast"),
    "fluid, 64³, multigrid": lambda options, folder: cavity(options, folder, "conjugate_gradients"),
    "fluid and 125 resolved spheres": settling,
}


def simulated(loop, options):
    """Instructions, and lines from beyond the first and the second cache, per unit and step; by valgrind."""
    sizes = dict(re.findall(r"^LEVEL(1_D|2)_?CACHE_SIZE +(\d+)$", run(["getconf", "-a"], 60), re.M))
    first, second = sizes["1_D"], sizes["2"]
    totals = []
    for steps in (loop.steps, 2 * loop.steps):
        out = loop.folder / "cachegrind.out"
        # A program that asks for huge pages begins anew, which valgrind does not follow.
        tool = ["env", "GLIBC_TUNABLES=glibc.malloc.hugetlb=0", "valgrind", "--tool=cachegrind", "--cache-sim=yes", f"--cachegrind-out-file={out}",
                f"--D1={first},8,{LINE}", f"--I1={first},8,{LINE}", f"--LL={second},8,{LINE}"]
        output = run(tool + loop.command(options.binary, steps, 1), options.timeout, loop.folder)
        (_, work), = loop.segments(output, steps)
        names, values = (re.search(rf"^{key}: (.*)$", out.read_text(), re.M)[1].split() for key in ("events", "summary"))
        totals.append({"work": work, **dict(zip(names, map(int, values)))})
    less, more = totals
    rate = lambda *names: sum(more[name] - less[name] for name in names) / (more["work"] - less["work"])
    return rate("Ir"), rate("D1mr", "D1mw"), rate("DLmr", "DLmw")


def timed(loop, options, copies):
    """Nanoseconds per unit and step of copies that run at once, each on a core of its own."""
    cores = sorted(os.sched_getaffinity(0))[:copies]
    steps = options.longer * loop.steps
    command = loop.command(options.binary, steps, 5)
    start = lambda core: subprocess.Popen(["taskset", "-c", str(core), *command], cwd=loop.folder, env=os.environ | ENVIRONMENT,
                                          text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    running = [start(core) for core in cores]
    outputs = [copy.communicate(timeout=options.timeout)[0] for copy in running]
    return [time for output in outputs for time, _ in loop.segments(output, steps)]


def abilities(folder):
    """What one core can do, by name."""
    run(["rustc", "-O", "-o", folder / "limits", Path(__file__).with_suffix(".rs")], 300)
    return {name: float(value) for name, value in map(str.split, run([folder / "limits"], 300).splitlines())}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--peers", type=Path, help="folder with state/b14.csv.gz and state/b100.csv.gz")
    parser.add_argument("--binary", type=Path, default=BINARY, help="grains-mpi program")
    parser.add_argument("--folder", type=Path, help="where beds that have settled are kept for the next time")
    parser.add_argument("--longer", type=int, default=10, help="times as many steps timed as simulated")
    parser.add_argument("--only", nargs="*", default=[], help="loops whose names contain one of these")
    parser.add_argument("--timeout", type=float, default=7200, help="longest time of one run (s)")
    options = parser.parse_args()
    for program in ("valgrind", "rustc", "taskset"):
        if not shutil.which(program):
            parser.error(f"{program} is not there")
    options.binary = options.binary.resolve()
    with tempfile.TemporaryDirectory() as temporary:
        folder = (options.folder or Path(temporary)).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        before, core = machine(), abilities(folder)
        print(f"{before}. One core: {core['gigahertz']:.2f} cycles/ns; by level of memory, streaming (GB/s) and a load that waits (ns): "
              + ", ".join(f"{level} {core[f'stream_{level}']:.0f}, {core[f'latency_{level}']:.1f}"
                          for level in ("first", "second", "third", "memory")) + ".\n")
        rows = []
        for name, prepare in LOOPS.items():
            if options.only and not any(part in name for part in options.only) or not options.peers and "000 spheres" in name:
                continue
            loop = prepare(options, folder)
            alone, beside = (statistics.median(timed(loop, options, copies)) for copies in (1, 2))
            instructions, beyond_first, beyond_second = simulated(loop, options)
            cycles = alone * core["gigahertz"]
            rows.append([name, "cell" if loop.of_fluid else "particle", f"{alone:.1f}", f"{instructions:.0f}",
                         f"{instructions / cycles:.2f}", f"{LINE * beyond_first:.0f}", f"{LINE * beyond_second:.0f}",
                         f"{100 * LINE * beyond_second / alone / core['stream_third']:.0f} %",
                         f"{100 * LINE * beyond_second / alone / core['stream_memory']:.0f} %", f"{beside / alone:.2f}"])
    header = ["loop", "per", "ns", "instructions", "per cycle", "bytes beyond the first cache", "beyond the second",
              "of the third's bandwidth", "of the memory's", "beside a second copy"]
    print(table(header, rows))


if __name__ == "__main__":
    main()
