"""Calibration of a serial arm from settled poses, for the scripts of the tracker sets (numpy and scipy only).

Model: standard DH; free are the base frame (6), one point in the flange per reflector (3 each) and any of the DH parameters. Points
are compared in the tracker frame. Gross poses are left out by their 3D residual. `identifiable` names what a log can tell.
"""
import csv
import os
import sys

import numpy as np
from scipy.optimize import least_squares


def folder(name):
    given = sys.argv[1] if len(sys.argv) > 1 else os.environ.get("LOSTMOTION_REAL_DATA", "../shared/data/real")
    return os.path.join(given, name)


def table(path, delimiter=",", comma=False):
    with open(path, encoding="utf-8-sig") as f:
        rows = list(csv.reader(f, delimiter=delimiter))
    number = lambda s: float(s.replace(",", ".") if comma else s) if s.strip() else np.nan
    return {h.strip(): np.array([number(r[i]) for r in rows[1:]]) for i, h in enumerate(rows[0])}


def rot(v):
    """Rotation matrix of a rotation vector."""
    a = np.linalg.norm(v)
    if a < 1e-15:
        return np.eye(3)
    k = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]]) / a
    return np.eye(3) + np.sin(a) * k + (1 - np.cos(a)) * k @ k


def frames(dh, q):
    """Transforms base -> after joint k, (6 + 1) x n x 4 x 4; dh rows: theta0, d, a, alpha (rad, mm); q: n x 6 rad."""
    n = len(q)
    out = [np.broadcast_to(np.eye(4), (n, 4, 4)).copy()]
    for k, (t0, d, a, al) in enumerate(dh):
        c, s, ca, sa = np.cos(q[:, k] + t0), np.sin(q[:, k] + t0), np.cos(al), np.sin(al)
        m = np.zeros((n, 4, 4))
        m[:, 0, 0], m[:, 0, 1], m[:, 0, 2], m[:, 0, 3] = c, -s * ca, s * sa, a * c
        m[:, 1, 0], m[:, 1, 1], m[:, 1, 2], m[:, 1, 3] = s, c * ca, -c * sa, a * s
        m[:, 2, 1], m[:, 2, 2], m[:, 2, 3], m[:, 3, 3] = sa, ca, d, 1
        out.append(out[-1] @ m)
    return out


def kabsch(a, b):
    ma, mb = a.mean(0), b.mean(0)
    u, _, vt = np.linalg.svd((b - mb).T @ (a - ma))
    r = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    return r, mb - r @ ma


