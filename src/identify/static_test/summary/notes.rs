//! What a reader of a static test should know of a joint, in words.

use super::*;
use crate::identify::static_test::creep::Creep;
use crate::robot::{Joint, JointKind};

/// Where the noise of a joint's figures comes from, and what that leaves open.
fn noise_notes(table: &Table, summary: &Summary) -> Vec<String> {
    let mut notes = Vec::new();
    let mut note = |text: &str| notes.push(text.to_string());
    match summary.noise.from {
        NoiseFrom::Cycles if summary.gate.is_none() && summary.angles.len() > 1 => {
            note("too few repeats to test whether the gap varies with position");
        }
        NoiseFrom::Cycles => {}
        NoiseFrom::Places => note(
            "only one cycle: the intervals treat the spread between positions as noise, and no test shows whether the gap varies",
        ),
        NoiseFrom::Dwells => {
            note("only one pair: its interval contains the noise within the dwells but not the repeatability");
        }
    }
    if summary.noise.rounding {
        note("the repeats agree better than the last digit of the file: the rounding was used as the noise");
    }
    let sigma = summary.noise.variance.sqrt();
    if summary.noise.from == NoiseFrom::Cycles
        && summary.noise.dof >= 6.0
        && sigma > 3.0 * summary.sigma_in_dwell
        && summary.sigma_in_dwell > table.rounding
    {
        note(&format!(
            "the cycles scatter {:.1} times as much as the noise within the dwells: drift, temperature or settling between cycles",
            sigma / summary.sigma_in_dwell
        ));
    }
    notes
}

/// What a reader of a joint's figures should know.
pub fn notes(table: &Table, summary: &Summary, joint: &Joint) -> Vec<String> {
    let (unit, edge) = (joint.kind.unit(), |v: f64| joint.kind.to_user_unit(v));
    let mut notes = Vec::new();
    let mut note = |text: String| notes.push(format!("{}: {text}", joint.name));
    for a in &summary.angles {
        let at = edge(a.at);
        if !a.dropped.is_empty() {
            let values: Vec<String> = a.dropped.iter().map(|b| format!("{:.5}", edge(*b))).collect();
            note(format!(
                "at {at:.4} {unit} {} left out as gross errors: {} {unit}",
                a.dropped.len(),
                values.join(", ")
            ));
        }
        if a.flagged {
            note(format!(
                "at {at:.4} {unit} the cycles disagree, and too few would remain without the outliers: all are kept; do not trust this value"
            ));
        }
    }
    noise_notes(table, summary).into_iter().for_each(&mut note);
    if summary.ci95[1] < 0.0 {
        let turned = if joint.kind == JointKind::Revolute { "turns" } else { "moves" };
        note(format!(
            "the gap is negative, as if the joint {turned} past its command: check the direction of the joint and of `trigger`"
        ));
    }
    if let Some(text) = summary.creep.as_ref().and_then(|c| creep_note(c, summary, joint)) {
        note(text);
    }
    let largest = summary.angles.iter().map(|a| a.mean).fold(0.0, f64::max);
    if table.least_stroke < 2.0 * largest {
        note(format!(
            "an approach of {:.5} {unit} is shorter than twice the half gap: the gap was not crossed; approach from farther away",
            edge(table.least_stroke)
        ));
    }
    notes
}

/// Says what the creep leaves open, and the dwell that would tell; `None` where the dwells are long enough.
fn creep_note(creep: &Creep, summary: &Summary, joint: &Joint) -> Option<String> {
    let width = summary.ci95[1] - summary.ci95[0];
    let short = creep.dwell_s < creep.needed_dwell_s && width > WIDE * summary.half_gap.abs();
    if short && !creep.applies() {
        return Some(format!(
            "the dwells of {:.1} s are too short to exclude that the readings still creep (probability {:.2}); the interval allows for it",
            creep.dwell_s, creep.probability
        ));
    }
    short.then(|| {
        format!(
            "the readings still creep when the dwells of {:.1} s end ({:.5} {} then, pace {:.1} s, 95 % interval {:.1} to {:.1} s): the half gap at rest is extrapolated, and its interval allows for this; dwells of {:.0} s would measure it",
            creep.dwell_s,
            joint.kind.to_user_unit(creep.at_end),
            joint.kind.unit(),
            creep.pace_s,
            creep.pace_ci95_s[0],
            creep.pace_ci95_s[1],
            creep.needed_dwell_s.ceil(),
        )
    })
}
