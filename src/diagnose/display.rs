//! The diagnosis on a terminal: the story round by round, the verdict in one sentence, what to do next.

use super::document::{Diagnosis, Round};
use super::verdict::Verdict;
use std::fmt::Write;

/// The whole story.
pub fn story(d: &Diagnosis) -> String {
    let mut out = String::new();
    let _ = writeln!(
        out,
        "{} samples, noise {:.1} um ({}, from one sample to the next {:.2})",
        d.samples, d.noise.sigma_um, d.noise.source, d.noise.ar1
    );
    if d.outliers > 0 {
        let _ = writeln!(out, "{} samples disagree with their neighbours and were left out", d.outliers);
    }
    let _ = writeln!(
        out,
        "gap {:.1} um as given, {:.1} um with the frame fitted",
        d.gap.initial_rms_um, d.gap.nuisance_only_rms_um
    );
    for (i, r) in d.rounds.iter().enumerate() {
        round(&mut out, i + 1, r);
    }
    for p in &d.put_aside {
        let _ = writeln!(out, "  put aside: {} {} (now {})", p.effect, p.target, p.replaced_by);
    }
    let _ = writeln!(out, "{}", sentence(d));
    for r in &d.rounds {
        let _ = writeln!(out, "  do: {} - {}", r.target, r.action);
    }
    out
}

fn round(out: &mut String, number: usize, r: &Round) {
    let sizes: Vec<String> = r
        .parameters
        .iter()
        .map(|(k, p)| format!("{k} {} [{}, {}]", short(p.value), short(p.ci95[0]), short(p.ci95[1])))
        .collect();
    let _ = writeln!(
        out,
        "{number}. {:.1} um -> {} {} -> {:.1} um (predicted {:.1}; held out {:.1} -> {:.1})",
        r.rms_before_um,
        r.effect,
        r.target,
        r.rms_after_um,
        r.rms_after_predicted_um,
        r.validation.rms_before_um,
        r.validation.rms_after_um
    );
    let _ = writeln!(out, "   {}", sizes.join(", "));
    let _ = writeln!(out, "   {}", r.place.description);
    if r.set.len() > 1 {
        let names: Vec<String> =
            r.set.iter().map(|m| format!("{} {} ({:.0} %)", m.effect, m.target, 100.0 * m.probability)).collect();
        let _ = writeln!(out, "   this log cannot tell: {}", names.join(", "));
        if let Some(by) = &r.decide_by {
            let _ = writeln!(out, "   to decide: {by}");
        }
    }
}

fn short(v: f64) -> String {
    if v == 0.0 { "0".into() } else { format!("{:.*}", (3 - v.abs().log10().floor() as i32).clamp(0, 9) as usize, v) }
}

/// The verdict in one sentence.
pub fn sentence(d: &Diagnosis) -> String {
    let names: Vec<String> = d.rounds.iter().map(|r| format!("{} {}", r.effect, r.target)).collect();
    match d.verdict {
        Verdict::None => "Nothing is missing: the gap is at the noise floor.".into(),
        Verdict::Named => format!("Missing: {}. What remains is noise.", names.join(", ")),
        Verdict::NamedSet => format!("Missing: {}; at least one of them cannot be told from a rival with this log.", names.join(", ")),
        Verdict::Unknown => {
            let u = d.unexplained.as_ref();
            format!(
                "Unknown: {:.1} um of structure remains that no effect of the catalogue describes; it goes with {}. Record {}.",
                u.map_or(0.0, |u| u.rms_um),
                u.map_or("nothing in particular", |u| &u.goes_with),
                u.map_or("more channels", |u| &u.record)
            )
        }
        Verdict::NotObservable => "Not observable: no joint moves in this log.".into(),
        Verdict::BadData => "Bad data.".into(),
    }
}
