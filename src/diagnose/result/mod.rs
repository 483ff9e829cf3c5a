//! The diagnosis document and its text.
//!
//! Read in this order: [`document`], the document; `round`, a found effect of it; [`words`], its keys and sizes in words;
//! [`display`], for a terminal; [`traces`], for a page.

#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod display;
pub(crate) mod document;
mod round;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod traces;
#[cfg_attr(not(feature = "cli"), allow(dead_code))]
pub(crate) mod words;

pub use document::of;
