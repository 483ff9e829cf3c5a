//! Limits of joints: the time that a step needs, and what exceeds speed or acceleration.

use super::{DEG, kuka, on_axis, one_axis, run};
use lostmotion::compensator::FrictionShape;
use lostmotion::effects::Decay;
use lostmotion::rewrite::{LimitKind, Options, Origin, Points};

#[test]
fn limits_are_named_with_place_and_value() {
    let robot = kuka();
    // A1 ends at 185 degrees
    let (_, stats) = run(&robot, &on_axis(0, 0.01, None), Options::new(6), &one_axis(&[184.0, 184.995, 184.0]), 10);
    assert_eq!(stats.violations_total, 1);
    let v = &stats.violations[0];
    assert_eq!((v.origin, v.axis, v.what), (Origin::Point(1), 0, LimitKind::Range));
    assert!((v.value / DEG - 185.005).abs() < 1e-9 && (v.limit / DEG - 185.0).abs() < 1e-9);
    // 136 degrees a second
    let mut fast = one_axis(&[0.0, 1.0, 2.0]);
    fast.t_s = vec![0.0, 0.005, 1.0];
    let (_, stats) = run(&robot, &on_axis(0, 0.01, None), Options::new(6), &fast, 10);
    assert!(stats.violations.iter().any(|v| v.what == LimitKind::Speed && v.origin == Origin::Point(1)));
}

#[test]
fn the_step_of_a_fast_program_keeps_to_the_joint_s_own_acceleration() {
    let robot = kuka();
    // 250 Hz, soft turns of 3 degrees
    let n = 4000;
    let mut points = one_axis(&(0..n).map(|i| 3.0 * (f64::from(i) * 0.004 * 2.0).sin()).collect::<Vec<_>>());
    points.t_s = (0..n).map(|i| f64::from(i) * 0.004).collect();
    let (out, stats) = run(
        &robot,
        &on_axis(0, 0.005, Some((0.003, FrictionShape::Decay(Decay::Time(0.2))))),
        Options::new(6),
        &points,
        512,
    );
    assert!(stats.reversals[0] > 8);
    assert_eq!(stats.violations, []);
    assert!(out.t_s.windows(2).all(|w| w[1] > w[0]));
}

#[test]
fn a_joint_that_turns_again_before_its_step_is_done_exceeds_its_acceleration() {
    let robot = kuka();
    // to and fro every 8 ms: no step of 0.02 deg fits within half of 300 deg/s2
    let mut points = one_axis(&(0..60).map(|i| 0.05 * f64::from(i / 2 % 2)).collect::<Vec<_>>());
    points.t_s = (0..60).map(|i| f64::from(i) * 0.004).collect();
    let (_, stats) = run(&robot, &on_axis(0, 0.01, None), Options::new(6), &points, 512);
    assert!(stats.reversals[0] > 8);
    assert!(stats.violations.iter().any(|v| v.what == LimitKind::Acceleration), "{:?}", stats.violations);
}

/// A1 turns once, in the middle; A6 goes on by 4 degrees a point, the TCP by some millimetres.
fn turn_beside_a_fast_wrist(n: u32) -> Points {
    let mut p = Points { axes: 6, ..Points::default() };
    for i in 0..n {
        let a1 = 0.2 * (f64::from(i) - f64::from(n) / 2.0).abs();
        p.q.extend([a1 * DEG, -80.0 * DEG, 90.0 * DEG, 0.0, 20.0 * DEG, (4.0 * f64::from(i) - 80.0) * DEG]);
    }
    p
}

#[test]
fn a_step_at_constant_tcp_speed_has_the_time_its_joint_needs_and_stops_no_other_joint() {
    let robot = kuka();
    let points = turn_beside_a_fast_wrist(40);
    for (mm_s, friction) in
        [(100.0, None), (300.0, None), (100.0, Some((0.0034, FrictionShape::Decay(Decay::Time(5.2)))))]
    {
        let options = Options { tcp_speed_m_s: Some(mm_s / 1000.0), ..Options::new(6) };
        let (out, stats) = run(&robot, &on_axis(0, 0.006, friction), options, &points, 16);
        assert_eq!((stats.reversals[0], &stats.violations), (1, &vec![]), "{mm_s} mm/s");
        // the leg after the turn at nominal speed, and the least time of the step: half the acceleration, up and down again
        let leg_s = (robot.tcp_m(points.row(21)) - robot.tcp_m(points.row(20))).norm() / (mm_s / 1000.0);
        let step = 0.012 + friction.map_or(0.0, |f| f.0);
        let need_s = 2.0 * (step * DEG / (0.5 * robot.axis(0).max_accel.unwrap())).sqrt();
        let share = out.origin.iter().find_map(|o| match *o {
            Origin::Inserted { after: 20, fraction } => Some(fraction),
            _ => None,
        });
        assert!(need_s < leg_s && (share.unwrap() * leg_s - need_s).abs() < 1e-6, "{share:?}, {need_s} of {leg_s} s");
    }
}

#[test]
fn a_step_that_its_joint_cannot_do_before_it_turns_again_is_named_and_a_corner_of_the_program_is_not() {
    let robot = kuka();
    let zigzag: Vec<f64> = (0..40).map(|i| if i % 2 == 0 { 0.0 } else { 0.02 }).collect();
    let options = || Options { tcp_speed_m_s: Some(0.2), ..Options::new(6) };
    let (_, stats) = run(&robot, &on_axis(0, 0.006, None), options(), &one_axis(&zigzag), 16);
    assert!(stats.violations.iter().any(|v| v.what == LimitKind::Acceleration && v.axis == 0));
    // 0.4 degrees a point and back, 80 ms a point: far beyond the joint at 2 m/s, with or without an offset of 1e-6 degrees
    let corner: Vec<f64> = (0..40).map(|i: i32| 0.4 * f64::from((i - 20).abs())).collect();
    let options = Options { tcp_speed_m_s: Some(2.0), ..Options::new(6) };
    let (_, stats) = run(&robot, &on_axis(0, 1e-6, None), options, &one_axis(&corner), 16);
    assert_eq!(stats.violations, []);
}

#[test]
fn a_zero_compensator_refuses_nothing() {
    let robot = kuka();
    let (_, stats) = run(&robot, &on_axis(0, 0.0, None), Options::new(6), &one_axis(&[0.0, 300.0]), 10);
    assert_eq!(stats.violations_total, 0);
}
