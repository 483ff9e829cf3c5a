//! Random RAPID programs with random edits, and mutations of the samples.

use super::Rapid;
use crate::script::harness::{self, Outcome, generator, random_edits};
use proptest::prelude::*;
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::fixtures::irb1600 as robot;

/// Samples with their moves, and how many of these can be edited.
const SAMPLES: &[(&str, usize, usize)] = &[
    ("inline_targets.mod", 5, 5),
    ("declared_targets.mod", 8, 8),
    ("run_time_values.mod", 9, 2),
    ("zones_and_speeds.mod", 7, 7),
    ("cartesian_and_process.mod", 10, 2),
    ("flow_and_interrupts.mod", 9, 9),
    ("synchronised.mod", 4, 4),
    ("layout.prg", 4, 4),
];

#[test]
fn every_sample_has_as_many_moves_to_edit_as_it_says() {
    harness::samples_have(&Rapid, &robot(), SAMPLES, false);
}

fn number(rng: &mut ChaCha8Rng) -> String {
    let v: f64 = rng.random_range(-179.0..179.0);
    match rng.random_range(0..8) {
        0 => format!("{:.0}", v),
        1 => format!("{:.*}E-0{}", rng.random_range(0..6), v / 20.0, rng.random_range(1..6)),
        2 => format!("+{:.3}", v.abs()),
        3 => format!(".{:03}", rng.random_range(0..1000)),
        4 => "0".into(),
        5 => format!("{:.0}.", v),
        _ => format!("{:.*}", rng.random_range(1..7), v),
    }
}

fn literal(rng: &mut ChaCha8Rng) -> String {
    let unused = ["9E9", "9E+09", "1E+10", "9e9", "0", "12.5"];
    let gap =
        ["", " ", "\n   ", " ! ]]\n "][rng.random_range(0..4) as usize % if rng.random_bool(0.9) { 2 } else { 4 }];
    let axes: Vec<String> = (0..6).map(|_| if rng.random_bool(0.05) { "9E9".into() } else { number(rng) }).collect();
    let external: Vec<&str> = (0..6).map(|_| unused[rng.random_range(0..unused.len())]).collect();
    format!("[[{}],{gap}[{}]]", axes.join(&format!(",{gap}")), external.join(","))
}

/// A program with declarations of every storage class at three scopes, and moves in and out of blocks.
fn program(rng: &mut ChaCha8Rng) -> String {
    let eol = if rng.random_bool(0.3) { "\r\n" } else { "\n" };
    let mut out = String::new();
    if rng.random_bool(0.2) {
        out.push_str("%%%\n  VERSION:1\n  LANGUAGE:ENGLISH\n%%%\n");
    }
    out.push_str("MODULE Random\n");
    let mut names = Vec::new();
    for n in 0..rng.random_range(1..5) {
        let class =
            ["CONST", "PERS", "VAR", "LOCAL CONST", "LOCAL PERS", "TASK PERS", "LOCAL VAR"][rng.random_range(0..7)];
        let name = format!("{}_{n}", ["jHome", "J", "positionWithAVeryLongName001"][rng.random_range(0..3)]);
        out.push_str(&format!("  {class} jointtarget {name}:={};", literal(rng)));
        out.push_str(["\n", " ! taught\n", " VAR num n;\n"][rng.random_range(0..3)]);
        out = out.replace("VAR num n;", &format!("VAR num n{n};"));
        names.push(name);
    }
    out.push_str(&format!("  CONST jointtarget path{{2}}:=[{},{}];\n", literal(rng), literal(rng)));
    for r in 0..rng.random_range(1..4) {
        out.push_str(&format!("  PROC {}()\n", if r == 0 { "main".into() } else { format!("work{r}") }));
        if rng.random_bool(0.5) {
            let hidden = names[rng.random_range(0..names.len())].clone();
            out.push_str(&format!("    CONST jointtarget {hidden}:={};\n", literal(rng)));
        }
        let mut open = Vec::new();
        for _ in 0..rng.random_range(1..14) {
            statement(rng, &names, &mut open, &mut out);
        }
        while let Some(end) = open.pop() {
            out.push_str(&format!("    {end}\n"));
        }
        out.push_str("  ENDPROC\n");
    }
    out.push_str("ENDMODULE");
    out.replace('\n', eol)
}

fn statement(rng: &mut ChaCha8Rng, names: &[String], open: &mut Vec<&'static str>, out: &mut String) {
    match rng.random_range(0..20) {
        0 => out.push_str("    IF di1=1 THEN ! test\n"),
        1 => out.push_str("    WHILE n<3 DO\n"),
        2 | 3 => {
            if let Some(end) = open.pop() {
                out.push_str(&format!("    {end}\n"));
            }
            return;
        }
        4 => return out.push_str("    WaitTime 0.5; SetDO do1,1;\n"),
        5 => return out.push_str("    Elsewhere;\n"),
        6 => return out.push_str("    ! lostmotion: off\n    TPWrite \"a! [[\";\n"),
        7 => return out.push_str(&format!("    x:={}.robax.rax_1;\n", names[rng.random_range(0..names.len())])),
        8 => return out.push_str("    MoveL Offs(p1,0,0,10),v100,fine,tool0;\n"),
        9 => out.push_str("    IF di2=1 "),
        _ => {}
    }
    let text = out.trim_end_matches([' ', '\n']);
    if text.ends_with("! test") {
        return open.push("ENDIF");
    }
    if text.ends_with(" DO") {
        return open.push("ENDWHILE");
    }
    let target = match rng.random_range(0..5) {
        0 | 1 => literal(rng),
        2 => format!("path{{{}}}", rng.random_range(1..3)),
        _ => names[rng.random_range(0..names.len())].clone(),
    };
    let speed = ["v100", "vmax", "v50\\V:=30", "v100\\T:=1.5", "v100\\T:=2", "vOwn"][rng.random_range(0..6)];
    let zone = ["fine", "z0", "z10", "z50\\Z:=3", "fine\\Inpos:=inpos20", "zOwn"][rng.random_range(0..6)];
    let before = ["", "\\Conc, "][usize::from(rng.random_bool(0.1))];
    let flag = ["", "\\NoEOffs", " \\NoEOffs", "\\ID:=10"][rng.random_range(0..4)];
    let comma = [",", ", ", " , ", ",\n      "][rng.random_range(0..4)];
    let tool = ["tool0", "tGun\\WObj:=wobj0", "tool0 \\WObj:=w1"][rng.random_range(0..3)];
    let word = ["MoveAbsJ", "moveabsj"][usize::from(rng.random_bool(0.1))];
    let indent = if out.ends_with('\n') { "    " } else { "" };
    let end = ["\n", " ! there\n", " "][rng.random_range(0..3)];
    out.push_str(&format!("{indent}{word} {before}{target}{flag}{comma}{speed}{comma}{zone}{comma}{tool};{end}"));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn random_programs_take_random_edits_and_give_them_back(seed in any::<u64>()) {
        let mut rng = generator(seed);
        let source = program(&mut rng);
        let doc = harness::parse(&Rapid, source.as_bytes(), &robot()).map_err(|e| TestCaseError::fail(format!("{e}\n{source}")))?;
        let edits = random_edits(doc.script(), &robot(), &mut rng);
        prop_assert_eq!(harness::kept(&Rapid, doc.as_ref(), &edits, &robot()), Ok(Outcome::Kept), "{}", source);
    }
}

#[test]
fn damaged_programs_never_panic_and_never_take_a_wrong_edit() {
    harness::samples_survive(&Rapid, &robot());
}
