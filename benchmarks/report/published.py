"""Scenes of other projects' comparisons: what is measured here, and what has been published, in columns of
their own. Published figures are of other machines: errors compare, times do not."""
import csv
import json
import os
import subprocess
import sys

from text import number, table

# What the tables SIMBENCH and BOX3D run: label, program and its options; engines have the programs
# program, program_bullet64, program_ode.
SIMBENCH = [
    ("rolling, 60 degrees, 1 ms", ["simbench", "--scene", "rolling", "--angle", "60"]),
    ("rolling, 90 degrees, 1 ms", ["simbench", "--scene", "rolling", "--angle", "90"]),
    ("bouncing, 1 ms", ["simbench", "--scene", "bouncing"]),
    ("bouncing, 10 ms", ["simbench", "--scene", "bouncing", "--rate", "100"]),
    ("elastic_666, 1 ms", ["simbench", "--scene", "elastic"]),
    ("elastic_666, 10 ms", ["simbench", "--scene", "elastic", "--rate", "100"]),
]
BOX3D = [
    ("large_pyramid, 1/60 s", ["pyramid", "--rows", "100", "--rate", "60", "--seconds", "8"]),
    ("many_pyramids, 1/60 s", ["pyramid", "--rows", "10", "--count", "196", "--rate", "60", "--seconds", "4"]),
    ("large_world, 1/60 s", ["box3d_scenes", "--scene", "large_world"]),
]
ENGINES = {"talus": "", "bullet64": "_bullet64", "ode": "_ode"}
LABELS = {"talus": "talus", "bullet64": "Bullet, double", "ode": "ODE, double"}
TABLES = {"simbench": (SIMBENCH, list(ENGINES)), "box3d": (BOX3D, ["talus"])}
TIMEOUT = 1800  # seconds of one run

# Errors that SimBenchmark publishes (i7-7700HQ). The figures of rolling name no direction; that
# of ODE agrees with 60 degrees. Bullet had 400 iterations. Those of elastic_666 at 10 ms are a range over all
# engines.
ROLLING = {"RaiSim": "4e-07", "Bullet": "4e-27", "ODE": "3.1", "DART": "3.1", "MuJoCo": "0.002"}
SPREAD = dict.fromkeys(["RaiSim", "Bullet", "ODE"], "2300 to 3100")
PUBLISHED_SIMBENCH = [
    ROLLING, {},
    {"RaiSim": "0.136", "Bullet": "274", "ODE": "13.6"},
    {"RaiSim": "13.6", "Bullet": "2722", "ODE": "137"},
    {"RaiSim": "2.9", "Bullet": "204", "ODE": "10.6"},
    SPREAD,
]
# Milliseconds a step: scene, Box3D's own on one thread of a Ryzen 7950X; Box3D 30c67b5 and talus beside
# each other on one core of an EPYC (g++ 12), where that was done.
PUBLISHED_BOX3D = [
    ("washer", "27.1", "45.4", "91"), ("junkyard", "40.1", "61.4", "71.6"),
    ("convex_pile", "34.7", "40.6", "41"), ("joint_grid", "15.9", "-", "-"),
    ("large_pyramid", "10.4", "12 to 13.2", "-"), ("many_pyramids", "23.3", "31.7 to 33.3", "-"),
    ("rain", "6.09", "-", "-"), ("large_world", "0.022", "-", "-"),
]


def programs(names):
    """Those that the tables of these names need."""
    return sorted({words[0] + ENGINES[engine] for name in names for _, words in TABLES[name][0]
                   for engine in TABLES[name][1]})


def measure(build, output, names, keep):
    """Runs what the tables need; with `keep` what they lack."""
    for name in names:
        runs, engines = TABLES[name]
        rows = read(output, name) if keep else []
        known = {(row["label"], row["engine"]) for row in rows}
        for label, words in runs:
            for engine in engines:
                program = os.path.join(build, words[0] + ENGINES[engine])
                if (label, engine) in known or not os.path.exists(program):
                    continue
                try:
                    done = subprocess.run([program, *words[1:]], capture_output=True, text=True,
                                          timeout=TIMEOUT)
                except subprocess.TimeoutExpired:
                    print(f"report: {label}, {engine}: took more than {TIMEOUT} s", file=sys.stderr)
                    continue
                if done.returncode != 0:
                    print(f"report: {label}, {engine}: {done.stderr.strip()}", file=sys.stderr)
                    continue
                rows.append({"label": label, **json.loads(done.stdout), "engine": engine})
                write(output, name, rows)
                print(f"report: {label}, {engine}", file=sys.stderr)


def write(output, name, rows):
    keys = list(dict.fromkeys(key for row in rows for key in row))
    with open(os.path.join(output, name + ".csv"), "w", newline="") as file:
        lines = csv.DictWriter(file, keys, lineterminator="\n")
        lines.writeheader()
        lines.writerows(rows)


def read(output, name):
    path = os.path.join(output, name + ".csv")
    if not os.path.exists(path):
        return []
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def simbench(output):
    """Errors of the engines here, with the cost in brackets, and the published ones."""
    rows = {(row["label"], row["engine"]): row for row in read(output, "simbench")}
    if not rows:
        return "Not measured yet."
    others = ["RaiSim", "Bullet", "ODE", "DART", "MuJoCo"]
    lines = []
    for (label, words), published in zip(SIMBENCH, PUBLISHED_SIMBENCH):
        cells = [label, "m²/s²" if "rolling" in words else "J"]
        for engine in ENGINES:
            row = rows.get((label, engine))
            cells.append("-" if row is None else f"{number(float(row['error']))} "
                         f"({number(float(row['cpu_seconds_per_simulated_second']))})")
        lines.append(cells + [published.get(other, "-") for other in others])
    head = ["scene", "error in", *(LABELS[engine] + ", here" for engine in ENGINES),
            *(other + ", published" for other in others)]
    return table(head, lines)


def box3d(output):
    """Milliseconds a step: here, and published."""
    here = {row["label"].split(",")[0]: row for row in read(output, "box3d")}
    lines = []
    for name, own, beside, talus in PUBLISHED_BOX3D:
        cells = ["-", "-", "-"]
        if name in here:
            row = here[name]
            cost = 1e3 * float(row["cpu_seconds_per_simulated_second"]) / float(row["rate"])
            drift = number(float(row["top_drift"])) if row.get("top_drift") else "-"
            cells = [number(cost), drift, number(float(row["penetration_max"]))]
        lines.append([name, *cells, talus, beside, own])
    return table(["scene", "talus, here", "drift of the top", "largest overlap", "talus, EPYC",
                  "Box3D, EPYC", "Box3D, 7950X, published"], lines)
