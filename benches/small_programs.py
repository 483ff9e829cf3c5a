"""Many small programs of all formats for the benches `shards.py` and `million.py`: the same bytes each time."""

import hashlib
import math
import os
from pathlib import Path

PER_FOLDER = 1000
EXTERNAL = "[9E9,9E9,9E9,9E9,9E9,9E9]"


def rows(i, n=8):
    return [(10 * math.sin(0.7 * j + i), -90 + 5 * math.cos(0.5 * j + i), 90 + 3 * math.sin(0.9 * j), 1.5 * j, 10 + i % 7, -j) for j in range(n)]


def csv(i):
    return "csv", "a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n" + "".join("%.4f,%.4f,%.4f,%.4f,%.4f,%.4f\n" % r for r in rows(i))


def krl(i):
    body = "".join("PTP {A1 %.4f,A2 %.4f,A3 %.4f,A4 %.4f,A5 %.4f,A6 %.4f}\n" % r for r in rows(i))
    return "src", f"DEF p{i}( )\n{body}END\n"


def rapid(i):
    body = "".join("  MoveAbsJ [[%.4f,%.4f,%.4f,%.4f,%.4f,%.4f],%s],v500,fine,tool0;\n" % (*r, EXTERNAL) for r in rows(i, 6))
    return "mod", f"MODULE m{i}\n PROC main()\n{body} ENDPROC\nENDMODULE\n"


def fanuc(i):
    points = rows(i, 4)
    lines = "".join("%4d:J P[%d] 50%% FINE ;\n" % (k, k) for k in range(1, len(points) + 1))
    text = "P[%d]{\n   GP1:\n\tUF : 0, UT : 1,\t\n\tJ1= %9.3f deg,\tJ2= %9.3f deg,\tJ3= %9.3f deg,\n\tJ4= %9.3f deg,\tJ5= %9.3f deg,\tJ6= %9.3f deg\n};\n"
    return "ls", f"/PROG  P{i}\n/ATTR\nDEFAULT_GROUP\t= 1,*,*,*,*;\n/MN\n{lines}/POS\n" + "".join(text % (k + 1, *r) for k, r in enumerate(points)) + "/END\n"


def inform(i):
    points = rows(i, 6)
    table = "".join("C%05d=%s\n" % (k, ",".join("%.4f" % v for v in r)) for k, r in enumerate(points))
    moves = "".join("MOVJ C%05d VJ=25.00\n" % k for k in range(len(points)))
    head = f"/JOB\n//NAME P{i}\n//POS\n///NPOS {len(points)},0,0,0,0,0\n///TOOL 0\n///POSTYPE ANGLE\n///ANGLE\n"
    return "JBI", f"{head}{table}//INST\n///DATE 2024/05/06 07:08\n///ATTR SC,RW\n///GROUP1 RB1\nNOP\n{moves}END\n"


def urscript(i):
    body = "".join("  movej([%.6f, %.6f, %.6f, %.6f, %.6f, %.6f], a=1.4, v=1.05)\n" % tuple(map(math.radians, r)) for r in rows(i, 6))
    return "script", f"def p{i}():\n{body}end\n"


def trajectory(i):
    body = "".join("- positions: [%.6f, %.6f, %.6f, %.6f, %.6f, %.6f]\n  time_from_start: {secs: %d, nsecs: 0}\n" % (*map(math.radians, r), 2 * k) for k, r in enumerate(rows(i, 6)))
    return "yaml", f"joint_names: [A1, A2, A3, A4, A5, A6]\npoints:\n{body}"


FORMATS = (csv, krl, rapid, fanuc, inform, urscript, trajectory)


def make(root, i, folder=None):
    """Program `i`, in the folder of its number or another one."""
    folder = root / f"c{i // PER_FOLDER if folder is None else folder:04d}"
    folder.mkdir(parents=True, exist_ok=True)
    ending, text = FORMATS[i % len(FORMATS)](i)
    path = folder / f"p{i}.{ending}"
    path.write_text(text)
    return path


def tree(root):
    """Hash over the names and contents below a folder; files that are half written are counted."""
    total, files, half = hashlib.sha256(), 0, 0
    for folder, names, entries in os.walk(root):
        names.sort()
        for name in sorted(entries):
            if name.startswith(".lostmotion"):
                half += not name.startswith(".lostmotion.lock")
                continue
            path = Path(folder) / name
            total.update(str(path.relative_to(root)).encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
            files += 1
    return total.hexdigest(), files, half
