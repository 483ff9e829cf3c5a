//! Where the public measured logs lie, if they are there: `LOSTMOTION_REAL_DATA`, or `../shared/data/real` beside the checkout.
//! They are never copied into the project (five of the sets state no licence).

use crate::support::bundled;
use lostmotion::log::{ColumnMap, Log};
use lostmotion::robot::Robot;
use std::path::PathBuf;

/// A file of the data. A test on it is ignored where the data are absent, and fails where it is asked for all the same.
pub fn data(file: &str) -> PathBuf {
    let folder = std::env::var_os("LOSTMOTION_REAL_DATA").map_or_else(|| bundled("../shared/data/real"), PathBuf::from);
    let path = folder.join(file);
    assert!(path.is_file(), "no {} (set LOSTMOTION_REAL_DATA to the folder of the measured sets)", path.display());
    path
}

/// Robot file, model or map of a set (`tests/real`).
pub fn ours(file: &str) -> PathBuf {
    bundled("tests/real").join(file)
}

/// Robot and log of a set through one of its maps.
pub fn read(set: &str, map: &str, file: &str) -> (Robot, Log) {
    let path = data(&format!("{set}/{file}"));
    let robot = Robot::load(&ours(&format!("{set}/robot.yaml"))).unwrap();
    let map = ColumnMap::load(&ours(&format!("{set}/{map}"))).unwrap();
    let log = Log::load_with(&path, &robot, Some(&map)).unwrap();
    (robot, log)
}
