//! The curve as the half gap of a joint: a schedule for `fit`, or an effect of a model.
//!
//! A joint that alone moves the line has the half gap `-y/2` where errors are measured minus commanded and forward is towards
//! rising positions; `+y/2` where one of the two is turned round. A prismatic joint moves by the position itself, a revolute
//! one by position over lever arm. The curve of a state is taken; over speed, a straight line through the mean half gaps
//! of the states that differ in speed alone (`backlash_speed`: `b = half_gap + slope * speed`).
//!
//! How it fails: a curve whose mean is below 0 is no play (the joint moves past its target, or a sign is turned) and is
//! refused; one that is below 0 in places is cut at 0 there, and a note says so. A polynomial of a short line far from joint position 0 has
//! terms that cancel and would not survive the digits of a document: it becomes knots.

use super::digits::digits;
use super::{Assessment, Model, Pose, Refusal, equation};
use crate::effects::{BacklashPosition, BacklashSpeed, EffectInstance, GapCurve};
use crate::error::{Error, Place, Result};
use crate::gaps::file::SIGNIFICANT_DIGITS;
use crate::gaps::note::line::Note;
use crate::gaps::{GapPoint, Gaps, JointGap, LogRef};
use crate::numerics::robust::range;
use crate::numerics::{legendre, student};
use crate::robot::Robot;

/// Which joint moves the line, and how.
#[derive(Debug, Clone, Copy)]
pub struct Mapping {
    pub axis: usize,
    /// Metres of the line per radian; 1 for a prismatic joint. Negative: the joint falls where the position rises.
    pub lever: f64,
    /// Position of the joint (rad or m) where the line's position is 0.
    pub origin: f64,
    /// The errors are commanded minus measured, or forward is towards falling positions.
    pub reversed: bool,
}

impl Mapping {
    fn joint(&self, position_m: f64) -> f64 {
        self.origin + position_m / self.lever
    }

    /// Half gap per backlash.
    fn scale(&self) -> f64 {
        (if self.reversed { 0.5 } else { -0.5 }) / self.lever.abs()
    }

    fn range(&self, [lo, hi]: [f64; 2]) -> [f64; 2] {
        let (a, b) = (self.joint(lo), self.joint(hi));
        [a.min(b), a.max(b)]
    }
}

/// Refuses a line that lies beyond the limits of the joint that moves it; notes one that reaches beyond them.
pub fn within_limits(result: &Assessment, mapping: &Mapping, robot: &Robot, notes: &mut Vec<Note>) -> Result<()> {
    let joint = robot.axis(mapping.axis);
    let Some([least, most]) = joint.limits else { return Ok(()) };
    let [lo, hi] = mapping.range(range(result.poses.iter().map(|p| p.position_m)));
    let slack = 1e-6 * (most - least);
    if lo >= least - slack && hi <= most + slack {
        return Ok(());
    }
    let (edge, unit) = (|v: f64| digits(joint.kind.to_user_unit(v), 6), joint.kind.unit());
    let (line, limits) = ([lo, hi].map(edge), [least, most].map(edge));
    if hi < least || lo > most {
        let found = format!("a line from {} to {} {unit} of {}", line[0], line[1], joint.name);
        let expected = format!("a line within its limits {} to {} {unit}", limits[0], limits[1]);
        return Err(Error::bad(Place::file(&result.file), found, expected).mended_by(&["joint", "origin", "lever_mm"]));
    }
    notes.push(Note::BeyondLimits { joint: joint.name.clone(), unit, line, limits });
    Ok(())
}

fn refused(y_m: f64) -> Error {
    Refusal::NoPlay { backlash_m: y_m }.into()
}

/// Positions of a state that were measured from both sides.
fn positions(result: &Assessment, state: usize) -> Result<Vec<f64>> {
    let here = result.poses.iter().filter(|p| p.state == state && !p.pairs_m.is_empty());
    let all: Vec<f64> = here.map(|p| p.position_m).collect();
    if all.is_empty() {
        let found = format!("no pose measured from both sides with {}", result.states.text(state));
        return Err(Error::bad(Place::file(&result.file), found, "another state").mended_by(&["at_state"]));
    }
    Ok(all)
}

