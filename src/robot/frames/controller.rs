//! Frames and tools as controllers store them.
//!
//! - KUKA `$config.dat`: `BASE_DATA[2]={X 1200.0,Y 0.0,Z 400.0,A 90.0,B 0.0,C 0.0}`, `TOOL_DATA[n]` the same; `MACHINE_FRAME_DAT[n]`
//!   and `MACHINE_DEF[n]`: which bases count from another machine than the world.
//! - KUKA `$machine.dat`: `$ROBROOT={X ...}`, the place of the robot in the world, and the software limits `$SOFTN_END[n]`,
//!   `$SOFTP_END[n]`.
//! - FANUC listings of variables (`SYSFRAME.VA`): under `$MNUFRAME` and `$MNUTOOL` an entry `[1,n] =` for group 1 and number n,
//!   then `X: 0.000 Y: 0.000 Z: 0.000` and `W: P: R:`.
//! - FANUC listings of position registers (`POSREG.VA`).
//! - Yaskawa `UFRAME.CND`: `//UFRAME 2`, in it `////BUSER x,y,z,rx,ry,rz` (user frame 2 in the robot's base); `TOOL.CND`: `//TOOL 1`,
//!   after its name the first line of six numbers (mm, deg).
//!
//! A KUKA value may name its type (`{FRAME: X 1200.0, ...}`). What is not complete (a frame that was never taught, or one of another group)
//! is left out; a file in which nothing is left is refused.

use super::Frames;
use crate::error::{Error, Place, Result};
use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use robot_programs::bases::CarriedBases;
use robot_programs::fanuc::Registers;
use robot_programs::krl::Machine;
use std::collections::BTreeMap;

/// Frames of a controller's file; `None`: no controller is known that writes it.
pub(super) fn read(name: &str, text: &str) -> Option<Result<Frames>> {
    if Registers::is_listing(text) {
        return Some(registers(name, text));
    }
    let found = of_text(text)?;
    if let Some((line, None)) = found.machine.as_ref().and_then(|m| m.root) {
        let expected = "X, Y, Z, A, B and C as numbers";
        return Some(Err(Error::bad(Place::line(name, line), "a `$ROBROOT` that cannot be read", expected)));
    }
    if !found.frames.is_empty() || !found.tools.is_empty() || found.machine.is_some() {
        return Some(Ok(found));
    }
    let nothing = "no frame and no tool that can be read".to_string();
    let (place, found, expected) = match listed(text) {
        Some((line, variable)) if !matches!(variable, "$MNUFRAME" | "$MNUTOOL") => (
            Place::line(name, line),
            format!("a listing of `{variable}`"),
            "a listing of `$MNUFRAME` and `$MNUTOOL` (SYSFRAME.VA)".to_string(),
        ),
        _ => (
            Place::file(name),
            nothing,
            "`BASE_DATA[n]={X ...}` and `TOOL_DATA[n]={X ...}` (KUKA), `$MNUFRAME` and `$MNUTOOL` with numbers for group 1 (FANUC), \
             or `//UFRAME` and `//TOOL` (Yaskawa)"
                .into(),
        ),
    };
    Some(Err(Error::bad(place, found, expected)))
}

/// Position registers of a FANUC listing.
fn registers(name: &str, text: &str) -> Result<Frames> {
    let registers = Registers::read(name, text)?;
    if registers.positions.is_empty() {
        let found = "no position register of group 1 with a value";
        return Err(Error::bad(Place::file(name), found, "`[1,n] =` and then J1 to J6, or X, Y, Z, W, P, R"));
    }
    Ok(Frames { registers, ..Frames::default() })
}

fn of_text(text: &str) -> Option<Frames> {
    if listed(text).is_some() || text.contains("$MNUFRAME") || text.contains("$MNUTOOL") {
        return Some(fanuc(text));
    }
    let condition = |l: &str| l.trim_start().starts_with("//UFRAME ") || l.trim_start().starts_with("//TOOL ");
    if text.lines().find(|l| !l.trim().is_empty()).is_some_and(condition) {
        return Some(yaskawa(text));
    }
    let kuka = |l: &str| {
        let l = l.trim_start().to_ascii_uppercase();
        ["DEFDAT", "BASE_DATA[", "TOOL_DATA[", "FRAME $ROBROOT", "$ROBROOT"].iter().any(|word| l.starts_with(word))
    };
    text.lines().any(kuka).then(|| kuka_data(text))
}

