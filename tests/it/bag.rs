//! Recordings of ROS 2: what other people's writers stored is what is read (tests/oracle/bag.py).

use crate::support::bundled;
use lostmotion::io::bag::{self, TopicChoice};
use lostmotion::io::input::{self, Input};
use lostmotion::log::ColumnMap;
use lostmotion::log::columns::Meaning;
use lostmotion::log::recording::Recording;
use lostmotion::robot::Robot;

fn file() -> Input {
    input::read(&bundled("tests/data/ros2.mcap")).unwrap()
}

fn robot() -> Robot {
    let text = "schema: lostmotion/robot/1\njoints:\n  - {name: base, kind: revolute, a_mm: 500}\n  - {name: elbow, kind: revolute, a_mm: 300}\n";
    Robot::parse("robot.yaml", text).unwrap()
}

#[test]
fn joint_states_are_commands_of_the_joints_of_that_name() {
    let seen = Recording::parse(file(), &robot(), None, TopicChoice::Joints).unwrap();
    assert_eq!(seen.rows(), 200);
    let of = |meaning: Meaning| seen.values(meaning).unwrap();
    for k in 0..200 {
        let t = k as f64 / 100.0;
        assert!((of(Meaning::Time)[k] - t).abs() < 1e-9);
        assert!((of(Meaning::Command(0))[k] - 0.3 * t.sin()).abs() < 1e-15);
        assert!((of(Meaning::Command(1))[k] - (-0.5 + 0.2 * t)).abs() < 1e-15);
        assert!((of(Meaning::Torque(0))[k] - 12.5 * t.cos()).abs() < 1e-12);
    }
}

#[test]
fn poses_are_places_of_the_tcp() {
    let seen = Recording::parse(file(), &robot(), None, TopicChoice::Places).unwrap();
    let places = seen.positions_m();
    assert_eq!(places.len(), 100);
    for (k, place) in places.into_iter().enumerate() {
        let t = k as f64 / 50.0;
        let expected = nalgebra::Vector3::new(0.8 + 0.01 * t, -0.2, 0.05 * t);
        assert!((place.unwrap() - expected).norm() < 1e-12);
    }
}

#[test]
fn a_recording_with_several_topics_asks_which() {
    let error = bag::unpacked(file(), TopicChoice::Any).unwrap_err().to_string();
    assert!(error.contains("/joint_states, /tracker/pose") && error.contains("topic"), "{error}");
    let error = bag::unpacked(file(), TopicChoice::Topic("/joints")).unwrap_err().to_string();
    assert!(error.contains("topic /joints"), "{error}");
    let map = "schema: lostmotion/columns/1\ntopic: /joint_states\ncolumns:\n  t_s: t_s\n  position.base: {to: meas_base_deg, unit: rad}\n";
    let map = ColumnMap::parse("map.yaml", map).unwrap();
    let seen = Recording::parse(file(), &robot(), Some(&map), TopicChoice::Any).unwrap();
    assert!(seen.values(Meaning::Measured(0)).is_some() && seen.values(Meaning::Command(0)).is_none());
}

#[test]
fn damaged_recordings_are_refused_and_nothing_panics() {
    let whole = file();
    let with = |bytes: Vec<u8>| Input { name: "ros2.mcap".into(), bytes, sha256: String::new() };
    for cut in (0..whole.bytes.len()).step_by(97) {
        let text = bag::unpacked(with(whole.bytes[..cut].to_vec()), TopicChoice::Joints).unwrap_err().to_string();
        assert!(text.contains("ros2.mcap"), "{text}");
    }
    for at in (0..whole.bytes.len()).step_by(53) {
        let mut bytes = whole.bytes.clone();
        bytes[at] ^= 0xff;
        let _ = bag::unpacked(with(bytes), TopicChoice::Joints); // read or refused
    }
}

/// An attachment that ends before its checksum, which the parser of attachments takes for granted.
#[test]
fn an_attachment_that_is_cut_short_does_not_panic() {
    let record = |opcode: u8, body: &[u8]| [&[opcode][..], &(body.len() as u64).to_le_bytes(), body].concat();
    let magic = b"\x89MCAP0\r\n";
    let bytes = [&magic[..], &record(1, &[0; 8]), &record(9, &[0; 34]), &record(2, &[0; 20]), magic].concat();
    let said = bag::unpacked(Input { bytes, ..file() }, TopicChoice::Any).map(|_| ()).unwrap_err().to_string();
    assert!(said.contains("no topic that can be read"), "{said}");
}
