//! A static test as a program of the robot's own language, so that it runs as it is written.
//!
//! Every leg is a joint motion that stops exactly, every dwell a wait. FANUC, RAPID and URScript take the time of a leg; KRL and INFORM
//! take a share of the joints' largest speeds, which is therefore in the robot file. Joints have the decimals that the language holds, and
//! every visit of a place is written with the same digits. What is written is read again by [`crate::program::Program`] in the tests.
//!
//! A path or an excitation is no program of few targets: it stays a table for controllers that stream positions.

use super::legs::{Leg, legs};
use super::{Kind, Recording};
use crate::error::{Error, Result};
use crate::robot::{Joint, JointKind, Robot};
use std::fmt::Write;

/// Shortest time that a leg is given, s: FANUC's unit.
const SHORTEST_S: f64 = 0.1;
/// Acceleration of KRL's joints, percent of the largest.
const KRL_ACCELERATION: u32 = 20;

/// A language that a static test can be written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Language {
    /// FANUC TP, `.ls`.
    Fanuc,
    /// ABB RAPID, `.mod`.
    Rapid,
    /// KUKA KRL, `.src`.
    Krl,
    /// Yaskawa INFORM, `.jbi`.
    Inform,
    /// Universal Robots, `.script`.
    UrScript,
    /// G-code, `.nc` and others.
    Gcode,
}

impl Language {
    /// The language of a format by its name in [`crate::program::formats`].
    pub fn of_format(name: &str) -> Option<Self> {
        Some(match name {
            "fanuc" => Self::Fanuc,
            "rapid" => Self::Rapid,
            "krl" => Self::Krl,
            "inform" => Self::Inform,
            "urscript" => Self::UrScript,
            "gcode" => Self::Gcode,
            _ => return None,
        })
    }
}

/// The program, named `name` (letters and digits of it).
///
/// # Errors
/// Where the plan is no static test, or the language cannot move such a robot.
pub fn program(recording: &Recording, robot: &Robot, language: Language, name: &str) -> Result<Vec<u8>> {
    if recording.kind != Kind::Static {
        let found = format!("the {} program as one of a vendor's language", recording.kind.name());
        let expected =
            "a table (.csv): only a static test has few enough targets; your own program, run slowly, is a path, too";
        return Err(Error::setting("output", found, expected));
    }
    let legs = legs(&recording.rows);
    let name = identifier(name, language);
    let text = match language {
        Language::Fanuc => fanuc(&legs, robot, &name)?,
        Language::Rapid => rapid(&legs, robot, &name)?,
        Language::Krl => krl(&legs, robot, &name)?,
        Language::Inform => inform(&legs, robot, &name)?,
        Language::UrScript => urscript(&legs, robot, &name)?,
        Language::Gcode => gcode(&legs, robot)?,
    };
    // what INFORM's controllers read and write
    let text = if language == Language::Inform { text.replace('\n', "\r\n") } else { text };
    Ok(text.into_bytes())
}

/// The program's name in capitals: letters, digits and `_`, a letter first. KRL, FANUC and INFORM want the name of the file; in RAPID and
/// URScript the name of a word of the language (`TEST`, `MAIN`, `sleep`) would be refused or called, so there it gets an end.
fn identifier(name: &str, language: Language) -> String {
    let mut id: String = name.chars().filter(|c| c.is_ascii_alphanumeric() || *c == '_').take(20).collect();
    id.make_ascii_uppercase();
    if !id.starts_with(|c: char| c.is_ascii_alphabetic()) {
        id.insert(0, 'T');
    }
    if matches!(language, Language::Rapid | Language::UrScript) { format!("{id}_LM") } else { id }
}

fn refuse(found: String, expected: &str) -> Error {
    Error::setting("output", found, expected)
}

/// Refuses robots with more joints than the language's targets have, or with joints that slide.
fn needs_arm(robot: &Robot, most: usize, language: &str) -> Result<()> {
    let slides = robot.axis_joints().find(|j| j.kind == JointKind::Prismatic);
    if let Some(joint) = slides {
        return Err(refuse(
            format!("{}, which slides, in {language}", joint.name),
            "an arm of joints that turn, or a table (.csv)",
        ));
    }
    if robot.dof() > most {
        return Err(refuse(
            format!("{} joints in {language}", robot.dof()),
            "at most as many as its targets have, or a table (.csv)",
        ));
    }
    Ok(())
}

