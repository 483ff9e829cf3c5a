#!/usr/bin/env python3
"""Time and memory of `rewrite` on large programs of joint moves, format by format.

  vendor.py --binary LOSTMOTION --work FOLDER [--mb 20] [--formats krl,rapid] [--runs 3] [--against OTHER] [--threads 2]

Makes one program for each format (the same bytes each time) and a model of its robot, rewrites it, and prints processor time, wall
time, the speed in bytes of the program per second of processor time, and the largest memory of the process in sizes of the program.
`--against` measures a second binary in turn and compares the bytes of both results: exit code 1 where they differ.
"""

import argparse
import hashlib
import math
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

CONFIGS = Path(__file__).resolve().parent.parent / "configs"
EXTERNAL = "[9E9,9E9,9E9,9E9,9E9,9E9]"
# joints swing about these places, deg: limits of all the robots hold
CENTRE, SWING, PACE = (5, 0, 40, 5, 30, 10), (20, 6, 12, 15, 14, 30), (0.051, 0.073, 0.067, 0.091, 0.083, 0.059)


def joints(n, shoulder=0):
    """Rows of six joints; each turns every 35 to 60 moves."""
    for j in range(n):
        row = [c + s * math.sin(p * j + k) for k, (c, s, p) in enumerate(zip(CENTRE, SWING, PACE))]
        row[1] += shoulder
        yield tuple(row)


def krl(n):
    yield "DEF big( )\n"
    for q in joints(n, -60):
        yield "PTP {A1 %.4f,A2 %.4f,A3 %.4f,A4 %.4f,A5 %.4f,A6 %.4f}\n" % q
    yield "END\n"


def krl_dat(n):
    """Moves to points of a data list, as a pendant makes them."""
    yield "DEF big( )\nBAS(#VEL_PTP,50)\n"
    for j in range(n):
        yield f"PTP XP{j} C_PTP\n"
    yield "END\n"


def krl_list(n):
    yield "DEFDAT big\n"
    for j, q in enumerate(joints(n, -60)):
        yield "DECL E6AXIS XP%d={A1 %.4f,A2 %.4f,A3 %.4f,A4 %.4f,A5 %.4f,A6 %.4f,E1 0.0,E2 0.0,E3 0.0,E4 0.0,E5 0.0,E6 0.0}\n" % (j, *q)
    yield "ENDDAT\n"


def rapid(n):
    yield "MODULE big\n PROC main()\n"
    for q in joints(n):
        yield "  MoveAbsJ [[%.4f,%.4f,%.4f,%.4f,%.4f,%.4f],%s],v500,z10,tool0;\n" % (*q, EXTERNAL)
    yield " ENDPROC\nENDMODULE\n"


def fanuc(n):
    yield "/PROG  BIG\n/ATTR\nDEFAULT_GROUP\t= 1,*,*,*,*;\n/MN\n"
    for j in range(n):
        yield "%4d:J P[%d] 50%% CNT50 ;\n" % (j + 1, j + 1)
    yield "/POS\n"
    for j, (a, b, c, d, e, f) in enumerate(joints(n)):
        yield "P[%d]{\n   GP1:\n\tUF : 0, UT : 1,\t\n" % (j + 1)
        yield "\tJ1= %9.3f deg,\tJ2= %9.3f deg,\tJ3= %9.3f deg,\n" % (a, b, c)
        yield "\tJ4= %9.3f deg,\tJ5= %9.3f deg,\tJ6= %9.3f deg\n};\n" % (d, e, f)
    yield "/END\n"


def inform(n):
    yield f"/JOB\n//NAME BIG\n//POS\n///NPOS {n},0,0,0,0,0\n///TOOL 0\n///POSTYPE PULSE\n///PULSE\n"
    for j, q in enumerate(joints(n)):
        yield "C%05d=%s\n" % (j, ",".join(str(round(1341.4 * v)) for v in q))
    yield "//INST\n///DATE 2024/05/06 07:08\n///ATTR SC,RW\n///GROUP1 RB1\nNOP\n"
    for j in range(n):
        yield "MOVJ C%05d VJ=25.00 PL=1\n" % j
    yield "END\n"


def urscript(n):
    yield "def big():\n"
    for q in joints(n):
        yield "  movej([%.6f, %.6f, %.6f, %.6f, %.6f, %.6f], a=1.4, v=1.05)\n" % tuple(map(math.radians, q))
    yield "end\n"


def trajectory(n):
    yield "joint_names: [%s]\npoints:\n" % ", ".join(
        ["base", "shoulder", "elbow", "wrist1", "wrist2", "wrist3"]
    )
    for j, q in enumerate(joints(n)):
        yield "- positions: [%.6f, %.6f, %.6f, %.6f, %.6f, %.6f]\n" % tuple(map(math.radians, q))
        yield "  time_from_start: {secs: %d, nsecs: %d}\n" % divmod(j * 100_000_000, 1_000_000_000)


