//! Page of `diagnose`: the verdict and what to do, the gap before and after, what was tried, what could not be seen.

use super::milli;
use crate::diagnose::display;
use crate::diagnose::document::{Diagnosis, Round};
use crate::diagnose::structure::Aspect;
use crate::diagnose::traces::{self, Hidden, LogTrace, Traces, Way};
use crate::diagnose::words::{self, GapUnit};
use crate::diagnose::{Outcome, Verdict};
use crate::report::number::{p_value, significant};
use crate::report::{
    BarRow, BarsView, HeatPath, HeatPathView, JointWays, Lane, MapBlock, MapCell, MapView, Method, Page, PathMark,
    Role, Run, StripLog, StripsView, TableView, Tile, Tone, TraceMark, WaterfallView, WayView, WaysPanel, WaysView,
    number,
};
use crate::robot::Robot;

/// In what the page tells a gap: micrometres, or thousandths of a degree where only joints were measured.
struct Told {
    unit: &'static str,
    /// From SI.
    si: f64,
    /// From the `_um` figures of the document.
    um: f64,
}

impl Told {
    fn of(d: &Diagnosis) -> Self {
        if d.unit == GapUnit::MICROMETRE {
            Self { unit: "µm", si: 1e6, um: 1.0 }
        } else {
            let mdeg = 180e3 / std::f64::consts::PI;
            Self { unit: "mdeg", si: mdeg, um: mdeg * 1e-6 }
        }
    }

    fn tile(&self, label: &str, um: f64) -> Tile {
        Tile::number(label, um * self.um, if self.um * um < 10.0 { 2 } else { 1 }, self.unit)
    }

    fn quantity(&self) -> &'static str {
        if self.unit == "µm" { "gap at the TCP" } else { "gap of the joints" }
    }
}

/// Colours reach to this many standard deviations of the noise at least, so that noise is dark.
const QUIET: f64 = 6.0;

/// The page.
pub fn of(model: &str, outcome: &Outcome, d: &Diagnosis) -> Page {
    let robot = &outcome.problem.robot;
    let told = Told::of(d);
    let t = traces::of(outcome);
    let mut page = super::start("diagnose", "What the model lacks", robot);
    head(&mut page, model, outcome, d, &told);
    if d.unexplained.is_some() {
        structure(&mut page, outcome, d, &told);
    }
    if !d.rounds.is_empty() {
        waterfall(&mut page, outcome, d, &told);
    }
    strips(&mut page, robot, outcome, d, &t, &told);
    path(&mut page, d, &t, &told);
    ways(&mut page, robot, &t);
    found(&mut page, d, &told);
    candidates(&mut page, outcome, d);
    blind(&mut page, robot, &t, &told);
    if d.unexplained.is_none() {
        structure(&mut page, outcome, d, &told);
    }
    noise(&mut page, outcome, d, &told);
    let aside: Vec<String> =
        d.put_aside.iter().map(|p| format!("{} {}: now {}", p.effect, p.target, p.replaced_by)).collect();
    if !aside.is_empty() {
        page.section("Put aside on the way", "Named in one round, replaced in a later one.", aside);
    }
    page.section("", "", methods());
    page
}

