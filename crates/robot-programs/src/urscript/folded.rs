//! Targets that are computed from constants: a move to one gets the list of numbers itself where it is edited, so that nothing else that
//! reads a name in it changes.

use super::constant::{Constant, isometry};
use super::read::Span;
use super::steps::{Builder, Folded, Literal};
use super::value;
use crate::script::number::{Style, last_digit};
use crate::script::sites::Number;
use crate::script::{At, Goal, PoseForm, PoseGoal, Target, Value};

/// Decimals that an edited number has at least.
const DECIMALS: u8 = 6;
/// Decimals of a number that stays, m or rad: what reading it again may differ by is far below them.
const EXACT: usize = 12;

/// No robot goes there, m or rad, and its decimals would not be read again as they stand.
const LARGEST: f64 = 1e6;

impl Builder<'_> {
    /// The value of an expression of the item at hand, if it can be put in its place: no comment may go with it.
    fn folded(&self, span: &Span) -> Option<Constant> {
        let value = self.values.value(span, self.place)?;
        let numbers = if let Constant::Pose(pose) = &value { Some(pose.to_vec()) } else { value.clone().list() };
        if numbers.is_some_and(|all| all.iter().any(|v| v.abs() > LARGEST)) {
            return None;
        }
        (!self.text.slice(self.bytes(span)).contains(&b'\n')).then_some(value)
    }

    /// The pose that an expression is.
    pub fn folded_pose(&self, span: &Span) -> Option<[f64; 6]> {
        if let Some(Constant::Pose(pose)) = self.folded(span) { Some(pose) } else { None }
    }

    /// The goal that an expression is.
    pub fn folded_goal(&mut self, span: &Span) -> Option<Goal> {
        match self.folded(span)? {
            Constant::Pose(numbers) => Some(self.folded_place(span, numbers)),
            list => {
                let numbers = list.list()?;
                let axes = value::numbers(self.robot)?;
                let least = axes.iter().copied().max().unwrap_or_default().max(self.robot.dof());
                let places: Option<Vec<usize>> = axes.iter().map(|n| n.checked_sub(1)).collect();
                let places = places.filter(|_| numbers.len() >= least)?;
                let all = numbers.clone();
                let target = self.push_folded(span, numbers, places, None);
                if let Some(without) = &mut self.without_joint {
                    without.keep(target, all.into_iter().map(Some));
                }
                Some(Goal::Joints(target))
            }
        }
    }

    /// The goal that an expression is if it is a pose.
    pub fn folded_pose_goal(&mut self, span: &Span) -> Option<Goal> {
        self.folded_pose(span).map(|pose| self.folded_place(span, pose))
    }

    fn folded_place(&mut self, span: &Span, numbers: [f64; 6]) -> Goal {
        let target = self.push_folded(span, numbers.to_vec(), (0..6).collect(), Some(PoseForm::RotationVector));
        let at = isometry(numbers);
        self.inner = Some(span.clone());
        Goal::pose(PoseGoal {
            target: Some(target),
            position_m: at.translation.vector,
            rotation: Some(at.rotation),
            frame: crate::script::Frame::Base,
            tool: self.tcp(),
            ..PoseGoal::default()
        })
    }

    fn push_folded(&mut self, span: &Span, numbers: Vec<f64>, places: Vec<usize>, pose: Option<PoseForm>) -> usize {
        let bytes = self.bytes(span);
        // what is written of a number that stays is the very number that was read
        let numbers: Vec<f64> = numbers.into_iter().map(|v| exact(v).parse().unwrap_or(v)).collect();
        let style = Style { decimals: DECIMALS, point: true, ..Style::default() };
        let value = |k: &usize| {
            let si = numbers.get(*k).copied()?;
            let (start, end) = (bytes.start, bytes.end);
            Some(Value { si, start, end, style, digit: last_digit(DECIMALS), finest: value::FINEST })
        };
        let values: Vec<Option<Value>> = places.iter().map(value).collect();
        let units = self.units(&vec![1.0; values.len()]);
        let at = At { file: 0, line: self.line(span.start) };
        self.targets.push(Target { name: None, at, values, pose });
        let folded = Some(Box::new(Folded { pose: pose.is_some(), numbers, places }));
        self.literals.push(Literal { bytes: bytes.into(), units, owner: None, folded });
        self.targets.len() - 1
    }
}

impl Folded {
    /// The list with other numbers, by their places in it.
    pub fn with(&self, numbers: &[Number]) -> String {
        let text = |(k, own): (usize, &f64)| {
            let new = numbers.iter().find(|(place, _)| place.start == k);
            new.map_or_else(|| exact(*own), |(_, new)| new.clone())
        };
        let list: Vec<String> = self.numbers.iter().enumerate().map(text).collect();
        format!("{}[{}]", if self.pose { "p" } else { "" }, list.join(", "))
    }
}

/// A number with all digits that count, and none more.
fn exact(value: f64) -> String {
    let text = format!("{value:.EXACT$}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".into() } else { text.into() }
}
