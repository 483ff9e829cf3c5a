#!/usr/bin/env python3
"""Recordings of a controller and a tracker, each by its own clock, for `join`; simulated, with the truth.

  join.py FOLDER --first SEED --count N [--tracker-hz 250] [--controller-hz 50] [--seconds 40]

writes controller_<seed>.csv, tracker_<seed>.csv and truth_<seed>.json (controller's time = offset_s + rate * tracker's time).

The arm is a KUKA KR 120 R2500 PRO as a product of rotations about fixed axes; nothing is shared with lostmotion. Every joint has a gap
that drags behind its command, the tracker an unknown frame and noise of 11 um, the reflector stands 3 mm off. Clocks differ by up
to 30 s and 20 ppm. Even seeds sample late by 2 ms (standard deviation) and stamp rightly; odd seeds sample
regularly and stamp by 2 ms wrongly. Needs numpy.
"""
import argparse, json, pathlib
import numpy as np

AXES = np.array([(0, 0, -1), (0, 1, 0), (0, 1, 0), (-1, 0, 0), (0, 1, 0), (-1, 0, 0)], float)
POINTS = np.array([(0, 0, 0), (350, 0, 675), (1500, 0, 675), (2500, 0, 634), (2500, 0, 634), (2500, 0, 634)], float)
TCP0 = np.array([2500.0 + 215.0 + 63.0, 0.0, 634.0 - 156.0])
HOME = np.array([20.0, -60.0, 80.0, 10.0, 40.0, -20.0])
FINE_HZ, JITTER_S, NOISE_MM = 2000, 0.002, 0.011


def forward(deg, tcp):
    q = np.radians(deg)
    p = np.tile(tcp, (len(q), 1))
    for j in range(5, -1, -1):
        v = p - POINTS[j]
        c, s = np.cos(q[:, j])[:, None], np.sin(q[:, j])[:, None]
        p = v * c + np.cross(AXES[j], v) * s + AXES[j] * (v @ AXES[j])[:, None] * (1 - c) + POINTS[j]
    return p


def play(q, half):
    """What a joint with a gap does: it stays until its command has crossed the gap."""
    out = np.empty_like(q)
    at = q[0]
    for i, v in enumerate(q):
        at = min(max(at, v - half), v + half)
        out[i] = at
    return out


def rotation(rng):
    m, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return m * np.sign(np.linalg.det(m))


def write(path, header, rows):
    np.savetxt(path, rows, delimiter=",", header=header, comments="", fmt="%.7f")


def one(folder, seed, tracker_hz, controller_hz, seconds):
    rng = np.random.default_rng(seed)
    grid = np.arange(0, seconds, 1 / FINE_HZ)
    motion = [[(rng.uniform(2, 9), rng.uniform(0.04, 0.35), rng.uniform(0, 2 * np.pi)) for _ in range(3)] for _ in range(6)]

    def command(t):
        return np.stack([h + sum(a * np.sin(2 * np.pi * f * t + p) for a, f, p in joint) for h, joint in zip(HOME, motion)], 1)

    cmd = command(grid)
    real = np.stack([play(cmd[:, j], rng.uniform(0.001, 0.006)) for j in range(6)], 1)
    tcp = forward(real, TCP0 + rng.normal(size=3) * 3)

    def sampled(hz, begin, end):
        """True instants of the samples, and what their stamps say, both by the true clock."""
        even = np.arange(begin, end, 1 / hz)
        late = rng.normal(size=len(even)) * JITTER_S
        if seed % 2 == 0:
            even = even + np.clip(late, -0.45 / hz, 0.45 / hz)
            return even, even
        return even, even + late

    at, stamp = sampled(controller_hz, 0.1, seconds - rng.uniform(0.2, 4))
    offset, rate = rng.uniform(-30, 30), 1 + rng.uniform(-20e-6, 20e-6)
    q = np.round(command(at), 6)
    write(folder / f"controller_{seed}.csv", "t_s," + ",".join(f"cmd_A{j + 1}_deg" for j in range(6)), np.column_stack([stamp, q]))
    at, stamp = sampled(tracker_hz, rng.uniform(0.1, 4), seconds - 0.1)
    p = np.stack([np.interp(at, grid, tcp[:, k]) for k in range(3)], 1) @ rotation(rng).T + rng.uniform(-3000, 3000, 3)
    p = np.round(p + rng.normal(size=p.shape) * NOISE_MM, 4)
    write(folder / f"tracker_{seed}.csv", "t_s,x_mm,y_mm,z_mm", np.column_stack([(stamp - offset) / rate, p]))
    (folder / f"truth_{seed}.json").write_text(json.dumps({"offset_s": offset, "rate": rate}))


if __name__ == "__main__":
    a = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    a.add_argument("folder", type=pathlib.Path)
    a.add_argument("--first", type=int, default=1)
    a.add_argument("--count", type=int, default=1)
    a.add_argument("--tracker-hz", type=float, default=250)
    a.add_argument("--controller-hz", type=float, default=50)
    a.add_argument("--seconds", type=float, default=40)
    a = a.parse_args()
    a.folder.mkdir(parents=True, exist_ok=True)
    for seed in range(a.first, a.first + a.count):
        one(a.folder, seed, a.tracker_hz, a.controller_hz, a.seconds)
