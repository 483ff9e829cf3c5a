//! The fields of the document `lostmotion/gaps/1`, made of [`Gaps`].
//!
//! What a kind of test knows beyond them is appended to the document by that identification ([`super::file::extend`]).

use super::file::SCHEMA;
use super::values::{NameAndHash, SIGNIFICANT_DIGITS, in_user_unit, keyed, keyed_list, number};
use super::{Distrust, GapPoint, Gaps, JointGap, Note, Registered, StictionFound, estimate};
use crate::effects::{Decay, GapCurve};
use crate::io::keyed::Keyed;
use crate::robot::file::FrameFile;
use crate::robot::{JointKind, Robot};
use serde::Serialize;
use serde_json::Value;

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    robot: NameAndHash,
    logs: Vec<NameAndHash>,
    registration: Option<RegistrationFields>,
    #[serde(skip_serializing_if = "Option::is_none")]
    tcp_speed_mm_s: Option<Value>,
    points: Vec<PointFields<'a>>,
    joints: Vec<JointFields<'a>>,
    #[serde(flatten)]
    estimate: Option<estimate::TopFields<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    distrust: Option<&'a Distrust>,
    notes: &'a [Note],
}

#[derive(Serialize)]
struct PointFields<'a> {
    joint: &'a str,
    #[serde(flatten)]
    at: Keyed<Value>,
    #[serde(flatten)]
    half_gap: Keyed<Value>,
    ci95: Value,
    cycles: usize,
    #[serde(flatten)]
    per_cycle: Option<Keyed<Value>>,
}

#[derive(Serialize)]
struct JointFields<'a> {
    joint: &'a str,
    #[serde(flatten)]
    half_gap: Keyed<Value>,
    ci95: Value,
    #[serde(flatten)]
    sides: Option<SideFields>,
    significant: bool,
    schedule: Option<CurveFields>,
    varies_p_value: Option<Value>,
    stiction: Option<StictionFields>,
    #[serde(skip_serializing_if = "Option::is_none")]
    stiction_p_value: Option<Value>,
    #[serde(flatten)]
    estimate: Option<estimate::JointFields<'a>>,
}

#[derive(Serialize)]
struct SideFields {
    #[serde(flatten)]
    positive: Keyed<Value>,
    positive_ci95: Value,
    #[serde(flatten)]
    negative: Keyed<Value>,
    negative_ci95: Value,
}

#[derive(Serialize)]
struct RegistrationFields {
    xyz_mm: Vec<Value>,
    rpy_deg: Vec<Value>,
    rms_um: Value,
    samples: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    sigma_um: Option<Vec<Value>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    sigma_deg: Option<Vec<Value>>,
}

#[derive(Serialize)]
struct StictionFields {
    #[serde(flatten)]
    spike: Keyed<Value>,
    ci95: Value,
    #[serde(flatten)]
    decay: Keyed<Value>,
    decay_ci95: Value,
}

/// A gap curve: `{kind: pchip, knots: [[position, half gap], ...]}` or `{kind: polynomial, coefficients, range_deg}`, position
/// and gap both in deg (or mm).
#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum CurveFields {
    /// The same everywhere.
    Constant {
        /// Half gap in the unit of its key.
        #[serde(flatten)]
        half_gap: Keyed<Value>,
    },
    /// Through knots.
    Pchip {
        /// Position and half gap of each.
        knots: Vec<Value>,
    },
    /// A polynomial of the position.
    Polynomial {
        /// From the constant term on.
        coefficients: Vec<Value>,
        /// Where it holds.
        #[serde(flatten)]
        range: Keyed<Value>,
    },
}

impl CurveFields {
    /// The curve of a joint of this kind.
    pub fn new(curve: &GapCurve, kind: JointKind) -> Self {
        match &curve.for_digits(SIGNIFICANT_DIGITS) {
            GapCurve::Constant(b) => Self::Constant { half_gap: keyed("half_gap", *b, kind) },
            GapCurve::Pchip(p) => Self::Pchip { knots: p.knots().iter().map(|k| in_user_unit(k, kind)).collect() },
            GapCurve::Polynomial { coefficients, range } => {
                let si = kind.si_per_user_unit();
                let scaled = coefficients.iter().enumerate().map(|(k, c)| number(c * si.powi(k as i32 - 1)));
                Self::Polynomial { coefficients: scaled.collect(), range: keyed_list("range", range, kind) }
            }
        }
    }
}

