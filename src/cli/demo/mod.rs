//! `lostmotion demo`: the whole job on bundled input, from log to rewritten program and report.
//!
//! [`bundle`] holds the input, [`runs`] executes programs on the bundled machine.

mod bundle;
mod runs;

use super::page;
use crate::assess::circle::Measured;
use crate::compensator::{BacklashOffset, Compensator, Evidence, FrictionOffset, FrictionShape, JointCompensator};
use crate::effects::GapCurve;
use crate::error::Error;
use crate::fit::{Form, fit};
use crate::gaps::file;
use crate::identify::{path, static_test};
use crate::io::output::write_whole;
use crate::log::registration::Registered;
use crate::report::{Page, Role, TableView, Tone};
use crate::rewrite::{Options, Refine};
use crate::robot::Robot;
use anyhow::{Context, Result};
use comfy_table::{CellAlignment, Table, presets::UTF8_HORIZONTAL_ONLY};
use std::path::{Path, PathBuf};

/// Run the whole job on bundled logs: identify, fit, rewrite, simulate before and after, report.
///
/// The logs come from an independent simulation of a published laser-tracker experiment (KUKA KR 120, circle of 250 mm at
/// 1.5 mm/s). The demo identifies gaps and stiction, fits a compensator, and rewrites the circle program in two ways and,
/// for comparison, with the published controller. Then it runs all programs on the simulated machine with 11 um of tracker
/// noise.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  lostmotion demo
  lostmotion demo --output-dir demo-2
  lostmotion demo --json | jq '.runs[] | {name, largest_um, mean_reduction}'")]
pub struct Args {
    /// Folder for the output files; it is created if it does not exist
    #[arg(long, value_name = "DIR", default_value = "demo-out")]
    pub output_dir: PathBuf,
    /// Print the result as one JSON document on standard output instead of the table
    #[arg(long)]
    pub json: bool,
}

const DENSE: &str = "this tool, dense path";

/// What the table and the page show of one run.
struct Shown {
    name: &'static str,
    role: Role,
    points: usize,
    measured: Measured,
}

/// The circle program, and what became of it.
struct Programs {
    nominal: PathBuf,
    /// Its own points, with offsets.
    offsets: PathBuf,
    /// With points between them.
    dense: PathBuf,
    /// By the published controller.
    published: PathBuf,
}

impl Programs {
    fn rewrite(robot: &Robot, compensator: &Compensator, dir: &Path) -> Result<Self> {
        eprintln!("rewrite: the circle program, its own points kept; then with a dense path");
        let mut options = Options::new(robot.dof());
        options.tcp_speed_m_s = compensator.evidence.tcp_speed_m_s;
        let nominal = dir.join("circle_program.csv");
        write_whole(&nominal, bundle::PROGRAM)?;
        let offsets = dir.join("circle_compensated.csv");
        runs::rewrite(robot, compensator, options.clone(), &nominal, &offsets)?;
        let dense = dir.join("circle_compensated_dense.csv");
        options.refine = Refine::Cartesian;
        runs::rewrite(robot, compensator, options, &nominal, &dense)?;
        let published = dir.join("circle_published_controller.csv");
        runs::rewrite_as_printed(robot, &published_controller(robot), &nominal, &published)?;
        Ok(Self { nominal, offsets, dense, published })
    }
}

/// Gaps from the static tests and from the circle.
fn identify(robot: &Robot, dir: &Path) -> Result<(static_test::Found, path::PathFound)> {
    eprintln!("identify static: six logs of bidirectional dwells");
    let still = static_test::identify(robot, &bundle::static_logs(robot)?, &static_test::Options::default())
        .context("identify static, on the bundled logs")?;
    write_whole(&dir.join("static.gaps.yaml"), file::to_yaml(&file::document(&still.gaps, robot))?.as_bytes())?;

    eprintln!("identify path: a circle log of 52,358 rows, tracker frame unknown");
    let found = path::identify(robot, &[bundle::circle_log(robot)?], &path::Options::default())
        .context("identify path, on the bundled circle")?;
    write_whole(&dir.join("circle.gaps.yaml"), file::to_yaml(&file::document(&found.gaps, robot))?.as_bytes())?;
    Ok((still, found))
}

