//! What the figures of a diagnosis take: strips and paths coloured by the gap, residuals in both directions, maps.
//!
//! Units as in [`super::figures`]; a coloured quantity brings its unit with it.

use super::figures::{PathMark, TraceMark};

/// A quantity over time as lanes of colour, log by log.
#[derive(Debug, Clone, Default)]
pub struct StripsView {
    /// What the values are, for the axis.
    pub quantity: String,
    /// Unit of the values.
    pub unit: String,
    /// The colours reach at least this far: noise alone shall not look like a gap.
    pub at_least: f64,
    /// One strip for each log.
    pub logs: Vec<StripLog>,
}

/// Traces of one log over its rows or time.
#[derive(Debug, Clone, Default)]
pub struct StripLog {
    /// Name of the log.
    pub name: String,
    /// "time, s" or "pose".
    pub x_title: String,
    /// Abscissa of all lanes.
    pub x: Vec<f64>,
    /// Lanes from top to bottom.
    pub lanes: Vec<Lane>,
}

/// One lane: a value per `x` of the log, and where joints reverse.
#[derive(Debug, Clone, Default)]
pub struct Lane {
    /// Name of the channel.
    pub name: String,
    /// One value per abscissa.
    pub values: Vec<f64>,
    /// Reversals to mark.
    pub marks: Vec<TraceMark>,
}

/// The path in space, coloured by a quantity; panels share scale and colours.
#[derive(Debug, Clone, Default)]
pub struct HeatPathView {
    /// What the colours show.
    pub quantity: String,
    /// Unit of the values.
    pub unit: String,
    /// Least value of the upper end of the colour scale.
    pub at_least: f64,
    /// One picture for each log.
    pub panels: Vec<HeatPath>,
}

/// A path whose colour shows a value.
#[derive(Debug, Clone, Default)]
pub struct HeatPath {
    /// Title of the picture.
    pub title: String,
    /// Points of the path, mm.
    pub at_mm: Vec<[f64; 3]>,
    /// One value per point.
    pub values: Vec<f64>,
    /// Settled poses: dots, no line between them.
    pub dots: bool,
    /// Places to mark on the path.
    pub marks: Vec<PathMark>,
}

/// A joint's error over its position, moving up and moving down; the panels of a joint share their scales.
#[derive(Debug, Clone, Default)]
pub struct WaysView {
    /// Joints in the order of the robot.
    pub joints: Vec<JointWays>,
}

/// Errors of one joint by its direction.
#[derive(Debug, Clone, Default)]
pub struct JointWays {
    /// Name of the joint.
    pub joint: String,
    /// One picture for each log or channel.
    pub panels: Vec<WaysPanel>,
}

/// Errors over position, both ways.
#[derive(Debug, Clone, Default)]
pub struct WaysPanel {
    /// Title of the picture.
    pub title: String,
    /// Movement with rising values.
    pub up: WayView,
    /// Movement with falling values.
    pub down: WayView,
}

/// Quartiles over position.
#[derive(Debug, Clone, Default)]
pub struct WayView {
    /// Middle of each class of positions, deg or mm.
    pub at_deg_mm: Vec<f64>,
    /// Lower quartile, median and upper quartile in each class, thousandths of deg or mm.
    pub quartiles_milli: Vec<[f64; 3]>,
}

/// Tables whose cells are coloured by a quantity; the tables share the colours.
#[derive(Debug, Clone, Default)]
pub struct MapView {
    /// What the colour means; empty: there is none.
    pub quantity: String,
    /// Unit of the sizes.
    pub unit: String,
    /// Colours by the logarithm: what differs by less than a decade looks the same.
    pub by_decades: bool,
    /// What a hatched cell means.
    pub hatched: String,
    /// Groups of rows.
    pub blocks: Vec<MapBlock>,
}

/// Rows of the map that belong together.
#[derive(Debug, Clone, Default)]
pub struct MapBlock {
    /// Heading of the rows: "joint".
    pub corner: String,
    /// Name and unit.
    pub columns: Vec<(String, String)>,
    /// Label and cells of each row.
    pub rows: Vec<(String, Vec<MapCell>)>,
}

/// A cell of the map.
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
    Size {
        /// The number as it is printed.
        text: String,
        /// The quantity, in the unit of the map.
        colour: f64,
    },
}
