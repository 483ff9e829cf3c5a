//! Page of `plan-experiment`: the motion that decides, what else was tried, and what each would show.

use crate::plan::display::sentence;
use crate::plan::document::{DetectableShown, Entry, Plan, QuestionKind, Verdict};
use crate::plan::motions::Motion;
use crate::plan::path::Envelope;
use crate::report::{JointTraces, Method, Page, Role, Run, TableView, Tile, Tone, TracePanel, TraceRun, TracesView};
use crate::robot::Robot;
use serde_json::Value;

/// Points of a joint's line.
const POINTS: usize = 1500;

pub fn of_plan(robot: &Robot, plan: &Plan, motion: Option<&Motion>, envelope: &Envelope) -> Page {
    let mut page = super::start("plan-experiment", "The experiment that decides", robot);
    let tone = match plan.verdict {
        Verdict::Separable | Verdict::Observable => Tone::Good,
        Verdict::Inseparable => Tone::Bad,
        _ => Tone::Mixed,
    };
    page.verdict(tone, sentence(plan));
    page.option("noise", format!("{} µm", number(plan.noise_um)));
    page.option("rows", format!("{} Hz", number(plan.rate_hz)));
    if let Some(best) = &plan.best {
        page.tile(Tile::text("motion", best.motion.clone(), "").with_detail(best.does.clone()));
        page.tile(Tile::number("of one run", best.duration_s, 0, "s").with_detail(runs(best)));
        if let Some(e) = &best.evidence {
            page.tile(Tile::text("expected 2 ln L", evidence(e.expected_2lnl), ""));
            page.tile(Tile::number("named alone", 100.0 * e.probability_named, 1, "% of logs"));
        }
    }
    let reason = plan.reason.iter().map(ToString::to_string);
    let notes: Vec<String> = reason.chain(plan.notes.iter().map(ToString::to_string)).collect();
    if !notes.is_empty() {
        page.section("To know", "", notes);
    }
    if let Some(motion) = motion {
        let caption =
            "The motion starts and ends at rest at the pose and stays within the ranges and speeds of the joints.";
        page.section("The motion", caption, traces(robot, motion, envelope));
    }
    sets(&mut page, plan);
    motions(&mut page, plan);
    if let Some(best) = plan.best.as_ref().filter(|b| !b.detectable.is_empty()) {
        page.section(
            "What the motion would show",
            "Typical size divided by the smallest size that is reliably detected; below 1, an effect of typical size is not detected.",
            detectable(best),
        );
    }
    if !plan.channels.is_empty() {
        let row = |c: &crate::plan::document::ChannelShown| {
            vec![c.channel.to_string(), c.log.to_string(), c.motion.clone(), evidence(c.expected_2lnl)]
        };
        let headings = ["channel", "columns of the log", "motion", "expected 2 ln L"];
        let view = TableView::numbers_after(3, &headings, plan.channels.iter().map(row));
        page.section("With a further channel", "", view);
    }
    let text = "Each motion is run on the model with one alternative as the truth; the other alternative is refitted, together with the frame and every effect that it may be confused with. The remaining misfit, in 2 ln L, is the evidence that a log of this motion would give.";
    page.section("", "", vec![Method::new("Expected evidence", text, "non-centrality of the likelihood ratio")]);
    page
}

/// Joints that move, over time.
fn traces(robot: &Robot, motion: &Motion, envelope: &Envelope) -> TracesView {
    let step = motion.rows.len().div_ceil(POINTS).max(1);
    let moves = |a: &usize| motion.rows.iter().any(|r| r.get(*a) != motion.rows[0].get(*a));
    let joints = (0..robot.dof()).filter(moves).map(|a| {
        let joint = robot.axis(a);
        let (model_x, model_milli) = motion
            .rows
            .iter()
            .enumerate()
            .step_by(step)
            .filter_map(|(i, q)| Some((i as f64 * envelope.step_s, joint.kind.to_user_unit(*q.get(a)?))))
            .unzip();
        let run = TraceRun { run: Run::new("command", Role::After), model_x, model_milli, ..TraceRun::default() };
        let panel = TracePanel { title: String::new(), runs: vec![run], marks: Vec::new() };
        JointTraces { joint: joint.name.clone(), panels: vec![panel] }
    });
    TracesView {
        x_name: "time".into(),
        x_unit: "s".into(),
        y_name: "position".into(),
        y_whole: true,
        joints: joints.collect(),
    }
}

