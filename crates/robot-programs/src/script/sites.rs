//! What writers of languages with statements share: which moves want what of a declared target, what is written where it stands
//! and what under another name, and how a written time is shared out over new points.

use super::blocks::BySteps;
use super::{EditRef, Edits, Goal, Move, NewPoint, Patch, Patches, Script, Span, StepKind, Text, number};
use crate::error::{Error, Result};
use std::collections::BTreeMap;
use std::fmt::Display;
use std::ops::Range;

/// A number's bytes, and what takes their place.
pub type Number = (Range<usize>, String);

/// A time that is written on a move: bytes of the number, s, style.
pub type Time = (Range<usize>, f64, number::Style);

/// A script of one text, and what is asked of it.
#[derive(Clone, Copy)]
pub struct EditRequest<'a> {
    /// The program as it was read.
    pub script: &'a Script,
    /// What is asked of it.
    pub edits: &'a Edits,
}

/// What becomes of one target.
pub struct TargetEdit<'a> {
    /// Number of the target.
    pub target: usize,
    /// Joint values, or numbers of a pose, of the one move that leads there: its numbers are written where they stand. Nearly every target
    /// has such, so that no list is made of them.
    pub alone: Option<&'a [f64]>,
    /// Numbers that are written where they stand.
    pub in_place: Vec<Number>,
    /// Numbers of each clone, and the moves that are turned to it.
    pub clones: Vec<(Vec<Number>, Vec<usize>)>,
}

