//! Which wrist FANUC's F and N and Yaskawa's flip mean differs by model: what a program or the robot file tells of it, and what is edited
//! where nothing does.

use crate::support::bundled;
use crate::vendor_rewrite::Desk;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;

/// Poses of an M-10iA at J5 = -60 to -70, or with J4 and J6 half a turn further at the same above zero.
const POSES: [[f64; 6]; 3] = [
    [862.275, 132.908, 768.106, 163.598, -28.091, 21.295],
    [849.244, 57.387, 748.759, 166.101, -29.965, 13.215],
    [891.598, 166.274, 792.478, 160.602, -24.936, 25.844],
];

/// A program that starts at a pose, goes to others and back, and then to joint values.
fn program(lines: &[&str], letter: char, joints: [f64; 6]) -> String {
    let mut text = format!("/PROG  P\n/ATTR\nLINE_COUNT\t= {};\n/MN\n", lines.len());
    for (k, line) in lines.iter().enumerate() {
        text += &format!("{:4}:{line} ;\n", k + 1);
    }
    text += "/POS\n";
    let axes: Vec<String> = joints.iter().enumerate().map(|(k, v)| format!("J{}={v:>10.3} deg", k + 1)).collect();
    text += &format!(
        "P[1]{{\n   GP1:\n\tUF : 0, UT : 1,\t\n\t{},\n\t{}\n}};\n",
        axes[..3].join(",\t"),
        axes[3..].join(",\t")
    );
    for (k, [x, y, z, w, p, r]) in POSES.into_iter().enumerate() {
        text += &format!(
            "P[{}]{{\n   GP1:\n\tUF : 0, UT : 1,\t\tCONFIG : '{letter} U T, 0, 0, 0',\n\tX = {x:9.3}  mm,\tY = {y:9.3}  mm,\tZ = {z:9.3}  mm,\n\tW = {w:9.3} deg,\tP = {p:9.3} deg,\tR = {r:9.3} deg\n}};\n",
            k + 2
        );
    }
    text + "/END\n"
}

const LINES: [&str; 5] =
    ["J P[3] 100% FINE", "L P[2] 100mm/sec FINE", "L P[4] 100mm/sec FINE", "L P[2] 100mm/sec FINE", "J P[1] 100% FINE"];

