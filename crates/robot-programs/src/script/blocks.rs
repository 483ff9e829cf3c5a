//! Steps of a language with blocks, as a reader collects them: a block in which nothing moves leaves no break.
//!
//! Parts: `control` where control goes, by routines, blocks, labels and jumps.

mod control;

pub use super::by_steps::BySteps;
use super::joins::{Labels, through_still};
pub use super::order::{Round, is_entered};
use super::routines::Routines;
use super::{At, Break, Goal, Join, Move, Reason, Script, Step, StepKind, Text, pragma};

/// Steps, and the places `S` of their moves.
pub struct Steps<S> {
    steps: Vec<Step>,
    /// Breaks of blocks that hold nothing which moves.
    gone: Vec<usize>,
    sites: BySteps<S>,
    open: Vec<Block>,
    rounds: Vec<Round>,
    joins: Vec<Join>,
    labels: Labels,
    routines: Routines,
    /// Places at which the program ends and runs again from its start.
    again: Vec<usize>,
    /// Next comment to look at.
    comment: usize,
    /// The start with which the program starts, where that is known.
    pub entry: Option<usize>,
}

/// A block that is open: its own breaks, and whether anything in it moves.
#[derive(Default)]
struct Block {
    breaks: Vec<usize>,
    busy: bool,
    /// A loop that is certainly entered.
    round: bool,
    /// Something in it may lead out of it.
    left: bool,
    /// It is a loop in which something leads to its next pass.
    skipped: bool,
    /// Something may move while its conditions are looked at.
    unsure: bool,
    /// One of its branches is taken whatever the conditions are.
    whole: bool,
    /// Where its branches but the last one end.
    ends: Vec<usize>,
}

impl<S> Default for Steps<S> {
    fn default() -> Self {
        Self {
            steps: Vec::new(),
            gone: Vec::new(),
            sites: BySteps::default(),
            open: Vec::new(),
            rounds: Vec::new(),
            joins: Vec::new(),
            labels: Labels::default(),
            routines: Routines::default(),
            again: Vec::new(),
            comment: 0,
            entry: None,
        }
    }
}

impl<S> Steps<S> {
    /// With memory for the steps of a text.
    pub fn of_text(text: &Text) -> Self {
        let steps = Vec::with_capacity(text.likely_steps());
        Self { steps, sites: BySteps::of_text(text), ..Self::default() }
    }

    /// The step that comes next.
    pub fn next(&self) -> usize {
        self.steps.len()
    }

    fn add(&mut self, at: At, kind: StepKind) -> usize {
        let step = Step::following(self.steps.last(), at, kind);
        self.steps.push(step);
        self.steps.len() - 1
    }

    fn busy(&mut self) {
        if let Some(block) = self.open.last_mut() {
            block.busy = true;
        }
    }

    /// A step; all but a dwell, and names that are set, are something that moves.
    pub fn push(&mut self, at: At, kind: StepKind) -> usize {
        if !matches!(kind, StepKind::Dwell(_) | StepKind::Sets(_)) {
            self.busy();
        }
        if matches!(kind, StepKind::Break(Break::Interrupt)) {
            // what it runs may move the robot wherever it is, and end what it interrupts
            self.routines.are_unknown();
        }
        let next = self.next();
        if matches!(kind, StepKind::Break(_))
            && let Some(block) = self.open.last_mut()
            && block.breaks.last().is_some_and(|k| k + 1 == next)
        {
            // what its condition calls stands after its break
            block.unsure = true;
        }
        self.add(at, kind)
    }

    /// Where the move of a step stands.
    pub fn place(&mut self, step: usize, site: S) {
        self.sites.push(step, site);
    }

    /// The last step.
    pub fn last(&self) -> Option<&Step> {
        self.steps.last()
    }

    /// A step that was pushed, as it is before breaks of blocks go.
    pub fn get(&self, step: usize) -> Option<&Step> {
        self.steps.get(step)
    }

    /// The move of a step with its target, if it goes straight to joint values.
    pub fn joint_move(&self, step: usize) -> Option<(&Move, usize)> {
        match &self.get(step)?.kind {
            StepKind::Move(m) if m.way.is_empty() => match m.goal {
                Goal::Joints(target) => Some((m, target)),
                _ => None,
            },
            _ => None,
        }
    }

    /// The last move keeps its goal, if nothing else keeps it already.
    pub fn fix_last_move(&mut self, why: Reason) {
        if let Some(m) = self.last_move().filter(|m| m.fixed.is_none()) {
            m.fixed = Some(why);
        }
    }

    fn last_move(&mut self) -> Option<&mut Move> {
        self.steps.iter_mut().rev().find_map(|s| if let StepKind::Move(m) = &mut s.kind { Some(m) } else { None })
    }

    /// What is done after the last move is done as the robot enters its corner, if it may have one.
    pub fn act_in_corner(&mut self, why: &Reason) {
        if let Some(m) = self.last_move().filter(|m| m.blend_m != Some(0.0) && m.acts_in_corner.is_none()) {
            m.acts_in_corner = Some(Box::new(why.clone()));
        }
    }

    /// The last step.
    pub fn last_mut(&mut self) -> Option<&mut Step> {
        self.steps.last_mut()
    }

    /// The place that was given last.
    pub fn last_place(&self) -> Option<&S> {
        self.sites.last()
    }

    /// The one before it.
    pub fn place_before_last(&self) -> Option<&S> {
        self.sites.before_last()
    }

