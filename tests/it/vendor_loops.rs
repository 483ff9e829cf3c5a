//! Loops with constant bounds: what stands in them is written once and runs on every pass.

use crate::support::bundled;
use crate::vendor_rewrite::Desk;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;

/// A desk with half gaps of 0.01 deg on all joints of the ABB.
pub fn desk() -> Desk {
    let desk = Desk::new(0.0);
    std::fs::copy(bundled("configs").join("abb-irb1600-6-145.yaml"), desk.path("robot.yaml")).unwrap();
    let effects: String =
        (1..=6).map(|k| format!("  - {{effect: backlash, joint: J{k}, half_gap_deg: 0.01}}\n")).collect();
    desk.write("model.yaml", &format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{effects}"));
    desk
}

/// All joints at this angle.
pub fn to(deg: i32) -> String {
    format!("MoveAbsJ [[{0},{0},{0},{0},{1},{0}],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\n", deg, deg + 30)
}

pub fn program(body: &str) -> String {
    // it does not run again
    format!("MODULE r\nPROC main()\nVAR num i;\n{body}Stop;\nENDPROC\nENDMODULE\n")
}

/// Hundredths of a degree by which J1 of each move has changed.
pub fn offsets(before: &str, after: &str) -> Vec<i32> {
    let j1 = |text: &str| -> Vec<f64> {
        let number = |l: &str| l.strip_prefix("MoveAbsJ [[")?.split(',').next()?.parse().ok();
        text.lines().filter_map(number).collect()
    };
    let (a, b) = (j1(before), j1(after));
    assert_eq!(a.len(), b.len(), "{after}");
    a.iter().zip(&b).map(|(a, b)| ((b - a) * 100.0).round() as i32).collect()
}

pub fn rewritten(desk: &Desk, text: &str) -> (Vec<i32>, String) {
    rewritten_with(desk, text, "--max-added 0")
}

/// With these options, which add no points to this program.
pub fn rewritten_with(desk: &Desk, text: &str, options: &str) -> (Vec<i32>, String) {
    desk.write("p.mod", text);
    let run = desk.run(&format!("rewrite --model model.yaml p.mod --output out.mod --force {options}")).success();
    let said = String::from_utf8_lossy(&run.get_output().stderr).into_owned();
    (offsets(text, &String::from_utf8(desk.read("out.mod")).unwrap()), said)
}

#[test]
fn the_first_move_of_a_loop_is_edited_where_every_pass_comes_from_the_same_side() {
    let desk = desk();
    for head in ["FOR i FROM 1 TO 4 DO", "WHILE TRUE DO"] {
        let end = if head.starts_with("FOR") { "ENDFOR" } else { "ENDWHILE" };
        // to 0 from 10 and from 20: downwards both times
        let body = format!("{}{}{head}\n{}{}{}{end}\n{}", to(0), to(10), to(0), to(10), to(20), to(5));
        let (by, said) = rewritten(&desk, &program(&body));
        assert_eq!(by, [1, 1, -1, 1, 1, -1], "{head}: {said}");
        assert!(said.contains("all editable"), "{said}");
    }
}

#[test]
fn a_move_that_the_passes_of_a_loop_reach_from_different_sides_is_left_and_the_others_are_edited() {
    let desk = desk();
    // to 15 from 10 upwards, and from 20 downwards
    let body = format!("{}{}FOR i FROM 1 TO 4 DO\n{}{}ENDFOR\n{}", to(0), to(10), to(15), to(20), to(5));
    let (by, said) = rewritten(&desk, &program(&body));
    assert_eq!(by, [1, 1, 0, 1, -1], "{said}");
    assert!(said.contains("reached from other sides on its other ways"), "{said}");
    // a joint that stands in the loop keeps the side that it had before
    let body = format!("{}{}FOR i FROM 1 TO 4 DO\n{}{}ENDFOR\n", to(10), to(0), to(10), to(10));
    assert_eq!(rewritten(&desk, &program(&body)).0, [-1, -1, 1, 1]);
}

#[test]
fn what_follows_a_loop_that_may_not_be_entered_comes_from_before_it_or_from_its_end() {
    let desk = desk();
    let heads = ["FOR i FROM 1 TO n DO", "FOR i FROM 4 TO 1 DO", "WHILE i<3 DO"];
    for head in heads {
        let end = if head.starts_with("FOR") { "ENDFOR" } else { "ENDWHILE" };
        let around =
            |inside: &str, last: i32| program(&format!("{}{}{head}\n{inside}{end}\n{}", to(0), to(10), to(last)));
        // downwards to 0 and to 5, whether the loop was entered or not
        let (by, said) = rewritten(&desk, &around(&format!("{}{}{}", to(0), to(10), to(20)), 5));
        assert_eq!(by, [1, 1, -1, 1, 1, -1], "{head}: {said}");
        // to 15 upwards from before the loop, and downwards from its end
        let (by, said) = rewritten(&desk, &around(&format!("{}{}{}", to(0), to(10), to(20)), 15));
        assert_eq!(by, [1, 1, -1, 1, 1, 0], "{head}: {said}");
        assert!(said.contains("reached from other sides on its other ways"), "{said}");
        // to 12 from 10 upwards, on the next pass from 20 downwards
        let (by, said) = rewritten(&desk, &around(&format!("{}{}{}", to(12), to(10), to(20)), 5));
        assert_eq!(by, [1, 1, 0, -1, 1, -1], "{head}: {said}");
    }
    // a branch in it: its first move is reached from one place; and a loop in it: the inner one is followed
    let branch = format!("{}{}FOR i FROM 1 TO 4 DO\n{}IF i=2 THEN\n{}ENDIF\nENDFOR\n", to(0), to(10), to(0), to(20));
    assert_eq!(rewritten(&desk, &program(&branch)).0, [1, 1, 0, 1]);
    let inner = format!(
        "{}FOR i FROM 1 TO 4 DO\n{}{}FOR j FROM 1 TO 2 DO\n{}{}ENDFOR\nENDFOR\n",
        to(10),
        to(0),
        to(20),
        to(10),
        to(20)
    );
    assert_eq!(rewritten(&desk, &program(&inner)).0, [0, 0, 1, -1, 1]);
}

#[test]
fn no_point_is_put_on_the_way_to_the_first_move_of_a_loop() {
    let desk = desk();
    let body = format!("{}{}FOR i FROM 1 TO 4 DO\n{}{}{}ENDFOR\n", to(0), to(10), to(0), to(10), to(20));
    desk.write("p.mod", &program(&body));
    desk.run("rewrite --model model.yaml p.mod --output out.mod").success();
    let out = String::from_utf8(desk.read("out.mod")).unwrap();
    let lines: Vec<&str> = out.lines().collect();
    let head = lines.iter().position(|l| l.starts_with("FOR")).unwrap();
    assert!(lines[head + 1].starts_with("MoveAbsJ [[-0.0"), "{out}");
    // the way up after it begins with a step
    assert!(lines[head + 2].starts_with("MoveAbsJ [[0."), "{out}");
    desk.run("rewrite --model model.yaml out.mod --output again.mod").code(2);
}

#[test]
fn moves_that_are_not_written_do_not_count_as_edited() {
    let desk = desk();
    let body = format!(
        "{}{}{}away;\n{}{}Stop;\nENDPROC\nPROC part()\n{}{}",
        to(0),
        to(10),
        to(0),
        to(10),
        to(0),
        to(5),
        to(10)
    );
    desk.write("p.mod", &program(&body));
    let run = desk.run("rewrite --model model.yaml p.mod --output out.mod --max-added 0 --json").success();
    let doc: serde_json::Value = serde_json::from_slice(&run.get_output().stdout).unwrap();
    assert_eq!(
        (doc["moves"].as_u64(), doc["editable"].as_u64(), doc["left"].as_u64()),
        (Some(7), Some(5), Some(2)),
        "{doc}"
    );
    let out = String::from_utf8(desk.read("out.mod")).unwrap();
    let changed = out.lines().zip(program(&body).lines()).filter(|(a, b)| a != b).count();
    assert_eq!(changed, 5, "{out}");
    let run = desk.run("rewrite --model model.yaml p.mod --output o.mod --require-coverage 100%");
    run.code(1).stderr(contains("5 of 7").or(contains("from which side its joints reach it is not known")));
}

#[test]
fn the_second_pass_of_a_loop_begins_its_straight_way_at_the_end_of_the_loop() {
    let desk = desk();
    let line = |q1: i32, z: &str| {
        format!("MoveL [[{q1},800,{z}],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\n")
    };
    let body = format!(
        "{}{}WHILE TRUE DO\n{}{}ENDWHILE\n",
        "MoveAbsJ [[45,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\n",
        line(800, "1000"),
        line(800, "600"),
        line(800, "800"),
    );
    desk.write("p.mod", &program(&body));
    desk.run("simulate --model model.yaml --input p.mod --rate-hz 100 --output log.csv").success();
    let log = String::from_utf8(desk.read("log.csv")).unwrap();
    let mut rows = log.lines().filter(|l| !l.starts_with('#'));
    let z = rows.next().unwrap().split(',').position(|name| name == "z_mm").unwrap();
    let z: Vec<f64> = rows.map(|l| l.split(',').nth(z).unwrap().parse().unwrap()).collect();
    // 100 mm/s: no row is more than a millimetre and its lost motion from the one before, once the lines have begun
    let first = z.iter().rposition(|z| (z - 1000.0).abs() < 0.5).unwrap();
    let step = z[first..].windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
    let lowest = z[first..].iter().copied().fold(f64::INFINITY, f64::min);
    assert!(step < 1.6 && (lowest - 600.0).abs() < 0.5, "{step} {lowest}");
    // down, up, and down again
    assert!(z[first..].windows(2).filter(|w| w[1] < w[0] - 0.9).count() > 550, "{}", z.len());
}
