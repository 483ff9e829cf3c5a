//! What figures and tables take. Joint positions are in degrees or millimetres (`_deg_mm`: the joint's kind decides), joint
//! errors and gaps in thousandths of that (`_milli`: mdeg or µm), errors at the TCP in µm. Joints are named as in
//! [`super::Page::joints`]; a name that is not there is shown as it is, without a colour.
//!
//! Series that belong together have one length; where they do not, what is beyond the shortest is not drawn.
//!
//! Parts:
//! - [`rows`]: rows of tables.

mod rows;

pub use rows::{CompensatorRow, GapRow, ReversalRow, ReversalValue, ReversalsView, StictionRow};

/// Which of the compared runs: fixes colour and line on the whole page.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Role {
    /// Without compensation.
    #[default]
    Before,
    /// Another compensator that is compared.
    Between,
    /// The result.
    After,
}

/// A run and what the page calls it: "without", "paper's Table 3", "this tool".
#[derive(Debug, Clone, Default)]
pub struct Run {
    /// Name in the legend.
    pub name: String,
    /// What the run is among the others; it chooses the colour.
    pub role: Role,
}

impl Run {
    /// A run with its name and role.
    pub fn new(name: impl Into<String>, role: Role) -> Self {
        Self { name: name.into(), role }
    }
}

/// Nominal and measured paths, the error exaggerated.
#[derive(Debug, Clone)]
pub struct PathView {
    /// Factor of the drawn errors (Zhang (2023) figure 11: 400).
    pub exaggeration: f64,
    /// Points of the commanded path, mm.
    pub nominal_mm: Vec<[f64; 3]>,
    /// Measured runs.
    pub runs: Vec<PathRun>,
    /// Places to mark on the path.
    pub marks: Vec<PathMark>,
    /// The nominal points are joints of an arm: a thick line, each point marked.
    pub is_arm: bool,
}

/// A measured path: drawn at `reference_mm + exaggeration * error_um / 1000`.
#[derive(Debug, Clone, Default)]
pub struct PathRun {
    /// Name and role.
    pub run: Run,
    /// Points of the path that errors are drawn from, mm.
    pub reference_mm: Vec<[f64; 3]>,
    /// Error at each of these points, um.
    pub error_um: Vec<[f64; 3]>,
}

/// A reversal on the path; `sense` is the joint's new direction (+1, -1).
#[derive(Debug, Clone, Default)]
pub struct PathMark {
    /// Name of the joint that reverses.
    pub joint: String,
    /// Place of the reversal, mm.
    pub at_mm: [f64; 3],
    /// Direction after the reversal, -1 or 1.
    pub sense: i8,
}

/// Errors against the best-fit circle over the circle's angle: three polar plots.
#[derive(Debug, Clone, Default)]
pub struct PolarView {
    /// Measured runs.
    pub runs: Vec<PolarRun>,
    /// Angles to mark.
    pub marks: Vec<AngleMark>,
}

/// Deviations of one run over the angle.
#[derive(Debug, Clone, Default)]
pub struct PolarRun {
    /// Name and role.
    pub run: Run,
    /// Angle of each point on the circle, deg.
    pub angle_deg: Vec<f64>,
    /// 2-norm of the two parts.
    pub total_um: Vec<f64>,
    /// Radial, outwards positive.
    pub in_plane_um: Vec<f64>,
    /// Deviation across the plane at each angle, um.
    pub out_of_plane_um: Vec<f64>,
}

/// A reversal at an angle of the circle.
#[derive(Debug, Clone, Default)]
pub struct AngleMark {
    /// Name of the joint that reverses.
    pub joint: String,
    /// Angle on the circle, deg.
    pub at_deg: f64,
    /// Direction after the reversal, -1 or 1.
    pub sense: i8,
}

/// Joint errors over time, command or travel: one row of panels a joint, one scale a row.
#[derive(Debug, Clone, Default)]
pub struct TracesView {
    /// "time", "command of the joint", "time since the reversal".
    pub x_name: String,
    /// "s", "deg", "mm", "points".
    pub x_unit: String,
    /// What is on the vertical axis; empty: "error". Its unit is the joint's thousandth, or the joint's own.
    pub y_name: String,
    /// The values are in deg or mm, not in thousandths of them.
    pub y_whole: bool,
    /// Joints in the order of the robot.
    pub joints: Vec<JointTraces>,
}

/// Errors of one joint.
#[derive(Debug, Clone, Default)]
pub struct JointTraces {
    /// Name of the joint.
    pub joint: String,
    /// Pictures of this joint.
    pub panels: Vec<TracePanel>,
}

/// One picture of a joint's errors.
#[derive(Debug, Clone, Default)]
pub struct TracePanel {
    /// "without compensation", "at -12.3 deg, turning up".
    pub title: String,
    /// Runs in this picture.
    pub runs: Vec<TraceRun>,
    /// Reversals to mark.
    pub marks: Vec<TraceMark>,
}

/// Measured errors as points, the model as a line.
#[derive(Debug, Clone, Default)]
pub struct TraceRun {
    /// Name and role.
    pub run: Run,
    /// Abscissa of each row.
    pub x: Vec<f64>,
    /// Error at each row, thousandths of deg or mm unless [`TracesView::y_whole`].
    pub error_milli: Vec<f64>,
    /// Empty: no model is drawn.
    pub model_x: Vec<f64>,
    /// The same by the fitted model, in the same unit.
    pub model_milli: Vec<f64>,
}

/// A reversal of a joint (the panel's own or another) on the horizontal axis.
#[derive(Debug, Clone, Default)]
pub struct TraceMark {
    /// Name of the joint that reverses.
    pub joint: String,
    /// Abscissa of the reversal.
    pub x: f64,
    /// Direction after the reversal, -1 or 1.
    pub sense: i8,
}

