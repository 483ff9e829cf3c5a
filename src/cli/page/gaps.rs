//! Sections about an identification: gap over position (Zhang (2023) Figure 5), the table of gaps and stiction, joint error
//! traces (Figures 3 and 13).

use super::{milli, milli2};
use crate::effects::Decay;
use crate::gaps::{Gaps, JointGap, Note};
use crate::identify::deadzone;
use crate::identify::path::PathFound;
use crate::identify::static_test::Found;
use crate::numerics::robust::range;
use crate::report::views::file_name;
use crate::report::{
    BarRow, BarsView, GapPointView, GapRow, GapsOver, GapsView, JointGapView, JointTraces, Page, Role, Run,
    ScheduleView, StictionRow, Tile, Tone, TraceMark, TracePanel, TraceRun, TracesView, method,
};
use crate::robot::{JointKind, Robot};

/// Half gaps of revolute joints from here on are shown in degrees, not in thousandths: those of tendons, not of gears.
const WIDE_DEG: f64 = 0.1;

/// The gap over position where points were tested, then the table of gaps.
pub fn sections(page: &mut Page, robot: &Robot, gaps: &Gaps, from: &str) {
    let rows: Vec<GapRow> = gaps.joints.iter().map(|j| row(robot, j)).collect();
    let unit = if page.joints.iter().any(|j| j.wide_gaps) {
        "With 95 % intervals. Degrees, or micrometres of a prismatic joint."
    } else {
        "With 95 % intervals. Thousandths of a degree (mdeg) or micrometres."
    };
    if gaps.points.len() > gaps.joints.len() {
        let joints = gaps.joints.iter().map(|j| over_position(robot, gaps, j)).collect();
        page.section(
            format!("Half gap over position, {from}"),
            "Each position with its 95 % interval and its repeats. The line is the constant or the schedule that a compensator uses.",
            GapsView { over: GapsOver::Position, joints },
        );
    }
    if gaps.points.is_empty() && page.sections.is_empty() {
        bars(page, robot, gaps);
    }
    page.section(format!("Half gaps from {from}"), unit, rows);
    if !gaps.notes.is_empty() {
        page.section(format!("Notes on {from}"), "", gaps.notes.iter().map(shown).collect::<Vec<_>>());
    }
}

/// A note in words; one on a log names its file without the folder. What was read from a document begins with the file, too.
fn shown(note: &Note) -> String {
    if let Note::Read(text) = note {
        let split = text.split_once(": ").map(|(file, rest)| format!("{}: {rest}", file_name(file)));
        return split.unwrap_or_else(|| text.clone());
    }
    let mut note = note.clone();
    if let Some(log) = note.log_mut() {
        *log = file_name(log);
    }
    note.to_string()
}

/// A bar for each joint's half gap, where nothing else is drawn: readings of a ballbar or a gauge give no positions. Joints of each kind
/// apart.
fn bars(page: &mut Page, robot: &Robot, gaps: &Gaps) {
    let wide = page.joints.iter().any(|j| j.wide_gaps);
    for kind in [JointKind::Revolute, JointKind::Prismatic] {
        let of_kind = gaps.joints.iter().filter(|j| robot.axis(j.axis).kind == kind);
        let (unit, factor) = match kind {
            JointKind::Revolute if wide => ("deg", 1e-3),
            JointKind::Revolute => ("mdeg", 1.0),
            JointKind::Prismatic => ("µm", 1.0),
        };
        let row = |j: &JointGap| BarRow {
            label: robot.axis(j.axis).name.clone(),
            values: vec![Some(factor * milli(robot, j.axis, j.half_gap))],
        };
        let rows: Vec<BarRow> = of_kind.map(row).collect();
        if !rows.is_empty() {
            let view = BarsView {
                quantity: "half gap".into(),
                unit: unit.into(),
                runs: vec![Run::new("half gap", Role::Before)],
                rows,
            };
            page.section("Half gap of each joint", "The table below has the 95 % intervals.", view);
        }
    }
}

/// The model that is fitted.
pub fn methods() -> Vec<method::Method> {
    vec![method::PLAY, method::STICTION]
}

