//! Limits on a machine whose TCP stands at (X, Y, Z): every figure by hand.

use super::*;

/// X: -100 to 200 mm, 500 mm/s, 2000 mm/s2; Y: no limits but a range at 0; Z: none.
fn machine(rates: &str) -> Robot {
    let yaml = format!(
        "schema: lostmotion/robot/1\nname: m\nconvention: dh-standard\njoints:\n\
         - {{name: X, kind: prismatic, theta_deg: 0, d_mm: 0, a_mm: 0, alpha_deg: 90, direction: 1, limits_mm: [-100, 200]{rates}}}\n\
         - {{name: Y, kind: prismatic, theta_deg: 90, d_mm: 0, a_mm: 0, alpha_deg: 90, direction: 1, limits_mm: [-300, 0]}}\n\
         - {{name: Z, kind: prismatic, theta_deg: 0, d_mm: 0, a_mm: 0, alpha_deg: 0, direction: 1}}\n"
    );
    Robot::parse("m.yaml", &yaml).unwrap()
}

fn fast() -> Robot {
    machine(", max_speed_mm_s: 500, max_accel_mm_s2: 2000")
}

const AT: Origin = Origin::Point(7);

/// What, axis and value of each violation.
fn found(stats: &RewriteStats) -> Vec<(LimitKind, usize, f64)> {
    stats.violations.iter().map(|v| (v.what, v.axis, v.value)).collect()
}

fn range(q: [f64; 3], unplaced: AxisSet) -> Vec<(LimitKind, usize, f64)> {
    let robot = machine("");
    let (mut alone, mut together) = (RewriteStats::default(), RewriteStats::default());
    Limits::new(&robot, None, unplaced).check(&q, &q, None, None, AT, &mut alone);
    Limits::new(&robot, None, unplaced).check_run(&q, None, &[AT], &mut together);
    assert_eq!(found(&alone), found(&together));
    assert!(
        alone
            .violations
            .iter()
            .all(|v| v.origin == AT && v.limit == [-0.1, 0.2, -0.3, 0.0][v.axis * 2 + usize::from(v.value > -0.05)])
    );
    found(&alone)
}

#[test]
fn a_range_is_exceeded_beyond_its_ends_by_more_than_the_noise_of_numbers() {
    let none = AxisSet::default();
    for x in [-0.1, 0.0, 0.2, 0.2 * (1.0 + 0.9e-9), -0.1 * (1.0 + 0.9e-9)] {
        assert_eq!(range([x, -0.1, 9.0], none), [], "{x}");
    }
    for x in [0.2 * (1.0 + 1.1e-9), -0.1 * (1.0 + 1.1e-9), 0.3, -5.0] {
        assert_eq!(range([x, -0.1, 9.0], none), [(LimitKind::Range, 0, x)], "{x}");
    }
    // at a limit of zero the noise of a millimetre counts
    assert_eq!(range([0.0, 0.9e-12, 0.0], none), []);
    assert_eq!(range([0.0, 1.1e-12, 0.0], none), [(LimitKind::Range, 1, 1.1e-12)]);
    assert_eq!(range([0.3, 0.1, 0.0], none), [(LimitKind::Range, 0, 0.3), (LimitKind::Range, 1, 0.1)]);
    // where an axis stands in its range is not known
    assert_eq!(range([0.3, 0.1, 0.0], AxisSet::from_iter([0])), [(LimitKind::Range, 1, 0.1)]);
}

