//! Page of `diagnose`: the verdict and what to do, what was found and tried.
//!
//! Modules: [`gap`] where the gap is, [`machine`] what each joint lacks where everything was fitted together, [`hidden`] what could not
//! be seen, [`left`] what is left; [`scale`] the unit of all of them.

mod gap;
mod hidden;
mod left;
mod machine;
mod scale;

use crate::diagnose::result::display;
use crate::diagnose::result::document::{Diagnosis, Round};
use crate::diagnose::result::traces;
use crate::diagnose::result::words::{self, Size};
use crate::diagnose::{Outcome, Verdict};
use crate::report::number::{p_value, significant};
use crate::report::{BarRow, BarsView, Method, Page, Role, Run, TableView, Tile, Tone, WaterfallView, number};
use scale::GapScale;

/// A size below a tenth of a degree in thousandths, the unit of the charts.
fn in_milli(size: Size) -> Size {
    const SMALL_DEG: f64 = 0.1;
    // as written, with three decimals less
    let milli = |text: &str| -> Option<String> {
        let deg = text.parse::<f64>().ok().filter(|v| v.abs() < SMALL_DEG)?;
        let decimals = text.split_once('.').map_or(0, |(_, d)| d.len()).saturating_sub(3);
        Some(number(1e3 * deg, decimals))
    };
    let all = |text: &str| text.split(" to ").map(milli).collect::<Option<Vec<_>>>().map(|v| v.join(" to "));
    let ci95 = match &size.ci95 {
        Some([lo, hi]) => all(lo).zip(all(hi)).map(|(lo, hi)| Some([lo, hi])),
        None => Some(None),
    };
    match (size.unit, all(&size.value), ci95) {
        ("deg", Some(value), Some(ci95)) => Size { value, ci95, unit: "mdeg", ..size },
        ("um", ..) => Size { unit: "µm", ..size },
        _ => size,
    }
}

/// The page.
pub fn of(model: &str, outcome: &Outcome, d: &Diagnosis) -> Page {
    let robot = &outcome.problem.robot;
    let scale = GapScale::of(d);
    let t = traces::of(outcome);
    let mut page = super::start("diagnose", "What the model lacks", robot);
    head(&mut page, model, outcome, d, &scale);
    if d.unexplained.is_some() {
        left::structure(&mut page, outcome, d, &scale);
    }
    if !d.rounds.is_empty() {
        waterfall(&mut page, outcome, d, &scale);
    }
    machine::causes(&mut page, robot, d);
    gap::strips(&mut page, robot, outcome, d, &t, &scale);
    gap::path(&mut page, d, &t, &scale);
    gap::ways(&mut page, robot, &t);
    found(&mut page, d, &scale);
    if d.geometry_tcp_um.is_none() {
        candidates(&mut page, outcome, d);
    }
    hidden::blind(&mut page, robot, &t, &scale);
    if d.unexplained.is_none() {
        left::structure(&mut page, outcome, d, &scale);
    }
    left::noise(&mut page, outcome, d, &scale);
    let aside: Vec<String> =
        d.put_aside.iter().map(|p| format!("{} {}: now {}", p.effect, p.target, p.replaced_by)).collect();
    if !aside.is_empty() {
        page.section("Replaced hypotheses", "Named in one round and replaced in a later one.", aside);
    }
    page.section("", "", methods());
    page
}

/// Effects that have a tile, where everything was fitted together: the largest.
const MOST_TILES: usize = 8;

fn head(page: &mut Page, model: &str, outcome: &Outcome, d: &Diagnosis, scale: &GapScale) {
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
            "No action is needed. The map of blind spots shows what this log cannot detect.".into(),
        ));
    }
    page.warnings.extend(d.notes.iter().map(ToString::to_string));
    page.file("model", model, "");
    for l in &outcome.problem.logs {
        page.file("log", l.log.name.clone(), l.log.sha256.clone());
    }
    page.tile(scale.tile("gap before the diagnosis, rms", d.gap.initial_rms_um).with_detail(format!(
        "at most {} {}",
        number(d.gap.initial_max_um * scale.um, 1),
        scale.unit
    )));
    page.tile(scale.tile("remaining gap, rms", d.gap.final_rms_um).with_detail(format!(
        "at most {} {}",
        number(d.gap.final_max_um * scale.um, 1),
        scale.unit
    )));
    page.tile(scale.tile("noise", d.noise.sigma_um).with_detail("per coordinate, one standard deviation"));
    for (i, r) in d.rounds.iter().enumerate() {
        if d.geometry_tcp_um.is_some() && (r.group.is_some() || i >= MOST_TILES) {
            continue;
        }
        let alike = |o: &Round| o.effect == r.effect && o.target == r.target;
        if d.rounds[..i].iter().any(alike) {
            continue;
        }
        let more = match d.rounds[i + 1..].iter().filter(|o| alike(o)).count() {
            0 => String::new(),
            k => format!("; {k} more"),
        };
        if let Some(s) = words::sizes(r).into_iter().next().map(in_milli) {
            let detail = format!("95 %: {}{more}", s.interval());
            page.tile(
                Tile::text(format!("{} {}, {}", r.effect, r.target, s.name), s.value, s.unit).with_detail(detail),
            );
        }
    }
}

