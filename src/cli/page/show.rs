//! Pages of `show`: a log, a program, a machine as they are.

use crate::error::counted;
use crate::log::Log;
use crate::log::registration::{Pair, register_line};
use crate::model::Model;
use crate::numerics::robust::range;
use crate::program::{Program, ScriptPath, note::Note};
use crate::report::{JointTraces, PathMark, PathRun, PathView, Role, Run, TracePanel, TraceRun, TracesView};
use crate::report::{Page, TableView, Tile, Tone};
use crate::robot::Robot;
use nalgebra::{Isometry3, Point3, Vector3};

/// Points of a drawn path and of a drawn trace.
const DRAWN: usize = 1500;
/// Movement that is none, rad or m.
const STILL: f64 = 1e-6;

/// Rows of joint positions, by axis.
struct Motion<'a> {
    q: Vec<&'a [f64]>,
    t_s: Option<&'a [f64]>,
}

impl Motion<'_> {
    fn rows(&self) -> usize {
        self.q.first().map_or(0, |c| c.len())
    }

    fn row(&self, i: usize) -> Vec<f64> {
        self.q.iter().map(|c| c[i]).collect()
    }

    fn drawn(&self) -> Vec<usize> {
        (0..self.rows()).step_by(self.rows().div_ceil(DRAWN).max(1)).collect()
    }

    /// Rows in which an axis turns round, with its new direction.
    fn reversals(&self, axis: usize) -> Vec<(usize, i8)> {
        let (mut out, mut last) = (Vec::new(), 0i8);
        let Some((first, rest)) = self.q[axis].split_first() else { return out };
        let mut from = *first;
        for (i, v) in rest.iter().enumerate() {
            if (v - from).abs() > STILL {
                let now = if *v > from { 1 } else { -1 };
                if last != 0 && now != last {
                    out.push((i, now));
                }
                (last, from) = (now, *v);
            }
        }
        out
    }
}

/// A log: its path by the commands and as measured, every joint over time.
pub fn of_log(robot: &Robot, log: &Log) -> Page {
    let motion = Motion { q: log.cmd.iter().map(Vec::as_slice).collect(), t_s: (!log.poses).then_some(&log.t_s) };
    let mut page = super::start("show", super::file_name(&log.name), robot);
    log_verdict(&mut page, robot, log, &motion);
    log_figures(&mut page, robot, log, &motion, "measured");
    page
}

/// Path and joints of a predicted log, for the page of another command.
pub fn figures_of_log(page: &mut Page, robot: &Robot, log: &Log) {
    let motion = Motion { q: log.cmd.iter().map(Vec::as_slice).collect(), t_s: (!log.poses).then_some(&log.t_s) };
    log_figures(page, robot, log, &motion, "predicted");
}

fn log_verdict(page: &mut Page, robot: &Robot, log: &Log, motion: &Motion) {
    let seen = log.tcp_m.iter().flatten().count();
    let turns: usize = (0..robot.dof()).map(|a| motion.reversals(a).len()).sum();
    let what = if log.poses { "settled pose" } else { "row" };
    page.verdict(
        Tone::Plain,
        format!(
            "{}, {} with a measured TCP, {} of joints.",
            counted(log.len(), what),
            seen,
            counted(turns, "reversal")
        ),
    );
    if let (Some(t), false) = (motion.t_s, log.is_empty()) {
        let span = t[t.len() - 1] - t[0];
        page.tile(Tile::number("duration", span, 1, "s"));
        page.tile(Tile::number("rows a second", (t.len() - 1) as f64 / span.max(f64::MIN_POSITIVE), 1, "Hz"));
    }
}

