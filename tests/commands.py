#!/usr/bin/env python3
"""Runs the commands of the documentation: in a copy of the project, by a bash of its own.

Of every *.md that is part of the project: each line of a block that has no language or `sh`, in the order
of the page, from the folder to which the lines before have changed; then each command within the text,
from the folder after the blocks before it. Differences from a user's session: programs make fewer steps,
long measurements, drawings and tests run only in part (INSTEAD), the home folder is SCRATCH, srun is a
stand-in, and CTest allows mpirun as root and with more ranks than cores. A block that is quoted from a
file is tested by the test of that file.
  commands.py ROOT SCRATCH people|measures|habits|all [--list] [FILE.md ...]
`people`: running, drawing, projects; `measures`: benchmarks and reports; `habits`: what contributors do.
"""
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

STEPS = 40
PROGRAMS = r"(/dev run \w|\./build/heap\b|srun )"
COMMAND = re.compile(
    r"(TALUS_\w+=\S+ )?(\./dev|~/|(\./)?build/|cd |cmake |ctest |mpirun -|srun |xvfb-run |apt-get |"
    r"(/usr/bin/)?python3 |git )\S*")
# A file whose name is quoted, without a command.
NAMED = re.compile(r"(~/|(\./)?build/)[\w/.]*$")
WAY = re.compile(r"cd \S+$")  # to where the next commands are
LANGUAGES = {"": True, "sh": True, "cpp": False, "cmake": False, "python": False, "text": False, "toml": False}
MINUTES = 30  # that a command may take

