"""One page of the site: navigation, search box, text, contents of the page, previous and next page."""
import html
import os
import pathlib
import re


def relative(to, page):
    """The address of a file of the site as a link on a page of it."""
    path, hash_, anchor = str(to).partition("#")
    if path == str(page):
        return hash_ + anchor or pathlib.Path(path).name
    return os.path.relpath(path, pathlib.Path(page).parent or ".") + hash_ + anchor


def navigation(tree, page):
    """Sections of (title, [(name, address)], address): guides are open, and so is the layer with the present
    page; of the other layers there is a link to their table."""
    parts = []
    for title, entries, table in tree:
        here = any(str(address) == str(page) for _, address in entries)
        if table and not here:
            parts.append(f'<p class="layer"><a href="{relative(table, page)}">{html.escape(title)}</a></p>')
            continue
        links = "".join(
            f'<li><a href="{relative(address, page)}"{" aria-current=page" if str(address) == str(page) else ""}>'
            f"{html.escape(name)}</a></li>" for name, address in entries)
        if title:
            parts.append(f"<details open><summary>{html.escape(title)}</summary>"
                         f"<ul>{links}</ul></details>")
        else:
            parts.append(f"<ul>{links}</ul>")
    return "\n".join(parts)


def contents(body):
    """Links to the headings of the second and third level, if there are several."""
    found = re.findall(r'<h([23]) id="([^"]+)"[^>]*>(.*?)</h\1>', body, re.S)
    if len(found) < 3:
        return ""
    plain = lambda text: re.sub(r'<a class="here".*?</a>|</?a\b[^>]*>|<span class="kind">.*?</span>', "", text)
    items = "".join(f'<li class="level{level}"><a href="#{anchor}">{plain(text).strip()}</a></li>'
                    for level, anchor, text in found)
    return f'<aside class="toc"><p>On this page</p><ul>{items}</ul></aside>'


def render(path, title, body, tree, before=None, after=None):
    """The HTML of a page; `before` and `after` are (name, address) or None."""
    to = lambda address: relative(address, path)
    turn = ""
    if before or after:
        turn = '<nav class="turn">' + "".join(
            f'<a class="{side}" rel="{side}" href="{to(page[1])}"><small>{word}</small> {html.escape(page[0])}</a>'
            for side, word, page in (("prev", "Previous", before), ("next", "Next", after)) if page) + "</nav>"
    up = os.path.relpath(".", pathlib.Path(path).parent or ".")
    return f"""<!DOCTYPE html>
<html lang="en" data-root="{up}/">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>{html.escape(title)} · talus</title>
<link rel="icon" href="data:,">
<link rel="stylesheet" href="{to('style.css')}">
</head>
<body>
<header>
<input type="checkbox" id="talus-menu" aria-label="Navigation"><label for="talus-menu" title="Navigation">☰</label>
<a class="home" href="{to('index.html')}">talus</a>
<form class="search" role="search" action="{to('index.html')}">
<input id="talus-search" type="search" name="q" placeholder="Search guides and reference (press /)" autocomplete="off"
 aria-label="Search guides and reference" aria-controls="talus-results">
<div id="talus-results" hidden></div>
</form>
</header>
<div class="columns">
<nav class="tree">
{navigation(tree, path)}
</nav>
<main>
{body}
{turn}
</main>
{contents(body)}
</div>
<script src="{to('search_index.js')}"></script>
<script src="{to('search.js')}"></script>
</body>
</html>
"""
