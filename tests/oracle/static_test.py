#!/usr/bin/env python3
"""The static test of samples/static worked out with numpy and scipy alone: static_test.py > static_test.json.

Nothing is shared with the crate: the arm is a product of rotations about fixed axes (not DH), registration by singular values,
the joint's deviation by a difference quotient. `truth_deg` is what the simulator put in: PCHIP between knots, from scipy.
Columns trigger and cycle mark dwells and repeats.
"""
import json
import pathlib
import numpy as np
import pandas as pd
from scipy import stats
from scipy.interpolate import PchipInterpolator

HERE = pathlib.Path(__file__).resolve().parent
JOINTS = ["A1", "A2", "A3", "A4", "A5", "A6"]
AXES = [(0, 0, -1), (0, 1, 0), (0, 1, 0), (-1, 0, 0), (0, 1, 0), (-1, 0, 0)]
POINTS = [(0, 0, 0), (350, 0, 675), (1500, 0, 675), (2500, 0, 634), (2500, 0, 634), (2500, 0, 634)]
TCP0 = (2778.0, 0.0, 478.0)
GAPS = {"A1": 0.0028, "A3": 0.0022, "A4": 0.0061, "A6": 0.0060,
        "A2": [(-110, 0.0042), (-70, 0.0022), (-45, 0.0038), (-10, 0.0050), (10, 0.0046)],
        "A5": [(-90, 0.0094), (-50, 0.0055), (0, 0.0034), (40, 0.0011), (65, 0.0042), (90, 0.0094)]}


def forward(deg):
    q = np.radians(np.atleast_2d(deg))
    p = np.tile(np.array(TCP0), (len(q), 1))
    for j in range(5, -1, -1):
        ax, o = np.array(AXES[j], float), np.array(POINTS[j], float)
        v, c, s = p - o, np.cos(q[:, j])[:, None], np.sin(q[:, j])[:, None]
        p = v * c + np.cross(ax, v) * s + ax * (v @ ax)[:, None] * (1 - c) + o
    return p


def truth(joint, at):
    g = GAPS[joint]
    if isinstance(g, float):
        return np.full(len(at), g)
    k = np.array(g)
    return PchipInterpolator(k[:, 0], k[:, 1])(np.clip(at, k[0, 0], k[-1, 0]))


cmd = [f"cmd_{j}_deg" for j in JOINTS]
dwells = {}
for j in JOINTS:
    d = pd.read_csv(HERE / f"../../samples/static/single_axis_{j}.csv.gz", comment="#")
    d = d[d.trigger != 0]
    d[cmd] = d[cmd].round(4)
    dwells[j] = d.groupby(cmd + ["cycle", "trigger"], as_index=False)[["x_mm", "y_mm", "z_mm"]].mean()
place = pd.concat(dwells).groupby(cmd, as_index=False)[["x_mm", "y_mm", "z_mm"]].mean()
src, dst = place[["x_mm", "y_mm", "z_mm"]].to_numpy(), forward(place[cmd].to_numpy())
u, _, w = np.linalg.svd((src - src.mean(0)).T @ (dst - dst.mean(0)))
r = w.T @ np.diag([1, 1, np.sign(np.linalg.det(w.T @ u.T))]) @ u.T
t = dst.mean(0) - r @ src.mean(0)
out = {}
for k, j in enumerate(JOINTS):
    d = dwells[j]
    q, p = d[cmd].to_numpy(), d[["x_mm", "y_mm", "z_mm"]].to_numpy() @ r.T + t
    h = np.eye(6)[k] * 0.01
    column = (forward(q + h) - forward(q - h)) / 0.02
    d["e"] = ((p - forward(q)) * column).sum(1) / (column ** 2).sum(1)
    table = d.pivot_table(index=cmd[k], columns=["trigger", "cycle"], values="e")
    b = (table[-1].to_numpy() - table[1].to_numpy()) / 2
    x, y = table.index.to_numpy(float), b.mean(1)
    n, reps = b.shape
    nu = n * (reps - 1)
    s2 = ((b - y[:, None]) ** 2).sum() / nu
    v = 2 * (x - x[0]) / (x[-1] - x[0]) - 1
    basis = np.linalg.qr(np.stack([np.ones(n), v, v * v], 1))[0]
    p_any = stats.f.sf(reps * ((y - y.mean()) ** 2).sum() / (n - 1) / s2, n - 1, nu)
    p_quad = stats.f.sf(reps * ((basis[:, 1:].T @ y) ** 2).sum() / 2 / s2, 2, nu)
    degrees = [np.linalg.lstsq(np.polynomial.legendre.legvander(v, d), y, rcond=None)[0] for d in range(min(9, n - 3) + 1)]
    left = [((y - np.polynomial.legendre.legvander(v, d) @ c) ** 2).sum() for d, c in enumerate(degrees)]
    out[j] = {"at_deg": x.tolist(), "truth_deg": truth(j, x).tolist(), "half_gap_deg": y.tolist(), "sigma_deg": float(np.sqrt(s2)), "dof": nu,
              "half_width_deg": float(stats.t.ppf(0.975, nu) * np.sqrt(s2 / reps)), "p_any_shape": float(p_any), "p_slope_and_bow": float(p_quad),
              "lack_of_fit_p": [float(stats.f.sf(reps * w / (n - d - 1) / s2, n - d - 1, nu)) for d, w in enumerate(left)]}
print(json.dumps(out, indent=0))
