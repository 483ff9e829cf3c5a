//! One reading a row of a ballbar, a draw wire or a dial, in a log without points.
//!
//! The reading is computed from the predicted TCP by [`Instrument::reading`], and changes with it along [`Instrument::sensitivity`]. What
//! the instrument does not know of itself (centre and length of a ballbar, zero and tilt of a dial) is estimated, as far as the log
//! tells it: a circle says nothing of a centre off its plane, and what it does not say is held.

use crate::error::Result;
use crate::identify::machine::readings::Readings;
use crate::identify::scalar::Setup;
use crate::log::Log;
use crate::machine::measurement::Instrument;
use crate::robot::Robot;
use nalgebra::Vector3;

/// Change of the readings by an own quantity of the instrument, rms beside those before it, below which the log does not tell it; m per m.
const TOLD: f64 = 1e-2;

/// The readings of a log.
#[derive(Debug, Clone)]
pub struct Reading {
    instrument: Instrument,
    /// Readings less a zero that is not known, m.
    values: Vec<Option<f64>>,
    /// Direction in which a movement of the TCP changes the reading most, row by row.
    along: Vec<Vector3<f64>>,
    /// Independent columns of what the instrument does not know, each of mean square 1.
    own: Vec<Vec<f64>>,
}

impl Reading {
    /// Of a log without points; `None` where it has no such readings either.
    ///
    /// # Errors
    /// As [`Readings::of_log`]: a dial without its direction, readings that cannot be in their unit, settled poses.
    pub fn of(robot: &Robot, log: &Log) -> Result<Option<Self>> {
        if !log.tcp_m.is_empty() || !log.instruments.has_scalar() {
            return Ok(None);
        }
        let Some(read) = Readings::of_log(robot, log, &Setup::of(log), None)?.into_iter().next() else {
            return Ok(None);
        };
        let instrument = read.instrument;
        let nominal: Vec<Vector3<f64>> = (0..log.len()).map(|row| robot.tcp_m(&log.command(row))).collect();
        let values = nominal.iter().enumerate().map(|(row, p)| {
            let off = read.deviation(row, p)?;
            Some(off.x + instrument.reading(p)?)
        });
        let along = |p: &Vector3<f64>| Vector3::from_fn(|k, _| instrument.sensitivity(p, &Vector3::ith(k, 1.0))[0]);
        Ok(Some(Self {
            instrument,
            values: values.collect(),
            along: nominal.iter().map(along).collect(),
            own: determined_directions(&instrument, &nominal),
        }))
    }

    /// Whether a row has a reading.
    pub fn is_there(&self, row: usize) -> bool {
        self.values[row].is_some()
    }

    /// Number of own quantities that are estimated.
    pub fn unknowns(&self) -> usize {
        self.own.len()
    }

    /// How the reading of a row changes with an own quantity.
    pub fn own(&self, k: usize, row: usize) -> f64 {
        self.own[k][row]
    }

    /// What a small movement of the TCP changes in the reading of a row.
    pub fn seen(&self, row: usize, movement: &Vector3<f64>) -> f64 {
        self.along[row].dot(movement)
    }

    /// Reading of a row less that of the TCP at `point` with these own quantities, m.
    pub fn residual(&self, row: usize, point: &Vector3<f64>, unknowns: &[f64]) -> f64 {
        let own: f64 = self.own.iter().zip(unknowns).map(|(column, u)| column[row] * u).sum();
        self.values[row].zip(self.instrument.reading(point)).map_or(0.0, |(read, computed)| read - computed - own)
    }

    /// The instrument, its centre as estimated from the log alone.
    pub fn instrument(&self) -> &Instrument {
        &self.instrument
    }
}

/// The instrument's own columns that are independent of those before them; the length or zero comes first.
fn determined_directions(instrument: &Instrument, nominal: &[Vector3<f64>]) -> Vec<Vec<f64>> {
    let n = nominal.len().max(1) as f64;
    let middle = match instrument {
        Instrument::Direction { .. } => nominal.iter().sum::<Vector3<f64>>() / n,
        _ => Vector3::zeros(),
    };
    let rows: Vec<Vec<f64>> =
        nominal.iter().map(|p| instrument.nuisances(&(p - middle)).iter().map(|v| v[0]).collect()).collect();
    let count = rows.first().map_or(0, Vec::len);
    let constant = match instrument {
        Instrument::Distance { .. } => count.saturating_sub(1),
        _ => 0,
    };
    let order = std::iter::once(constant).chain((0..count).filter(|k| *k != constant)).take(count);
    let mut out: Vec<Vec<f64>> = Vec::new();
    for k in order {
        let mut column: Vec<f64> = rows.iter().map(|r| r[k]).collect();
        for before in &out {
            let share = before.iter().zip(&column).map(|(a, b)| a * b).sum::<f64>() / n;
            column.iter_mut().zip(before).for_each(|(c, b)| *c -= share * b);
        }
        let rms = (column.iter().map(|v| v * v).sum::<f64>() / n).sqrt();
        if rms > TOLD {
            column.iter_mut().for_each(|v| *v /= rms);
            out.push(column);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_planar_circle_does_not_tell_the_centre_of_its_ballbar_across_the_plane() {
        let centre_m = Vector3::new(1.0, 0.2, 0.8);
        let circle: Vec<Vector3<f64>> = (0..200)
            .map(|i| {
                let a = f64::from(i) * 0.05;
                centre_m + 0.3 * Vector3::new(a.cos(), 0.0, a.sin())
            })
            .collect();
        let own = determined_directions(&Instrument::Distance { centre_m }, &circle);
        assert_eq!(own.len(), 3, "length, and the centre in the plane");
        let wave = |p: &Vector3<f64>| 2.0 * (p - centre_m).x * (p - centre_m).z;
        let lifted: Vec<Vector3<f64>> = circle.iter().map(|p| p + Vector3::new(0.0, wave(p), 0.0)).collect();
        assert_eq!(determined_directions(&Instrument::Distance { centre_m }, &lifted).len(), 4);
    }
}
