//! What a line assigns, and what else it may do besides: looked at before anything of the line is believed.
//!
//! A line that assigns one variable one value, and does nothing else, is followed. Of any other the names that it may assign are
//! not known after it: two assignments in a line (controls differ in their order), one after `/` or `IF ... THEN`. A computed
//! name may be any, one of the control's own among them. Variables of the control move frames, make the machine signal, or
//! are not followed. A line that stands beside other words, or that is none of these, hides what it does.

use super::lex::expression_end;

/// First parameter that is the control's own.
pub(super) const SYSTEM: u32 = 1000;

/// What a line assigns.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Assignments {
    /// Names that have another value after the line, as they stand in the table of variables.
    pub(super) names: Vec<String>,
    /// The line assigns one name, whatever runs, and nothing else.
    pub(super) plain: bool,
    /// A name is computed.
    pub(super) any: bool,
    /// A variable of the control that moves a frame or a tool.
    pub(super) frame: bool,
    /// A variable of the control by which it signals.
    pub(super) signal: bool,
    /// Something that is not followed at all.
    pub(super) hidden: bool,
}

impl Assignments {
    /// Whether a line assigns, and what; `None`: it does not.
    ///
    /// `assignment = {("N" | "/") {digit}} ["IF" condition "THEN"] "#" name "=" expression`
    pub(super) fn of(line: &[u8]) -> Option<Self> {
        if !line.contains(&b'=') {
            return None;
        }
        let (spaced, cut) = without_comments(line);
        if !spaced.contains('=') || !spaced.contains('#') {
            return None;
        }
        let mut out = Self::default();
        let compact: String = spaced.chars().filter(|c| !c.is_ascii_whitespace()).collect();
        let (body, optional) = body(&compact);
        let (body, conditional) = match body.strip_prefix("IF").and_then(|rest| rest.rsplit_once("THEN")) {
            Some((condition, then)) => {
                out.hidden |= condition.contains('=');
                (then, true)
            }
            None => (body, false),
        };
        out.read(body);
        // a blank in a name is none to some controls
        out.any |= cuts_a_name(&spaced);
        let certain = !optional && !conditional && !cut && !out.any && !out.hidden && !out.frame && !out.signal;
        out.plain = certain && out.names.len() == 1;
        Some(out)
    }

    /// A line in capitals without comments and blanks.
    pub(super) fn compact(line: &[u8]) -> String {
        without_comments(line).0.chars().filter(|c| !c.is_ascii_whitespace()).collect()
    }

    /// Assignments one after the other; anything else hides what the line does.
    fn read(&mut self, body: &str) {
        let mut rest = body;
        while !rest.is_empty() {
            let Some((name, after)) = head(rest) else {
                self.hidden = true;
                return;
            };
            match name {
                Name::Own(name) => self.names.push(name),
                Name::Computed => self.any = true,
                Name::Control(n) => self.control(n),
            }
            let value = after.find('=').map_or(after.len(), |at| {
                // the name of the next one
                after[..at].rfind('#').map_or(at, |hash| after[..hash].trim_end_matches('#').len())
            });
            if !is_expression(&after[..value]) {
                self.hidden = true;
                return;
            }
            rest = &after[value..];
        }
    }

    /// Fanuc's custom macro and LinuxCNC number them differently: what moves something in one of them counts.
    fn control(&mut self, n: u32) {
        match n {
            // outputs; alarm, timers, single block, feed hold, message
            1000..=1199 | 3000..=3004 | 3006 => self.signal = true,
            // tool and work offsets; reference points, G92, work frames
            2001..=2999 | 5161..=5400 | 7001..=7999 | 10001..=19999 => self.frame = true,
            _ => self.hidden = true,
        }
    }
}

enum Name {
    Own(String),
    Computed,
    Control(u32),
}

