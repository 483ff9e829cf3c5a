#!/usr/bin/env python3
"""Expected results of `simulate` for every effect of the catalogue, written from the specification's equations alone.

  python3 tests/oracle/catalogue_oracle.py

writes tests/data/catalogue/{cases.json,*_log.csv,arm_program.csv,arm_poses.csv} again. It shares no code with lostmotion: every
joint is stepped in time at 0.25 ms with commands known as formulas (a log gets their rows at 20 Hz, so the turning points
between rows have to be found by the program under test); kinematics multiply 4 x 4 matrices in the order of the robot file;
gravity's torque is the numerical derivative of the potential energy. Needs numpy and yaml. All data are made up.
"""
import json, pathlib
import numpy as np, yaml

OUT = pathlib.Path(__file__).resolve().parent.parent / "data" / "catalogue"
DT, RATE, END = 0.25e-3, 20, 20.0
EVERY = 7  # rows that are kept: every 7th
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
    return shift(*(np.array(f["xyz_mm"]) / 1000)) @ rot("z", y) @ rot("y", p) @ rot("x", r)


class Robot:
    def __init__(self, name):
        self.file = yaml.safe_load((OUT / name).read_text())
        self.joints = self.file["joints"]
        self.axes = [j for j in self.joints if "follows" not in j]
        self.names = [j["name"] for j in self.axes]
        self.tool_m = np.array(self.file["tool"]["xyz_mm"]) / 1000

    def si(self, name):
        return np.pi / 180 if self.axes[self.names.index(name)]["kind"] == "revolute" else 1e-3

    def frames(self, q, change={}):
        """Frames behind every joint; `change` maps (joint, parameter) to a delta."""
        t = frame(self.file["base"])
        out = []
        for j in self.joints:
            driver, ratio = (j["follows"]["joint"], j["follows"]["ratio"]) if "follows" in j else (j["name"], 1)
            v = j.get("direction", 1) * ratio * q[self.names.index(driver)]
            theta, d = rad(j.get("theta_deg", 0)), j.get("d_mm", 0) / 1000
            if j["kind"] == "revolute":
                theta += v
            else:
                d += v
            a, alpha = j.get("a_mm", 0) / 1000, rad(j.get("alpha_deg", 0))
            a += change.get((j["name"], "a"), 0)
            d += change.get((j["name"], "d"), 0)
            alpha += change.get((j["name"], "alpha"), 0)
            if self.file["convention"] == "dh-standard":
                t = t @ rot("z", theta) @ shift(0, 0, d) @ shift(a, 0, 0) @ rot("x", alpha)
            else:
                t = t @ rot("x", alpha) @ shift(a, 0, 0) @ rot("z", theta) @ shift(0, 0, d)
            out.append(t)
        return out

    def tcp(self, q, change={}, tool=np.zeros(3)):
        return (self.frames(q, change)[-1] @ np.append(self.tool_m + tool, 1))[:3]

    def torque(self, q, payload):
        def energy(q):
            g = np.array(self.file["gravity_m_s2"]) if "gravity_m_s2" in self.file else np.array([0, 0, -9.80665])
            fs = self.frames(q)
            e = 0
            for f, l in zip(fs, self.file["links"]):
                e -= l["mass_kg"] * g @ (f @ np.append(np.array(l["com_mm"]) / 1000, 1))[:3]
            return e - payload * g @ fs[-1][:3, 3]
        h = 1e-5
        return np.array([-(energy(q + h * e) - energy(q - h * e)) / (2 * h) for e in np.eye(len(q))])


# commands by formula, deg or mm: centre, then (amplitude, rad/s) of A (1 - cos(w t)); they start at rest
COMMANDS = {
    "arm": [(10, (12, 0.9), (3, 2.1)), (-60, (8, 0.7), (2, 1.7)), (70, (9, 1.1), (2, 0.4)), (5, (25, 0.8), (4, 1.9)),
            (30, (15, 1.3),), (-20, (40, 0.6), (5, 1.5))],
    "slide": [(200, (120, 0.5), (15, 1.3)), (10, (9, 0.8),), (20, (11, 0.6), (3, 1.4)), (-15, (30, 1.0), (6, 2.0))],
}


