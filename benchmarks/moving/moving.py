"""Scenes in which bodies move, each over its whole run: the default solver beside its sweeps alone.

Settled piles say little about moving scenes. Examples run as a user runs them; POUR and the washer are
programs beside the other benchmarks, POUR and WELL also in other engines. Of several turns the one with
the least CPU time counts."""
import argparse
import csv
import json
import os
import shutil
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
import beside  # noqa: E402

RIVALS = ["bullet", "ode"]
EXAMPLES = {"well": 6000, "drum": 5000, "hourglass": None, "landslide": None, "silo": None, "rubble": None}
POURS = {"pour_0.9": (0.45, 0.5), "pour_0.6": (0.3, 0.5), "pour_0.5": (0.25, 0.5), "pour_0.4": (0.2, 0.5),
         "pour_0.2": (0.1, 0.5), "pour_lognormal": (0.5 / 30, 0.5)}
SCENES = [*EXAMPLES, *POURS, "washer"]
SOLVERS = {"default": "nonlinear_gauss_seidel", "sweeps alone": "coloured_gauss_seidel"}
SAMPLE = 24  # steps from one look at the overlaps to the next
QUICK = 20  # part of the steps of a quick run
COLUMNS = ["scene", "engine", "solver", "steps", "cpu_seconds", "median_ms", "p99_ms", "longest_ms",
           "overlap_of_run", "overlap_at_end", "unstopped_momentum", "instructions", "warnings"]


def parse():
    parser = argparse.ArgumentParser(prog="./dev bench moving", description=__doc__.split("\n")[0],
                                     allow_abbrev=False)
    parser.add_argument("build", help="folder of the benchmark programs (./dev fills it in)")
    parser.add_argument("--rivals", type=beside.rivals("moving", RIVALS), default=[], help=",".join(RIVALS))
    parser.add_argument("--scenes", type=lambda text: text.split(","), default=SCENES, help=",".join(SCENES))
    parser.add_argument("--json", type=beside.file_for_rows, default="", help="file for the rows")
    parser.add_argument("--turns", type=beside.positive, default=1, help="of which the fastest counts")
    parser.add_argument("--quick", action="store_true", help="the first steps of each scene alone")
    parser.add_argument("--list", action="store_true", help="name the targets to build, and stop")
    options = parser.parse_args()
    for scene in options.scenes:
        if scene not in SCENES:
            parser.error(f"there is no scene '{scene}'; there are: {', '.join(SCENES)}")
    options.build = os.path.abspath(options.build)
    options.counts = counts_instructions()
    return options


def counts_instructions():
    """Whether perf counts instructions here; virtual machines often have no counter."""
    if shutil.which("perf") is None:
        return False
    done = subprocess.run(["perf", "stat", "-x,", "-e", "instructions:u", "true"], capture_output=True, text=True)
    return done.returncode == 0 and done.stderr.split(",")[0].isdigit()


def finished(options, words, folder):
    """Runs a program: its output, and the instructions it took, None where nothing counts them."""
    counted = os.path.join(folder, "counted")
    if options.counts:
        words = ["perf", "stat", "-x,", "-o", counted, "-e", "instructions:u", "--", *words]
    done = subprocess.run(words, capture_output=True, text=True, cwd=folder)
    if done.returncode != 0:
        sys.exit(f"moving: {' '.join(words)} fails: {done.stderr[-500:].strip()}")
    instructions = None
    if options.counts:
        with open(counted) as file:
            first = [line.split(",")[0] for line in file if "instructions" in line]
        instructions = int(first[0]) if first and first[0].isdigit() else None
    return done.stdout, instructions


