#!/usr/bin/env python3
"""Draws the figures of the guides as SVG files beside this script, for light and dark pages.
  draw.py [--check]     with --check: whether the files are those that it draws
"""
import math
import pathlib
import sys

STYLE = """
text { font-family: "DejaVu Sans", "Segoe UI", system-ui, sans-serif; font-size: 14px; fill: #1d2430 }
.small { font-size: 12px } .dim { fill: #5a6474 } .strong { font-weight: bold } .mono { font-family: "DejaVu Sans Mono", monospace; font-size: 13px }
.mid { text-anchor: middle } .end { text-anchor: end }
.paper { fill: #ffffff }
.box { fill: #e9f0f9; stroke: #7f9cc0 } .band { fill: #f3f5f8 }
.line { stroke: #4c5766; fill: none } .thin { stroke: #a9b3c0; fill: none } .dash { stroke-dasharray: 5 4 }
.arrow { stroke: #1257a6; fill: none; stroke-width: 1.6 } .head { fill: #1257a6 }
.c0 { fill: #8fbce6; stroke: #2a6aa8 } .c1 { fill: #f2b880; stroke: #b5671a } .c2 { fill: #9fd3a0; stroke: #3b8a3d } .c3 { fill: #dba6d6; stroke: #93448c }
.t0 { fill: #dceafa } .t1 { fill: #fbe9d6 } .t2 { fill: #e0f2e0 } .t3 { fill: #f5e4f3 }
.copy { fill-opacity: 0.25; stroke-dasharray: 4 3 }
.cone { fill: #8fbce6; fill-opacity: 0.35; stroke: #2a6aa8 } .mark { fill: #c0392b } .force { stroke: #c0392b; stroke-width: 2; fill: none } .tip { fill: #c0392b }
@media (prefers-color-scheme: dark) {
  text { fill: #dde3ea } .dim { fill: #9aa5b3 } .paper { fill: #1b2128 } .band { fill: #242c35 }
  .box { fill: #27384c; stroke: #6f93bb } .line { stroke: #aab6c4 } .thin { stroke: #5a6675 }
  .arrow { stroke: #7ab8ff } .head { fill: #7ab8ff }
  .c0 { fill: #3b6ea5; stroke: #9cc6f0 } .c1 { fill: #a5682a; stroke: #f2c08c } .c2 { fill: #3f7f42; stroke: #a8dba9 } .c3 { fill: #874a82; stroke: #e3b3de }
  .t0 { fill: #202f40 } .t1 { fill: #3a2d1f } .t2 { fill: #21342a } .t3 { fill: #352536 }
  .cone { fill: #3b6ea5; stroke: #9cc6f0 } .mark, .tip { fill: #ff7b6b } .force { stroke: #ff7b6b }
}
"""


class Drawing:
    def __init__(self, width, height, title):
        self.width, self.height, self.title, self.parts = width, height, title, []

    def add(self, text):
        self.parts.append(text)

    def rect(self, x, y, w, h, kind="box", r=5):
        self.add(f'<rect x="{x:.1f}" y="{y:.1f}" width="{w:.1f}" height="{h:.1f}" rx="{r}" class="{kind}"/>')

    def text(self, x, y, words, kind=""):
        words = words.replace("&", "&amp;").replace("<", "&lt;")
        self.add(f'<text x="{x:.1f}" y="{y:.1f}" class="{kind}">{words}</text>')

    def line(self, points, kind="line"):
        self.add(f'<polyline points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in points)}" class="{kind}"/>')

    def polygon(self, points, kind):
        self.add(f'<polygon points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in points)}" class="{kind}"/>')

    def circle(self, x, y, r, kind):
        self.add(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{r:.1f}" class="{kind}"/>')

    def arrow(self, a, b, kind="arrow", head="head", size=8):
        angle = math.atan2(b[1] - a[1], b[0] - a[0])
        back = (b[0] - 0.8 * size * math.cos(angle), b[1] - 0.8 * size * math.sin(angle))
        self.line([a, back], kind)
        self.polygon([b] + [(b[0] - size * math.cos(angle + s), b[1] - size * math.sin(angle + s))
                            for s in (0.42, -0.42)], head)

    def svg(self):
        return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.width} {self.height}" width="{self.width}" '
                f'height="{self.height}" role="img">\n<title>{self.title}</title>\n<style>{STYLE}</style>\n'
                f'<rect width="{self.width}" height="{self.height}" rx="8" class="paper"/>\n' + "\n".join(self.parts) + "\n</svg>\n")