# Commands that would take too long, or are patterns with names to be filled in, and their replacements.
INSTEAD = {
    "./dev test": None, "./dev test --long": None,  # .ci/run is the one, and this is part of the other
    "./dev test [PATTERN] [--long]": None,
    "./dev test 'sleeping|joints'": None,
    "./dev new NAME": "./dev new shore",
    "./dev run shaker --config shaker.toml":
        "printf 'steps = 20\\n[grain]\\nfriction = 0.6\\n' >shaker.toml && "
        "./dev run shaker --config shaker.toml",
    "./dev run shaker --config shaker.toml --set iterations=20 --set grain.friction=0.3 --seed 7":
        "./dev run shaker --config shaker.toml --set iterations=5 --set grain.friction=0.3 --seed 7",
    "./dev new --python": None,  # named, not typed
    "./dev new --python heap": "./dev new --python waves",
    "./dev sweep": None,
    "./dev sweep NAME --vary OPTION=VALUES": "./dev sweep drop --vary iterations=5,10 --out ~/swept -- --steps 40",
    "./dev sweep --collect DIR": "./dev sweep --collect ~/swept",
    "./dev sweep cards --vary friction=0.3:0.42:7 --vary lean=20,25 --jobs 2":
        "./dev sweep cards --vary friction=0.3:0.42:2 --jobs 2 -- --steps 40 --ranks 1",
    "./dev sweep ./build/heap --vary iterations=5,10,20 --repeat 10 -n 16 --slurm --time 02:00:00 --jobs 8":
        "./dev sweep drop --vary iterations=5,10,20 --repeat 10 -n 16 --slurm --time 02:00:00 --jobs 8 && "
        "bash -n sweep_drop/sweep.sh",
    "./dev run NAME [-n RANKS] [OPTIONS]": "./dev run drop -n 2 --seed 3",
    "./dev run NAME --movie FILE": "./dev run drop --movie ~/drop.gif --every 100",
    "./dev run heap --movie heap.mp4 --every 20": "./dev run drop --movie ~/drop.mp4 --every 100",
    "./dev run hopper --movie hopper.mp4 --every 20": "./dev run hopper --movie ~/hopper.mp4 --every 100",
    "./dev render DIR --movie FILE.gif --rate 10": "./dev render ~/heap/pictures --movie ~/heap.gif --rate 10",
    "./dev run NAME -n RANKS": "./dev run drop -n 3",
    "./dev render DIR": "./dev render ~/heap/pictures",
    "./dev render DIR [--frame N] [--quality fast]": "./dev render ~/heap/pictures --frame last --quality fast",
    "./dev view OUTPUT [--html FILE] [--serve PORT]":
        "./dev run hopper --output ~/seen --output-every 20 && ./dev view ~/seen --html ~/seen.html",
    "python3 tests/view/measure.py PAGE.html": None,  # minutes of a browser
    "./dev view hopper --serve 8000": None,  # it serves until it is ended
    "./dev gallery": "./dev gallery cards",
    "./dev compile-cost": "./dev compile-cost --runs 1",
    "./dev bench": "./dev bench --quick",
    "./dev bench --only ranks": "./dev bench --quick --only ranks",
    "./dev bench --only shapes": "./dev bench --quick --only shapes",
    "./dev bench --only precision": "./dev bench --quick --only precision",
    r"./dev bench [--only PART,...] [--full] [--keep\|--draw]": "./dev bench --quick --only sizes",
    "./dev bench NAME [--rivals bullet,ode] [--json FILE]":
        "./dev bench pile --bodies 300 --rivals bullet,ode --json ~/pile.json",
    "./dev bench fc3d [--siconos] [--tol T] FILES": "./dev bench fc3d --tol 1e-4 {problem}",
    "./dev bench fc3d FILES": "./dev bench fc3d {problem}",
    "./dev bench dem --bodies N --rivals liggghts,lammps --json FILE":
        "./dev bench dem --quick --rivals liggghts,lammps --json ~/dem.json",
    "./dev bench joints --rivals simbody,mujoco,dart,ode,bullet --json FILE":
        "./dev bench joints --quick --scenes A01 --rivals ode --json ~/joints.json",
    "./dev bench joints --quick --rivals mujoco,simbody,dart,ode,bullet --json joints.json":
        "./dev bench joints --quick --scenes A01 --rivals ode --json ~/joints.json",
    "./dev bench tosses --data tosses_train.csv.gz --rivals mujoco,bullet,ode,dart --json docs/validation/tosses.json":
        None,  # the data are not part of the project
    "./dev bench simbench": "./dev bench simbench --steps 20 --rivals bullet64,ode --json ~/simbench.json",
    "./dev bench pile --bodies 8000 --from STATE --tiles 8":
        "./dev bench pile --bodies 300 --settle 60 --keep ~/pile.state && "
        "./dev bench pile --bodies 300 --from ~/pile.state --tiles 2",
    "./dev bench moving": "./dev bench moving --quick --scenes pour_0.2 --json ~/moving.json",
    "./dev bench moving --rivals bullet,ode --json moving.json":
        "./dev bench moving --quick --scenes pour_0.2 --rivals ode --json ~/moving.json",
    "./dev bench hard": "./dev bench hard --only 'stack of 10' --rate 60 --json ~/hard.json",
    "./dev bench cluster": "./dev bench cluster --quick --bodies 1000 --turns 1",
    "./dev bench pyramid [--rows N] [--count N] [--rate N] [--rivals bullet,ode] [--json FILE]":
        "./dev bench pyramid --rows 20 --seconds 1 --rivals bullet,ode --json ~/pyramid.json",
    "./dev bench pile --solver NAME": "./dev bench pile --solver accelerated_jacobi",
    "./dev bench pile --bodies 8000 --iterations N --precision mixed":
        "./dev bench pile --bodies 800 --iterations 2 --precision mixed",
    "./dev bench pile_soft --bodies 1000 --iterations N": "./dev bench pile_soft --bodies 300",
    "./dev report": "./dev report roll",
    "./dev test --long -R 'promises|_twice'": None,
    # The tests themselves are in the default run.
    "ctest --test-dir build/release -R 'reproducible|same_bits' -LE long":
        "ctest --test-dir build/release -R 'reproducible|same_bits' -LE long -N | grep -q 'Test *#'",
    "ctest --test-dir build/release -R 'checkpoint'":
        "ctest --test-dir build/release -R 'checkpoint' -N | grep -q 'Test *#'",
    "ctest --test-dir build/release -R test_world_nothing_lost":
        "./dev build test_world_nothing_lost && ctest --test-dir build/release -R test_world_nothing_lost",
    "ctest --test-dir build/release -R 'test_world_bad_input|test_mpi_transport_failures'":
        "ctest --test-dir build/release -R 'test_world_bad_input|test_mpi_transport_failures' -N | "
        "grep -q 'Test *#'",
    "./dev faults": "./dev faults --list",
    "./dev fuzz scenarios --runs 10000 --seed 1000000": "./dev fuzz scenarios --runs 10 --seed 1000000",
    "./dev fuzz options 600": "./dev fuzz options 5",
    "./dev fuzz checkpoint 600": "./dev fuzz checkpoint 5",
    "build/release/tests/test_hard_load --steps 20000":
        "./dev build test_hard_load && build/release/tests/test_hard_load --steps 200",
    "xvfb-run -a /usr/bin/python3 docs/output_picture.py hopper_0000000700.hdf hopper.png":
        "xvfb-run -a /usr/bin/python3 docs/output_picture.py hopper_0000000040.hdf hopper.png",
    "./dev sanitize address": "./dev sanitize address -R test_scene_options_corpus",
    "./dev sanitize": "./dev sanitize thread -R test_world_momentum",
    "./dev sanitize thread": "./dev sanitize thread -R test_world_momentum",
    "./dev sanitize address --all": "./dev sanitize address -R test_world_momentum",
    "cmake --preset release && cmake --install build/release --prefix FOLDER":
        "cmake --preset release && cmake --install build/release --prefix ~/folder",
    "mpirun --map-by core --bind-to core ./build/heap ...":
        "cd ~/heap && mpirun -n 2 --map-by core --bind-to core ./build/heap",
    "./dev compile-cost --compare OLD.o NEW.o":
        "./dev compile-cost --compare $(find build/release/tests -name hello.cpp.o -o -name drop.cpp.o)",
    "mpirun -n N": None, "./dev": None, "./dev new": None,  # named, not typed
}
# Commands that only the help documents.
BESIDE = ["./dev help"]
HABITS = r"(TALUS_PRESET=\S+ )?\./dev (sanitize|tidy|docs|format|fuzz|faults|build|test)\b|ctest |git "
MEASURES = r"\./dev (bench|report|compile-cost)\b|.*/benchmarks/"


