#!/usr/bin/env python3
"""What recorders do to logs: the documented chain on logs of random machines that were changed as real recordings are.

    recorders.py --binary target/fast/lostmotion --machines ../shared/reference/machines/machines.py --work FOLDER 7101:kr120 7104:m20ia

Needs numpy and pandas, and what machines.py needs. For each machine and each change: all its logs are changed, `identify`, `fit` and
`rewrite` run without options, and the rewritten circle runs on the machine. Printed: reduction of the largest error after a reversal
(median) and of the path's rms.
"""

import argparse
import ast
import json
import pathlib
import shutil
import subprocess
import sys

import numpy as np
import pandas as pd

TCP = ["x_mm", "y_mm", "z_mm"]
PROGRAM = "program_circle"


def joints(log):
    return [c for c in log if c.startswith("cmd_")]


def held(every):
    """Joint positions that a controller gives every so many rows, repeated in between."""

    def change(log, _):
        t = log["t_s"].to_numpy()
        interval = every * np.median(np.diff(t))
        read = np.floor((t - t[0]) / interval + 1e-9) * interval + t[0]
        for c in joints(log):
            log[c] = np.interp(read, t, log[c].to_numpy()).round(5)
        return log

    return change


def repeated(every):
    """Positions of a tracker that measures every so many rows."""

    def change(log, _):
        k = np.floor(np.arange(len(log)) / every + 1e-9)
        log[TCP] = log[TCP].to_numpy()[np.searchsorted(k, k)]
        return log

    return change


def outliers(share, mm):
    def change(log, rng):
        hit = rng.random(len(log)) < share
        log.loc[hit, TCP] += rng.normal(size=(hit.sum(), 3)) * mm
        return log

    return change


def moved(mm):
    """The tracker is moved after two thirds."""

    def change(log, rng):
        log.iloc[len(log) * 2 // 3 :, [log.columns.get_loc(c) for c in TCP]] += rng.normal(size=3) * mm
        return log

    return change


def blanks(log, rng):
    log.loc[rng.random(len(log)) < 0.2, TCP] = np.nan
    return log


def coarse(log, _):
    log[joints(log)] = log[joints(log)].round(2)
    return log


def late(log, _):
    for c in joints(log):
        log[c] = log[c].shift(2).bfill()
    return log


def rows_lost(log, rng):
    return log[rng.random(len(log)) > 0.2]


CHANGES = {
    "as recorded": lambda log, _: log,
    "joint positions new every 3 rows": held(3),
    "... every 2.5 rows": held(2.5),
    "... every 1.5 rows": held(1.5),
    "TCP new every 3 rows": repeated(3),
    "... every 2.5 rows": repeated(2.5),
    "5 % of the rows off by 20 mm": outliers(0.05, 20),
    "0.5 % of the rows off by 20 mm": outliers(0.005, 20),
    "20 % of the TCP positions lost": blanks,
    "20 % of the rows lost": rows_lost,
    "joint positions in steps of 0.01 deg": coarse,
    "joint positions 2 rows late": late,
    "tracker moved by 1 mm on the way": moved(1.0),
    "tracker moved by 0.05 mm on the way": moved(0.05),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", type=pathlib.Path, required=True)
    parser.add_argument("--machines", type=pathlib.Path, required=True)
    parser.add_argument("--work", type=pathlib.Path, required=True)
    parser.add_argument("machine", nargs="+", help="SEED:ROBOT")
    args = parser.parse_args()
    tool, work = [sys.executable, args.machines.resolve()], args.work.resolve()

    def run(*command):
        return subprocess.run([str(c) for c in command], capture_output=True, text=True)

    for machine in args.machine:
        seed, robot = machine.split(":")
        of = work / seed
        if not of.exists():
            run(*tool, "make", of, "--seed", seed, "--robot", robot)
        speed = json.loads((of / "job.json").read_text())["programs"][f"{PROGRAM}.csv"]["speed_mm_s"]
        perfect = ["--perfect-tracker", "--no-wander"]
        run(*tool, "run", of, of / f"{PROGRAM}.csv", "-o", of / "before.csv", *perfect)
        for n, (name, change) in enumerate(CHANGES.items()):
            folder = work / f"{seed}_{n}"
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
            rng = np.random.default_rng(5)
            logs = sorted(of.glob("static_*.csv")) + [of / "circle.csv", of / "excitation.csv"]
            given = []
            for log in logs:
                change(pd.read_csv(log, comment="#"), rng).to_csv(folder / log.name, index=False)
                given += ["--log", folder / log.name]
            robot_file, done = of / "robot.yaml", folder / f"{PROGRAM}.done.csv"
            lostmotion = [args.binary.resolve()]
            steps = [
                ["identify", *given, "--output", folder / "gaps.yaml"],
                ["fit", "--gaps", folder / "gaps.yaml", "--output", folder / "compensator.yaml"],
                ["rewrite", "--compensator", folder / "compensator.yaml", of / f"{PROGRAM}.csv", "--output", done, "--speed-mm-s", speed],
            ]
            ends = [run(*lostmotion, step[0], "--robot", robot_file, *step[1:]) for step in steps]
            if failed := [e for e in ends if e.returncode]:
                print(f"{seed}\t{name}\trefused: {failed[0].stderr.strip().splitlines()[-1]}", flush=True)
                continue
            run(*tool, "run", of, done, "-o", folder / "after.csv", "--seed", 2, *perfect)
            score = run(*tool, "score", of, "--nominal", of / f"{PROGRAM}.csv", "--before", of / "before.csv", "--after", folder / "after.csv")
            found = next(ast.literal_eval(line) for line in score.stdout.splitlines() if "rms_reduction" in line)
            print(f"{seed}\t{name}\t{found['median_reduction']:.3f}\t{found['rms_reduction']:.3f}", flush=True)


if __name__ == "__main__":
    main()
