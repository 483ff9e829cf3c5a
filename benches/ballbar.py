#!/usr/bin/env python3
"""Half gaps from the ballbar circles that `plan-experiment` plans, on machines that are computed here and nowhere else.

    ballbar.py --binary target/fast/lostmotion --configs configs --work FOLDER --seeds 10 [--noise-um 1] [--diagnose]

Needs numpy. Shares no code and no convention with lostmotion: the arm turns about axes that are fixed in space (no DH), the gantry's TCP is
its joints. For each seed half gaps are drawn (gantry 5 to 40 um, arm 0.002 to 0.010 deg); the planned circles are run with a play operator
in every joint, between the rows of the log as well; the ballbar is set up 0.5 to 1.5 mm off the planned centre, its length is off by 0.1 mm,
and reads to 0.1 um with white noise. Printed: the error of every half gap that the plan says the circles tell, as a share of the true one,
for each command, and how often the 95 % interval holds the truth.
"""

import argparse
import csv
import json
import pathlib
import subprocess
import sys

import numpy as np

RATE, FINE = 50, 20  # rows of the log a second, places between two of them
# the arm with all joints at zero, stretched level along x: directions of the axes, points on them, and the TCP, mm
AXES = [(0, 0, -1), (0, 1, 0), (0, 1, 0), (-1, 0, 0), (0, 1, 0), (-1, 0, 0)]
POINTS = [(0, 0, 0), (350, 0, 675), (1500, 0, 675), (2500, 0, 634), (2500, 0, 634), (2500, 0, 634)]
TCP = (2500.0 + 215.0 + 63.0, 0.0, 634.0 - 156.0)


def arm(q):
    q = np.radians(q)
    p = np.tile(np.array(TCP), (len(q), 1))
    for j in range(5, -1, -1):
        a, o = np.array(AXES[j], float), np.array(POINTS[j], float)
        v, c, s = p - o, np.cos(q[:, j])[:, None], np.sin(q[:, j])[:, None]
        p = v * c + np.cross(a, v) * s + a * (v @ a)[:, None] * (1 - c) + o
    return p


MACHINES = {
    "gantry": ("gantry-xyz-ballscrew.yaml", list("XYZ"), "mm", lambda q: q, (500, 400, -200), 150, (0.005, 0.040)),
    "arm": ("kuka-kr120-r2500-pro.yaml", [f"A{k}" for k in range(1, 7)], "deg", arm, (1500, 300, 1200), 300, (0.002, 0.010)),
}


def play(p, b):
    """What follows p at the distance b and stands still inside the gap; in the middle of it at first."""
    out = np.empty_like(p)
    y = p[0]
    for i, v in enumerate(p):
        y = min(max(y, v - b), v + b)
        out[i] = y
    return out


def run(lostmotion, *args, code=0):
    done = subprocess.run([lostmotion, *map(str, args)], capture_output=True, text=True)
    if done.returncode != code:
        sys.exit(f"{args}: {done.returncode}\n{done.stderr}")
    return done.stdout


def program(path, names, unit):
    with open(path) as f:
        rows = list(csv.DictReader(line for line in f if not line.startswith("#")))
    column = lambda n: next(c for c in rows[0] if c.lower() in (f"{n}_{unit}".lower(), f"cmd_{n}_{unit}".lower()))
    t = np.array([float(r["t_s"]) for r in rows])
    return t, np.array([[float(r[column(n)]) for n in names] for r in rows])


def log(path, names, unit, forward, t, q, gaps, centre, bar, noise_um, rng):
    fine = np.arange(0, t[-1], 1 / (RATE * FINE))
    cmd = np.stack([np.interp(fine, t, q[:, j]) for j in range(len(names))], 1)
    true = np.stack([play(cmd[:, j], gaps[j]) for j in range(len(names))], 1)
    away = rng.normal(size=3)
    off = centre + away / np.linalg.norm(away) * rng.uniform(0.5, 1.5)
    r = (np.linalg.norm(forward(true[::FINE]) - off, axis=1) - bar - rng.uniform(-0.1, 0.1)) * 1e3
    r += noise_um * rng.normal(size=len(r))
    with open(path, "w") as f:
        f.write("t_s," + ",".join(f"cmd_{n}_{unit}" for n in names) + ",r_um\n")
        for k, row in enumerate(cmd[::FINE]):
            f.write(f"{k / RATE:.3f}," + ",".join(f"{v:.6f}" for v in row) + f",{r[k]:.1f}\n")


