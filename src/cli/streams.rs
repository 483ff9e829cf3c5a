//! Names of the system for standard input and output, taken as `-` for all commands alike.
//!
//! Where standard output is a file, `/dev/stdout` names that file, and an output under this name would be put in its place with a note
//! in `/dev`.

use std::ffi::OsString;

const NAMES: [&str; 6] = ["/dev/stdout", "/dev/stdin", "/dev/fd/1", "/dev/fd/0", "/proc/self/fd/1", "/proc/self/fd/0"];

/// The arguments with `-` where a name of a standard stream is an argument or the value of an option.
pub fn as_dash(arguments: Vec<OsString>) -> Vec<OsString> {
    let of_folder = |a: &OsString| a.to_str().is_some_and(|a| a.ends_with("-dir") || a == "--root");
    let mut all = Vec::with_capacity(arguments.len());
    for argument in arguments {
        // the name of a folder names no stream
        let same = all.is_empty() || all.last().is_some_and(of_folder);
        all.push(if same { argument } else { dash(&argument).unwrap_or(argument) });
    }
    all
}

/// `None`: the argument names no stream.
fn dash(argument: &OsString) -> Option<OsString> {
    let text = argument.to_str()?;
    let option = NAMES.iter().find_map(|name| text.strip_suffix(name))?;
    let long = option.starts_with("--") && option.ends_with('=') && !option.ends_with("-dir=") && option != "--root=";
    let letters = option.strip_prefix('-').map(|o| o.strip_suffix('=').unwrap_or(o));
    let short = letters.is_some_and(|l| !l.is_empty() && l.chars().all(|c| c.is_ascii_alphabetic()));
    (option.is_empty() || long || short).then(|| format!("{option}-").into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_of_a_stream_is_a_dash_wherever_a_file_may_be_named() {
        let dashed = |line: &str| {
            let words = as_dash(line.split(' ').map(OsString::from).collect());
            words.iter().map(|w| w.to_str().unwrap()).collect::<Vec<_>>().join(" ")
        };
        for (given, taken) in [
            ("lm rewrite /dev/stdin --output /dev/stdout", "lm rewrite - --output -"),
            ("lm x --output=/proc/self/fd/1 -o/dev/fd/1 -qo=/dev/stdout", "lm x --output=- -o- -qo=-"),
            (
                "lm x --output-dir /dev/stdout --output-dir=/dev/stdout",
                "lm x --output-dir /dev/stdout --output-dir=/dev/stdout",
            ),
            ("lm x a/dev/stdout /dev/stdout.csv --x-/dev/stdin", "lm x a/dev/stdout /dev/stdout.csv --x-/dev/stdin"),
            ("/dev/stdout x", "/dev/stdout x"),
        ] {
            assert_eq!(dashed(given), taken);
        }
    }
}
