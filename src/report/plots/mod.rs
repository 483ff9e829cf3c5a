//! SVG drawings. Each takes a view and gives the figure's markup; colours and type come from the page's style sheet by class.
//!
//! Modules:
//! - [`axes`]: extents, scales, ticks, the frame of a chart in x and y.
//! - [`mod@line`]: series of points to path data, thinned to what the eye can see.
//! - [`joints`]: a joint's colour, shape, name and units on the page.
//! - [`path3d`], [`polar`], [`traces`], [`gap_curve`], [`backlash_line`], [`histogram`], [`bars`], [`ways`]: one figure each; [`heat`]:
//!   what is coloured by a quantity.

pub mod axes;
pub mod backlash_line;
pub(crate) mod bars;
pub(crate) mod gap_curve;
pub(crate) mod heat;
pub(crate) mod histogram;
pub(crate) mod joints;
pub mod line;
pub(crate) mod path3d;
pub(crate) mod polar;
pub(crate) mod traces;
pub(crate) mod ways;

use super::figures::{Role, Run};
use maud::{Markup, html};

/// Class of a run's colour and line.
pub(super) fn role_class(role: Role) -> &'static str {
    match role {
        Role::Before => "before",
        Role::Between => "between",
        Role::After => "after",
    }
}

/// What the lines of a figure mean.
pub(super) fn legend<'a>(runs: impl IntoIterator<Item = &'a Run>, extra: &[(&str, &str)]) -> Markup {
    html! {
        ul.legend {
            @for run in runs { li { span.swatch.(role_class(run.role)) {} (run.name) } }
            @for (class, name) in extra { li { span.swatch.(class) {} (name) } }
        }
    }
}

/// Says how many values could not be drawn; nothing where all could.
pub(super) fn dropped_note(dropped: usize) -> Markup {
    html! {
        @if dropped == 1 { p.dropped { "1 value is not a finite number and is left out." } }
        @else if dropped > 1 {
            p.dropped { (super::number::count(dropped as u64)) " values are not finite numbers and are left out." }
        }
    }
}

/// Stands where there is nothing to draw.
pub(super) fn nothing(what: &str) -> Markup {
    html! { p.nothing { "Nothing to draw: " (what) "." } }
}
