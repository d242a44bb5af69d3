#!/usr/bin/env python3
"""Builds the documentation as one static site: the guides, and the reference of the public API.

  build.py ROOT OUTPUT      writes OUTPUT/html/index.html; what Doxygen says goes to OUTPUT/xml
  build.py ROOT --check     only whether docs/README.md lists each guide, once
Needs Doxygen, python3-markdown and python3-pygments; nothing is loaded from elsewhere. A link that
leads nowhere is an error.
"""
import html
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

import contents

PICTURES = {".png", ".svg", ".gif", ".jpg"}
CODE = {".hpp": "cpp", ".cpp": "cpp", ".py": "python", ".sh": "bash", ".cmake": "cmake", ".txt": "text",
        ".dict": "text", "": "bash"}
SHORT = 4  # letters that a name needs to be linked from the text of a guide
# Everyday words that are names, too: a link from each of them would be noise.
WORDS = {"sphere", "plane", "world", "body", "site", "every", "grid", "mass", "real", "material", "motion"}


class Site:
    def __init__(self, root, output):
        self.root, self.html, self.xml = root, output / "html", output / "xml"
        self.faults, self.linked, self.copied = [], set(), set()

    # Files of the tree as addresses of the site.

    def target(self, file, where):
        """The address of a file or folder, relative to the root of the tree."""
        if not (self.root / file).exists():
            self.faults.append(f"{where}: there is no {file}")
            return file
        if (self.root / file).is_dir():
            readme = pathlib.Path(file) / "README.md"
            if readme in self.guide_pages:
                return self.guide_pages[readme]
            self.linked.add(file)
            return pathlib.Path("source") / file / "index.html"
        if file in self.guide_pages:
            return self.guide_pages[file]
        header = str(file).removeprefix("include/")
        if header in self.reference.headers and str(file).startswith("include/"):
            return self.reference.page(header)
        if file.suffix in PICTURES or file.suffix not in CODE:
            self.copied.add(file)
            return file
        self.linked.add(file)
        return pathlib.Path("source") / f"{file}.html"

    def relink(self, body, path, source=None):
        """Addresses in a body as links of the page `path`. Those of a guide, `source`, name files."""
        from page import relative

        def link(match):
            name, to = match[1], html.unescape(match[2])
            to, hash_, anchor = to.partition("#")
            if re.match(r"(https?|mailto|data):", to) or (not to and hash_):
                return match[0]
            if to.startswith("/"):
                address = to[1:]
            elif to.startswith("repo:"):
                address = self.target(pathlib.Path(to[5:]), source)
            else:
                file = os.path.normpath(pathlib.Path(source).parent / to)
                if file.startswith(".."):
                    self.faults.append(f"{source}: {to} is outside of the project")
                    return match[0]
                address = self.target(pathlib.Path(file), source)
            return f'{name}="{html.escape(relative(f"{address}{hash_}{anchor}", path))}"'
        return re.sub(r'\b(href|src)="([^"]*)"', link, body)

    def link_names(self, body):
        """Names of the reference in the text of a guide become links."""
        def name(match):
            word = re.match(r"(?:talus::)?([a-z]\w+)(?:&lt;.*&gt;)?(?:\(.*\)|\{.*\})?$", match[1])
            entry = word and len(word[1]) >= SHORT and word[1] not in WORDS and self.reference.entry(word[1])
            return f'<a class="ref" href="/{self.reference.where[entry.id]}">{match[0]}</a>' if entry else match[0]
        parts = re.split(r"(<pre.*?</pre>|<a\b.*?</a>|<h\d.*?</h\d>)", body, flags=re.S)
        return "".join(p if i % 2 else re.sub(r"<code>([^<]*)</code>", name, p) for i, p in enumerate(parts))

    def names_in_guides(self):
        """For each name of the reference the guides that say it, most often first."""
        counts = {}
        for g in self.guides:
            if g.source.name in ("members.md", "CHANGELOG.md"):
                continue
            words = re.findall(r"[a-z]\w+", " ".join(g.code + re.findall(r"<code>([^<]*)</code>", g.body)))
            for word in words:
                if word in self.reference.names:
                    of = counts.setdefault(word, {})
                    of[g] = of.get(g, 0) + 1
        return {w: sorted(of, key=lambda g: -of[g])[:6] for w, of in counts.items()}

    # Steps of the build

    def read(self):
        from guides import Guide, address
        from reference import Reference
        self.pages, faults = contents.read(self.root)
        self.faults += faults
        self.guide_pages = {p.source: address(p.source) for p in self.pages}
        self.reference = Reference(self.xml, self.root)
        self.guides = [Guide(self.root, p.source) for p in self.pages]
        layers = {}
        for header in sorted(self.reference.headers):
            layers.setdefault(str(pathlib.Path(header).parent), []).append(header)
        self.layers = layers
        sections = []
        for p in self.pages:
            if not sections or sections[-1][0] != p.section:
                sections.append((p.section, [], None))
            sections[-1][1].append((p.name, self.guide_pages[p.source]))
        headers = ("Public headers", pathlib.Path("reference/index.html"))
        next((s for s in sections if s[0] == "Reference"), sections[-1])[1].insert(0, headers)
        self.tree = sections + [
            (layer, [(pathlib.Path(h).stem, self.reference.page(h)) for h in headers],
             f"reference/index.html#{layer.replace('/', '.')}")
            for layer, headers in sorted(layers.items())]

    def write(self, path, title, body, before=None, after=None):
        import page
        file = self.html / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(page.render(path, title, body, self.tree, before, after))

    def write_guides(self):
        order = [(p.name, self.guide_pages[p.source]) for p in self.pages]
        for n, (p, g) in enumerate(zip(self.pages, self.guides)):
            body = self.relink(self.link_names(g.body), g.path, g.source)
            self.write(g.path, g.title, body, order[n - 1] if n else None, order[n + 1] if n + 1 < len(order) else None)

    def write_reference(self):
        said = self.names_in_guides()

        def used_in(entry):
            found = said.get(entry.short, [])
            links = ", ".join(f'<a href="/{g.path}">{html.escape(g.title)}</a>' for g in found)
            return f'<p class="used">Guides: {links}</p>' if found else ""
        for header, entries in self.reference.headers.items():
            path = self.reference.page(header)
            self.linked.add(pathlib.Path("include") / header)
            self.write(path, header, self.relink(self.reference.body(header, used_in), path))
        parts = ["<h1>Public headers</h1><p>All names of the namespace <code>talus</code>, by the layers of "
                 '<a href="/docs/architecture.html">the architecture</a>. <code>#include &lt;talus/talus.hpp&gt;</code> '
                 "includes most of them.</p>"]
        shown = ("class", "struct", "union", "concept", "function", "enum", "typedef")
        for layer, headers in sorted(self.layers.items()):
            rows = ""
            for h in headers:
                names = {}  # each once, whatever its overloads
                for e in self.reference.headers[h]:
                    if e.kind in shown:
                        names.setdefault(e.short, self.reference.where[e.id])
                links = ", ".join(f'<a href="/{to}"><code>{html.escape(n)}</code></a>' for n, to in names.items())
                rows += (f'<tr><td><a href="/{self.reference.page(h)}"><code>{pathlib.Path(h).name}</code></a></td>'
                         f"<td>{links}</td></tr>")
            parts.append(f'<h2 id="{layer.replace("/", ".")}"><code>{layer}</code></h2><div class="table"><table>{rows}</table></div>')
        self.write("reference/index.html", "Public headers", self.relink("\n".join(parts), "reference/index.html"))

    def write_sources(self):
        from guides import highlight
        for file in sorted(self.linked):
            path = pathlib.Path("source") / (file / "index.html" if (self.root / file).is_dir() else f"{file}.html")
            if (self.root / file).is_dir():
                names = sorted(p.name for p in (self.root / file).iterdir())
                body = f"<h1><code>{file}/</code></h1><ul>" + "".join(f"<li><code>{n}</code></li>" for n in names) + "</ul>"
            else:
                text = (self.root / file).read_text()
                body = (f"<h1><code>{file}</code></h1><figure class=\"code whole\"><pre><code>"
                        f"{highlight(text, CODE.get(file.suffix, 'text'))}</code></pre></figure>")
            self.write(path, str(file), body)
        for file in self.copied:
            (self.html / file).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(self.root / file, self.html / file)

    def write_index(self):
        """What the search looks through: parts of guides, and names of the reference."""
        entries = []
        for p, g in zip(self.pages, self.guides):
            weight = {"members.md": 0.3, "CHANGELOG.md": 0.3}.get(g.source.name, 0.6 if g.source.parts[:2] in (
                ("docs", "report"), ("docs", "performance"), ("docs", "validation")) else 1)
            for anchor, heading, text in g.sections():
                entries.append({"k": "guide", "p": g.title, "h": heading, "s": p.section, "w": weight,
                                "u": f"{g.path}#{anchor}" if anchor else str(g.path), "t": text})
        from guides import plain
        for header, own in self.reference.headers.items():
            for e in own:
                entries.append({"k": e.kind, "p": header, "h": e.short, "s": "Reference", "w": 1,
                                "u": self.reference.where[e.id], "t": plain(self.reference.description(e.node))})
                for anchor, name, m in e.members:
                    entries.append({"k": "member", "p": header, "h": f"{e.short}::{name}", "s": "Reference", "w": 0.7,
                                    "u": f"{self.reference.page(header)}#{anchor}",
                                    "t": plain(self.reference.description(m))})
        text = json.dumps(entries, ensure_ascii=False, separators=(",", ":"))
        (self.html / "search_index.js").write_text(f"window.SEARCH_INDEX = {text};\n")

    def write_styles(self):
        import pygments.formatters
        here = pathlib.Path(__file__).parent
        light = pygments.formatters.HtmlFormatter(style="friendly").get_style_defs("pre code")
        dark = pygments.formatters.HtmlFormatter(style="github-dark").get_style_defs("pre code")
        # Colours of words alone: backgrounds are those of the page.
        words = lambda style: "\n".join(line for line in style.splitlines() if re.match(r"pre code \.\w+ ", line)
                                        and ".err" not in line)
        (self.html / "style.css").write_text((here / "style.css").read_text() + words(light) +
                                             "\n@media (prefers-color-scheme: dark) {\n" + words(dark) + "\n}\n")
        shutil.copy(here / "search.js", self.html / "search.js")