def found_by(lostmotion, command, robot, path, unit):
    """Half gap and interval by joint."""
    if command == "diagnose":
        said = json.loads(run(lostmotion, "diagnose", "--robot", robot, "--log", path, "--json"))
        effects = [f"{r['effect']} {r['target']}" for r in said["rounds"]]
        out = {}
        for r in said["rounds"]:
            v = r["parameters"].get(f"half_gap_{unit}")
            if r["effect"] == "backlash" and v:
                out[r["target"]] = (v["value"], v["ci95"])
        return out, f"{said['verdict']}: {', '.join(effects)}"
    said = json.loads(run(lostmotion, *command.split(), "--robot", robot, "--log", path, "--json"))
    joints = said["joints"]
    items = joints.items() if isinstance(joints, dict) else ((j["joint"], j) for j in joints)
    pick = lambda j: j.get("backlash", j)
    return {n: (pick(j)[f"half_gap_{unit}"], pick(j)["ci95"]) for n, j in items if f"half_gap_{unit}" in pick(j)}, ""


def main():
    a = argparse.ArgumentParser()
    for name in ("--binary", "--configs", "--work"):
        a.add_argument(name, required=True)
    a.add_argument("--seeds", type=int, default=10)
    a.add_argument("--noise-um", type=float, default=1.0)
    a.add_argument("--diagnose", action="store_true")
    a = a.parse_args()
    work = pathlib.Path(a.work)
    work.mkdir(parents=True, exist_ok=True)
    commands = ["identify", "identify path"] + (["diagnose"] if a.diagnose else [])
    for machine, (config, names, unit, forward, centre, bar, span) in MACHINES.items():
        robot = pathlib.Path(a.configs) / config
        plan = work / f"{machine}.csv"
        doc = json.loads(run(a.binary, "plan-experiment", "path", "--robot", robot, "--ballbar", ",".join(map(str, centre)),
                             "--bar-mm", bar, "--output", plan, "--json"))
        told = [j["joint"] for j in doc["joints"] if j[f"sigma_half_gap_{unit}"] is not None]
        print(f"{machine}: the plan tells {told}")
        for note in doc.get("notes", []):
            print(f"   {note}")
        t, q = program(plan, names, unit)
        off, inside = {c: [] for c in commands}, {c: [] for c in commands}
        for seed in range(a.seeds):
            rng = np.random.default_rng([2024, seed])
            gaps = rng.uniform(*span, len(names))
            path = work / f"{machine}_{seed}.csv"
            log(path, names, unit, forward, t, q, gaps, np.array(centre, float), bar, a.noise_um, rng)
            for command in commands:
                found, words = found_by(a.binary, command, robot, path, unit)
                said = []
                for n, b in zip(names, gaps):
                    if n not in told:
                        continue
                    if n not in found:
                        said.append(f"{n} missing")
                        off[command].append(1.0)
                        continue
                    v, ci = found[n]
                    off[command].append(v / b - 1)
                    inside[command].append(ci is not None and ci[0] <= b <= ci[1])
                    said.append(f"{n} {100 * (v / b - 1):+.1f} %")
                print(f"   {seed} {command}: {', '.join(said)} {words}", flush=True)
        for c in commands:
            e = np.abs(off[c])
            print(f"{machine}, {c}: {len(e)} gaps, median {100 * np.median(e):.2f} %, largest {100 * e.max():.2f} %, "
                  f"within 5 %: {np.mean(e <= 0.05):.0%}, interval holds the truth: {sum(inside[c])} of {len(inside[c])}")


main()
