//! External axes of the robot file beside Cartesian targets: given by the program, never solved, with offsets in their own numbers.
//!
//! A track only carries the arm: seen from the arm, a program for both is that of the arm alone. So every number of the one follows from
//! the other, whatever the kinematics are.

use crate::support::bundled;
use crate::vendor_rewrite::Desk;
use predicates::str::contains;

/// A prismatic axis under the robot, along its base's z.
const TRACK: &str = "  - {name: NAME, kind: prismatic, theta_deg: 0, d_mm: 0, a_mm: 0, alpha_deg: 0, direction: 1, \
                     limits_mm: [-2000, 5000], max_speed_mm_s: 500}\n";

/// A desk with a robot `arm.yaml`, the same on a track `track.yaml`, and models of backlash.
fn desk(config: &str, track: &str, joints: &str) -> Desk {
    let desk = Desk::new(0.0);
    let arm = std::fs::read_to_string(bundled("configs").join(config)).unwrap();
    let carried = arm.replacen("joints:\n", &format!("joints:\n{}", TRACK.replace("NAME", track)), 1);
    assert_ne!(arm, carried);
    desk.write("arm.yaml", &arm);
    desk.write("track.yaml", &carried);
    let gaps = |names: &str, size: &str| -> String {
        let one = |n: &str| format!("  - {{effect: backlash, joint: {n}, {size}}}\n");
        names.split_ascii_whitespace().map(one).collect()
    };
    let model =
        |robot: &str, effects: String| format!("schema: lostmotion/model/1\nrobot: {robot}.yaml\neffects:\n{effects}");
    desk.write("m-arm.yaml", &model("arm", gaps(joints, "half_gap_deg: 0.004")));
    desk.write("m-both.yaml", &model("track", gaps(joints, "half_gap_deg: 0.004")));
    desk.write("m-track.yaml", &model("track", gaps(track, "half_gap_mm: 0.05")));
    desk
}

/// Numbers of the Cartesian moves of a KRL program: X, Y, Z, A, B, C and E1 where it stands.
fn krl(text: &str) -> Vec<Vec<f64>> {
    let line = |l: &str| -> Option<Vec<f64>> {
        let inner = l.strip_prefix("LIN ").or(l.strip_prefix("PTP "))?.trim().trim_matches(['{', '}']);
        let inner = inner.strip_prefix("E6POS: ").unwrap_or(inner);
        if !inner.contains("X ") {
            return None;
        }
        let value =
            |part: &str| part.split_once(' ').filter(|p| p.0 != "S" && p.0 != "T").map(|p| p.1.parse().unwrap());
        Some(inner.split(',').filter_map(value).collect())
    };
    text.lines().filter_map(line).collect()
}

/// A program of the arm alone (`track: false`), or of both with these positions of the track at its targets.
fn program(track: Option<[i32; 4]>) -> String {
    let e1 = |v: i32| track.map_or(String::new(), |_| format!(",E1 {v}"));
    let [a, b, c, d] = track.unwrap_or_default();
    let pose = |y: i32, z: i32, on: i32| format!("X 1500,Y {y},Z {},A 0,B 60,C 0", z + on);
    format!(
        "DEF rail( )\n$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\nPTP {{A1 0,A2 -90,A3 90,A4 0,A5 30,A6 0{}}}\n\
         PTP {{E6POS: {},S 2,T 35{}}}\nLIN {{{}{}}}\nLIN {{{}{}}}\nLIN {{{}{}}}\nEND\n",
        e1(a),
        pose(300, 1500, a),
        e1(a),
        pose(-300, 1500, b),
        e1(b),
        pose(100, 1400, c),
        e1(c),
        pose(200, 1500, d),
        e1(d),
    )
}

const KUKA: (&str, &str) = ("kuka-kr120-r2500-pro.yaml", "A1 A2 A3 A4 A5 A6");

