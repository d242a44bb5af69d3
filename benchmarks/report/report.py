#!/usr/bin/env python3
"""Speed against error: runs every engine over its knobs, writes tables, plots and the page.

report.py BUILD OUTPUT [--jobs N] [--fc3d FOLDER] [--keep] [--draw] [PLOT ...]
  BUILD   folder of the benchmark programs
  OUTPUT  folder for <plot>.csv, <plot>.svg and README.md
  PLOT    measure these only and take the others from their tables; all are drawn anew
  FOLDER  contact problems for the program fc3d
  --keep  measure only what the tables lack
  --draw  measure nothing
  --list  print the programs that PLOT needs, and end
PLOT may also be simbench or box3d, the tables of scenes of other projects.
"""
import argparse
import concurrent.futures
import csv
import json
import os
import re
import subprocess
import sys
import time

import published
from drawing import LOOKS, frame, save
from text import number, ratio, table

HERE = os.path.dirname(os.path.abspath(__file__))
FLOOR = 1e-17  # where errors of exactly zero are drawn
TIMEOUT = 1800  # seconds of one run, on a machine that does other things too
FALLEN = 30.0  # and those of what broke down

# Name of a curve: its program with arguments.
PROGRAMS = {
    "talus": ["precision"],
    "talus_jacobi": ["precision", "--solver", "accelerated_jacobi"],
    "talus_small": ["precision", "--solver", "substepping"],
    "talus_soft": ["precision", "--solver", "soft_contact"],
    "bullet": ["precision_bullet"],
    "bullet64": ["precision_bullet64"],
    "ode": ["precision_ode"],
}
# The same with label, colour and marker.
CURVES = {curve: (program, *LOOKS[curve]) for curve, program in PROGRAMS.items()}
OWN = [c for c in CURVES if c.startswith("talus")]
HARD = [c for c in CURVES if c != "talus_soft"]

STEPS = [30, 60, 120, 240, 480, 960]  # per unit of time
ITERATIONS = {c: [2, 5, 10, 20, 50, 100, 200] for c in ("talus", "talus_jacobi", "talus_small")}
DEFAULT_ITERATIONS = [5, 10, 20, 50, 100, 200]


def plot(name, title, scene, size, knob, values=None, curves=None, error=""):
    """One plot: a scene, and the knob that each curve is swept over."""
    return {"name": name, "title": title, "scene": scene, "size": size, "knob": knob,
            "values": values or {}, "curves": curves or HARD, "error": error}


# The expensive ones first, so that the last minutes are not one long run.
PLOTS = [
    plot("pile_8000", "Pile of 8,000 spheres", "pile", 8000, "iterations",
         {"talus": [2, 5, 10, 20, 50, 100], "talus_jacobi": [10, 20, 50, 100],
          "talus_small": [2, 5, 10, 20], "bullet": [5, 10, 20, 50], "bullet64": [10, 20],
          "ode": [10, 20, 50]}, error="mean overlap / mean radius"),
    plot("pile_1000", "Pile of 1,000 spheres", "pile", 1000, "iterations",
         error="mean overlap / mean radius"),
    plot("pile_1000_dt", "Pile of 1,000 spheres, default iterations, time step varied", "pile",
         1000, "steps", {"talus_soft": [480, 960, 1920, 3840, 7680],
                           **{c: [60, 120, 240, 480, 960] for c in HARD}}, list(CURVES),
         error="mean overlap / mean radius"),
    plot("pyramid", "Pyramid of 55 boxes, 5 s", "pyramid", 10, "iterations",
         error="largest displacement / edge"),
    plot("heavy_10", "Ten boxes, the top one of density 10, 5 s", "heavy", 10, "iterations",
         error="largest displacement / edge"),
    plot("heavy_1000", "Ten boxes, the top one of density 1,000, 5 s", "heavy", 1000, "iterations",
         error="largest displacement / edge"),
    plot("spin", "Free box about its intermediate axis, 60 s", "spin", 0, "steps",
         error="max |E/E0 - 1|"),
    plot("creep", "Box at rest on 30 degrees, friction 0.6", "creep", 0, "steps",
         error="way in 10 s / edge"),
    plot("slide", "Box sliding down 30 degrees, friction 0.4", "slide", 0, "steps",
         error="relative error of speed after 2 s"),
    plot("roll", "Sphere from sliding to rolling", "roll", 0, "steps",
         error="relative error of way after 2 s"),
    plot("bounce", "Bouncing ball, restitution 0.8, until it rests", "bounce", 0, "steps",
         error="mean error of height / first height"),
]