fn row(robot: &Robot, j: &JointGap) -> GapRow {
    let stiction = j.stiction.as_ref().map(|s| {
        let kind = robot.axis(j.axis).kind;
        let (decay, decay_ci95, decay_unit) = match s.decay {
            Decay::Time(t) => (t, s.decay_ci95, "s"),
            Decay::Travel(x) => (kind.to_user_unit(x), s.decay_ci95.map(|v| kind.to_user_unit(v)), kind.unit()),
        };
        StictionRow {
            spike_milli: milli(robot, j.axis, s.spike),
            ci95_milli: milli2(robot, j.axis, s.ci95),
            decay,
            decay_ci95,
            decay_unit: decay_unit.into(),
        }
    });
    GapRow {
        joint: robot.axis(j.axis).name.clone(),
        half_gap_milli: milli(robot, j.axis, j.half_gap),
        ci95_milli: milli2(robot, j.axis, j.ci95),
        significant: j.significant,
        varies_p_value: j.varies_p_value,
        tcp_um: None,
        stiction,
    }
}

fn over_position(robot: &Robot, gaps: &Gaps, j: &JointGap) -> JointGapView {
    let kind = robot.axis(j.axis).kind;
    let points: Vec<GapPointView> = gaps
        .points
        .iter()
        .filter(|p| p.axis == j.axis)
        .map(|p| GapPointView {
            at_deg_mm: kind.to_user_unit(p.at),
            half_gap_milli: milli(robot, j.axis, p.half_gap),
            ci95_milli: milli2(robot, j.axis, p.ci95),
            per_cycle_milli: p.per_cycle.iter().map(|v| milli(robot, j.axis, *v)).collect(),
        })
        .collect();
    let [lo, hi] = range(points.iter().map(|p| p.at_deg_mm));
    let p = j.varies_p_value.map_or(String::new(), |p| format!(", p {}", crate::report::number::p_value(p)));
    let schedule = j.schedule.as_ref().filter(|_| lo < hi).map(|curve| {
        let at: Vec<f64> = (0..=200).map(|i| lo + (hi - lo) * f64::from(i) / 200.0).collect();
        let half_gap_milli = at.iter().map(|x| milli(robot, j.axis, curve.at(x * kind.si_per_user_unit()))).collect();
        ScheduleView { at_deg_mm: at, half_gap_milli, band_milli: Vec::new() }
    });
    JointGapView {
        joint: robot.axis(j.axis).name.clone(),
        finding: if schedule.is_some() { format!("varies{p}") } else { format!("constant{p}") },
        points,
        constant_milli: schedule.is_none().then(|| (milli(robot, j.axis, j.half_gap), milli2(robot, j.axis, j.ci95))),
        schedule,
    }
}

/// Joint errors over time, measured and fitted, with all reversals; one panel a run.
pub fn traces(page: &mut Page, robot: &Robot, runs: &[(&str, Role, &PathFound)]) -> bool {
    let mut joints: Vec<JointTraces> = Vec::new();
    let axes: std::collections::BTreeSet<usize> = runs.iter().flat_map(|r| &r.2.traces).map(|t| t.axis).collect();
    for axis in axes {
        let panels = runs.iter().flat_map(|(name, role, found)| {
            found.traces.iter().filter(move |t| t.axis == axis && t.log == 0).map(move |t| TracePanel {
                title: (*name).to_string(),
                runs: vec![TraceRun {
                    run: Run::new(*name, *role),
                    x: t.t_s.clone(),
                    error_milli: t.error.iter().map(|v| milli(robot, axis, *v)).collect(),
                    model_x: if t.fitted.is_empty() { Vec::new() } else { t.t_s.clone() },
                    model_milli: t.fitted.iter().map(|v| milli(robot, axis, *v)).collect(),
                }],
                marks: t
                    .reversals_s
                    .iter()
                    .map(|&x| TraceMark { joint: robot.axis(axis).name.clone(), x, sense: 0 })
                    .collect(),
            })
        });
        joints.push(JointTraces { joint: robot.axis(axis).name.clone(), panels: panels.collect() });
    }
    if joints.is_empty() {
        return false;
    }
    page.section(
        "Joint errors step at each reversal",
        "Actual minus commanded joint position from the measured TCP (inverse of the position Jacobian of the free joints, \
         registration fitted together with the gaps), averaged. The line is the identified model; the marks show the reversals of the joint.",
        TracesView { x_name: "time".into(), x_unit: "s".into(), y_name: String::new(), y_whole: false, joints },
    );
    true
}

