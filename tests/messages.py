#!/usr/bin/env python3
"""Checks that a test holds each message of docs/messages.md.

Each row of its tables ends with a link to a test, and has a message in backquotes: that test's source
must expect these words, where "..." stands for anything.
  messages.py ROOT [MESSAGES.md]
"""
import pathlib
import re
import sys

root = pathlib.Path(sys.argv[1])
page = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else root / "docs" / "messages.md"


def words(text):
    return " ".join(text.split())


def expected(file):
    """The texts of a test, as they are printed: literals joined, comments of refusals too."""
    text = file.read_text()
    text = re.sub(r"^// (expects: )?", " ", text, flags=re.M)
    text = re.sub(r'"\s*"', "", text)
    return words(text.replace(r"\"", '"').replace(r"\n", " "))


faults, rows = [], 0
for number, line in enumerate(page.read_text().splitlines(), 1):
    cells = [c.strip() for c in line.strip().strip("|").split(" | ")]
    if not line.startswith("| ") or len(cells) < 3 or "](" not in cells[-1]:
        continue
    rows += 1
    message = re.search(r"`` (.+?) ``|`([^`]+)`", cells[1])
    path = re.search(r"\]\(([^)]+)\)", cells[-1])[1]
    file = (page.parent / path).resolve()
    if not message or not file.is_file():
        faults.append(f"{page.name}:{number}: no message, or no test: {line}")
        continue
    at, text = 0, expected(file)
    for part in re.split(r"\.\.\.(?!>)", message[1] or message[2]):
        part = words(part)
        found = text.find(part, at)
        if found < 0:
            faults.append(f"{page.name}:{number}: {path} does not expect: {part}")
            break
        at = found + len(part)
print("\n".join(faults))
print(f"{rows} rows, {len(faults)} faults")
sys.exit(1 if faults or rows < 20 else 0)