fn head(page: &mut Page, model: &str, outcome: &Outcome, d: &Diagnosis, told: &Told) {
    let tone = match d.verdict {
        Verdict::None => Tone::Good,
        Verdict::Named => Tone::Plain,
        Verdict::NamedSet | Verdict::NotObservable => Tone::Mixed,
        Verdict::Unknown | Verdict::BadData => Tone::Bad,
    };
    page.verdict(tone, display::sentence(d).replace(" um ", " µm "));
    page.next = words::next_steps(d);
    if d.verdict == Verdict::None {
        page.next.push((
            String::new(),
            "Nothing has to be done. What this log could not have shown stands in the map of blind spots.".into(),
        ));
    }
    page.warnings.extend(d.notes.iter().cloned());
    page.file("model", model, "");
    for l in &outcome.problem.logs {
        page.file("log", l.log.name.clone(), l.log.sha256.clone());
    }
    page.tile(told.tile("gap as given, rms", d.gap.initial_rms_um).with_detail(format!(
        "at most {} {}",
        number(d.gap.initial_max_um * told.um, 1),
        told.unit
    )));
    page.tile(told.tile("gap that is left, rms", d.gap.final_rms_um).with_detail(format!(
        "at most {} {}",
        number(d.gap.final_max_um * told.um, 1),
        told.unit
    )));
    page.tile(told.tile("noise", d.noise.sigma_um).with_detail("per coordinate, one standard deviation"));
    for (i, r) in d.rounds.iter().enumerate() {
        let alike = |o: &Round| o.effect == r.effect && o.target == r.target;
        if d.rounds[..i].iter().any(alike) {
            continue;
        }
        let more = match d.rounds[i + 1..].iter().filter(|o| alike(o)).count() {
            0 => String::new(),
            k => format!("; {k} more"),
        };
        if let Some((name, value, [lo, hi], unit)) = words::sizes(r).into_iter().next() {
            page.tile(
                Tile::text(format!("{} {}, {name}", r.effect, r.target), value, unit)
                    .with_detail(format!("95 %: {lo} to {hi}{more}")),
            );
        }
    }
}

/// From the gap as given to the noise, and the same on parts that were not fitted.
fn waterfall(page: &mut Page, outcome: &Outcome, d: &Diagnosis, told: &Told) {
    let mut steps = Vec::new();
    let start = match (outcome.problem.frames_free, d.outliers) {
        (true, _) => Some("frame fitted"),
        (false, 1..) => Some("outliers left out"),
        (false, 0) => None,
    };
    steps.extend(start.map(|name| (name.to_string(), d.gap.nuisance_only_rms_um * told.um)));
    steps.extend(d.rounds.iter().map(|r| (format!("+ {} {}", r.effect, r.target), r.rms_after_um * told.um)));
    page.section(
        format!(
            "The gap falls from {:.1} to {:.1} {}",
            d.gap.initial_rms_um * told.um,
            d.gap.final_rms_um * told.um,
            told.unit
        ),
        "Root mean square per coordinate. Each step refits everything that came before it; the line is the noise.",
        WaterfallView {
            quantity: "gap, rms".into(),
            unit: told.unit.into(),
            start: ("as given".into(), d.gap.initial_rms_um * told.um),
            steps,
            floor: Some(("noise".into(), d.noise.sigma_um * told.um)),
        },
    );
    let Some(first) = d.rounds.first() else { return };
    let row = |label: String, fitted: f64, held: f64| BarRow {
        label,
        values: [fitted, held].map(|v| Some(v * told.um)).to_vec(),
    };
    let mut rows = vec![row(start.unwrap_or("as given").into(), first.rms_before_um, first.validation.rms_before_um)];
    rows.extend(
        d.rounds.iter().map(|r| row(format!("+ {} {}", r.effect, r.target), r.rms_after_um, r.validation.rms_after_um)),
    );
    page.section(
        "The same on parts that were not fitted",
        "Held out: each fifth of the log, in four stretches, is predicted with parameters of the other four fifths.",
        BarsView {
            quantity: "gap, rms".into(),
            unit: told.unit.into(),
            runs: vec![Run::new("fitted", Role::After), Run::new("held out", Role::Between)],
            rows,
        },
    );
}