#[test]
fn a_run_without_times_and_one_without_limits_of_speed_check_ranges_alone() {
    let (with, without) = (fast(), machine(""));
    let q = [0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.3, 0.0, 0.0];
    let origin = [Origin::Point(0), Origin::Point(1), Origin::Point(2)];
    for (robot, t_s) in [(&with, None), (&without, Some(&[0.0, 1e-3, 2e-3][..]))] {
        let (mut limits, mut stats) = (Limits::new(robot, None, AxisSet::default()), RewriteStats::default());
        limits.check_run(&q, t_s, &origin, &mut stats);
        limits.check_run(&[], t_s, &[], &mut stats);
        assert_eq!(found(&stats), [(LimitKind::Range, 0, 0.3)]);
        assert_eq!(stats.violations[0].origin, Origin::Point(2));
        assert_eq!(limits.durations(), t_s.map(|_| [2e-3, 2e-3]));
        assert_eq!(limits.any_rate(), t_s.is_none());
    }
    assert_eq!(Limits::new(&with, Some(0.1), AxisSet::default()).rate_speed_m_s(), Some(0.1));
    assert_eq!(Limits::new(&without, Some(0.1), AxisSet::default()).rate_speed_m_s(), None);
    assert!(Limits::new(&machine(", max_accel_mm_s2: 2000"), None, AxisSet::default()).any_rate());
    assert!(Limits::new(&machine(", max_speed_mm_s: 500"), None, AxisSet::default()).any_rate());
}

#[test]
fn a_row_beyond_every_limit_of_an_arm_is_found() {
    let yaml = "schema: lostmotion/robot/1\nname: m\nconvention: dh-standard\njoints:\n\
                - {name: X, kind: prismatic, theta_deg: 0, d_mm: 0, a_mm: 0, alpha_deg: 90, direction: 1, limits_mm: [-100, 200]}\n\
                - {name: Y, kind: prismatic, theta_deg: 90, d_mm: 0, a_mm: 0, alpha_deg: 90, direction: 1, limits_mm: [-300, 0]}\n";
    let robot = Robot::parse("m.yaml", yaml).unwrap();
    for q in [[-0.4, -0.4], [0.4, 0.4]] {
        let mut stats = RewriteStats::default();
        Limits::new(&robot, None, AxisSet::default()).check_run(&q, None, &[AT], &mut stats);
        assert_eq!(found(&stats), [(LimitKind::Range, 0, q[0]), (LimitKind::Range, 1, q[1])]);
    }
}

#[test]
fn a_leg_after_a_run_begins_at_the_last_point_of_the_run() {
    let robot = fast();
    for (x, want) in [(0.0699, &[][..]), (0.0801, &[(LimitKind::Acceleration, 3.01)])] {
        let (mut limits, mut stats) = (Limits::new(&robot, None, AxisSet::default()), RewriteStats::default());
        let run = [0.0, -0.01, 0.02, 0.01, -0.02, 0.03, 0.03, -0.03, 0.04];
        limits.check_run(&run, None, &[AT; 3], &mut stats);
        // 0.1 m/s from 0.03, then 0.299 or 0.401 m/s where the program keeps to 0.1
        limits.check(&[0.04, -0.03, 0.04], &[0.04, -0.03, 0.04], None, Some(0.1), AT, &mut stats);
        limits.check(&[x, -0.03, 0.04], &[0.05, -0.03, 0.04], None, Some(0.1), AT, &mut stats);
        close(&found(&stats), want);
    }
}

/// Violations of X at these times; the program's own X beside it, or none where no offset changes.
fn timed(rows: &[(f64, f64, Option<f64>)]) -> Vec<(LimitKind, usize, f64)> {
    let robot = fast();
    let (mut limits, mut stats) = (Limits::new(&robot, None, AxisSet::default()), RewriteStats::default());
    for &(t, x, own) in rows {
        match own {
            Some(own) => limits.check(&[x, 0.0, 0.0], &[own, 0.0, 0.0], Some(t), None, AT, &mut stats),
            None => limits.check_run(&[x, 0.0, 0.0], Some(&[t]), &[AT], &mut stats),
        }
    }
    let (first, last) = (rows[0].0, rows[rows.len() - 1].0);
    assert_eq!(limits.durations(), Some([last - first; 2]));
    found(&stats)
}

fn close(found: &[(LimitKind, usize, f64)], want: &[(LimitKind, f64)]) {
    assert_eq!(found.len(), want.len(), "{found:?}");
    for ((what, axis, value), (kind, by_hand)) in found.iter().zip(want) {
        assert!(what == kind && *axis == 0 && (value - by_hand).abs() < 1e-9 * by_hand.abs(), "{found:?}");
    }
}