#[test]
fn an_external_axis_beside_a_pose_is_given_and_not_solved() {
    let desk = desk(KUKA.0, "E1", KUKA.1);
    desk.write("arm.src", &program(None));
    desk.run("rewrite --model m-arm.yaml arm.src --output arm-out.src").success();
    let alone = krl(&String::from_utf8(desk.read("arm-out.src")).unwrap());
    assert!(alone.len() > 4 && alone != krl(&program(None)), "{alone:?}");
    // at rest at 0 and elsewhere, and moving on straight ways
    for at in [[0, 0, 0, 0], [100, 100, 100, 100], [0, 200, 400, 700]] {
        desk.write("both.src", &program(Some(at)));
        desk.run("rewrite --model m-both.yaml both.src --output both-out.src --force").success();
        let both = krl(&String::from_utf8(desk.read("both-out.src")).unwrap());
        assert_eq!(both.len(), alone.len(), "{at:?}");
        for (own, alone) in both.iter().zip(&alone) {
            let seen = [own[0], own[1], own[2] - own[6], own[3], own[4], own[5]];
            // where a joint turns on a way is found between samples, which stand elsewhere on a longer way
            let goal = [[300.0, 1500.0], [-300.0, 1500.0], [100.0, 1400.0], [200.0, 1500.0]]
                .iter()
                .any(|[y, z]| (seen[1] - y).abs() < 0.3 && (seen[2] - z).abs() < 0.3);
            let within = if goal || at[0] == at[3] { 2.5e-4 } else { 0.01 };
            let near = seen.iter().zip(alone).all(|(a, b)| (a - b).abs() < within);
            assert!(near, "{at:?}: {own:?} instead of {alone:?}");
        }
    }
}

#[test]
fn an_external_axis_that_reverses_has_its_offset_in_its_own_number() {
    let desk = desk(KUKA.0, "E1", KUKA.1);
    desk.write("both.src", &program(Some([0, 200, 100, 300])));
    desk.run("rewrite --model m-track.yaml both.src --output out.src --max-added 0").success();
    let before = krl(&program(Some([0, 200, 100, 300])));
    let after = krl(&String::from_utf8(desk.read("out.src")).unwrap());
    let by: Vec<[f64; 7]> =
        before.iter().zip(&after).map(|(a, b)| std::array::from_fn(|k| ((b[k] - a[k]) * 1e4).round() / 1e4)).collect();
    // the arm stands where it stood on the track, and its base has moved along by the offset
    let offsets: Vec<f64> = by.iter().map(|b| b[6]).collect();
    assert_eq!(offsets[1..], [0.05, -0.05, 0.05], "{by:?}");
    for b in &by {
        assert!((b[2] - b[6]).abs() < 1.5e-4 && [0, 1, 3, 4, 5].iter().all(|k| b[*k] == 0.0), "{by:?}");
    }
}

#[test]
fn a_pose_that_does_not_name_the_external_axis_is_left_where_it_would_need_its_offset() {
    let desk = desk(KUKA.0, "E1", KUKA.1);
    let text = program(Some([0, 200, 100, 100])).replace("Z 1600,A 0,B 60,C 0,E1 100", "Z 1600,A 0,B 60,C 0");
    desk.write("both.src", &text);
    let run = desk.run("rewrite --model m-track.yaml both.src --output out.src --max-added 0");
    run.success().stderr(contains("does not give the external axis"));
    assert!(String::from_utf8(desk.read("out.src")).unwrap().contains("Y 200,Z 1600,A 0,B 60,C 0}"));
}

const ABB: (&str, &str) = ("abb-irb1600-6-145.yaml", "J1 J2 J3 J4 J5 J6");

fn rapid(track: Option<[i32; 3]>) -> String {
    let at = |k: usize| track.map_or("9E9".to_string(), |t| t[k].to_string());
    let on = |k: usize| track.map_or(0, |t| t[k]);
    let target = |k: usize, y: i32, quarter: i32| {
        format!(
            "MoveL [[700,{y},{}],[0.258819,0,0.965926,0],[{quarter},-1,0,0],[{},9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\n",
            900 + on(k),
            at(k)
        )
    };
    format!(
        "MODULE r\nPROC main()\nConfL\\Off;\nMoveAbsJ [[0,0,0,0,30,0],[{},9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\n{}{}{}ENDPROC\nENDMODULE\n",
        at(0),
        target(0, 200, 0),
        target(1, -200, -1),
        target(2, 150, 0),
    )
}

/// Numbers of the brackets of each MoveL, and those of the joint target.
fn numbers(text: &str, word: &str) -> Vec<Vec<f64>> {
    let of = |l: &str| l.split(['[', ']', ',']).filter_map(|p| p.trim().parse::<f64>().ok()).collect();
    text.lines().filter(|l| l.starts_with(word)).map(of).collect()
}

