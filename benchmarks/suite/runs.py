"""Starts benchmark programs, one at a time, and reads what they say."""
import json
import os
import resource
import shutil
import subprocess
import time

TIMEOUT = 1800  # seconds of one run


class Bench:
    """The programs of one build, and the results that they add to."""

    def __init__(self, build, results, quick=False, full=False, keep=False):
        self.build, self.results = build, results
        self.quick, self.full, self.keep = quick, full, keep
        self.states = os.path.join(build, "settled")
        os.makedirs(self.states, exist_ok=True)
        self.settled_here = set()

    def has(self, program):
        return os.path.exists(os.path.join(self.build, program))

    def command(self, program, options):
        words = [os.path.join(self.build, program)]
        for name, value in options.items():
            words += ["--" + name.replace("_", "-"), str(value)]
        return words

    def run(self, part, label, program, processes=0, tags=None, **options):
        """Runs a program and adds its rows; under mpirun with `processes`. `tags` are fields that
        tell the row from others. Does nothing for what --keep finds already there, and says so for
        what is not installed or fails."""
        tags = {"label": label, **(tags or {})}
        if self.keep and self.results.row(part, **tags):
            return
        if not self.has(program):
            self.results.say(f"{part}: {label} left out, {program} is not built")
            return
        words = self.command(program, options)
        if processes:
            words = [*mpirun(processes), *words]
        began = time.monotonic()
        said, complaint = output_of(words)
        if said is None:
            self.results.say(f"{part}: {label} failed: {complaint}")
            return
        self.add(part, said, tags)
        self.results.say(f"{part}: {describe(label, options)}, {time.monotonic() - began:.1f} s")

    def add(self, part, said, tags):
        """Adds what a program said, replacing what it said before under the same tags."""
        rows = json.loads(said)
        for row in rows if isinstance(rows, list) else [rows]:
            self.results.add(part, {**tags, **row})

    def together(self, programs):
        """Runs several commands beside each other; what each said, or None."""
        running = [subprocess.Popen(words, stdout=subprocess.PIPE, text=True) for words in programs]
        said = [each.communicate(timeout=TIMEOUT)[0] for each in running]
        return said if all(each.returncode == 0 for each in running) else None

    def state(self, bodies):
        return os.path.join(self.states, f"pile_{bodies}.bin")

    def settled(self, bodies, **options):
        """A file with the settled PILE of so many bodies. Settling counts for nothing, so that it
        may use all cores: two ranks as threads."""
        return self.settle(self.state(bodies), f"a pile of {bodies:,}",
                           {"ranks": 2, "cells_x": 2, "cells_y": 1, "bodies": bodies, **options})

    def settle(self, path, what, options):
        """Runs until what the options describe has settled, unless that has been done."""
        if path in self.settled_here or (self.keep and os.path.exists(path)):
            return path
        began = time.monotonic()
        said, complaint = output_of(self.command("ranks", {
            "keep": path, "iterations": SETTLING_ITERATIONS, "settle": 60 if self.quick else 720,
            "measure": 0, **options}))
        if said is None:
            raise RuntimeError(f"{what} cannot be settled: {complaint}")
        self.results.say(f"settled {what}, {time.monotonic() - began:.1f} s")
        self.settled_here.add(path)
        return path


SETTLING_ITERATIONS = 5


def describe(label, options):
    return " ".join([label, *(f"{name}={value}" for name, value in options.items()
                              if name in ("bodies", "iterations", "ranks", "ratio", "scene",
                                          "shape"))])


def mpirun(processes):
    os.environ.setdefault("OMPI_MCA_btl_vader_single_copy_mechanism", "none")
    if os.geteuid() == 0:
        os.environ["OMPI_ALLOW_RUN_AS_ROOT"] = os.environ["OMPI_ALLOW_RUN_AS_ROOT_CONFIRM"] = "1"
    words = ["mpirun", "-q", "-n", str(processes), "--oversubscribe"]
    if processes > (os.cpu_count() or 1):
        words += ["--bind-to", "none", "--mca", "mpi_yield_when_idle", "1"]
    return words


def output_of(words, **how):
    """What a command says, or None and its complaint."""
    if shutil.which(words[0]) is None:
        return None, f"there is no {words[0]}"
    try:
        done = subprocess.run(words, capture_output=True, text=True, timeout=TIMEOUT, **how)
    except subprocess.TimeoutExpired:
        return None, f"took more than {TIMEOUT} s"
    if done.returncode != 0:
        return None, (done.stderr or done.stdout).strip()[-500:]
    return done.stdout, ""


def cpu_seconds_of_children():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
