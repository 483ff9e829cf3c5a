//! `time_offset`: the clocks of tracker and controller differ: the measurement at `t` shows the robot at `t + offset`, or, where
//! they run at different rates, at `t + offset + drift t`, with `t` from the first row of the log.
//!
//! Parameters: `offset_s` of either sign, at most 10 s: clocks farther apart are set, not estimated; `drift_ppm` of either sign, at
//! most 1000 (quartz: 1 to 50). One of them may be left out. Action: trigger both from one signal; shift the times of the log.

use super::common::*;
use super::site::within;

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "time_offset",
    heading: "time offset",
    stage: Stage::Measurement,
    family: Family::Lag,
    acts_on: ActsOn::Log,
    adds: "the measurement shows the robot at a slightly earlier or later time",
    equation: "measured(t) = robot(t + offset + drift t), t from the first row of the log",
    reference: "a shift of the time axis; rates: Allan (1987), IEEE Trans. Ultrasonics, Ferroelectrics, and Frequency Control 34(6)",
    parameters: &[
        ("offset_s", "either sign, within 10 s; may be left out if drift_ppm is given"),
        ("drift_ppm", "how much faster the clock of the commands runs, either sign, within 1000 ppm; may be left out"),
    ],
    confused_with: &["servo_lag"],
    decide_by: "log the encoders; or move one joint at a time, at two speeds",
    action: "trigger tracker and controller by one signal; or shift the times of the log",
    undone: "nothing: it is an error of the measurement",
    special: Special {
        further: |survey, list| {
            if survey.motion {
                let make = |drift| TimeOffset { offset_s: None, drift: Some(drift) };
                list.push(Candidate::of_size(survey.robot, Target::Log, PPM, make).with_form("drift"));
            }
        },
        ..Special::NONE
    },
    example: ("{effect: time_offset, offset_s: 0.002}", View::TcpOverTime),
    read: |f| {
        let drift = f.number(DRIFT, f64::NEG_INFINITY)?.map(|ppm| ppm * PPM);
        let offset_s = match drift {
            Some(_) => f.number("offset_s", f64::NEG_INFINITY)?,
            None => Some(f.any("offset_s")?),
        };
        Ok(TimeOffset { offset_s, drift }.into())
    },
    typical: |_| vec![("offset_s".into(), 0.01.into())],
    candidates: |survey, list| {
        if survey.motion {
            list.push(Candidate::of_size(survey.robot, Target::Log, 1e-4, TimeOffset::by));
        }
    },
};

const DRIFT: &str = "drift_ppm";
const PPM: f64 = 1e-6;
/// Largest difference of the rates of two clocks.
const MOST_DRIFT: f64 = 1e-3;

/// Offset in s, and how much faster the clock of the commands runs; `None`: not a part of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeOffset {
    /// Offset of the clocks, s; `None`: not a part of the effect.
    pub offset_s: Option<f64>,
    /// By how much the clock of the commands runs faster; `None`: not a part of the effect.
    pub drift: Option<f64>,
}

impl TimeOffset {
    /// An offset alone.
    pub fn by(offset_s: f64) -> Self {
        Self { offset_s: Some(offset_s), drift: None }
    }
}

impl EffectType for TimeOffset {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn nature(&self) -> Nature {
        Nature::Clock
    }

    fn values(&self) -> Vec<f64> {
        self.offset_s.into_iter().chain(self.drift).collect()
    }

    fn with(&self, v: &[f64]) -> Effect {
        let mut values = v.iter().copied();
        let mut next = |old: Option<f64>| old.and_then(|old| values.next().or(Some(old)));
        Self { offset_s: next(self.offset_s), drift: next(self.drift) }.into()
    }

    fn parameters(&self, _site: &Site) -> Vec<Parameter> {
        let offset = self.offset_s.map(|_| Parameter::seconds("offset_s", within(10.0), 0.01));
        let drift = self.drift.map(|_| Parameter::new(DRIFT, 1.0 / PPM, within(MOST_DRIFT), 5.0 * PPM));
        offset.into_iter().chain(drift).collect()
    }

    fn clock(&self) -> Clock {
        Clock { offset_s: self.offset_s.unwrap_or(0.0), drift: self.drift.unwrap_or(0.0) }
    }

    fn idle(&self, _site: &Site, settled_poses: bool) -> Option<&'static str> {
        in_settled_poses(settled_poses)
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::nothing("it is an error of the measurement")
    }
}
