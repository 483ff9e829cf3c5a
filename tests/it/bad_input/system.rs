//! Paths, names, disks and pipes: what the operating system refuses.

use super::{ROBOT, listing};
use crate::support::{self, WorkFolder, root};
use lostmotion::robot::Robot;
use std::path::Path;

/// Files that are not there, are folders, or have names that are hard to say.
#[test]
fn paths_that_cannot_be_read_are_named() {
    let folder = WorkFolder::new();
    for (path, says) in [
        ("none.yaml", "cannot open"),
        (".", "a folder"),
        ("none/robot.yaml", "cannot open"),
        ("with blanks.yaml", "cannot open"),
    ] {
        let e = Robot::load(&folder.join(path)).unwrap_err();
        assert_eq!(lostmotion::cli::exit::code_of(&e), 2);
        assert!(e.to_string().contains(says) && e.to_string().contains(path), "{e}");
    }
}

#[cfg(unix)]
#[test]
fn a_name_that_is_not_utf8_is_read_and_shown() {
    use std::os::unix::ffi::OsStrExt;
    let folder = WorkFolder::new();
    let path = folder.join(std::ffi::OsStr::from_bytes(b"robot \xff.yaml"));
    let missing = Robot::load(&path).unwrap_err().to_string();
    assert!(missing.contains("robot \\xFF.yaml"), "{missing}");
    std::fs::write(&path, ROBOT).unwrap();
    assert_eq!(Robot::load(&path).unwrap().dof(), 3);
}

#[cfg(unix)]
#[test]
fn an_output_that_cannot_be_written_leaves_what_was_there() {
    use lostmotion::io::output::write_whole;
    use std::os::unix::fs::PermissionsExt;
    let folder = WorkFolder::new();
    let kept = folder.join("kept.yaml");
    std::fs::write(&kept, "old").unwrap();
    std::fs::set_permissions(&kept, std::fs::Permissions::from_mode(0o444)).unwrap();
    let e = write_whole(&kept, b"new").unwrap_err();
    assert!(lostmotion::cli::exit::code_of(&e) == 2 && e.to_string().contains("kept.yaml: cannot write"), "{e}");
    assert_eq!(std::fs::read_to_string(&kept).unwrap(), "old");
    let e = write_whole(folder.path(), b"new").unwrap_err();
    assert!(lostmotion::cli::exit::code_of(&e) == 2 && e.to_string().contains("a folder"), "{e}");
    let e = write_whole(&folder.join("none/out.yaml"), b"new").unwrap_err();
    assert!(lostmotion::cli::exit::code_of(&e) == 2 && e.to_string().contains("out.yaml: cannot write"), "{e}");
    assert_eq!(listing(folder.path()), [kept], "no leftovers");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_and_no_success() {
    let e = lostmotion::io::output::write_whole(Path::new("/dev/full"), &[b'x'; 4096]).unwrap_err();
    assert!(lostmotion::cli::exit::code_of(&e) == 2 && e.to_string().contains("/dev/full: cannot write"), "{e}");
    // standard output on a full disk
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let mut command = support::process();
    let out = command.args(["completions", "bash"]).stdout(full).output().unwrap();
    let says = String::from_utf8_lossy(&out.stderr);
    assert_eq!((out.status.code(), says.lines().count()), (Some(2), 1), "{says}");
}

#[cfg(unix)]
#[test]
fn a_closed_pipe_is_quiet_and_no_failure() {
    use std::process::Stdio;
    let mut command = support::process();
    let mut child = command.args(["completions", "zsh"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let out = child.wait_with_output().unwrap();
    let says = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.success() && says.is_empty(), "{:?} {says}", out.status);
}

#[test]
fn an_unknown_flag_is_bad_usage() {
    let out = support::run(root(), "rewrite --no-such-flag").ends_with(2);
    assert!(out.stdout.is_empty());
}
