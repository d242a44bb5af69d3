"""The table of contents: the sections and pages that docs/README.md lists, in its order."""
import pathlib
import re


class Page:
    """A guide: its file, its short name in the navigation, and the section that lists it."""

    def __init__(self, source, name, section):
        self.source, self.name, self.section = source, name, section


def pages_of(root):
    """All guides of the project, relative to its root."""
    found = sorted(root.glob("*.md")) + sorted((root / "docs").rglob("*.md"))
    return [p.relative_to(root) for p in found]


def read(root):
    """(pages in order, faults). A fault is a guide without an entry, or an entry without a guide."""
    index = root / "docs" / "README.md"
    pages, faults, section = [Page(pathlib.Path("docs/README.md"), "Contents", "")], [], ""
    for number, line in enumerate(index.read_text().splitlines(), 1):
        if heading := re.match(r"## (.*)", line):
            section = heading[1]
        elif entry := re.match(r"- \[([^\]]+)\]\(([^)#]+\.md)\): ", line):
            source = (index.parent / entry[2]).resolve()
            if source.is_file():
                pages.append(Page(source.relative_to(root), entry[1], section))
            else:
                faults.append(f"docs/README.md:{number}: there is no {entry[2]}")
        elif line.startswith("- "):
            faults.append(f"docs/README.md:{number}: an entry reads '- [name](page.md): sentence'")
    listed = [p.source for p in pages]
    for source in [p for p in pages_of(root) if p not in listed]:
        faults.append(f"docs/README.md does not list {source}: add '- [name](page.md): sentence' to a section")
        pages.append(Page(source, source.stem, "More"))
    faults += [f"docs/README.md lists {p} twice" for p in {p for p in listed if listed.count(p) > 1}]
    return pages, faults