/// A desk with an M-10iA whose file says what F means, or does not.
fn desk(flip: Option<&str>) -> Desk {
    let desk = Desk::new(0.0);
    let robot = std::fs::read_to_string(bundled("configs/fanuc-m10ia.yaml")).unwrap();
    let robot: String = robot.lines().filter(|l| !l.starts_with("wrist_flip")).map(|l| format!("{l}\n")).collect();
    desk.write("robot.yaml", &(robot + &flip.map_or(String::new(), |flip| format!("wrist_flip: {flip}\n"))));
    let gaps: String =
        (1..=6).map(|k| format!("  - {{effect: backlash, joint: J{k}, half_gap_deg: 0.02}}\n")).collect();
    desk.write("model.yaml", &format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{gaps}"));
    desk.write("frames.yaml", "schema: lostmotion/frames/1\ntools: {\"1\": {xyz_mm: [0, 0, 0]}}\n");
    desk
}

/// What is written, and the report.
fn rewritten(desk: &Desk, text: &str) -> (String, String) {
    desk.write("p.ls", text);
    let run = desk.run("rewrite --model model.yaml p.ls --frames frames.yaml --output out.ls --force").success();
    let said = String::from_utf8_lossy(&run.get_output().stderr).into_owned();
    // what stays as it was has no note
    if desk.path("out.ls.lostmotion.json").exists() {
        desk.run("undo out.ls --output back.ls").success();
        assert_eq!(desk.read("back.ls"), text.as_bytes());
    } else {
        assert_eq!(desk.read("out.ls"), text.as_bytes());
    }
    (String::from_utf8(desk.read("out.ls")).unwrap(), said)
}

/// Values of a joint in the order of the file, deg.
fn values(text: &str, joint: &str) -> Vec<f64> {
    let parts = text.split(['\t', '\n']).filter_map(|w| w.strip_prefix(joint)?.strip_prefix('='));
    parts.filter_map(|w| w.trim().trim_end_matches(',').trim_end_matches("deg").trim().parse().ok()).collect()
}

/// No new point turns the wrist over, and the joints next to the poses tell the letter.
#[test]
fn a_letter_means_the_wrist_that_is_next_to_the_joints_of_the_program() {
    for (letter, sign) in [('F', "negative"), ('N', "positive")] {
        let (out, said) = rewritten(&desk(None), &program(&LINES, letter, [0.0, 0.0, 0.0, 10.0, -60.0, 0.0]));
        assert!(said.contains("5 moves, all editable"), "{said}");
        assert_eq!(said.contains(&format!("wrist_flip `{sign}`")), letter == 'F', "{said}");
        assert!(values(&out, "J5").iter().all(|v| *v < 0.0), "{out}");
        // from 12 to 10, from -65 to -60, from 5 to 0
        let of = |joint: &str, own: f64| values(&out, joint).iter().any(|v| (v - own).abs() < 1e-9);
        assert!(of("J4", 9.98) && of("J5", -59.98) && of("J6", -0.02), "{letter}: {out}");
    }
}

/// J4 and J6 turn by a quarter, and J5 less far than to where the wrist turns over: both wrists are as near.
#[test]
fn joint_values_stay_where_nothing_tells_the_wrist_and_poses_are_the_same_with_both() {
    let text = program(&LINES, 'F', [0.0, 0.0, 0.0, -78.0, -60.0, -85.0]);
    let (out, said) = rewritten(&desk(None), &text);
    assert!(said.contains("as joints: 0 moves, as poses: 4 moves, left: 1 move"), "{said}");
    assert!(said.contains("which wrist the letters F and N (Yaskawa: flip) mean"), "{said}");
    assert_eq!([values(&out, "J4"), values(&out, "J5")], [vec![-78.0], vec![-60.0]], "{out}");
    // the robot file says it; the poses are the same
    let pose = |text: &str| text.lines().filter(|l| l.contains("X =")).map(String::from).collect::<Vec<_>>();
    for (flip, j4) in [("negative", -78.02), ("positive", -77.98)] {
        let (known, said) = rewritten(&desk(Some(flip)), &text);
        assert!(said.contains("5 moves, all editable"), "{said}");
        assert!(values(&known, "J4").iter().any(|v| (v - j4).abs() < 1e-9), "{flip}: {known}");
        assert!(pose(&out).iter().all(|line| pose(&known).contains(line)), "{out}\n{known}");
    }
}

/// A gap that is another one on the other side of zero gives poses that differ by wrist.
#[test]
fn a_pose_stays_whose_offset_depends_on_a_wrist_that_nothing_tells() {
    let desk = desk(None);
    let gap = "  - {effect: backlash_position, joint: J5, knots: [[-100, 0.01], [100, 0.05]]}\n";
    desk.write("model.yaml", &format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{gap}"));
    let (out, said) = rewritten(&desk, &program(&LINES[..4], 'F', [0.0; 6]));
    assert!(said.contains("which wrist the letters F and N (Yaskawa: flip) mean"), "{said}");
    assert!(out.contains("X =   862.275  mm"), "{out}");
}

#[test]
fn a_robot_file_that_the_program_contradicts_decides_nothing() {
    let text = program(&LINES, 'F', [0.0, 0.0, 0.0, 10.0, -60.0, 0.0]);
    let (out, said) = rewritten(&desk(Some("positive")), &text);
    assert!(said.contains("wrist_flip `positive` of the robot file does not fit the joints of this program"), "{said}");
    assert_eq!(values(&out, "J4"), [10.0], "{out}");
    desk(Some("up"))
        .run("robot check robot.yaml")
        .code(2)
        .stderr(contains("wrist_flip `up`").and(contains("within-90")));
}
