#!/usr/bin/env python3
"""Share of the moves of public programs that `rewrite` edits (writes with their offsets), by language, with the reasons for the rest, ranked by moves.

    coverage.py --binary target/fast/lostmotion --corpus FOLDER [--language krl,rapid] [--assume G21,G90] [--prove] [--declare] [--listings] [--approach-unknown] [--json out.json]

FOLDER holds a folder for each language (fanuc, gcode, inform, krl, rapid, urscript) with programs below it; each folder below
is its own project, so that the files beside a program stand beside it. `corpus.tsv`, `projects.tsv` (whole repositories) `fresh.tsv` (drawn after the readers were written) and `held.tsv` (in none of the others) list repositories, commits and paths
of the programs that the figures of the documents were taken from; this script fetches nothing.

Every program is read twice: first to learn which frames and tools it waits for, then with these at zero. The robots are those
of `configs/`, their joint limits widened to two turns and their lengths as they are, halved and doubled (for G-code: without and with
rotary axes), of which the best counts (the programs' own robots are not known), with a half gap of 0.004 deg on each joint. With --prove each program is also written, undone (the bytes must come back), and rewritten again (it must be refused, and is meant to be recognised without its notes, too).
"""

import argparse
import collections
import hashlib
import json
import pathlib
import re
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor

ROBOTS = {
    "fanuc": "fanuc-m10ia.yaml",
    "gcode": "gantry-xyz-ballscrew.yaml",
    "inform": "motoman-ma2010.yaml",
    "krl": "kuka-kr120-r2500-pro.yaml",
    "rapid": "abb-irb1600-6-145.yaml",
    "urscript": "universal-robots-ur10.yaml",
}
ENDINGS = {
    "fanuc": {".ls"},
    "gcode": {".nc", ".ngc", ".gcode", ".tap", ".cnc"},
    "inform": {".jbi"},
    "krl": {".src"},
    "rapid": {".mod", ".modx", ".prg", ".sys"},
    "urscript": {".script", ".urscript"},
}
# robot files of the makers, for --all-robots
MAKERS = {"fanuc": "fanuc-", "inform": "motoman-", "krl": "kuka-", "rapid": "abb-", "urscript": "universal-robots-"}
HALF_GAP_DEG, HALF_GAP_MM = 0.004, 0.01
SIZES = (1.0, 0.5, 2.0)
# of a G-code program it is not known which rotary axes the machine has: without, and with A, B and C
ROTARY = "".join(
    f"  - {{name: {name}, kind: revolute, theta_deg: 0, d_mm: 0, a_mm: 0, alpha_deg: {alpha}, direction: 1, limits_deg: [-1e6, 1e6]}}\n"
    for name, alpha in (("A", 90), ("B", 90), ("C", 0))
)
# what a control's power-on modes say where a G-code program does not; empty: nothing is assumed
ASSUMED = []
# whether calls that are asked for are declared to move nothing, whether listings of position registers are given, and whether stops that may be reached from
# any side are reached over a point
CHOSEN = {"declare": False, "listings": False, "approach_unknown": False}


def robots_of(language):
    """The other six-axis arms of the maker among the bundled robot files."""
    folder = pathlib.Path(__file__).parents[2] / "configs"
    files = sorted(folder.glob(MAKERS[language] + "*.yaml")) if language in MAKERS else []
    six = lambda f: len(re.findall(r"(?m)^  - \{name:(?!.*follows:)", f.read_text())) == 6
    return [f.name for f in files if f.name != ROBOTS[language] and six(f)]


def bench(folder, language, size, robot=None):
    """Robot with wide limits and its model, in `folder`."""
    folder.mkdir(exist_ok=True)
    text = (pathlib.Path(__file__).parents[2] / "configs" / (robot or ROBOTS[language])).read_text()
    text = re.sub(r"(limits_deg:) *(\[[^]]*\]|(\n *- [-.\d]+){2})", r"\1 [-720, 720]", text)
    text = re.sub(r"(limits_mm:) *(\[[^]]*\]|(\n *- [-.\d]+){2})", r"\1 [-100000, 100000]", text)
    text = re.sub(r"\b([da]_mm): *([-.\d]+)", lambda m: f"{m[1]}: {float(m[2]) * size}", text)
    if language == "gcode" and size != 1.0:
        text = re.sub(r"^(?=base:)", ROTARY, text, flags=re.M)
    (folder / "robot.yaml").write_text(text)
    # a joint that follows another has no gap of its own
    joints = re.findall(r"- \{name: *(\w+),(.*)\}", text)
    lines = ["schema: lostmotion/model/1", "robot: robot.yaml", "effects:"]
    for name, rest in joints:
        if "follows:" in rest:
            continue
        gap = f"half_gap_mm: {HALF_GAP_MM}" if "prismatic" in rest else f"half_gap_deg: {HALF_GAP_DEG}"
        lines.append(f"  - {{effect: backlash, joint: {name}, {gap}}}")
    (folder / "model.yaml").write_text("\n".join(lines) + "\n")


