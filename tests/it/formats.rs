//! Every vendor format over every sample of it: samples/programs/<format>/.
//!
//! Asked of each: the file is known by its ending and by its content; it is read; no edit changes no byte; the same with other
//! line endings, a Latin-1 byte in a comment, with and without a last line ending, with a byte order mark; random edits come
//! back when the output is read again; and whatever is done to the bytes, nothing panics, hangs or makes a wrong edit.
//!
//! `LOSTMOTION_MUTATIONS` sets the number of mutations of each format (usually few); the ignored test makes 100,000:
//! `cargo test --release --test it formats::a_hundred_thousand -- --ignored --nocapture`.
//!
//! Rooms: [`samples`] the files and their robots; [`edits`] random edits, and whether they came back; [`mutate`] damage;
//! [`variants`] other ways to write the same.

mod edits;
mod mutate;
mod samples;
mod variants;

use edits::Outcome;
use lostmotion::program::formats::{self, FORMATS, Recognised};
use samples::Sample;
use std::path::Path;

/// What went wrong, all of it.
fn none_of(failures: Vec<String>) {
    assert!(failures.is_empty(), "{} failures:\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn every_format_has_samples_and_every_sample_folder_a_format() {
    let folders = samples::folders();
    for format in FORMATS {
        assert!(!samples::of(*format).is_empty(), "samples/programs/{} has no programs", format.name());
    }
    for folder in folders {
        assert!(FORMATS.iter().any(|f| f.name() == folder), "samples/programs/{folder} belongs to no format");
    }
}

#[test]
fn every_sample_is_known_by_its_ending_and_by_its_content() {
    let mut failures = Vec::new();
    for s in samples::all() {
        for path in [s.path.as_path(), Path::new("program.unknown")] {
            let head = &s.texts[0].bytes[..s.texts[0].bytes.len().min(65_536)];
            let found = match formats::recognise(path, head) {
                Recognised::Csv => "csv",
                Recognised::Script(f) => f.name(),
            };
            if found != s.format.name() {
                failures.push(format!("{} as {}: taken for {found}", s.path.display(), path.display()));
            }
        }
        if !formats::is_program(&s.path, None) {
            failures.push(format!("{}: no program by its ending", s.path.display()));
        }
    }
    none_of(failures);
}

#[test]
fn no_edit_changes_no_byte_in_any_way_of_writing() {
    let mut failures = Vec::new();
    for s in samples::all() {
        let own = edits::shape(s.parse().unwrap().script());
        for (name, variant) in variants::of(&s) {
            match variant.parse() {
                Err(e) => failures.push(format!("{} {name}: {e}", s.path.display())),
                Ok(d) => {
                    if edits::shape(d.script()) != own {
                        failures.push(format!("{} {name}: other steps than the sample's", s.path.display()));
                    }
                    if let Err(e) = edits::nothing(&variant, &*d) {
                        failures.push(format!("{} {name}: {e}", s.path.display()));
                    }
                }
            }
        }
    }
    none_of(failures);
}

#[test]
fn random_edits_come_back_when_the_output_is_read_again() {
    let mut failures = Vec::new();
    for format in FORMATS {
        let (mut done, mut refused) = (0, 0);
        for s in samples::of(*format) {
            for (name, variant) in variants::of(&s) {
                // another test covers what is not read
                let Ok(document) = variant.parse() else { continue };
                for seed in 0..20 {
                    let wish = edits::random(&*document, &s.robot, seed);
                    match edits::check(&variant, &*document, &wish) {
                        Ok(Outcome::Edited) => done += 1,
                        Ok(Outcome::Nothing) => {}
                        Ok(Outcome::Refused(why)) => {
                            refused += 1;
                            println!("{} {name}, seed {seed}: {why}", s.path.display());
                        }
                        Err(e) => failures.push(format!("{} {name}, seed {seed}: {e}", s.path.display())),
                    }
                }
            }
        }
        println!("{}: {done} sets of edits came back, {refused} were refused", format.name());
        if done == 0 {
            failures.push(format!("{}: not one set of edits was taken", format.name()));
        }
    }
    none_of(failures);
}

fn mutations(usual: usize) -> usize {
    std::env::var("LOSTMOTION_MUTATIONS").ok().and_then(|v| v.parse().ok()).unwrap_or(usual)
}

fn all_survive(count: usize) {
    let mut failures = Vec::new();
    for format in FORMATS {
        let samples: Vec<Sample> = samples::of(*format);
        if samples.is_empty() {
            continue;
        }
        let tally = mutate::run(&samples, count);
        println!("{}: {tally}", format.name());
        failures.extend(tally.failures.iter().map(|f| format!("{}: {f}", format.name())));
    }
    none_of(failures);
}

#[test]
fn damaged_programs_are_refused_or_edited_rightly() {
    all_survive(mutations(400));
}

#[test]
#[ignore = "minutes; run by hand and before a release"]
fn a_hundred_thousand_damaged_programs_are_refused_or_edited_rightly() {
    all_survive(mutations(100_000));
}
