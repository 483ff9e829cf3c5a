//! `thermal_growth`: a link grows, or a joint's zero creeps, with time, with the row or with the temperature.
//!
//! Adds `rate * x` to the joint, or to the `a` or `d` of a joint's link; `x` is the time since the first row in hours, or
//! `(tau/3600)(1 - exp(-t/tau))` where `tau_s` is given (warming up that ends), or the change of `temp_c` since the first row, or the
//! number of the row (poses without a clock). Reference: Heisel, Richter, Wurst (1997), CIRP Annals 46(1); Gong, Yuan, Ni
//! (2000), Int. J. Machine Tools and Manufacture 40(1).
//!
//! Parameters: rates of either sign, at most 100 mm (0.1 rad) an hour, 1 mm (0.01 rad) a kelvin, 0.1 mm (1 mrad) a row; steel grows
//! by 12 um a metre and kelvin. Typical: 10 to 100 um. A length moves the TCP along the link's axis; joints do not change.

use super::common::*;
use super::site::within;
use nalgebra::Vector3;

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "thermal_growth",
    heading: "thermal growth",
    stage: Stage::Geometry,
    family: Family::Drift,
    acts_on: ActsOn::JointOrDhParameter(&[DhParameter::A, DhParameter::D]),
    adds: "a link grows, or a joint's zero drifts, with time or temperature",
    equation: "rate x, x hours since the first row, tau (1 - exp(-t/tau)) in hours, kelvin since the first row, or rows",
    reference: "Heisel, Richter, Wurst (1997), CIRP Annals 46(1); Gong, Yuan, Ni (2000), Int. J. Machine Tools and Manufacture 40(1)",
    parameters: &[
        ("per_hour_mm or per_hour_deg", "either sign, within 100 mm or 0.1 rad"),
        ("per_k_mm or per_k_deg", "instead of per_hour, with a column `temp_c`: within 1 mm or 0.01 rad"),
        ("per_row_mm or per_row_deg", "instead of per_hour, for poses without times: within 0.1 mm or 1 mrad"),
        ("tau_s", "with per_hour, time constant with which the growth levels off: 1 s to 1e6 s"),
    ],
    confused_with: &["thermal_drift", "tracker_frame", "link_error", "joint_zero_offset"],
    decide_by: "log the temperature; visit the same poses cold and warm, in another order",
    action: "warm up before work; measure and calibrate at the working temperature",
    undone: "nothing: it depends on time, not on the program",
    special: Special {
        further: |survey, list| {
            let until = |(_, length): (f64, f64)| SHARES.map(|share| Some((With::HoursUntil(share * length), "until")));
            let kelvin = survey.clock.is_none() && survey.temperature;
            let without_clock = [Some((With::Rows, "rows")), kelvin.then_some((With::Kelvin, "kelvin"))];
            if survey.clock.is_none() || survey.points {
                tried(survey, list, &survey.clock.map_or(without_clock, until));
            }
        },
        ..Special::NONE
    },
    example: ("{effect: thermal_growth, target: A1.a, per_hour_mm: 15, tau_s: 8}", View::TcpOverTime),
    read,
    typical: |size| {
        if size.has("per_") {
            return Vec::new();
        }
        let rate = if size.is_revolute() { 0.002 } else { 0.05 };
        vec![(size.key("per_hour"), (rate * 3600.0 / size.duration_s.max(1.0)).into())]
    },
    // where a drift of the TCP is tried: growth in proportion to time or temperature; that which levels off has more freedom. A joint
    // sensor drifts itself, and its gear creeps
    candidates: |survey, list| {
        if survey.clock.is_some() && survey.points {
            tried(
                survey,
                list,
                &[Some((With::Hours, "hours")), survey.temperature.then_some((With::Kelvin, "kelvin"))],
            );
        }
    },
};

/// What it grows with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum With {
    /// Hours since the first row.
    Hours,
    /// Hours, towards an end with this time constant, s.
    HoursUntil(f64),
    /// The temperature less that of the first row.
    Kelvin,
    /// The number of the row, of settled poses without times.
    Rows,
}

/// Rate in rad or m per hour, kelvin or row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThermalGrowth {
    /// Growth, rad or m per hour, kelvin or row.
    pub rate: f64,
    /// What it grows with.
    pub with: With,
    /// It changes a joint's position; else a length.
    pub of_joint: bool,
}

const SECONDS_PER_HOUR: f64 = 3600.0;

fn read(f: &mut Fields) -> Result<Effect> {
    let site = f.site();
    let tau = f.number("tau_s", f64::MIN_POSITIVE)?;
    let (hours, kelvin, rows) = (site.key("per_hour"), site.key("per_k"), site.key("per_row"));
    let mut take = |key: &str| f.number(key, f64::NEG_INFINITY);
    let (rate, with) = match (take(&hours)?, take(&kelvin)?, take(&rows)?, tau) {
        (Some(r), None, None, None) => (r, With::Hours),
        (Some(r), None, None, Some(tau)) => (r, With::HoursUntil(tau)),
        (None, Some(r), None, None) => (r, With::Kelvin),
        (None, None, Some(r), None) => (r, With::Rows),
        _ => {
            let expected = format!("one of `{hours}` (perhaps with `tau_s`), `{kelvin}`, `{rows}`");
            return Err(f.bad("per_", "no rate, or two", &expected));
        }
    };
    let of_joint = matches!(site.target, Target::Joint(_));
    Ok(ThermalGrowth { rate: rate * site.si_per_user_unit(), with, of_joint }.into())
}

