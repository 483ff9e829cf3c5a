//! Circles made of arcs in RAPID and KRL, in several planes and sizes: rewritten, executed by an interpolation of this file alone, and
//! compared with the verdict of `rewrite`.
//!
//! The interpolation shares no code with the rewriter: centre and normal of the circle through three points, steps of a fixed angle, each
//! solved by the damped numerical inverse from the step before.

use super::cartesian_circle::{MODEL, csv, list, pose, verdict_is_that_of_the_joints};
use super::vendor_circle::robot;
use crate::support::{WorkFolder, run};
use lostmotion::program::formats::{self, Recognised};
use lostmotion::program::script::{Goal, Text};
use lostmotion::robot::{InverseOptions, Pose, Robot, Target};
use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use serde_json::Value;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;

/// Arcs of a circle.
const ARCS: usize = 8;
/// Length of a step of the interpolation, m.
const STEP_M: f64 = 0.8e-3;

/// Centre of the circle in the joints of its middle, radius, m, and the two directions of its plane.
struct Circle {
    middle_deg: [f64; 6],
    radius_m: f64,
    plane: [Vector3<f64>; 2],
    /// Where on it the first arc starts, rad: at 0 joints turn where arcs meet.
    start_rad: f64,
}

fn solved(robot: &Robot, position: Vector3<f64>, rotation: Rotation3<f64>, guess: &[f64]) -> Vec<f64> {
    let options = InverseOptions { target_error_m: 1e-12, target_error_rad: 1e-12, ..InverseOptions::default() };
    let found = robot.inverse(&Target::Pose(Pose { position, rotation }), guess, &options);
    assert!(found.error_m < 1e-9 && found.error_rad < 1e-7, "{position} is not reached");
    found.q
}

fn degrees(q: &[f64]) -> [f64; 6] {
    std::array::from_fn(|i| q[i].to_degrees())
}

impl Circle {
    /// Joints at the ends of the arcs and in the middle of each, by turns, deg: one and a half turns, so that every joint turns on the way.
    fn joints(&self, robot: &Robot) -> Vec<[f64; 6]> {
        let mut q: Vec<f64> = self.middle_deg.map(f64::to_radians).into();
        let middle = robot.forward(&q);
        let [u, v] = self.plane;
        let at = |angle: f64, radius_m: f64| middle.position + (u * angle.cos() + v * angle.sin()) * radius_m;
        for k in 1..=20 {
            q = solved(robot, at(self.start_rad, self.radius_m * f64::from(k) / 20.0), middle.rotation, &q);
        }
        let mut out = Vec::new();
        for k in 0..=3 * ARCS {
            let angle = self.start_rad + TAU * k as f64 / (2 * ARCS) as f64;
            q = solved(robot, at(angle, self.radius_m), middle.rotation, &q);
            out.push(degrees(&q));
        }
        out
    }
}

fn program(format: &str, robot: &Robot, joints: &[[f64; 6]]) -> (String, String) {
    let mut t = String::new();
    let at: Vec<_> = joints.iter().map(|q| pose(robot, q)).collect();
    if format == "krl" {
        t.push_str("&ACCESS RVP\r\nDEF arcs( )\r\n$BASE=$NULLFRAME\r\n$TOOL={X 156,Y 0,Z 63,A 0,B 0,C 0}\r\n$VEL.CP=0.0015\r\n");
        let angles: Vec<String> = joints[0].iter().enumerate().map(|(k, v)| format!("A{} {v:.6}", k + 1)).collect();
        let _ = write!(t, "PTP {{{}}}\r\n", angles.join(","));
        for pair in at[1..].chunks_exact(2) {
            let [x, y, z] = pair[0].mm;
            let [c, b, a] = pair[1].xyz_deg;
            let [ex, ey, ez] = pair[1].mm;
            let _ = write!(
                t,
                "CIRC {{X {x:.6},Y {y:.6},Z {z:.6}}},{{X {ex:.6},Y {ey:.6},Z {ez:.6},A {a:.6},B {b:.6},C {c:.6}}} C_DIS\r\n"
            );
        }
        return ("arcs.src".into(), t + "END\r\n");
    }
    t.push_str("MODULE arcs\n  PERS tooldata probe:=[TRUE,[[156,0,63],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\n  PROC main()\n");
    let _ = writeln!(
        t,
        "    MoveAbsJ [[{}],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,probe;\n    ConfL\\Off;",
        list(&joints[0], 6)
    );
    for pair in at[1..].chunks_exact(2) {
        let target = |mm: &[f64; 3]| {
            format!("[[{}],[{}],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]", list(mm, 4), list(&pair[1].quaternion, 7))
        };
        let _ = writeln!(t, "    MoveC {},{},[1.5,500,5000,1000],z0,probe;", target(&pair[0].mm), target(&pair[1].mm));
    }
    ("arcs.mod".into(), t + "  ENDPROC\nENDMODULE\n")
}

/// Places on the circle from `a` over `b` to `c`, without `a`.
fn arc(a: Vector3<f64>, b: Vector3<f64>, c: Vector3<f64>) -> Vec<(f64, Vector3<f64>)> {
    let normal = (b - a).cross(&(c - b)).normalize();
    // the centre is as far from all three, and in their plane
    let rows = nalgebra::Matrix3::from_rows(&[(b - a).transpose(), (c - a).transpose(), normal.transpose()]);
    let right = Vector3::new(
        0.5 * (b.norm_squared() - a.norm_squared()),
        0.5 * (c.norm_squared() - a.norm_squared()),
        normal.dot(&a),
    );
    let centre = rows.lu().solve(&right).unwrap();
    let (x, y) = (a - centre, normal.cross(&(a - centre)));
    let angle = (c - centre).dot(&y).atan2((c - centre).dot(&x)).rem_euclid(TAU);
    let steps = (angle * x.norm() / STEP_M).ceil();
    let at = |k: f64| {
        let (s, cos) = (angle * k / steps).sin_cos();
        (k / steps, centre + x * cos + y * s)
    };
    (1..=steps as usize).map(|k| at(k as f64)).collect()
}

