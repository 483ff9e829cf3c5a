"""Two plays in series on ball screw joints, stepped in time: the independent truth for `identify screw`.

    python3 tests/oracle/screw.py        # writes the sample, the test logs and screw.json again, the same bytes

Own code throughout (numpy only): motor -> coupling -> screw -> nut -> carriage, 1 ms steps, each play by equation 2 of
Gantry (2015): y = m (u - c_l) while u <= v_l = y/m + c_l, y = m (u - c_r) while u >= v_r = y/m + c_r, else y stays.

The seed prints total gaps (coupling 1.8 deg = 0.05 mm at a 10 mm lead, nut 0.1825 mm) and says that the "very large fluctuations"
of its figures 8 and 9 are noise and vibration, without a number. Assumed here: white noise of 0.1 deg on both angles and 30 um on
the carriage, and a carriage that swings by 60 um at 12.3 Hz and 25 um at 31 Hz: fluctuations as large as the gap itself.
"""

import gzip
import json
import math
import os

import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
DATA = os.path.join(HERE, "..", "data", "screw")
SAMPLES = os.path.join(HERE, "..", "..", "samples", "screw")
LEAD = 10.0
DEG = 360.0 / LEAD  # degrees of screw per mm
STEP = 1e-3


def play(u, c_l, c_r, m=1.0, start=None):
    """Equation 2, sample by sample; `start` is the output before the first sample (default: middle of the gap)."""
    y = m * (u[0] - 0.5 * (c_l + c_r)) if start is None else start
    out = np.empty(len(u))
    for i, x in enumerate(u):
        if x <= y / m + c_l:
            y = m * (x - c_l)
        elif x >= y / m + c_r:
            y = m * (x - c_r)
        out[i] = y
    return out


def motion(points, speed, ramp=0.1, dwell=0.0):
    """Rest-to-rest moves with trapezoidal speed between points (lists of joint values), a dwell at each."""
    q = [np.array(points[0], float)]
    for a, b in zip(points[:-1], points[1:]):
        a, b = np.array(a, float), np.array(b, float)
        way = np.abs(b - a).max()
        t_ramp = min(ramp, math.sqrt(way * ramp / speed))
        top = speed * t_ramp / ramp
        total = way / top + t_ramp
        t = np.arange(1, int(round(total / STEP)) + 1) * STEP
        up = 0.5 * (top / t_ramp) * np.minimum(t, t_ramp) ** 2
        flat = top * np.clip(t - t_ramp, 0, total - 2 * t_ramp)
        late = np.clip(t - (total - t_ramp), 0, t_ramp)
        s = np.clip((up + flat + top * late - 0.5 * (top / t_ramp) * late**2) / way, 0, 1)
        s[-1] = 1.0
        q.extend(a + (b - a) * x for x in s)
        q.extend([b] * int(round(dwell / STEP)))
    return np.array(q)


def lagged(p, lag):
    if lag == 0:
        return p
    # backward Euler: a ramp is followed at exactly this lag
    out, y, k = np.empty(len(p)), p[0], STEP / (lag + STEP)
    for i, x in enumerate(p):
        y += k * (x - y)
        out[i] = y
    return out


def write(path, columns, comment):
    names = list(columns)
    rows = zip(*[[f"{v:.{d}f}" for v in values] for values, d in columns.values()])
    text = "".join("# " + line + "\n" for line in comment) + ",".join(names) + "\n" + "".join(",".join(r) + "\n" for r in rows)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "wb") as f, gzip.GzipFile("", "wb", 9, f, mtime=0) as z:
        z.write(text.encode())


def chain(p, case):
    """Motor, screw and carriage of one joint, mm at the joint's scale, at the steps."""
    motor = lagged(p, case.get("lag_s", 0.0))
    screw = play(motor, *case["coupling_mm"], case.get("m_coupling", 1.0))
    return motor, screw, play(screw, *case["nut_mm"], case.get("m_nut", 1.0))


def shaken(y, t, rng, case):
    white, swings = case.get("white_mm", 0.030), case.get("swings", [(0.060, 12.3), (0.025, 31.0)])
    y = y + rng.normal(0, white, len(y)) if white else y.copy()
    for amplitude, hz in swings:
        # a machine's swing keeps neither phase nor size
        phase = rng.uniform(0, 2 * math.pi) + np.cumsum(rng.normal(0, 0.15, len(t)))
        y = y + amplitude * np.sin(2 * math.pi * hz * t + phase)
    return y


PAPER = {"coupling_mm": [-0.025, 0.025], "nut_mm": [-0.09125, 0.09125]}
# figure 4: to the zero reference, back after the start of the test, then up to it: the gap lies to the other side
FIGURE_4 = [[-190.0], [-205.0], [-200.0]] + [[-100.0], [-200.0]] * 4