def layers():
    """From the foundation at the bottom to what users include at the top."""
    rows = [("13", ["scene/"], "run, options, lattices, inflow, outflow"), ("12", ["io/", "observe/"], "files; digest, energy, fields, summary"),
            ("11", ["world/"], "the public face: world, views, sections"), ("10", ["step/"], "one time step"),
            ("9", ["features/"], "optional parts, with their hooks"), ("8", ["pairs/"], "search for pairs, neighbour lists"),
            ("7", ["ghosts/"], "migration, shadow copies"), ("6", ["state/"], "a world on one rank"),
            ("5", ["scenario/"], "policies, their defaults and contradictions"),
            ("4", ["solver/", "parallel/"], "sweeps; domains, messages"),
            ("3", ["detect/", "constraint/", "interaction/", "motion/"], "contacts, rows, soft laws; integration"), ("2", ["body/", "contact/"], "columns, materials; keys of contacts"),
            ("1", ["geometry/", "shape/"], "parts of space; shapes"), ("0", ["core/", "concepts.hpp"], "numbers, vectors, ids, errors")]
    d = Drawing(760, 64 + 36 * len(rows), "The layers of talus")
    d.text(24, 30, "Level", "small dim")
    d.text(84, 30, "Folders of include/talus/", "small dim")
    for n, (level, names, words) in enumerate(rows):
        y = 42 + 36 * n
        d.rect(16, y, 700, 32, "band")
        d.text(44, y + 21, level, "mid dim")
        x = 84
        for name in names:
            w = 20 + 8 * len(name)
            d.rect(x, y + 4, w, 24)
            d.text(x + w / 2, y + 21, name, "mid mono")
            x += w + 8
        d.text(706, y + 21, words, "small end")
    d.arrow((727, 48), (727, 42 + 36 * len(rows) - 6))
    d.add(f'<text transform="translate(738 {42 + 18 * len(rows)}) rotate(90)" class="small mid dim">includes only from lower layers</text>')
    return d


def step():
    """The messages of a step between two ranks, with 10 iterations and 3 of the correction."""
    d = Drawing(760, 590, "One time step on two ranks")
    left, right = 160, 560
    stages = [("announce", 74, 44), ("detect", 134, 40), ("respond", 190, 140), ("integrate", 346, 84), ("migrate, refresh", 446, 96)]
    for x, name in ((left, "rank 0"), (right, "rank 1")):
        d.text(x, 34, name, "mid strong")
        d.line([(x, 46), (x, 566)], "thin dash")
        for stage, y, h in stages:
            d.rect(x - 66, y, 132, h)
            d.text(x, y + (h / 2 + 5 if h < 60 else 20), stage, "mid")

    def both(y, words, count, gap=13):
        d.arrow((left + 68, y), (right - 68, y))
        d.arrow((right - 68, y + gap), (left + 68, y + gap))
        d.text((left + right) / 2, y - 6, words, "mid small")
        d.text(744, y + gap / 2 + 4, count, "end strong")
    d.text(744, 34, "messages", "end small dim")
    both(96, "changes by the user, if any", "1")
    both(222, "velocities after iteration 1", "")
    both(258, "after iteration 2", "")
    d.text((left + right) / 2, 288, "...", "mid")
    both(312, "after iteration 10", "")
    d.text(744, 264, "10", "end strong")
    d.text(left, 232, "boundary", "mid small dim"), d.text(left, 248, "contacts, then", "mid small dim"), d.text(left, 264, "interior ones", "mid small dim")
    d.text(left, 284, "10 iterations", "mid small dim")
    d.text(right, 232, "the same", "mid small dim"), d.text(right, 248, "boundary contacts,", "mid small dim"), d.text(right, 264, "its own interior", "mid small dim")
    d.text(right, 284, "10 iterations", "mid small dim")
    both(392, "displacements of the position correction", "2")
    d.text(left, 392, "correction,", "mid small dim"), d.text(left, 408, "then move", "mid small dim")
    d.text(right, 392, "correction,", "mid small dim"), d.text(right, 408, "then move", "mid small dim")
    both(474, "bodies that leave, with their contacts", "1")
    both(520, "shadow copies", "1")
    d.arrow((26, 60), (26, 560), "thin", "head")
    d.text(36, 310, "time", "small dim")
    d.text(744, 572, "sum: 15 to each neighbour", "end small")
    return d


