"""Measured tosses of a cube in talus and in other engines, with two fitted numbers each.

Each engine is a program of its own (runner.hpp), tosses_NAME beside the other benchmarks. Friction and
restitution are fitted on the tosses with even numbers; those with odd numbers judge, if the file has any."""
import argparse
import gzip
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
import beside  # noqa: E402

RIVALS = ["mujoco", "bullet", "ode", "dart"]
# The grid of the fit, then the smallest steps of its refinement.
FRICTIONS = [0.06 + 0.06 * i for i in range(6)]
RESTITUTIONS = [0.1 * i for i in range(5)]
STEP, FINEST = (0.03, 0.05), 0.007


def main():
    options = parse()
    with tempfile.TemporaryDirectory() as folder:
        table = os.path.join(folder, "tosses.csv")
        opened = gzip.open if options.data.endswith(".gz") else open
        with opened(options.data, "rb") as source, open(table, "wb") as plain:
            shutil.copyfileobj(source, plain)
        judges = halves(table)
        engines = [engine(options, name, table) for name in ["talus", *options.rivals]]
        engines = [one for one in engines if one]
        fitted = [(one, *fit(one, options)) for one in engines]
        turns = [[] for _ in fitted]
        for _ in range(options.turns):
            for rows, (one, best, _) in zip(turns, fitted):
                rows.append(one.ask(best["friction"], best["restitution"], judges))
        found = []
        for rows, (one, best, tried) in zip(turns, fitted):
            row = dict(rows[0], judged_on=judges, fit_objective=best["objective"], substeps=options.substeps,
                       cpu_seconds=statistics.median(row["cpu_seconds"] for row in rows))
            row["cpu_us_per_step"] = round(1e6 * row["cpu_seconds"] / row["steps"], 3)
            row["tried"] = sorted([t["friction"], t["restitution"], t["objective"]] for t in tried)
            found.append(row)
            one.close()
    beside.write_rows(found, options.json)
    if options.json:
        plot(found, os.path.splitext(options.json)[0] + ".svg")
    show(found)


def parse():
    parser = argparse.ArgumentParser(prog="./dev bench tosses", allow_abbrev=False)
    parser.add_argument("build", help="folder of the benchmark programs (./dev fills it in)")
    parser.add_argument("--data", required=True, metavar="FILE", help="table of frames, .csv or .csv.gz")
    parser.add_argument("--rivals", type=beside.rivals("tosses", RIVALS), default=[], help=",".join(RIVALS))
    parser.add_argument("--json", type=beside.file_for_rows, default="", help="file for the rows; a figure goes beside it")
    parser.add_argument("--substeps", type=beside.positive, default=4, help="time steps between two frames")
    parser.add_argument("--turns", type=beside.positive, default=3, help="of which the median of the CPU time counts")
    parser.add_argument("--quick", action="store_true", help="one step a frame, one turn, no refinement")
    options = parser.parse_args()
    if options.quick:
        options.substeps = options.turns = 1
    if not os.path.isfile(options.data):
        parser.error(f"there is no file --data {options.data}")
    return options


def halves(table):
    """The half that judges: odd, or even if there are no others."""
    with open(table) as file:
        next(file, None)
        return "odd" if any(int(line.split(",", 1)[0]) % 2 for line in file if line.strip()) else "even"


class engine_program:
    """The program of an engine: a line with two numbers in, a row out."""

    def __init__(self, name, words):
        self.name = name
        self.process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(self, friction, restitution, half):
        self.process.stdin.write(f"{friction:.6g} {restitution:.6g} {half}\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        if not line:
            sys.exit(f"tosses: {self.name} fails at friction {friction:g}, restitution {restitution:g}")
        return json.loads(line)

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def engine(options, name, table):
    program = os.path.join(os.path.abspath(options.build), f"tosses_{name}")
    if not os.path.exists(program):
        print(f"tosses: {name} is left out, its program is not built", file=sys.stderr)
        return None
    return engine_program(name, [program, "--file", table, "--substeps", str(options.substeps)])


def fit(one, options):
    """The row with the smallest objective and all that were tried: a grid, then steps to the best of eight
    neighbours, halved where none is better."""
    rows = {}

    def at(friction, restitution):
        place = (round(max(friction, 0), 6), round(min(max(restitution, 0), 1), 6))
        if place not in rows:
            rows[place] = one.ask(*place, "even")
        return rows[place]

    best = min((at(mu, e) for mu in FRICTIONS for e in RESTITUTIONS), key=lambda row: row["objective"])
    step = STEP
    while not options.quick and step[0] >= FINEST:
        near = min((at(best["friction"] + i * step[0], best["restitution"] + j * step[1])
                    for i in (-1, 0, 1) for j in (-1, 0, 1)), key=lambda row: row["objective"])
        if near["objective"] < best["objective"]:
            best = near
        else:
            step = (step[0] / 2, step[1] / 2)
    return best, list(rows.values())


def show(rows):
    print(f"{'engine':8} {'mu':>6} {'e':>6} {'edges':>7} {'degrees':>8} {'faces':>6} {'CPU s':>7} {'us/step':>8}",
          file=sys.stderr)
    for row in rows:
        print(f"{row['engine']:8} {row['friction']:6.3f} {row['restitution']:6.3f} {row['distance']:7.3f} "
              f"{row['angle']:8.2f} {row['faces']:6.3f} {row['cpu_seconds']:7.3f} "
              f"{row['cpu_us_per_step']:8.2f}", file=sys.stderr)
    if rows:
        print(f"fitted on the even tosses, judged on the {rows[0]['judged_on']} ones", file=sys.stderr)


def plot(rows, file):
    """Errors over time, and the objective over friction at the best restitution, if there is matplotlib."""
    pyplot = beside.pyplot()
    if not pyplot:
        return
    pyplot.rcParams["font.size"] = 9
    figure, axes = pyplot.subplots(1, 3, figsize=(10, 3.2))
    for row in rows:
        seconds = [k / 148 for k in range(len(row["distances"]))]
        axes[0].plot(seconds, row["distances"], label=row["engine"])
        axes[1].plot(seconds, row["angles"], label=row["engine"])
        least = {}
        for friction, _, objective in row["tried"]:
            least[friction] = min(objective, least.get(friction, objective))
        axes[2].plot(*zip(*sorted(least.items())), ".-", label=row["engine"])
    for axis, across, up in zip(axes, ("time (s)", "time (s)", "friction"),
                                ("distance of the centres (edges)", "angle (degrees)",
                                 "objective, least over restitution")):
        axis.set_xlabel(across)
        axis.set_ylabel(up)
        axis.set_ylim(bottom=0)
    axes[0].legend(frameon=False)
    figure.tight_layout()
    figure.savefig(file, metadata={"Date": None})
    pyplot.close(figure)


if __name__ == "__main__":
    main()
