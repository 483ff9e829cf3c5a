//! Edits by step, in columns: goals one after the other, and a list of what few edits have beside them.

use super::{Edit, EditRef, NewPoint};

/// Nothing stands there.
const NONE: u32 = u32::MAX;

/// Edits by step.
#[derive(Debug, Clone, Default)]
pub struct StepEdits {
    /// By step; steps after the last have none.
    rows: Vec<Row>,
    /// How many rows are edits.
    count: usize,
    goals: Vec<f64>,
    rest: Vec<Rest>,
}

#[derive(Debug, Clone, Copy)]
struct Row {
    /// First value of its goal; [`NONE`]: it has none.
    goal: u32,
    /// Values of its goal.
    len: u16,
    edited: bool,
    /// What else is asked; [`NONE`]: nothing.
    rest: u32,
}

const STAYS: Row = Row { goal: NONE, len: 0, edited: false, rest: NONE };

/// An edit without its goal.
#[derive(Debug, Clone, Default)]
struct Rest {
    before: Vec<NewPoint>,
    blend_at_most_m: Option<f64>,
    as_joint_moves: bool,
    vias: Vec<Vec<f64>>,
}

impl StepEdits {
    /// With memory for edits of so many steps and so many values of their goals.
    pub fn with_capacity(steps: usize, values: usize) -> Self {
        Self { rows: Vec::with_capacity(steps), goals: Vec::with_capacity(values), ..Self::default() }
    }

    /// How many patches they may make, beside those of new points: one for each value of a goal and one for each move.
    pub fn likely_patches(&self) -> usize {
        self.goals.len() + self.count
    }

    /// How many steps are edited.
    pub fn len(&self) -> usize {
        self.count
    }

    /// No step is edited.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Whether a step is edited.
    pub fn contains(&self, step: usize) -> bool {
        self.row(step).is_some()
    }

    #[inline]
    fn row(&self, step: usize) -> Option<&Row> {
        self.rows.get(step).filter(|row| row.edited)
    }

    /// The edit of a step.
    #[inline]
    pub fn get(&self, step: usize) -> Option<EditRef<'_>> {
        self.row(step).map(|row| self.shown(row))
    }

    #[inline]
    fn shown(&self, row: &Row) -> EditRef<'_> {
        let from = row.goal as usize;
        let goal = self.goals.get(from..from + usize::from(row.len)).filter(|_| row.goal != NONE);
        let Some(rest) = self.rest.get(row.rest as usize) else { return EditRef { goal, ..EditRef::default() } };
        let Rest { before, blend_at_most_m, as_joint_moves, vias } = rest;
        EditRef { before, goal, blend_at_most_m: *blend_at_most_m, as_joint_moves: *as_joint_moves, vias }
    }

    /// All edits in the order of their steps.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = (usize, EditRef<'_>)> {
        self.rows.iter().enumerate().filter(|(_, row)| row.edited).map(|(step, row)| (step, self.shown(row)))
    }

    /// The last edited step that is no later than `step`.
    pub fn last_until(&self, step: usize) -> Option<usize> {
        let until = self.rows.len().min(step.saturating_add(1));
        self.rows.get(..until)?.iter().rposition(|row| row.edited)
    }

    /// The edit of a step, instead of any that it has.
    pub fn insert(&mut self, step: usize, edit: Edit) {
        let own = self.rows.get(step).copied().unwrap_or(STAYS);
        let mut row = Row { edited: true, len: 0, goal: NONE, rest: NONE };
        if let Some(goal) = &edit.goal {
            row.len = goal.len() as u16;
            let there = own.goal as usize..own.goal as usize + usize::from(own.len);
            match self.goals.get_mut(there).filter(|there| own.goal != NONE && there.len() == goal.len()) {
                Some(there) => {
                    there.copy_from_slice(goal);
                    row.goal = own.goal;
                }
                None => {
                    row.goal = self.goals.len() as u32;
                    self.goals.extend_from_slice(goal);
                }
            }
        }
        let has_rest = edit.has_rest();
        let Edit { before, blend_at_most_m, as_joint_moves, vias, .. } = edit;
        let rest = Rest { before, blend_at_most_m, as_joint_moves, vias };
        match self.rest.get_mut(own.rest as usize) {
            Some(there) => {
                *there = rest;
                row.rest = own.rest;
            }
            None if has_rest => {
                row.rest = self.rest.len() as u32;
                self.rest.push(rest);
            }
            None => {}
        }
        if step >= self.rows.len() {
            self.rows.resize(step + 1, STAYS);
        }
        self.count += usize::from(!own.edited);
        if let Some(place) = self.rows.get_mut(step) {
            *place = row;
        }
    }

    /// The edit of a step that has none so far: another goal, and nothing else.
    pub fn insert_goal(&mut self, step: usize, goal: &[f64]) {
        if self.rows.get(step).is_some_and(|row| row.edited || row.goal != NONE || row.rest != NONE) {
            return self.insert(step, Edit { goal: Some(goal.to_vec()), ..Edit::default() });
        }
        if step >= self.rows.len() {
            self.rows.resize(step + 1, STAYS);
        }
        let row = Row { edited: true, goal: self.goals.len() as u32, len: goal.len() as u16, rest: NONE };
        self.goals.extend_from_slice(goal);
        self.count += 1;
        if let Some(place) = self.rows.get_mut(step) {
            *place = row;
        }
    }

    /// Takes the edit of a step out: the step stays as it is.
    pub fn remove(&mut self, step: usize) -> Option<Edit> {
        let edit = Edit::from(self.get(step)?);
        let row = self.rows.get_mut(step)?;
        if let Some(rest) = self.rest.get_mut(row.rest as usize) {
            *rest = Rest::default();
        }
        // the places stay its own, for the next edit of this step
        row.edited = false;
        self.count -= 1;
        Some(edit)
    }

    /// Changes the edit of a step; nothing where it has none.
    pub fn change(&mut self, step: usize, change: impl FnOnce(&mut Edit)) {
        if let Some(mut edit) = self.remove(step) {
            change(&mut edit);
            self.insert(step, edit);
        }
    }

    /// Changes the edit of a step, which is made where it has none.
    pub fn change_or_insert(&mut self, step: usize, change: impl FnOnce(&mut Edit)) {
        let mut edit = self.remove(step).unwrap_or_default();
        change(&mut edit);
        self.insert(step, edit);
    }

    /// Changes all edits, and takes those out for which `keep` does not hold.
    pub fn retain(&mut self, mut keep: impl FnMut(usize, &mut Edit) -> bool) {
        for step in 0..self.rows.len() {
            if let Some(mut edit) = self.remove(step)
                && keep(step, &mut edit)
            {
                self.insert(step, edit);
            }
        }
    }
}

