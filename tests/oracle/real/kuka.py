#!/usr/bin/env python3
"""KUKA KR 300, motor and link-side encoders: what a diagnosis of joint signals should find, and in which order.

    python3 tests/oracle/real/kuka.py FOLDER      # the folder of the data sets, or LOSTMOTION_REAL_DATA

Reads kuka-kr300-dual-encoder/trajectory_{A,B}.csv. For joints 1 to 3, link side minus motor side (the gear and what is behind it):
  1. the README's regression on 1, sign(v), v, torque, q, q^2 for |v| > 0.5 deg/s;
  2. the generic way: all rows of a joint at once, an autoregressive noise model of order `AR` fitted to the residual, forward selection
     of one effect at a time over the catalogue in its linear form; the cyclic term's frequency by a scan.
Everything printed is computed here from the files.
"""
import os
import sys

import numpy as np
from scipy import stats

AR = 8


def folder():
    given = sys.argv[1] if len(sys.argv) > 1 else os.environ.get("LOSTMOTION_REAL_DATA", "../shared/data/real")
    return os.path.join(given, "kuka-kr300-dual-encoder")


def load(name):
    path = os.path.join(folder(), name)
    with open(path) as f:
        head = f.readline().strip().split(",")
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    return {h: table[:, i] for i, h in enumerate(head)}


def readme(d, j):
    """The README's regression; returns delay in s, half offset in deg, residual sd."""
    q, v = d[f"j{j}_mot_deg"], d[f"j{j}_mot_dps"]
    y = d[f"j{j}_se_deg"] - q
    m = np.abs(v) > 0.5
    a = np.column_stack([np.ones_like(q), np.sign(v), v, d[f"j{j}_tau_nm"], q, q * q])[m]
    x, *_ = np.linalg.lstsq(a, y[m], rcond=None)
    r = y[m] - a @ x
    return -x[2], x[1], r.std(), q[m], r


def play(p, b):
    """Output of a play of half gap b, started in the middle."""
    out = np.empty_like(p)
    x = p[0]
    for i, c in enumerate(p):
        x = min(max(x, c - b), c + b)
        out[i] = x
    return out - p


def direction(p, least=1e-4):
    """Sign of the last movement, 0 before the first; movements below `least` deg are none."""
    s, extreme, out = 0, p[0], np.empty_like(p)
    for i, c in enumerate(p):
        if s == 0:
            if abs(c - extreme) > least:
                s, extreme = (1 if c > extreme else -1), c
        elif (c - extreme) * s >= 0:
            extreme = c
        elif abs(c - extreme) > least:
            s, extreme = -s, c
        out[i] = s
    return out


def ar_fit(r, order=AR):
    """Yule-Walker coefficients of the residual."""
    r = r - r.mean()
    c = np.array([np.dot(r[: len(r) - k], r[k:]) for k in range(order + 1)]) / len(r)
    t = np.array([[c[abs(i - k)] for k in range(order)] for i in range(order)])
    return np.linalg.solve(t + 1e-9 * c[0] * np.eye(order), c[1:])


def whiten(x, phi):
    y = x.copy()
    for k, f in enumerate(phi, 1):
        y[k:] = y[k:] - f * x[: len(x) - k]
    return y[len(phi):]


def gls(a, y, phi):
    aw = np.column_stack([whiten(c, phi) for c in a.T])
    yw = whiten(y, phi)
    x, *_ = np.linalg.lstsq(aw, yw, rcond=None)
    r = yw - aw @ x
    s2 = r @ r / (len(yw) - a.shape[1])
    cov = s2 * np.linalg.pinv(aw.T @ aw)
    return x, np.sqrt(np.diag(cov)), r @ r, len(yw)


def iterated(a, y, rounds=4):
    x, *_ = np.linalg.lstsq(a, y, rcond=None)
    for _ in range(rounds):
        phi = ar_fit(y - a @ x)
        x, se, rss, n = gls(a, y, phi)
    return x, se, rss, n, phi


