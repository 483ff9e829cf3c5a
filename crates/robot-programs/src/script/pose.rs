//! Cartesian targets: how languages write a pose, which frame and tool its numbers belong to, and which of the joints that reach
//! it are meant.
//!
//! A pose is three lengths and the turn, in one of four forms. All are the same rotation `Rz(c) Ry(b) Rx(a)`, a unit quaternion
//! or axis times angle; coordinates of a changed pose are those nearest to the ones that stand there, so that numbers that need
//! not change do not.
//!
//! References: KUKA System Software, Operating and Programming Instructions for System Integrators (A, B, C; status and turn);
//! ABB, RAPID Instructions, Functions and Data types (`orient`, `confdata`); FANUC operator's manuals (W, P, R; configuration);
//! Yaskawa NX100, Instructions for Relative Job function, section 4.1 (`RCONF`); Universal Robots, The URScript Programming Language (poses).

use super::reason::Reason;
use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};
use std::f64::consts::{PI, TAU};
use std::fmt;

/// How a pose is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PoseForm {
    /// X, Y, Z, and the turns about the fixed X, Y, Z in this order: FANUC (W, P, R), INFORM (Rx, Ry, Rz).
    FixedXyz,
    /// X, Y, Z, and the turns about Z, the new Y, the new X in this order: KRL (A, B, C).
    EulerZyx,
    /// x, y, z and a quaternion, its real part first: RAPID.
    Quaternion,
    /// x, y, z and axis times angle: URScript.
    RotationVector,
}

/// Below this cosine of the middle angle the other two turn about one line.
const LOCKED: f64 = 1e-9;
/// Angles that stand there within half a turn (and the rounding of their digits) stay within it.
const HALF_TURN: f64 = PI + 1e-6;

impl PoseForm {
    /// Numbers of a pose.
    pub fn count(self) -> usize {
        if self == Self::Quaternion { 7 } else { 6 }
    }

    /// Whether number `k` is a length (m), an angle (rad), or neither.
    pub fn quantity(self, k: usize) -> Quantity {
        match self {
            _ if k < 3 => Quantity::Length,
            Self::Quaternion => Quantity::Ratio,
            _ => Quantity::Angle,
        }
    }

    /// SI value of the unit in which number `k` is written.
    pub fn unit(self, k: usize) -> f64 {
        match (self, self.quantity(k)) {
            (Self::RotationVector, _) | (_, Quantity::Ratio) => 1.0,
            (_, Quantity::Length) => 1e-3,
            (_, Quantity::Angle) => PI / 180.0,
        }
    }

    /// The pose of numbers in SI; `None`: too few of them, or a quaternion that is far from a unit one.
    pub fn pose(self, values: &[f64]) -> Option<Isometry3<f64>> {
        let [x, y, z, ref turn @ ..] = *values else { return None };
        let rotation = match (self, turn) {
            (Self::FixedXyz, [a, b, c]) | (Self::EulerZyx, [c, b, a]) => UnitQuaternion::from_euler_angles(*a, *b, *c),
            (Self::Quaternion, [w, x, y, z]) => {
                let q = Quaternion::new(*w, *x, *y, *z);
                UnitQuaternion::try_new(q, 0.1).filter(|q| q.coords.iter().all(|c| c.is_finite()))?
            }
            (Self::RotationVector, [x, y, z]) => UnitQuaternion::from_scaled_axis(Vector3::new(*x, *y, *z)),
            _ => return None,
        };
        Some(Isometry3::from_parts(Translation3::new(x, y, z), rotation))
    }

