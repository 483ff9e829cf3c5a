//! Random bytes, and random damage to good files: no reader may panic.

use super::{ALL, Bad, C, D, G, L, M, P, R, ROBOT, documents, log_of, map, programs};
use lostmotion::compensator::Compensator;
use lostmotion::gaps::Gaps;
use lostmotion::log::{ColumnMap, Log, plausibility};
use lostmotion::program::Program;
use lostmotion::robot::Robot;

/// Whatever the bytes, a reader answers; a log that is accepted is whole and finite.
fn answer(bad: Bad, bytes: Vec<u8>) {
    use lostmotion::io::input::{Input, decode};
    let robot = Robot::parse("robot.yaml", ROBOT).unwrap();
    let text = || decode("file", bytes.clone());
    match bad {
        R | D => drop(text().and_then(|t| Robot::parse("robot.yaml", &t))),
        M => drop(text().and_then(|t| ColumnMap::parse("map.yaml", &t))),
        G => drop(text().and_then(|t| Gaps::parse("gaps.yaml", &t, &robot))),
        C => drop(text().and_then(|t| Compensator::parse("comp.yaml", &t, &robot))),
        P => {
            let input = Input { name: "program.csv".into(), bytes, sha256: String::new() };
            let Ok(program) = Program::parse(input, &robot) else { return };
            assert!(program.q.iter().all(|q| q.len() == program.len() && q.iter().all(|v| v.is_finite())));
            assert!((0..program.len()).all(|i| program.line(i).is_some()));
        }
        L => {
            let Ok(log) = Log::parse(Input { name: "log.csv".into(), bytes, sha256: String::new() }, &robot) else {
                return;
            };
            assert!(log.cmd.iter().all(|c| c.len() == log.len() && c.iter().all(|v| v.is_finite())));
            assert!(log.tcp_m.is_empty() || log.tcp_m.len() == log.len());
            assert!(log.tcp_m.iter().flatten().all(|p| p.iter().all(|v| v.is_finite())));
            drop(plausibility::check(&log, &robot));
        }
    }
}

proptest::proptest! {
    #[test]
    fn no_bytes_make_a_reader_panic(bytes in proptest::collection::vec(proptest::num::u8::ANY, 0..200)) {
        for bad in ALL {
            answer(bad, bytes.clone());
        }
    }

    #[test]
    fn no_damage_to_a_good_file_makes_a_reader_panic(
        hits in proptest::collection::vec((0.0..1.0_f64, "[-0-9.,;:#\"\\[\\]{}&*!|>%@\n\r\t eNn\u{0}\u{e9}]{0,4}"), 1..6),
        cut in 0.0..1.5_f64,
    ) {
        let map = map("{x_mm: {to: x_mm, unit: m, sign: -1, scale: 2}}");
        for (bad, good) in [(R, ROBOT.to_string()), (M, map), (L, log_of(20, |_, _| {})), (G, documents::gaps()),
            (C, documents::compensator()), (P, programs::good())]
        {
            let mut text: Vec<char> = good.chars().collect();
            for (at, new) in &hits {
                let at = (at * text.len() as f64) as usize;
                let end = (at + 2).min(text.len());
                text.splice(at..end, new.chars());
            }
            text.truncate((cut * text.len() as f64) as usize);
            answer(bad, text.into_iter().collect::<String>().into_bytes());
        }
    }
}