/// Runs the command.
pub fn run(args: Args) -> Result<()> {
    let dir = args.output_dir.as_path();
    std::fs::create_dir_all(dir).map_err(|e| Error::io(dir, "create", e))?;
    let robot = bundle::robot()?;

    let (still, found) = identify(&robot, dir)?;
    eprintln!("fit: compensator from the circle");
    let compensator = fit(&robot, std::slice::from_ref(&found.gaps), Form::Decay).context("fit")?;
    write_whole(&dir.join("compensator.yaml"), compensator.to_yaml(&robot)?.as_bytes())?;

    let Programs { nominal, offsets, dense, published } = Programs::rewrite(&robot, &compensator, dir)?;

    eprintln!("simulate: each program on the machine, 25 Hz, noise 11 um");
    let machine = bundle::machine()?;
    let mut shown: Vec<Shown> = Vec::new();
    let mut circle = None;
    for (name, role, program) in [
        ("without", Role::Before, &nominal),
        ("published controller", Role::Between, &published),
        ("this tool, own points", Role::Between, &offsets),
        (DENSE, Role::After, &dense),
    ] {
        let log = runs::run(&machine, program, &program.with_extension("log.csv"))
            .with_context(|| format!("simulate, {name}"))?;
        let (points, measured, plan) = runs::assess(&robot, &nominal, program, &log)?;
        shown.push(Shown { name, role, points, measured });
        circle.get_or_insert(plan);
    }
    // the dense program's own log, through the same inverse, for the joint error traces after
    let after = runs::log(&robot, &dense.with_extension("log.csv"))?;
    let after = path::identify(&robot, &[after], &path::Options::default())
        .ok()
        .zip(circle.as_ref())
        .map(|(mut a, plan)| runs::against_nominal(&robot, plan, &nominal, &mut a).map(|()| a));
    let after = after.transpose()?;

    let report = dir.join("report.html");
    if let Some(nominal) = &circle {
        let mut page = page::start("demo", "Circle of 250 mm, before and after compensation", &robot);
        page.summary = "Simulated laser-tracker logs of a KUKA KR 120 R2500 PRO: gaps identified, a compensator fitted, the program \
                        rewritten, and run again on the simulated machine. Nothing here was measured on a real robot."
            .into();
        describe(&mut page, &robot, &still, &found, &compensator, nominal, &shown, after.as_ref());
        write_whole(&report, page.render().as_bytes())?;
    }
    if args.json {
        let text = serde_json::to_string_pretty(&document(&shown)).map_err(|e| Error::internal("write JSON", e))?;
        return write_whole(Path::new("-"), (text + "\n").as_bytes()).map_err(Into::into);
    }
    write_whole(Path::new("-"), table(&robot, &shown, circle.as_ref()).as_bytes())?;
    eprintln!("files and report.html in {}", crate::error::shown(dir));
    Ok(())
}

/// The controller of Zhang (2023) Table 3 (multi-axis test).
fn published_controller(robot: &Robot) -> Compensator {
    let joint = |axis: usize, d_deg: f64, g_deg: f64| {
        let gap = GapCurve::Constant(d_deg.to_radians());
        let shape = FrictionShape::Poses { exponent: 3.0, poses: 5 };
        let friction = (g_deg > 0.0).then(|| FrictionOffset { gain: g_deg.to_radians(), shape });
        JointCompensator { axis, backlash: Some(BacklashOffset::symmetric(gap)), friction }
    };
    Compensator {
        robot_name: robot.name.clone(),
        robot_sha256: robot.fingerprint(),
        joints: vec![joint(0, 0.0028, 0.0034), joint(1, 0.0037, 0.0), joint(2, 0.0022, 0.0017)],
        evidence: Evidence::default(),
    }
}

#[allow(clippy::too_many_arguments)]
fn describe(
    page: &mut Page,
    robot: &Robot,
    still: &static_test::Found,
    found: &path::PathFound,
    compensator: &Compensator,
    nominal: &crate::assess::circle::Nominal,
    shown: &[Shown],
    after: Option<&path::PathFound>,
) {
    let named = |s: &'static str, r: Role, m| page::circle::Named { name: s, role: r, measured: m, chords: s != DENSE };
    let all: Vec<page::circle::Named> = shown.iter().map(|s| named(s.name, s.role, &s.measured)).collect();
    // the figures show three runs: four lines on one circle hide each other
    let drawn: Vec<page::circle::Named> =
        [0, 1, 3].iter().filter_map(|&i| shown.get(i)).map(|s| named(s.name, s.role, &s.measured)).collect();
    page::circle::head(page, &all);
    for log in still.gaps.logs.iter().chain(&found.gaps.logs) {
        page.file("log", log.name.clone(), log.sha256.clone());
    }
    page::circle::around(page, robot, nominal, &drawn);
    page::circle::table(page, robot, nominal, &all);
    page::circle::figures(page, robot, nominal, &drawn);
    let mut runs = vec![("without", Role::Before, found)];
    runs.extend(after.map(|a| ("this tool, dense path, against the nominal program", Role::After, a)));
    page::gaps::traces(page, robot, &runs);
    page::gaps::sections(page, robot, &found.gaps, "the circle");
    page::gaps::sections(page, robot, &still.gaps, "the static tests");
    if let Some(r) = found.gaps.registration.as_ref() {
        page.section("The tracker's frame, found with the gaps", "", registration(r));
    }
    page::compensator::sections(page, robot, compensator);
    let methods = [page::circle::methods(), page::gaps::methods(), page::compensator::methods()].concat();
    page.section("", "", methods);
    if page.verdict.tone == Tone::Plain {
        page.verdict.tone = Tone::Good;
    }
}

