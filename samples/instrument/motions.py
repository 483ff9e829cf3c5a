#!/usr/bin/env python3
"""The three motions of Cursi (2022) (Table I) as programs for the simulated instrument: growing_sine.csv, exponential.csv, random.csv.

  python3 samples/instrument/motions.py

Each joint moves alone for T = 500 s (Cursi (2022), section III-A), one after the other; the paper samples at 0.2 s, here a point stands every
0.4 s (corners of the programs are where joints turn). Assumed, as the paper prints neither: amplitude 40 deg, period 20 s (8 to 20 s
at random), time constant of the exponential T/3. Needs numpy.
"""
import pathlib
import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
JOINTS = ["e1", "e2", "pitch", "yaw"]
T, STEP, AMPLITUDE, PERIOD = 500.0, 0.4, 40.0, 20.0
t = np.arange(0, T + STEP / 2, STEP)
sine = np.sin(2 * np.pi * t / PERIOD)


def growing(_):
    return AMPLITUDE * t / T * sine


def exponential(_):
    tau = T / 3
    return AMPLITUDE * np.expm1(t / tau) / np.expm1(T / tau) * sine


def random(seed):
    """From one random angle to the next, with the ease of a cosine, within the amplitude."""
    rng = np.random.default_rng(2000 + seed)
    out, at, now = np.zeros_like(t), 0.0, 0.0
    side = 1.0
    while at < T - STEP:
        # a random target on the other side of where the joint stands
        target = rng.uniform(now, AMPLITUDE) if side > 0 else rng.uniform(-AMPLITUDE, now)
        duration = STEP * round(rng.uniform(4.0, 10.0) / STEP)
        k = (t > at + 1e-9) & (t <= at + duration + 1e-9)
        out[k] = now + (target - now) * 0.5 * (1 - np.cos(np.pi * (t[k] - at) / duration))
        at, now, side = at + duration, target, -side
    return out


for name, motion in [("growing_sine", growing), ("exponential", exponential), ("random", random)]:
    lines = ["t_s," + ",".join(f"{j}_deg" for j in JOINTS)]
    for j in range(4):
        p = motion(j)
        # back to zero within 4 s, so that the next joint moves alone
        p = np.concatenate([p, p[-1] * 0.5 * (1 + np.cos(np.pi * np.arange(1, 11) / 10))])
        for i, v in enumerate(p):
            row = ["0"] * 4
            row[j] = f"{v:.4f}".rstrip("0").rstrip(".").replace("-0", "0") if abs(v) < 5e-5 else f"{v:.4f}"
            lines.append(f"{j * (T + 10 * STEP + STEP) + i * STEP:.1f}," + ",".join(row))
    (HERE / f"{name}.csv").write_text("\n".join(lines) + "\n")