    /// The numbers of a pose, in SI, nearest to `near` among those that mean the same.
    pub fn coordinates(self, pose: &Isometry3<f64>, near: &[f64]) -> Vec<f64> {
        let at = |k: usize| near.get(k).copied().unwrap_or(0.0);
        let mut out: Vec<f64> = pose.translation.vector.iter().copied().collect();
        match self {
            Self::FixedXyz => out.extend(euler(pose, [at(3), at(4), at(5)])),
            Self::EulerZyx => {
                let [a, b, c] = euler(pose, [at(5), at(4), at(3)]);
                out.extend([c, b, a]);
            }
            Self::Quaternion => {
                let own = Quaternion::new(at(3), at(4), at(5), at(6));
                let q = pose.rotation.quaternion();
                // a quaternion that was rounded to digits keeps its length
                let scale = if own.norm() > 0.5 { own.norm() } else { 1.0 };
                let sign = if own.dot(q) < 0.0 { -scale } else { scale };
                out.extend([q.w * sign, q.i * sign, q.j * sign, q.k * sign]);
            }
            Self::RotationVector => {
                let v = scaled_axis(&pose.rotation);
                let own = Vector3::new(at(3), at(4), at(5));
                let axis = v.try_normalize(1e-12).or_else(|| own.try_normalize(1e-12)).unwrap_or_default();
                let around = |k: i32| v + axis * (TAU * f64::from(k));
                let best = (-2..=2).map(around).min_by(|a, b| (a - own).norm().total_cmp(&(b - own).norm()));
                out.extend(best.unwrap_or(v).iter());
            }
        }
        out
    }
}

/// What a number of a pose is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Millimetres or inches in programs, m inside.
    Length,
    /// Degrees or radians in programs, rad inside.
    Angle,
    /// Without a unit: a part of a quaternion.
    Ratio,
}

/// Axis times angle, with digits at half a turn.
fn scaled_axis(rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
    let q = rotation.quaternion();
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    let (w, v) = (q.w * sign, Vector3::new(q.i, q.j, q.k) * sign);
    let sine = v.norm();
    if sine < 1e-12 { v * 2.0 } else { v * (2.0 * sine.atan2(w) / sine) }
}

/// Turns about the fixed X, Y, Z, nearest to `near`.
fn euler(pose: &Isometry3<f64>, near: [f64; 3]) -> [f64; 3] {
    let rotation: Rotation3<f64> = pose.rotation.to_rotation_matrix();
    let m: &Matrix3<f64> = rotation.matrix();
    let level = m[(0, 0)].hypot(m[(1, 0)]);
    let b = (-m[(2, 0)]).atan2(level);
    let candidates = if level < LOCKED {
        // a and c turn about one line: a stays, c takes all
        let a = near[0];
        let sum = (-m[(0, 1)]).atan2(m[(1, 1)]);
        vec![[a, b, if b > 0.0 { sum + a } else { sum - a }]]
    } else {
        let (a, c) = (m[(2, 1)].atan2(m[(2, 2)]), m[(1, 0)].atan2(m[(0, 0)]));
        vec![[a, b, c], [a + PI, PI - b, c + PI]]
    };
    let beside = |angles: [f64; 3]| {
        let mut out = angles;
        for (v, n) in out.iter_mut().zip(near) {
            *v -= ((*v - n) / TAU).round() * TAU;
            if n.abs() <= HALF_TURN && v.abs() > HALF_TURN {
                *v -= v.signum() * TAU;
            }
        }
        out
    };
    let distance = |angles: &[f64; 3]| {
        angles.iter().zip(near).map(|(v, n)| ((v - n) - ((v - n) / TAU).round() * TAU).abs()).sum::<f64>()
    };
    let all = candidates.into_iter().map(beside);
    all.min_by(|x, y| distance(x).total_cmp(&distance(y))).unwrap_or([0.0; 3])
}

/// A Cartesian target.
#[derive(Debug, Clone, Default)]
pub struct PoseGoal {
    /// Index into [`super::Script::targets`] of the numbers, where they can be written; `None`: they are not plain numbers.
    pub target: Option<usize>,
    /// Position of the TCP in the frame, m.
    pub position_m: Vector3<f64>,
    /// `None`: the format gives no orientation.
    pub rotation: Option<UnitQuaternion<f64>>,
    /// Frame in which the numbers are given, and tool that goes there.
    pub frame: Frame,
    /// Tool in which the pose is given.
    pub tool: Frame,
    /// Joints that are meant.
    pub solution: Solution,
    /// The controller takes `solution` as an order on this move; else it only tells how the point was taught.
    pub binding: bool,
    /// Whether it does so on this move is not certain (`binding` is `true` then): where `solution` is not the one nearest to the joints before,
    /// the joints are not known.
    pub unsure: bool,
    /// What the program adds to the numbers of `target`; `None`: nothing.
    pub shift: Option<Box<Shift>>,
    /// Of an arc through three points: the one on its way, in the frame of the goal, m.
    pub via_m: Option<Vector3<f64>>,
    /// External axes of the robot that the target places itself; boxed, as few do.
    pub external: Option<Box<[OfAxis]>>,
}

