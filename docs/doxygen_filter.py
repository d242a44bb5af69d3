#!/usr/bin/env python3
"""Pages as Doxygen 1.9 can read them: headings get the anchors that links here name (as GitHub makes
them), unique over all pages; and code in tables is code, whatever stands in it.
  doxygen_filter.py FILE.md
"""
import html
import os
import pathlib
import re
import sys

page = pathlib.Path(sys.argv[1]).resolve()
root = pathlib.Path(os.environ["TALUS_ROOT"]).resolve()


def name(file, slug):
    return re.sub(r"\W", "_", f"{file.relative_to(root).with_suffix('')}__{slug}")


def slug(heading):
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading.strip())
    return re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-")


def link(match):
    path, anchor = match[1], match[2]
    to = (page.parent / path).resolve() if path else page
    return f"](#{name(to, anchor)})" if to.suffix == ".md" and to.is_relative_to(root) else match[0]


def code(match):
    return "<code>" + html.escape(match[1]).replace("#", "&#35;").replace("@", "&#64;") + "</code>"


inside = False
for line in page.read_text().splitlines():
    if line.startswith("```"):
        inside = not inside
    elif not inside:
        line = re.sub(r"\]\(([^)#\s:]*)#([^)\s]+)\)", link, line)
        if heading := re.match(r"(#{2,6} )(.*)", line):
            line = f"{heading[1]}{heading[2]} {{#{name(page, slug(heading[2]))}}}"
        elif line.startswith("| "):
            line = re.sub(r"`([^`]+)`", code, line)
    print(line)
