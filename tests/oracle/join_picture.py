#!/usr/bin/env python3
"""docs/join.svg: the speed of the TCP in two recordings of samples/join, by both clocks and on one. Needs numpy.

  join_picture.py OFFSET_S > docs/join.svg      (the offset that `join` prints for samples/join/*_2.csv.gz)
"""
import gzip
import pathlib
import sys

import numpy as np

import join

SAMPLES = pathlib.Path(__file__).resolve().parents[2] / "samples/join"
WIDE, HIGH, LEFT = 540, 110, 46


def recording(name):
    with gzip.open(SAMPLES / name, "rt") as file:
        return np.genfromtxt(file, delimiter=",", skip_header=1)


def speed(t, p, grid):
    """mm/s on a grid, from positions a twentieth of a second apart."""
    at = np.stack([np.interp(np.append(grid, grid[-1] + 0.05), t, p[:, k], np.nan, np.nan) for k in range(3)], 1)
    return np.linalg.norm(np.diff(at, axis=0), axis=1) / 0.05


def main(offset_s):
    ours, theirs = recording("controller_2.csv.gz"), recording("tracker_2.csv.gz")
    path = join.forward(ours[:, 1:], join.TCP0)
    begin, span = ours[0, 0] + 8.0, 8.0
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDE} {2 * HIGH + 52}" width="{WIDE}" height="{2 * HIGH + 52}" role="img" '
        'aria-label="Speed of the TCP by both clocks, and on one clock"><style>text{font:11px system-ui,sans-serif;fill:#57616c}'
        'path{fill:none;stroke-width:1.4}.c{stroke:#0072b2}.t{stroke:#e69f00}.axis{stroke:#8a949e}'
        '@media(prefers-color-scheme:dark){text{fill:#a3adb8}}</style>'
    ]
    grid = np.arange(begin, begin + span, 0.05)
    rows = [("by both clocks: controller blue, tracker orange", grid - begin + theirs[0, 0] + 8.0), ("on one clock", grid - offset_s)]
    most = np.nanmax(speed(ours[:, 0], path, grid)) * 1.15
    for k, (title, of_tracker) in enumerate(rows):
        base = 20 + (k + 1) * HIGH + 10 * k
        out.append(f'<text x="{LEFT}" y="{base - HIGH + 6}">{title}</text>')
        out.append(f'<path class="axis" d="M{LEFT} {base}H{WIDE - 10}"/>')
        for name, v in (("c", speed(ours[:, 0], path, grid)), ("t", speed(theirs[:, 0], theirs[:, 1:4], of_tracker))):
            xs = LEFT + (grid - begin) / span * (WIDE - 10 - LEFT)
            points = " ".join(f"{x:.1f},{base - y / most * (HIGH - 20):.1f}" for x, y in zip(xs, v) if np.isfinite(y))
            out.append(f'<path class="{name}" d="M{points}"/>')
    out.append(f'<text x="{WIDE - 10}" y="{2 * HIGH + 46}" text-anchor="end">{span:.0f} s; speed of the TCP up to {most / 1.15:.0f} mm/s</text></svg>')
    print("".join(out))


main(float(sys.argv[1]))