/// Refuses robots whose joints have names that do not tell their numbers in a target.
fn needs_numbers(robot: &Robot, told: bool) -> Result<()> {
    if told {
        return Ok(());
    }
    let names: Vec<&str> = robot.axis_joints().map(|j| j.name.as_str()).collect();
    Err(refuse(
        format!("joints {}, whose numbers in a target are not certain", names.join(", ")),
        "the joints of the arm named J1, J2, ... by these numbers, those after it E1, E2, ..., or a table (.csv)",
    ))
}

/// Values of a target in deg or mm, with so many decimals.
fn values(robot: &Robot, q: &[f64], decimals: usize) -> Vec<String> {
    let edge = |(joint, v): (&Joint, &f64)| {
        let text = format!("{:.decimals$}", joint.kind.to_user_unit(*v));
        let zero = text.trim_start_matches('-').bytes().all(|b| matches!(b, b'0' | b'.'));
        if zero { text.trim_start_matches('-').to_string() } else { text }
    };
    robot.axis_joints().zip(q).map(edge).collect()
}

/// Time of a leg in tenths of a second, rounded up.
fn tenths(leg: &Leg) -> f64 {
    ((leg.time_s / SHORTEST_S - 1e-6).ceil() * SHORTEST_S).max(SHORTEST_S)
}

/// Share of the largest speeds that a leg takes, percent; refused where the robot file has none.
fn percent(robot: &Robot, leg: &Leg) -> Result<f64> {
    let mut share = 0f64;
    for (joint, v) in robot.axis_joints().zip(&leg.speed) {
        let most = joint.max_speed.filter(|m| *m > 0.0).ok_or_else(|| {
            let key = if joint.kind == JointKind::Revolute { "max_speed_deg_s" } else { "max_speed_mm_s" };
            refuse(format!("no {key} of {} in the robot file", joint.name), "it: the language takes a share of it")
        })?;
        share = share.max(100.0 * v / most);
    }
    Ok(share)
}

/// Joints of an arm in a target.
const OF_ARM: usize = 6;

const HEAD: &str =
    "Static test for lostmotion: every place from both sides. It knows no obstacles: run it slowly first.";

fn fanuc(legs: &[Leg], robot: &Robot, name: &str) -> Result<String> {
    needs_arm(robot, 9, "FANUC TP")?;
    // older names of E1, ... go on after those of the arm
    let places = robot.axes().places();
    let external = |axis: usize| places.external.iter().find(|e| e.1 == axis).map(|e| OF_ARM + e.0);
    let numbers: Vec<usize> =
        (0..robot.dof()).map(|axis| places.number(axis).or_else(|| external(axis)).unwrap_or(axis + 1)).collect();
    let mut lines: Vec<String> = vec!["!Static test for lostmotion".into(), "!It knows no obstacles".into()];
    let mut positions = String::new();
    let mut places: Vec<Vec<String>> = Vec::new();
    for leg in legs {
        let joints = values(robot, &leg.to, 3);
        let index = places.iter().position(|p| *p == joints).unwrap_or_else(|| {
            places.push(joints);
            places.len() - 1
        });
        let speed = if leg.time_s > 0.0 { format!("{:.1}sec", tenths(leg)) } else { "10%".into() };
        lines.push(format!("J P[{}] {speed} FINE", index + 1));
        if leg.stand_s > 0.0 {
            lines.push(format!("  WAIT {:7.2}(sec)", leg.stand_s));
        }
    }
    for (i, joints) in places.iter().enumerate() {
        let mut fields: Vec<(usize, &String)> = numbers.iter().copied().zip(joints).collect();
        fields.sort_unstable();
        let fields: Vec<String> = fields.iter().map(|(n, v)| format!("J{n}= {v:>9} deg")).collect();
        let rows: Vec<String> = fields.chunks(3).map(|c| format!("\t{}", c.join(",\t"))).collect();
        let _ = writeln!(positions, "P[{}]{{\n   GP1:\n\tUF : 0, UT : 1,\t\n{}\n}};", i + 1, rows.join(",\n"));
    }
    let mut text = format!(
        "/PROG  {name}\n/ATTR\nOWNER\t\t= MNEDITOR;\nCOMMENT\t\t= \"static test\";\nPROG_SIZE\t= 0;\nFILE_NAME\t= ;\nVERSION\t\t= 0;\n\
         LINE_COUNT\t= {};\nMEMORY_SIZE\t= 0;\nPROTECT\t\t= READ_WRITE;\nDEFAULT_GROUP\t= 1,*,*,*,*;\n/MN\n",
        lines.len()
    );
    for (i, line) in lines.iter().enumerate() {
        let motion = line.starts_with("J ");
        let _ = writeln!(text, "{:4}:{}{line}    ;", i + 1, if motion || line.starts_with(' ') { "" } else { "  " });
    }
    let _ = write!(text, "/POS\n{positions}/END\n");
    Ok(text)
}

