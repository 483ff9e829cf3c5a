#!/usr/bin/env python3
"""A circle as Cartesian programs of five languages, rewritten, run on an independent simulator, against a joint program.

    cartesian_circle.py --binary target/fast/lostmotion --simulator twin.py [--json out.json]
    cartesian_circle.py --binary target/fast/lostmotion --machine FOLDER --machines machines.py [--compensator compensator.yaml]

First form: the circle of Zhang (2023) (centre, radius, speed), one orientation away from the wrist's singularity. Second form: the
first program of a random machine, as it stands in its folder. Every pose is one straight move; with --arcs
eight arcs make a turn. A rewritten program is read here by
expressions of its own and interpolated as its controller would: position straight, orientation by the shortest turn (slerp),
joints by Newton's method on the nominal arm (Denavit-Hartenberg), from the point before. What comes out is run and scored by the
simulator; chords are removed by scoring against the interpolated original. Nothing here shares code with the rewriter.
Needs numpy, scipy, pandas, pyyaml.
"""

import argparse
import importlib.util
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np
import yaml
from scipy.spatial import cKDTree

ROOT = pathlib.Path(__file__).parents[1]
PARTS = 6  # points into which a straight move is parted
ARC_PART = 0.005  # rad, of an arc
WRIST = (20.0, 45.0, -30.0)  # deg, at the circle's start
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"


def load(path):
    spec = importlib.util.spec_from_file_location(pathlib.Path(path).stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


# ------------------------------------------------------------------ turns


def about(axis, rad):
    c, s = np.cos(rad), np.sin(rad)
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    m = np.eye(3)
    m[i, i], m[i, j], m[j, i], m[j, j] = c, -s, s, c
    return m


def fixed(deg):
    """Turns about fixed X, Y, Z."""
    x, y, z = np.radians(deg)
    return about(2, z) @ about(1, y) @ about(0, x)


def fixed_of(m):
    y = np.arctan2(-m[2, 0], np.hypot(m[0, 0], m[1, 0]))
    return np.degrees([np.arctan2(m[2, 1], m[2, 2]), y, np.arctan2(m[1, 0], m[0, 0])])


def turn(v):
    """Rotation of a rotation vector."""
    a = np.linalg.norm(v)
    if a < 1e-15:
        return np.eye(3)
    x, y, z = v / a
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(a) * k + (1 - np.cos(a)) * k @ k


def vector(m):
    """Rotation vector of a rotation, less than half a turn."""
    w = np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]]) / 2
    s, c = np.linalg.norm(w), (np.trace(m) - 1) / 2
    a = np.arctan2(s, c)
    if s > 1e-6:
        return w * (a / s)
    if c > 0:
        return w
    axis = np.sqrt(np.maximum((np.diag(m) + 1) / 2, 0))
    k = int(np.argmax(axis))
    axis = m[k] / axis[k] / 2
    axis[k] = (m[k, k] + 1) / 2 / np.sqrt((m[k, k] + 1) / 2)
    return axis / np.linalg.norm(axis) * a


def quaternion(m):
    v = vector(m)
    a = np.linalg.norm(v)
    return np.r_[np.cos(a / 2), v * (np.sin(a / 2) / a if a > 1e-12 else 0.5)]


def of_quaternion(q):
    w, x, y, z = np.array(q) / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


# ------------------------------------------------------------------ the nominal arm


class Arm:
    def __init__(self, path):
        robot = yaml.safe_load(pathlib.Path(path).read_text())
        self.modified = robot["convention"] == "dh-modified"
        self.rows = [[j[k] for k in ("theta_deg", "d_mm", "a_mm", "alpha_deg", "direction")] for j in robot["joints"]]
        self.names = [j["name"] for j in robot["joints"]]
        frame = lambda f: (fixed(f.get("rpy_deg", [0, 0, 0])), np.array(f["xyz_mm"], float))
        self.base, self.tool = frame(robot["base"]), frame(robot["tool"])

    def forward(self, deg):
        """Rotation and place of the TCP, and axis and point of each joint."""
        r, p = self.base
        axes = []
        for (theta, d, a, alpha, sign), q in zip(self.rows, deg):
            x = about(0, np.radians(alpha))
            if self.modified:
                p, r = p + r[:, 0] * a, r @ x
            axes.append((r[:, 2] * sign, p))
            p = p + r[:, 2] * d
            r = r @ about(2, np.radians(theta + sign * q))
            if not self.modified:
                p, r = p + r[:, 0] * a, r @ x
        return r @ self.tool[0], p + r @ self.tool[1], axes

    def inverse(self, r, p, deg):
        """Joints at a pose, next to `deg`."""
        q = np.array(deg, float)
        for _ in range(60):
            own, at, axes = self.forward(q)
            miss = np.r_[p - at, 500.0 * vector(r @ own.T)]
            if np.abs(miss).max() < 2e-9:
                return q
            jacobian = np.array([np.r_[np.cross(z, at - o), 500.0 * z] for z, o in axes]).T
            q += np.degrees(np.clip(np.linalg.solve(jacobian, miss), -0.2, 0.2))
        raise ValueError(f"no joints at {p} next to {deg}: {np.abs(miss).max()} is missing")