impl<'a> EditRequest<'a> {
    /// The one text of the program.
    pub fn text(&self) -> Result<&'a Text> {
        self.script.texts.first().ok_or_else(|| Error::Refused("no text".into()))
    }

    /// The move of a step.
    pub fn move_at(&self, k: usize) -> Result<&'a Move> {
        match self.script.steps.get(k).map(|s| &s.kind) {
            Some(StepKind::Move(m)) => Ok(m),
            _ => Err(Error::Refused(format!("step {} is no move", k + 1))),
        }
    }

    /// A refusal with the place of a step.
    pub fn refused(&self, k: usize, why: impl Display) -> Error {
        let place = self.script.steps.get(k).map(|s| self.script.place(s.at)).unwrap_or_default();
        Error::Refused(format!("{place}: {why}"))
    }

    /// Weight that the last digit of an axis should have at most, rad or m; NaN: no wish.
    pub fn digit(&self, axis: usize) -> f64 {
        self.edits.digit.get(axis).copied().unwrap_or(f64::NAN)
    }

    /// Changed goals, by target: in place where all moves to it agree, else by clones. `numbers` gives the changed numbers of a
    /// target for joint values; `keeps` says of a named target whether it must keep its value, and nothing of one in the
    /// statement itself. What becomes of each target goes to `each` in their order, so that never all of it is held.
    pub fn wanted(
        &self,
        numbers: &dyn Fn(usize, &[f64]) -> Vec<Number>,
        keeps: &dyn Fn(usize) -> Option<bool>,
        each: &mut dyn FnMut(TargetEdit<'a>) -> Result<()>,
    ) -> Result<()> {
        let uses = self.script.use_counts();
        let mut goals: Vec<(usize, usize, &[f64])> = Vec::with_capacity(self.edits.steps.len());
        for (k, edit) in self.edits.steps.iter().filter(|(_, e)| !e.as_joint_moves) {
            let Some(q) = edit.goal else { continue };
            let m = self.move_at(k)?;
            match (m.goal.target(), &m.fixed, &m.goal) {
                (Some(t), None, _) => goals.push((t, k, q)),
                (_, Some(why), _) | (_, _, Goal::Opaque(why)) => return Err(self.refused(k, why)),
                _ => return Err(self.refused(k, "the numbers of its target cannot be written")),
            }
        }
        goals.sort_by_key(|g| g.0);
        for steps in goals.chunk_by(|a, b| a.0 == b.0) {
            let Some(&(target, ..)) = steps.first() else { continue };
            let shared = uses.get(target).copied().unwrap_or(0) > steps.len();
            if let [(_, k, q)] = steps {
                // one move, one change: nearly every target
                let stays = keeps(target).is_some_and(|keeps| shared || keeps);
                let numbers = if stays { numbers(target, q) } else { Vec::new() };
                let clones = if numbers.is_empty() { Vec::new() } else { vec![(numbers, vec![*k])] };
                each(TargetEdit { target, alone: (!stays).then_some(*q), in_place: Vec::new(), clones })?;
                continue;
            }
            // groups of moves that want the same, in the order of the program
            let mut groups: Vec<(Vec<Number>, Vec<usize>)> = Vec::new();
            let mut index: BTreeMap<Vec<(usize, String)>, usize> = BTreeMap::new();
            let mut unchanged = shared;
            for &(_, k, q) in steps {
                let numbers = numbers(target, q);
                if numbers.is_empty() {
                    unchanged = true;
                    continue;
                }
                let key = numbers.iter().map(|(span, new)| (span.start, new.clone())).collect();
                let g = *index.entry(key).or_insert_with(|| {
                    groups.push((numbers, Vec::new()));
                    groups.len() - 1
                });
                groups[g].1.push(k);
            }
            let in_place = match keeps(target) {
                None => groups.len(),
                Some(keeps) => usize::from(!unchanged && !keeps).min(groups.len()),
            };
            let clones = groups.split_off(in_place);
            let in_place = groups.into_iter().flat_map(|g| g.0).collect();
            each(TargetEdit { target, alone: None, in_place, clones })?;
        }
        Ok(())
    }

    /// Joint values of a Cartesian move that is to become a joint move.
    pub fn joints_for_pose(&self, k: usize, m: &Move, edit: EditRef<'a>) -> Result<&'a [f64]> {
        let Some(q) = edit.goal else { return Err(self.refused(k, "a joint move without a goal")) };
        if !matches!(m.goal, Goal::Pose(_)) || m.closed.is_some() {
            return Err(match &m.closed {
                Some(why) => self.refused(k, why),
                None => self.refused(k, "only a Cartesian move can become a joint move"),
            });
        }
        Ok(q)
    }

    /// A written time shared out over the new points of a move and its goal: a text for each leg, with at least `decimals`. The last
    /// replaces the time. `least_s`: shortest legs, of which the first that fits is taken. `None`: none fits.
    pub fn legs(edit: EditRef, time: &Time, least_s: &[f64], decimals: u8) -> Option<Vec<String>> {
        let (_, total_s, style) = time;
        let shares: Vec<f64> = edit.before.iter().map(|p| p.share).collect();
        let legs = least_s.iter().find_map(|least| number::share_out(*total_s, &shares, *least))?;
        let style = number::Style { exponent: false, ..*style };
        let decimals = style.decimals.max(decimals);
        Some(legs.iter().map(|s| number::write(*s, style, decimals)).collect())
    }
}

/// A writer of programs of one text, in which each move has a separate place.
pub trait OneText {
    /// Where a move stands, and what of it is written.
    type Site;

    /// The program, and what is asked of it.
    fn asked(&self) -> EditRequest<'_>;

    /// The places of the moves.
    fn sites(&self) -> &BySteps<Self::Site>;

    /// New texts of a target's numbers, with their bytes; `scratch`: where a text is put together.
    fn each_number(&self, target: usize, q: &[f64], scratch: &mut Vec<u8>, each: &mut dyn FnMut(Range<usize>, &[u8]));

    /// The same as a list.
    fn numbers(&self, target: usize, q: &[f64]) -> Vec<Number> {
        let mut all = Vec::new();
        self.each_number(target, q, &mut Vec::new(), &mut |span, new| {
            all.push((span, String::from_utf8_lossy(new).into_owned()));
        });
        all
    }

    /// A target's list with other numbers, on one line.
    fn literal(&self, target: usize, numbers: &[Number]) -> Result<String>;

    /// A list of joint values for a move whose own target is Cartesian.
    fn plain(&self, k: usize, site: &Self::Site, q: &[f64]) -> Result<String>;

    /// Bytes of the point on the way of an arc.
    fn via(&self, site: &Self::Site) -> Option<Span>;

    /// The one text of the program.
    fn text(&self) -> Result<&Text> {
        self.asked().text()
    }

    /// Whether a move gets new points before it. Writes the point on the way of the last piece of an arc, which the motion itself goes.
    fn has_new_points(&self, k: usize, m: &Move, site: &Self::Site, edit: EditRef, out: &mut Patches) -> Result<bool> {
        if edit.before.is_empty() && edit.vias.is_empty() {
            return Ok(false);
        }
        if let Some(why) = &m.closed {
            return Err(self.refused(k, why));
        }
        if let Some(via) = self.via(site) {
            if edit.vias.len() != edit.before.len() + 1 {
                return Err(self.refused(k, "a piece of its arc has no point on its way"));
            }
            if let Some(at) = edit.piece(edit.before.len()) {
                let q = edit.goal.or(edit.before.last().map(|p| p.q.as_slice()));
                out.push(Patch::new(0, via, self.on_arc(k, m, q, at)?));
            }
        }
        Ok(!edit.before.is_empty())
    }

    /// Target of a new point, in line.
    fn target(&self, k: usize, m: &Move, site: &Self::Site, point: &NewPoint, as_joints: bool) -> Result<String> {
        match (m.goal.target(), &m.goal) {
            (_, Goal::Pose(_)) if as_joints => self.plain(k, site, &point.q),
            (Some(t), _) => self.literal(t, &self.numbers(t, &point.q)),
            (_, Goal::Opaque(why)) => Err(self.refused(k, why)),
            _ => Err(self.refused(k, "the numbers of its target cannot be written")),
        }
    }

    /// Target of a point on the way of an arc: the numbers of a pose beside it (else those of the goal), but for its position.
    fn on_arc(&self, k: usize, m: &Move, beside: Option<&[f64]>, at_m: &[f64]) -> Result<String> {
        let Some(t) = m.goal.target() else { return Err(self.refused(k, "its arc has no numbers")) };
        let beside = beside.unwrap_or_default();
        let numbers: Vec<f64> = at_m.iter().chain(beside.get(at_m.len()..).unwrap_or_default()).copied().collect();
        self.literal(t, &self.numbers(t, &numbers))
    }

    /// The move of a step, and its place.
    fn at(&self, k: usize) -> Result<(&Move, &Self::Site)> {
        let site = self.sites().get(k).ok_or_else(|| Error::Refused(format!("step {} is no move", k + 1)))?;
        Ok((self.asked().move_at(k)?, site))
    }

    /// A refusal with the place of a step.
    fn refused(&self, k: usize, why: impl Display) -> Error {
        self.asked().refused(k, why)
    }

    /// Weight that the last digit of an axis should have at most, rad or m; NaN: no wish.
    fn digit(&self, axis: usize) -> f64 {
        self.asked().digit(axis)
    }
}

/// Numbers written where they stand.
pub fn in_place(numbers: Vec<Number>) -> impl Iterator<Item = Patch> {
    numbers.into_iter().map(|(span, new)| Patch::new(0, span, new))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::script::{Edit, Few, How, NewPoint, Step, Target};

    /// Three moves to one target, of which each wants a number or none.
    fn wanted(wishes: [Option<f64>; 3], keeps: Option<bool>) -> TargetEdit<'static> {
        let to = Move::new(How::default(), Goal::Joints(0), Few::new());
        let step = Step { at: Default::default(), kind: StepKind::Move(to) };
        let target = Target::default();
        let script = Script {
            steps: vec![step.clone(), step.clone(), step],
            targets: [target].into_iter().collect(),
            ..Script::default()
        };
        let edit = |q: f64| Edit { goal: Some(vec![q]), ..Edit::default() };
        let steps = wishes.iter().enumerate().filter_map(|(k, w)| Some((k, edit((*w)?)))).collect();
        let edits = Edits { steps, ..Edits::default() };
        // 0 is what stands there
        let numbers = |_: usize, q: &[f64]| if q[0] == 0.0 { Vec::new() } else { vec![(0..1, q[0].to_string())] };
        let mut all = Vec::new();
        let mut each = |w: TargetEdit| {
            assert!(w.alone.is_none());
            all.push(TargetEdit { alone: None, ..w });
            Ok(())
        };
        EditRequest { script: &script, edits: &edits }.wanted(&numbers, &|_| keeps, &mut each).unwrap();
        all.remove(0)
    }

    #[test]
    fn a_target_is_written_where_it_stands_only_if_all_its_moves_agree() {
        let named = wanted([Some(1.0), Some(1.0), Some(1.0)], Some(false));
        assert_eq!((named.in_place, named.clones), (vec![(0..1, "1".into())], vec![]));
        let two = wanted([Some(1.0), Some(2.0), Some(1.0)], Some(false));
        assert_eq!((two.in_place, two.clones), (vec![(0..1, "1".into())], vec![(vec![(0..1, "2".into())], vec![1])]));
        for wishes in [[Some(1.0), None, Some(1.0)], [Some(1.0), Some(0.0), Some(1.0)]] {
            let one_stays = wanted(wishes, Some(false));
            assert_eq!((one_stays.in_place, one_stays.clones), (vec![], vec![(vec![(0..1, "1".into())], vec![0, 2])]));
        }
        let read = wanted([Some(1.0), Some(1.0), Some(1.0)], Some(true));
        assert_eq!((read.in_place.len(), read.clones), (0, vec![(vec![(0..1, "1".into())], vec![0, 1, 2])]));
    }

    #[test]
    fn a_time_is_shared_out_with_the_longest_least_leg_that_fits() {
        let point = NewPoint { q: Vec::new(), share: 0.0, t_s: None, clearance_m: 0.0, of_way: false, waits: false };
        let before = [point];
        let edit = EditRef { before: &before, ..EditRef::default() };
        let time = |s: f64| (0..1, s, number::Style::default());
        assert_eq!(EditRequest::legs(edit, &time(1.0), &[0.1, 0.01], 3).unwrap(), ["0.100", "0.900"]);
        assert_eq!(EditRequest::legs(edit, &time(0.15), &[0.1, 0.01], 3).unwrap(), ["0.010", "0.140"]);
        assert_eq!(EditRequest::legs(edit, &time(0.015), &[0.1, 0.01], 3), None);
    }
}