impl FromIterator<(usize, Edit)> for StepEdits {
    fn from_iter<I: IntoIterator<Item = (usize, Edit)>>(all: I) -> Self {
        let mut edits = Self::default();
        for (step, edit) in all {
            edits.insert(step, edit);
        }
        edits
    }
}

impl<const N: usize> From<[(usize, Edit); N]> for StepEdits {
    fn from(all: [(usize, Edit); N]) -> Self {
        all.into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    fn edit() -> impl Strategy<Value = Edit> {
        let q = || proptest::collection::vec(-3.0..3.0, 3..8);
        let point =
            q().prop_map(|q| NewPoint { q, share: 0.5, t_s: None, clearance_m: 0.1, of_way: false, waits: false });
        let points = proptest::collection::vec(point, 0..3);
        (proptest::option::of(q()), points, proptest::option::of(0.0..1.0), any::<bool>()).prop_map(
            |(goal, before, blend_at_most_m, as_joint_moves)| Edit {
                before,
                goal,
                blend_at_most_m,
                as_joint_moves,
                vias: Vec::new(),
            },
        )
    }

    proptest! {
        /// As a map from steps to edits does.
        #[test]
        fn edits_are_kept_by_step(work in proptest::collection::vec((0usize..12, proptest::option::weighted(0.7, edit())), 0..40), until in 0usize..14) {
            let (mut map, mut edits) = (BTreeMap::new(), StepEdits::default());
            for (step, edit) in work {
                match edit {
                    Some(edit) => {
                        map.insert(step, edit.clone());
                        match (&edit.goal, edit.has_rest()) {
                            (Some(goal), false) => edits.insert_goal(step, goal),
                            _ => edits.insert(step, edit),
                        }
                    }
                    None => prop_assert_eq!(map.remove(&step), edits.remove(step)),
                }
            }
            let change = |e: &mut Edit| e.goal = Some(vec![1.0]);
            if let Some(e) = map.get_mut(&3) {
                change(e);
            }
            edits.change(3, change);
            map.entry(4).or_default().blend_at_most_m = Some(2.0);
            edits.change_or_insert(4, |e| e.blend_at_most_m = Some(2.0));
            map.retain(|k, e| { e.vias.push(vec![*k as f64]); k % 3 != 1 });
            edits.retain(|k, e| { e.vias.push(vec![k as f64]); k % 3 != 1 });
            prop_assert_eq!(edits.last_until(until), map.range(..=until).next_back().map(|e| *e.0));
            prop_assert_eq!((edits.len(), edits.is_empty()), (map.len(), map.is_empty()));
            let all: BTreeMap<usize, Edit> = edits.iter().map(|(k, e)| (k, e.into())).collect();
            prop_assert_eq!(all, map);
        }
    }
}