#[test]
fn a_speed_is_the_way_over_the_time_of_a_leg() {
    // 0.5 m/s is the limit, whoever asks for it
    close(&timed(&[(1.0, 0.0, None), (1.25, 0.125, None), (1.5, 0.0, None)]), &[]);
    close(&timed(&[(1.0, 0.0, None), (1.25, 0.15, None)]), &[(LimitKind::Speed, 0.6)]);
    close(&timed(&[(1.0, 0.15, Some(0.15)), (1.25, 0.0, Some(0.0))]), &[(LimitKind::Speed, -0.6)]);
}

#[test]
fn an_acceleration_is_checked_where_an_offset_changes_and_its_own_corners_are_the_programs() {
    // 0.1 and 0.3 m/s over legs of 0.1 s: 2 m/s2, the limit
    close(&timed(&[(0.0, 0.0, Some(0.0)), (0.1, 0.01, Some(0.01)), (0.2, 0.04, Some(0.02))]), &[]);
    close(
        &timed(&[(0.0, 0.0, Some(0.0)), (0.1, 0.01, Some(0.01)), (0.2, 0.0401, Some(0.02))]),
        &[(LimitKind::Acceleration, 2.01)],
    );
    // the same of the program itself, and where nothing says that an offset changes
    close(&timed(&[(0.0, 0.0, Some(0.0)), (0.1, 0.01, Some(0.01)), (0.2, 0.0401, Some(0.0401))]), &[]);
    close(&timed(&[(0.0, 0.0, None), (0.1, 0.01, None), (0.2, 0.0401, None)]), &[]);
    // the program exceeds it, and what the offset adds does, too: -3 by itself, 3 with it
    close(
        &timed(&[(0.0, 0.0, Some(0.0)), (0.1, 0.0, Some(0.0)), (0.2, 0.03, Some(-0.03))]),
        &[(LimitKind::Acceleration, 3.0)],
    );
    // the program keeps its 0.2 m/s, and the joint turns: 0.2, -0.2 and 0.25 m/s
    close(
        &timed(&[(0.0, 0.0, Some(0.0)), (0.1, 0.02, Some(0.02)), (0.2, 0.0, Some(0.04)), (0.3, 0.025, Some(0.06))]),
        &[(LimitKind::Acceleration, -4.0), (LimitKind::Acceleration, 4.5)],
    );
    // the program exceeds it by itself, and what the offset adds does not
    close(&timed(&[(0.0, 0.0, Some(0.0)), (0.1, 0.0, Some(0.0)), (0.2, 0.04, Some(0.03))]), &[]);
    // legs of 0.1 and 0.3 s: the mean is 0.2 s; 0.1 and 0.49 m/s make 1.95, 0.1 and -0.31 m/s make -2.05
    close(&timed(&[(0.0, 0.0, Some(0.0)), (0.1, 0.01, Some(0.01)), (0.4, 0.157, Some(0.04))]), &[]);
    close(
        &timed(&[(0.0, 0.0, Some(0.0)), (0.1, 0.01, Some(0.01)), (0.4, -0.083, Some(0.04))]),
        &[(LimitKind::Acceleration, -2.05)],
    );
}

#[test]
fn the_first_leg_and_the_one_after_a_leg_without_duration_have_no_acceleration() {
    close(&timed(&[(0.0, 0.0, Some(0.0)), (0.01, 0.004, Some(0.0))]), &[]);
    close(
        &timed(&[(0.0, 0.0, Some(0.0)), (0.1, 0.01, Some(0.01)), (0.1, 0.01, Some(0.01)), (0.2, 0.05, Some(0.02))]),
        &[],
    );
    // after a run in which no offset changes, the program's speed is that of its points
    close(&timed(&[(0.0, 0.0, None), (0.1, 0.01, None), (0.2, 0.0401, Some(0.0401))]), &[]);
}

