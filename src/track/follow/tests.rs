use super::*;
use crate::io::input::from_bytes;
use nalgebra::Vector3;

/// Two links in a plane, 300 and 200 mm.
fn arm(extra: &str) -> Robot {
    let text = format!(
        "schema: lostmotion/robot/1\njoints:\n  - {{name: A1, kind: revolute, a_mm: 300, limits_deg: [-170, 170]{extra}}}\n  - {{name: A2, kind: revolute, a_mm: 200, limits_deg: [5, 150]{extra}}}\n"
    );
    Robot::parse("robot.yaml", &text).unwrap()
}

fn path(rows: &str) -> Path {
    Path::parse(from_bytes("path.csv".into(), format!("t_s,x_mm,y_mm\n{rows}").into()).unwrap()).unwrap()
}

fn line(from: [f64; 2], to: [f64; 2], points: usize) -> Path {
    let row = |k: usize| {
        let s = k as f64 / (points - 1) as f64;
        format!("{k},{},{}\n", from[0] + s * (to[0] - from[0]), from[1] + s * (to[1] - from[1]))
    };
    path(&(0..points).map(row).collect::<String>())
}

fn run(robot: &Robot, path: &Path, method: Method) -> Tracked {
    let options = Options { method, start: Some(vec![0.1, 1.0]), ..Options::default() };
    let k = Kinematics::nominal(robot, &path.coordinates);
    follow(robot, &k, path, path.t_s.as_ref().unwrap(), &options).unwrap()
}

/// The elbow-down solution in closed form.
fn closed_form(x: f64, y: f64) -> [f64; 2] {
    let (a, b) = (0.3, 0.2);
    let c = (x * x + y * y - a * a - b * b) / (2.0 * a * b);
    let q2 = c.acos();
    [y.atan2(x) - (b * q2.sin()).atan2(a + b * q2.cos()), q2]
}

#[test]
fn both_methods_give_the_joints_of_the_closed_form() {
    let robot = arm("");
    let path = line([400.0, -100.0], [150.0, 250.0], 200);
    for method in [Method::Qp, Method::Inverse] {
        let tracked = run(&robot, &path, method);
        assert!(tracked.misses.is_empty(), "{method:?}: {:?}", tracked.misses.first());
        let allowed = if method == Method::Qp { 2e-5 } else { 1e-7 };
        for (q, p) in tracked.q.iter().zip(&path.points_m) {
            let truth = closed_form(p[0], p[1]);
            let apart = q.iter().zip(truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < allowed, "{method:?} at {p:?}: {q:?} {truth:?}");
        }
    }
}

#[test]
fn no_joint_leaves_its_range_or_is_faster_than_it_can_be_and_the_points_missed_are_named() {
    for (extra, what) in [(", max_speed_deg_s: 2", Bound::Speed), ("", Bound::Range)] {
        let robot = arm(extra);
        let path = line([400.0, -100.0], [560.0, 0.0], 30);
        for method in [Method::Qp, Method::Inverse] {
            let tracked = run(&robot, &path, method);
            for (i, q) in tracked.q.iter().enumerate() {
                for (a, (joint, &v)) in robot.axis_joints().zip(q).enumerate() {
                    let [lo, hi] = joint.limits.unwrap();
                    assert!(v >= lo && v <= hi, "{method:?} point {i}");
                    if i > 0 && what == Bound::Speed {
                        let speed = (v - tracked.q[i - 1][a]) / (tracked.t_s[i] - tracked.t_s[i - 1]);
                        assert!(speed.abs() <= 2f64.to_radians() * (1.0 + 1e-9), "{method:?} point {i}: {speed}");
                    }
                }
            }
            let held: Vec<(usize, Bound)> = tracked.misses.iter().flat_map(|m| m.held.clone()).collect();
            assert!(held.contains(&(1, what)), "{method:?}: {held:?}");
            assert!(tracked.misses.iter().all(|m| m.distance_m > 1e-4));
        }
    }
}

#[test]
fn a_free_coordinate_leaves_the_smallest_move_to_the_joints() {
    let text = "schema: lostmotion/robot/1\njoints:\n  - {name: X, kind: prismatic, theta_deg: 0, alpha_deg: 90}\n  - {name: Z, kind: prismatic}\n";
    let robot = Robot::parse("robot.yaml", text).unwrap();
    // X slides along z, Z along -y: a path in z moves X alone
    let path = Path::parse(from_bytes("p.csv".into(), "t_s,z_mm\n0,0\n1,10\n".into()).unwrap()).unwrap();
    let k = Kinematics::nominal(&robot, &path.coordinates);
    let tracked = follow(&robot, &k, &path, &[0.0, 1.0], &Options::default()).unwrap();
    assert!((robot.tcp_m(&tracked.q[1]) - Vector3::new(0.0, 0.0, 0.01)).norm() < 1e-8);
    assert!(tracked.q[1][1].abs() < 1e-12);
}

#[test]
fn a_sharp_corner_is_too_fast_for_a_joint_with_a_limited_acceleration() {
    let robot = arm(", max_accel_deg_s2: 10");
    let corner = path("0,400,0\n0.1,400,5\n0.2,400,10\n0.3,395,10\n0.4,390,10\n");
    let tracked = run(&robot, &corner, Method::Inverse);
    assert!(tracked.too_fast.iter().any(|f| f.point == 2), "{:?}", tracked.too_fast);
    let straight = line([400.0, 0.0], [400.0, 10.0], 20);
    assert!(run(&robot, &straight, Method::Inverse).too_fast.is_empty());
}

#[test]
fn a_start_outside_the_limits_is_refused() {
    let robot = arm("");
    let path = line([400.0, 0.0], [400.0, 10.0], 2);
    let k = Kinematics::nominal(&robot, &path.coordinates);
    let options = Options { start: Some(vec![0.0, 0.0]), ..Options::default() };
    let e = follow(&robot, &k, &path, &[0.0, 1.0], &options).unwrap_err().to_string();
    assert!(e.contains("A2 at 0 deg"), "{e}");
}
