//! Joints of targets and back, by five arms; frames and tools by name.

use super::super::configuration::allows;
use super::borders::Rounding;
use super::solve::distance;
use super::*;
use crate::program::script::PathKind;
use crate::program::script::pose::{Configuration, Frame, PoseForm, PoseGoal, Quantity, Solution};
use crate::rewrite::script::cause::Cause;
use crate::robot::frames::Frames;
use crate::robot::{Flip, GapOf, Robot};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use std::sync::Arc;

const ARMS: [&str; 5] = [
    include_str!("../../../../configs/kuka-kr120-r2500-pro.yaml"),
    include_str!("../../../../configs/abb-irb1600-6-145.yaml"),
    include_str!("../../../../configs/fanuc-m10ia.yaml"),
    include_str!("../../../../configs/motoman-ma2010.yaml"),
    include_str!("../../../../configs/universal-robots-ur10.yaml"),
];
const FORMS: [PoseForm; 4] = [PoseForm::EulerZyx, PoseForm::Quaternion, PoseForm::FixedXyz, PoseForm::RotationVector];

fn isometry(v: &[f64]) -> Isometry3<f64> {
    let rotation = UnitQuaternion::from_scaled_axis(Vector3::new(v[3], v[4], v[5]));
    Isometry3::from_parts(Translation3::new(v[0], v[1], v[2]), rotation)
}

fn place(k: usize, tool: Isometry3<f64>, frame: Isometry3<f64>) -> Place {
    let robot = Robot::parse("r", ARMS[k]).unwrap();
    Place {
        tooled: Arc::new(Tooled::new(&robot, tool)),
        frame,
        posture: None,
        by_order: true,
        lettered: false,
        flip: None,
    }
}

fn goal(at: &Isometry3<f64>, solution: Solution) -> PoseGoal {
    PoseGoal {
        target: None,
        position_m: at.translation.vector,
        rotation: Some(at.rotation),
        frame: Frame::Null,
        tool: Frame::Null,
        solution,
        binding: true,
        ..PoseGoal::default()
    }
}

fn joints(place: &Place, shares: &[f64]) -> Vec<f64> {
    let robot = &place.tooled.robot;
    robot.axis_joints().zip(shares).map(|(j, s)| j.limits.map_or(0.0, |[a, b]| a + s * (b - a))).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Rounded to digits, the pose that is written is that of q + offset within half a last digit.
    #[test]
    fn what_is_written_is_the_pose_of_the_joints_with_their_offset(
        k in 0..5usize, f in 0..4usize,
        shares in prop::collection::vec(0.2..0.8f64, 6), by in prop::collection::vec(-1e-4..1e-4f64, 6),
        tool in prop::collection::vec(-0.3..0.3f64, 6), frame in prop::collection::vec(-1.0..1.0f64, 6),
    ) {
        let place = place(k, isometry(&tool), isometry(&frame));
        let form = FORMS[f];
        let q = joints(&place, &shares);
        let to: Vec<f64> = q.iter().zip(&by).map(|(a, b)| a + b).collect();
        let plain = PoseGoal::default();
        let own = place.written(&plain, form, &q, &[0.0; 7]);
        let new = place.shifted(&plain, form, &own, &q, &to).unwrap();
        // the digits of a language: 0.001 mm, 0.0001 deg, 1e-7 of a quaternion
        let digit = |i: usize| match form.quantity(i) {
            Quantity::Length => 1e-6,
            Quantity::Angle => 1e-4_f64.to_radians(),
            Quantity::Ratio => 1e-7,
        };
        let rounded: Vec<f64> = new.iter().enumerate().map(|(i, v)| (v / digit(i)).round() * digit(i)).collect();
        let wanted = place.frame.inverse() * place.arm_at(&to);
        let back = form.pose(&rounded).unwrap();
        prop_assert!((back.translation.vector - wanted.translation.vector).abs().max() <= 0.5e-6 + 1e-12);
        let turn = (wanted.rotation.inverse() * back.rotation).scaled_axis().norm();
        // three angles of half a digit each; a quaternion's parts count twice
        let most = if f == 1 { 4.0 * 0.5e-7 * 2.0 } else { 3.0 * 0.5 * digit(3) };
        prop_assert!(turn <= most + 1e-9, "{turn} {most}");
        // nothing moves where no joint does
        let same = place.shifted(&plain, form, &own, &q, &q).unwrap();
        prop_assert!(own.iter().zip(&same).all(|(a, b)| (a - b).abs() < 1e-11), "{own:?} {same:?}");
    }

    /// A KUKA's S and T name the joints, without any joints before; so do those before alone.
    #[test]
    fn status_and_turn_or_the_joints_before_give_the_joints(
        shares in prop::collection::vec(0.05..0.95f64, 6), near in prop::collection::vec(-0.05..0.05f64, 6),
    ) {
        let place = place(0, Isometry3::translation(0.1, 0.0, 0.2), Isometry3::identity());
        let q = joints(&place, &shares);
        let arm = place.tooled.arm.as_ref().unwrap();
        let posture = arm.posture(&q).unwrap();
        prop_assume!(q.iter().all(|v| v.abs() > 0.05 && v.abs() < 3.1) && posture.front_m.abs() > 0.05);
        prop_assume!(posture.elbow.abs() > 0.05 && q[4].sin().abs() > 0.05);
        let at = place.arm_at(&q);
        let turn = q.iter().enumerate().map(|(i, v)| u8::from(*v < 0.0) << i).sum();
        let status = u8::from(posture.front_m < 0.0) + 2 * u8::from(posture.elbow > 0.0) + 4 * u8::from(q[4] < 0.0);
        let taught = Solution::Configured(Configuration::Kuka { status: Some(status), turn: Some(turn) });
        let found = place.joints(&goal(&at, taught), None, PathKind::Joint, None).unwrap();
        prop_assert!(distance(&found, &q) < 1e-6, "{found:?} {q:?}");
        let from: Vec<f64> = q.iter().zip(&near).map(|(a, b)| a + b).collect();
        let found = place.joints(&goal(&at, Solution::Same), Some(&from), PathKind::Joint, None).unwrap();
        prop_assert!(distance(&found, &q) < 1e-6, "{found:?} {q:?}");
    }
}