/// Where a target puts an external axis. Its number is one of the target's, after those of the pose, in the same order.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OfAxis {
    /// Axis of the robot.
    pub axis: usize,
    /// rad or m.
    pub si: f64,
}

/// A displacement of a target: the pose that is meant is `before * numbers * after`.
#[derive(Debug, Clone, PartialEq)]
pub struct Shift {
    /// Left of the numbers.
    pub before: Isometry3<f64>,
    /// Right of the numbers.
    pub after: Isometry3<f64>,
}

impl Shift {
    /// Along the axes of the frame, m.
    pub fn in_frame(by: Vector3<f64>) -> Self {
        Self { before: Translation3::from(by).into(), after: Isometry3::identity() }
    }

    /// Along the axes of the pose itself.
    pub fn of_pose(by: Isometry3<f64>) -> Self {
        Self { before: Isometry3::identity(), after: by }
    }
}

impl PoseGoal {
    /// Whether its frame or its tool hangs on what the program does while it runs.
    pub fn is_computed(&self) -> bool {
        self.frame.is_computed() || self.tool.is_computed()
    }

    /// External axes that the target places.
    pub fn placed(&self) -> &[OfAxis] {
        self.external.as_deref().unwrap_or_default()
    }

    /// The pose as it is written, in its frame.
    pub fn pose(&self) -> Option<Isometry3<f64>> {
        Some(Isometry3::from_parts(self.position_m.into(), self.rotation?))
    }

    /// The pose that numbers of the target mean.
    pub fn meant(&self, numbers: &Isometry3<f64>) -> Isometry3<f64> {
        self.shift.as_ref().map_or(*numbers, |s| s.before * numbers * s.after)
    }

    /// The numbers of the target for a pose that is meant.
    pub fn numbers(&self, meant: &Isometry3<f64>) -> Isometry3<f64> {
        self.shift.as_ref().map_or(*meant, |s| s.before.inverse() * meant * s.after.inverse())
    }

    /// This goal displaced.
    pub fn shifted(mut self, shift: Shift) -> Self {
        let numbers = Isometry3::from_parts(self.position_m.into(), self.rotation.unwrap_or_default());
        let meant = shift.before * numbers * shift.after;
        self.position_m = meant.translation.vector;
        self.rotation = self.rotation.map(|_| meant.rotation);
        self.shift = Some(Box::new(match self.shift.take() {
            Some(own) => Shift { before: shift.before * own.before, after: own.after * shift.after },
            None => shift,
        }));
        self
    }

    /// Why the frame or the tool cannot be known by any file of a user.
    pub fn unknown(&self) -> Option<&Reason> {
        [&self.frame, &self.tool].into_iter().find_map(Frame::unknown)
    }
}

/// Between the name of a frame and the places of the axes that carry it.
const AT: &str = " at ";

/// A frame: of the numbers in the world, or of the tool on the flange.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Frame {
    /// World, or flange.
    #[default]
    Null,
    /// The robot's base.
    Base,
    /// The text gives it.
    Given(Isometry3<f64>),
    /// The controller has it under this name or number, and it stands fixed there while the program runs.
    Named(String),
    /// The program computes it or may change it while it runs: it is asked for by these words. Only what is written in it again is right
    /// whatever its value is.
    Computed(String),
    /// One of these, and which is not certain: known where all are the same.
    Any(Vec<Frame>),
    /// It cannot be determined: why.
    Unknown(Reason),
}

impl Frame {
    /// One that cannot be determined.
    pub fn unclear(why: impl Into<Reason>) -> Self {
        Self::Unknown(why.into())
    }

    /// Why it cannot be determined, where the reader says so.
    pub fn unknown(&self) -> Option<&Reason> {
        match self {
            Self::Unknown(why) => Some(why),
            Self::Any(all) => all.iter().find_map(Self::unknown),
            _ => None,
        }
    }

