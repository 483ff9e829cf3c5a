//! Command of a stroke whose friction responds to it ([`crate::effects::response`]).
//!
//! What friction does depends on the command, and the command on what friction does: both are found alternately, each time halfway
//! to what the last command asks for. What does not depend on the command (the wind-up, and by how much a spike fades from node to
//! node) is worked out once ([`Along::lay`]). A round then needs one `exp` for each node up to where friction has turned over to the
//! last bit, and none after it.
//!
//! Where the command rises all the way, it needs no isotonic fit: it is what friction, gap and travel add up to.
//!
//! Nodes stand in columns, and several are worked out at once; only what one node hands to the next (`z` and the spikes) goes one by
//! one. The last node is repeated until the columns are whole.

use super::{Place, RESPONSE_PASSES, SETTLED, Work};
use crate::compensator::response::{MOST_SPIKES, MOST_WINDUPS, State};
use crate::compensator::{Response, Spike};
use crate::numerics::fading::{LANES, fade};
use crate::rewrite::stroke::{Node, hold};

/// Spans of time that differ by no more than this share of the time since the turn are one span: the nodes of a leg are evenly
/// spaced, and their times are rounded.
const SAME_SPAN: f64 = 4.0 * f64::EPSILON;
/// Friction that is nearer to having turned over than this has turned over: nothing beside 1.
const TURNED: f64 = f64::EPSILON / 4.0;

/// What of a stroke does not depend on its command, and what a round changes; a value for each node.
#[derive(Debug, Default)]
pub(super) struct Along {
    /// Travel and half gap of the joint, rad or m.
    base: Vec<f64>,
    /// Wind-up, rad or m.
    wound: Vec<f64>,
    /// What is left of each spike since the node before, and of a change that is spread over that time.
    fade: [Vec<f64>; MOST_SPIKES],
    share: [Vec<f64>; MOST_SPIKES],
    /// The wind-up at the last node, as a state has it.
    z_joint: [f64; MOST_WINDUPS],
    /// Where the command of the last round stands, the first node twice.
    way: Vec<f64>,
    /// Friction that is left.
    friction: Vec<f64>,
    /// The command.
    command: Vec<f64>,
}

/// The spikes in use, one after the other.
#[derive(Debug, Clone, Copy, Default)]
struct Spikes {
    count: usize,
    place: [usize; MOST_SPIKES],
    spike: [Spike; MOST_SPIKES],
}

impl Spikes {
    fn of(r: &Response) -> Self {
        let mut used = Self::default();
        for (place, s) in r.spikes.iter().enumerate().filter(|(_, s)| s.gain != 0.0) {
            used.place[used.count] = place;
            used.spike[used.count] = *s;
            used.count += 1;
        }
        used
    }
}

/// Command of a stroke whose friction responds, into `work`, whose friction at each node it changes, too. Returns the state of
/// friction at the end of the stroke.
pub(super) fn respond(r: &Response, before: &State, start: f64, first: usize, work: &mut Work) -> State {
    let (n, spikes) = (work.machine.len(), Spikes::of(r));
    let along = &mut work.along;
    along.lay(r, &spikes, before, &work.nodes, &work.machine);
    let settled = SETTLED * (r.gain() + r.windup().abs());
    let mut last = *before;
    let mut known = work.command.len() == n;
    for _ in 0..RESPONSE_PASSES {
        along.follow(start, first, &work.nodes, &work.machine, known.then_some(&work.command));
        let round = Round { r, windup: r.windup(), spikes: &spikes, before, along, known };
        let (state, moved) = pulp::Arch::new().dispatch(round);
        work.command.clear();
        work.command.extend_from_slice(&along.command[..n]);
        let pairs = work.command[first..].iter().zip(&work.command[first + 1..]);
        // no short cut: nearly all commands rise
        if !pairs.fold(true, |rises, (a, b)| rises & (a <= b)) {
            hold(&work.machine, first, &mut work.command, &mut work.fall);
        }
        (last, known) = (state, true);
        if moved <= settled {
            break;
        }
    }
    for (node, friction) in work.machine.iter_mut().zip(&along.friction) {
        node.friction = *friction;
    }
    State { z_joint: along.z_joint, ..last }
}

