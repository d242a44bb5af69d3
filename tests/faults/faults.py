#!/usr/bin/env python3
"""Puts faults into a copy of the headers, and prints which of them the tests notice.

  faults.py BUILD [--list] [--jobs N] [--tests PATTERN] [--folder DIR] [NAME ...]

list.txt names the faults. Each has a title, a file of include/talus, a piece of that file in which
<<right ==> wrong>> marks the fault, and the tests that should see it:

  title of the fault
    interaction/tangential_spring.hpp
    if (<<memory.contact_radius < b.contact_radius ==> false>>) spring *=
    test_validation_soft_tangential

A piece may go over several lines, and its white space does not matter. The mark stands around an
expression, or around a statement with its semicolon. All faults are compiled at once, each behind a
switch that an environment variable sets, so that a test is compiled once. BUILD is a configured
build folder, from which the options of the compiler are taken. A fault that no test notices, and a
piece that is not in its file any more, end the run with 1.
"""
import argparse
import concurrent.futures
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import threading
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
SWITCH = "talus_fault"
LONGEST = 300  # seconds that a test may take, and ten times what it takes without a fault

PRECOMPILED, PRECOMPILING = set(), threading.Lock()


class Fault:
    def __init__(self, title, lines):
        self.title, self.file, self.tests = title, lines[0], lines[-1].split()
        self.piece = " ".join(lines[1:-1])
        match = re.fullmatch(r"(.*?)<<(.*)==>(.*)>>(.*)", self.piece, re.S)
        if not match or not all(t.startswith("test_") for t in self.tests):
            sys.exit(f"faults: '{title}' has no <<right ==> wrong>>, or no tests")
        self.before, self.right, self.wrong, self.after = (g.strip() for g in match.groups())

    def put_into(self, text, number):
        words = re.findall(r"\w+|[^\w\s]", self.before + " \0 " + self.right + " \0 " + self.after)
        pattern = "".join("()" if w == "\0" else re.escape(w) + r"\s*" for w in words)
        found = list(re.finditer(pattern, text))
        if len(found) != 1:
            return None
        first, last = found[0].start(1), found[0].start(2)
        right = text[first:last].rstrip()
        last = first + len(right)
        on = f"{SWITCH} == {number}"
        if self.right.endswith(";"):
            new = f"if ({on}) {{ {self.wrong} }} else {{ {right} }}"
        else:
            new = f"({on} ? ({self.wrong}) : ({right}))"
        return text[:first] + new + text[last:]


def read_list():
    faults, title, lines = [], None, []
    for line in (HERE / "list.txt").read_text().splitlines() + [""]:
        if line.startswith("#"):
            continue
        if not line.startswith(" "):
            if title and lines:
                faults.append(Fault(title, lines))
            title, lines = line.strip(), []
        elif line.strip():
            lines.append(line.strip())
    return faults


def command_of(build, test):
    """How a test is compiled and linked: options, source, command of the linker, common headers."""
    ninja = ["ninja", "-C", build, "-t", "commands", f"tests/{test}"]
    lines = subprocess.run(ninja, capture_output=True, text=True, check=True).stdout.splitlines()
    source = next(l for l in reversed(lines) if re.search(rf"{test}\.dir/\S+\.cpp\.o -c ", l))
    words = [w for w in shlex.split(source)]
    words = words[next(i for i, w in enumerate(words) if re.search(r"(g\+\+|c\+\+|clang\S*)$", w)):]
    keep, skip, common = [], 0, None
    for i, word in enumerate(words):
        if word == "-include":
            common = words[i + 1]
        if skip:
            skip -= 1
        elif word in ("-include", "-Xclang", "-MT", "-MF", "-o", "-c"):
            skip = 1
        elif word not in ("-MD", "-Winvalid-pch", "-fpch-preprocess", "-DTALUS_COMPILED") and not word.startswith("-W"):
            keep.append(word)
    link = next(l for l in reversed(lines) if f"-o tests/{test}" in l)
    link = link.split("&&")[1].strip() if link.startswith(":") else link
    # The worlds that tests share have no faults: the test compiles its own.
    keep.append("-DTALUS_SHARED_SCENE_LINKAGE=")
    link = re.sub(r"\S*/talus_test_scene_\S+\.o\b", "", link)
    return keep, words[words.index("-c") + 1], link, common


def precompile(build, folder, options, common):
    """Precompiles the common headers of some tests, with the switch before them."""
    path = folder / (pathlib.Path(common).parent.name + ".hpp")
    with PRECOMPILING:
        if path not in PRECOMPILED:
            path.write_text('#include "switch.hpp"\n' + pathlib.Path(common).read_text())
            done = subprocess.run(options + ["-w", "-x", "c++-header", "-o", f"{path}.gch", str(path)],
                                  cwd=build, capture_output=True, text=True)
            if done.returncode:
                print(f"faults: the common headers cannot be compiled:\n{done.stderr[:3000]}")
            PRECOMPILED.add(path)
    return path


