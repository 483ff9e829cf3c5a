//! One joint's gaps in series, and what they were measured with.

use super::flanks::Flanks;
use super::loops::Loop;
use super::start::Start;
pub use crate::gaps::note::screw::TrainGap;
use crate::gaps::note::screw::Unseen;

/// What a sensor says row by row (rad or m), or why there is nothing.
pub type OutputPositions = std::result::Result<Vec<Option<f64>>, Unseen>;

/// What is measured on the output side.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Output {
    /// `meas_<joint>`.
    Sensor,
    /// The tracker's coordinates.
    Tracker,
}

/// One joint's gaps; rad or m.
#[derive(Debug, Clone)]
pub struct Series {
    /// Number of the axis, from 0.
    pub axis: usize,
    /// Number of the log.
    pub log: usize,
    /// The input is the encoder, else the command.
    pub encoder: bool,
    /// What the driven side was measured with.
    pub output: Option<Output>,
    /// Play between motor and screw.
    pub coupling: Option<Flanks>,
    /// Play between screw and nut.
    pub nut: Option<Flanks>,
    /// Play of the whole train, from motor to slide.
    pub both: Option<Flanks>,
    /// On which flank the log starts.
    pub start: Start,
    /// Where the gaps were not crossed: the least that the total can be.
    pub at_least: Option<f64>,
    /// Loops of output over input, for pictures.
    pub loops: Vec<Loop>,
}

impl Series {
    /// The gaps that were found, along the train.
    pub fn found(&self) -> impl Iterator<Item = (TrainGap, &Flanks)> {
        let all = [(TrainGap::Coupling, &self.coupling), (TrainGap::Nut, &self.nut), (TrainGap::Both, &self.both)];
        all.into_iter().filter_map(|(gap, flanks)| Some((gap, flanks.as_ref()?)))
    }

    /// `c_l` and `c_r` mean something: the columns have one zero, as far as can be determined, and it is known to less than the gap.
    pub fn shares_zero(&self, gap: TrainGap, flanks: &Flanks) -> bool {
        let tracked = gap != TrainGap::Coupling && self.output == Some(Output::Tracker);
        let unsure = flanks.middle.ci95[1] - flanks.middle.value;
        let about = flanks.middle.value.abs() <= 0.5 * flanks.total.value + unsure;
        !tracked && about && unsure <= flanks.total.value && !self.leans_on_slope(flanks)
    }

    /// Without an encoder the slope of the flanks holds what is left of a lag, too: where it makes much of the gap on the way from the
    /// strokes to the zero, the offsets to that zero are those of the slope.
    pub fn leans_on_slope(&self, flanks: &Flanks) -> bool {
        const MUCH: f64 = 0.25;
        !self.encoder && ((flanks.slope.value - 1.0) * flanks.centre).abs() > MUCH * flanks.total.value
    }
}