fn log_figures(page: &mut Page, robot: &Robot, log: &Log, motion: &Motion, name: &str) {
    let pairs: Vec<Pair> = (motion.drawn().into_iter())
        .filter_map(|i| Some(Pair { base_m: robot.tcp_m(&motion.row(i)), tracker_m: (*log.tcp_m.get(i)?)? }))
        .collect();
    let found = register_line(&pairs).ok().map(|r| r.found);
    if let Some(r) = &found {
        page.tile(
            Tile::number("off the commanded path", r.rms_m * 1e6, 1, "µm")
                .with_detail("rms, frame of the tracker fitted"),
        );
    }
    let measured = found.map(|r| {
        let back: Isometry3<f64> = r.frame.inverse();
        let error = |p: &Pair| (back * Point3::from(p.tracker_m)).coords - p.base_m;
        PathRun {
            run: Run::new(name, Role::Before),
            reference_mm: pairs.iter().map(|p| (p.base_m * 1e3).into()).collect(),
            error_um: pairs.iter().map(|p| (error(p) * 1e6).into()).collect(),
        }
    });
    draw(page, robot, motion, measured.into_iter().collect());
}

/// A program: its path and every joint along it.
pub fn of_program(robot: &Robot, program: &Program) -> Page {
    let mut columns = vec![Vec::with_capacity(program.len()); robot.dof()];
    let mut q = vec![0.0; robot.dof()];
    for i in 0..program.len() {
        program.point_into(i, &mut q);
        columns.iter_mut().zip(&q).for_each(|(c, v)| c.push(*v));
    }
    let motion = Motion { q: columns.iter().map(Vec::as_slice).collect(), t_s: program.t_s.as_deref() };
    let mut page = super::start("show", super::file_name(&program.name), robot);
    let turns: usize = (0..robot.dof()).map(|a| motion.reversals(a).len()).sum();
    page.verdict(
        Tone::Plain,
        format!("{}, {} of joints.", counted(program.len(), "point"), counted(turns, "reversal")),
    );
    draw(&mut page, robot, &motion, Vec::new());
    let notes = program.script.as_ref().map(ScriptPath::left).unwrap_or_default();
    if !notes.is_empty() {
        page.section("Notes", "", notes.iter().map(Note::to_string).collect::<Vec<_>>());
    }
    page
}

fn draw(page: &mut Page, robot: &Robot, motion: &Motion, runs: Vec<PathRun>) {
    let drawn = motion.drawn();
    let at_mm = |i: usize| -> [f64; 3] { (robot.tcp_m(&motion.row(i)) * 1e3).into() };
    let marks = (0..robot.dof()).flat_map(|a| motion.reversals(a).into_iter().map(move |r| (a, r)));
    let marks: Vec<PathMark> = marks
        .take(DRAWN)
        .map(|(a, (i, sense))| PathMark { joint: robot.axis(a).name.clone(), at_mm: at_mm(i), sense })
        .collect();
    page.section(
        "Path of the TCP",
        if runs.is_empty() {
            "Path of the commands in the robot's base frame; the marks show the reversals of joints."
        } else {
            "Path of the commands in the robot's base frame; the marks show the reversals of joints; errors are exaggerated."
        },
        PathView {
            exaggeration: super::EXAGGERATION,
            nominal_mm: drawn.iter().map(|&i| at_mm(i)).collect(),
            runs,
            marks,
            is_arm: false,
        },
    );
    let moving: Vec<usize> =
        (0..robot.dof()).filter(|&a| motion.q[a].windows(2).any(|w| (w[1] - w[0]).abs() > STILL)).collect();
    let trace = |a: usize| {
        let joint = robot.axis(a);
        let run = TraceRun {
            run: Run::new("command", Role::Before),
            model_x: drawn.iter().map(|&i| motion.t_s.map_or(i as f64, |t| t[i])).collect(),
            model_milli: drawn.iter().map(|&i| joint.kind.to_user_unit(motion.q[a][i])).collect(),
            ..TraceRun::default()
        };
        JointTraces { joint: joint.name.clone(), panels: vec![TracePanel { runs: vec![run], ..TracePanel::default() }] }
    };
    if !moving.is_empty() {
        let (x_name, x_unit) = if motion.t_s.is_some() { ("time", "s") } else { ("row", "points") };
        page.section(
            "Joints",
            "Those that move.",
            TracesView {
                x_name: x_name.into(),
                x_unit: x_unit.into(),
                y_name: "command".into(),
                y_whole: true,
                joints: moving.iter().map(|&a| trace(a)).collect(),
            },
        );
    }
    page.section("Travel", "", travel(robot, motion));
}

