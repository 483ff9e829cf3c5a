//! Command of a stroke whose friction responds to it ([`crate::effects::response`]).
//!
//! What friction does depends on the command, and the command on what friction does: both are found alternately, each time halfway
//! to what the last command asks for. What does not depend on the command (the wind-up, and by how much a spike fades from node to
//! node) is worked out once ([`Along`]). A round then needs one `exp` for each node up to where friction has turned over to the last
//! bit, and none after it.
//!
//! Where the command rises all the way, it needs no isotonic fit: it is what friction, gap and travel add up to.

use super::{Place, RESPONSE_PASSES, SETTLED, Work};
use crate::compensator::response::{MOST_SPIKES, MOST_WINDUPS, State};
use crate::compensator::{Response, Spike};
use crate::numerics::fading::{LANES, fade};
use crate::rewrite::stroke::{Node, hold};

/// Spans of time that differ by no more than this share of the time since the turn are one span: the nodes of a leg are evenly
/// spaced, and their times are rounded.
const SAME_SPAN: f64 = 4.0 * f64::EPSILON;

/// What a node has from the one before, whatever the command.
#[derive(Debug, Clone, Copy, Default)]
struct Step {
    /// Wind-up at the node, rad or m.
    wound: f64,
    /// What is left of each spike, and of a change that is spread over the step.
    fade: [f64; MOST_SPIKES],
    share: [f64; MOST_SPIKES],
}

/// What of a stroke does not depend on its command; memory for what does.
#[derive(Debug, Default)]
pub(super) struct Along {
    steps: Vec<Step>,
    /// The wind-up at the last node.
    z_joint: [f64; MOST_WINDUPS],
    /// The command at each node, and a few places more.
    way: Vec<f64>,
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

    /// Of `dt_s`: what is left of each spike, and of a change that was spread evenly over it.
    fn fades(&self, dt_s: f64, step: &mut Step) {
        for k in 0..self.count {
            [step.fade[k], step.share[k]] = self.spike[k].fades(dt_s);
        }
    }
}

/// Command of a stroke whose friction responds, into `work`, whose friction at each node it changes, too. Returns the state of
/// friction at the end of the stroke.
pub(super) fn respond(r: &Response, before: &State, start: f64, first: usize, work: &mut Work) -> State {
    let n = work.machine.len();
    let spikes = Spikes::of(r);
    work.along.lay(r, &spikes, before, &work.nodes, &work.machine);
    let settled = SETTLED * (r.gain() + r.windup().abs());
    let mut last = *before;
    for _ in 0..RESPONSE_PASSES {
        let known = work.command.len() == n;
        work.along.follow(start, first, &work.nodes, &work.machine, &work.command);
        work.command.resize(n, 0.0);
        let round = Round {
            r,
            windup: r.windup(),
            spikes: &spikes,
            before,
            along: &work.along,
            known,
            first,
            machine: &mut work.machine,
            command: &mut work.command,
        };
        let passed = pulp::Arch::new().dispatch(round);
        if !passed.rises {
            hold(&work.machine, first, &mut work.command, &mut work.fall);
        }
        last = passed.state;
        if passed.moved <= settled {
            break;
        }
    }
    State { z_joint: work.along.z_joint, ..last }
}

impl Along {
    /// Works out what does not depend on the command.
    fn lay(&mut self, r: &Response, spikes: &Spikes, before: &State, nodes: &[Place], machine: &[Node]) {
        self.steps.clear();
        self.steps.resize(nodes.len(), Step::default());
        let (mut span_s, mut step) = (f64::NAN, Step::default());
        for (now, pair) in self.steps.iter_mut().skip(1).zip(nodes.windows(2)) {
            let dt_s = (pair[1].since_s - pair[0].since_s).max(0.0);
            let same = (dt_s - span_s).abs() <= SAME_SPAN * pair[1].since_s;
            if !same {
                span_s = dt_s;
                spikes.fades(dt_s, &mut step);
            }
            *now = step;
        }
        self.z_joint = before.z_joint;
        for (w, z) in r.windups.iter().zip(&mut self.z_joint).filter(|(w, _)| w.half != 0.0) {
            pulp::Arch::new().dispatch(Winding {
                half: w.half,
                presliding: w.presliding,
                z,
                steps: &mut self.steps,
                machine,
            });
        }
    }

    /// Writes down where the command stands at each node; before it is known, it is what the joint is to do.
    fn follow(&mut self, start: f64, first: usize, nodes: &[Place], machine: &[Node], command: &[f64]) {
        self.way.clear();
        if command.len() == machine.len() {
            self.way.extend_from_slice(command);
            let (u0, u1, level) = (nodes[0].u, nodes[first].u, command[first]);
            for (way, node) in self.way[..first].iter_mut().zip(nodes) {
                *way = start + (level - start) * (node.u - u0) / (u1 - u0).max(f64::MIN_POSITIVE);
            }
        } else {
            self.way.extend(machine.iter().map(|m| m.travel));
        }
        let last = self.way.last().copied().unwrap_or(0.0);
        self.way.resize(machine.len() + LANES, last);
    }
}