/// Half gap over the joint's position in a state: constant where the backlash does not vary with position.
fn curve(model: &Model, state: usize, mapping: &Mapping, notes: &mut Vec<Note>) -> GapCurve {
    let turn = |k: usize| if mapping.lever < 0.0 && k % 2 == 1 { -mapping.scale() } else { mapping.scale() };
    let terms: Vec<f64> = model.legendre_of(state).iter().enumerate().map(|(k, c)| c * turn(k)).collect();
    let range = mapping.range(model.range_m);
    if terms.len() == 1 || range[0] >= range[1] {
        return GapCurve::Constant(terms[0]);
    }
    let polynomial = GapCurve::Polynomial { coefficients: legendre::in_powers(&terms, range), range };
    // not by powers of the position: far from 0 these lose digits
    let at = |p: f64| -> f64 {
        let u = legendre::mapped(p, range);
        terms.iter().enumerate().map(|(k, c)| c * legendre::value(k, u)).sum()
    };
    let writable = polynomial.for_digits(SIGNIFICANT_DIGITS) == polynomial;
    let curve = if writable { polynomial.clone() } else { polynomial.through_knots(at) };
    if curve.smallest() >= 0.0 {
        return curve;
    }
    notes.push(Note::CutAtZero);
    polynomial.through_knots(|p| at(p).max(0.0))
}

/// Ends of an interval times `scale`, in order.
fn scaled(c: [f64; 2], scale: f64) -> [f64; 2] {
    let (a, b) = (c[0] * scale, c[1] * scale);
    [a.min(b), a.max(b)]
}

/// The half gap of the joint at a pose that was reached from both sides.
fn point(p: &Pose, mapping: &Mapping) -> Option<GapPoint> {
    let (b, scale) = (p.backlash?, mapping.scale());
    Some(GapPoint {
        axis: mapping.axis,
        at: mapping.joint(p.position_m),
        half_gap: b.mean_m * scale,
        ci95: scaled(b.ci95_m.unwrap_or([b.mean_m; 2]), scale),
        cycles: p.pairs_m.len(),
        per_cycle: p.pairs_m.iter().map(|y| y * scale).collect(),
    })
}

/// The gaps document of a joint (`lostmotion/gaps/1`), in a state.
pub fn gaps(result: &Assessment, model: &Model, state: usize, mapping: &Mapping, robot: &Robot) -> Result<Gaps> {
    let (scale, mut notes) = (mapping.scale(), Vec::new());
    let (y, se) = model.mean_over(state, &positions(result, state)?);
    if y * scale < 0.0 {
        return Err(refused(y));
    }
    let here = result.poses.iter().filter(|p| p.state == state);
    let mut points: Vec<GapPoint> = here.filter_map(|p| point(p, mapping)).collect();
    points.sort_by(|a, b| a.at.total_cmp(&b.at));
    let half = student::factor(0.95, model.scatter.dof) * se;
    let half = if half.is_finite() { half } else { 0.0 };
    let ci95 = scaled([y - half, y + half], scale);
    let varies = model.given || model.varies_p_value.is_some_and(|p| p < result.alpha);
    if !varies && model.degree > 0 {
        notes.push(Note::Constant);
    }
    let schedule = (varies && model.degree > 0).then(|| curve(model, state, mapping, &mut notes));
    let text = result.states.text(state);
    if !text.is_empty() {
        notes.push(Note::State(text));
    }
    notes.push(Note::Equation(equation::of(model)));
    Ok(Gaps {
        estimate: None,
        distrust: None,
        robot_name: robot.name.clone(),
        robot_sha256: robot.fingerprint(),
        logs: vec![LogRef { name: result.file.clone(), sha256: result.sha256.clone() }],
        registration: None,
        points,
        joints: vec![JointGap {
            sides: None,
            axis: mapping.axis,
            half_gap: y * scale,
            ci95,
            significant: ci95[0] > 0.0,
            schedule,
            varies_p_value: model.varies_p_value,
            stiction: None,
            stiction_p_value: None,
        }],
        tcp_speed_m_s: speed_m_s(result, state),
        notes: notes.into_iter().map(Into::into).collect(),
    })
}