def gcode(n):
    yield "%\nO1001\nG21 G90 G17 G94\nG54\n"
    for a, b, c, *_ in joints(n):
        yield "G1 X%.4f Y%.4f Z%.4f F3000\n" % (500 + 10 * a, 400 + 5 * b, c - 300)
    yield "M30\n%\n"


# name: (maker of the text, ending, robot, bytes a move, most moves)
FORMATS = {
    "krl": (krl, "src", "kuka-kr120-r2500-pro", 72, None),
    "krl-list": (krl_dat, "src", "kuka-kr120-r2500-pro", 164, None),
    "rapid": (rapid, "mod", "abb-irb6640-185-280", 99, None),
    "fanuc": (fanuc, "ls", "fanuc-m20ia", 198, 32_000),
    "inform": (inform, "JBI", "motoman-ma2010", 73, 80_000),
    "urscript": (urscript, "script", "universal-robots-ur10e", 82, None),
    "trajectory": (trajectory, "yaml", "universal-robots-ur10e", 117, None),
    "gcode": (gcode, "nc", "gantry-xyz-ballscrew", 36, None),
}


def prepare(name, work, size):
    """The program and the model of its machine; made once."""
    text, ending, robot, each, most = FORMATS[name]
    n = min(size // each, most or size)
    path, model = work / f"big-{name}" / f"big.{ending}", work / f"{robot}.model.yaml"
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("".join(text(n)))
        if name == "krl-list":
            path.with_suffix(".dat").write_text("".join(krl_list(n)))
    config = (CONFIGS / f"{robot}.yaml").read_text()
    lines = [line for line in config.splitlines() if line.strip().startswith("- {name:") and "follows" not in line]
    names = [(line.split("name:")[1].split(",")[0].strip(), "prismatic" in line) for line in lines]
    gap = [f"  - {{effect: backlash, joint: {j}, {'half_gap_mm: 0.01' if p else 'half_gap_deg: 0.005'}}}" for j, p in names]
    model.write_text("\n".join([
        "schema: lostmotion/model/1", f"robot: {os.path.relpath(CONFIGS / f'{robot}.yaml', work)}",
        "registration: {xyz_mm: [0, 0, 0], rpy_deg: [0, 0, 0]}", "effects:", *gap, ""]))
    files = [path, path.with_suffix(".dat")] if name == "krl-list" else [path]
    return path, model, sum(f.stat().st_size for f in files), n


def run(binary, path, model, out, threads):
    """Processor time and wall time, s, and the largest memory, bytes, of one rewrite."""
    for old in out.parent.glob("*"):
        old.unlink()
    line = [binary, "rewrite", "--model", model, path, "--output", out]
    start = time.perf_counter()
    child = subprocess.Popen(line, env={**os.environ, "RAYON_NUM_THREADS": threads}, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    said = child.stderr.read()
    _, status, usage = os.wait4(child.pid, 0)
    if status != 0:
        sys.exit(f"{path}: {status}\n{said.decode(errors='replace')}")
    return usage.ru_utime + usage.ru_stime, time.perf_counter() - start, usage.ru_maxrss * 1024


def hashes(folder):
    return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in folder.iterdir() if not p.name.endswith(".json") and p.name[0] != "."}


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("--binary", type=Path, required=True)
    ap.add_argument("--against", type=Path)
    ap.add_argument("--work", type=Path, required=True)
    ap.add_argument("--mb", type=float, default=20)
    ap.add_argument("--formats", default=",".join(FORMATS))
    ap.add_argument("--runs", type=int, default=3)
    ap.add_argument("--threads", default="2")
    a = ap.parse_args()
    work, differ = a.work.resolve(), False
    work.mkdir(parents=True, exist_ok=True)
    binaries = [a.binary] + ([a.against] if a.against else [])
    print("format       binary    MB   moves   cpu s  wall s   MB/s    memory")
    for name in a.formats.split(","):
        path, model, size, n = prepare(name, work, int(a.mb * 1e6))
        seen, figures = [], [[] for _ in binaries]
        for _ in range(a.runs):
            for k, binary in enumerate(binaries):
                out = work / f"out-{k}" / path.name
                out.parent.mkdir(exist_ok=True)
                figures[k].append(run(binary.resolve(), path, model, out, a.threads))
        for k, f in enumerate(figures):
            cpu, wall, memory = (statistics.median(column) for column in zip(*f))
            print(f"{name:12} {'AB'[k]:6} {size / 1e6:5.1f} {n:7} {cpu:7.2f} {wall:7.2f} {size / 1e6 / cpu:6.1f} {memory / size:6.1f} x", flush=True)
            seen.append(hashes(work / f"out-{k}"))
        if any(s != seen[0] for s in seen):
            print(f"{name}: the results differ")
            differ = True
    sys.exit(differ)


if __name__ == "__main__":
    main()
