//! What is certain of the position and of the modes, and what ends that.
//!
//! A position is known as long as every word since it was is known. Whatever lets it slip (a call, a label, a block that cannot be
//! determined) ends what is known, and with it what relative words lead to. Before such a place, and before a G92, the last move must
//! end where it always ended where relative words led to it, or the difference would stay in all that follows (and add up in
//! a loop): it is fixed.

use super::lex::{Block, Word};
use super::read::Reader;
use super::reason::{After, Doubt, Elsewhere, Reason};
use crate::script::{AxisSet, Break, Few, Goal, How, Move, PathKind, StepKind, Value};
use std::collections::BTreeSet;

/// A move whose goal cannot be determined.
pub(super) fn opaque(why: Reason) -> Move {
    Move::new(How { path: PathKind::Curve, ..How::default() }, Goal::opaque(why), Few::new())
}

/// From where relative words of an axis count whose position is not known.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) enum Carried {
    /// From a place of the machine, or where no move of the text ended.
    #[default]
    Nothing,
    /// From where this step ended.
    After(usize),
    /// From where any move may have ended before a label, a jump, a loop or a call.
    Anywhere,
}

impl Reader<'_> {
    /// Nothing is known of the position any more.
    pub(super) fn lose(&mut self, why: After) {
        if (self.absolute != Some(true) || self.relative) && !self.settled {
            self.anchor(why);
        }
        self.carry((0..self.letters.len()).collect());
        self.last = None;
        self.position.fill(None);
        self.relative = false;
    }

    /// Of some axes it is not known any more where they stand, nor from where their next words count.
    pub(super) fn slip(&mut self, k: usize, axes: Option<AxisSet>, why: After) {
        match axes.filter(|_| self.words_are_plain()) {
            Some(axes) => {
                self.lose_axes(axes, why);
                self.step(k, StepKind::Break(Break::Axes(axes)), None);
            }
            None => self.end(k, Break::Frame, why),
        }
    }

    /// A move of some axes (`None`: of any) to a place that the program does not contain.
    pub(super) fn goes_elsewhere(&mut self, k: usize, axes: Option<AxisSet>, why: Elsewhere) {
        let axes = axes.filter(|axes| !axes.is_empty() && self.words_are_plain());
        match axes {
            Some(axes) => {
                self.lose_axes(axes, why.into());
                // a variable without a value leaves its axis where it stands
                if why != Elsewhere::Expression {
                    // what counts from there counts from a place of the machine
                    axes.axes().for_each(|a| self.carried[a] = Carried::Nothing);
                    self.settled = true;
                }
            }
            None => self.lose(why.into()),
        }
        let mut goes = opaque(why.into());
        goes.moves_alone = axes;
        self.step(k, StepKind::Move(goes), None);
    }

    /// A straight move by words of which some may mean another place than they say: it stays, and where its axes come to is not known; the
    /// others stand where they stood. `false`: other axes may move too, or its words count from where the machine stands.
    ///
    /// Of G90 and G91 in one block Beckhoff takes each word by the one before it (TF5200, programming manual, combined programming: "N20
    /// G91 X20 G90 Y20 (relative for X axis, absolute for Y axis)"), others take the last one for the whole block or refuse the block.
    /// After it the last one is in force.
    ///
    /// `block = ["G91" axis_word {axis_word} "G90"] axis_word {axis_word}`
    pub(super) fn leaves_named(&mut self, k: usize, block: &Block, why: Elsewhere) -> bool {
        let cuts = |w: &Word| b"IJKR".contains(&w.letter) && w.value.is_none_or(|v| v.0 != 0.0);
        let straight = matches!(self.motion, Some(0 | 10)) && !block.words.iter().any(cuts);
        let whole = straight && (self.absolute == Some(true) || why == Elsewhere::BothDistances);
        let axes = self.axes_named(block).filter(|axes| whole && !axes.is_empty());
        if axes.is_some() {
            self.goes_elsewhere(k, axes, why);
        }
        axes.is_some()
    }

    /// An axis word moves its own axis and no other.
    fn words_are_plain(&self) -> bool {
        self.strange.is_none() && self.modal_macro.is_none() && self.compensation.is_none()
    }

    pub(super) fn lose_axes(&mut self, axes: AxisSet, why: After) {
        if self.absolute != Some(true) || self.relative {
            self.anchor(why);
        }
        self.carry(axes);
        axes.axes().filter_map(|a| self.position.get_mut(a).map(|p| *p = None)).for_each(drop);
    }

    /// Positions of these axes are about to be lost: the offset with which the last move ends stays in what relative words lead to from
    /// here.
    pub(super) fn carry(&mut self, axes: AxisSet) {
        let Some(step) = self.last else { return };
        let known: AxisSet = axes.axes().filter(|a| self.position.get(*a).is_some_and(Option::is_some)).collect();
        known.axes().for_each(|a| self.carried[a] = Carried::After(step));
        self.named = self.named.without(known);
    }

    /// A block whose words are or may be relative: moves from which they count, and of which that is known only now, end where they always
    /// did.
    pub(super) fn keep_before_relative(&mut self, block: &Block) {
        if self.absolute == Some(true) {
            return;
        }
        for w in &block.words {
            let axis = self.letters.iter().position(|&l| l == w.letter).filter(|a| self.position[*a].is_none());
            match axis.map(|a| std::mem::take(&mut self.carried[a])) {
                Some(Carried::After(step)) => self.anchor_at(step, After::RelativeWords),
                Some(Carried::Anywhere) => self.keep_leaving(After::RelativeWords),
                _ => {}
            }
        }
    }

    /// The last move must end where it always did, on every axis.
    pub(super) fn anchor(&mut self, why: After) {
        if let Some(step) = self.last {
            self.anchor_at(step, why);
        }
    }

    pub(super) fn anchor_at(&mut self, step: usize, why: After) {
        let Some(StepKind::Move(m)) = self.script.steps.get_mut(step).map(|s| &mut s.kind) else { return };
        m.fixed.get_or_insert_with(|| Reason::kept(why).into());
        let Goal::Joints(t) = m.goal else { return };
        let Some(s) = self.statements.get(step, self.text, self.letters) else { return };
        // axes without a word may need one, to take back what was changed before
        let at = s.words.last().map_or(0, |w| w.span().end);
        for (a, &goal) in s.goal.iter().enumerate() {
            if let (Some(goal), None) = (goal, self.script.targets.get(t).and_then(|t| t.values.get(a))) {
                let (si, digit) = (goal * self.robot.axis(a).kind.si_per_user_unit(), self.digit[a]);
                let value = Value { si, start: at, end: at, style: Default::default(), digit, finest: digit };
                self.script.targets.set(t, a, Some(value));
            }
        }
    }

    pub(super) fn end(&mut self, k: usize, kind: Break, why: After) {
        self.back_to_r = false;
        self.lose(why);
        self.step(k, StepKind::Break(kind), None);
    }

    /// Control may come from elsewhere: only what the whole text never changes is still certain.
    pub(super) fn join(&mut self, k: usize, kind: Break) {
        let why = if kind == Break::Call { After::Call } else { After::Jump };
        let last = self.last;
        self.end(k, kind, why);
        self.leave(last, why);
        self.carried.fill(Carried::Anywhere);
        self.named = AxisSet::default();
        self.motion = None;
        if matches!(kind, Break::Start | Break::Call) {
            self.variables.forget();
        } else {
            self.variables.join();
        }
        if !self.survey.single(&[900, 910]) {
            self.absolute = None;
        }
        if !self.survey.single(&[200, 210]) {
            self.inch = None;
        }
        if !self.survey.single(&[170, 180, 190]) {
            self.plane = None;
        }
        self.feed = None;
        // on the other ways to this place another mode may be on; the control's own is on where the text has no other
        let other = [611, 620, 640].iter().any(|c| self.survey.codes.contains(c)) || self.survey.hidden;
        self.exact &= self.robot.control.exact_stop && !other;
        self.join_lathe();
        self.lost_frame |= self.survey.frames();
        if self.survey.leaves_compensation {
            self.compensation = Some(Doubt::CompensationMayBeOn);
        }
        self.may_be_strange();
        if [430, 431, 440].iter().any(|c| self.survey.codes.contains(c)) && self.length_reference.is_some() {
            self.length = "unknown".into();
        }
    }

    /// A program or subprogram starts or ends.
    pub(super) fn start(&mut self, k: usize, block: &Block) {
        let before = (self.modes_before(), self.frame);
        self.join(k, Break::Start);
        self.route_program(block, before);
        let survey = &self.survey;
        // what is not in the text calls no main program
        let other = survey.lacks && self.script.moves().next().is_some();
        let calls = other || survey.outside || survey.repeats || survey.called.contains(&block.label);
        if block.flow.as_deref() == Some("") && !calls {
            // nothing in the text leads there
            self.carried.fill(Carried::Nothing);
        }
    }

    /// Control may go elsewhere after the move `last`, or after one above of which relative words may still count.
    fn leave(&mut self, last: Option<usize>, why: After) {
        let above = self.carried.iter().filter_map(|c| if let Carried::After(step) = c { Some(*step) } else { None });
        let ends: BTreeSet<usize> = above.chain(last).collect();
        if self.counts_anywhere {
            ends.into_iter().for_each(|step| self.anchor_at(step, why));
        } else {
            self.leaving.extend(ends);
        }
    }

    /// Something outside of this text runs: no mode is certain.
    pub(super) fn call(&mut self, k: usize) {
        if self.survey.whole {
            // what runs stands in this text
            return self.join(k, Break::Call);
        }
        let last = self.last;
        self.end(k, Break::Call, After::Call);
        // a subprogram of the text may be what runs
        self.leave(last, After::Call);
        self.variables.forget();
        self.may_be_strange();
        self.forget_modes(After::Call);
    }

    /// What the text sets somewhere may be in force where control comes from elsewhere.
    fn may_be_strange(&mut self) {
        if self.strange.is_none() && self.survey.hidden {
            self.strange = Some(Doubt::Unfollowed);
        }
        if let (None, Some(c)) = (&self.strange, self.survey.unfollowed) {
            self.strange = Some(Doubt::MayBeOn(c));
        }
        if self.strange.is_none() && self.survey.mirrors {
            self.strange = Some(Doubt::MirrorMayBeOn);
        }
        // centres of arcs, and feeds, that another way there may take otherwise
        for (other, doubt) in [(901, Doubt::CentresMayDiffer(901)), (930, Doubt::FeedMayDiffer(930))] {
            if self.strange.is_none() && self.survey.codes.contains(&other) {
                self.strange = Some(doubt);
            }
        }
        if self.survey.macros > 0 {
            self.modal_macro = Some(Doubt::MacroMayBeOn);
        }
    }

    /// No mode is certain.
    pub(super) fn forget_modes(&mut self, after: After) {
        self.motion = None;
        self.absolute = None;
        self.inch = None;
        self.plane = None;
        self.feed = None;
        self.exact = false;
        self.join_lathe();
        self.lost_frame = true;
        self.frame_to_name = true;
        self.compensation.get_or_insert(Doubt::Modes(after));
    }

    /// What words mean, to be compared.
    pub(super) fn modes(&self) -> String {
        let words = (self.motion, self.absolute, self.inch, self.plane, self.centre_absolute, self.feed_mode);
        let lost = (self.lost_frame, self.frame_to_name);
        let frames = (self.frame, lost, &self.local, &self.moved, &self.length);
        let doubts = (&self.strange, &self.modal_macro, &self.compensation, self.exact);
        format!("{words:?} {:?} {frames:?} {doubts:?}", self.across)
    }
}
