#!/usr/bin/env python3
"""Checks that targets of links in the documentation exist, and the commands and symbols that it names.

Of every *.md that is part of the project: each relative link is a file or a folder, and its anchor, if
it has one, a heading there; each file in back quotes exists, and contains the symbol that a page
places in it; each `./dev VERB` is a verb that ./dev knows, and each `./dev run NAME` an example.
  links.py ROOT [FILE.md ...]
"""
import pathlib
import re
import subprocess
import sys

root = pathlib.Path(sys.argv[1]).resolve()
if len(sys.argv) > 2:
    pages = [pathlib.Path(p).resolve() for p in sys.argv[2:]]
else:
    pages = sorted(root.glob("*.md")) + sorted((root / "docs").rglob("*.md"))

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
print("\n".join(faults))
print(f"{len(pages)} pages, {links} links, {len(faults)} faults")
sys.exit(1 if faults or links == 0 else 0)
