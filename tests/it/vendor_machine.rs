//! What KUKA's `$machine.dat` says of where the robot stands and how far its axes go.

use crate::vendor_rewrite::Desk;
use lostmotion::robot::Robot;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;

/// A program that starts at joint values and draws lines in base 1.
const PROGRAM: &str = "DEF lines( )\nPTP {A1 0.0,A2 -90.0,A3 90.0,A4 0.0,A5 60.0,A6 0.0}\n$BASE=BASE_DATA[1]\n$TOOL=TOOL_DATA[1]\n\
LIN {X 0.0,Y 0.0,Z 0.0,A 0.0,B 180.0,C 0.0}\nLIN {X 0.0,Y 150.0,Z 0.0,A 0.0,B 180.0,C 0.0}\n\
LIN {X 0.0,Y -100.0,Z 0.0,A 0.0,B 180.0,C 0.0}\nLIN {X 50.0,Y 0.0,Z 0.0,A 0.0,B 180.0,C 0.0}\nEND\n";

fn config(x: f64, y: f64, z: f64, a: f64) -> String {
    format!(
        "DEFDAT $CONFIG PUBLIC\nDECL FRAME BASE_DATA[32]\nBASE_DATA[1]={{X {x},Y {y},Z {z},A {a},B 0.0,C 0.0}}\n\
         TOOL_DATA[1]={{X 0.0,Y 0.0,Z 100.0,A 0.0,B 0.0,C 0.0}}\nENDDAT\n"
    )
}

fn machine(root: &str, low: f64, high: f64) -> String {
    format!(
        "DEFDAT $MACHINE PUBLIC\nFRAME $ROBROOT={{{root}}}\nREAL $SOFTN_END[12]\n$SOFTN_END[1]={low}\n$SOFTP_END[1]={high}\nENDDAT\n"
    )
}

/// A robot that stands where the world is, with a base in front of it.
fn at_the_world() -> Desk {
    let desk = Desk::new(0.02);
    desk.write("R1/Program/lines.src", PROGRAM);
    desk.write("R1/System/$config.dat", &config(1500.0, 100.0, 900.0, 0.0));
    desk
}

const REWRITE: &str = "rewrite --model model.yaml R1/Program/lines.src --frames R1/System/$config.dat --max-added 0";

/// Lines of the output, and the number of edited poses.
fn written(desk: &Desk, more: &str) -> (Vec<String>, String) {
    let run = desk.run(&format!("{REWRITE} --output out.src --force{more}")).success();
    let said = String::from_utf8_lossy(&run.get_output().stderr).into_owned();
    let text = String::from_utf8(desk.read("out.src")).unwrap();
    (text.lines().map(String::from).collect(), said)
}

/// Numbers of the lines, which may differ in their last digit.
fn numbers(lines: &[String]) -> Vec<f64> {
    let words = lines.iter().flat_map(|l| l.split(['{', '}', ',', ' ']));
    words.filter_map(|w| w.parse().ok()).collect()
}

#[test]
fn a_base_is_that_of_the_world_in_which_the_robot_stands() {
    let desk = at_the_world();
    let (plain, said) = written(&desk, "");
    assert!(said.contains("as poses: 4 moves"), "{said}");
    assert_ne!(plain, PROGRAM.lines().map(String::from).collect::<Vec<_>>());
    // 0.0 changes nothing
    desk.write("R1/Mada/$machine.dat", &machine("X 0.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0", -185.0, 185.0));
    assert_eq!(written(&desk, "").0, plain);
    // the same cell, seen from a corner of the hall: the robot stands at (2000, 300, 500), turned by a quarter
    desk.write("R1/Mada/$machine.dat", &machine("X 2000.0,Y 300.0,Z 500.0,A 90.0,B 0.0,C 0.0", -185.0, 185.0));
    desk.write("R1/System/$config.dat", &config(1900.0, 1800.0, 1400.0, 90.0));
    let (moved, said) = written(&desk, "");
    assert!(said.contains("the robot stands at $ROBROOT {X 2000.000,Y 300.000,Z 500.000,A 90.000"), "{said}");
    let (a, b) = (numbers(&plain), numbers(&moved));
    assert_eq!(a.len(), b.len());
    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 2e-4), "{plain:?}\n{moved:?}");
    // by --frames alone, where no project says it
    std::fs::rename(desk.path("R1/Mada/$machine.dat"), desk.path("machine.dat")).unwrap();
    assert_eq!(written(&desk, " --frames machine.dat").0, moved);
    // and without it the base is another place
    let elsewhere = desk.run(&format!("{REWRITE} --dry-run"));
    elsewhere.success().stderr(contains("as poses: 4 moves").not());
}

