//! How a command ends: its exit code, and what is printed of an error.

use crate::assess::bidirectional::Refusal as NoGap;
use crate::error::{BadInput, Error, Place, counted};
use crate::rewrite::Refusal;

/// How a command that did what it was asked for ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Finished {
    /// The job is done and its answer is yes.
    Done,
    /// `--exit-code`, and no program needed a change.
    NothingChanged,
}

impl Finished {
    /// 0, or 3 where nothing needed a change and that was asked.
    pub fn code(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::NothingChanged => 3,
        }
    }
}

/// A command whose answer is no: a check that differs, a threshold that is passed.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct No(pub String);

/// The results of a folder are in place, but their summary or page could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{why}; the results of {} are in place, and the next run goes on from there", counted(*programs, "program"))]
pub struct InPlace {
    /// The error of what could not be written.
    pub why: String,
    /// Programs whose results are in place.
    pub programs: usize,
}

/// The error of a command whose answer is no. One reason a line.
pub fn no(why: impl Into<String>) -> anyhow::Error {
    No(why.into()).into()
}

/// The error of bad input at a place.
pub fn bad(place: Place, found: impl Into<String>, expected: impl Into<String>) -> anyhow::Error {
    Error::bad(place, found, expected).into()
}

/// Exit code of a command's error: that of the library's error in it, else 1 for a no.
pub fn code(error: &anyhow::Error) -> u8 {
    match error.downcast_ref::<Error>() {
        Some(e) => code_of(e),
        None if error.is::<No>() => 1,
        None if error.is::<InPlace>() => UNFINISHED,
        None => INTERNAL,
    }
}

/// Exit code of an error of the library: 0 for a reader that has gone, 1 for a no, 2 for bad input (nothing was written), 4 for a
/// commit that could neither be finished nor taken back, 70 for a mistake of the program itself.
pub fn code_of(error: &Error) -> u8 {
    match error {
        e if e.is_closed_pipe() => 0,
        Error::Refused(_) => 1,
        Error::MendedBy { source, .. } => code_of(source),
        Error::BadInput(_) | Error::UnknownHeader(_) | Error::Setting { .. } | Error::RewrittenAlready(_) => 2,
        Error::Io { .. } => 2,
        Error::Unfinished { .. } => UNFINISHED,
        Error::Internal { .. } => INTERNAL,
    }
}

/// Outputs that belong together are in place in part.
const UNFINISHED: u8 = 4;
/// Of a mistake of the program itself: `EX_SOFTWARE` of sysexits.h.
pub(super) const INTERNAL: u8 = 70;
/// What is printed after a panic.
pub(super) const PANICKED: &str = "an internal error: please report it with the lines above; no file is half written";

/// What is printed of an error: what the command was about, the error in its own words, and the option that helps.
pub fn words(error: &anyhow::Error) -> String {
    let mut parts = Vec::new();
    for cause in error.chain() {
        parts.push(match cause.downcast_ref() {
            Some(Error::Setting { name, found, expected }) => {
                BadInput { place: Place::file(flag(name)), found: found.clone(), expected: expected.clone() }
                    .to_string()
            }
            _ => cause.to_string(),
        });
        // a typed error tells its own source
        if cause.is::<Error>() || cause.is::<No>() || cause.is::<InPlace>() {
            break;
        }
    }
    let option = error.downcast_ref::<Error>().and_then(option).unwrap_or_default();
    parts.join(": ") + &option
}

/// The option for a file that stands in the way of a result.
pub const REPLACE: &str = "--replace replaces it";

/// The option of a setting of the library: they share their names.
fn flag(setting: &str) -> String {
    format!("--{}", setting.replace('_', "-"))
}

