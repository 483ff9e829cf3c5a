//! Long lists in pieces, on several processors. What comes out does not depend on their number.

use super::patches::Patches;
use std::num::NonZero;
use std::thread;

/// Fewest items of a piece: fewer take no longer than a thread needs to start.
const LEAST: usize = 4096;
/// Most pieces.
const MOST: usize = 8;

/// What `make` makes of the pieces of a list, in their order.
pub fn in_pieces<T: Sync, U: Send>(items: &[T], make: impl Fn(&[T]) -> U + Sync) -> Vec<U> {
    let pieces = match items.len() / LEAST {
        0 | 1 => return vec![make(items)],
        most => most.min(thread::available_parallelism().map_or(1, NonZero::get)).min(MOST),
    };
    let mut pieces = items.chunks(items.len().div_ceil(pieces));
    let own = pieces.next().unwrap_or_default();
    let make = &make;
    thread::scope(|scope| {
        // where no thread can be started the work is done here
        let others: Vec<_> = pieces
            .map(|piece| thread::Builder::new().spawn_scoped(scope, move || make(piece)).map_err(|_| piece))
            .collect();
        let mut all = vec![make(own)];
        all.extend(others.into_iter().map(|other| match other.map(thread::ScopedJoinHandle::join) {
            Ok(Ok(made)) => made,
            Ok(Err(panic)) => std::panic::resume_unwind(panic),
            Err(piece) => make(piece),
        }));
        all
    })
}

/// The patches that `add` makes of the items of a list, one item after the other; `room`: where a text is put together.
pub fn patches<T: Sync>(items: &[T], add: impl Fn(&T, &mut Vec<u8>, &mut Patches) + Sync) -> Patches {
    let of_piece = |piece: &[T]| {
        let (mut room, mut out) = (Vec::new(), Patches::default());
        piece.iter().for_each(|item| add(item, &mut room, &mut out));
        out
    };
    let mut all = in_pieces(items, of_piece).into_iter();
    let mut out = all.next().unwrap_or_default();
    all.for_each(|more| out.append(more));
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_stand_in_the_order_of_the_list() {
        for n in [0, 1, LEAST, 2 * LEAST + 1, 9 * LEAST] {
            let all: Vec<usize> = (0..n).collect();
            let made: Vec<usize> = in_pieces(&all, <[usize]>::to_vec).concat();
            assert_eq!(made, all);
        }
    }

    #[test]
    fn patches_of_pieces_are_those_of_the_list() {
        let all: Vec<usize> = (0..3 * LEAST).collect();
        // every hundredth replaces more bytes than a short patch holds
        let add = |k: &usize, _: &mut Vec<u8>, out: &mut Patches| {
            let len = if k % 100 == 0 { 70_000 } else { 2 };
            out.put(0, k * 100_000..k * 100_000 + len, k.to_string().as_bytes());
        };
        let mut whole = Patches::default();
        all.iter().for_each(|k| add(k, &mut Vec::new(), &mut whole));
        let pieces = patches(&all, add);
        assert_eq!(pieces.len(), whole.len());
        assert!(pieces.iter().eq(whole.iter()) && pieces.sorted().eq(whole.sorted()));
    }
}