def run(binary, *arguments):
    return subprocess.run([binary, *map(str, arguments)], capture_output=True, text=True, errors="replace")


def account(binary, desk, program, extra):
    model = desk / "model.yaml"
    extra = list(extra)
    extra += ASSUMED if program.suffix.lower() in ENDINGS["gcode"] else []
    extra += ["--approach-unknown"] if CHOSEN["approach_unknown"] else []
    out = run(binary, "rewrite", "--model", model, program, "--dry-run", "--json", "--force", *extra)
    try:
        return json.loads(out.stdout), out
    except ValueError:
        return None, out


def measured(binary, desk, program, work, prove):
    """The account of a program with all frames at zero, and what the proof says."""
    listing = [f for f in sorted(program.parent.iterdir()) if f.name.lower() == "posreg.va"] if CHOSEN["listings"] else []
    given = [word for f in listing for word in ("--frames", f)]
    extra, names, calls = given, {"frames": set(), "tools": set()}, set()
    # a call that is declared may let others be asked for
    for _ in range(12 if CHOSEN["declare"] else 4):
        done, out = account(binary, desk, program, extra)
        if done is None:
            return {"failed": out.stderr.strip().splitlines()[:1], "code": out.returncode}
        missing = done.get("missing") or {}
        fresh = False
        for kind in names:
            for name in missing.get(kind) or {}:
                fresh |= name not in names[kind]
                names[kind].add(name)
        asked = set(missing.get("calls") or {}) if CHOSEN["declare"] else set()
        fresh |= not asked <= calls
        calls |= asked
        if not fresh:
            break
        frames = work / "frames.yaml"
        zero = {kind: {n: {"xyz_mm": [0, 0, 0]} for n in sorted(names[kind])} for kind in names}
        frames.write_text(json.dumps({"schema": "lostmotion/frames/1", **zero}))
        extra = [*given, "--frames", frames, *(word for name in sorted(calls) for word in ("--no-motion", name))]
    done["declared"] = sorted(calls)
    if prove and done.get("changes"):
        done["proof"] = proof(binary, desk, program, extra, work)
        if done["proof"] == "ok":
            done["recognised"] = recognised(binary, desk, program, extra, work)
    return done


def proof(binary, desk, program, extra, work):
    extra = list(extra)
    extra += ASSUMED if program.suffix.lower() in ENDINGS["gcode"] else []
    extra += ["--approach-unknown"] if CHOSEN["approach_unknown"] else []
    into = work / "out"
    into.mkdir()
    target = into / program.name
    first = run(binary, "rewrite", "--model", desk / "model.yaml", program, "--output", target, *extra)
    if first.returncode != 0:
        return f"not written ({first.returncode}): {first.stderr.strip().splitlines()[-1:]}"
    if target.read_bytes() == program.read_bytes() and len(list(into.iterdir())) == 1:
        return "the output is the input"
    again = run(binary, "rewrite", "--model", desk / "model.yaml", target, "--output", work / ("again_" + program.name), *extra)
    if again.returncode != 2:
        return f"a second rewrite is not refused ({again.returncode})"
    undone = work / "undone"
    undone.mkdir()
    back = run(binary, "undo", target, "--output", undone / program.name)
    if back.returncode != 0:
        return f"undo ({back.returncode}): {back.stderr.strip().splitlines()[-1:]}"
    for written in sorted(undone.iterdir()):
        if written.read_bytes() != (program.parent / written.name).read_bytes():
            return "undo gives other bytes"
    return "ok"


def recognised(binary, desk, program, extra, work):
    """Is the result refused when its notes are lost?"""
    extra = list(extra)
    extra += ASSUMED if program.suffix.lower() in ENDINGS["gcode"] else []
    extra += ["--approach-unknown"] if CHOSEN["approach_unknown"] else []
    bare = work / "bare"
    bare.mkdir()
    for written in (work / "out").iterdir():
        if not written.name.endswith(".lostmotion.json"):
            (bare / written.name).write_bytes(written.read_bytes())
    again = run(binary, "rewrite", "--model", desk / "model.yaml", bare / program.name, "--output", work / ("bare_" + program.name), *extra)
    return again.returncode == 2


