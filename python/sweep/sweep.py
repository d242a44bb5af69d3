#!/usr/bin/env python3
"""Sweeps: runs a program over the values of its options, and collects one table and its plots.

  ./dev sweep NAME --vary friction=0.1:0.9:9 --vary iterations=5,10,20 --jobs 2 [-- OPTIONS OF THE PROGRAM]
  ./dev sweep --collect DIR

docs/sweeps.md describes it.
"""
import argparse
import hashlib
import json
import os
import pathlib
import shlex
import signal
import sys
import time

sys.path.insert(1, str(pathlib.Path(__file__).resolve().parents[1]))
import design  # noqa: E402
import plots  # noqa: E402
import slurm  # noqa: E402
import table  # noqa: E402
from design import Wrong  # noqa: E402
from printable import Parser  # noqa: E402
from program import WHOLE, Program  # noqa: E402
from progress import Progress, say  # noqa: E402
from runs import Run, name_of, read  # noqa: E402
from whole_file import remove_leftovers, write_whole  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
KINDS = {"program": str, "digest": str, "options": list, "ranks": int, "limit": (int, float)}  # in sweep.json


class Ended(Exception):
    """By SIGINT, SIGTERM or SIGHUP."""


def digest_of(file):
    return hashlib.sha256(pathlib.Path(file).read_bytes()).hexdigest()[:16]


def arguments_of(words):
    """What the user asks for, and the options for the program after `--`."""
    options = []
    if "--" in words:
        words, options = words[:words.index("--")], words[words.index("--") + 1:]
    parser = Parser(
        prog="./dev sweep", allow_abbrev=False, usage="%(prog)s NAME --vary OPTION=VALUES ... [-- OPTIONS]",
        description="Runs an example, or the program of a path, over the values of its options.")
    add = parser.add_argument
    add("program", nargs="?", metavar="NAME", help="an example, or the path of a program made with run<...>")
    add("--vary", action="append", default=[], metavar="OPTION=VALUES",
        help="A:B:N for N values from A to B, A:B:N:log for constant ratios, or V,W,...; may be repeated")
    add("--design", default="full", help="full: all combinations; latin:N: a Latin hypercube of N runs")
    add("--design-seed", type=int, default=1, help="seed of the Latin hypercube (1)")
    add("--repeat", type=int, default=0, metavar="N", help="N runs of each, with --seed 1 to N")
    add("--jobs", type=int, default=0, metavar="N", help="runs at a time (1); of a job array: at most")
    add("-n", "--np", type=int, default=0, dest="ranks", metavar="RANKS", help="each run under mpirun on so many ranks")
    add("--out", metavar="DIR", help="folder of the sweep (sweep_NAME)")
    add("--limit", type=float, default=0, metavar="SECONDS", help="a run that takes longer is ended and fails")
    add("--retry", action="store_true", help="run those again that failed")
    add("--plot", default="", metavar="A,B", help="draw these results, not the usual ones that vary")
    add("--no-plots", action="store_true", help="write the table only")
    add("--slurm", action="store_true", help="run nothing; write a job array for Slurm, DIR/sweep.sh")
    add("--time", default="01:00:00", help="with --slurm: the time limit of a task, as sbatch takes it")
    add("--collect", metavar="DIR", help="write the table and the plots of what is there")
    add("--task", nargs=2, type=int, metavar=("I", "TASKS"), help=argparse.SUPPRESS)
    asked = parser.parse_args(words)
    parser.require_names(asked, program="NAME", out="--out", collect="--collect")
    asked.plot = [name for name in map(str.strip, asked.plot.split(",")) if name]
    if asked.collect is None and asked.program is None:
        parser.error("sweep which program? Write ./dev sweep NAME --vary OPTION=VALUES")
    if min(asked.jobs, asked.ranks, asked.repeat, asked.limit) < 0:
        parser.error("--jobs, -n, --repeat and --limit are not negative")
    if asked.slurm and not slurm.valid_time(asked.time):
        parser.error(f"--time is a time limit of sbatch such as 90, 02:00:00 or 1-12:00:00, not '{asked.time}'")
    return asked, options


