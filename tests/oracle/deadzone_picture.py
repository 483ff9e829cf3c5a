#!/usr/bin/env python3
"""Picture of docs/identify-deadzone.md, in the manner of Figures 3 and 4 of Cursi (2022).

  lostmotion identify deadzone --robot configs/micro-iges-4dof.yaml --log samples/instrument/growing_sine_log.csv.gz --json > gaps.json
  python3 tests/oracle/deadzone_picture.py gaps.json

Needs numpy, scipy, pandas, yaml and matplotlib.
"""
import json, pathlib, sys
import matplotlib, numpy as np, pandas as pd, yaml
from scipy.interpolate import PchipInterpolator
matplotlib.use("svg")
matplotlib.rcParams.update({"svg.hashsalt": "deadzone", "font.size": 8, "svg.fonttype": "none", "font.family": "sans-serif",
                            "axes.spines.top": False, "axes.spines.right": False})
import matplotlib.pyplot as plt

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
doc = json.load(open(sys.argv[1]))
log = pd.read_csv(ROOT / "samples/instrument/growing_sine_log.csv.gz", comment="#")
effects = yaml.safe_load((ROOT / "samples/instrument/instrument.model.yaml").read_text())["effects"]
fig = plt.figure(figsize=(7.2, 5.0))
grid = fig.add_gridspec(2, 4, height_ratios=[1, 1], hspace=0.45, wspace=0.35)

joint, t0, t1 = "PITCH", 240, 300
start = 504.4 * 2
rows = log[(log.t_s >= start + t0) & (log.t_s <= start + t1)]
tip = rows[["x_mm", "y_mm", "z_mm"]].to_numpy()
home = log[["x_mm", "y_mm", "z_mm"]].to_numpy()[:2].mean(axis=0)
u = np.linalg.svd(tip - tip.mean(axis=0), full_matrices=False)[2][0]
along = (tip - home) @ u
cmd = rows[f"cmd_{joint}_deg"].to_numpy()
along *= np.sign(np.corrcoef(along, cmd)[0, 1])
ax = fig.add_subplot(grid[0, :])
t = rows.t_s.to_numpy() - start
ax.plot(t, cmd, color="#888", lw=1, label="motor, deg")
ax.plot(t, along, ".", color="#1f5f9f", ms=2, label="tip along its path, mm")
for p in doc["points"]:
    if p["joint"] == joint and t0 < p["t_s"] - start < t1 - 2:
        later = (t > p["t_s"] - start - 0.05) & (np.abs(cmd - p["from_deg"]) <= p["deadzone_deg"]) & (t < p["t_s"] - start + 5)
        ax.plot(t[later], along[later], ".", color="#c0392b", ms=4)
ax.plot([], [], ".", color="#c0392b", ms=4, label="deadzone found")
ax.set_xlabel("time of the sweep of PITCH, s")
ax.legend(frameon=False, loc="upper left", ncol=3)
ax.set_ylim(-32, 38)
for k, (e, j) in enumerate(zip(effects, doc["joints"])):
    ax = fig.add_subplot(grid[1, k])
    pts = [p for p in doc["points"] if p["joint"] == j["joint"]]
    at, b = np.array([p["at_deg"] for p in pts]), np.array([p["half_gap_deg"] for p in pts])
    ci = np.array([p["ci95"] for p in pts])
    ax.errorbar(at, b, yerr=[b - ci[:, 0], ci[:, 1] - b], fmt=".", ms=3, lw=0.6, color="#c0392b")
    x = np.linspace(-40, 40, 161)
    knots = np.array(e["knots"])
    ax.plot(x, PchipInterpolator(knots[:, 0], knots[:, 1])(x), color="#888", lw=1.2)
    found = np.array(j["schedule"]["knots"])
    band = np.array(j["band_deg"])
    ax.fill_between(found[:, 0], found[:, 1] - band, found[:, 1] + band, color="#1f5f9f", alpha=0.2, lw=0)
    ax.plot(found[:, 0], found[:, 1], color="#1f5f9f", lw=1)
    ax.set_title(j["joint"], fontsize=8)
    ax.set_xlabel("motor, deg")
    ax.set_ylim(0, 4.2)
    if k == 0:
        ax.set_ylabel("half gap, deg")
fig.savefig(ROOT / "docs/identify-deadzone.svg", metadata={"Date": None, "Creator": None}, bbox_inches="tight")