#[test]
fn a_joint_move_to_another_configuration_than_that_before_goes_there_where_one_solution_has_it() {
    let mut place = place(0, Isometry3::identity(), Isometry3::identity());
    let q: Vec<f64> = [10.0, -80.0, 95.0, 12.0, 40.0, -20.0].map(f64::to_radians).into();
    let at = place.arm_at(&q);
    let kuka = |status, turn| Solution::Configured(Configuration::Kuka { status: Some(status), turn: Some(turn) });
    let own = goal(&at, kuka(2, 0b100010));
    assert!(distance(&place.joints(&own, Some(&q), PathKind::Joint, None).unwrap(), &q) < 1e-6);
    // the wrist turned over: A5 below zero
    let flipped = goal(&at, kuka(6, 0b011010));
    let other = place.joints(&flipped, None, PathKind::Joint, None).unwrap();
    assert!(other[4] < 0.0 && distance(&other, &q) > 1.0);
    let ordered = place.joints(&flipped, Some(&q), PathKind::Joint, None).unwrap();
    assert!(distance(&ordered, &other) < 1e-6 && place.goes_over(&q, &ordered) && !place.goes_over(&q, &q));
    // not without turn or status, and not in a program of which most motions do so
    for part in [(Some(6), None), (None, Some(0b011010))] {
        let part = Solution::Configured(Configuration::Kuka { status: part.0, turn: part.1 });
        assert!(place.joints(&goal(&at, part), Some(&q), PathKind::Joint, None).is_err());
    }
    // nor where it is not certain that the controller follows it; the nearest one is known all the same
    let unsure = |goal: &PoseGoal| PoseGoal { unsure: true, ..goal.clone() };
    let found = place.joints(&unsure(&flipped), Some(&q), PathKind::Joint, None);
    assert_eq!(found, Err(Cause::PerhapsOtherArm));
    assert!(distance(&place.joints(&unsure(&own), Some(&q), PathKind::Joint, None).unwrap(), &q) < 1e-6);
    place.by_order = false;
    assert_eq!(place.joints(&flipped, Some(&q), PathKind::Joint, None), Err(Cause::OtherArm));
    place.by_order = true;
    // on a straight path the controller does not look at it
    let linear = PoseGoal { binding: false, ..flipped };
    assert!(distance(&place.joints(&linear, Some(&q), PathKind::Linear, None).unwrap(), &q) < 1e-6);
}