def group(command):
    if re.match(MEASURES, command):
        return "measures"
    return "habits" if re.match(HABITS, command) else "people"


def shortened(command):
    """The same with fewer steps, and with periodic actions as often as before, or more often."""
    if not re.search(PROGRAMS, command) or "--help" in command:
        return command
    few = lambda option, most: lambda m: f"{option} {max(1, min(int(m[1]) // 10, most))}"
    for option in ("--checkpoint-every", "--output-every", "--every"):
        command = re.sub(rf"(?<!\S){option} (\d+)", few(option, 20), command)
    if "--steps " in command:
        return re.sub(r"--steps (\d+)", few("--steps", 2 * STEPS), command)
    return f"{command} --steps {STEPS}"


def commands_of(page, name):
    """(where, the page's words) of the blocks; with the number of block lines before it, of the text;
    faults are blocks of unknown kind."""
    blocks, text, faults = [], [], []
    language, quoted, before, left = None, False, "", ""
    for number, line in enumerate(page.read_text().splitlines(), 1):
        where = f"{name}:{number}"
        if line.startswith("```"):
            if language is None:
                language, quoted = line[3:].strip(), before.startswith("<!-- ")
                if language not in LANGUAGES:
                    faults.append(f"{where}: what are blocks of '{language}'? Commands are in blocks of 'sh'")
            else:
                language = None
        elif language is None:
            for span in re.findall(r"`([^`]+)`", left + line):
                if COMMAND.match(span) and not NAMED.match(span):
                    text.append((where, span, len(blocks)))
            if line.startswith("    ") and COMMAND.match(line.strip()):
                faults.append(f"{where}: '{line.strip()}' is indented: put it into a block of 'sh'")
            # A command may continue in the next line.
            left = (left + line).rpartition("`")[2] + " " if (left + line).count("`") % 2 else ""
            left = "`" + left if left else ""
        elif LANGUAGES.get(language) and not quoted:
            command = re.sub(r"\s+#.*", "", line).strip()
            if COMMAND.match(command):
                blocks.append((where, command))
            elif command and not command.startswith("#"):
                faults.append(f"{where}: is '{command}' a command? Output is a block of 'text'")
        before = line
    return blocks, text, faults


