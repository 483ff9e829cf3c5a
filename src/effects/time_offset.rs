//! `time_offset`: the clocks of tracker and controller differ: the measurement at `t` shows the robot at `t + offset`.
//!
//! Parameter: `offset_s` of either sign, at most 10 s: clocks farther apart are set, not estimated. Action: trigger both from one
//! signal; shift the times of the log.

use super::site::within;
use super::*;

pub static INFO: EffectInfo = EffectInfo {
    name: "time_offset",
    heading: "time offset",
    stage: Stage::Measurement,
    family: Family::Lag,
    acts_on: ActsOn::Log,
    adds: "the measurement shows the robot a moment earlier or later",
    equation: "measured(t) = robot(t + offset)",
    reference: "a shift of the time axis",
    parameters: &[("offset_s", "either sign, within 10 s")],
    confused_with: &["servo_lag"],
    decide_by: "log the encoders; or move one joint at a time, at two speeds",
    action: "trigger tracker and controller from one signal; shift the times of the log",
    undone: "nothing: it is an error of the measurement",
    after_reversal: AfterReversal::Nothing,
    includes: &[],
    imitates: &[],
    needs_motion: false,
    example: ("{effect: time_offset, offset_s: 0.002}", View::TcpOverTime),
    read: |f| Ok(TimeOffset { offset_s: f.any("offset_s")? }.into()),
    typical: |_| vec![("offset_s".into(), 0.01.into())],
    candidates: |survey, list| {
        if survey.motion {
            list.push(Candidate::of_size(survey.robot, Target::Log, 1e-4, |offset_s| TimeOffset { offset_s }));
        }
    },
    further: |_, _| {},
};

/// s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeOffset {
    pub offset_s: f64,
}

impl EffectType for TimeOffset {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn values(&self) -> Vec<f64> {
        vec![self.offset_s]
    }

    fn with(&self, v: &[f64]) -> Effect {
        Self { offset_s: v[0] }.into()
    }

    fn parameters(&self, _site: &Site) -> Vec<Parameter> {
        vec![Parameter::seconds("offset_s", within(10.0), 0.01)]
    }

    fn time_offset_s(&self) -> f64 {
        self.offset_s
    }

    fn idle(&self, _site: &Site, settled_poses: bool) -> Option<&'static str> {
        settled_poses.then_some("settled poses have no time")
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::nothing("it is an error of the measurement")
    }
}