def commands(robot, which, t):
    t = np.maximum(t, 0)
    cols = [c[0] + sum(a * (1 - np.cos(w * t)) for a, w in c[1:]) for c in COMMANDS[which]]
    return np.array([col * robot.si(n) for col, n in zip(cols, robot.names)])


def stepped_lag(p, s, lag):
    """lag dq/dt + q = s by the trapezoidal rule, from rest."""
    q = np.empty_like(s)
    q[0] = s[0]
    k = DT / (2 * lag)
    for i in range(1, len(s)):
        q[i] = (q[i - 1] * (1 - k) + k * (s[i] + s[i - 1])) / (1 + k)
    return q


def stiction(t, p, spike, decay_s, decay):
    out = np.zeros_like(p)
    direction, turn = 0, None
    for i in range(1, len(p)):
        step = np.sign(p[i] - p[i - 1])
        if step != 0 and step != direction:
            if direction != 0:
                turn = i - 1
            direction = step
        if turn is not None:
            travel = abs(p[i] - p[turn])
            left = np.exp(-(t[i] - t[turn]) / decay_s) if decay_s else np.exp(-travel / decay)
            out[i] = -direction * min(travel, spike * left)
    return out


def play(s, b, preload):
    out = np.empty_like(s)
    y = s[0] - preload * b[0]
    for i in range(len(s)):
        y = min(max(y, s[i] - b[i]), s[i] + b[i])
        out[i] = y
    return out


def dahl(s, width, presliding, preload):
    z, zs = float(preload), np.empty_like(s)
    zs[0] = z
    for i in range(1, len(s)):
        step = s[i] - s[i - 1]
        d = np.sign(step)
        middle = z + 0.5 * (d - z) / presliding * abs(step)
        z += (d - middle) / presliding * abs(step)
        zs[i] = z
    return s - width * zs


def run(robot, t, p, effects, preload={}, payload=0.0, settled=False, rows=None, shift_steps=0, measured=None):
    """TCP in the base frame (m) at the steps `rows`; `shift_steps` is the time offset."""
    joint = []
    path = None
    for k, name in enumerate(robot.names):
        si, side = robot.si(name), preload.get(name, 0)
        unit = "deg" if si < 0.5e-1 and si != 1e-3 else "mm"
        s = p[k].copy()
        mine = [e for e in effects if e.get("joint") == name]
        v = lambda e, key: e[f"{key}_{unit}"] * si
        order = ["servo_lag", "stiction"]
        for e in [e for e in mine if e["effect"] in order]:
            if e["effect"] == "servo_lag":
                s = s if settled else stepped_lag(p[k], s, e["lag_s"])
            else:
                if "decay_s" in e:
                    s = s if settled else s + stiction(t, p[k], v(e, "spike"), e["decay_s"], None)
                else:
                    s = s + stiction(t, p[k], v(e, "spike"), None, v(e, "decay"))
        for e in mine:
            n = e["effect"]
            if n == "encoder_scale":
                s = s * (1 + e["scale_ppm"] * 1e-6)
            elif n == "transmission_error":
                turn = 2 * np.pi if unit == "deg" else robot.axes[k]["lead_mm_per_rev"] / 1000
                s = s + v(e, "amplitude") * np.sin(2 * np.pi * e["cycles_per_rev"] * s / turn + rad(e["phase_deg"]))
            elif n == "backlash":
                s = play(s, np.full_like(s, v(e, "half_gap")), side)
            elif n == "backlash_position":
                from scipy.interpolate import PchipInterpolator
                x, y = np.array(e["knots"]).T * si
                s = play(s, PchipInterpolator(x, y)(np.clip(p[k], x[0], x[-1])), side)
            elif n == "backlash_speed":
                if path is None:
                    path = np.array([robot.tcp(q) for q in p.T[::4]])
                    speed = np.interp(t, t[::4], np.linalg.norm(np.gradient(path, t[::4], axis=0), axis=1))
                s = play(s, v(e, "half_gap") + e[f"slope_{unit}_per_mm_s"] * si * 1000 * speed, side)
            elif n == "hysteresis":
                s = dahl(s, v(e, "half_width"), v(e, "presliding"), side)
        joint.append(s)
    joint = np.array(joint)
    at = rows + shift_steps
    q, cmd = joint[:, at], p[:, at]
    for e in effects:
        if e["effect"] == "joint_zero_offset":
            k = robot.names.index(e["joint"])
            q[k] += e["offset_deg" if "offset_deg" in e else "offset_mm"] * robot.si(e["joint"])
        elif e["effect"] == "axis_coupling":
            to, source = (robot.names.index(n) for n in e["target"].split("<-"))
            edge = robot.si(robot.names[to]) / robot.si(robot.names[source])
            q[to] += e["ratio"] * edge * cmd[source]
        elif e["effect"] == "gravity_compliance":
            k = robot.names.index(e["joint"])
            c = e["compliance_deg_per_nm"] * np.pi / 180 if "compliance_deg_per_nm" in e else e["compliance_mm_per_n"] * 1e-3
            q[k] += c * np.array([robot.torque(x, payload)[k] for x in cmd.T])
    change, tool = {}, np.zeros(3)
    for e in effects:
        if e["effect"] == "link_error":
            name, parameter = e["target"].split(".")
            change[name, parameter] = rad(e["delta_deg"]) if parameter == "alpha" else e["delta_mm"] / 1000
        elif e["effect"] == "tool_error":
            tool = np.array([e["x_mm"], e["y_mm"], e["z_mm"]]) / 1000
    points = np.array([robot.tcp(x, change, tool) for x in q.T])
    for e in effects:
        seconds = t[at] - t[rows[0]]
        if e["effect"] == "thermal_drift" and not settled:
            d = np.array([e["x_mm"], e["y_mm"], e["z_mm"]]) / 1000
            points += np.outer(1 - np.exp(-np.maximum(seconds, 0) / e["tau_s"]), d)
        elif e["effect"] == "vibration" and not settled:
            n = np.array(e["direction"], float)
            wave = np.sin(2 * np.pi * e["frequency_hz"] * seconds + rad(e["phase_deg"]))
            points += np.outer(e["amplitude_um"] * 1e-6 * wave, n / np.linalg.norm(n))
    return points