def language_of(binary, corpus, language, prove, threads, all_robots=False):
    folder = corpus / language
    seen, programs = set(), []
    for path in sorted(p for p in folder.rglob("*") if p.suffix.lower() in ENDINGS[language]):
        digest = hashlib.sha1(path.read_bytes()).hexdigest()
        if digest not in seen:
            seen.add(digest)
            programs.append(path)
    with tempfile.TemporaryDirectory() as desk:
        sizes = SIZES[:2] if language == "gcode" else SIZES
        desks = [pathlib.Path(desk) / str(size) for size in sizes]
        for own, size in zip(desks, sizes):
            bench(own, language, size)
        for robot in robots_of(language) if all_robots else ():
            desks.append(pathlib.Path(desk) / robot)
            bench(desks[-1], language, 1.0, robot)

        def one(k):
            best = None
            for own in desks:
                with tempfile.TemporaryDirectory() as work:
                    done = measured(binary, own, programs[k], pathlib.Path(work), prove)
                if best is None or (done.get("editable") or 0) > (best.get("editable") or 0):
                    best = done
                if "failed" in best or best.get("editable") == best.get("moves"):
                    break
                # another arm helps where this one does not reach, or has not the configuration
                reasons = str([r["why"] for r in best.get("not_edited") or []])
                if own == desks[len(sizes) - 1] and not re.search("cannot reach|configuration", reasons):
                    break
            return best

        with ThreadPoolExecutor(threads) as pool:
            return list(zip(programs, pool.map(one, range(len(programs)))))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--binary", required=True)
    parser.add_argument("--corpus", required=True, type=pathlib.Path)
    parser.add_argument("--language", default=",".join(sorted(ROBOTS)))
    parser.add_argument("--prove", action="store_true")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--top", type=int, default=12)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--all-robots", action="store_true", help="try the maker's other bundled arms, too")
    parser.add_argument("--assume", help="modes in which a G-code control starts, such as G21,G90")
    parser.add_argument("--declare", action="store_true", help="declare every call that is asked for to move nothing")
    parser.add_argument("--listings", action="store_true", help="give the POSREG.VA beside a FANUC program")
    parser.add_argument("--approach-unknown", action="store_true", help="reach stops whose side is not known over a point")
    given = parser.parse_args()
    CHOSEN.update(declare=given.declare, listings=given.listings, approach_unknown=given.approach_unknown)
    ASSUMED.extend(["--assume", given.assume] if given.assume else [])
    kept = {}
    for language in given.language.split(","):
        if not (given.corpus / language).is_dir():
            continue
        results = language_of(given.binary, given.corpus, language, given.prove, given.threads, given.all_robots)
        kept[language] = {str(p): r for p, r in results}
        report(language, results, given)
    if given.json:
        given.json.write_text(json.dumps(kept))


def report(language, results, given):
    good = [(p, r) for p, r in results if "failed" not in r]
    bad = [(p, r) for p, r in results if "failed" in r]
    total = lambda key: sum(r.get(key) or 0 for _, r in good)
    moves, joints, poses = total("moves"), total("edited_as_joints"), total("edited_as_poses")
    reverses = [(p, r) for p, r in good if sum(r.get("reversals", [0]) if isinstance(r.get("reversals"), list) else [r.get("reversals") or 0])]
    with_moves = [(p, r) for p, r in good if r.get("moves")]
    gains = [1 for _, r in with_moves if r.get("changes")]
    shares = [((r.get("edited_as_joints") or 0) + (r.get("edited_as_poses") or 0)) / r["moves"] for _, r in with_moves]
    both = [1 for _, r in reverses if r.get("changes")]
    print(
        f"{language}: {len(results)} programs, {len(bad)} refused, {len(with_moves)} with moves, {moves} moves; "
        f"as joints {joints}, as poses {poses}, share {100 * (joints + poses) / max(moves, 1):.1f} %, "
        f"mean of programs {100 * sum(shares) / max(len(shares), 1):.1f} %; reverse {len(reverses)}, of which changed {len(both)}; changed {len(gains)}"
    )
    reasons, where = collections.Counter(), {}
    for path, r in good:
        for reason in r.get("not_edited") or []:
            why = re.sub(r"`[^`]*`", "`…`", reason["why"])
            reasons[why] += reason["moves"]
            where.setdefault(why, collections.Counter())[f"{path.relative_to(given.corpus)}:{reason['lines'][0]}"] += reason["moves"]
    for why, count in reasons.most_common(given.top):
        top = ", ".join(f"{place} ({n})" for place, n in where[why].most_common(2))
        print(f"  {count:6} {why}   [{len(where[why])} programs: {top}]")
    for why, count in collections.Counter(str(r["failed"])[:150] for _, r in bad).most_common(given.top):
        print(f"  refused {count}: {why}")
    if given.prove:
        proofs = collections.Counter(r.get("proof", "unchanged") for _, r in good)
        print("  proof:", dict(proofs))
        count = lambda r: sum(r["reversals"]) if isinstance(r.get("reversals"), list) else r.get("reversals") or 0
        for least in (1, 4):
            known = [(p, r["recognised"]) for p, r in good if "recognised" in r and count(r) >= least]
            print(f"  without their notes recognised: {sum(k for _, k in known)} of {len(known)} with {least} reversals or more")
        print("   ", *[p.relative_to(given.corpus) for p, k in known if not k])
        for path, r in good:
            if r.get("proof") not in (None, "ok"):
                print("   ", path, r["proof"])


if __name__ == "__main__":
    main()