#[test]
fn two_places_of_one_robot_and_one_that_cannot_be_read_are_refused() {
    let desk = at_the_world();
    desk.write("R1/Mada/$machine.dat", &machine("X 2000.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0", -185.0, 185.0));
    desk.write("other.dat", &machine("X 1000.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0", -185.0, 185.0));
    let run = desk.run(&format!("{REWRITE} --dry-run --frames other.dat")).code(2);
    run.stderr(contains("$machine.dat:2: found another `$ROBROOT`"));
    desk.write("R1/Mada/$machine.dat", "DEFDAT $MACHINE PUBLIC\nFRAME $ROBROOT={X x0,Y 0.0}\nENDDAT\n");
    let run = desk.run(&format!("{REWRITE} --dry-run")).code(2);
    run.stderr(contains("$machine.dat:2: found a `$ROBROOT` that cannot be read"));
}

#[test]
fn offsets_do_not_lead_beyond_the_software_limits() {
    let desk = at_the_world();
    desk.write("R1/Mada/$machine.dat", &machine("X 0.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0", -185.0, 185.0));
    desk.write(
        "axes.src",
        "DEF axes( )\nPTP {A1 0.0,A2 -90.0,A3 90.0,A4 0.0,A5 60.0,A6 0.0}\nPTP {A1 80.0}\nPTP {A1 20.0}\nEND\n",
    );
    desk.write("machine.dat", &machine("X 0.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0", -80.0, 80.0));
    desk.run("rewrite --model model.yaml axes.src --dry-run").success();
    let run = desk.run("rewrite --model model.yaml axes.src --output out.src --frames machine.dat").code(1);
    run.stderr(contains("A1").and(contains("80")));
    assert!(!desk.path("out.src").exists());
    // wider ones change nothing
    desk.write("machine.dat", &machine("X 0.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0", -800.0, 800.0));
    let run = desk.run("rewrite --model model.yaml axes.src --dry-run --frames machine.dat").success();
    run.stderr(contains("software limits").not());
    desk.write("machine.dat", &machine("X 0.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0", -100.0, 100.0));
    let run = desk.run("rewrite --model model.yaml axes.src --dry-run --frames machine.dat").success();
    run.stderr(contains("the software limits of $machine.dat are narrower than those of the robot file and hold here: A1 -100.000 to 100.000 deg"));
}

/// Commands that run a program solve its Cartesian targets within the same limits as the rewriter.
#[test]
fn a_program_is_run_within_the_limits_within_which_it_is_rewritten() {
    let desk = Desk::new(0.02);
    let wide = String::from_utf8(desk.read("robot.yaml")).unwrap().replace("[-350, 350]", "[-720, 720]");
    desk.write("robot.yaml", &wide);
    let robot = Robot::parse("robot.yaml", &wide).unwrap();
    let q = [0.0, -90.0, 90.0, -5.0, 60.0, 30.0].map(f64::to_radians);
    let pose = robot.forward(&q);
    let (c, b, a) = pose.rotation.euler_angles();
    let [x, y, z] = [pose.position.x, pose.position.y, pose.position.z].map(|v| v * 1e3);
    let [a, b, c] = [a, b, c].map(f64::to_degrees);
    desk.write(
        "R1/Program/turn.src",
        &format!(
            "DEF turn( )\n$BASE=$NULLFRAME\n$TOOL={{X 156.0,Y 0.0,Z 63.0,A 0.0,B 0.0,C 0.0}}\nPTP {{A1 0.0,A2 -90.0,A3 90.0,A4 345.0,A5 60.0,A6 0.0}}\n\
             PTP {{X {x:.4},Y {y:.4},Z {z:.4},A {a:.5},B {b:.5},C {c:.5}}}\nEND\n"
        ),
    );
    desk.write("R1/System/$config.dat", &config(0.0, 0.0, 0.0, 0.0));
    for limit in [720.0, 350.0] {
        let limits = format!(
            "DEFDAT $MACHINE PUBLIC\nREAL $SOFTN_END[12]\n$SOFTN_END[4]=-{limit}\n$SOFTP_END[4]={limit}\nENDDAT\n"
        );
        desk.write("R1/Mada/$machine.dat", &limits);
        let _ = std::fs::remove_file(desk.path("log.csv"));
        desk.run("simulate --model model.yaml --input R1/Program/turn.src --output log.csv").success();
        let log = String::from_utf8(desk.read("log.csv")).unwrap();
        let mut rows = log.lines().filter(|l| !l.starts_with('#'));
        let column = rows.next().unwrap().split(',').position(|c| c == "cmd_A4_deg").unwrap();
        let last: f64 = rows.next_back().unwrap().split(',').nth(column).unwrap().parse().unwrap();
        // A4 goes on to 355 deg, where it may
        assert_eq!(last > 350.0, limit > 350.0, "{limit}: {last}");
    }
}
