//! Moves that lead to where the robot stands, after a place from which it is not known how it came there.

use crate::support::bundled;
use crate::vendor_rewrite::Desk;

/// A desk for a robot with gaps on all of its joints.
fn desk(robot: &str, joint: char) -> Desk {
    let desk = Desk::new(0.0);
    std::fs::copy(bundled("configs").join(robot), desk.path("robot.yaml")).unwrap();
    let gaps: String =
        (1..=6).map(|k| format!("  - {{effect: backlash, joint: {joint}{k}, half_gap_deg: 0.05}}\n")).collect();
    desk.write("model.yaml", &format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{gaps}"));
    let null = "{xyz_mm: [0, 0, 0]}";
    desk.write(
        "frames.yaml",
        &format!("schema: lostmotion/frames/1\nframes: {{$BASE: {null}}}\ntools: {{$TOOL: {null}, \"1\": {null}}}\n"),
    );
    desk
}

/// What is written.
fn rewritten(desk: &Desk, name: &str, text: &str) -> String {
    desk.write(name, text);
    desk.run(&format!("rewrite --model model.yaml {name} --frames frames.yaml --output out-{name} --force")).success();
    String::from_utf8(desk.read(&format!("out-{name}"))).unwrap()
}

/// The same pose once and once more: the robot does not move, and from which side its joints stand there is still not known.
#[test]
fn a_straight_move_to_where_the_robot_stands_tells_no_side() {
    let desk = desk("kuka-kr120-r2500-pro.yaml", 'A');
    let here = "{X 1703.4061,Y 17.2810,Z 1528.5687,A -140.2765,B 37.6603,C -141.7458";
    let next = "LIN {X 1737.3531,Y -66.5162,Z 1420.7442,A -143.5483,B 35.2678,C -144.9614}";
    for again in 1..4 {
        let line = format!("LIN {here}}}\n");
        let lines = line.repeat(again);
        let text = format!("DEF a()\nSUB()\nPTP {here},S 2,T 3}}\nWAIT SEC 1\n{lines}{next}\nEND\n");
        let out = rewritten(&desk, "a.src", &text);
        assert_eq!(out.matches(&line).count(), again, "{out}");
        assert!(!out.contains(next), "{out}");
    }
}

#[test]
fn a_straight_move_to_the_same_position_after_a_call_tells_no_side() {
    let desk = desk("fanuc-m10ia.yaml", 'J');
    let pose = |n: u32, numbers: [f64; 6]| {
        let [x, y, z, w, p, r] = numbers;
        format!(
            "P[{n}]{{\n   GP1:\n\tUF : 0, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',\n\tX = {x:9.3}  mm,\tY = {y:9.3}  mm,\tZ = {z:9.3}  mm,\n\tW = {w:9.3} deg,\tP = {p:9.3} deg,\tR = {r:9.3} deg\n}};\n"
        )
    };
    let first = pose(1, [912.647, -59.904, 789.406, 146.260, -31.952, 26.321]);
    let second = pose(2, [951.137, -8.081, 807.173, 144.826, -35.144, 32.380]);
    let text = format!(
        "/PROG  A\n/ATTR\nLINE_COUNT\t= 4;\n/MN\n   1:  CALL X ;\n   2:J P[1] 50% FINE ;\n   3:L P[1] 100mm/sec FINE ;\n   4:L P[2] 100mm/sec FINE ;\n/POS\n{first}{second}/END\n"
    );
    let out = rewritten(&desk, "a.ls", &text);
    assert!(out.contains(&first) && out.contains("J P[1] 50% FINE") && out.contains("L P[1] 100mm/sec FINE"), "{out}");
    assert!(!out.contains(&second), "{out}");
}
