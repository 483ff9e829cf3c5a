//! The sample programs and the robots for which they are written.
//!
//! The folder's `robot.txt` names a file in configs/; without it the first robot that reads the sample and gives it a joint
//! target is taken, those of the vendor first. Files whose name holds `refused` are there to be refused.

use crate::support::bundled;
use lostmotion::program::files::Files;
use lostmotion::program::formats::FORMATS;
use lostmotion::program::script::{Document, Format, Goal, Text};
use lostmotion::robot::Robot;
use robot_programs::error::Result;
use robot_programs::gcode::Control;
use std::path::{Path, PathBuf};

#[derive(Clone)]
pub struct Sample {
    pub format: &'static dyn Format,
    pub path: PathBuf,
    pub texts: Vec<Text>,
    pub robot: Robot,
}

impl Sample {
    pub fn parse(&self) -> Result<Box<dyn Document>> {
        self.format.parse(self.texts.clone(), self.robot.axes())
    }

    pub fn with(&self, texts: Vec<Text>) -> Self {
        Self { texts, ..self.clone() }
    }
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    let Ok(found) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut paths: Vec<PathBuf> = found.map(|e| e.unwrap().path()).collect();
    paths.sort();
    paths
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Folders of samples/programs.
pub fn folders() -> Vec<String> {
    entries(&bundled("samples/programs")).iter().filter(|p| p.is_dir()).map(|p| name(p)).collect()
}

/// Beginnings of the names of a format's robots in configs/.
fn makers(format: &str) -> &'static [&'static str] {
    match format {
        "krl" => &["kuka"],
        "rapid" => &["abb"],
        "inform" => &["yaskawa", "motoman"],
        "fanuc" => &["fanuc"],
        "urscript" => &["ur", "universal"],
        "gcode" => &["gantry"],
        _ => &["kuka"],
    }
}

/// Robots to be tried, in order.
fn robots(format: &str, folder: &Path) -> Vec<Robot> {
    let mut paths: Vec<PathBuf> = entries(&bundled("configs"));
    if let Ok(named) = std::fs::read_to_string(folder.join("robot.txt")) {
        let word = named.split_whitespace().next().unwrap_or_default().to_string();
        let word = name(Path::new(&word));
        paths.retain(|p| name(p) == word || name(p).trim_end_matches(".yaml") == word);
        assert!(!paths.is_empty(), "{}: configs/{word} is missing", folder.display());
    }
    let own = |p: &PathBuf| makers(format).iter().any(|m| name(p).starts_with(m));
    paths.sort_by_key(|p| !own(p));
    // samples in whole numbers are in millimetres
    let control = Control { whole_units: true, ..Control::default() };
    let load = |p: &PathBuf| {
        let mut robot = Robot::load(p).unwrap();
        robot.assume(control);
        robot
    };
    paths.iter().map(load).collect()
}

/// A program and its companions, as they are on disk.
fn texts(format: &dyn Format, path: &Path) -> Vec<Text> {
    let read = |p: &Path| std::fs::read(p).ok().map(|bytes| Text::new(name(p), bytes));
    let companions = format.companions(path, &Files::Disk).into_iter().filter_map(|p| read(&p));
    read(path).into_iter().chain(companions).collect()
}

/// The samples of a format; that there are some is a separate test.
pub fn of(format: &'static dyn Format) -> Vec<Sample> {
    let folder = bundled("samples/programs").join(format.name());
    let ours = |p: &PathBuf| {
        let ending = p.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        p.is_file() && format.endings().contains(&ending.as_str())
    };
    let files: Vec<PathBuf> = entries(&folder).into_iter().filter(ours).collect();
    let companions: Vec<PathBuf> = files.iter().flat_map(|f| format.companions(f, &Files::Disk)).collect();
    let robots = robots(format.name(), &folder);
    let mut samples = Vec::new();
    for path in files.iter().filter(|f| !companions.contains(f)) {
        let texts = texts(format, path);
        let mut refusals = Vec::new();
        let read = robots.iter().enumerate().find_map(|(k, robot)| match format.parse(texts.clone(), robot.axes()) {
            Ok(d) => {
                let joints = d.script().moves().any(|(_, m)| matches!(m.goal, Goal::Joints(_)));
                // a program without a joint target is one, too: with the last robot
                (joints || k + 1 == robots.len()).then(|| robot.clone())
            }
            Err(e) => {
                refusals.push(e.to_string());
                None
            }
        });
        if name(path).contains("refused") {
            assert!(read.is_none(), "{}: was read", path.display());
            continue;
        }
        let robot = read.unwrap_or_else(|| panic!("{}: no robot reads it:\n{}", path.display(), refusals.join("\n")));
        samples.push(Sample { format, path: path.clone(), texts, robot });
    }
    samples
}

pub fn all() -> Vec<Sample> {
    FORMATS.iter().flat_map(|f| of(*f)).collect()
}
