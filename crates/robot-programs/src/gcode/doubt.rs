//! Constructs after which nothing of a G-code program is certain enough to be edited.
//!
//! A modal macro (G66) runs once more for every block that is added. An assignment that a block-delete switch may leave out, that stands
//! beside other words, whose name is computed or one of the control's own (`#2501`, `#5221` move a work frame) changes values,
//! modes or frames in ways that are not followed here. Such a program is left whole, and the reason names the line.

use crate::script::Text;

/// First parameter that is the control's own.
const SYSTEM: u32 = 1000;

/// Why no move of the program may be edited; `None`: nothing of the kind stands in it.
pub(super) fn doubt(text: &Text) -> Option<String> {
    (0..text.line_count()).find_map(|k| {
        let spaced = without_comments(text.line(k));
        let line: String = spaced.chars().filter(|c| !c.is_ascii_whitespace()).collect();
        let why = if has_modal_macro(&line) {
            "G66 is in the program: every block of it may run a macro"
        } else if line.contains('=') && line.contains('#') && (!is_plain_assignment(&line) || cuts_a_name(&spaced)) {
            "an assignment is in the program that is not one plain value"
        } else {
            return None;
        };
        Some(format!("{why} (line {})", k + 1))
    })
}

/// A line without comments, in capitals.
fn without_comments(line: &[u8]) -> String {
    let mut out = String::with_capacity(line.len());
    let mut comment = false;
    for &b in line {
        match b {
            b';' if !comment => break,
            b'(' => comment = true,
            b')' => comment = false,
            _ if comment => {}
            _ => out.push(char::from(b.to_ascii_uppercase())),
        }
    }
    out
}

/// Whether a blank stands in the name of a variable, `# 1` or `#1 0`, where it is not looked for.
fn cuts_a_name(line: &str) -> bool {
    line.match_indices('#').any(|(at, _)| {
        let rest = &line[at + 1..];
        let behind = rest.trim_start_matches(|c: char| c.is_ascii_digit());
        let blank = behind.trim_start();
        rest.starts_with([' ', '\t'])
            || behind.len() < rest.len()
                && blank.len() < behind.len()
                && blank.starts_with(|c: char| c.is_ascii_digit())
    })
}

fn has_modal_macro(line: &str) -> bool {
    line.match_indices('G').any(|(at, _)| {
        let number: String = line[at + 1..].chars().take_while(|c| c.is_ascii_digit() || *c == '.').collect();
        number.parse::<f64>().is_ok_and(|v| v.floor() == 66.0)
    })
}

/// `N10#1=...` or `#<name>=...` with an expression behind it and no other word.
fn is_plain_assignment(line: &str) -> bool {
    let line = line.strip_prefix('N').map_or(line, |rest| rest.trim_start_matches(|c: char| c.is_ascii_digit()));
    let Some(rest) = line.strip_prefix('#') else { return false };
    let Some((name, value)) = rest.split_once('=') else { return false };
    let named =
        name.len() > 2 && name.starts_with('<') && name.ends_with('>') && !name[1..name.len() - 1].contains(['<', '>']);
    let numbered = !name.is_empty()
        && name.bytes().all(|b| b.is_ascii_digit())
        && name.parse::<u32>().is_ok_and(|n| (1..SYSTEM).contains(&n));
    (named || numbered) && is_expression(value)
}

/// Numbers, operators and functions: a letter that stands alone is a word of the block.
fn is_expression(value: &str) -> bool {
    let mut letters = 0;
    let mut inside_name = false;
    for c in value.chars().chain(std::iter::once(' ')) {
        match c {
            '<' => inside_name = true,
            '>' => inside_name = false,
            _ if inside_name => continue,
            _ if c.is_ascii_alphabetic() => {
                letters += 1;
                continue;
            }
            '0'..='9' | '.' | '+' | '-' | '*' | '/' | '[' | ']' | '#' | ' ' => {}
            _ => return false,
        }
        if letters == 1 {
            return false;
        }
        letters = 0;
    }
    !value.is_empty() && !inside_name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_plain_value_is_no_doubt() {
        for line in [
            "#1=.5",
            "N10 #<depth> = [#2*53 + SIN[30]] (deep)",
            "#100=-3 ; x",
            "IF [#1 EQ 2] GOTO 10",
            "G1 X#1 F[#2*10]",
        ] {
            assert_eq!(doubt(&Text::new("a", line.into())), None, "{line}");
        }
    }

    #[test]
    fn what_runs_macros_moves_frames_or_stands_beside_words_is_a_doubt() {
        for line in [
            "G66 P9100",
            "N5G066.1P1",
            "/#100=40",
            "#100=40 (depth) #100=45",
            "#2=5 #3=[#1+#2] #1=30",
            "#100=40 (depth) G1 X55",
            "#1=ROUND[3] G1 X5",
            "#[#4]=3 G1 X5",
            "#[#4]=3",
            "#1=3 G91",
            "#5221=5",
            "#2501 = 1",
            "##2=4",
            "o100 call [#1=3]",
            "# 100=45",
            "#1 0=45",
        ] {
            let text = format!("G21 G90\n{line}\n");
            assert!(
                doubt(&Text::new("a", text.clone().into_bytes())).is_some_and(|why| why.ends_with("(line 2)")),
                "{line}"
            );
        }
    }
}
