#!/usr/bin/env python3
"""Expected results of `simulate` for every effect of the catalogue, written from the specification's equations alone.

  python3 tests/oracle/catalogue_oracle.py

writes tests/data/catalogue/{cases.json,*_log.csv,arm_program.csv,arm_poses.csv} again. It shares no code with lostmotion: every
joint is stepped in time at 0.25 ms with commands known as formulas (a log gets their rows at 20 Hz, so the turning points
between rows have to be found by the program under test); kinematics multiply 4 x 4 matrices in the order of the robot file;
gravity's torque is the numerical derivative of the potential energy. Needs numpy, scipy and yaml. All data are made up.
"""
import json, pathlib
import numpy as np, yaml
from scipy.interpolate import CubicSpline

OUT = pathlib.Path(__file__).resolve().parent.parent / "data" / "catalogue"
DT, RATE, END = 0.25e-3, 20, 20.0
EVERY = 7  # rows that are kept: every 7th
# a whole step more from one kept row to the next
DRIFT_PPM = 1e6 * DT / (EVERY / RATE)
rad = np.deg2rad


def rot(axis, a):
    c, s = np.cos(a), np.sin(a)
    m = np.eye(4)
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    m[i, i] = m[j, j] = c
    m[i, j], m[j, i] = -s, s
    return m


def turned_by(v):
    """Rotation about a vector by its length (Rodrigues)."""
    m, angle = np.eye(4), np.linalg.norm(v)
    if angle > 0:
        x, y, z = np.array(v) / angle
        k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        m[:3, :3] += np.sin(angle) * k + (1 - np.cos(angle)) * k @ k
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

    def frames(self, q, change={}, tilt={}, turned=None):
        """Frames behind every joint; `change` maps (joint, parameter) to a delta, `tilt` a joint to a small turn of its axis in the
        frame before its own turn; `turned` gets the frames after the turns, before the standard convention's a and alpha."""
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
            beta = change.get((j["name"], "beta"), 0)
            if self.file["convention"] != "dh-standard":
                t = t @ rot("x", alpha) @ shift(a, 0, 0) @ rot("y", beta)
            t = t @ shift(0, 0, d) @ turned_by(tilt.get(j["name"], (0, 0, 0))) @ rot("z", theta)
            if turned is not None:
                turned.append(t)
            if self.file["convention"] == "dh-standard":
                t = t @ shift(a, 0, 0) @ rot("x", alpha) @ rot("y", beta)
            out.append(t)
        return out

    def tcp(self, q, change={}, tool=np.zeros(3), tilt={}):
        return (self.frames(q, change, tilt)[-1] @ np.append(self.tool_m + tool, 1))[:3]

    def gravity(self):
        return np.array(self.file.get("gravity_m_s2", [0, 0, -9.80665]))

    def moment_torque(self, q, axis, moments):
        """Torque about an axis of unit gravity on first moments (x, y) of links: minus the derivative of their energy."""
        def energy(q):
            turned = []
            self.frames(q, turned=turned)
            down = self.gravity() / np.linalg.norm(self.gravity())
            names = [j["name"] for j in self.joints]
            return -sum(down @ (turned[names.index(n)][:3, :3] @ np.array([rad(x), rad(y), 0])) for n, x, y in moments)
        h = 1e-5 * np.eye(len(q))[axis]
        return -(energy(q + h) - energy(q - h)) / 2e-5

    def overturning(self, q, payload):
        """Moment of the weights about the base's origin."""
        fs, base = self.frames(q), frame(self.file["base"])[:3, 3]
        m = sum(np.cross((f @ np.append(np.array(l["com_mm"]) / 1000, 1))[:3] - base, l["mass_kg"] * self.gravity())
                for f, l in zip(fs, self.file["links"]))
        return m + np.cross(fs[-1][:3, 3] - base, payload * self.gravity()), base

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


