//! Where the public measured logs lie, if they are there: `LOSTMOTION_REAL_DATA`, or `../shared/data/real` beside the checkout.
//! They are never copied into the project (five of the sets state no licence).

use lostmotion::log::{ColumnMap, Log};
use lostmotion::robot::Robot;
use std::path::{Path, PathBuf};

/// A file of the data, or `None` with a message: the test that asked for it says nothing then.
pub fn data(file: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("LOSTMOTION_REAL_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/real"), PathBuf::from);
    let path = folder.join(file);
    if path.is_file() {
        return Some(path);
    }
    eprintln!("skipped: no {} (set LOSTMOTION_REAL_DATA to the folder of the measured sets)", path.display());
    None
}

/// Robot file, model or map of a set (`tests/real`).
pub fn ours(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/real").join(file)
}

/// Robot and log of a set through one of its maps.
pub fn read(set: &str, map: &str, file: &str) -> Option<(Robot, Log)> {
    let path = data(&format!("{set}/{file}"))?;
    let robot = Robot::load(&ours(&format!("{set}/robot.yaml"))).unwrap();
    let map = ColumnMap::load(&ours(&format!("{set}/{map}"))).unwrap();
    let log = Log::load_with(&path, &robot, Some(&map)).unwrap();
    Some((robot, log))
}