/// Over the travel `by` of which friction turns over by a factor e, as the exponent of what is left.
#[inline(always)]
fn exponent(by: f64, over: f64) -> f64 {
    -by.max(0.0) / over
}

/// A part of the wind-up along the stroke, added to that of the steps.
struct Winding<'a> {
    half: f64,
    presliding: f64,
    z: &'a mut f64,
    steps: &'a mut [Step],
    machine: &'a [Node],
}

impl pulp::NullaryFnOnce for Winding<'_> {
    type Output = ();

    // inlined, so that it is compiled for the registers that there are
    #[inline(always)]
    fn call(self) {
        let Self { half, presliding, z, steps, machine } = self;
        let Some((head, steps)) = steps.split_first_mut() else { return };
        head.wound += half * *z;
        let mut rest = machine;
        for steps in steps.chunks_mut(LANES) {
            let wound = *z == 1.0;
            let mut left = [0.0; LANES];
            if !wound {
                for (left, pair) in left.iter_mut().zip(rest.windows(2)) {
                    *left = exponent(pair[1].travel - pair[0].travel, presliding);
                }
                fade(&mut left);
            }
            for (step, left) in steps.iter_mut().zip(left) {
                if !wound {
                    *z = 1.0 + (*z - 1.0) * left;
                }
                step.wound += half * *z;
            }
            rest = rest.get(steps.len()..).unwrap_or_default();
        }
    }
}

/// One round: what friction does for the command of [`Along::way`], halfway to it, and the command that this asks for.
struct Round<'a> {
    r: &'a Response,
    windup: f64,
    spikes: &'a Spikes,
    before: &'a State,
    along: &'a Along,
    /// There was a round before.
    known: bool,
    first: usize,
    machine: &'a mut [Node],
    command: &'a mut [f64],
}

/// What came of a round.
struct Passed {
    /// Friction at the last node, without the wind-up.
    state: State,
    /// Largest change of friction at a node.
    moved: f64,
    /// The command never falls from the step point on.
    rises: bool,
}

impl pulp::NullaryFnOnce for Round<'_> {
    type Output = Passed;

    // inlined, so that it is compiled for the registers that there are
    #[inline(always)]
    fn call(self) -> Passed {
        match self.spikes.count {
            0 | 1 => self.pass::<1>(),
            2 => self.pass::<2>(),
            _ => self.pass::<MOST_SPIKES>(),
        }
    }
}

impl Round<'_> {
    #[inline(always)]
    fn pass<const SPIKES: usize>(self) -> Passed {
        let Self { spikes, before, along, .. } = self;
        let (way, over) = (along.way.as_slice(), self.r.presliding);
        let mut h = [0.0; SPIKES];
        for k in 0..SPIKES {
            h[k] = before.h[spikes.place[k]];
        }
        let moved = if self.known { 0.0 } else { f64::INFINITY };
        let mut halfway = Halfway { round: self, moved, highest: f64::NEG_INFINITY, rises: true };
        halfway.settle(0, &h);
        let (mut z, mut i, n) = (before.z, 1, along.steps.len());
        while i < n {
            let end = (i + LANES).min(n);
            let turned = z == 1.0;
            let mut left = [0.0; LANES];
            if !turned {
                let pairs = way[i..i + LANES].iter().zip(&way[i - 1..i + LANES - 1]);
                for (left, (now, last)) in left.iter_mut().zip(pairs) {
                    *left = exponent(now - last, over);
                }
                fade(&mut left);
            }
            for (i, left) in (i..end).zip(left) {
                let step = &along.steps[i];
                // friction that has turned over stays so: nothing is spread over the step any more
                let next = if turned { z } else { 1.0 + (z - 1.0) * left };
                for k in 0..SPIKES {
                    h[k] = h[k] * step.fade[k] + (next - z) * step.share[k];
                }
                z = next;
                halfway.settle(i, &h);
            }
            i = end;
        }
        let mut state = State { z, ..*before };
        for k in 0..spikes.count.min(SPIKES) {
            state.h[spikes.place[k]] = h[k];
        }
        Passed { state, moved: halfway.moved, rises: halfway.rises }
    }
}

/// A round on its way.
struct Halfway<'a> {
    round: Round<'a>,
    moved: f64,
    /// `H` at the node before, from the step point on.
    highest: f64,
    rises: bool,
}

impl Halfway<'_> {
    /// Takes friction at node `i` halfway to what the spikes `h` ask for.
    #[inline(always)]
    fn settle<const SPIKES: usize>(&mut self, i: usize, h: &[f64; SPIKES]) {
        let round = &mut self.round;
        let mut spike = 0.0;
        for k in 0..SPIKES {
            spike += round.spikes.spike[k].gain * h[k];
        }
        let now = round.along.steps[i].wound + spike - round.windup;
        let node = &mut round.machine[i];
        let next = if round.known { 0.5 * (node.friction + now) } else { now };
        self.moved = self.moved.max((next - node.friction).abs());
        node.friction = next;
        let wanted = node.travel + node.gap + next;
        round.command[i] = wanted;
        if i >= round.first {
            self.rises &= wanted >= self.highest;
            self.highest = wanted;
        }
    }
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
