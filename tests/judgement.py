#!/usr/bin/env python3
"""The benchmark suite's verdicts (benchmarks/suite/judgement.py) on made-up measurements: a target is
met only at a setting whose error is within the rival's, and missing results are reported as missing."""
import os
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [os.path.join(HERE, "..", "benchmarks", "suite"),
                os.path.join(HERE, "..", "benchmarks", "report")]

import judgement  # noqa: E402
from results import Results  # noqa: E402


def pile(label, bodies, iterations, ms, error):
    return {"label": label, "size": bodies, "bodies": bodies, "iterations": iterations,
            "cpu_ms_per_step_median": ms, "penetration_mean": error, "bytes_stored_per_body": 99}


def verdict(results, start):
    return next(line for line in judgement.judge(results) if line[0].startswith(start))


def expect(line, met, *words):
    assert line[3] == met, line
    for word in words:
        assert word in line[2], (word, line)


with tempfile.TemporaryDirectory() as folder:
    results = Results(folder)
    bullet = "Pile of 8,000: times less CPU time than Bullet"
    expect(verdict(results, bullet), "not measured")

    results.add("pile", pile("bullet", 8000, 10, 60, 1e-3))
    results.add("pile", pile("talus", 8000, 1, 2, 5e-4))  # cheapest, but not within 1e-4
    results.add("pile", pile("talus", 8000, 3, 5, 5e-5))
    results.add("pile", pile("talus", 8000, 10, 9, 1e-6))
    expect(verdict(results, bullet), "**no**", "12.0", "3 iterations")
    results.add("pile", pile("talus", 8000, 3, 3, 5e-5))  # a second run, faster: the mean counts
    expect(verdict(results, bullet), "yes", "15.0")

    results.add("pile", pile("ode", 8000, 20, 200, 1e-7))  # more precise than any setting
    expect(verdict(results, "Pile of 8,000: times less CPU time than ODE"), "**no**", "no setting")

    results.add("pile", pile("talus", 64000, 10, 90, 1e-5))
    results.add("pile", pile("talus", 512000, 10, 9 * 64 * 1.7, 1e-5))
    expect(verdict(results, "Cost per body from 8,000 to 512,000, 10"), "**no**", "1.70")

    for label, wall in (("one", 100), ("two processes", 55)):
        results.add("ranks", {"label": label, "scaling": "strong", "bodies": 64000,
                              "wall_ms_per_step_median": wall})
    expect(verdict(results, "Parallel efficiency of two MPI"), "yes", "0.91")
    expect(verdict(results, "Parallel efficiency of two threads"), "not measured")

    for label, messages in (("64", 120), ("1024", 121)):
        results.add("threads", {"label": label, "messages_per_step_max": messages})
    expect(verdict(results, "Messages of the busiest rank"), "**no**", "120 and 121")
    expect(verdict(results, "Bytes stored"), "yes", "99")
    assert len(Results(folder).rows("pile")) == 8  # what was written can be read again
print("all verdicts as expected")
