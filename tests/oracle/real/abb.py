#!/usr/bin/env python3
"""ABB IRB 120 and laser tracker: the README's figures, and the order in which a diagnosis should find them.

    python3 tests/oracle/real/abb.py FOLDER
"""
import numpy as np
from pose import Arm, folder, independent, table

DH = [(0, 290, 0, -90), (-90, 0, 270, 0), (0, 0, 70, -90), (0, 302, 0, 90), (0, 0, 0, -90), (180, 72, 0, 0)]
# standard DH rows: theta, d, a, alpha in degrees and mm
DH = [(np.radians(t), d, a, np.radians(al)) for t, d, a, al in DH]
# link masses: rough split of the 25 kg of the data sheet; centre of mass in the link's DH frame, mm
LINKS = [(3.1, (0, 60, 0)), (3.9, (-160, 0, 0)), (2.9, (-60, 0, 0)), (1.3, (0, 80, 0)), (0.5, (0, 0, 0)), (0.14, (0, 0, -10))]


def main():
    d = table(folder("abb-irb120-laser-tracker") + "/poses_0000_0599.csv")
    q = {k: np.radians(np.column_stack([d[f"{k}_j{j}_deg"] for j in range(1, 7)])) for k in ("cmd", "read")}
    points = [np.column_stack([d[f"smr{k}_{c}_mm"] for c in "xyz"]) for k in (1, 2, 3)]
    gaps = [np.linalg.norm(points[a] - points[b], axis=1) for a, b in ((0, 1), (0, 2), (1, 2))]
    print("reflector distances, mm and sd um:", [(round(np.median(g), 3), round(1.4826e3 * np.median(abs(g - np.median(g))), 1)) for g in gaps])
    keep = None
    for which in ("cmd", "read"):
        arm = Arm(q[which], points, DH, LINKS)
        arm.start([(0, 0, 0)] * 3)
        x, r, jac, use = arm.fit([])
        print(which, "tools from 0,0,0 start:", np.round(x[30:39], 2))
        every = [n for n in arm.names]
        xa, ra, jac, use = arm.fit(every, loss="soft_l1", x=x)
        if keep is None:
            worst = np.sqrt((ra ** 2).sum(-1)).max(1)
            keep = (worst < 0.5) & (np.arange(len(worst)) > 0)
            print("poses kept", keep.sum(), "of", len(keep), "; dropped", np.flatnonzero(~keep).tolist(), np.round(worst[~keep], 2).tolist())
        x, r, jac, use = arm.fit([], keep=keep, x=x)
        print(which, "nominal DH, base and tools free: %.3f mm" % arm.rms3(r, keep), "per coordinate um %.1f" % (1e3 * np.sqrt((r[keep] ** 2).mean())))
        xa, ra, jac, use = arm.fit(every, keep=keep, x=xa)
        print(which, "all DH: %.3f" % arm.rms3(ra, keep))
        labels = [arm.label(i) for i in use]
        nuisance = [i for i, l in enumerate(labels) if l.startswith(("base", "tool"))]
        rest = [i for i, l in enumerate(labels) if i not in nuisance]
        kept, dropped = independent(jac, labels, nuisance + rest)
        print("   identifiable beyond base and tools:", len(kept) - len(nuisance), "not:", dropped)
        grav = [("gravity", 1), ("gravity", 2)]
        xg, rg, jac, use = arm.fit(every, grav, keep, xa)
        print(which, "+ gravity A2 A3: %.3f" % arm.rms3(rg, keep), "deg per 100 Nm", np.round(np.degrees(xg[-2:] * 1e-3) * 100, 4))
        ex = grav + [("direction", j) for j in range(6)]
        xd, rd, jac, use = arm.fit(every, ex, keep, xg)
        cov = np.linalg.pinv(jac.T @ jac) * (rd[keep] ** 2).mean()
        # poses are independent, the three points of a pose are not: cluster by pose
        res = rd[keep].transpose(1, 0, 2)
        g = jac.reshape(3, keep.sum(), 3, -1)
        score = np.einsum("kpc,kpcm->pm", res, g)
        bread = np.linalg.pinv(jac.T @ jac)
        robust = bread @ (score.T @ score) @ bread
        print(which, "+ directions: %.3f" % arm.rms3(rd, keep))
        for j in range(6):
            i = len(use) - 6 + j
            print("    A%d half offset %.4f deg, se iid %.4f, se by pose %.4f" % (j + 1, np.degrees(xd[-6 + j] * 1e-3), np.degrees(np.sqrt(cov[i, i]) * 1e-3), np.degrees(np.sqrt(robust[i, i]) * 1e-3)))
        if which == "cmd":
            print("    correlation of residuals between the points of one pose:", np.round(np.corrcoef(rd[keep].reshape(-1, 9).T)[0], 2))
            lag = rd[keep].reshape(-1, 9)
            print("    lag 1 from pose to pose:", np.round([np.corrcoef(lag[1:, c], lag[:-1, c])[0, 1] for c in range(9)], 2))
            base_r = rd
            greedy(arm, keep, x)
            shuffle(arm, every, grav, keep, xg)
    a = (q["read"] - q["cmd"])[1:]
    s = np.sign(np.diff(q["cmd"], axis=0))
    print("read - cmd, mean over + and - approach, deg:", [(round(np.degrees(a[s[:, j] > 0, j].mean()), 3), round(np.degrees(a[s[:, j] < 0, j].mean()), 3)) for j in range(6)])