fn strips(page: &mut Page, robot: &Robot, outcome: &Outcome, d: &Diagnosis, t: &Traces, told: &Told) {
    let axis_of = |r: &Round| r.place.joint.clone().filter(|j| robot.axis_named(j).is_some());
    let scaled = |v: &[f64]| v.iter().map(|v| v * told.si).collect::<Vec<f64>>();
    let lanes = |l: &LogTrace| {
        if d.rounds.is_empty() {
            return vec![Lane { name: "gap".into(), values: scaled(&l.after), marks: Vec::new() }];
        }
        let mut lanes = vec![Lane { name: "before".into(), values: scaled(&l.before), marks: Vec::new() }];
        lanes.extend(l.effects.iter().zip(&d.rounds).map(|(e, r)| Lane {
            name: format!("{} {}", r.effect, r.target),
            values: scaled(&e.moves),
            marks: axis_of(r).map_or(Vec::new(), |joint| {
                e.turns.iter().map(|&(x, sense)| TraceMark { joint: joint.clone(), x, sense }).collect()
            }),
        }));
        lanes.push(Lane { name: "after".into(), values: scaled(&l.after), marks: Vec::new() });
        lanes
    };
    let logs = t.logs.iter().filter(|l| !l.at.is_empty()).map(|l| StripLog {
        name: if t.logs.len() > 1 { l.name.clone() } else { String::new() },
        x_title: if l.poses { "pose".into() } else { "time, s".into() },
        x: l.at.clone(),
        lanes: lanes(l),
    });
    let noise = outcome.whitening.noise.first().map_or(0.0, |n| n.sigma);
    page.section(
        "The gap along the path",
        if d.rounds.is_empty() {
            "Distance from the predicted to the measured position, as a colour.".to_string()
        } else {
            "Distance from the predicted to the measured position, as a colour: before with the frame alone, after with all that \
             was found; between them what each found effect moves, with its joint's reversals where it acts behind them."
                .to_string()
        },
        StripsView {
            quantity: told.quantity().into(),
            unit: told.unit.into(),
            at_least: QUIET * noise * told.si,
            logs: logs.collect(),
        },
    );
}

fn path(page: &mut Page, d: &Diagnosis, t: &Traces, told: &Told) {
    if !t.points {
        return;
    }
    let noise_um = d.noise.sigma_um;
    let mut panels = Vec::new();
    for l in t.logs.iter().filter(|l| !l.points_m.is_empty()) {
        let at_mm: Vec<[f64; 3]> = l.points_m.iter().map(|p| (p * 1e3).into()).collect();
        let of = if t.logs.len() > 1 { format!(", {}", l.name) } else { String::new() };
        let marks = l.effects.iter().zip(&d.rounds).flat_map(|(e, r)| {
            let joint = r.place.joint.clone();
            e.turns.iter().filter_map(move |&(at, sense)| Some((joint.clone()?, at, sense)))
        });
        let marks: Vec<PathMark> = marks
            .filter_map(|(joint, at, sense)| {
                let k = l.at.partition_point(|x| *x < at).min(l.at.len().saturating_sub(1));
                Some(PathMark { joint, at_mm: *at_mm.get(k)?, sense })
            })
            .collect();
        let panel = |title: String, values: &[f64], marks: Vec<PathMark>| HeatPath {
            title,
            at_mm: at_mm.clone(),
            values: values.iter().map(|v| v * told.si).collect(),
            dots: l.poses,
            marks,
        };
        if !d.rounds.is_empty() {
            panels.push(panel(format!("before{of}"), &l.before, marks));
            panels.push(panel(format!("after{of}"), &l.after, Vec::new()));
        } else {
            panels.push(panel(format!("gap{of}"), &l.after, marks));
        }
    }
    let words = match (panels.iter().any(|p| !p.marks.is_empty()), panels.len()) {
        (true, _) => " All drawings have one scale. Marks: reversals behind which a found effect acts.",
        (false, 2..) => " All drawings have one scale.",
        _ => "",
    };
    page.section(
        "Where on the path the gap stands",
        format!(
            "Path of the TCP in the base frame, seen isometrically, coloured by the distance from the predicted to the measured \
             point.{words}"
        ),
        HeatPathView { quantity: "gap at the TCP".into(), unit: "µm".into(), at_least: QUIET * noise_um, panels },
    );
}

fn ways(page: &mut Page, robot: &Robot, t: &Traces) {
    let joints: Vec<JointWays> = t
        .joints
        .iter()
        .map(|j| {
            let kind = robot.axis(j.axis).kind;
            let view = |w: &Way, quartiles: &[[f64; 3]]| WayView {
                at_deg_mm: w.position.iter().map(|p| kind.to_edge(*p)).collect(),
                quartiles_milli: quartiles.iter().map(|q| q.map(|v| milli(robot, j.axis, v))).collect(),
            };
            let [up, down] = &j.ways;
            let panel = |title: &str, of: fn(&Way) -> &Vec<[f64; 3]>| WaysPanel {
                title: title.into(),
                up: view(up, of(up)),
                down: view(down, of(down)),
            };
            let panels = if j.own {
                vec![panel("without what was found on it", |w| &w.before), panel("after", |w| &w.after)]
            } else {
                vec![panel("after; nothing was found on it", |w| &w.after)]
            };
            JointWays { joint: robot.axis(j.axis).name.clone(), panels }
        })
        .collect();
    if joints.is_empty() {
        return;
    }
    let how = if t.joints.iter().all(|j| j.measured) {
        "Measured minus predicted joint position over the command."
    } else {
        "The part of the TCP's gap that lies along the joint's lever, as an angle: e·J / |J|², over the command of the joint. \
         Three coordinates cannot give all joints, so what is left of the others shows there, too."
    };
    let caption = format!(
        "{how} Effects found elsewhere are taken off in all drawings. Medians over bins of position. Alike in both directions: \
         geometry, compliance, gear; apart: lost motion or lag."
    );
    page.section("Each joint by itself, both ways", caption, WaysView { joints });
}

