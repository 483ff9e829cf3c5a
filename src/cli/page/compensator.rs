//! Sections about a compensator: its offsets, and what was left out and why.

use super::{milli, milli2};
use crate::compensator::{Compensator, FrictionShape, JointCompensator, Note};
use crate::effects::{Decay, GapCurve};
use crate::report::{BarRow, BarsView, CompensatorRow, Page, Role, Run, Tone, method};
use crate::robot::Robot;

/// Table of offsets, then the notes of the fit.
pub fn sections(page: &mut Page, robot: &Robot, compensator: &Compensator) {
    let rows: Vec<CompensatorRow> = compensator.joints.iter().map(|j| row(robot, j)).collect();
    page.section(
        "Offsets of the compensator",
        "Added to the command in the direction of the movement; the friction term fades after each reversal.",
        rows,
    );
    if !compensator.evidence.notes.is_empty() {
        let notes: Vec<String> = compensator.evidence.notes.iter().map(Note::to_string).collect();
        page.section("Decisions of the fit", "", notes);
    }
}

/// The offsets.
pub fn methods() -> Vec<method::Method> {
    vec![method::FEEDFORWARD, method::FRICTION_POINTS]
}

fn row(robot: &Robot, j: &JointCompensator) -> CompensatorRow {
    let kind = robot.axis(j.axis).kind;
    let ends = |c: &GapCurve| milli2(robot, j.axis, [c.smallest(), c.largest()]);
    let shape = j.friction.map_or(String::new(), |f| match f.shape {
        FrictionShape::Decay(Decay::Time(t)) => format!("decays over {t:.2} s"),
        FrictionShape::Decay(Decay::Travel(x)) => format!("decays over {:.4} {}", kind.to_user_unit(x), kind.unit()),
        FrictionShape::Poses { exponent, poses } => format!("equation 17, l = {exponent}, {poses} points"),
        FrictionShape::Response(r) => {
            let decays = r.spikes.iter().filter(|s| s.gain != 0.0);
            let parts: Vec<String> = decays
                .map(|s| format!("{:.5} {} in {:.1} s", kind.to_user_unit(s.gain), kind.unit(), s.decay_s))
                .collect();
            let (over, wound) = (kind.to_user_unit(r.presliding), kind.to_user_unit(r.windup()));
            let u = kind.unit();
            let decays = if parts.is_empty() { String::new() } else { format!(" decays ({}),", parts.join(", ")) };
            format!("builds up over {over:.5} {u},{decays} wind-up {wound:.5} {u}")
        }
    });
    let kind_of = |c: &GapCurve| match c {
        GapCurve::Constant(_) => "constant".to_string(),
        GapCurve::Polynomial { coefficients, .. } => {
            format!("polynomial of degree {}", coefficients.len().saturating_sub(1))
        }
        GapCurve::Pchip(p) => format!("PCHIP, {} knots", p.knots().len()),
    };
    CompensatorRow {
        joint: robot.axis(j.axis).name.clone(),
        positive_milli: j.backlash.as_ref().map(|b| ends(&b.positive)),
        negative_milli: j.backlash.as_ref().map(|b| ends(&b.negative)),
        kind: j.backlash.as_ref().map_or(String::new(), |b| kind_of(&b.positive)),
        friction_gain_milli: j.friction.map(|f| milli(robot, j.axis, f.gain)),
        friction_shape: shape,
    }
}

/// The offsets as bars.
fn offsets(robot: &Robot, compensator: &Compensator) -> BarsView {
    let row = |j: &JointCompensator| {
        let ends = |c: &GapCurve| c.smallest().abs().max(c.largest().abs());
        let gap = j.backlash.as_ref().map(|b| milli(robot, j.axis, ends(&b.positive).max(ends(&b.negative))));
        let friction = j.friction.map(|f| milli(robot, j.axis, f.gain));
        BarRow { label: robot.axis(j.axis).name.clone(), values: vec![gap, friction] }
    };
    BarsView {
        quantity: "offset".into(),
        unit: "mdeg or µm".into(),
        runs: vec![Run::new("gap", Role::After), Run::new("friction", Role::Between)],
        rows: compensator.joints.iter().map(row).collect(),
    }
}

/// What is expected to be left along the log that shows most lost motion.
fn expected(compensator: &Compensator) -> String {
    let largest = compensator.evidence.predicted.iter().max_by(|a, b| a.before_m.total_cmp(&b.before_m));
    largest.map_or(String::new(), |p| {
        let log = super::file_name(&p.log);
        format!(": {:.0} µm rms off the path of {log} now, about {:.0} µm with them", p.before_m * 1e6, p.after_m * 1e6)
    })
}

/// Page of `fit`.
pub fn of_fit(robot: &Robot, compensator: &Compensator) -> Page {
    let mut page = super::start("fit", "Compensator", robot);
    for log in &compensator.evidence.logs {
        page.file("log", log.name.clone(), log.sha256.clone());
    }
    let names: Vec<&str> = compensator.joints.iter().map(|j| robot.axis(j.axis).name.as_str()).collect();
    let text = if names.is_empty() {
        "Nothing to compensate: programs stay unchanged.".to_string()
    } else {
        format!("Offsets for {}{}.", names.join(", "), expected(compensator))
    };
    page.verdict(Tone::Plain, text);
    if !names.is_empty() {
        page.section(
            "Largest offset of each joint",
            "Added after a reversal: the gap, and the friction that fades. In mdeg, or in µm for a prismatic joint.",
            offsets(robot, compensator),
        );
    }
    sections(&mut page, robot, compensator);
    page.section("", "", methods());
    page
}
