//! What differs between two programs, move by move: joints in degrees or millimetres, the TCP in micrometres.

use super::run::Run;
use crate::error::Result;
use crate::program::script::{Document, Edits, Format, Goal, Script, StepKind, Text};
use crate::rewrite::near::{self, first_difference};
use crate::robot::Robot;
use serde::Serialize;

/// A move that is written differently, or a point that is new.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Change {
    pub line: u64,
    /// The point is new, on the way to the target of this line.
    pub added: bool,
    /// Joint name and change, deg or mm (of a new point: against the way without it).
    pub joints: Vec<(String, f64)>,
    pub tcp_um: f64,
}

impl Change {
    /// `line 12: A1 +0.002800 deg, at the TCP 142.0 um`.
    pub fn words(&self, robot: &Robot) -> String {
        let unit = |name: &str| robot.axis_named(name).map_or("", |a| robot.axis(a).kind.unit());
        let joints: Vec<String> = self.joints.iter().map(|(n, v)| format!("{n} {v:+.6} {}", unit(n))).collect();
        let added = if self.added { " new point:" } else { "" };
        format!("line {}:{added} {}, at the TCP {:.1} um", self.line, joints.join(", "), self.tcp_um)
    }
}

/// The first changes that edits make, at most `most`, in the order of the program; and how many moves and new points change.
pub fn of_edits(
    document: &dyn Document,
    runs: &[Run],
    edits: &Edits,
    robot: &Robot,
    most: usize,
) -> (Vec<Change>, usize) {
    let script = document.script();
    let mut changes = Vec::new();
    let mut total = 0;
    let change = |list: &mut Vec<Change>, line, added, from: &[f64], to: &[f64]| {
        if list.len() < most {
            list.extend(change(line, added, from, to, robot));
        }
    };
    for run in runs {
        for leg in run.legs() {
            let vertex = leg.goal;
            let line = script.steps[vertex.step].at.line;
            if let Some(edit) = edits.steps.get(vertex.step) {
                for p in edit.before {
                    let known = document.on_way(vertex.step, p.share).map(|q| run.standing(vertex.step, q, &vertex.q));
                    let own = known.filter(|_| document.passes_points()).or_else(|| leg.plan(p.share));
                    if let Some(own) = own.filter(|_| !p.of_way) {
                        total += 1;
                        change(&mut changes, line, true, &own, &p.q);
                    }
                }
                if let Some(goal) = edit.goal {
                    let any = vertex.q.iter().zip(goal).any(|(a, b)| (a - b).abs() > 1e-11);
                    total += usize::from(any);
                    change(&mut changes, line, false, &vertex.q, goal);
                }
            }
        }
    }
    let total = total.max(changes.len());
    (changes, total)
}

fn change(line: u64, added: bool, from: &[f64], to: &[f64], robot: &Robot) -> Option<Change> {
    let joints: Vec<(String, f64)> = robot
        .axis_joints()
        .enumerate()
        .map(|(k, j)| (j.name.clone(), j.kind.to_user_unit(to[k] - from[k])))
        .filter(|(_, v)| v.abs() > 1e-9)
        .map(|(n, v)| (n, (v * 1e9).round() / 1e9))
        .collect();
    let tcp_um = (robot.tcp_m(to) - robot.tcp_m(from)).norm() * 1e6;
    (added || !joints.is_empty()).then(|| Change { line, added, joints, tcp_um: (tcp_um * 1e3).round() / 1e3 })
}

/// The first difference between our texts and a golden program, in words; `None`: the same bytes, but for numbers within
/// `tolerance`.
pub fn against(
    format: &dyn Format,
    ours: &[Text],
    golden: &[Text],
    robot: &Robot,
    tolerance: Option<f64>,
) -> Result<Option<String>> {
    let first =
        ours.iter().zip(golden).find_map(|(a, b)| Some((a, b, first_difference(&a.bytes, &b.bytes, tolerance)?)));
    let Some((a, b, at)) = first else { return Ok(None) };
    let text = |t: &Text| String::from_utf8_lossy(t.line(at.line as usize - 1)).trim_end().to_string();
    let mut words = vec![format!("{}:{}: the output differs", b.name, at.line)];
    words[0] += &match at.ends {
        Some(near::Text::First) => ": the output ends before this line".into(),
        Some(near::Text::Second) => ": the golden file ends before this line".into(),
        None => format!(": `{}` instead of `{}`", text(a), text(b)),
    };
    // the first move whose joints differ, where both can be read
    if let (Ok(x), Ok(y)) = (format.parse(ours.to_vec(), robot.axes()), format.parse(golden.to_vec(), robot.axes())) {
        words.extend(first_move(x.script(), y.script(), robot, tolerance.unwrap_or(0.0)));
    }
    Ok(Some(words.join("\n")))
}

/// The first move whose joint target differs by more than `tolerance`, deg or mm.
fn first_move(ours: &Script, golden: &Script, robot: &Robot, tolerance: f64) -> Option<String> {
    let targets = |s: &Script| -> Vec<(u64, Vec<Option<f64>>)> {
        s.steps
            .iter()
            .filter_map(|step| match &step.kind {
                StepKind::Move(m) => match m.goal {
                    Goal::Joints(t) => {
                        Some((step.at.line, s.targets.get(t)?.values.iter().map(|v| v.map(|v| v.si)).collect()))
                    }
                    _ => Some((step.at.line, Vec::new())),
                },
                _ => None,
            })
            .collect()
    };
    let (a, b) = (targets(ours), targets(golden));
    let near = |axis: usize, x: Option<f64>, y: Option<f64>| match (x, y) {
        (Some(x), Some(y)) => robot.axis(axis).kind.to_user_unit(x - y).abs() <= tolerance,
        _ => x == y,
    };
    let same = |x: &[Option<f64>], y: &[Option<f64>]| {
        x.len() == y.len() && (0..x.len()).all(|axis| near(axis, x[axis], y[axis]))
    };
    let k = a.iter().zip(&b).position(|(x, y)| !same(&x.1, &y.1));
    let Some(k) = k else {
        return (a.len() != b.len()).then(|| format!("  {} moves instead of {}", a.len(), b.len()));
    };
    let full =
        |v: &[Option<f64>]| (0..robot.dof()).map(|i| v.get(i).copied().flatten().unwrap_or(0.0)).collect::<Vec<_>>();
    let difference = change(b[k].0, false, &full(&b[k].1), &full(&a[k].1), robot)?;
    Some(format!("  {}", difference.words(robot)))
}
