//! The fast way and the parser give the same tree wherever the fast way takes a text, whatever the text.

use super::*;
use crate::script::Text;
use proptest::prelude::*;

/// Whether the text is plain; its tree is then that of the parser.
fn compare(source: &[u8]) -> bool {
    let text = Text::new("t.yaml", source.to_vec());
    let Some(fast) = tree(source) else { return false };
    let slow = match Tree::parse(&text) {
        Ok(slow) => format!("{slow:#?}"),
        Err(e) => e.to_string(),
    };
    let fast = format!("{fast:#?}");
    let differ = fast.lines().zip(slow.lines()).find(|(fast, slow)| fast != slow);
    assert!(fast == slow, "{:?}\n{differ:?}", String::from_utf8_lossy(source));
    true
}

#[test]
fn plain_texts_have_the_tree_of_the_parser() {
    for source in [
        "joint_names: [a, b]\npoints:\n- positions: [0.1, -2]\n  time_from_start: {secs: 0, nsecs: 10}\n",
        "joint_names:\n  - a\n  - b\n\npoints:\n  - positions:\n    - 0.1\n    - 2e-3\n    time_from_start:\n      sec: 1\n  -   positions: []  \n      velocities: [ ]\n",
        "---\nheader:\n  stamp: {secs: 0}\n  frame_id: base/link\na: 1\nb:\n- 1\n- x: 2\nc: .5",
        "{\"a\": [1.0,\n\t-2], \"b c\":  {\"d\": [{\"e\": [ ]}, {}]}, f: g}\n\n",
        "[1, [2 , 3 ] , {a: b}]",
        "- a: 1\n  b: 2\n- a: 3\n",
        "- 1\n- [2]\n- {c: d}\n",
        "# é\na: ''  # b\n  # c\nd:   # e\n- 'f g' #h\n- \"\"\n#",
        "{\"a\":[1,2],\"b\":{\"c\":null}}",
    ] {
        assert!(compare(source.as_bytes()), "{source}");
    }
}

#[test]
fn texts_with_more_than_one_meaning_are_left_to_the_parser() {
    for source in [
        "a: &x 1\n",
        "a: *x\n",
        "a: !t 1\n",
        "a: |\n  b\n",
        "a: b c\n",
        "a:\nb: 1\n",
        "a: 1\n---\nb: 2\n",
        "a: 1\n b: 2\n",
        "a: b\n  c\n",
        "a: [1, 2,]\n",
        "a: [1\n, 2]\n",
        "'a': b\n",
        "a: 'b''c'\n",
        "a\n",
        "a: -\n",
        "- - 1\n",
        "a: [-]\n",
        "a: [b: 1]\n",
        "{a: }",
        "{\"a\" : 1}",
        "{a:1}",
        "[a b]",
        "[a] b",
        "[a",
        "a: 1\r\n",
        "\ta: 1\n",
        "",
        "\n",
        "a: é\n",
        "{\"\\u0061\": 1}",
        "  a: 1\n b: 2\n",
        "a:\n  - 1\n - 2\n",
        "a: [1] 2\n",
        "{---: 1}",
        "a: ...\n...\n",
    ] {
        assert_eq!(tree(source.as_bytes()), None, "{source}");
    }
}

#[test]
fn samples_are_mostly_plain_and_have_the_tree_of_the_parser() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../samples/programs/trajectory");
    let files = std::fs::read_dir(folder).unwrap().map(|f| std::fs::read(f.unwrap().path()).unwrap());
    assert!(files.filter(|bytes| compare(bytes)).count() >= 2);
}

/// Numbers that follow from a seed (Steele 2014, splitmix64).
struct Dice(u64);

impl Dice {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) % n as u64) as usize
    }

    fn of<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len())]
    }
}

const WORDS: [&str; 24] = [
    "1",
    "-2.5",
    ".5",
    "1_000",
    "0x10",
    "null",
    "yes",
    "2026-11-23",
    "1e-9",
    "+3",
    "a",
    "positions",
    "base/link",
    "'b c'",
    "\"d # e\"",
    "''",
    "\"\"",
    "1.",
    "-a",
    "010",
    ".inf",
    "'{'",
    "\"]\"",
    "'it: # is'",
];
const KEYS: [&str; 8] = ["a", "b", "positions", "time_from_start", "0", "-1", "x/y", "_"];
const ENDS: [&str; 10] = ["\n", "\n", "\n", "\n", "  \n", " # c\n", "\n\n", "\n # d\n", "\n#\n", " #\n   \n"];

/// A value in brackets, or a word; in JSON with line breaks and quoted keys.
fn flow(d: &mut Dice, depth: usize, json: bool, out: &mut String) {
    let blank = |d: &mut Dice| if json { d.of(&["", " ", "\n", "\t", " \n  "]) } else { d.of(&["", "", " ", "  "]) };
    let shape = if depth == 0 { 0 } else { d.below(4) };
    if shape < 2 {
        return out.push_str(d.of(&WORDS));
    }
    let map = shape == 2;
    out.push(if map { '{' } else { '[' });
    for k in 0..d.below(4) {
        if k > 0 {
            out.push(',');
        }
        out.push_str(blank(d));
        if map {
            match json && d.below(3) > 0 {
                true => *out += &format!("\"{}\":{}", d.of(&KEYS), blank(d)),
                false => *out += &format!("{}: ", d.of(&KEYS)),
            }
        }
        flow(d, depth - 1, json, out);
        out.push_str(blank(d));
    }
    out.push(if map { '}' } else { ']' });
}

