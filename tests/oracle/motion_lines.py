"""Compares which lines move: the readers of this project and public grammars for editors (TextMate) of FANUC TP and INFORM.

    motion_lines.py fanuc|inform RULES TARGETS FOLDER...

RULES is a grammar file: `syntaxes/fanuctp.tmLanguage.json` of github.com/alek5k/TPSyntaxHighlighter or `syntaxes/inform.tmLanguage.yaml` of
github.com/tshikina/YaskawaInformSupport; neither is part of this repository. TARGETS is `cargo build -p robot-programs --example targets`.
The rules are applied as an editor does: at each place of a line the rule that matches first, of several the one that stands first. A line
moves where a rule gives the scope of motions to a motion word. Output: a table in Markdown, checked in as motion_lines.md with the reasons.
Needs the modules `regex` (look-behind of any length) and `yaml`.
"""

import collections
import json
import pathlib
import re
import subprocess
import sys

import regex
import yaml

ENDINGS = {"fanuc": ".ls", "inform": ".jbi"}
# INFORM's rules know commands, not what they do
MOVES = re.compile(r"S?(MOV[JLCS]|IMOV)")


def rules_of(path):
    text = path.read_text(encoding="utf-8").replace("\t", " ")
    return json.loads(text) if path.suffix == ".json" else yaml.safe_load(text)


def flat(rules, entries):
    """The rules of a list with those that it includes, in order."""
    for entry in entries:
        if "include" in entry:
            yield from flat(rules, [rules["repository"][entry["include"].lstrip("#")]])
        elif "match" in entry or "begin" in entry:
            yield entry
        elif "patterns" in entry:
            yield from flat(rules, entry["patterns"])


def compiled(entries):
    made = []
    for entry in entries:
        start = regex.compile(entry.get("match") or entry["begin"])
        end = regex.compile(entry["end"]) if "end" in entry and "begin" in entry else None
        made.append((start, end, entry.get("name", "")))
    return made


def tokens(rules, lines):
    """Line, scope and text of every match."""
    inside = None
    for k, line in enumerate(lines, 1):
        at = 0
        while at <= len(line):
            if inside is not None:
                end = inside.search(line, at)
                if not end:
                    break
                inside, at = None, max(end.end(), at + 1)
                continue
            found = [(m.start(), n, m) for n, (start, _, _) in enumerate(rules) if (m := start.search(line, at))]
            if not found:
                break
            _, n, match = min(found, key=lambda f: f[:2])
            yield k, rules[n][2], match.group().strip()
            inside = rules[n][1]
            at = match.end() if match.end() > match.start() else match.end() + 1


def by_grammar(language, rules, text):
    lines = text.splitlines(keepends=True)
    if language == "fanuc":
        known = compiled(flat(rules, rules["patterns"]))
        return {k for k, scope, word in tokens(known, lines) if scope == "invalid.illegal" and word in list("JLCA")}
    first = next((k for k, line in enumerate(lines) if line.startswith("//INST")), len(lines))
    known = compiled(flat(rules, rules["repository"]["metainst"]["patterns"]))
    body = [line.rstrip("\r\n") for line in lines[first + 1 :]]
    found = tokens(known, body)
    return {k + first + 1 for k, scope, word in found if scope == "support.function.inform" and MOVES.fullmatch(word)}


def by_reader(targets, path):
    axes = ",".join(f"A{k}:pulse" for k in range(1, 7))
    run = subprocess.run([targets, path, axes], capture_output=True, text=True, errors="replace", timeout=60)
    if run.returncode:
        return None, run.stderr.strip()
    return {int(n) for n in re.findall(r"(?m)^" + re.escape(str(path)) + r":(\d+): ", run.stdout)}, None


def main(language, rules, targets, folders):
    rules = rules_of(pathlib.Path(rules))
    total, rows, seen = collections.Counter(), [], set()
    for path in sorted(p for f in folders for p in pathlib.Path(f).rglob("*") if p.suffix.lower() == ENDINGS[language]):
        text = path.read_bytes().decode("latin-1")
        if text in seen:
            continue
        seen.add(text)
        name = "/".join(path.parts[-2:])
        ours, refused = by_reader(targets, path)
        theirs = by_grammar(language, rules, text)
        total["programs"] += 1
        if ours is None:
            total["the reader refuses"] += 1
            rows.append((name, "refused", refused.split(": found")[-1][:100]))
            continue
        total["motions of both"] += len(ours & theirs)
        rest = text.splitlines()
        for k, lines in (("motions of the reader alone", ours - theirs), ("motions of the grammar alone", theirs - ours)):
            total[k] += len(lines)
            if lines:
                rows.append((f"{name}:{min(lines)}", k, f"`{rest[min(lines) - 1].strip()[:70]}` ({len(lines)})"))
    print("| | |\n| --- | --- |")
    for key, count in total.items():
        print(f"| {key} | {count} |")
    print("\n| program | | what |\n| --- | --- | --- |")
    for row in rows:
        print("| " + " | ".join(c.replace("|", "/") for c in row) + " |")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], sys.argv[3], sys.argv[4:])