/// Time constants that are tried, as shares of the longest log.
const SHARES: [f64; 2] = [0.1, 0.4];

/// Growth of every joint and of every length, with each of some inputs.
fn tried(survey: &Survey, list: &mut Vec<Candidate>, ways: &[Option<(With, &'static str)>]) {
    let joints = survey.all_axes().map(Target::Joint);
    let link = |joint| [DhParameter::A, DhParameter::D].map(|parameter| Target::Link { joint, parameter });
    // a length of zero does not grow
    let long = |t: &Target| match t {
        Target::Link { joint, parameter: DhParameter::A } => survey.robot.joints[*joint].a_m != 0.0,
        Target::Link { joint, .. } => survey.robot.joints[*joint].d_m != 0.0,
        _ => true,
    };
    let links = (0..survey.robot.joints.len()).flat_map(link).filter(long).filter(|_| survey.points);
    for target in joints.chain(links) {
        let of_joint = matches!(target, Target::Joint(_));
        for (with, form) in ways.iter().flatten().copied() {
            let shape = usize::from(matches!(with, With::HoursUntil(_)));
            let make = move |rate| ThermalGrowth { rate, with, of_joint };
            list.push(Candidate::of_size(survey.robot, target, 1e-5, make).with_shape(shape).with_form(form));
        }
    }
}

impl ThermalGrowth {
    /// What it grows with, at a row.
    fn so_far(&self, inputs: &dyn Inputs, index: usize) -> f64 {
        let since = || inputs.t_s().first().zip(inputs.t_s().get(index)).map_or(0.0, |(a, b)| b - a);
        match self.with {
            With::Hours => since() / SECONDS_PER_HOUR,
            With::HoursUntil(tau) => tau / SECONDS_PER_HOUR * -(-since() / tau).exp_m1(),
            With::Kelvin => {
                let all = inputs.temp_c();
                all.and_then(|t| t.first().zip(t.get(index))).map_or(0.0, |(a, b)| b - a)
            }
            With::Rows => index as f64,
        }
    }
}

impl EffectType for ThermalGrowth {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn values(&self) -> Vec<f64> {
        match self.with {
            With::HoursUntil(tau) => vec![self.rate, tau],
            _ => vec![self.rate],
        }
    }

    fn with(&self, v: &[f64]) -> Effect {
        let with = if let With::HoursUntil(_) = self.with { With::HoursUntil(v[1]) } else { self.with };
        Self { rate: v[0], with, ..*self }.into()
    }

    fn parameters(&self, site: &Site) -> Vec<Parameter> {
        // an arm of a metre that warms by some kelvin an hour
        let (name, mm, rad, typical) = match self.with {
            With::Hours | With::HoursUntil(_) => ("per_hour", 100.0, 0.1, site.typical(0.003, 0.05)),
            With::Kelvin => ("per_k", 1.0, 0.01, site.typical(0.001, 0.01)),
            With::Rows => ("per_row", 0.1, 1e-3, site.typical(1e-5, 1e-4)),
        };
        let most = if site.is_revolute() { rad } else { mm * 1e-3 };
        let mut all = vec![site.length(name, within(most), typical)];
        if let With::HoursUntil(_) = self.with {
            all.push(Parameter::seconds("tau_s", (1.0, 1e6), 1800.0));
        }
        all
    }

    /// Growth whose end the log does not see is in proportion to time.
    fn with_held_shape(&self, _longest_s: f64, _times: f64) -> Option<Effect> {
        matches!(self.with, With::HoursUntil(_)).then(|| Self { with: With::Hours, ..*self }.into())
    }

    fn shape(&self) -> Option<usize> {
        matches!(self.with, With::HoursUntil(_)).then_some(1)
    }

    fn stage(&self) -> Stage {
        if self.of_joint { Stage::Link } else { Stage::Geometry }
    }

    fn add_to_joint(&self, _target: Target, inputs: &dyn Inputs, joint: &mut [f64]) {
        for (index, q) in joint.iter_mut().enumerate() {
            *q += self.rate * self.so_far(inputs, index);
        }
    }

    fn displacement_m(&self, target: Target, row: &Row, _point_m: &Vector3<f64>) -> Vector3<f64> {
        let Target::Link { joint, parameter } = target else { return Vector3::zeros() };
        let by = self.rate * self.so_far(row.inputs, row.index);
        row.direction_of(joint, parameter) * by
    }

    fn displaces(&self) -> bool {
        !self.of_joint
    }

    fn uses_frames(&self) -> bool {
        !self.of_joint
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::nothing("it depends on time, not on the program")
    }
}
