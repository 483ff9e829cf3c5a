//! Joints that turn shortly before the end of a straight move or an arc: their goals have the offset of the side after the turn.
//!
//! The programs are by kinematics of a UR10 written apart from this crate: in the straight one the shoulder turns 10 mm before the end and
//! goes back by 0.0136 deg.

use crate::support::bundled;
use crate::vendor_rewrite::Desk;

const STRAIGHT: &str = "def prog():\n  set_tcp(p[0, 0, 0.1, 0, 0, 0])\n\
  movej([-0.097697455, -1.871251101, 1.170351035, -1.831767005, -1.848244360, 0.059988770])\n\
  movej([-0.147697455, -1.921251101, 1.120351035, -1.881767005, -1.898244360, 0.009988770])\n\
  movel(p[-0.436555853, 0.126093588, 1.075409127, -1.688713393, -1.165934035, 0.578699554], a=0.5, v=0.1)\n  textmsg(\"k1\")\nend\n";

#[test]
fn a_turn_in_the_last_part_of_a_straight_move_is_found() {
    let desk = Desk::new(0.0);
    std::fs::copy(bundled("configs/universal-robots-ur10.yaml"), desk.path("robot.yaml")).unwrap();
    let joints = ["base", "shoulder", "elbow", "wrist1", "wrist2", "wrist3"];
    let effects: String =
        joints.iter().map(|j| format!("  - {{effect: backlash, joint: {j}, half_gap_deg: 0.004}}\n")).collect();
    desk.write("model.yaml", &format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{effects}"));
    desk.write("p.script", STRAIGHT);
    for options in ["", " --max-added 0"] {
        let run = desk
            .run(&format!("rewrite --model model.yaml p.script --output o.script --replace --force --json{options}"))
            .success();
        let doc: serde_json::Value = serde_json::from_slice(&run.get_output().stdout).unwrap();
        let shoulder = doc["joints"].as_array().unwrap().iter().find(|a| a["joint"] == "shoulder").unwrap();
        assert_eq!(shoulder["reversals"], 1, "{doc}");
        let of = |side: &str| doc["path_error"]["at_targets"]["largest_um"][side].as_f64().unwrap();
        assert!(of("before") > 50.0 && of("after") < 0.1 * of("before"), "{options}: {doc}");
    }
}