/// Which sign of J5 a FANUC calls N differs by model. Where both ends of a joint move have the same letter, J4 and J6 turn by the same
/// amount whatever it means, unless one of them turns the other way round then.
#[test]
fn a_letter_for_the_wrist_decides_between_targets_that_have_it() {
    let mut place = place(2, Isometry3::identity(), Isometry3::identity());
    let fanuc = |flip| Solution::Configured(Configuration::Fanuc { flip, up: true, front: true, turns: [0; 3] });
    let deg = |q: [f64; 6]| q.map(f64::to_radians).to_vec();
    let from = deg([5.0, 10.0, 20.0, 10.0, -50.0, 20.0]);
    let to = |place: &Place, q: &[f64], flip| {
        place.joints(&goal(&place.arm_at(q), fanuc(flip)), Some(&from), PathKind::Joint, None)
    };
    // J4 turns by 110 deg: the other wrist is nearer
    let far = deg([8.0, 12.0, 22.0, 120.0, -45.0, 60.0]);
    assert_eq!(to(&place, &far, false), Err(Cause::OtherArm));
    place.lettered = true;
    assert!(distance(&to(&place, &far, false).unwrap(), &far) < 1e-6);
    // from 10 to -150 deg or, with the other meaning, from -170 to 30 deg
    let round = deg([8.0, 12.0, 22.0, -150.0, -45.0, 60.0]);
    assert_eq!(to(&place, &round, false), Err(Cause::OtherArm));
}

/// The letter is of a robot with F below zero: joints near a target show it, joints that are as near to both wrists do not.
#[test]
fn a_letter_is_refuted_by_joints_near_a_target_that_it_would_turn_over() {
    let mut place = place(2, Isometry3::identity(), Isometry3::identity());
    let fanuc = Solution::Configured(Configuration::Fanuc { flip: true, up: true, front: true, turns: [0; 3] });
    let deg = |q: [f64; 6]| q.map(f64::to_radians).to_vec();
    let (own, other) = (deg([10.0, 5.0, 5.0, 12.0, -65.0, 5.0]), deg([10.0, 5.0, 5.0, -168.0, 65.0, -175.0]));
    let goal = goal(&place.arm_at(&own), fanuc);
    let (near, between) = (deg([0.0, 0.0, 0.0, 10.0, -60.0, 0.0]), deg([0.0, 0.0, 0.0, -78.0, -60.0, -85.0]));
    for (flip, meant) in [(Flip::Positive, &other), (Flip::Negative, &own)] {
        place.flip = Some(flip);
        let found = place.joints(&goal, None, PathKind::Joint, None).unwrap();
        assert!(distance(&found, meant) < 1e-6 && place.is_by_letter(&goal, &found), "{flip:?}: {found:?}");
        assert_eq!(place.contradicts(&goal, &own), flip == Flip::Positive);
        assert_eq!(place.turns_over_for_letter(&goal, &near), flip == Flip::Positive);
        assert!(!place.turns_over_for_letter(&goal, &between), "{flip:?}");
        assert!(!place.stands_on_turn(&goal, &found));
    }
    assert!(place.stands_on_turn(&goal, &deg([10.0, 5.0, 5.0, 180.0, -65.0, 5.0])));
}

#[test]
fn joints_elsewhere_tell_the_arm_configuration_of_an_unknown_start() {
    let place = place(4, Isometry3::translation(0.0, 0.0, 0.1), Isometry3::identity());
    let q: Vec<f64> = [20.0, -80.0, 90.0, -100.0, -90.0, 30.0].map(f64::to_radians).into();
    let goal = PoseGoal { binding: false, ..goal(&place.arm_at(&q), Solution::Same) };
    let from = |hint: Option<&[f64]>| place.joints(&goal, None, PathKind::Linear, hint);
    assert_eq!(from(None), Err(Cause::NoStart));
    let elsewhere: Vec<f64> = q.iter().zip([0.4, -0.2, 0.3, -0.2, 0.1, 0.2]).map(|(a, b)| a + b).collect();
    assert!(distance(&from(Some(&elsewhere)).unwrap(), &q) < 1e-6);
    // the elbow bent the other way: another arm, or none that is certain
    let other: Vec<f64> = [20.0, -20.0, -90.0, 20.0, -90.0, 30.0].map(f64::to_radians).into();
    assert!(from(Some(&other)).map_or(f64::INFINITY, |found| distance(&found, &q)) > 0.5);
}