/// A list or a mapping by lines, its first line begun already.
fn lines(d: &mut Dice, indent: usize, depth: usize, list: bool, out: &mut String) {
    for k in 0..1 + d.below(3) {
        if k > 0 {
            *out += &" ".repeat(indent);
        }
        if list {
            let gap = 1 + d.below(2);
            *out += &format!("-{}", " ".repeat(gap));
            if depth > 0 && d.below(2) == 0 {
                lines(d, indent + 1 + gap, depth - 1, false, out);
                continue;
            }
        } else {
            *out += &format!("{}:", d.of(&KEYS));
            if depth > 0 && d.below(2) == 0 {
                let inner = d.below(2) == 0;
                let deeper = indent + if inner { d.below(3) } else { 1 + d.below(3) };
                *out += d.of(&ENDS);
                *out += &" ".repeat(deeper);
                lines(d, deeper, depth - 1, inner, out);
                continue;
            }
            *out += d.of(&[" ", " ", "  "]);
        }
        flow(d, depth.min(2), false, out);
        *out += d.of(&ENDS);
    }
}

/// A text that is plain, mostly.
fn plain(d: &mut Dice) -> String {
    let mut out = String::new();
    let depth = d.below(5);
    if d.below(3) == 0 {
        out += d.of(&["", " ", "\n", "\t"]);
        flow(d, depth + 1, true, &mut out);
        out += d.of(&["", "\n", " \n\t"]);
    } else {
        let indent = d.of(&[0, 0, 0, 2]);
        out += d.of(&["", "", "---\n", "# a\n", "\n"]);
        out += &" ".repeat(indent);
        let list = d.below(2) == 0;
        lines(d, indent, depth, list, &mut out);
        if d.below(4) == 0 {
            out.truncate(out.trim_end().len());
        }
    }
    out
}

/// Spoils a text in one place.
fn spoil(d: &mut Dice, bytes: &mut Vec<u8>) {
    const BYTES: &[u8] = b" \t\n\r-:,[]{}#'\"\\&*!|>%@`~?.=<0a\x00\x07\x0b\x0c\x7f\x80\x85\xa0\xc2\xe2\xef\xff";
    let at = d.below(bytes.len() + 1);
    match d.below(6) {
        0 => bytes.insert(at, d.of(BYTES)),
        1 if at < bytes.len() => bytes[at] = d.of(BYTES),
        2 if at < bytes.len() => drop(bytes.remove(at)),
        3 => bytes.truncate(at),
        4 => {
            let (to, end) = (d.below(bytes.len() + 1), (at + d.below(12)).min(bytes.len()));
            let copy = bytes[at.min(end)..end].to_vec();
            bytes.splice(to..to, copy);
        }
        _ => {
            let token = d.of(&[
                "...\n", "---\n", "\n", "- ", "a: ", "\r\n", "\t", " # ", "? ", ": ", "<<: ", "*a", "&a ", "!t ",
                "|\n", "\u{feff}", "  ", "\u{2028}", "\n...\n", "\n--- ",
            ]);
            bytes.splice(at..at, token.bytes());
        }
    }
}

#[test]
fn most_of_the_texts_that_are_made_are_plain() {
    let plain = (0..2000).filter(|&seed| compare(plain(&mut Dice(seed)).as_bytes())).count();
    assert!(plain > 1500, "{plain}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]
    #[test]
    fn any_text_that_is_plain_has_the_tree_of_the_parser(
        parts in proptest::collection::vec(prop_oneof![
            Just("a: "), Just("b:"), Just("- "), Just("-"), Just("\n"), Just("\n  "), Just("\n"), Just("\n    "), Just("1"), Just("-2.5"), Just("["), Just("]"),
            Just("{"), Just("}"), Just(", "), Just(","), Just(" "), Just("\"c\": "), Just("\"d\":"), Just("[1, 2]"), Just("{e: 3}"), Just("x"), Just("---\n"),
            Just("a: 1\n"), Just("b:\n"), Just("- 1\n"), Just("  - 1\n"), Just("- c: 1\n"), Just("  d: [1]\n"), Just("..."), Just("# f\n"), Just(" # g\n"), Just("#"), Just("'h i'"), Just("''"), Just("\"\""), Just("\t"), Just("~"), Just("null"),
        ], 0..14)
    ) {
        compare(parts.concat().as_bytes());
    }

    #[test]
    fn any_plain_text_that_is_spoilt_is_left_to_the_parser_or_has_its_tree(seed in any::<u64>()) {
        let mut d = Dice(seed);
        let mut bytes = plain(&mut d).into_bytes();
        compare(&bytes);
        for _ in 0..8 {
            spoil(&mut d, &mut bytes);
            compare(&bytes);
        }
    }
}
