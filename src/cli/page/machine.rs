//! Page of `identify` over all logs of a machine: what compensation takes away at the TCP, what each joint loses after a reversal,
//! what is left out and why, single reversals.

use super::{gaps, milli, milli2};
use crate::gaps::Gaps;
use crate::gaps::after_reversal::AfterReversal;
use crate::gaps::estimate::{Agreement, Estimate, JointEstimate};
use crate::numerics::normal::Z95;
use crate::report::{
    BarRow, BarsView, GapPointView, GapsOver, GapsView, JointGapView, Page, Role, Run, ScheduleView, TableView, Tile,
    Tone, method,
};
use crate::robot::Robot;

/// Page of `identify` over all logs.
pub fn of_identify(robot: &Robot, found: &Gaps) -> Page {
    match &found.estimate {
        Some(estimate) => of_estimate(robot, found, estimate, "identify"),
        None => gaps::of_gaps(robot, found, "identify", "Lost motion from all logs", "all logs", method::PLAY),
    }
}

/// Page of `show` for a gaps document, whichever test it comes from.
pub fn of_document(robot: &Robot, found: &Gaps) -> Page {
    match &found.estimate {
        Some(estimate) => of_estimate(robot, found, estimate, "show"),
        None => gaps::of_gaps(robot, found, "show", "Half gaps of the joints", "the document", method::PLAY),
    }
}

/// The page of a joint estimate.
fn of_estimate(robot: &Robot, found: &Gaps, estimate: &Estimate, command: &str) -> Page {
    let mut page = super::start(command, "Lost motion of all joints", robot);
    for log in &found.logs {
        page.file("log", log.name.clone(), log.sha256.clone());
    }
    if let Some(r) = &found.registration {
        let text = format!("{:.1} µm per coordinate, {} samples", r.rms_m * 1e6, r.samples);
        page.option("residual of the registration", text);
    }
    answer(&mut page, robot, found, estimate);
    page.section(
        "Error at the TCP after the reversals of each joint",
        "Root mean square within 4 s after a reversal, on parts of the logs that the estimate did not use. After: predicted error of the robot itself with compensation, without the noise of the instrument.",
        before_after(robot, estimate),
    );
    let curves = after_reversals(robot, found, estimate);
    if !curves.is_empty() {
        page.section(
            "Lost motion of a joint after a reversal",
            "Sum of half gap, wind-up and friction spike, with its 95 % band: this is what a compensator adds to the command at the usual speed of the joint. Dots at the end: single reversals, each estimated only from a window around it.",
            GapsView { over: GapsOver::SinceReversal, joints: curves },
        );
    }
    page.section("Which joints are compensated, and why", "", decisions(robot, estimate));
    let compared = agreements(robot, estimate);
    if let Some(compared) = compared {
        page.section(
            "The fit of all logs and the single reversals",
            "Half gap, friction spike and wind-up together, right after a reversal: by the fit of all logs, which a compensator uses, and by single reversals, each estimated only from a window around it.",
            compared,
        );
    }
    gaps::sections(&mut page, robot, found, "all logs");
    page.section(
        "Each reversal by itself",
        "Lost motion of a single reversal as a multiple of the value of the model, with its 95 % interval.",
        single_reversals(robot, estimate),
    );
    page.section("", "", vec![method::PLAY, method::RESPONSE, method::REGISTRATION]);
    page
}

/// The answer in a sentence, and the figures along the paths.
fn answer(page: &mut Page, robot: &Robot, found: &Gaps, estimate: &Estimate) {
    let names = |compensate: bool| -> Vec<&str> {
        let those = estimate.joints.iter().filter(|j| j.trust.compensate == compensate);
        those.map(|j| robot.axis(j.axis).name.as_str()).collect()
    };
    let (helps, not) = (names(true), names(false));
    let um = |m: f64| m * 1e6;
    let worst = estimate.predicted.iter().max_by(|a, b| a.1.total_cmp(&b.1));
    let along = worst.map_or(String::new(), |(_, before, after)| {
        format!(": {:.0} µm rms off the path now, about {:.0} µm with it", um(*before), um(*after))
    });
    let left = match not.as_slice() {
        [] => String::new(),
        names => format!(
            " {} not compensated.",
            if names.len() == 1 { format!("{} is", names[0]) } else { format!("{} are", names.join(", ")) }
        ),
    };
    match &found.distrust {
        Some(why) => page.verdict(Tone::Bad, format!("{why}.")),
        None if helps.is_empty() => {
            page.verdict(Tone::Plain, "No joint for which compensation clearly reduces the error.")
        }
        None => page.verdict(Tone::Good, format!("Compensation helps at {}{along}.{left}", helps.join(", "))),
    };
    for (log, before, after) in &estimate.predicted {
        let tile = Tile::number(format!("rms off the path, {}", super::file_name(log)), um(*after), 1, "µm");
        page.tile(tile.with_detail(format!("predicted; without compensation {:.1} µm", um(*before))));
    }
}

