#!/usr/bin/env python3
"""How ranks tell each other of their clones: the strategies of Rakotonirina (2016, section 5.3) and our own.

The bed of weak.py, a column per rank, with each `domain.exchange`, in turns: messages, bytes and waiting are per rank and
step of updates of clones. Ranks whose number is a cube form one, others a flat grid.

    scaling/exchange.py --ranks 1 2
    scaling/exchange.py --ranks 8 27 64 --count 500 --oversubscribe
"""

import argparse
import os
import statistics
from pathlib import Path

from benchmark import BINARY, ROOT, machine, run, spread, table
from study import grid, launch, number, parse, picture, write_csv
from weak import bed, per_rank

STRATEGIES = ["all_gather_global", "all_gather_local", "all_gather_local_nonblocking", "send_recv_local_geoloc", "persistent"]


def layout(ranks):
    """A cube if ranks are the cube of 2 or more, else a flat grid."""
    edge = round(ranks ** (1 / 3))
    return (edge,) * 3 if edge > 1 and edge**3 == ranks else (*grid(ranks), 1)


def measure(strategy, ranks, options):
    """What `bench` found of one strategy."""
    folder = options.out / "exchange" / f"{strategy}-{ranks}"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "case.toml").write_text(bed(options.count, layout(ranks), f'exchange = "{strategy}"\n'))
    command = [options.binary.resolve(), "bench", "case.toml", "--warm", options.warm, "--steps", max(1, options.steps // 3)]
    output = run(launch(ranks, command, options.oversubscribe), options.timeout, folder)
    (folder / "bench.txt").write_text(output)
    found = parse(output)
    if not found:
        raise SystemExit(f"no timing in the output:\n{output[-2000:]}")
    return found


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", type=Path, default=BINARY, help="grains-mpi program")
    parser.add_argument("--ranks", type=int, nargs="+", default=[1, 2])
    parser.add_argument("--count", type=int, default=4000, help="spheres per rank, about")
    parser.add_argument("--strategies", nargs="+", choices=STRATEGIES, default=STRATEGIES)
    parser.add_argument("--rounds", type=int, default=2, help="times that the strategies take turns")
    parser.add_argument("--warm", type=int, default=8000, help="steps before timing, until the bed has fallen")
    parser.add_argument("--steps", type=int, default=6000, help="steps timed, in three segments")
    parser.add_argument("--oversubscribe", action="store_true", help="more ranks than cores: counts, but no times")
    parser.add_argument("--out", type=Path, default=ROOT / "results/scaling", help="folder of cases and tables")
    parser.add_argument("--timeout", type=float, default=3600, help="longest time of one run (s)")
    options = parser.parse_args()
    if max(options.ranks) > len(os.sched_getaffinity(0)) and not options.oversubscribe:
        parser.error("more ranks than cores would time the waiting for cores; --oversubscribe counts only")
    return options


def main():
    options = arguments()
    found = {}
    for ranks in options.ranks:
        for _ in range(1 if options.oversubscribe else options.rounds):
            for strategy in options.strategies:
                found.setdefault((strategy, ranks), []).append(measure(strategy, ranks, options))
    header = ["ranks", "strategy", "clones", "neighbours", "messages per step", "kB per step", "wait (us per step)",
              "us per step and sphere of one rank", "communication"]
    rows, bytes_sent = [], {strategy: {} for strategy in options.strategies}
    for (strategy, ranks), rounds in found.items():
        mean = {name: value[0] for name, value in rounds[-1].per_rank.items()}
        counted = [number(mean.get(name), digits) for name, digits in [("clones", 0), ("neighbours", 1), ("messages", 1)]]
        kilobytes = number(mean["bytes"] / 1000 if "bytes" in mean else None, 2)
        timed = ["-"] * 3
        if not options.oversubscribe:
            waits = [each.per_rank["wait_us"][0] for each in rounds if "wait_us" in each.per_rank]
            times = [ranks * us for each in rounds for us in each.times]
            share = statistics.median(each.communication() for each in rounds)
            timed = [spread(waits, 2) if waits else "-", spread(times), f"{100 * share:.1f} %"]
        rows.append([ranks, strategy, *counted, kilobytes, *timed])
        if mean.get("bytes"):
            bytes_sent[strategy][ranks] = mean["bytes"] / 1000
    print(f"{machine()}. {per_rank(options.count):,} spheres per rank.\n")
    print(table(header, rows))
    folder = options.out / "exchange"
    write_csv(folder / "exchange.csv", header, rows)
    curves = [(strategy, points, False) for strategy, points in bytes_sent.items()]
    if any(bytes_sent.values()):
        picture(folder / "exchange.svg", curves, "Updates of clones", y_label="kB per rank and step", log_y=True)


if __name__ == "__main__":
    main()
