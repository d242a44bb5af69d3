#!/usr/bin/env python3
"""Stands in for a program made with run<...>: its options, its results, and ways to go wrong.

Each start adds a line to the file STARTS of the environment, so that tests can count. With --fail-at it ends with
LAST_WORDS."""
import json
import os
import sys
import time

HELP = """Usage: program.py [OPTIONS]

  --help                    show this help and stop
  --steps UINT=1000         time steps
  --friction FLOAT=0.5      of all
  --iterations INT=10       of the solver
  --seed UINT=1             seed of all random numbers
  --json TEXT               write the results to this file
  --reproducible            the same bits
  --seconds FLOAT=0         how long it takes
  --fail-at FLOAT           friction with which it fails
"""
KINDS = {"steps": int, "friction": float, "iterations": int, "seed": int, "json": str,
         "reproducible": lambda s: s == "true", "seconds": float, "fail-at": float}


def main():
    chosen = {"steps": 1000, "friction": 0.5, "iterations": 10, "seed": 1, "seconds": 0.0, "fail-at": None}
    words, mistake = sys.argv[1:], ""
    if "--help" in words:
        print(HELP, end="")
        return 0
    while words:
        name, sign, value = words.pop(0).removeprefix("--").partition("=")
        if name not in KINDS:
            mistake = mistake or f"'--{name}' is not an option of this program"
            continue
        value = value if sign else words.pop(0)
        try:
            chosen[name] = KINDS[name](value)
        except ValueError:
            mistake = mistake or f"--{name}: needs a number, but is '{value}'"
        if name == "iterations" and not mistake and chosen[name] < 1:
            mistake = f"--iterations must be at least 1, but is {value}"
    if mistake:
        print(f"program.py: {mistake}", file=sys.stderr)
        return 2
    with open(os.environ["STARTS"], "a") as starts:
        starts.write(f"{chosen['friction']} {chosen['iterations']} {chosen['seed']}\n")
    time.sleep(chosen["seconds"])
    if chosen["friction"] == chosen["fail-at"]:
        print("progress\nprogram.py: " + os.environ.get("LAST_WORDS", "body 7 is lost"), file=sys.stderr)
        return 1
    results = {"scenario": "program", "steps": chosen["steps"], "contacts": int(100 * chosen["friction"]),
               "residual": None, "state_digest": "0123", "angle": chosen["friction"] * chosen["iterations"],
               "flowing": chosen["friction"] < 0.3, "seed": chosen["seed"]}
    with open(chosen["json"], "w") as file:
        json.dump(results, file)
    return 0


if __name__ == "__main__":
    sys.exit(main())
