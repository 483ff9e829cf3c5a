//! Random programs and random damage.

use super::Krl;
use crate::script::harness::{self, Outcome, generator, random_edits};
use proptest::prelude::*;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use std::fmt::Write;

pub(super) use crate::fixtures::kr120;

/// Axis values in any order and style; some axes only where `whole` is false.
fn aggregate(rng: &mut ChaCha8Rng, whole: bool) -> String {
    let mut axes: Vec<usize> = (1..=6).collect();
    for i in (1..6).rev() {
        axes.swap(i, rng.random_range(0..=i));
    }
    let keep = if whole { 6 } else { rng.random_range(1..=6) };
    let mut out = ["{", "{E6AXIS: ", "{AXIS:", "{ "][rng.random_range(0..4)].to_string();
    for (i, axis) in axes[..keep].iter().enumerate() {
        let v: f64 = rng.random_range(-180.0..180.0);
        let value = match rng.random_range(0..6) {
            0 => format!("{v:.0}"),
            1 => format!("{v:.6}"),
            2 => format!("{v:.4E}"),
            3 => "0.0".into(),
            4 => format!("{v:.1}").replace("0.", "."),
            _ => format!("{v:.2}"),
        };
        let _ = write!(out, "{}A{axis} {value}", if i > 0 { [",", ", "][rng.random_range(0..2)] } else { "" });
    }
    out + "}"
}

/// A program and its data list.
fn generate(rng: &mut ChaCha8Rng) -> Vec<Vec<u8>> {
    let ending = if rng.random_bool(0.5) { "\r\n" } else { "\n" };
    let n = rng.random_range(1..5);
    let mut dat = format!("DEFDAT made{ending}");
    for i in 0..n {
        let _ = write!(dat, "DECL E6AXIS XP{i}={}{ending}", aggregate(rng, true));
        let _ = write!(dat, "DECL FDAT FP{i}={{TOOL_NO 1,BASE_NO 0,IPO_FRAME #BASE}}{ending}");
    }
    let _ = write!(dat, "DECL E6AXIS XQ={},XR={}{ending}ENDDAT{ending}", aggregate(rng, true), aggregate(rng, true));
    let mut src =
        format!("&ACCESS RVP{ending}DEF made( ){ending}DECL E6AXIS XLOC{ending}XLOC={}{ending}", aggregate(rng, true));
    for _ in 0..rng.random_range(0..14) {
        let p = rng.random_range(0..n);
        let tail = ["", " C_PTP", " C_PTP C_DIS", " ;note"][rng.random_range(0..4)];
        match rng.random_range(0..9) {
            0 | 1 => {
                let cont = rng.random_bool(0.5);
                let (text, end) = if cont { ("CONT ", " C_PTP") } else { ("", "") };
                let _ = write!(
                    src,
                    ";FOLD PTP P{p} {text}Vel=50 % PDAT1 Tool[1] Base[0];%{{PE}}%R 8.3,%MKUKATPBASIS,%P 1:PTP, 2:P{p}, 7:PDAT1{ending}\
                     $BWDSTART=FALSE{ending}PDAT_ACT=PPDAT1{ending}FDAT_ACT=FP{p}{ending}BAS(#PTP_PARAMS,50){ending}PTP XP{p}{end}{ending};ENDFOLD{ending}"
                );
            }
            2 | 3 => {
                let whole = rng.random_bool(0.5);
                let _ = write!(src, "  PTP {}{tail}{ending}", aggregate(rng, whole));
            }
            4 => {
                let _ = write!(src, "\tptp XP{p}{tail}{ending}");
            }
            5 => {
                let _ = write!(src, "PTP {}{tail}{ending}", ["XQ", "XR", "XLOC", "xq"][rng.random_range(0..4)]);
            }
            6 => {
                let _ = write!(src, "SPTP XP{p} WITH $VEL_AXIS[1]=SVEL_JOINT(40.0), $TOOL=STOOL2(FP{p}) C_SPL{ending}");
            }
            7 => {
                let other = [
                    "WAIT SEC 0.2",
                    "LOOP",
                    "ENDLOOP",
                    "L1:",
                    "WORK( )",
                    "$VEL.CP=0.5",
                    "PTP_REL {A1 5}",
                    "PTP {X 1,Y 2,Z 3,A 0,B 0,C 0}",
                    "TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[1]=TRUE",
                    "PTP XHOME",
                    ";PTP XP0",
                    "LIN {X 1,Y 2,Z 3,A 0,B 0,C 0} C_DIS",
                ];
                let _ = write!(src, "{}{ending}", other[rng.random_range(0..other.len())]);
            }
            _ => {
                let _ = write!(src, "IF XP{p}.A1>0.0 THEN{ending}PTP XP{p}{ending}ENDIF{ending}");
            }
        }
    }
    vec![format!("{src}END{ending}").into_bytes(), dat.into_bytes()]
}

proptest! {
    #[test]
    fn a_random_program_moves_as_its_edits_say(seed in any::<u64>()) {
        let mut rng = generator(seed);
        let robot = kr120();
        let bytes = generate(&mut rng);
        let doc = harness::read(&Krl, &bytes, &robot).unwrap();
        let edits = random_edits(doc.script(), &robot, &mut rng);
        for patch in doc.patches(&edits).unwrap().iter() {
            let old = &bytes[patch.file][patch.span.clone()];
            let plain = |b: &u8| b.is_ascii_alphanumeric() || b"_.+-".contains(b);
            prop_assert!(old.iter().all(plain), "{:?}", patch);
        }
        prop_assert_eq!(harness::kept(&Krl, doc.as_ref(), &edits, &robot), Ok(Outcome::Kept));
    }
}

#[test]
fn damaged_programs_are_refused_or_edited_exactly() {
    let programs = super::tests::samples();
    let source = |rng: &mut ChaCha8Rng| programs[rng.random_range(0..programs.len())].clone();
    harness::survives(&Krl, &kr120(), &source, &|script, rng| random_edits(script, &kr120(), rng));
}
