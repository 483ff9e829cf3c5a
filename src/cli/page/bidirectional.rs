//! Page of `assess bidirectional`.

use crate::assess::bidirectional::digits::digits;
use crate::assess::bidirectional::equation::{self, um_per_mm};
use crate::assess::bidirectional::poses::Way;
use crate::assess::bidirectional::{Assessment, Model, Note};
use crate::error::counted;
use crate::report::number::{interval, number, p_value};
use crate::report::{
    BacklashCurve, BacklashCurvesView, BacklashPoint, BothWaysPanel, BothWaysView, Page, TableView, Tile, Tone,
    WayPoint, method,
};
use crate::robot::Robot;

/// Points of a drawn curve.
const SAMPLES: usize = 80;
/// Readings that are drawn one by one, for each direction of a pose.
const DRAWN: usize = 60;

/// The page.
pub fn of_assessment(result: &Assessment, robot: Option<&Robot>) -> Page {
    let title = "Positions reached from both sides";
    let mut page = match robot {
        Some(robot) => super::start("assess bidirectional", title, robot),
        None => Page::new("assess bidirectional", title),
    };
    let mut places: Vec<f64> = result.poses.iter().map(|p| p.position_m).collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    let states = match result.order.len() {
        1 => String::new(),
        n => format!(" in {n} states"),
    };
    page.summary = format!("{} at {}{states}.", counted(result.used, "reading"), counted(places.len(), "position"));
    page.file("readings", result.file.clone(), result.sha256.clone());
    verdict(&mut page, result);
    for l in &result.lines {
        let state = result.states.text(l.state);
        let name = |what: &str| if state.is_empty() { what.to_string() } else { format!("{what}, {state}") };
        let ci = l.ci95_m.map_or(String::new(), |c| format!("95 %: {}", interval(c.map(|v| v * 1e6), 1)));
        page.tile(Tile::number(name("mean backlash"), l.mean_m * 1e6, 1, "µm").with_detail(ci));
        if let Some(r) = l.bidirectional_m {
            let iso =
                l.bidirectional_iso230_m.map_or(String::new(), |v| format!("ISO 230-2: {} µm", number(v * 1e6, 1)));
            page.tile(Tile::number(name("largest R"), r * 1e6, 1, "µm").with_detail(iso));
        }
    }
    page.warnings = result.notes.iter().map(Note::to_string).collect();
    page.section(
        "Reading of each direction at each pose",
        "Mean of the repeats and 3 standard deviations on both sides.",
        both_ways(result),
    );
    let caption = match &result.model {
        Some(m) => format!("{} (µm over mm).{}", equation::of(m), letters(result, m)),
        None => "No curve: there is only one repeat.".into(),
    };
    page.section("Backlash over position, and its fit", caption, curves(result));
    page.section("", "", poses(result));
    if let Some(m) = &result.model {
        if !m.lack_of_fit.is_empty() {
            let text = "F against its critical value; the first degree without significant lack of fit is chosen.";
            page.section("Degree of the curve: lack of fit", text, lack_of_fit(m));
        }
        if !m.tests.is_empty() {
            let text = "First the offset; if it is significant, the slope; and so on.";
            page.section("Influence of the states: Student's t tests", text, student(result, m));
        }
    }
    page.section("", "", vec![method::BIDIRECTIONAL, method::LACK_OF_FIT, method::INDICATOR]);
    page
}

fn verdict(page: &mut Page, result: &Assessment) {
    let differ = result.lines.iter().filter(|l| l.p_value.is_some_and(|p| p < result.alpha)).count();
    let mut text = match (differ, result.lines.len()) {
        (0, _) => "Over the whole line the two directions do not differ significantly.".to_string(),
        (n, all) if n == all => "The two directions differ over the whole line.".to_string(),
        (n, all) => format!("The two directions differ over the whole line in {n} of {all} states."),
    };
    if let Some(m) = &result.model {
        text.push_str(&format!(" The backlash follows a polynomial of degree {}", m.degree));
        text.push_str(match m.adequate {
            Some(true) => ".",
            Some(false) => ", which leaves a significant lack of fit.",
            None => "; its lack of fit was not tested.",
        });
        let names: Vec<String> = m.states().map(|s| result.states.difference(s, m.reference)).collect();
        if !names.is_empty() {
            text.push_str(&format!(" It changes with {}.", names.join(" and with ")));
        } else if !m.tests.is_empty() {
            text.push_str(" No state changes it.");
        }
    }
    page.verdict(Tone::Plain, text);
}

fn letters(result: &Assessment, m: &Model) -> String {
    let n = m.blocks.len() - 1;
    m.blocks[1..]
        .iter()
        .enumerate()
        .filter_map(|(k, b)| {
            Some(format!(
                " {} = 1 where {}.",
                equation::indicator(k, n),
                result.states.difference(b.state?, m.reference)
            ))
        })
        .collect()
}

