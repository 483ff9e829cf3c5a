//! The gaps document: written and read back, and what is refused.

use crate::bench::kuka;
use crate::identify_static::logs;
use lostmotion::gaps::Gaps;
use lostmotion::identify::static_test::{Knots, Options, document, identify};

#[test]
fn the_document_reads_back_as_it_was_written_in_yaml_and_json() {
    let robot = kuka();
    for knots in [Knots::All, Knots::Few] {
        let found = identify(&robot, &logs(&robot)[1..5], &Options { knots, ..Options::default() }).unwrap();
        let doc = document::document(&found, &robot);
        for text in [lostmotion::gaps::file::to_yaml(&doc).unwrap(), lostmotion::gaps::file::to_json(&doc).unwrap()] {
            let read = Gaps::parse("gaps", &text, &robot).unwrap();
            let again = lostmotion::gaps::file::document(&read, &robot);
            let first = lostmotion::gaps::file::document(&found.gaps, &robot);
            for key in ["schema", "robot", "logs", "points", "joints", "notes"] {
                assert_eq!(again[key], first[key], "{key}");
            }
            assert!(!text.contains("e-5\n") && !text.contains("NaN"));
        }
    }
}

#[test]
fn refuses_gaps_that_cannot_be_used() {
    let robot = kuka();
    let good = format!(
        "schema: lostmotion/gaps/1\nrobot: {{name: K, sha256: {}}}\nregistration: null\npoints: []\njoints:\n- joint: A1\n  half_gap_deg: 0.0028\n",
        robot.fingerprint()
    );
    assert!(Gaps::parse("g.yaml", &good, &robot).is_ok());
    for (from, to, message) in [
        ("gaps/1", "gaps/9", "schema `lostmotion/gaps/9`"),
        ("joint: A1", "joint: B1", "g.yaml:6: found joint `B1` at joints[0].joint; expected one of A1"),
        ("0.0028", ".inf", "g.yaml:7: found null, or a number that is not finite at joints[0].half_gap_deg"),
        ("0.0028", "text", "found `\"text\"` at joints[0].half_gap_deg"),
        (
            "half_gap_deg",
            "half_gap_mm",
            "g.yaml:7: found the unknown key `half_gap_mm` at joints[0].half_gap_mm; expected `half_gap_deg`",
        ),
        ("half_gap_deg", "half_gap_rad", "expected `half_gap_deg`"),
        ("half_gap_deg", "gap", "found nothing (the keys there: joint, gap) at joints[0].half_gap_deg"),
        (
            "0.0028",
            "0.0028\n  signficant: false",
            "the unknown key `signficant` at joints[0].signficant; expected `significant`",
        ),
        ("points: []", "point: []", "the unknown key `point` at point; expected `points`"),
        ("joints:\n", "joints: 3\nrest:\n", "a list"),
        (&robot.fingerprint()[..8], "00000000", "gaps of another robot"),
        ("0.0028", "0.0028\n  schedule: {kind: pchip, knots: [[1, 2], [1, 3]]}", "rising positions"),
        ("0.0028", "0.0028\n  stiction: {spike_deg: 0.003, decay_s: -1}", "decay"),
    ] {
        let error = Gaps::parse("g.yaml", &good.replace(from, to), &robot).map(|_| ()).unwrap_err();
        assert_eq!(lostmotion::cli::exit::code_of(&error), 2);
        assert!(error.to_string().contains(message), "{error}\nlacks {message}");
    }
}
