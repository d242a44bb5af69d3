"""Guides: Markdown files as pages of the site, at the same places as in the tree."""
import html
import pathlib
import re
import textwrap

import markdown
import pygments
import pygments.formatters
import pygments.lexers
from pygments.util import ClassNotFound

LANGUAGES = {"": "text", "sh": "bash", "text": "text"}
FORMAT = pygments.formatters.HtmlFormatter(nowrap=True)


def highlight(code, language):
    try:
        lexer = pygments.lexers.get_lexer_by_name(LANGUAGES.get(language, language), stripnl=False)
    except ClassNotFound:
        lexer = pygments.lexers.get_lexer_by_name("text")
    return pygments.highlight(code, lexer, FORMAT)


def dedented(code):
    """The parts of a quoted block without their common indentation; a line "// ..." stands between two."""
    parts = re.split(r"^[ ]*// \.\.\.$\n", code, flags=re.M)
    return "// ...\n".join(textwrap.dedent(part) for part in parts)


def slug(heading):
    """The anchor of a heading, as GitHub makes it."""
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading.strip())
    return re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-")


def address(source):
    """Where the page of a guide is in the site: README.md is the front page of its folder."""
    source = pathlib.Path(source)
    return source.with_name("index.html") if source.name == "README.md" else source.with_suffix(".html")


class Guide:
    """A guide as HTML, and what the search finds of it."""

    def __init__(self, root, source):
        self.root, self.source, self.path = root, source, address(source)
        self.links = []  # the files that it names, relative to the root
        self.code = []   # of blocks of C++
        self.blocks = []
        text = self.take_blocks((root / source).read_text())
        self.title = next((re.sub(r"[`*]", "", m[1]) for m in [re.search(r"^# (.*)", text, re.M)] if m),
                          source.stem)
        body = markdown.markdown(self.prepared(text), extensions=["tables", "sane_lists", "toc"], tab_length=2,
                                 extension_configs={"toc": {"slugify": self.anchors(), "marker": ""}})
        body = re.sub(r"<p>TALUSBLOCK(\d+)X</p>|TALUSBLOCK(\d+)X", lambda m: self.blocks[int(m[1] or m[2])], body)
        # A heading has its own address at hand.
        body = re.sub(r'<h([2-6]) id="([^"]+)">(.*?)</h\1>',
                      r'<h\1 id="\2">\3 <a class="here" href="#\2" aria-label="Address of this section">#</a></h\1>',
                      body, flags=re.S)
        body = re.sub(r"<table>.*?</table>", lambda m: '<div class="table">' + m[0].replace(r"\|", "|") + "</div>",
                      body, flags=re.S)
        # The title comes first.
        before, heading, after = re.match(r"(.*?)(<h1\b.*?</h1>|$)(.*)", body, re.S).groups()
        self.body = heading + before + after

    def anchors(self):
        seen = {}

        def anchor(heading, _separator):
            name = slug(html.unescape(heading))
            seen[name] = seen.get(name, -1) + 1
            return name if seen[name] == 0 else f"{name}-{seen[name]}"
        return anchor

    def take_blocks(self, text):
        """Blocks of code are highlighted, under the name of the file that they are quoted from."""
        def block(match):
            source, language, code = match[1], match[2].strip(), match[3]
            if language == "cpp":
                code = dedented(code)
                self.code.append(code)
            name = ""
            if source:
                at = f'<a href="repo:{source}">{source}</a>' if (self.root / source).is_file() else source
                name = f'<figcaption>{at}</figcaption>'
            self.blocks.append(f'<figure class="code">{name}<pre><code>{highlight(code, language)}</code></pre></figure>')
            return f"\n\nTALUSBLOCK{len(self.blocks) - 1}X\n\n"
        return re.sub(r"^(?:<!-- (\S+) -->\n)?```([^\n]*)\n(.*?)^```$", block, text, flags=re.S | re.M)

    @staticmethod
    def prepared(text):
        """A list or a table may follow a paragraph without an empty line."""
        lines, item = [], re.compile(r"\s*([-*]|\d+\.) ")
        for line in text.splitlines():
            before = lines[-1] if lines else ""
            if before.strip() and not before.startswith((" ", "|")) and not item.match(before) and (
                    (item.match(line) and not line.startswith(" ")) or line.startswith("|")):
                lines.append("")
            lines.append(line)
        return "\n".join(lines)

    def sections(self):
        """(anchor, heading, text) of each part of the page."""
        parts = re.split(r'(<h[1-6] id="[^"]*">.*?</h[1-6]>)', self.body, flags=re.S)
        found = [("", self.title, plain(parts[0]))]
        for heading, text in zip(parts[1::2], parts[2::2]):
            anchor, words = re.match(r'<h\d id="([^"]*)">(.*?)</h', heading, re.S).groups()
            words = plain(words.split('<a class="here"')[0])
            first = heading.startswith("<h1")
            found.append(("" if first else anchor, words, plain(text)))
        return [f for f in found if f[2] or f[0]] or found


def plain(body):
    body = re.sub(r"</?(span|code|a|b|em|strong|sub|sup)\b[^>]*>", "", body)  # inside of words
    return re.sub(r"\s+", " ", html.unescape(re.sub(r"<[^>]+>", " ", body))).strip()
