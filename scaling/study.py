"""What the scaling studies share: settling beds, timing them on many ranks, tables, CSV and pictures.

A study is a list of systems. A system is settled on a few ranks (its stages), copied to every number of ranks, and
timed by `grains-mpi bench`. Weak scaling gives the thesis's factor (Rakotonirina 2016, eq. 5.7)

    S(n) = T(1, N) / T(n, n N)

with T the time of a step, and strong scaling the speed-up T(1)/T(n); both in units of the least number of ranks that
was timed. The share of communication is what updates of clones and the agreement of ranks take of all phases of
rank 0, waiting included.
"""

import argparse
import csv
import os
import re
import statistics
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Callable

import slurm
from benchmark import BINARY, ROOT, machine, run, spread, table
from copies import Copies, write_copies

NUMBER = r"([-+\d.eE]+|inf|nan)"
COMMUNICATION = ("clone update", "agreement of ranks")
COUNTED = ("owned", "clones", "neighbours", "messages", "bytes", "wait_us", "memory_bytes")


@dataclass
class Stage:
    """A run that settles a bed."""

    name: str  # of its folder; stages of the same name are run once
    text: str  # of the case, which writes to the folder "settled" and may take particles from bed.h5
    copies: Copies | None = None  # of the stage before, in bed.h5


@dataclass
class System:
    """Some kind of particles, and how the source fared with them."""

    kind: str
    count: int  # particles per rank, or in all if scaling is strong
    case: Callable  # (count, ranks) -> text of the case to time, copies of the last stage in its bed.h5 or None
    stages: Callable = lambda count: []  # count -> list of Stage
    actual: Callable = lambda count: count  # what can be had of a number of particles
    source: dict = field(default_factory=dict)  # ranks -> S(n)
    source_time: str = "-"  # on one rank, microseconds per particle and step
    warm: int | None = None  # steps before timing, if not those of the study
    steps: int | None = None

    @property
    def label(self):
        return f"{self.count:,} {self.kind}"


@dataclass
class Study:
    """A study of the literature, or one of our own."""

    name: str
    title: str
    systems: list
    ranks: list  # of the source
    warm: int  # steps before timing
    steps: int  # in all segments
    published: list = field(default_factory=list)  # the source's tables: (caption, header, rows)
    is_strong: bool = False
    with_fluid: bool = False  # timed without the fluid, which is counted apart


@dataclass
class Found:
    """What `bench` printed."""

    times: list  # microseconds per particle and step, a value per segment
    particles: int
    phases: list  # per segment: name -> microseconds per particle and step of rank 0
    per_rank: dict  # name -> (mean, largest)
    contacts: float | None
    rebuilds: int  # of the lists, in the last segment
    clones: int  # that rank 0 brings up to date, periodic images of its own particles included

    def communication(self):
        """Share of communication in the phases of all segments (-)."""
        whole = sum(sum(phases.values()) for phases in self.phases)
        return sum(phases[name] for phases in self.phases for name in COMMUNICATION) / whole if whole else 0.0

    def imbalance(self):
        """Particles of the fullest rank over the mean (-)."""
        mean, most = self.per_rank.get("owned", (None, None))
        return most / mean if mean else None


def parse(output):
    """What `bench` printed, or None if it did not come to an end."""
    segments = re.findall(rf"^us_per_particle_step {NUMBER} particles {NUMBER} rebuilds (\d+) .*clones (\d+)", output, re.M)
    if not segments:
        return None
    lines = re.findall(r"^  neighbour lists .*", output, re.M)
    phases = [{name: float(us) for name, us in re.findall(rf"  ([a-z ]+?) {NUMBER}(?=  |$)", line)} for line in lines]
    ranks = re.findall(rf"^per_rank (\w+) mean {NUMBER} max {NUMBER}", output, re.M)
    contacts = re.search(rf"^contacts_per_particle {NUMBER}", output, re.M)
    return Found(
        times=[float(us) for us, *_ in segments],
        particles=int(float(segments[-1][1])),
        phases=phases,
        per_rank={name: (float(mean), float(most)) for name, mean, most in ranks},
        contacts=float(contacts[1]) if contacts else None,
        rebuilds=int(segments[-1][2]),
        clones=int(segments[-1][3]),
    )


