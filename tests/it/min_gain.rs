//! `--min-gain`: new points that gain less at the TCP than the user wants stay away, and all others stay as they were.

use crate::support::bundled;
use crate::vendor_rewrite::{Desk, PROGRAM};
use lostmotion::robot::Robot;

const HALF_GAP_DEG: f64 = 0.01;

/// Lines that move, of a result.
fn moves(desk: &Desk, options: &str) -> (Vec<String>, String) {
    let run =
        desk.run(&format!("rewrite --model model.yaml part.src --output out.src --force --replace{options}")).success();
    let said = String::from_utf8_lossy(&run.get_output().stderr).into_owned();
    let text = String::from_utf8(desk.read("out.src")).unwrap();
    (text.lines().filter(|l| l.starts_with("PTP") || l.starts_with("LIN")).map(str::to_string).collect(), said)
}

fn joints_deg(line: &str) -> Vec<f64> {
    let inner = line.split(['{', '}']).nth(1).unwrap();
    inner.split(',').map(|word| word[3..].parse().unwrap()).collect()
}

/// The point after the turn of A1 moves the step of a whole gap from the whole move to its start: as far as the axis is from the TCP.
#[test]
fn a_point_stays_if_the_lost_motion_at_the_tool_is_larger() {
    let desk = Desk::new(HALF_GAP_DEG);
    let (all, _) = moves(&desk, "");
    assert_eq!(all.len(), 4);
    let robot = std::fs::read_to_string(bundled("configs/kuka-kr120-r2500-pro.yaml")).unwrap();
    let robot = Robot::parse("robot.yaml", &robot).unwrap();
    let point = joints_deg(&all[2]);
    let rad: Vec<f64> = point.iter().map(|v| v.to_radians()).collect();
    let tcp = robot.tcp_m(&rad);
    // A1 goes from 20 to 5 degrees
    let share = (20.0 - (point[0] + HALF_GAP_DEG)) / 15.0;
    let gain_um = (2.0 * HALF_GAP_DEG).to_radians() * tcp.x.hypot(tcp.y) * 1e6 * (1.0 - share);
    assert!(gain_um > 300.0, "{gain_um}");
    let (kept, said) = moves(&desk, &format!(" --min-gain {}", 0.99 * gain_um));
    assert_eq!(kept, all);
    assert!(!said.contains("--min-gain"), "{said}");
    let (few, said) = moves(&desk, &format!(" --min-gain {}", 1.01 * gain_um));
    // the targets have their offsets all the same
    assert_eq!(few, [&all[0], &all[1], &all[3]].map(String::clone));
    assert!(said.contains("left out by --min-gain: 1 new point;"), "{said}");
    desk.run("undo out.src --output back.src").success();
    assert_eq!(desk.read("back.src"), PROGRAM.as_bytes());
}

/// Straight moves on which A1 turns 1.5 m from the TCP (210 um of lost motion there), and joint moves of A6, 0.16 m from it (22 um).
#[test]
fn points_of_joints_that_the_tool_hardly_feels_stay_away() {
    let desk = Desk::new(0.004);
    let straight = "DEF part( )\n$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\nPTP {A1 0,A2 -90,A3 90,A4 0,A5 60,A6 0}\n\
LIN {X 1500,Y 200,Z 1800,A 0,B 60,C 0}\nLIN {X 1500,Y -200,Z 1800,A 0,B 60,C 0}\nLIN {X 1500,Y 200,Z 1800,A 0,B 60,C 0}\n\
PTP {A1 0,A2 -90,A3 90,A4 0,A5 60,A6 20}\nPTP {A1 0,A2 -90,A3 90,A4 0,A5 60,A6 -20}\nPTP {A1 0,A2 -90,A3 90,A4 0,A5 60,A6 20}\nEND\n";
    desk.write("part.src", straight);
    let gap = |joint: &str| format!("  - {{effect: backlash, joint: {joint}, half_gap_deg: 0.004}}\n");
    let model = |joints: &str| {
        let gaps: String = joints.split(' ').map(gap).collect();
        desk.write("model.yaml", &format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{gaps}"));
    };
    model("A1 A6");
    let (all, _) = moves(&desk, "");
    let (some, _) = moves(&desk, " --min-gain 40");
    let (none, _) = moves(&desk, " --min-gain 100000");
    assert_eq!(none.len(), straight.lines().filter(|l| l.starts_with("PTP") || l.starts_with("LIN")).count());
    assert!(all.len() > some.len() && some.len() > none.len(), "{} {} {}", all.len(), some.len(), none.len());
    // what is left out are points of motions that turn A6 alone
    let points = |lines: &[String], word: &str| lines.iter().filter(|l| l.starts_with(word)).count();
    assert_eq!(points(&all, "LIN"), points(&some, "LIN"));
    // the first of these turns A1
    assert_eq!(points(&some, "PTP"), points(&none, "PTP") + 1);
}

#[test]
fn a_gain_is_a_distance_above_zero_and_stands_in_the_note() {
    let desk = Desk::new(HALF_GAP_DEG);
    for (gain, words) in [("0", "a distance above 0"), ("-5", "a distance above 0"), ("a", "invalid value 'a'")] {
        let run = desk.run(&format!("rewrite --model model.yaml part.src --output out.src --min-gain {gain}")).code(2);
        let said = String::from_utf8_lossy(&run.get_output().stderr).into_owned();
        assert!(said.contains(words), "{said}");
        assert!(!desk.path("out.src").exists());
    }
    moves(&desk, " --min-gain 5");
    assert!(String::from_utf8(desk.read("out.src.lostmotion.json")).unwrap().contains("min_gain_um 5"));
}