    /// Whether its value hangs on what the program does while it runs.
    pub fn is_computed(&self) -> bool {
        match self {
            Self::Computed(_) => true,
            Self::Any(all) => all.iter().any(Self::is_computed),
            _ => false,
        }
    }

    /// Whether a name of the program, in lower case, stands among the words that compute it.
    pub fn is_made_of(&self, word: &str) -> bool {
        let inside = |c: char| c.is_alphanumeric() || matches!(c, '_' | '$');
        match self {
            Self::Computed(name) => {
                let name = name.to_lowercase();
                name.match_indices(word).any(|(at, _)| {
                    let before = name[..at].chars().next_back();
                    let after = name[at + word.len()..].chars().next();
                    !(before.is_some_and(inside) || after.is_some_and(inside))
                })
            }
            Self::Any(all) => all.iter().any(|f| f.is_made_of(word)),
            _ => false,
        }
    }

    /// What it is called, whatever external axes carry it and wherever these stand ([`Self::carried`]); empty: it has no name.
    pub fn name_at_rest(&self) -> String {
        match self {
            Self::Named(name) | Self::Computed(name) => match name.split_once(AT).map_or(name.as_str(), |(own, _)| own)
            {
                // the names under which a frame without one is asked for
                "$NULLFRAME" | "wobj0" | "0" => String::new(),
                own => own.to_string(),
            },
            _ => String::new(),
        }
    }

    /// A frame that the program makes of another one: computed, asked for by the name of that and by what is done. `own`: the name where it
    /// has none.
    pub fn made(self, own: &str, how: &str) -> Self {
        match self {
            Self::Unknown(_) => self,
            Self::Any(all) => Self::Any(all.into_iter().map(|f| f.made(own, how)).collect()),
            Self::Named(name) | Self::Computed(name) => Self::Computed(format!("{name} {how}")),
            _ => Self::Computed(format!("{own} {how}")),
        }
    }

    /// The frame where external axes carry the robot or the part: it has to be known for the place where these stand, and so it
    /// is named after both. `axes`: name and value of those that stand elsewhere than at 0; `own`: the frame's own name.
    pub fn carried(self, own: &str, axes: &[(String, f64)]) -> Self {
        if axes.is_empty() {
            return self;
        }
        let name = match &self {
            Self::Unknown(_) => return self,
            Self::Any(all) => return Self::Any(all.iter().map(|f| f.clone().carried(own, axes)).collect()),
            Self::Named(name) | Self::Computed(name) => name.as_str(),
            _ => own,
        };
        let at: Vec<String> = axes.iter().map(|(axis, value)| format!("{axis} {value}")).collect();
        let name = format!("{name}{AT}{}", at.join(", "));
        if self.is_computed() { Self::Computed(name) } else { Self::Named(name) }
    }
}

/// Which of the joints that reach a pose are meant.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Solution {
    /// Those on the branch on which the robot stands.
    #[default]
    Same,
    /// Those next to these, rad or m.
    Near(Vec<f64>),
    /// Those with this configuration.
    Configured(Configuration),
}

/// A configuration as its maker writes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Configuration {
    /// KRL `S` and `T`. S: bit 0 the wrist's centre behind axis 1 (overhead), bit 1 the elbow, bit 2 A5 below zero. T: a bit
    /// for each of A1 to A6 below zero.
    Kuka {
        /// `S`: bits of the arm's form.
        status: Option<u8>,
        /// `T`: bits of the signs of the axes.
        turn: Option<u8>,
    },
    /// RAPID `[cf1, cf4, cf6, cfx]`: quarters of a turn of axes 1, 4, 6; cfx: wrist behind axis 1 (4), behind the lower arm
    /// (2), axis 5 negative (1).
    Abb {
        /// `cf1`, `cf4`, `cf6`: quarter turns of axes 1, 4 and 6.
        quarters: [i32; 3],
        /// `cfx`: the form of the arm, 0 to 7.
        cfx: i32,
    },
    /// `'N U T, 0, 0, 0'`: wrist flipped, elbow up, in front; turns of J1, J4, J6.
    Fanuc {
        /// `F` (flip), else `N` (no flip).
        flip: bool,
        /// `U` (up), else `D` (down).
        up: bool,
        /// `T` (toward the front), else `B` (back).
        front: bool,
        /// Turns of J1, J4 and J6.
        turns: [i32; 3],
    },
    /// `///RCONF`: no-flip, lower arm, rear, and R, T, S beyond half a turn.
    Yaskawa {
        /// First number of `///RCONF`: no flip.
        no_flip: bool,
        /// Second number: the elbow below.
        lower: bool,
        /// Third number: the rear.
        rear: bool,
        /// R, T and S are 180 deg or more.
        beyond: [bool; 3],
    },
}

