//! `tracker_refraction`: air that is warmer above than below bends the tracker's beam, and points seem to stand too high.
//!
//! The index of air falls with its temperature, and a beam bends towards the larger index, away from the warm side. The tracker takes
//! the direction in which the beam leaves it: over a length `L` the point seems to stand `L^2/2 * 0.93e-6/K * gradient` nearer the warm
//! side, across the beam. References: Ciddor (1996), Applied Optics 35(9), for the index (0.93e-6 per K at 20 deg C, 1013 hPa, 633 nm);
//! Estler, Edmundson, Peggs, Parker (2002), CIRP Annals 51(2), for its influence on large measurements.
//!
//! A mean of the temperature that was entered wrongly lengthens distances: that is `tracker_scale`. The station stands at the origin of
//! the tracker's frame, up is the z axis of the robot's world frame. Parameter: gradient of either sign, at most 2 K/m; typical 0.2 to
//! 1 K/m in a hall. 1 K/m is 12 um at 5 m and 46 um at 10 m. A frame that is estimated takes it up, over the space that an arm fills, so
//! that a diagnosis tries it where the model has the frame. Action: stir the air.

use super::common::*;
use super::site::within;
use nalgebra::Vector3;

/// Fall of the index of air per kelvin, 1/K: 20 deg C, 1013 hPa, 633 nm.
const INDEX_PER_K: f64 = 0.93e-6;

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "tracker_refraction",
    heading: "refraction of the beam",
    stage: Stage::Measurement,
    family: Family::Tracker,
    acts_on: ActsOn::Log,
    adds: "air that is warmer above than below bends the beam of the tracker: points seem to stand towards the warm side",
    equation: "L^2/2 * 0.93e-6/K * gradient * (up - u (u . up)), u the direction of the beam, L its length",
    reference: "Ciddor (1996), Applied Optics 35(9), for the index of air; Estler, Edmundson, Peggs, Parker (2002), CIRP Annals 51(2)",
    parameters: &[("gradient_k_per_m", "change of temperature with height, within 2 K/m; positive: warmer above")],
    confused_with: &["tracker_scale", "base_tilt", "link_error", "gravity_compliance"],
    decide_by: "measure the air at two heights along the beam; repeat with the tracker at half the distance: the error falls to a quarter",
    action: "stir the air with fans, keep the beam short and away from the floor and the ceiling",
    undone: "nothing: it is an error of the measurement",
    special: Special::NONE,
    example: ("{effect: tracker_refraction, gradient_k_per_m: 1}", View::TcpOverTime),
    read: |f| Ok(TrackerRefraction { gradient_k_per_m: f.any("gradient_k_per_m")? }.into()),
    typical: |_| vec![("gradient_k_per_m".into(), 0.5.into())],
    candidates: |survey, list| {
        if survey.tracker && survey.frame_known {
            let make = |gradient_k_per_m| TrackerRefraction { gradient_k_per_m };
            list.push(Candidate::of_size(survey.robot, Target::Log, 0.1, make));
        }
    },
};

/// Change of the temperature with height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackerRefraction {
    /// K/m; positive: warmer above.
    pub gradient_k_per_m: f64,
}

impl EffectType for TrackerRefraction {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn values(&self) -> Vec<f64> {
        vec![self.gradient_k_per_m]
    }

    fn with(&self, v: &[f64]) -> Effect {
        Self { gradient_k_per_m: v[0] }.into()
    }

    fn parameters(&self, _site: &Site) -> Vec<Parameter> {
        vec![Parameter::new("gradient_k_per_m", 1.0, within(2.0), 0.5)]
    }

    fn displacement_m(&self, _target: Target, row: &Row, point_m: &Vector3<f64>) -> Vector3<f64> {
        let beam = point_m - row.station_m;
        let half = 0.5 * INDEX_PER_K * self.gradient_k_per_m;
        (Vector3::z() * beam.norm_squared() - beam * beam.z) * half
    }

    fn displaces(&self) -> bool {
        true
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::nothing("it is an error of the measurement")
    }
}
