//! The document `lostmotion/circle/1` (contract, section 8): degrees, millimetres, micrometres.

use super::{Assessment, Measured, Note, SMOOTHING_S, WINDOW_DEG};
use crate::io::keyed::Keyed;
use crate::io::rounded::{round, um};
use crate::robot::Robot;
use serde::Serialize;

pub const SCHEMA: &str = "lostmotion/circle/1";

/// What `assess circle --json` prints.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Document {
    schema: &'static str,
    robot: File,
    nominal: NominalShown,
    smoothing_s: f64,
    window_deg: [f64; 2],
    before: Half,
    /// Null without a log after compensation.
    after: Option<Half>,
    histogram: HistogramShown,
    #[schemars(with = "Vec<String>")]
    notes: Vec<Note>,
}

/// A robot or a log.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
struct File {
    name: String,
    sha256: String,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
struct NominalShown {
    radius_mm: f64,
    centre_mm: [f64; 3],
    normal: [f64; 3],
    revolutions: f64,
    assessed_phase_deg: [f64; 2],
    chord_max_um: f64,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
struct HistogramShown {
    bin_um: f64,
    before: Vec<u64>,
    after: Option<Vec<u64>>,
}

/// The run before or after compensation.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
struct Half {
    log: File,
    rows: usize,
    averaged_rows: usize,
    covered_phase_deg: [f64; 2],
    registration_rms_um: f64,
    radius_mm: f64,
    centre_mm: [f64; 3],
    total_max_um: f64,
    total_rms_um: f64,
    in_plane_max_um: f64,
    in_plane_rms_um: f64,
    out_of_plane_max_um: f64,
    out_of_plane_rms_um: f64,
    beyond_nominal_max_um: f64,
    beyond_nominal_rms_um: f64,
    reversals: Vec<ReversalShown>,
}

/// A reversal; `reduction` stands in both halves, null without a log after compensation.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
struct ReversalShown {
    joint: String,
    at_deg: f64,
    #[serde(flatten)]
    command: Keyed<f64>,
    direction: i8,
    line: Option<u64>,
    total_um: Option<f64>,
    in_plane_um: Option<f64>,
    out_of_plane_um: Option<f64>,
    beyond_nominal_um: Option<f64>,
    reduction: Option<f64>,
    reduction_beyond_nominal: Option<f64>,
}

impl Assessment {
    /// The document.
    pub fn document(&self, robot: &Robot) -> Document {
        let n = &self.nominal;
        let chords = n.chord.in_plane_m.iter().zip(&n.chord.out_of_plane_m);
        Document {
            schema: SCHEMA,
            robot: File { name: robot.name.clone(), sha256: robot.fingerprint() },
            nominal: NominalShown {
                radius_mm: round(n.circle.radius_m * 1e3, 6),
                centre_mm: millimetres(&n.circle.centre_m),
                normal: [0, 1, 2].map(|k| round(n.circle.normal[k], 9)),
                revolutions: round(n.revolutions(), 6),
                assessed_phase_deg: [round(n.from_deg, 4), round(n.to_deg, 4)],
                chord_max_um: um(chords.map(|(a, b)| a.hypot(*b)).fold(0.0, f64::max)),
            },
            smoothing_s: SMOOTHING_S,
            window_deg: WINDOW_DEG,
            before: self.half(robot, &self.before),
            after: self.after.as_ref().map(|m| self.half(robot, m)),
            histogram: HistogramShown {
                bin_um: um(self.histogram.width_m),
                before: self.histogram.before.clone(),
                after: self.after.as_ref().map(|_| self.histogram.after.clone()),
            },
            notes: self.notes.clone(),
        }
    }

    fn half(&self, robot: &Robot, m: &Measured) -> Half {
        Half {
            log: File { name: m.name.clone(), sha256: m.sha256.clone() },
            rows: m.rows,
            averaged_rows: m.averaged_rows,
            covered_phase_deg: m.covered_deg.map(|v| round(v, 4)),
            registration_rms_um: um(m.registration_rms_m),
            radius_mm: round(m.circle.radius_m * 1e3, 6),
            centre_mm: millimetres(&m.circle.centre_m),
            total_max_um: um(m.total_max_m),
            total_rms_um: um(m.total_rms_m),
            in_plane_max_um: um(m.in_plane_max_m),
            in_plane_rms_um: um(m.in_plane_rms_m),
            out_of_plane_max_um: um(m.out_of_plane_max_m),
            out_of_plane_rms_um: um(m.out_of_plane_rms_m),
            beyond_nominal_max_um: um(m.beyond_nominal_max_m),
            beyond_nominal_rms_um: um(m.beyond_nominal_rms_m),
            reversals: (0..m.reversals.len()).map(|i| self.reversal(robot, m, i)).collect(),
        }
    }

    fn reversal(&self, robot: &Robot, m: &Measured, i: usize) -> ReversalShown {
        let (r, e) = (&self.nominal.reversals[i], &m.reversals[i]);
        let joint = robot.axis(r.axis);
        ReversalShown {
            joint: joint.name.clone(),
            at_deg: round(if r.at_deg < 359.99995 { r.at_deg } else { 0.0 }, 4),
            command: Keyed::new("command", joint.kind.unit(), round(joint.kind.to_user_unit(r.command), 6)),
            direction: r.direction,
            line: r.line,
            total_um: e.total_m.map(um),
            in_plane_um: e.in_plane_m.map(um),
            out_of_plane_um: e.out_of_plane_m.map(um),
            beyond_nominal_um: e.beyond_nominal_m.map(um),
            reduction: self.reduction(i).map(|v| round(v, 4)),
            reduction_beyond_nominal: self.reduction_beyond_nominal(i).map(|v| round(v, 4)),
        }
    }
}

fn millimetres(p: &nalgebra::Vector3<f64>) -> [f64; 3] {
    [0, 1, 2].map(|k| round(p[k] * 1e3, 6))
}
