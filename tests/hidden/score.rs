//! Scores a diagnosis against the truth of its case.
//!
//! An effect is *named first* where a round of the final set names it on its target (or one of its `also_right`); it is
//! *right* where such a round's set, of at most three, holds it. The gap is closed on the second log: `closed` is
//! (known^2 - found^2)/(known^2 - truth^2) of rms against the measurement, as an oracle that knows the effect would have it;
//! `closed_exact` is 1 - rms(found - truth)/rms(known - truth), without the noise, which is the harder figure.

use crate::diagnose::{self, Diagnosed};
use crate::effects::{Effect, is_size};
use crate::kinematics::{apply, rigid_fit};
use crate::physics::rms_um;
use crate::replay::{Folder, without_outliers};
use serde_json::Value;
use std::path::Path;

/// What became of one effect of the truth.
#[derive(Clone, Debug, Default)]
pub struct Found {
    pub name: String,
    pub target: String,
    pub first: bool,
    pub right: bool,
    /// Name and target that the nearest round gave it.
    pub named: Option<(String, String)>,
    /// Found size over true size, of the first size parameter.
    pub size: Option<f64>,
    /// Parameters inside their ci95, and parameters with one.
    pub inside: (usize, usize),
}

#[derive(Clone, Debug, Default)]
pub struct Score {
    pub case: String,
    /// `null`, `single 10`, `single 3`, `single large`, `pair`, `triple`, `unknown`, `bad`.
    pub class: String,
    pub verdict: String,
    pub verdict_right: bool,
    pub effects: Vec<Found>,
    /// Effects named that are none of the truth, nor stand in a set that holds one.
    pub false_alarms: Vec<String>,
    pub closed: Option<f64>,
    pub closed_exact: Option<f64>,
    pub seconds: f64,
    pub note: String,
}

type Named = (String, String);

fn named(v: &Value) -> Named {
    let e = Effect::parse(v);
    (e.name, e.target.to_lowercase())
}

/// Rounds that stand in the final set.
fn final_rounds(document: &Value) -> Vec<&Value> {
    let list = |key: &str| document[key].as_array().map(Vec::as_slice).unwrap_or_default();
    let kept: Vec<Named> = list("effects").iter().map(named).collect();
    list("rounds").iter().filter(|r| kept.is_empty() || kept.contains(&named(r))).collect()
}

fn class_of(truth: &Value) -> String {
    let kind = truth["kind"].as_str().unwrap_or("?");
    if kind != "single" {
        return kind.into();
    }
    match truth["effects"][0]["mdb_multiple"].as_f64().unwrap_or(10.0) {
        m if m < 5.0 => "single 3".into(),
        m if m < 18.0 => "single 10".into(),
        _ => "single large".into(),
    }
}

/// Diagnoses the case in a folder and scores the answer.
pub fn folder(path: &Path) -> Score {
    let case = Folder::read(path);
    let work = tempfile::tempdir().expect("a work folder");
    // Beside the case, as the found model names its robot by a relative path.
    let found = work.path().join("found.yaml");
    std::fs::copy(path.join("robot.yaml"), work.path().join("robot.yaml")).expect("robot.yaml can be copied");
    let said = diagnose::run(path, &found);
    let mut score = judge(&case.truth, &said);
    score.case = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let of_this_log = |e: &crate::effects::Effect| {
        ["tracker_frame", "process_force"].contains(&e.name.as_str()) || e.name.starts_with("torque_")
    };
    let repeats = !case.effects.iter().any(of_this_log);
    if said.exit == 0 && !case.effects.is_empty() && repeats && case.truth["kind"] != "bad" {
        closure(&case, &found, work.path(), &mut score);
    }
    score
}

