#!/usr/bin/env python3
"""Many small programs through a workflow engine that is killed: the tree must be that of an undisturbed run.

  million.py --programs 1000000 --kills 5 --work FOLDER --binary LOSTMOTION --snakemake SNAKEMAKE

Makes the programs (joint-space CSV, KRL, RAPID; the same bytes each time), plans them, runs the shards without a disturbance into
one folder, then under Snakemake into another one, killing the engine with all its jobs (SIGKILL) at random moments; adds a
program; compares the hashes of both trees. Prints times, memory, and what differs. Exit code 1: something differs or is lost.
"""

import argparse
import hashlib
import math
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent.parent


def rows(i, n):
    return [(10 * math.sin(0.3 * j + i), -90 + 5 * math.cos(0.2 * j + i), 90 + 3 * math.sin(0.5 * j)) for j in range(n)]


def make(root, i):
    folder = root / f"c{i % 1000:03d}"
    if i < 1000:
        folder.mkdir(parents=True, exist_ok=True)
    if i % 3 == 0:
        body = "".join("%.4f,%.4f,%.4f,0.0000,10.0000,0.0000\n" % r for r in rows(i, 20))
        text, ending = "a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n" + body, "csv"
    elif i % 3 == 1:
        body = "".join("PTP {A1 %.4f,A2 %.4f,A3 %.4f,A4 0.0,A5 10.0,A6 0.0}\n" % r for r in rows(i, 15))
        text, ending = f"DEF p{i}( )\n{body}END\n", "src"
    else:
        external = "[9E9,9E9,9E9,9E9,9E9,9E9]"
        body = "".join("  MoveAbsJ [[%.4f,%.4f,%.4f,0,10,0],%s],v500,fine,tool0;\n" % (*r, external) for r in rows(i, 12))
        text, ending = f"MODULE m{i}\n PROC main()\n{body} ENDPROC\nENDMODULE\n", "mod"
    (folder / f"p{i}.{ending}").write_text(text)


def tree(root):
    """Hash over the names and contents below a folder; files that are half written are counted."""
    total, files, half = hashlib.sha256(), 0, 0
    for folder, names, entries in os.walk(root):
        names.sort()
        for name in sorted(entries):
            if name.startswith(".lostmotion"):
                half += not name.startswith(".lostmotion.lock")
                continue
            path = Path(folder) / name
            total.update(str(path.relative_to(root)).encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
            files += 1
    return total.hexdigest(), files, half


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("--programs", type=int, default=1_000_000)
    ap.add_argument("--per-shard", type=int, default=2000)
    ap.add_argument("--kills", type=int, default=5)
    ap.add_argument("--cores", type=int, default=2)
    ap.add_argument("--work", type=Path, required=True)
    ap.add_argument("--binary", type=Path, required=True)
    ap.add_argument("--snakemake", default="snakemake")
    ap.add_argument("--robot", type=Path, default=HERE / "configs/kuka-kr120-r2500-pro.yaml")
    ap.add_argument("--compensator", type=Path, required=True)
    ap.add_argument("--seed", type=int, default=1)
    a = ap.parse_args()
    random.seed(a.seed)
    work = a.work.resolve()
    cell, binary, shards = work / "cell", a.binary.resolve(), max(1, a.programs // a.per_shard)
    if not cell.exists():
        for i in range(a.programs):
            make(cell, i)
    env = {**os.environ, "RAYON_NUM_THREADS": str(a.cores)}
    common = [str(binary), "rewrite", "--robot", str(a.robot.resolve()), "--compensator", str(a.compensator.resolve())]

    start = time.time()
    subprocess.run([str(binary), "manifest", str(cell), "--output", str(work / "plan.jsonl")], check=True, env=env)
    print(f"planned {a.programs} programs in {time.time() - start:.1f} s", flush=True)

    start, parts = time.time(), work / "whole-parts"
    shutil.rmtree(parts, ignore_errors=True)
    parts.mkdir()
    memory = []
    for k in range(1, shards + 1):
        line = common + [str(cell), "--manifest", str(work / "plan.jsonl"), "--shard", f"{k}/{shards}", "--fail-on", "none"]
        line += ["--output-dir", str(work / "whole"), "--summary", str(parts / f"{k}.jsonl")]
        done = subprocess.Popen(line, env=env, stderr=subprocess.DEVNULL)
        _, status, usage = os.wait4(done.pid, 0)
        if status != 0:
            sys.exit(f"shard {k} of the undisturbed run: {status}")
        memory.append(usage.ru_maxrss)
    took = time.time() - start
    print(f"undisturbed: {took:.0f} s, {a.programs / took:.0f} programs/s; memory of a shard {min(memory)} to {max(memory)} KB")

    options = ["--config", f"programs={cell}", f"results={work / 'done'}", f"work={work / 'job'}", f"robot={a.robot.resolve()}"]
    options += [f"compensator={a.compensator.resolve()}", f"shards={shards}", f"binary={binary}", "threads=1"]
    engine = [a.snakemake, "--snakefile", str(HERE / "workflows/snakemake/Snakefile"), "--profile"]
    engine += [str(HERE / "workflows/snakemake/profile"), "--configfile", str(HERE / "workflows/snakemake/config.yaml")]
    engine += ["--cores", str(a.cores), "--directory", str(work / "engine"), "--quiet", "all", *options]
    (work / "engine").mkdir(exist_ok=True)
    unlock = engine + ["--unlock"]
    for n in range(a.kills):
        run = subprocess.Popen(engine, start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        wait = random.uniform(0.1, 0.9) * took / (a.kills + 1) + 3
        try:
            run.wait(wait)
            print(f"kill {n + 1}: the run had ended")
        except subprocess.TimeoutExpired:
            os.killpg(run.pid, signal.SIGKILL)
            run.wait()
            print(f"kill {n + 1}: engine and workers after {wait:.1f} s", flush=True)
        if n == a.kills // 2:
            make(cell, a.programs)
            for planned in ("manifest.jsonl", "summary.jsonl"):
                (work / "job" / planned).unlink(missing_ok=True)
            print("a program was added")
        subprocess.run(unlock, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    start = time.time()
    subprocess.run(engine, check=True, stdout=subprocess.DEVNULL)
    print(f"the rest: {time.time() - start:.0f} s")
    subprocess.run(common + [str(cell), "--output-dir", str(work / "whole"), "--fail-on", "none"], check=True, env=env)
    whole, done = tree(work / "whole"), tree(work / "done")
    lines = sum(1 for _ in open(work / "job" / "summary.jsonl"))
    print(f"undisturbed {whole}\nkilled      {done}\nsummary: {lines} lines")
    if whole[:2] != done[:2] or done[2] or lines != a.programs + (a.kills > 0):
        sys.exit("the trees differ, or something is lost")
    print("the same")


if __name__ == "__main__":
    main()