def ghosts():
    """A corner of four domains: who owns each body, and what each rank holds."""
    size, reach = 230, 12
    bodies = [(0.06, 0.05, 34), (-0.42, 0.28, 26), (0.42, 0.38, 30), (-0.24, -0.30, 30), (0.38, -0.22, 26), (-0.12, 0.56, 24), (0.62, -0.64, 26), (-0.66, -0.60, 24)]
    d = Drawing(760, 428, "Shadow copies at a corner of four domains")
    largest = max(r for *_, r in bodies)

    def owner(x, y):
        return (1 if x >= 0 else 0) + (2 if y >= 0 else 0)

    def scene(cx, cy, scale, visible):
        half = size / 2 * scale * 1.4
        for k in range(4):
            x, y = (cx if k % 2 else cx - half), (cy - half if k // 2 else cy)
            d.add(f'<rect x="{x:.1f}" y="{y:.1f}" width="{half:.1f}" height="{half:.1f}" class="t{k}"'
                  f'{"" if visible is None or visible == k else " opacity=" + chr(34) + "0.25" + chr(34)}/>')
        d.line([(cx - half, cy), (cx + half, cy)], "line"), d.line([(cx, cy - half), (cx, cy + half)], "line")
        for x, y, r in bodies:
            px, py, k = x * size / 1.4, y * size / 1.4, owner(x, y)
            kind = f"c{k}"
            if visible is not None and visible != k:
                dx = max(0.0, -px if visible % 2 else px)
                dy = max(0.0, -py if visible // 2 else py)
                if math.hypot(dx, dy) > r + largest * 0.55 + reach:
                    continue
                kind += " copy"
            d.circle(cx + px * scale * 1.4 * 0.7, cy - py * scale * 1.4 * 0.7, r * scale, kind)
        return half
    half = scene(180, 206, 1.0, None)
    for k, (x, y) in enumerate(((-1, 1), (1, 1), (-1, -1), (1, -1))):
        d.text(180 + x * (half - 34), 206 + y * (half - 12) + 5, f"rank {k}", "mid small strong")
    d.text(180, 24, "owners: by the centre of mass", "mid small")
    for k, (cx, cy) in enumerate(((470, 300), (650, 300), (470, 118), (650, 118))):
        scene(cx, cy, 0.5, k)
        d.text(cx, cy - 86, f"rank {k} holds", "mid small strong")
    d.circle(60, 398, 10, "c0"), d.text(78, 403, "own body", "small")
    d.circle(170, 398, 10, "c0 copy"), d.text(188, 403, "shadow copy, in the colour of its owner", "small")
    d.text(744, 403, "faint: domains of other ranks", "small end dim")
    return d


def hexagonal():
    """19 hexagonal domains: their ranks, and the connections of three of them."""
    d = Drawing(760, 490, "A hexagonal decomposition of 19 ranks and its connections")
    cx, cy, spacing = 290, 246, 96
    steps = [(-1, 1), (-1, 0), (0, -1), (1, -1), (1, 0), (0, 1)]
    places = [(0, 0)]
    for ring in (1, 2):
        at = (ring, 0)
        for dq, dr in steps:
            for _ in range(ring):
                places.append(at)
                at = (at[0] + dq, at[1] + dr)
    centre = lambda p: (cx + spacing * (p[0] + p[1] / 2), cy - spacing * p[1] * math.sqrt(3) / 2)
    for n, p in enumerate(places):
        x, y = centre(p)
        radius = spacing / math.sqrt(3) - 1.5
        kind = "c0" if n == 0 else "c2" if n == 7 else "c1" if n == 8 else "box"
        d.polygon([(x + radius * math.cos(math.radians(30 + 60 * k)), y + radius * math.sin(math.radians(30 + 60 * k)))
                   for k in range(6)], kind)
    for n in (0, 7, 8):
        x, y = centre(places[n])
        for dq, dr in steps:
            other = (places[n][0] + dq, places[n][1] + dr)
            if other in places:
                X, Y = centre(other)
                far = math.hypot(X - x, Y - y)
                d.arrow((x + 17 * (X - x) / far, y + 17 * (Y - y) / far), (X - 17 * (X - x) / far, Y - 17 * (Y - y) / far))
    for n, p in enumerate(places):
        x, y = centre(p)
        d.text(x, y + 5, str(n), "mid strong")
    x = 560
    d.text(x, 80, "hexagonal<2>", "mono strong")
    for n, words in enumerate(("19 = 3 · 2 · (2 + 1) + 1 ranks,", "numbered ring by ring,", "counter-clockwise")):
        d.text(x, 104 + 19 * n, words, "small")
    for n, (kind, words) in enumerate((("c0", "inside: 6 connections"), ("c1", "on an edge: 4"), ("c2", "at a corner: 3"))):
        d.circle(x + 9, 190 + 28 * n, 8, kind)
        d.text(x + 26, 195 + 28 * n, words, "small")
    d.arrow((x, 282), (x + 34, 282))
    d.text(x + 44, 287, "start: from rank 0 to 1", "small")
    d.text(x, 330, "A point belongs to the nearest", "small dim"), d.text(x, 348, "centre, so the outer cells", "small dim"), d.text(x, 366, "extend to infinity.", "small dim")
    return d


def cone():
    """Coulomb's cone of impulses, and the three states of a contact."""
    d = Drawing(760, 400, "The friction cone and the admissible impulses")
    ax, ay, height, wide, flat = 190, 330, 240, 130, 30
    d.add(f'<path d="M {ax} {ay} L {ax - wide} {ay - height} A {wide} {flat} 0 0 0 {ax + wide} {ay - height} Z" class="cone"/>')
    d.add(f'<ellipse cx="{ax}" cy="{ay - height}" rx="{wide}" ry="{flat}" class="cone"/>')
    d.line([(40, ay), (360, ay)], "line")
    d.arrow((ax, ay), (ax, 46), "line", "head")
    d.text(ax + 10, 52, "normal impulse rₙ", "")
    d.arrow((ax, ay), (350, ay), "line", "head")
    d.text(352, ay - 10, "tangential impulse rₜ", "small end")
    d.line([(ax, ay - height), (ax + wide, ay - height)], "thin dash")
    d.text(ax + wide + 8, ay - height + 5, "μ rₙ", "strong")
    for k in range(10):
        d.line([(52 + 32 * k, ay + 12), (64 + 32 * k, ay)], "thin")
    d.circle(ax, ay, 5, "mark")
    d.text(ax - 12, ay + 32, "1", "mid strong")
    d.arrow((ax, ay), (ax - 36, ay - 150), "force", "tip")
    d.text(ax - 52, ay - 150, "2", "mid strong")
    x = ax + wide * 190 / height
    d.arrow((ax, ay), (x, ay - 190), "force", "tip")
    d.text(x + 12, ay - 180, "3", "mid strong")
    x = 400
    rows = [("Admissible: |rₜ| ≤ μ rₙ", "strong"), ("The cone and its inside.", ""), ("", ""),
            ("1  open", "strong"), ("The bodies part: rₙ = 0, so rₜ = 0.", ""), ("", ""),
            ("2  sticking", "strong"), ("Inside the cone: the surfaces do not slip.", ""), ("", ""),
            ("3  sliding", "strong"), ("On the cone: |rₜ| = μ rₙ, and friction acts", ""), ("against the slip. An impulse outside the", ""),
            ("cone is projected back onto it.", "")]
    y = 92
    for words, kind in rows:
        d.text(x, y, words, kind if kind else "small")
        y += 21 if words else 9
    return d


def main():
    here, wrong = pathlib.Path(__file__).parent, []
    for figure in (layers, step, ghosts, hexagonal, cone):
        file, text = here / f"{figure.__name__}.svg", figure().svg()
        if "--check" not in sys.argv:
            file.write_text(text)
        elif not file.is_file() or file.read_text() != text:
            wrong.append(file.name)
    if wrong:
        sys.exit(f"{', '.join(wrong)}: not what draw.py draws; call python3 docs/figures/draw.py")


if __name__ == "__main__":
    main()