#[test]
fn a_posture_that_the_user_gives_chooses_the_arm_configuration_wherever_it_stands() {
    // the same elbow and wrist far away, for arms with and without a spherical wrist
    let postures = [[-60.0, -100.0, 110.0, 0.0, 70.0, 0.0], [150.0, -60.0, 70.0, -110.0, -60.0, -20.0]];
    let there = [[40.0, -70.0, 80.0, 20.0, 30.0, -10.0], [20.0, -80.0, 90.0, -100.0, -90.0, 30.0]];
    for (k, (posture, q)) in [0, 4].into_iter().zip(postures.into_iter().zip(there)) {
        let mut place = place(k, Isometry3::translation(0.0, 0.0, 0.1), Isometry3::identity());
        let q: Vec<f64> = q.map(f64::to_radians).into();
        let goal = PoseGoal { binding: false, ..goal(&place.arm_at(&q), Solution::Same) };
        assert_eq!(place.joints(&goal, None, PathKind::Linear, None), Err(Cause::NoStart));
        place.posture = Some(posture.map(f64::to_radians).into());
        let found = place.joints(&goal, None, PathKind::Linear, None).unwrap();
        assert!(distance(&found, &q) < 1e-6, "{k}: {found:?}");
        // another wrist is another solution
        let mut other = posture.map(f64::to_radians);
        other[4] = -other[4];
        place.posture = Some(other.into());
        let found = place.joints(&goal, None, PathKind::Linear, None).unwrap();
        assert!((found[4].sin() > 0.0) != (q[4].sin() > 0.0), "{k}: {found:?}");
        assert!((place.arm_at(&found).translation.vector - place.arm_at(&q).translation.vector).norm() < 1e-9);
    }
}

#[test]
fn a_displaced_target_is_written_in_its_own_numbers() {
    let place = place(1, Isometry3::identity(), Isometry3::identity());
    let q: Vec<f64> = [10.0, 20.0, 15.0, 30.0, 40.0, -20.0].map(f64::to_radians).into();
    let to: Vec<f64> = q.iter().map(|v| v + 7e-5).collect();
    let shift = crate::program::script::Shift {
        before: isometry(&[0.1, 0.2, 0.0, 0.0, 0.0, 0.3]),
        after: isometry(&[0.0, 0.0, -0.05, 0.2, 0.0, 0.0]),
    };
    let numbers = shift.before.inverse() * place.arm_at(&q) * shift.after.inverse();
    let goal = goal(&numbers, Solution::Same).shifted(shift);
    let form = PoseForm::Quaternion;
    let own = form.coordinates(&numbers, &[0.0; 7]);
    let found = place.joints(&goal, Some(&q), PathKind::Joint, None).unwrap();
    assert!(distance(&found, &q) < 1e-6, "{found:?}");
    let new = form.pose(&place.shifted(&goal, form, &own, &q, &to).unwrap()).unwrap();
    let (meant, wanted) = (goal.meant(&new), place.arm_at(&to));
    assert!((meant.translation.vector - wanted.translation.vector).norm() < 1e-12);
    assert!(meant.rotation.angle_to(&wanted.rotation) < 1e-7);
}

#[test]
fn several_frames_are_known_where_all_are_the_same() {
    let robot = Robot::parse("r", ARMS[0]).unwrap();
    let any = |names: &[&str]| Frame::Any(names.iter().map(|n| Frame::Named((*n).into())).collect());
    let asks = |names: &[&str]| PoseGoal { frame: any(names), ..goal(&Isometry3::identity(), Solution::Same) };
    let text = "schema: lostmotion/frames/1\nframes: {a: {xyz_mm: [1, 0, 0]}, b: {xyz_mm: [1, 0, 0]}, c: {}}\n";
    let mut poses = Poses::new(&robot, &Frames::parse("f", text).unwrap());
    assert!(poses.place(&asks(&["a", "b"])).is_ok());
    assert!(poses.place(&asks(&["a", "c"])).unwrap_err().to_string().contains("is ambiguous"));
    assert!(poses.missing.is_empty());
    assert!(poses.place(&asks(&["a", "d"])).unwrap_err().to_string().contains("frame `d`"));
}

