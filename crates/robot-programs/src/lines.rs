//! Point number -> line of the file. Only the places where the distance between the two changes are kept (comments, blank
//! lines, cells with line breaks), at most [`MOST`] of them; beyond that the line is not known and messages give the point.

/// Changes that are kept: 8 MB.
const MOST: usize = 500_000;

/// The lines of a program's points.
#[derive(Debug, Clone, Default)]
pub struct Lines {
    /// `(first point, its line - point)`.
    steps: Vec<(u64, u64)>,
    /// Points from here on are not known.
    end: Option<u64>,
}

impl Lines {
    /// Notes that `point` and those after it stand on `line` and the lines after it.
    #[inline]
    pub fn note(&mut self, point: u64, line: u64) {
        let offset = line - point;
        if self.end.is_some() || self.steps.last().is_some_and(|&(_, o)| o == offset) {
            return;
        }
        if self.steps.len() == MOST {
            self.end = Some(point);
            return;
        }
        self.steps.push((point, offset));
    }

    /// Adds the lines of the points that follow, counted there from 0: the first of them is `point`, on `line`.
    pub fn append(&mut self, following: &Lines, point: u64, line: u64) {
        for &(p, offset) in &following.steps {
            self.note(point + p, line + p + offset);
        }
    }

    /// Every change was kept.
    pub fn is_complete(&self) -> bool {
        self.end.is_none()
    }

    /// Line of a point, counted from 1.
    pub fn line(&self, point: u64) -> Option<u64> {
        if self.end.is_some_and(|end| point >= end) {
            return None;
        }
        let k = self.steps.partition_point(|&(p, _)| p <= point);
        k.checked_sub(1).map(|k| point + self.steps[k].1)
    }
}