/// The variable of a FANUC listing's first line, and this line: `[*POSREG*]$POSREG  Storage: ...`.
fn listed(text: &str) -> Option<(u64, &str)> {
    let (k, line) = text.lines().enumerate().find(|(_, l)| !l.trim().is_empty())?;
    let variable = line.trim_start().strip_prefix("[*")?.split_once("*]")?.1.split_ascii_whitespace().next()?;
    Some((k as u64 + 1, variable))
}

/// X, Y, Z in mm and turns about fixed X, Y, Z in degrees.
fn frame([x, y, z, a, b, c]: [f64; 6]) -> Isometry3<f64> {
    let turn = [a, b, c].map(f64::to_radians);
    Isometry3::from_parts(
        Translation3::new(x * 1e-3, y * 1e-3, z * 1e-3),
        UnitQuaternion::from_euler_angles(turn[0], turn[1], turn[2]),
    )
}

fn kuka_data(text: &str) -> Frames {
    let machine = Machine::of(text);
    let says = machine.root.is_some() || machine.ends.iter().any(Option::is_some);
    let carried = CarriedBases::of_list(text);
    let mut found = Frames { machine: Some(machine).filter(|_| says), carried, ..Frames::default() };
    for line in text.lines() {
        let line = line.split(';').next().unwrap_or_default().trim().to_ascii_uppercase();
        for (list, name) in [(&mut found.frames, "BASE_DATA["), (&mut found.tools, "TOOL_DATA[")] {
            let Some((number, rest)) = line.strip_prefix(name).and_then(|l| l.split_once(']')) else { continue };
            let Some(inside) = rest.split_once('{').and_then(|(_, r)| r.split_once('}')).map(|r| r.0) else { continue };
            // an aggregate may name its type
            let inside = inside.split_once(':').map_or(inside, |(_, values)| values);
            let of = |key: &str| {
                let part = inside.split(',').find_map(|p| p.trim().strip_prefix(key)?.strip_prefix(' '));
                part.and_then(|p| p.trim().parse::<f64>().ok()).filter(|v| v.is_finite())
            };
            let values = ["X", "Y", "Z", "C", "B", "A"].map(of);
            if let (Ok(number), [Some(x), Some(y), Some(z), Some(c), Some(b), Some(a)]) =
                (number.trim().parse::<u32>(), values)
            {
                list.insert(number.to_string(), frame([x, y, z, c, b, a]));
            }
        }
    }
    found
}

fn yaskawa(text: &str) -> Frames {
    let mut found = Frames::default();
    // tool or user frame, and its number
    let mut open: Option<(bool, u32)> = None;
    for line in text.lines().map(str::trim) {
        let head =
            [("//TOOL ", true), ("//UFRAME ", false)].into_iter().find_map(|(w, t)| Some((line.strip_prefix(w)?, t)));
        if let Some((number, tool)) = head {
            open = number.trim().parse().ok().map(|n| (tool, n));
            continue;
        }
        let Some((tool, number)) = open else { continue };
        let list = if tool { (!line.starts_with('/')).then_some(line) } else { line.strip_prefix("////BUSER") };
        let values: Option<Vec<f64>> =
            list.and_then(|l| l.split(',').map(|v| v.trim().parse().ok().filter(|v: &f64| v.is_finite())).collect());
        if let Some(Ok(six)) = values.map(<[f64; 6]>::try_from) {
            let list = if tool { &mut found.tools } else { &mut found.frames };
            list.insert(number.to_string(), frame(six));
            open = None;
        }
    }
    found
}

