#!/usr/bin/env python3
"""Many small programs of all formats through shards that are killed: the tree must be that of an undisturbed run.

  shards.py --programs 200000 --kills 5 --workers 2 --work FOLDER --binary LOSTMOTION

Makes the programs (joint-space CSV, KRL, RAPID, FANUC, INFORM, URScript, trajectories; the same bytes each time), plans them, runs
the shards of the plan without a disturbance, keeps the hash of the tree and takes the tree away. Then it runs them again and kills all
workers (SIGKILL) at random moments; after the middle one a program is added. At the end `status` must find nothing left, `merge`
must take all summaries, and the tree must have the same hash as a whole run with the added program. Prints times and memory.
Exit code 1: something differs or is lost. No workflow engine is needed (million.py does the same under one).
"""

import argparse
import json
import math
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

from small_programs import PER_FOLDER, make, tree

HERE = Path(__file__).resolve().parent.parent
MODEL = """schema: lostmotion/model/1
robot: {robot}
registration: {{xyz_mm: [0, 0, 0], rpy_deg: [0, 0, 0]}}
effects:
""" + "".join(f"  - {{effect: backlash, joint: A{k}, half_gap_deg: 0.005}}\n".replace("{", "{{").replace("}", "}}") for k in range(1, 7))



class Job:
    def __init__(self, a, work, done, parts):
        self.binary, self.workers, self.shards = str(a.binary.resolve()), a.workers, max(1, a.programs // a.per_shard)
        self.cell, self.plan, self.done, self.parts = work / "cell", work / "plan.jsonl", work / done, work / parts
        self.model, self.memory = work / "model.yaml", []
        self.env = {**os.environ, "RAYON_NUM_THREADS": "1"}
        self.parts.mkdir(exist_ok=True)

    def call(self, *args):
        return subprocess.run([self.binary, *map(str, args)], check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout

    def rewrite(self, *more):
        return [self.binary, "rewrite", "--model", str(self.model), str(self.cell), "--output-dir", str(self.done), "--fail-on", "none", *map(str, more)]

    def summary(self, k):
        return self.parts / f"{k}.jsonl"

    def run(self, seconds=math.inf, again=False):
        """Runs what has no summary; after so many seconds all workers are killed. True: everything is done."""
        end = time.time() + seconds
        left = [k for k in range(1, self.shards + 1) if again or not self.summary(k).exists()]
        running = {}
        while left or running:
            while left and len(running) < self.workers:
                k = left.pop(0)
                line = self.rewrite("--manifest", self.plan, "--shard", f"{k}/{self.shards}", "--summary", self.summary(k))
                child = subprocess.Popen(line, env=self.env, stdout=subprocess.DEVNULL, stderr=open(self.parts / f"{k}.err", "w"))
                running[child.pid] = (k, child)
            pid, status, usage = os.wait4(-1, os.WNOHANG)
            if pid:
                if status != 0:
                    sys.exit(f"shard {running[pid][0]}: {status}\n" + (self.parts / f"{running[pid][0]}.err").read_text())
                self.memory.append(usage.ru_maxrss)
                del running[pid]
            elif time.time() > end:
                for pid in running:
                    os.kill(pid, signal.SIGKILL)
                for pid in running:
                    os.waitpid(pid, 0)
                return False
            else:
                time.sleep(0.01)
        return True


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("--programs", type=int, default=200_000)
    ap.add_argument("--per-shard", type=int, default=2000)
    ap.add_argument("--kills", type=int, default=5)
    ap.add_argument("--workers", type=int, default=2)
    ap.add_argument("--work", type=Path, required=True)
    ap.add_argument("--binary", type=Path, required=True)
    ap.add_argument("--seed", type=int, default=1)
    a = ap.parse_args()
    random.seed(a.seed)
    work = a.work.resolve()
    work.mkdir(parents=True, exist_ok=True)
    (work / "model.yaml").write_text(MODEL.format(robot=HERE / "configs/kuka-kr120-r2500-pro.yaml"))
    if not (work / "cell").exists():
        for i in range(a.programs):
            make(work / "cell", i)

    whole = Job(a, work, "done", "parts-whole")
    start = time.time()
    whole.call("manifest", whole.cell, "--output", whole.plan)
    print(f"planned {a.programs} programs in {time.time() - start:.1f} s", flush=True)
    start = time.time()
    whole.run()
    took = time.time() - start
    print(f"undisturbed: {took:.0f} s, {a.programs / took:.0f} programs/s on {a.workers} workers; memory of a shard {min(whole.memory)} to {max(whole.memory)} KB", flush=True)
    start = time.time()
    whole.run(again=True)
    print(f"all of them once more, skipped by their hashes: {time.time() - start:.0f} s", flush=True)
    # the program that is added: what it becomes undisturbed
    added = a.programs
    make(whole.cell, added)
    subprocess.run(whole.rewrite(), check=True, env=whole.env, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    wanted = tree(whole.done)
    shutil.rmtree(whole.done)
    for path in (whole.cell / f"c{added // PER_FOLDER:04d}").glob(f"p{added}.*"):
        path.unlink()

    job = Job(a, work, "done", "parts")
    for n in range(a.kills):
        wait = random.uniform(0.1, 0.9) * took / (a.kills + 1)
        finished = job.run(wait)
        print(f"kill {n + 1}: " + ("all had ended" if finished else f"workers after {wait:.1f} s"), flush=True)
        if n == a.kills // 2:
            make(job.cell, added)
            job.call("manifest", job.cell, "--output", job.plan)
            # summaries of the old plan tell nothing of the new one; what is done is skipped
            for k in range(1, job.shards + 1):
                job.summary(k).unlink(missing_ok=True)
            print("a program was added", flush=True)
    start = time.time()
    job.run()
    print(f"the rest: {time.time() - start:.0f} s; memory of a shard {min(job.memory)} to {max(job.memory)} KB", flush=True)
    parts = [str(job.summary(k)) for k in range(1, job.shards + 1)]
    status = json.loads(job.call("status", "--manifest", job.plan, *parts, "--output-dir", job.done, "--json"))
    job.call("merge", "--manifest", job.plan, *parts, "--output", work / "summary.jsonl")
    lines = [json.loads(line)["status"] for line in open(work / "summary.jsonl")]
    counts = {s: lines.count(s) for s in sorted(set(lines))}
    done = tree(job.done)
    print(f"status: {json.dumps(status)}\nsummary: {len(lines)} lines, {counts}\nundisturbed {wanted}\nkilled      {done}")
    if wanted != done or done[2] or len(lines) != a.programs + 1:
        sys.exit("the trees differ, or something is lost")
    print("the same")


if __name__ == "__main__":
    main()