def of_example(options, name, solver):
    """The row of an example that runs as it stands; None if it has no sweeps alone."""
    program = os.path.join(os.path.dirname(options.build), "examples", name, name)
    text = subprocess.run([program, "--help"], capture_output=True, text=True, check=True).stdout
    if solver != "default" and "--reproducible" not in text:
        return None
    words = [program, "--json", "found.json", "--csv", "found.csv", "--csv-every", str(SAMPLE)]
    if options.quick:
        steps = next(line.split("=")[1].split()[0] for line in text.splitlines() if "--steps" in line)
        words += ["--steps", str(max(1, int(steps) // QUICK))]
    if solver != "default":
        words.append("--reproducible")
    with tempfile.TemporaryDirectory() as folder:
        said, instructions = finished(options, words, folder)
        with open(os.path.join(folder, "found.json")) as file:
            found = json.load(file)
        with open(os.path.join(folder, "found.csv")) as file:
            lines = list(csv.DictReader(file))
    overlap = next((key for key in lines[0] if key.startswith("penetration_mean")), None)
    return {"engine": "talus", "steps": found["steps"], "cpu_seconds": found["cpu_seconds"],
            "median_ms": 1e3 * found["cpu_seconds_per_step_median"],
            "p99_ms": 1e3 * found["cpu_seconds_per_step_p99"],
            "longest_ms": 1e3 * found["cpu_seconds_per_step_longest"],
            "overlap_of_run": sum(float(line[overlap]) for line in lines[1:]) / max(1, len(lines) - 1),
            "overlap_at_end": found["penetration_mean"],
            "unstopped_momentum": found.get("balance_unstopped"), "instructions": instructions,
            "warnings": sum(line.startswith("  warning") for line in said.splitlines())}


def of_program(options, program, words):
    """The row of a benchmark program."""
    with tempfile.TemporaryDirectory() as folder:
        said, instructions = finished(options, [os.path.join(options.build, program), *words], folder)
    found = json.loads(said)
    return {"engine": found["engine"], "steps": found["steps"], "cpu_seconds": found["cpu_seconds"],
            "median_ms": found["cpu_ms_per_step_median"], "p99_ms": found["cpu_ms_per_step_p99"],
            "longest_ms": found["cpu_ms_per_step_longest"], "overlap_of_run": found["mean_overlap_of_run"],
            "overlap_at_end": found["penetration_mean"],
            "unstopped_momentum": found.get("balance_unstopped"), "instructions": instructions,
            "warnings": None}


def words_of(options, scene):
    """The options of the program of a scene that is no example."""
    steps, words = 1000, []
    if scene in POURS:
        steps = 960
        words = ["--smallest", str(POURS[scene][0]), "--largest", str(POURS[scene][1])]
        if scene == "pour_lognormal":
            words += ["--lognormal", "1"]
    return [*words, "--steps", str(max(1, steps // QUICK) if options.quick else steps)]


def runs_of(options, scene):
    """Names of the columns of a scene, each with a function that runs it once."""
    runs = []
    for solver, method in SOLVERS.items():
        if scene in EXAMPLES:
            runs.append((solver, lambda solver=solver: of_example(options, scene, solver)))
        else:
            program = "pour" if scene in POURS else scene
            words = ["--solver", method, *words_of(options, scene)]
            runs.append((solver, lambda words=words, program=program: of_program(options, program, words)))
    for rival in options.rivals if scene in POURS else []:
        program = f"pour_{rival}"
        if os.path.exists(os.path.join(options.build, program)):
            runs.append((rival, lambda program=program: of_program(options, program, words_of(options, scene))))
    return runs


def main():
    options = parse()
    if options.list:
        print(*targets(options))
        return
    if not options.counts:
        print("moving: nothing counts instructions here (perf stat -e instructions:u)", file=sys.stderr)
    rows = []
    for scene in options.scenes:
        best = {}
        for turn in range(options.turns):
            for name, run in runs_of(options, scene):
                print(f"moving: {scene}, {name}" + (f", turn {turn + 1}" if options.turns > 1 else ""),
                      file=sys.stderr)
                row = run()
                if row and (name not in best or row["cpu_seconds"] < best[name]["cpu_seconds"]):
                    best[name] = row
        for name, row in best.items():
            row = {"scene": scene, **row, "solver": name if name in SOLVERS else "its own"}
            rows.append({key: row[key] for key in COLUMNS})
            print(line_of(rows[-1]), file=sys.stderr)
    beside.write_rows(rows, options.json)
    table(rows)


def targets(options):
    """The programs of the scenes, as targets of the build."""
    named = [f"example_{scene}" for scene in options.scenes if scene in EXAMPLES]
    if any(scene in POURS for scene in options.scenes):
        named += ["bench_pour", *(f"bench_pour_{rival}" for rival in options.rivals)]
    return named + (["bench_washer"] if "washer" in options.scenes else [])


def line_of(row):
    return (f"moving: {row['scene']}, {row['engine']}, {row['solver']}: {row['cpu_seconds']:.3g} s, "
            f"mean overlap {row['overlap_of_run']:.2g}")


def table(rows):
    """The rows on the standard error, each over the sweeps alone of its scene."""
    alone = {row["scene"]: row for row in rows if row["solver"] == "sweeps alone"}
    heads = ["scene", "engine", "solver", "CPU s", "median ms", "p99 ms", "longest ms", "overlap of run",
             "at end", "unstopped", "instructions", "warnings", "CPU/sweeps", "longest/sweeps"]
    lines = [heads]
    for row in rows:
        words = [row["scene"], row["engine"], row["solver"]]
        for key in COLUMNS[4:]:
            words.append("-" if row[key] is None else f"{row[key]:.3g}" if key != "warnings" else str(row[key]))
        base = alone.get(row["scene"])
        for key in ["cpu_seconds", "longest_ms"]:
            words.append(f"{row[key] / base[key]:.2f}" if base and base[key] else "-")
        lines.append(words)
    widths = [max(len(line[k]) for line in lines) for k in range(len(heads))]
    for line in lines:
        print("  ".join(word.ljust(width) if k < 3 else word.rjust(width)
                        for k, (word, width) in enumerate(zip(line, widths))), file=sys.stderr)


if __name__ == "__main__":
    main()
