#!/usr/bin/env python3
"""Checks that no type of namespace talus::detail has the name of one of namespace talus: where both are
known, the code of talus::detail means the former, so that a program compiles or not by the order of its
includes.
  names.py ROOT          fails for each such name
  names.py --self-test   whether one is found
"""
import pathlib
import re
import sys

DECLARED = re.compile(r"(?:template <.*> )?(?:class|struct|enum class|concept) (\w+)(?! *;)|(?:template <.*> )?using (\w+) =")


def declared(lines):
    """Yields (namespace, name) of each type, concept and alias that is declared in a namespace itself."""
    spaces, depth = [], 0
    for line in lines:
        code = re.sub(r'"(\\.|[^"\\])*"|\'(\\.|[^\'\\])\'|//.*', "", line)
        opened = re.match(r"(?:inline )?namespace ([\w:]+) ?\{", code)
        found = DECLARED.match(code)
        if found and depth == len(spaces) and not re.match(r"[^{=]*;$", code):
            yield "::".join(spaces), found[1] or found[2]
        depth += code.count("{") - code.count("}")
        if opened and depth > len(spaces):
            spaces.append(opened[1])
        del spaces[depth:]


def clashes(headers):
    places = {"talus": {}, "talus::detail": {}}
    for name, text in headers:
        for space, what in declared(text.splitlines()):
            if space in places:
                places[space].setdefault(what, name)
    public, private = places["talus"], places["talus::detail"]
    return [f"{private[n]}: talus::detail::{n} has the name of talus::{n} ({public[n]}): rename it"
            for n in sorted(public.keys() & private.keys())]


if sys.argv[1] == "--self-test":
    one = ("a.hpp", "namespace talus {\nstruct crate {\n};\n}  // namespace talus\n")
    two = ("b.hpp", "namespace talus::detail {\ntemplate <class T>\nclass crate {\n};\n}  // namespace talus::detail\n")
    sys.exit(0 if len(clashes([one, two])) == 1 and not clashes([one, one]) else 1)
include = pathlib.Path(sys.argv[1]).resolve() / "include"
faults = clashes((str(h.relative_to(include)), h.read_text()) for h in sorted(include.rglob("*.hpp")))
print("\n".join(faults) or "no name twice")
sys.exit(1 if faults else 0)