/// What rounding to a last digit of so many mm and degrees may do.
fn digits(mm: f64, deg: f64) -> Rounding {
    let mut all = Rounding::default();
    for k in 0..6 {
        all.add(PoseForm::EulerZyx, k, 0.0, if k < 3 { mm * 1e-3 } else { deg.to_radians() });
    }
    all
}

#[test]
fn signs_that_several_joints_make_leave_a_target_on_their_border() {
    let place = place(0, Isometry3::identity(), Isometry3::identity());
    let taught = Solution::Configured(Configuration::Kuka { status: Some(2), turn: None });
    let mut q: Vec<f64> = [10.0, -80.0, 95.0, 30.0, 40.0, -20.0].map(f64::to_radians).into();
    let goal = goal(&place.arm_at(&q), taught);
    assert!(place.may_be(&goal, &q, digits(1e-4, 1e-4)).is_ok());
    // the wrist goes over to the other sign of A5
    q[4] = -5e-5;
    assert!(place.may_be(&goal, &q, digits(1e-4, 1e-4)).unwrap_err() == Cause::Border);
}

/// Configuration, pendant joints, the joint that stands on a border (counted from 0), and on which side it has to stay.
fn on_borders() -> [(usize, Configuration, [f64; 6], usize, f64); 7] {
    let abb = |quarters| Configuration::Abb { quarters, cfx: 0 };
    let kuka = |turn| Configuration::Kuka { status: Some(2), turn: Some(turn) };
    let fanuc = Configuration::Fanuc { flip: false, up: true, front: true, turns: [0, 0, -1] };
    let yaskawa = Configuration::Yaskawa { no_flip: false, lower: false, rear: false, beyond: [false, true, false] };
    [
        // tools straight down
        (1, abb([0, 0, 0]), [10.0, 20.0, 15.0, 0.0, 55.0, 10.0], 3, 1.0),
        (1, abb([0, -1, 0]), [10.0, 20.0, 15.0, 0.0, 55.0, 10.0], 3, -1.0),
        (1, abb([0, -1, 1]), [10.0, 20.0, 15.0, -5.0, 55.0, 90.0], 5, 1.0),
        (0, kuka(0b000010), [10.0, -80.0, 95.0, 0.0, 75.0, 10.0], 3, 1.0),
        (0, kuka(0b000011), [0.0, -80.0, 95.0, 20.0, 75.0, 10.0], 0, -1.0),
        (2, fanuc, [10.0, 20.0, 15.0, 20.0, -60.0, -180.0], 5, -1.0),
        (3, yaskawa, [10.0, 20.0, 15.0, 20.0, -60.0, -180.0], 5, -1.0),
    ]
}

#[test]
fn a_joint_that_its_offset_takes_over_a_border_stays_on_it_and_the_others_have_theirs() {
    for (k, configuration, q, axis, side) in on_borders() {
        let place = place(k, isometry(&[0.02, 0.0, 0.2, 0.0, 0.0, 0.1]), isometry(&[0.3, 0.1, 0.0, 0.0, 0.0, 0.4]));
        let q: Vec<f64> = q.map(f64::to_radians).into();
        // Yaskawa writes poses as FANUC does
        let form = FORMS[k.min(2)];
        let at = place.frame.inverse() * place.arm_at(&q);
        let goal = goal(&at, Solution::Configured(configuration));
        let own = form.coordinates(&at, &[0.0; 7]);
        let rounding = digits(1e-4, 1e-4);
        for by in [-7e-5, -1e-5, 0.0, 1e-5, 7e-5] {
            let to: Vec<f64> = q.iter().enumerate().map(|(n, v)| v + if n == axis { by } else { 7e-5 }).collect();
            let kept = place.held(&goal, false, [&q, &to], rounding).unwrap();
            assert_eq!(place.may_be(&goal, &kept, rounding), Ok(()), "{configuration} {by}");
            // an offset to the inside is written, one over the border is not; the joint is not further from where it has to be
            let lost = by * side < 0.0;
            assert!((kept[axis] - if lost { q[axis] } else { to[axis] }).abs() < 1e-5, "{configuration} {by}");
            assert!((kept[axis] - to[axis]).abs() <= by.abs() + 1e-5);
            assert!((0..6).all(|n| n == axis || kept[n] == to[n]));
            // as it is written, to four decimals, it has the configuration without any slack
            let numbers = place.shifted(&goal, form, &own, &q, &kept).unwrap();
            let unit = |n: usize| 1e-4 * if form == PoseForm::Quaternion && n > 2 { 1e-2 } else { form.unit(n) };
            let written: Vec<f64> = numbers.iter().enumerate().map(|(n, v)| (v / unit(n)).round() * unit(n)).collect();
            let read = PoseGoal { position_m: Vector3::from_column_slice(&written[..3]), ..goal.clone() };
            let read = PoseGoal { rotation: Some(form.pose(&written).unwrap().rotation), ..read };
            let back = place.joints(&read, Some(&q), PathKind::Joint, None).unwrap();
            assert!(distance(&back, &kept) < 1e-5, "{configuration} {by}: {back:?}");
            let arm = place.tooled.arm.as_ref().unwrap();
            assert!(allows(&configuration, arm, &back, 0.0), "{configuration} {by}: {back:?}");
        }
    }
}

