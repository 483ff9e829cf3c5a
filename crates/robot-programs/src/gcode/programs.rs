//! What a look over a text finds of its programs: the modes of words that each leaves, and how often each is called.

use std::collections::BTreeMap;

/// Groups of modes, times ten: the last word of a group is in force.
const GROUPS: [&[u32]; 3] = [&[900, 910], &[200, 210], &[170, 180, 190]];

/// G90 or G91, G20 or G21, and the plane.
pub(super) type Modes = (Option<bool>, Option<bool>, Option<[u8; 3]>);

/// What running a subprogram does to a group of modes.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) enum Effect {
    /// Nothing.
    #[default]
    Keeps,
    /// This G word is in force after it, times ten.
    Sets(u32),
    /// Not known.
    Unsure,
}

/// What a look over the text finds of its programs.
#[derive(Debug, Default)]
pub(super) struct Programs {
    pub(super) effects: BTreeMap<String, [Effect; 3]>,
    /// How many calls of each stand in the text.
    pub(super) calls: BTreeMap<String, usize>,
    current: Option<String>,
    /// A condition or a loop stands in the one that is read.
    branches: bool,
}

impl Programs {
    /// The text of a program begins; `None`: it goes on in that of no subprogram.
    pub(super) fn begin(&mut self, label: Option<&str>) {
        (self.current, self.branches) = (label.map(Into::into), false);
        let Some(label) = label else { return };
        // of two with one name it is not known which is meant
        let twice = self.effects.contains_key(label);
        self.effects.insert(label.into(), [if twice { Effect::Unsure } else { Effect::Keeps }; 3]);
    }

    /// A call of a program of the text.
    pub(super) fn called(&mut self, label: &str) {
        *self.calls.entry(label.into()).or_default() += 1;
        self.are_unsure(&[0, 1, 2]);
    }

    /// What follows in this program may be passed by.
    pub(super) fn branch(&mut self) {
        self.branches = true;
        let set = |effects: &[Effect; 3]| (0..3).filter(|n| effects[*n] != Effect::Keeps).collect::<Vec<_>>();
        let groups = self.current.as_ref().and_then(|label| self.effects.get(label)).map(set).unwrap_or_default();
        self.are_unsure(&groups);
    }

    /// How many calls of programs of the text there are.
    pub(super) fn call_count(&self) -> usize {
        self.calls.values().sum()
    }

    fn are_unsure(&mut self, groups: &[usize]) {
        if let Some(effects) = self.current.as_ref().and_then(|label| self.effects.get_mut(label)) {
            groups.iter().for_each(|n| effects[*n] = Effect::Unsure);
        }
    }

    /// A G word, times ten, in a block that an operator may switch off (`optional`).
    pub(super) fn g_word(&mut self, c: u32, optional: bool) {
        let unsure = optional || self.branches;
        let Some(effects) = self.current.as_ref().and_then(|label| self.effects.get_mut(label)) else { return };
        for (effect, _) in effects.iter_mut().zip(GROUPS).filter(|(_, group)| group.contains(&c)) {
            *effect = if unsure || *effect == Effect::Unsure { Effect::Unsure } else { Effect::Sets(c) };
        }
    }
}