/// `backlash_position` (or `backlash`, where the curve is constant) of a joint, in a state.
pub fn over_position(
    result: &Assessment,
    model: &Model,
    state: usize,
    mapping: &Mapping,
    notes: &mut Vec<Note>,
) -> Result<EffectInstance> {
    let (y, _) = model.mean_over(state, &positions(result, state)?);
    if y * mapping.scale() < 0.0 {
        return Err(refused(y));
    }
    let half_gap = curve(model, state, mapping, notes);
    Ok(EffectInstance::on_axis(mapping.axis, BacklashPosition::or_constant(half_gap)))
}

/// Column of the TCP speed and its value in m/s.
fn speed_m_s(result: &Assessment, state: usize) -> Option<f64> {
    let (k, factor) = speed_column(result)?;
    Some(result.states.all[state][k].number? * factor)
}

fn speed_column(result: &Assessment) -> Option<(usize, f64)> {
    result.states.names.iter().enumerate().find_map(|(k, n)| match n.to_ascii_lowercase().as_str() {
        "speed_mm_s" => Some((k, 1e-3)),
        "speed_m_s" => Some((k, 1.0)),
        _ => None,
    })
}

/// `backlash_speed` of a joint: the reference and the states that differ from it in speed alone.
pub fn over_speed(
    result: &Assessment,
    model: &Model,
    mapping: &Mapping,
    notes: &mut Vec<Note>,
) -> Result<EffectInstance> {
    let file = || Place::file(&result.file);
    let Some((k, _)) = speed_column(result) else {
        return Err(Error::bad(file(), "no column `speed_mm_s`", "readings at two or more TCP speeds"));
    };
    let all = &result.states.all;
    let alone = |s: usize| (0..result.states.names.len()).all(|c| c == k || all[s][c] == all[model.reference][c]);
    let tested = |s: &usize| *s == model.reference || model.tests.iter().any(|t| t.state == *s);
    let states: Vec<usize> = result.order.iter().copied().filter(|s| alone(*s)).filter(tested).collect();
    let places = positions(result, model.reference)?;
    let mut points: Vec<[f64; 2]> = Vec::new();
    for s in &states {
        match speed_m_s(result, *s) {
            Some(v) => points.push([v, model.mean_over(*s, &places).0 * mapping.scale()]),
            None => {
                let found = format!("speed `{}`", all[*s][k].text);
                return Err(Error::bad(file(), found, "a number of mm/s in every row"));
            }
        }
    }
    if points.len() < 2 {
        return Err(Error::bad(
            file(),
            "one TCP speed",
            "readings at two or more TCP speeds with all other states equal",
        ));
    }
    if !model.states().any(|s| states.contains(&s)) {
        return Err(Refusal::NoSlope.into());
    }
    let n = points.len() as f64;
    let mean = |i: usize| points.iter().map(|p| p[i]).sum::<f64>() / n;
    let (v, b) = (mean(0), mean(1));
    let sxx: f64 = points.iter().map(|p| (p[0] - v).powi(2)).sum();
    let slope = points.iter().map(|p| (p[0] - v) * (p[1] - b)).sum::<f64>() / sxx;
    let half_gap = b - slope * v;
    if half_gap < 0.0 || points.iter().any(|p| half_gap + slope * p[0] < 0.0) {
        return Err(refused(model.mean_over(model.reference, &places).0));
    }
    let off = points.iter().map(|p| (half_gap + slope * p[0] - p[1]).abs()).fold(0.0, f64::max);
    if points.len() > 2 {
        notes.push(Note::OverSpeed { speeds: points.len(), error_m: off * mapping.lever.abs() });
    }
    if model.degree > 0 {
        notes.push(Note::MeanOverLine);
    }
    Ok(EffectInstance::on_axis(mapping.axis, BacklashSpeed { half_gap, slope }))
}
