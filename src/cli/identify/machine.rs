//! `lostmotion identify` without a subcommand: one model for all logs of a machine.

use super::common::{LogArgs, ResultArgs, SetupsArgs, Shown};
use crate::cli::progress::during;
use crate::cli::{logs, page};
use crate::gaps::Gaps;
use crate::gaps::estimate::Trust;
use crate::gaps::file;
use crate::identify::machine;
use crate::robot::Robot;
use anyhow::Result;
use comfy_table::{Table, presets::UTF8_HORIZONTAL_ONLY};
use std::path::PathBuf;

/// What was asked for.
#[derive(Debug)]
pub struct Args {
    pub robot: PathBuf,
    pub input: LogArgs,
    pub setups: SetupsArgs,
    pub result: ResultArgs,
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    let opened = args.result.open(&args.input, &[("--robot", Some(args.robot.as_path()))])?;
    let robot = Robot::load(&args.robot)?;
    let logs = logs::load(&args.input.logs, args.input.columns.as_deref(), &robot)?;
    logs::refuse_repeats(&logs)?;
    let setups = args.setups.of_each(&logs)?;
    let found = during("identify", || machine::identify(&robot, &logs, &setups))?;
    let document = file::document(&found, &robot);
    let shown = Shown { document: &document, table: &table(&found, &robot), notes: &found.notes };
    args.result.finish(opened, &shown, || page::machine::of_identify(&robot, &found))
}

/// Scatter of single reversals: none that is seen is below what is printed, not none.
fn scatter_text(share: f64) -> String {
    if share < 0.005 { "below 1 %".into() } else { format!("{:.0} %", share * 100.0) }
}

/// What is predicted to be left, um.
fn left_text(m: f64) -> String {
    if m < 0.05e-6 { "below 0.1".into() } else { format!("{:.1}", m * 1e6) }
}

/// Nothing where no reversal could be judged.
fn judged(trust: &Trust, text: impl Fn(&Trust) -> String) -> String {
    if trust.reversals == 0 { "-".into() } else { text(trust) }
}

/// What a person reads.
fn table(found: &Gaps, robot: &Robot) -> String {
    let mut t = Table::new();
    t.load_preset(UTF8_HORIZONTAL_ONLY);
    t.set_header(["joint", "half gap", "95 %", "spikes", "wind-up", "scatter", "error um", "after um", "compensate"]);
    for j in &found.joints {
        let joint = robot.axis(j.axis);
        let edge = |v: f64| format!("{:.5}", joint.kind.to_user_unit(v));
        let mark = if j.schedule.is_some() { " (varies)" } else { "" };
        let mut row = vec![
            joint.name.clone(),
            format!("{} {}{mark}", edge(j.half_gap), joint.kind.unit()),
            format!("{} .. {}", edge(j.ci95[0]), edge(j.ci95[1])),
        ];
        if let Some(e) = found.estimate.iter().flat_map(|e| &e.joints).find(|e| e.axis == j.axis) {
            row.extend([
                edge(e.response.gain()),
                edge(e.response.windup()),
                scatter_text(e.scatter),
                judged(&e.trust, |t| format!("{:.1}", t.before_m * 1e6)),
                judged(&e.trust, |t| left_text(t.after_m)),
                if e.trust.compensate { "yes".into() } else { "no".to_string() },
            ]);
        }
        t.add_row(row);
    }
    format!("{t}\n")
}
