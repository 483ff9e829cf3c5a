#!/usr/bin/env python3
"""Programs in an object store, with a local S3 server: the results must be those of the same programs in a folder.

  python3 -m venv venv && venv/bin/pip install 'moto[server]'
  cargo build --release --features cloud
  venv/bin/python benches/s3.py --programs 700 --work FOLDER --binary target/release/lostmotion

Starts the server `moto` on this machine, puts small programs of all formats (those of `shards.py`) into a bucket, and compares:
  1. the manifest of the bucket with that of a folder of the same programs;
  2. the results of all shards, put into another prefix, and read from the store to disk, with those of the folder: every byte and note;
  3. the same where workers are killed (SIGKILL) at random moments and started again;
  4. an object that changed since the manifest, and one that is gone: each fails by name, nothing is put for it;
  5. wrong keys of a closed endpoint, a bucket that does not exist: exit code 2 and no summary.
Prints times, requests and the memory of the workers. Exit code 1: something differs.
"""

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import boto3
from moto.server import ThreadedMotoServer

from shards import HERE, MODEL
from small_programs import make, tree

BUCKET = "cells"


class Job:
    def __init__(self, a, work, endpoint):
        self.binary, self.work, self.shards = str(a.binary.resolve()), work, a.shards
        self.env = {**os.environ, "AWS_ENDPOINT_URL": endpoint, "AWS_ACCESS_KEY_ID": "test", "AWS_SECRET_ACCESS_KEY": "test",
                    "AWS_REGION": "us-east-1", "RAYON_NUM_THREADS": "2"}
        self.memory = 0

    def line(self, *args):
        return [self.binary, *map(str, args)]

    def call(self, *args, code=0, env=None):
        done = subprocess.run(self.line(*args), env={**self.env, **(env or {})}, capture_output=True, text=True, cwd=self.work)
        if done.returncode != code:
            sys.exit(f"{args}: exit code {done.returncode}, expected {code}\n{done.stderr}")
        return done.stderr

    def shard(self, k, source, results, plan="plan.jsonl"):
        return self.line("rewrite", "--model", "model.yaml", source, "--manifest", plan, "--shard", f"{k}/{self.shards}",
                         "--output-dir", results, "--summary", f"part{k}.jsonl", "--fail-on", "none")

    def run(self, source, results, seconds=None):
        """Runs every shard; with `seconds` it is killed after them. The lines of all summaries."""
        lines = []
        for k in range(1, self.shards + 1):
            (self.work / f"part{k}.jsonl").unlink(missing_ok=True)
            child = subprocess.Popen(self.shard(k, source, results), env=self.env, cwd=self.work, stderr=subprocess.PIPE)
            end = time.time() + (seconds() if seconds else 1e9)
            while True:
                pid, status, usage = os.wait4(child.pid, os.WNOHANG)
                if pid:
                    break
                if time.time() > end:
                    child.send_signal(signal.SIGKILL)
                    end = 1e18
                time.sleep(0.01)
            self.memory = max(self.memory, usage.ru_maxrss)
            child.returncode = status
            if seconds is None:
                if status != 0:
                    sys.exit(f"shard {k}: {status}\n{child.stderr.read().decode()}")
                lines += [json.loads(line) for line in open(self.work / f"part{k}.jsonl")]
        return lines


def download(s3, prefix, folder):
    count = 0
    for page in s3.get_paginator("list_objects_v2").paginate(Bucket=BUCKET, Prefix=prefix):
        for item in page.get("Contents", []):
            path = folder / item["Key"][len(prefix):]
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(s3.get_object(Bucket=BUCKET, Key=item["Key"])["Body"].read())
            count += 1
    return count


def bare(lines):
    return [{k: v for k, v in line.items() if k not in ("input", "output", "reason")} for line in lines]


