"""Mechanisms with joints in talus and in other engines: error against CPU time.

Each engine is a program of its own (runner.hpp), joints_NAME beside the other benchmarks. The programs
run in turns; a row has the median of the CPU seconds. An engine that is not built is left out."""
import argparse
import json
import os
import statistics
import subprocess
import sys
import time

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
import beside  # noqa: E402

RIVALS = ["mujoco", "simbody", "dart", "ode", "bullet"]
ENGINES = ["talus", *RIVALS]
COLUMNS = ["scene", "engine", "integrator", "dt", "cpu_seconds", "error", "error_is",
           "joint_drift_max", "energy_drift"]
LONGEST = 120  # seconds of a run; what takes longer is left out


def main():
    options = parse()
    runs, exact = [], {}
    for engine in ["talus", *options.rivals]:
        runs += plans(engine, options)
    runs.sort(key=lambda run: run[1])  # engines of a scene one after the other
    rows = {run: [] for run in runs}
    ends = time.monotonic() + options.within if options.within else float("inf")
    for turn in range(options.turns):
        for run in runs:
            if rows[run] is None or (turn and time.monotonic() > ends):
                continue
            if time.monotonic() > ends:
                print(f"joints: {' '.join(run)} is left out, the time is over", file=sys.stderr)
                rows[run] = None
                continue
            row = measured(options, *run)
            if row is None:
                rows[run] = None
                continue
            rows[run].append(row)
    found = []
    for run, turns in rows.items():
        if turns:
            row = dict(turns[0])
            row["cpu_seconds"] = statistics.median(turn["cpu_seconds"] for turn in turns)
            scene = row["scene"]
            if scene not in exact:
                exact[scene] = reference(options, scene)
            row["error"] = error_of(row, exact[scene])
            found.append({name: row[name] for name in COLUMNS})
    beside.write_rows(found, options.json)
    if options.json:
        stem = os.path.splitext(os.path.abspath(options.json))[0]
        plot(found, stem)
        with open(stem + ".md", "w") as file:
            file.write(page(found, options, os.path.basename(stem)))
    table(found)


def parse():
    parser = argparse.ArgumentParser(prog="./dev bench joints", allow_abbrev=False)
    parser.add_argument("build", help="folder of the benchmark programs (./dev fills it in)")
    parser.add_argument("--rivals", type=beside.rivals("joints", RIVALS), default=[], help=",".join(RIVALS))
    parser.add_argument("--scenes", type=lambda text: text.split(","), default=[],
                        help="only scenes whose names begin so, such as A01,chain")
    parser.add_argument("--json", type=beside.file_for_rows, default="", help="file for the rows; plots and a page of tables go beside it")
    parser.add_argument("--turns", type=beside.positive, default=3, help="of which the median counts")
    parser.add_argument("--quick", action="store_true",
                        help="one turn, large steps; ends within five minutes")
    parser.add_argument("--within", type=float, default=0, metavar="SECONDS",
                        help="after which no run begins; 0: none, 200 with --quick")
    options = parser.parse_args()
    if options.within < 0:
        parser.error(f"--within needs seconds, not {options.within:g}")
    options.build = os.path.abspath(options.build)
    if options.quick:
        options.turns, options.within = 1, options.within or 200
    return options


def program(options, name):
    return os.path.join(options.build, f"joints_{name}")


def plans(engine, options):
    """The runs of an engine: (engine, scene, integrator, dt) as text."""
    if not os.path.exists(program(options, engine)):
        print(f"joints: {engine} is left out, its program is not built", file=sys.stderr)
        return []
    words = [program(options, engine), "--list"] + (["--quick"] if options.quick else [])
    runs = []
    for line in subprocess.run(words, check=True, capture_output=True,
                               text=True).stdout.splitlines():
        if line.startswith("#"):
            print(f"joints: {engine} leaves out {line[1:].strip()}", file=sys.stderr)
        elif not options.scenes or line.startswith(tuple(options.scenes)):
            runs.append((engine, *line.split()))
    return runs


def measured(options, engine, scene, integrator, dt):
    """The row of a run; None if it fails or takes too long."""
    words = [program(options, engine), "--scene", scene, "--integrator", integrator, "--dt", dt]
    longest = min(LONGEST, options.within / 6) if options.quick else LONGEST
    try:
        done = subprocess.run(words, capture_output=True, text=True, timeout=longest,
                              cwd=options.build)
    except subprocess.TimeoutExpired:
        print(f"joints: {engine} {scene} {integrator} {dt} takes longer than {longest:g} s",
              file=sys.stderr)
        return None
    if done.returncode != 0:
        print(f"joints: {engine} {scene} {integrator} {dt} fails: {done.stderr[-300:].strip()}",
              file=sys.stderr)
        return None
    try:
        return json.loads(done.stdout.splitlines()[-1])
    except (IndexError, ValueError):
        print(f"joints: {engine} {scene} {integrator} {dt} prints no row", file=sys.stderr)
        return None