fn registration(r: &Registered) -> TableView {
    let t = r.frame.translation.vector * 1e3;
    let (roll, pitch, yaw) = r.frame.rotation.euler_angles();
    let um = |v: f64| format!("{:.1}", v * 1e6);
    let row = |name: &str, v: String, s: String| vec![name.to_string(), v, s];
    let mut rows = Vec::new();
    for (k, name) in ["x", "y", "z"].iter().enumerate() {
        rows.push(row(&format!("{name}, mm"), format!("{:.4}", t[k]), format!("{} µm", um(r.sigma_m[k]))));
    }
    for (k, (name, angle)) in [("roll", roll), ("pitch", pitch), ("yaw", yaw)].iter().enumerate() {
        let sigma = format!("{:.2} mdeg", r.sigma_rad[k].to_degrees() * 1e3);
        rows.push(row(&format!("{name}, deg"), format!("{:.5}", angle.to_degrees()), sigma));
    }
    rows.push(row("residual per coordinate, µm", um(r.rms_m), format!("{} samples", r.samples)));
    TableView::numbers_after(1, &["base to tracker", "value", "standard uncertainty"], rows)
}

/// Like Table 5 of the paper.
fn table(robot: &Robot, shown: &[Shown], nominal: Option<&crate::assess::circle::Nominal>) -> String {
    let mut t = Table::new();
    t.load_preset(UTF8_HORIZONTAL_ONLY);
    let mut header = vec!["total error at the reversals, um".to_string()];
    header.extend(
        nominal.iter().flat_map(|n| &n.reversals).map(|r| format!("{}\n{:.0} deg", robot.axis(r.axis).name, r.at_deg)),
    );
    header.extend(["mean\nreduction", "in plane\nlargest", "out of\nplane", "points"].map(String::from));
    t.set_header(header);
    for s in shown {
        let mut row = vec![s.name.to_string()];
        row.extend(s.measured.reversals.iter().map(|r| r.total_m.map_or("-".into(), |v| format!("{:.0}", v * 1e6))));
        let reduction = shown
            .first()
            .filter(|f| f.name != s.name)
            .and_then(|f| page::circle::mean_reduction(&f.measured, &s.measured));
        row.push(reduction.map_or(String::new(), |r| format!("{:.0} %", r * 100.0)));
        row.push(format!("{:.0}", s.measured.in_plane_max_m * 1e6));
        row.push(format!("{:.0}", s.measured.out_of_plane_max_m * 1e6));
        row.push(s.points.to_string());
        t.add_row(row);
    }
    for column in t.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    format!("{t}\n")
}

/// What `--json` prints.
#[derive(serde::Serialize)]
struct Document {
    schema: &'static str,
    runs: Vec<RunFields>,
}

#[derive(serde::Serialize)]
struct RunFields {
    name: &'static str,
    points: usize,
    total_um: Vec<Option<f64>>,
    largest_um: f64,
    in_plane_max_um: f64,
    out_of_plane_max_um: f64,
    mean_reduction: Option<f64>,
}

fn document(shown: &[Shown]) -> Document {
    let um = |v: f64| (v * 1e7).round() / 10.0;
    let run = |s: &Shown| {
        let reduction = shown.first().and_then(|f| page::circle::mean_reduction(&f.measured, &s.measured));
        RunFields {
            name: s.name,
            points: s.points,
            total_um: s.measured.reversals.iter().map(|r| r.total_m.map(um)).collect(),
            largest_um: um(page::circle::largest_um(&s.measured) * 1e-6),
            in_plane_max_um: um(s.measured.in_plane_max_m),
            out_of_plane_max_um: um(s.measured.out_of_plane_max_m),
            mean_reduction: reduction.map(|r| (r * 1e4).round() / 1e4),
        }
    };
    Document { schema: "lostmotion/demo/1", runs: shown.iter().map(run).collect() }
}