def presliding(t, p, spikes, rise_s, rise, decay_s, decay, growth):
    """Friction z turns over as dz = (dir - z) dr, the servo answers de = -(spike/2) dz - e dd: stepped by the midpoint rule."""
    out = np.zeros_like(p)
    direction, e, z, begun = 0, 0.0, 0.0, False
    for i in range(1, len(p)):
        step = p[i] - p[i - 1]
        d = np.sign(step)
        if d != 0:
            begun = begun or (direction != 0 and d != direction)
            if not begun:
                z = d
            direction = d
        if begun:
            seconds, travel = t[i] - t[i - 1], abs(step)
            dr = seconds / rise_s if rise_s else travel / rise
            dd = seconds / decay_s if decay_s else travel / decay
            size = spikes[0 if direction > 0 else 1] * growth[i]
            middle = z + 0.5 * (direction - z) * dr
            dz = (direction - middle) * dr
            e_middle = e - 0.25 * size * dz - 0.5 * e * dd
            e += -0.5 * size * dz - e_middle * dd
            z += dz
        out[i] = e
    return out


def stops(s, elements, preload):
    out, z = s.copy(), np.full(len(elements), float(preload))
    w, k = elements[:, 0], elements[:, 1]
    out[0] -= w @ z
    for i in range(1, len(s)):
        z = np.clip(z + (s[i] - s[i - 1]) / k, -1, 1)
        out[i] -= w @ z
    return out


def loaded(s, b, load, limit, preload):
    out = np.empty_like(s)
    y = s[0] - preload * b
    for i in range(len(s)):
        y = s[i] + b if load[i] > limit else s[i] - b if load[i] < -limit else min(max(y, s[i] - b), s[i] + b)
        out[i] = y
    return out


def dahl_over(torque, reach):
    """State of Dahl's equation at every row, by small explicit steps over a torque that is straight between rows."""
    z, out = 0.0, [0.0]
    for a, b in zip(torque[:-1], torque[1:]):
        n = 4000
        step = (b - a) / n
        for _ in range(n):
            # midpoint rule
            half = z + 0.5 * abs(step) / reach * (np.sign(step) - z)
            z += abs(step) / reach * (np.sign(step) - half)
        out.append(z)
    return np.array(out)


def logged_torque(t, name):
    """Nm, as the log has it; made up."""
    k = int(name[-1])
    return 200 / k * np.sin(0.7 * t + k) + 60 * np.cos(1.9 * t) + 30


def logged_force(t):
    """N on the tool, world frame, as the log has it; made up."""
    return np.array([150 * np.sin(0.8 * t), 90 * np.cos(1.3 * t) + 40, -120 + 70 * np.sin(0.5 * t + 1)])


def logged_temperature(t):
    return 21 + 4 * (1 - np.exp(-np.maximum(t, 0) / 7))


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