def arc(a, b, c):
    """Point at a share of the arc from `a` over `b` to `c`, and how many parts follow it."""
    u, v = b - a, c - a
    w = np.cross(u, v)
    centre = a + (np.cross(w, u) * (v @ v) + np.cross(v, w) * (u @ u)) / (2 * w @ w)
    normal, x = w / np.linalg.norm(w), a - centre
    angle = np.arctan2(normal @ np.cross(x, c - centre), x @ (c - centre)) % (2 * np.pi)
    return lambda s: centre + turn(normal * (s * angle)) @ x, max(PARTS, int(np.ceil(angle / ARC_PART)))


def path(arm, moves, first):
    """Joints along moves: to a pose, straight or over a point on the way."""
    out, q = [], np.array(first, float)
    for k, (r, p, *via) in enumerate(moves):
        r0, p0 = moves[k - 1][:2] if k else (r, p)
        by = vector(r0.T @ r)
        at, parts = arc(p0, via[0], p) if via else (lambda s: p0 + s * (p - p0), PARTS if k else 1)
        for n in range(1, parts + 1):
            s = n / parts
            q = arm.inverse(r0 @ turn(s * by), at(s), q)
            out.append(q)
    return np.array(out)


# ------------------------------------------------------------------ programs


def listed(values, decimals):
    return ",".join(f"{v:.{decimals}f}" for v in values)


def krl(poses, joints, tool, speed):
    x, y, z = tool
    out = f"&ACCESS RVP\r\nDEF circle( )\r\n$BASE=$NULLFRAME\r\n$TOOL={{X {x:g},Y {y:g},Z {z:g},A 0,B 0,C 0}}\r\n$VEL.CP={speed / 1e3:g}\r\n"
    for k, ((r, p, *via), q) in enumerate(zip(poses, joints)):
        c, b, a = fixed_of(r)
        numbers = ",".join(f"{n} {v:.6f}" for n, v in zip("XYZABC", [*p, a, b, c]))
        bits = sum((v < 0) << i for i, v in enumerate(q))
        if via:
            over = ",".join(f"{n} {v:.6f}" for n, v in zip("XYZ", via[0]))
            out += f"CIRC {{{over}}},{{{numbers}}} C_DIS\r\n"
            continue
        out += f"PTP {{{numbers},S {2 + 4 * (q[4] < 0)},T {bits}}}\r\n" if k == 0 else f"LIN {{{numbers}}} C_DIS\r\n"
    return "circle.src", out + "END\r\n"


def rapid(poses, joints, tool, speed):
    out = f"MODULE circle\n  PERS tooldata probe:=[TRUE,[[{listed(tool, 3)}],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\n  PROC main()\n"
    out += f"    MoveAbsJ [[{listed(joints[0], 6)}],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,probe;\n    ConfL\\Off;\n"
    for r, p, *via in poses:
        target = lambda at: f"[[{listed(at, 4)}],[{listed(quaternion(r), 7)}],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
        word = f"MoveC {target(via[0])}," if via else "MoveL "
        out += f"    {word}{target(p)},[{speed:g},500,5000,1000],z0,probe;\n"
    return "circle.mod", out + "  ENDPROC\nENDMODULE\n"