def grid(ranks):
    """The most nearly square px x py = ranks, px >= py."""
    py = max(n for n in range(1, int(ranks**0.5) + 1) if ranks % n == 0)
    return ranks // py, py


def slug(label):
    """A label as the name of a folder."""
    return re.sub(r"[^a-z0-9]+", "-", label.lower().replace(",", "")).strip("-")


def launch(ranks, command, oversubscribe=False):
    """The command line of an MPI run on this machine."""
    place = ["--oversubscribe", "--bind-to", "none", "--mca", "mpi_yield_when_idle", "1"] if oversubscribe else ["--bind-to", "core"]
    return ["mpirun", "-n", str(ranks), *place, *map(str, command)]


def write_stage(stage, out):
    """Writes the case of a stage; returns its folder. A changed case has to settle again."""
    folder = out / "beds" / stage.name
    folder.mkdir(parents=True, exist_ok=True)
    case = folder / "bed.toml"
    if not case.exists() or case.read_text() != stage.text:
        (folder / "done").unlink(missing_ok=True)
        for old in folder.glob("settled/checkpoint-*.h5"):
            old.unlink()
        case.write_text(stage.text)
    return folder


def settle(stages, out, options):
    """Runs what has not settled yet; returns the snapshots of the last stage, or None if there is no stage."""
    snapshots = None
    for stage in stages:
        folder = write_stage(stage, out)
        if not (folder / "done").exists():
            if stage.copies:
                write_copies(snapshots, folder / "bed.h5", stage.copies)
            begun = ["--restart", "latest"] if list(folder.glob("settled/checkpoint-*.h5")) else []
            command = [options.binary.resolve(), "bed.toml", *begun]
            print(f"settling {stage.name}", file=sys.stderr, flush=True)
            if "continue with --restart latest" in run(launch(options.settle_ranks, command), options.timeout, folder):
                raise SystemExit(f"{stage.name} was stopped before it had settled; the same command goes on with it")
            (folder / "done").touch()
        snapshots = folder / "settled/particles.vtkhdf"
    return snapshots


