//! Maps over all processors. Results stand in the order of their indices, whatever the number of threads.
//!
//! The scheduling (`rayon`) is compiled once, here, for all of them: a parallel iterator at each place is a tenth of the code of the
//! command otherwise. Each index costs a lock that nobody waits for (about 20 ns), so let `f` do more than that: take numbers in pieces.

use rayon::prelude::*;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// `f(0), f(1), .. f(n - 1)`.
fn map<T: Send>(n: usize, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let slots: Vec<Mutex<Option<T>>> = (0..n).map(|_| Mutex::new(None)).collect();
    each(n, &|k| {
        let value = f(k);
        *slots[k].lock().unwrap_or_else(PoisonError::into_inner) = Some(value);
    });
    slots.into_iter().filter_map(|slot| slot.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
}

/// What a function can be applied to on all processors.
pub trait ParMap<'a> {
    /// What the function takes.
    type Item;

    /// The function of each item, in their order.
    fn par_map<T: Send>(&'a self, f: impl Fn(Self::Item) -> T + Sync) -> Vec<T>;
}

impl<'a, A: Sync + 'a> ParMap<'a> for [A] {
    type Item = &'a A;

    fn par_map<T: Send>(&'a self, f: impl Fn(&'a A) -> T + Sync) -> Vec<T> {
        map(self.len(), |k| f(&self[k]))
    }
}

impl<'a> ParMap<'a> for Range<usize> {
    type Item = usize;

    fn par_map<T: Send>(&'a self, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
        map(self.len(), |k| f(self.start + k))
    }
}

/// `f` of each item, which it takes, in their order.
pub fn of_each<A: Send, T: Send>(items: Vec<A>, f: impl Fn(A) -> T + Sync) -> Vec<T> {
    let items: Vec<Mutex<Option<A>>> = items.into_iter().map(|item| Mutex::new(Some(item))).collect();
    let take = |k: usize| items[k].lock().unwrap_or_else(PoisonError::into_inner).take();
    map(items.len(), |k| take(k).map(&f)).into_iter().flatten().collect()
}

/// `f(k, &mut items[k])` for each item.
pub fn change<A: Send>(items: &mut [A], f: impl Fn(usize, &mut A) + Sync) {
    let items: Vec<Mutex<&mut A>> = items.iter_mut().map(Mutex::new).collect();
    each(items.len(), &|k| f(k, &mut items[k].lock().unwrap_or_else(PoisonError::into_inner)));
}

/// `f(k, piece)` for pieces of `size` items, of which the last may be shorter; `k` counts the pieces. A size of 0 is 1.
pub fn change_pieces<A: Send>(items: &mut [A], size: usize, f: impl Fn(usize, &mut [A]) + Sync) {
    let mut pieces: Vec<&mut [A]> = items.chunks_mut(size.max(1)).collect();
    change(&mut pieces, |k, piece| f(k, piece));
}

/// Number of threads that share the work.
#[must_use]
pub fn threads() -> usize {
    rayon::current_num_threads()
}

/// The pieces of `0..n` of `size` indices, of which the last may be shorter. A size of 0 is 1.
pub fn pieces(n: usize, size: usize) -> Vec<Range<usize>> {
    let size = size.max(1);
    (0..n.div_ceil(size)).map(|k| k * size..((k + 1) * size).min(n)).collect()
}

/// [`ParMap::par_map`] over `0..n` of a value that others wait for, as in a `OnceLock`: on this thread alone where it works for a map
/// already. A thread of the pool that waits for the rest of its map takes up other work, which may wait for this very value.
pub fn map_awaited<T: Send>(n: usize, f: impl Fn(usize) -> T + Sync) -> Vec<T> {
    if rayon::current_thread_index().is_some() { (0..n).map(f).collect() } else { map(n, f) }
}

fn each(n: usize, run: &(dyn Fn(usize) + Sync)) {
    if n == 1 {
        return run(0);
    }
    (0..n).into_par_iter().for_each(run);
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::OnceLock;

    #[test]
    fn a_value_that_all_threads_wait_for_is_found_within_a_map() {
        let work = |k: usize| (0..20_000).fold(k, |a, b| a.wrapping_mul(31).wrapping_add(b));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap();
        pool.install(|| {
            for _ in 0..100 {
                let value = OnceLock::new();
                let all = (0..16).par_map(|_| value.get_or_init(|| map_awaited(64, work)).len());
                assert_eq!(all, [64; 16]);
            }
        });
    }

    #[test]
    fn results_stand_in_the_order_of_their_indices() {
        assert_eq!((0..1000).par_map(|k| k * k), (0..1000).map(|k| k * k).collect::<Vec<_>>());
        let words: Vec<String> = (0..100).map(|k| k.to_string()).collect();
        assert_eq!(words.par_map(String::len).iter().sum::<usize>(), 190);
        assert_eq!(of_each(words.clone(), |w| w + "!")[7], "7!");
        let mut numbers = vec![0; 10];
        change_pieces(&mut numbers, 4, |k, piece| piece.fill(k));
        change(&mut numbers, |k, number| *number += 10 * k);
        assert_eq!(numbers, [0, 10, 20, 30, 41, 51, 61, 71, 82, 92]);
        assert_eq!(((5..7).par_map(|k| k)[0], pieces(10, 4)), (5, vec![0..4, 4..8, 8..10]));
    }
}
