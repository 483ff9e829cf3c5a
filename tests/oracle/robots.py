#!/usr/bin/env python3
"""The arms of configs/ that come from public URDF files: their robot files, and poses of the URDFs themselves.

  robots.py make --sources FOLDER --lostmotion BINARY

reads git directories `FOLDER/<owner>+<name>/repo` at the commits named below, expands the xacro files (package xacrodoc), lets
`lostmotion robot init` write the robot file, gives the joints the names of their maker, and writes tests/oracle/robots.json: poses by the
URDF's own chain, product of homogeneous matrices read by ElementTree, which shares nothing with lostmotion. Needs numpy, pyyaml
and xacrodoc. The reach is the farthest that the wrist centre gets from the first axis, searched over the joints within their limits; the
data sheet's figure stands beside it (R2700 of a KUKA is 2700 mm).
"""
import argparse, json, math, pathlib, re, subprocess, tempfile
import xml.etree.ElementTree as ET
import numpy as np
import yaml

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
KUKA, KROSHU = ("ros-industrial/kuka_experimental", "e78bbd15edb2b39c9053ff3b963ef2947e10a531"), ("kroshu/kuka_robot_descriptions", "7766e92afcfd71c06d98cd5e54cbb857eabd015d")
ABB, FANUC = ("ros-industrial/abb", "77db19bdb098f50d9569d1cab03ee657627e934e"), ("ros-industrial/fanuc", "8fee5e30e535378758ace26dfdffb8ab0403e23c")
MOTOMAN, STAUBLI = ("ros-industrial/motoman", "433be15f6a27cb9a5715cc3887b1cd15ff33a8cb"), ("ros-industrial/staubli", "367d92ec7432867d9ba87c3399d49a940c4afc67")
UR = ("ros-industrial/universal_robot", "a7a2c5459b9702ba8b07ebf35f0134159e50e680")
# file in configs/, name, source, xacro, reach of the data sheet in mm
ARMS = [
    ("abb-irb2400-12-155", "ABB IRB 2400-12/1.55", ABB, "irb2400_12_155.xacro", 1550),
    ("abb-irb4400l-30-243", "ABB IRB 4400L-30/2.43", ABB, "irb4400l_30_243.xacro", 2430),
    ("abb-irb6600-225-255", "ABB IRB 6600-225/2.55", ABB, "irb6600_225_255.xacro", 2550),
    ("abb-irb6640-185-280", "ABB IRB 6640-185/2.8", ABB, "irb6640_185_280.xacro", 2800),
    ("fanuc-cr35ia", "FANUC CR-35iA", FANUC, "cr35ia.xacro", 1813),
    ("fanuc-lrmate200id", "FANUC LR Mate 200iD", FANUC, "lrmate200id.xacro", 717),
    ("fanuc-lrmate200id7l", "FANUC LR Mate 200iD/7L", FANUC, "lrmate200id7l.xacro", 911),
    ("fanuc-m20ia", "FANUC M-20iA", FANUC, "m20ia.xacro", 1811),
    ("fanuc-m710ic50", "FANUC M-710iC/50", FANUC, "m710ic50.xacro", 2050),
    ("fanuc-m16ib20", "FANUC M-16iB/20", FANUC, "m16ib20.xacro", 1667),
    ("fanuc-r1000ia80f", "FANUC R-1000iA/80F", FANUC, "r1000ia80f.xacro", 2230),
    ("kuka-kr3-r540", "KUKA KR 3 R540", KUKA, "kr3r540.xacro", 541),
    ("kuka-kr5-arc", "KUKA KR 5 arc", KUKA, "kr5_arc.xacro", 1411),
    ("kuka-kr6-r900-sixx", "KUKA KR 6 R900 sixx", KUKA, "kr6r900sixx.xacro", 901),
    ("kuka-kr10-r1100-sixx", "KUKA KR 10 R1100 sixx", KUKA, "kr10r1100sixx.xacro", 1101),
    ("kuka-kr10-r1420", "KUKA KR 10 R1420", KUKA, "kr10r1420.xacro", 1420),
    ("kuka-kr16-2", "KUKA KR 16-2", KUKA, "kr16_2.xacro", 1611),
    ("kuka-kr150-2", "KUKA KR 150-2", KUKA, "kr150_2.xacro", 2700),
    ("kuka-kr150-r3100-2", "KUKA KR 150 R3100-2", KUKA, "kr150r3100_2.xacro", 3100),
    ("kuka-kr210-l150", "KUKA KR 210 L150", KUKA, "kr210l150.xacro", 3100),
    ("kuka-kr16-r2010-2", "KUKA KR 16 R2010-2", KROSHU, "kr16_r2010_2.urdf.xacro", 2013),
    ("kuka-kr210-r2700-2", "KUKA KR 210 R2700-2", KROSHU, "kr210_r2700_2.urdf.xacro", 2700),
    ("kuka-kr300-r2700-2", "KUKA KR 300 R2700-2", KROSHU, "kr300_r2700_2.urdf.xacro", 2701),
    ("kuka-kr50-r2500", "KUKA KR 50 R2500", KROSHU, "kr50_r2500.urdf.xacro", 2501),
    ("kuka-kr560-r3100-2", "KUKA KR 560 R3100-2", KROSHU, "kr560_r3100_2.urdf.xacro", 3076),
    ("kuka-lbr-iiwa14-r820", "KUKA LBR iiwa 14 R820", KROSHU, "lbr_iiwa14_r820.urdf.xacro", 820),
    ("motoman-ar2010", "Yaskawa Motoman AR2010", MOTOMAN, "ar2010.xacro", 2010),
    ("motoman-gp7", "Yaskawa Motoman GP7", MOTOMAN, "gp7.xacro", 927),
    ("motoman-gp12", "Yaskawa Motoman GP12", MOTOMAN, "gp12.xacro", 1440),
    ("motoman-gp25", "Yaskawa Motoman GP25", MOTOMAN, "gp25.xacro", 1730),
    ("motoman-gp50", "Yaskawa Motoman GP50", MOTOMAN, "gp50.xacro", 2061),
    ("motoman-gp180", "Yaskawa Motoman GP180", MOTOMAN, "gp180.xacro", 2702),
    ("motoman-hc10", "Yaskawa Motoman HC10", MOTOMAN, "hc10.xacro", 1200),
    ("motoman-mh50", "Yaskawa Motoman MH50", MOTOMAN, "mh50.xacro", 2061),
    ("motoman-sia20d", "Yaskawa Motoman SIA20D", MOTOMAN, "sia20d.xacro", 910),
    ("staubli-rx160", "Staubli RX160", STAUBLI, "rx160.xacro", 1710),
    ("staubli-rx160l", "Staubli RX160L", STAUBLI, "rx160l.xacro", 2010),
    ("universal-robots-ur3e", "Universal Robots UR3e", UR, "ur3e.xacro", 500),
    ("universal-robots-ur5e", "Universal Robots UR5e", UR, "ur5e.xacro", 850),
    ("universal-robots-ur10e", "Universal Robots UR10e", UR, "ur10e.xacro", 1300),
    ("universal-robots-ur16e", "Universal Robots UR16e", UR, "ur16e.xacro", 900),
    ("universal-robots-ur20", "Universal Robots UR20", UR, "ur20.xacro", 1750),
]
UR_NAMES = {"shoulder_pan": "base", "shoulder_lift": "shoulder", "wrist_1": "wrist1", "wrist_2": "wrist2", "wrist_3": "wrist3"}
POSES = 5
# what the maker's pendant shows where the description's joints are zero, deg
AT_ZERO = {"kuka-kr210-l150": [0, -90, 90, 0, 0, 0]}
# their `tool0` keeps the base's orientation at zero; the maker's has z out of the flange and x down, as at his other arms
NO_TURN_OF_FLANGE = ["abb-irb4400l-30-243"]
# J3 as the controller counts it is the forearm against the horizontal: how J2 enters the description's angle. FANUC by its motors, these two of
# ABB by the linkage beside the arm (J23_coupled in abb_irb2400_support and abb_irb4400_support: J3 of the controller is J2 + J3 of the description)
LINKAGE = {"abb-irb2400-12-155": -1, "abb-irb4400l-30-243": -1}


