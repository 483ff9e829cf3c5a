//! What a column is, by the contract's name, and the name of what a column is.

use crate::robot::{Joint, Robot};

/// Meaning of a column; `axis` counts the robot's axes, `k` the reflectors from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Meaning {
    /// Time, s.
    Time,
    /// Command of an axis, rad or m.
    Command(usize),
    /// Motor encoder of an axis, at the joint's scale, rad or m.
    Encoder(usize),
    /// Between the two gaps of a drive: after the coupling, before the nut or gear; at the joint's scale.
    Screw(usize),
    /// Position of an axis measured after its gear, rad or m.
    Measured(usize),
    /// Encoder or screw of a prismatic joint as an angle of its screw: read, it is one of the above.
    EncoderAngle(usize),
    /// Angle of the screw of an axis, rad.
    ScrewAngle(usize),
    /// Coordinate 0, 1 or 2 of reflector `k`.
    Position {
        /// Number of the reflector, from 0.
        k: usize,
        /// 0, 1, 2 for x, y, z.
        coordinate: usize,
    },
    /// Mark of a reading that was triggered at a standstill.
    Trigger,
    /// Number of the cycle of a static test.
    Cycle,
    /// Distance from a fixed point; its difference from a nominal length; reading along a direction.
    Distance,
    /// Deviation of a ballbar from its nominal length, m.
    DistanceOff,
    /// Reading of a dial gauge, m.
    Dial,
    /// Part 0 to 3 (w, x, y, z) of the tool's orientation.
    Orientation(usize),
    /// Torque of an axis, N m.
    Torque(usize),
    /// Component 0, 1 or 2 (x, y, z) of the force on the tool, N, world frame of the robot.
    Force(usize),
    /// TCP speed, m/s.
    Speed,
    /// Payload, kg.
    Payload,
    /// Temperature, degrees Celsius.
    Temperature,
    /// Number of the row or point.
    Index,
    /// A column that has no meaning here and is ignored.
    Other,
}

/// Meaning of a contract's column name, case ignored.
pub fn meaning(name: &str, robot: &Robot) -> Meaning {
    let name = name.trim().to_ascii_lowercase();
    match name.as_str() {
        "t_s" => return Meaning::Time,
        "trigger" => return Meaning::Trigger,
        "cycle" => return Meaning::Cycle,
        "r_mm" => return Meaning::Distance,
        "r_um" => return Meaning::DistanceOff,
        "dial_um" => return Meaning::Dial,
        "qw" => return Meaning::Orientation(0),
        "qx" => return Meaning::Orientation(1),
        "qy" => return Meaning::Orientation(2),
        "qz" => return Meaning::Orientation(3),
        "fx_n" => return Meaning::Force(0),
        "fy_n" => return Meaning::Force(1),
        "fz_n" => return Meaning::Force(2),
        "speed_mm_s" => return Meaning::Speed,
        "payload_kg" => return Meaning::Payload,
        "temp_c" => return Meaning::Temperature,
        "index" => return Meaning::Index,
        _ => {}
    }
    type Make = fn(usize) -> Meaning;
    let columns: [(&str, Make, Option<Make>); 4] = [
        ("cmd_", Meaning::Command, None),
        ("enc_", Meaning::Encoder, Some(Meaning::EncoderAngle)),
        ("screw_", Meaning::Screw, Some(Meaning::ScrewAngle)),
        ("meas_", Meaning::Measured, None),
    ];
    for (prefix, make, angle) in columns {
        let Some((joint, unit)) = name.strip_prefix(prefix).and_then(|rest| rest.rsplit_once('_')) else { continue };
        let named = |j: &Joint| j.name.eq_ignore_ascii_case(joint);
        let Some((axis, joint)) = robot.axis_joints().enumerate().find(|(_, j)| named(j)) else { continue };
        match angle {
            _ if unit == joint.kind.unit() => return make(axis),
            Some(angle) if unit == "deg" && joint.lead_m_per_rev.is_some() => return angle(axis),
            _ => {}
        }
    }
    if let Some(joint) = name.strip_prefix("torque_").and_then(|rest| rest.strip_suffix("_nm")) {
        let axis = robot.axis_joints().position(|j| j.name.eq_ignore_ascii_case(joint));
        return axis.map_or(Meaning::Other, Meaning::Torque);
    }
    if let Some(rest) = name.strip_suffix("_mm") {
        let mut letters = rest.chars();
        let coordinate = letters.next().and_then(|c| ['x', 'y', 'z'].iter().position(|k| *k == c));
        if let Some(coordinate) = coordinate {
            if letters.as_str().is_empty() {
                return Meaning::Position { k: 0, coordinate };
            }
            if let Ok(n) = letters.as_str().parse::<usize>()
                && (2..=99).contains(&n)
            {
                return Meaning::Position { k: n - 1, coordinate };
            }
        }
    }
    Meaning::Other
}

