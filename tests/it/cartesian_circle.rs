//! One circle as Cartesian programs in five languages: written, rewritten, executed on the machine, against what the CSV program
//! gains.
//!
//! The circle has a radius of 150 mm and one orientation, away from the wrist's singularity, in which the bundled one lies. It is
//! executed by a small interpreter that shares no code with the rewriter's kinematics: straight segments of the TCP, position and
//! rotation interpolated, each point solved by the damped numerical inverse from the point before; what comes out is a joint program for
//! `simulate`.

use super::vendor_circle::robot;
use crate::support::{self, WorkFolder, run};
use lostmotion::program::formats::{self, Recognised};
use lostmotion::program::script::{Goal, Text};
use lostmotion::robot::{InverseOptions, Pose, Robot, Target};
use nalgebra::{Isometry3, Rotation3, UnitQuaternion};
use serde_json::Value;
use std::fmt::Write;
use std::path::Path;

pub const MODEL: &str = "schema: lostmotion/model/1
robot: robot.yaml
effects:
  - {effect: backlash, joint: A1, half_gap_deg: 0.0028}
  - {effect: backlash, joint: A2, half_gap_deg: 0.0037}
  - {effect: backlash, joint: A3, half_gap_deg: 0.0022}
";
pub const FRAMES: &str = "schema: lostmotion/frames/1
tools: {\"1\": {xyz_mm: [156, 0, 63], rpy_deg: [0, 0, 0]}}
";

/// TCP pose in mm and degrees about fixed X, Y, Z (KUKA's C, B, A), and as quaternion and rotation vector.
pub struct Written {
    pub mm: [f64; 3],
    pub xyz_deg: [f64; 3],
    pub quaternion: [f64; 4],
    pub vector: [f64; 3],
}

pub fn pose(robot: &Robot, q_deg: &[f64; 6]) -> Written {
    let is = robot.forward(&q_deg.map(f64::to_radians));
    let turn = UnitQuaternion::from_rotation_matrix(&is.rotation);
    let (a, b, c) = turn.euler_angles();
    let q = turn.quaternion();
    Written {
        mm: (is.position * 1e3).into(),
        xyz_deg: [a, b, c].map(f64::to_degrees),
        quaternion: [q.w, q.i, q.j, q.k],
        vector: turn.scaled_axis().into(),
    }
}

pub fn list(values: &[f64], decimals: usize) -> String {
    values.iter().map(|v| format!("{v:.decimals$}")).collect::<Vec<_>>().join(",")
}

/// Joints of the circle, deg: by the damped numerical inverse from point to point.
pub fn circle(robot: &Robot) -> Vec<[f64; 6]> {
    const POINTS: usize = 200;
    let mut q: Vec<f64> = [-14.0, -78.0, 85.0, 20.0, 45.0, -30.0].map(f64::to_radians).into();
    let middle = robot.forward(&q);
    let options = InverseOptions { target_error_m: 1e-12, target_error_rad: 1e-12, ..InverseOptions::default() };
    // the first point is reached in steps, then the circle is closed
    let radius = |k: usize| if k < 20 { 0.15 * k as f64 / 20.0 } else { 0.15 };
    let turn = |k: usize| if k < 20 { 0.0 } else { std::f64::consts::TAU * (k - 20) as f64 / POINTS as f64 };
    let mut points = Vec::new();
    for k in 0..=POINTS + 20 {
        let (s, c) = turn(k).sin_cos();
        let position = middle.position + nalgebra::Vector3::new(0.0, c, s) * radius(k);
        let found = robot.inverse(&Target::Pose(Pose { position, ..middle }), &q, &options);
        assert!(found.error_m < 1e-9 && found.error_rad < 1e-7, "point {k}");
        q = found.q;
        if k >= 20 {
            points.push(std::array::from_fn(|i| q[i].to_degrees()));
        }
    }
    points
}

/// The circle as straight moves to Cartesian targets.
pub fn written(format: &str, robot: &Robot, points: &[[f64; 6]]) -> (String, String) {
    let poses: Vec<Written> = points.iter().map(|q| pose(robot, q)).collect();
    let n = poses.len();
    let mut t = String::new();
    let name = match format {
        "krl" => {
            t.push_str("&ACCESS RVP\r\nDEF circle( )\r\n$BASE=$NULLFRAME\r\n$TOOL={X 156,Y 0,Z 63,A 0,B 0,C 0}\r\n$VEL.CP=0.0015\r\n");
            for (k, p) in poses.iter().enumerate() {
                let [c, b, a] = p.xyz_deg;
                let at = format!("X {:.6},Y {:.6},Z {:.6},A {a:.6},B {b:.6},C {c:.6}", p.mm[0], p.mm[1], p.mm[2]);
                let turn: u8 = points[k].iter().enumerate().map(|(i, v)| u8::from(*v < 0.0) << i).sum();
                let status = 2 + 4 * u8::from(points[k][4] < 0.0);
                let word = if k == 0 { "PTP" } else { "LIN" };
                let tail = if k == 0 { "" } else { " C_DIS" };
                let _ = write!(t, "{word} {{{at},S {status},T {turn}}}{tail}\r\n");
            }
            t.push_str("END\r\n");
            "circle.src"
        }
        "rapid" => {
            t.push_str("MODULE circle\n  PERS tooldata probe:=[TRUE,[[156,0,63],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\n  PROC main()\n");
            for (q, p) in points.iter().zip(&poses) {
                let quarters: Vec<i64> = [q[0], q[3], q[5]].map(|v| (v / 90.0).floor() as i64).into();
                let cfx = i64::from(q[4] < 0.0);
                let _ = writeln!(
                    t,
                    "    MoveL [[{}],[{}],[{},{},{},{cfx}],[9E9,9E9,9E9,9E9,9E9,9E9]], [1.5,500,5000,1000], z0, probe;",
                    list(&p.mm, 4),
                    list(&p.quaternion, 7),
                    quarters[0],
                    quarters[1],
                    quarters[2]
                );
            }
            t.push_str("  ENDPROC\nENDMODULE\n");
            "circle.mod"
        }
        "fanuc" => {
            let _ = write!(t, "/PROG  CIRCLE\n/ATTR\nLINE_COUNT\t= {n};\n/MN\n");
            for k in 1..=n {
                let _ = writeln!(t, "{k:4}:L P[{k}] 2mm/sec CNT100    ;");
            }
            t.push_str("/POS\n");
            for (k, (q, p)) in points.iter().zip(&poses).enumerate() {
                let wrist = if q[4] > 0.0 { 'F' } else { 'N' };
                let mm = |i: usize| format!("{} = {:>9.3}  mm", ["X", "Y", "Z"][i], p.mm[i]);
                let deg = |i: usize| format!("{} = {:>9.3} deg", ["W", "P", "R"][i], p.xyz_deg[i]);
                let rows = [[mm(0), mm(1), mm(2)].join(",\t"), [deg(0), deg(1), deg(2)].join(",\t")];
                let _ = write!(
                    t,
                    "P[{}]{{\n   GP1:\n\tUF : 0, UT : 1,\t\tCONFIG : '{wrist} U T, 0, 0, 0',\n\t{},\n\t{}\n}};\n",
                    k + 1,
                    rows[0],
                    rows[1]
                );
            }
            t.push_str("/END\n");
            "circle.ls"
        }
        "urscript" => {
            t.push_str("def circle():\n  set_tcp(p[0.156, 0, 0.063, 0, 0, 0])\n");
            let _ = writeln!(t, "  movej([{}], a=1.4, v=1.05)", list(&points[0].map(f64::to_radians), 9));
            for p in &poses {
                let m = p.mm.map(|v| v * 1e-3);
                let _ = writeln!(t, "  movel(p[{},{}], a=1.2, v=0.0015, r=0.0001)", list(&m, 8), list(&p.vector, 8));
            }
            t.push_str("end\n");
            "circle.script"
        }
        _ => {
            let _ = write!(t, "/JOB\r\n//NAME CIRCLE\r\n//POS\r\n///NPOS {n},0,0,0,0,0\r\n///TOOL 1\r\n");
            t.push_str("///POSTYPE ROBOT\r\n///RECTAN\r\n///RCONF 0,0,0,0,0,0,0,0\r\n");
            for (k, p) in poses.iter().enumerate() {
                let _ = write!(t, "C{k:05}={},{}\r\n", list(&p.mm, 3), list(&p.xyz_deg, 4));
            }
            t.push_str("//INST\r\n///DATE 2020/01/01 00:00\r\n///ATTR SC,RW\r\n///GROUP1 RB1\r\nNOP\r\n");
            for k in 0..n {
                let _ = write!(t, "MOVL C{k:05} V=1.5 \r\n");
            }
            t.push_str("END\r\n");
            "circle.JBI"
        }
    };
    (name.into(), t)
}

/// Sub-points of a straight segment.
const PARTS: usize = 6;

/// Runs the straight moves of a program: joints in degrees along the path.
fn executed(name: &str, bytes: Vec<u8>, robot: &Robot, first: &[f64; 6]) -> Vec<[f64; 6]> {
    let Recognised::Script(format) = formats::recognise(Path::new(name), &bytes) else { panic!("{name}") };
    let document = format.parse(vec![Text::new(name, bytes)], robot.axes()).unwrap();
    let poses: Vec<Isometry3<f64>> = document
        .script()
        .moves()
        .filter_map(|(_, m)| if let Goal::Pose(p) = &m.goal { p.pose() } else { None })
        .collect();
    let mut q: Vec<f64> = first.map(f64::to_radians).into();
    let mut out = Vec::new();
    let options = InverseOptions { target_error_m: 1e-12, target_error_rad: 1e-12, ..InverseOptions::default() };
    for (k, to) in poses.iter().enumerate() {
        let from = if k == 0 { to } else { &poses[k - 1] };
        let parts = if k == 0 { 1 } else { PARTS };
        for part in 1..=parts {
            let share = part as f64 / parts as f64;
            let turn = from.rotation.slerp(&to.rotation, share);
            let position = from.translation.vector.lerp(&to.translation.vector, share);
            let rotation: Rotation3<f64> = turn.to_rotation_matrix();
            let found = robot.inverse(&Target::Pose(Pose { position, rotation }), &q, &options);
            assert!(found.error_m < 1e-9 && found.error_rad < 1e-7, "{name}, segment {k}");
            q = found.q;
            out.push(std::array::from_fn(|i| q[i].to_degrees()));
        }
    }
    out
}

pub fn csv(points: &[[f64; 6]]) -> String {
    let rows = points.iter().map(|q| list(q, 9) + "\n");
    std::iter::once("a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n".to_string()).chain(rows).collect()
}

/// The verdict of `rewrite` on Cartesian targets is that of `assess program` on what this file's own interpreter makes of both programs.
pub fn verdict_is_that_of_the_joints(folder: &Path, what: &str, summary: &Value) {
    let line = "assess program --model model.yaml --before before-program.csv --after after-program.csv --speed-mm-s 1.5 --json";
    let out = support::run(folder, line);
    let joints: Value = serde_json::from_slice(&out.stdout).unwrap();
    let own = &summary["path_error"];
    assert_eq!(own["verdict"], joints["verdict"], "{what}: {own} and {joints}");
    for key in ["rms_um", "largest_um"] {
        for side in ["before", "after"] {
            let [a, b] = [own, &joints].map(|d| d[key][side].as_f64().unwrap());
            // both follow the path within half a micrometre, and their rows stand elsewhere on the steps
            assert!((a - b).abs() < 0.6 + 0.03 * b, "{what}: {key} {side} {a}, {b} by its joints");
        }
    }
}

/// Largest error beyond the circle at each reversal, um, without and with compensation; and the summary of the rewrite.
fn errors(format: &str) -> (Vec<[f64; 2]>, Value) {
    let folder = WorkFolder::new();
    let at = folder.path();
    let arm = Robot::parse("robot.yaml", &robot()).unwrap();
    let points = circle(&arm);
    std::fs::write(at.join("robot.yaml"), super::vendor_circle::robot()).unwrap();
    std::fs::write(at.join("model.yaml"), MODEL).unwrap();
    std::fs::write(at.join("frames.yaml"), FRAMES).unwrap();
    let (name, text) = written(format, &arm, &points);
    std::fs::write(at.join(&name), &text).unwrap();
    let out = format!("out-{name}");
    let json = run(at, &format!("rewrite --model model.yaml --frames frames.yaml {name} --output {out} --json"))
        .success()
        .stdout;
    let summary: Value = serde_json::from_slice(&json).unwrap();
    for (program, path) in [(&name, "before"), (&out, "after")] {
        let joints = executed(program, std::fs::read(at.join(program)).unwrap(), &arm, &points[0]);
        std::fs::write(at.join(format!("{path}-program.csv")), csv(&joints)).unwrap();
        run(
            at,
            &format!("simulate --model model.yaml --input {path}-program.csv --output {path}.csv --speed-mm-s 1.5"),
        )
        .success();
    }
    verdict_is_that_of_the_joints(at, format, &summary);
    let json = run(
        at,
        "assess circle --robot robot.yaml --nominal before-program.csv --before before.csv --after after.csv --json",
    )
    .success()
    .stdout;
    let found: Value = serde_json::from_slice(&json).unwrap();
    let totals = |which: &str| -> Vec<f64> {
        let list = found[which]["reversals"].as_array().unwrap();
        list.iter().map(|r| r["beyond_nominal_um"].as_f64().unwrap()).collect()
    };
    (totals("before").into_iter().zip(totals("after")).map(|(a, b)| [a, b]).collect(), summary)
}

#[test]
fn cartesian_programs_of_every_language_take_out_what_a_joint_program_takes_out() {
    for format in ["krl", "rapid", "urscript", "fanuc", "inform"] {
        let (found, summary) = errors(format);
        println!("{format}: {found:?}");
        assert!(summary["edited_as_poses"].as_u64().unwrap() > 100, "{format}: {summary}");
        let moves = &summary["path_error"]["moves"];
        let count = |key: &str| moves[key].as_u64().unwrap();
        assert_eq!((count("from_unknown_place"), count("to_unknown_place")), (1, 0), "{format}: {moves}");
        assert_eq!(count("in_verdict") + 1, count("all"), "{format}: {moves}");
        assert_eq!(summary["path_error"]["verdict"], "better", "{format}: {summary}");
        assert!(found.len() >= 4, "{format}: {found:?}");
        let worst = |k: usize| found.iter().map(|e| e[k]).fold(0.0, f64::max);
        // most of it goes; what is left are the steps' ramps and the digits of the language
        assert!(worst(0) > 60.0 && worst(1) < 0.5 * worst(0), "{format}: {found:?}");
    }
}