def found_in(folder):
    """What the sweep.json of a folder holds, or None if it has none. Raises Wrong."""
    if not os.path.lexists(folder / "sweep.json"):
        return None
    found = read(folder / "sweep.json") or {}
    runs = found.get("runs")
    if not isinstance(runs, list) or not runs or not all(isinstance(run, dict) and run for run in runs) or \
            not all(isinstance(value, str) for run in runs for value in run.values()) or \
            not all(isinstance(found.get(key), kind) for key, kind in KINDS.items()) or not isinstance(found.get("plot", []), list):
        raise Wrong(f"{folder}/sweep.json is damaged, or of another program: choose another folder with --out DIR")
    return found


def prepare(asked, options):
    """The folder, and the design in it: a new one, or that of an earlier call if both agree."""
    path = pathlib.Path(asked.program).resolve()
    folder = pathlib.Path(asked.out or f"sweep_{path.name}").resolve()
    factors = [design.parse(v) for v in asked.vary]
    program = Program(path)
    program.check([f.name for f in factors] + ["seed"] * (asked.repeat > 0), options)
    whole = [f.name for f in factors if program.options[f.name] in WHOLE]
    for f in factors:
        for value in f.values or ():
            if f.name in whole and not value.lstrip("+-").isdigit() and not value.startswith("0x"):
                raise Wrong(f"--vary {f.name}: the option takes whole numbers, and one of the values is {value}")
    runs = design.make(factors, asked.design, asked.design_seed, asked.repeat, whole)
    program.check_values(runs, options)
    wanted = {"program": str(path), "digest": digest_of(path), "options": options, "ranks": asked.ranks,
              "limit": asked.limit, "plot": asked.plot, "runs": runs}
    found = found_in(folder)
    if folder.exists() and not folder.is_dir():
        raise Wrong(f"{folder} is no folder: choose another one with --out DIR")
    remove_leftovers(folder, ("sweep.json", "runs.txt", "table.csv", "sweep.sh"))
    if found is None and folder.exists() and any(folder.iterdir()):
        raise Wrong(f"{folder} is there already and holds no sweep: choose another folder with --out DIR")
    if found is not None:
        for key, word in (("program", "of another program"), ("options", "with other options"),
                          ("ranks", "on another number of ranks")):
            if found.get(key) != wanted[key]:
                raise Wrong(f"{folder} holds a sweep {word}, {found.get(key)} instead of {wanted[key]}: choose "
                            "another folder with --out DIR")
        if set(found["runs"][0]) != set(runs[0]):
            raise Wrong(f"{folder} holds a sweep over {', '.join(found['runs'][0])}, and this one is over "
                        f"{', '.join(runs[0])}: choose another folder with --out DIR")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as e:
        raise Wrong(f"{folder} cannot be made: {e.strerror}: choose another folder with --out DIR") from None
    write_whole(folder / "sweep.json", json.dumps(wanted, indent=1) + "\n")
    write_whole(folder / "runs.txt", "".join(f"{i} runs/{name_of(r)}\n" for i, r in enumerate(runs)))
    return folder, wanted


def runs_of(folder, wanted):
    return [Run(folder, values, wanted) for values in wanted["runs"]]


def carry_out(todo, progress, jobs, limit):
    """Makes the runs, `jobs` at a time. Whatever ends it, no program is left behind."""
    waiting, active = list(todo), []
    try:
        while waiting or active:
            for run in list(waiting):
                if len(active) >= jobs:
                    break
                if not run.take():  # another sweep of this folder makes it, or its program still ends
                    continue
                waiting.remove(run)
                if run.state == "done":
                    run.leave()
                    progress.note(run, "done", len(active))
                    continue
                run.start()
                if run.process is None:
                    progress.note(run, "failed", len(active))
                else:
                    active.append(run)
            for run in list(active):
                code = run.process.poll()
                if code is None and limit and time.monotonic() - run.began > limit:
                    run.end()
                    state = run.finish(-signal.SIGTERM, f"it took longer than {limit:g} s (--limit)")
                elif code is None:
                    continue
                else:
                    state = run.finish(code)
                active.remove(run)
                progress.note(run, state, len(active))
            progress.show(len(active))
            time.sleep(0.02)
    finally:
        progress.clear()
        for run in active:
            run.stop()


def draw(folder, runs, wanted_plots):
    """Draws the plots; returns whether all that are wanted can be drawn."""
    _, names, rows = table.collect(runs)
    able = [n for n in wanted_plots if any(table.as_number(row.get(n)) is not None for row in rows)]
    for name in wanted_plots:
        if name not in able:
            say(f"--plot {name}: the results have no " + (f"{name}" if name not in names else f"number as {name}"))
    drawn = plots.draw(folder / "plots", runs, able if wanted_plots else None)
    if drawn is None:
        say("no plots: this Python has no matplotlib (in Debian python3-matplotlib)")
    else:
        say(f"{len(drawn)} plots are in {folder}/plots")
    return len(able) == len(wanted_plots)