/// Makes a column of the values, the last one repeated until it is whole.
fn fill(column: &mut Vec<f64>, values: impl Iterator<Item = f64>) {
    column.clear();
    column.extend(values);
    let last = column.last().copied().unwrap_or(0.0);
    column.resize(column.len().next_multiple_of(LANES), last);
}

impl Along {
    /// Works out what does not depend on the command.
    fn lay(&mut self, r: &Response, spikes: &Spikes, before: &State, nodes: &[Place], machine: &[Node]) {
        fill(&mut self.base, machine.iter().map(|m| m.travel + m.gap));
        fill(&mut self.friction, machine.iter().map(|m| m.friction));
        let whole = self.base.len();
        self.command.resize(whole, 0.0);
        for (k, spike) in spikes.spike[..spikes.count].iter().enumerate() {
            let (fade, share) = (&mut self.fade[k], &mut self.share[k]);
            for column in [&mut *fade, &mut *share] {
                column.clear();
                column.push(1.0);
            }
            let (mut span_s, mut fades) = (f64::NAN, [1.0; 2]);
            for pair in nodes.windows(2) {
                let dt_s = (pair[1].since_s - pair[0].since_s).max(0.0);
                let same = (dt_s - span_s).abs() <= SAME_SPAN * pair[1].since_s;
                if !same {
                    (span_s, fades) = (dt_s, spike.fades(dt_s));
                }
                fade.push(fades[0]);
                share.push(fades[1]);
            }
            // nothing fades between nodes that are one
            fade.resize(whole, 1.0);
            share.resize(whole, 1.0);
        }
        self.wound.clear();
        self.wound.resize(whole, 0.0);
        // travel of the joint, as long as no command is asked for
        self.go(machine.iter().map(|m| m.travel));
        self.z_joint = before.z_joint;
        for (w, z) in r.windups.iter().zip(&mut self.z_joint).filter(|(w, _)| w.half != 0.0) {
            let winding = Winding { half: w.half, over: w.presliding, z: *z, way: &self.way, wound: &mut self.wound };
            *z = pulp::Arch::new().dispatch(winding);
        }
    }

    /// Writes down where the command stands at each node; before it is known, it is what the joint is to do.
    fn follow(&mut self, start: f64, first: usize, nodes: &[Place], machine: &[Node], command: Option<&Vec<f64>>) {
        let Some(command) = command else { return self.go(machine.iter().map(|m| m.travel)) };
        self.go(command.iter().copied());
        let (u0, u1, level) = (nodes[0].u, nodes[first].u, command[first]);
        for (way, node) in self.way[1..=first].iter_mut().zip(nodes) {
            *way = start + (level - start) * (node.u - u0) / (u1 - u0).max(f64::MIN_POSITIVE);
        }
        self.way[0] = self.way[1];
    }

    /// Makes the way of the values.
    fn go(&mut self, values: impl Iterator<Item = f64>) {
        let whole = self.base.len() + 1;
        self.way.clear();
        self.way.push(0.0);
        self.way.extend(values);
        let last = self.way.last().copied().unwrap_or(0.0);
        self.way.resize(whole, last);
        self.way[0] = self.way[1];
    }
}

/// How much is left of what turns over by a factor e over the travel `over`, from each place of the `way` to the next.
#[inline(always)]
fn left(way: &[f64], over: f64) -> [f64; LANES] {
    let mut left = [0.0; LANES];
    for (left, (now, before)) in left.iter_mut().zip(way.iter().skip(1).zip(way)) {
        *left = -(now - before).max(0.0) / over;
    }
    fade(&mut left);
    left
}

/// A part of the wind-up from `z` on, along the way of the joint, added to that of the nodes; gives `z` at the last node.
struct Winding<'a> {
    half: f64,
    over: f64,
    z: f64,
    way: &'a [f64],
    wound: &'a mut [f64],
}

impl pulp::NullaryFnOnce for Winding<'_> {
    type Output = f64;

    // inlined, so that it is compiled for the registers that there are
    #[inline(always)]
    fn call(self) -> f64 {
        let mut short = self.z - 1.0;
        let chunks = self.wound.as_chunks_mut::<LANES>().0;
        for (wound, way) in chunks.iter_mut().zip(self.way.windows(LANES + 1).step_by(LANES)) {
            let mut shorts = [0.0; LANES];
            if short.abs() > TURNED {
                let left = left(way, self.over);
                for i in 0..LANES {
                    short *= left[i];
                    shorts[i] = short;
                }
            }
            for i in 0..LANES {
                wound[i] += self.half * (1.0 + shorts[i]);
            }
        }
        1.0 + short
    }
}

