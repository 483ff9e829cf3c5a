//! Command lines that ask for what cannot be: exit code 2, nothing on standard output, nothing written.

use super::{good_folder, listing};
use crate::support;

/// What is asked, and what the refusal says; ours are one line, those of the argument parser more.
const LINES: &[(&str, &[&str])] = &[
    ("identify path --robot robot.yaml --log log.csv --free J1,A9 --output o.yaml", &["--free", "`A9`", "J1, J2, Z"]),
    (
        "identify path --robot robot.yaml --log log.csv --log log.csv --output o.yaml",
        &["log.csv", "found a log that was given before"],
    ),
    ("identify static --robot robot.yaml --log log.csv --log log.csv --output o.yaml", &["log.csv", "every log once"]),
    ("identify path --robot robot.yaml --log log.csv --output - --json", &["--output", "--json", "one document"]),
    ("identify static --robot robot.yaml --log log.csv --output - --json", &["--output", "--json", "one document"]),
    ("identify static --robot robot.yaml --log log.csv --min-dwell-s 0", &["--min-dwell-s", "above 0"]),
    ("identify static --robot robot.yaml --log log.csv --min-dwell-s nan", &["--min-dwell-s", "above 0"]),
    ("identify static --log log.csv", &["--robot"]),
    ("identify path --robot robot.yaml", &["--log"]),
    ("fit --robot robot.yaml --gaps gaps.yaml --output - --json", &["--output", "--json", "one document"]),
    ("fit --robot robot.yaml --gaps gaps.yaml", &["--output"]),
    (
        "fit --robot robot.yaml --gaps gaps.yaml --output o.yaml --valid-until soon",
        &["--valid-until", "`soon`", "date"],
    ),
    ("fit --robot robot.yaml --gaps gaps.yaml --output o.yaml --valid-until 2027-13-01", &["--valid-until", "date"]),
    ("fit --robot robot.yaml --gaps gaps.yaml --output o.yaml --form poses", &["--form poses", "--pose-spacing-mm"]),
    (
        "fit --robot robot.yaml --gaps gaps.yaml --output o.yaml --form poses --pose-spacing-mm=0",
        &["--pose-spacing-mm", "above 0"],
    ),
    (
        "fit --robot robot.yaml --gaps gaps.yaml --output o.yaml --form poses --pose-spacing-mm 1 --speed-mm-s=-1",
        &["--speed-mm-s", "-1", "above 0"],
    ),
    ("fit --robot robot.yaml --gaps gaps.yaml --output o.yaml --speed-mm-s=inf", &["--speed-mm-s", "above 0"]),
    (
        "rewrite --robot robot.yaml --compensator comp.yaml program.csv --output - --json",
        &["--output", "standard output", "--json"],
    ),
    ("rewrite --robot robot.yaml --compensator comp.yaml program.csv", &["--output"]),
    ("rewrite --robot robot.yaml program.csv --output o.csv", &["--compensator"]),
    (
        "rewrite --model model.yaml --robot robot.yaml --compensator comp.yaml program.csv --output o.csv",
        &["cannot be used with"],
    ),
    (
        "rewrite --robot robot.yaml --compensator comp.yaml program.csv --output o.csv --initial-direction A9=+",
        &["A9=+", "J1, J2, Z"],
    ),
    (
        "rewrite --robot robot.yaml --compensator comp.yaml program.csv --output o.csv --initial-direction J1",
        &["--initial-direction J1", "JOINT=+"],
    ),
    (
        "rewrite --robot robot.yaml --compensator comp.yaml program.csv --output o.csv --initial-direction J1=up",
        &["J1=up"],
    ),
    ("rewrite --robot robot.yaml --compensator comp.yaml program.csv --output o.csv --speed-mm-s -5", &["-5"]),
    (
        "rewrite --robot robot.yaml --compensator comp.yaml program.csv --output o.csv --speed-mm-s=-5",
        &["--speed-mm-s -5", "above 0"],
    ),
    (
        "rewrite --robot robot.yaml --compensator comp.yaml program.csv --output o.csv --speed-mm-s nan",
        &["--speed-mm-s NaN"],
    ),
    ("rewrite --robot robot.yaml --compensator comp.yaml program.csv --output o.csv --speed-mm-s 1,5", &["1,5"]),
    (
        "rewrite --robot robot.yaml --compensator comp.yaml program.csv --output o.csv --gain 1.01",
        &["--gain 1.01", "0 to 1"],
    ),
    ("rewrite --robot robot.yaml --compensator comp.yaml program.csv --output o.csv --gain nan", &["--gain NaN"]),
    (
        "rewrite --robot robot.yaml --compensator comp.yaml program.csv --output o.csv --step-fraction 1.5",
        &["--step-fraction 1.5"],
    ),
    ("rewrite --robot robot.yaml --compensator comp.yaml program.csv --output o.csv --chord-um 0", &["--chord-um 0"]),
    ("rewrite --robot robot.yaml --compensator comp.yaml program.csv --output o.csv --ramp-deg=-1", &["--ramp-deg -1"]),
    (
        "rewrite --robot robot.yaml --compensator comp.yaml program.csv --output o.csv --deadband-mm=inf",
        &["--deadband-mm inf"],
    ),
    (
        "rewrite --robot robot.yaml --compensator comp.yaml program.csv --output o.csv --decimals 2",
        &["--decimals", "2 decimals"],
    ),
    ("rewrite --robot robot.yaml --compensator comp.yaml program.csv --output o.csv --decimals 99", &["99"]),
    (
        "rewrite --robot robot.yaml --compensator comp.yaml program.csv --output o.csv --refine smooth",
        &["smooth", "cartesian"],
    ),
    (
        "rewrite --robot robot.yaml --compensator comp.yaml program.csv --output-dir out",
        &["--output-dir", "a folder as IN"],
    ),
    ("rewrite --robot robot.yaml --compensator comp.yaml . --output o.csv", &["a folder as IN", "--output-dir"]),
    ("rewrite --robot robot.yaml --compensator comp.yaml none.csv --output o.csv", &["none.csv: cannot open"]),
    (
        "rewrite --robot robot.yaml --compensator comp.yaml program.csv --check none.csv",
        &["--check: found none.csv", "--output writes it"],
    ),
    (
        "rewrite --robot robot.yaml --compensator comp.yaml . --check none",
        &["--check: found none,", "--output-dir writes"],
    ),
    ("rewrite robot.yaml", &["--robot <FILE>", "--compensator <FILE>", "--output <FILE>"]),
    (
        "rewrite --robot robot.yaml --compensator comp.yaml program.csv --output o.csv --gain 0,8",
        &["'0,8'", "a number, with a point before the decimals, such as 0.8"],
    ),
    ("robot check robot.yaml --pose 0 -90 5", &["separate the numbers by commas, without blanks: --pose 0,-90,5"]),
    ("robot check robot.yaml --pose 0 90 5", &["separate the numbers by commas, without blanks: --pose 0,90,5"]),
    (
        "rewrite --robot robot.yaml --compensator comp.yaml program.csv --output none/o.csv",
        &["--output: found none/o.csv in a folder that does not exist"],
    ),
    ("rewrite --robot robot.yaml --compensator none.yaml program.csv --output o.csv", &["none.yaml: cannot open"]),
    ("rewrite --robot robot.yaml --compensator comp.yaml program.csv --output .", &["found a folder"]),
    ("simulate --model model.yaml --input program.csv --output none/o.csv", &["none/o.csv: cannot write"]),
    (
        "simulate --model model.yaml --input program.csv --output o.csv --speed-mm-s=-5",
        &["--speed-mm-s", "more than 0"],
    ),
    ("simulate --model model.yaml --input program.csv --output o.csv --noise-um=-1", &["--noise-um", "0 or more"]),
    ("simulate --model model.yaml --input program.csv --output o.csv --rate-hz 0", &["--rate-hz", "more than 0"]),
    ("simulate --model model.yaml --input program.csv --output o.csv --seed=-1", &["--seed"]),
    ("simulate --model model.yaml --input . --output o.csv", &["found a folder"]),
    ("identify path --robot robot.yaml --log log.csv --output none/o.yaml", &["none/o.yaml: cannot write"]),
    ("fit --robot robot.yaml --gaps gaps.yaml --output none/o.yaml", &["none/o.yaml: cannot write"]),
    ("assess impact --robot robot.yaml --pose 1,2 --half-gap J1=1", &["--pose 1,2 with 2 values", "J1, J2, Z"]),
    ("assess impact --robot robot.yaml --pose 1,5,2,3 --half-gap J1=1", &["with 4 values"]),
    ("assess impact --robot robot.yaml --pose 1;2;3 --half-gap J1=1", &["with 1 values"]),
    ("assess impact --robot robot.yaml --pose 1,2,up --half-gap J1=1", &["`up` in --pose"]),
    ("assess impact --robot robot.yaml --pose A9@1,2,3 --half-gap J1=1", &["joint `A9`", "J1, J2, Z"]),
    ("assess impact --robot robot.yaml --pose 1,2,3 --half-gap 1,2", &["--half-gap 1,2", "J1, J2, Z"]),
    ("assess impact --robot robot.yaml --pose 1,2,3 --half-gap 1,2,3,4", &["--half-gap 1,2,3,4"]),
    ("assess impact --robot robot.yaml --pose 1,2,3 --half-gap J1=1,J1=2", &["`J1=2`", "one gap"]),
    ("assess impact --robot robot.yaml --pose 1,2,3 --half-gap=-1,0,0", &["`-1`", "0 or more"]),
    ("assess impact --robot robot.yaml --pose 1,2,3", &["--half-gap"]),
];

#[test]
fn values_of_the_command_line_are_refused_by_their_name() {
    let folder = good_folder();
    let before = listing(folder.path());
    let mut wrong = Vec::new();
    for (line, says) in LINES {
        let out = support::run(folder.path(), line);
        let text = out.stderr;
        // the argument parser adds a hint and where to find help
        let brief = text.starts_with("lostmotion: ") && (text.lines().count() == 1 || text.contains("try '--help'"));
        if out.code != Some(2) || !out.stdout.is_empty() || !brief {
            wrong.push(format!("{line}: {:?}, {} bytes on stdout: {text}", out.code, out.stdout.len()));
        }
        wrong.extend(says.iter().filter(|s| !text.contains(**s)).map(|s| format!("{line}: no `{s}` in: {text}")));
        if listing(folder.path()) != before {
            wrong.push(format!("{line}: left {:?}", listing(folder.path())));
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}