/// How far each joint goes, its limits and its reversals.
fn travel(robot: &Robot, motion: &Motion) -> TableView {
    let row = |a: usize| {
        let joint = robot.axis(a);
        let all = range(motion.q[a].iter().copied());
        let edge = |v: f64| format!("{:.3}", joint.kind.to_user_unit(v));
        let limits = joint.limits.map_or("-".into(), |[l, h]| format!("{} to {}", edge(l), edge(h)));
        let turns = motion.reversals(a).len().to_string();
        vec![joint.name.clone(), joint.kind.unit().into(), edge(all[0]), edge(all[1]), limits, turns]
    };
    let columns =
        [("joint", false), ("unit", false), ("lowest", true), ("highest", true), ("limits", true), ("reversals", true)];
    TableView::new(&columns, (0..robot.dof()).map(row))
}

/// A machine: the arm at zero and in the middle of its limits, its joints, and what is wrong with it.
pub fn of_model(model: &Model) -> Page {
    let robot = &model.robot;
    let mut page = super::start("show", &robot.name, robot);
    let reach = crate::robot::plausible::reach_m(robot) * 1e3;
    let axes = if robot.dof() == 1 { "1 axis".to_string() } else { format!("{} axes", robot.dof()) };
    let effects = match model.effects.len() {
        0 => String::new(),
        n => format!(", {} that move the TCP off its path", counted(n, "known effect")),
    };
    page.verdict(Tone::Plain, format!("{axes}, {reach:.0} mm of reach at most{effects}."));
    page.tile(Tile::number("reach at most", reach, 0, "mm"));
    let middle: Vec<f64> = robot.axis_joints().map(|j| j.limits.map_or(0.0, |[l, h]| 0.5 * (l + h))).collect();
    for (title, q) in [("The arm at zero", vec![0.0; robot.dof()]), ("The arm in the middle of its limits", middle)] {
        let mut points: Vec<Vector3<f64>> = vec![robot.base.translation.vector];
        robot.chain().frames(&q, |_, frame| points.push(frame[3]));
        points.push(robot.tcp_m(&q));
        // no -0.0
        let tcp = points[points.len() - 1].map(|m| (m * 1e4).round() / 10.0 + 0.0);
        page.section(
            title,
            format!(
                "Lines between the joints, from the base to the TCP at {:.1}, {:.1}, {:.1} mm.",
                tcp.x, tcp.y, tcp.z
            ),
            PathView {
                exaggeration: 1.0,
                nominal_mm: points.iter().map(|p| (p * 1e3).into()).collect(),
                runs: Vec::new(),
                marks: Vec::new(),
                is_arm: true,
            },
        );
    }
    let rows = robot.joints.iter().map(|j| {
        let unit = j.kind.unit();
        let edge =
            |v: f64| format!("{:.4}", j.kind.to_user_unit(v)).trim_end_matches('0').trim_end_matches('.').to_string();
        vec![
            j.name.clone(),
            j.kind.pick(["revolute", "prismatic"]).into(),
            format!("{:.4} deg, {:.4} mm", j.theta_rad.to_degrees(), j.d_m * 1e3),
            format!("{:.4} mm", j.a_m * 1e3),
            format!("{:.4} deg", j.alpha_rad.to_degrees()),
            j.limits.map_or("-".into(), |[l, h]| format!("{} to {} {unit}", edge(l), edge(h))),
        ]
    });
    let headings = ["joint", "kind", "theta or d at 0", "a", "alpha", "limits"];
    page.section("Joints", "", TableView::words(&headings, rows));
    if !model.effects.is_empty() {
        page.section("Effects of the model", "", super::effects(model));
    }
    page
}
