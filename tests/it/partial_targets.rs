//! KRL goals that lack parts or axes: what they do not give stays where the robot stands.

use crate::support::bundled;
use crate::vendor_rewrite::Desk;
use std::fmt::Write;

/// A desk with play on each joint of a KR 120.
fn desk() -> Desk {
    let desk = Desk::new(0.0);
    desk.write("robot.yaml", &std::fs::read_to_string(bundled("configs/kuka-kr120-r2500-pro.yaml")).unwrap());
    let mut model = String::from("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n");
    for axis in 1..=6 {
        let _ = writeln!(model, "  - {{effect: backlash, joint: A{axis}, half_gap_deg: 0.05}}");
    }
    desk.write("model.yaml", &model);
    desk
}

/// Axis values of a line such as `PTP {A1 8.0,A5 43.0}`.
fn axes(line: &str) -> Vec<(usize, f64)> {
    let inner = line.split_once('{').and_then(|l| l.1.split_once('}')).map_or("", |l| l.0);
    let value = |part: &str| {
        let (name, value) = part.split_once(' ')?;
        Some((name.strip_prefix('A')?.parse().ok()?, value.parse().ok()?))
    };
    inner.split(',').filter_map(value).collect()
}

#[test]
fn an_approach_point_moves_only_the_axes_that_a_target_names() {
    let desk = desk();
    desk.write(
        "a.src",
        "DEF a()\n  PTP {A1 0,A2 -100,A3 80,A4 10,A5 30,A6 -5}\n  PTP {A1 -8,A5 43}\n  WAIT SEC 1\n  \
         PTP {A1 -17,A2 -80,A3 88,A4 -9,A5 54,A6 0}\nEND\n",
    );
    let out = desk.run("rewrite --model model.yaml a.src --approach-from + --output o.src").success();
    let said = String::from_utf8_lossy(&out.get_output().stderr).into_owned();
    assert!(said.contains("1 target without all axes"), "{said}");
    let written = String::from_utf8(desk.read("o.src")).unwrap();
    let mut stands = [0.0, -100.0, 80.0, 10.0, 30.0, -5.0];
    let mut lowest = 0.0_f64;
    for line in written.lines().filter(|l| l.contains("PTP")) {
        let given = axes(line);
        given.iter().for_each(|(axis, v)| stands[axis - 1] = *v);
        lowest = lowest.min(stands[0]);
        if given.len() == 2 {
            break;
        }
    }
    // A1 came back from below, and the others were not led away
    assert!(stands[0] > -8.06 && lowest < -8.1, "{written}");
    for (axis, q) in [(1, -100.0), (2, 80.0), (3, 10.0), (5, -5.0)] {
        assert!((stands[axis] - q).abs() < 0.06, "A{}: {written}", axis + 1);
    }
}

#[test]
fn the_point_before_a_goal_without_an_orientation_stays() {
    let desk = desk();
    let [a, b] = [
        "LIN {X 1489.596,Y -274.887,Z 1646.327,A -169.337,B 47.426,C -161.171,S 2,T 2}",
        "LIN {X 1538.533,Y -578.244,Z 1345.567,A -173.303,B 35.356,C -158.853,S 2,T 2}",
    ];
    desk.write(
        "a.src",
        &format!(
            "DEF a()\n  $BASE={{X 0,Y 0,Z 0,A 0,B 0,C 0}}\n  $TOOL={{X 0,Y 0,Z 0,A 0,B 0,C 0}}\n  \
             PTP {{A1 10,A2 -85,A3 95,A4 5,A5 40,A6 10}}\n  {a}\n  {b}\n  LIN XP\n  {a}\nEND\n"
        ),
    );
    desk.write("a.dat", "DEFDAT a\nDECL POS XP={X 1500,Y 200,Z 1500}\nENDDAT\n");
    std::fs::create_dir(desk.path("out")).unwrap();
    let out = desk.run("rewrite --model model.yaml a.src --output out/a.src").success();
    let said = String::from_utf8_lossy(&out.get_output().stderr).into_owned();
    assert!(said.contains("lacks parts, which stay as they are here"), "{said}");
    let written = String::from_utf8(desk.read("out/a.src")).unwrap();
    assert!(written.contains(&format!("  {b}\n  LIN XP\n")), "{written}");
}
