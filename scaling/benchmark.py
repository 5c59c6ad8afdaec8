"""What the benchmarks share: MPI runs with bounded time, timings in the output, tables."""

import os
import re
import shlex
import statistics
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
BINARY = TARGET / "release" / "grains-mpi"

# The grains of all benchmarks.
RADIUS = 1.5e-3  # m, of a sphere, or of the sphere of the same volume
DENSITY = 2500.0  # kg/m3
STIFFNESS = 1e5  # N/m
RESTITUTION = 0.75
FRICTION = 0.5
STIFFNESS_RATIO = 2 / 7  # tangential over normal
DAMPING_RATIO = 0.5  # tangential over normal
DT = 2.5e-6  # s

# Passages of their case files.
GLASS = f"""\
[[material]]
name = "glass"
density = {DENSITY}

[[contact]]
between = ["glass", "glass"]
normal_stiffness = {STIFFNESS}
restitution = {RESTITUTION}
friction = {FRICTION}
tangential = {{ kind = "spring", stiffness_ratio = {STIFFNESS_RATIO}, damping_ratio = {DAMPING_RATIO} }}
"""

FLOOR = """\
[[wall]]
name = "floor"
material = "glass"
kind = "plane"
point = [0, 0, 0]
normal = [0, 0, 1]
"""

ENVIRONMENT = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_btl_vader_single_copy_mechanism": "none",
    "OMP_NUM_THREADS": "1",
}


def mpi(ranks, command):
    """The command line of an MPI run; ranks are bound to cores, so more of them than cores is refused."""
    return ["mpirun", "-n", str(ranks), "--bind-to", "core", *map(str, command)]


def run(command, timeout, folder=None):
    """Runs a command, in a folder, and returns its output; ends the program if it fails or exceeds `timeout` (s)."""
    command = list(map(str, command))
    try:
        done = subprocess.run(
            command, cwd=folder, env=os.environ | ENVIRONMENT, timeout=timeout, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )
    except FileNotFoundError:
        raise SystemExit(f"{command[0]}: not found") from None
    except subprocess.TimeoutExpired:
        raise SystemExit(f"{shlex.join(command)}: not done after {timeout} s") from None
    if done.returncode != 0:
        raise SystemExit(f"{shlex.join(command)}: ended with {done.returncode}\n{done.stdout[-2000:]}")
    return done.stdout


def segments(output, steps):
    """Microseconds per particle and step of each timed segment in the output of grains-mpi or LAMMPS."""
    own = [float(value) for value in re.findall(r"^us_per_particle_step\s+(\S+)", output, re.M)]
    loops = re.findall(r"^Loop time of (\S+) on \d+ procs for (\d+) steps with (\d+) atoms", output, re.M)
    # Warm-up is a loop too, but of another length.
    peer = [1e6 * float(time) / steps / int(atoms) for time, count, atoms in loops if int(count) == steps]
    if not own + peer:
        raise SystemExit(f"no timing in the output:\n{output[-2000:]}")
    return own or peer


def bench(binary, case, ranks, warm, steps, timeout):
    """Segments of `grains-mpi bench`."""
    command = mpi(ranks, [binary, "bench", case, "--warm", warm, "--steps", steps])
    return segments(run(command, timeout), steps)


def spread(values, digits=4):
    """Median, and least and largest value, for a table."""
    middle, low, high = (f"{x:.{digits}f}" for x in (statistics.median(values), min(values), max(values)))
    return f"{middle} ({low}–{high})"


def table(header, rows):
    """A Markdown table."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines)


def machine():
    """Processor and number of cores, for the line above a table."""
    try:
        names = re.findall(r"^model name\s*: (.*)$", Path("/proc/cpuinfo").read_text(), re.M)
    except OSError:
        names = []
    cores = len(os.sched_getaffinity(0))
    return f"{names[0] if names else 'unknown processor'}, {cores} cores, load {os.getloadavg()[0]:.1f}"