def load_of(robot, t, p, axis, payload):
    """Torque of gravity about an axis at every step, by a spline through one in forty."""
    some = slice(None, None, 40)
    return CubicSpline(t[some], [robot.torque(q, payload)[axis] for q in p.T[some]])(t)


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
            elif any(key.startswith(("rise", "spike_positive", "per_nm")) for key in e):
                both = v(e, "spike") if f"spike_{unit}" in e else None
                spikes = [both, both] if both is not None else [v(e, "spike_positive"), v(e, "spike_negative")]
                growth = 1 + e["per_nm"] * np.abs(load_of(robot, t, p, k, payload)) if "per_nm" in e else np.ones_like(t)
                travel = lambda key: v(e, key) if f"{key}_{unit}" in e else None
                s = s + presliding(t, p[k], spikes, e.get("rise_s"), travel("rise"), e.get("decay_s"), travel("decay"), growth)
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
                speed = np.abs(np.gradient(p[k], t)) if f"fade_{unit}_s" in e else 0.0
                fade = np.exp(-speed / (e.get(f"fade_{unit}_s", 1.0) * si))
                s = s + v(e, "amplitude") * fade * np.sin(2 * np.pi * e["cycles_per_rev"] * s / turn + rad(e["phase_deg"]))
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
            elif n == "loaded_play":
                limit = e["torque_nm" if unit == "deg" else "force_n"]
                s = loaded(s, v(e, "half_gap"), load_of(robot, t, p, k, payload), limit, side)
            elif n == "hysteresis" and "elements" in e:
                s = stops(s, np.array(e["elements"]) * si, side)
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
        elif e["effect"] == "gravity_compliance" and "moments" in e:
            k = robot.names.index(e["joint"])
            q[k] += np.array([robot.moment_torque(x, k, e["moments"]) for x in cmd.T])
        elif e["effect"] == "gravity_compliance":
            k = robot.names.index(e["joint"])
            c = e["compliance_deg_per_nm"] * np.pi / 180 if "compliance_deg_per_nm" in e else e["compliance_mm_per_n"] * 1e-3
            q[k] += c * np.array([robot.torque(x, payload)[k] for x in cmd.T])
        elif e["effect"] == "torque_windup":
            k = robot.names.index(e["joint"])
            torque = logged_torque(t[at], e["joint"])
            q[k] += rad(e["compliance_deg_per_nm"]) * torque + rad(e.get("cubic_deg_per_nm3", 0)) * torque ** 3
        elif e["effect"] == "torque_hysteresis":
            k = robot.names.index(e["joint"])
            q[k] -= rad(e["half_width_deg"]) * dahl_over(logged_torque(t[rows], e["joint"]), e["torque_nm"])
        elif e["effect"] == "process_force":
            k = robot.names.index(e["joint"])
            h = 1e-6 * np.eye(len(robot.names))[k]
            levers = np.array([(robot.tcp(x + h) - robot.tcp(x - h)) / 2e-6 for x in cmd.T])
            q[k] += rad(e["compliance_deg_per_nm"]) * np.sum(levers * logged_force(t[at]).T, axis=1)
        elif e["effect"] == "coupled_play":
            to, source = (robot.names.index(n) for n in e["target"].split("<-"))
            u = p[to] - e["ratio"] * p[source]
            gap = e["half_gap_deg" if "half_gap_deg" in e else "half_gap_mm"] * robot.si(robot.names[to])
            q[to] += (play(u, np.full_like(u, gap), 0) - u)[at]
        elif e["effect"] == "empirical" and "joint" in e:
            k = robot.names.index(e["joint"])
            si, knots = robot.si(e["joint"]), np.array(e["knots"], float)
            direction = np.sign(np.diff(p[k], prepend=p[k][0]))[at]
            x = {"position": cmd[k] / si, "direction": direction, "speed": np.gradient(p[k], t)[at] / si,
                 "torque": logged_torque(t[at], e["joint"]), "time": t[at] - t[rows[0]]}[e["over"]]
            value = CubicSpline(*knots.T, bc_type="natural")(np.clip(x, knots[0, 0], knots[-1, 0])) * si
            q[k] += value * (direction if e.get("times") == "direction" else 1)
        elif e["effect"] == "thermal_growth" and "joint" in e:
            k = robot.names.index(e["joint"])
            q[k] += growth_of(e, t, at, rows) * robot.si(e["joint"])
    change, tool = {}, np.zeros(3)
    for e in effects:
        if e["effect"] == "link_error":
            name, parameter = e["target"].split(".")
            change[name, parameter] = rad(e["delta_deg"]) if parameter in ("alpha", "beta") else e["delta_mm"] / 1000
        elif e["effect"] == "tool_error":
            tool = np.array([e["x_mm"], e["y_mm"], e["z_mm"]]) / 1000
    grown = [e for e in effects if e["effect"] == "thermal_growth" and "target" in e]
    wobbly = [e for e in effects if e["effect"] == "bearing_wobble"]
    growth = [growth_of(e, t, at, rows) / 1000 for e in grown]
    points = []
    for i, x in enumerate(q.T):
        now = dict(change)
        for e, g in zip(grown, growth):
            name, parameter = e["target"].split(".")
            now[name, parameter] = now.get((name, parameter), 0) + g[i]
        tilt = {}
        for e in wobbly:
            k = robot.names.index(e["joint"])
            rev = 2 * np.pi if robot.axes[k]["kind"] == "revolute" else robot.axes[k]["lead_mm_per_rev"] / 1000
            across = np.array(e["direction"][:2], float)
            size = rad(e["amplitude_deg"]) * np.sin(2 * np.pi * e["cycles_per_rev"] * cmd[k, i] / rev + rad(e["phase_deg"]))
            tilt[e["joint"]] = np.append(across / np.linalg.norm(across) * size, 0)
        point = robot.tcp(x, now, tool, tilt)
        for e in effects:
            if e["effect"] == "base_tilt":
                moment, base = robot.overturning(cmd[:, i], payload)
                about = np.array([e.get("x_rad_per_nm", 0) * moment[0], e.get("y_rad_per_nm", 0) * moment[1], 0])
                point = base + (turned_by(about)[:3, :3] @ (point - base))
        points.append(point)
    points = np.array(points)
    for e in effects:
        seconds = t[at] - t[rows[0]]
        if e["effect"] == "thermal_drift" and not settled:
            d = np.array([e["x_mm"], e["y_mm"], e["z_mm"]]) / 1000
            points += np.outer(1 - np.exp(-np.maximum(seconds, 0) / e["tau_s"]), d)
        elif e["effect"] == "vibration" and not settled:
            n = np.array(e["direction"], float)
            wave = np.sin(2 * np.pi * e["frequency_hz"] * seconds + rad(e["phase_deg"]))
            points += np.outer(e["amplitude_um"] * 1e-6 * wave, n / np.linalg.norm(n))
        elif e["effect"] == "empirical" and e.get("target") == "tcp":
            knots = np.array(e["knots"], float)
            k = robot.names.index(e["of"]) if "of" in e else None
            x = seconds if k is None else cmd[k] / robot.si(e["of"])
            points += CubicSpline(knots[:, 0], knots[:, 1:], bc_type="natural")(np.clip(x, knots[0, 0], knots[-1, 0])) / 1000
    return measured_by_tracker(points, effects, t[rows] - t[rows[0]])


