//! What a reader of a static test should know of a joint.

use super::*;
use crate::gaps::note::static_test::Remark;
use crate::identify::static_test::creep::Creep;
use crate::robot::JointKind;

/// Share of a half gap below which a drift adds nothing worth a note.
const LITTLE: f64 = 0.01;

/// Where the noise of a joint's figures comes from, and what that leaves open.
fn about_noise(table: &Table, summary: &Summary, kind: JointKind) -> Vec<Remark> {
    let mut notes = Vec::new();
    match summary.noise.from {
        NoiseFrom::Cycles if summary.gate.is_none() && summary.angles.len() > 1 => notes.push(Remark::TooFewRepeats),
        NoiseFrom::Cycles => {}
        NoiseFrom::Places => notes.push(Remark::OneCycle),
        NoiseFrom::Dwells => notes.push(Remark::OnePair),
    }
    if summary.noise.rounding {
        notes.push(Remark::Rounding);
    }
    if table.common_rounding > WIDE * summary.half_gap.abs() {
        notes.push(Remark::CoarseReadings { kind, error: table.common_rounding });
    }
    let sigma = summary.noise.variance.sqrt();
    if summary.noise.from == NoiseFrom::Cycles
        && summary.noise.dof >= 6.0
        && sigma > 3.0 * summary.sigma_in_dwell
        && summary.sigma_in_dwell > table.rounding
    {
        notes.push(Remark::CyclesScatter { factor: sigma / summary.sigma_in_dwell });
    }
    notes
}

/// What a reader of a joint's figures should know.
pub fn notes(table: &Table, summary: &Summary, kind: JointKind) -> Vec<Remark> {
    let mut notes = Vec::new();
    for a in &summary.angles {
        if !a.dropped.is_empty() {
            notes.push(Remark::GrossErrors { kind, at: a.at, values: a.dropped.clone() });
        }
        if a.flagged {
            notes.push(Remark::CyclesDisagree { kind, at: a.at });
        }
    }
    notes.extend(about_noise(table, summary, kind));
    if let Some(drift) = table.drift.filter(|d| d.bias.abs() > LITTLE * summary.half_gap.abs()) {
        notes.push(Remark::Drifts { kind, per_min: 60.0 * drift.rate, bias: drift.bias });
    }
    if summary.ci95[1] < 0.0 {
        notes.push(Remark::Negative { kind });
    }
    notes.extend(summary.creep.as_ref().and_then(|c| about_creep(c, summary, kind)));
    let largest = summary.angles.iter().map(|a| a.mean).fold(0.0, f64::max);
    if table.least_stroke < 2.0 * largest {
        notes.push(Remark::ShortApproach { kind, stroke: table.least_stroke });
    }
    notes
}

/// What the creep leaves open, and the dwell that would tell; `None` where the dwells are long enough.
fn about_creep(creep: &Creep, summary: &Summary, kind: JointKind) -> Option<Remark> {
    let width = summary.ci95[1] - summary.ci95[0];
    let short = creep.dwell_s < creep.needed_dwell_s && width > WIDE * summary.half_gap.abs();
    short.then_some(if creep.applies() {
        Remark::Creeps {
            kind,
            dwell_s: creep.dwell_s,
            at_end: creep.at_end,
            pace_s: creep.pace_s,
            pace_ci95_s: creep.pace_ci95_s,
            needed_dwell_s: creep.needed_dwell_s,
        }
    } else {
        Remark::MayCreep { dwell_s: creep.dwell_s, probability: creep.probability }
    })
}
