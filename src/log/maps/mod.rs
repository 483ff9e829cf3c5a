//! Column maps that ship with the program, by name: `--columns rtde`. Each file says where its names are described in public.
//!
//! Controllers: `rtde` (Universal Robots), `rws` (ABB), `rsi` (KUKA). Trackers: `tracker`, for the names that exports commonly bear.
//!
//! Fails: for a maker whose export is not described in public, with what to do instead.

use super::ColumnMap;
use crate::error::{Error, Result};

/// Name and text of each map.
pub const MAPS: [(&str, &str); 4] = [
    ("rsi", include_str!("rsi.yaml")),
    ("rtde", include_str!("rtde.yaml")),
    ("rws", include_str!("rws.yaml")),
    ("tracker", include_str!("tracker.yaml")),
];
/// Makers and software whose export has the columns that its user chose.
const UNDESCRIBED: [&str; 6] = ["api", "faro", "ksetup", "leica", "polyworks", "spatialanalyzer"];

/// A map by its name; `None`: no such name.
pub fn named(name: &str) -> Option<Result<ColumnMap>> {
    if UNDESCRIBED.contains(&name) {
        let expected = "`tracker` (common names: Time, X, Y, Z), or your own map as in docs/log.md";
        let found = format!("`{name}`, whose exports have columns that the user chooses");
        return Some(Err(Error::setting("columns", found, expected)));
    }
    let (name, text) = MAPS.iter().find(|m| m.0 == name)?;
    Some(ColumnMap::parse(name, text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::bag::TopicChoice;
    use crate::io::input::Input;
    use crate::log::Log;
    use crate::log::recording::Recording;
    use crate::robot::Robot;

    fn robot() -> Robot {
        let text = "schema: lostmotion/robot/1\njoints:\n  - {name: base, kind: revolute, a_mm: 500}\n  - {name: elbow, kind: revolute, a_mm: 300}\n";
        Robot::parse("robot.yaml", text).unwrap()
    }

    fn input(text: &str) -> Input {
        Input { name: "log.csv".into(), bytes: text.into(), sha256: String::new() }
    }

    #[test]
    fn every_map_is_one_and_names_joints_by_number() {
        for (name, _) in MAPS {
            named(name).unwrap().unwrap();
        }
        let map = named("rtde").unwrap().unwrap();
        let text = "timestamp target_q_0 target_q_1 target_q_2 robot_mode\n0.002 0.5 -0.25 7 1\n0.004 0.6 -0.25 7 1\n";
        let log = Log::parse_with(input(text), &robot(), Some(&map)).unwrap();
        assert_eq!(log.command(0), [0.5, -0.25]);
        let map = named("tracker").unwrap().unwrap();
        let seen =
            Recording::parse(input("Time;X;Y;Z\n1;500;1.5;-2\n"), &robot(), Some(&map), TopicChoice::Places).unwrap();
        assert_eq!(seen.channels.len(), 4);
    }

    #[test]
    fn a_file_of_another_recorder_is_refused_with_the_names_that_are_sought() {
        let map = named("rsi").unwrap().unwrap();
        let error = Log::parse_with(input("a,b\n1,2\n"), &robot(), Some(&map)).unwrap_err().to_string();
        assert!(error.contains("none of the columns that rsi names") && error.contains("ASPos.A1"), "{error}");
        let error = named("faro").unwrap().unwrap_err().to_string();
        assert!(error.contains("tracker"), "{error}");
    }
}
