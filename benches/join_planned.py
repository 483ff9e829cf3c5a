#!/usr/bin/env python3
"""How often the intervals of `join` cover the clock offset, on planned programs run on simulated machines.

  join_planned.py LOSTMOTION FOLDER [--count 40] [--kinds static,path] [--first 1] [--rate-hz 20]

For each seed: a program of `plan-experiment` (KUKA KR 120 and FANUC M-10iA in turn, the latter with `gap_of`) at a random pose, a machine
with a gap in every joint and stiction that fades, `simulate` with 10 um of noise, and the log cut into a controller's and a tracker's
recording, whose clocks differ by up to 20 s and 20 ppm. `--near-s` is the truth to a second. Prints a line for each, and the coverage.
"""
import argparse
import json
import pathlib
import random
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent
ARMS = [
    ("kuka-kr120-r2500-pro.yaml", [f"A{k}" for k in range(1, 7)], [0, -80, 95, 20, 30, 40]),
    ("fanuc-m10ia.yaml", [f"J{k}" for k in range(1, 7)], [0, 10, -10, 0, -60, 0]),
]


def run(*words):
    return subprocess.run([str(w) for w in words], check=False, capture_output=True, text=True)


def model(rng, robot, joints):
    lines = ["schema: lostmotion/model/1", f"robot: {robot}", "effects:"]
    for joint in joints:
        lines.append(f"  - {{effect: backlash, joint: {joint}, half_gap_deg: {rng.uniform(0.001, 0.006):.5f}}}")
        spike, decay = rng.uniform(0.0, 0.004), rng.uniform(0.5, 6.0)
        lines.append(f"  - {{effect: stiction, joint: {joint}, spike_deg: {spike:.5f}, decay_s: {decay:.2f}}}")
    return "\n".join(lines) + "\n"


def split(log, folder, offset_s, rate):
    """A log as two recordings: tracker's time = (controller's - offset) / rate."""
    rows = [line.split(",") for line in log.read_text().splitlines() if line and not line.startswith("#")]
    head, body = rows[0], rows[1:]
    commands = [k for k, name in enumerate(head) if name.startswith("cmd_")]
    xyz = [head.index(name) for name in ("x_mm", "y_mm", "z_mm")]
    ours, theirs = ["t_s," + ",".join(head[k] for k in commands)], ["t_s,x_mm,y_mm,z_mm"]
    for r in body:
        t = float(r[0])
        ours.append(f"{t:.4f}," + ",".join(r[k] for k in commands))
        theirs.append(f"{(t - offset_s) / rate:.7f}," + ",".join(r[k] for k in xyz))
    (folder / "controller.csv").write_text("\n".join(ours) + "\n")
    (folder / "tracker.csv").write_text("\n".join(theirs) + "\n")


def one(binary, folder, kind, seed, rate_hz):
    rng = random.Random(f"{kind} {seed}")
    robot, joints, pose = ARMS[seed % len(ARMS)]
    robot = ROOT / "configs" / robot
    at = ",".join(f"{q + rng.uniform(-15, 15):.2f}" for q in pose)
    more = ["--dwell-s", 2, "--cycles", 1, "--places", 3, "--travel-deg", 20] if kind == "static" else ["--duration-s", 120]
    program, log, machine = folder / "plan.csv", folder / "log.csv", folder / "machine.yaml"
    machine.write_text(model(rng, robot, joints))
    for words in (
        ["plan-experiment", kind, "--robot", robot, f"--pose={at}", "--rate-hz", rate_hz, *more, "--output", program],
        ["simulate", "--model", machine, "--input", program, "--rate-hz", rate_hz, "--noise-um", 10, "--seed", seed, "--output", log],
    ):
        done = run(binary, "-q", *words)
        if done.returncode != 0:
            return None, done.stderr.strip()
    offset_s, rate = rng.uniform(-20, 20), 1 + rng.uniform(-20e-6, 20e-6)
    split(log, folder, offset_s, rate)
    done = run(binary, "-q", "join", "--robot", robot, "--controller", folder / "controller.csv", "--tracker", folder / "tracker.csv",
               f"--near-s={round(offset_s)}", "--output", folder / "joined.csv", "--json")
    if done.returncode != 0:
        return None, done.stderr.strip()
    found = json.loads(done.stdout)
    truth = (offset_s + (rate - 1) * found["at_tracker_s"]) * 1e3
    (lo, hi), value = found["offset_ms"]["ci95"], found["offset_ms"]["value"]
    return (value - truth, 0.5 * (hi - lo), lo <= truth <= hi), None


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("binary", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--kinds", default="static,path")
    parser.add_argument("--rate-hz", type=float, default=20)
    args = parser.parse_args()
    args.folder.mkdir(parents=True, exist_ok=True)
    for kind in args.kinds.split(","):
        errors, refused = [], 0
        for seed in range(args.first, args.first + args.count):
            found, why = one(args.binary.resolve(), args.folder, kind, seed, args.rate_hz)
            if found is None:
                refused += 1
                print(f"{kind} {seed}: refused: {why}", flush=True)
                continue
            errors.append(found)
            print(f"{kind} {seed}: off by {found[0]:+.4f} ms, interval +- {found[1]:.4f} ms{'' if found[2] else '  MISSED'}", flush=True)
        off, half = sorted(abs(e[0]) for e in errors), sorted(e[1] for e in errors)
        if errors:
            print(f"{kind}: {sum(e[2] for e in errors)} of {len(errors)} within their intervals, {refused} refused; error median "
                  f"{off[len(off) // 2]:.4f} ms, largest {off[-1]:.4f} ms; half interval median {half[len(half) // 2]:.4f} ms", flush=True)


if __name__ == "__main__":
    main()
