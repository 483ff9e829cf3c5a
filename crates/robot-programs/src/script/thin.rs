//! What few moves have, in eight bytes.

use std::fmt;
use std::ops::{Deref, DerefMut};

/// A list that is nearly always empty.
#[derive(Clone, PartialEq, Eq)]
#[allow(clippy::box_collection)] // eight bytes, where a vector has twenty-four
pub struct Few<T>(Option<Box<Vec<T>>>);

impl<T> Default for Few<T> {
    fn default() -> Self {
        Self(None)
    }
}

impl<T> Few<T> {
    /// No element.
    pub const fn new() -> Self {
        Self(None)
    }

    /// All elements.
    pub fn as_slice(&self) -> &[T] {
        self.0.as_deref().map_or(&[], Vec::as_slice)
    }

    /// An element after the others.
    pub fn push(&mut self, value: T) {
        self.0.get_or_insert_default().push(value);
    }

    /// Takes all elements out.
    pub fn clear(&mut self) {
        self.0 = None;
    }

    /// Keeps the elements for which `keep` holds.
    pub fn retain_mut(&mut self, keep: impl FnMut(&mut T) -> bool) {
        if let Some(all) = &mut self.0 {
            all.retain_mut(keep);
        }
        if self.is_empty() {
            self.0 = None;
        }
    }

    /// Keeps the elements for which `keep` holds.
    pub fn retain(&mut self, mut keep: impl FnMut(&T) -> bool) {
        self.retain_mut(|value| keep(value));
    }
}

impl<T> Deref for Few<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        self.as_slice()
    }
}

impl<T> DerefMut for Few<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        self.0.as_deref_mut().map_or(&mut [], Vec::as_mut_slice)
    }
}

impl<T> From<Vec<T>> for Few<T> {
    fn from(all: Vec<T>) -> Self {
        Self((!all.is_empty()).then(|| Box::new(all)))
    }
}

impl<T> FromIterator<T> for Few<T> {
    fn from_iter<I: IntoIterator<Item = T>>(all: I) -> Self {
        all.into_iter().collect::<Vec<T>>().into()
    }
}

impl<'a, T> IntoIterator for &'a Few<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.as_slice().iter()
    }
}

impl<'a, T> IntoIterator for &'a mut Few<T> {
    type Item = &'a mut T;
    type IntoIter = std::slice::IterMut<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter_mut()
    }
}

impl<T: fmt::Debug> fmt::Debug for Few<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.as_slice().fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_that_was_emptied_is_an_empty_one() {
        let mut few: Few<u8> = Few::new();
        few.push(1);
        few.push(2);
        few.retain(|v| *v > 1);
        assert_eq!((&*few, few.len()), (&[2][..], 1));
        few.retain(|_| false);
        assert_eq!(few, Few::default());
        assert_eq!(Few::from(vec![3, 4]).iter().sum::<u8>(), 7);
    }

    #[test]
    fn an_empty_list_is_small() {
        assert_eq!(size_of::<Few<[f64; 9]>>(), 8);
    }
}
