//! A joint on the page: its colour class, its shape, the units of its position and of its errors.

use crate::report::views::JointView;
use crate::robot::JointKind;
use maud::{Markup, html};

/// Number of colours; a seventh joint starts again with other shapes.
const COLOURS: usize = 6;
const SHAPES: usize = 5;

/// Lookup of the page's joints.
#[derive(Debug, Clone, Copy)]
pub struct Joints<'a>(pub &'a [JointView]);

impl Joints<'_> {
    fn index(&self, name: &str) -> Option<usize> {
        self.0.iter().position(|j| j.name == name)
    }

    /// Class of the joint's colour.
    pub fn class(&self, name: &str) -> String {
        self.index(name).map_or_else(|| "j-other".into(), |i| format!("j{}", i % COLOURS))
    }

    /// Unit of positions.
    pub fn unit(&self, name: &str) -> &'static str {
        if self.is_prismatic(name) { "mm" } else { "deg" }
    }

    /// Unit of errors and gaps.
    pub fn milli_unit(&self, name: &str) -> &'static str {
        if self.is_prismatic(name) { "µm" } else { "mdeg" }
    }

    /// How gaps are shown: factor of thousandths, unit, decimals.
    pub fn gaps(&self, name: &str) -> (f64, &'static str, usize) {
        let wide = self.index(name).is_some_and(|i| self.0[i].wide_gaps);
        if wide { (1e-3, self.unit(name), 4) } else { (1.0, self.milli_unit(name), 2) }
    }

    /// Whether positions are angles.
    pub fn is_prismatic(&self, name: &str) -> bool {
        self.index(name).is_some_and(|i| self.0[i].kind == JointKind::Prismatic)
    }

    /// The joint's mark, about `r` pixels in radius.
    pub fn glyph(&self, name: &str, x: f64, y: f64, r: f64) -> Markup {
        use crate::report::number::px;
        let i = self.index(name);
        let class = self.class(name);
        let shape = i.map_or(SHAPES, |i| (i + i / COLOURS) % SHAPES);
        let corners = |n: usize, turn: f64, r: f64| {
            let at = |k: usize| {
                let a = (turn + k as f64 / n as f64) * std::f64::consts::TAU;
                format!("{},{}", px(x + r * a.sin()), px(y - r * a.cos()))
            };
            (0..n).map(at).collect::<Vec<_>>().join(" ")
        };
        html! {
            @match shape {
                0 => circle.glyph.(class) cx=(px(x)) cy=(px(y)) r=(px(r)) {},
                1 => polygon.glyph.(class) points=(corners(4, 0.125, 1.2 * r)) {},
                2 => polygon.glyph.(class) points=(corners(3, 0.0, 1.35 * r)) {},
                3 => polygon.glyph.(class) points=(corners(4, 0.0, 1.3 * r)) {},
                4 => polygon.glyph.(class) points=(corners(6, 0.0, 1.15 * r)) {},
                _ => polygon.glyph.(class) points=(corners(3, 0.5, 1.35 * r)) {},
            }
        }
    }

    /// Legend of the joints named: mark and name.
    pub fn legend<'n>(&self, names: impl Iterator<Item = &'n str>) -> Markup {
        let mut seen: Vec<&str> = Vec::new();
        for n in names {
            if !seen.contains(&n) {
                seen.push(n);
            }
        }
        seen.sort_by_key(|n| self.index(n).unwrap_or(usize::MAX));
        html! {
            @if !seen.is_empty() {
                ul.legend {
                    @for name in seen.iter().take(24) {
                        li {
                            svg.key viewBox="0 0 14 14" aria-hidden="true" { (self.glyph(name, 7.0, 7.5, 4.5)) }
                            (name) " reverses"
                        }
                    }
                }
            }
        }
    }
}

/// A joint's name with the direction in which it turns.
pub fn turning(joint: &str, sense: i8) -> String {
    match sense.signum() {
        1 => format!("{joint}\u{2191}"),
        -1 => format!("{joint}\u{2193}"),
        _ => joint.to_owned(),
    }
}

/// Longest name that stands beside a mark in a round drawing, letters; longer ones are in the legend alone.
const SHORT: usize = 8;

/// Whether the names of all marks are short enough to stand beside them.
pub fn all_short<'a>(mut names: impl Iterator<Item = &'a str>) -> bool {
    names.all(|n| n.chars().count() < SHORT)
}
