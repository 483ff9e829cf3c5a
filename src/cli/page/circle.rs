//! Sections about a circle: reversals (Zhang (2023) Table 5), path in space, polar plots, histogram (Figures 11 and 12).

use super::EXAGGERATION;
use crate::assess::circle::{Assessment, Measured, Nominal, Note};
use crate::report::{
    AngleMark, HistogramRun, HistogramView, Page, PathMark, PathRun, PathView, PolarRun, PolarView, ReversalRow,
    ReversalValue, ReversalsView, Role, Run, Tile, Tone, method,
};
use crate::robot::Robot;

/// One run of the circle and its name on the page.
pub struct Named<'a> {
    pub name: &'a str,
    pub role: Role,
    pub measured: &'a Measured,
    /// The program ran the nominal program's own chords; else "beyond nominal" means nothing.
    pub chords: bool,
}

/// Mean share by which the total error at the reversals fell from `before` to `after`.
pub fn mean_reduction(before: &Measured, after: &Measured) -> Option<f64> {
    let pairs = before.reversals.iter().zip(&after.reversals);
    let shares: Vec<f64> =
        pairs.filter_map(|(b, a)| Some(1.0 - a.total_m? / b.total_m.filter(|v| *v > 0.0)?)).collect();
    (!shares.is_empty()).then(|| shares.iter().sum::<f64>() / shares.len() as f64)
}

/// Largest total error at a reversal, um.
pub fn largest_um(m: &Measured) -> f64 {
    m.reversals.iter().filter_map(|r| r.total_m).fold(0.0, f64::max) * 1e6
}

/// Verdict and key figures: first run against last.
pub fn head(page: &mut Page, runs: &[Named]) {
    let (Some(first), Some(last)) = (runs.first(), runs.last()) else { return };
    let (before, after) = (largest_um(first.measured), largest_um(last.measured));
    if runs.len() == 1 {
        page.verdict(Tone::Plain, format!("Reversals leave up to {before:.0} µm on this circle."));
        page.tile(Tile::number("largest error at a reversal", before, 1, "µm"));
        page.tile(Tile::number("largest error on the circle", first.measured.total_max_m * 1e6, 1, "µm"));
        return;
    }
    let reduction = mean_reduction(first.measured, last.measured);
    let tone = match reduction {
        Some(r) if r > 0.7 => Tone::Good,
        Some(r) if r > 0.0 => Tone::Mixed,
        _ => Tone::Bad,
    };
    let share = reduction.map_or(String::new(), |r| format!(", {:.0} % less on average", r * 100.0));
    page.verdict(tone, format!("Errors at the reversals: up to {before:.0} µm before, {after:.0} µm after{share}."));
    page.tile(Tile::number("largest at a reversal", after, 1, "µm").with_detail(format!("before: {before:.1} µm")));
    if let Some(r) = reduction {
        page.tile(Tile::number("mean reduction at the reversals", r * 100.0, 0, "%"));
    }
    let detail = |b: f64| format!("before: {:.1} µm", b * 1e6);
    let (f, l) = (first.measured, last.measured);
    page.tile(
        Tile::number("in the plane, largest", l.in_plane_max_m * 1e6, 1, "µm").with_detail(detail(f.in_plane_max_m)),
    );
    page.tile(
        Tile::number("out of the plane, largest", l.out_of_plane_max_m * 1e6, 1, "µm")
            .with_detail(detail(f.out_of_plane_max_m)),
    );
}

fn named(r: &Named) -> Run {
    Run::new(r.name, r.role)
}

fn um(v: f64) -> f64 {
    v * 1e6
}

/// Errors at the reversals of all runs; the first is the one that reductions refer to.
pub fn table(page: &mut Page, robot: &Robot, nominal: &Nominal, runs: &[Named]) {
    let how = "Best-fit plane and circle (Taubin) of the last revolution; errors averaged over 1 s; the error of a reversal is the largest from 0.9° of the circle before it to 7.2° after it. Beyond nominal: without the error that the chords of the program cause.";
    let rows = nominal.reversals.iter().enumerate().map(|(i, r)| ReversalRow {
        joint: robot.axis(r.axis).name.clone(),
        at_deg: Some(r.at_deg),
        sense: r.direction,
        values: runs
            .iter()
            .enumerate()
            .map(|(k, run)| {
                let e = run.measured.reversals.get(i).copied().unwrap_or_default();
                let first = runs.first().and_then(|f| f.measured.reversals.get(i)?.total_m);
                ReversalValue {
                    total_um: e.total_m.map_or(f64::NAN, um),
                    beyond_nominal_um: e.beyond_nominal_m.filter(|_| run.chords).map(um),
                    reduction: if k == 0 { None } else { e.total_m.zip(first).map(|(a, b)| 1.0 - a / b) },
                }
            })
            .collect(),
    });
    let view = ReversalsView { runs: runs.iter().map(named).collect(), rows: rows.collect() };
    page.section("Error at each reversal", how, view);
}

