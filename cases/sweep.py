"""Many runs of one case: side by side, and resumed where an earlier call of the same command stopped."""
import concurrent.futures
import csv
import os
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = Path(os.environ.get("GRAINS_MPI", ROOT / "target/release/grains-mpi"))
RESULTS = ROOT / "results"


def run(case, folder):
    """Runs the text of a case in a folder of its own, once; continues from its last checkpoint."""
    folder.mkdir(parents=True, exist_ok=True)
    done, path = folder / "done", folder / "case.toml"
    if done.exists() and path.read_text() == case:
        return
    begun = path.exists() and path.read_text() == case and list((folder / "run").glob("checkpoint-*.h5"))
    done.unlink(missing_ok=True)
    path.write_text(case)
    command = [PROGRAM, path] + (["--restart", "latest"] if begun else [])
    with open(folder / "log", "a" if begun else "w") as log:
        start = log.tell()
        subprocess.run(command, stdout=log, stderr=subprocess.STDOUT, check=True, env=environment())
    # A run that a signal has stopped succeeds too.
    if b"continue with --restart latest" in (folder / "log").read_bytes()[start:]:
        raise InterruptedError(folder)
    done.touch()


def run_all(cases, jobs=os.cpu_count()):
    """Runs (text, folder) pairs, `jobs` at a time, each on one rank; those that fail are named at the end."""
    failed = []
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        futures = {pool.submit(run, case, folder): folder for case, folder in cases}
        for future in concurrent.futures.as_completed(futures):
            folder = futures[future]
            error = future.exception()
            print(f"{folder.relative_to(RESULTS)}: {'failed, see its log' if error else 'done'}", flush=True)
            if error:
                failed.append(folder)
    return failed


def analyse(what, folder, *options):
    """The rows of the table that `grains-mpi analyse` makes of a run."""
    out = folder / "analysis"
    command = [PROGRAM, "analyse", what, folder / "run", "--output", out, *map(str, options)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=environment())
    return table(out / f"{what}.csv")


def table(path):
    """The rows of a CSV file of the program, which begins with comments."""
    with open(path) as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def environment():
    """One rank without mpirun, also for root in a container."""
    return {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
