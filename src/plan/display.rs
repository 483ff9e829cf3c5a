//! The plan on a terminal: the question, a table of the motions, the proposal in words.

use super::document::{Plan, QuestionKind, Verdict};
use std::fmt::Write;

/// Motions that are shown.
const SHOWN: usize = 12;

/// The whole story.
pub fn story(plan: &Plan) -> String {
    let mut out = String::new();
    for set in &plan.sets {
        let names: Vec<&str> = set.alternatives.iter().map(|r| r.name.as_str()).collect();
        let _ = writeln!(out, "to tell apart: {}", names.join(" | "));
    }
    if plan.question == QuestionKind::Catalogue {
        let _ = writeln!(out, "to see: every effect of the catalogue on every joint");
    }
    if !plan.motions.is_empty() {
        table(&mut out, plan);
    }
    let _ = writeln!(out, "{}", sentence(plan));
    if let Some(reason) = &plan.reason {
        let _ = writeln!(out, "  why: {reason}");
    }
    for c in &plan.channels {
        let _ = writeln!(out, "  with {} ({}): {} by {}", c.channel, c.log, short(c.expected_2lnl), c.motion);
    }
    if let Some(runs) = plan.best.as_ref().map(|b| &b.runs).filter(|r| r.len() > 1) {
        let loads: Vec<String> = runs.iter().map(|r| format!("{} kg", r.payload_kg.unwrap_or(0.0))).collect();
        let _ = writeln!(out, "  run this program {} times, with {}", runs.len(), loads.join(" and with "));
    }
    let evidence = plan.best.as_ref().and_then(|b| b.evidence.as_ref());
    if let Some(o) = evidence.and_then(|e| e.nearest_outside.as_ref()) {
        let _ = writeln!(out, "  nearest effect outside the set: {} ({} worse)", o.what, short(o.expected_2lnl));
    }
    for note in &plan.notes {
        let _ = writeln!(out, "  note: {note}");
    }
    out
}

fn table(out: &mut String, plan: &Plan) {
    let heads = if plan.question == QuestionKind::Catalogue {
        ["size/MDB of worst", "", ""]
    } else {
        ["expected 2 ln L", "named alone", "to other effects"]
    };
    let mut line = |cells: [&str; 5]| {
        let [motion, duration, a, b, c] = cells;
        let text = format!("{motion:<36} {duration:>10} {a:>18} {b:>12} {c:>17}");
        let _ = writeln!(out, "{}", text.trim_end());
    };
    line(["motion", "duration", heads[0], heads[1], heads[2]]);
    for e in plan.motions.iter().take(SHOWN) {
        let runs = if e.runs.len() > 1 { format!("{} x ", e.runs.len()) } else { String::new() };
        let duration = format!("{runs}{:.0} s", e.duration_s);
        let (mut value, mut named, mut other) = (String::new(), String::new(), String::new());
        if let Some(v) = &e.evidence {
            value = short(v.expected_2lnl);
            named = format!("{:.1} %", 100.0 * v.probability_named);
            other = v.nearest_outside.as_ref().map_or(String::new(), |o| short(o.expected_2lnl));
        } else if let Some(ratio) = e.worst_ratio {
            value = short(ratio);
        }
        line([&e.motion, &duration, &value, &named, &other]);
    }
    if plan.motions.len() > SHOWN {
        let _ = writeln!(out, "... and {} more", plan.motions.len() - SHOWN);
    }
}

fn short(v: f64) -> String {
    if v >= 100.0 {
        format!("{v:.0}")
    } else if v >= 0.01 {
        format!("{v:.2}")
    } else if v < 1e-6 {
        "0".into()
    } else {
        format!("{v:.1e}")
    }
}

/// The proposal in one sentence.
pub fn sentence(plan: &Plan) -> String {
    let best = plan.best.as_ref();
    let motion = best.map_or("", |b| b.motion.as_str());
    let evidence = best.and_then(|b| b.evidence.as_ref());
    let expected = evidence.map_or(String::new(), |e| {
        format!(
            "expected 2 ln L {}, named as the only effect in {:.1} % of logs",
            short(e.expected_2lnl),
            100.0 * e.probability_named
        )
    });
    match plan.verdict {
        Verdict::Separable => format!("Run \"{motion}\": {expected}."),
        Verdict::Weak => format!("Run \"{motion}\", but it may not decide: {expected}."),
        Verdict::NeedsChannel => {
            let channel = plan.needs_channel.as_deref().unwrap_or_default();
            format!(
                "The TCP alone does not separate them on any motion. Run \"{motion}\" with {channel} in the log: {expected}."
            )
        }
        Verdict::Inseparable => "No motion separates them with any channel that a log can contain. No program.".into(),
        Verdict::Observable => format!("Run \"{motion}\": every detectable effect is detected at its typical size."),
        Verdict::PartlyObservable => {
            let worst = best.and_then(|b| b.detectable.iter().find(|d| d.ratio.is_finite() && d.ratio > 0.0));
            let (effect, target, ratio) = worst.map_or(("", "", 0.0), |w| (w.effect, w.target.as_str(), w.ratio));
            let from = short(1.0 / f64::max(ratio, 1e-12));
            format!("Run \"{motion}\"; {effect} {target} is the hardest to detect: from {from} times its typical size.")
        }
        Verdict::NothingToDecide => "Nothing to decide. No program.".into(),
    }
}
