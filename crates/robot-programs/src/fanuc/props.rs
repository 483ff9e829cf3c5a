//! Random programs and random damage.

use super::Fanuc;
use crate::script::harness::{self, Outcome, applied, generator, random_edits};
use proptest::prelude::*;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use std::fmt::Write;

pub(super) use crate::fixtures::m10ia;

/// A program: joints, rails, poses; moves with speeds, ends and options; whatever else stands between.
fn generate(rng: &mut ChaCha8Rng) -> Vec<u8> {
    let ending = if rng.random_bool(0.5) { "\r\n" } else { "\n" };
    let (bare, rail) = (rng.random_bool(0.5), rng.random_bool(0.3));
    let positions: Vec<u32> = (0..rng.random_range(1..6)).map(|i| i * rng.random_range(1..3) + 1).collect();
    let positions: std::collections::BTreeSet<u32> = positions.into_iter().collect();
    let mut body = String::new();
    let mut n = 0;
    let mut line = |text: &str| {
        n += 1;
        let _ = write!(body, "{n:4}:{text} ;{ending}");
        n
    };
    let mut last = line("  !made");
    for _ in 0..rng.random_range(0..15) {
        let pick = |rng: &mut ChaCha8Rng, list: &[&'static str]| list[rng.random_range(0..list.len())];
        let p = *positions.iter().nth(rng.random_range(0..positions.len())).unwrap();
        last = match rng.random_range(0..8) {
            0 => line(pick(
                rng,
                &[
                    "  WAIT   .50(sec)",
                    "  LBL[1]",
                    "  CALL X",
                    "  !lostmotion: off",
                    "",
                    "  FOR R[1]=1 TO 3",
                    "  DO[1]=ON",
                ],
            )),
            1 => line(&format!(
                "L P[{p}] 100mm/sec CNT50 {}",
                pick(rng, &["", "ACC80", "DO[1]=ON", "Weld End[1]", "Skip,LBL[1]", "INC"])
            )),
            2 => line(&format!("  PR[2]=P[{p}]")),
            _ => line(&format!(
                "J P[{p}:x] {} {} {}",
                pick(rng, &["100%", "5%", "R[1]%"]),
                pick(rng, &["FINE", "CNT100", "CNT R[2]"]),
                pick(rng, &["   ", "ACC50", "TB .1sec,CALL A"])
            )),
        };
    }
    let mut pos = String::new();
    for p in &positions {
        let _ = write!(pos, "P[{p}]{{{ending}   GP1:{ending}\tUF : 0, UT : 1,\t");
        for j in 1..=6 {
            let v: f64 =
                if rng.random_bool(0.2) { rng.random_range(-1.0..1.0) } else { rng.random_range(-180.0..180.0) };
            let mut t = format!("{v:.3}");
            if bare && v.abs() < 1.0 {
                t = t.replace("0.", ".");
            }
            let _ = write!(
                pos,
                "{}\tJ{j}={t:>10} deg{}",
                if j % 3 == 1 { ending } else { "" },
                if j < 6 { "," } else { "" }
            );
        }
        pos += ending;
        if rail {
            let mm = if rng.random_bool(0.7) { "0.000" } else { "800.000" };
            let _ = write!(pos, "   GP2:{ending}\tUF : 0, UT : 1,{ending}\tJ1={mm:>10}  mm{ending}");
        }
        let _ = write!(pos, "}};{ending}");
    }
    format!("/PROG  MADE{ending}/ATTR{ending}LINE_COUNT\t= {last};{ending}/APPL{ending}/MN{ending}{body}/POS{ending}{pos}/END{ending}").into_bytes()
}

/// Line numbers count from 1, and the attribute says the last one.
fn counted(bytes: &[u8]) -> bool {
    let text = String::from_utf8_lossy(bytes);
    let body = text.split("/MN").nth(1).and_then(|t| t.split("/POS").next()).unwrap_or_default();
    let numbers: Vec<u64> = body.lines().filter_map(|l| l.split(':').next()?.trim().parse().ok()).collect();
    let last = numbers.last().copied().unwrap_or(0);
    numbers.iter().copied().eq(1..=last) && text.contains(&format!("LINE_COUNT\t= {last};"))
}

proptest! {
    #[test]
    fn a_random_program_moves_as_its_edits_say(seed in any::<u64>()) {
        let mut rng = generator(seed);
        let robot = m10ia();
        let bytes = generate(&mut rng);
        prop_assert!(counted(&bytes));
        let doc = harness::parse(&Fanuc, &bytes, &robot).unwrap();
        let edits = random_edits(doc.script(), &robot, &mut rng);
        for patch in doc.patches(&edits).unwrap().iter() {
            let old = &bytes[patch.span.clone()];
            prop_assert!(old.iter().all(|b| b.is_ascii_digit() || b" .-".contains(b)), "{:?}", patch);
        }
        prop_assert_eq!(harness::kept(&Fanuc, doc.as_ref(), &edits, &robot), Ok(Outcome::Kept));
        prop_assert!(counted(&applied(doc.as_ref(), &edits).unwrap()[0]));
    }
}

#[test]
fn damaged_programs_are_refused_or_edited_exactly() {
    harness::samples_survive(&Fanuc, &m10ia());
}