ARM = [
    [dict(effect="servo_lag", joint="A1", lag_s=0.02), dict(effect="servo_lag", joint="A4", lag_s=0.001)],
    [dict(effect="stiction", joint="A2", spike_deg=0.004, decay_s=0.8)],
    [dict(effect="stiction", joint="A3", spike_deg=0.004, decay_deg=0.5)],
    [dict(effect="encoder_scale", joint="A1", scale_ppm=150)],
    [dict(effect="transmission_error", joint="A1", amplitude_deg=0.003, cycles_per_rev=37, phase_deg=25)],
    [dict(effect="backlash", joint="A2", half_gap_deg=0.005), dict(effect="backlash", joint="A5", half_gap_deg=0.01)],
    [dict(effect="backlash_position", joint="A1", knots=[[5, 0.002], [15, 0.006], [30, 0.003]])],
    [dict(effect="backlash_speed", joint="A1", half_gap_deg=0.002, slope_deg_per_mm_s=1e-5)],
    [dict(effect="hysteresis", joint="A2", half_width_deg=0.004, presliding_deg=0.2)],
    [dict(effect="joint_zero_offset", joint="A3", offset_deg=0.02)],
    [dict(effect="axis_coupling", target="A6<-A5", ratio=0.001)],
    [dict(effect="gravity_compliance", joint="A2", compliance_deg_per_nm=5e-6),
     dict(effect="gravity_compliance", joint="A5", compliance_deg_per_nm=5e-5)],
    [dict(effect="link_error", target="A2.a", delta_mm=0.3)],
    [dict(effect="link_error", target="A3.alpha", delta_deg=0.02), dict(effect="link_error", target="A4.d", delta_mm=-0.2)],
    [dict(effect="tool_error", x_mm=0.2, y_mm=-0.1, z_mm=0.3)],
    [dict(effect="thermal_drift", x_mm=0.1, y_mm=0, z_mm=-0.2, tau_s=8)],
    [dict(effect="vibration", amplitude_um=40, frequency_hz=3.3, phase_deg=20, direction=[1, 2, -2])],
    [dict(effect="time_offset", offset_s=0.013)],
    # chained: a gap behind a lagging servo that sticks, in a gear with an error of its own
    [dict(effect="servo_lag", joint="A1", lag_s=0.03), dict(effect="transmission_error", joint="A1", amplitude_deg=0.002,
     cycles_per_rev=11, phase_deg=0), dict(effect="backlash", joint="A1", half_gap_deg=0.006)],
    [dict(effect="servo_lag", joint="A2", lag_s=0.01), dict(effect="hysteresis", joint="A2", half_width_deg=0.004,
     presliding_deg=0.1), dict(effect="encoder_scale", joint="A2", scale_ppm=-80)],
    [dict(effect="stiction", joint="A1", spike_deg=0.003, decay_s=1.5), dict(effect="servo_lag", joint="A1", lag_s=0.02)],
    [dict(effect="time_offset", offset_s=-0.008), dict(effect="vibration", amplitude_um=30, frequency_hz=1.1, phase_deg=0,
     direction=[0, 0, 1]), dict(effect="thermal_drift", x_mm=0, y_mm=0.3, z_mm=0, tau_s=5)],
]
SLIDE = [
    [dict(effect="servo_lag", joint="S", lag_s=0.015)],
    [dict(effect="stiction", joint="S", spike_mm=0.05, decay_s=1.2)],
    [dict(effect="encoder_scale", joint="S", scale_ppm=200)],
    [dict(effect="transmission_error", joint="S", amplitude_mm=0.01, cycles_per_rev=1, phase_deg=-40)],
    [dict(effect="backlash", joint="S", half_gap_mm=0.1)],
    [dict(effect="backlash_speed", joint="S", half_gap_mm=0.04, slope_mm_per_mm_s=3e-4)],
    [dict(effect="hysteresis", joint="S", half_width_mm=0.05, presliding_mm=1.5)],
    [dict(effect="joint_zero_offset", joint="S", offset_mm=0.3), dict(effect="joint_zero_offset", joint="J2", offset_deg=0.05)],
    [dict(effect="axis_coupling", target="J3<-S", ratio=0.0002)],
    [dict(effect="gravity_compliance", joint="S", compliance_mm_per_n=1e-5),
     dict(effect="gravity_compliance", joint="J2", compliance_deg_per_nm=1e-5)],
    [dict(effect="link_error", target="J2b.a", delta_mm=0.3), dict(effect="link_error", target="J2.alpha", delta_deg=0.03)],
    [dict(effect="backlash", joint="J2", half_gap_deg=0.01), dict(effect="tool_error", x_mm=0.1, y_mm=0.2, z_mm=0.3)],
]


