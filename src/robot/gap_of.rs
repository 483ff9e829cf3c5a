//! Joints whose gear turns by a sum of axes: the gap of such a joint belongs to that sum, and so does the direction in which it is
//! crossed.
//!
//! On most FANUC arms a program gives J3 against the horizontal while the motor at the elbow turns by J2 + J3
//! (`gap_of: {J3: J2 + J3}`). The elbow then reverses where that sum does, and a command that must move its gear by an offset moves
//! J3 by the offset less what J2's own offset already does.

pub use super::joint::GapOf;
use super::{Convention, Robot};

/// A method takes joints alone although a gear turns by a sum of axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error(
    "a gap that belongs to a sum of axes (`gap_of`) is treated as a gap of its joint alone: where another axis of the sum moves, its gear \
     moves too, and part of its gap is counted as the gap of that axis"
)]
pub struct JointsAlone;

impl Robot {
    /// What a method that takes joints alone notes where a gear turns by a sum of axes.
    pub(crate) fn by_joints_alone(&self) -> Option<JointsAlone> {
        self.has_sums().then_some(JointsAlone)
    }

    /// Whether any gear turns by a sum of axes.
    pub fn has_sums(&self) -> bool {
        self.gap_of.iter().any(|g| !g.others.is_empty())
    }

    /// From the values of the axes, rad or m, to what their gears turn by.
    pub fn to_gears(&self, q: &mut [f64]) {
        self.sums(q, 1.0);
    }

    /// Back again.
    pub fn from_gears(&self, q: &mut [f64]) {
        self.sums(q, -1.0);
    }

    /// The same arm with a command for each gear instead of one for each axis; `None`: no gear turns by a sum, or the joints do not
    /// allow it. A joint that turns about the line of the gear and follows the other axis of the sum takes up what the sum holds of that
    /// axis, as on the arms whose pendant shows the forearm against the horizontal.
    pub fn of_gears(&self) -> Option<Self> {
        let mut joints = self.joints.clone();
        for gear in &self.gap_of {
            let own = self.axis_index(gear.axis);
            if !gear.others.is_empty() {
                joints[own].limits = None; // they are those of the axis
            }
            for &(axis, c) in &gear.others {
                let driver = self.axis_index(axis);
                let direction = joints[own].direction;
                let follower = joints.get_mut(own.checked_sub(1)?)?;
                let on_line =
                    [follower.d_m, follower.a_m, follower.alpha_rad, follower.beta_rad].iter().all(|v| *v == 0.0);
                let follows = follower.follows.as_mut().filter(|f| f.joint == driver && on_line)?;
                follows.ratio -= c * direction * follower.direction;
            }
        }
        let known = self.has_sums() && self.convention == Convention::Standard;
        let mut robot = known.then(|| self.with_geometry(joints, self.tool))?;
        robot.gap_of.clear();
        Some(robot)
    }

    /// No axis of a sum has its own sum, so that the order does not matter.
    fn sums(&self, q: &mut [f64], sign: f64) {
        for gear in &self.gap_of {
            let sum: f64 = gear.others.iter().filter_map(|&(k, c)| Some(c * q.get(k)?)).sum();
            if let Some(own) = q.get_mut(gear.axis) {
                *own += sign * sum;
            }
        }
    }

    /// `J2 + J3` of the axis J3.
    pub fn sum_text(&self, gear: &GapOf) -> String {
        let name = |axis: usize| self.axis(axis).name.as_str();
        let mut text = String::new();
        for &(axis, c) in &gear.others {
            text.push_str(match (text.is_empty(), c < 0.0) {
                (true, false) => "",
                (true, true) => "-",
                (false, false) => " + ",
                (false, true) => " - ",
            });
            text.push_str(name(axis));
        }
        if !text.is_empty() {
            text.push_str(" + ");
        }
        text + name(gear.axis)
    }
}

/// What is wrong with a sum; the words stand after "found".
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(super) enum Misread {
    #[error("`{0}`, no axis of the robot")]
    NoAxis(String),
    #[error("`{0}` without + or - before it")]
    NoSign(String),
    #[error("{0}, a joint of another kind")]
    OtherKind(String),
    /// The axis itself, taken off.
    #[error("-{0}")]
    Negative(String),
    #[error("a second {0}")]
    Twice(String),
    /// A sum without the axis itself, or with a sign at its end.
    #[error("`{0}`")]
    Incomplete(String),
}

/// Reads `J2 + J3` as the sum of the axis `axis`.
///
/// # Errors
/// What is wrong with it.
pub(super) fn read(robot: &Robot, axis: usize, text: &str) -> Result<GapOf, Misread> {
    let mut others = Vec::new();
    let mut own = false;
    let mut sign = 1.0;
    let spaced = text.replace('+', " + ").replace('-', " - ");
    let mut open = true;
    for word in spaced.split_whitespace() {
        match word {
            "+" => open = true,
            "-" => (open, sign) = (true, -sign),
            name => {
                let k = robot.axis_named(name).ok_or_else(|| Misread::NoAxis(name.into()))?;
                if !open {
                    return Err(Misread::NoSign(name.into()));
                }
                if robot.axis(k).kind != robot.axis(axis).kind {
                    return Err(Misread::OtherKind(name.into()));
                }
                match (k == axis, sign > 0.0) {
                    (true, true) if !own => own = true,
                    (false, _) if others.iter().all(|o: &(usize, f64)| o.0 != k) => others.push((k, sign)),
                    (true, false) => return Err(Misread::Negative(name.into())),
                    _ => return Err(Misread::Twice(name.into())),
                }
                (open, sign) = (false, 1.0);
            }
        }
    }
    if own && !open { Ok(GapOf { axis, others }) } else { Err(Misread::Incomplete(text.into())) }
}
