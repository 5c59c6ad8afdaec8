"""What plot.py and render.py share: the case file, the time series and the moments of a discharge."""

import argparse
import tomllib
from dataclasses import dataclass
from pathlib import Path

import pandas as pd


@dataclass
class Silo:
    """What a silo case file says about its discharge."""

    results: Path  # folder of the results
    beads: int  # number of beads
    radius: float  # radius of a bead (m)
    removal: float  # time at which the plate begins to move (s)
    plane: str  # flow plane in the opening


def arguments(description, picture):
    """Command line common to both scripts; `picture` is the default name of the picture."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("case", type=Path, help="case file, e.g. cases/silo/discharge.toml")
    parser.add_argument("--results", type=Path, help="folder of the results; that of the case by default")
    parser.add_argument("--output", type=Path, help=f"picture to write; {picture} in the results by default")
    return parser


def read_silo(case, results=None):
    """Reads a case file; its results lie relative to the working directory."""
    with open(case, "rb") as file:
        content = tomllib.load(file)
    directory = content.get("output", {}).get("directory", Path("results") / case.stem)
    plates = [wall for wall in content["wall"] if wall["name"] == "plate"]
    if not plates or not content.get("flow_plane"):
        raise SystemExit(f"{case}: needs a wall named plate and a flow_plane")
    return Silo(
        results=Path(results or directory),
        beads=sum(insert["count"] for insert in content["insert"]),
        radius=content["shape"][0]["radius"],
        removal=plates[0]["motion"]["start"],
        plane=content["flow_plane"][0]["name"],
    )


def read_series(silo):
    """Reads the time series: `time` (s), and `passed` (beads) and `mass` (kg) through the opening."""
    path = silo.results / "series.csv"
    try:
        table = pd.read_csv(path, comment="#", skipinitialspace=True)
    except FileNotFoundError:
        raise SystemExit(f"{path}: not found; run the case first, or give --results") from None
    wanted = {"time": "time", f"{silo.plane}_count": "passed", f"{silo.plane}_mass": "mass"}
    missing = wanted.keys() - set(table.columns)
    if missing:
        raise SystemExit(f"{path}: no column {', '.join(sorted(missing))} among {', '.join(table.columns)}")
    return table[list(wanted)].rename(columns=wanted).sort_values("time", ignore_index=True)


def time_when_passed(series, count):
    """First time (s) at which `count` beads have passed, or None."""
    reached = series.loc[series.passed >= count, "time"]
    return None if reached.empty else float(reached.iloc[0])