/// Sizes, intervals, sets and evidence of what was found.
fn found(page: &mut Page, d: &Diagnosis, told: &Told) {
    if d.rounds.is_empty() {
        return;
    }
    let left = format!("left: predicted, achieved, {}", told.unit);
    let headings = [
        ("round", false),
        ("effect", false),
        ("target", false),
        ("size, 95 % interval", false),
        ("set", false),
        (&left, true),
        ("F", true),
        ("p value", true),
        ("ΔBIC", true),
    ];
    let rows = d.rounds.iter().enumerate().map(|(i, r)| {
        let sizes: Vec<String> = words::sizes(r)
            .into_iter()
            .map(|(name, value, [lo, hi], unit)| {
                format!("{name} {value} {unit} ({lo} to {hi})").replace(" um ", " µm ")
            })
            .collect();
        let set: Vec<String> =
            r.set.iter().map(|m| format!("{} {} {:.0} %", m.effect, m.target, 100.0 * m.probability)).collect();
        vec![
            (i + 1).to_string(),
            r.effect.clone(),
            r.target.clone(),
            sizes.join("; "),
            if r.set.len() > 1 { set.join("; ") } else { "alone".into() },
            [r.rms_after_predicted_um, r.rms_after_um].map(|v| number(v * told.um, 1)).join(", "),
            significant(r.evidence.value),
            p_value(r.evidence.p_value),
            number(r.evidence.delta_bic, 0),
        ]
    });
    page.section(
        "What was found",
        "Parameters of the joint fit of everything, with intervals that account for correlated noise. Set: the smallest that holds \
         the truth with 95 %, and whatever fits within 4 of 2 ln L.",
        TableView { columns: columns(&headings), rows: rows.collect() },
    );
}

fn columns(headings: &[(&str, bool)]) -> Vec<(String, bool)> {
    headings.iter().map(|(h, n)| (h.to_string(), *n)).collect()
}

/// What was tried in the place of each found effect.
fn candidates(page: &mut Page, outcome: &Outcome, d: &Diagnosis) {
    if d.rounds.is_empty() {
        return;
    }
    let price = (outcome.problem.n as f64).ln();
    let mut rows = Vec::new();
    for (i, r) in d.rounds.iter().enumerate() {
        let named = r.candidates.iter().find(|c| c.effect == r.effect && c.target == r.target).map(|c| c.gain_2lnl);
        for c in &r.candidates {
            let member = r.set.iter().find(|m| m.effect == c.effect && m.target == c.target);
            let word = match member {
                Some(_) if c.effect == r.effect && c.target == r.target => "named".to_string(),
                Some(m) => format!("in the set, {:.0} %", 100.0 * m.probability),
                None => String::new(),
            };
            rows.push(vec![
                (i + 1).to_string(),
                c.effect.clone(),
                c.target.clone(),
                number(c.gain_2lnl, 1),
                named.map_or("–".into(), |n| number(c.gain_2lnl - n, 1)),
                c.parameters.to_string(),
                number(c.parameters as f64 * price - c.gain_2lnl, 1),
                word,
            ]);
        }
    }
    let headings = [
        ("round", false),
        ("effect", false),
        ("target", false),
        ("gain in 2 ln L", true),
        ("against the named", true),
        ("parameters", true),
        ("ΔBIC", true),
        ("", false),
    ];
    page.section(
        "What was tried in its place",
        "Each found effect was taken out and the best of the catalogue refitted in its place, with everything else free. ΔBIC: \
         parameters times ln n, less the gain; the lower the better.",
        TableView { columns: columns(&headings), rows },
    );
}