def build_test(build, folder, test):
    try:
        options, source, link, common = command_of(build, test)
    except (subprocess.CalledProcessError, StopIteration):
        return "it is no test of this build"
    object_file = folder / f"{test}.o"
    options = [o if not re.fullmatch(r"-I\S*include", o) else f"-I{folder}/include" for o in options]
    first = precompile(build, folder, options, common) if common else folder / "switch.hpp"
    compile_ = options + ["-w", "-include", str(first), "-o", str(object_file), "-c", source]
    done = subprocess.run(compile_, cwd=build, capture_output=True, text=True)
    if done.returncode:
        return done.stderr
    link = re.sub(rf"\S*{test}\.dir/\S+\.cpp\.o", str(object_file), link)
    link = re.sub(rf"-o tests/{test}\b", f"-o {folder}/{test}", link)
    done = subprocess.run(link, cwd=build, shell=True, capture_output=True, text=True)
    return done.stderr if done.returncode else ""


def run_test(folder, test, number, seconds):
    started = time.monotonic()
    try:
        done = subprocess.run([str(folder / test), "-aa=1", "-m"], cwd=folder, timeout=seconds,
                              env={**os.environ, SWITCH.upper(): str(number)},
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        good = done.returncode == 0
    except subprocess.TimeoutExpired:
        good = False
    return good, time.monotonic() - started


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build")
    parser.add_argument("--list", action="store_true")
    parser.add_argument("--check", action="store_true", help="only whether all can be put in")
    parser.add_argument("--jobs", type=int, default=int(os.environ.get("TALUS_JOBS", "2")))
    parser.add_argument("--tests", default="", help="only tests whose names match it")
    parser.add_argument("--folder", help="for headers and programs with faults; BUILD/faults")
    parser.add_argument("names", nargs="*")
    args = parser.parse_intermixed_args()
    everything = read_list()
    if args.list:
        for number, fault in enumerate(everything, 1):
            print(f"{number:3} {fault.title}: {fault.file}, {' '.join(fault.tests)}")
        return 0
    if args.check:
        headers = ROOT / "include" / "talus"
        stale = [f for n, f in enumerate(everything, 1) if not (headers / f.file).is_file()
                 or f.put_into((headers / f.file).read_text(), n) is None]
        for fault in stale:
            print(f"the piece of '{fault.title}' is not in {fault.file}, or more than once: mend list.txt")
        return 1 if stale else 0
    wanted = [(n, f) for n, f in enumerate(everything, 1)
              if not args.names or any(w in f.title or w == str(n) for w in args.names)]

    build = pathlib.Path(args.build).resolve()
    folder = pathlib.Path(args.folder).resolve() if args.folder else build / "faults"
    shutil.rmtree(folder / "include", ignore_errors=True)
    shutil.copytree(ROOT / "include", folder / "include")
    (folder / "switch.hpp").write_text(
        f"#pragma once\n#include <cstdlib>\ninline const int {SWITCH} = [] {{\n"
        f"  const char* n = std::getenv(\"{SWITCH.upper()}\");\n"
        "  return n ? std::atoi(n) : 0;\n}();\n")
    stale = []
    for number, fault in wanted:
        path = folder / "include" / "talus" / fault.file
        text = fault.put_into(path.read_text(), number) if path.is_file() else None
        if text is None:
            stale.append(fault.title)
        else:
            path.write_text(text)
    for title in stale:
        print(f"faults: the piece of '{title}' is not there, or more than once: mend list.txt")

    live = {n: f for n, f in wanted if f.title not in stale}
    tests = sorted({t for f in live.values() for t in f.tests if re.search(args.tests, t)})
    noticed, broken = {}, []

    def examine(test):
        """Builds a test, and runs it with each of its faults that nothing has noticed so far."""
        said = build_test(build, folder, test)
        if said:
            broken.append(test)
            return print(f"faults: {test} cannot be built:\n{said[:2000]}", flush=True)
        good, seconds = run_test(folder, test, 0, LONGEST)
        if not good:
            broken.append(test)
            return print(f"faults: {test} fails without a fault", flush=True)
        for number, fault in live.items():
            if test not in fault.tests or number in noticed:
                continue
            good, _ = run_test(folder, test, number, min(LONGEST, 10 * seconds + 20))
            print(f"{number:3} {test} {'misses' if good else 'notices'} '{fault.title}'", flush=True)
            if not good:
                noticed[number] = test
        (folder / f"{test}.o").unlink()

    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        list(pool.map(examine, tests))
    unnoticed = [f for n, f in live.items() if n not in noticed]
    for fault in unnoticed:
        print(f"UNNOTICED: {fault.title} ({fault.file})")
    print(f"{len(noticed)} of {len(live)} faults noticed")
    return 1 if unnoticed or stale or broken else 0


if __name__ == "__main__":
    sys.exit(main())
