//! The diagnosis document and its text.
//!
//! Read in this order: [`document`], the document; `round`, a found effect of it; [`words`], its keys and sizes in words;
//! [`display`], for a terminal; [`traces`], for a page.

pub mod display;
pub mod document;
mod round;
pub mod traces;
pub mod words;