def finish(folder, runs, asked):
    """The table and the plots; returns the exit code: 0 if all runs are done, and all plots asked for drawn."""
    table.write(folder / "table.csv", runs)
    states = [run.state for run in runs]
    failed = [run for run, state in zip(runs, states) if state == "failed"]
    drawn = asked.no_plots or "done" not in states or draw(folder, runs, asked.plot)
    say(f"{states.count('done')} of {len(runs)} runs are done, {len(failed)} failed, "
        f"{states.count('missing')} are missing; the table is {folder}/table.csv")
    for run in failed:
        say(f"failed: {run.folder.name}: {run.failure()}")
    if failed:
        say("their folders keep command and log; --retry makes them again")
    return 0 if drawn and states.count("done") == len(runs) else 1


def stored(folder):
    folder = pathlib.Path(folder).resolve()
    wanted = found_in(folder)
    if wanted is None:
        raise Wrong(f"{folder} holds no sweep: there is no sweep.json in it")
    return folder, wanted


def make_task(asked):
    """Some runs of a job array."""
    index, tasks = asked.task
    folder, wanted = stored(asked.program)
    runs = runs_of(folder, wanted)
    if not 0 <= index < tasks or index >= len(runs):
        raise Wrong(f"there is no task {index}: the sweep has {len(runs)} runs in {tasks} tasks")
    if digest_of(wanted["program"]) != wanted["digest"]:
        say(f"{wanted['program']} has changed since the script was written")
    mine = [runs[i] for i in slurm.share(len(runs), index, tasks)]
    todo = [run for run in mine if run.state == "missing"]
    carry_out(todo, Progress(len(mine), len(mine) - len(todo), 1), 1, wanted["limit"])
    return 0 if all(run.state == "done" for run in mine) else 1


def main(words):
    asked, options = arguments_of(words)
    if asked.task:
        return make_task(asked)
    if asked.collect is not None:
        folder, wanted = stored(asked.collect)
        asked.plot = asked.plot or wanted.get("plot", [])
        return finish(folder, runs_of(folder, wanted), asked)
    folder, wanted = prepare(asked, options)
    runs = runs_of(folder, wanted)
    if asked.slurm:
        script = slurm.write(folder, wanted, sys.executable, pathlib.Path(__file__).resolve(), asked.jobs, asked.time,
                             shlex.join([str(ROOT / "dev"), "sweep", "--collect", str(folder)]))
        say(f"{script} is written, for {len(runs)} runs; submit it with: sbatch {shlex.quote(str(script))}")
        return 0
    jobs = asked.jobs or 1
    states = {run: run.state for run in runs}
    if asked.retry:
        for run in runs:
            if states[run] == "failed":
                (run.folder / "failed.json").unlink(missing_ok=True)
                states[run] = "missing"
    todo = [run for run in runs if states[run] == "missing"]
    earlier = sum(1 for run in runs if states[run] == "done" and
                  read(run.folder / "done.json").get("program") != wanted["digest"])
    if earlier:
        say(f"{earlier} runs were made by another build of the program; for one table of one build choose "
            "another folder with --out DIR")
    if len(todo) < len(runs):
        say(f"{len(runs) - len(todo)} of {len(runs)} runs are there already")
    try:
        carry_out(todo, Progress(len(runs), len(runs) - len(todo), jobs), jobs, asked.limit)
    except (Ended, KeyboardInterrupt) as end:
        table.write(folder / "table.csv", runs)
        say(f"ended by {end or 'SIGINT'}; the same command goes on from here")
        return 130
    return finish(folder, runs, asked)


def on_signal(number, _):
    raise Ended(signal.Signals(number).name)


if __name__ == "__main__":
    for kind in (signal.SIGTERM, signal.SIGHUP, signal.SIGINT):
        signal.signal(kind, on_signal)
    try:
        sys.exit(main(sys.argv[1:]))
    except Wrong as wrong:
        say(wrong)
        sys.exit(2)
    except OSError as e:
        say(f"{e.filename or 'the sweep'}: {e.strerror}; when that is mended the same command goes on from here")
        sys.exit(1)
    except Ended as end:
        say(f"ended by {end}")
        sys.exit(130)