def measured_by_tracker(points, effects, seconds):
    """Scale and steps of the tracker, which stands at STATION in the base frame where the model has a registration."""
    station = -STATION["r"].T @ STATION["t"] if any(e["effect"].startswith("tracker") for e in effects) and STATION["on"] else np.zeros(3)
    for e in effects:
        if e["effect"] == "tracker_scale":
            points = points + e["scale_ppm"] * 1e-6 * (points - station)
        elif e["effect"] == "tracker_refraction":
            # the tracker sees along the tangent at its end of a beam of constant curvature
            beam = points - station
            length = np.linalg.norm(beam, axis=1, keepdims=True)
            along = beam / length
            bend = -0.93e-6 * e["gradient_k_per_m"] * (np.array([0, 0, 1]) - along * along[:, 2:])
            points = points - 0.5 * length ** 2 * bend
        elif e["effect"] == "tracker_frame":
            number = lambda keys: np.array([e.get(k, 0) * 1e-6 for k in keys])
            if "t_s" in e:
                share = np.clip((seconds - e["t_s"]) / e["over_s"], 0, 1) if "over_s" in e else (seconds >= e["t_s"] - 1e-9) * 1.0
            else:
                share = (np.arange(len(points)) >= e["at_row"]) * 1.0
            for i, k in enumerate(share):
                arm = points[i] - station
                points[i] = station + turned_by(k * number(["rx_urad", "ry_urad", "rz_urad"]))[:3, :3] @ arm + k * number(["x_um", "y_um", "z_um"])
    return points


# base frame -> tracker frame of the cases that have one
REGISTRATION = dict(xyz_mm=[2500, -1200, 400], rpy_deg=[4, -3, 110])
STATION = dict(r=frame(REGISTRATION)[:3, :3], t=frame(REGISTRATION)[:3, 3], on=False)