fn rapid(legs: &[Leg], robot: &Robot, name: &str) -> Result<String> {
    needs_arm(robot, 6, "RAPID")?;
    let places = robot.axes().places();
    needs_numbers(robot, places.certain && places.numbered)?;
    let mut text = format!("MODULE {name}\n  ! {HEAD}\n  PROC main()\n");
    for leg in legs {
        let own = values(robot, &leg.to, 4);
        let mut joints = vec!["0".to_string(); OF_ARM];
        let mut external = vec!["9E9".to_string(); OF_ARM];
        for (axis, value) in own.into_iter().enumerate() {
            let of_arm = places.number(axis).and_then(|n| joints.get_mut(n - 1));
            let place = of_arm.or_else(|| {
                let number = places.external.iter().find(|e| e.1 == axis)?.0;
                external.get_mut(number - 1)
            });
            if let Some(place) = place {
                *place = value;
            }
        }
        let time = if leg.time_s > 0.0 { format!("\\T:={:.1}", tenths(leg)) } else { String::new() };
        let (joints, external) = (joints.join(","), external.join(","));
        let _ = writeln!(text, "    MoveAbsJ [[{joints}],[{external}]],v50{time},fine,tool0;");
        if leg.stand_s > 0.0 {
            let _ = writeln!(text, "    WaitTime {:.2};", leg.stand_s);
        }
    }
    text.push_str("  ENDPROC\nENDMODULE\n");
    Ok(text)
}

fn krl(legs: &[Leg], robot: &Robot, name: &str) -> Result<String> {
    needs_arm(robot, 6, "KRL")?;
    let mut text = format!(
        "DEF {name}( )\n; {HEAD}\nINT I\nBAS(#INITMOV,0)\nFOR I=1 TO 6\n  $VEL_AXIS[I]=10\n  $ACC_AXIS[I]={KRL_ACCELERATION}\nENDFOR\n"
    );
    let names = krl_names(robot)?;
    let mut set = 10.0;
    for leg in legs {
        let share = if leg.time_s > 0.0 { percent(robot, leg)?.floor().clamp(1.0, 100.0) } else { set };
        if share != set {
            let _ = writeln!(text, "FOR I=1 TO 6\n  $VEL_AXIS[I]={share:.0}\nENDFOR");
            set = share;
        }
        let joints: Vec<String> =
            names.iter().zip(values(robot, &leg.to, 4)).map(|(n, v)| format!("{n} {v}")).collect();
        let _ = writeln!(text, "PTP {{{}}}", joints.join(","));
        if leg.stand_s > 0.0 {
            let _ = writeln!(text, "WAIT SEC {:.2}", leg.stand_s);
        }
    }
    text.push_str("END\n");
    Ok(text)
}

/// Names of the axes in an aggregate: the joints' own where all are such, else by their numbers, as programs are read.
fn krl_names(robot: &Robot) -> Result<Vec<String>> {
    let own: Vec<String> = robot.axis_joints().map(|j| j.name.to_ascii_uppercase()).collect();
    let is = |n: &String| matches!(n.as_bytes(), [b'A' | b'E', b'1'..=b'6']);
    if own.iter().all(is) {
        return Ok(own);
    }
    let places = robot.axes().places();
    needs_numbers(robot, places.certain && places.numbered)?;
    let external = |axis: usize| places.external.iter().find(|e| e.1 == axis).map(|e| format!("E{}", e.0));
    let name = |axis: usize| places.number(axis).map(|n| format!("A{n}")).or_else(|| external(axis));
    Ok((0..own.len()).filter_map(name).collect())
}

