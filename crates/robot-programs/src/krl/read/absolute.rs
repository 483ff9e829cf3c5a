//! Goals that cannot be determined, but are whole places of their own: points that hold all their parts whatever the program assigns to
//! them, lists with all parts, and products of these. A part that nobody gives stays where the robot stands.

use super::Reader;
use crate::krl::aggregate::{Aggregate, aggregate};
use crate::krl::data::Data;
use crate::krl::lex::{Kind, Token, upper};
use crate::krl::motion::{self, Word};
use crate::krl::name::Holds;
use crate::script::{Goal, PathKind};

/// Copies of copies that are followed.
const DEEPEST: usize = 8;

impl Reader<'_> {
    /// Whether the goal at token `at` is such a one.
    ///
    /// `goal = factor {":" factor}`, `factor = aggregate | name ["[" index "]"]`
    pub(super) fn is_absolute(&self, goal: &Goal, line: &[Token], at: usize, word: Word) -> bool {
        let simple = !(word.relative || word.arc || self.spline) && word.path != PathKind::Curve;
        // an axis of which the goal says nothing stays where it is
        let of_arm = !self.names.is_empty() && self.names.iter().all(|name| name.starts_with('A'));
        if !(simple && of_arm && matches!(goal, Goal::Opaque(_))) {
            return false;
        }
        let mut at = at;
        while let Some(next) = self.whole_factor(line, at) {
            if !line.get(next).is_some_and(|t| t.is(b':')) {
                return motion::ends(self.text, line, next);
            }
            at = next + 1;
        }
        false
    }

    /// The token after a factor that is a whole place.
    fn whole_factor(&self, line: &[Token], at: usize) -> Option<usize> {
        let first = line.get(at)?;
        if first.is(b'{') {
            let (given, next) = aggregate(self.text, 0, line, at).ok()?;
            return (is_plain(self, &line[at..next]) && self.is_complete(&given)).then_some(next);
        }
        if first.kind != Kind::Word {
            return None;
        }
        let name = upper(self.text, first);
        let open = line.get(at + 1).is_some_and(|t| t.is(b'['));
        let close = line.iter().skip(at).position(|t| t.is(b']')).map(|k| at + k).filter(|_| open);
        let next = if open { close? + 1 } else { at + 1 };
        if !is_plain(self, &line[at + 1..next]) {
            return None;
        }
        let element = crate::krl::product::name(self.text, line, at);
        let n = match self.data.find(self.routine, &element.0).filter(|_| element.1 == next) {
            Some(n) => n,
            None => self.data.find(self.routine, &name)?,
        };
        self.is_whole(self.data, n, 0).then_some(next)
    }

    /// All parts that the robot goes to.
    fn is_complete(&self, given: &Aggregate) -> bool {
        let has = |name: &str| given.component(name).is_some();
        match given.has_axes() {
            true => self.names.iter().all(|name| has(name)),
            false => ["X", "Y", "Z", "A", "B", "C"].into_iter().all(has),
        }
    }

    /// Whether a point holds all its parts wherever it is used: it is declared with them, or gets them before, and whatever else it gets
    /// is whole, too, or a part.
    fn is_whole(&self, data: &Data, n: usize, depth: usize) -> bool {
        let Some(name) = data.names.get(n).filter(|n| !n.spoiled_whole && depth < DEEPEST) else { return false };
        if name.array {
            let mut elements = data.names.iter().enumerate().filter(|(_, e)| e.of == Some(n)).peekable();
            return name.spoiled.is_none()
                && elements.peek().is_some()
                && elements.all(|(e, _)| self.is_whole(data, e, depth + 1));
        }
        let fits = |a: &Aggregate| self.is_complete(a) && (name.holds == Holds::Axes) == a.has_axes();
        let mut sure = name.given.as_ref().is_some_and(fits);
        for a in &name.assigned {
            let whole = match (&a.aggregate, a.from) {
                (Some(given), _) => fits(given),
                (None, Some(from)) => {
                    let same = data.names.get(from).is_some_and(|f| f.holds == name.holds && !f.array);
                    same && self.is_whole(data, from, depth + 1)
                }
                (None, None) => false,
            };
            if !whole {
                return false;
            }
            sure |= a.always;
        }
        sure
    }
}

/// No call, and nothing of the controller, which may be where the robot stands.
fn is_plain(reader: &Reader, tokens: &[Token]) -> bool {
    tokens.iter().all(|t| !t.is(b'(') && !upper(reader.text, t).starts_with('$'))
}
