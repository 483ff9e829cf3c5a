//! What the tests share: the command under test, its outcome, a folder to work in, the files of the checkout.
//!
//! - [`run`] and [`WorkFolder::run`]: a command line in a folder, and what came of it ([`Outcome`]).
//! - [`command`]: the command, to add to and to assert on; [`process`]: the same, to start and to end while it runs.
//! - [`bundled`]: a file of the checkout.

use serde::de::DeserializeOwned;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// The checkout.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A file of the checkout: a sample, a robot, data of the tests.
pub fn bundled(name: &str) -> PathBuf {
    root().join(name)
}

/// The program under test.
pub fn binary() -> &'static Path {
    Path::new(env!("CARGO_BIN_EXE_lostmotion"))
}

/// The command in the folder of the tests, which is the checkout.
pub fn command() -> assert_cmd::Command {
    assert_cmd::Command::new(binary())
}

/// The command as a process that a test starts, watches and ends.
pub fn process() -> std::process::Command {
    std::process::Command::new(binary())
}

/// A command line, without the program's name, in a folder. Words are parted by spaces.
pub fn run(folder: &Path, line: &str) -> Outcome {
    run_args(folder, line.split_whitespace())
}

/// As [`run`], for arguments that hold spaces.
pub fn run_args<I: IntoIterator<Item: AsRef<OsStr>>>(folder: &Path, args: I) -> Outcome {
    outcome(command().current_dir(folder).args(args))
}

/// A command line in the checkout, `{}` being a folder to work in.
pub fn run_from_root(work: &Path, line: &str) -> Outcome {
    let work = work.to_str().expect("a folder in UTF-8");
    run_args(root(), line.split_whitespace().map(|word| word.replace("{}", work)))
}

/// Runs a command to its end.
pub fn outcome(command: &mut assert_cmd::Command) -> Outcome {
    let out = command.output().expect("the command starts");
    let what = format!("{command:?}");
    Outcome { what, code: out.status.code(), stdout: out.stdout, stderr: String::from_utf8_lossy(&out.stderr).into() }
}

/// What came of a command.
#[derive(Debug)]
pub struct Outcome {
    what: String,
    /// None after a signal.
    pub code: Option<i32>,
    pub stdout: Vec<u8>,
    pub stderr: String,
}

impl Outcome {
    /// Panics with the messages if the command did not succeed.
    #[track_caller]
    pub fn success(self) -> Self {
        self.ends_with(0)
    }

    /// Panics with the messages if the command ended with another exit code.
    #[track_caller]
    pub fn ends_with(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "{}\n{}{}", self.what, self.text(), self.stderr);
        self
    }

    pub fn succeeded(&self) -> bool {
        self.code == Some(0)
    }

    /// Standard output.
    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.stdout).into_owned()
    }

    /// The JSON document on standard output.
    #[track_caller]
    pub fn json<T: DeserializeOwned>(&self) -> T {
        serde_json::from_slice(&self.stdout)
            .unwrap_or_else(|e| panic!("{e}: {}\n{}{}", self.what, self.text(), self.stderr))
    }
}

/// A folder for one test, removed at its end.
#[derive(Debug)]
pub struct WorkFolder(tempfile::TempDir);

impl WorkFolder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder to work in"))
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// The path of a file in the folder.
    pub fn join(&self, name: impl AsRef<Path>) -> PathBuf {
        self.path().join(name)
    }

    /// A command line in this folder.
    pub fn run(&self, line: &str) -> Outcome {
        run(self.path(), line)
    }
}
