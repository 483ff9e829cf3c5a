//! Which column of a file is what.

use crate::robot::Robot;

/// Meaning of a column; `axis` counts the robot's axes, `k` the reflectors from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Meaning {
    Time,
    Command(usize),
    Encoder(usize),
    Measured(usize),
    /// Coordinate 0, 1 or 2 of reflector `k`.
    Position {
        k: usize,
        coordinate: usize,
    },
    Trigger,
    Cycle,
    Speed,
    Payload,
    Temperature,
    Index,
    Other,
}

/// Meaning of a contract's column name, case ignored.
pub fn meaning(name: &str, robot: &Robot) -> Meaning {
    let name = name.trim().to_ascii_lowercase();
    match name.as_str() {
        "t_s" => return Meaning::Time,
        "trigger" => return Meaning::Trigger,
        "cycle" => return Meaning::Cycle,
        "speed_mm_s" => return Meaning::Speed,
        "payload_kg" => return Meaning::Payload,
        "temp_c" => return Meaning::Temperature,
        "index" => return Meaning::Index,
        _ => {}
    }
    for (prefix, make) in
        [("cmd_", Meaning::Command as fn(usize) -> Meaning), ("enc_", Meaning::Encoder), ("meas_", Meaning::Measured)]
    {
        if let Some(rest) = name.strip_prefix(prefix) {
            for (axis, joint) in robot.axis_joints().enumerate() {
                if rest == format!("{}_{}", joint.name.to_ascii_lowercase(), joint.kind.unit()) {
                    return make(axis);
                }
            }
        }
    }
    if let Some(rest) = name.strip_suffix("_mm") {
        let (letter, number) = rest.split_at(rest.len().min(1));
        if let Some(coordinate) = ["x", "y", "z"].iter().position(|c| *c == letter) {
            if number.is_empty() {
                return Meaning::Position { k: 0, coordinate };
            }
            if let Ok(n) = number.parse::<usize>()
                && (2..=99).contains(&n)
            {
                return Meaning::Position { k: n - 1, coordinate };
            }
        }
    }
    Meaning::Other
}
