//! A point whose numbers stand nowhere in the program as they are: they are put together into an separate aggregate.

use super::aggregate::{Aggregate, aggregate, axis_name};
use super::lex::tokens;
use super::name::Holds;
use crate::script::Text;

/// Parts of a point in their order: name in upper case, and the number as text.
pub(super) type Parts = Vec<(String, Vec<u8>)>;

/// An aggregate that no file has.
pub(super) struct Made {
    /// `{X 1070.0,Y -610.0,...}`.
    pub text: Text,
    /// Its bytes are those of [`Self::text`].
    pub value: Aggregate,
}

impl Made {
    /// Of its parts; `None`: they are no point of this kind.
    pub fn of(parts: &Parts, holds: Holds) -> Option<Self> {
        let mut bytes = vec![b'{'];
        for (k, (name, number)) in parts.iter().enumerate() {
            bytes.extend_from_slice(if k > 0 { b"," } else { b"" });
            bytes.extend_from_slice(name.as_bytes());
            bytes.push(b' ');
            bytes.extend_from_slice(number);
        }
        bytes.push(b'}');
        let (text, mut line) = (Text::new("", bytes), Vec::new());
        tokens(&text, 0, &mut line);
        let (value, end) = aggregate(&text, 0, &line, 0).ok()?;
        let axes = parts.iter().all(|part| axis_name(&part.0));
        let whole = end == line.len() && value.components().all(|c| c.value.is_some());
        (whole && (holds == Holds::Axes) == axes && value.has_axes() == axes).then_some(Self { text, value })
    }
}

/// The parts of an aggregate of a text; `None`: one of them is computed.
pub(super) fn parts(a: &Aggregate, text: &Text) -> Option<Parts> {
    a.components().map(|c| Some((c.name.as_str().to_string(), text.slice(c.value?.0).to_vec()))).collect()
}
