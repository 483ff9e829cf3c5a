//! Breaks of which it is known from where control comes: a branch, which one way alone reaches, and places where ways come together.
//!
//! The script is cut into runs first, each of which begins where nothing is known of the way there. Then what follows such a break is gone
//! through again from each place from which control comes to it. The points before that place come first ([`Role::Before`]): they show from
//! which side joints come, and their own run writes them. Where several ways lead there, no point may be on the way of the first move,
//! which has several starts, and what comes out of the engine for all of them is compared as the passes of a loop are ([`super::rounds`]).
//!
//! A program that runs again from its start comes to its first moves from its end, too: these runs ([`super::Cut::again`]) write nothing,
//! and what comes out of the engine for them is compared ([`super::super::again`]).
//!
//! A place of which nothing is known, a target that is not known, or goals that differ leave the break as it was.

use super::super::cause::Cause;
use super::reach::Reach;
use super::stretch::empty_run;
use super::{Cut, Cutter, Joints, LastFrame, Role, Run, Vertex};
use crate::program::script::{At, Break, Join, Round, Script, StepKind};
use crate::rewrite::script::approach::Directions;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Points before a place that are kept. A joint that does not move in them has no direction, and gets no points where it turns next.
const KEPT: usize = 48;
/// Ways that come together at most.
const WAYS: usize = 8;
/// Ends of a program that runs again at most.
const ENDS: usize = 64;
/// Breaks of a program at most; each is compared with all runs.
pub(super) const MOST: usize = 5000;
/// Times that all breaks are looked at: what follows one may lead to one before it.
const SWEEPS: usize = 2;
/// Joints that differ by less are the same, rad or m: what the solver leaves.
const SAME: f64 = 1e-7;

/// Where the robot stands at a place, and how it came there.
#[derive(Clone)]
pub(super) struct Standing {
    before: Vec<Vertex>,
    directions: Directions,
    hint: Option<Joints>,
    last_frame: Option<LastFrame>,
    lettered: bool,
    by_letter: bool,
    by_joints: bool,
    untimed: Option<At>,
    certain: bool,
    by_program: bool,
}

/// Where the robot stands before a step.
pub(super) type Places = BTreeMap<usize, Standing>;

/// Steps before which it has to be known where the robot stands.
pub(super) fn places(script: &Script) -> BTreeSet<usize> {
    script.joins.iter().chain(&script.again).flat_map(|j| j.from.iter().copied()).collect()
}