#[test]
fn external_axes_of_rapid_are_told_by_their_names_and_not_by_their_places() {
    for name in ["E1", "eax_a", "J7", "track"] {
        let desk = desk(ABB.0, name, ABB.1);
        desk.write("arm.mod", &rapid(None));
        desk.run("rewrite --model m-arm.yaml arm.mod --output arm-out.mod").success();
        desk.write("both.mod", &rapid(Some([0, 300, 500])));
        desk.run("rewrite --model m-both.yaml both.mod --output both-out.mod").success();
        let read = |n: &str| String::from_utf8(desk.read(n)).unwrap();
        let (alone, both) = (read("arm-out.mod"), read("both-out.mod"));
        assert_eq!(numbers(&alone, "MoveAbsJ")[0][..6], numbers(&both, "MoveAbsJ")[0][..6], "{name}: {both}");
        let (alone, both) = (numbers(&alone, "MoveL"), numbers(&both, "MoveL"));
        assert_eq!(alone.len(), both.len(), "{name}");
        for (a, b) in alone.iter().zip(&both) {
            let seen = [b[0], b[1], b[2] - b[11], b[3], b[4], b[5], b[6]];
            let goal = [200.0, -200.0, 150.0].iter().any(|y| (seen[1] - y).abs() < 0.3);
            let within = if goal { 1e-3 } else { 0.01 };
            assert!(seen.iter().zip(a).all(|(x, y)| (x - y).abs() < within), "{name}: {b:?} instead of {a:?}");
        }
        desk.run("rewrite --model m-track.yaml both.mod --output t.mod --max-added 0").success();
        let track: Vec<f64> = numbers(&read("t.mod"), "MoveL").iter().map(|n| n[11]).collect();
        assert_eq!(track[1..], [300.05, 500.05], "{name}");
    }
}

#[test]
fn a_robot_whose_external_axes_cannot_be_told_has_its_moves_left() {
    let desk = desk(ABB.0, "x", ABB.1);
    let robot = String::from_utf8(desk.read("track.yaml")).unwrap();
    desk.write("track.yaml", &robot.replacen("joints:\n", &format!("joints:\n{}", TRACK.replace("NAME", "y")), 1));
    desk.write("both.mod", &rapid(Some([0, 300, 500])));
    let run = desk.run("rewrite --model m-both.yaml both.mod --output out.mod");
    run.success().stderr(contains("is not certain: name them E1"));
    assert_eq!(desk.read("out.mod"), desk.read("both.mod"));
}

fn fanuc(track: Option<[i32; 3]>) -> String {
    let mut text = String::from("/PROG  T\n/ATTR\nLINE_COUNT\t= 3;\n/MN\n");
    for k in 1..=3 {
        text += &format!(
            "{k:4}:{} P[{k}] {} FINE ;\n",
            if k == 1 { 'J' } else { 'L' },
            if k == 1 { "50%" } else { "200mm/sec" }
        );
    }
    text += "/POS\n";
    for (k, y) in [100, -200, 150].iter().enumerate() {
        let on = track.map_or(0, |t| t[k]);
        let e1 = track.map_or(String::new(), |t| format!(",\n\tE1={:>10}.000  mm", t[k]));
        text += &format!(
            "P[{}]{{\n   GP1:\n\tUF : 0, UT : 0,\t\tCONFIG : 'N U T, 0, 0, 0',\n\tX =   800.000  mm,\tY ={y:>6}.000  mm,\tZ ={:>6}.000  mm,\n\
             \tW =   180.000 deg,\tP =   -10.000 deg,\tR =    10.000 deg{e1}\n}};\n",
            k + 1,
            200 + on
        );
    }
    text + "/END\n"
}

#[test]
fn extended_axes_of_fanuc_stand_in_group_1_under_their_names() {
    let desk = desk("fanuc-m10ia.yaml", "E1", "J1 J2 J4 J5 J6");
    desk.write("arm.ls", &fanuc(None));
    desk.run("rewrite --model m-arm.yaml arm.ls --output arm-out.ls").success();
    desk.write("both.ls", &fanuc(Some([0, 300, 500])));
    desk.run("rewrite --model m-both.yaml both.ls --output both-out.ls").success();
    let fields = |name: &str, field: &str| -> Vec<f64> {
        let text = String::from_utf8(desk.read(name)).unwrap();
        let after = |p: &str| p.split_ascii_whitespace().next()?.parse().ok();
        text.split(&format!("{field}=")).skip(1).filter_map(after).collect()
    };
    let [alone, both] =
        [("arm-out.ls"), ("both-out.ls")].map(|n| ["X ", "Y ", "Z ", "W ", "P ", "R "].map(|f| fields(n, f)));
    let track = fields("both-out.ls", "E1");
    assert!(alone[0].len() > 3 && track.len() == alone[0].len(), "{alone:?} {track:?}");
    assert_ne!(alone[1][..3], [100.0, -200.0, 150.0]);
    for n in 0..6 {
        for k in 0..track.len() {
            let seen = both[n][k] - if n == 2 { track[k] } else { 0.0 };
            // the first three are the goals; where a joint turns on a way is found between samples
            let within = if k < 3 { 1.6e-3 } else { 0.5 };
            assert!((seen - alone[n][k]).abs() < within, "{n} {k}: {both:?} instead of {alone:?}");
        }
    }
}
