//! Joint-space CSV: the streaming reader, block by block.
#![no_main]

use libfuzzer_sys::fuzz_target;
use robot_programs::Block;
use robot_programs::csv::Reader;
use lostmotion::robot::Robot;
use lostmotion_fuzz::{KUKA, robot};
use std::sync::LazyLock;

static ROBOT: LazyLock<Robot> = LazyLock::new(|| robot(KUKA));

fuzz_target!(|data: &[u8]| {
    let Ok(mut reader) = Reader::new(Box::new(std::io::Cursor::new(data.to_vec())), "p.csv", ROBOT.axes()) else { return };
    let mut block = Block::default();
    while let Ok(true) = reader.next(&mut block) {
        assert!(block.q.iter().chain(&block.t_s).all(|v| v.is_finite()), "a number that is none");
        block.clear();
    }
});