/// Joints that a program runs through, deg.
fn executed(name: &str, bytes: Vec<u8>, robot: &Robot) -> Vec<[f64; 6]> {
    let Recognised::Script(format) = formats::recognise(Path::new(name), &bytes) else { panic!("{name}") };
    let document = format.parse(vec![Text::new(name, bytes)], robot.axes()).unwrap();
    let script = document.script();
    let mut q: Vec<f64> = Vec::new();
    let mut out = Vec::new();
    for (_, m) in script.moves() {
        match &m.goal {
            Goal::Joints(t) => {
                q = script.targets.get(*t).unwrap().values.iter().map(|v| v.unwrap().si).collect();
                out.push(degrees(&q));
            }
            Goal::Pose(goal) => {
                let from = robot.forward(&q);
                let [start, end] = [UnitQuaternion::from_rotation_matrix(&from.rotation), goal.rotation.unwrap()];
                for (share, position) in arc(from.position, goal.via_m.unwrap(), goal.position_m) {
                    let rotation = start.slerp(&end, share).to_rotation_matrix();
                    q = solved(robot, position, rotation, &q);
                    out.push(degrees(&q));
                }
            }
            Goal::Opaque(why) => panic!("{name}: {why}"),
        }
    }
    out
}

/// Verdict of `rewrite`, and rms and largest error before and after, um, of the executed joints.
fn outcome(format: &str, circle: &Circle) -> (String, [[f64; 2]; 2]) {
    let folder = WorkFolder::new();
    let at = folder.path();
    let arm = Robot::parse("robot.yaml", &robot()).unwrap();
    std::fs::write(at.join("robot.yaml"), robot()).unwrap();
    std::fs::write(at.join("model.yaml"), MODEL).unwrap();
    let (name, text) = program(format, &arm, &circle.joints(&arm));
    std::fs::write(at.join(&name), &text).unwrap();
    let out = format!("out-{name}");
    let json = run(at, &format!("rewrite --model model.yaml {name} --output {out} --json")).success().stdout;
    let summary: Value = serde_json::from_slice(&json).unwrap();
    for (program, path) in [(&name, "before"), (&out, "after")] {
        let joints = executed(program, std::fs::read(at.join(program)).unwrap(), &arm);
        std::fs::write(at.join(format!("{path}-program.csv")), csv(&joints)).unwrap();
    }
    verdict_is_that_of_the_joints(at, &name, &summary);
    let found = &summary["path_error"];
    let um = |key: &str| ["before", "after"].map(|side| found[key][side].as_f64().unwrap());
    (found["verdict"].as_str().unwrap().into(), [um("rms_um"), um("largest_um")])
}

const UPRIGHT: [Vector3<f64>; 2] = [Vector3::new(0.0, 1.0, 0.0), Vector3::new(0.0, 0.0, 1.0)];
const LEVEL: [Vector3<f64>; 2] = [Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 1.0, 0.0)];
const TILTED: [Vector3<f64>; 2] = [Vector3::new(0.6, 0.8, 0.0), Vector3::new(-0.48, 0.36, 0.8)];

#[test]
fn a_circle_of_arcs_that_is_rewritten_errs_less_where_it_is_executed_by_another_interpolation() {
    let middle_deg = [-14.0, -78.0, 85.0, 20.0, 45.0, -30.0];
    let circle = Circle { middle_deg, radius_m: 0.15, plane: UPRIGHT, start_rad: 0.3 };
    for format in ["krl", "rapid"] {
        let (verdict, [rms, largest]) = outcome(format, &circle);
        println!("{format}: {verdict}, rms {rms:?}, largest {largest:?}");
        assert_eq!(verdict, "better", "{format}: rms {rms:?}, largest {largest:?}");
        assert!(rms[0] > 20.0 && rms[1] < 0.5 * rms[0] && largest[1] < largest[0], "{format}: {rms:?} {largest:?}");
    }
}

#[test]
fn arcs_of_other_radii_and_planes_shrink_their_error_or_are_called_worse() {
    let near = [-14.0, -78.0, 85.0, 20.0, 45.0, -30.0];
    let beside = [35.0, -95.0, 110.0, -15.0, 60.0, 10.0];
    for (middle_deg, radius_m, plane, start_rad) in [
        (near, 0.15, UPRIGHT, 0.0),
        (near, 0.06, LEVEL, 0.3),
        (near, 0.25, TILTED, 0.0),
        (beside, 0.1, UPRIGHT, 0.0),
        (beside, 0.2, LEVEL, 0.3),
        (beside, 0.03, TILTED, 0.0),
    ] {
        let circle = Circle { middle_deg, radius_m, plane, start_rad };
        for format in ["krl", "rapid"] {
            let (verdict, [rms, largest]) = outcome(format, &circle);
            println!("{format}, {radius_m} m: {verdict}, rms {rms:?}, largest {largest:?}");
            let grows = largest[1] > 1.01 * largest[0] + 0.5;
            assert!(rms[1] < rms[0], "{format}, {radius_m} m: rms {rms:?}");
            assert!(!grows || verdict == "worse", "{format}, {radius_m} m: {verdict}, largest {largest:?}");
        }
    }
}