#[test]
fn a_joint_beyond_its_border_or_with_coarse_digits_or_in_a_sum_leaves_the_target() {
    for (k, configuration, q, axis, side) in on_borders() {
        let place = place(k, Isometry3::identity(), Isometry3::identity());
        let mut q: Vec<f64> = q.map(f64::to_radians).into();
        let goal = goal(&place.arm_at(&q), Solution::Configured(configuration));
        let with = |q: &[f64], by: f64| -> Vec<f64> {
            q.iter().enumerate().map(|(n, v)| v + if n == axis { by * side } else { 7e-5 }).collect()
        };
        let fine = digits(1e-4, 1e-4);
        assert!(place.held(&goal, false, [&q, &with(&q, -7e-5)], fine).is_ok());
        assert!(place.held(&goal, false, [&q, &with(&q, -7e-5)], digits(0.01, 0.01)).unwrap_err() == Cause::Border);
        // well inside no digit matters
        assert!(place.held(&goal, false, [&q, &with(&q, 1e-2)], digits(0.01, 0.01)).is_ok());
        let mut robot = place.tooled.robot.clone();
        robot.gap_of = vec![GapOf { axis: 2, others: vec![(axis, 1.0)] }];
        let summed = Place { tooled: Arc::new(Tooled::new(&robot, Isometry3::identity())), ..place.clone() };
        assert!(summed.held(&goal, false, [&q, &with(&q, -7e-5)], fine).unwrap_err() == Cause::Border);
        // a little outside, as rounded programs are, it stays where it is; further outside nobody knows
        q[axis] -= 1.5e-5 * side;
        assert!(place.held(&goal, false, [&q, &with(&q, -7e-5)], fine).unwrap()[axis] == q[axis]);
        q[axis] -= 1e-3 * side;
        assert!(place.held(&goal, false, [&q, &with(&q, -7e-5)], fine).unwrap_err() == Cause::Border);
        assert!(place.held(&goal, false, [&q, &q], fine).unwrap_err() == Cause::Border);
        // an order that the controller does not look at holds nobody
        let free = PoseGoal { binding: false, ..goal };
        assert_eq!(place.held(&free, false, [&q, &with(&q, -7e-5)], fine).unwrap(), with(&q, -7e-5));
    }
}

#[test]
fn what_is_not_known_is_asked_for_by_name_with_the_moves_that_wait() {
    let robot = Robot::parse("r", ARMS[0]).unwrap();
    let mut poses = Poses::new(&robot, &Frames::default());
    let waiting = PoseGoal {
        frame: Frame::Named("2".into()),
        tool: Frame::Named("tGun".into()),
        ..goal(&Isometry3::identity(), Solution::Same)
    };
    for _ in 0..2 {
        assert!(poses.place(&waiting).unwrap_err().to_string().contains("frame `2` and tool `tGun`"));
    }
    assert_eq!((poses.missing.frames["2"], poses.missing.tools["tGun"]), (2, 2));
    let text = "schema: lostmotion/frames/1\nframes: {\"2\": {}}\ntools: {tgun: {}}\n";
    let mut poses = Poses::new(&robot, &Frames::parse("f", text).unwrap());
    assert!(poses.place(&waiting).is_ok() && poses.missing.is_empty());
}