/// Errors over the angle of the circle.
pub fn around(page: &mut Page, robot: &Robot, nominal: &Nominal, runs: &[Named]) {
    let marks = nominal.reversals.iter().map(|r| AngleMark {
        joint: robot.axis(r.axis).name.clone(),
        at_deg: r.at_deg,
        sense: r.direction,
    });
    let polar = PolarView {
        runs: runs
            .iter()
            .map(|r| {
                let t = &r.measured.trace;
                let angles = t.ideal_m.iter().map(|p| nominal.angle_deg(p)).collect();
                PolarRun {
                    run: named(r),
                    angle_deg: angles,
                    total_um: t.in_plane_m.iter().zip(&t.out_of_plane_m).map(|(i, o)| um(i.hypot(*o))).collect(),
                    in_plane_um: t.in_plane_m.iter().copied().map(um).collect(),
                    out_of_plane_um: t.out_of_plane_m.iter().copied().map(um).collect(),
                }
            })
            .collect(),
        marks: marks.collect(),
    };
    page.section(
        "Error around the circle",
        "Total, radial and normal error over the angle of the circle, averaged over 1 s.",
        polar,
    );
}

/// Path in space, histogram.
pub fn figures(page: &mut Page, robot: &Robot, nominal: &Nominal, runs: &[Named]) {
    page.section(
        "Deviation of the path from its circle",
        format!("Errors are drawn {EXAGGERATION:.0} times larger and averaged over 1 s; the marks show the reversals of joints."),
        path(robot, nominal, runs),
    );
    let histogram = HistogramView {
        quantity: "total error".into(),
        unit: "µm".into(),
        runs: runs
            .iter()
            .map(|r| {
                let t = &r.measured.trace;
                let mut values: Vec<f64> =
                    t.in_plane_m.iter().zip(&t.out_of_plane_m).map(|(i, o)| um(i.hypot(*o))).collect();
                values.sort_by(f64::total_cmp);
                let p95 = values.get(values.len() * 95 / 100).copied();
                HistogramRun { run: named(r), values, p95 }
            })
            .collect(),
    };
    page.section(
        "Distribution of the error",
        "Total error of the rows of the last revolution; 95 % are left of the mark.",
        histogram,
    );
}

/// How errors of a circle are measured.
pub fn methods() -> Vec<method::Method> {
    vec![method::CIRCLE, method::REGISTRATION]
}

/// Nominal circle and the runs around it.
fn path(robot: &Robot, nominal: &Nominal, runs: &[Named]) -> PathView {
    let mm = |p: &nalgebra::Vector3<f64>| -> [f64; 3] { (p * 1e3).into() };
    let ideal = |m: &Measured| m.trace.ideal_m.iter().map(mm).collect::<Vec<_>>();
    let marks = nominal.reversals.iter().filter_map(|r| {
        let points = &runs.first()?.measured.trace.ideal_m;
        let away = |p: &nalgebra::Vector3<f64>| {
            let d = (nominal.angle_deg(p) - r.at_deg).rem_euclid(360.0);
            d.min(360.0 - d)
        };
        let at = points.iter().min_by(|a, b| away(a).total_cmp(&away(b)))?;
        Some(PathMark { joint: robot.axis(r.axis).name.clone(), at_mm: mm(at), sense: r.direction })
    });
    PathView {
        exaggeration: EXAGGERATION,
        nominal_mm: runs.first().map(|r| ideal(r.measured)).unwrap_or_default(),
        runs: runs
            .iter()
            .map(|r| PathRun {
                run: Run::new(r.name, r.role),
                reference_mm: ideal(r.measured),
                error_um: r.measured.trace.error_m.iter().map(|e| (e * 1e6).into()).collect(),
            })
            .collect(),
        marks: marks.collect(),
        is_arm: false,
    }
}

/// Page of `assess circle`.
pub fn of_assessment(robot: &Robot, result: &Assessment) -> Page {
    let mut page =
        super::start("assess circle", &format!("Circle of {:.0} mm", result.nominal.circle.radius_m * 1e3), robot);
    let mut runs = vec![Named { name: "before", role: Role::Before, measured: &result.before, chords: true }];
    runs.extend(result.after.as_ref().map(|a| Named { name: "after", role: Role::After, measured: a, chords: true }));
    for r in &runs {
        page.file(format!("log {}", r.name), r.measured.name.clone(), r.measured.sha256.clone());
    }
    head(&mut page, &runs);
    around(&mut page, robot, &result.nominal, &runs);
    table(&mut page, robot, &result.nominal, &runs);
    figures(&mut page, robot, &result.nominal, &runs);
    if !result.notes.is_empty() {
        page.section("", "", result.notes.iter().map(Note::to_string).collect::<Vec<_>>());
    }
    page.section("", "", methods());
    page
}
