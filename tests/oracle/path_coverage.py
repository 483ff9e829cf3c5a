#!/usr/bin/env python3
"""Bias, scatter and coverage of `identify path` over noises: the figures of docs/identify-path.md.

  path_coverage.py TWIN_DIR LOSTMOTION N [table3|figure5] [RATE_HZ]

TWIN_DIR holds twin.py, the independent simulator (rotations about fixed axes, no DH). Its noise-free run of the circle is made
once; N logs with white noise of 11 um are written, identified and compared with what was put in. Needs numpy, pandas.
"""
import json, os, subprocess, sys, tempfile
import numpy as np
import pandas as pd

where, program, count = sys.argv[1], sys.argv[2], int(sys.argv[3])
machine = sys.argv[4] if len(sys.argv) > 4 else "table3"
rate = float(sys.argv[5]) if len(sys.argv) > 5 else 25.0
sys.path.insert(0, where)
sys.dont_write_bytecode = True
import twin

robot = os.path.join(os.path.dirname(__file__), "../../configs/kuka-kr120-r2500-pro.yaml")
truth = {("A1", "gap"): 0.0028, ("A3", "gap"): 0.0022, ("A1", "spike"): 0.0034, ("A3", "spike"): 0.0017,
         ("A1", "decay"): 5.2, ("A3", "decay"): 5.2}
if machine == "table3":
    truth[("A2", "gap")] = 0.0037

q = twin.circle()
t, out = twin.execute(q, twin.durations(q, 1.5), rate, machine, "stick")
tcp = twin.forward(out["true"]) @ twin.rotation().T + np.array(twin.TRACKER_XYZ)
columns = {"t_s": np.round(t, 4)} | {f"cmd_A{i + 1}_deg": np.round(out["cmd"][:, i], 6) for i in range(6)}
found, false = {}, 0
with tempfile.TemporaryDirectory() as work:
    log = os.path.join(work, "log.csv")
    for seed in range(count):
        x = tcp + np.random.default_rng(7000 + seed).normal(0, 0.011, tcp.shape)
        pd.DataFrame(columns | {n: np.round(x[:, k], 4) for k, n in enumerate(("x_mm", "y_mm", "z_mm"))}).to_csv(log, index=False)
        run = subprocess.run([program, "identify", "path", "--robot", robot, "--log", log, "--json"], capture_output=True, check=True)
        for j in json.loads(run.stdout)["joints"]:
            found.setdefault((j["joint"], "gap"), []).append((j["half_gap_deg"], *j["ci95"]))
            s = j["stiction"]
            if s and j["joint"] == "A2":
                false += 1
            elif s:
                found.setdefault((j["joint"], "spike"), []).append((s["spike_deg"], *s["ci95"]))
                found.setdefault((j["joint"], "decay"), []).append((s["decay_s"], *s["decay_ci95"]))
for key, want in sorted(truth.items()):
    v = np.array(found.get(key, np.zeros((0, 3))))
    if len(v):
        print(f"{key[0]} {key[1]:6s} n {len(v):3d}  bias {100 * (v[:, 0].mean() / want - 1):+6.2f} %  sd {100 * v[:, 0].std() / want:6.2f} %  "
              f"95 % interval +-{50 * np.mean(v[:, 2] - v[:, 1]) / want:6.2f} %  covers {np.mean((v[:, 1] <= want) & (want <= v[:, 2])):.2f}  "
              f"within 10 % {np.mean(abs(v[:, 0] / want - 1) < 0.1):.2f}")
print("false stiction of A2:", false)