/// Error of each joint before and after.
fn before_after(robot: &Robot, estimate: &Estimate) -> BarsView {
    let row = |j: &JointEstimate| {
        let after = if j.trust.compensate { j.trust.after_m } else { j.trust.before_m };
        BarRow { label: robot.axis(j.axis).name.clone(), values: vec![Some(j.trust.before_m * 1e6), Some(after * 1e6)] }
    };
    BarsView {
        quantity: "error after reversals".into(),
        unit: "µm rms".into(),
        runs: vec![Run::new("before", Role::Before), Run::new("after", Role::After)],
        rows: estimate.joints.iter().filter(|j| j.trust.reversals > 0).map(row).collect(),
    }
}

/// The curve of each joint whose speed the logs show.
fn after_reversals(robot: &Robot, found: &Gaps, estimate: &Estimate) -> Vec<JointGapView> {
    let curve = |gap| Some((gap, estimate.after_reversal(robot, gap, &found.points)?));
    let view = |(gap, curve): (&crate::gaps::JointGap, AfterReversal)| {
        let (axis, joint) = (gap.axis, robot.axis(gap.axis));
        let milli_of = |v: &f64| milli(robot, axis, *v);
        let band = curve.lost.iter().zip(&curve.sigma).map(|(l, s)| milli2(robot, axis, [l - Z95 * s, l + Z95 * s]));
        let end = curve.lost.last().copied().unwrap_or(0.0);
        let scatter = estimate.joints.iter().find(|j| j.axis == axis).map_or(0.0, |j| j.scatter);
        let at_end = GapPointView {
            at_deg_mm: curve.t_s.last().copied().unwrap_or(0.0),
            half_gap_milli: milli(robot, axis, end),
            ci95_milli: milli2(robot, axis, [end * (1.0 - Z95 * scatter), end * (1.0 + Z95 * scatter)]),
            per_cycle_milli: curve.single.iter().map(milli_of).collect(),
        };
        JointGapView {
            joint: joint.name.clone(),
            finding: format!("at {:.2} {}/s", joint.kind.to_user_unit(curve.speed), joint.kind.unit()),
            points: vec![at_end],
            constant_milli: None,
            schedule: Some(ScheduleView {
                half_gap_milli: curve.lost.iter().map(milli_of).collect(),
                band_milli: band.collect(),
                at_deg_mm: curve.t_s,
            }),
        }
    };
    found.joints.iter().filter_map(curve).map(view).collect()
}

/// What is done about each joint, with the reason.
fn decisions(robot: &Robot, estimate: &Estimate) -> TableView {
    let columns = [
        ("joint", false),
        ("compensation", false),
        ("before, µm", true),
        ("after, µm", true),
        ("reversals", true),
        ("scatter", true),
        ("because it", false),
    ];
    let row = |j: &JointEstimate| {
        let t = &j.trust;
        vec![
            robot.axis(j.axis).name.clone(),
            if t.compensate { "yes" } else { "no" }.into(),
            if t.reversals == 0 { "–".into() } else { format!("{:.1}", t.before_m * 1e6) },
            if t.compensate { format!("{:.1}", t.after_m * 1e6) } else { "–".into() },
            t.reversals.to_string(),
            format!("{:.0} %", j.scatter * 100.0),
            t.reason.to_string(),
        ]
    };
    TableView::new(&columns, estimate.joints.iter().map(row))
}

/// Both estimates of each joint's lost motion; `None` where no joint has enough reversals.
fn agreements(robot: &Robot, estimate: &Estimate) -> Option<TableView> {
    let columns = [
        ("joint", false),
        ("all logs", true),
        ("95 %", true),
        ("single reversals", true),
        ("95 %", true),
        ("agree", false),
    ];
    let row = |(axis, a): (usize, Agreement)| {
        let joint = robot.axis(axis);
        let edge = |v: f64| format!("{:.5}", joint.kind.to_user_unit(v));
        let span = |[low, high]: [f64; 2]| format!("{} to {}", edge(low), edge(high));
        vec![
            joint.name.clone(),
            format!("{} {}", edge(a.all_logs), joint.kind.unit()),
            span(a.all_logs_ci95),
            format!("{} {}", edge(a.single), joint.kind.unit()),
            span(a.single_ci95),
            if a.agree { "yes" } else { "no" }.into(),
        ]
    };
    let rows: Vec<Vec<String>> = estimate.joints.iter().filter_map(|j| Some((j.axis, j.agreement?))).map(row).collect();
    (!rows.is_empty()).then(|| TableView::new(&columns, rows))
}

/// Single reversals, those that stand out marked.
fn single_reversals(robot: &Robot, estimate: &Estimate) -> TableView {
    let columns = [
        ("joint", false),
        ("position", true),
        ("time, s", true),
        ("log", false),
        ("times the model", true),
        ("± 95 %", true),
        ("note", false),
    ];
    let row = |r: &crate::gaps::estimate::LocalReversal| {
        let joint = robot.axis(r.axis);
        vec![
            joint.name.clone(),
            format!("{:.3} {}", joint.kind.to_user_unit(r.at), joint.kind.unit()),
            format!("{:.1}", r.t_s),
            r.log.clone(),
            format!("{:.2}", r.ratio),
            format!("{:.2}", Z95 * r.sigma),
            if r.outlying { "outlying".into() } else { String::new() },
        ]
    };
    TableView::new(&columns, estimate.reversals.iter().map(row))
}
