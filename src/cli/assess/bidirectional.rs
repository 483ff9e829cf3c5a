//! `lostmotion assess bidirectional`.

use crate::assess::bidirectional::digits::digits;
use crate::assess::bidirectional::equation::{self, um_per_mm};
use crate::assess::bidirectional::gap::{self, Mapping};
use crate::assess::bidirectional::{Assessment, Errors, Model, Note, Options, Readings, assess};
use crate::cli::exit::bad;
use crate::cli::print::{print, print_json, table};
use crate::cli::{page, paths};
use crate::error::{Place, is_stdio};
use crate::gaps;
use crate::gaps::file::{document, to_json, to_yaml};
use crate::io::output::{self, Output};
use crate::log::ColumnMap;
use crate::model::Model as Machine;
use crate::robot::{JointKind, Robot};
use anyhow::Result;
use std::fmt::Write;
use std::path::PathBuf;

/// Evaluate positions reached from both sides: repeatability, and backlash over position, speed and payload.
///
/// The readings are a CSV file with the columns position_mm, direction (+1/-1, +/-, forward/backward), repeat and error_um
/// (measured minus commanded; or error_mm, or reading_mm: the measured position). Every further column is a state
/// (speed_mm_s, payload_kg). For each pose the command reports RP (3 sigma of one direction), R (equation 24 of Slamani,
/// Nubiola and Bonev, and with the factor 2 of ISO 230-2) and the backlash, forward minus backward. The polynomial of the
/// backlash over position is the one of lowest degree that a lack-of-fit test against the repeats does not reject. Student's
/// t tests decide whether a state adds an offset, and then a slope.
///
/// Examples:
///   lostmotion assess bidirectional --readings readings.csv
///   lostmotion assess bidirectional --readings readings.csv --json --report page.html
///   lostmotion assess bidirectional --readings readings.csv --robot robot.yaml --joint X --output gaps.yaml
///   lostmotion assess bidirectional --readings readings.csv --robot robot.yaml --joint X --model-out machine.yaml --effect backlash-speed
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub struct Args {
    /// Readings (CSV, or .csv.gz), `-` for standard input
    #[arg(long, value_name = "READINGS.csv")]
    pub readings: PathBuf,
    /// Column map (YAML): translates other column names, units, signs and separators of the file
    #[arg(long, value_name = "FILE")]
    pub columns: Option<PathBuf>,
    /// Columns to use as states [default: every further column]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    pub states: Option<Vec<String>>,
    /// Reference state, with which the others are compared [default: the smallest value of each state]
    #[arg(long, value_name = "NAME=VALUE,...", value_delimiter = ',')]
    pub reference: Vec<String>,
    /// Confidence level of the tests, 0 to 1; the intervals are always 95 %
    #[arg(long, value_name = "P", default_value_t = 0.95)]
    pub level: f64,
    /// Lowest degree of the polynomial to try; 0 is a constant backlash, the paper starts at 1
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub min_degree: usize,
    /// Highest degree of the polynomial to try [default: 6, or two less than the number of poses]
    #[arg(long, value_name = "N")]
    pub max_degree: Option<usize>,
    /// Use this degree, whatever the tests show
    #[arg(long, value_name = "N", conflicts_with_all = ["min_degree", "max_degree"])]
    pub degree: Option<usize>,
    /// Scatter used in Student's t tests and in the intervals of the curve [default: means for the tests, the larger of both
    /// for the curve]
    #[arg(long, value_enum)]
    pub errors: Option<ErrorsArg>,
    /// Print the result as one JSON document (lostmotion/bidirectional/1) instead of the tables
    #[arg(long)]
    pub json: bool,
    /// Write a self-contained HTML page with figures and tables to this file
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Write the curve to this file as the half gap of a joint (lostmotion/gaps/1, for `fit`)
    #[arg(long, short, value_name = "GAPS.yaml", requires_all = ["robot", "joint"])]
    pub output: Option<PathBuf>,
    /// Write a model of the robot with the curve as an effect to this file (lostmotion/model/1)
    #[arg(long, value_name = "MODEL.yaml", requires_all = ["robot", "joint"])]
    pub model_out: Option<PathBuf>,
    /// Effect that --model-out writes
    #[arg(long, value_enum, default_value_t = EffectArg::BacklashPosition, requires = "model_out")]
    pub effect: EffectArg,
    /// Robot file (YAML)
    #[arg(long, value_name = "ROBOT.yaml")]
    pub robot: Option<PathBuf>,
    /// Joint that moved along the line; all others stood still
    #[arg(long, value_name = "NAME", requires = "robot")]
    pub joint: Option<String>,
    /// State whose curve is written, such as speed_mm_s=6000 [default: the reference state]
    #[arg(long, value_name = "NAME=VALUE,...", value_delimiter = ',')]
    pub at_state: Vec<String>,
    /// Position of the joint at which position_mm is 0, deg or mm
    #[arg(long, value_name = "Q", default_value_t = 0.0, allow_hyphen_values = true)]
    pub origin: f64,
    /// Lever arm of a revolute joint, mm along the line per radian; negative if the joint angle falls as position_mm rises
    #[arg(long, value_name = "MM", allow_hyphen_values = true)]
    pub lever_mm: Option<f64>,
    /// Reverse the signs: the errors are commanded minus measured, or forward is towards lower positions
    #[arg(long)]
    pub reversed: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum ErrorsArg {
    /// Residuals of the means at the poses (Slamani (2012))
    Means,
    /// Residuals of the single readings
    Readings,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum EffectArg {
    /// Half gap over joint position
    #[value(alias = "backlash_position")]
    BacklashPosition,
    /// Half gap over TCP speed
    #[value(alias = "backlash_speed")]
    BacklashSpeed,
}

/// The curve as that of a joint: gaps and a model, where they are asked for. Returns notes.
fn write_joint(
    args: &Args,
    result: &Assessment,
    robot: &Robot,
    mapping: &Mapping,
    output: &mut Option<Output>,
    model_out: &mut Option<Output>,
) -> Result<Vec<gaps::Note>> {
    let (mut notes, mut of_curve) = (Vec::new(), Vec::new());
    let model = needed(result)?;
    gap::within_limits(result, mapping, robot, &mut of_curve)?;
    notes.extend(of_curve.drain(..).map(gaps::Note::from));
    let at = pairs("--at-state", &args.at_state)?;
    let state = if at.is_empty() { model.reference } else { result.states.named(&at, &result.order, &result.file)? };
    if let (Some(path), Some(out)) = (&args.output, output) {
        let gaps = gap::gaps(result, model, state, mapping, robot)?;
        let doc = document(&gaps, robot);
        let json = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
        out.put(if json { to_json(&doc)? } else { to_yaml(&doc)? }.as_bytes())?;
        notes.extend(gaps.notes);
    }
    if let Some(out) = model_out {
        let effect = match args.effect {
            EffectArg::BacklashPosition => gap::over_position(result, model, state, mapping, &mut of_curve)?,
            EffectArg::BacklashSpeed => gap::over_speed(result, model, mapping, &mut of_curve)?,
        };
        let mut machine = Machine::ideal(robot.clone());
        machine.effects.push(effect);
        out.put(machine.to_yaml_inline()?.as_bytes())?;
    }
    notes.extend(of_curve.into_iter().map(gaps::Note::from));
    Ok(notes)
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    let inputs = [
        ("--readings", Some(args.readings.as_path())),
        ("--columns", args.columns.as_deref()),
        ("--robot", args.robot.as_deref()),
    ];
    let outputs = [
        ("--output", args.output.as_deref()),
        ("--model-out", args.model_out.as_deref()),
        ("--report", args.report.as_deref()),
    ];
    paths::refuse_shared(&inputs, &outputs)?;
    let to_stdout = outputs.iter().find(|(_, path)| path.is_some_and(is_stdio));
    if let Some((option, _)) = to_stdout.filter(|_| args.json) {
        return Err(bad(Place::file(*option), "`-` and --json", "one document on standard output"));
    }
    let options = options(&args)?;
    let reference = pairs("--reference", &args.reference)?;
    let mut output = output::create(args.output.as_deref())?;
    let mut model_out = output::create(args.model_out.as_deref())?;
    let mut report = output::create(args.report.as_deref())?;
    let map = args.columns.as_deref().map(ColumnMap::load).transpose()?;
    let robot = args.robot.as_deref().map(Robot::load).transpose()?;
    let mapping = robot.as_ref().map(|r| mapping(&args, r)).transpose()?.flatten();
    let readings = Readings::load(&args.readings, map.as_ref(), args.states.as_deref())?;
    let mut result = assess(readings, &reference, &options)?;
    if let (Some(robot), Some(mapping)) = (&robot, &mapping) {
        for note in write_joint(&args, &result, robot, mapping, &mut output, &mut model_out)? {
            let note = Note::Gap(note);
            if !result.notes.contains(&note) {
                result.notes.push(note);
            }
        }
    }
    for note in &result.notes {
        eprintln!("note: {note}");
    }
    page::write(&mut report, || page::bidirectional::of_assessment(&result, robot.as_ref()))?;
    output::commit([output, model_out, report])?;
    match (args.json, to_stdout) {
        (true, _) => print_json(&result.to_json()?),
        (false, None) => print(&tables(&result)),
        (false, Some(_)) => {
            eprint!("{}", tables(&result));
            Ok(())
        }
    }
}

fn needed(result: &Assessment) -> Result<&Model> {
    result.model.as_ref().ok_or_else(|| {
        let expected = "repeats, or a --degree, so that there is a curve to write";
        bad(Place::file(&result.file), "no curve (one repeat only)", expected)
    })
}

fn options(args: &Args) -> Result<Options> {
    if !(args.level > 0.5 && args.level < 1.0) {
        let expected = "a level between 0.5 and 1 (0.95 is a threshold of 0.05)";
        return Err(bad(Place::file("--level"), args.level.to_string(), expected));
    }
    if args.max_degree.is_some_and(|h| h < args.min_degree) {
        let found = format!("--min-degree {} above it", args.min_degree);
        return Err(bad(Place::file("--max-degree"), found, "a degree of at least --min-degree"));
    }
    Ok(Options {
        // the decimal that was meant: 1 - 0.95 is not quite 0.05
        alpha: ((1.0 - args.level) * 1e12).round() / 1e12,
        lowest: args.min_degree,
        highest: args.max_degree,
        degree: args.degree,
        errors: match args.errors {
            None => Errors::Auto,
            Some(ErrorsArg::Means) => Errors::Means,
            Some(ErrorsArg::Readings) => Errors::Readings,
        },
    })
}

fn pairs(option: &str, texts: &[String]) -> Result<Vec<(String, String)>> {
    let pair = |t: &String| t.split_once('=').map(|(n, v)| (n.trim().to_string(), v.trim().to_string()));
    texts
        .iter()
        .map(|t| pair(t).ok_or_else(|| bad(Place::file(option), format!("`{t}`"), "NAME=VALUE of a state column")))
        .collect()
}

/// How the named joint moves the line; `None` where no joint is named.
fn mapping(args: &Args, robot: &Robot) -> Result<Option<Mapping>> {
    let Some(name) = &args.joint else { return Ok(None) };
    let Some(axis) = robot.axis_named(name) else {
        let expected = format!("one of {}", robot.axis_names().join(", "));
        return Err(bad(Place::file("--joint"), format!("joint `{name}`"), expected));
    };
    let kind = robot.axis(axis).kind;
    let lever = match (kind, args.lever_mm) {
        (JointKind::Prismatic, None) => 1.0,
        (JointKind::Prismatic, Some(_)) => {
            return Err(bad(Place::file("--lever-mm"), format!("a prismatic joint, {name}"), "a revolute joint"));
        }
        (JointKind::Revolute, Some(mm)) if mm.is_finite() && mm != 0.0 => mm * 1e-3,
        (JointKind::Revolute, _) => {
            let found = format!("a revolute joint, {name}, without a lever arm");
            return Err(bad(Place::file("--joint"), found, "--lever-mm: mm of the line per radian of the joint"));
        }
    };
    if !args.origin.is_finite() {
        return Err(bad(Place::file("--origin"), args.origin.to_string(), "a finite number"));
    }
    Ok(Some(Mapping { axis, lever, origin: args.origin * kind.si_per_user_unit(), reversed: args.reversed }))
}

fn um(v: Option<f64>) -> String {
    v.map_or("-".into(), |v| format!("{:.1}", v * 1e6))
}

fn between(ci: Option<[f64; 2]>) -> String {
    ci.map_or("-".into(), |c| format!("{:.1} to {:.1}", c[0] * 1e6, c[1] * 1e6))
}

fn p_text(p: f64) -> String {
    if p < 1e-4 { format!("{p:.1e}") } else { format!("{p:.4}") }
}

/// Poses and line, then the model.
fn tables(result: &Assessment) -> String {
    let mut text = String::new();
    for &state in &result.order {
        let name = result.states.text(state);
        if !name.is_empty() {
            let _ = writeln!(text, "State {name}{}\n", if state == result.order[0] { " (reference)" } else { "" });
        }
        let mut t = table(&[
            "position\nmm",
            "backlash\num",
            "95 %",
            "RP forward\num",
            "RP backward",
            "R\n(3 sigma)",
            "R ISO 230-2\n(2 sigma)",
            "pairs",
        ]);
        for p in result.poses.iter().filter(|p| p.state == state) {
            t.add_row(vec![
                digits(p.position_m * 1e3, 7),
                um(p.backlash.map(|b| b.mean_m)),
                between(p.backlash.and_then(|b| b.ci95_m)),
                um(p.forward.as_ref().and_then(|w| w.repeatability_m())),
                um(p.backward.as_ref().and_then(|w| w.repeatability_m())),
                um(p.bidirectional_m(3.0)),
                um(p.bidirectional_m(2.0)),
                p.pairs_m.len().to_string(),
            ]);
        }
        let _ = writeln!(text, "{t}\n");
        if let Some(l) = result.lines.iter().find(|l| l.state == state) {
            let verdict = match l.p_value {
                Some(p) if p < result.alpha => format!("the directions differ along the line (p = {})", p_text(p)),
                Some(p) => format!("the directions do not differ along the line (p = {})", p_text(p)),
                None => "too few poses for a test over the line".into(),
            };
            let _ = writeln!(
                text,
                "Mean backlash {} um (95 %: {}): {verdict}.\nDifferent from 0 at {} of {} poses when each pose is tested alone. R of the line: {} um; by ISO 230-2: {} um.\n",
                um(Some(l.mean_m)),
                between(l.ci95_m),
                l.poses_beyond[0],
                l.poses_beyond[1],
                um(l.bidirectional_m),
                um(l.bidirectional_iso230_m),
            );
        }
    }
    if let Some(model) = &result.model {
        model_tables(&mut text, result, model);
    }
    text
}

fn model_tables(text: &mut String, result: &Assessment, model: &Model) {
    if !model.lack_of_fit.is_empty() {
        let mut t = table(&["degree", "F", "dof", "F critical", "p", "lack of fit"]);
        for l in &model.lack_of_fit {
            t.add_row(vec![
                l.degree.to_string(),
                format!("{:.3}", l.f),
                format!("{}, {}", l.dof[0], l.dof[1]),
                format!("{:.3}", l.f_critical),
                p_text(l.p_value),
                if l.adequate { "none" } else { "significant" }.to_string(),
            ]);
        }
        let _ = writeln!(text, "Lack of fit of the backlash over position\n\n{t}\n");
    }
    if !model.tests.is_empty() {
        let mut t = table(&["state", "term", "coefficient", "t", "t critical", "dof", "p", ""]);
        for s in &model.tests {
            let term = match s.order {
                0 => "offset".to_string(),
                1 => "slope".to_string(),
                k => format!("x^{k}"),
            };
            t.add_row(vec![
                result.states.difference(s.state, model.reference),
                term,
                format!("{} {}", digits(um_per_mm(s.coefficient, s.order), 4), equation::unit(s.order)),
                format!("{:.3}", s.t),
                format!("{:.3}", s.t_critical),
                s.dof.to_string(),
                p_text(s.p_value),
                if s.significant { "significant" } else { "not significant" }.to_string(),
            ]);
        }
        let _ = writeln!(text, "Student tests of the states\n\n{t}\n");
    }
    let _ = writeln!(text, "Backlash in um, x in mm, {}:", range(model));
    let _ = writeln!(text, "  {}", equation::of(model));
    let letters = model.blocks.len() - 1;
    for (k, block) in model.blocks[1..].iter().enumerate() {
        let state = block.state.map_or(String::new(), |s| result.states.difference(s, model.reference));
        let _ = writeln!(text, "  {} = 1 where {state}, else 0", equation::indicator(k, letters));
    }
}

fn range(model: &Model) -> String {
    let [lo, hi] = model.range_m.map(|v| digits(v * 1e3, 7));
    if lo == hi { format!("at {lo}") } else { format!("from {lo} to {hi}") }
}
