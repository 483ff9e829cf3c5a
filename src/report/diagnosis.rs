//! What the figures of a diagnosis take: strips and paths coloured by the gap, residuals in both directions, maps.
//!
//! Units as in [`super::figures`]; a coloured quantity brings its unit with it.

use super::figures::{PathMark, TraceMark};

/// A quantity over time as lanes of colour, log by log.
#[derive(Debug, Clone, Default)]
pub struct StripsView {
    pub quantity: String,
    pub unit: String,
    /// The colours reach at least this far: noise alone shall not look like a gap.
    pub at_least: f64,
    pub logs: Vec<StripLog>,
}

#[derive(Debug, Clone, Default)]
pub struct StripLog {
    pub name: String,
    /// "time, s" or "pose".
    pub x_title: String,
    pub x: Vec<f64>,
    pub lanes: Vec<Lane>,
}

/// One lane: a value per `x` of the log, and where joints reverse.
#[derive(Debug, Clone, Default)]
pub struct Lane {
    pub name: String,
    pub values: Vec<f64>,
    pub marks: Vec<TraceMark>,
}

/// The path in space, coloured by a quantity; panels share scale and colours.
#[derive(Debug, Clone, Default)]
pub struct HeatPathView {
    pub quantity: String,
    pub unit: String,
    pub at_least: f64,
    pub panels: Vec<HeatPath>,
}

#[derive(Debug, Clone, Default)]
pub struct HeatPath {
    pub title: String,
    pub at_mm: Vec<[f64; 3]>,
    pub values: Vec<f64>,
    /// Settled poses: dots, no line between them.
    pub dots: bool,
    pub marks: Vec<PathMark>,
}

/// A joint's error over its position, moving up and moving down; the panels of a joint share their scales.
#[derive(Debug, Clone, Default)]
pub struct WaysView {
    pub joints: Vec<JointWays>,
}

#[derive(Debug, Clone, Default)]
pub struct JointWays {
    pub joint: String,
    pub panels: Vec<WaysPanel>,
}

#[derive(Debug, Clone, Default)]
pub struct WaysPanel {
    pub title: String,
    pub up: WayView,
    pub down: WayView,
}

/// Quartiles over position.
#[derive(Debug, Clone, Default)]
pub struct WayView {
    pub at_deg_mm: Vec<f64>,
    pub quartiles_milli: Vec<[f64; 3]>,
}

/// Tables whose cells are coloured by a quantity; the tables share the colours.
#[derive(Debug, Clone, Default)]
pub struct MapView {
    /// What the colour means; empty: there is none.
    pub quantity: String,
    pub unit: String,
    /// Colours by the logarithm: what differs by less than a decade looks alike.
    pub by_decades: bool,
    /// What a hatched cell means.
    pub hatched: String,
    pub blocks: Vec<MapBlock>,
}

#[derive(Debug, Clone, Default)]
pub struct MapBlock {
    /// Heading of the rows: "joint".
    pub corner: String,
    /// Name and unit.
    pub columns: Vec<(String, String)>,
    pub rows: Vec<(String, Vec<MapCell>)>,
}

#[derive(Debug, Clone, Default, PartialEq)]
pub enum MapCell {
    /// Nothing stands here.
    #[default]
    Absent,
    /// A word, without a colour.
    Word(String),
    /// Hatched.
    Hatched,
    /// A written number and the quantity that colours it.
    Size { text: String, colour: f64 },
}
