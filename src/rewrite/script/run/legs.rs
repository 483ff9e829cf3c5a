//! The ways between the goals of a run, without offsets.

use super::{Role, Run, Vertex};

/// The way to a goal.
#[derive(Debug, Clone, Copy)]
pub struct Leg<'a> {
    run: &'a Run,
    /// Joints where it starts, rad or m; `None`: not known.
    start: Option<&'a [f64]>,
    /// The point from which the goal is reached from its side.
    approach: Option<&'a Vertex>,
    /// Where it ends.
    pub goal: &'a Vertex,
}

impl Leg<'_> {
    /// Joints without offsets at a share of the way; `None`: the way is not known.
    pub fn plan(&self, share: f64) -> Option<Vec<f64>> {
        if let Some(point) = self.approach.filter(|point| point.share == share) {
            return Some(point.q.to_vec());
        }
        match (self.run.line(self.goal.step), self.start) {
            (Some(line), _) => line.at(share),
            (None, start) => Some(start?.iter().zip(self.goal.q.iter()).map(|(a, b)| a + share * (b - a)).collect()),
        }
    }
}

impl Run {
    /// The ways to goals of moves, each once.
    pub fn legs(&self) -> impl Iterator<Item = Leg<'_>> {
        let (mut start, mut approach) = (None, None);
        self.vertices.iter().filter(|v| !v.again).filter_map(move |v| match v.role {
            Role::Before => {
                start = Some(&v.q[..]);
                None
            }
            Role::Approach => {
                approach = Some(v);
                None
            }
            Role::Goal => {
                let approach = approach.take().filter(|a| a.step == v.step);
                Some(Leg { run: self, start: start.replace(&v.q[..]), approach, goal: v })
            }
            Role::Way | Role::Hold | Role::Crossing => None,
        })
    }
}