def copy(root, to):
    """The project as checked out, and the build of an earlier run."""
    listed = subprocess.run(["git", "-C", root, "ls-files", "-co", "--exclude-standard"],
                            capture_output=True, text=True)
    if listed.returncode == 0:
        names = {pathlib.Path(n) for n in listed.stdout.splitlines() if (root / n).is_file()}
    else:
        names = {p.relative_to(root) for p in root.rglob("*") if p.is_file()}
    built = {p.parent.relative_to(root) for p in root.glob("**/CMakeCache.txt")} | {
        pathlib.Path("build"), pathlib.Path(".git")}
    names = {n for n in names if not built & set(n.parents)}
    for old in [p for p in to.rglob("*") if p.is_file()]:
        name = old.relative_to(to)
        if name not in names and (name.parts[0] != "build" or name.suffix == ".h5"):
            old.unlink()
    for folder in sorted((p for p in to.rglob("*") if p.is_dir()), reverse=True):
        if not any(folder.iterdir()):
            folder.rmdir()
    for name in names:
        one, other = root / name, to / name
        if other.is_file() and other.read_bytes() == one.read_bytes():
            continue
        other.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(one, other)
        os.utime(other)


def can_show(root):
    """Whether the history to which pages refer exists."""
    told = subprocess.run(["git", "-C", root, "rev-parse", "--is-shallow-repository"],
                          capture_output=True, text=True)
    return told.stdout.strip() == "false"


def plan(root, pages, whole):
    """The commands, as (where, (page, block lines before it), command); those of them that are lines
    of blocks; faults. `whole`: these are all pages there are."""
    blocks, text, faults = [], [], []
    for page in pages:
        name = page.relative_to(root)
        b, t, f = commands_of(page, name)
        blocks += [(where, (page, n), c) for n, (where, c) in enumerate(b)]
        text += [(where, (page, n), c) for where, c, n in t]
        faults += f
    if whole:
        text += [("the help", (None, 0), c) for c in BESIDE]

    todo, seen, used, lines = [], set(), set(), set()
    problem = next(iter(sorted((root.parent / "shared" / "fc3d").rglob("*.hdf5"))), None)
    for in_block, (where, place, command) in [(True, x) for x in blocks] + [(False, x) for x in text]:
        if not in_block and command in seen:
            continue
        seen.add(command)
        used |= {command} & set(INSTEAD)
        typed = INSTEAD.get(command, command)
        if typed is None or ("{problem}" in typed and problem is None):
            continue
        if command not in INSTEAD and "$(" not in command and re.search(
                r"\b[A-Z]{3,}\b|\bN\b|\[|\.\.\.", command.replace("TALUS_PRESET", "")):
            faults.append(f"{where}: '{command}' has names to fill in: say in INSTEAD what is to be typed")
        todo.append((where, place, shortened(typed.replace("{problem}", str(problem)))))
        if in_block:
            lines.add(todo[-1])
    if whole:
        faults += [f"INSTEAD has '{c}', which no page says" for c in INSTEAD if c not in used]
        helped = subprocess.run(["bash", root / "dev", "help"], capture_output=True, text=True).stdout
        for verb in set(re.findall(r"^  ([a-z][a-z-]*)", helped, re.M)) - {"test"}:
            if not any(re.search(rf"\bdev {verb}\b", c) for _, _, c in todo):
                faults.append(f"no page says ./dev {verb}: add it to BESIDE")
    return todo, lines, faults


