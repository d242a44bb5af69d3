#!/usr/bin/env python3
"""The benchmark suite: runs its parts, writes tables, plots and the page, and docs/scaling.md.

suite.py BUILD OUTPUT [--only PART,...] [--full] [--quick] [--keep] [--draw]
  BUILD    folder of the benchmark programs
  OUTPUT   folder for results.json, <part>.csv, plots and README.md
  --only   measure these parts and take the others from their tables
  --full   the rivals at 64,000 bodies and in the well too, which takes an hour
  --quick  small sizes, to see whether all works: the figures mean nothing
  --keep   measure only what the tables lack
  --draw   measure nothing
  --list   the programs that the parts need, and nothing else
"""
import argparse
import os
import platform
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "..", "report")]

from parts import PARTS, PROGRAMS, TABLES  # noqa: E402
from results import Results  # noqa: E402
from quiet import Clock, wait_for_quiet  # noqa: E402
from runs import Bench  # noqa: E402


def machine(say):
    """What a figure depends on besides the program."""
    model = "unknown processor"
    try:
        with open("/proc/cpuinfo") as file:
            names = [line.split(":", 1)[1].strip() for line in file if line.startswith("model name")]
            model = names[0] if names else model
    except OSError:
        pass
    return {"processor": model, "cores": os.cpu_count(), "system": platform.platform(),
            "others_before": wait_for_quiet(say)}


def wanted_parts(text):
    names = text.split(",") if text else list(PARTS)
    for name in names:
        if name not in PARTS:
            sys.exit(f"bench: there is no part '{name}'; there are: {' '.join(PARTS)}")
    return names


def main():
    options = argparse.ArgumentParser(usage=__doc__)
    options.add_argument("build", nargs="?")
    options.add_argument("output", nargs="?")
    options.add_argument("--only", metavar="PART,...")
    for flag in ("full", "quick", "keep", "draw", "list"):
        options.add_argument("--" + flag, action="store_true")
    given = options.parse_args()
    parts = wanted_parts(given.only)
    if given.list:
        print(" ".join(dict.fromkeys(each for part in parts for each in PROGRAMS[part])))
        return
    if not given.output:
        options.error("BUILD and OUTPUT are needed")
    results = Results(given.output)
    if not given.draw:
        # A run of some parts leaves most figures as they were, and what is said of them.
        partly = bool(results.machine) and (given.keep or bool(given.only))
        if partly:
            run = {"parts": parts, "others_before": wait_for_quiet(results.say)}
            results.machine.setdefault("again", []).append(run)
        else:
            run = results.machine = {**machine(results.say), "quick": given.quick}
        clock = Clock()
        bench = Bench(given.build, results, given.quick, given.full, given.keep or bool(given.only))
        began = time.monotonic()
        if not given.keep:
            for part in parts:
                for table in TABLES.get(part, [part]):
                    results.forget(table)
        for part in parts:
            try:
                PARTS[part](bench)
            except RuntimeError as error:
                results.say(f"{part} is left: {error}")
        run["others_during"] = clock.others()
        if not partly:
            results.machine["minutes"] = round((time.monotonic() - began) / 60, 1)
        results.save(parts[-1])

    import page  # noqa: E402  (Matplotlib is slow to start)
    page.write(results)


if __name__ == "__main__":
    main()