def fanuc(poses, joints, tool, speed):
    out = f"/PROG  CIRCLE\n/ATTR\nLINE_COUNT\t= {len(poses)};\n/MN\n"
    out += "".join(f"{k + 1:4}:L P[{k + 1}] {speed:g}mm/sec CNT100    ;\n" for k in range(len(poses))) + "/POS\n"
    for k, ((r, p), q) in enumerate(zip(poses, joints)):
        mm = ",\t".join(f"{n} = {v:>9.3f}  mm" for n, v in zip("XYZ", p))
        deg = ",\t".join(f"{n} = {v:>9.3f} deg" for n, v in zip("WPR", fixed_of(r)))
        out += f"P[{k + 1}]{{\n   GP1:\n\tUF : 0, UT : 1,\t\tCONFIG : '{'F' if q[4] > 0 else 'N'} U T, 0, 0, 0',\n\t{mm},\n\t{deg}\n}};\n"
    return "circle.ls", out + "/END\n"


def urscript(poses, joints, tool, speed):
    m = [v / 1e3 for v in tool]
    out = f"def circle():\n  set_tcp(p[{m[0]:g},{m[1]:g},{m[2]:g},0,0,0])\n  movej([{listed(np.radians(joints[0]), 9)}], a=1.4, v=1.05)\n"
    for r, p, *via in poses:
        word = "movec" if via else "movel"
        targets = ", ".join(f"p[{listed(at / 1e3, 8)},{listed(vector(r), 8)}]" for at in [*via, p])
        out += f"  {word}({targets}, a=1.2, v={speed / 1e3:g}, r=0.0001)\n"
    return "circle.script", out + "end\n"


def inform(poses, joints, tool, speed):
    n = len(poses)
    out = f"/JOB\r\n//NAME CIRCLE\r\n//POS\r\n///NPOS {n},0,0,0,0,0\r\n///TOOL 1\r\n///POSTYPE ROBOT\r\n///RECTAN\r\n///RCONF 0,0,0,0,0,0,0,0\r\n"
    out += "".join(f"C{k:05}={listed(p, 3)},{listed(fixed_of(r), 4)}\r\n" for k, (r, p) in enumerate(poses))
    out += "//INST\r\n///DATE 2020/01/01 00:00\r\n///ATTR SC,RW\r\n///GROUP1 RB1\r\nNOP\r\n"
    return "circle.JBI", out + "".join(f"MOVL C{k:05} V={speed:g} \r\n" for k in range(n)) + "END\r\n"


WRITERS = {"krl": krl, "rapid": rapid, "urscript": urscript, "fanuc": fanuc, "inform": inform}


def numbers(text):
    return [float(v) for v in re.findall(NUMBER, text)]


def poses_of(language, text):
    """Poses of the straight moves (and of the first motion) in their order, by rules of this script alone."""
    out = []
    if language == "krl":
        for over, body in re.findall(r"^(?:PTP|LIN|CIRC) (?:\{([^}]*)\},)?\{([^}]*)\}", text, re.M):
            v, w = ({k: float(x) for k, x in re.findall(rf"\b([XYZABC]) ({NUMBER})", part)} for part in (body, over))
            at = [np.array([one["X"], one["Y"], one["Z"]]) for one in (v, w) if one]
            out.append((fixed([v["C"], v["B"], v["A"]]), *at))
    elif language == "rapid":
        for line in re.findall(r"^\s*(Move[LC] .*)$", text, re.M):
            *over, (p, q) = re.findall(r"\[\[([^]]*)\],\s*\[([^]]*)\]", line)
            out.append((of_quaternion(numbers(q)), np.array(numbers(p)), *(np.array(numbers(o[0])) for o in over)))
    elif language == "urscript":
        for line in re.findall(r"^\s*(move[lc]\(.*)$", text, re.M):
            *over, v = [numbers(body) for body in re.findall(r"p\[([^]]*)\]", line)]
            out.append((turn(np.array(v[3:6])), np.array(v[:3]) * 1e3, *(np.array(o[:3]) * 1e3 for o in over)))
    elif language == "fanuc":
        places = {}
        for index, body in re.findall(r"^P\[(\d+)\]\{(.*?)\};", text, re.M | re.S):
            v = {k: float(x) for k, x in re.findall(rf"\b([XYZWPR]) *= *({NUMBER})", body)}
            places[index] = (fixed([v["W"], v["P"], v["R"]]), np.array([v["X"], v["Y"], v["Z"]]))
        out = [places[index] for index in re.findall(r"^ *\d+:L P\[(\d+)\]", text, re.M)]
    else:
        places = {name: numbers(body) for name, body in re.findall(r"^(C\d+)=(.*)", text, re.M)}
        out = [(fixed(v[3:6]), np.array(v[:3])) for v in (places[n] for n in re.findall(r"^MOVL (C\d+)", text, re.M))]
    return out


