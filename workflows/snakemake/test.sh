#!/usr/bin/env bash
# The wrapper on its test files, and the workflow on small programs of seven formats: once undisturbed, once killed and taken up again.
# usage: workflows/snakemake/test.sh BINARY [PROGRAMS [KILLS]]
# Snakemake 9 comes from PyPI into target/snakemake-venv, unless SNAKEMAKE names it.
set -euo pipefail
binary=$(realpath "${1:?usage: workflows/snakemake/test.sh BINARY [PROGRAMS [KILLS]]}")
programs=${2:-350}
kills=${3:-1}
cd "$(dirname "$0")/../.."
snakemake=${SNAKEMAKE:-$PWD/target/snakemake-venv/bin/snakemake}
if [ ! -x "$snakemake" ]; then
  python3 -m venv target/snakemake-venv
  target/snakemake-venv/bin/pip install --quiet 'snakemake>=9,<10'
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# as users have it: the command on the path, the wrapper beside a workflow
mkdir "$work/bin"
ln -s "$binary" "$work/bin/lostmotion"
cp -r workflows/snakemake/wrapper "$work/wrapper"
(cd "$work/wrapper/test" && PATH="$work/bin:$(dirname "$snakemake"):$PATH" "$snakemake" part.jsonl --cores 2 --quiet all)
python3 - "$work/wrapper/test" <<'PY'
import hashlib, json, sys
from pathlib import Path
test = Path(sys.argv[1])
plan = {e["key"]: e for e in map(json.loads, open(test / "manifest.jsonl"))}
lines = {e["key"]: e for e in map(json.loads, open(test / "part.jsonl"))}
assert lines.keys() == plan.keys() and len(plan) == 8, sorted(lines)
for key, line in lines.items():
    assert line["sha256_in"] == plan[key]["sha256"], key
    assert line["status"] == ("failed" if key == "line2/bad.csv" else "written"), line
    if line["status"] == "written":
        out = (test / "done" / key).read_bytes()
        assert out != (test / "cell" / key).read_bytes() and hashlib.sha256(out).hexdigest() == line["sha256_out"], key
print("wrapper: 7 programs written, 1 failed by name, as its test files say")
PY

python3 benches/million.py --programs "$programs" --per-shard 50 --kills "$kills" --work "$work/cells" --binary "$binary" --snakemake "$snakemake"
