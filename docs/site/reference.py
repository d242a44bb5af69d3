"""The reference: what Doxygen's XML says of each public header, as one page a header."""
import html
import pathlib
import re
import xml.etree.ElementTree as ET

KINDS = {"class", "struct", "union", "concept"}
HIDDEN = {"talus_part_of", "name"}  # marks of policies, unless they are documented
DETAILS = re.compile(r"(^|::)detail(::|$)|::(impl|self_test)(::|$)")


class Entry:
    """A class, concept, function, alias, constant or enumeration of the namespace, with its members."""

    def __init__(self, node, name, kind, header):
        self.node, self.name, self.kind, self.header = node, name, kind, header
        self.short = name.removeprefix("talus::")
        self.anchor, self.members = "", []


class Reference:
    def __init__(self, xml, root):
        self.root, self.where, self.headers = root, {}, {}
        self.include = root / "include"
        compounds = [ET.parse(p).getroot().find("compounddef") for p in sorted(pathlib.Path(xml).glob("*.xml"))
                     if p.name not in ("index.xml", "Doxyfile.xml")]
        for c in compounds:
            name, kind = c.findtext("compoundname") or "", c.get("kind")
            if kind in KINDS and name.startswith("talus") and not DETAILS.search(name):
                self.add(Entry(c, name, kind, self.header_of(c)), c.get("id"))
            elif kind == "namespace" and name.split("::")[0] == "talus" and not DETAILS.search(name):
                for m in c.iter("memberdef"):
                    own = f"{name}::{m.findtext('name')}"
                    self.add(Entry(m, own, m.get("kind"), self.header_of(m)), m.get("id"))
        for entries in self.headers.values():
            entries.sort(key=lambda e: int(e.node.find("location").get("line") or 0))
        self.name_anchors()

    def header_of(self, node):
        at = node.find("location")
        file = (at.get("declfile") or at.get("file")) if at is not None else ""
        file = file.split("include/", 1)[-1]
        return file if (self.include / file).is_file() else ""

    def add(self, entry, id_):
        if not entry.header or "/detail/" in entry.header or "@" in entry.name or not entry.header.endswith(".hpp"):
            return
        if entry.kind in ("friend", "define") or entry.short.startswith("operator") or self.refuses(entry.node):
            return
        entry.id = id_
        self.headers.setdefault(entry.header, []).append(entry)

    @staticmethod
    def refuses(node):
        """An overload that only gives the message for a mistake."""
        words = "".join("".join(node.find(d).itertext()) for d in ("briefdescription", "detaileddescription"))
        return node.get("kind") == "function" and words.strip().startswith("Refuses")

    def name_anchors(self):
        """Addresses: page#name and page#name.member, numbered where names are overloaded."""
        self.names = {}
        for header, entries in self.headers.items():
            used = {}

            def unique(name):
                name = re.sub(r"[^\w.~:-]", "_", name)
                used[name] = used.get(name, 0) + 1
                return name if used[name] == 1 else f"{name}-{used[name]}"
            for e in entries:
                e.anchor = unique(e.short.replace("::", "."))
                self.where[e.id] = f"{self.page(header)}#{e.anchor}"
                if "<" not in e.short:
                    self.names.setdefault(e.short, []).append(e)
                if e.kind not in KINDS:
                    continue
                for section in e.node.findall("sectiondef"):
                    if section.get("kind", "").startswith(("private", "protected")):
                        continue
                    for m in section.findall("memberdef"):
                        name = m.findtext("name") or ""
                        hidden = name in HIDDEN and m.get("kind") != "function" and not self.description(m).strip()
                        if (m.get("prot") == "private" or hidden or m.get("kind") == "friend" or self.refuses(m)
                                or name.startswith(("~", "@"))):
                            continue
                        anchor = unique(f"{e.anchor}.{name}")
                        self.where[m.get("id")] = f"{self.page(header)}#{anchor}"
                        e.members.append((anchor, name, m))

    @staticmethod
    def page(header):
        return pathlib.Path("reference") / pathlib.Path(header).with_suffix(".html")

    def entry(self, name):
        """The one entry of this name, or None; overloads of a function count as one."""
        found = self.names.get(name, [])
        return found[0] if found and len({e.header for e in found}) == 1 else None

    # Text

    def text(self, node, depth=0):
        """Children of a description as HTML; links become /site addresses."""
        if node is None:
            return ""
        out = html.escape(node.text or "", quote=False)
        for child in node:
            out += self.element(child, depth) + html.escape(child.tail or "", quote=False)
        return out

    def element(self, e, depth):
        inside = lambda: self.text(e, depth + 1)
        tag = e.tag
        if tag == "ref":
            to = self.where.get(e.get("refid"))
            return f'<a href="/{to}">{inside()}</a>' if to else inside()
        if tag == "para":
            blocks = {"itemizedlist", "orderedlist", "simplesect", "programlisting", "verbatim", "parameterlist", "table"}
            return f"<div class=p>{inside()}</div>" if any(c.tag in blocks for c in e) else f"<p>{inside()}</p>"
        if tag in ("computeroutput", "emphasis", "bold", "subscript", "superscript"):
            as_ = {"computeroutput": "code", "emphasis": "em", "bold": "strong", "subscript": "sub", "superscript": "sup"}
            return f"<{as_[tag]}>{inside()}</{as_[tag]}>"
        if tag in ("itemizedlist", "orderedlist"):
            list_ = "ul" if tag == "itemizedlist" else "ol"
            return f"<{list_}>{inside()}</{list_}>"
        if tag == "listitem":
            return f"<li>{inside()}</li>"
        if tag == "ulink":
            return f'<a href="{html.escape(e.get("url"))}">{inside()}</a>'
        if tag in ("verbatim", "preformatted"):
            return f"<pre>{html.escape(''.join(e.itertext()))}</pre>"
        if tag == "programlisting":
            lines = ["".join(self.text(h) for h in line.iter("highlight")) for line in e.iter("codeline")]
            return "<pre><code>" + "\n".join(lines) + "</code></pre>"
        if tag == "sp":
            return " "
        if tag == "simplesect":
            return f"<div class=note><strong>{html.escape(e.get('kind', '').title())}:</strong> {inside()}</div>"
        if tag == "parameterlist":
            return f"<dl>{inside()}</dl>"
        if tag == "parameternamelist":
            return f"<dt><code>{inside()}</code></dt>"
        if tag == "parameterdescription":
            return f"<dd>{inside()}</dd>"
        named = {"mdash": "—", "ndash": "–", "nonbreakablespace": " ", "times": "×", "linebreak": "<br>"}
        return named[tag] if tag in named else inside()

    def description(self, node):
        return self.text(node.find("briefdescription")) + self.text(node.find("detaileddescription"))

    # Declarations

    def template(self, node):
        list_ = node.find("templateparamlist")
        if list_ is None:
            return ""
        parts = []
        for p in list_.findall("param"):
            name = p.findtext("declname")
            part = self.text(p.find("type")) + (f" {html.escape(name)}" if name else "")
            if p.find("defval") is not None:
                part += " = " + self.text(p.find("defval"))
            parts.append(part)
        requires = node.find("requiresclause")
        clause = f"\nrequires {self.text(requires)}" if requires is not None else ""
        return f"template &lt;{', '.join(parts)}&gt;{clause}\n"

    def declaration(self, m):
        """A function, field, alias or enumeration as it is written."""
        kind, name = m.get("kind"), html.escape(m.findtext("name") or "")
        type_ = re.sub(r"\[\[nodiscard[^\]]*\]\]|\[\[[^\]]*\]\]", "", self.text(m.find("type"))).strip()
        words = "static " if m.get("static") == "yes" and kind == "function" else ""
        if kind == "function":
            parts = []
            for p in m.findall("param"):
                part = self.text(p.find("type"))
                if p.findtext("declname"):
                    part += " " + html.escape(p.findtext("declname"))
                if p.find("defval") is not None:
                    part += " = " + self.text(p.find("defval"))
                parts.append(part + html.escape(p.findtext("array") or ""))
            after = (m.findtext("argsstring") or "").rpartition(")")[2]
            after = re.sub(r"\s*=\s*(default|delete)$", r" = \1", after)
            line = f"{words}{type_ + ' ' if type_ else ''}<b>{name}</b>({', '.join(parts)}){html.escape(after)}"
        elif kind == "typedef":
            line = f"using <b>{name}</b> = {type_}"
        elif kind == "enum":
            values = ", ".join(html.escape(v.findtext("name")) for v in m.findall("enumvalue"))
            line = f"enum class <b>{name}</b> {{ {values} }}"
        else:
            value = self.text(m.find("initializer")).strip()
            line = f"{words}{type_} <b>{name}</b>{html.escape(m.findtext('argsstring') or '')}"
            if value and len(value) < 200:
                line += value if value.startswith("{") else " " + value
        return self.template(m) + re.sub(r" +", " ", line)

    # Pages

    def purpose(self, header):
        """The comment at the head of a header."""
        words = []
        for line in (self.include / header).read_text().splitlines()[:25]:
            if line.startswith("// "):
                words.append(line[3:])
            elif words:
                break
        return re.sub(r"`([^`]+)`", r"<code>\1</code>", html.escape(" ".join(words), quote=False))

    def body(self, header, used_in):
        """The page of a header. `used_in(entry)`: links to guides, as HTML."""
        out = [f"<h1><code>{header}</code></h1>", f'<p class="lead">{self.purpose(header)}</p>',
               f'<figure class="code"><pre><code>#include &lt;{header}&gt;</code></pre></figure>',
               f'<p class="source"><a href="/source/include/{header}.html">Source</a></p>']
        for e in self.headers[header]:
            out.append(f'<section class="entry"><h2 id="{e.anchor}"><span class="kind">{e.kind}</span> '
                       f"<code>{html.escape(e.short)}</code></h2>")
            if e.kind in KINDS:
                bases = [self.text(b) for b in e.node.findall("basecompoundref")
                         if b.get("prot") == "public" and not DETAILS.search("".join(b.itertext()))]
                end = f" : {', '.join(bases)}" if bases else ""
                what = f"{e.kind} <b>{html.escape(e.short)}</b>{end}"
                if e.kind == "concept":
                    what = html.escape("".join(e.node.find("initializer").itertext()) if e.node.find("initializer")
                                       is not None else e.short)
                    out.append(f"<pre class=sig>{what}</pre>")
                else:
                    if bases or self.template(e.node):
                        out.append(f"<pre class=sig>{self.template(e.node)}{what}</pre>")
            else:
                out.append(f"<pre class=sig>{self.declaration(e.node)}</pre>")
            out.append(self.description(e.node))
            for v in e.node.findall("enumvalue"):
                out.append(f'<p class="value"><code>{html.escape(v.findtext("name"))}</code> '
                           f'{re.sub("</?p>", "", self.description(v))}</p>')
            for anchor, _, m in e.members:
                out.append(f'<div class="member" id="{anchor}"><pre class=sig>{self.declaration(m)}</pre>'
                           f"{self.description(m)}</div>")
            out.append(used_in(e) + "</section>")
        return "\n".join(out)
