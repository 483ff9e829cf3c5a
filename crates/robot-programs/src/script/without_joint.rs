//! Numbers of a controller's list of six for which the robot file has no joint: it describes some joints of an arm only, or the arm has
//! fewer than six.
//!
//! A new point on the way of a move is a copy of its target with other values of the robot's joints. Where one of the other numbers
//! changes on this way, or may change, the copy would bring its axis to the end at once, so no point is added there. Palletizers with four
//! axes, which are 1, 2, 3 and 6, hold 0 in the other two: nothing moves there on the way to a pose either.
//!
//! A loop or a call between two targets makes unknown what stood before, unless all targets of the program have the same numbers.

use super::{Goal, OtherWay, PathKind, Reason, Step, StepKind};
use crate::axes::{Axes, OF_ARM};
use std::collections::BTreeMap;

/// The numbers without a joint, the others 0; `None`: not known.
type Rest = Option<[f64; OF_ARM]>;

/// What the targets of a program give for numbers without a joint.
#[derive(Debug, Clone)]
pub struct WithoutJoint {
    /// Numbers with a joint.
    own: [bool; OF_ARM],
    /// The rest where a target does not give it.
    of_poses: Rest,
    by_target: BTreeMap<usize, Rest>,
}

impl WithoutJoint {
    /// Of a robot; `None`: every number has a joint, or which one it has is not certain, so that no target is read.
    pub fn of(robot: &Axes) -> Option<Self> {
        let places = robot.places();
        let own = places.own_numbers();
        let some = places.certain && places.numbered && own.contains(&false);
        let of_poses = places.keeps_upright().then_some([0.0; OF_ARM]);
        some.then_some(Self { own, of_poses, by_target: BTreeMap::new() })
    }

    /// Keeps the numbers of a joint target, all in order as they are written; `None`: one that is computed.
    pub fn keep(&mut self, target: usize, numbers: impl IntoIterator<Item = Option<f64>>) {
        let mut numbers = numbers.into_iter();
        let mut rest = Some([0.0; OF_ARM]);
        for (k, own) in self.own.iter().enumerate() {
            let number = numbers.next().flatten();
            rest = match (rest, own, number) {
                (rest, true, _) => rest,
                (Some(mut rest), false, Some(v)) => {
                    rest[k] = v;
                    Some(rest)
                }
                _ => None,
            };
        }
        self.by_target.insert(target, rest);
    }

    fn rest(&self, goal: &Goal) -> Rest {
        match goal {
            Goal::Joints(target) => self.by_target.get(target).copied().flatten(),
            Goal::Pose(_) | Goal::Opaque(_) => self.of_poses,
        }
    }

    /// Closes the moves on whose ways such a number changes, or may change.
    pub fn close(&self, steps: &mut [Step]) {
        let mut before: Rest = None;
        let mut all = steps.iter().filter_map(|s| match &s.kind {
            StepKind::Move(m) => Some(self.rest(&m.goal)),
            _ => None,
        });
        let first = all.next().flatten();
        if first.is_some() && all.all(|rest| rest == first) {
            return;
        }
        for step in steps {
            match &mut step.kind {
                StepKind::Move(m) => {
                    let here = self.rest(&m.goal);
                    if here.is_none() || here != before {
                        m.closed.get_or_insert(Reason::OtherNumbers);
                        if m.path != PathKind::Joint {
                            m.other_way.get_or_insert(OtherWay::Carried);
                        }
                    }
                    before = here;
                }
                StepKind::Break(_) => before = None,
                _ => {}
            }
        }
    }
}
