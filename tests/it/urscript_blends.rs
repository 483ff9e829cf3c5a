//! URScript: what follows a move with a blend is done as the robot enters it, and where it did in the rewritten program.

use crate::support::bundled;
use crate::vendor_rewrite::Desk;
use lostmotion::robot::Robot;

/// A desk with play on each joint of a UR10e.
fn desk() -> Desk {
    let desk = Desk::new(0.0);
    desk.write("robot.yaml", &std::fs::read_to_string(bundled("configs/universal-robots-ur10e.yaml")).unwrap());
    let joints = ["base", "shoulder", "elbow", "wrist1", "wrist2", "wrist3"];
    let effects: String =
        joints.iter().map(|j| format!("  - {{effect: backlash, joint: {j}, half_gap_deg: 0.02}}\n")).collect();
    desk.write("model.yaml", &format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{effects}"));
    desk
}

fn program(between: &str) -> String {
    format!(
        "def prog():\n  movej([0.1, -1.57, 1.8, -1.8, -1.57, 0.3])\n  movej([0.3, -1.4, 1.7, -1.7, -1.5, 0.4], r=0.05)\n{between}  \
         movej([0.2, -1.5, 1.75, -1.75, -1.4, 0.2], r=0.05)\n  x = 1\n  movej([0.1, -1.57, 1.8, -1.8, -1.57, 0.3])\nend\n"
    )
}

#[test]
fn a_blend_after_which_something_is_done_keeps_its_radius() {
    let desk = desk();
    let radii = |text: &str| -> Vec<f64> {
        desk.write("p.script", text);
        desk.run("rewrite --model model.yaml p.script --output o.script --force --replace").success();
        let written = String::from_utf8(desk.read("o.script")).unwrap();
        let radius = |l: &str| l.split("r=").nth(1).and_then(|r| r.trim_end_matches([')', '\r']).parse().ok());
        // those of new points are smaller
        written.lines().filter_map(radius).filter(|r: &f64| *r > 0.002 || *r == 0.05).collect()
    };
    // by a function, on both ways of a branch, and from the end of a loop to its begin
    let [a, b, c] = [
        "[0.3, -1.4, 1.7, -1.7, -1.5, 0.4]",
        "[0.2, -1.5, 1.75, -1.75, -1.4, 0.2]",
        "[0.1, -1.57, 1.8, -1.8, -1.57, 0.3]",
    ];
    let grip = "def grip():\n  set_digital_out(0, True)\nend\n";
    let by_call =
        format!("{grip}def prog():\n  movej({c})\n  movej({a}, r=0.05)\n  grip()\n  movej({b})\n  movej({c})\nend\n");
    let branch = format!(
        "def prog():\n  movej({c})\n  if x:\n    movej({a}, r=0.05)\n  else:\n    movej({a}, r=0.05)\n  end\n  set_digital_out(0, True)\n  \
         movej({b})\n  movej({c})\nend\n"
    );
    let repeated = format!(
        "def prog():\n  movej({c})\n  while True:\n    set_digital_out(0, True)\n    movej({b})\n    movej({a}, r=0.05)\n  end\nend\n"
    );
    for (text, blends) in [(by_call, 1), (branch, 2), (repeated, 1)] {
        assert_eq!(radii(&text), vec![0.05; blends], "{text}");
    }
    for (between, keeps) in [
        ("", false),
        ("  y = 1\n  textmsg(\"on\")\n", false),
        ("  q = get_inverse_kin(p[0, 0.3, 0.4, 0, 3, 0])\n", false),
        ("  set_digital_out(0, True)\n", true),
        ("  if get_digital_in(1):\n    textmsg(\"on\")\n  end\n", true),
        ("  y = 1\n  socket_send_string(\"on\")\n", true),
    ] {
        let text = program(between);
        desk.write("p.script", &text);
        let out = desk.run("rewrite --model model.yaml p.script --output o.script --force --replace").success();
        let said = String::from_utf8_lossy(&out.get_output().stderr).into_owned();
        let written = String::from_utf8(desk.read("o.script")).unwrap();
        let radius =
            |line: &str| line.split("r=").nth(1).and_then(|r| r.trim_end_matches([')', '\r']).parse::<f64>().ok());
        let of_second =
            written.lines().filter(|l| l.contains("movej([0.3") || l.contains("movej([0.2999")).find_map(radius);
        assert_eq!(of_second == Some(0.05), keeps, "{between}: {written}");
        assert_eq!(said.contains("as the robot enters its blend"), keeps, "{between}: {said}");
        // after the other one nothing is done
        let third = |l: &&str| l.contains("movej([0.199651") || l.contains("movej([0.200349");
        let of_third = written.lines().filter(third).find_map(radius);
        assert!(of_third.is_some_and(|r| r < 0.05), "{between}: {written}");
    }
}

#[test]
fn a_new_point_does_not_stand_in_the_blend_of_a_move_of_another_run() {
    let desk = desk();
    let [a, b, c] =
        ["[0.0, -1.5, 1.5, -1.5, -1.5, 0.1]", "[0.3, -1.4, 1.4, -1.4, -1.4, 0.3]", "[0.9, -1.0, 1.0, -1.5, -1.5, 0.1]"];
    let written = |text: &str| {
        desk.write("p.script", text);
        desk.run("rewrite --model model.yaml p.script --output o.script --force --replace").success();
        String::from_utf8(desk.read("o.script")).unwrap()
    };
    let kept = |text: &str| text.matches("r=0.05)").count();
    let lines = |text: &str| text.lines().count();
    let after_call = format!(
        "def prog():\n  def go():\n    movej({c}, r=0.05)\n  end\n  movej({a})\n  movej({b})\n  go()\n  movej({b})\nend\n"
    );
    let into_call = format!(
        "def prog():\n  def go():\n    movej({b}, r=0.02)\n    movej({a})\n  end\n  movej({a})\n  movej({c}, r=0.05)\n  go()\nend\n"
    );
    let branch = format!(
        "def prog():\n  movej({a})\n  movej({b})\n  movej({c}, r=0.05)\n  if x1:\n    movej({b})\n  end\nend\n"
    );
    for text in [&after_call, &into_call, &branch] {
        let out = written(text);
        assert_eq!(kept(&out), 0, "{out}");
        assert!(lines(&out) > lines(text), "{out}");
    }
    // a blend that stays as it is keeps points away
    for (between, after) in [("# lostmotion: off\n", "# lostmotion: on\n"), ("", "  set_digital_out(0, True)\n")] {
        let text = format!(
            "def prog():\n  movej({a})\n  movej({b})\n{between}  movej({c}, r=0.05)\n{after}  if x1:\n    movej({b})\n  end\nend\n"
        );
        let out = written(&text);
        assert_eq!(kept(&out), 1, "{out}");
        let (_, next) = out.split_once("  if x1:\n").unwrap();
        assert_eq!(next.matches("movej").count(), 1, "{out}");
    }
}

/// Lists of joint values, rad, and radii, m, of the motions of a program.
fn motions(text: &str) -> Vec<(Vec<f64>, f64)> {
    let motion = |line: &str| {
        let list = line.trim().strip_prefix("movej([")?.split(']').next()?;
        let radius = line.split("r=").nth(1).and_then(|r| r.trim_end_matches(')').parse().ok());
        Some((list.split(',').map(|v| v.trim().parse().unwrap()).collect(), radius.unwrap_or(0.0)))
    };
    text.lines().filter_map(motion).collect()
}

/// Radii are as large as the places that are written allow: an offset moves the TCP by as much as a new point is away from its target.
#[test]
fn radii_of_a_target_and_of_the_new_point_after_it_fit_between_them() {
    let desk = Desk::new(0.0);
    let file = std::fs::read_to_string(bundled("configs/universal-robots-ur10.yaml")).unwrap();
    desk.write("robot.yaml", &file);
    let joints = ["base", "shoulder", "elbow", "wrist1", "wrist2", "wrist3"];
    let effects: String =
        joints.iter().map(|j| format!("  - {{effect: backlash, joint: {j}, half_gap_deg: 0.05}}\n")).collect();
    desk.write("model.yaml", &format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{effects}"));
    desk.write(
        "p.script",
        "def prog():\n  movej([0.1, -1.8, 1.2, -1.2, -1.2, 0.1])\n  movej([0.453, -1.542, 1.222, -1.405, -1.249, 0.244])\n  \
         movej([0.125, -1.274, 1.242, -1.5, -1.51, 0.1], r=0.005)\n  movej([0.049, -1.278, 1.288, -1.363, -1.716, 0.347], r=0.005)\n  \
         movej([0.149, -1.378, 1.388, -1.463, -1.616, 0.247])\nend\nprog()\n",
    );
    desk.run("rewrite --model model.yaml p.script --output o.script --force").success();
    let text = String::from_utf8(desk.read("o.script")).unwrap();
    let (robot, motions) = (Robot::parse("robot.yaml", &file).unwrap(), motions(&text));
    assert!(motions.len() > 5 && motions.iter().filter(|m| m.1 > 0.0).count() > 2, "{text}");
    for pair in motions.windows(2) {
        let away = (robot.tcp_m(&pair[0].0) - robot.tcp_m(&pair[1].0)).norm();
        // radii are written to 10 um
        assert!(pair[0].1 + pair[1].1 <= away + 1e-5, "{} + {} in {away}: {text}", pair[0].1, pair[1].1);
    }
}