/// The option that an error of the library calls for.
pub fn option(error: &Error) -> Option<String> {
    let why = match error {
        Error::Refused(why) => why,
        Error::MendedBy { settings, .. } => {
            let flags: Vec<String> = settings.iter().map(|s| flag(s)).collect();
            return Some(format!(" ({})", flags.join(", ")));
        }
        Error::RewrittenAlready(_) => return Some(" (--force rewrites it anyway)".into()),
        _ => return None,
    };
    let words = match (why.downcast_ref::<Refusal>(), why.downcast_ref::<NoGap>()) {
        (Some(Refusal::NoClock { .. }), _) => "; give --speed-mm-s".into(),
        (Some(Refusal::SumOfAxes), _) => " (leave out --refine and --law)".into(),
        (Some(Refusal::CoarseDigits(coarse)), _) => {
            let joints: Vec<&str> = coarse.iter().map(|c| c.joint.as_str()).collect();
            format!(" (--leave-out {} writes the others)", joints.join(","))
        }
        (Some(Refusal::Foreign { .. }), _) => format!(" ({REPLACE})"),
        (_, Some(NoGap::NoPlay { .. })) => {
            "; if the errors are commanded minus measured, or forward is towards lower positions, use --reversed".into()
        }
        _ => return None,
    };
    Some(words)
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::Context;

    #[test]
    fn each_kind_of_error_has_its_code_and_its_words() {
        let io = |kind: std::io::ErrorKind| anyhow::Error::from(Error::io("out.csv", "write", kind.into()));
        let internal = Error::internal("write JSON", "broken");
        let clock: Error = Refusal::NoClock { joint: "A1".into() }.into();
        for (error, expected) in [
            (io(std::io::ErrorKind::BrokenPipe), 0),
            (clock.into(), 1),
            (no("2 of 3 programs differ"), 1),
            (bad(Place::line("a.csv", 3), "`x`", "a number"), 2),
            (io(std::io::ErrorKind::PermissionDenied), 2),
            (internal.into(), 70),
        ] {
            assert_eq!(code(&error), expected, "{error}");
            assert_eq!(code(&error.context("the first log")), expected);
        }
    }

    #[test]
    fn context_stands_first_and_the_option_last() {
        let clock: Error = Refusal::NoClock { joint: "A1".into() }.into();
        let told = words(&Err::<(), _>(clock).context("step 3 of the demo").unwrap_err());
        assert!(
            told.starts_with("step 3 of the demo: the friction offset of A1") && told.ends_with("--speed-mm-s"),
            "{told}"
        );
        // the source of an error of the system is in its words once
        let io = Error::io("out.csv", "write", std::io::ErrorKind::PermissionDenied.into());
        assert_eq!(words(&io.into()).matches("permission denied").count(), 1);
    }

    /// The library's sources outside the command line, comments left out.
    fn library_sources(folder: &std::path::Path, each: &mut dyn FnMut(&std::path::Path, &str)) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() && !path.ends_with("cli") {
                library_sources(&path, each);
            } else if path.extension().is_some_and(|e| e == "rs") && !path.ends_with("main.rs") {
                let text = std::fs::read_to_string(&path).unwrap();
                let code: Vec<&str> = text.lines().filter(|l| !l.trim_start().starts_with("//")).collect();
                each(&path, &code.join("\n"));
            }
        }
    }

    #[test]
    fn the_library_names_no_option_and_its_settings_are_options() {
        let src = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
        let mut settings = std::collections::BTreeSet::new();
        let string = regex::Regex::new(r#"(?s)"(?:[^"\\]|\\.)*""#).unwrap();
        let set = regex::Regex::new(r#"Error::setting\(\s*"([a-z_]+)"|timed\(path, "([a-z_]+)"\)"#).unwrap();
        let mends = regex::Regex::new(r"mended_by\(&\[([^\]]*)\]\)").unwrap();
        library_sources(&src, &mut |path, code| {
            for found in string.find_iter(code) {
                let text = found.as_str();
                let option = text.match_indices("--").any(|(i, _)| {
                    text[i + 2..].starts_with(|c: char| c.is_ascii_lowercase()) && !text[..i].ends_with(['-', '!'])
                });
                assert!(!option, "{}: {text} names an option", path.display());
            }
            settings.extend(set.captures_iter(code).map(|c| c.get(1).or(c.get(2)).unwrap().as_str().to_string()));
            for list in mends.captures_iter(code) {
                settings.extend(list[1].split(',').map(|s| s.trim().trim_matches('"').to_string()));
            }
        });
        assert!(settings.len() > 15, "{settings:?}");
        let command = crate::cli::help::command();
        let mut options = std::collections::BTreeSet::new();
        let mut waiting = vec![&command];
        while let Some(c) = waiting.pop() {
            options.extend(c.get_arguments().filter_map(|a| a.get_long()).map(|l| format!("--{l}")));
            waiting.extend(c.get_subcommands());
        }
        for setting in &settings {
            assert!(options.contains(&flag(setting)), "no option {}", flag(setting));
        }
    }

    #[test]
    fn a_setting_is_shown_as_its_option() {
        let degree: anyhow::Error = Error::setting("at_state", "5", "at most 3").into();
        assert_eq!(words(&degree), "--at-state: found 5; expected at most 3");
        let short: anyhow::Error = Error::bad(Place::file("a.csv"), "x", "y").mended_by(&["travel_deg", "pose"]).into();
        assert_eq!(words(&short), "a.csv: found x; expected y (--travel-deg, --pose)");
        assert_eq!((code(&degree), code(&short)), (2, 2));
    }
}