/// Columns of the map for joints: effect, heading, and whether its targets are `joint.parameter`.
const ON_JOINTS: [(&str, &str); 11] = [
    ("backlash", "backlash"),
    ("stiction", "stiction"),
    ("hysteresis", "hysteresis"),
    ("servo_lag", "servo lag"),
    ("encoder_scale", "encoder scale"),
    ("joint_zero_offset", "zero offset"),
    ("gravity_compliance", "gravity compliance"),
    ("transmission_error", "transmission error"),
    ("link_error.a", "link a"),
    ("link_error.d", "link d"),
    ("link_error.alpha", "link alpha"),
];

fn blind(page: &mut Page, robot: &Robot, t: &Traces, told: &Told) {
    if t.hidden.is_empty() {
        return;
    }
    let find = |effect: &str, target: &str| -> Option<&Hidden> {
        let both = || t.hidden.iter().filter(|h| h.effect == effect && h.target == target);
        both().find(|h| h.found).or_else(|| both().next())
    };
    let joints: Vec<&str> = robot.joints.iter().map(|j| j.name.as_str()).collect();
    let on_joint = |effect: &str, joint: &str| match effect.split_once('.') {
        Some((effect, parameter)) => find(effect, &format!("{joint}.{parameter}")),
        None => find(effect, joint),
    };
    let mut blocks = Vec::new();
    let kept: Vec<&(&str, &str)> =
        ON_JOINTS.iter().filter(|(e, _)| joints.iter().any(|j| on_joint(e, j).is_some())).collect();
    blocks.push(MapBlock {
        corner: "joint".into(),
        columns: kept
            .iter()
            .map(|(e, heading)| (heading.to_string(), unit_of(joints.iter().filter_map(|j| on_joint(e, j)))))
            .collect(),
        rows: joints
            .iter()
            .map(|j| {
                (
                    j.to_string(),
                    kept.iter().map(|(e, _)| on_joint(e, j).map_or(MapCell::Absent, |h| cell(h, told))).collect(),
                )
            })
            .collect(),
    });
    // a coupling shows only where both joints move
    let rests = |joint: &str| find("encoder_scale", joint).is_some_and(|h| !h.found && h.moves.is_none());
    let coupled = |to: &str, from: &str| find("axis_coupling", &format!("{to}<-{from}"));
    if joints.iter().any(|to| joints.iter().any(|from| coupled(to, from).is_some())) {
        let all = || joints.iter().flat_map(|to| joints.iter().filter_map(|from| coupled(to, from)));
        let unit = unit_of(all());
        blocks.push(MapBlock {
            corner: "coupling of".into(),
            columns: joints.iter().map(|from| (format!("to {from}"), unit.clone())).collect(),
            rows: joints
                .iter()
                .map(|to| {
                    let cells = joints.iter().map(|from| match coupled(to, from) {
                        Some(h) => cell(h, told),
                        None if to != from && (rests(to) || rests(from)) => MapCell::Hatched,
                        None => MapCell::Absent,
                    });
                    (to.to_string(), cells.collect())
                })
                .collect(),
        });
    }
    let whole: Vec<&Hidden> = t.hidden.iter().filter(|h| matches!(h.target.as_str(), "tool" | "tcp" | "log")).collect();
    if !whole.is_empty() {
        blocks.push(MapBlock {
            corner: "whole machine".into(),
            columns: whole.iter().map(|h| (h.effect.replace('_', " "), unit_of(std::iter::once(*h)))).collect(),
            rows: vec![(String::new(), whole.iter().map(|h| cell(h, told)).collect())],
        });
    }
    let none = t.hidden.iter().filter(|h| !h.found && h.moves.is_none()).count();
    let title = match none {
        0 => "What this log could not have shown".to_string(),
        1 => "One effect could hide in this log whatever its size".to_string(),
        n => format!("{n} effects could hide in this log whatever their size"),
    };
    page.section(
        title,
        format!(
            "The smallest size that would have been detected (chance 0.001, power 0.8), in the unit of its column; coloured by the \
             {} that such a size moves, rms. The brighter, the more may be wrong without a trace in this log.",
            told.unit
        ),
        MapView {
            quantity: "what may hide, rms".into(),
            unit: told.unit.into(),
            hatched: "not visible at any size".into(),
            by_decades: true,
            blocks,
        },
    );
}

