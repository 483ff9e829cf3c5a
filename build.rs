//! Tells the tests what is there, so that a test whose data are absent is reported as ignored and not as passed.
//!
//! - `real_data`: the measured sets, in `LOSTMOTION_REAL_DATA` or in `../shared/data/real` beside the checkout.
//! - `strace`: the program that makes a system call fail.
//!
//! Looked for when the package is built. After the data have come, touch this file; once they are there, cargo sees when they go.

use std::path::{Path, PathBuf};

fn main() {
    println!("cargo::rustc-check-cfg=cfg(real_data, strace)");
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
}