/// What the curves of a [`GapsView`] stand over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum GapsOver {
    /// Half gap over the position of the joint.
    #[default]
    Position,
    /// Lost motion over the time since a reversal, s.
    SinceReversal,
}

/// Half gap over position or lost motion over time, one panel a joint.
#[derive(Debug, Clone, Default)]
pub struct GapsView {
    /// What the curves stand over.
    pub over: GapsOver,
    /// Joints in the order of the robot.
    pub joints: Vec<JointGapView>,
}

/// Half gaps of one joint over position.
#[derive(Debug, Clone, Default)]
pub struct JointGapView {
    /// Name of the joint.
    pub joint: String,
    /// A few words beside the joint's name: "constant", "varies, p < 0.001".
    pub finding: String,
    /// Half gaps at tested places.
    pub points: Vec<GapPointView>,
    /// Where one value holds everywhere: it and its 95 % interval.
    pub constant_milli: Option<(f64, [f64; 2])>,
    /// Where it does not: the schedule, sampled.
    pub schedule: Option<ScheduleView>,
}

/// Half gap at one place.
#[derive(Debug, Clone, Default)]
pub struct GapPointView {
    /// Position of the joint, deg or mm.
    pub at_deg_mm: f64,
    /// Half gap, thousandths of deg or mm.
    pub half_gap_milli: f64,
    /// Its 95 % interval, thousandths of deg or mm.
    pub ci95_milli: [f64; 2],
    /// Half gap of each cycle, thousandths of deg or mm.
    pub per_cycle_milli: Vec<f64>,
}

/// A curve of half gaps over position.
#[derive(Debug, Clone, Default)]
pub struct ScheduleView {
    /// Positions of the joint, deg or mm.
    pub at_deg_mm: Vec<f64>,
    /// Half gap at each position, thousandths of deg or mm.
    pub half_gap_milli: Vec<f64>,
    /// Empty, or 95 % band.
    pub band_milli: Vec<[f64; 2]>,
}

/// Distribution of the total error; the page chooses the bins.
#[derive(Debug, Clone, Default)]
pub struct HistogramView {
    /// "total error".
    pub quantity: String,
    /// "µm".
    pub unit: String,
    /// Runs that are compared.
    pub runs: Vec<HistogramRun>,
}

/// Values of one run.
#[derive(Debug, Clone, Default)]
pub struct HistogramRun {
    /// Name and role.
    pub run: Run,
    /// The values, in the unit of the histogram.
    pub values: Vec<f64>,
    /// Marked on the axis where given.
    pub p95: Option<f64>,
}

/// Bars in groups: the same quantity of several runs.
#[derive(Debug, Clone, Default)]
pub struct BarsView {
    /// What the bars show, for the axis.
    pub quantity: String,
    /// Unit of the values.
    pub unit: String,
    /// Runs that are compared: one bar of each in every row.
    pub runs: Vec<Run>,
    /// Rows from top to bottom.
    pub rows: Vec<BarRow>,
}

/// Bars of one row.
#[derive(Debug, Clone, Default)]
pub struct BarRow {
    /// Label of the row.
    pub label: String,
    /// One per run; a missing one stays empty.
    pub values: Vec<Option<f64>>,
}

/// A quantity that falls step by step.
#[derive(Debug, Clone, Default)]
pub struct WaterfallView {
    /// What the steps show, for the axis.
    pub quantity: String,
    /// Unit of the values.
    pub unit: String,
    /// Name and value of the start.
    pub start: (String, f64),
    /// Name of each step and what is left after it.
    pub steps: Vec<(String, f64)>,
    /// A floor that no step can pass, and its name: ("noise", 11.0).
    pub floor: Option<(String, f64)>,
}

/// Places of a program that were changed; a page shows the first of them and the count.
#[derive(Debug, Clone, Default)]
pub struct PlacesView {
    /// How many there are in all.
    pub total: u64,
    /// Places in their order.
    pub places: Vec<Place>,
}

/// A place of the program that changes.
#[derive(Debug, Clone, Default)]
pub struct Place {
    /// Line of the program that came in; counts from 1.
    pub line: Option<u64>,
    /// Name of the joint.
    pub joint: String,
    /// "reversal", "inserted point".
    pub what: String,
    /// Command at the place.
    pub at_deg_mm: f64,
    /// Change of the target, thousandths of deg or mm.
    pub offset_milli: f64,
}

/// A table of words and written numbers, for what has no separate view.
#[derive(Debug, Clone, Default)]
pub struct TableView {
    /// Headings and whether the column holds numbers (set right).
    pub columns: Vec<(String, bool)>,
    /// Cells of each row, as many as there are headings.
    pub rows: Vec<Vec<String>>,
}

impl TableView {
    /// A table of these headings; `true` where the column holds numbers.
    pub fn new(headings: &[(&str, bool)], rows: impl IntoIterator<Item = Vec<String>>) -> Self {
        let columns = headings.iter().map(|(h, numbers)| ((*h).to_string(), *numbers)).collect();
        Self { columns, rows: rows.into_iter().collect() }
    }

    /// A table whose first `words` columns hold words, the others numbers.
    pub fn numbers_after(words: usize, headings: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> Self {
        let columns: Vec<(&str, bool)> = headings.iter().enumerate().map(|(k, h)| (*h, k >= words)).collect();
        Self::new(&columns, rows)
    }

    /// A table of words.
    pub fn words(headings: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> Self {
        Self::numbers_after(headings.len(), headings, rows)
    }
}
