//! `fit`: identified gaps and stiction become the offsets of Zhang (2023) equations 15 to 17.
//!
//! The story: [`mod@merge`] takes each joint's gap from the document that knows it best and its stiction from the path; this module
//! decides which terms are worth applying; [`minimax`] finds the constants that leave the smallest largest error after
//! reversals (infinity norm) under the identified chain; [`poses`] turns a decay into the paper's `{g, l, k_t}`; [`spacing`] reads
//! how far apart the points of a program are.
//!
//! With half gaps `b_i` at the reversals, spike `s` and decay `tau`, a joint that has closed its gap is off by
//! `(d - b_i) + g f(t) - s exp(-t/tau)` after an offset of `d` and a friction term `g f(t)`. A term that is not significant, or
//! smaller than its own uncertainty, is left out: an offset that is not known does more harm than the error it is meant for.
//! Every decision stands in the notes.
//!
//! Files beside:
//! - `contradict`: documents that say different things about one joint
//!
//! # Example
//!
//! A half gap becomes an offset of that size in either direction.
//!
//! ```
//! use lostmotion::{fit, gaps::Gaps, robot::Robot};
//! use std::path::Path;
//!
//! let robot = Robot::load(Path::new("configs/kuka-kr120-r2500-pro.yaml"))?;
//! let text = format!(
//!     "schema: lostmotion/gaps/1\nrobot: {{name: KUKA, sha256: {}}}\nlogs: [{{name: circle.csv, sha256: aa}}]\npoints: []\njoints:\n  \
//!      - {{joint: A2, half_gap_deg: 0.0037, ci95: [0.0036, 0.0038]}}\n",
//!     robot.fingerprint()
//! );
//! let gaps = Gaps::parse("gaps.yaml", &text, &robot)?;
//! let compensator = fit::fit(&robot, &[gaps], fit::Form::Decay)?;
//! let offsets = compensator.joints[0].backlash.as_ref().expect("a gap of A2");
//! for offset in [&offsets.positive, &offsets.negative] {
//!     // rad, anywhere in the joint's range
//!     assert!((offset.at(0.5) - 0.0037_f64.to_radians()).abs() < 1e-9);
//! }
//! # Ok::<(), lostmotion::error::Error>(())
//! ```

#![warn(missing_docs)]

pub mod contradict;
pub mod merge;
pub mod minimax;
pub mod poses;
pub mod spacing;

use crate::compensator::{
    BacklashOffset, Compensator, Evidence, FrictionOffset, FrictionShape, JointCompensator, JointEvidence, Note,
    Predicted,
};
use crate::effects::{Decay, GapCurve, curve::Pchip};
use crate::error::{Error, Place, Result};
use crate::gaps::estimate::JointEstimate;
use crate::gaps::{GapPoint, Gaps, StictionFound};
use crate::numerics::normal::Z95;
use crate::robot::{Joint, Robot};
use merge::{Merged, merge};

/// How the friction term fades.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Form {
    /// As it was identified: in seconds, or in travel.
    #[default]
    Decay,
    /// Equation 17 as printed, for programs whose points are this far apart in time, s.
    Poses {
        /// Time from one point to the next, s.
        spacing_s: f64,
    },
}

/// Fits a compensator for `robot` to gaps documents of that robot.
pub fn fit(robot: &Robot, documents: &[Gaps], form: Form) -> Result<Compensator> {
    let fingerprint = robot.fingerprint();
    if let Some(other) = documents.iter().find(|d| d.robot_sha256 != fingerprint) {
        return Err(Error::bad(
            Place::default(),
            format!("gaps of another robot, `{}` ({})", other.robot_name, other.robot_sha256),
            format!("gaps of `{}` ({fingerprint})", robot.name),
        ));
    }
    let mut evidence = Evidence::default();
    for log in documents.iter().flat_map(|d| &d.logs) {
        if !evidence.logs.contains(log) {
            evidence.logs.push(log.clone());
        }
    }
    let predicted = documents.iter().filter_map(|d| d.estimate.as_ref()).flat_map(|e| &e.predicted);
    evidence.predicted = predicted
        .map(|(log, before_m, after_m)| Predicted { log: log.clone(), before_m: *before_m, after_m: *after_m })
        .collect();
    let with_stiction = documents.iter().filter(|d| d.joints.iter().any(|j| j.stiction.is_some()));
    evidence.tcp_speed_m_s = with_stiction.chain(documents).find_map(|d| d.tcp_speed_m_s);
    let mut joints = Vec::new();
    for merged in merge(documents, robot, &mut evidence.notes) {
        let joint = robot.axis(merged.axis);
        let mut known = JointEvidence { axis: merged.axis, ..JointEvidence::default() };
        if let Some(estimate) = &merged.estimate {
            joints.extend(together(&merged, estimate, joint, &mut known, &mut evidence.notes));
            evidence.joints.push(known);
            continue;
        }
        let backlash = backlash(&merged, joint, &mut known, &mut evidence.notes);
        let friction = friction(&merged, joint, form, &mut known, &mut evidence.notes)?;
        if backlash.is_none() && friction.is_none() {
            continue;
        }
        before_and_after(&merged, backlash.as_ref(), friction.as_ref(), form, &mut known);
        joints.push(JointCompensator { axis: merged.axis, backlash, friction });
        evidence.joints.push(known);
    }
    if joints.is_empty() {
        evidence.notes.push(Note::NothingToCompensate);
    }
    Ok(Compensator { robot_name: robot.name.clone(), robot_sha256: fingerprint, joints, evidence })
}