def name_of(effects):
    return " + ".join(f"{e['effect']} {e.get('joint') or e.get('target') or ''}".strip() for e in effects)


def decimals(robot, values):
    return ["%.9f" % (v / robot.si(n)) for v, n in zip(values, robot.names)]


def main():
    cases = []
    per_row = round(1 / RATE / DT)
    margin = round(0.1 / DT)
    t = (np.arange(round(END / DT) + 1 + 2 * margin) - margin) * DT
    all_rows = np.arange(round(END * RATE) + 1) * per_row + margin
    # beyond the last row nobody knows how the motion goes on
    kept = [i for i in range(0, len(all_rows), EVERY) if i < len(all_rows) - 3]
    for which, groups in (("arm", ARM), ("slide", SLIDE)):
        robot = Robot(f"{which}.yaml")
        p = commands(robot, which, t)
        payload = 25.0 if which == "arm" else 0.0
        head = ["t_s"] + [f"cmd_{n}_{'mm' if robot.si(n) == 1e-3 else 'deg'}" for n in robot.names]
        lines = [",".join(head + (["payload_kg"] if payload else []))]
        for r in all_rows:
            lines.append(",".join(["%.3f" % t[r]] + decimals(robot, p[:, r]) + (["25"] if payload else [])))
        (OUT / f"{which}_log.csv").write_text("\n".join(lines) + "\n")
        for effects in groups:
            offset = sum(e["offset_s"] for e in effects if e["effect"] == "time_offset")
            # vibration and drift count from the first row
            preload = {"A2": 1} if effects[0]["effect"] in ("backlash", "hysteresis") and which == "arm" else {}
            # the fine run starts with the log: the start at rest belongs to the first row
            points = run(robot, t, p, effects, preload, payload, rows=all_rows, shift_steps=round(offset / DT))
            cases.append(dict(name=name_of(effects), robot=f"{which}.yaml", input=f"{which}_log.csv", effects=effects,
                              preload=preload, rows=kept, xyz_mm=(points[kept] * 1000).round(6).tolist()))
    robot = Robot("arm.yaml")
    # a program: straight in the joints between points
    rng = np.random.default_rng(3)
    times = np.cumsum(np.r_[0, rng.integers(8, 30, 14)]) * 0.1
    corners = np.array([[c[0] for c in COMMANDS["arm"]]] * 15) + rng.uniform(-6, 6, (15, 6)).round(3)
    (OUT / "arm_program.csv").write_text("t_s," + ",".join(f"{n}_deg" for n in robot.names) + "\n" + "".join(
        "%.1f," % a + ",".join("%.3f" % x for x in q) + "\n" for a, q in zip(times, corners)))
    t = np.arange(round(times[-1] / DT) + 1) * DT
    p = np.array([np.interp(t, times, c) for c in rad(corners).T])
    rows = np.arange(int(round(times[-1] * RATE)) + 1) * per_row
    effects = [dict(effect="servo_lag", joint="A1", lag_s=0.02), dict(effect="backlash", joint="A1", half_gap_deg=0.006),
               dict(effect="servo_lag", joint="A2", lag_s=0.02), dict(effect="stiction", joint="A2", spike_deg=0.003, decay_s=0.5),
               dict(effect="hysteresis", joint="A3", half_width_deg=0.004, presliding_deg=0.3)]
    points = run(robot, t, p, effects, rows=rows)
    kept = list(range(0, len(rows), EVERY))
    cases.append(dict(name="program: " + name_of(effects), robot="arm.yaml", input="arm_program.csv", effects=effects, preload={},
                      rows=kept, xyz_mm=(points[kept] * 1000).round(6).tolist()))
    # settled poses: each approached in a straight line; what fades in time has faded
    poses = np.array([[c[0] for c in COMMANDS["arm"]]] * 30) + rng.uniform(-6, 6, (30, 6)).round(3)
    (OUT / "arm_poses.csv").write_text(",".join(f"cmd_{n}_deg" for n in robot.names) + "\n" + "".join(
        ",".join("%.3f" % x for x in q) + "\n" for q in poses))
    steps = 4000
    t = np.arange((len(poses) - 1) * steps + 1) * DT
    p = np.array([np.interp(np.arange(len(t)), np.arange(len(poses)) * steps, c) for c in rad(poses).T])
    effects = [dict(effect="servo_lag", joint="A1", lag_s=0.05), dict(effect="backlash", joint="A1", half_gap_deg=0.006),
               dict(effect="stiction", joint="A2", spike_deg=0.01, decay_s=3.0),
               dict(effect="stiction", joint="A5", spike_deg=0.01, decay_deg=4.0),
               dict(effect="hysteresis", joint="A3", half_width_deg=0.004, presliding_deg=2.0),
               dict(effect="thermal_drift", x_mm=1, y_mm=1, z_mm=1, tau_s=5),
               dict(effect="vibration", amplitude_um=300, frequency_hz=0.3, phase_deg=40, direction=[1, 0, 0])]
    points = run(robot, t, p, effects, settled=True, rows=np.arange(len(poses)) * steps)
    cases.append(dict(name="poses: " + name_of(effects), robot="arm.yaml", input="arm_poses.csv", effects=effects, preload={},
                      rows=list(range(len(poses))), xyz_mm=(points * 1000).round(6).tolist()))
    text = ",\n".join(json.dumps(c, separators=(",", ":")) for c in cases)
    (OUT / "cases.json").write_text("[\n" + text + "\n]\n")


main()
