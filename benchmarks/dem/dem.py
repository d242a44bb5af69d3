"""BED in talus and in other programs of the discrete element method, from the same settled state.

The engines run in turns; a row has the median of their rates. Each rival is a program of its own and
gets a deck and the state as text. Its rate is that of the CPU time of its loop of steps; the state that
it reaches is judged as that of talus is."""
import argparse
import json
import os
import statistics
import subprocess
import sys

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
import beside  # noqa: E402
import liggghts
import lammps
import yade

RIVALS = {"liggghts": liggghts, "lammps": lammps, "yade": yade}
SETTLE = 15000  # steps: 1.2 s


def main():
    options = parse()
    folder = os.path.join(options.build, "bed", f"{options.bodies}_{options.settle}")
    os.makedirs(folder, exist_ok=True)
    engines = {}
    for ranks in options.ranks:
        engines[name_of(ranks)] = lambda ranks=ranks: talus(options, scene, ranks)
    for name in options.rivals:
        if RIVALS[name].program() is None:
            print(f"dem: {name} is left out, it is not installed (apt install {name})",
                  file=sys.stderr)
        else:
            engines[name] = lambda name=name: rival(name, options, scene)
    scene = settled(options, folder)
    runs = {name: [] for name in engines}
    for turn in range(options.turns):
        for name, run in engines.items():
            runs[name].append(run())
            print(f"dem: turn {turn + 1}, {name}: {rate(runs[name][-1]):.3g} particle-steps/s",
                  file=sys.stderr)
    rows = []
    for turns in runs.values():
        row = dict(turns[0])
        row["particle_steps_per_second"] = statistics.median(map(rate, turns))
        row["fastest_turn"] = max(map(rate, turns))
        row["turns"] = options.turns
        rows.append(row)
    beside.write_rows(rows, options.json, indent=2)
    table(rows)


def parse():
    parser = argparse.ArgumentParser(prog="./dev bench dem", allow_abbrev=False)
    parser.add_argument("build", help="folder of the benchmark programs (./dev fills it in)")
    parser.add_argument("--bodies", type=beside.positive, default=8000)
    parser.add_argument("--rivals", type=beside.rivals("dem", RIVALS), default=[], help=",".join(RIVALS))
    parser.add_argument("--json", type=beside.file_for_rows, default="", help="file for the rows")
    parser.add_argument("--steps", type=beside.positive, default=500, help="that are measured")
    parser.add_argument("--turns", type=beside.positive, default=3, help="of which the median counts")
    parser.add_argument("--ranks", type=rank_counts, default=[1], help="of talus, such as 1,2")
    parser.add_argument("--settle", type=beside.positive, default=SETTLE, help="steps before the first turn")
    parser.add_argument("--quick", action="store_true", help="500 bodies, 1 turn of 50 steps")
    options = parser.parse_args()
    if options.quick:
        options.bodies, options.steps, options.turns, options.settle = 500, 50, 1, 2000
    options.build = os.path.abspath(options.build)
    return options


def rank_counts(text):
    return [beside.positive(word) for word in text.split(",")]


def name_of(ranks):
    return "talus" if ranks == 1 else f"talus on {ranks} ranks"


def rate(row):
    return row["particle_steps_per_second"]


def program(options):
    return os.path.join(options.build, "dem")


def settled(options, folder):
    """The settled state, which is kept for later runs; its file and its values."""
    scene = {"folder": folder, "state": os.path.join(folder, "state.txt")}
    values = os.path.join(folder, "state.json")
    if not os.path.exists(values):
        print(f"dem: settling {options.bodies} spheres", file=sys.stderr)
        said = output_of([program(options), "--bodies", str(options.bodies), "--settle",
                          str(options.settle), "--write", scene["state"]])
        with open(values, "w") as file:
            file.write(said)
    with open(values) as file:
        scene.update(json.load(file))
    with open(scene["state"]) as file:
        scene["lines"] = [line.split() for line in file]
    return scene


def talus(options, scene, ranks):
    words = [program(options), "--bodies", str(options.bodies), "--from", scene["state"],
             "--measure", str(options.steps), "--parts", "1"]
    if ranks > 1:
        words = ["mpirun", "-q", "-n", str(ranks), "--oversubscribe", *words]
    row = json.loads(output_of(words))
    row["engine"] = name_of(ranks)
    return row


def rival(name, options, scene):
    engine = RIVALS[name]
    folder = os.path.join(scene["folder"], name)
    os.makedirs(folder, exist_ok=True)
    moved = os.path.join(folder, "moved.txt")
    if os.path.exists(moved):
        os.remove(moved)
    seconds = engine.run(scene, options.steps, folder, moved, output_of)
    row = {"engine": name, "bodies": options.bodies, "ranks": 1, "dt": scene["dt"],
           "steps": options.steps,
           "particle_steps_per_second": options.bodies * options.steps / seconds}
    row.update(json.loads(output_of(
        [program(options), "--bodies", str(options.bodies), "--from", scene["state"],
         "--judge", moved])))
    return row


def output_of(words, folder=None):
    """What a command prints; ends the program with its complaint if it fails."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "OMPI_ALLOW_RUN_AS_ROOT": "1",
                   "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                   "OMPI_MCA_btl_vader_single_copy_mechanism": "none"}
    done = subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"dem: {' '.join(words)} failed:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


def table(rows):
    alone = rate(rows[0])
    print(f"{'engine':16} {'particle-steps/s':>17} {'talus/it':>9} {'contacts':>9} "
          f"{'overlap_mean':>13} {'energy/body':>12}", file=sys.stderr)
    for row in rows:
        print(f"{row['engine']:16} {rate(row):17.4g} {alone / rate(row):9.2f} "
              f"{row.get('contacts', '-'):>9} {row.get('overlap_mean', '-'):>13} "
              f"{row.get('kinetic_energy_per_body', '-'):>12}", file=sys.stderr)


if __name__ == "__main__":
    main()
