//! `lostmotion learn`: forward kinematics from logs.

use crate::cli::exit::bad;
use crate::cli::{logs, page, paths};
use crate::error::{self, Place, counted};
use crate::io::output::{self, Output};
use crate::learn::{Kind, LETTERS, Options, Source, learn};
use crate::log::Log;
use crate::program::Program;
use crate::robot::Robot;
use anyhow::Result;
use std::path::{Path, PathBuf};

/// Learn the forward kinematics of a machine from its logs, with a small neural network.
///
/// Use it for machines whose kinematics from motor to TCP are hard to model: tendons, sheaths, coupled joints. Each
/// coordinate of the TCP becomes one network of the joint commands. The augmented network learns velocities as well as
/// positions, which gives `track` a better Jacobian; the plain network learns only positions. A random fifth of the rows is
/// kept for the test, unless --test names another log. The same seed gives the same file.
///
/// If the logs were recorded with compensated commands, give the desired commands with --commands. The network then learns
/// the machine with its compensation, and you must compensate the programs of `track` in the same way.
///
/// Examples:
///   lostmotion learn --robot robot.yaml --log log.csv --output kinematics.yaml
///   lostmotion learn --robot robot.yaml --log log.csv --commands desired.csv --output kinematics.yaml
///   lostmotion learn --robot robot.yaml --log log.csv --kind plain --test other.csv --json --output k.yaml
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Args {
    /// Robot file (YAML)
    #[arg(long, value_name = "ROBOT.yaml")]
    pub robot: PathBuf,
    /// Log to learn from; repeat the option to use several logs together
    #[arg(long, value_name = "LOG.csv", required = true)]
    pub log: Vec<PathBuf>,
    /// Program with the desired commands of each --log, in the same order, if the commands in the logs are compensated
    #[arg(long, value_name = "PROGRAM.csv")]
    pub commands: Vec<PathBuf>,
    /// Log for the test, instead of a fifth of the rows
    #[arg(long, value_name = "LOG.csv")]
    pub test: Vec<PathBuf>,
    /// Program with the desired commands of each --test, in the same order
    #[arg(long, value_name = "PROGRAM.csv")]
    pub test_commands: Vec<PathBuf>,
    /// Kind of network
    #[arg(long, value_enum, default_value_t = KindArg::Augmented)]
    pub kind: KindArg,
    /// Number of neurons in the hidden layer
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = clap::value_parser!(u16).range(1..=200))]
    pub hidden: u16,
    /// Seed of the random split and of the initial weights
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Coordinates of the TCP to learn
    #[arg(long, value_name = "LETTERS", default_value = "xyz", value_parser = coordinates)]
    pub coordinates: Coordinates,
    /// Write the learned kinematics to this file; `-` for standard output
    #[arg(long, short, value_name = "KINEMATICS.yaml")]
    pub output: PathBuf,
    /// Column map (YAML): translates other column names, units and separators of the logs
    #[arg(long, value_name = "FILE")]
    pub columns: Option<PathBuf>,
    /// Print the result as one JSON document (lostmotion/learning/1) instead of the table
    #[arg(long)]
    pub json: bool,
    /// Write a self-contained HTML page with figures and tables to this file
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

/// `--kind`.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub enum KindArg {
    /// Learns positions only
    Plain,
    /// Learns positions and velocities
    Augmented,
}

/// 0, 1, 2 for x, y, z; rising.
#[derive(Debug, Clone)]
pub struct Coordinates(Vec<usize>);

fn coordinates(text: &str) -> std::result::Result<Coordinates, String> {
    let found: Vec<usize> = (0..3).filter(|&c| text.contains(LETTERS[c])).collect();
    if found.is_empty() || found.len() != text.chars().count() {
        return Err("expected some of the letters x, y, z, each once".into());
    }
    Ok(Coordinates(found))
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    let mut inputs = vec![("--robot", Some(args.robot.as_path())), ("--columns", args.columns.as_deref())];
    let lists = [
        ("--log", &args.log),
        ("--commands", &args.commands),
        ("--test", &args.test),
        ("--test-commands", &args.test_commands),
    ];
    for (option, list) in lists {
        inputs.extend(list.iter().map(|p| (option, Some(p.as_path()))));
    }
    let outputs = [("--output", Some(args.output.as_path())), ("--report", args.report.as_deref())];
    paths::refuse_shared(&inputs, &outputs)?;
    for (option, programs, of, logs) in [
        ("--commands", &args.commands, "--log", &args.log),
        ("--test-commands", &args.test_commands, "--test", &args.test),
    ] {
        if !programs.is_empty() && programs.len() != logs.len() {
            let found = format!("{} for {} of {of}", counted(programs.len(), "program"), logs.len());
            return Err(bad(Place::file(option), found, "one for each, in the same order, or none"));
        }
    }
    let to_stdout = args.output == Path::new("-");
    if args.json && to_stdout {
        let found = "--json with --output -";
        return Err(bad(Place::file("command line"), found, "one of them: both go to standard output"));
    }
    let mut out = Output::create(&args.output)?;
    let mut report = output::create(args.report.as_deref())?;
    let robot = Robot::load(&args.robot)?;
    let programs = |all: &[PathBuf]| all.iter().map(|p| Program::load(p, &robot)).collect::<error::Result<Vec<_>>>();
    let (desired, test_desired) = (programs(&args.commands)?, programs(&args.test_commands)?);
    let all: Vec<PathBuf> = args.log.iter().chain(&args.test).cloned().collect();
    let all = logs::load_free(&all, args.columns.as_deref(), &robot)?;
    logs::refuse_repeats(&all)?;
    let (teach, test) = all.split_at(args.log.len());
    let kind = match args.kind {
        KindArg::Plain => Kind::Plain,
        KindArg::Augmented => Kind::Augmented,
    };
    let options = Options { kind, hidden: args.hidden.into(), seed: args.seed, coordinates: args.coordinates.0 };
    let lesson = learn(&robot, &sources(teach, &desired), &sources(test, &test_desired), &options)?;
    for note in &lesson.notes {
        eprintln!("note: {note}");
    }
    out.put(lesson.learned.to_yaml(&robot)?.as_bytes())?;
    page::write(&mut report, || page::learn::of_training(&robot, &lesson))?;
    if to_stdout {
        output::commit([Some(out), report])?;
        eprint!("{}", lesson.to_text());
        return Ok(());
    }
    let mut stdout = Output::create(Path::new("-"))?;
    let text = if args.json { format!("{:#}\n", lesson.to_json()?) } else { lesson.to_text() };
    stdout.put(text.as_bytes())?;
    output::commit([Some(out), report, Some(stdout)]).map_err(Into::into)
}

/// Each log with its program, where there are any.
fn sources<'a>(logs: &'a [Log], programs: &'a [Program]) -> Vec<Source<'a>> {
    logs.iter().enumerate().map(|(i, log)| Source { log, desired: programs.get(i) }).collect()
}
