//! Gaps files and compensator files that cannot be used.

use super::{C, Case, G, ROBOT, case, swapped, utf16};
use lostmotion::robot::Robot;

fn fingerprint() -> String {
    Robot::parse("robot.yaml", ROBOT).unwrap().fingerprint()
}

/// Lines: 3 logs, 5 points, 7 and 8 joints.
pub fn gaps() -> String {
    format!(
        "schema: lostmotion/gaps/1
robot: {{name: arm, sha256: {}}}
logs: [{{name: log.csv, sha256: aa}}]
points:
  - {{joint: J1, at_deg: 5, half_gap_deg: 0.003, ci95: [0.0029, 0.0031], cycles: 4}}
joints:
  - {{joint: J1, half_gap_deg: 0.003, ci95: [0.0029, 0.0031], stiction: {{spike_deg: 0.002, ci95: [0.0019, 0.0021], decay_s: 5}}}}
  - {{joint: Z, half_gap_mm: 0.02, ci95: [0.019, 0.021], schedule: {{kind: pchip, knots: [[0, 0.02], [100, 0.03]]}}}}
tcp_speed_mm_s: 5
",
        fingerprint()
    )
}

/// Lines: 4 and 5 joints, 6 evidence.
pub fn compensator() -> String {
    format!(
        "schema: lostmotion/compensator/1
robot: {{name: arm, sha256: {}}}
joints:
  J1: {{backlash: {{half_gap_deg: 0.003}}, friction: {{gain_deg: 0.002, decay_s: 5}}}}
  Z: {{backlash: {{schedule: {{kind: pchip, knots: [[0, 0.02], [100, 0.03]]}}}}}}
evidence: {{tcp_speed_mm_s: 5}}
",
        fingerprint()
    )
}

fn g(from: &str, to: &str) -> String {
    swapped(&gaps(), from, to)
}

fn c(from: &str, to: &str) -> String {
    swapped(&compensator(), from, to)
}

const J1: &str = "{backlash: {half_gap_deg: 0.003}, friction: {gain_deg: 0.002, decay_s: 5}}";
const KNOTS: &str = "knots: [[0, 0.02], [100, 0.03]]";
const PCHIP: &str = "{kind: pchip, knots: [[0, 0.02], [100, 0.03]]}";