impl Cutter<'_> {
    /// Where the robot stands now; `None`: not known of every axis.
    pub(super) fn standing(&self) -> Option<Standing> {
        let known = self.known.is_empty() && self.free.is_empty() && !self.run.vertices.is_empty();
        known.then(|| {
            let all = &self.run.vertices;
            let last = &all[all.len().saturating_sub(KEPT)..];
            let began_s = last.first().map_or(0.0, |v| v.t_s);
            let kept = |v: &Vertex| Vertex {
                role: Role::Before,
                editable: false,
                again: false,
                t_s: v.t_s - began_s,
                ..v.clone()
            };
            Standing {
                before: last.iter().map(kept).collect(),
                directions: self.directions.clone(),
                hint: self.hint.clone(),
                last_frame: self.last_frame.clone(),
                lettered: self.lettered,
                by_letter: self.by_letter,
                by_joints: self.by_joints,
                untimed: self.run.untimed,
                certain: self.run.certain,
                by_program: self.run.by_program,
            }
        })
    }

    /// A run that goes on from a place.
    fn seed(&mut self, standing: &Standing) {
        self.end(false);
        let Standing { before, directions, hint, last_frame, lettered, .. } = standing.clone();
        let Standing { by_letter, by_joints, untimed, certain, by_program, .. } = *standing;
        (self.last_frame, self.by_letter) = (last_frame, by_letter);
        self.run = Run { vertices: before, untimed, certain, by_program, ..empty_run(false) };
        (self.directions, self.hint, self.lettered, self.by_joints) = (directions, hint, lettered, by_joints);
        (self.stands, self.rest) = (false, None);
    }

    /// Goes through what follows each break once more, from the places from which control comes there.
    ///
    /// `rounds`: loops that the runs go through already.
    pub(super) fn join(&mut self, script: &Script, rounds: &[Round], places: &mut Places) {
        let round = |at: usize| rounds.iter().any(|r| r.open == at || r.close == at);
        let apart =
            |j: &Join| first_move(script, &segment(script, j.at)).is_some_and(|k| self.choice.approach.is_apart(k));
        let known = |j: &&Join| !j.from.is_empty() && j.from.len() <= WAYS && !round(j.at) && !apart(j);
        let mut open: Vec<&Join> = script.joins.iter().filter(known).collect();
        let wanted = self::places(script);
        for _ in 0..SWEEPS {
            open.retain(|join| !self.joined(script, join, &wanted, places));
        }
    }

    /// The same of one break; `true`: it is done with.
    fn joined(&mut self, script: &Script, join: &Join, wanted: &BTreeSet<usize>, places: &mut Places) -> bool {
        let segment = segment(script, join.at);
        if first_move(script, &segment).is_none() {
            return true;
        }
        let Some(ways) = join.from.iter().map(|k| places.get(k).cloned()).collect::<Option<Vec<_>>>() else {
            return false;
        };
        let before = std::mem::take(&mut self.out);
        let (over, missing) = (self.over.len(), self.poses.missing.clone());
        let mut found: Vec<Run> = Vec::new();
        let mut end = None;
        for (n, way) in ways.iter().enumerate() {
            self.again = n > 0;
            let (run, stands) = self.seeded(script, way, &segment, ways.len() > 1);
            end = stands.filter(|_| wanted.contains(&segment.end));
            let first = found.first().map(|first| goals(first, usize::MAX));
            found.extend(run.filter(|run| first.is_none_or(|first| alike(&first, run))));
        }
        self.again = false;
        // what moves wait for was counted when they were met first
        self.poses.missing = missing;
        let joined = std::mem::replace(&mut self.out, before);
        if found.len() < ways.len() || !self.replace(script, &segment, joined, found) {
            self.over.truncate(over);
            return true;
        }
        // of several ways none is certain
        let end = end.map(|end| if ways.len() > 1 { self.without_way(end, &segment) } else { end });
        places.extend(end.map(|end| (segment.end, end)));
        true
    }

    /// Goes through the first moves of a program that runs again from its start once more, from the places at which it ends. Places after
    /// something of which nothing is known count for nothing. `false`: from one that is known it cannot be gone through in the same way, so
    /// that what comes out cannot be compared; or one is the end of a loop or of branches to which several ways lead.
    ///
    /// From each the first move comes on another way than at the first start, so that no point may be on its way.
    pub(super) fn run_again(&mut self, script: &Script, places: &Places) -> bool {
        let Some(again) = &script.again else { return true };
        let ways: Vec<&Standing> = again.from.iter().filter_map(|k| places.get(k)).collect();
        let begins = |run: &&Run| run.entry && !run.own().is_empty();
        if !self.out.runs.iter().any(|run| begins(&run)) {
            return true;
        }
        if again.from.iter().any(|k| !places.contains_key(k) && is_end_of_block(script, *k)) {
            return false;
        }
        if ways.is_empty() {
            return true;
        }
        let segment = segment(script, again.at);
        if first_move(script, &segment).is_some_and(|k| self.choice.approach.is_apart(k)) {
            return true;
        }
        let own = |run: &&Run| begins(run) && run.own().first().is_some_and(|v| segment.contains(&v.step));
        let Some(first) = self.out.runs.iter().find(own).filter(|_| ways.len() <= ENDS) else {
            return false;
        };
        let reach = Reach::of(first, self.choice);
        let first = goals(first, reach.as_ref().map_or(usize::MAX, |reach| reach.end));
        let segment = segment.start..reach.as_ref().map_or(segment.end, |reach| reach.end);
        let mut all = true;
        for way in ways {
            let before = std::mem::take(&mut self.out);
            let (over, missing) = (self.over.len(), self.poses.missing.clone());
            let (run, _) = self.seeded(script, way, &segment, true);
            self.poses.missing = missing;
            self.over.truncate(over);
            self.out = before;
            let mut run = run.filter(|run| alike(&first, run));
            all &= run.is_some();
            if let (Some(run), Some(reach)) = (&mut run, &reach) {
                // after these nothing is compared: the last of them see the end of the stretch
                run.vertices.iter_mut().filter(|v| v.step >= reach.compared).for_each(|v| v.editable = false);
            }
            self.out.again.extend(run);
        }
        all
    }

    /// Where the robot stands after a stretch to which several ways lead: from which sides it came to its first target is not known.
    fn without_way(&self, standing: Standing, segment: &Range<usize>) -> Standing {
        let mut directions = Directions::default();
        let own = |v: &&Vertex| segment.contains(&v.step);
        let before: Vec<Vertex> = standing.before.iter().filter(own).cloned().collect();
        for v in &before {
            directions.go(self.choice.robot, &v.q, self.choice.deadband);
        }
        Standing { before, directions, ..standing }
    }

    /// The run that goes on from a place through the moves of a stretch, as far as they are known, and where the robot stands at its end;
    /// `several`: other ways lead there as well.
    fn seeded(
        &mut self,
        script: &Script,
        way: &Standing,
        segment: &Range<usize>,
        several: bool,
    ) -> (Option<Run>, Option<Standing>) {
        self.seed(way);
        if several {
            self.run.entered.extend(first_move(script, segment));
        }
        for k in segment.clone() {
            self.step_in(script, k);
            if !self.run.goes_on() {
                // it has ended: what comes after is as it was found without a start
                break;
            }
        }
        let stands = self.standing().filter(|_| self.run.goes_on());
        self.end(false);
        let mut runs = std::mem::take(&mut self.out.runs).into_iter();
        (runs.find(Run::goes_on), stands)
    }

    fn step_in(&mut self, script: &Script, k: usize) {
        let Some(step) = script.steps.get(k) else { return };
        match &step.kind {
            StepKind::Move(m) => self.take(script, k, step.at, m),
            StepKind::Dwell(seconds) => self.dwell(*seconds),
            StepKind::Sets(name) => self.set(name),
            _ => {}
        }
    }

    /// Puts what was found of a stretch of the script in the place of what was found without a start; `false`: that led further.
    fn replace(&mut self, script: &Script, segment: &Range<usize>, joined: Cut, runs: Vec<Run>) -> bool {
        let Some(last) = runs.first().and_then(|run| run.own().last()).map(|v| v.step) else { return false };
        let covered = segment.start..last + 1;
        let inside = |step: usize| covered.contains(&step);
        let own = |run: &Run| run.own().first().is_some_and(|v| inside(v.step));
        let further = |run: &Run| run.own().last().is_some_and(|v| !inside(v.step));
        if self.out.runs.iter().any(|run| own(run) && further(run)) {
            return false;
        }
        let at = self.out.runs.iter().position(own).unwrap_or_else(|| {
            let later = |run: &Run| run.own().first().is_some_and(|v| v.step >= covered.end);
            self.out.runs.iter().position(later).unwrap_or(self.out.runs.len())
        });
        self.out.runs.retain(|run| !own(run));
        self.out.runs.splice(at..at, runs);
        let unsolved = self.out.left.iter().filter(|(k, why)| inside(**k) && **why == Cause::NoStart).count() as u64;
        self.poses.missing.posture = self.poses.missing.posture.saturating_sub(unsolved);
        self.out.left.retain(|k, _| !inside(*k));
        self.out.left.extend(joined.left.into_iter().filter(|(k, _)| inside(*k)));
        let lines: Vec<At> = covered.clone().filter_map(|k| script.steps.get(k)).map(|s| s.at).collect();
        self.out.gaps.retain(|gap| !lines.contains(&gap.at));
        self.out.partial.retain(|k| !inside(*k));
        for note in joined.notes {
            if !self.out.notes.contains(&note) {
                self.out.notes.push(note);
            }
        }
        true
    }
}

