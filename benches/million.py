#!/usr/bin/env python3
"""Many small programs of all formats through a workflow engine that is killed: the tree must be that of an undisturbed run.

  million.py --programs 1000000 --kills 5 --work FOLDER --binary LOSTMOTION --snakemake SNAKEMAKE

Makes the programs, plans them, runs the Snakemake workflow without a disturbance into one folder, then into another one, killing
(SIGKILL) at random moments the engine with its workers, the workers alone or the engine alone; after the middle moment a program is
added among the others. Compares the hashes of both trees. Prints times, memory, and what differs. Exit code 1: something differs or
is lost.
"""

import argparse
import os
import random
import resource
import signal
import subprocess
import sys
import time
from multiprocessing import Pool
from pathlib import Path

from small_programs import PER_FOLDER, make, tree

HERE = Path(__file__).resolve().parent.parent
ROBOT = HERE / "configs/kuka-kr120-r2500-pro.yaml"
GAPS = "schema: lostmotion/gaps/1\nlogs: [{name: bench, sha256: aa}]\njoints:\n" + "".join(
    f"  - {{joint: A{k}, half_gap_deg: 0.005, ci95: [0.0049, 0.0051], significant: true}}\n" for k in range(1, 7))
# what is killed at each moment
KILLED = ("engine and workers", "engine", "engine and workers", "workers", "engine")


def make_many(root, first, end):
    for i in range(first, end):
        make(root, i)


def processes(session):
    """The live processes of a session: `(number, name)`."""
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                name, rest = (entry / "stat").read_text().split("(", 1)[1].rsplit(")", 1)
            except OSError:
                continue
            state, _, _, own = rest.split()[:4]
            if int(own) == session and state != "Z":
                yield int(entry.name), name


class Cell:
    """The workflow over the programs of `cell`, with its results and state in folders of this name."""

    def __init__(self, a, name):
        self.a, self.work, self.name = a, a.work.resolve(), name
        self.results, self.job = self.work / f"{name}-results", self.work / f"{name}-job"
        shards = max(1, a.programs // a.per_shard)
        options = [f"programs={self.work / 'cell'}", f"results={self.results}", f"work={self.job}", f"robot={ROBOT}", "threads=1"]
        options += [f"compensator={self.work / 'compensator.yaml'}", f"shards={shards}", f"binary={a.binary.resolve()}"]
        flow = HERE / "workflows/snakemake"
        self.line = [a.snakemake, "--snakefile", str(flow / "Snakefile"), "--profile", str(flow / "profile"), "--configfile"]
        self.line += [str(flow / "config.yaml"), "--cores", str(a.cores), "--directory", str(self.work / f"{name}-engine")]
        self.line += ["--quiet", "all", "--config", *options]
        (self.work / f"{name}-engine").mkdir(exist_ok=True)
        self.log = open(self.work / f"{name}.log", "ab")

    def start(self):
        return subprocess.Popen(self.line, start_new_session=True, stdout=self.log, stderr=self.log)

    def kill(self, run, what):
        """Kills what is named; gives the number of processes that got it."""
        found = list(processes(run.pid))
        if what != "engine and workers":
            binary = self.a.binary.name[:15]
            found = [p for p in found if (p[1] == binary) == (what == "workers")]
        for number, _ in found:
            try:
                os.kill(number, signal.SIGKILL)
            except ProcessLookupError:
                pass
        return len(found)

    def unlock(self):
        subprocess.run([*self.line, "--unlock"], check=True, stdout=self.log, stderr=self.log)


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("--programs", type=int, default=1_000_000)
    ap.add_argument("--per-shard", type=int, default=2000)
    ap.add_argument("--kills", type=int, default=5)
    ap.add_argument("--cores", type=int, default=2)
    ap.add_argument("--work", type=Path, required=True)
    ap.add_argument("--binary", type=Path, required=True)
    ap.add_argument("--snakemake", default="snakemake")
    ap.add_argument("--seed", type=int, default=1)
    a = ap.parse_args()
    random.seed(a.seed)
    work = a.work.resolve()
    work.mkdir(parents=True, exist_ok=True)
    if not (work / "cell").exists():
        with Pool(a.cores) as pool:
            pool.starmap(make_many, [(work / "cell", k, min(k + PER_FOLDER, a.programs)) for k in range(0, a.programs, PER_FOLDER)])
    (work / "gaps.yaml").write_text(GAPS)
    fit = [a.binary.resolve(), "fit", "--robot", ROBOT, "--gaps", work / "gaps.yaml", "--output", work / "compensator.yaml"]
    subprocess.run(fit, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    start = time.time()
    subprocess.run([a.binary.resolve(), "manifest", work / "cell", "--output", work / "plan.jsonl"], check=True)
    print(f"planned {a.programs} programs in {time.time() - start:.1f} s", flush=True)

    middle = a.programs // PER_FOLDER // 2
    added = make(work / "cell", a.programs, middle)
    start, whole = time.time(), Cell(a, "whole")
    if whole.start().wait() != 0:
        sys.exit("the undisturbed run failed; see whole.log")
    took = time.time() - start
    memory = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    print(f"undisturbed, with the engine: {took:.0f} s, {a.programs / took:.0f} programs/s; the largest process {memory} KB", flush=True)
    added.unlink()

    job = Cell(a, "killed")
    run, began = job.start(), time.time()
    for n in range(a.kills):
        wait, what = random.uniform(0.3, 0.9) * took / (a.kills + 1) + 3, KILLED[n % len(KILLED)]
        try:
            run.wait(wait)
            print(f"moment {n + 1}: the run had ended with {run.returncode}", flush=True)
        except subprocess.TimeoutExpired:
            killed = job.kill(run, what)
            done = len(list((job.job / "parts").glob("*.jsonl")))
            print(f"moment {n + 1}, after {wait:.1f} s: {what} killed, {killed} processes; {done} shards had ended", flush=True)
        if what == "workers" and run.poll() is None:
            continue  # the engine starts them again
        if n == a.kills // 2:
            make(work / "cell", a.programs, middle)
            for planned in ("manifest.jsonl", "summary.jsonl"):
                (job.job / planned).unlink(missing_ok=True)
            print("a program was added", flush=True)
        run.wait()
        job.unlock()
        run = job.start()
    code, again = run.wait(), 0
    while code != 0 and again < 3:
        # a shard whose orphaned twin was still at work was refused; as its user would, start the engine again
        again += 1
        job.unlock()
        code = job.start().wait()
    print(f"the rest: the engine was started {again} times more and ended with {code}; {time.time() - began:.0f} s in all", flush=True)
    wanted, done = tree(whole.results), tree(job.results)
    lists = [(c.job / "summary.jsonl").read_bytes().replace(str(c.results).encode(), b"") for c in (whole, job)]
    lines = lists[1].count(b"\n")
    print(f"undisturbed {wanted}\nkilled      {done}\nsummary: {lines} lines, {'the same' if lists[0] == lists[1] else 'other'} bytes")
    if code != 0 or wanted != done or done[2] or lines != a.programs + 1:
        sys.exit("the trees differ, or something is lost")
    print("the same")


if __name__ == "__main__":
    main()
