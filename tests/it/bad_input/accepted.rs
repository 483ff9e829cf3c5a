//! Odd names that are none of our business: read, written, and shown in messages as well as they can be.

use super::{ALL, Bad, good_folder};
use crate::support;
use std::ffi::{OsStr, OsString};
use std::path::Path;

/// Runs `identify path`, `fit`, `rewrite` and `simulate` on files that were renamed by `name`; their outputs get such names.
fn the_whole_way(name: &dyn Fn(&str) -> OsString) {
    let folder = good_folder();
    let old = |b: Bad| folder.join(b.file());
    for bad in ALL {
        // a model names its robot by the old name
        if bad != Bad::Robot {
            std::fs::rename(old(bad), folder.join(name(bad.file()))).unwrap();
        }
    }
    let run = |args: &[&OsStr]| {
        support::run_args(folder.path(), args).success();
    };
    let o = |s: &'static str| OsStr::new(s);
    let [log, gaps, comp, program, model] =
        [Bad::Log, Bad::Gaps, Bad::Compensator, Bad::Program, Bad::Model].map(|b| name(b.file()));
    let [found, fitted, out, run_log] = ["found", "fitted", "out", "run"].map(name);
    let robot = [o("--robot"), o("robot.yaml")];
    run(&[&[o("identify"), o("path")], &robot[..], &[o("--log"), &log, o("--output"), &found]].concat());
    run(&[&[o("fit")], &robot[..], &[o("--gaps"), &gaps, o("--output"), &fitted]].concat());
    run(&[&[o("rewrite")], &robot[..], &[o("--compensator"), &comp, &program, o("--output"), &out]].concat());
    run(&[o("simulate"), o("--model"), &model, o("--input"), &out, o("--output"), &run_log]);
    for file in [&found, &fitted, &out, &run_log] {
        assert!(folder.join(Path::new(file)).metadata().unwrap().len() > 100, "{file:?}");
    }
    // and a refusal names the file
    let again = [&[o("rewrite")], &robot[..], &[o("--compensator"), &comp, &out, o("--output"), o("x.csv")]].concat();
    let refused = support::run_args(folder.path(), again);
    let says = refused.stderr;
    assert!(refused.code == Some(2) && says.contains(&lostmotion::io::name::text_of_name(&out)), "{says}");
}

#[test]
fn paths_with_spaces_are_paths() {
    the_whole_way(&|n| format!("my {n}").into());
}

#[test]
fn an_ending_says_nothing_about_a_file() {
    the_whole_way(&|n| format!("{n}.txt").into());
    the_whole_way(&|n| n.replace('.', "_").into());
}

#[cfg(unix)]
#[test]
fn names_that_are_not_utf8_are_read_and_written() {
    use std::os::unix::ffi::OsStringExt;
    the_whole_way(&|n| OsString::from_vec([b"\xe9\xff ", n.as_bytes()].concat()));
}

#[test]
fn a_compensator_past_its_day_is_used_and_said_to_be_old() {
    let folder = good_folder();
    let path = folder.join(Bad::Compensator.file());
    let text = std::fs::read_to_string(&path).unwrap();
    for (day, old) in [("2020-01-31", true), ("9999-12-31", false)] {
        std::fs::write(&path, format!("{text}valid_until: {day}\n")).unwrap();
        let args = ["rewrite", "--robot", "robot.yaml", "--compensator", "comp.yaml", "program.csv", "--dry-run"];
        let out = support::run_args(folder.path(), args);
        let says = &out.stderr;
        assert!(out.succeeded() && says.contains(&format!("comp.yaml: valid until {day}")) == old, "{says}");
    }
}