/// The document.
pub fn document(gaps: &Gaps, robot: &Robot) -> Value {
    let named = |name: &str, sha256: &str| NameAndHash { name: name.into(), sha256: sha256.into() };
    let fields = Document {
        schema: SCHEMA,
        robot: named(&gaps.robot_name, &gaps.robot_sha256),
        logs: gaps.logs.iter().map(|l| named(&l.name, &l.sha256)).collect(),
        registration: gaps.registration.as_ref().map(registration),
        tcp_speed_mm_s: gaps.tcp_speed_m_s.map(|v| number(v * 1e3)),
        points: gaps.points.iter().map(|p| point(p, robot)).collect(),
        joints: gaps.joints.iter().map(|j| joint(j, gaps, robot)).collect(),
        estimate: gaps.estimate.as_ref().map(|e| estimate::TopFields::new(e, robot)),
        distrust: gaps.distrust.as_ref(),
        notes: &gaps.notes,
    };
    serde_json::to_value(fields).unwrap_or_default()
}

fn point<'a>(p: &'a GapPoint, robot: &'a Robot) -> PointFields<'a> {
    let joint = robot.axis(p.axis);
    let kind = joint.kind;
    PointFields {
        joint: &joint.name,
        at: keyed("at", p.at, kind),
        half_gap: keyed("half_gap", p.half_gap, kind),
        ci95: in_user_unit(&p.ci95, kind),
        cycles: p.cycles,
        per_cycle: (!p.per_cycle.is_empty()).then(|| keyed_list("per_cycle", &p.per_cycle, kind)),
    }
}

fn joint<'a>(j: &'a JointGap, gaps: &'a Gaps, robot: &'a Robot) -> JointFields<'a> {
    let joint = robot.axis(j.axis);
    let kind = joint.kind;
    let of_all = gaps.estimate.iter().flat_map(|e| &e.joints).find(|e| e.axis == j.axis);
    JointFields {
        joint: &joint.name,
        half_gap: keyed("half_gap", j.half_gap, kind),
        ci95: in_user_unit(&j.ci95, kind),
        sides: j.sides.as_ref().map(|s| SideFields {
            positive: keyed("positive", s.positive, kind),
            positive_ci95: in_user_unit(&s.positive_ci95, kind),
            negative: keyed("negative", s.negative, kind),
            negative_ci95: in_user_unit(&s.negative_ci95, kind),
        }),
        significant: j.significant,
        schedule: j.schedule.as_ref().map(|c| CurveFields::new(c, kind)),
        varies_p_value: j.varies_p_value.map(number),
        stiction: j.stiction.as_ref().map(|s| stiction(s, kind)),
        stiction_p_value: j.stiction_p_value.map(number),
        estimate: of_all.map(|e| estimate::JointFields::new(e, kind)),
    }
}

fn registration(r: &Registered) -> RegistrationFields {
    let frame = FrameFile::from_isometry(&r.frame);
    let list = |values: [f64; 3], scale: f64| -> Vec<Value> { values.iter().map(|v| number(v * scale)).collect() };
    let known = r.sigma_m.iter().chain(&r.sigma_rad).any(|s| *s > 0.0);
    RegistrationFields {
        xyz_mm: list(frame.xyz_mm, 1.0),
        rpy_deg: list(frame.rpy_deg, 1.0),
        rms_um: number(r.rms_m * 1e6),
        samples: r.samples,
        sigma_um: known.then(|| list(r.sigma_m, 1e6)),
        sigma_deg: known.then(|| list(r.sigma_rad, 1f64.to_degrees())),
    }
}

fn stiction(s: &StictionFound, kind: JointKind) -> StictionFields {
    let (decay, decay_ci95) = match s.decay {
        Decay::Time(t) => (Keyed::new("decay", "s", number(t)), s.decay_ci95.iter().map(|&v| number(v)).collect()),
        Decay::Travel(x) => (keyed("decay", x, kind), in_user_unit(&s.decay_ci95, kind)),
    };
    StictionFields { spike: keyed("spike", s.spike, kind), ci95: in_user_unit(&s.ci95, kind), decay, decay_ci95 }
}
