//! Learned kinematics: a network for each coordinate of the TCP, and the commands for which it was taught.

use super::network::Network;
use crate::gaps::LogRef;

/// Coordinates of the TCP by their letters.
pub const LETTERS: [&str; 3] = ["x", "y", "z"];

/// Which cost a network was trained with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Positions alone (FFNet of Cursi (2022)).
    Plain,
    /// Positions and velocities (AugNet).
    Augmented,
}

impl Kind {
    /// Name of the kind in documents.
    pub fn text(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Augmented => "augmented",
        }
    }
}

/// Range of an axis in the training: commands are scaled as `(q - centre) / half_range`. An axis that stood still has the half range 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Input {
    /// Middle of the range of the training data, rad or m.
    pub centre: f64,
    /// Half the range of the training data, rad or m.
    pub half_range: f64,
}

impl Input {
    /// Lower and upper end, rad or m.
    pub fn range(&self) -> [f64; 2] {
        [self.centre - self.half_range, self.centre + self.half_range]
    }

    fn scaled(&self, q: f64) -> f64 {
        if self.half_range > 0.0 { (q - self.centre) / self.half_range } else { 0.0 }
    }

    /// Scaled units per rad or m.
    pub fn gain(&self) -> f64 {
        if self.half_range > 0.0 { 1.0 / self.half_range } else { 0.0 }
    }
}

/// Root mean square errors of a coordinate, m and m/s.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rmse {
    /// Root mean square error of the position, m.
    pub position_m: f64,
    /// Root mean square error of the velocity, m/s; `None` of a plain network.
    pub speed_m_s: Option<f64>,
}

/// What the kinematics is based on.
#[derive(Debug, Clone, Default)]
pub struct Evidence {
    /// Logs that were learned from.
    pub logs: Vec<LogRef>,
    /// The commands learned from were those of these programs, and the machine got compensated ones.
    pub programs: Vec<LogRef>,
    /// Seed of the split and of the first weights.
    pub seed: u64,
    /// Number of rows that were learned from.
    pub train_rows: usize,
    /// Number of rows that were kept for the test.
    pub test_rows: usize,
    /// Per coordinate.
    pub train: Vec<Rmse>,
    /// Errors on the rows of the test, one per coordinate.
    pub test: Vec<Rmse>,
}

/// Forward kinematics of one robot from commands to the TCP in the log's frame.
#[derive(Debug, Clone)]
pub struct Learned {
    /// Name of the robot.
    pub robot_name: String,
    /// Fingerprint of the robot.
    pub robot_sha256: String,
    /// Plain or augmented.
    pub kind: Kind,
    /// 0, 1, 2 for x, y, z; rising.
    pub coordinates: Vec<usize>,
    /// One per axis.
    pub inputs: Vec<Input>,
    /// One per coordinate; outputs in m.
    pub networks: Vec<Network>,
    /// The data and the errors of the training.
    pub evidence: Evidence,
    /// The file it was read from.
    pub file: Option<LogRef>,
}

impl Learned {
    /// Commands scaled for the networks.
    pub fn scaled(&self, q: &[f64]) -> Vec<f64> {
        self.inputs.iter().zip(q).map(|(i, &q)| i.scaled(q)).collect()
    }

    /// Coordinates of the TCP at commands `q` (rad or m), m.
    pub fn position_m(&self, q: &[f64]) -> Vec<f64> {
        let u = self.scaled(q);
        self.networks.iter().map(|n| n.value(&u)).collect()
    }

    /// The same with the derivative by each axis, `jacobian[coordinate][axis]` in m/rad or m/m.
    pub fn position_and_jacobian(&self, q: &[f64]) -> (Vec<f64>, Vec<Vec<f64>>) {
        let u = self.scaled(q);
        let slope = |n: &Network| {
            let mut slope = vec![0.0; u.len()];
            let value = n.value_and_slope(&u, &mut slope);
            slope.iter_mut().zip(&self.inputs).for_each(|(s, i)| *s *= i.gain());
            (value, slope)
        };
        self.networks.iter().map(slope).unzip()
    }
}
