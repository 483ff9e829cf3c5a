#!/usr/bin/env python3
"""Takes one drawing out of a report page, as a picture for docs: its own colours, light or dark as the reader has it.

  picture.py PAGE.html "START OF THE DRAWING'S LABEL" PICTURE.svg

docs/identify.svg: identify.html of make-pages.sh, "lost motion of joint J3".
docs/fit.svg: a page of `fit --gaps` of the same document, "offset in".
"""
import html
import pathlib
import re
import sys

STYLE = (
    "text{font:11px system-ui,sans-serif;fill:#57616c}.grid{stroke:#dde2e7}.zero{stroke:#8a949e}.axis{stroke:#57616c}"
    "path,line,circle{fill:none}*{--c:#0072b2}.j1{--c:#e69f00}.j2{--c:#56b4e9}.j3{--c:#cc79a7}.j4{--c:#d55e00}.j5{--c:#1a1f26}.j0{--c:#009e73}"
    ".line,.curve,.used,.mean{stroke:var(--c);stroke-width:1.6}.band,.half{fill:var(--c);fill-opacity:.16;stroke:none}.bar,rect{fill:#0072b2}"
    "rect.after{fill:#e69f00}.mark,.ci,.error{stroke:var(--c);stroke-width:1.5}.glyph,.dot{fill:var(--c)}.cycle{fill:var(--c);fill-opacity:.5}"
    "@media(prefers-color-scheme:dark){text{fill:#a3adb8}.grid{stroke:#2e363f}.j5{--c:#e6e9ec}}"
)


def main(page, label, picture):
    text = pathlib.Path(page).read_text(encoding="utf-8")
    for found in re.finditer(r"<svg [^>]*aria-label=\"([^\"]*)\"[^>]*>.*?</svg>", text, re.S):
        if html.unescape(found.group(1)).startswith(label):
            svg = found.group(0)
            box = re.search(r'viewBox="0 0 (\S+) (\S+)"', svg)
            size = f' xmlns="http://www.w3.org/2000/svg" width="{box.group(1)}" height="{box.group(2)}"'
            svg = re.sub(r' (data-[a-z]+|tabindex|class="(zooms|turns)")(="[^"]*")?', "", svg)
            head, rest = svg.split(">", 1)
            pathlib.Path(picture).write_text(head + size + "><style>" + STYLE + "</style>" + rest + "\n", encoding="utf-8")
            return
    sys.exit(f"{page}: no drawing whose label begins with `{label}`")


main(*sys.argv[1:])
