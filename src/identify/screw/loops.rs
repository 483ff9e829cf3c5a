//! Deviation over position, measured and by the identified plays: the pictures of Gantry (2015)'s Figures 6 and 9.
//!
//! The plays are the catalogue's ([`crate::effects::Backlash`]) on the command; deviations are output minus slope times input, about
//! the middle of the two flanks.

use super::flanks::Flanks;
use crate::effects::{Backlash, EffectType, Track};
use crate::log::Log;

/// Rows that a picture holds, about.
const SHOWN: usize = 6000;

/// Measured and identified deviation; rad or m.
#[derive(Debug, Clone)]
pub struct Loop {
    /// `coupling`, `nut` or `total`.
    pub gap: &'static str,
    pub command: Vec<f64>,
    pub measured: Vec<f64>,
    pub model: Vec<f64>,
}

/// Replaces a signal along the motion of an axis by the output of a play with these gaps.
fn apply_play(log: &Log, axis: usize, signal: &mut [f64], flanks: Option<&Flanks>) {
    let Some(flanks) = flanks else { return };
    let track = Track::new(&log.t_s, &log.cmd[axis], 0.0);
    Backlash::constant(0.5 * flanks.total.value.max(0.0)).apply(&track, signal);
}

/// Motion of the carriage for the commands, about the middle of its gaps.
pub fn carriage(log: &Log, axis: usize, both: &Flanks) -> Vec<f64> {
    let mut signal = log.cmd[axis].clone();
    apply_play(log, axis, &mut signal, Some(both));
    signal.iter().map(|v| v * both.slope.value).collect()
}

/// The loops of a joint: of coupling, nut and both.
pub fn of(
    log: &Log,
    axis: usize,
    input: &[Option<f64>],
    screw: Option<&[Option<f64>]>,
    output: Option<&[Option<f64>]>,
    [coupling, nut, both]: [&Option<Flanks>; 3],
) -> Vec<Loop> {
    let command = &log.cmd[axis];
    let mut middle = command.clone();
    apply_play(log, axis, &mut middle, coupling.as_ref());
    let one =
        |gap, first: &[f64], from: Option<&[Option<f64>]>, to: Option<&[Option<f64>]>, flanks: &Option<Flanks>| {
            let (flanks, from, to) = (flanks.as_ref()?, from?, to?);
            let mut last = first.to_vec();
            apply_play(log, axis, &mut last, Some(flanks));
            let m = flanks.slope.value;
            let mut found = Loop { gap, command: Vec::new(), measured: Vec::new(), model: Vec::new() };
            for i in (0..log.len()).step_by(log.len().div_ceil(SHOWN).max(1)) {
                if let (Some(u), Some(w)) = (from[i], to[i]) {
                    found.command.push(command[i]);
                    found.measured.push(w - m * (u - flanks.middle.value));
                    found.model.push(m * (last[i] - first[i]));
                }
            }
            Some(found)
        };
    [
        one("coupling", command, Some(input), screw, coupling),
        one("nut", &middle, screw, output, nut),
        one("total", command, Some(input), output, both),
    ]
    .into_iter()
    .flatten()
    .collect()
}
