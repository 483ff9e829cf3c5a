//! ROS 2 recordings (MCAP): every choice of a topic.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lostmotion::io::bag::{TopicChoice, unpacked};
use lostmotion::io::input::Input;

fuzz_target!(|data: &[u8]| {
    for wanted in [TopicChoice::Any, TopicChoice::Joints, TopicChoice::Places, TopicChoice::Topic("/joint_states")] {
        let input = Input { name: "recording.mcap".into(), bytes: data.to_vec(), sha256: String::new() };
        let _ = unpacked(input, wanted);
    }
});
