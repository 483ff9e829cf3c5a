//! What may be missing: every effect of the catalogue on every target, with the shapes of its nonlinear parameters.
//!
//! A [`Candidate`] is one effect on one target with its shape (decay, presliding, time constant) held: its signatures are
//! linear in what is left, so that all candidates can be compared by linear algebra; a refit frees the shape later.
//! Ripple and vibration have a frequency instead of a list of shapes: [`super::spectrum`] finds it.

use super::forward::{Hypothesis, Problem, State};
use super::normal::dot;
use crate::effects::{
    AxisCoupling, Backlash, BacklashSpeed, Decay, DhParameter, Effect, EffectInstance, EncoderScale, GapCurve,
    GravityCompliance, Hysteresis, JointZeroOffset, LinkError, ServoLag, Stiction, Target, ThermalDrift, TimeOffset,
    ToolError, TransmissionError, Vibration, curve::Pchip,
};
use crate::robot::JointKind;
use nalgebra::Vector3;

/// Makes effects of linear coefficients.
type Build = Box<dyn Fn(&[f64]) -> Vec<EffectInstance> + Send + Sync>;

/// One effect on one target with its shape held.
pub struct Candidate {
    pub effect: &'static str,
    pub target: String,
    /// Effects whose signatures are compared with, one per linear coefficient, each at the size `scale`; where `base`
    /// stands, it is taken off.
    trial: Vec<(Vec<EffectInstance>, f64)>,
    base: Option<Vec<EffectInstance>>,
    /// The first coefficient may not be negative: a gap, a spike, a lag.
    pub positive: bool,
    /// Parameters that the shape holds.
    pub shape_parameters: usize,
    /// Forms of one effect that a refit cannot turn into each other.
    pub form: &'static str,
    build: Build,
}

impl Candidate {
    /// Linear coefficients and shape parameters.
    pub fn parameters(&self) -> usize {
        self.trial.len() + self.shape_parameters
    }

    /// Number of signatures.
    pub fn signatures(&self) -> usize {
        self.trial.len()
    }

    /// The joint whose position it changes.
    pub fn axis(&self) -> Option<usize> {
        self.trial.first().and_then(|t| t.0.first()).and_then(EffectInstance::axis)
    }

    /// Signatures, one per coefficient.
    pub fn columns(&self, problem: &Problem, h: &Hypothesis, state: &State) -> Vec<Vec<f64>> {
        let base = self.base.as_ref().map(|b| problem.difference(h, state, &[], b, 1.0));
        self.trial
            .iter()
            .map(|(to, scale)| {
                let mut column = problem.difference(h, state, &[], to, *scale);
                if let Some(base) = &base {
                    for (c, b) in column.iter_mut().zip(base) {
                        *c -= b / scale;
                    }
                }
                column
            })
            .collect()
    }

    /// The effects at the given coefficients.
    pub fn at(&self, coefficients: &[f64]) -> Vec<EffectInstance> {
        (self.build)(coefficients)
    }
}

/// Size at which joint effects are tried, rad or m: far below any gap, so that the signature is that of a small one.
const TRIAL: f64 = 2e-6;

fn one(
    problem: &Problem,
    target: Target,
    effect: Effect,
    scale: f64,
    positive: bool,
    shape_parameters: usize,
    build: impl Fn(f64) -> Effect + Send + Sync + 'static,
) -> Candidate {
    let placed = EffectInstance { target, effect };
    Candidate {
        effect: placed.effect.name(),
        target: placed.target_text(&problem.robot),
        trial: vec![(vec![placed], scale)],
        base: None,
        positive,
        shape_parameters,
        form: "",
        build: Box::new(move |c| vec![EffectInstance { target, effect: build(c[0]) }]),
    }
}

/// All candidates but ripple and vibration.
pub fn all(problem: &Problem) -> Vec<Candidate> {
    let mut list = Vec::new();
    for axis in 0..problem.robot.dof() {
        joint(problem, axis, &mut list);
    }
    geometry(problem, &mut list);
    if problem.logs.iter().any(|l| l.reflectors() > 0) {
        tcp(problem, &mut list);
    }
    if problem.logs.iter().any(|l| !l.log.poses) {
        let effect = |s: f64| Effect::TimeOffset(TimeOffset { offset_s: s });
        list.push(one(problem, Target::Log, effect(1e-4), 1e-4, false, 0, effect));
    }
    list
}

/// Length of the shortest sample interval and of the longest log, s; `None` for poses alone.
pub fn clock(problem: &Problem) -> Option<(f64, f64)> {
    let (mut step, mut length) = (f64::INFINITY, 0.0_f64);
    for l in problem.logs.iter().filter(|l| !l.log.poses && l.drive.rows() > 1) {
        let t = l.drive.t_s();
        let span = t[t.len() - 1] - t[0];
        step = step.min(span / (t.len() - 1) as f64);
        length = length.max(span);
    }
    (length > 0.0).then_some((step, length))
}