def single(name, case, points=FIGURE_4, speed=10.0, hz=50, dwell=0.4, sensors=("enc", "screw", "meas"), seed=3, angle=0.1, folder=DATA, skip=0.0):
    """Joint Z alone; X and Y stand."""
    rng = np.random.default_rng(seed)
    p = motion(points, speed, dwell=dwell)[:, 0]
    motor, screw, carriage = chain(p, case)
    keep = slice(int(round(skip / STEP)), None, int(round(1 / hz / STEP)))
    p, motor, screw, carriage = p[keep], motor[keep], screw[keep], carriage[keep]
    t = np.arange(len(p)) / hz
    columns = {"t_s": (t, 2), "cmd_X_mm": (500 + 0 * p, 0), "cmd_Y_mm": (400 + 0 * p, 0), "cmd_Z_mm": (p, 4)}
    noisy = lambda v: v * DEG + (rng.normal(0, angle, len(v)) if angle else 0)
    if "enc" in sensors:
        columns["enc_Z_deg"] = (noisy(motor), 3)
    if "screw" in sensors:
        columns["screw_Z_deg"] = (noisy(screw), 3)
    measured = shaken(carriage, t, rng, case)
    if "meas" in sensors:
        columns["meas_Z_mm"] = (measured, 4)
    if "z" in sensors:
        columns["z_mm"] = (1234.5 - measured, 4)
    write(os.path.join(folder, name + ".csv.gz"), columns, ["simulated by tests/oracle/screw.py: " + name])
    return dict(case, rows=len(t))


def gantry(name, cases, seed=5, noise=0.011, hz=50):
    """All three joints: one after another, then together, under a tracker in a frame of its own."""
    rng = np.random.default_rng(seed)
    home = [500.0, 400.0, -200.0]
    points = [home]
    for axis, way in [(0, 80.0), (1, 60.0), (2, 50.0)]:
        near, far = list(home), list(home)
        near[axis] -= 3.0
        far[axis] += way
        points += [near, home] + [far, home] * 3
    points += [[540.0, 440.0, -160.0], [500.0, 440.0, -160.0], home, [540.0, 400.0, -160.0], home]
    p = motion(points, 10.0, dwell=0.2)
    carriage = np.stack([chain(p[:, k], c)[2] for k, c in enumerate(cases)], axis=1)
    keep = slice(None, None, int(round(1 / hz / STEP)))
    p, carriage = p[keep], carriage[keep]
    t = np.arange(len(p)) / hz
    a, b, c = np.radians([12.0, -7.0, 143.0])
    turn = (
        np.array([[math.cos(c), -math.sin(c), 0], [math.sin(c), math.cos(c), 0], [0, 0, 1]])
        @ np.array([[math.cos(b), 0, math.sin(b)], [0, 1, 0], [-math.sin(b), 0, math.cos(b)]])
        @ np.array([[1, 0, 0], [0, math.cos(a), -math.sin(a)], [0, math.sin(a), math.cos(a)]])
    )
    # joints are not quite square to each other: 0.2 mrad
    square = np.array([[1, 2e-4, 0], [0, 1, -1e-4], [0, 0, 1]])
    tcp = carriage @ square.T @ turn.T + np.array([2650.0, 1890.0, -640.0]) + rng.normal(0, noise, (len(t), 3))
    columns = {"t_s": (t, 2)}
    for k, joint in enumerate("XYZ"):
        columns[f"cmd_{joint}_mm"] = (p[:, k], 4)
    for k, axis in enumerate("xyz"):
        columns[f"{axis}_mm"] = (tcp[:, k], 4)
    write(os.path.join(DATA, name + ".csv.gz"), columns, ["simulated by tests/oracle/screw.py: " + name])
    return {"joints": dict(zip("XYZ", cases)), "rows": len(t)}


def main():
    clean = {"white_mm": 0, "swings": []}
    truth = {
        "sample": single("gantry2015_z", PAPER, folder=SAMPLES),
        "clean": single("clean", {**PAPER, **clean}, angle=0, hz=25),
        "asymmetric": single(
            "asymmetric", {"coupling_mm": [-0.040, 0.010], "nut_mm": [-0.1425, 0.040], "m_nut": 1.004}, seed=7
        ),
        "no_screw": single("no_screw", PAPER, sensors=("enc", "meas"), seed=8),
        "lone_z": single("lone_z", PAPER, sensors=("z",), seed=9),
        "servo_lag": single("servo_lag", {**PAPER, "lag_s": 0.03}, sensors=("meas",), seed=10),
        "one_cycle": single("one_cycle", PAPER, points=[[-200.0], [-100.0], [-200.0]], seed=11),
        "short": single("short", PAPER, points=[[-200.0]] + [[-199.85], [-200.0]] * 6, speed=0.2, hz=20, seed=12),
        "little_more": single(
            "little_more", {**PAPER, "white_mm": 0.003, "swings": []}, points=[[-200.0]] + [[-199.6], [-200.0]] * 6, speed=0.2, hz=20, seed=13
        ),
        "gantry": gantry(
            "gantry_tracker",
            [
                {"coupling_mm": [-0.025, 0.025], "nut_mm": [-0.09125, 0.09125]},
                {"coupling_mm": [-0.010, 0.010], "nut_mm": [-0.030, 0.030]},
                {"coupling_mm": [-0.005, 0.005], "nut_mm": [-0.0125, 0.0125], "m_nut": 1.0005},
            ],
        ),
    }
    with open(os.path.join(HERE, "screw.json"), "w") as f:
        json.dump(truth, f, indent=1)
        f.write("\n")


main()
