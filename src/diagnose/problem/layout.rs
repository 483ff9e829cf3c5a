//! The observations of all logs as one long vector, and the way from rows of a log into it.
//!
//! A [`Group`] is what one sensor of one log measured: a reflector or the orientation of the tool (three coordinates), a joint, or a
//! reading of the TCP (one). Its values stand one coordinate after the other. Rows without a measurement are left out. Long logs are
//! averaged over blocks of consecutive rows: a linear map, applied alike to what was measured and to every sensitivity, so that nothing but
//! time resolution is lost.

use crate::diagnose::problem::orientation;
use nalgebra::Vector3;

/// What a group of observations measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sensor {
    /// Coordinates of a reflector of the tool in the base frame; 0 is the TCP.
    Reflector(usize),
    /// Motor side of an axis.
    Motor(usize),
    /// An axis after its gear.
    Joint(usize),
    /// One reading of the TCP: a ballbar, a dial.
    Reading,
    /// Orientation of the tool, as turns about the axes of the base, rad.
    Orientation,
}

impl Sensor {
    /// The point of the tool that it measures, whole or in part; 0 is the TCP.
    pub fn point(self) -> Option<usize> {
        match self {
            Self::Reflector(k) => Some(k),
            Self::Reading => Some(0),
            Self::Motor(_) | Self::Joint(_) | Self::Orientation => None,
        }
    }

    /// Whether it shows something of a movement of a point of the tool.
    pub fn sees(self, point: usize) -> bool {
        self.point() == Some(point) || self == Self::Orientation && orientation::POINTS.contains(&point)
    }

    /// The place of its samples among those that are left out; `None` of joint sensors, whose samples are all kept.
    pub fn left_out_as(self) -> Option<usize> {
        if self == Self::Orientation { Some(orientation::POINTS.start) } else { self.point() }
    }

    /// Whether its readings are metres at a point of the tool.
    pub fn is_length(self) -> bool {
        self.point().is_some()
    }
}

/// Observations of one sensor in one log.
#[derive(Debug, Clone)]
pub struct Group {
    pub log: usize,
    pub sensor: Sensor,
    /// Rows with a measurement, in order.
    pub rows: Vec<u32>,
    /// Where each block starts in `rows`; one more than there are blocks.
    starts: Vec<u32>,
    /// Samples (blocks) since the block before; 1 where none is missing.
    pub steps: Vec<f64>,
    /// Place of the first value in the long vector.
    pub offset: usize,
    /// Coordinates: 3 or 1.
    pub dims: usize,
}

impl Group {
    /// Groups `rows` (rising) into blocks of `block` consecutive rows of the log. `poses`: rows do not follow in time.
    pub fn new(log: usize, sensor: Sensor, rows: Vec<u32>, block: usize, offset: usize, poses: bool) -> Self {
        let (mut starts, mut steps) = (Vec::new(), Vec::new());
        let mut last: Option<u32> = None;
        for (k, &row) in rows.iter().enumerate() {
            let b = row / block as u32;
            if last != Some(b) {
                let step = last.map_or(0.0, |l| f64::from(b - l));
                steps.push(if poses { f64::INFINITY } else { step });
                starts.push(k as u32);
                last = Some(b);
            }
        }
        starts.push(rows.len() as u32);
        let dims = if matches!(sensor, Sensor::Reflector(_) | Sensor::Orientation) { 3 } else { 1 };
        Self { log, sensor, rows, starts, steps, offset, dims }
    }

    /// Number of blocks.
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// Values in the long vector.
    pub fn range(&self) -> std::ops::Range<usize> {
        self.offset..self.offset + self.dims * self.len()
    }

    /// Rows of one block.
    pub fn block(&self, b: usize) -> &[u32] {
        &self.rows[self.starts[b] as usize..self.starts[b + 1] as usize]
    }

    /// Row in the middle of a block.
    pub fn middle(&self, b: usize) -> usize {
        let rows = self.block(b);
        rows[rows.len() / 2] as usize
    }

    /// Adds the block means of a point-valued function of the row to `out`, the long vector.
    pub fn add_points(&self, out: &mut [f64], value: impl Fn(usize) -> Vector3<f64>) {
        let n = self.len();
        let (x, rest) = out[self.range()].split_at_mut(n);
        let (y, z) = rest.split_at_mut(n);
        for b in 0..n {
            let rows = self.block(b);
            let mut sum = Vector3::zeros();
            for &r in rows {
                sum += value(r as usize);
            }
            sum /= rows.len() as f64;
            x[b] += sum.x;
            y[b] += sum.y;
            z[b] += sum.z;
        }
    }

    /// Adds the block means of a number per row to `out`, the long vector.
    pub fn add_numbers(&self, out: &mut [f64], value: impl Fn(usize) -> f64) {
        for (b, o) in out[self.range()].iter_mut().enumerate() {
            let rows = self.block(b);
            *o += rows.iter().map(|&r| value(r as usize)).sum::<f64>() / rows.len() as f64;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_means_of_the_rows_that_are_there() {
        let g = Group::new(0, Sensor::Joint(0), vec![0, 1, 2, 5, 9], 3, 1, false);
        assert_eq!(g.steps, [0.0, 1.0, 2.0]);
        let mut out = vec![0.0; 5];
        g.add_numbers(&mut out, |r| r as f64);
        assert_eq!(out, [0.0, 1.0, 5.0, 9.0, 0.0]);
    }
}