/// From the gap as given to the noise, and the same on parts that were not fitted.
fn waterfall(page: &mut Page, outcome: &Outcome, d: &Diagnosis, scale: &GapScale) {
    let mut steps = Vec::new();
    let start = match (outcome.problem.frames_free, d.outliers) {
        (true, _) => Some("frame fitted"),
        (false, 1..) => Some("outliers left out"),
        (false, 0) => None,
    };
    steps.extend(start.map(|name| (name.to_string(), d.gap.nuisance_only_rms_um * scale.um)));
    steps.extend(machine::steps(d).map(|(name, r)| (format!("+ {name}"), r.rms_after_um * scale.um)));
    page.section(
        format!(
            "The gap falls from {:.1} to {:.1} {}",
            d.gap.initial_rms_um * scale.um,
            d.gap.final_rms_um * scale.um,
            scale.unit
        ),
        "Root mean square per coordinate. Each step refits everything before it; the line is the noise.",
        WaterfallView {
            quantity: "gap, rms".into(),
            unit: scale.unit.into(),
            start: ("as given".into(), d.gap.initial_rms_um * scale.um),
            steps,
            floor: Some(("noise".into(), d.noise.sigma_um * scale.um)),
        },
    );
    let Some(first) = d.rounds.first() else { return };
    let row = |label: String, fitted: f64, held: f64| BarRow {
        label,
        values: [fitted, held].map(|v| Some(v * scale.um)).to_vec(),
    };
    let mut rows = vec![row(start.unwrap_or("as given").into(), first.rms_before_um, first.validation.rms_before_um)];
    rows.extend(machine::steps(d).map(|(name, r)| row(format!("+ {name}"), r.rms_after_um, r.validation.rms_after_um)));
    page.section(
        "The same on parts that were not fitted",
        "Held out: each fifth of the log, in four stretches, is predicted with parameters of the other four fifths.",
        BarsView {
            quantity: "gap, rms".into(),
            unit: scale.unit.into(),
            runs: vec![Run::new("fitted", Role::After), Run::new("held out", Role::Between)],
            rows,
        },
    );
}

/// Sizes, intervals, sets and evidence of what was found.
fn found(page: &mut Page, d: &Diagnosis, scale: &GapScale) {
    if d.rounds.is_empty() {
        return;
    }
    let left = format!("left: predicted, achieved, {}", scale.unit);
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
            .map(|s| format!("{} {} {} ({})", s.name, s.value, s.unit, s.interval()).replace(" um ", " µm "))
            .collect();
        let set: Vec<String> =
            r.set.iter().map(|m| format!("{} {} {}", m.effect, m.target, words::probability(m.probability))).collect();
        vec![
            (i + 1).to_string(),
            r.effect.clone(),
            r.target.clone(),
            sizes.join("; "),
            if r.set.len() > 1 { set.join("; ") } else { "alone".into() },
            [r.rms_after_predicted_um, r.rms_after_um].map(|v| number(v * scale.um, 1)).join(", "),
            significant(r.evidence.value),
            p_value(r.evidence.p_value),
            number(r.evidence.delta_bic, 0),
        ]
    });
    page.section(
        "What was found",
        "Parameters of the joint fit of everything, with intervals that account for correlated noise. Set: the smallest set that contains the truth with a probability of 95 %, and all alternatives within 4 of 2 ln L.",
        TableView::new(&headings, rows),
    );
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
                Some(m) => format!("in the set, {}", words::probability(m.probability)),
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
        "Alternatives",
        "Each found effect was removed, and the best effects of the catalogue were refitted instead, with everything else free. ΔBIC: parameters times ln n, minus the gain; lower is better.",
        TableView::new(&headings, rows),
    );
}

fn methods() -> Vec<Method> {
    vec![
        Method::new(
            "Detection, identification, adaptation",
            "Every effect of the catalogue on every joint is a hypothesis about the residual; the best one is added to the model and everything is fitted again, until a test without the catalogue finds nothing.",
            "W. Baarda, A testing procedure for use in geodetic networks, 1968; P. Teunissen, Distributional theory for the DIA method, Journal of Geodesy 92, 2018",
        ),
        Method::new(
            "Correlated noise",
            "White noise plus a first-order autoregressive part; a Kalman filter whitens it for any pattern of lost samples. Without it, every test would raise alarms on noise alone.",
            "A. C. Harvey, Forecasting, Structural Time Series Models and the Kalman Filter, 1989, section 3.4",
        ),
        Method::new(
            "Smallest detectable size",
            "An effect of this size is found with a probability of 0.8, at a false alarm rate of one in a thousand: 4.13 standard uncertainties, with the frame and the found effects free.",
            "W. Baarda, 1968 (minimal detectable bias)",
        ),
        Method::new(
            "Weights of alternatives",
            "Probability of each candidate instead of a found effect, by the Bayesian information criterion.",
            "G. Schwarz, Estimating the dimension of a model, Annals of Statistics 6, 1978",
        ),
    ]
}