fn inform(legs: &[Leg], robot: &Robot, name: &str) -> Result<String> {
    needs_arm(robot, 8, "INFORM")?;
    let line = crate::program::inform::places_on_line(robot.axes());
    needs_numbers(robot, line.is_some())?;
    let line = line.unwrap_or_default();
    let mut pulses: Vec<Vec<String>> = Vec::new();
    let mut steps = String::new();
    for leg in legs {
        let mut row = vec!["0".to_string(); line.iter().map(|k| k + 1).fold(OF_ARM, usize::max)];
        for ((joint, v), place) in robot.axis_joints().zip(&leg.to).zip(&line) {
            let scale = joint.pulses.ok_or_else(|| {
                refuse(format!("no pulses_per_deg of {} in the robot file", joint.name), "it: a job holds pulses")
            })?;
            if let Some(number) = row.get_mut(*place) {
                *number = format!("{:.0}", (v * scale).round() + 0.0);
            }
        }
        let speed = if leg.time_s > 0.0 { percent(robot, leg)?.clamp(0.01, 100.0) } else { 5.0 };
        let _ = writeln!(steps, "MOVJ C{:05} VJ={speed:.2} PL=0", pulses.len());
        pulses.push(row);
        if leg.stand_s > 0.0 {
            let _ = writeln!(steps, "TIMER T={:.2}", leg.stand_s);
        }
    }
    let mut text = format!(
        "/JOB\n//NAME {name}\n//POS\n///NPOS {},0,0,0,0,0\n///TOOL 0\n///POSTYPE PULSE\n///PULSE\n",
        pulses.len()
    );
    for (i, row) in pulses.iter().enumerate() {
        let _ = writeln!(text, "C{i:05}={}", row.join(","));
    }
    let _ = write!(
        text,
        "//INST\n///DATE 2026/01/01 00:00\n///ATTR SC,RW\n///GROUP1 RB1\nNOP\n'STATIC TEST FOR LOSTMOTION\n{steps}END\n"
    );
    Ok(text)
}

fn urscript(legs: &[Leg], robot: &Robot, name: &str) -> Result<String> {
    needs_arm(robot, 6, "URScript")?;
    if robot.dof() != 6 {
        return Err(refuse(format!("{} joints in URScript", robot.dof()), "six, or a table (.csv)"));
    }
    let places = robot.axes().places();
    needs_numbers(robot, places.numbered && places.external.is_empty())?;
    let name = name.to_lowercase();
    let mut text = format!("# {HEAD}\ndef {name}():\n");
    for leg in legs {
        let mut joints: Vec<(usize, f64)> = places.numbers.iter().copied().zip(leg.to.iter().copied()).collect();
        joints.sort_by_key(|j| j.0);
        let joints: Vec<String> = joints.iter().map(|(_, v)| format!("{v:.7}")).collect();
        let time = if leg.time_s > 0.0 { format!("t={:.1}", tenths(leg)) } else { "a=0.3, v=0.2".into() };
        let _ = writeln!(text, "  movej([{}], {time})", joints.join(", "));
        if leg.stand_s > 0.0 {
            let _ = writeln!(text, "  sleep({:.2})", leg.stand_s);
        }
    }
    text.push_str("end\n");
    Ok(text)
}

fn gcode(legs: &[Leg], robot: &Robot) -> Result<String> {
    let names: Vec<String> = robot.axis_joints().map(|j| j.name.to_ascii_uppercase()).collect();
    if let Some(name) = names.iter().find(|n| !matches!(n.as_str(), "X" | "Y" | "Z" | "U" | "V" | "W")) {
        return Err(refuse(format!("an axis {name} in G-code"), "axes X, Y, Z, U, V, W in mm, or a table (.csv)"));
    }
    if let Some(joint) = robot.axis_joints().find(|j| j.kind != JointKind::Prismatic) {
        return Err(refuse(format!("{}, which turns, in G-code", joint.name), "axes in mm, or a table (.csv)"));
    }
    let mut text = format!(
        "%\n({HEAD})\n(Positions of the axes: clear the work offset and the tool length before you run it)\n\
         (G4 P counts seconds here: a control that counts milliseconds needs 1000 times as much)\n"
    );
    let diameter = robot.axes().control.diameter == Some(true);
    if diameter {
        text.push_str("(X words are diameters)\n");
    }
    text.push_str("G21 G90 G94 G61 G49\n");
    let factor = |name: &String| if diameter && name == "X" { 2.0 } else { 1.0 };
    for leg in legs {
        let to: Vec<f64> = leg.to.iter().zip(&names).map(|(v, name)| v * factor(name)).collect();
        let words: Vec<String> = names.iter().zip(values(robot, &to, 3)).map(|(n, v)| format!("{n}{v}")).collect();
        let mm_min = leg.speed.iter().map(|v| v * v).sum::<f64>().sqrt() * 60e3;
        let feed = if leg.time_s > 0.0 { mm_min.max(1.0) } else { 600.0 };
        let _ = writeln!(text, "G1 {} F{feed:.0}", words.join(" "));
        if leg.stand_s > 0.0 {
            let _ = writeln!(text, "G4 P{:.2}", leg.stand_s);
        }
    }
    text.push_str("M30\n%\n");
    Ok(text)
}