/// The steps after a break, up to the next one.
fn segment(script: &Script, at: usize) -> Range<usize> {
    let from = at + 1;
    let next = script.steps.iter().skip(from).position(|s| matches!(s.kind, StepKind::Break(_)));
    from..next.map_or(script.steps.len(), |n| from + n)
}

/// Whether nothing moves between a place and the loop, the branch or the label before it.
fn is_end_of_block(script: &Script, place: usize) -> bool {
    let before = script.steps.iter().take(place).rev();
    let last = before.map(|s| &s.kind).find(|kind| matches!(kind, StepKind::Move(_) | StepKind::Break(_)));
    matches!(last, Some(StepKind::Break(Break::Loop | Break::Jump)))
}

fn first_move(script: &Script, segment: &Range<usize>) -> Option<usize> {
    segment.clone().find(|k| matches!(script.steps[*k].kind, StepKind::Move(_)))
}

/// The goals of a run before step `end`, with their steps.
fn goals(run: &Run, end: usize) -> Vec<(usize, Joints)> {
    let own = |v: &&Vertex| v.role == Role::Goal && v.step < end;
    run.vertices.iter().filter(own).map(|v| (v.step, v.q.clone())).collect()
}

/// A run leads to the same places as the goals of another one, after the points before it.
fn alike(first: &[(usize, Joints)], other: &Run) -> bool {
    let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(x, y)| (x - y).abs() <= SAME);
    let mut others = other.vertices.iter().filter(|v| v.role == Role::Goal);
    first.iter().all(|(step, q)| others.next().is_some_and(|v| v.step == *step && near(q, &v.q)))
        && others.next().is_none()
}