fn joint(problem: &Problem, axis: usize, list: &mut Vec<Candidate>) {
    let target = Target::Joint(axis);
    let joint = problem.robot.axis(axis);
    let unit = joint.kind.si();
    let offset = |x: f64| Effect::JointZeroOffset(JointZeroOffset { offset: x });
    list.push(one(problem, target, offset(TRIAL), TRIAL, false, 0, offset));
    if problem.logs.iter().any(|l| l.drive.gravity_torque(axis).iter().any(|t| *t != 0.0)) {
        let effect = |x: f64| Effect::GravityCompliance(GravityCompliance { compliance: x });
        list.push(one(problem, target, effect(1e-8), 1e-8, true, 0, effect));
    }
    // a joint at rest may still be moved by another one
    for from in (0..problem.robot.dof()).filter(|&f| f != axis && problem.robot.axis(f).kind == joint.kind) {
        if problem.logs.iter().any(|l| l.log.travel(from) > 1e-3 * unit) {
            let effect = |x: f64| Effect::AxisCoupling(AxisCoupling { ratio: x });
            list.push(one(problem, Target::Coupled { to: axis, from }, effect(1e-6), 1e-6, false, 0, effect));
        }
    }
    let travel = problem.logs.iter().map(|l| l.log.travel(axis)).fold(0.0, f64::max);
    if travel < 1e-4 * unit.max(1e-2) {
        return;
    }
    let scale = |x: f64| Effect::EncoderScale(EncoderScale { scale: x });
    list.push(one(problem, target, scale(1e-6), 1e-6, false, 0, scale));
    gaps(problem, axis, list);
    if let Some((step, length)) = clock(problem) {
        let lag = |x: f64| Effect::ServoLag(ServoLag { lag_s: x });
        list.push(one(problem, target, lag(1e-4), 1e-4, true, 0, lag));
        let mut tau = 0.75 * step.max(0.02);
        while tau < 0.5 * length && tau < 30.0 {
            stiction(problem, target, Decay::Time(tau), list);
            tau *= 1.9;
        }
    }
    let mut lambda = 0.01 * unit;
    while lambda < 0.5 * travel {
        stiction(problem, target, Decay::Travel(lambda), list);
        let effect = move |x: f64| Effect::Hysteresis(Hysteresis { half_width: x, presliding: lambda });
        list.push(one(problem, target, effect(TRIAL), TRIAL, true, 1, effect));
        lambda *= 2.7;
    }
}

fn stiction(problem: &Problem, target: Target, decay: Decay, list: &mut Vec<Candidate>) {
    let effect = move |x: f64| Effect::Stiction(Stiction { spike: x, decay });
    let form = if matches!(decay, Decay::Time(_)) { "time" } else { "travel" };
    list.push(Candidate { form, ..one(problem, target, effect(TRIAL), TRIAL, true, 1, effect) });
}

/// Counts of knots with which a gap over position is tried.
const KNOTS: &[usize] = &[3, 5, 8];

fn gaps(problem: &Problem, axis: usize, list: &mut Vec<Candidate>) {
    let target = Target::Joint(axis);
    let gap = |x: f64| Effect::Backlash(Backlash::constant(x.max(0.0)));
    list.push(one(problem, target, gap(TRIAL), TRIAL, true, 0, gap));
    let name = |e: &Effect| (e.name(), EffectInstance { target, effect: e.clone() }.target_text(&problem.robot));
    // over the TCP speed
    let speed = |b: f64, m: f64| Effect::BacklashSpeed(BacklashSpeed { half_gap: b, slope: m });
    let (effect, text) = name(&speed(TRIAL, 0.0));
    let place = move |e: Effect| vec![EffectInstance { target, effect: e }];
    let fastest =
        problem.logs.iter().flat_map(|l| l.drive.tcp_speed_m_s().iter().copied()).fold(0.0, f64::max).max(1e-6);
    list.push(Candidate {
        effect,
        target: text,
        trial: vec![(place(speed(TRIAL, 0.0)), TRIAL), (place(speed(0.0, TRIAL / fastest)), TRIAL / fastest)],
        base: None,
        positive: false,
        shape_parameters: 0,
        form: "",
        build: Box::new(move |c| {
            // a gap is nowhere negative: start inside
            let least = c[0].min(c[0] + c[1] * fastest);
            let lift = if least < 0.0 { -least } else { 0.0 };
            place(speed(c[0] + lift, c[1]))
        }),
    });
    // over position
    let (lo, hi) = problem
        .logs
        .iter()
        .flat_map(|l| l.drive.command(axis).iter().copied())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    for &n in KNOTS {
        let places: Vec<f64> = (0..n).map(|k| lo + (hi - lo) * k as f64 / (n - 1) as f64).collect();
        let curve = move |gaps: &[f64]| -> Option<Effect> {
            let knots: Vec<[f64; 2]> = places.iter().zip(gaps).map(|(&p, &b)| [p, b.max(0.0)]).collect();
            Pchip::new(&knots).map(|p| Effect::Backlash(Backlash { half_gap: GapCurve::Pchip(p) }))
        };
        let trial: Option<Vec<(Vec<EffectInstance>, f64)>> = (0..n)
            .map(|k| {
                let gaps: Vec<f64> = (0..n).map(|i| if i == k { 1.5 * TRIAL } else { TRIAL }).collect();
                curve(&gaps).map(|e| (place(e), 0.5 * TRIAL))
            })
            .collect();
        let base = curve(&vec![TRIAL; n]).map(place);
        if let (Some(trial), Some(base)) = (trial, base) {
            let (effect, text) = name(&base[0].effect);
            list.push(Candidate {
                effect,
                target: text,
                trial,
                base: Some(base),
                positive: false,
                shape_parameters: 0,
                form: "",
                build: Box::new(move |c| curve(c).map(place).unwrap_or_default()),
            });
        }
    }
}