def numbers(text, default):
    return [float(v) for v in (text or default).split()]


def hom(origin):
    r, p, y = numbers(origin.get("rpy") if origin is not None else None, "0 0 0")
    c, s = np.cos, np.sin
    rx = np.array([[1, 0, 0], [0, c(r), -s(r)], [0, s(r), c(r)]])
    ry = np.array([[c(p), 0, s(p)], [0, 1, 0], [-s(p), 0, c(p)]])
    rz = np.array([[c(y), -s(y), 0], [s(y), c(y), 0], [0, 0, 1]])
    m = np.eye(4)
    m[:3, :3], m[:3, 3] = rz @ ry @ rx, numbers(origin.get("xyz") if origin is not None else None, "0 0 0")
    return m


def rodrigues(axis, q):
    k = np.array(axis) / np.linalg.norm(axis)
    w = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    m = np.eye(4)
    m[:3, :3] += math.sin(q) * w + (1 - math.cos(q)) * w @ w
    return m


def exact(v):
    """A multiple of 45 deg, where the URDF writes one to its digits (1.5708): the robot file takes it as that, and says so."""
    k = round(v / (math.pi / 4))
    return k * math.pi / 4 if k and abs(v - k * math.pi / 4) < 1e-3 else v


class Chain:
    def __init__(self, text, tip):
        root = ET.fromstring(text)
        by_child = {j.find("child").get("link"): j for j in root.iter("joint") if j.find("child") is not None}
        self.joints = []
        while tip in by_child:
            self.joints.insert(0, by_child[tip])
            tip = by_child[tip].find("parent").get("link")
        for j in self.joints:
            o = j.find("origin")
            if o is not None and o.get("rpy"):
                o.set("rpy", " ".join(repr(exact(float(v))) for v in o.get("rpy").split()))
        self.moving = [j for j in self.joints if j.get("type") in ("revolute", "continuous", "prismatic")]
        assert all(j.get("type") != "prismatic" for j in self.moving)

    def frames(self, q):
        m, out, q = np.eye(4), [], list(q)
        for j in self.joints:
            m = m @ hom(j.find("origin"))
            if j in self.moving:
                out.append(m.copy())
                m = m @ rodrigues(numbers(j.find("axis").get("xyz"), ""), q.pop(0))
        return m, out

    def world(self, root):
        """The controller's world (REP 199: link `base`, fixed to `base_link`) in the root link."""
        at = {self.joints[0].find("parent").get("link"): np.eye(4)}
        for j in root.iter("joint"):
            if j.get("type") == "fixed" and j.find("child").get("link") == "base" and j.find("parent").get("link") in at:
                return hom(j.find("origin"))
        return np.eye(4)

    def limits(self):
        lim = [j.find("limit") for j in self.moving]
        return [(float(l.get("lower", -math.pi)), float(l.get("upper", math.pi))) if j.get("type") == "revolute" else (-math.pi, math.pi)
                for j, l in zip(self.moving, lim)]

    def reach(self, rng):
        """Farthest of the wrist centre (axis of the last joint but one) from the first axis, mm."""
        lim = self.limits()

        def of(q):
            _, frames = self.frames(q)
            a, p = frames[0], frames[-2][:3, 3]
            z = a[:3, :3] @ np.array(numbers(self.moving[0].find("axis").get("xyz"), ""))
            v = p - a[:3, 3]
            return np.linalg.norm(v - z * (v @ z))
        best = 0.0
        for _ in range(12):
            q = np.array([rng.uniform(*l) for l in lim])
            q[0], value, step = 0.0, 0.0, 0.5
            value = of(q)
            while step > 1e-4:
                better = False
                for k in range(1, len(q) - 2):
                    for d in (step, -step):
                        t = q.copy()
                        t[k] = min(max(t[k] + d, lim[k][0]), lim[k][1])
                        if of(t) > value + 1e-12:
                            q, value, better = t, of(t), True
                step = step if better else step / 2
            best = max(best, value)
        return best * 1e3


