//! Cartesian paths of `track`: only finite numbers.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lostmotion::io::input::from_bytes;
use lostmotion::track::path::Path;

fuzz_target!(|data: &[u8]| {
    if let Ok(input) = from_bytes("path.csv".into(), data.to_vec())
        && let Ok(path) = Path::parse(input)
    {
        assert!(path.points_m.iter().flatten().all(|v| v.is_finite()), "a number that is none");
    }
});
