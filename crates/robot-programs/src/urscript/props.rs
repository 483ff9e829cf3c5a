//! Random URScripts with random edits, and mutations of the samples.

use super::UrScript;
use crate::script::harness::{self, Outcome, generator, random_edits};
use proptest::prelude::*;
use rand::Rng;
use rand_chacha::ChaCha8Rng;

use crate::fixtures::ur10 as robot;

/// Samples with their moves, and how many of these can be edited.
const SAMPLES: &[(&str, usize, usize)] = &[
    ("literals.script", 6, 6),
    ("variables.script", 10, 7),
    ("blends_and_times.script", 6, 6),
    ("servo_stream.script", 5, 5),
    ("cartesian.script", 6, 2),
    ("exported.script", 3, 3),
    ("flow.script", 8, 8),
];

#[test]
fn every_sample_has_as_many_moves_to_edit_as_it_says() {
    harness::samples_have(&UrScript, &robot(), SAMPLES, true);
}

fn number(rng: &mut ChaCha8Rng) -> String {
    let v: f64 = rng.random_range(-3.1..3.1);
    match rng.random_range(0..7) {
        0 => format!("d2r({:.*})", rng.random_range(0..4), v.to_degrees()),
        1 => format!("{:.*}e-0{}", rng.random_range(0..6), v, rng.random_range(1..6)),
        2 => "0".into(),
        3 => format!(".{:03}", rng.random_range(0..1000)),
        4 => format!("{v}"),
        _ => format!("{:.*}", rng.random_range(1..7), v),
    }
}

fn literal(rng: &mut ChaCha8Rng) -> String {
    let gap = if rng.random_bool(0.1) { ", # ]\n    " } else { [",", ", "][rng.random_range(0..2)] };
    let axes: Vec<String> = (0..6).map(|_| number(rng)).collect();
    format!("[{}]", axes.join(gap))
}

fn program(rng: &mut ChaCha8Rng) -> String {
    let mut out = String::new();
    let names = ["q_home", "Waypoint_1_q", "q"];
    for d in 0..rng.random_range(1..4) {
        out.push_str(&format!("def work{d}():\n"));
        for name in &names[..rng.random_range(1..4)] {
            let qualifier = ["", "", "local ", "global "][rng.random_range(0..4)];
            out.push_str(&format!("  {qualifier}{name} = {}", literal(rng)));
            out.push_str(["\n", " # taught\n"][rng.random_range(0..2)]);
        }
        let mut open = 0;
        for _ in 0..rng.random_range(1..14) {
            statement(rng, &names, &mut open, &mut out);
        }
        out.push_str(&"  end\n".repeat(open));
        out.push_str("end\n");
    }
    if rng.random_bool(0.3) { out.replace('\n', "\r\n") } else { out }
}

fn statement(rng: &mut ChaCha8Rng, names: &[&str], open: &mut usize, out: &mut String) {
    let name = names[rng.random_range(0..names.len())];
    match rng.random_range(0..22) {
        0 | 1 => {
            *open += 1;
            return out.push_str(["  if get_digital_in(1): # a: b\n", "  while x < 3:\n"][rng.random_range(0..2)]);
        }
        2 | 3 if *open > 0 => {
            *open -= 1;
            return out.push_str("  end\n");
        }
        4 => return out.push_str("  sleep(0.5)\n  $ 3 \"it's\"\n"),
        5 => return out.push_str("  elsewhere()\n"),
        6 => return out.push_str("  # lostmotion: on\n  textmsg(\"movej( # \")\n"),
        7 => return out.push_str(&format!("  x = {name}[0] + 1\n")),
        8 => return out.push_str("  movel(p[0.4, 0, 0.3, 0, 3.14, 0], a=1.2, v=0.1)\n"),
        9 if rng.random_bool(0.3) => return out.push_str(&format!("  {name} = {}\n", literal(rng))),
        _ => {}
    }
    let target = if rng.random_bool(0.5) { literal(rng) } else { name.to_string() };
    let call = match rng.random_range(0..8) {
        0 => format!("servoj({target}, t=0.{}, lookahead_time=0.1, gain=300)", rng.random_range(1..9)),
        1 => format!("servoj({target}, 0, 0, 0.008, 0.1, 300)"),
        2 => format!("movel({target}, a=1.2, v=0.25, t=2, r=0.01)"),
        3 => format!("movep({target}, 1.2, 0.25, 0.02)"),
        4 => format!("movej({target}, 1.4, 1.05, 0, 0)"),
        5 => format!("movej({target}, t=3.5)"),
        6 => format!("movej( {target} , a=1.4 , v=speed,\n    r=0.05 )"),
        _ => format!("movej({target}, a=1.4, v=1.05, r=blend)"),
    };
    out.push_str(&format!("  {call}{}\n", ["", " # there"][rng.random_range(0..2)]));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn random_programs_take_random_edits_and_give_them_back(seed in any::<u64>()) {
        let mut rng = generator(seed);
        let source = program(&mut rng);
        let doc = harness::parse(&UrScript, source.as_bytes(), &robot()).map_err(|e| TestCaseError::fail(format!("{e}\n{source}")))?;
        let edits = random_edits(doc.script(), &robot(), &mut rng);
        prop_assert_eq!(harness::kept(&UrScript, doc.as_ref(), &edits, &robot()), Ok(Outcome::Kept), "{}", source);
    }
}

#[test]
fn damaged_programs_never_panic_and_never_take_a_wrong_edit() {
    harness::samples_survive(&UrScript, &robot());
}