fn both_ways(result: &Assessment) -> BothWaysView {
    let point = |at: f64, w: &Way| WayPoint {
        at_mm: at * 1e3,
        mean_um: w.mean_m * 1e6,
        band_um: w.repeatability_m().unwrap_or(0.0) * 1e6,
        readings_um: w.errors_m.iter().take(DRAWN).map(|e| e * 1e6).collect(),
    };
    let panel = |&state: &usize| {
        let here = || result.poses.iter().filter(move |p| p.state == state);
        BothWaysPanel {
            title: result.states.text(state),
            forward: here().filter_map(|p| Some(point(p.position_m, p.forward.as_ref()?))).collect(),
            backward: here().filter_map(|p| Some(point(p.position_m, p.backward.as_ref()?))).collect(),
        }
    };
    BothWaysView { panels: result.order.iter().map(panel).collect() }
}

/// Backlash of every state and the curves of those that have one of their own.
pub fn curves(result: &Assessment) -> BacklashCurvesView {
    let curve = |&state: &usize| {
        let here = result.poses.iter().filter(|p| p.state == state);
        let points = here
            .filter_map(|p| {
                let b = p.backlash?;
                Some(BacklashPoint {
                    at_mm: p.position_m * 1e3,
                    backlash_um: b.mean_m * 1e6,
                    ci95_um: b.ci95_m.map(|c| c.map(|v| v * 1e6)),
                })
            })
            .collect();
        let mut one = BacklashCurve { name: result.states.text(state), points, ..BacklashCurve::default() };
        let own = |m: &&Model| m.reference == state || m.states().any(|s| s == state);
        if let Some(m) = result.model.as_ref().filter(own) {
            let [lo, hi] = m.range_m;
            for i in 0..=SAMPLES {
                let x = lo + (hi - lo) * i as f64 / SAMPLES as f64;
                let (y, band) = m.at(state, x);
                one.at_mm.push(x * 1e3);
                one.fit_um.push(y * 1e6);
                one.band_um.push(band.map(|v| v * 1e6));
            }
        }
        one
    };
    BacklashCurvesView { states: result.order.iter().map(curve).collect() }
}

fn poses(result: &Assessment) -> TableView {
    let um = |v: Option<f64>| v.map_or("–".into(), |v| number(v * 1e6, 1));
    let states = result.order.len() > 1;
    let mut names = vec![
        "Position, mm",
        "Backlash, µm",
        "95 %",
        "RP forward",
        "RP backward",
        "R (3 σ)",
        "R by ISO 230-2 (2 σ)",
        "Pairs",
    ];
    if states {
        names.insert(0, "State");
    }
    let rows = result.poses.iter().map(|p| {
        let mut row = vec![
            digits(p.position_m * 1e3, 7),
            um(p.backlash.map(|b| b.mean_m)),
            p.backlash.and_then(|b| b.ci95_m).map_or("–".into(), |c| interval(c.map(|v| v * 1e6), 1)),
            um(p.forward.as_ref().and_then(|w| w.repeatability_m())),
            um(p.backward.as_ref().and_then(|w| w.repeatability_m())),
            um(p.bidirectional_m(3.0)),
            um(p.bidirectional_m(2.0)),
            p.pairs_m.len().to_string(),
        ];
        if states {
            row.insert(0, result.states.text(p.state));
        }
        row
    });
    TableView::numbers_after(usize::from(states), &names, rows)
}

fn lack_of_fit(m: &Model) -> TableView {
    let um2 = |v: f64| number(v * 1e12, 1);
    let names =
        ["Degree", "Lack of fit, µm²", "Pure error, µm²", "Degrees of freedom", "F", "Critical F", "p", "Lack of fit"];
    let rows = m.lack_of_fit.iter().map(|t| {
        vec![
            t.degree.to_string(),
            um2(t.lack_m2),
            um2(t.pure_m2),
            format!("{}, {}", t.dof[0], t.dof[1]),
            number(t.f, 3),
            number(t.f_critical, 3),
            p_value(t.p_value),
            if t.adequate { "none" } else { "significant" }.into(),
        ]
    });
    TableView::numbers_after(0, &names, rows)
}

fn student(result: &Assessment, m: &Model) -> TableView {
    let names = ["State", "Term", "Coefficient", "t", "Critical t", "Degrees of freedom", "p", "Significant"];
    let rows = m.tests.iter().map(|t| {
        vec![
            result.states.difference(t.state, m.reference),
            ["offset", "slope"].get(t.order).map_or_else(|| format!("power {}", t.order), |s| s.to_string()),
            format!("{} {}", digits(um_per_mm(t.coefficient, t.order), 4), equation::unit(t.order).replace('u', "µ")),
            number(t.t, 3),
            number(t.t_critical, 3),
            t.dof.to_string(),
            p_value(t.p_value),
            if t.significant { "yes" } else { "no" }.into(),
        ]
    });
    TableView::numbers_after(2, &names, rows)
}
