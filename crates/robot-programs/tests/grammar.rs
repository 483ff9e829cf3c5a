//! The readers of the languages quote the grammar that they read: what is read is seen without following the code.
//!
//! Two rules for the files in [`READERS`], checked on their sources:
//! - A function that compares what it reads with [`SIGNS`] or more signs of the language (bytes, words in patterns, kinds of tokens) has a
//!   grammar line in its doc comment: `` `motion = keyword [via ","] goal` ``.
//! - A word that a grammar line quotes stands in the code of the language, too. So a line that a change of the code leaves behind is found.

use std::fs;
use std::path::Path;

/// Files that read, by the language. Word lists, writers and what interprets a script that has been read are not among them.
const READERS: [(&str, &[&str]); 8] = [
    (
        "krl",
        &[
            "lex.rs",
            "aggregate.rs",
            "calls.rs",
            "data.rs",
            "elsewhere.rs",
            "form.rs",
            "frame.rs",
            "going.rs",
            "led.rs",
            "motion.rs",
            "product.rs",
            "read.rs",
            "read/ahead.rs",
            "read/computed.rs",
            "read/computed/assigned.rs",
            "read/computed/numbers.rs",
            "read/flow.rs",
            "read/goals.rs",
            "read/moves.rs",
            "read/triggers.rs",
            "relative.rs",
            "seam.rs",
            "settings.rs",
            "statement.rs",
            "still.rs",
            "switches.rs",
        ],
    ),
    (
        "fanuc",
        &[
            "calls.rs",
            "flow.rs",
            "instruction.rs",
            "motion.rs",
            "positions.rs",
            "readings.rs",
            "sections.rs",
            "statement.rs",
            "triggers.rs",
            "uses.rs",
        ],
    ),
    ("urscript", &["lex.rs", "arguments.rs", "goals.rs", "moves.rs", "read.rs", "steps.rs", "value.rs"]),
    (
        "gcode",
        &[
            "lex.rs",
            "assignments.rs",
            "callee.rs",
            "calls.rs",
            "cycles.rs",
            "read.rs",
            "routes.rs",
            "survey.rs",
            "variables.rs",
            "words.rs",
        ],
    ),
    (
        "rapid",
        &[
            "lex.rs",
            "arguments.rs",
            "facts.rs",
            "goals.rs",
            "poses.rs",
            "read.rs",
            "rules.rs",
            "statements.rs",
            "steps.rs",
            "steps/motion.rs",
            "value.rs",
        ],
    ),
    (
        "inform",
        &["facts.rs", "flow.rs", "goals.rs", "job.rs", "list.rs", "movement.rs", "read.rs", "shared.rs", "words.rs"],
    ),
    ("trajectory", &["plain/mod.rs", "read.rs", "tree.rs"]),
    ("csv", &["fast.rs", "header.rs", "number.rs", "parser.rs", "record.rs"]),
];

/// Signs of a language in a function from which on it reads some grammar; fewer are those of a helper.
const SIGNS: usize = 4;

/// Kinds of tokens that lexers tell apart. Marks are counted by their bytes.
const KINDS: [&str; 9] = ["Word", "Number", "String", "Quoted", "Assign", "Placeholder", "Comment", "Compare", "Line"];

/// A function of a source file.
struct Function {
    name: String,
    /// Line, from 1.
    line: usize,
    /// Lines of the doc comment, without their slashes.
    doc: Vec<String>,
    body: String,
}