def check(what, ok):
    print(("the same: " if ok else "DIFFERS: ") + what, flush=True)
    if not ok:
        sys.exit(1)


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("--programs", type=int, default=700)
    ap.add_argument("--shards", type=int, default=3)
    ap.add_argument("--kills", type=int, default=2, help="times that every shard is killed")
    ap.add_argument("--work", type=Path, required=True)
    ap.add_argument("--binary", type=Path, required=True)
    ap.add_argument("--seed", type=int, default=1)
    a = ap.parse_args()
    random.seed(a.seed)
    work = a.work.resolve()
    work.mkdir(parents=True)
    (work / "model.yaml").write_text(MODEL.format(robot=HERE / "configs/kuka-kr120-r2500-pro.yaml"))
    for i in range(a.programs):
        make(work / "cell", i, i % 11)

    server = ThreadedMotoServer(ip_address="127.0.0.1", port=0)
    server.start()
    host, port = server.get_host_and_port()
    endpoint = f"http://127.0.0.1:{port}"
    s3 = boto3.client("s3", endpoint_url=endpoint, aws_access_key_id="test", aws_secret_access_key="test", region_name="us-east-1")
    s3.create_bucket(Bucket=BUCKET)
    keys = []
    for path in sorted(p for p in (work / "cell").rglob("*") if p.is_file()):
        keys.append(str(path.relative_to(work / "cell")))
        s3.put_object(Bucket=BUCKET, Key=f"line 4/{keys[-1]}", Body=path.read_bytes())
    source = f"s3://{BUCKET}/line 4"
    job = Job(a, work, endpoint)

    job.call("manifest", "cell", "--output", "folder.jsonl")
    start = time.time()
    job.call("manifest", source, "--output", "plan.jsonl")
    print(f"{a.programs} programs listed and hashed in {time.time() - start:.1f} s")
    check("the manifest", (work / "folder.jsonl").read_bytes() == (work / "plan.jsonl").read_bytes())

    folder = job.run("cell", "done")
    wanted = tree(work / "done")
    job.memory = 0
    start = time.time()
    lines = job.run(source, f"s3://{BUCKET}/done")
    took = time.time() - start
    print(f"store to store: {took:.1f} s in {a.shards} shards, one after the other; largest memory of a worker {job.memory} KB")
    print(f"{download(s3, 'done/', work / 'from-store')} objects of results")
    check("results in the store", tree(work / "from-store") == wanted and bare(lines) == bare(folder))
    start = time.time()
    again = job.run(source, f"s3://{BUCKET}/done")
    print(f"all of them once more, skipped by their hashes: {time.time() - start:.1f} s")
    check("lines of what is skipped", again == lines)
    lines = job.run(source, "to-disk")
    check("results on disk", tree(work / "to-disk") == wanted and bare(lines) == bare(folder))

    for n in range(a.kills):
        job.run(source, f"s3://{BUCKET}/killed", lambda: random.uniform(0.2, 0.9) * took / a.shards)
        there = download(s3, "killed/", work / f"killed{n}")
        bad = [p for p in (work / f"killed{n}").rglob("*") if p.is_file() and p.read_bytes() != (work / "done" / p.relative_to(work / f"killed{n}")).read_bytes()]
        print(f"kill {n + 1} of every shard: {there} objects of results there, {len(bad)} of them torn")
        check("every object that is there", not bad)
    lines = job.run(source, f"s3://{BUCKET}/killed")
    download(s3, "killed/", work / "after-kills")
    check("results after kills", tree(work / "after-kills") == wanted and bare(lines) == bare(folder))

    changed, gone = keys[3], keys[10]
    s3.put_object(Bucket=BUCKET, Key=f"line 4/{changed}", Body=b"other bytes\n")
    s3.delete_object(Bucket=BUCKET, Key=f"line 4/{gone}")
    reasons = {line["key"]: line["reason"] for line in job.run(source, f"s3://{BUCKET}/changed") if line["status"] == "failed"}
    print(json.dumps(reasons, indent=1))
    check("what fails", sorted(reasons) == sorted([changed, gone]))
    check("what is put", download(s3, "changed/", work / "changed") == len([p for p in (work / "done").rglob("*") if p.is_file() and not p.name.startswith(".lostmotion")])
          - sum((work / "done" / (k + end)).exists() for k in (changed, gone) for end in ("", ".lostmotion.json")))

    for what, line, more in [
        ("a bucket that does not exist", ["manifest", "s3://nowhere/cell", "--output", "none.jsonl"], {}),
        ("an endpoint that is closed", ["manifest", source, "--output", "none.jsonl"], {"AWS_ENDPOINT_URL": "http://127.0.0.1:9"}),
    ]:
        start = time.time()
        words = job.call(*line, code=2, env=more)
        print(f"{what}: exit code 2 after {time.time() - start:.1f} s: {words.strip()}")
        check("no manifest", not (work / "none.jsonl").exists())
    server.stop()


if __name__ == "__main__":
    main()
