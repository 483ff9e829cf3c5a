//! Random messages in three styles, and random edits of them.

use super::*;
use crate::script::{Edit, harness};
use proptest::prelude::*;
use std::fmt::Write as _;

/// A message in one of its styles: joints, positions by point, style, times, velocities.
fn message(points: &[Vec<f64>], gaps: &[f64], style: u8, rates: bool, accelerations: bool) -> String {
    let mut t = 0.0;
    let mut items = Vec::new();
    for (k, (q, gap)) in points.iter().zip(gaps).enumerate() {
        t += gap;
        let list = |v: &[f64]| v.iter().map(|x| format!("{x:.4}")).collect::<Vec<_>>().join(", ");
        let mut fields = vec![("positions", list(q))];
        if rates {
            let v: Vec<f64> = q.iter().map(|x| (x * 7.0 + k as f64).sin()).collect();
            fields.push(("velocities", list(&v)));
        }
        if rates && accelerations {
            fields.push(("accelerations", list(&[0.0, 0.5, -0.5])));
        }
        items.push((fields, t));
    }
    let time =
        |t: f64| format!("{{sec: {}, nanosec: {}}}", t.trunc(), ((t.fract() * 1e9).round() as i64).min(999_999_999));
    let mut out = String::new();
    match style {
        0 => {
            out.push_str("# a block\njoint_names:\n  - X\n  - J1\n  - J2\npoints:\n");
            for (fields, t) in items {
                let mut lead = "  - ";
                for (name, list) in fields {
                    let _ = writeln!(out, "{lead}{name}:   # {name}");
                    lead = "    ";
                    for n in list.split(", ") {
                        let _ = writeln!(out, "      - {n}");
                    }
                }
                let _ = writeln!(
                    out,
                    "    time_from_start:\n      secs: {}\n      nsecs: {}\n",
                    t.trunc(),
                    (t.fract() * 1e9).round().min(999_999_999.0)
                );
            }
        }
        1 => {
            out.push_str("goal: {trajectory: {joint_names: [J1, 'x', \"J2\"], points: [");
            let all = items.iter().map(|(fields, t)| {
                let f: Vec<_> = fields.iter().map(|(n, l)| format!("{n}: [{l}]")).collect();
                format!("{{{}, time_from_start: {}}}", f.join(", "), time(*t))
            });
            out.push_str(&all.collect::<Vec<_>>().join(", "));
            out.push_str("]}}\n");
        }
        _ => {
            out.push_str("{\"joint_names\": [\"j1\", \"j2\", \"x\"],\r\n \"points\": [\r\n");
            let all = items.iter().map(|(fields, t)| {
                let f: Vec<_> = fields.iter().map(|(n, l)| format!("    \"{n}\": [{l}]")).collect();
                format!("  {{\r\n{},\r\n    \"time_from_start\": {t:.6}\r\n  }}", f.join(",\r\n"))
            });
            out.push_str(&all.collect::<Vec<_>>().join(",\r\n"));
            out.push_str("\r\n]}");
        }
    }
    out
}

proptest! {
    #![proptest_config(ProptestConfig { cases: u32::try_from(harness::count("PROPTEST_CASES", 256)).unwrap(), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_messages_take_random_edits(
        points in prop::collection::vec(prop::collection::vec(-3.0..3.0f64, 3), 1..7),
        gaps in prop::collection::vec(0.05..3.0f64, 7),
        style in 0u8..3,
        kinds in (any::<bool>(), any::<bool>()),
        wishes in prop::collection::vec((0usize..4, prop::option::of(prop::collection::vec(-3.0..3.0f64, 3)), 1e-6..1e-2f64), 7),
    ) {
        let text = message(&points, &gaps, style, kinds.0, kinds.1);
        let d = parse(&text);
        prop_assert_eq!(d.script().moves().count(), points.len());
        prop_assert!(d.patches(&Edits::default()).unwrap().is_empty());
        let mut edits = Edits { digit: vec![wishes[0].2; 3], ..Edits::default() };
        for ((step, m), (count, goal, _)) in d.script().moves().zip(&wishes) {
            let count = if m.closed.is_some() { 0 } else { *count };
            let before = (1..=count).map(|k| {
                let share = k as f64 / (count + 1) as f64;
                point(&[share, 1.0 - share, 0.1 * share], share)
            });
            let before: Vec<_> = before.collect();
            if goal.is_some() || !before.is_empty() {
                edits.steps.insert(step, Edit { before, goal: goal.clone(), ..Edit::default() });
            }
        }
        edited(&text, &edits);
    }
}