/// The functions of a source as rustfmt leaves it, up to its tests.
fn functions(source: &str) -> Vec<Function> {
    let lines: Vec<&str> = source.lines().collect();
    let end = lines.windows(2).position(|w| w[0] == "#[cfg(test)]" && w[1].starts_with("mod tests {"));
    let lines = &lines[..end.unwrap_or(lines.len())];
    let mut found = Vec::new();
    for (k, line) in lines.iter().enumerate() {
        let head = line.trim_start();
        let Some((before, after)) = head.split_once("fn ").filter(|_| !head.starts_with("//")) else { continue };
        let word = |w: &str| w.starts_with("pub") || matches!(w, "const" | "async");
        if !before.split_ascii_whitespace().all(word) {
            continue;
        }
        let indent = &line[..line.len() - head.len()];
        let above = lines[..k].iter().rev().map(|l| l.trim_start());
        let mut doc: Vec<String> = above
            .take_while(|l| l.starts_with("///") || l.starts_with("#["))
            .filter_map(|l| Some(l.strip_prefix("///")?.trim().to_string()))
            .collect();
        doc.reverse();
        let close = format!("{indent}}}");
        let last = if line.ends_with('}') { k } else { (k..lines.len()).find(|&n| lines[n] == close).unwrap_or(k) };
        let name = after.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        found.push(Function { name, line: k + 1, doc, body: lines[k..=last].join("\n") });
    }
    found
}

/// A piece of Rust: comments left out.
enum Piece<'a> {
    Code(&'a str),
    /// A literal without its quotes; bytes or one character: it is one of the language.
    Literal {
        text: &'a str,
        of_language: bool,
    },
}

/// Length of a literal in quotes at the start of `code`; `None`: a lifetime.
fn literal_len(code: &str) -> Option<usize> {
    let quote = code.chars().next()?;
    if quote == '\'' && !code.starts_with("'\\") && code.chars().nth(2) != Some('\'') {
        return None;
    }
    let mut escaped = false;
    for (at, c) in code.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            _ if c == quote => return Some(at + 1),
            _ => {}
        }
    }
    None
}

/// Cuts a source into code and literals.
fn pieces(source: &str) -> Vec<Piece<'_>> {
    let (mut out, mut from, mut at) = (Vec::new(), 0, 0);
    while let Some(c) = source[at..].chars().next() {
        if source[at..].starts_with("//") {
            out.push(Piece::Code(&source[from..at]));
            at += source[at..].find('\n').unwrap_or(source.len() - at);
            from = at;
        } else if let Some(len) = matches!(c, '"' | '\'').then(|| literal_len(&source[at..])).flatten() {
            out.push(Piece::Code(&source[from..at]));
            let of_language = c == '\'' || source[..at].ends_with('b');
            out.push(Piece::Literal { text: &source[at + 1..at + len - 1], of_language });
            at += len;
            from = at;
        } else {
            at += c.len_utf8();
        }
    }
    out.push(Piece::Code(&source[from..]));
    out
}

/// How many signs of its language a function compares with.
fn signs(body: &str) -> usize {
    let pieces = pieces(body);
    let code = |k: Option<usize>| match k.and_then(|k| pieces.get(k)) {
        Some(Piece::Code(code)) => code.trim(),
        _ => "",
    };
    let mut count = 0;
    for (k, piece) in pieces.iter().enumerate() {
        count += match piece {
            Piece::Literal { of_language: true, .. } => 1,
            Piece::Literal { text, .. } => {
                let (before, after) = (code(k.checked_sub(1)), code(Some(k + 1)));
                let pattern = after.starts_with("=>") || after.starts_with('|') && !after.starts_with("||");
                let compared = before.ends_with("==") || before.ends_with("!=");
                usize::from((pattern || compared) && !text.is_empty() && !text.contains(' '))
            }
            Piece::Code(code) => code
                .match_indices("Kind::")
                .filter(|(at, _)| !code[..*at].ends_with(|c: char| c.is_alphanumeric() || c == '_'))
                .filter(|(at, _)| KINDS.iter().any(|kind| code[at + "Kind::".len()..].starts_with(kind)))
                .count(),
        };
    }
    count
}

/// The grammar of a doc line: what stands between its backticks, where that defines a name.
fn grammar(line: &str) -> Option<&str> {
    let rule = line.strip_prefix('`')?;
    let (name, _) = rule.split_once(" = ")?;
    (!name.is_empty() && name.bytes().all(|b| b.is_ascii_lowercase() || b == b'_')).then_some(rule)
}