def growth_of(e, t, at, rows):
    """deg or mm by which a zero or a length has grown."""
    value = lambda key: next((v for k, v in e.items() if k.startswith(key)), None)
    seconds = t[at] - t[rows[0]]
    if value("per_hour") is not None:
        tau = e.get("tau_s")
        return value("per_hour") / 3600 * (tau * (1 - np.exp(-seconds / tau)) if tau else seconds)
    if value("per_k") is not None:
        return value("per_k") * (logged_temperature(t[at]) - logged_temperature(t[rows[0]]))
    return value("per_row") * np.arange(len(at))


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
ARM_MORE = [
    [dict(effect="stiction", joint="A1", spike_deg=0.004, rise_deg=0.3, decay_s=1.2)],
    [dict(effect="stiction", joint="A2", spike_positive_deg=0.005, spike_negative_deg=0.002, rise_s=0.4, decay_s=2.0)],
    [dict(effect="stiction", joint="A3", spike_deg=0.003, rise_deg=0.2, decay_deg=1.5, per_nm=0.002)],
    [dict(effect="hysteresis", joint="A1", elements=[[0.001, 0.05], [0.002, 0.4], [0.001, 2.0]])],
    [dict(effect="loaded_play", joint="A3", half_gap_deg=0.005, torque_nm=150)],
    [dict(effect="loaded_play", joint="A5", half_gap_deg=0.01, torque_nm=3), dict(effect="servo_lag", joint="A5", lag_s=0.01)],
    [dict(effect="transmission_error", joint="A2", amplitude_deg=0.004, cycles_per_rev=30, phase_deg=70, fade_deg_s=9)],
    [dict(effect="torque_windup", joint="A1", compliance_deg_per_nm=1e-5, cubic_deg_per_nm3=-4e-11)],
    [dict(effect="process_force", joint="A2", compliance_deg_per_nm=2e-5), dict(effect="process_force", joint="A5", compliance_deg_per_nm=8e-5)],
    [dict(effect="tracker_refraction", gradient_k_per_m=1.5)],
    [dict(effect="torque_hysteresis", joint="A1", half_width_deg=0.004, torque_nm=60)],
    [dict(effect="time_offset", drift_ppm=DRIFT_PPM)],
    [dict(effect="coupled_play", target="A5<-A4", half_gap_deg=0.01, ratio=0.8)],
    [dict(effect="gravity_compliance", joint="A2", moments=[["A2", 0.01, -0.004], ["A3", 0.006, 0.003], ["A5", -0.002, 0.001]])],
    [dict(effect="bearing_wobble", joint="A1", amplitude_deg=0.004, cycles_per_rev=9, phase_deg=20, direction=[1, -2, 0]),
     dict(effect="time_offset", offset_s=0.01)],
    [dict(effect="bearing_wobble", joint="A5", amplitude_deg=0.008, cycles_per_rev=2, phase_deg=-50, direction=[0, 1, 0])],
    [dict(effect="link_error", target="A2.beta", delta_deg=0.03), dict(effect="link_error", target="A6.beta", delta_deg=-0.02)],
    [dict(effect="base_tilt", x_rad_per_nm=3e-8, y_rad_per_nm=1e-7)],
    [dict(effect="thermal_growth", target="A2.a", per_hour_mm=40), dict(effect="thermal_growth", target="A4.d", per_k_mm=0.01),
     dict(effect="thermal_growth", joint="A1", per_hour_deg=1.5, tau_s=6)],
    [dict(effect="tracker_scale", scale_ppm=60)],
    [dict(effect="tracker_frame", x_um=40, y_um=-20, rz_urad=30, t_s=7.5), dict(effect="tracker_frame", z_um=50, t_s=3, over_s=9)],
    [dict(effect="empirical", joint="A2", over="position", knots=[[-62, 0.001], [-56, -0.002], [-50, 0.003], [-42, 0]])],
    [dict(effect="empirical", joint="A1", over="position", times="direction", knots=[[10, 0.001], [20, 0.003], [32, 0.002]])],
    [dict(effect="empirical", joint="A4", over="speed", knots=[[-20, 0.003], [-5, -0.002], [6, 0.004], [20, -0.001]]),
     dict(effect="empirical", joint="A6", over="time", knots=[[0, 0], [6, 0.004], [13, -0.003], [20, 0.001]])],
    [dict(effect="empirical", joint="A3", over="torque", knots=[[-80, 0.002], [0, 0], [90, 0.004]]),
     dict(effect="empirical", joint="A5", over="direction", knots=[[-1, 0.002], [1, -0.003]])],
    [dict(effect="empirical", target="tcp", over="time", knots=[[0, 0, 0, 0], [8, 0.03, -0.02, 0.01], [20, 0.01, 0.05, -0.02]]),
     dict(effect="empirical", target="tcp", over="position", of="A1", knots=[[10, 0, 0.01, 0], [22, 0.02, 0, 0.03], [34, 0, 0, 0]])],
]
SLIDE_MORE = [
    [dict(effect="stiction", joint="S", spike_mm=0.04, rise_mm=0.5, decay_s=0.9)],
    [dict(effect="hysteresis", joint="S", elements=[[0.02, 0.5], [0.03, 3.0]])],
    [dict(effect="transmission_error", joint="S", amplitude_mm=0.02, cycles_per_rev=0.5, phase_deg=10, fade_mm_s=40)],
    [dict(effect="bearing_wobble", joint="S", amplitude_deg=0.004, cycles_per_rev=0.05, phase_deg=30, direction=[1, 1, 0])],
    [dict(effect="bearing_wobble", joint="J3", amplitude_deg=0.004, cycles_per_rev=3, phase_deg=30, direction=[1, 0, 0])],
    [dict(effect="thermal_growth", target="J2b.a", per_hour_mm=30, tau_s=20), dict(effect="thermal_growth", target="J3.d", per_hour_mm=20)],
    [dict(effect="gravity_compliance", joint="J2", moments=[["J2", 0.01, 0.003], ["J3", 0.004, -0.002]])],
    [dict(effect="link_error", target="J2b.beta", delta_deg=0.03)],
    [dict(effect="coupled_play", target="J3<-J2", half_gap_deg=0.01, ratio=-1)],
    [dict(effect="base_tilt", x_rad_per_nm=1e-7, y_rad_per_nm=0)],
]
REGISTERED = [
    [dict(effect="tracker_scale", scale_ppm=-45)],
    [dict(effect="tracker_refraction", gradient_k_per_m=-0.8)],
    [dict(effect="tracker_frame", x_um=40, ry_urad=-25, at_row=150)],
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
    for which, groups in (("arm", ARM + ARM_MORE), ("slide", SLIDE + SLIDE_MORE), ("arm", REGISTERED)):
        STATION["on"] = groups is REGISTERED
        robot = Robot(f"{which}.yaml")
        p = commands(robot, which, t)
        payload = 25.0 if which == "arm" else 0.0
        head = ["t_s"] + [f"cmd_{n}_{'mm' if robot.si(n) == 1e-3 else 'deg'}" for n in robot.names]
        more = ["payload_kg", "temp_c"] + [f"torque_{n}_nm" for n in robot.names] + ["fx_n", "fy_n", "fz_n"] if payload else []
        lines = [",".join(head + more)]
        for r in all_rows:
            logged = ["25", "%.9f" % logged_temperature(t[r])] + ["%.6f" % logged_torque(t[r], n) for n in robot.names if payload] + ["%.6f" % f for f in logged_force(t[r])]
            lines.append(",".join(["%.3f" % t[r]] + decimals(robot, p[:, r]) + (logged if payload else [])))
        (OUT / f"{which}_log.csv").write_text("\n".join(lines) + "\n")
        for effects in groups:
            clock = [e for e in effects if e["effect"] == "time_offset"]
            offset = sum(e.get("offset_s", 0) for e in clock)
            drift = sum(e.get("drift_ppm", 0) for e in clock) * 1e-6
            shift = np.round((offset + drift * (t[all_rows] - t[all_rows[0]])) / DT).astype(int)
            # vibration and drift count from the first row
            preload = {"A2": 1} if effects[0]["effect"] in ("backlash", "hysteresis") and which == "arm" else {}
            # the fine run starts with the log: the start at rest belongs to the first row
            points = run(robot, t, p, effects, preload, payload, rows=all_rows, shift_steps=shift)
            if STATION["on"]:
                points = points @ STATION["r"].T + STATION["t"]
            cases.append(dict(name=name_of(effects), robot=f"{which}.yaml", input=f"{which}_log.csv", effects=effects,
                              preload=preload, rows=kept, xyz_mm=(points[kept] * 1000).round(6).tolist(),
                              **(dict(registration=REGISTRATION) if STATION["on"] else {})))
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