def shuffle(arm, every, grav, keep, xg):
    """Largest half offset over shuffles of the direction rows (the null of no approach effect)."""
    rng = np.random.default_rng(1)
    x, r, jac, use = arm.fit(every, grav + [("direction", j) for j in range(6)], keep, xg)
    kept_dirs = arm.dirs.copy()
    res = r + 0  # linear: project the null residual on shuffled direction columns
    x0, r0, j0, u0 = arm.fit(every, grav, keep, xg)
    qm, _ = np.linalg.qr(j0)
    y = np.concatenate([r0[keep][:, k].ravel() for k in range(3)])
    dcols = jac[:, -6:]  # columns: derivative * direction
    n = keep.sum()
    unsigned = dcols.reshape(3, n, 3, 6) * kept_dirs[keep][None, :, None, :]
    out = []
    for _ in range(200):
        p = rng.permutation(n)
        c = (unsigned * kept_dirs[keep][p][None, :, None, :]).reshape(-1, 6)
        c = c - qm @ (qm.T @ c)
        b, *_ = np.linalg.lstsq(c, -y, rcond=None)
        out.append(np.degrees(b * 1e-3))
    out = np.abs(np.array(out))
    print("    shuffled signs, 95 % and largest of 200, deg:", np.round(np.quantile(out, 0.95, axis=0), 4), np.round(out.max(0), 4))


def greedy(arm, keep, x):
    """Forward selection of single geometry parameters: how many are significant, what each round leaves."""
    free = []
    r = arm.fit(free, keep=keep, x=x)[1]
    n = keep.sum() * 9
    print("    greedy single parameters: 0: %.3f" % arm.rms3(r, keep))
    # linear forward selection on the jacobian of the full fit
    xa, ra, jac, use = arm.fit(arm.names, keep=keep, x=x)
    labels = [arm.label(i) for i in use]
    y = -np.concatenate([r[keep][:, k].ravel() for k in range(3)])
    x0, r0, j0, u0 = arm.fit(arm.names, keep=keep, x=xa)
    nuis = [i for i, l in enumerate(labels) if l.startswith(("base", "tool"))]
    q, _ = np.linalg.qr(j0[:, nuis])
    rest = [i for i in range(len(labels)) if i not in nuis]
    y = y - q @ (q.T @ y)
    for step in range(22):
        best = None
        for i in rest:
            c = j0[:, i] - q @ (q.T @ j0[:, i])
            if np.linalg.norm(c) < 1e-6 * np.linalg.norm(j0[:, i]):
                continue
            c = c / np.linalg.norm(c)
            g = (c @ y) ** 2
            if best is None or g > best[0]:
                best = (g, i, c)
        if best is None:
            break
        g, i, c = best
        left = y @ y - g
        f = g / (left / (n - q.shape[1] - 1))
        y = y - c * (c @ y)
        q = np.column_stack([q, c])
        rest.remove(i)
        print("      %2d %-9s F(iid) %8.1f  -> %.4f mm" % (step + 1, labels[i], f, np.sqrt(3 * (y @ y) / n)))


if __name__ == "__main__":
    main()