def reference(options, scene):
    done = subprocess.run([program(options, "reference"), scene], check=True, capture_output=True,
                          text=True)
    return json.loads(done.stdout)


def error_of(row, exact):
    """Largest distance of a probe from the reference; scenes without one: the gap, in lengths."""
    if not exact:
        drift = row["joint_drift_max"]
        return None if drift is None else drift / row["length"]
    if len(row["samples"]) != len(exact) or any(not sample for sample in row["samples"]):
        return None
    most = 0.0
    for values, wanted in zip(row["samples"], exact):
        for i in range(0, len(wanted), 3):
            apart = sum((a - b) ** 2 for a, b in zip(values[i:i + 3], wanted[i:i + 3])) ** 0.5
            most = max(most, apart)
    return most


def said(value):
    return "-" if value is None else f"{value:.3g}"


def table(rows):
    print(f"{'scene':10} {'engine':8} {'integrator':26} {'dt':>7} {'CPU s':>9} {'error':>9} "
          f"{'gap':>9} {'energy':>9}", file=sys.stderr)
    for row in sorted(rows, key=lambda row: row["scene"]):
        print(f"{row['scene']:10} {row['engine']:8} {row['integrator']:26} {row['dt']:>7g} "
              f"{said(row['cpu_seconds']):>9} {said(row['error']):>9} "
              f"{said(row['joint_drift_max']):>9} {said(row['energy_drift']):>9}", file=sys.stderr)


def page(rows, options, stem):
    """The rows as a page: a table for each scene, and where talus has no run that is better."""
    command = "./dev bench joints" + " --quick" * options.quick
    command += f" --within {options.within:g}" * (options.quick and options.within != 200)
    command += f" --scenes {','.join(options.scenes)}" * bool(options.scenes)
    command += f" --rivals {','.join(options.rivals)} --json {stem}.json"
    text = ["# Mechanisms with joints", "",
            f"Written by `{command}`. "
            f"{'One turn' if options.turns == 1 else f'Medians of {options.turns} turns'} on one "
            "core, CPU seconds; `-` is a value that is not finite, or an energy that is not "
            "conserved.", ""]
    for scene in sorted({row["scene"] for row in rows}):
        own = [row for row in rows if row["scene"] == scene]
        text += [f"## {scene}", "", f"Error: {own[0]['error_is']}.", ""]
        others = [row for row in own if row["engine"] != "talus" and row["error"] is not None]
        better = [row for row in others if not any(
            x["engine"] == "talus" and x["error"] is not None and x["error"] <= row["error"] and
            x["cpu_seconds"] <= row["cpu_seconds"] for x in own)]
        if others and len(others) < len(own):
            names = sorted({f"{row['engine']} {row['integrator']}" for row in better})
            text += [f"Of {len(others)} runs of other engines {len(others) - len(better)} are both "
                     "slower and less accurate than a run of talus"
                     f"{'; at least one run of each of these is not: ' + ', '.join(names) if names else ''}.", ""]
        if os.path.exists(f"{os.path.splitext(os.path.abspath(options.json))[0]}_{scene}.png"):
            text += [f"![{scene}]({stem}_{scene}.png)", ""]
        text += ["| engine | integrator | dt, s | CPU, s | error | largest gap, m | energy, J |",
                 "|---|---|---|---|---|---|---|"]
        for row in sorted(own, key=lambda row: (row["error"] is None, row["error"])):
            text.append(f"| {row['engine']} | {row['integrator']} | {row['dt']:g} | "
                        f"{row['cpu_seconds']:.3g} | {said(row['error'])} | "
                        f"{said(row['joint_drift_max'])} | {said(row['energy_drift'])} |")
        text.append("")
    return "\n".join(text)


def plot(rows, stem):
    """A picture for each scene, STEM_SCENE.png, if there is matplotlib."""
    pyplot = beside.pyplot()
    if not pyplot:
        return
    for scene in sorted({row["scene"] for row in rows}):
        curves = {}
        for row in rows:
            if row["scene"] == scene and row["error"] and row["cpu_seconds"] > 0:
                name = row["integrator"].rsplit("_1e-", 1)[0]
                curves.setdefault(f"{row['engine']}, {name}", []).append(
                    (row["cpu_seconds"], row["error"]))
        figure, axes = pyplot.subplots()
        for name, points in curves.items():
            axes.loglog(*zip(*sorted(points)), "o-", label=name)
        axes.set_xlabel("CPU time, s")
        axes.set_ylabel(next(row["error_is"] for row in rows if row["scene"] == scene))
        axes.set_title(scene)
        if curves:
            axes.legend()
        figure.savefig(f"{stem}_{scene}.png", dpi=120)
        pyplot.close(figure)


if __name__ == "__main__":
    main()