def main():
    data = {k: load(f"trajectory_{k}.csv") for k in "AB"}
    print("README regression: delay ms, sign(v) deg, sd deg; cyclic period deg, amplitude deg, sd after")
    for k, d in data.items():
        for j in (1, 2, 3):
            delay, half, sd, q, r = readme(d, j)
            periods = np.linspace(0.2, 3.0, 6000)
            best = (0.0,)
            for w in 2 * np.pi / periods:
                c = np.column_stack([np.sin(w * q), np.cos(w * q)])
                x, *_ = np.linalg.lstsq(c, r, rcond=None)
                amp = np.hypot(*x)
                if amp > best[0]:
                    best = (amp, 2 * np.pi / w, (r - c @ x).std())
            print(f"  {k} J{j}: {delay * 1e3:5.2f} ms {half:8.4f} {sd:.4f}   {best[1]:.4f} {best[0]:.4f} {best[2]:.4f}")
    print("rest at the start, se - mot and mot - ref, se - ref (deg, first 50 ms)")
    for k, d in data.items():
        rest = lambda a, b: [f"{np.mean((d[f'j{j}_{a}_deg'] - d[f'j{j}_{b}_deg'])[:12]):.4f}" for j in (1, 2, 3)]
        print(" ", k, rest("se", "mot"), rest("mot", "ref"), rest("se", "ref"))
    print("motor against reference: lag of mot behind ref (regression on v, a of ref), rms before and after, deg")
    for k, d in data.items():
        for j in range(1, 7):
            q, v = d[f"j{j}_ref_deg"], d[f"j{j}_ref_dps"]
            y = d[f"j{j}_mot_deg"] - q
            a = np.column_stack([np.ones_like(q), v])
            x, *_ = np.linalg.lstsq(a, y, rcond=None)
            a2 = np.column_stack([a, np.gradient(v, d["t_s"])])
            x2, *_ = np.linalg.lstsq(a2, y, rcond=None)
            print(f"  {k} J{j}: {-x[1] * 1e3:6.2f} ms  {y.std():.4f} {(y - a @ x).std():.4f} with acceleration {-x2[1]*1e3:.2f} ms, {x2[2]*1e6:.0f} ms2 {(y - a2 @ x2).std():.4f}  travel {np.ptp(q):.2f}")
    print("whole log, link minus motor, GLS AR(%d), forward selection" % AR)
    for k, d in data.items():
        for j in (1, 2, 3):
            forward(k, d, j)


def forward(k, d, j):
    q, t, tau = d[f"j{j}_mot_deg"], d["t_s"], d[f"j{j}_tau_nm"]
    y = d[f"j{j}_se_deg"] - q
    v = np.gradient(q, t)
    # lag through the discrete first-order filter; delay: shift of the motor signal
    cols = {
        "delay (d/dt mot)": [v],
        "scale": [q],
        "direction": [direction(q)],
        "coulomb-like torque": [tau],
        "acceleration": [np.gradient(v, t)],
    }
    for b in (0.0005, 0.001, 0.002, 0.004):
        cols[f"play {b}"] = [play(q, b)]
    have = [np.ones_like(q)]
    names = ["offset"]
    for step in range(5):
        a = np.column_stack(have)
        x, se, rss, n, phi = iterated(a, y)
        if step:
            # all periods from 0.15 to 10 deg
            best = (0,)
            r = y - a @ x
            for w in 2 * np.pi / np.geomspace(0.15, 10, 2500):
                c = np.column_stack([have[i] for i in range(len(have))] + [np.sin(w * q), np.cos(w * q)])
                xx, ss, rs, _ = gls(c, y, phi)
                if rss - rs > best[0]:
                    best = (rss - rs, w)
            if best[0] > 0:
                cols[f"cyclic {2 * np.pi / best[1]:.4f}"] = [np.sin(best[1] * q), np.cos(best[1] * q)]
        rows = []
        for name, c in cols.items():
            if name in names:
                continue
            aa = np.column_stack(have + c)
            xx, ss, rs, n = gls(aa, y, phi)
            m = len(c)
            f = (rss - rs) / m / (rs / (n - aa.shape[1]))
            rows.append((f, name, xx[-m:], ss[-m:], (y - aa @ xx).std()))
        rows.sort(key=lambda r: -r[0])
        print(f"  {k} J{j} step {step}: sd {(y - a @ x).std():.5f} ar1 {phi[0]:.2f} white sd {np.sqrt(rss / n):.5f}; " +
              "; ".join(f"{r[1]} F {r[0]:.0f} {np.round(r[2], 5)} se {np.round(r[3], 5)} -> {r[4]:.5f}" for r in rows[:4]))
        f, name, *_ = rows[0]
        if stats.f.sf(f, len(cols[name]), n) > 1e-4:
            break
        have += cols[name]
        names.append(name)
        cols = {k2: c2 for k2, c2 in cols.items() if not k2.startswith("cyclic") or k2 in names}


if __name__ == "__main__":
    main()