/// All but the gap's closure: from the truth and the diagnosis alone.
pub fn judge(truth: &Value, said: &Diagnosed) -> Score {
    let mut score = Score { class: class_of(truth), seconds: said.seconds, ..Score::default() };
    let nothing = Value::Null;
    let document = said.document.as_ref().unwrap_or(&nothing);
    let bad = truth["kind"] == "bad";
    score.verdict = match document["verdict"].as_str() {
        Some(v) => v.into(),
        // A refusal of the file, not of the command line.
        None if said.exit == 2 && bad && !said.stderr.contains("--help") => "bad_data".into(),
        None => format!("exit {}", said.exit),
    };
    if said.exit != 0 {
        score.note = said.stderr.lines().last().unwrap_or_default().chars().take(110).collect();
    }
    let right = truth["right_verdict"].as_array().map(Vec::as_slice).unwrap_or_default();
    score.verdict_right = right.iter().any(|r| r.as_str() == Some(&score.verdict));
    let rounds = final_rounds(document);
    let mut used = vec![false; rounds.len()];
    if bad {
        score.false_alarms = rounds.iter().map(|r| show(r)).collect();
        return score;
    }
    let truths = truth["effects"].as_array().map(Vec::as_slice).unwrap_or_default();
    // First what is named outright, then what stands in a set: a round counts once.
    let mut found: Vec<Found> = Vec::new();
    for t in truths {
        let e = Effect::parse(t);
        let accepted = accepted(t);
        let mut f = Found { name: e.name.clone(), target: e.target.clone(), ..Found::default() };
        if let Some(k) = (0..rounds.len()).find(|&k| !used[k] && accepted.contains(&named(rounds[k]))) {
            used[k] = true;
            (f.first, f.right) = (true, true);
            f.named = Some(named(rounds[k]));
            if named(rounds[k]) == named(t) {
                measure(&e, &rounds[k]["parameters"], &mut f);
            }
        }
        found.push(f);
    }
    for (t, f) in truths.iter().zip(&mut found).filter(|(_, f)| !f.first) {
        let accepted = accepted(t);
        let holds = |r: &Value| {
            let set = r["set"].as_array().map(Vec::as_slice).unwrap_or_default();
            set.len() <= 3 && set.iter().any(|s| accepted.contains(&named(s)))
        };
        if let Some(k) = (0..rounds.len()).find(|&k| !used[k] && holds(rounds[k])) {
            used[k] = true;
            f.right = true;
            f.named = Some(named(rounds[k]));
        }
    }
    // What is left over goes to the confusion matrix against what was missed.
    let mut left = (0..rounds.len()).filter(|k| !used[*k]).map(|k| named(rounds[k]));
    for f in found.iter_mut().filter(|f| f.named.is_none()) {
        f.named = left.next();
    }
    score.effects = found;
    score.false_alarms = (0..rounds.len()).filter(|k| !used[*k]).map(|k| show(rounds[k])).collect();
    score
}

fn accepted(t: &Value) -> Vec<Named> {
    let also = t["also_right"].as_array().map(Vec::as_slice).unwrap_or_default();
    std::iter::once(named(t)).chain(also.iter().map(named)).collect()
}

fn show(round: &Value) -> String {
    let (name, target) = named(round);
    format!("{name} {target}")
}

/// Size and intervals of a round's parameters against the true ones.
fn measure(e: &Effect, parameters: &Value, f: &mut Found) {
    for (key, value) in &e.values {
        let p = &parameters[key.as_str()];
        let Some(got) = p["value"].as_f64() else { continue };
        if is_size(key) && f.size.is_none() && *value != 0.0 {
            f.size = Some(got / value);
        }
        let (Some(low), Some(high)) = (p["ci95"][0].as_f64(), p["ci95"][1].as_f64()) else { continue };
        // A phase counts round the turn that is nearest; of a swing the half turn, as its direction may be told either way.
        let round = if e.name == "vibration" { 180.0 } else { 360.0 };
        let turn = if key == "phase_deg" { round * ((0.5 * (low + high) - value) / round).round() } else { 0.0 };
        f.inside.1 += 1;
        if (low..=high).contains(&(value + turn)) {
            f.inside.0 += 1;
        }
    }
}

/// How much of the gap on the second log a found model closes.
pub fn closure(case: &Folder, found: &Path, work: &Path, score: &mut Score) {
    let log = case.log("test.csv");
    let (known, truth) = (case.predict(&log, &[]), case.predict(&log, &case.effects));
    let measured = without_outliers(&truth, &log.measured);
    let exact: Vec<_> = truth.iter().map(|p| Some(*p)).collect();
    let (gap, floor) = (case.gap_um(&known, &measured), case.gap_um(&truth, &measured));
    let moved = case.gap_um(&known, &exact);
    // A second path that hardly shows the effect says nothing about its closure.
    if moved < 0.15 * floor {
        return;
    }
    let Some(predicted) = diagnose::predict(found, &case.path.join("test.csv"), &case.robot, work) else {
        score.note = "the found model does not simulate".into();
        return;
    };
    score.closed = Some((gap.powi(2) - case.gap_um(&predicted, &measured).powi(2)) / (gap.powi(2) - floor.powi(2)));
    let fit = rigid_fit(&predicted, &exact);
    let laid: Vec<_> = if case.given { predicted } else { predicted.iter().map(|p| apply(&fit, p)).collect() };
    score.closed_exact = Some(1.0 - rms_um(&laid, &exact) / moved);
}