# ------------------------------------------------------------------ the measure


class Desk:
    """Files of one rewrite: the robot with its tool by name, the model or compensator."""

    def __init__(self, folder, binary, robot, by):
        self.folder, self.binary, self.by = pathlib.Path(folder), binary, by  # by: model or compensator, options
        text = pathlib.Path(robot).read_text()
        arm = Arm(robot)
        # in a FANUC program, too, the third axis of this arm is its motor's own
        self.robot = text + f"\ngap_of: {{{arm.names[2]}: {arm.names[2]}}}\n"
        (self.folder / "robot.yaml").write_text(self.robot)
        self.tool = arm.tool[1]
        (self.folder / "frames.yaml").write_text(
            json.dumps({"schema": "lostmotion/frames/1", "tools": {"1": {"xyz_mm": [float(v) for v in self.tool]}}})
        )

    def rewritten(self, name, text, speed):
        (self.folder / name).write_bytes(text.encode())
        line = [self.binary, "rewrite", *self.by, name, "--output", f"out-{name}", "--force", "--frames", "frames.yaml", "--speed-mm-s", f"{speed:g}"]
        if name.endswith(".csv"):
            line = [v for v in line if v not in ("--frames", "frames.yaml")]
        done = subprocess.run(line, cwd=self.folder, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"{' '.join(line)}\n{done.stdout}{done.stderr}")
        return (self.folder / f"out-{name}").read_bytes().decode(), done.stdout


def joint_csv(arm, q, digits=9):
    head = ",".join(f"{n.lower()}_deg" for n in arm.names)
    return head + "\n" + "".join(listed(row, digits) + "\n" for row in np.round(q, digits) + 0.0)


def arcs(poses, joints):
    """A circle of 200 points in eight arcs a turn (the first point, then every 25th, over the point in its middle)."""
    ends = range(25, len(poses), 25)
    return [poses[0], *((*poses[k], poses[k - 12][1]) for k in ends)], [joints[0], *(joints[k] for k in ends)]


def measured(desk, arm, joints, speed, languages, judge, of_arcs):
    """By language the score of the original and of the rewritten program."""
    poses = [arm.forward(q)[:2] for q in joints]
    result = {}
    text, _ = desk.rewritten("nominal.csv", joint_csv(arm, joints, 6), speed)
    done = np.array([[float(v) for v in line.split(",")[: len(arm.names)]] for line in text.splitlines() if line[:1] in "-0123456789" and line])
    result["joint CSV"] = judge(joints, joints, done)
    if of_arcs:
        (poses, joints), result = arcs(poses, joints), {}
    for language in languages:
        name, text = WRITERS[language](poses, joints, desk.tool, speed)
        out, said = desk.rewritten(name, text, speed)
        before, after = (path(arm, poses_of(language, t), joints[0]) for t in (text, out))
        result[language] = judge(before, before, after)
        result[language]["rewrite"] = said.splitlines()[:2]
    return result