def named(joint, file):
    """The maker's name of a joint: A1 of a KUKA, J1 of ABB, FANUC and Staubli, S of a Motoman, base of a UR."""
    number = re.search(r"joint_a?(\d)$", joint)
    if number:
        return ("A" if file.startswith("kuka") else "J") + number.group(1)
    letter = re.search(r"joint_(?:\d_)?([a-z])$", joint)
    if letter:
        return letter.group(1).upper()
    name = joint.removesuffix("_joint")
    return UR_NAMES.get(name, name)


def expanded(source, xacro, folder):
    from xacrodoc import XacroDoc, packages
    path = next(p for p in sorted(folder.rglob(xacro)))
    packages.look_in([folder])
    text = XacroDoc.from_file(str(path), resolve_packages=False).to_urdf_string()
    package = next(p for p in path.parents if (p / "package.xml").exists())
    licence = sorted({e.text.strip() for e in ET.parse(package / "package.xml").getroot().iter("license")})
    return text, str(path.relative_to(folder)), ", ".join(licence)


def text_of(v, digits, towards_zero=False):
    v = math.trunc(v * 10**digits) / 10**digits if towards_zero else round(v, digits)
    return repr(int(v)) if v == int(v) else repr(v)


def uniform(doc, name, names, ratio, gap_of):
    """One line a joint. Lengths to 1e-9 mm, angles to 1e-11 deg; limits and speeds cut, never beyond those of the URDF."""
    lines = ["schema: lostmotion/robot/1", f"name: {name}", f"convention: {doc['convention']}", "joints:"]
    for j in doc["joints"]:
        if ratio and names[j["name"]] == "J3":
            lines.append(f"  - {{name: J23, kind: revolute, follows: {{joint: J2, ratio: {ratio}}}}}")
        cells = [f"name: {names[j['name']]}", f"kind: {j['kind']}"]
        cells += [f"{k}: {text_of(j[k], d)}" for k, d in [("theta_deg", 11), ("d_mm", 9), ("a_mm", 9), ("alpha_deg", 11)]]
        if "limits_deg" in j:
            cells.append("limits_deg: [" + ", ".join(text_of(v, 3, True) for v in j["limits_deg"]) + "]")
        if "max_speed_deg_s" in j:
            cells.append(f"max_speed_deg_s: {text_of(j['max_speed_deg_s'], 3, True)}")
        lines.append("  - {" + ", ".join(cells) + "}")
    for key in [k for k in ("base", "flange", "tool") if k in doc]:
        xyz, rpy = ([text_of(v, d) for v in doc[key][k]] for k, d in [("xyz_mm", 9), ("rpy_deg", 9)])
        lines.append(f"{key}: {{xyz_mm: [{', '.join(xyz)}], rpy_deg: [{', '.join(rpy)}]}}")
    lines.append("gravity_m_s2: [0, 0, -9.80665]")
    if gap_of:
        lines.append("gap_of: {J3: J2 + J3}")
    return "\n".join(lines) + "\n"