/// Words of two letters or more between the quotes of a grammar line.
fn quoted_words(rule: &str) -> Vec<String> {
    let (mut out, mut rest) = (Vec::new(), rest_of_quote(rule));
    while let Some((inside, after)) = rest {
        let words = inside.split(|c: char| !(c.is_alphabetic() || c == '_'));
        out.extend(words.filter(|w| w.len() > 1).map(str::to_lowercase));
        rest = rest_of_quote(after);
    }
    out
}

/// What stands in the next quotes, and the text after them. A quote is quoted by the other kind.
fn rest_of_quote(rule: &str) -> Option<(&str, &str)> {
    let at = rule.find(['"', '\''])?;
    let quote = &rule[at..=at];
    rule[at + 1..].split_once(quote)
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// All code of a folder in lower case: files, and files of folders in it.
fn code_of(folder: &Path) -> String {
    let mut all = String::new();
    let mut paths: Vec<_> = fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            all += &code_of(&path);
        } else if path.extension().is_some_and(|e| e == "rs") {
            for piece in pieces(&read(&path)) {
                let (Piece::Code(text) | Piece::Literal { text, .. }) = piece;
                all += &text.to_lowercase();
                all.push('\n');
            }
        }
    }
    all
}

#[test]
fn every_function_that_reads_a_language_quotes_its_grammar() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut without = Vec::new();
    for (language, files) in READERS {
        for file in files {
            let all = functions(&read(&source.join(language).join(file)));
            let quotes = |f: &Function| f.doc.iter().any(|line| grammar(line).is_some());
            assert!(all.iter().any(quotes), "{language}/{file} quotes no grammar: is it a reader?");
            for f in all.iter().filter(|f| signs(&f.body) >= SIGNS && !quotes(f)) {
                without.push(format!("{language}/{file}:{}: {} ({} signs)", f.line, f.name, signs(&f.body)));
            }
        }
    }
    let list = without.join("\n");
    assert!(without.is_empty(), "these functions read and have no line such as `goal = name [index]`:\n{list}");
}

#[test]
fn every_language_names_its_manual_in_the_header_of_its_module() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for (language, _) in READERS {
        let module = read(&source.join(language).join("mod.rs"));
        let header = module.lines().take_while(|l| l.starts_with("//!"));
        let named = header.filter(|l| l.contains("Reference") || l.contains("manual")).count();
        assert!(named > 0, "{language}/mod.rs names no manual and no standard");
    }
}

#[test]
fn a_word_that_a_grammar_quotes_stands_in_the_code_of_its_language() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut unknown = Vec::new();
    for (language, files) in READERS {
        let code = code_of(&source.join(language));
        for file in files {
            for f in functions(&read(&source.join(language).join(file))) {
                for word in f.doc.iter().filter_map(|line| grammar(line)).flat_map(quoted_words) {
                    if !code.contains(&word) {
                        unknown.push(format!("{language}/{file}:{}: {}: `{word}`", f.line, f.name));
                    }
                }
            }
        }
    }
    assert!(unknown.is_empty(), "these words stand in a grammar line alone:\n{}", unknown.join("\n"));
}

#[test]
fn a_function_without_its_grammar_and_a_word_that_no_code_has_are_found() {
    let source = r#"
/// Reads a goal.
fn goal(at: u8) -> bool {
    // b'x', b'y', b'z' and b'w' stand in a comment
    matches!(at, b'[' | b']') || at == b'"' || word(at) == "TO"
}

/// Names 'a letter'.
///
/// `letter = "A" | "BC" | '"' | "Dé"`
pub(super) fn letter<'a>(at: &'a str) -> bool {
    format!("{at} {{").len() == 1
}
"#;
    let found = functions(source);
    let names: Vec<_> = found.iter().map(|f| (f.name.as_str(), f.line, signs(&f.body))).collect();
    assert_eq!(names, [("goal", 3, 4), ("letter", 11, 0)]);
    let rules: Vec<Vec<&str>> = found.iter().map(|f| f.doc.iter().filter_map(|l| grammar(l)).collect()).collect();
    assert_eq!(rules, [vec![], vec![r#"letter = "A" | "BC" | '"' | "Dé"`"#]]);
    assert_eq!(quoted_words(rules[1][0]), ["bc", "dé"]);
}
