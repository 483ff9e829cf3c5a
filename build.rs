//! Tells the tests what is there, so that a test whose data are absent is reported as ignored and not as passed.
//!
//! - `real_data`: the measured sets, in `LOSTMOTION_REAL_DATA` or in `../shared/data/real` beside the checkout.
//! - `strace`: the program that makes a system call fail.
//! - `superuser`: no folder is closed to who builds, so that none can be made to fail.
//!
//! Looked for when the package is built. After the data have come, touch this file; once they are there, cargo sees when they go.

use std::path::{Path, PathBuf};

fn main() {
    println!("cargo::rustc-check-cfg=cfg(real_data, strace, superuser)");
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=LOSTMOTION_REAL_DATA");
    let beside = || Path::new(&std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_default()).join("../shared/data/real");
    let sets = std::env::var_os("LOSTMOTION_REAL_DATA").map_or_else(beside, PathBuf::from);
    if sets.is_dir() {
        println!("cargo::rerun-if-changed={}", sets.display());
        println!("cargo::rustc-cfg=real_data");
    }
    let path = std::env::var_os("PATH").unwrap_or_default();
    if std::env::split_paths(&path).any(|folder| folder.join("strace").is_file()) {
        println!("cargo::rustc-cfg=strace");
    }
    #[cfg(unix)]
    if reads_a_closed_folder() {
        println!("cargo::rustc-cfg=superuser");
    }
}

/// A folder of this build without a permission is read all the same.
#[cfg(unix)]
fn reads_a_closed_folder() -> bool {
    use std::os::unix::fs::DirBuilderExt;
    let Some(out) = std::env::var_os("OUT_DIR") else { return false };
    let closed = Path::new(&out).join("closed");
    let made = std::fs::DirBuilder::new().mode(0o000).create(&closed).is_ok();
    let read = made && std::fs::read_dir(&closed).is_ok();
    if made {
        // an empty folder is removed by who owns the one above
        drop(std::fs::remove_dir(&closed));
    }
    read
}