#[rustfmt::skip]
pub fn cases() -> Vec<Case> {
    vec![
        // gaps
        case("gaps empty", G, "", &["gaps.yaml", "empty"]),
        case("gaps no YAML", G, "{joints: [", &["gaps.yaml:2"]),
        case("gaps in UTF-16", G, utf16(&gaps(), true), &["gaps.yaml", "UTF-16"]),
        case("gaps not UTF-8", G, b"schema: \xff\n".to_vec(), &["gaps.yaml:1", "0xFF"]),
        case("a compensator for gaps", G, compensator(), &["gaps.yaml:1", "lostmotion/compensator/1", "lostmotion/gaps/1"]),
        case("gaps without schema", G, g("schema: lostmotion/gaps/1\n", ""), &["gaps.yaml", "schema"]),
        case("gaps that are a list", G, "- 1\n", &["gaps.yaml", "schema"]),
        case("gaps of another robot", G, gaps().replace(&fingerprint(), "abc"), &["gaps.yaml:2", "another robot", "abc", "`arm`"]),
        case("gaps of an unknown joint", G, g("joint: Z", "joint: A7"), &["gaps.yaml:8", "A7", "J1, J2, Z"]),
        case("a point of an unknown joint", G, g("joint: J1, at", "joint: A7, at"), &["gaps.yaml:5", "A7"]),
        case("gaps with a joint twice", G, g("joint: Z, half_gap_mm", "joint: j1, half_gap_deg").replace("schedule", "x"), &["gaps.yaml:8", "second entry", "J1"]),
        case("gaps without a number", G, g("joint: Z, half_gap_mm: 0.02,", "joint: Z,"), &["gaps.yaml:8", "half_gap_mm"]),
        case("gaps in the other unit", G, g("half_gap_mm: 0.02", "half_gap_deg: 0.02"), &["gaps.yaml:8", "half_gap_mm"]),
        case("gaps of text", G, g("half_gap_mm: 0.02", "half_gap_mm: small"), &["gaps.yaml:8", "small"]),
        case("gaps with a decimal comma", G, g("half_gap_mm: 0.02", "half_gap_mm: '0,02'"), &["gaps.yaml:8", "0,02"]),
        case("gaps NaN", G, g("half_gap_mm: 0.02", "half_gap_mm: .nan"), &["gaps.yaml:8", "not finite"]),
        case("gaps infinite", G, g("half_gap_mm: 0.02", "half_gap_mm: .inf"), &["gaps.yaml:8", "not finite"]),
        case("interval of one number", G, g("[0.019, 0.021]", "[0.019]"), &["gaps.yaml:8", "1 numbers", "2 numbers"]),
        case("interval the wrong way round", G, g("[0.019, 0.021]", "[0.021, 0.019]"), &["gaps.yaml:8", "[lower, upper]"]),
        case("interval with NaN", G, g("[0.019, 0.021]", "[.nan, 0.021]"), &["gaps.yaml:8", "finite"]),
        case("schedule knots not rising in gaps", G, g(KNOTS, "knots: [[100, 0.02], [0, 0.03]]"), &["gaps.yaml:8", "knots", "rising"]),
        case("schedule of an unknown kind in gaps", G, g("kind: pchip", "kind: spline"), &["gaps.yaml:8", "spline", "pchip"]),
        case("schedule without knots", G, g(", knots: [[0, 0.02], [100, 0.03]]", ""), &["gaps.yaml:8", "no `knots`"]),
        case("stiction without decay", G, g(", decay_s: 5", ""), &["gaps.yaml:7", "decay"]),
        case("stiction with two decays", G, g("decay_s: 5", "decay_s: 5, decay_deg: 1"), &["gaps.yaml:7", "decay"]),
        case("stiction with decay 0", G, g("decay_s: 5", "decay_s: 0"), &["gaps.yaml:7", "decay"]),
        case("joints that are no list", G, "schema: lostmotion/gaps/1\njoints: {J1: 2}\n", &["gaps.yaml:2", "a list"]),
        // compensator
        case("compensator empty", C, "", &["comp.yaml", "empty"]),
        case("compensator no YAML", C, "schema: [\n", &["comp.yaml:"]),
        case("compensator in UTF-16", C, utf16(&compensator(), false), &["comp.yaml", "UTF-16"]),
        case("gaps for a compensator", C, gaps(), &["comp.yaml:1", "lostmotion/gaps/1", "lostmotion/compensator/1"]),
        case("compensator of another schema", C, c("compensator/1", "compensator/2"), &["comp.yaml:1", "compensator/2"]),
        case("compensator of another robot", C, compensator().replace(&fingerprint(), "abc"), &["comp.yaml:2", "sha256 abc", "`arm`"]),
        case("compensator without fingerprint", C, c(&format!(", sha256: {}", fingerprint()), ""), &["comp.yaml:2", "sha256"]),
        case("compensator with an unknown key", C, c("evidence:", "evidense:"), &["comp.yaml", "evidense"]),
        case("compensator of an unknown joint", C, c("  Z:", "  A7:"), &["comp.yaml:5", "A7", "J1, J2, Z"]),
        case("compensator with a joint twice", C, c("  Z:", "  j1: {backlash: {half_gap_deg: 0}}\n  Z:"), &["comp.yaml:5", "second entry"]),
        case("compensator with a joint twice in the same letters", C, c("  Z:", "  J1: {backlash: {half_gap_deg: 0}}\n  Z:"), &["comp.yaml", "J1"]),
        case("joint with an unknown term", C, c("friction:", "frction:"), &["comp.yaml:4", "frction", "backlash, friction"]),
        case("backlash with an unknown key", C, c("half_gap_deg", "halfgap_deg"), &["comp.yaml:4", "halfgap_deg"]),
        case("backlash in the other unit", C, c("half_gap_deg", "half_gap_mm"), &["comp.yaml:4", "half_gap_mm"]),
        case("compensator gap negative", C, c("half_gap_deg: 0.003", "half_gap_deg: -0.003"), &["comp.yaml:4", "-0.003", "0 or more"]),
        case("compensator gap NaN", C, c("half_gap_deg: 0.003", "half_gap_deg: .nan"), &["comp.yaml:4", "finite"]),
        case("compensator gap infinite", C, c("half_gap_deg: 0.003", "half_gap_deg: .inf"), &["comp.yaml:4", "finite"]),
        case("compensator gap of text", C, c("half_gap_deg: 0.003", "half_gap_deg: small"), &["comp.yaml:4", "small"]),
        case("compensator gap with a decimal comma", C, c("half_gap_deg: 0.003", "half_gap_deg: '0,003'"), &["comp.yaml:4", "0,003"]),
        case("gap and schedule", C, c("schedule: {", "half_gap_mm: 1, schedule: {"), &["comp.yaml:5", "half_gap_mm", "schedule"]),
        case("one side of a gap", C, c("half_gap_deg: 0.003", "positive_deg: 0.003"), &["comp.yaml:4", "two kinds"]),
        case("no gap", C, c("{half_gap_deg: 0.003}", "{}"), &["comp.yaml:4", "at least one"]),
        case("compensator knots not rising", C, c(KNOTS, "knots: [[100, 0.02], [0, 0.03]]"), &["comp.yaml:5", "knots", "rising"]),
        case("compensator knots repeated", C, c(KNOTS, "knots: [[0, 0.02], [0, 0.03]]"), &["comp.yaml:5", "knots", "rising"]),
        case("compensator knots with NaN", C, c(KNOTS, "knots: [[0, .nan], [100, 0.03]]"), &["comp.yaml:5", "knots"]),
        case("compensator schedule below 0", C, c(KNOTS, "knots: [[0, -0.02], [100, 0.03]]"), &["comp.yaml:5", "half gap of -0.02 mm"]),
        case("polynomial over a range the wrong way round", C, c(PCHIP, "{kind: polynomial, coefficients: [0.02, 0.001], range_mm: [5, 1]}"), &["comp.yaml:5", "range_mm"]),
        case("polynomial that falls below 0", C, c(PCHIP, "{kind: polynomial, coefficients: [0.02, -0.001]}"), &["comp.yaml:5", "half gap of -"]),
        case("schedule of an unknown kind", C, c("kind: pchip", "kind: spline"), &["comp.yaml:5", "spline", "polynomial"]),
        case("schedule with an unknown key", C, c("kind: pchip", "kind: pchip, unit: m"), &["comp.yaml:5", "unit"]),
        case("two friction forms", C, c("decay_s: 5", "decay_s: 5, exponent: 3, poses: 5"), &["comp.yaml:4", "two of them"]),
        case("friction in seconds and in travel", C, c("decay_s: 5", "decay_s: 5, decay_deg: 1"), &["comp.yaml:4", "two of them"]),
        case("friction that never fades", C, c(", decay_s: 5", ""), &["comp.yaml:4", "without a decay"]),
        case("friction with decay 0", C, c("decay_s: 5", "decay_s: 0"), &["comp.yaml:4", "decay_s: 0", "above 0"]),
        case("friction gain negative", C, c("gain_deg: 0.002", "gain_deg: -0.002"), &["comp.yaml:4", "gain_deg: -0.002"]),
        case("friction without gain", C, c("gain_deg: 0.002, ", ""), &["comp.yaml:4", "no `gain_deg`"]),
        case("friction over half a point", C, c("decay_s: 5", "exponent: 3, poses: 2.5"), &["comp.yaml:4", "poses: 2.5"]),
        case("friction over one point", C, c("decay_s: 5", "exponent: 3, poses: 1"), &["comp.yaml:4", "poses"]),
        case("a joint that is a number", C, c(J1, "0.003"), &["comp.yaml:4", "0.003"]),
        case("joints that are a list", C, c("joints:\n", "joints: [1]\nx:\n"), &["comp.yaml:3"]),
        case("valid until soon", C, compensator() + "valid_until: soon\n", &["comp.yaml:7", "soon", "date"]),
        case("evidence speed 0", C, c("tcp_speed_mm_s: 5", "tcp_speed_mm_s: 0"), &["comp.yaml:6", "above 0"]),
        case("evidence of text", C, c("{tcp_speed_mm_s: 5}", "seen"), &["comp.yaml:6", "evidence"]),
    ]
}
