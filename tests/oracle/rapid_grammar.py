"""Compares which lines move: the RAPID reader of this project and the ANTLR grammar of RAPID (github.com/antlr/grammars-v4, abb/).

    rapid_grammar.py GENERATED TARGETS FOLDER...

GENERATED is the folder that `antlr4 -Dlanguage=Python3 abbLexer.g4 abbParser.g4` makes (ANTLR 4.13); the runtime `antlr4-python3-runtime`
must be there. TARGETS is `cargo build -p robot-programs --example targets`. The grammar says of itself that it reads data modules (.sys)
alone; whether its parser accepts a file is counted. Its lexer tells words, comments and strings of every file: a line moves where the first
word of a statement begins as a motion instruction does. Output: a table in Markdown, checked in as rapid_grammar.md with the reasons.
"""

import collections
import pathlib
import re
import subprocess
import sys

# what ABB's manual of instructions lists as moving the robot; nothing of this comes from the reader
MOTIONS = re.compile(r"(MoveAbsJ|MoveJ|MoveL|MoveC|Move[JLC](DO|AO|GO|Sync)|MoveExtJ|Trigg[JLC]|TriggAbsJ|Trigg[JL]IOs|Search[LC]|SearchExtJ|Arc[LC](Start|End|\d)?|Spot[LJ]|Disp[LC]|Paint[LC])", re.I)
# after these a statement begins
BEFORE = {";", "then", "else", "do"}


def by_grammar(text, lexer_class, parser_class, antlr4):
    class Faults(antlr4.error.ErrorListener.ErrorListener):
        def __init__(self):
            self.first = None

        def syntaxError(self, recognizer, symbol, line, column, message, e):
            self.first = self.first or f"{line}:{column} {message}"

    faults = Faults()
    lexer = lexer_class(antlr4.InputStream(text))
    lexer.removeErrorListeners()
    stream = antlr4.CommonTokenStream(lexer)
    stream.fill()
    words = [t for t in stream.tokens if t.channel == 0 and t.type != lexer_class.NEWLINE]
    lines = set()
    for before, word in zip([None, *words], words):
        begins = before is None or before.text.lower() in BEFORE or before.line < word.line
        if begins and word.type == lexer_class.IDENTIFIER and MOTIONS.fullmatch(word.text):
            lines.add(word.line)
    stream.seek(0)
    parser = parser_class(stream)
    parser.removeErrorListeners()
    parser.addErrorListener(faults)
    parser.module_()
    return lines, faults.first


def by_reader(targets, path):
    run = subprocess.run([targets, path], capture_output=True, text=True, errors="replace", timeout=60)
    if run.returncode:
        return None, run.stderr.strip()
    return {int(n) for n in re.findall(r"(?m)^" + re.escape(str(path)) + r":(\d+): ", run.stdout)}, None


# the runtime in Python takes minutes for more
LARGEST = 40_000


def main(generated, targets, folders):
    sys.path.insert(0, generated)
    import antlr4
    import antlr4.error.ErrorListener
    from abbLexer import abbLexer
    from abbParser import abbParser

    total, rows, seen = collections.Counter(), [], set()
    endings = {".mod", ".modx", ".prg", ".sys"}
    for path in sorted(p for f in folders for p in pathlib.Path(f).rglob("*") if p.suffix.lower() in endings):
        text = path.read_bytes().decode("latin-1")
        if text in seen:
            continue
        seen.add(text)
        if len(text) > LARGEST:
            total["programs too large for the runtime"] += 1
            continue
        name = "/".join(path.parts[-2:])
        ours, refused = by_reader(targets, path)
        theirs, fault = by_grammar(text, abbLexer, abbParser, antlr4)
        total["programs"] += 1
        total["the grammar accepts" if fault is None else "the grammar does not accept"] += 1
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
    main(sys.argv[1], sys.argv[2], sys.argv[3:])
