//! Which document a joint's values come from.
//!
//! Gap and friction that were estimated together stay together. Otherwise a schedule wins over a constant: a gap that varies has no
//! constant. Among schedules the one from most tested cycles wins, among constants the one with the narrower interval. Stiction comes
//! from the document that knows it best in proportion. The reversals by which a constant is judged are those of the document it comes
//! from.

use crate::compensator::note::{Note, Source};
use crate::gaps::estimate::JointEstimate;
use crate::gaps::{GapPoint, Gaps, JointGap, StictionFound};
use crate::robot::Robot;

/// What is known about an axis.
#[derive(Debug, Clone)]
pub struct Merged {
    /// Axis of the robot.
    pub axis: usize,
    /// The half gap that is used.
    pub gap: JointGap,
    /// Logs of the document that the gap comes from.
    pub gap_source: Source,
    /// Half gaps at single positions, if the gap comes from a static test.
    pub points: Vec<GapPoint>,
    /// Friction after reversals, from the paths.
    pub stiction: Option<StictionFound>,
    /// Friction that was estimated together with the gap.
    pub estimate: Option<JointEstimate>,
    /// p of no stiction, where one was looked for.
    pub stiction_p: Option<f64>,
}

/// One entry per axis that any document names, in the robot's order.
pub fn merge(documents: &[Gaps], robot: &Robot, notes: &mut Vec<Note>) -> Vec<Merged> {
    let mut out = Vec::new();
    // documents whose gaps are passed over, and the joints
    let mut unused: Vec<(usize, usize, Vec<String>)> = Vec::new();
    for axis in 0..robot.dof() {
        let found: Vec<(usize, &JointGap)> = documents
            .iter()
            .enumerate()
            .flat_map(|(d, doc)| doc.joints.iter().filter(|j| j.axis == axis).map(move |j| (d, j)))
            .collect();
        let Some(&first) = found.first() else { continue };
        let points = |d: usize| documents[d].points.iter().filter(move |p| p.axis == axis);
        let cycles = |d: usize| points(d).map(|p| p.cycles).sum::<usize>();
        let scheduled = found.iter().filter(|(_, j)| j.schedule.is_some()).max_by_key(|(d, _)| cycles(*d));
        let narrowest = found
            .iter()
            .filter(|(_, j)| width(j.ci95) > 0.0)
            .min_by(|a, b| width(a.1.ci95).total_cmp(&width(b.1.ci95)));
        let estimated = |d: usize| documents[d].estimate.iter().flat_map(|e| &e.joints).find(|e| e.axis == axis);
        // what was estimated together is used together
        let together = found.iter().rev().find(|(d, _)| estimated(*d).is_some());
        let &(from, gap) = together.or(scheduled).or(narrowest).unwrap_or(&first);
        for (d, j) in found.iter().filter(|(d, _)| *d != from) {
            if together.is_some() {
                match unused.iter_mut().find(|u| (u.0, u.1) == (*d, from)) {
                    Some(u) => u.2.push(robot.axis(axis).name.clone()),
                    None => unused.push((*d, from, vec![robot.axis(axis).name.clone()])),
                }
            }
            if gap.schedule.is_none() && (j.ci95[0] > gap.ci95[1] || j.ci95[1] < gap.ci95[0]) {
                notes.push(Note::HalfGapsDiffer {
                    joint: robot.axis(axis).name.clone(),
                    kind: robot.axis(axis).kind,
                    used: source(&documents[from]),
                    used_half_gap: gap.half_gap,
                    other: source(&documents[*d]),
                    other_half_gap: j.half_gap,
                });
            }
        }
        let stiction = found
            .iter()
            .filter_map(|(_, j)| j.stiction.as_ref())
            .min_by(|a, b| (width(a.ci95) / a.spike).total_cmp(&(width(b.ci95) / b.spike)));
        out.push(Merged {
            axis,
            gap: gap.clone(),
            gap_source: source(&documents[from]),
            points: points(from).cloned().collect(),
            stiction: stiction.filter(|_| together.is_none()).cloned(),
            estimate: estimated(from).cloned(),
            stiction_p: found.iter().find_map(|(_, j)| j.stiction_p_value),
        });
    }
    notes.extend(unused.into_iter().map(|(d, from, joints)| Note::PassedOver {
        joints,
        unused: source(&documents[d]),
        used: source(&documents[from]),
    }));
    out
}

fn width(ci: [f64; 2]) -> f64 {
    ci[1] - ci[0]
}

fn source(document: &Gaps) -> Source {
    Source(document.logs.iter().map(|l| l.name.clone()).collect())
}
