//! `tracker_scale`: the tracker's distances are `1 + scale` too long, from its station.
//!
//! A laser tracker measures a distance by the wavelength of its laser in air: 1 K or 3.7 hPa of error in the refraction is 1 ppm;
//! a worn calibration some ppm more. Reference: ISO 10360-10:2021; Ciddor (1996), Applied Optics 35(9), for the index of air.
//!
//! The station stands at the origin of the tracker's frame. Without a registration it is taken to stand in the base; an estimated
//! frame takes up the difference. Parameter: `scale_ppm` of either sign, at most 1000 ppm. Action: enter the weather, check the
//! scale bar.

use super::common::*;
use super::site::within;
use nalgebra::Vector3;

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "tracker_scale",
    heading: "tracker scale",
    stage: Stage::Measurement,
    family: Family::Tracker,
    acts_on: ActsOn::Log,
    adds: "the tracker measures every distance from its station proportionally too long or too short",
    equation: "scale (p - station)",
    reference: "ISO 10360-10:2021; Ciddor (1996), Applied Optics 35(9), for the index of air",
    parameters: &[("scale_ppm", "either sign, within 1,000 ppm")],
    confused_with: &["encoder_scale", "link_error"],
    decide_by: "measure a scale bar or two fixed nests before and after; move the tracker to another distance",
    action: "enter temperature, pressure and humidity of the air; check the tracker on a scale bar",
    undone: "nothing: it is an error of the measurement",
    special: Special::NONE,
    example: ("{effect: tracker_scale, scale_ppm: 40}", View::TcpOverTime),
    read: |f| Ok(TrackerScale { scale: f.any("scale_ppm")? * 1e-6 }.into()),
    typical: |_| vec![("scale_ppm".into(), 10.0.into())],
    candidates: |survey, list| {
        if survey.tracker {
            list.push(Candidate::of_size(survey.robot, Target::Log, 1e-6, |scale| TrackerScale { scale }));
        }
    },
};

/// Relative error of distances (1e-6 per ppm).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackerScale {
    /// Relative error of distances.
    pub scale: f64,
}

impl EffectType for TrackerScale {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn values(&self) -> Vec<f64> {
        vec![self.scale]
    }

    fn with(&self, v: &[f64]) -> Effect {
        Self { scale: v[0] }.into()
    }

    fn parameters(&self, _site: &Site) -> Vec<Parameter> {
        vec![Parameter::new("scale_ppm", 1e6, within(1e-3), 5e-6)]
    }

    fn displacement_m(&self, _target: Target, row: &Row, point_m: &Vector3<f64>) -> Vector3<f64> {
        (point_m - row.station_m) * self.scale
    }

    fn displaces(&self) -> bool {
        true
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::nothing("it is an error of the measurement")
    }
}