def run_doxygen(root, output):
    """Its warnings, each of which is a reference in a comment that leads nowhere."""
    environment = {**os.environ, "TALUS_ROOT": str(root), "TALUS_DOCS_OUTPUT": str(output)}
    subprocess.run(["doxygen", str(root / "docs" / "Doxyfile")], check=True, cwd=root, env=environment)
    log = output / "warnings.txt"
    return log.read_text().splitlines() if log.is_file() else []


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    if sys.argv[2:] == ["--check"]:
        pages, faults = contents.read(root)
        print("\n".join(faults))
        print(f"{len(pages)} guides, {len(faults)} faults")
        sys.exit(1 if faults else 0)
    output = pathlib.Path(sys.argv[2]).resolve()
    sys.path.insert(0, str(pathlib.Path(__file__).parent))
    began = time.monotonic()
    for old in (output / "html", output / "xml"):
        shutil.rmtree(old, ignore_errors=True)
    (output / "html").mkdir(parents=True)
    site = Site(root, output)
    site.faults += run_doxygen(root, output)
    read = time.monotonic()
    site.read()
    site.write_guides()
    site.write_reference()
    site.write_sources()
    site.write_index()
    site.write_styles()
    pages = sum(1 for _ in (output / "html").rglob("*.html"))
    print(f"{pages} pages: Doxygen {read - began:.0f} s, the site {time.monotonic() - read:.0f} s")
    if site.faults:
        print("\n".join(sorted(set(site.faults))), file=sys.stderr)
        sys.exit(1)


if __name__ == "__main__":
    main()