class Arm:
    """q: n x 6 rad; points: list of n x 3 mm (NaN: lost); dh as above; links: (mass, com mm) per joint or None."""

    def __init__(self, q, points, dh, links=None):
        self.q, self.points, self.dh0, self.links = q, points, np.array(dh, float), links
        self.dirs = np.sign(np.vstack([np.zeros(q.shape[1]), np.diff(q, axis=0)]))
        for j in range(q.shape[1]):  # a pause keeps the direction
            last = 0
            for i in range(len(q)):
                last = self.dirs[i, j] if abs(self.dirs[i, j]) > 0 else last
                self.dirs[i, j] = last
        self.names = [f"A{k + 1}.{p}" for k in range(len(dh)) for p in ("theta", "d", "a", "alpha")]
        self.scale = np.tile([1e-3, 1.0, 1.0, 1e-3], len(dh))  # 1 mm and 1 mrad are of one size
        self.torque = self.gravity() if links else None

    def gravity(self):
        """Gravity torque about each joint axis (Nm), positive where it turns the joint positive."""
        f = frames(self.dh0, self.q)
        out = np.zeros_like(self.q)
        for j in range(len(self.dh0)):
            z, o = f[j][:, :3, 2], f[j][:, :3, 3]
            for k in range(j, len(self.dh0)):
                m, com = self.links[k]
                c = np.einsum("nij,j->ni", f[k + 1][:, :3, :3], np.array(com)) + f[k + 1][:, :3, 3]
                out[:, j] += np.einsum("ni,ni->n", z, np.cross((c - o) * 1e-3, np.array([0, 0, -9.80665 * m])))
        return out

    def split(self, x):
        n, m = 4 * len(self.dh0), len(self.points)
        return x[:n], x[n : n + 6], x[n + 6 : n + 6 + 3 * m], x[n + 6 + 3 * m :]

    def predict(self, x, extra=()):
        """Predicted points; `extra`: list of (kind, joint) whose coefficients are at the end of x."""
        dx, base, tools, coef = self.split(x)
        dh = self.dh0 + (dx * self.scale).reshape(-1, 4)
        q = self.q.copy()
        for (kind, j), c in zip(extra, coef):
            column = {"gravity": self.torque, "direction": self.dirs}[kind][:, j]
            q[:, j] = q[:, j] + c * 1e-3 * column
        f = frames(dh, q)[-1]
        r = self.r0 @ rot(base[:3] * 1e-3)
        t = self.t0 + base[3:]
        out = []
        for k in range(len(self.points)):
            p = f[:, :3, :3] @ (self.tools0[k] + tools[3 * k : 3 * k + 3]) + f[:, :3, 3]
            out.append(p @ r.T + t)
        return out

    def residual(self, x, extra, keep):
        return np.concatenate([((m - p)[keep]).ravel() for p, m in zip(self.predict(x, extra), self.points)])

    def start(self, tools, q=None):
        """Rough tool points; the frame by Kabsch on all of them, then base and tools alone."""
        self.tools0 = [np.array(t, float) for t in tools]
        f = frames(self.dh0, self.q)[-1]
        ok = np.all([np.isfinite(p).all(1) for p in self.points], axis=0)
        a = np.vstack([(f[:, :3, :3] @ t + f[:, :3, 3])[ok] for t in self.tools0])
        self.r0, self.t0 = kabsch(a, np.vstack([p[ok] for p in self.points]))
        self.ok = ok

    def fit(self, free, extra=(), keep=None, x=None, loss="linear"):
        """Fits the named DH parameters, base, tools and the extra terms; returns x, residual (n x points x 3), jacobian."""
        n = 4 * len(self.dh0) + 6 + 3 * len(self.points) + len(extra)
        use = [i for i in range(n) if i >= 4 * len(self.dh0) or self.names[i] in free]
        full = np.zeros(n)
        if x is not None:
            full[: min(len(x), n)] = x[:n]
        keep = self.ok if keep is None else keep

        def fun(u):
            full[use] = u
            return self.residual(full, extra, keep)

        s = least_squares(fun, full[use], method="lm" if loss == "linear" else "trf", loss=loss, f_scale=0.3, x_scale="jac" if loss == "linear" else 1.0)
        full[use] = s.x
        r = np.stack([(m - p) for p, m in zip(self.predict(full, extra), self.points)], 1)
        return full.copy(), r, s.jac, use

    def rms3(self, r, keep):
        return np.sqrt((r[keep] ** 2).sum(-1).mean())

    def label(self, i, extra=()):
        n, m = 4 * len(self.dh0), len(self.points)
        if i < n:
            return self.names[i]
        if i < n + 6:
            return "base" + "rrrxyz"[i - n] + str((i - n) % 3)
        if i < n + 6 + 3 * m:
            return f"tool{(i - n - 6) // 3}{'xyz'[(i - n - 6) % 3]}"
        return "{} A{}".format(extra[i - n - 6 - 3 * m][0], extra[i - n - 6 - 3 * m][1] + 1)


def independent(jac, labels, order, tol=1e-6):
    """Greedy independent columns in the given order (QR with the order kept): names kept and names that are combinations."""
    q, kept, dropped = np.zeros((jac.shape[0], 0)), [], []
    for i in order:
        c = jac[:, i] / max(np.linalg.norm(jac[:, i]), 1e-300)
        r = c - q @ (q.T @ c)
        r -= q @ (q.T @ r)
        if np.linalg.norm(r) > tol:
            q = np.column_stack([q, r / np.linalg.norm(r)])
            kept.append(labels[i])
        else:
            dropped.append(labels[i])
    return kept, dropped