/// In the words of its language: `S 2, T 34`, `[0,-1,0,1]`, `'N U T, 0, 0, 0'`, `RCONF 1,0,0,0,0,0`.
impl fmt::Display for Configuration {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Kuka { status, turn } => {
                let of = |name: &str, v: Option<u8>| v.map(|v| format!("{name} {v}"));
                let all: Vec<String> = of("S", status).into_iter().chain(of("T", turn)).collect();
                f.write_str(&all.join(", "))
            }
            Self::Abb { quarters: [a, b, c], cfx } => write!(f, "[{a},{b},{c},{cfx}]"),
            Self::Fanuc { flip, up, front, turns: [a, b, c] } => {
                let letter = |is: bool, yes: char, no: char| if is { yes } else { no };
                let [wrist, elbow, side] = [letter(flip, 'F', 'N'), letter(up, 'U', 'D'), letter(front, 'T', 'B')];
                write!(f, "'{wrist} {elbow} {side}, {a}, {b}, {c}'")
            }
            Self::Yaskawa { no_flip, lower, rear, beyond } => {
                let [r, t, s] = beyond.map(u8::from);
                let [flip, elbow, side] = [no_flip, lower, rear].map(u8::from);
                write!(f, "RCONF {flip},{elbow},{side},{r},{t},{s}")
            }
        }
    }
}

