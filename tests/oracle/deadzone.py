#!/usr/bin/env python3
"""Logs of growing sweeps, and the deadzones in them, for the tests of `identify deadzone`.

  python3 tests/oracle/deadzone.py

writes tests/data/deadzone/{instrument_log,coupled_log}.csv.gz and truth.json again, the same bytes. It shares no code with lostmotion:
the motor follows a formula (rows show it at 5 Hz, so that turning points lie between rows), the play is stepped in time at 1 ms with a
gap that is a formula of the motor position, kinematics multiply 4 x 4 matrices in the order of the robot file. A deadzone of the truth
begins where the motor turns while the joint moves, and ends at the first step at which the joint moves the other way. Needs numpy
and yaml. All data are made up: the instrument after Cursi (2022) (configs/micro-iges-4dof.yaml, tests/data/robots/coupled-elbows.yaml).
"""
import gzip, json, pathlib
import numpy as np, yaml

TESTS = pathlib.Path(__file__).resolve().parent.parent
OUT = TESTS / "data" / "deadzone"
DT, RATE, T, PERIOD = 1e-3, 5, 250.0, 20.0
rad = np.deg2rad


def rot(axis, a):
    c, s = np.cos(a), np.sin(a)
    m = np.eye(4)
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    m[i, i] = m[j, j] = c
    m[i, j], m[j, i] = -s, s
    return m


def shift(x, y, z):
    m = np.eye(4)
    m[:3, 3] = x, y, z
    return m


def frame(f):
    r, p, y = rad(f["rpy_deg"])
    return shift(*f["xyz_mm"]) @ rot("z", y) @ rot("y", p) @ rot("x", r)


def tip(robot, q):
    """Tip in mm for joint values by name (deg, mm)."""
    m = frame(robot["base"])
    for j in robot["joints"]:
        f = j.get("follows")
        v = j.get("direction", 1) * (q[f["joint"]] * f["ratio"] if f else q[j["name"]])
        theta, d = j.get("theta_deg", 0), j.get("d_mm", 0)
        theta, d = (theta + v, d) if j["kind"] == "revolute" else (theta, d + v)
        m = m @ rot("z", rad(theta)) @ shift(0, 0, d) @ shift(j["a_mm"], 0, 0) @ rot("x", rad(j["alpha_deg"]))
    return (m @ frame(robot["tool"]))[:3, 3]


def sweep(gap, amplitude):
    """Motor and joint at the rows, and the deadzones: [from, to], of one growing sine."""
    t = np.arange(0, T + DT / 2, DT)
    p = amplitude * t / T * np.sin(2 * np.pi * t / PERIOD)
    y, rows, zones = 0.0, [], []
    moving, turned_at = 0, None
    every = round(1 / RATE / DT)
    for i, x in enumerate(p):
        b = gap(x)
        new = min(max(y, x - b), x + b)
        step = np.sign(new - y)
        if step and moving and step != moving:
            zones.append([turned_at, x])
        if step:
            moving, turned_at = step, x
        y = new
        if i % every == 0:
            rows.append((x, y))
    return rows, zones


def write(name, robot, sweeps, noise_mm, seed, lost=()):
    rng = np.random.default_rng(seed)
    registration = frame({"xyz_mm": [120.0, -85.0, 210.0], "rpy_deg": [12.0, -35.0, 80.0]})
    axes = [j for j in robot["joints"] if "follows" not in j]
    unit = {j["name"]: "deg" if j["kind"] == "revolute" else "mm" for j in axes}
    lines = ["t_s," + ",".join(f"cmd_{n}_{u}" for n, u in unit.items()) + ",x_mm,y_mm,z_mm"]
    truth, k = {}, 0
    for joint, (gap, amplitude) in sweeps.items():
        rows, zones = sweep(gap, amplitude)
        # the motor goes back and the joint with it, before the next one moves
        rows += [(rows[-1][0] * (1 - s), rows[-1][1] * (1 - s)) for s in np.linspace(0, 1, 11)[1:]]
        sizes = [abs(b - a) for a, b in zones]
        truth[joint] = {"deadzones": [[round(a, 5), round(b, 5)] for a, b in zones], "mean_half_gap": round(float(np.mean(sizes)) / 2, 6),
                        "at": list(range(-30, 31, 5)), "half_gap": [round(float(gap(v)), 6) for v in range(-30, 31, 5)]}
        for p, y in rows:
            q = {n: 0.0 for n in unit} | {joint: y}
            x = (registration @ np.append(tip(robot, q), 1))[:3] + rng.normal(0, noise_mm, 3)
            cells = [f"{v:.3f}" for v in x] if not any(a <= k % 997 < b for a, b in lost) else [""] * 3
            lines.append(f"{k / RATE:.1f}," + ",".join(f"{p:.4f}" if n == joint else "0" for n in unit) + "," + ",".join(cells))
            k += 1
    (OUT / f"{name}_log.csv.gz").write_bytes(gzip.compress(("\n".join(lines) + "\n").encode(), 9, mtime=0))
    return truth


instrument = yaml.safe_load((TESTS.parent / "configs" / "micro-iges-4dof.yaml").read_text())
coupled = yaml.safe_load((TESTS / "data" / "robots" / "coupled-elbows.yaml").read_text())
bow = lambda c, s, q: (lambda p: c + s * np.sin(p / 15) + q * (p / 40) ** 2)
truth = {
    # 50 um: an electromagnetic tracker at its best
    "instrument": write("instrument", instrument, {
        "E1": (bow(1.7, 0.05, 0.3), 40), "E2": (bow(3.4, -0.1, -0.5), 40),
        "PITCH": (bow(1.1, 0.1, 1.5), 40), "YAW": (lambda p: 2.2, 40)}, 0.050, 1),
    # each elbow is a pair of joints; the tracker drops out now and then, once about a turn
    "coupled": write("coupled", coupled, {"E1": (bow(1.2, 0.0, 0.8), 30), "E2": (lambda p: 2.0, 30)}, 0.020, 2,
                     lost=[(100, 104), (300, 302), (516, 540), (800, 801)]),
}
(OUT / "truth.json").write_text(json.dumps(truth, indent=1) + "\n")