    /// Comments for the tool among `comments` that stand before a byte.
    pub fn pragmas(&mut self, text: &Text, comments: &[(usize, usize)], before: usize) {
        while let Some(&(start, end)) = comments.get(self.comment).filter(|c| c.0 < before) {
            self.comment += 1;
            if let Some(on) = pragma(text.slice(start..end)) {
                self.busy();
                self.add(At { file: 0, line: text.line_of(start) }, StepKind::Pragma(on));
            }
        }
    }

    /// From where control comes to routines; `None`: nothing asks for it, as no process is switched on.
    fn starts(&self) -> Option<Vec<Join>> {
        let processes = self.steps.iter().any(|s| matches!(s.kind, StepKind::Process(true)));
        let call =
            |k: &usize| matches!(self.steps[*k].kind, StepKind::Break(Break::Call)) && !self.routines.is_call(*k);
        processes.then(|| self.routines.starts(&(0..self.steps.len()).filter(call).collect::<Vec<_>>()))
    }

    /// Gives the steps that stay to the script; the places of its moves, by step.
    pub fn finish(mut self, script: &mut Script) -> BySteps<S> {
        self.joins.extend(std::mem::take(&mut self.labels).joins());
        let (starts, entered) = (self.starts(), self.routines.entered());
        // what calls the routine with which the program starts leads to its start as its end does
        let start = self.steps.iter().position(|s| matches!(s.kind, StepKind::Break(Break::Start)));
        self.again.extend(self.entry.or(start).into_iter().flat_map(|k| self.routines.calls_of_start(k)));
        self.joins.extend(std::mem::take(&mut self.routines).joins(self.steps.len()));
        // inner blocks close before outer ones
        self.gone.sort_unstable();
        let gone = &self.gone;
        // places from the first break that goes on move up
        let moved = |k: usize| k - gone.partition_point(|g| *g < k);
        let stays = |k: &usize| gone.binary_search(k).is_err();
        if let Some(k) = self.entry.filter(|k| *k < self.steps.len() && stays(k)) {
            script.entry = Some(moved(k));
        }
        let rounds = self.rounds.iter().map(|r| Round { open: moved(r.open), close: moved(r.close), ..*r });
        script.rounds = rounds.collect();
        let renumbered = |joins: &[Join]| -> Vec<Join> {
            let joins = joins.iter().filter(|j| stays(&j.at));
            joins.map(|j| Join { at: moved(j.at), from: j.from.iter().map(|k| moved(*k)).collect() }).collect()
        };
        script.joins = renumbered(&self.joins);
        let again = self.entry.or(start).filter(|k| stays(k) && !self.again.is_empty()).map(moved);
        script.again = again.map(|at| Join { at, from: self.again.iter().map(|k| moved(*k)).collect() });
        if let Some(starts) = starts {
            script.ways = script.joins.iter().cloned().chain(renumbered(&starts)).collect();
            script.ways.sort_by_key(|j| j.at);
        }
        script.joins.extend(renumbered(&entered));
        if !gone.is_empty() {
            let mut k = 0..;
            self.steps.retain(|_| k.next().is_some_and(|k| stays(&k)));
            self.sites.renumber(moved);
        }
        script.steps = self.steps;
        through_still(script);
        self.sites
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_are_loops_without_a_second_branch_and_know_whether_something_leads_out() {
        let at = At { file: 0, line: 1 };
        let mut steps = Steps::<()>::default();
        steps.push(at, StepKind::Break(Break::Start));
        for (leaves, skips) in [(false, false), (true, false), (false, true)] {
            steps.open_loop(at, true);
            steps.push(at, StepKind::Process(true));
            steps.open(at, Break::Jump);
            if leaves {
                steps.leaves();
            }
            if skips {
                steps.skips();
            }
            steps.close(at, Break::Jump);
            steps.close(at, Break::Loop);
        }
        let mut script = Script::default();
        steps.finish(&mut script);
        let round = |open, close, goes_on| Round { open, close, goes_on };
        assert_eq!(script.rounds, [round(1, 3, true), round(4, 6, false)]);
    }

    #[test]
    fn a_block_that_moves_nothing_leaves_no_break_and_one_around_a_busy_one_stays() {
        let at = At { file: 0, line: 1 };
        let mut steps = Steps::default();
        steps.push(at, StepKind::Break(Break::Start));
        steps.open(at, Break::Jump);
        steps.push(at, StepKind::Dwell(None));
        steps.branch(at, true);
        assert!(!steps.close(at, Break::Jump));
        steps.open(at, Break::Loop);
        steps.open(at, Break::Jump);
        steps.entry = Some(steps.next());
        let k = steps.push(at, StepKind::Break(Break::Start));
        steps.place(k, "here");
        assert!(steps.close(at, Break::Jump) && steps.close(at, Break::Loop));
        let mut script = Script::default();
        let sites = steps.finish(&mut script);
        let breaks: Vec<Option<Break>> = script
            .steps
            .iter()
            .map(|s| match s.kind {
                StepKind::Break(kind) => Some(kind),
                _ => None,
            })
            .collect();
        let [start, jump, round] = [Break::Start, Break::Jump, Break::Loop].map(Some);
        assert_eq!(breaks, [start, None, round, jump, start, jump, round]);
        assert_eq!((script.entry, sites.get(4)), (Some(4), Some(&"here")));
    }
}
