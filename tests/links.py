#!/usr/bin/env python3
"""Checks that targets of links in the documentation exist, and the commands and symbols that it names;
and the files and symbols that comments in headers name.

Of every *.md that is part of the project: each relative link is a file or a folder, and its anchor, if
it has one, a heading there; each file in back quotes exists, and contains the symbol that a page
places in it; each `./dev VERB` is a verb that ./dev knows, and each `./dev run NAME` an example.
In comments of every header: each file exists, by its path or by its name alone; each `symbol`,
function() and qualified::name occurs in the code of headers or examples, or in a CMakeLists.txt.
No docstring there begins with "Of", "The same", "As", "Likewise", "Its", "Those", "That", "Their", "But" or
"It", which only its neighbours make clear.
  links.py ROOT [FILE.md | FILE.hpp ...]
"""
import pathlib
import re
import subprocess
import sys

root = pathlib.Path(sys.argv[1]).resolve()
if len(sys.argv) > 2:
    given = [pathlib.Path(p).resolve() for p in sys.argv[2:]]
    pages = [p for p in given if p.suffix == ".md"]
    headers = [p for p in given if p.suffix == ".hpp"]
else:
    pages = sorted(root.glob("*.md")) + sorted((root / "docs").rglob("*.md"))
    headers = sorted((root / "include").rglob("*.hpp"))

dev = (root / "dev").read_text()
verbs = set(re.findall(r"[a-z][a-z-]*", " ".join(re.findall(r"^  ([a-z -|]+)\)", dev.split("case $verb in")[1], re.M))))
shown = subprocess.run(["bash", str(root / "dev"), "help"], capture_output=True, text=True, check=True).stdout
shown = set(re.findall(r"^  ([a-z][a-z-]*)", shown, re.M))
examples = {p.parent.name for p in (root / "examples").glob("*/*.cpp") if p.stem == p.parent.name}

faults = []
links = 0


def homes(page):
    """Folders in which a page may name files: its own, that of the tree, or that of the headers."""
    return [page.parent, root, root / "include" / "talus", root / "include"]


def headings(page):
    """Anchors made from headings: letters, digits, _ and -, in lower case; duplicates are numbered."""
    seen, anchors, inside = {}, set(), False
    for line in page.read_text().splitlines():
        if line.startswith("```"):
            inside = not inside
        if inside or not re.match(r"#{1,6} ", line):
            continue
        text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", line.lstrip("#").strip())
        anchor = re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-")
        count = seen.get(anchor, 0)
        seen[anchor] = count + 1
        anchors.add(anchor if count == 0 else f"{anchor}-{count}")
    return anchors


for page in pages:
    inside = False
    for number, line in enumerate(page.read_text().splitlines(), 1):
        where = f"{page.relative_to(root) if page.is_relative_to(root) else page}:{number}"
        for verb in re.findall(r"\./dev ([a-z][a-z-]*)", line):
            if verb not in verbs or (verb not in shown and verb != "help"):
                faults.append(f"{where}: ./dev has no verb '{verb}'")
        for name in re.findall(r"\./dev run ([a-z]\w*)", line):
            if name not in examples:
                faults.append(f"{where}: there is no example '{name}'")
        if line.startswith("```"):
            inside = not inside
        if inside:
            continue
        for name in re.findall(r"`((?:[a-z_0-9]+/)+[a-z_0-9]+\.(?:hpp|cpp|sh|py|txt|cmake))`", line):
            if not any((folder / name).is_file() for folder in homes(page)):
                faults.append(f"{where}: there is no file '{name}'")
        for symbol, name in re.findall(r"`([\w:]+)(?:\(\))?` in `((?:[a-z_0-9]+/)+[a-z_0-9]+\.hpp)`", line):
            files = [folder / name for folder in homes(page) if (folder / name).is_file()]
            if not any(re.search(rf"\b{symbol.split('::')[-1]}\b", f.read_text()) for f in files):
                faults.append(f"{where}: '{name}' has no '{symbol}'")
        for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"`[^`]*`", "", line)):
            if re.match(r"[a-z]+:", target):
                continue
            links += 1
            path, _, anchor = target.partition("#")
            to = (page.parent / path).resolve() if path else page
            if not to.exists():
                faults.append(f"{where}: there is no {target}")
            elif anchor and to.suffix == ".md" and anchor not in headings(to):
                faults.append(f"{where}: there is no heading #{anchor} in {to.name}")


COMMENT = re.compile(r'R"(\w*)\(.*?\)\1"|"(?:[^"\\\n]|\\.)*"|(//[^\n]*|/\*.*?\*/)', re.S)
NAMES = re.compile(
    r"`([A-Za-z_]\w*(?:::\w+)*)(?:\(\))?`|\b([A-Za-z_]\w*(?:::\w+)+)|\b([A-Za-z_]\w*)\(\)")
FILES = re.compile(r"(?<![\w*/])((?:[\w.]+/)*\w+\.(?:hpp|cpp|py|sh|md))\b")


def split_comments(path):
    """The code of a file, and its comments as (line, text)."""
    text, comments = path.read_text(), []

    def take(m):
        if not m[2]:
            return m[0]
        comments.append((text.count("\n", 0, m.start()) + 1, m[2]))
        return ""

    return COMMENT.sub(take, text), comments


def words_of(code):
    return set(re.findall(r"\w+", code))


names = 0
if headers:
    tree = sorted((root / "include").rglob("*.hpp"))
    code_of, comments_of = {}, {}
    for header in sorted(set(tree + headers)):
        code_of[header], comments_of[header] = split_comments(header)
    together = [words_of(code_of[h]) for h in tree]
    together += [words_of(split_comments(p)[0]) for p in sorted((root / "examples").glob("*/*.cpp"))]
    together += [words_of(p.read_text()) for p in (root / "CMakeLists.txt", root / "tests/CMakeLists.txt")]
    alone = {h.name for h in tree}
    for header in headers:
        own = words_of(code_of[header])
        lines = [""] + [line.strip() for line in header.read_text().split("\n")]
        for number, (before, line) in enumerate(zip(lines, lines[1:]), 1):
            if re.match(r"/// ([Oo]f|The same|As|Likewise|Its|Those|That|Their|But|It)\b", line) and not before.startswith("///"):
                where = f"{header.relative_to(root) if header.is_relative_to(root) else header}:{number}"
                faults.append(f"{where}: the docstring cannot be read alone: {line[4:]}")
        for number, text in comments_of[header]:
            where = f"{header.relative_to(root) if header.is_relative_to(root) else header}:{number}"
            for name in FILES.findall(text):
                names += 1
                included = re.search(rf'#include [<"](\S*/)?{re.escape(name)}[>"]', code_of[header])
                if not (included or name in alone or any((f / name).is_file() for f in homes(header))):
                    faults.append(f"{where}: there is no file '{name}'")
            for match in NAMES.finditer(text):
                names += 1
                name = next(filter(None, match.groups()))
                parts = set(name.split("::"))
                if not (parts <= own or any(parts <= w for w in together)):
                    faults.append(f"{where}: no header has '{name}'")
print("\n".join(faults))
print(f"{len(pages)} pages, {links} links, {len(headers)} headers, {names} names, {len(faults)} faults")
sys.exit(1 if faults or links + names == 0 else 0)