/// Offsets of a joint whose gap and friction were estimated together: applied where that helps beyond doubt.
fn together(
    m: &Merged,
    estimate: &JointEstimate,
    joint: &Joint,
    known: &mut JointEvidence,
    notes: &mut Vec<Note>,
) -> Option<JointCompensator> {
    let t = &estimate.trust;
    let (name, before_m, after_m) = (joint.name.clone(), t.before_m, t.after_m);
    if !t.compensate {
        notes.push(Note::NotTrusted { joint: name, reason: t.reason.clone(), before_m, after_m });
        return None;
    }
    notes.push(Note::Predicted { joint: name, before_m, after_m });
    known.half_gap_ci95 = Some(m.gap.ci95);
    known.proved = true;
    let mut response = estimate.response;
    let curve = m.gap.schedule.clone().unwrap_or(GapCurve::Constant(m.gap.half_gap));
    // what a joint leads by at rest is no offset that a gap may have
    let short = -curve.smallest() - response.windup();
    response.windups[0].half += short.max(0.0);
    let friction = FrictionOffset::of_response(response);
    Some(JointCompensator {
        axis: m.axis,
        backlash: Some(BacklashOffset::symmetric(curve)),
        friction: friction.acts().then_some(friction),
    })
}

/// Equation 16: a schedule where the gap varies, else the constant that leaves the smallest largest error.
fn backlash(m: &Merged, joint: &Joint, known: &mut JointEvidence, notes: &mut Vec<Note>) -> Option<BacklashOffset> {
    let (name, kind) = (|| joint.name.clone(), joint.kind);
    let g = &m.gap;
    known.half_gap_ci95 = Some(g.ci95);
    let uncertainty = (g.ci95[1] - g.ci95[0]) / 2.0;
    if g.significant && g.half_gap < -uncertainty {
        notes.push(Note::Overshoots { joint: name(), kind, half_gap: g.half_gap });
        known.half_gap_ci95 = None;
        return None;
    }
    if !g.significant || g.half_gap <= uncertainty {
        notes.push(Note::GapUncertain { joint: name(), kind, half_gap: g.half_gap, uncertainty });
        known.half_gap_ci95 = None;
        return None;
    }
    if let Some(curve) = &g.schedule {
        let (curve, dropped) = significant_knots(curve, &m.points);
        if dropped > 0 {
            notes.push(Note::PositionsUncertain { joint: name(), positions: dropped });
        }
        notes.push(Note::Scheduled { joint: name(), from: m.gap_source.clone() });
        return Some(BacklashOffset::symmetric(curve));
    }
    if let Some(s) = &g.sides {
        notes.push(Note::SidesDiffer { joint: name(), kind, positive: s.positive, negative: s.negative });
        let [positive, negative] = [s.positive, s.negative].map(GapCurve::Constant);
        return Some(BacklashOffset { positive, negative });
    }
    let d = minimax::constant_gap(g.half_gap, &m.points);
    if d != g.half_gap {
        notes.push(Note::NotTheMean { joint: name(), kind, offset: d, mean: g.half_gap });
    }
    Some(BacklashOffset::symmetric(GapCurve::Constant(d)))
}

/// A schedule whose knots are zero where the tested gap does not exceed its uncertainty; how many were.
fn significant_knots(curve: &GapCurve, points: &[GapPoint]) -> (GapCurve, usize) {
    let GapCurve::Pchip(p) = curve else { return (curve.clone(), 0) };
    let mut dropped = 0;
    let knots: Vec<[f64; 2]> = p
        .knots()
        .into_iter()
        .map(|[at, gap]| {
            let unsure =
                points.iter().filter(|q| (q.at - at).abs() < 1e-6).any(|q| q.half_gap <= (q.ci95[1] - q.ci95[0]) / 2.0);
            dropped += usize::from(unsure && gap > 0.0);
            [at, if unsure { 0.0 } else { gap.max(0.0) }]
        })
        .collect();
    (Pchip::new(&knots).map_or_else(|| curve.clone(), GapCurve::Pchip), dropped)
}

/// Standard errors by which the friction term stays on the safe side.
///
/// A gain that is too large makes the joint overshoot at once; one that is too small leaves it standing a little longer, which
/// costs little while the command is slow. Over the uncertainty of a slow circle the largest error is least, on average
/// and in its upper tenth, 0.7 to 0.8 standard errors below the estimate (`tests/oracle/friction_shade.py`).
const PRUDENCE: f64 = 0.75;