/// One round: what friction does for the command of [`Along::way`], halfway to it, and the command that this asks for. Gives
/// friction at the last node, without the wind-up, and the largest change of friction at a node.
struct Round<'a> {
    r: &'a Response,
    windup: f64,
    spikes: &'a Spikes,
    before: &'a State,
    along: &'a mut Along,
    /// There was a round before.
    known: bool,
}

impl pulp::NullaryFnOnce for Round<'_> {
    type Output = (State, f64);

    // inlined, so that it is compiled for the registers that there are
    #[inline(always)]
    fn call(self) -> (State, f64) {
        match self.spikes.count {
            0 => self.pass::<0>(),
            1 => self.pass::<1>(),
            2 => self.pass::<2>(),
            _ => self.pass::<MOST_SPIKES>(),
        }
    }
}

impl Round<'_> {
    #[inline(always)]
    fn pass<const SPIKES: usize>(self) -> (State, f64) {
        let Self { r, windup, spikes, before, along, known } = self;
        let mut h: [f64; SPIKES] = std::array::from_fn(|k| before.h[spikes.place[k]]);
        let gain: [f64; SPIKES] = std::array::from_fn(|k| spikes.spike[k].gain);
        let mut short = before.z - 1.0;
        let mut moved = [0.0; LANES];
        let (fades, shares) = (chunks_of::<SPIKES>(&along.fade), chunks_of::<SPIKES>(&along.share));
        let friction = along.friction.as_chunks_mut::<LANES>().0.iter_mut();
        let command = along.command.as_chunks_mut::<LANES>().0.iter_mut();
        let fixed = along.wound.as_chunks::<LANES>().0.iter().zip(along.base.as_chunks::<LANES>().0);
        let ways = along.way.windows(LANES + 1).step_by(LANES);
        for (c, (((friction, command), (wound, base)), way)) in friction.zip(command).zip(fixed).zip(ways).enumerate() {
            let mut turn = [0.0; LANES];
            // friction that has turned over stays so: nothing is spread over a step any more
            if short.abs() > TURNED {
                let left = left(way, r.presliding);
                for i in 0..LANES {
                    let next = short * left[i];
                    (turn[i], short) = (next - short, next);
                }
            }
            let mut spike = [0.0; LANES];
            for k in 0..SPIKES {
                let (fade, share) = (&fades[k][c], &shares[k][c]);
                let mut now = [0.0; LANES];
                for i in 0..LANES {
                    h[k] = h[k] * fade[i] + turn[i] * share[i];
                    now[i] = h[k];
                }
                for i in 0..LANES {
                    spike[i] += gain[k] * now[i];
                }
            }
            for i in 0..LANES {
                let now = wound[i] + spike[i] - windup;
                let next = if known { 0.5 * (friction[i] + now) } else { now };
                let by = (next - friction[i]).abs();
                moved[i] = if by > moved[i] { by } else { moved[i] };
                friction[i] = next;
                command[i] = base[i] + next;
            }
        }
        let mut state = State { z: 1.0 + short, ..*before };
        for k in 0..SPIKES {
            state.h[spikes.place[k]] = h[k];
        }
        let moved = if known { moved.into_iter().fold(0.0, f64::max) } else { f64::INFINITY };
        (state, moved)
    }
}