/// A line in capitals without comments, and whether anything stands after one.
///
/// `line = {any | "(" comment ")"} [";" comment]`
fn without_comments(line: &[u8]) -> (String, bool) {
    let mut out = String::with_capacity(line.len());
    let (mut comment, mut had, mut after) = (false, false, false);
    for &b in line {
        match b {
            b';' if !comment => break,
            b'(' => (comment, had) = (true, true),
            b')' => comment = false,
            _ if comment => {}
            _ => {
                after |= had && !b.is_ascii_whitespace();
                out.push(char::from(b.to_ascii_uppercase()));
            }
        }
    }
    (out, after)
}

/// A line without its number and what switches it off; whether it may be switched off.
///
/// `body = {("N" | "/") {digit}} ...`
fn body(compact: &str) -> (&str, bool) {
    let (mut rest, mut optional) = (compact, false);
    while let Some(after) = rest.strip_prefix(['N', '/']) {
        optional |= rest.starts_with('/');
        rest = after.trim_start_matches(|c: char| c.is_ascii_digit());
    }
    (rest, optional)
}

/// The name that is assigned, and what stands after its `=`.
///
/// `assignment = "#" ("<" name ">" | digit {digit} | computed) "=" ...`
fn head(text: &str) -> Option<(Name, &str)> {
    let rest = text.strip_prefix('#')?;
    if let Some(named) = rest.strip_prefix('<') {
        let (name, after) = named.split_once('>')?;
        let after = after.strip_prefix('=')?;
        let plain =
            !name.is_empty() && name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'.' || b == b'-');
        return plain.then(|| (Name::Own(format!("#<{}>", name.to_ascii_lowercase())), after));
    }
    let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
    if digits > 0
        && let Some(after) = rest[digits..].strip_prefix('=')
    {
        // 0 is nothing, and a number beyond all is none
        let n = rest[..digits].parse::<u32>().ok().filter(|n| *n > 0)?;
        let name = if n < SYSTEM { Name::Own(format!("#{n}")) } else { Name::Control(n) };
        return Some((name, after));
    }
    let end = bracket_end(rest)?;
    let after = rest[end..].strip_prefix('=')?;
    match single_number(&rest[..end]) {
        // another computed name may be one of the control's own, too
        Some(n) if n >= SYSTEM => Some((Name::Control(n), after)),
        _ => Some((Name::Computed, after)),
    }
}

/// After a computed name: `#1` of `##1`, `[...]`.
///
/// `computed = "#" {"#"} {digit} | "[" ... "]"`
fn bracket_end(text: &str) -> Option<usize> {
    if !text.starts_with('[') {
        let after = text.trim_start_matches('#').trim_start_matches(|c: char| c.is_ascii_digit());
        return (text.starts_with('#') && after.len() < text.len()).then(|| text.len() - after.len());
    }
    expression_end(text.as_bytes())
}

/// The number of `[5221]`.
///
/// `number = "[" digit {digit} "]"`
fn single_number(text: &str) -> Option<u32> {
    text.strip_prefix('[')?.strip_suffix(']')?.parse().ok()
}

/// Whether a blank stands in the name of a variable, `# 1` or `#1 0`, where it is not looked for.
fn cuts_a_name(line: &str) -> bool {
    line.match_indices('#').any(|(at, _)| {
        let rest = &line[at + 1..];
        let after = rest.trim_start_matches(|c: char| c.is_ascii_digit());
        let blank = after.trim_start();
        rest.starts_with([' ', '\t'])
            || after.len() < rest.len() && blank.len() < after.len() && blank.starts_with(|c: char| c.is_ascii_digit())
    })
}

/// Words of several letters that stand between two values.
const OPERATORS: [&str; 11] = ["MOD", "AND", "OR", "XOR", "EQ", "NE", "GT", "GE", "LT", "LE", "DIV"];

