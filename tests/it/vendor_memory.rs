//! The memory that a large vendor program takes, against what `docs/rewrite.md` promises and what is asked for before it is read.

use crate::support::bundled;
use crate::vendor_rewrite::Desk;
use std::fmt::Write;

/// What the documentation promises: so many times the size of a program, and what the process takes for itself.
const TIMES: f64 = 25.0;
const ITSELF: f64 = 30e6;
/// More moves than the verdict takes, and fewer than a FANUC program has lines.
const MOVES: usize = 22_000;

/// Six joints that turn every so many moves, deg.
fn joints(j: usize) -> [f64; 6] {
    let swing = |k: usize, centre: f64, by: f64, pace: f64| centre + by * (pace * j as f64 + k as f64).sin();
    [
        swing(0, 5.0, 20.0, 0.051),
        swing(1, 0.0, 6.0, 0.073),
        swing(2, 40.0, 12.0, 0.067),
        swing(3, 5.0, 15.0, 0.091),
        swing(4, 30.0, 14.0, 0.083),
        swing(5, 10.0, 30.0, 0.059),
    ]
}

fn list(q: &[f64], decimals: usize) -> String {
    q.iter().map(|v| format!("{v:.decimals$}")).collect::<Vec<_>>().join(", ")
}

fn krl() -> String {
    let mut text = String::from("DEF big( )\n");
    for [a, b, c, d, e, f] in (0..MOVES).map(joints) {
        let b = b - 60.0;
        writeln!(text, "PTP {{A1 {a:.4},A2 {b:.4},A3 {c:.4},A4 {d:.4},A5 {e:.4},A6 {f:.4}}}").unwrap();
    }
    text + "END\n"
}

fn rapid() -> String {
    let mut text = String::from("MODULE big\n PROC main()\n");
    for q in (0..MOVES).map(joints) {
        let external = "[9E9,9E9,9E9,9E9,9E9,9E9]";
        writeln!(text, "  MoveAbsJ [[{}],{external}],v500,z10,tool0;", list(&q, 4)).unwrap();
    }
    text + " ENDPROC\nENDMODULE\n"
}

fn fanuc() -> String {
    let mut text = String::from("/PROG  BIG\n/ATTR\nDEFAULT_GROUP\t= 1,*,*,*,*;\n/MN\n");
    for k in 1..=MOVES {
        writeln!(text, "{k:4}:J P[{k}] 50% CNT50 ;").unwrap();
    }
    text += "/POS\n";
    for (k, q) in (0..MOVES).map(joints).enumerate() {
        write!(text, "P[{}]{{\n   GP1:\n\tUF : 0, UT : 1,\t\n\t", k + 1).unwrap();
        let fields: Vec<String> = q.iter().zip(1..).map(|(v, n)| format!("J{n}= {v:9.3} deg")).collect();
        writeln!(text, "{}\n}};", fields.join(",\t")).unwrap();
    }
    text + "/END\n"
}

fn inform() -> String {
    let mut text =
        format!("/JOB\n//NAME BIG\n//POS\n///NPOS {MOVES},0,0,0,0,0\n///TOOL 0\n///POSTYPE ANGLE\n///ANGLE\n");
    for (k, q) in (0..MOVES).map(joints).enumerate() {
        writeln!(text, "C{k:05}={}", list(&q, 4).replace(' ', "")).unwrap();
    }
    text += "//INST\n///DATE 2024/05/06 07:08\n///ATTR SC,RW\n///GROUP1 RB1\nNOP\n";
    for k in 0..MOVES {
        writeln!(text, "MOVJ C{k:05} VJ=25.00 PL=1").unwrap();
    }
    text + "END\n"
}

fn urscript() -> String {
    let mut text = String::from("def big():\n");
    for q in (0..MOVES).map(joints) {
        writeln!(text, "  movej([{}], a=1.4, v=1.05)", list(&q.map(f64::to_radians), 6)).unwrap();
    }
    text + "end\n"
}

fn trajectory() -> String {
    let mut text = String::from("joint_names: [base, shoulder, elbow, wrist1, wrist2, wrist3]\npoints:\n");
    for (k, q) in (0..MOVES).map(joints).enumerate() {
        let q = list(&q.map(f64::to_radians), 6);
        let (secs, nsecs) = (k / 10, k % 10 * 100_000_000);
        writeln!(text, "- positions: [{q}]\n  time_from_start: {{secs: {secs}, nsecs: {nsecs}}}").unwrap();
    }
    text
}

fn gcode() -> String {
    let mut text = String::from("%\nO1001\nG21 G90 G17 G94\nG54\n");
    for [a, b, c, ..] in (0..2 * MOVES).map(joints) {
        writeln!(text, "G1 X{:.4} Y{:.4} Z{:.4} F3000", 500.0 + 10.0 * a, 400.0 + 5.0 * b, c - 300.0).unwrap();
    }
    text + "M30\n%\n"
}

/// Most memory, bytes, of a rewrite of a program, as the command itself says with `--verbose`; and the size of the program.
fn most_memory(name: &str, text: &str, robot: &str, joint: &str) -> (f64, f64) {
    let desk = Desk::new(0.005);
    let robot = bundled(&format!("configs/{robot}.yaml"));
    std::fs::copy(robot, desk.path("robot.yaml")).unwrap();
    let model = String::from_utf8(desk.read("model.yaml")).unwrap();
    let gap = if joint == "X" { "half_gap_mm: 0.01" } else { "half_gap_deg: 0.005" };
    desk.write(
        "model.yaml",
        &model.replace("half_gap_deg: 0.005", gap).replace("joint: A1", &format!("joint: {joint}")),
    );
    desk.write(name, text);
    let done = desk.run(&format!("--verbose rewrite --model model.yaml {name} --output out-{name}")).success();
    let said = String::from_utf8(done.get_output().stderr.clone()).unwrap();
    assert_ne!(desk.read(&format!("out-{name}")), text.as_bytes(), "{name}: nothing was rewritten");
    let mb = said
        .split("at most ")
        .nth(1)
        .and_then(|rest| rest.split(" MB of memory").next())
        .and_then(|mb| mb.parse().ok());
    let mb: f64 = mb.unwrap_or_else(|| panic!("{said}"));
    (mb * 1e6, text.len() as f64)
}

#[cfg(target_os = "linux")]
#[test]
fn a_large_vendor_program_takes_no_more_memory_than_is_promised() {
    for (name, text, robot, joint) in [
        ("big.src", krl(), "kuka-kr120-r2500-pro", "A1"),
        ("big.mod", rapid(), "abb-irb6640-185-280", "J1"),
        ("big.ls", fanuc(), "fanuc-m20ia", "J1"),
        ("big.JBI", inform(), "motoman-ma2010", "S"),
        ("big.script", urscript(), "universal-robots-ur10e", "base"),
        ("big.yaml", trajectory(), "universal-robots-ur10e", "base"),
        ("big.nc", gcode(), "gantry-xyz-ballscrew", "X"),
    ] {
        let (memory, size) = most_memory(name, &text, robot, joint);
        assert!(memory <= TIMES * size + ITSELF, "{name}: {:.1} times its size", memory / size);
    }
}
