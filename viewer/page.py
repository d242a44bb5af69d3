"""The page of the viewer, put together from the files beside this one.

  page.py ROOT           writes include/talus/io/detail/view_page_text.hpp, for --view of programs
  page.py ROOT --check   fails if that header does not match the files
"""
import json
import os
import pathlib
import sys

SCRIPTS = ("colours", "data", "orbit", "shaders", "hidden", "shapes", "stage", "picking", "plots", "view")
HEADER = "include/talus/io/detail/view_page_text.hpp"
# Where Debian's package libjs-three has the library; TALUS_THREE names another file.
THREE = "/usr/share/javascript/three/three.min.js"
PIECE = 12000  # characters of a literal: compilers need not take more than 65,536


def parts(folder):
    """The page before three.js, between three.js and the data, and after the data."""
    read = lambda name: (folder / name).read_text(encoding="utf-8")
    scripts = "\n".join(read(name + ".js") for name in SCRIPTS)
    own = f'<script>\nconst talus_view = (() => {{\n"use strict";\n{scripts}\nreturn talus_view;\n}})();\n</script>'
    page = read("page.html").replace("@STYLE@", read("style.css").rstrip())
    before, rest = page.split("@SCRIPTS@")
    between, after = rest.split("@DATA@")
    return before + "<script>\n", "\n</script>\n" + own + between, after


def three():
    """The text of three.js, or an exit with what to install."""
    path = os.environ.get("TALUS_THREE") or THREE
    try:
        text = pathlib.Path(path).read_text(encoding="utf-8")
    except OSError as error:
        sys.exit(f"view: the page needs three.js, and {path} cannot be read ({error.strerror}): install Debian's "
                 "package libjs-three, or name the file three.min.js in the environment variable TALUS_THREE")
    if "THREE" not in text or "</script" in text:
        sys.exit(f"view: {path} is not three.js as a plain script: name a file three.min.js in TALUS_THREE")
    return text


def script_of(name, value):
    """A JSON value as an element of the page."""
    text = json.dumps(value, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return f'<script type="application/json" class="talus-{name}">{text}</script>\n'


def literal(name, text):
    if ')page"' in text:
        sys.exit("page.py: the page contains the end of a raw string")
    pieces = [text[i:i + PIECE] for i in range(0, len(text), PIECE)]
    return f"inline constexpr const char* {name}[] = {{\n" + "".join(f'    R"page({p})page",\n' for p in pieces) + "};\n"


def header(folder):
    names = ("view_page_before_three", "view_page_before_data", "view_page_end")
    return ("#pragma once\n// The page of --view, from the files of viewer/: written by viewer/page.py.\n\n// clang-format off\n"
            "namespace talus::detail {\n\n" + "\n".join(literal(n, t) for n, t in zip(names, parts(folder))) +
            "\n}  // namespace talus::detail\n")


def main():
    root = pathlib.Path(sys.argv[1])
    text, file = header(root / "viewer"), root / HEADER
    if sys.argv[2:] == ["--check"]:
        if not file.exists() or file.read_text(encoding="utf-8") != text:
            sys.exit(f"{HEADER} does not match the files of viewer/: run python3 viewer/page.py .")
    else:
        file.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