/// The first columns, several values at once.
#[inline(always)]
fn chunks_of<const SPIKES: usize>(columns: &[Vec<f64>; MOST_SPIKES]) -> [&[[f64; LANES]]; SPIKES] {
    std::array::from_fn(|k| columns[k].as_chunks::<LANES>().0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compensator::Windup;
    use proptest::prelude::*;

    /// The same by steps one by one ([`Response::advance`]), each round with the isotonic fit of all nodes.
    fn one_by_one(r: &Response, before: &State, start: f64, first: usize, work: &mut Work) -> State {
        let n = work.machine.len();
        let settled = SETTLED * (r.gain() + r.windup().abs());
        let mut last = *before;
        for _ in 0..RESPONSE_PASSES {
            let known = work.command.len() == n;
            let (u0, u1) = (work.nodes[0].u, work.nodes[first].u);
            let way = |k: usize| match known {
                false => work.machine[k].travel,
                true if k < first => start + (work.command[first] - start) * (work.nodes[k].u - u0) / (u1 - u0),
                true => work.command[k],
            };
            let mut state = *before;
            let mut back = vec![r.back(&state)];
            for k in 1..n {
                let joint = work.machine[k].travel - work.machine[k - 1].travel;
                let dt_s = work.nodes[k].since_s - work.nodes[k - 1].since_s;
                state = r.advance(&state, way(k) - way(k - 1), joint, dt_s);
                back.push(r.back(&state));
            }
            let mut moved = if known { 0.0 } else { f64::INFINITY };
            for (m, back) in work.machine.iter_mut().zip(&back) {
                let now = back - r.windup();
                let next = if known { 0.5 * (m.friction + now) } else { now };
                moved = f64::max(moved, (next - m.friction).abs());
                m.friction = next;
            }
            crate::rewrite::stroke::solve(&work.machine, first, false, &mut work.command, &mut work.fall);
            last = state;
            if moved <= settled {
                break;
            }
        }
        last
    }

    /// A stroke of legs with evenly spaced nodes.
    fn stroke(legs: &[(usize, f64, f64)], first: usize, gap: f64) -> Work {
        let mut work = Work::default();
        let (mut p, mut since_s, mut u) = (0.0, 0.0, 0.0);
        let mut add = |p: f64, since_s: f64, u: f64| {
            work.nodes.push(Place { vertex: 0, share: 0.0, p, since_s, u });
            work.machine.push(Node { travel: p, gap, friction: 0.0 });
        };
        add(p, since_s, u);
        for &(parts, travel, duration_s) in legs {
            for m in 1..=parts {
                let share = m as f64 / parts as f64;
                add(p + share * travel, since_s + share * duration_s, u + share);
            }
            (p, since_s, u) = (p + travel, since_s + duration_s, u + 1.0);
        }
        assert!(first < work.nodes.len());
        work
    }

    proptest! {
        #[test]
        fn a_stroke_is_that_of_steps_one_by_one(
            legs in prop::collection::vec((1usize..30, 0.0..4e-4f64, 0.004..3.0f64), 1..8),
            first in 0usize..3, used in 0usize..4, wound in 0usize..4, gap in 0.0..5e-5f64, z in -1.0..1.0f64,
            h in -1.0..1.0f64, scale in -5.0..-3.0f64
        ) {
            let size = 10f64.powf(scale);
            let mut r = Response { presliding: 0.3 * size, ..Response::default() };
            for k in 0..used {
                r.spikes[k] = Spike { gain: size * [0.1, 0.4, -0.05][k], decay_s: [0.4, 1.2, 3.6][k] };
            }
            for k in 0..wound {
                r.windups[k] = Windup { half: size * [0.05, 0.1, 0.02][k], presliding: size * [0.1, 0.3, 0.9][k] };
            }
            let before = State { z, h: [h, -h, 0.3 * h], z_joint: [z, -z, 0.5 * z] };
            let first = first.min(legs.iter().map(|l| l.0).sum());
            let (mut fast, mut slow) = (stroke(&legs, first, gap), stroke(&legs, first, gap));
            let is = respond(&r, &before, -gap, first, &mut fast);
            let want = one_by_one(&r, &before, -gap, first, &mut slow);
            // far below the last digit that a program can have, 1e-9 deg
            let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * size;
            for (k, (is, want)) in fast.command[first..].iter().zip(&slow.command[first..]).enumerate() {
                prop_assert!(near(*is, *want), "node {k}: {is} for {want}");
            }
            prop_assert!((is.z - want.z).abs() < 1e-12);
            for k in 0..MOST_SPIKES {
                prop_assert!((is.h[k] - want.h[k]).abs() < 1e-10 || k >= used, "spike {k}");
                prop_assert!((is.z_joint[k] - want.z_joint[k]).abs() < 1e-10 || k >= wound, "part {k}");
            }
        }
    }
}
