//! What a user may choose about a rewrite.

use super::equation2::Law;
use super::statics::Statics;
use crate::program::script::AxisSet;
use std::collections::BTreeMap;
use std::sync::Arc;

/// How turning points between program points are found and the path near them is refined.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Refine {
    /// The program's own points are the turning points; only the points that carry the step and its decay are inserted.
    #[default]
    None,
    /// Local cubic through the joint samples: the true turning point is inserted. On a coarse program that moves straight
    /// between points, the new point stands out of the polygon by the height of its chords.
    Cubic,
    /// Arcs through the TCP path and inverse kinematics: turning points on the smooth path, and the whole path made dense
    /// enough that its chords stay within [`Options::chord_m`].
    Cartesian,
}

/// Settings of a rewrite; values are SI.
#[derive(Debug, Clone)]
pub struct Options {
    /// Which offsets a reversal gets.
    pub law: Law,
    /// How the path is made finer.
    pub refine: Refine,
    /// Share of the segment after a turning point at which the point stands that carries the step (Zhang (2023): 0.1). It
    /// stands nearer where the joint would lag by more than [`Options::shape_m`] until then, unless `step_exact`.
    pub step_fraction: f64,
    /// The point that carries a step stands at [`Options::step_fraction`] whatever the joint lags until then.
    pub step_exact: bool,
    /// Movement against the direction that is number noise, per axis (rad or m).
    pub deadband: Vec<f64>,
    /// Spread the step over this travel after the turning point, per axis (rad or m); 0: at once.
    pub ramp: Vec<f64>,
    /// The same after single reversals: axis and the program point at which it turns, or after which it does; rad or m.
    pub ramps_after: Arc<BTreeMap<(usize, u64), f64>>,
    /// Axes that get no offsets.
    pub without: AxisSet,
    /// Direction in which each axis was moved before the first point: -1, +1; 0: that of its first movement.
    pub initial_direction: Vec<i8>,
    /// Share of every offset that is applied, 0 to 1.
    pub gain: f64,
    /// TCP speed of a program without times, m/s.
    pub tcp_speed_m_s: Option<f64>,
    /// Of a program without times for every move: the duration of the leg to each point, s, where it is known (else not a number),
    /// for the limits of speed.
    pub legs_s: Option<Arc<[f64]>>,
    /// Largest distance between the path and its chords, m (`Refine::Cartesian`).
    pub chord_m: f64,
    /// Static joint errors that are undone at every point.
    pub statics: Option<Arc<Statics>>,
    /// Axes whose positions count from an unknown origin: their range is not checked.
    pub unplaced: AxisSet,
    /// Largest TCP error that the straight lines between inserted points may add to the wanted offset, m.
    pub shape_m: f64,
}

impl Options {
    /// The defaults for a robot of `axes` axes.
    pub fn new(axes: usize) -> Self {
        Self {
            law: Law::default(),
            refine: Refine::default(),
            step_fraction: 0.1,
            step_exact: false,
            deadband: vec![1e-8; axes],
            ramp: vec![0.0; axes],
            ramps_after: Arc::default(),
            without: AxisSet::default(),
            initial_direction: vec![0; axes],
            gain: 1.0,
            tcp_speed_m_s: None,
            legs_s: None,
            chord_m: 2e-6,
            statics: None,
            unplaced: AxisSet::default(),
            shape_m: 1e-6,
        }
    }
}