/// Numbers, names, operators and functions: a letter that stands alone, or a word of another kind, is a word of the block.
///
/// `expression = {digit | "." | "+" | "-" | "*" | "/" | "#" ["<" ... ">"] | "[" | "]" | "," | operator | function "["}`
fn is_expression(value: &str) -> bool {
    let bytes = value.as_bytes();
    let (mut at, mut depth, mut inside) = (0, 0i32, false);
    while let Some(&b) = bytes.get(at) {
        match b {
            b'<' if at > 0 && bytes[at - 1] == b'#' => inside = true,
            b'>' if inside => inside = false,
            _ if inside => {}
            b'[' => depth += 1,
            b']' => depth -= 1,
            b'A'..=b'Z' => {
                let len = bytes[at..].iter().take_while(|b| b.is_ascii_uppercase()).count();
                let word = &value[at..at + len];
                if !OPERATORS.contains(&word) && (len < 2 || bytes.get(at + len) != Some(&b'[')) {
                    return false;
                }
                at += len;
                continue;
            }
            b'0'..=b'9' | b'.' | b'+' | b'-' | b'*' | b'/' | b'#' => {}
            b',' if depth > 0 => {}
            _ => return false,
        }
        if depth < 0 {
            return false;
        }
        at += 1;
    }
    !value.is_empty() && depth == 0 && !inside
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(line: &str) -> Assignments {
        Assignments::of(line.as_bytes()).unwrap_or_else(|| panic!("{line} assigns nothing"))
    }

    #[test]
    fn one_plain_value_is_followed_under_its_name() {
        for (line, name) in [
            ("#1=.5", "#1"),
            ("N10 #<De pth> = [#2*53 + SIN[30]] (deep)", "#<depth>"),
            ("#0100=-3 ; x", "#100"),
            ("#7=ATAN[#2,#3]", "#7"),
            ("#7 = #8 MOD 2", "#7"),
        ] {
            let found = of(line);
            assert!(found.plain && found.names == [name], "{line}: {found:?}");
        }
        for line in ["G1 X#1 F[#2*10]", "IF [#1 EQ 2] GOTO 10", "(#1=3)", "G1 X3 ; #1=4", "M117 a=b"] {
            assert_eq!(Assignments::of(line.as_bytes()), None, "{line}");
        }
    }

    #[test]
    fn names_whose_value_is_not_certain_are_told() {
        for (line, names) in [
            ("/#100=40", vec!["#100"]),
            ("N5/2 #100=40", vec!["#100"]),
            ("#2=5 #3=[#1+#2] #1=30", vec!["#2", "#3", "#1"]),
            ("#100=40 (depth) #100=45", vec!["#100", "#100"]),
            ("IF [#1 EQ 0] THEN #100=45", vec!["#100"]),
            ("#100=4(c)0", vec!["#100"]),
        ] {
            let found = of(line);
            assert!(!found.plain && !found.any && !found.hidden, "{line}: {found:?}");
            assert_eq!(found.names, names, "{line}");
        }
    }

    #[test]
    fn computed_names_control_variables_and_words_beside_are_told() {
        for line in ["#[#4]=3", "##2=4", "# 100=45", "#1 0=45", "#[ABS[3]]=1", "#[100]=3", "#2=1 ##2=4"] {
            let found = of(line);
            assert!(found.any && !found.hidden && !found.plain, "{line}: {found:?}");
        }
        for line in ["#5221=5", "#2501 = 1", "#[5221]=5", "/#5221=5", "#7001=1"] {
            let found = of(line);
            assert!(found.frame && !found.hidden && !found.plain, "{line}: {found:?}");
        }
        for line in ["#3000=1", "#1100=1"] {
            assert!(of(line).signal && !of(line).plain, "{line}");
        }
        for line in [
            "#100=40 (depth) G1 X55",
            "#1=ROUND[3] G1 X5",
            "#[#4]=3 G1 X5",
            "#1=3 G91",
            "#1=3 GOTO 10",
            "#1=A[3]",
            "#1=40,5",
            "#1=[40",
            "#1=#2=40",
            "#1=",
            "#3005=1",
            "#4001=1",
            "#0=1",
            "#99999999999=1",
            "o100 call [#1=3]",
            "WHILE [#1 <= 3] DO1",
            "X=#1",
            "IF [#1=3] THEN #2=4",
            "IF [#1 EQ 3] THEN #2=4 G91",
            "IF [#1 EQ 3] THEN GOTO #2=4",
        ] {
            assert!(of(line).hidden, "{line}: {:?}", of(line));
        }
    }
}