def values_of(p, curve):
    if curve in p["values"]:
        return p["values"][curve]
    if p["knob"] == "steps":
        return STEPS
    return ITERATIONS.get(curve, DEFAULT_ITERATIONS)


def measure(build, p, curve, value):
    program, *extra = CURVES[curve][0]
    command = [os.path.join(build, program), *extra, "--scene", p["scene"], "--size",
               str(p["size"])]
    command += ["--iterations", str(value)] if p["knob"] == "iterations" else \
        ["--dt", repr(1 / value)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT)
    except subprocess.TimeoutExpired:
        return None, f"took more than {TIMEOUT} s"
    if done.returncode != 0:
        return None, done.stderr.strip()
    row = json.loads(done.stdout)
    row["curve"], row["knob"], row["value"] = curve, p["knob"], value
    for key in ("size", "iterations_chosen", "dt_chosen"):
        row.pop(key, None)
    return row, ""


def write_table(output, p, rows):
    """At once and in order, after each run: a report that is broken off loses nothing."""
    order = list(CURVES)
    rows.sort(key=lambda r: (order.index(r["curve"]), float(r["value"])))
    keys = list(dict.fromkeys(k for r in rows for k in r))
    path = os.path.join(output, p["name"] + ".csv")
    with open(path + ".new", "w", newline="") as file:
        table = csv.DictWriter(file, keys, lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
    os.replace(path + ".new", path)


def measure_all(build, output, plots, jobs, keep):
    """Runs everything that `plots` ask for; with `keep`, what their tables lack."""
    rows = {p["name"]: read(output, p) if keep else [] for p in plots}
    began = time.monotonic()
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        waiting = {}
        for p in plots:
            known = {(r["curve"], r["value"]) for r in rows[p["name"]]}
            for curve in p["curves"]:
                for value in reversed(values_of(p, curve)):
                    if (curve, value) not in known and \
                            os.path.exists(os.path.join(build, CURVES[curve][0][0])):
                        waiting[pool.submit(measure, build, p, curve, value)] = (p, curve, value)
        for n, future in enumerate(concurrent.futures.as_completed(waiting), 1):
            p, curve, value = waiting[future]
            row, complaint = future.result()
            if row is None:
                print(f"report: {p['name']}, {curve}, {value}: {complaint}", file=sys.stderr)
                continue
            rows[p["name"]].append(row)
            write_table(output, p, rows[p["name"]])
            print(f"report: {time.monotonic() - began:5.0f} s  {n}/{len(waiting)}  {p['name']} "
                  f"{curve} {value}", file=sys.stderr)


def read(output, p):
    path = os.path.join(output, p["name"] + ".csv")
    if not os.path.exists(path):
        return []
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    for r in rows:
        r["cost"], r["error"], r["value"] = float(r["cost"]), float(r["error"]), float(r["value"])
    return [r for r in rows if r["curve"] in CURVES]


def is_default(p, row):
    return int(row["value"]) == 240 if p["knob"] == "steps" else \
        int(row["value"]) == (20 if row["curve"] == "ode" else 10)


def shown(error):
    return min(max(error, FLOOR), FALLEN)


def draw(output, p, rows):
    knob = "solver iterations" if p["knob"] == "iterations" else "steps per second"
    figure, axes = frame(p["title"], f"numbers: {knob}; ring: default; lower left is better")
    for curve, (_, label, colour, marker) in CURVES.items():
        points = [r for r in rows if r["curve"] == curve]
        if not points:
            continue
        own = curve in OWN
        axes.plot([r["cost"] for r in points], [shown(r["error"]) for r in points], marker=marker,
                  color=colour, label=label, linewidth=2.2 if own else 1.4, markersize=5.5,
                  zorder=3 if own else 2)
        for r in points:
            if is_default(p, r):
                axes.plot(r["cost"], shown(r["error"]), marker="o", markersize=13,
                          markerfacecolor="none", markeredgecolor=colour, zorder=4)
        for r in (points[0], points[-1]):
            axes.annotate(f"{int(r['value'])}", (r["cost"], shown(r["error"])), fontsize=7.5,
                          color=colour, xytext=(5, 5), textcoords="offset points")
    axes.set_xscale("log")
    axes.set_yscale("log")
    errors = [shown(r["error"]) for r in rows]
    if min(errors) <= FLOOR:
        axes.axhline(FLOOR, color="#bbbbbb", linewidth=0.8, linestyle=":")
        axes.text(0.995, FLOOR * 1.6, "exactly 0", transform=axes.get_yaxis_transform(),
                  fontsize=8, color="#777777", ha="right")
    if p["scene"] in ("heavy", "pyramid") and max(errors) > 0.5:
        axes.axhspan(0.5, max(60, 2 * max(errors)), color="#f3d9d9", zorder=0)
        axes.text(0.01, 0.55, "fallen", transform=axes.get_yaxis_transform(), fontsize=8,
                  color="#aa4444", va="bottom")
    axes.set_xlabel("cost: CPU seconds per simulated second")
    axes.set_ylabel("error: " + p["error"])
    axes.legend(fontsize=8.5, frameon=False, loc="best")
    save(figure, output, p["name"])


def best_within(points, cost):
    """The most precise of the points that cost no more, or None."""
    return min((r for r in points if r["cost"] <= cost), key=lambda r: r["error"], default=None)


def cheapest_within(points, error):
    """The cheapest of the points whose error is no larger, or None."""
    return min((r for r in points if r["error"] <= error), key=lambda r: r["cost"], default=None)


def versus(p, rows, values):
    """For each rival setting, what talus does at no more cost and at no more error."""
    lines = []
    own = [r for r in rows if r["curve"] in OWN]
    for r in rows:
        if r["curve"] in OWN:
            continue
        better, cheaper = best_within(own, r["cost"]), cheapest_within(own, r["error"])
        less_error = None if better is None else \
            float("inf") if better["error"] == 0 else r["error"] / better["error"]
        less_time = None if cheaper is None else r["cost"] / cheaper["cost"]
        if is_default(p, r):
            key = f"{p['name']} {r['curve']}"
            values[key + " error"] = "-" if less_error is None else ratio(less_error)
            values[key + " time"] = "-" if less_time is None else ratio(less_time)
        what = f"{CURVES[r['curve']][1]}, {int(r['value'])}"
        lines.append([f"**{what}**" if is_default(p, r) else what, number(r["cost"]),
                      number(r["error"]), "-" if better is None else describe(better),
                      "-" if less_error is None else ratio(less_error),
                      "-" if cheaper is None else describe(cheaper),
                      "-" if less_time is None else ratio(less_time)])
    knob = "iterations" if p["knob"] == "iterations" else "steps per second"
    return table([f"engine, {knob}", "cost", "error", "talus at no more cost", "error ratio",
                  "talus at no more error", "cost ratio"], lines)


def describe(row):
    return f"{CURVES[row['curve']][1]} {int(row['value'])}: {number(row['error'])} " \
           f"at {number(row['cost'])}"


def defaults(everything):
    """One line a scene: error and cost of every engine at its defaults."""
    head = ["scene", "error is"] + [CURVES[c][1] for c in CURVES]
    lines = []
    for p, rows in everything:
        cells = [p["title"], p["error"]]
        for curve in CURVES:
            at = [r for r in rows if r["curve"] == curve and is_default(p, r)]
            cells.append(f"{number(at[0]['error'])} ({number(at[0]['cost'])})" if at else "-")
        lines.append(cells)
    return table(head, lines)


def validation(output):
    """The checks that the validation tests recorded."""
    path = os.path.join(output, "validation.tsv")
    if not os.path.exists(path):
        return "No table: the validation tests have not been run."
    with open(path) as file:
        lines = [line.rstrip("\n").split("\t") for line in file if line.strip()]
    lines = [line for line in lines if len(line) == 7 and line[0] != "test"]
    return table(["test", "quantity", "expected", "measured", "error", "tolerance", "within"],
                 [line[:6] + ["yes" if line[6] in ("1", "true", "ok", "yes") else "**no**"]
                  for line in lines])


def solve_problems(build, folder, output):
    """Every contact problem of a folder, with each solver; the lines go to fc3d.csv."""
    files = sorted(os.path.join(folder, f) for f in os.listdir(folder)
                   if f.endswith((".dat", ".hdf5")))
    program = os.path.join(build, "fc3d")
    options = subprocess.run([program, "--help"], capture_output=True, text=True).stdout
    done = subprocess.run([program, *files, "--max-seconds", "5"] +
                          (["--siconos"] if "--siconos" in options else []),
                          capture_output=True, text=True)
    lines = [line.lstrip("#").split("\t") for line in done.stdout.splitlines()]
    with open(os.path.join(output, "fc3d.csv"), "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(lines)


def fc3d(output):
    path = os.path.join(output, "fc3d.csv")
    if not os.path.exists(path):
        return "No table: no problems were solved in this run."
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    lines = []
    for solver in dict.fromkeys(r["solver"] for r in rows):
        own = [r for r in rows if r["solver"] == solver]
        solved = [r for r in own if r["converged"] == "1"]
        times = sorted(float(r["cpu_ms"]) for r in own)
        lines.append([solver, f"{len(solved)} of {len(own)}", number(times[len(times) // 2]),
                      number(max((float(r["err_scaled"]) for r in solved), default=0))])
    return table(["solver", "solved", "median CPU ms", "largest err_scaled of the solved"], lines)


def write_page(output, everything):
    values = {"defaults": defaults(everything), "validation": validation(output),
              "fc3d": fc3d(output), "simbench": published.simbench(output),
              "box3d": published.box3d(output)}
    for p, rows in everything:
        values["plot " + p["name"]] = f"![{p['title']}]({p['name']}.svg)"
        values["versus " + p["name"]] = versus(p, rows, values)
    with open(os.path.join(HERE, "words.md")) as file:
        values["words"] = file.read().strip()
    with open(os.path.join(HERE, "page.md")) as file:
        page = file.read()
    for key, text in reversed(values.items()):  # the words ask for values
        page = page.replace("{{" + key + "}}", text)
    page = re.sub("{{(plot|versus) [^}]*}}", "Not measured yet.", page)
    page = re.sub("{{[^}]*}}", "?", page)
    with open(os.path.join(output, "README.md"), "w") as file:
        file.write(page)


def main():
    options = argparse.ArgumentParser(usage=__doc__)
    options.add_argument("build")
    options.add_argument("output")
    options.add_argument("--jobs", type=int, default=2)
    options.add_argument("--fc3d", metavar="FOLDER")
    options.add_argument("--keep", action="store_true")
    options.add_argument("--draw", action="store_true")
    options.add_argument("--list", action="store_true")
    options.add_argument("plots", nargs="*")
    given = options.parse_intermixed_args()
    names = [p["name"] for p in PLOTS] + list(published.TABLES)
    for name in given.plots:
        if name not in names:
            sys.exit(f"report: there is no plot '{name}'; there are: {' '.join(names)}")
    plots = [p for p in PLOTS if not given.plots or p["name"] in given.plots]
    tables = [name for name in published.TABLES if not given.plots or name in given.plots]
    if given.list:
        curves = {CURVES[c][0][0] for p in plots for c in p["curves"]}
        print(*sorted(curves), *published.programs(tables))
        return
    os.makedirs(given.output, exist_ok=True)
    if not given.draw:
        measure_all(given.build, given.output, plots, given.jobs, given.keep)
        published.measure(given.build, given.output, tables, given.keep)
    if given.fc3d:
        solve_problems(given.build, given.fc3d, given.output)
    everything = [(p, read(given.output, p)) for p in PLOTS]
    everything = [(p, rows) for p, rows in everything if rows]
    for p, rows in everything:
        draw(given.output, p, rows)
    write_page(given.output, everything)


if __name__ == "__main__":
    main()
