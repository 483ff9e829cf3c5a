#!/usr/bin/env python3
"""TCP poses of several robots by methods that share nothing with src/robot: writes kinematics.json beside this file.

  KUKA          product of rotations about fixed axes in space, as in the twin: no DH at all, lengths typed in here
  ABB           Pinocchio (`pip install pin`), a tree of joints and placements; without it, homogeneous matrices
  all others    products of 4 x 4 homogeneous matrices of the contract's equations, read from the robot files

Needs numpy and pyyaml. The poses are drawn from a seeded generator: the same file each time, to the last printed digit.
"""
import json, pathlib
import numpy as np
import yaml

HERE = pathlib.Path(__file__).parent
ROOT = HERE.parent.parent
POSES = 25


def rot(axis, deg):
    a = np.radians(deg)
    c, s = np.cos(a), np.sin(a)
    return {"x": np.array([[1, 0, 0], [0, c, -s], [0, s, c]]), "y": np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]),
            "z": np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])}[axis]


def hom(r=np.eye(3), p=(0, 0, 0)):
    m = np.eye(4)
    m[:3, :3], m[:3, 3] = r, p
    return m


def frame(f):
    r, p, y = f.get("rpy_deg", [0, 0, 0])
    return hom(rot("z", y) @ rot("y", p) @ rot("x", r), f.get("xyz_mm", [0, 0, 0]))


def by_matrices(robot, command):
    m = frame(robot.get("base", {}))
    for j in robot["joints"]:
        driver, ratio = (j["follows"]["joint"], j["follows"]["ratio"]) if "follows" in j else (j["name"], 1)
        q = j.get("direction", 1) * ratio * command[driver]
        theta, d = j.get("theta_deg", 0), j.get("d_mm", 0)
        theta, d = (theta + q, d) if j["kind"] == "revolute" else (theta, d + q)
        turn_z, along_z = hom(rot("z", theta)), hom(p=(0, 0, d))
        turn_x, along_x = hom(rot("x", j.get("alpha_deg", 0))), hom(p=(j.get("a_mm", 0), 0, 0))
        if robot["convention"] == "dh-modified":
            m = m @ turn_x @ along_x @ turn_z @ along_z
        else:
            m = m @ turn_z @ along_z @ along_x @ turn_x
    return m @ frame(robot.get("tool", {}))


def kuka(_, command):
    """Rodrigues' formula about the six axes with the arm stretched level along x (all joints zero), from the tool inwards."""
    axes = [(0, 0, -1), (0, 1, 0), (0, 1, 0), (-1, 0, 0), (0, 1, 0), (-1, 0, 0)]
    points = [(0, 0, 0), (350, 0, 675), (1500, 0, 675), (2500, 0, 634), (2500, 0, 634), (2500, 0, 634)]
    p = np.array([2500 + 215 + 63, 0, 634 - 156.0])
    # flange frame at zero: z out of the flange (+x), x down (-z), y completes it (+y)
    r = np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0.0]])
    for k in range(5, -1, -1):
        a, o = np.array(axes[k], float), np.array(points[k], float)
        t = np.radians(command[f"A{k + 1}"])
        cross = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
        turn = np.eye(3) + np.sin(t) * cross + (1 - np.cos(t)) * cross @ cross
        p, r = turn @ (p - o) + o, turn @ r
    return hom(r, p)


def pinocchio(robot, command):
    try:
        import pinocchio as pin
    except ImportError:
        return by_matrices(robot, command)
    m, parent, place = pin.Model(), 0, pin.SE3(*split(frame(robot["base"])))
    for j in robot["joints"]:
        at = place * pin.SE3(rot("z", j["theta_deg"]), np.zeros(3))
        parent = m.addJoint(parent, pin.JointModelRevoluteUnaligned(0, 0, j["direction"]), at, j["name"])
        place = pin.SE3(rot("x", j["alpha_deg"]), np.array([j["a_mm"], 0, j["d_mm"]]))
    tcp = m.addFrame(pin.Frame("tcp", parent, 0, place * pin.SE3(*split(frame(robot["tool"]))), pin.FrameType.OP_FRAME))
    d = m.createData()
    pin.framesForwardKinematics(m, d, np.radians([command[j["name"]] for j in robot["joints"]]))
    return d.oMf[tcp].homogeneous


def split(m):
    return m[:3, :3], m[:3, 3]


def main():
    rng = np.random.default_rng(20)
    out = []
    for path, method in [("configs/kuka-kr120-r2500-pro.yaml", kuka), ("configs/abb-irb1600-6-145.yaml", pinocchio),
                         ("configs/gantry-xyz-ballscrew.yaml", by_matrices), ("configs/micro-iges-4dof.yaml", by_matrices),
                         ("tests/data/robots/modified-with-slide.yaml", by_matrices),
                         ("tests/data/robots/coupled-elbows.yaml", by_matrices)]:
        robot = yaml.safe_load((ROOT / path).read_text())
        own = [j for j in robot["joints"] if "follows" not in j]
        poses = []
        for _ in range(POSES):
            q = [round(float(rng.uniform(*j.get("limits_deg", j.get("limits_mm")))), 4) for j in own]
            m = method(robot, {j["name"]: v for j, v in zip(own, q)})
            poses.append({"command": q, "xyz_mm": [round(v, 9) + 0.0 for v in m[:3, 3].tolist()],
                          "rotation": [round(v, 12) + 0.0 for v in m[:3, :3].flatten().tolist()]})
        out.append({"robot": path, "method": method.__name__, "poses": poses})
    rows = lambda r: ",\n".join("    " + json.dumps(p) for p in r["poses"])
    text = ",\n".join(f'  {{"robot": "{r["robot"]}", "method": "{r["method"]}", "poses": [\n{rows(r)}\n  ]}}' for r in out)
    (HERE / "kinematics.json").write_text(f"[\n{text}\n]\n")


if __name__ == "__main__":
    main()