impl Meaning {
    /// Unit in which the contract's name gives the value.
    pub(super) fn unit(self, robot: &Robot) -> Option<&'static str> {
        match self {
            Self::Time => Some("s"),
            Self::Command(axis) | Self::Encoder(axis) | Self::Screw(axis) | Self::Measured(axis) => {
                Some(robot.axis(axis).kind.unit())
            }
            Self::EncoderAngle(_) | Self::ScrewAngle(_) => Some("deg"),
            Self::Position { .. } | Self::Distance => Some("mm"),
            Self::DistanceOff | Self::Dial => Some("um"),
            Self::Speed => Some("mm_s"),
            _ => None,
        }
    }

    /// What a screw's angle measures, and metres per radian of it; else itself and 1.
    pub fn of_joint(self, robot: &Robot) -> (Self, f64) {
        let lead = |axis: usize| robot.axis(axis).lead_m_per_rev.unwrap_or(0.0) / std::f64::consts::TAU;
        match self {
            Self::EncoderAngle(axis) => (Self::Encoder(axis), lead(axis)),
            Self::ScrewAngle(axis) => (Self::Screw(axis), lead(axis)),
            other => (other, 1.0),
        }
    }

    /// Contract's name, for messages.
    pub fn name(self, robot: &Robot) -> String {
        let joint = |prefix: &str, axis: usize| {
            let j = robot.axis(axis);
            format!("{prefix}_{}_{}", j.name, j.kind.unit())
        };
        match self {
            Self::Time => "t_s".into(),
            Self::Command(axis) => joint("cmd", axis),
            Self::Encoder(axis) => joint("enc", axis),
            Self::Screw(axis) => joint("screw", axis),
            Self::Measured(axis) => joint("meas", axis),
            Self::EncoderAngle(axis) => format!("enc_{}_deg", robot.axis(axis).name),
            Self::ScrewAngle(axis) => format!("screw_{}_deg", robot.axis(axis).name),
            Self::Position { k, coordinate } => {
                let number = if k == 0 { String::new() } else { (k + 1).to_string() };
                format!("{}{number}_mm", ["x", "y", "z"][coordinate.min(2)])
            }
            Self::Distance => "r_mm".into(),
            Self::DistanceOff => "r_um".into(),
            Self::Dial => "dial_um".into(),
            Self::Orientation(part) => ["qw", "qx", "qy", "qz"][part.min(3)].into(),
            Self::Torque(axis) => format!("torque_{}_nm", robot.axis(axis).name),
            Self::Force(part) => ["fx_n", "fy_n", "fz_n"][part.min(2)].into(),
            Self::Trigger => "trigger".into(),
            Self::Cycle => "cycle".into(),
            Self::Speed => "speed_mm_s".into(),
            Self::Payload => "payload_kg".into(),
            Self::Temperature => "temp_c".into(),
            Self::Index => "index".into(),
            Self::Other => "other".into(),
        }
    }
}