fn geometry(problem: &Problem, list: &mut Vec<Candidate>) {
    if problem.logs.iter().all(|l| l.reflectors() == 0) {
        return;
    }
    for joint in 0..problem.robot.joints.len() {
        for parameter in [DhParameter::A, DhParameter::D, DhParameter::Alpha] {
            // a prismatic joint's d is its zero offset
            if parameter == DhParameter::D && problem.robot.joints[joint].kind == JointKind::Prismatic {
                continue;
            }
            let effect = |x: f64| Effect::LinkError(LinkError { delta: x });
            list.push(one(problem, Target::Link { joint, parameter }, effect(1e-5), 1e-5, false, 0, effect));
        }
    }
    let tool = |v: Vector3<f64>| {
        vec![EffectInstance { target: Target::Tool, effect: Effect::ToolError(ToolError { offset_m: v }) }]
    };
    list.push(Candidate {
        effect: "tool_error",
        target: "tool".into(),
        trial: (0..3).map(|k| (tool(Vector3::ith(k, 1e-5)), 1e-5)).collect(),
        base: None,
        positive: false,
        shape_parameters: 0,
        form: "",
        build: Box::new(move |c| tool(Vector3::new(c[0], c[1], c[2]))),
    });
}

fn tcp(problem: &Problem, list: &mut Vec<Candidate>) {
    let Some((_, length)) = clock(problem) else { return };
    for share in [0.02, 0.06, 0.2, 0.6, 2.0] {
        let tau_s = share * length;
        let drift = move |v: Vector3<f64>| {
            vec![EffectInstance {
                target: Target::Tcp,
                effect: Effect::ThermalDrift(ThermalDrift { amplitude_m: v, tau_s }),
            }]
        };
        list.push(Candidate {
            effect: "thermal_drift",
            target: "tcp".into(),
            trial: (0..3).map(|k| (drift(Vector3::ith(k, 1e-5)), 1e-5)).collect(),
            base: None,
            positive: false,
            shape_parameters: 1,
            form: "",
            build: Box::new(move |c| drift(Vector3::new(c[0], c[1], c[2]))),
        });
    }
}

/// Ripple of an axis at a number of cycles per revolution (of its lead, for a prismatic one).
pub fn ripple(problem: &Problem, axis: usize, cycles_per_rev: f64) -> Candidate {
    let target = Target::Joint(axis);
    let effect = move |sine: f64, cosine: f64| {
        let (amplitude, phase_rad) = (sine.hypot(cosine), cosine.atan2(sine));
        vec![EffectInstance {
            target,
            effect: Effect::TransmissionError(TransmissionError { amplitude, cycles_per_rev, phase_rad }),
        }]
    };
    let name = effect(TRIAL, 0.0);
    Candidate {
        effect: name[0].effect.name(),
        target: name[0].target_text(&problem.robot),
        trial: vec![(effect(TRIAL, 0.0), TRIAL), (effect(0.0, TRIAL), TRIAL)],
        base: None,
        positive: false,
        shape_parameters: 1,
        form: "",
        build: Box::new(move |c| effect(c[0], c[1])),
    }
}

/// Vibration of the TCP at a frequency: sine and cosine in three directions; built along the strongest one.
pub fn vibration(frequency_hz: f64) -> Candidate {
    let effect = move |v: Vector3<f64>, phase_rad: f64| {
        let amplitude_m = v.norm();
        let direction = if amplitude_m > 0.0 { v / amplitude_m } else { Vector3::x() };
        vec![EffectInstance {
            target: Target::Tcp,
            effect: Effect::Vibration(Vibration { amplitude_m, frequency_hz, phase_rad, direction }),
        }]
    };
    let quarter = std::f64::consts::FRAC_PI_2;
    Candidate {
        effect: "vibration",
        target: "tcp".into(),
        trial: (0..6).map(|k| (effect(Vector3::ith(k % 3, 1e-5), if k < 3 { 0.0 } else { quarter }), 1e-5)).collect(),
        base: None,
        positive: false,
        // the six coefficients of an ellipse hold one more than a line has
        shape_parameters: 0,
        form: "",
        build: Box::new(move |c| {
            let (s, c) = (Vector3::new(c[0], c[1], c[2]), Vector3::new(c[3], c[4], c[5]));
            // the phase at which the ellipse is longest: its major axis is the line of motion
            let phase = 0.5 * (2.0 * dot(s.as_slice(), c.as_slice())).atan2(s.norm_squared() - c.norm_squared());
            effect(s * phase.cos() + c * phase.sin(), phase)
        }),
    }
}
