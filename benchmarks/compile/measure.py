#!/usr/bin/env python3
"""What compiling talus costs: seconds, memory, instantiations and size of the object.

Each program is compiled by one plain call of the compiler, as a user would: the flags of the build folder
but without its precompiled header and its compiler cache. See ./dev compile-cost.
"""
import argparse
import collections
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
import beside  # noqa: E402


def flags_of(build, source):
    """The compiler and the flags with which `source` is built, without what makes it cheaper."""
    with open(os.path.join(build, "compile_commands.json")) as file:
        for entry in json.load(file):
            if entry["file"] == source and "talus_compile" not in entry["command"]:
                words = collections.deque(shlex.split(entry["command"]))
                break
        else:
            sys.exit(f"compile-cost: {source} is not in {build}")
    while not re.search(r"(g\+\+|clang\+\+|c\+\+)[^/]*$", words[0]):  # env, ccache
        words.popleft()
    kept = []
    while words:
        word = words.popleft()
        if word in ("-o", "-include", "-c"):
            words.popleft()
        elif not re.match(r"-O\d|-Winvalid-pch|-fpch-preprocess|.*cmake_pch", word):
            kept.append(word)
    return kept


def compile_once(command):
    """Seconds of processor in user mode, seconds by the clock, and the largest memory (MiB)."""
    start = os.times().elapsed
    process = subprocess.Popen(command)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = status
    if status != 0:
        sys.exit("compile-cost: failed: " + shlex.join(command))
    return used.ru_utime, os.times().elapsed - start, used.ru_maxrss / 1024


def source_of(root, build, name):
    """`hello` is the example drop cut down to what the least program needs, as CMake makes it for the test
    compile_cost; all others are examples."""
    if name == "hello":
        return os.path.join(build, "tests/compile/hello.cpp")
    return os.path.join(root, f"examples/{name}/{name}.cpp")


def families(path):
    """Weak symbols of an object by class or function template."""
    names = subprocess.run(["nm", "-C", path], check=True, capture_output=True, text=True).stdout
    count = collections.Counter()
    for line in names.splitlines():
        match = re.match(r"[0-9a-f ]{16} [WVwvu] (.*)", line)
        if not match:
            continue
        name, depth = "", 0
        for c in match.group(1).replace("operator<", "operator").replace("operator>", "operator"):
            depth += (c == "<") - (c == ">")
            if c == "(" and depth == 0:
                break
            if depth == 0 and c != ">":
                name += c
        count["::".join(name.split(" ")[-1].split("::")[:4])] += 1
    return count


def instantiations(build, folder, name, compiler, source):
    """As the test compile_cost counts them, from its object if there is one."""
    place = "compile" if name == "hello" else f"__/examples/{name}"
    target = os.path.join(build, f"tests/CMakeFiles/talus_compile_{name}.dir/{place}/{name}.cpp.o")
    if not os.path.exists(target):
        target = os.path.join(folder, f"{name}-O0.o")
        subprocess.run(compiler + ["-O0", "-g0", "-march=x86-64", "-Wno-psabi", "-c", source, "-o", target],
                       check=True)
    return sum(families(target).values())


def compare(old, new):
    before, after = families(old), families(new)
    change = {k: after[k] - before[k] for k in before | after if after[k] != before[k]}
    for name in sorted(change, key=lambda k: -abs(change[k]))[:30]:
        print(f"{change[name]:+6d}  {name}")


def main():
    parser = argparse.ArgumentParser(prog="./dev compile-cost", description=__doc__.split("\n")[0])
    parser.add_argument("--root", help=argparse.SUPPRESS)
    parser.add_argument("--build", help=argparse.SUPPRESS)
    parser.add_argument("--json", type=beside.file_for_rows, help="where the numbers go (default: docs/performance/compile.json)")
    parser.add_argument("--runs", type=int, default=2, help="times each is compiled, the fastest counts")
    parser.add_argument("--keep", metavar="DIR", help="where the objects stay (default: nowhere)")
    parser.add_argument("--compare", nargs=2, metavar="OBJECT", help="what two objects differ in, no more")
    arguments = parser.parse_args()
    if arguments.compare:
        compare(*arguments.compare)
        return

    root, build = arguments.root, arguments.build
    rows, counts = [], {}
    path = arguments.json or os.path.join(root, "docs/performance/compile.json")
    os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
    folder = arguments.keep or tempfile.mkdtemp()
    os.makedirs(folder, exist_ok=True)
    try:
        print("program  flags  user s  wall s  peak MiB  instantiations  object KiB")
        for level in ("-O3", "-O2"):
            for name in ("hello", "drop", "well", "stair"):
                source = source_of(root, build, name)
                compiler = flags_of(build, source_of(root, build, "drop" if name == "hello" else name))
                if name not in counts:
                    counts[name] = instantiations(build, folder, name, compiler, source)
                target = os.path.join(folder, f"{name}{level}.o")
                best = min(compile_once(compiler + [level, "-c", source, "-o", target])
                           for _ in range(max(1, arguments.runs)))
                rows.append({"program": name, "flags": level, "seconds": round(best[0], 2),
                             "seconds_wall": round(best[1], 2), "peak_mib": round(best[2]),
                             "instantiations": counts[name],
                             "object_kib": round(os.path.getsize(target) / 1024)})
                r = rows[-1]
                print(f"{name:8} {level:5} {r['seconds']:7} {r['seconds_wall']:7} {r['peak_mib']:9}"
                      f" {r['instantiations']:15} {r['object_kib']:11}", flush=True)
                beside.write_rows(rows, path)
    finally:
        if not arguments.keep:
            shutil.rmtree(folder)


main()
