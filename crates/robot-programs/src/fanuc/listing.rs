//! Position registers as the controller lists them (`POSREG.VA`).
//!
//! A listing holds the values at the time when it was written. Registers are the controller's, shared by all its programs.

use super::positions::configuration;
use crate::error::{Error, Place, Result};
use crate::registers::{Register, Registers};
use crate::script::pose::Configuration;
use std::collections::BTreeMap;

/// A register as it is read.
#[derive(Default)]
struct Open {
    number: u64,
    values: BTreeMap<String, f64>,
    configuration: Option<Configuration>,
    /// An axis in mm, or beyond the sixth: the robot's axes are others.
    other: bool,
}

impl Open {
    fn close(self) -> Option<(u64, Register)> {
        let six = |names: [&str; 6]| {
            let found = names.map(|n| self.values.get(n).copied());
            let all = found.iter().all(Option::is_some) && self.values.len() == 6 && !self.other;
            all.then(|| found.map(|v| v.unwrap_or(f64::NAN)))
        };
        let joints = six(["J1", "J2", "J3", "J4", "J5", "J6"]).map(Register::Joints);
        let pose = || Some(Register::Pose(six(["X", "Y", "Z", "W", "P", "R"])?, self.configuration?));
        Some((self.number, joints.or_else(pose)?))
    }
}

impl Registers {
    /// Whether a text is a listing of position registers.
    pub fn is_listing(text: &str) -> bool {
        let first = text.lines().find(|l| !l.trim().is_empty()).unwrap_or_default();
        first
            .trim_start()
            .strip_prefix("[*")
            .and_then(|l| l.split_once("*]"))
            .is_some_and(|l| l.1.starts_with("$POSREG"))
    }

    /// Reads a listing; `name` stands in messages. Registers that are not initialised, and those with other axes than the six of an arm,
    /// are left out.
    ///
    /// `listing = "[*POSREG*]$POSREG" ... {"[" group "," number "]" "=" comment ["Uninitialized"] {line}}`,
    /// `line = {"Group:" number | "Config:" configuration | name (":" | "=") number ["deg" | "mm"]}`
    ///
    /// # Errors
    /// A number that is none, and a register that occurs twice.
    pub fn read(name: &str, text: &str) -> Result<Self> {
        let mut found = Self::default();
        let mut open: Option<Open> = None;
        for (k, line) in text.lines().enumerate() {
            let line = line.trim_end();
            if let Some((group, number, rest)) = head(line) {
                if let Some((number, value)) = open.take().and_then(Open::close) {
                    found.positions.insert(number, value);
                }
                let there = group == 1 && !rest.ends_with("Uninitialized");
                if there && found.positions.contains_key(&number) {
                    let place = Place::line(name, k as u64 + 1);
                    return Err(Error::bad(place, format!("a second [1,{number}]"), "each register once"));
                }
                open = there.then(|| Open { number, ..Open::default() });
                // the group may stand on the line of the head, after the comment
                continue;
            }
            if let Some(register) = &mut open {
                values(name, k, line, register)?;
            }
        }
        found.positions.extend(open.and_then(Open::close));
        Ok(found)
    }
}

/// Group, number and what follows in the head of a register: `[1,16] =   '' `.
///
/// `head = "[" group "," number "]" "=" ...`
fn head(line: &str) -> Option<(u64, u64, &str)> {
    let (inside, rest) = line.trim_start().strip_prefix('[')?.split_once(']')?;
    let (group, number) = inside.split_once(',')?;
    let rest = rest.trim_start().strip_prefix('=')?;
    Some((group.trim().parse().ok()?, number.trim().parse().ok()?, rest.trim()))
}

/// The values of a line.
fn values(name: &str, k: usize, line: &str, register: &mut Open) -> Result<()> {
    if let Some((_, text)) = line.split_once("Config:") {
        register.configuration = configuration(text.as_bytes());
        return Ok(());
    }
    let mut rest = line;
    while let Some(at) = rest.find([':', '=']) {
        let field = rest[..at].split_ascii_whitespace().last().unwrap_or_default().to_ascii_uppercase();
        rest = &rest[at + 1..];
        let value = rest.split_ascii_whitespace().next().unwrap_or_default();
        let after = rest.trim_start().get(value.len()..).unwrap_or_default();
        if field == "GROUP" {
            // values of another group follow
            register.other |= value != "1";
        } else {
            let bad = || {
                let column = (line.len() - rest.trim_start().len()) as u64 + 1;
                Error::bad(Place::field(name, k as u64 + 1, column), format!("`{value}` for {field}"), "a number")
            };
            // what was never taught is written in stars
            match value.parse::<f64>().ok().filter(|v| v.is_finite()) {
                Some(v) => drop(register.values.insert(field.clone(), v)),
                None if !value.is_empty() && value.bytes().all(|b| b == b'*') => register.other = true,
                None => return Err(bad()),
            }
            let joint = field.starts_with('J');
            register.other |= joint && after.trim_start().starts_with("mm");
        }
        rest = after;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "[*POSREG*]$POSREG  Storage: SHADOW  Access: RW  : ARRAY[2,255] OF Position Reg\r\n    [1,1] =   '@Home'   Group: 1\r\n\
        \x20 J1 =   -70.000 deg   J2 =   -25.000 deg   J3 =     0.000 deg \r\n  J4 =     0.000 deg   J5 =   -90.000 deg   J6 =   -20.000 deg \r\n\r\n\
        \x20   [1,3] =   'Reserved' Uninitialized\r\n    [1,16] =   '' \r\n  Group: 1   Config: N U T, 0, 0, 0\r\n\
        \x20 X:  -606.500   Y: -1058.200   Z:  -782.000\r\n  W:     0.000   P:      .500   R:     0.000\r\n\
        \x20   [1,17] =   ''   Group: 1\r\n  J1 =  -130.224 mm  \r\n    [1,18] =   ''   Group: 1\r\n  J1 = ********   J2 = 1.0 deg\r\n\
        \x20   [2,1] =   ''   Group: 2\r\n  J1 =  -100.000 mm  \r\n";

    #[test]
    fn registers_of_group_1_are_read_as_joints_and_poses() {
        assert!(Registers::is_listing(TEXT) && !Registers::is_listing("[*SYSTEM*]$MNUFRAME  Storage: CMOS\n"));
        let found = Registers::read("POSREG.VA", TEXT).unwrap().positions;
        assert_eq!(found.keys().copied().collect::<Vec<_>>(), [1, 16]);
        assert_eq!(found[&1], Register::Joints([-70.0, -25.0, 0.0, 0.0, -90.0, -20.0]));
        let Register::Pose(values, Configuration::Fanuc { flip, up, front, turns }) = &found[&16] else { panic!() };
        assert_eq!(
            (*values, *flip, *up, *front, *turns),
            ([-606.5, -1058.2, -782.0, 0.0, 0.5, 0.0], false, true, true, [0; 3])
        );
    }

    #[test]
    fn a_number_that_is_none_and_a_second_register_are_refused_at_their_place() {
        let bad = Registers::read("P.VA", &TEXT.replace("J5 =   -90.000", "J5 =   -9x.000")).unwrap_err().to_string();
        assert!(bad.starts_with("P.VA:4:31: found `-9x.000` for J5"), "{bad}");
        let twice =
            Registers::read("P.VA", &TEXT.replace("[1,3] =   'Reserved' Uninitialized", "[1,1] =   ''")).unwrap_err();
        assert!(twice.to_string().starts_with("P.VA:6: found a second [1,1]"), "{twice}");
    }
}