fn fanuc(text: &str) -> Frames {
    let mut found = Frames::default();
    let (mut tools, mut known, mut number) = (false, false, None);
    let mut values: BTreeMap<char, f64> = BTreeMap::new();
    for line in text.lines() {
        if let Some(name) = line.find('$').map(|at| &line[at..]) {
            tools = name.starts_with("$MNUTOOL ") || name.starts_with("$MNUTOOL\t");
            known = tools || name.starts_with("$MNUFRAME ") || name.starts_with("$MNUFRAME\t");
            number = None;
        }
        // `[1,3] =`: group 1, number 3
        if let Some(inside) = line.trim_start().strip_prefix('[').and_then(|l| l.split_once(']')).map(|l| l.0) {
            let index: Vec<Option<u32>> = inside.split(',').map(|n| n.trim().parse().ok()).collect();
            values.clear();
            number = match index[..] {
                [Some(1), Some(n)] if known => Some(n),
                _ => None,
            };
        }
        let Some(n) = number else { continue };
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        for pair in words.windows(2) {
            if let ([key @ ("X:" | "Y:" | "Z:" | "W:" | "P:" | "R:"), value], Some(letter)) =
                (pair, pair[0].chars().next())
                && let Ok(v) = value.parse::<f64>()
                && v.is_finite()
                && key.len() == 2
            {
                values.insert(letter, v);
            }
        }
        let all = ['X', 'Y', 'Z', 'W', 'P', 'R'].map(|k| values.get(&k).copied());
        if let [Some(x), Some(y), Some(z), Some(w), Some(p), Some(r)] = all {
            let list = if tools { &mut found.tools } else { &mut found.frames };
            list.insert(n.to_string(), frame([x, y, z, w, p, r]));
            number = None;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn user_frames_and_tools_of_a_yaskawa_are_read_by_their_numbers() {
        let text = "//UFRAME 1\r\n///NAME TABLE\r\n///TOOL 0\r\n////BUSER 1200.000,-5.500,400.000,0.0000,0.0000,90.0000\r\n\
//UFRAME 2\r\n///NAME \r\n";
        let frames = read("f", text).unwrap().unwrap();
        let at = frames.frame("1").unwrap();
        assert!((at.translation.vector - nalgebra::Vector3::new(1.2, -0.0055, 0.4)).norm() < 1e-12);
        assert!((at * nalgebra::Vector3::x() - nalgebra::Vector3::y()).norm() < 1e-12);
        assert!(frames.frame("2").is_none() && frames.tools.is_empty());
        let text = "//TOOL 0\r\n///NAME TORCH\r\n10.000,0.000,300.000,0.0000,0.0000,0.0000\r\n0.0,0.0,0.0\r\n1.500\r\n\
0.0,0.0,0.0,0.0,0.0,0.0\r\n//TOOL 1\r\n///NAME \r\n0.000,0.000,120.500,0.0000,45.0000,0.0000\r\n";
        let tools = read("f", text).unwrap().unwrap();
        assert_eq!(tools.tool("0").unwrap().translation.vector, nalgebra::Vector3::new(0.01, 0.0, 0.3));
        assert!((tools.tool("1").unwrap().rotation.angle() - 45f64.to_radians()).abs() < 1e-12);
    }

    #[test]
    fn bases_and_tools_of_a_kuka_are_read_by_their_numbers() {
        let text = "DEFDAT $CONFIG PUBLIC\r\nBASE_DATA[2]={X 1200.0,Y -5.5,Z 400.0,A 90.0,B 0.0,C 0.0} ; table\r\n\
                    TOOL_DATA[1]={X 156.0,Y 0.0,Z 63.0,A 0.0,B 10.0,C 0.0}\r\nBASE_DATA[3]={X 1.0,Y 2.0}\r\nENDDAT\r\n";
        let found = read("f", text).unwrap().unwrap();
        assert_eq!((found.frames.len(), found.tools.len()), (1, 1));
        let base = found.frame("2").unwrap();
        assert!(
            (base.translation.vector.x - 1.2).abs() < 1e-12
                && (base.rotation.euler_angles().2.to_degrees() - 90.0).abs() < 1e-9
        );
        assert!((found.tool("1").unwrap().rotation.euler_angles().1.to_degrees() - 10.0).abs() < 1e-9);
    }

    #[test]
    fn frames_and_tools_of_a_fanuc_listing_are_read_for_group_1() {
        let text = "[*SYSTEM*]$MNUFRAME  Storage: CMOS  Access: RW  : ARRAY[2,9] OF POSITION\n\
                    \x20    [1,1] =\n  Group: 1   Config: N D B, 0, 0, 0\n  X:   100.000   Y:      .000   Z:   -20.500\n\
                    \x20 W:      .000   P:      .000   R:    90.000\n     [2,1] =\n  X: 1.0 Y: 1.0 Z: 1.0\n  W: 0 P: 0 R: 0\n\
                    [*SYSTEM*]$MNUTOOL  Storage: CMOS : ARRAY[2,10] OF POSITION\n     [1,3] =\n  Group: 1\n\
                    \x20 X: .0 Y: .0 Z: 180.0\n  W: .0 P: .0 R: .0\n     [1,4] = Uninitialized\n";
        let found = read("f", text).unwrap().unwrap();
        assert_eq!((found.frames.len(), found.tools.len()), (1, 1));
        assert!((found.frame("1").unwrap().translation.vector.z + 0.0205).abs() < 1e-12);
        assert!((found.tool("3").unwrap().translation.vector.z - 0.18).abs() < 1e-12);
    }

    #[test]
    fn a_value_of_a_kuka_may_name_its_type_and_stand_in_a_part_of_the_file() {
        let frame = "BASE_DATA[1]={FRAME: X 1.0,Y 2.0,Z 3.0,A 0.0,B 0.0,C 0.0}\n";
        for text in [frame.to_string(), format!("DEFDAT $CONFIG PUBLIC\nDECL FRAME BASE_DATA[16]\n{frame}ENDDAT\n")] {
            let found = read("f", &text).unwrap().unwrap();
            assert!((found.frame("1").unwrap().translation.vector.x - 1e-3).abs() < 1e-12);
        }
    }

    #[test]
    fn a_controllers_file_without_frames_is_refused_in_its_own_words() {
        let machine = |x: &str| {
            format!("DEFDAT $MACHINE PUBLIC\nFRAME $ROBROOT={{X {x},Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0}}\nENDDAT\n")
        };
        for (text, words) in [
            (machine("n"), "f:2: found a `$ROBROOT` that cannot be read; expected X, Y, Z, A, B and C as numbers"),
            (
                "DEFDAT $CONFIG PUBLIC\nENDDAT\n".into(),
                "f: found no frame and no tool that can be read; expected `BASE_DATA[n]",
            ),
            (
                "[*POSREG*]$POSREG  Storage: SHADOW : ARRAY[1,10] OF Position Reg\n     [1,1] =   ''\n".into(),
                "f: found no position register of group 1 with a value",
            ),
            (
                "[*SYSTEM*]$MNUFRAME  Storage: CMOS\n     [1,1] = Uninitialized\n".into(),
                "f: found no frame and no tool",
            ),
        ] {
            let refused = read("f", &text).unwrap().unwrap_err().to_string();
            assert!(refused.starts_with(words), "{refused}");
        }
    }

    #[test]
    fn a_machine_of_a_kuka_tells_where_the_robot_stands() {
        let text = "DEFDAT $MACHINE PUBLIC\nFRAME $ROBROOT={X 10.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0}\n$SOFTN_END[1]=-90.0\n$SOFTP_END[1]=80.0\nENDDAT\n";
        let machine = read("f", text).unwrap().unwrap().machine.unwrap();
        assert_eq!(machine.root.unwrap().1.unwrap().translation.vector.x, 0.01);
        assert_eq!(machine.ends[0], Some([-90.0, 80.0]));
    }

    #[test]
    fn another_text_is_no_controllers_file() {
        assert!(read("f", "schema: lostmotion/frames/1\nframes: {}\n").is_none());
    }
}
