//! `thermal_drift`: the TCP drifts to another position: adds `D * (1 - exp(-t/tau))` in the base frame.
//!
//! Parameters: the three coordinates of `D`, at most 10 mm each; `tau_s` between 1 s and 1e6 s: faster is a settling servo,
//! slower is no drift of one log. Where a log does not tell the time constant, a diagnosis holds it. Times count from the first row.
//! Action: warm up before measuring and working; zero again.

use super::common::*;
use nalgebra::Vector3;
use serde_yaml::Mapping;

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "thermal_drift",
    heading: "thermal drift",
    stage: Stage::Tcp,
    family: Family::Drift,
    acts_on: ActsOn::Tcp,
    adds: "the TCP drifts to another position",
    equation: "D (1 - exp(-t/tau)) in the base frame, t from the first row",
    reference: "Heisel, Richter, Wurst (1997), CIRP Annals 46(1)",
    parameters: &[("x_mm, y_mm, z_mm", "final displacement, within 10 mm"), ("tau_s", "1 s to 1e6 s")],
    confused_with: &["joint_zero_offset", "thermal_growth", "tracker_frame"],
    decide_by: "return to one pose repeatedly over the whole log",
    action: "warm up before work, measure again when warm",
    undone: "nothing: it depends on time, not on the program",
    special: Special::NONE,
    example: ("{effect: thermal_drift, x_mm: 0.1, y_mm: 0, z_mm: 0.05, tau_s: 8}", View::TcpOverTime),
    read: |f| Ok(ThermalDrift { amplitude_m: f.xyz_m()?, tau_s: f.above_0("tau_s")?, tau_held: false }.into()),
    typical: |size| {
        let mut keys = size.xyz_mm(0.03);
        keys.push(("tau_s".into(), (0.5 * size.duration_s).max(1.0).into()));
        keys
    },
    candidates,
};

/// Where it ends, m, and its time constant, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ThermalDrift {
    /// Where the drift ends, m in the base frame.
    pub amplitude_m: Vector3<f64>,
    /// Time constant, s.
    pub tau_s: f64,
    /// The time constant is no parameter of a fit.
    pub tau_held: bool,
}

/// Time constants that are tried, as shares of the longest log.
const SHARES: [f64; 5] = [0.02, 0.06, 0.2, 0.6, 2.0];

fn candidates(survey: &Survey, list: &mut Vec<Candidate>) {
    let Some((_, length)) = survey.clock.filter(|_| survey.points) else { return };
    for share in SHARES {
        let drift = move |amplitude_m| ThermalDrift { amplitude_m, tau_s: share * length, tau_held: false };
        list.push(Candidate::of_vector(survey.robot, Target::Tcp, 1e-5, drift).with_shape(1));
    }
}

impl ThermalDrift {
    /// How far it has drifted after a time, m.
    pub fn after_m(&self, t_s: f64) -> Vector3<f64> {
        self.amplitude_m * -(-t_s.max(0.0) / self.tau_s).exp_m1()
    }
}

impl EffectType for ThermalDrift {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn values(&self) -> Vec<f64> {
        let d = self.amplitude_m;
        let tau = (!self.tau_held).then_some(self.tau_s);
        [d.x, d.y, d.z].into_iter().chain(tau).collect()
    }

    fn with(&self, v: &[f64]) -> Effect {
        let tau_s = if self.tau_held { self.tau_s } else { v[3] };
        Self { amplitude_m: Vector3::new(v[0], v[1], v[2]), tau_s, ..*self }.into()
    }

    fn parameters(&self, _site: &Site) -> Vec<Parameter> {
        let mut all = Parameter::xyz_mm(0.01, 30e-6).to_vec();
        if !self.tau_held {
            all.push(Parameter::seconds("tau_s", (1.0, 1e6), 1800.0));
        }
        all
    }

    fn write(&self, site: &Site, entry: &mut Mapping) {
        for (p, v) in self.parameters(site).into_iter().zip(self.values()) {
            entry.insert(p.key.into(), (v * p.user_units_per_si).into());
        }
        if self.tau_held {
            entry.insert("tau_s".into(), self.tau_s.into());
        }
    }

    /// A drift whose end the log does not see is one along a straight line, as far as the log shows it.
    fn with_held_shape(&self, longest_s: f64, times: f64) -> Option<Effect> {
        if self.tau_held || longest_s <= 0.0 {
            return None;
        }
        let tau_s = self.tau_s.min(times * longest_s);
        let end = |tau_s: f64| -(-longest_s / tau_s).exp_m1();
        let amplitude_m = self.amplitude_m * (end(self.tau_s) / end(tau_s));
        Some(Self { amplitude_m, tau_s, tau_held: true }.into())
    }

    fn shape(&self) -> Option<usize> {
        (!self.tau_held).then_some(3)
    }

    fn displacement_m(&self, _target: Target, row: &Row, _point_m: &Vector3<f64>) -> Vector3<f64> {
        if row.settled {
            return Vector3::zeros();
        }
        self.after_m(row.t_s)
    }

    fn displaces(&self) -> bool {
        true
    }

    fn magnitude(&self) -> f64 {
        self.amplitude_m.amax()
    }

    fn idle(&self, _site: &Site, settled_poses: bool) -> Option<&'static str> {
        in_settled_poses(settled_poses)
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::nothing("it depends on time, not on the program")
    }
}