def bench_command(study, system, options, binary):
    """The timed run of a system, to be started in the folder of its case."""
    warm = system.warm or study.warm if options.warm is None else options.warm
    steps = options.steps or system.steps or study.steps
    return [str(binary), "bench", "case.toml", "--warm", str(warm), "--steps", str(max(1, steps // 3)), "--segments", "3"]


def write_point(study, system, ranks, out):
    """Writes the case of a system on a number of ranks; returns its folder and the copies it wants."""
    folder = out / slug(study.name) / slug(system.label) / f"ranks-{ranks}"
    folder.mkdir(parents=True, exist_ok=True)
    text, wanted = system.case(system.count, ranks)
    (folder / "case.toml").write_text(text)
    return folder, wanted


def measure(study, system, ranks, out, options):
    """Settles if needed, times, and keeps what `bench` printed."""
    snapshots = settle(system.stages(system.count), out, options)
    folder, wanted = write_point(study, system, ranks, out)
    if wanted:
        write_copies(snapshots, folder / "bed.h5", wanted)
    command = launch(ranks, bench_command(study, system, options, options.binary.resolve()), options.oversubscribe)
    (folder / "bench.txt").write_text(run(command, options.timeout, folder))
    (folder / "bed.h5").unlink(missing_ok=True)


def collect(study, systems, ranks, out):
    """What has been measured: (system, ranks) -> Found."""
    found = {}
    for system in systems:
        for n in ranks:
            path = out / slug(study.name) / slug(system.label) / f"ranks-{n}" / "bench.txt"
            found[system.label, n] = parse(path.read_text()) if path.exists() else None
    return found


def step_times(study, found, ranks):
    """Time of a step, a value per segment, in microseconds per particle of one rank (weak) or of all (strong)."""
    times = [sum(phases.values()) for phases in found.phases] if study.with_fluid else found.times
    return times if study.is_strong else [us * ranks for us in times]


def factors(study, system, found, ranks):
    """S(n) of a system: ranks -> weak scaling factor or speed-up, of the ranks that were timed."""
    timed = {n: found[system.label, n] for n in ranks if found.get((system.label, n))}
    middles = {n: statistics.median(step_times(study, here, n)) for n, here in timed.items()}
    if not middles:
        return {}
    least = min(middles)
    return {n: middles[least] / time * (least if study.is_strong else 1) for n, time in middles.items()}


def number(value, digits):
    return "-" if value is None else f"{value:.{digits}f}"


def timing_rows(study, systems, found, ranks):
    """Header and rows of the times, beside the source's if there is one."""
    of_all = "" if study.is_strong else " of one rank"
    beside = lambda name: [name] + (["source"] if study.published else [])
    header = ["system", "ranks", "particles", *beside(f"us per step and particle{of_all}"), *beside("S(n)")]
    header += [*beside("efficiency")] if study.is_strong else []
    header += ["communication", "contacts per particle"] + (["fluid"] if study.with_fluid else [])
    rows = []
    for system in systems:
        scaling = factors(study, system, found, ranks)
        for n in sorted({*ranks, *system.source}):
            here, ours, theirs = found.get((system.label, n)), scaling.get(n), system.source.get(n)
            pairs = [(spread(step_times(study, here, n)) if here else "-", system.source_time if n == 1 else "-"),
                     (number(ours, 2), number(theirs, 3))]
            if study.is_strong:
                pairs.append((number(ours and ours / n, 3), number(theirs and theirs / n, 3)))
            row = [system.label, n, f"{here.particles:,}" if here else "-"]
            row += [value for pair in pairs for value in (pair if study.published else pair[:1])]
            row += [f"{100 * here.communication():.1f} %" if here else "-", number(here and here.contacts, 2)]
            if study.with_fluid:
                whole = statistics.median(here.times) if here else 0
                inside = here and statistics.median(sum(phases.values()) for phases in here.phases)
                row.append(f"{100 * (1 - inside / whole):.1f} %" if here else "-")
            rows.append(row)
    return header, rows


def count_rows(systems, found, ranks):
    """Header and rows of what was counted per rank: mean, and of particles the largest over the mean."""
    header = ["system", "ranks", "particles per rank", "imbalance", "clones", "neighbours", "messages per step",
              "kB per step", "MB"]
    rows = []
    for system in systems:
        for n in ranks:
            here = found.get((system.label, n))
            if here:
                mean = {name: here.per_rank.get(name, (None, None))[0] for name in COUNTED}
                in_units = lambda name, unit: None if mean[name] is None else mean[name] / unit
                rows.append([system.label, n, number(here.particles / n, 0), number(here.imbalance(), 3),
                             number(mean["clones"], 0), number(mean["neighbours"], 1), number(mean["messages"], 1),
                             number(in_units("bytes", 1e3), 1), number(in_units("memory_bytes", 1e6), 2)])
    return header, rows


def write_csv(path, header, rows):
    with open(path, "w", newline="") as file:
        csv.writer(file).writerows([header, *rows])


def picture(path, curves, title, x_label="ranks", y_label="S(n)", log_y=False):
    """An SVG of curves (label, {x: y}, is_published); says so if there is no matplotlib."""
    try:
        import matplotlib
    except ImportError:
        print(f"no {path.name}: this Python has no matplotlib (see scripts/python-environment)", file=sys.stderr)
        return
    matplotlib.use("svg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6.4, 4.2))
    for label, points, is_published in curves:
        if points:
            x = sorted(points)
            style = dict(marker="s", linestyle="--", mfc="none") if is_published else dict(marker="o")
            axes.plot(x, [points[k] for k in x], label=label, **style)
    axes.set_xscale("log", base=2)
    if log_y:
        axes.set_yscale("log")
    else:
        axes.set_ylim(bottom=0)
    axes.set(xlabel=x_label, ylabel=y_label, title=title)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)
    figure.savefig(path, format="svg", bbox_inches="tight", metadata={"Date": None})
    pyplot.close(figure)


def chosen(study, options):
    """The systems asked for, none twice, with as many particles as can be had."""
    systems, labels = [], set()
    for system in study.systems:
        if options.kinds and not any(kind in system.label for kind in options.kinds):
            continue
        count = system.actual(min(system.count, options.count or system.count))
        system = System(**{**vars(system), "count": count})
        if system.label not in labels:
            labels.add(system.label)
            systems.append(system)
    return systems


def report(study, systems, ranks, out, oversubscribe):
    """Prints the tables and writes CSV and picture."""
    found = collect(study, systems, ranks, out)
    folder = out / slug(study.name)
    print(f"## {study.title}\n\n{machine()}\n")
    for caption, header, rows in study.published:
        print(f"{caption}\n\n{table(header, rows)}\n")
    header, rows = timing_rows(study, systems, found, ranks)
    if not oversubscribe:
        print(table(header, rows) + "\n")
        write_csv(folder / "times.csv", header, rows)
        curves = [(system.label, factors(study, system, found, ranks), False) for system in systems]
        curves += [(f"{system.label}, source", system.source, True) for system in systems]
        picture(folder / "scaling.svg", curves, study.title)
    header, rows = count_rows(systems, found, ranks)
    print(table(header, rows))
    write_csv(folder / "counts.csv", header, rows)


def arguments(study):
    about = sys.modules["__main__"].__doc__
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", type=Path, default=BINARY, help="grains-mpi program")
    parser.add_argument("--ranks", type=int, nargs="+", help="numbers of ranks; powers of 2 up to the cores by default")
    parser.add_argument("--count", type=int, help="at most this many particles per rank (strong scaling: in all)")
    labels = "; ".join(system.label for system in study.systems)
    parser.add_argument("--kinds", nargs="+", help=f"systems whose name holds one of these: {labels}")
    parser.add_argument("--warm", type=int, help="steps before timing")
    parser.add_argument("--steps", type=int, help=f"steps timed, in three segments; {study.steps} by default")
    parser.add_argument("--settle-ranks", type=int, default=1, help="ranks that settle a bed")
    parser.add_argument("--oversubscribe", action="store_true", help="more ranks than cores: counts, but no times")
    parser.add_argument("--out", type=Path, default=ROOT / "results/scaling", help="folder of cases, beds and tables")
    parser.add_argument("--collect", action="store_true", help="run nothing: tables from what is in --out")
    parser.add_argument("--timeout", type=float, default=86400, help="longest time of one run (s)")
    slurm.add_options(parser)
    options = parser.parse_args()
    cores = len(os.sched_getaffinity(0))
    if options.slurm or options.collect:
        options.ranks = options.ranks or study.ranks
    options.ranks = sorted(options.ranks or [2**k for k in range(cores.bit_length()) if 2**k <= cores])
    here = not (options.slurm or options.collect or options.oversubscribe)
    if here and max(options.ranks + [options.settle_ranks]) > cores:
        parser.error(f"more ranks than the {cores} cores would time the waiting for cores; --oversubscribe counts only")
    return options


def main(study):
    options = arguments(study)
    systems = chosen(study, options)
    if options.slurm:
        return slurm.write_study(study, systems, options)
    if not options.collect:
        for system in systems:
            for n in options.ranks:
                measure(study, system, n, options.out, options)
    report(study, systems, options.ranks, options.out, options.oversubscribe)
