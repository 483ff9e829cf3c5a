#!/usr/bin/env python3
"""Ballbar and dial logs of random machines: what `identify` makes of instruments that read one number a row.

    instruments.py --binary target/fast/lostmotion --machines ../shared/reference/machines/machines.py --work FOLDER 8101:kr120 8102:irb4600

Needs numpy and pandas, and what machines.py needs. Of each machine, beside its own logs by a tracker: both circles with a ballbar set up a
millimetre or two off their centre (noise 0.5 um, as much again that is slow, the TCP's wander), and each joint back and forth by some
millimetres against a dial. Printed for each set of logs: the half gap of every joint that is found as a share of the true one, whether
the truth is inside its 95 % interval, and what the compensator takes away of the circle. Truth: the mean of the gap over the places
where the logs turn the joint.
"""

import argparse
import importlib.util
import json
import pathlib
import subprocess
import sys

import numpy as np
import pandas as pd
import yaml

PROGRAM = "program_circle"
BAR_UM, DIAL_UM, RATE = 0.5, 1.0, 50


def slow(machines, rng, n, tau, um):
    return machines.ar1(rng, n, 1 / RATE, tau, 1)[:, 0] * um


def write(path, m, run, column, values):
    data = {"t_s": run["t"].round(4)}
    for j, (name, unit) in enumerate(zip(m.nominal.names, m.nominal.units)):
        data[f"cmd_{name}_{unit}"] = run["cmd"][:, j].round(m.digits + 1) + 0.0
    data[column] = np.round(values, 1) + 0.0
    pd.DataFrame(data).to_csv(path, index=False, lineterminator="\n")


def positions(m, run):
    """The TCP in the robot's world frame, with its wander."""
    return (m.observe(run, True, True) - m.reg_t) @ m.reg_r


def ballbar(machines, m, folder, name, seed):
    job, rng = m.jobs[name], np.random.default_rng([m.seed, 77, seed])
    run = m.execute(job["points"], m.durations(job["points"], job["speed_mm_s"]), RATE, seed)
    p = positions(m, run)
    centre = m.nominal.tcp(job["points"]).mean(0) + rng.normal(0, 1.0, 3)
    r = np.linalg.norm(p - centre, axis=1) * 1e3
    r += BAR_UM * rng.standard_normal(len(r)) + slow(machines, rng, len(r), 5.0, BAR_UM)
    write(folder / f"bar_{name}.csv", m, run, "r_um", r - np.round(r.mean(), -3))


def dial(machines, m, folder, j, seed):
    """Strokes of 30 mm at the TCP (at least a degree, at most 5) with rests at the ends; the dial along the joint's movement."""
    rng = np.random.default_rng([m.seed, 78, seed])
    lever = max(m.levers(m.home)[j], 0.3)
    span = np.clip(30 / lever, 1, 5) if not m.nominal.prism[j] else 30.0
    q, tv = [m.home.round(2)], [0.0]
    for k in range(12):
        q.append(q[0] + np.eye(m.nominal.n)[j] * (span if k % 2 == 0 else 0))
        tv.append(tv[-1] + span * lever / 8)
        q.append(q[-1])
        tv.append(tv[-1] + 1.5)
    run = m.execute(np.array(q), np.array(tv), RATE, seed)
    step = np.eye(m.nominal.n)[j] * 1e-3
    along = (m.nominal.tcp(m.home + step) - m.nominal.tcp(m.home - step))[0]
    if np.linalg.norm(along) < 1e-5:
        return None
    along = (along / np.linalg.norm(along)).round(3)
    reading = positions(m, run) @ (along / np.linalg.norm(along)) * 1e3
    reading += DIAL_UM * rng.standard_normal(len(reading))
    name = folder / f"dial_{m.nominal.names[j]}.csv"
    write(name, m, run, "dial_um", reading - np.round(reading.mean(), -3))
    return name, ",".join(f"{v:g}" for v in along)


