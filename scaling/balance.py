#!/usr/bin/env python3
"""What borders between ranks that move to the work gain, as a Markdown table.

The first part of a dam break, the discharge of a silo and a drum, with `domain.balance` off and on. The work of the
busiest rank over the mean counts particles and pairs, so that more ranks than cores tell it too; times mean something
only where every rank has a core of its own.

    scaling/balance.py --ranks 2 4 8
"""

import argparse
import re
import subprocess
import tempfile
from pathlib import Path

from benchmark import BINARY, ROOT, machine, table

# Case, and how much of it (s).
CASES = {"dam-break/size1": 0.03, "silo/quick": 2, "drum/drum": 0.05}


def run(binary, name, end, ranks, balance, folder):
    """Work of the busiest rank over the mean, moves of borders, particles of the fullest rank, and seconds."""
    text = (ROOT / f"cases/{name}.toml").read_text()
    text = re.sub(r"^end = .*", f"end = {end}", text, count=1, flags=re.M)
    text = re.sub(r"^directory = .*", f'directory = "{folder}/run"', text, count=1, flags=re.M)
    text = re.sub(r"^\[domain\]", f"[domain]\nbalance = {'true' if balance else 'false'}", text, count=1, flags=re.M)
    case = folder / "case.toml"
    case.write_text(text)
    command = ["mpirun", "--oversubscribe", "-n", str(ranks), "--bind-to", "none", "--mca", "mpi_yield_when_idle", "1", binary, case]
    out = subprocess.run(command, capture_output=True, text=True, check=True, timeout=3600).stdout
    pattern = r"particles per rank: .* to (\d+); the busiest rank worked ([\d.]+) times the mean; borders moved (\d+) times"
    fullest, work, moves = re.search(pattern, out).groups()
    phases = re.findall(r"^  [a-z ]+? {2,}[\d.]+ +([\d.]+)", out, flags=re.M)
    return float(work), int(moves), int(fullest), sum(map(float, phases))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ranks", nargs="+", type=int, default=[2, 4, 8])
    parser.add_argument("--binary", type=Path, default=BINARY, help="grains-mpi program")
    parser.add_argument("--cases", nargs="+", default=list(CASES), choices=list(CASES))
    options = parser.parse_args()
    rows = []
    for name, end in ((name, CASES[name]) for name in options.cases):
        for ranks in options.ranks:
            found = []
            for balance in (False, True):
                with tempfile.TemporaryDirectory() as folder:
                    found.append(run(options.binary, name, end, ranks, balance, Path(folder)))
            (off, _, full, seconds), (on, moves, fullest, quick) = found
            rows.append([name, ranks, f"{off:.2f}", f"{on:.2f}", f"{off / on:.2f}", moves, full, fullest, f"{seconds:.1f}", f"{quick:.1f}"])
            print(*rows[-1], flush=True)
    print(machine())
    head = ["case", "ranks", "work, fixed", "moving", "gain", "moves", "particles, fixed", "moving", "time (s), fixed", "moving"]
    print(table(head, rows))


if __name__ == "__main__":
    main()