def prepare(root, scratch):
    """The copy, and the environment of the commands in it."""
    # A stand-in for a cluster's srun with the options used in the pages: two processes.
    programs = scratch / "bin"
    programs.mkdir(parents=True, exist_ok=True)
    (programs / "srun").write_text('#!/bin/bash\nwhile [[ $1 == -* ]]; do shift; done\nexec mpirun -q -n 2 "$@"\n')
    (programs / "srun").chmod(0o755)
    for made in ("heap", "folder"):
        shutil.rmtree(scratch / made, ignore_errors=True)
    copy(root, scratch / "talus")
    environment = {**os.environ, "HOME": str(scratch), "PATH": f"{programs}:{os.environ['PATH']}",
                   "CCACHE_DIR": os.environ.get("CCACHE_DIR", os.path.expanduser("~/.cache/ccache"))}
    for name in ("CXX", "CXXFLAGS", "TALUS_PRESET"):
        environment.pop(name, None)
    return environment


def type_it(command, folder, environment, scratch):
    """Its exit code, or why there is none; its output; the folder after it."""
    bash = subprocess.Popen(["bash", "-c", f"{command}\ncode=$?\npwd >'{scratch}/where'\nexit $code"],
                            cwd=folder, env=environment, stdin=subprocess.DEVNULL, text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)
    try:
        said, _ = bash.communicate(timeout=60 * MINUTES)
        return bash.returncode, said, pathlib.Path((scratch / "where").read_text().strip())
    except subprocess.TimeoutExpired:
        os.killpg(bash.pid, signal.SIGKILL)
        return f"nothing after {MINUTES} minutes", bash.communicate()[0], folder


def main():
    root, scratch = (pathlib.Path(p).resolve() for p in sys.argv[1:3])
    wanted, only_list = sys.argv[3], "--list" in sys.argv
    given = [pathlib.Path(p).resolve() for p in sys.argv[4:] if p.endswith(".md")]
    pages = given or [p for p in sorted(root.glob("*.md")) + sorted((root / "docs").rglob("*.md"))
                      if p.name != "CHANGELOG.md"]
    todo, lines, faults = plan(root, pages, whole=not given)
    if wanted != "all":  # and the ways to them
        pages = {place[0] for _, place, c in todo if group(c) == wanted and not WAY.match(c)}
        todo = [(w, p, c) for w, p, c in todo
                if (p[0] in pages if WAY.match(c) else group(c) == wanted)]
    print("\n".join(faults))
    if only_list:
        print("\n".join(f"{w}: {c}" for w, _, c in todo))
        print(f"{len(todo)} commands, {len(faults)} faults")
        sys.exit(1 if faults or not todo else 0)

    environment = prepare(root, scratch)
    folders = {}  # where the commands of a page have led, after so many of them
    for number, (where, (page, before), command) in enumerate(todo, 1):
        folder = next((folders[page, n] for n in range(before, 0, -1) if (page, n) in folders),
                      scratch / "talus")
        if command.startswith("srun ./well"):
            folder = scratch / "talus/build/release/examples/well"
        elif command.startswith("git show "):
            if not can_show(root):
                continue
            folder = root
        elif command.startswith("git "):
            sys.exit(f"{where}: '{command}' is not for the project's own repository")
        began = time.monotonic()
        code, said, led = type_it(command, folder, environment, scratch)
        if (where, (page, before), command) in lines:
            folders[page, before + 1] = led
        print(f"{number}/{len(todo)} {time.monotonic() - began:5.0f} s  {where}: {command}", flush=True)
        if code != 0:
            faults.append(f"{where}: '{command}' ended with {code}:\n" +
                          "\n".join("    " + line for line in said.splitlines()[-30:]))
            print(faults[-1], flush=True)
    print(f"{len(todo)} commands, {len(faults)} faults")
    print("\n".join(faults))
    sys.exit(1 if faults or not todo else 0)


if __name__ == "__main__":
    main()
