"""Compares which lines move: the KRL reader of this project and the ANTLR grammar of KRL (github.com/antlr/grammars-v4, kuka/krl.g4).

    krl_grammar.py GENERATED TARGETS FOLDER...

GENERATED is the folder that `antlr4 -Dlanguage=Python3 krl.g4` makes (ANTLR 4.13); the runtime `antlr4-python3-runtime` must be there.
TARGETS is `cargo build -p robot-programs --example targets`. Whether the grammar accepts a program is counted; which lines have a motion
word is told by its lexer, also where it does not accept. The grammar knows no SPTP, SLIN and SCIRC, which are left out of the comparison.
Output: a table in Markdown, checked in as krl_grammar.md with the reasons.
"""

import collections
import pathlib
import re
import subprocess
import sys
import threading

MOTIONS = {"PTP", "PTP_REL", "LIN", "LIN_REL", "CIRC", "CIRC_REL"}
# the runtime in Python takes minutes for more
LARGEST = 15_000


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
    lines, before = set(), None
    for token in stream.tokens:
        first = before is None or before.text in ("\n", "\r\n", "\r") or before.line < token.line
        if first and token.channel == 0 and token.text.upper() in MOTIONS:
            lines.add(token.line)
        if token.channel == 0:
            before = token
    stream.seek(0)
    parser = parser_class(stream)
    parser.removeErrorListeners()
    parser.addErrorListener(faults)
    parser.module()
    return lines, faults.first


def by_reader(targets, path, text):
    run = subprocess.run([targets, path], capture_output=True, text=True, errors="replace", timeout=60)
    if run.returncode:
        return None, run.stderr.strip()
    own = re.findall(r"(?m)^" + re.escape(str(path)) + r":(\d+): ", run.stdout)
    rows = text.splitlines()
    plain = {int(n) for n in own if not re.match(r"\s*S(PTP|LIN|CIRC)", rows[int(n) - 1], re.I)}
    return plain, None


def main(generated, targets, folders):
    sys.path.insert(0, generated)
    import antlr4
    import antlr4.error.ErrorListener
    from krlLexer import krlLexer
    from krlParser import krlParser

    total, rows = collections.Counter(), []
    for path in sorted(p for f in folders for p in pathlib.Path(f).rglob("*") if p.suffix.lower() == ".src"):
        text = path.read_text(encoding="latin-1")
        if len(text) > LARGEST:
            total["programs too large for the runtime"] += 1
            continue
        name = "/".join(path.parts[-2:])
        ours, refused = by_reader(targets, path, text)
        theirs, fault = by_grammar(text, krlLexer, krlParser, antlr4)
        total["programs"] += 1
        total["the grammar accepts" if fault is None else "the grammar does not accept"] += 1
        if ours is None:
            total["the reader refuses"] += 1
            rows.append((name, "refused", refused.split(": found")[-1][:100]))
            continue
        total["motions of both"] += len(ours & theirs)
        for k, lines in (("motions of the reader alone", ours - theirs), ("motions of the grammar alone", theirs - ours)):
            total[k] += len(lines)
            if lines:
                rows.append((f"{name}:{min(lines)}", k, f"`{text.splitlines()[min(lines) - 1].strip()[:70]}` ({len(lines)})"))
    print("| | |\n| --- | --- |")
    for key, count in total.items():
        print(f"| {key} | {count} |")
    print("\n| program | | what |\n| --- | --- | --- |")
    for row in rows:
        print("| " + " | ".join(c.replace("|", "/") for c in row) + " |")


if __name__ == "__main__":
    sys.setrecursionlimit(20_000)
    threading.stack_size(256 << 20)
    job = threading.Thread(target=main, args=(sys.argv[1], sys.argv[2], sys.argv[3:]))
    job.start()
    job.join()
