#!/usr/bin/env python3
"""Prints the targets that selected tests of a build folder need, one a line.

  targets.py BUILD [CTEST OPTIONS]

These are the files of the build in the commands of the tests, and those in their REQUIRED_FILES. A test file
is built alone unless more than half of the files of its shared program are selected (run_file.sh). Ends with
1 if no test is selected.
"""
import collections
import json
import os
import re
import subprocess
import sys


def main():
    build, options = os.path.realpath(sys.argv[1]), sys.argv[2:]

    def tests_with(options):
        done = subprocess.run(["ctest", "--test-dir", build, "--show-only=json-v1"] + options,
                              capture_output=True, text=True, check=True)
        return [t for t in json.loads(done.stdout)["tests"] if t.get("command")]

    def shared_program(test):
        return test["command"][2] if test["command"][0].endswith("/run_file.sh") else None

    selected = tests_with(options)
    done = subprocess.run(["ninja", "-C", build, "-t", "targets", "all"], capture_output=True, text=True, check=True)
    known = {m[1] for m in re.finditer(r"^(.*): (?!phony)", done.stdout, re.M)}
    files = collections.Counter(map(shared_program, tests_with([])))
    wanted = collections.Counter(map(shared_program, selected))
    targets = set()
    for test in selected:
        words = list(test["command"])
        for entry in test.get("properties", []):
            if entry["name"] == "REQUIRED_FILES":
                words += entry["value"]
        shared = shared_program(test)
        if shared and words[1]:
            words.remove(words[1] if 2 * wanted[shared] > files[shared] else shared)
        for word in words:
            path = os.path.relpath(re.sub(r"^-D\w+=", "", word) or ".", build)
            if path in known:
                targets.add(path)
    print("\n".join(sorted(targets)))
    return 0 if selected else 1


if __name__ == "__main__":
    sys.exit(main())
