//! The columns of one joint of one log: what drives it, and what is measured after its motor.

use super::flanks::{Flanks, Pair, fit};
use super::reach::reach;
use super::strokes::Strokes;
use super::{Output, OutputPositions, Series, TrainGap, notes, off_scale, same_scale};
use crate::error::{Error, Place, Result};
use crate::gaps::note::screw::{Remark, Sensor, Short, Unseen};
use crate::log::Log;
use crate::robot::{Joint, JointKind, Robot};

/// One joint's columns, rad or m; borrowed from its log.
pub(super) struct Columns<'a> {
    log: &'a Log,
    joint: &'a Joint,
    pub(super) strokes: Strokes,
    pub(super) command: Vec<Option<f64>>,
    encoder: Option<&'a [Option<f64>]>,
    pub(super) screw: Option<&'a [Option<f64>]>,
    /// The carriage, and what measures it.
    pub(super) output: Option<(&'a [Option<f64>], Output)>,
}

impl<'a> Columns<'a> {
    /// `None` where nothing after the motor is measured.
    pub(super) fn of(
        robot: &'a Robot,
        log: &'a Log,
        axis: usize,
        tracked: &'a OutputPositions,
        remarks: &mut Vec<Remark>,
    ) -> Option<Self> {
        let joint = robot.axis(axis);
        let output = match (&log.meas[axis], tracked) {
            (Some(meas), _) => Some((meas.as_slice(), Output::Sensor)),
            (None, Ok(seen)) => Some((seen.as_slice(), Output::Tracker)),
            (None, Err(why)) => {
                if *why != Unseen::NoCoordinates {
                    remarks.push(Remark::TrackerNotUsed(why.clone()));
                }
                None
            }
        };
        let (screw, encoder) = (log.screw[axis].as_deref(), log.enc[axis].as_deref());
        if screw.is_none() && output.is_none() {
            return None;
        }
        let command = log.cmd[axis].iter().map(|c| Some(*c)).collect();
        Some(Self { log, joint, strokes: Strokes::of(log, robot, axis), command, encoder, screw, output })
    }

    /// What drives the joint: the encoder, else the command.
    pub(super) fn input(&self) -> &[Option<f64>] {
        self.encoder.unwrap_or(&self.command)
    }

    pub(super) fn has_encoder(&self) -> bool {
        self.encoder.is_some()
    }

    /// Refuses an encoder of another scale than its joint.
    pub(super) fn check_encoder(&self) -> Result<()> {
        match self.encoder {
            Some(encoder) => same_scale(self.log, self.joint, "enc", &self.command, encoder, &self.strokes),
            None => Ok(()),
        }
    }

    /// From which way into a stroke on every gap before a sensor is surely closed. `None`, with a note, where strokes are too
    /// short.
    pub(super) fn reach(
        &self,
        what: Sensor,
        sensor: &[Option<f64>],
        series: &mut Series,
        remarks: &mut Vec<Remark>,
    ) -> Result<Option<f64>> {
        let kind = self.joint.kind;
        let why = match reach(&self.command, sensor, &self.strokes, kind == JointKind::Revolute) {
            Ok(way) => return Ok(Some(way)),
            Err(why) => why,
        };
        if let Short::Slope(m) = why {
            let found = format!("{what} of {} moves by {m:.5} per command", self.joint.name);
            return Err(Error::bad(Place::file(&self.log.name), found, notes::SCALE));
        }
        remarks.push(Remark::NotReached { sensor: what, kind, why });
        if let Short::NeverCrossed { way } = why {
            series.at_least = Some(series.at_least.map_or(way, |w: f64| w.max(way)));
        }
        Ok(None)
    }

    /// The flanks of the gap between two columns.
    fn gap(
        &self,
        gap: TrainGap,
        [input, output]: [&[Option<f64>]; 2],
        from: f64,
        with_lag: bool,
        remarks: &mut Vec<Remark>,
    ) -> Option<Flanks> {
        match fit(&Pair { t_s: &self.log.t_s, input, output, strokes: &self.strokes, from, with_lag }) {
            Ok(found) => {
                remarks.extend(notes::flanks(&found, gap, self.joint.kind));
                Some(found)
            }
            Err(why) => {
                remarks.push(Remark::NoGap { gap, why });
                None
            }
        }
    }

    /// The gap of the coupling, between motor and screw.
    pub(super) fn coupling(
        &self,
        screw: &[Option<f64>],
        from: f64,
        remarks: &mut Vec<Remark>,
    ) -> Result<Option<Flanks>> {
        let found = self.gap(TrainGap::Coupling, [self.input(), screw], from, !self.has_encoder(), remarks);
        if found.as_ref().is_some_and(off_scale) {
            same_scale(self.log, self.joint, "screw", self.input(), screw, &self.strokes)?;
        }
        Ok(found)
    }

    /// The gap between motor and carriage, and of it that of the nut, where a sensor stands between.
    pub(super) fn carriage(
        &self,
        (carriage, kind): (&[Option<f64>], Output),
        from: f64,
        remarks: &mut Vec<Remark>,
    ) -> (Option<Flanks>, Option<Flanks>) {
        let other_clock = kind == Output::Tracker;
        let both =
            self.gap(TrainGap::Both, [self.input(), carriage], from, other_clock || !self.has_encoder(), remarks);
        let nut = self.screw.and_then(|screw| self.gap(TrainGap::Nut, [screw, carriage], from, other_clock, remarks));
        (both, nut)
    }
}
