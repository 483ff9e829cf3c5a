//! Joint values of one point: those of most robots stand in place, as a large program has a million points.

use std::ops::{Deref, DerefMut};

/// Axes whose values need no memory of their own.
const FEW: usize = 6;

/// Joint values, rad or m, one per axis.
#[derive(Debug, Clone)]
pub struct Joints(Held);

#[derive(Debug, Clone)]
enum Held {
    Few([f64; FEW], u8),
    Many(Box<[f64]>),
}

impl From<&[f64]> for Joints {
    fn from(q: &[f64]) -> Self {
        let mut few = [0.0; FEW];
        Self(match few.get_mut(..q.len()) {
            Some(place) => {
                place.copy_from_slice(q);
                Held::Few(few, q.len() as u8)
            }
            None => Held::Many(q.into()),
        })
    }
}

impl From<Vec<f64>> for Joints {
    fn from(q: Vec<f64>) -> Self {
        if q.len() > FEW { Self(Held::Many(q.into())) } else { Self::from(&q[..]) }
    }
}

impl FromIterator<f64> for Joints {
    fn from_iter<I: IntoIterator<Item = f64>>(all: I) -> Self {
        let (mut few, mut count) = ([0.0; FEW], 0);
        let mut all = all.into_iter();
        while let Some(q) = all.next() {
            let Some(place) = few.get_mut(count) else {
                return Self(Held::Many(few.into_iter().chain([q]).chain(all).collect()));
            };
            *place = q;
            count += 1;
        }
        Self(Held::Few(few, count as u8))
    }
}

impl Deref for Joints {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        match &self.0 {
            Held::Few(all, count) => &all[..usize::from(*count)],
            Held::Many(all) => all,
        }
    }
}

impl DerefMut for Joints {
    fn deref_mut(&mut self) -> &mut [f64] {
        match &mut self.0 {
            Held::Few(all, count) => &mut all[..usize::from(*count)],
            Held::Many(all) => all,
        }
    }
}

impl<'a> IntoIterator for &'a Joints {
    type Item = &'a f64;
    type IntoIter = std::slice::Iter<'a, f64>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_come_back_however_many_there_are() {
        for count in 0..10 {
            let all: Vec<f64> = (0..count).map(f64::from).collect();
            assert_eq!(*Joints::from(&all[..]), all[..]);
            assert_eq!(*all.iter().copied().collect::<Joints>(), all[..]);
            assert_eq!(*Joints::from(all.clone()), all[..]);
        }
    }
}