def truth(m, logs):
    """Half gap of each joint, and its wind-up, over the places where the logs turn it."""
    places = {n: [] for n in m.nominal.names}
    for log in logs:
        data = pd.read_csv(log, comment="#")
        for n, u in zip(m.nominal.names, m.nominal.units):
            x = data[f"cmd_{n}_{u}"].to_numpy()
            d = np.sign(np.diff(x)) * (np.abs(np.diff(x)) > 10.0**-m.digits)
            at = np.flatnonzero(d)
            places[n] += [x[at[k + 1]] for k in range(len(at) - 1) if d[at[k]] * d[at[k + 1]] < 0]
    out = {}
    for j, n in enumerate(m.nominal.names):
        if places[n]:
            x = np.array(places[n])
            gap = float(m.gap[j].half(x, np.zeros(len(x))).mean()) if m.gap[j] else 0.0
            out[n] = gap, float(m.friction[j].windup_half)
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", type=pathlib.Path, required=True)
    parser.add_argument("--machines", type=pathlib.Path, required=True)
    parser.add_argument("--work", type=pathlib.Path, required=True)
    parser.add_argument("--sets", default="tracker,mixed,shop,circle")
    parser.add_argument("--estimates-only", action="store_true", help="no programs: intervals alone")
    parser.add_argument("machine", nargs="+", help="SEED:ROBOT")
    args = parser.parse_args()
    spec = importlib.util.spec_from_file_location("machines", args.machines)
    machines = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(machines)
    args.binary = args.binary.resolve()
    tool = [sys.executable, args.machines.resolve()]

    def sh(*words):
        done = subprocess.run([str(w) for w in words], capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"{' '.join(map(str, words))}\n{done.stderr}")
        return done

    rows = []
    for name in args.machine:
        seed, robot = name.split(":")
        folder = args.work.resolve() / name.replace(":", "_")
        if not (folder / "robot.yaml").exists():
            sh(*tool, "make", folder, "--seed", seed, "--robot", robot)
        m = machines.load(str(folder))
        ballbar(machines, m, folder, "circle", 31)
        ballbar(machines, m, folder, "tilted", 32)
        dials = [d for j in range(m.nominal.n) if (d := dial(machines, m, folder, j, 40 + j))]
        statics = [folder / f"static_{n}.csv" for n in m.nominal.names]
        bars = [folder / "bar_circle.csv", folder / "bar_tilted.csv"]
        along = [w for _, d in dials for w in ("--direction", d)]
        every = {
            "tracker": (statics + [folder / "circle.csv", folder / "excitation.csv"], []),
            "mixed": (statics + bars[:1], []),
            "shop": (bars + [d[0] for d in dials], along),
            "circle": (bars[:1], []),
        }
        before = folder / "before.csv"
        program, robot_file = folder / f"{PROGRAM}.csv", folder / "robot.yaml"
        speed = json.loads((folder / "job.json").read_text())["programs"][program.name]["speed_mm_s"]
        run = ["--perfect-tracker", "--no-wander"]
        if not before.exists() and not args.estimates_only:
            sh(*tool, "run", folder, program, "-o", before, *run)
        for label in args.sets.split(","):
            logs, options = every[label]
            document = folder / f"{label}.yaml"
            given = [w for log in logs for w in ("--log", log)]
            try:
                sh(args.binary, "identify", "--robot", robot_file, *given, *options, "--output", document)
            except RuntimeError as error:
                print(f"{name} {label}: {str(error)[-300:]}")
                continue
            found = yaml.safe_load(document.read_text())
            want = truth(m, logs)
            for joint in found["joints"]:
                unit = m.nominal.units[m.nominal.names.index(joint["joint"])]
                gap, windup = want[joint["joint"]]
                low, high = joint[f"half_gap_ci95_{unit}"] if f"half_gap_ci95_{unit}" in joint else joint["ci95"]
                is_ = joint[f"half_gap_{unit}"]
                both = is_ + joint["response"][f"windup_{unit}"]
                rows.append((label, name, joint["joint"], is_, low, high, gap, both, gap + windup, joint["trust"]["compensate"]))
            left = sorted(set(want) - {j["joint"] for j in found["joints"]})
            if args.estimates_only:
                print(f"{name:16s} {label:8s} not told: {', '.join(left) or '-'}", flush=True)
                continue
            try:
                sh(args.binary, "fit", "--robot", robot_file, "--gaps", document, "--output", folder / "c.yaml")
                done = folder / f"{PROGRAM}.{label}.csv"
                done.unlink(missing_ok=True)
                sh(args.binary, "rewrite", "--robot", robot_file, "--compensator", folder / "c.yaml", program, "--output", done, "--speed-mm-s", speed)
                sh(*tool, "run", folder, done, "-o", folder / "after.csv", "--seed", 2, *run)
                text = sh(*tool, "score", folder, "--nominal", program, "--before", before, "--after", folder / "after.csv", "--json").stdout
                score = json.loads(text)
                gain = f"{score['median_reduction']:.3f} / {score['rms_reduction']:.3f}"
            except RuntimeError as error:
                gain = str(error)[-200:]
            print(f"{name:16s} {label:8s} {gain}  not told: {', '.join(left) or '-'}", flush=True)
    data = pd.DataFrame(rows, columns="set machine joint gap low high true both true_both used".split())
    data.to_csv(args.work / "joints.csv", index=False)
    data["inside"] = (data.low <= data.true) & (data.true <= data.high)
    data["off"] = (data.gap / data.true - 1).abs()
    data["both_off"] = (data.both / data.true_both - 1).abs()
    data["wide"] = (data.high - data.low) / 2 / data.true_both
    for label, d in data.groupby("set", sort=False):
        there = d[d.true > 0]
        print(
            f"{label:8s} joints {len(d):3d}  inside {d.inside.mean():.2f}  gap off, median {there.off.median():.3f}  "
            f"gap and wind-up off, median {d.both_off.median():.3f}, 90 % {d.both_off.quantile(0.9):.3f}  half width {d.wide.median():.3f}"
        )


if __name__ == "__main__":
    main()