/// Page of `identify static`.
pub fn of_static(robot: &Robot, found: &Found) -> Page {
    of_gaps(
        robot,
        &found.gaps,
        "identify static",
        "Half gaps from bidirectional dwells",
        "static tests",
        method::STATIC_GAP,
    )
}

/// Page of `identify deadzone`.
pub fn of_deadzones(robot: &Robot, found: &deadzone::Found) -> Page {
    let mut page = of_gaps(
        robot,
        &found.gaps,
        "identify deadzone",
        "Deadzones from growing sweeps",
        "the sweeps",
        method::DEADZONE,
    );
    page.sections.pop();
    page.section("", "", vec![method::DEADZONE, method::PLAY]);
    page
}

/// Page of `identify path` for a ballbar or a dial gauge.
pub fn of_readings(robot: &Robot, gaps: &Gaps) -> Page {
    of_gaps(robot, gaps, "identify path", "Half gaps from single readings", "the readings", method::PLAY)
}

/// Page of `identify path`.
pub fn of_path(robot: &Robot, found: &PathFound) -> Page {
    let mut page = of_gaps(
        robot,
        &found.gaps,
        "identify path",
        "Half gaps and stiction from a path",
        "the path",
        method::STICTION,
    );
    if traces(&mut page, robot, &[("measured", Role::Before, found)]) {
        page.last_first();
    }
    page
}

/// A page whose answer is which gaps were found.
pub fn of_gaps(robot: &Robot, gaps: &Gaps, command: &str, title: &str, from: &str, method: method::Method) -> Page {
    let mut page = super::start(command, title, robot);
    for log in &gaps.logs {
        page.file("log", log.name.clone(), log.sha256.clone());
    }
    let found: Vec<&str> =
        gaps.joints.iter().filter(|j| j.significant).map(|j| robot.axis(j.axis).name.as_str()).collect();
    let text = match found.as_slice() {
        [] => "No joint has a gap that exceeds its uncertainty.".to_string(),
        [one] => format!("{one} has a gap that exceeds its uncertainty."),
        names => format!("{} have gaps that exceed their uncertainty.", names.join(", ")),
    };
    match &gaps.distrust {
        Some(why) => page.verdict(Tone::Bad, format!("{why}.")),
        None => page.verdict(Tone::Plain, text),
    };
    let wide =
        |j: &JointGap| robot.axis(j.axis).kind == JointKind::Revolute && j.half_gap.abs().to_degrees() >= WIDE_DEG;
    let wide = gaps.joints.iter().any(wide);
    for joint in &mut page.joints {
        joint.wide_gaps = wide && joint.kind == JointKind::Revolute;
    }
    for j in &gaps.joints {
        let (factor, unit, decimals) = match robot.axis(j.axis).kind {
            JointKind::Revolute if wide => (1e-3, "deg", 4),
            JointKind::Revolute => (1.0, "mdeg", 2),
            JointKind::Prismatic => (1.0, "µm", 2),
        };
        let [lo, hi] = milli2(robot, j.axis, j.ci95).map(|v| v * factor);
        let value = milli(robot, j.axis, j.half_gap) * factor;
        let tile = Tile::number(format!("half gap of {}", robot.axis(j.axis).name), value, decimals, unit);
        page.tile(tile.with_detail(format!("95 %: {lo:.decimals$} to {hi:.decimals$}")));
    }
    if let Some(r) = &gaps.registration {
        page.option(
            "residual of the registration",
            format!("{:.1} µm per coordinate, {} samples", r.rms_m * 1e6, r.samples),
        );
    }
    sections(&mut page, robot, gaps, from);
    page.section("", "", vec![method, method::REGISTRATION]);
    page
}
