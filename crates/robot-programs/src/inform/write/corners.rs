//! Corners of moves: those of new points, and narrower ones at a move's own goal.

use super::Writer;
use crate::decimal::Decimal;
use crate::inform::job::Statement;
use crate::script::{EditRef, NewPoint, Patch, PathKind, StepKind, number};

/// Corner of each position level, m, as the factory sets it.
const LEVELS_M: [f64; 9] = [0.0, 0.0125, 0.025, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5];

/// Smallest corner radius `CR=`, mm.
const LEAST_CR_MM: f64 = 1.0;

impl Writer<'_> {
    /// Speed and the like of a new point, with the finest corner that fits. Where the move gives no corner, neither does the new
    /// point: the controller's own choice holds for both.
    pub(super) fn tags(&self, step: usize, statement: &Statement, point: &NewPoint) -> String {
        let mut out = String::new();
        // a copy of an exact stop stops, but a straight TCP move is not stopped on its way
        let kind = self.job.script.steps.get(step).map(|s| &s.kind);
        let straight = matches!(kind, Some(StepKind::Move(m)) if m.path == PathKind::Linear);
        let corner = |stops: bool| {
            if stops && !straight {
                "PL=0".into()
            } else if point.clearance_m >= LEVELS_M[1] {
                "PL=1".into()
            } else if straight && self.knows_radii() {
                radius("", point.clearance_m)
            } else {
                "PL=0".to_string()
            }
        };
        for tag in self.job.parts.tags(statement) {
            let word = String::from_utf8_lossy(self.job.script.texts[0].slice(tag.span)).into_owned();
            out.push(' ');
            match tag.key() {
                "PL" => out.push_str(&corner(level(&word) == Some(0))),
                "CR" => out.push_str(&radius(&word, point.clearance_m)),
                _ => out.push_str(&word),
            }
        }
        out
    }

    /// Corner radii are written on a controller only if the job has some: older ones do not know them.
    fn knows_radii(&self) -> bool {
        self.job.parts.has_tag("CR")
    }

    /// Narrows the corner at a move's own goal. A move that gives none keeps none: no size may be chosen for it.
    pub(super) fn blend(&mut self, step: usize, edit: EditRef) {
        let (Some(at_most), Some(statement)) = (edit.blend_at_most_m, self.statement(step)) else { return };
        let text = &self.job.script.texts[0];
        let fits = LEVELS_M.iter().rposition(|&r| r <= at_most).unwrap_or(0);
        let tags = self.job.parts.tags(statement);
        let Some(tag) = tags.iter().find(|t| matches!(t.key(), "PL" | "CR")) else { return };
        let word = String::from_utf8_lossy(text.slice(tag.span)).into_owned();
        // a size that is computed stays: any number in its place may be a wider corner
        if size(&word).is_none() {
            return;
        }
        let new = match (tag.key(), level(&word)) {
            ("CR", _) => radius(&word, at_most),
            (_, Some(own)) if own <= fits => word.clone(),
            _ => format!("PL={fits}"),
        };
        if new != word {
            self.patches.push(Patch::new(0, tag.span, new));
        }
    }
}

/// `PL=2`.
fn level(word: &str) -> Option<usize> {
    word.split_once('=')?.1.parse().ok()
}

/// `CR=12.5`, `PL=2`: the number, as far as it is one.
fn size(word: &str) -> Option<f64> {
    Some(number::read(word.split_once('=')?.1.as_bytes())?.0)
}

/// `CR=` no wider than `at_most_m`; an exact stop where that is less than the least.
fn radius(word: &str, at_most_m: f64) -> String {
    let tenths = (at_most_m * 1e4).floor();
    if size(word).unwrap_or(f64::INFINITY) * 10.0 <= tenths {
        return word.to_string();
    }
    let fits = Decimal::new(tenths as i64, 1).filter(|fits| fits.value() >= LEAST_CR_MM);
    fits.map_or("PL=0".into(), |fits| format!("CR={fits}"))
}