/// Violations of X without times, on a machine that has limits of speed alone; it stands at 0 first.
fn untimed(tcp_m_s: Option<f64>, rows: &[(f64, f64, Option<f64>)]) -> Vec<(LimitKind, usize, f64)> {
    let robot = machine(", max_speed_mm_s: 500");
    let (mut limits, mut stats) = (Limits::new(&robot, tcp_m_s, AxisSet::default()), RewriteStats::default());
    for &(x, own, duration_s) in [(0.0, 0.0, None)].iter().chain(rows) {
        limits.check(&[x, 0.0, 0.0], &[own, 0.0, 0.0], None, duration_s, AT, &mut stats);
    }
    assert_eq!(limits.durations(), None);
    found(&stats)
}

#[test]
fn without_times_the_way_of_the_tcp_or_a_known_duration_tells_the_speed() {
    // 1 m/s along X is beyond 0.5 m/s: not if the program itself asks for it, but if an offset does
    close(&untimed(Some(1.0), &[(0.0, 0.0, None), (0.01, 0.01, None)]), &[]);
    close(&untimed(Some(1.0), &[(0.0, 0.0, None), (0.01, 0.0, None)]), &[(LimitKind::Speed, 1.0)]);
    close(&untimed(Some(1.0), &[(0.0, 0.0, None), (0.01, -0.01, None)]), &[(LimitKind::Speed, 1.0)]);
    close(&untimed(Some(0.4), &[(0.0, 0.0, None), (0.01, 0.0, None)]), &[]);
    // no leg is shorter than a cycle of 4 ms: 1.9 mm make 0.475 m/s
    close(&untimed(Some(10.0), &[(0.0, 0.0, None), (0.0019, 0.0, None)]), &[]);
    close(&untimed(Some(10.0), &[(0.0, 0.0, None), (0.0021, 0.0, None)]), &[(LimitKind::Speed, 0.525)]);
    // a duration that is known comes first
    close(&untimed(Some(10.0), &[(0.0, 0.0, None), (0.05, 0.0, Some(0.2))]), &[]);
    close(&untimed(None, &[(0.0, 0.0, None), (0.05, 0.0, Some(0.08))]), &[(LimitKind::Speed, 0.625)]);
    // the program stands where it stood
    close(&untimed(None, &[(0.03, 0.03, Some(0.1)), (0.09, 0.03, Some(0.1))]), &[(LimitKind::Speed, 0.6)]);
    // nothing tells how long it takes
    close(&untimed(None, &[(0.0, 0.0, None), (0.15, 0.0, None)]), &[]);
}

#[test]
fn a_step_takes_the_time_of_half_its_acceleration_or_half_its_speed() {
    let robot = fast();
    let [x, y] = [robot.axis(0), robot.axis(1)];
    // 2 sqrt(s / (a / 2)) with 2 m/s2; s / (v / 2) with 0.5 m/s
    assert!((step_s(x, 1e-4) - 0.02).abs() < 1e-12);
    assert!((step_s(x, 1.0) - 4.0).abs() < 1e-12);
    assert_eq!(step_s(x, 1e-9), CYCLE_S);
    assert_eq!(step_s(y, 1.0), CYCLE_S);
}

#[test]
fn a_position_out_of_range_is_listed_after_any_number_of_speeds() {
    let violation = |what| Violation { origin: AT, axis: 0, what, value: 1.0, limit: 0.5 };
    let mut stats = RewriteStats::default();
    (0..150).for_each(|_| add(&mut stats, violation(LimitKind::Speed)));
    assert_eq!((stats.violations.len(), stats.violations_total, stats.out_of_range), (100, 150, 0));
    (0..150).for_each(|_| add(&mut stats, violation(LimitKind::Range)));
    assert_eq!((stats.violations.len(), stats.violations_total, stats.out_of_range), (200, 300, 150));
    assert!(stats.violations[100..].iter().all(|v| v.what == LimitKind::Range));
}
