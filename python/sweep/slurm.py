"""A sweep as a job array of Slurm."""
import pathlib
import re
import shlex

from whole_file import write_whole

TIME = r"\d+|\d+:\d\d(:\d\d)?|\d+-\d+(:\d\d){0,2}"  # as sbatch(1) reads it
MOST = 1000  # tasks of an array: Slurm's default limit (MaxArraySize 1001)

SCRIPT = """#!/bin/bash
#SBATCH --job-name=sweep_{name}
#SBATCH --array=0-{last}{at_once}
#SBATCH --ntasks={ranks}
#SBATCH --ntasks-per-core=1
#SBATCH --time={time}
#SBATCH --output={logs}/slurm_%A_%a.log
#SBATCH --requeue
# Task I makes run I of {runs} (or those of its share, where they are more than {most}). Submit it again
# for what is missing: complete runs are not made twice.
# Afterwards, for the table and the plots:
#   {collect}
set -euo pipefail
cd {folder}
exec {python} {sweep} --task "$SLURM_ARRAY_TASK_ID" {tasks} {folder}
"""


def valid_time(text):
    return re.fullmatch(TIME, text) is not None


def write(folder, design, python, sweep, jobs, time, collect):
    """Writes folder/sweep.sh, and the order of the runs as folder/runs.txt. Returns the script's path."""
    count = len(design["runs"])
    tasks = min(count, MOST)
    path = folder / "sweep.sh"
    quoted = shlex.quote(str(folder))
    write_whole(path, SCRIPT.format(
        name=re.sub(r"\W", "_", pathlib.Path(design["program"]).name), last=tasks - 1,
        at_once=f"%{jobs}" if jobs else "", ranks=design["ranks"] or 1, time=time,
        logs=str(folder).replace(" ", "\\ "), runs="runs.txt", most=MOST, collect=collect, folder=quoted,
        python=shlex.quote(python), sweep=shlex.quote(str(sweep)), tasks=tasks))
    path.chmod(0o755)
    return path


def share(count, task, tasks):
    """The runs of a task: task, task + tasks, ..."""
    return range(task, count, tasks)