def on_simulator(given, work):
    simulator = load(given.simulator)
    arm = Arm(ROOT / "configs/kuka-kr120-r2500-pro.yaml")
    for q in ([10, -80, 90, 20, 40, -50], [-30, -60, 70, -10, 25, 100]):
        assert np.abs(simulator.forward([q])[0] - arm.forward(q)[1]).max() < 1e-6, "the arms differ"
    model = yaml.safe_load((ROOT / "samples/models/kuka-table3.model.yaml").read_text())
    model["robot"] = "robot.yaml"
    (work / "model.yaml").write_text(json.dumps(model))
    desk = Desk(work, given.binary, ROOT / "configs/kuka-kr120-r2500-pro.yaml", ["--model", "model.yaml", *given.options.split()])
    circle = simulator.forward(simulator.circle())
    q = np.r_[simulator.inverse3(circle[:1])[0], WRIST]
    rotation = arm.forward(q)[0]
    joints = []
    for p in circle:
        q = arm.inverse(rotation, p, q)
        joints.append(q)
    joints = np.array(joints)

    def judge(nominal, before, after):
        (work / "n.csv").write_text(joint_csv(arm, nominal))
        scores = []
        for program in (before, after):
            (work / "p.csv").write_text(joint_csv(arm, program))
            call = lambda *a: subprocess.run([sys.executable, given.simulator, *map(str, a)], check=True, capture_output=True, text=True).stdout
            call("run", work / "p.csv", "-o", work / "log.csv", "--noise-um", 0, "--speed-mm-s", simulator.SPEED)
            scores.append(json.loads(call("score", work / "log.csv", "--nominal", work / "n.csv", "--json")))
        key = "total_chord_removed_um"
        at = simulator.durations(nominal, simulator.SPEED)
        meant = simulator.forward(np.stack([np.interp(np.arange(0, at[-1], 0.01), at, nominal[:, j]) for j in range(6)], 1))

        def off(program):
            """Largest distance from the interpolated original, um; the first 30 s are those of an unknown side."""
            t, run = simulator.execute(program, simulator.durations(program, simulator.SPEED), 25)
            return round(float(cKDTree(meant).query(simulator.forward(run["true"])[t > 30])[0].max() * 1e3), 1)

        return {
            "off_path_um": [off(before), off(after)],
            "before_um": [r[key] for r in scores[0]["reversals"]],
            "after_um": [r[key] for r in scores[1]["reversals"]],
            "path_um": [s["path"]["total_chord_removed_max_um"] for s in scores],
            "path_rms_um": [s["path"]["total_chord_removed_rms_um"] for s in scores],
        }

    return measured(desk, arm, joints, simulator.SPEED, given.languages, judge, given.arcs)


def on_machine(given, work):
    folder = pathlib.Path(given.machine).resolve()
    arm = Arm(folder / "robot.yaml")
    compensator = pathlib.Path(given.compensator or folder / "compensator.yaml").resolve()
    desk = Desk(work, given.binary, folder / "robot.yaml", ["--robot", "robot.yaml", "--compensator", str(compensator), *given.options.split()])
    job = json.loads((folder / "job.json").read_text())["programs"]
    speed = job[given.program]["speed_mm_s"]
    rows = (folder / given.program).read_text().splitlines()
    joints = np.array([[float(v) for v in r.split(",")[:6]] for r in rows if r[:1] in "-0123456789" and r])
    stem = given.program[:-4]

    def judge(nominal, before, after):
        call = lambda *a: subprocess.run([sys.executable, given.machines, *map(str, a)], check=True, capture_output=True, text=True).stdout
        for kind, program in (("before", before), ("after", after)):
            path = work / f"{stem}.{kind}.csv"
            path.write_text(joint_csv(arm, program))
            call("run", folder, path, "-o", work / f"{kind}.csv", "--seed", 2 if kind == "after" else 1, "--perfect-tracker", "--no-wander")
        (work / f"{stem}.nominal.csv").write_text(joint_csv(arm, nominal))
        score = json.loads(call("score", folder, "--nominal", work / f"{stem}.nominal.csv", "--before", work / "before.csv", "--after", work / "after.csv", "--json"))
        return {k: score[k] for k in ("median_reduction", "worst_reduction", "rms_reduction", "rms_um", "median_um")}

    return measured(desk, arm, joints, speed, given.languages, judge, given.arcs)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", required=True, type=lambda p: str(pathlib.Path(p).resolve()))
    parser.add_argument("--simulator", help="the reference simulator of the circle")
    parser.add_argument("--machines", help="the simulator of random machines")
    parser.add_argument("--machine", help="folder of one of them")
    parser.add_argument("--program", default="program_circle.csv")
    parser.add_argument("--compensator")
    parser.add_argument("--options", default="", help="more options of the rewrite")
    parser.add_argument("--languages", default=",".join(WRITERS), type=lambda s: s.split(","))
    parser.add_argument("--arcs", action="store_true", help="the circle in arcs (KRL, RAPID, URScript)")
    parser.add_argument("--json", type=pathlib.Path)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as work:
        result = (on_machine if given.machine else on_simulator)(given, pathlib.Path(work))
    for language, score in result.items():
        print(language, json.dumps(score))
    if given.json:
        given.json.write_text(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
