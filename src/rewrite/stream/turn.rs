//! Workers that do a station's work in the order of their numbers.
//!
//! A worker waits until every number before its own has passed; then it alone holds what the station works on. Where a worker
//! fails, those with larger numbers are sent home and those with smaller ones finish, so that the first failure in the order of
//! the program is the one that is reported, whatever the number of threads.

use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// What the workers take turns at.
pub struct Turn<T> {
    state: Mutex<State<T>>,
    moved: Condvar,
}

struct State<T> {
    /// Whose turn it is.
    next: u64,
    /// Larger numbers have no turn any more.
    last: u64,
    work: T,
}

impl<T> Turn<T> {
    pub fn new(work: T) -> Self {
        Self { state: Mutex::new(State { next: 0, last: u64::MAX, work }), moved: Condvar::new() }
    }

    fn lock(&self) -> MutexGuard<'_, State<T>> {
        // a worker that panics closes every turn: nothing half done is used
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does `work` when it is the turn of `number`, then hands on; `None`: there is no such turn any more. Where the work fails, nobody
    /// after it has a turn.
    pub fn take<R, E>(&self, number: u64, work: impl FnOnce(&mut T) -> Result<R, E>) -> Option<Result<R, E>> {
        let waiting = |s: &mut State<T>| s.next != number && number <= s.last;
        let mut state = self.moved.wait_while(self.lock(), waiting).unwrap_or_else(PoisonError::into_inner);
        if number > state.last {
            return None;
        }
        let done = work(&mut state.work);
        match done {
            Ok(_) => state.next += 1,
            Err(_) => state.last = state.last.min(number),
        }
        drop(state);
        self.moved.notify_all();
        Some(done)
    }

    /// Takes the turn after `number` from everybody.
    pub fn close_after(&self, number: u64) {
        let mut state = self.lock();
        state.last = state.last.min(number);
        drop(state);
        self.moved.notify_all();
    }

    pub fn into_inner(self) -> T {
        self.state.into_inner().unwrap_or_else(PoisonError::into_inner).work
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU64, Ordering};

    #[test]
    fn turns_are_taken_in_order_by_any_number_of_workers() {
        for workers in [1, 2, 7] {
            let (turn, tickets) = (Turn::new(Vec::new()), AtomicU64::new(0));
            std::thread::scope(|scope| {
                for _ in 0..workers {
                    scope.spawn(|| {
                        loop {
                            let number = tickets.fetch_add(1, Ordering::Relaxed);
                            if number >= 500
                                || turn
                                    .take(number, |list| {
                                        list.push(number);
                                        Ok::<(), ()>(())
                                    })
                                    .is_none()
                            {
                                return;
                            }
                        }
                    });
                }
            });
            assert_eq!(turn.into_inner(), (0..500).collect::<Vec<u64>>());
        }
    }

    #[test]
    fn a_turn_that_is_closed_sends_larger_numbers_home_and_lets_smaller_ones_finish() {
        let turn = Turn::new(0);
        let add = |n: &mut i32| -> Result<(), ()> {
            *n += 1;
            Ok(())
        };
        std::thread::scope(|scope| {
            let late = scope.spawn(|| turn.take(5, |_| Ok::<(), ()>(())));
            turn.close_after(2);
            assert_eq!(late.join().unwrap(), None);
            for number in 0..3 {
                assert_eq!(turn.take(number, add), Some(Ok(())));
            }
            assert_eq!(turn.take(3, add), None);
        });
        assert_eq!(turn.into_inner(), 3);
    }

    #[test]
    fn nobody_has_a_turn_after_work_that_failed() {
        let turn = Turn::new(());
        std::thread::scope(|scope| {
            let late: Vec<_> = (1..5)
                .map(|n| {
                    scope.spawn({
                        let turn = &turn;
                        move || turn.take(n, |_| Ok::<(), ()>(()))
                    })
                })
                .collect();
            assert_eq!(turn.take(0, |_| Err::<(), ()>(())), Some(Err(())));
            for late in late {
                assert_eq!(late.join().unwrap(), None);
            }
        });
    }
}
