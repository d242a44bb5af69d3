"""BED in talus and in the programs of the field: from the same settled state, in turns, one core.

Each rival is a program of its own and gets a deck and the state as text. Its rate is that of the CPU
time of its loop of steps; the state that it reaches is judged as that of talus is."""
import argparse
import json
import os
import statistics
import subprocess
import sys

import liggghts
import lammps
import yade

RIVALS = {"liggghts": liggghts, "lammps": lammps, "yade": yade}
SETTLE = 15000  # steps: 1.2 s


def main():
    options = parse()
    unknown = [name for name in options.rivals if name not in RIVALS]
    if unknown:
        sys.exit(f"dem: no '{unknown[0]}' runs 'dem'; its rivals are: {', '.join(RIVALS)}")
    folder = os.path.join(options.build, "bed", str(options.bodies))
    os.makedirs(folder, exist_ok=True)
    scene = settled(options, folder)
    engines = {"talus": lambda: talus(options, scene)}
    for name in options.rivals:
        program = RIVALS[name].program()
        if program is None:
            sys.exit(f"dem: {name} is not installed (apt install {name})")
        engines[name] = lambda name=name: rival(name, options, scene)
    if options.ranks > 1:
        engines[f"talus on {options.ranks} ranks"] = lambda: talus(options, scene, options.ranks)
    runs = {name: [] for name in engines}
    for turn in range(options.turns):
        for name, run in engines.items():
            runs[name].append(run())
            print(f"dem: turn {turn + 1}, {name}: {rate(runs[name][-1]):.3g} particle-steps/s",
                  file=sys.stderr)
    # The fastest turn: other programs on the machine only slow one down.
    rows = [max(all_turns, key=rate) for all_turns in runs.values()]
    for row, all_turns in zip(rows, runs.values()):
        row["median_of_turns"] = statistics.median(map(rate, all_turns))
    text = "[\n" + ",\n".join(json.dumps(row, indent=2) for row in rows) + "\n]\n"
    if options.json:
        with open(options.json, "w") as file:
            file.write(text)
    else:
        print(text, end="")
    table(rows)


def parse():
    parser = argparse.ArgumentParser(prog="./dev bench dem")
    parser.add_argument("build", help="folder of the benchmark programs")
    parser.add_argument("--bodies", type=int, default=8000)
    parser.add_argument("--rivals", type=lambda text: [x for x in text.split(",") if x], default=[])
    parser.add_argument("--json", default="", help="file for the rows")
    parser.add_argument("--steps", type=int, default=500, help="that are measured")
    parser.add_argument("--turns", type=int, default=3, help="of which the fastest counts")
    parser.add_argument("--ranks", type=int, default=1, help="measure talus on these too")
    options = parser.parse_args()
    options.build = os.path.abspath(options.build)
    return options


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
        said = output_of([program(options), "--bodies", str(options.bodies), "--settle", str(SETTLE),
                          "--write", scene["state"]])
        with open(values, "w") as file:
            file.write(said)
    with open(values) as file:
        scene.update(json.load(file))
    with open(scene["state"]) as file:
        scene["lines"] = [line.split() for line in file]
    return scene


def talus(options, scene, ranks=1):
    words = [program(options), "--bodies", str(options.bodies), "--from", scene["state"],
             "--measure", str(options.steps), "--parts", "1"]
    if ranks > 1:
        words = ["mpirun", "-q", "-n", str(ranks), "--oversubscribe", *words]
    row = json.loads(output_of(words))
    if ranks > 1:
        row["engine"] = f"talus on {ranks} ranks"
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
    print(f"{'engine':16} {'particle-steps/s':>17} {'talus/it':>9} {'contacts':>9} "
          f"{'overlap_mean':>13} {'energy/body':>12}", file=sys.stderr)
    for row in rows:
        print(f"{row['engine']:16} {rate(row):17.4g} {rate(rows[0]) / rate(row):9.2f} "
              f"{row.get('contacts', '-'):>9} {row.get('overlap_mean', '-'):>13} "
              f"{row.get('kinetic_energy_per_body', '-'):>12}", file=sys.stderr)


if __name__ == "__main__":
    main()
