"""Compares where G-code leads: the reader of this project and LinuxCNC's standalone interpreter.

    rs274.py RS274 TARGETS FOLDER

RS274 is LinuxCNC's `rs274` (Debian's linuxcnc-uspace has it; it may be unpacked without being installed, with LD_LIBRARY_PATH set).
TARGETS is `cargo build -p robot-programs --example targets`. Both read a copy of each program whose blocks have line numbers, so that
what the interpreter commands is known by line. rs274 runs the program once, with no work offsets and an empty tool table; the reader
tells where each line leads, whatever runs. So a line that runs several times must lead to one of the reader's goals each time, and a
goal that counts from another origin is not compared. Output: a table in Markdown of what agrees and what does not, checked in as
rs274.md with the reasons.
"""

import collections
import pathlib
import re
import subprocess
import sys
import tempfile

AXES = "XYZABCUVW"
TABLE = ",".join(a + (":deg" if a in "ABC" else ":mm") for a in AXES)
# halves of the last digit that rs274 prints, in mm or deg; an inch has 25.4 of them
NEAR = 6e-5


def numbered(text):
    """Every block that may have a number gets that of its line; flow control, comments and the tape's ends stay. The start of the
    interpreter, G21 and G90, is said at the top."""
    out, lines = [], text.splitlines()
    if lines and lines[0].strip() == "%":
        out.append(lines.pop(0))
    lines.insert(0, "G21 G90")
    for k, line in enumerate(lines, len(out) + 1):
        bare = re.sub(r"\([^)]*\)|;.*", "", line).strip()
        line, bare = (re.sub(r"^\s*[nN]\s*[\d.]+\s*", "", text) for text in (line, bare))
        if not bare or bare[0] in "%oO/" or re.match(r"(?i)[mg]9[89]", bare) or "(" in line and "," in line:
            out.append(line)
        else:
            out.append(f"N{k} {line.lstrip()}")
    return "\n".join(out) + "\n"


def commanded(rs274, path, folder):
    """By line: places of the axes, mm and deg, in machine coordinates; and what the interpreter refused."""
    (folder / "tool.tbl").write_text("")
    (folder / "rs.var").write_text("")
    run = subprocess.run([rs274, "-t", "tool.tbl", "-v", "rs.var", "-n", "2", "-g", path], cwd=folder,
                         stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace", timeout=20)
    places, unit, work, shift, tool = collections.defaultdict(list), 1.0, [0.0] * 9, [0.0] * 9, [0.0] * 9
    turned, now = False, [0.0] * 9
    for line in run.stdout.splitlines():
        call = re.search(r"N(\S+) +(\w+)\((.*)\)", line)
        if not call:
            continue
        number, name, rest = call.groups()
        values = [float(v) for v in re.findall(r"-?\d+\.\d+|-?\d+", rest)] if name != "COMMENT" else []
        if name == "USE_LENGTH_UNITS":
            unit = 25.4 if "INCH" in rest else 1.0
        elif name == "SET_XY_ROTATION":
            turned = values[0] != 0.0
        elif name in ("SET_G5X_OFFSET", "SET_G92_OFFSET", "USE_TOOL_LENGTH_OFFSET"):
            six = values[1:] if name == "SET_G5X_OFFSET" else values
            new = (six + [0.0] * 9)[:9]
            if name == "SET_G5X_OFFSET":
                work = new
            elif name == "SET_G92_OFFSET":
                shift = new
            else:
                tool = new
        elif name in ("STRAIGHT_TRAVERSE", "STRAIGHT_FEED", "ARC_FEED"):
            if name == "ARC_FEED":
                new = list(now)
                plane = places.get("plane", "XY")
                order = {"XY": (0, 1, 2), "YZ": (1, 2, 0), "XZ": (2, 0, 1)}[plane]
                new[order[0]], new[order[1]], new[order[2]] = values[0], values[1], values[5]
                new[3:6] = values[6:9]
            else:
                new = (values + [0.0] * 9)[:9]
            now = new
            scale = [unit] * 3 + [1.0] * 3 + [unit] * 3
            at = [(v + a + b + c) * s for v, a, b, c, s in zip(new, work, shift, tool, scale)]
            if number.isdigit() and not turned:
                places[int(number)].append(at)
        elif name == "SELECT_PLANE":
            places["plane"] = re.search(r"PLANE_(\w+)", rest)[1]
    places.pop("plane", None)
    wrong = re.search(r"(?m)^(?!executing|Reading|done).+\n?", run.stderr)
    return places, wrong[0].strip() if wrong and run.returncode else None


def told(targets, path):
    """By line: goals of the reader (None where an axis is not named), and why others are unknown."""
    run = subprocess.run([targets, path, TABLE], capture_output=True, text=True, errors="replace", timeout=60)
    goals, reasons = {}, {}
    if run.returncode:
        return None, run.stderr.strip()
    for line in run.stdout.splitlines():
        number, rest = re.match(re.escape(str(path)) + r":(\d+): (.*)", line).groups()
        values, _, other = rest.partition(" (")
        words = values.split()
        if len(words) == len(AXES) and all(re.fullmatch(r"-|-?[\d.]+", w) for w in words):
            other = other.split(" ")[0].split(",") if other else []
            goals[int(number)] = [None if w == "-" or a in other else float(w) for a, w in zip(AXES, words)]
        else:
            reasons[int(number)] = rest
    return goals, reasons


def compare(rs274, targets, program, folder):
    copy = folder / ("p" + (program.suffix or ".ngc"))
    copy.write_text(numbered(program.read_text(encoding="latin-1")), encoding="latin-1")
    goals, reasons = told(targets, copy)
    if goals is None:
        return "refused", reasons.split(": found")[-1][:90], []
    try:
        places, wrong = commanded(rs274, copy, folder)
    except subprocess.TimeoutExpired:
        return "endless", "", []
    same, other = 0, []
    for line, goal in goals.items():
        for at in places.get(line, [])[-1:]:
            far = [(a, g, v) for a, g, v in zip(AXES, goal, at) if g is not None and abs(g - v) > NEAR * 25.4]
            same += not far
            other += [(line, *far[0])] if far else []
    left = sum(line in places for line in reasons)
    silent = [line for line in places if line not in goals and line not in reasons]
    return "run" if wrong is None else "stopped", (same, left, silent, wrong), other


def main(rs274, targets, top):
    total, rows = collections.Counter(), []
    for program in sorted(pathlib.Path(top).rglob("*.ngc")):
        with tempfile.TemporaryDirectory() as folder:
            how, what, other = compare(rs274, targets, program, pathlib.Path(folder))
        name = program.relative_to(top)
        total[how] += 1
        if how in ("refused", "endless"):
            rows.append((name, how, what))
            continue
        same, left, silent, _ = what
        total["lines that agree"] += same
        total["lines that are left"] += left
        total["lines that differ"] += len(other)
        total["lines of which the reader says nothing"] += len(silent)
        for line, axis, ours, theirs in other[:3]:
            rows.append((f"{name}:{line - 1}", "differs", f"{axis} {ours:.4f}, rs274 {theirs:.4f} ({len(other)} lines)"))
        if silent:
            rows.append((f"{name}:{silent[0] - 1}", "silent", f"{len(silent)} lines at which rs274 moves"))
    print("| | |\n| --- | --- |")
    for key in sorted(total):
        print(f"| {key} | {total[key]} |")
    print("\n| program | | what |\n| --- | --- | --- |")
    for row in rows:
        print("| " + " | ".join(str(c).replace("|", "/") for c in row) + " |")


if __name__ == "__main__":
    main(*sys.argv[1:4])
