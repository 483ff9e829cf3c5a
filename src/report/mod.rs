//! One self-contained HTML page for a job or for the whole chain: what was done, the verdict, pictures, tables, method.
//!
//! A command fills plain data ([`views`]) from its results and calls [`Page::render`]; this module knows neither results nor
//! robots, and computes nothing but drawing coordinates and the thinning of long series. A page needs no network and no script
//! (a short script turns the view in space and changes its exaggeration); it prints on A4. Colours: Okabe and Ito, "Color
//! Universal Design", 2008; every colour has a shape or a name beside it. Same input, same bytes: there is no clock in it.
//!
//! Values that cannot be drawn (not finite, or beyond 1e15) are left out and counted under their figure.
//!
//! Modules:
//! - [`views`], [`figures`], [`bidirectional`], [`diagnosis`]: what a page takes, with units in every name.
//! - [`page`]: the HTML shell, head and sections; `style.css`, `turn.js` and `zoom.js` go into it as they are.
//! - [`plots`]: SVG drawings; [`plots::axes`] has the scales and ticks that all of them share.
//! - [`tables`]: HTML tables; [`map`]: tables with coloured cells.
//! - [`method`]: notes on method with equations and sources, to be quoted by name.
//! - [`mod@number`]: how numbers are written.
//!
//! # Example
//!
//! Numbers of a page, with the decimals that they are asked for.
//!
//! ```
//! use lostmotion::report::number;
//!
//! assert_eq!(number(12.3456, 2), "12.35");
//! ```

#![warn(missing_docs)]

pub(crate) mod bidirectional;
pub(crate) mod diagnosis;
pub(crate) mod figures;
pub(crate) mod map;
pub mod method;
pub(crate) mod number;
pub(crate) mod page;
pub mod plots;
pub(crate) mod tables;
pub(crate) mod views;

pub use bidirectional::*;
pub use diagnosis::*;
pub use figures::*;
pub use method::Method;
pub use number::number;
pub use views::*;

/// The example of `docs/report.md`, kept true.
#[cfg(doctest)]
#[doc = include_str!("../../docs/report.md")]
struct Documentation;