fn sets(page: &mut Page, plan: &Plan) {
    let rows: Vec<Vec<String>> = plan
        .sets
        .iter()
        .enumerate()
        .flat_map(|(k, s)| s.alternatives.iter().map(move |r| (k, r)))
        .map(|(k, r)| {
            let effects: Vec<String> = r.effects.iter().map(parameters).collect();
            vec![(k + 1).to_string(), r.name.clone(), effects.join("; ")]
        })
        .collect();
    if !rows.is_empty() {
        let view = TableView::words(&["set", "alternative", "as it was tried"], rows);
        page.section("What is to be distinguished", "", view);
    }
}

fn motions(page: &mut Page, plan: &Plan) {
    if plan.motions.is_empty() {
        return;
    }
    let catalogue = plan.question == QuestionKind::Catalogue;
    let row = |e: &Entry| {
        let mut cells =
            vec![e.motion.clone(), e.does.clone(), format!("{:.0}", e.duration_s), e.runs.len().to_string()];
        if catalogue {
            cells.push(e.worst_ratio.map_or("–".into(), number));
            return cells;
        }
        let shown = e.evidence.as_ref();
        cells.push(shown.map_or("–".into(), |v| evidence(v.expected_2lnl)));
        cells.push(shown.map_or("–".into(), |v| format!("{:.1}", 100.0 * v.probability_named)));
        let outside = shown.and_then(|v| v.nearest_outside.as_ref());
        cells.push(outside.map_or("–".into(), |o| format!("{} ({})", o.what, evidence(o.expected_2lnl))));
        cells
    };
    let mut headings = vec![("motion", false), ("what it does", false), ("s", true), ("runs", true)];
    headings.extend(if catalogue {
        &[("typical over detectable size, worst effect", true)][..]
    } else {
        &[("expected 2 ln L", true), ("named alone, %", true), ("nearest other effect", false)]
    });
    let view = TableView::new(&headings, plan.motions.iter().map(row));
    page.section("Every motion of the library", "Best first.", view);
}

fn detectable(entry: &Entry) -> TableView {
    let row = |d: &DetectableShown| {
        let ratio = if d.ratio.is_finite() { number(d.ratio) } else { "–".into() };
        vec![d.effect.into(), d.target.clone(), ratio, d.detectable_from.as_ref().map_or("–".into(), parameters)]
    };
    let headings =
        [("effect", false), ("target", false), ("typical over detectable size", true), ("detectable from", false)];
    TableView::new(&headings, entry.detectable.iter().map(row))
}

/// Parameters of an effect as a model file has them.
fn parameters(effect: &Value) -> String {
    let Some(map) = effect.as_object() else { return String::new() };
    let shown = |(key, value): (&String, &Value)| match value {
        _ if key == "effect" => None,
        Value::Number(n) => Some(format!("{key} {}", n.as_f64().map_or_else(|| n.to_string(), number))),
        Value::String(s) => Some(format!("{key} {s}")),
        other => Some(format!("{key} {other}")),
    };
    let kind = map.get("effect").and_then(Value::as_str).unwrap_or_default();
    let list: Vec<String> = map.iter().filter_map(shown).collect();
    format!("{kind}: {}", list.join(", "))
}

/// Evidence; next to none is 0.
fn evidence(two_ln_l: f64) -> String {
    if two_ln_l.abs() < 0.005 { "0".into() } else { number(two_ln_l) }
}

/// Four digits that count.
fn number(v: f64) -> String {
    if !v.is_finite() || v == 0.0 {
        return crate::report::number(v, 0);
    }
    let decimals = (3 - v.abs().log10().floor() as i32).clamp(0, 9) as usize;
    let text = format!("{v:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

fn runs(entry: &Entry) -> String {
    let loads: Vec<String> =
        entry.runs.iter().filter_map(|r| r.payload_kg).map(|kg| format!("{} kg", number(kg))).collect();
    if loads.is_empty() { String::new() } else { format!("once with each of {}", loads.join(" and ")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_sizes_keep_their_digits_and_no_evidence_is_zero() {
        let effect = serde_json::json!({"effect": "backlash", "joint": "A2", "half_gap_deg": 0.003});
        assert_eq!(parameters(&effect), "backlash: joint A2, half_gap_deg 0.003");
        assert_eq!(
            [number(0.0), number(0.00012346), evidence(0.003), evidence(7.667)],
            ["0", "0.0001235", "0", "7.667"]
        );
    }
}
