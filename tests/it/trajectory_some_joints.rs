//! Trajectories that command some of the robot's joints: their splines turn between points as those of all joints do.

use crate::support::{WorkFolder, bundled};
use serde_json::{Value, json};

const NAMES: [&str; 6] = ["A1", "A2", "A3", "A4", "A5", "A6"];

/// Four points of cubics on which A1 and A2 turn between the points and the other joints rest.
fn program(joints: usize) -> Value {
    let points =
        [([0.1, -1.4], [0.1, 0.1]), ([0.3, -1.3], [0.1, 0.1]), ([0.2, -1.4], [-0.1, 0.0]), ([0.2, -1.1], [0.0, 0.0])];
    let rest = [1.6, 0.0, 0.5, 0.0];
    let of = |(k, (q, v)): (usize, &([f64; 2], [f64; 2]))| {
        let positions: Vec<f64> = q.iter().chain(&rest).copied().take(joints).collect();
        let velocities: Vec<f64> = v.iter().copied().chain([0.0; 4]).take(joints).collect();
        json!({"positions": positions, "velocities": velocities, "time_from_start": {"sec": k, "nanosec": 0}})
    };
    let points: Vec<Value> = points.iter().enumerate().map(of).collect();
    json!({"joint_names": NAMES[..joints], "points": points})
}

/// Times and positions of A1 and A2 of the rewritten program.
fn rewritten(joints: usize) -> Vec<(i64, f64, f64)> {
    let desk = WorkFolder::new();
    std::fs::copy(bundled("configs/kuka-kr120-r2500-pro.yaml"), desk.join("robot.yaml")).unwrap();
    let gaps = ["A1", "A2"].map(|j| format!("  - {{effect: backlash, joint: {j}, half_gap_deg: 0.05}}\n")).concat();
    let model = format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{gaps}");
    std::fs::write(desk.join("model.yaml"), model).unwrap();
    std::fs::write(desk.join("p.json"), serde_json::to_string_pretty(&program(joints)).unwrap()).unwrap();
    desk.run("rewrite --model model.yaml p.json --output out.json").success();
    let out: Value = serde_json::from_slice(&std::fs::read(desk.join("out.json")).unwrap()).unwrap();
    let of = |p: &Value| {
        let (q, t) = (&p["positions"], &p["time_from_start"]);
        let ns = t["sec"].as_i64().unwrap() * 1_000_000_000 + t["nanosec"].as_i64().unwrap();
        (ns, q[0].as_f64().unwrap(), q[1].as_f64().unwrap())
    };
    out["points"].as_array().unwrap().iter().map(of).collect()
}

#[test]
fn joints_that_are_not_commanded_hide_no_turn_of_the_others() {
    let all = rewritten(6);
    // A1 turns at 1.14 and 2.33 s, A2 at 1.4 s or so: a turn and a step for each beside the four points
    assert!(all.len() > 7, "{all:?}");
    assert_eq!(rewritten(2), all);
    assert_eq!(rewritten(5), all);
}