impl Configuration {
    /// What it says of the arm's posture alone, without turns, as a number of no other meaning; `None`: nothing.
    pub fn posture(&self) -> Option<u8> {
        let bits = |bits: [bool; 3]| bits.iter().enumerate().map(|(k, b)| u8::from(*b) << k).sum();
        match *self {
            Self::Kuka { status, .. } => status,
            // controllers of robots without cfx write 0
            Self::Abb { cfx, .. } => u8::try_from(cfx).ok(),
            Self::Fanuc { flip, up, front, .. } => Some(bits([flip, up, front])),
            Self::Yaskawa { no_flip, lower, rear, .. } => Some(bits([no_flip, lower, rear])),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const FORMS: [PoseForm; 4] =
        [PoseForm::FixedXyz, PoseForm::EulerZyx, PoseForm::Quaternion, PoseForm::RotationVector];

    fn same(a: &Isometry3<f64>, b: &Isometry3<f64>) -> bool {
        (a.translation.vector - b.translation.vector).norm() < 1e-12 && a.rotation.angle_to(&b.rotation) < 1e-7
    }

    proptest! {
        #[test]
        fn numbers_of_a_pose_come_back(k in 0..4usize, v in prop::collection::vec(-3.1..3.1f64, 6)) {
            let rotation = UnitQuaternion::from_euler_angles(v[3], v[4], v[5]);
            let pose = Isometry3::from_parts(Translation3::new(v[0], v[1], v[2]), rotation);
            let own = FORMS[k].coordinates(&pose, &[0.0; 7]);
            prop_assert_eq!(own.len(), FORMS[k].count());
            prop_assert!(same(&FORMS[k].pose(&own).unwrap(), &pose));
            // what stands there already is what comes back
            let again = FORMS[k].coordinates(&pose, &own);
            prop_assert!(own.iter().zip(&again).all(|(a, b)| (a - b).abs() < 1e-6), "{:?} {:?}", own, again);
        }

        #[test]
        fn a_small_turn_changes_numbers_by_little(k in 0..4usize, v in prop::collection::vec(-1.4..1.4f64, 6)) {
            let rotation = UnitQuaternion::from_euler_angles(v[3], v[4], v[5]);
            let pose = Isometry3::from_parts(Translation3::new(v[0], v[1], v[2]), rotation);
            let own = FORMS[k].coordinates(&pose, &[0.0; 7]);
            let turned = pose * UnitQuaternion::from_scaled_axis(Vector3::new(1e-5, -1e-5, 1e-5));
            let new = FORMS[k].coordinates(&turned, &own);
            prop_assert!(own.iter().zip(&new).all(|(a, b)| (a - b).abs() < 2e-4), "{:?} {:?}", own, new);
        }
    }

    /// KUKA: A 90, B 0, C 90 turns x into y, then tilts: the tool's z points along the base's x.
    #[test]
    fn angles_mean_what_their_makers_say() {
        let turn = PI / 2.0;
        let kuka = PoseForm::EulerZyx.pose(&[0.0, 0.0, 0.0, turn, 0.0, turn]).unwrap();
        assert!((kuka * Vector3::z() - Vector3::x()).norm() < 1e-12, "{}", kuka * Vector3::z());
        // FANUC W 180, P 0, R 0: the tool looks down, its x along the world's
        let fanuc = PoseForm::FixedXyz.pose(&[0.0, 0.0, 0.0, PI, 0.0, 0.0]).unwrap();
        assert!(
            (fanuc * Vector3::z() + Vector3::z()).norm() < 1e-12
                && (fanuc * Vector3::x() - Vector3::x()).norm() < 1e-12
        );
        // RAPID [0, 0, 1, 0]: half a turn about y
        let rapid = PoseForm::Quaternion.pose(&[0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]).unwrap();
        assert!(
            (rapid * Vector3::x() + Vector3::x()).norm() < 1e-12
                && (rapid * Vector3::y() - Vector3::y()).norm() < 1e-12
        );
        // URScript p[0, 0, 0, 0, 3.14159..., 0]: the same
        let ur = PoseForm::RotationVector.pose(&[0.0, 0.0, 0.0, 0.0, PI, 0.0]).unwrap();
        assert!((ur * Vector3::x() + Vector3::x()).norm() < 1e-12);
    }

    #[test]
    fn a_locked_middle_angle_keeps_the_first_and_half_turns_stay_within_half_a_turn() {
        let own = [0.0, 0.0, 0.0, 0.3, PI / 2.0, -0.2];
        let pose = PoseForm::FixedXyz.pose(&own).unwrap();
        let again = PoseForm::FixedXyz.coordinates(&pose, &own);
        assert!(same(&PoseForm::FixedXyz.pose(&again).unwrap(), &pose) && (again[3] - 0.3).abs() < 1e-9, "{again:?}");
        let own = [0.0, 0.0, 0.0, PI - 1e-5, 0.0, 0.0];
        let pose =
            PoseForm::FixedXyz.pose(&own).unwrap() * UnitQuaternion::from_scaled_axis(Vector3::new(5e-5, 0.0, 0.0));
        let new = PoseForm::FixedXyz.coordinates(&pose, &own);
        assert!((new[3] + PI - 4e-5).abs() < 1e-9, "{new:?}");
    }

    #[test]
    fn a_computed_frame_is_made_of_whole_words() {
        let frame = Frame::Computed("wList{i} displaced by PDispOn at eax_a 30".into());
        assert!(frame.is_made_of("wlist") && frame.is_made_of("i"));
        assert!(!frame.is_made_of("w") && !frame.is_made_of("list") && !frame.is_made_of("a"));
        assert!(!Frame::Named("w".into()).is_made_of("w"));
        let by = Frame::Null.made("0", "with OFFSET,PR[12:UP]");
        assert!(by.is_computed() && by.is_made_of("pr") && by.is_made_of("pr[12") && !by.is_made_of("pr[1"));
        assert!(by.carried("0", &[("E1".into(), 5.0)]).is_computed());
    }

    #[test]
    fn a_rounded_quaternion_keeps_its_length_and_sign() {
        let own = [0.0, 0.0, 0.0, -0.60001, 0.0, 0.80001, 0.0];
        let pose = PoseForm::Quaternion.pose(&own).unwrap();
        let again = PoseForm::Quaternion.coordinates(&pose, &own);
        assert!(own.iter().zip(&again).all(|(a, b)| (a - b).abs() < 1e-12), "{again:?}");
    }
}
