"""Draws docs/identify-screw.svg from the sample: deviations over position, and the plays that made them (numpy only).

    python3 tests/oracle/screw_picture.py
"""

import gzip
import os

import numpy as np

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
DEG = 36.0  # degrees of screw per mm of a 10 mm lead
STYLE = (
    "text{font:11px system-ui,sans-serif;fill:#57616c}.grid{stroke:#dde2e7}.axis{stroke:#57616c}"
    ".dot{fill:#8a949e;fill-opacity:.55}path{fill:none;stroke:#0072b2;stroke-width:1.8}"
    "@media(prefers-color-scheme:dark){text{fill:#a3adb8}.grid{stroke:#2e363f}path{stroke:#4da9e6}}"
)


def panel(left, x, y, half, unit, title, ticks, limit):
    """One loop: dots, grid, and the play of half gap `half` (same unit as y)."""
    w, h, top = 300.0, 190.0, 34.0
    lo, hi = -206.0, -99.0
    px = lambda v: left + 44 + (v - lo) / (hi - lo) * w
    py = lambda v: top + h / 2 - v / limit * h / 2
    out = [f'<text x="{left + 44:.0f}" y="18">{title}</text>']
    for t in ticks:
        out.append(f'<line class="grid" x1="{px(lo):.1f}" x2="{px(hi):.1f}" y1="{py(t):.1f}" y2="{py(t):.1f}"/>')
        out.append(f'<text x="{px(lo) - 6:.1f}" y="{py(t) + 4:.1f}" text-anchor="end">{t:g}</text>')
    for t in (-200, -175, -150, -125, -100):
        out.append(f'<text x="{px(t):.1f}" y="{top + h + 17:.1f}" text-anchor="middle">{t}</text>')
    out.append(f'<text x="{px(lo) + w / 2:.1f}" y="{top + h + 34:.1f}" text-anchor="middle">position of the joint, mm</text>')
    out.append(f'<text x="{left + 6:.0f}" y="{top - 2:.0f}">{unit}</text>')
    dots = "".join(f'<circle cx="{px(a):.1f}" cy="{py(b):.1f}" r="1"/>' for a, b in zip(x, y) if abs(b) < limit)
    out.append(f'<g class="dot">{dots}</g>')
    loop = [(-200, half), (-200, -half), (-100, -half), (-100, half), (-200, half)]
    out.append('<path d="M' + "L".join(f"{px(a):.1f} {py(b):.1f}" for a, b in loop) + '"/>')
    return "".join(out)


def main():
    with gzip.open(os.path.join(ROOT, "samples", "screw", "gantry2015_z.csv.gz"), "rt") as f:
        names = [line for line in (f.readline(), f.readline())][1].strip().split(",")
        data = np.loadtxt(f, delimiter=",")
    c = {n: data[:, k] for k, n in enumerate(names)}
    keep = slice(0, None, 5)
    cmd = c["cmd_Z_mm"][keep]
    coupling = (c["screw_Z_deg"] - c["enc_Z_deg"])[keep]
    nut = (c["meas_Z_mm"] - c["screw_Z_deg"] / DEG)[keep] * 1e3
    svg = (
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 720 270" width="720" height="270" role="img" '
        'aria-label="gaps of coupling and nut"><title>Deviation over position: screw against motor, carriage against screw</title>'
        f"<style>{STYLE}</style>"
        + panel(0, cmd, coupling, 0.9, "deg", "coupling: screw minus motor; gap 1.8 deg", (-1, 0, 1), 1.6)
        + panel(360, cmd, nut, 91.25, "um", "nut: carriage minus screw; gap 182.5 um", (-200, -100, 0, 100, 200), 260)
        + "</svg>\n"
    )
    with open(os.path.join(ROOT, "docs", "identify-screw.svg"), "w") as f:
        f.write(svg)


main()
