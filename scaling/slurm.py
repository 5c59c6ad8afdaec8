"""The studies as SLURM jobs: a chain that settles each bed, a job per number of ranks, and how to submit and collect.

A link of a chain continues from the last checkpoint; ten minutes before its time is up it leaves by `--max-walltime`,
and five minutes before SLURM signals the script, which passes SIGUSR1 on. Links of a bed follow each other whatever
happened (afterany); the last fails if the bed has not settled, so that nothing is timed on it (afterok).
"""

import shlex
import sys
from pathlib import Path

from copies import copy_command

HEADER = """\
#!/bin/bash
#SBATCH --job-name={name}
#SBATCH --nodes={nodes}
#SBATCH --ntasks={ranks}
#SBATCH --ntasks-per-node={per_node}
#SBATCH --cpus-per-task=1
#SBATCH --time={minutes}
#SBATCH --output={folder}/%x-%j.log
{more}set -euo pipefail
cd {quoted}
export OMP_NUM_THREADS=1
"""

SETTLE = """\
#SBATCH --signal=B:USR1@300
{header}
[ -e done ] && exit 0
restart=()
if compgen -G 'settled/checkpoint-*.h5' >/dev/null; then
    restart=(--restart latest)
{copy}fi
{launch} {binary} bed.toml "${{restart[@]}}" --max-walltime {seconds} >run.txt 2>&1 &
job=$!
trap 'kill -USR1 "$job" 2>/dev/null || true' USR1
# A signal interrupts wait; the code that counts is that of the run.
while kill -0 "$job" 2>/dev/null; do
    wait "$job" || true
done
code=0
wait "$job" || code=$?
cat run.txt
[ "$code" -eq 0 ] || exit "$code"
# A run that had to leave early says how to go on.
if ! grep -q 'continue with --restart latest' run.txt; then
    touch done
fi
[ -e done ]
"""

POINT = """\
{header}
{copy}{launch} {bench} >bench.part
mv bench.part bench.txt
rm -f bed.h5
"""

SUBMIT = """\
#!/bin/bash
# Submits all jobs of the study.
set -euo pipefail
submit() { sbatch --parsable "$@" | cut -d ';' -f 1; }
"""


def add_options(parser):
    """Options of the job scripts."""
    group = parser.add_argument_group("job scripts")
    group.add_argument("--slurm", type=Path, metavar="DIR", help="write job scripts to a folder instead of running")
    group.add_argument("--ranks-per-node", type=int, default=64)
    group.add_argument("--walltime", type=int, default=14400, help="of a job (s), more than 900")
    group.add_argument("--links", type=int, default=3, help="jobs in the chain that settles a bed")
    group.add_argument("--launcher", choices=["srun", "mpirun"], default="srun")
    group.add_argument("--sbatch", nargs="+", default=[], metavar="LINE", help="further lines, such as account=x partition=y")


def launch(ranks, options):
    """How a job starts its ranks: one per core, neighbours in a row on the same node."""
    per_node = min(ranks, options.ranks_per_node)
    if options.launcher == "srun":
        return f"srun --ntasks={ranks} --ntasks-per-node={per_node} --distribution=block:block --cpu-bind=cores"
    return f"mpirun -n {ranks} --map-by ppr:{per_node}:node --rank-by core --bind-to core"


def header(name, folder, ranks, options):
    per_node = min(ranks, options.ranks_per_node)
    return HEADER.format(
        name=name, nodes=-(-ranks // per_node), ranks=ranks, per_node=per_node, minutes=-(-options.walltime // 60),
        folder=folder, quoted=shlex.quote(str(folder)), more="".join(f"#SBATCH --{line}\n" for line in options.sbatch),
    )


def copy_line(source, target, wanted):
    """The line that copies a settled bed, or nothing."""
    return shlex.join(copy_command(sys.executable, source, target, wanted)) + "\n" if wanted else ""


def settle_script(stage, folder, snapshots, options):
    """The job that settles a bed, or goes on with it."""
    first, rest = header(f"settle-{stage.name}", folder, options.settle_ranks, options).split("\n", 1)
    copy = copy_line(snapshots, folder / "bed.h5", stage.copies)
    return first + "\n" + SETTLE.format(
        header=rest, copy=f"else\n    {copy}" if copy else "", launch=launch(options.settle_ranks, options),
        binary=shlex.quote(str(options.binary.resolve())), seconds=options.walltime - 600,
    )


def write_study(study, systems, options):
    """Writes cases and scripts of a study to the folder --slurm."""
    import study as common

    if options.walltime <= 900:
        raise SystemExit("--walltime: a job needs more than 900 s, ten minutes of which are for leaving in time")
    out = options.slurm.resolve()
    out.mkdir(parents=True, exist_ok=True)
    lines, settled = [SUBMIT], {}
    for system in systems:
        stages, snapshots, after = system.stages(system.count), None, ""
        for stage in stages:
            folder = common.write_stage(stage, out)
            if stage.name not in settled:
                script = folder / "settle.sbatch"
                script.write_text(settle_script(stage, folder, snapshots, options))
                variable = f"bed{len(settled)}"
                for link in range(options.links):
                    depends = f" --dependency=afterany:${variable}" if link else f"{after}"
                    lines.append(f"{variable}=$(submit{depends} {shlex.quote(str(script))})\n")
                settled[stage.name] = variable
            snapshots = folder / "settled/particles.vtkhdf"
            after = f" --dependency=afterok:${settled[stage.name]}"
        for ranks in options.ranks:
            folder, wanted = common.write_point(study, system, ranks, out)
            copy = copy_line(snapshots, folder / "bed.h5", wanted)
            bench = shlex.join(common.bench_command(study, system, options, options.binary.resolve()))
            name = f"{common.slug(study.name)}-{common.slug(system.kind)}-{system.count}-{ranks}"
            values = dict(header=header(name, folder, ranks, options), copy=copy, launch=launch(ranks, options))
            (folder / "job.sbatch").write_text(POINT.format(bench=bench, **values))
            lines.append(f"submit{after} {shlex.quote(str(folder / 'job.sbatch'))}\n")
    submit, gather = out / f"submit-{study.name}.sh", out / f"collect-{study.name}.sh"
    submit.write_text("".join(lines))
    script = Path(common.__file__).parent / f"{study.name.replace('-', '_')}.py"
    asked = ["--collect", "--out", out, "--ranks", *options.ranks] + (["--count", options.count] if options.count else [])
    asked += ["--kinds", *options.kinds] if options.kinds else []
    command = shlex.join(map(str, [sys.executable, script, *asked]))
    gather.write_text(f"#!/bin/bash\n# Tables, CSV and picture of what has been measured.\nexec {command}\n")
    for path in (submit, gather):
        path.chmod(0o755)
    print(f"{submit}\n{gather}")