/// Gain and decay to apply for an identified spike: along the ridge on which spike and decay trade off, so that the lag that the
/// log knows best stays as it was found.
fn prudent(s: &StictionFound) -> (f64, Decay) {
    let error = |ci: [f64; 2]| if ci[0] > 0.0 && ci[1] > ci[0] { (ci[1] / ci[0]).ln() / (2.0 * Z95) } else { 0.0 };
    match s.decay {
        Decay::Time(tau) => {
            let gain = s.spike * (-PRUDENCE * error(s.ci95)).exp();
            (gain, Decay::Time(tau * (PRUDENCE * error(s.decay_ci95)).exp()))
        }
        travel => (s.spike, travel),
    }
}

/// Equation 17.
fn friction(
    m: &Merged,
    joint: &Joint,
    form: Form,
    known: &mut JointEvidence,
    notes: &mut Vec<Note>,
) -> Result<Option<FrictionOffset>> {
    let (name, kind) = (|| joint.name.clone(), joint.kind);
    let Some(s) = &m.stiction else {
        notes.extend(m.stiction_p.map(|p_value| match p_value < 0.01 {
            true => Note::StictionLikeMisfit { joint: name(), p_value },
            false => Note::NoStiction { joint: name(), p_value },
        }));
        return Ok(None);
    };
    let uncertainty = (s.ci95[1] - s.ci95[0]) / 2.0;
    if s.spike <= uncertainty || s.ci95[0] <= 0.0 {
        notes.push(Note::FrictionUncertain { joint: name(), kind, spike: s.spike, uncertainty });
        return Ok(None);
    }
    known.gain_ci95 = Some(s.ci95);
    if let Decay::Time(_) = s.decay {
        known.decay_s_ci95 = Some(s.decay_ci95);
    }
    let (gain, decay) = prudent(s);
    if gain < s.spike {
        notes.push(Note::PrudentGain { joint: name(), kind, gain, spike: s.spike });
    }
    let Form::Poses { spacing_s } = form else {
        return Ok(Some(FrictionOffset { gain, shape: FrictionShape::Decay(decay) }));
    };
    let found = over_poses(joint, gain, decay, spacing_s, s.spike - uncertainty, notes)?;
    if found.is_none() {
        (known.gain_ci95, known.decay_s_ci95) = (None, None);
    }
    Ok(found)
}

/// Equation 17 over points `spacing_s` apart; nothing where it would leave `worth` of the spike or more.
fn over_poses(
    joint: &Joint,
    gain: f64,
    decay: Decay,
    spacing_s: f64,
    worth: f64,
    notes: &mut Vec<Note>,
) -> Result<Option<FrictionOffset>> {
    let name = &joint.name;
    let Decay::Time(tau_s) = decay else {
        return Err(Error::setting(
            "form",
            format!("points counted, and a decay of {name} over travel"),
            "a decay in seconds: equation 17 counts points in time",
        ));
    };
    let f = poses::fit(gain, tau_s, spacing_s);
    let d = poses::distance(gain, tau_s, spacing_s, f.gain, f.exponent, f.poses);
    if d.largest >= worth || d.energy >= 1.0 {
        notes.push(Note::PointsTooFarApart { joint: name.clone(), spacing_s, decay_s: tau_s });
        return Ok(None);
    }
    let (joint, kind) = (name.clone(), joint.kind);
    notes.push(Note::LeftByPoints { joint, kind, left: f.largest_left, decay_s: tau_s, spacing_s });
    Ok(Some(FrictionOffset { gain: f.gain, shape: FrictionShape::Poses { exponent: f.exponent, poses: f.poses } }))
}

/// Largest joint error after the reversals, without and with the offsets, as the identified chain predicts it.
fn before_and_after(
    m: &Merged,
    backlash: Option<&BacklashOffset>,
    friction: Option<&FrictionOffset>,
    form: Form,
    known: &mut JointEvidence,
) {
    let spike = |s: &StictionFound| s.spike;
    let lag = m.stiction.as_ref().map_or(0.0, spike);
    let mut gaps: Vec<(f64, f64)> = m.points.iter().map(|p| (p.at, p.half_gap)).collect();
    if gaps.is_empty() {
        gaps.push((0.0, m.gap.half_gap));
    }
    // of a gap whose sides differ the middle is an offset of the joint, not of the gap
    let offset = |at: f64| backlash.map_or(0.0, |b| 0.5 * (b.positive.at(at) + b.negative.at(at)));
    let left_of_lag = match (friction.map(|f| (f.gain, f.shape)), m.stiction.as_ref().map(|s| s.decay), form) {
        (None, ..) => lag,
        (
            Some((gain, FrictionShape::Poses { exponent, poses })),
            Some(Decay::Time(tau_s)),
            Form::Poses { spacing_s },
        ) => poses::distance(lag, tau_s, spacing_s, gain, exponent, poses).largest,
        _ => 0.0,
    };
    known.largest_before = Some(gaps.iter().map(|g| g.1.abs()).fold(0.0, f64::max) + lag);
    known.largest_after = Some(gaps.iter().map(|g| (g.1 - offset(g.0)).abs()).fold(0.0, f64::max) + left_of_lag);
}