/// Unit in which a size is shown, and the factor from its key's.
fn shown(key: &str) -> (f64, &'static str) {
    match words::key(key, "deg").1 {
        "deg" => (1e3, "mdeg"),
        "mm" => (1e3, "µm"),
        "s" => (1e3, "ms"),
        "deg/Nm" => (1e6, "µdeg/Nm"),
        "mm/N" => (1e6, "nm/N"),
        "" => (1e6, "10⁻⁶"),
        "um" => (1.0, "µm"),
        other => (1.0, other),
    }
}

fn unit_of<'a>(all: impl Iterator<Item = &'a Hidden>) -> String {
    let mut units: Vec<&str> = all.filter_map(|h| h.sizes.first()).map(|(k, _)| shown(k).1).collect();
    units.dedup();
    units.join(" or ")
}

fn cell(h: &Hidden, told: &Told) -> MapCell {
    match (h.sizes.first(), h.moves) {
        _ if h.found => MapCell::Word("found".into()),
        (Some((key, v)), Some(moves)) => {
            let tool = matches!(h.effect, "tool_error" | "thermal_drift");
            // of a vector the coordinate that is seen worst
            let size = if tool {
                h.sizes.iter().filter(|s| s.0.ends_with("_mm")).map(|s| s.1).fold(0.0, f64::max)
            } else {
                *v
            };
            MapCell::Size { text: words::rough(size * shown(key).0), colour: moves * told.si }
        }
        _ => MapCell::Hatched,
    }
}

const ASPECTS: [(Aspect, &str); 5] = [
    (Aspect::Position, "position"),
    (Aspect::Direction, "direction"),
    (Aspect::Speed, "speed"),
    (Aspect::Acceleration, "acceleration"),
    (Aspect::SinceReversal, "since its reversals"),
];

/// What is left, by joint and aspect: the test without the catalogue.
fn structure(page: &mut Page, outcome: &Outcome, d: &Diagnosis, told: &Told) {
    let bundles = &outcome.structure.bundles;
    if bundles.is_empty() {
        return;
    }
    let noise = d.gap.final_rms_um * told.um;
    let n = outcome.problem.n as f64;
    let chance = 1e-3 / bundles.len() as f64;
    let cell =
        |axis: Option<usize>, aspect: Aspect| match bundles.iter().find(|b| b.axis == axis && b.aspect == Some(aspect))
        {
            None => MapCell::Absent,
            Some(b) if b.p_value > chance => MapCell::Word("–".into()),
            Some(b) => {
                let size = noise * ((b.gain - b.dof as f64).max(0.0) / n).sqrt();
                MapCell::Size { text: words::rough(size), colour: size }
            }
        };
    let robot = &outcome.problem.robot;
    let rows = (0..robot.dof())
        .filter(|&a| bundles.iter().any(|b| b.axis == Some(a)))
        .map(|a| (robot.axis(a).name.clone(), ASPECTS.iter().map(|(aspect, _)| cell(Some(a), *aspect)).collect()));
    let named =
        |list: &[(Aspect, &str)]| list.iter().map(|(_, name)| (name.to_string(), told.unit.to_string())).collect();
    let whole = [(Aspect::Time, "time"), (Aspect::Geometry, "pose")];
    let mut blocks = vec![MapBlock { corner: "joint".into(), columns: named(&ASPECTS), rows: rows.collect() }];
    if bundles.iter().any(|b| b.axis.is_none()) {
        blocks.push(MapBlock {
            corner: "whole machine".into(),
            columns: named(&whole),
            rows: vec![(String::new(), whole.iter().map(|(aspect, _)| cell(None, *aspect)).collect())],
        });
    }
    let (title, nearest) = match &d.unexplained {
        Some(u) => {
            let nearest = u.nearest.as_ref().map_or(String::new(), |c| {
                format!(
                    " The nearest effect of the catalogue is {} {}, with a gain of {:.0} in 2 ln L.",
                    c.effect, c.target, c.gain_2lnl
                )
            });
            (format!("What is left goes with {}", u.goes_with), nearest)
        }
        None => ("A test without the catalogue".to_string(), String::new()),
    };
    page.section(
        title,
        format!(
            "Splines and powers per joint, over time and over the pose, tested on the residual against correlated noise; the size of \
             the structure in {}, rms. A dash: no more than chance. One structure may show in several cells.{nearest}",
            told.unit
        ),
        MapView { quantity: "structure, rms".into(), unit: told.unit.into(), hatched: String::new(), by_decades: false, blocks },
    );
}

