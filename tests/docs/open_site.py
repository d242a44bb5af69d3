#!/usr/bin/env python3
"""Builds the documentation, checks each link of each page, and opens it in headless Chromium.

  open_site.py ROOT SCRATCH        builds and checks; exit code 77 where a program is missing
  open_site.py --pages FOLDER      checks the pages of a folder (for pages that are wrong on purpose)
Without Chromium the build and the links are checked all the same, and the test counts as skipped.
"""
import html.parser
import json
import pathlib
import re
import shutil
import subprocess
import sys
import time
import urllib.parse

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import browser  # noqa: E402

# What is typed, and the beginnings of the addresses that must be first; then one that must be among
# the first ten.
SEARCHES = [
    ("coulomb_friction", ["reference/talus/"], "docs/policies/contact.html"),
    ("time step", ["docs/choosing.html"], "docs/"),
    ("restitution", ["docs/policies/contact.html"], "docs/"),
    ("checkpoint", ["docs/checkpoints.html"], "docs/"),
    ("for_each_contact", ["reference/talus/world/each_contact.html"], "docs/"),
    ("periodic space", ["docs/building_blocks.html#periodic-space", "docs/how_do_i.html#how-do-i-make-space-periodic"], "docs/"),
]


class Links(html.parser.HTMLParser):
    """Anchors of a page, and the addresses that it links to or loads."""

    def __init__(self, text):
        super().__init__()
        self.anchors, self.links, self.loads, self.twice = set(), [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        if "id" in given:
            if given["id"] in self.anchors:
                self.twice.append(given["id"])
            self.anchors.add(given["id"])
        if tag == "a" and given.get("href"):
            self.links.append(given["href"])
        loads = given.get("href") if tag == "link" else given.get("src") if tag != "a" else None
        if loads:
            self.loads.append(loads)


def check_links(folder):
    """(pages, links, faults) of all pages below a folder."""
    pages = {p: Links(p.read_text()) for p in sorted(folder.rglob("*.html"))}
    faults, links = [], 0
    for page, found in pages.items():
        name = page.relative_to(folder)
        faults += [f"{name}: the anchor '{a}' is there twice" for a in found.twice]
        for address in found.loads:
            if re.match(r"(https?:)?//", address):
                faults.append(f"{name}: loads {address} from elsewhere")
        for address in found.links + found.loads:
            if re.match(r"(https?|mailto|data):", address):
                continue
            links += 1
            path, _, anchor = address.partition("#")
            to = (page.parent / urllib.parse.unquote(path)).resolve() if path else page
            if not to.is_file():
                faults.append(f"{name}: there is no {address}")
            elif anchor and to in pages and urllib.parse.unquote(anchor) not in pages[to].anchors:
                faults.append(f"{name}: there is no anchor {address}")
    return pages, links, faults


def search(opened, folder, faults):
    """Types into the box of a page, and reads the list that appears."""
    for typed, first, among in SEARCHES:
        opened.open((folder / "docs" / "joints.html").as_uri())
        opened.run("document.getElementById('talus-search').focus()")
        opened.type_text(typed)
        found = opened.run(
            "[...document.querySelectorAll('#talus-results a')].map(a => a.getAttribute('href').replace(/^(\\.\\.\\/)+/, ''))")
        kinds = opened.run("[...document.querySelectorAll('#talus-results a')].map(a => a.dataset.kind)")
        if not found or not any(found[0].startswith(f) for f in first):
            faults.append(f"a search for '{typed}' finds {found[:3]} first, not {first[0]}")
        elif not any(f.startswith(among) for f in found[:10]):
            faults.append(f"a search for '{typed}' finds {found[:10]}, without {among}")
        if typed == "coulomb_friction" and "coulomb_friction" not in found[0]:
            faults.append(f"the first of '{typed}' is {found[0]}")
        if not opened.run("document.querySelector('#talus-results a')?.offsetHeight > 0"):
            faults.append(f"the results of '{typed}' are not visible")
        if "_" in typed and len(set(kinds)) < 2:
            faults.append(f"a search for '{typed}' finds only {set(kinds)}, not guides and the reference")
        # The first result leads to its page.
        opened.run("document.querySelector('.search').requestSubmit()")
        to = (folder / found[0].partition("#")[0]).as_uri() if found else ""
        if not opened.wait_until(f"location.href.split('#')[0] === {json.dumps(to)} && document.readyState === 'complete'"):
            faults.append(f"the first result of '{typed}' does not lead to {to}")
        faults += [f"search for '{typed}': {e}" for e in opened.errors]
    opened.open((folder / "index.html").as_uri())
    opened.run("document.getElementById('talus-search').focus()")
    opened.type_text("xyzzyplugh")
    if opened.run("document.querySelectorAll('#talus-results a').length") != 0:
        faults.append("a search for nonsense finds something")


def open_pages(pages, folder, faults):
    with browser.Browser() as opened:
        for page in pages:
            opened.open(page.as_uri())
            name = page.relative_to(folder)
            faults += [f"{name}: {e}" for e in opened.errors]
            broken = opened.run("[...document.images].filter(i => !i.naturalWidth).map(i => i.src)")
            faults += [f"{name}: {b} is no picture" for b in broken]
            if opened.run("document.querySelector('main').innerText.trim().length") < 40:
                faults.append(f"{name} is empty")
            if opened.run("document.documentElement.scrollWidth > innerWidth + 1"):
                faults.append(f"{name} is wider than the window")
        search(opened, folder, faults)


def main():
    if sys.argv[1] == "--pages":
        pages, links, faults = check_links(pathlib.Path(sys.argv[2]).resolve())
        print("\n".join(faults))
        print(f"{len(pages)} pages, {links} links, {len(faults)} faults")
        sys.exit(1 if faults else 0)
    root, scratch = (pathlib.Path(p).resolve() for p in sys.argv[1:3])
    missing = [] if shutil.which("doxygen") else ["doxygen"]
    # Debian's packages belong to Debian's Python.
    able = lambda python: subprocess.run([python, "-c", "import markdown, pygments"], capture_output=True).returncode == 0
    python = next((p for p in ("/usr/bin/python3", sys.executable) if pathlib.Path(p).exists() and able(p)), None)
    if not python:
        missing.append("python3-markdown or python3-pygments")
    if missing:
        print(f"skipped: {', '.join(missing)} not installed; ./dev docs installs what the site needs")
        sys.exit(77)
    began = time.monotonic()
    scratch.mkdir(parents=True, exist_ok=True)
    built = subprocess.run([python, "-B", root / "docs/site/build.py", root, scratch])
    folder = scratch / "html"
    pages, links, faults = check_links(folder)
    if built.returncode:
        faults.append("the build of the site failed")
    if links < 1000:
        faults.append(f"only {links} links: the pages have lost their text")
    print(f"{len(pages)} pages, {links} links, {len(faults)} faults, {time.monotonic() - began:.0f} s")
    found = browser.find_browser()
    if found:
        began = time.monotonic()
        # Pages of source code alike: one of them stands for all.
        sources = [p for p in pages if "source" in p.relative_to(folder).parts]
        open_pages([p for p in pages if p not in sources[1:]], folder, faults)
        print(f"opened in {found}: {len(faults)} faults, {time.monotonic() - began:.0f} s")
    print("\n".join(faults))
    if faults:
        sys.exit(1)
    if not found:
        print("skipped: chromium is not installed, so no page was opened; ./dev test --long installs it")
        sys.exit(77)


if __name__ == "__main__":
    main()
