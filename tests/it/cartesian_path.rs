//! Programs with Cartesian targets as paths: what is known of them, where they go, and where they stop.

use super::cartesian_circle::{MODEL, circle, written};
use super::vendor_circle::robot;
use crate::support::{WorkFolder, run};
use lostmotion::io::input;
use lostmotion::program::Program;
use lostmotion::rewrite::script::path::Reading;
use lostmotion::robot::Robot;
use lostmotion::robot::frames::Frames;
use serde_json::Value;

const TOOLS: &str = "schema: lostmotion/frames/1\ntools: {\"1\": {xyz_mm: [156, 0, 63], rpy_deg: [0, 0, 0]}}\n";

fn read(name: &str, text: &str) -> Program {
    let arm = Robot::parse("robot.yaml", &robot()).unwrap();
    let frames = Frames::parse("frames.yaml", TOOLS).unwrap();
    let reading = Reading { robot: &arm, frames: &frames, tcp_speed_m_s: Some(0.01), format: None };
    let folder = WorkFolder::new();
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    reading.load(&path, input::read(&path).unwrap()).unwrap()
}

#[test]
fn the_path_of_straight_moves_is_the_chord_between_their_poses_in_every_language() {
    let arm = Robot::parse("robot.yaml", &robot()).unwrap();
    let joints = circle(&arm);
    let corners: Vec<_> = joints.iter().map(|q| arm.tcp_m(&q.map(f64::to_radians))).collect();
    for format in ["krl", "rapid", "urscript", "fanuc", "inform"] {
        let (name, text) = written(format, &arm, &joints);
        let path = read(&name, &text);
        let told = path.script.as_ref().unwrap();
        assert!(told.starts.is_empty() && told.moves.known + 1 == told.moves.all, "{format}: {told:?}");
        // every point lies on the nearest chord, within the digits of the language and what lies between two solved places
        let mut q = vec![0.0; 6];
        let mut most = 0.0f64;
        for i in 0..path.len() {
            path.point_into(i, &mut q);
            let at = arm.tcp_m(&q);
            let off = |w: &[nalgebra::Vector3<f64>]| {
                let along = w[1] - w[0];
                let share = ((at - w[0]).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
                (at - w[0] - along * share).norm()
            };
            most = most.max(corners.windows(2).map(off).fold(f64::INFINITY, f64::min));
        }
        assert!(most < 1.5e-6, "{format}: {most} m off");
        assert!(path.len() > 3 * joints.len(), "{format}: {} points", path.len());
    }
}

#[test]
fn moves_to_and_from_unknown_places_are_left_out_and_counted() {
    // BASE_DATA[3] is not known: two moves; the one after them starts where nobody knows, and names its joints by S and T
    let text = "DEF p( )\r\n$TOOL={X 156,Y 0,Z 63,A 0,B 0,C 0}\r\n$BASE=$NULLFRAME\r\n$VEL.CP=0.01\r\n\
        PTP {A1 0,A2 -90,A3 90,A4 10,A5 45,A6 0}\r\nLIN_REL {Z 5}\r\nPTP {A1 5,A2 -90,A3 90,A4 10,A5 45,A6 0}\r\n\
        PTP {A1 0,A2 -90,A3 95,A4 10,A5 45,A6 0}\r\nBAS(#BASE,3)\r\nLIN {X 10,Y 0,Z 0,A 0,B 90,C 0}\r\n\
        LIN {X 20,Y 0,Z 0,A 0,B 90,C 0}\r\n$BASE=$NULLFRAME\r\nPTP {A1 0,A2 -90,A3 90,A4 10,A5 45,A6 0}\r\n\
        PTP {A1 9,A2 -90,A3 90,A4 10,A5 45,A6 0}\r\nEND\r\n";
    let path = read("p.src", text);
    let told = path.script.unwrap();
    let m = told.moves;
    // known: the ways 3 -> 4 and 7 -> 8; from unknown places: 1, 3, 7
    assert_eq!((m.all, m.known, m.unknown_start), (8, 2, 3), "{told:?}");
    assert_eq!(told.starts, [1, 3], "{told:?}");
    assert_eq!(path.q[0].iter().map(|v| v.to_degrees().round()).collect::<Vec<_>>(), [0.0, 5.0, 0.0, 0.0, 9.0]);
}

#[test]
fn stops_are_those_of_each_language_and_not_repeated_points() {
    let krl = "DEF p( )\r\n$TOOL={X 156,Y 0,Z 63,A 0,B 0,C 0}\r\n$BASE=$NULLFRAME\r\nPTP {A1 0,A2 -90,A3 90,A4 10,A5 45,A6 0}\r\n\
        LIN {X 1500,Y 0,Z 1500,A 0,B 90,C 0} C_DIS\r\nPTP {A1 1,A2 -90,A3 90,A4 10,A5 45,A6 0} C_PTP\r\nPTP {A1 1,A2 -90,A3 90,A4 10,A5 45,A6 0}\r\nEND\r\n";
    let joints = "[9E9,9E9,9E9,9E9,9E9,9E9]";
    let rapid = format!(
        "MODULE m\nPROC main()\nMoveAbsJ [[0,-90,90,10,45,0],{joints}],v100,fine,tool0;\nMoveAbsJ [[1,-90,90,10,45,0],{joints}],v100,z10,tool0;\n\
         MoveAbsJ [[2,-90,90,10,45,0],{joints}],v100,z0,tool0;\nENDPROC\nENDMODULE\n"
    );
    let point = |n: usize| {
        format!(
            "P[{n}]{{\n   GP1:\n\tUF : 0, UT : 1,\t\n\tJ1=     {n}.000 deg,\tJ2=   -90.000 deg,\tJ3=    90.000 deg,\n\tJ4=    10.000 deg,\tJ5=    45.000 deg,\tJ6=     0.000 deg\n}};\n"
        )
    };
    let fanuc = format!(
        "/PROG  P\n/ATTR\nLINE_COUNT\t= 3;\n/MN\n   1:J P[1] 10% FINE    ;\n   2:J P[2] 10% CNT50    ;\n   3:J P[3] 10% FINE    ;\n/POS\n{}{}{}/END\n",
        point(1),
        point(2),
        point(3)
    );
    let inform = "/JOB\r\n//NAME P\r\n//POS\r\n///NPOS 3,0,0,0,0,0\r\n///TOOL 1\r\n///POSTYPE ANGLE\r\n///ANGLE\r\nC00000=0.0000,-90.0000,90.0000,10.0000,45.0000,0.0000\r\n\
        C00001=1.0000,-90.0000,90.0000,10.0000,45.0000,0.0000\r\nC00002=2.0000,-90.0000,90.0000,10.0000,45.0000,0.0000\r\n//INST\r\n///DATE 2020/01/01 00:00\r\n///ATTR SC,RW\r\n\
        ///GROUP1 RB1\r\nNOP\r\nMOVJ C00000 VJ=5.00 PL=0\r\nMOVJ C00001 VJ=5.00 PL=2\r\nMOVJ C00002 VJ=5.00\r\nEND\r\n";
    let script = "def p():\n  movej([0,-1,1,0.1,0.5,0], a=1, v=1)\n  movej([0.1,-1,1,0.1,0.5,0], a=1, v=1, r=0.01)\n  movej([0.2,-1,1,0.1,0.5,0], a=1, v=1)\nend\n";
    for (name, text, stops) in
        [("p.src", krl, 2), ("p.mod", &rapid, 1), ("p.ls", &fanuc, 2), ("P.JBI", inform, 1), ("p.script", script, 2)]
    {
        assert_eq!(read(name, text).script.unwrap().exact_stops, stops, "{name}");
    }
}

#[test]
fn simulate_show_and_assess_take_a_program_with_cartesian_targets() {
    let folder = WorkFolder::new();
    let at = folder.path();
    let arm = Robot::parse("robot.yaml", &robot()).unwrap();
    std::fs::write(at.join("robot.yaml"), robot()).unwrap();
    std::fs::write(at.join("model.yaml"), MODEL).unwrap();
    std::fs::write(at.join("frames.yaml"), TOOLS).unwrap();
    let joints = circle(&arm);
    let (name, text) = written("fanuc", &arm, &joints);
    std::fs::write(at.join(&name), &text).unwrap();
    run(at, &format!("simulate --robot robot.yaml --input {name} --output log.csv --frames frames.yaml --rate-hz 2"))
        .success();
    // a robot without errors: the log lies on the circle of 150 mm, within the sagitta of its chords
    let log = std::fs::read_to_string(at.join("log.csv")).unwrap();
    let rows: Vec<Vec<f64>> = (log.lines().filter(|l| !l.starts_with('#')).skip(1))
        .map(|l| l.split(',').map(|v| v.parse().unwrap()).collect())
        .collect();
    let middle = arm.tcp_m(&[-14.0f64, -78.0, 85.0, 20.0, 45.0, -30.0].map(f64::to_radians)) * 1e3;
    let radii = rows.iter().map(|r| (r[r.len() - 2] - middle.y).hypot(r[r.len() - 1] - middle.z));
    let [least, most] = radii.fold([f64::MAX, f64::MIN], |[l, m], r| [l.min(r), m.max(r)]);
    assert!(rows.len() > 500 && (most - 150.0).abs() < 2e-3 && (150.0 - least - 0.0185).abs() < 3e-3, "{least} {most}");
    run(at, &format!("show {name} --robot robot.yaml --frames frames.yaml --output page.html")).success();
    assert!(std::fs::read_to_string(at.join("page.html")).unwrap().contains("Path of the TCP"));
    let line = format!("rewrite --model model.yaml --frames frames.yaml {name} --output out.ls --json");
    let own: Value = run(at, &line).success().json();
    let line = format!("assess program --model model.yaml --frames frames.yaml --before {name} --after out.ls --json");
    let same: Value = run(at, &line).success().json();
    for key in ["verdict", "rms_um", "largest_um", "stops", "moves", "cycle_time_s"] {
        assert_eq!(own["path_error"][key], same[key], "{key}");
    }
    // without its tool nothing of it is known
    let line = format!("assess program --model model.yaml --before {name} --after out.ls");
    let refused = run(at, &line).ends_with(2);
    assert!(refused.stderr.contains("tool `1`"), "{refused:?}");
}