fn noise(page: &mut Page, outcome: &Outcome, d: &Diagnosis, told: &Told) {
    use crate::diagnose::layout::Sensor;
    let robot = &outcome.problem.robot;
    let rows = outcome.problem.groups.iter().zip(&outcome.whitening.noise).map(|(g, noise)| {
        let (sensor, axis) = match g.sensor {
            Sensor::Reflector(0) => ("TCP".to_string(), None),
            Sensor::Reflector(k) => (format!("reflector {}", k + 1), None),
            Sensor::Motor(a) => (format!("motor of {}", robot.axis(a).name), Some(a)),
            Sensor::Joint(a) => (format!("joint {}", robot.axis(a).name), Some(a)),
        };
        let (sigma, unit) = match axis {
            None => (noise.sigma * 1e6, "µm"),
            Some(a) => (milli(robot, a, noise.sigma), if robot.axis(a).kind.unit() == "deg" { "mdeg" } else { "µm" }),
        };
        vec![
            outcome.problem.logs[g.log].log.name.clone(),
            sensor,
            crate::report::number::count(g.rows.len() as u64),
            format!("{} {unit}", significant(sigma)),
            number(noise.lag_one(), 2),
            number(noise.phi, 2),
            crate::report::number::percent(noise.share),
        ]
    });
    let headings = [
        ("log", false),
        ("sensor", false),
        ("samples", true),
        ("noise", true),
        ("from sample to sample", true),
        ("coloured part", true),
        ("share", true),
    ];
    let left = if d.outliers == 0 {
        "No sample was left out.".to_string()
    } else {
        format!("{} samples were left out, since they disagree with their neighbours.", d.outliers)
    };
    let blocks = outcome.problem.logs.iter().map(|l| l.block).max().unwrap_or(1);
    let means = if blocks > 1 {
        format!(" Up to {blocks} rows are averaged into one value; the noise is that of the averages.")
    } else {
        String::new()
    };
    page.section(
        format!("Noise of {} {}", significant(d.noise.sigma_um * told.um), told.unit),
        format!(
            "White noise and a first-order autoregressive part, of the largest likelihood ({}). Autocorrelation of the whole from one \
             sample to the next, that of the coloured part, and its share of the variance. {left}{means}",
            d.noise.source
        ),
        TableView { columns: columns(&headings), rows: rows.collect() },
    );
}

fn methods() -> Vec<Method> {
    vec![
        Method::new(
            "Detection, identification, adaptation",
            "Every effect of the catalogue on every joint is a hypothesis about the residual; the best goes into the model, all is fitted again, until a test without the catalogue finds nothing.",
            "W. Baarda, A testing procedure for use in geodetic networks, 1968; P. Teunissen, Distributional theory for the DIA method, Journal of Geodesy 92, 2018",
        ),
        Method::new(
            "Correlated noise",
            "White noise plus a first-order autoregressive part; a Kalman filter turns it white for any pattern of lost samples. Without it every test alarms on noise alone.",
            "A. C. Harvey, Forecasting, Structural Time Series Models and the Kalman Filter, 1989, section 3.4",
        ),
        Method::new(
            "Smallest detectable size",
            "An effect of this size is found with a probability of 0.8 where one in a thousand is found that is not there: 4.13 standard uncertainties, with frame and found effects free.",
            "W. Baarda, 1968 (minimal detectable bias)",
        ),
        Method::new(
            "Weights of rivals",
            "Probability of each candidate in the place of a found effect by the Bayesian information criterion.",
            "G. Schwarz, Estimating the dimension of a model, Annals of Statistics 6, 1978",
        ),
    ]
}