def make(sources, binary):
    rng = np.random.default_rng(7)
    oracle, folders = {}, {}
    work = pathlib.Path(tempfile.mkdtemp())
    for file, name, (repo, commit), xacro, sheet in ARMS:
        if repo not in folders:
            folders[repo] = work / repo.replace("/", "+")
            git = ["git", "-C", str(sources / repo.replace("/", "+") / "repo")]
            for path in subprocess.run([*git, "ls-tree", "-r", "--name-only", commit], capture_output=True, text=True, check=True).stdout.splitlines():
                if path.endswith((".xacro", ".urdf", ".yaml", "package.xml")):
                    to = folders[repo] / path
                    to.parent.mkdir(parents=True, exist_ok=True)
                    to.write_bytes(subprocess.run([*git, "show", f"{commit}:{path}"], capture_output=True, check=True).stdout)
        try:
            text, path, licence = expanded(repo, xacro, folders[repo])
        except Exception as e:
            print("SKIP", file, type(e).__name__, str(e)[:200])
            continue
        links = [l.get("name") for l in ET.fromstring(text).iter("link")]
        tip = next((t for t in links if t == "tool0" or t.endswith("tool0")), next((t for t in links if t.endswith("flange")), links[-1]))
        urdf = work / f"{file}.urdf"
        urdf.write_text(text)
        out = subprocess.run([binary, "robot", "init", "--urdf", urdf, "--tip", tip, "--output", work / f"{file}.yaml"], capture_output=True, text=True)
        if out.returncode:
            print("SKIP", file, out.stderr[:300])
            continue
        chain = Chain(text, tip)
        names = {j.get("name"): named(j.get("name"), file) for j in chain.moving}
        coupled = "fanuc" in file
        ratio = 1 if coupled else LINKAGE.get(file, 0)
        licence = licence.split(",")[0]  # the other one of UR's package is for its pictures
        doc = yaml.safe_load((work / f"{file}.yaml").read_text())
        world = np.linalg.inv(chain.world(ET.fromstring(text)))
        flange = np.eye(4)
        if file in NO_TURN_OF_FLANGE:
            flange = hom(ET.fromstring('<origin rpy="0 %r 0"/>' % (math.pi / 2)))
            # Ry(-90) Rx(-180) before the turn
            assert np.allclose(doc["flange"]["rpy_deg"], [-180, -90, 0])
            doc["flange"]["rpy_deg"] = [0.0, 0.0, 180.0]
        for j, shown in zip(doc["joints"], AT_ZERO.get(file, [])):
            j["theta_deg"] -= shown
            j["limits_deg"] = [v + shown for v in j["limits_deg"]]
        body = uniform(doc, name, names, ratio, coupled)
        reach = chain.reach(rng)
        head = [f"# {name}. Lengths, senses, limits and speeds: {path} of", f"# github.com/{repo} at commit {commit}",
                f"# ({licence}), not verified here. max_accel_deg_s2: add it from the data sheet.",
                f"# Wrist centre at most {reach:.0f} mm from the first axis; data sheet: {sheet} mm."]
        if file in AT_ZERO:
            head += ["# A2 and A3 are the pendant's: the description counts from the arm upright with its forearm level, the maker from A2 -90, A3 90 there."]
        if coupled:
            head += ["# J3 is the pendant's: the forearm against the horizontal. J23 takes J2 out of it. gap_of: see docs/program-fanuc.md."]
        elif ratio:
            head += ["# J3 is the controller's: the forearm against the horizontal, which the linkage beside the arm keeps when J2 moves. J23 takes J2 out of it.",
                     "# The motor of J3 drives that linkage, so its lost motion is one of J3 alone."]
        (ROOT / "configs" / f"{file}.yaml").write_text("\n".join(head) + "\n" + body)
        poses = []
        for _ in range(POSES):
            q = np.array([rng.uniform(max(lo, -math.pi), min(hi, math.pi)) for lo, hi in chain.limits()])
            m = world @ chain.frames(q)[0] @ flange
            deg = np.degrees(q) + np.array(AT_ZERO.get(file, 0))
            deg[2] -= ratio * deg[1]
            poses.append({"joints_deg": deg.tolist(), "xyz_m": m[:3, 3].tolist(), "rotation": m[:3, :3].tolist()})
        oracle[file] = {"reach_mm": round(reach, 1), "data_sheet_mm": sheet, "poses": poses}
        print(f"{file:28} {list(names.values())} reach {reach:.0f} / {sheet} {licence} {out.stderr.strip().splitlines()[0][-60:]}")
    rows = ",\n".join(f'"{k}": {json.dumps(v)}' for k, v in oracle.items())
    (ROOT / "tests/oracle/robots.json").write_text("{\n" + rows + "\n}\n")


if __name__ == "__main__":
    a = argparse.ArgumentParser()
    a.add_argument("what", choices=["make"])
    a.add_argument("--sources", type=pathlib.Path, required=True)
    a.add_argument("--lostmotion", required=True)
    a = a.parse_args()
    make(a.sources, a.lostmotion)
