//! Values of some steps, in the order of the steps.

use super::Text;

/// Values that are looked at before the place of a step is searched for.
const NEAR: usize = 4;

/// Values of some steps, in the order of the steps.
#[derive(Debug)]
pub struct BySteps<T>(Vec<(u32, T)>);

impl<T> Default for BySteps<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> BySteps<T> {
    /// With memory for the steps of a text.
    pub fn of_text(text: &Text) -> Self {
        Self(Vec::with_capacity(text.likely_steps()))
    }

    /// The value of a step after those that have one.
    pub fn push(&mut self, step: usize, value: T) {
        self.0.push((step as u32, value));
    }

    /// The value of a step.
    #[inline]
    pub fn get(&self, step: usize) -> Option<&T> {
        // few steps have no value, so that it stands not far before its step
        let until = self.0.get(..=step.min(self.0.len().checked_sub(1)?))?;
        let near = until.iter().rev().take(NEAR).find(|v| v.0 as usize <= step);
        if let Some(near) = near {
            return (near.0 as usize == step).then_some(&near.1);
        }
        let k = until.binary_search_by_key(&step, |v| v.0 as usize).ok()?;
        until.get(k).map(|v| &v.1)
    }

    /// The value that was pushed last.
    pub fn last(&self) -> Option<&T> {
        self.0.last().map(|v| &v.1)
    }

    /// All values with their steps.
    pub fn iter(&self) -> impl Iterator<Item = (usize, &T)> {
        self.0.iter().map(|v| (v.0 as usize, &v.1))
    }

    /// All values.
    pub fn values(&self) -> impl Iterator<Item = &T> {
        self.0.iter().map(|v| &v.1)
    }

    /// What is made of each value, for the steps where there is something.
    pub fn filter_map<U>(self, mut make: impl FnMut(T) -> Option<U>) -> BySteps<U> {
        BySteps(self.0.into_iter().filter_map(|(step, value)| Some((step, make(value)?))).collect())
    }

    /// The one before the last.
    pub fn before_last(&self) -> Option<&T> {
        self.0.get(self.0.len().checked_sub(2)?).map(|v| &v.1)
    }

    /// The last one before a step.
    pub fn before(&self, step: usize) -> Option<&T> {
        let k = self.0.partition_point(|v| (v.0 as usize) < step);
        self.0.get(k.checked_sub(1)?).map(|v| &v.1)
    }

    /// The first one after a step.
    pub fn after(&self, step: usize) -> Option<&T> {
        self.0.get(self.0.partition_point(|v| v.0 as usize <= step)).map(|v| &v.1)
    }

    /// Steps have moved: each value stands at the step that `to` gives.
    pub(super) fn renumber(&mut self, to: impl Fn(usize) -> usize) {
        self.0.iter_mut().for_each(|value| value.0 = to(value.0 as usize) as u32);
    }
}
