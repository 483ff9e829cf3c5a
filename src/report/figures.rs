//! What figures and tables take. Joint positions are in degrees or millimetres (`_deg_mm`: the joint's kind decides), joint
//! errors and gaps in thousandths of that (`_milli`: mdeg or µm), errors at the TCP in µm. Joints are named as in
//! [`super::Page::joints`]; a name that is not there is shown as it is, without a colour.
//!
//! Series that belong together have one length; where they do not, what is beyond the shortest is not drawn.

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
    pub name: String,
    pub role: Role,
}

impl Run {
    pub fn new(name: impl Into<String>, role: Role) -> Self {
        Self { name: name.into(), role }
    }
}

/// Nominal and measured paths, the error exaggerated.
#[derive(Debug, Clone)]
pub struct PathView {
    /// Factor of the drawn errors (Zhang (2023) figure 11: 400).
    pub exaggeration: f64,
    pub nominal_mm: Vec<[f64; 3]>,
    pub runs: Vec<PathRun>,
    pub marks: Vec<PathMark>,
    /// The nominal points are joints of an arm: a thick line, each point marked.
    pub is_arm: bool,
}

/// A measured path: drawn at `reference_mm + exaggeration * error_um / 1000`.
#[derive(Debug, Clone, Default)]
pub struct PathRun {
    pub run: Run,
    pub reference_mm: Vec<[f64; 3]>,
    pub error_um: Vec<[f64; 3]>,
}

/// A reversal on the path; `sense` is the joint's new direction (+1, -1).
#[derive(Debug, Clone, Default)]
pub struct PathMark {
    pub joint: String,
    pub at_mm: [f64; 3],
    pub sense: i8,
}

/// Errors against the best-fit circle over the circle's angle: three polar plots.
#[derive(Debug, Clone, Default)]
pub struct PolarView {
    pub runs: Vec<PolarRun>,
    pub marks: Vec<AngleMark>,
}

#[derive(Debug, Clone, Default)]
pub struct PolarRun {
    pub run: Run,
    pub angle_deg: Vec<f64>,
    /// 2-norm of the two parts.
    pub total_um: Vec<f64>,
    /// Radial, outwards positive.
    pub in_plane_um: Vec<f64>,
    pub out_of_plane_um: Vec<f64>,
}

/// A reversal at an angle of the circle.
#[derive(Debug, Clone, Default)]
pub struct AngleMark {
    pub joint: String,
    pub at_deg: f64,
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
    pub y_whole: bool,
    pub joints: Vec<JointTraces>,
}

#[derive(Debug, Clone, Default)]
pub struct JointTraces {
    pub joint: String,
    pub panels: Vec<TracePanel>,
}

#[derive(Debug, Clone, Default)]
pub struct TracePanel {
    /// "without compensation", "at -12.3 deg, turning up".
    pub title: String,
    pub runs: Vec<TraceRun>,
    pub marks: Vec<TraceMark>,
}

/// Measured errors as points, the model as a line.
#[derive(Debug, Clone, Default)]
pub struct TraceRun {
    pub run: Run,
    pub x: Vec<f64>,
    pub error_milli: Vec<f64>,
    /// Empty: no model is drawn.
    pub model_x: Vec<f64>,
    pub model_milli: Vec<f64>,
}

/// A reversal of a joint (the panel's own or another) on the horizontal axis.
#[derive(Debug, Clone, Default)]
pub struct TraceMark {
    pub joint: String,
    pub x: f64,
    pub sense: i8,
}

/// Half gap over position, one panel a joint.
#[derive(Debug, Clone, Default)]
pub struct GapsView {
    pub joints: Vec<JointGapView>,
}

#[derive(Debug, Clone, Default)]
pub struct JointGapView {
    pub joint: String,
    /// A few words beside the joint's name: "constant", "varies, p < 0.001".
    pub finding: String,
    pub points: Vec<GapPointView>,
    /// Where one value holds everywhere: it and its 95 % interval.
    pub constant_milli: Option<(f64, [f64; 2])>,
    /// Where it does not: the schedule, sampled.
    pub schedule: Option<ScheduleView>,
}

#[derive(Debug, Clone, Default)]
pub struct GapPointView {
    pub at_deg_mm: f64,
    pub half_gap_milli: f64,
    pub ci95_milli: [f64; 2],
    pub per_cycle_milli: Vec<f64>,
}

#[derive(Debug, Clone, Default)]
pub struct ScheduleView {
    pub at_deg_mm: Vec<f64>,
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
    pub runs: Vec<HistogramRun>,
}

#[derive(Debug, Clone, Default)]
pub struct HistogramRun {
    pub run: Run,
    pub values: Vec<f64>,
    /// Marked on the axis where given.
    pub p95: Option<f64>,
}

/// Bars in groups: the same quantity of several runs.
#[derive(Debug, Clone, Default)]
pub struct BarsView {
    pub quantity: String,
    pub unit: String,
    pub runs: Vec<Run>,
    pub rows: Vec<BarRow>,
}

#[derive(Debug, Clone, Default)]
pub struct BarRow {
    pub label: String,
    /// One per run; a missing one stays empty.
    pub values: Vec<Option<f64>>,
}

/// A quantity that falls step by step.
#[derive(Debug, Clone, Default)]
pub struct WaterfallView {
    pub quantity: String,
    pub unit: String,
    /// Name and value of the start.
    pub start: (String, f64),
    /// Name of each step and what is left behind it.
    pub steps: Vec<(String, f64)>,
    /// A floor that no step can pass, and its name: ("noise", 11.0).
    pub floor: Option<(String, f64)>,
}

/// Errors at each reversal, side by side for several runs (Zhang (2023) table 5).
#[derive(Debug, Clone, Default)]
pub struct ReversalsView {
    pub runs: Vec<Run>,
    pub rows: Vec<ReversalRow>,
}

#[derive(Debug, Clone, Default)]
pub struct ReversalRow {
    pub joint: String,
    /// Angle of the circle, where the path is one.
    pub at_deg: Option<f64>,
    pub sense: i8,
    /// One per run.
    pub values: Vec<ReversalValue>,
}

#[derive(Debug, Clone, Default)]
pub struct ReversalValue {
    pub total_um: f64,
    /// Beyond what the program's own chords leave.
    pub beyond_nominal_um: Option<f64>,
    /// Share by which the total error fell against the first run.
    pub reduction: Option<f64>,
}

/// A joint's lost motion, for a table.
#[derive(Debug, Clone, Default)]
pub struct GapRow {
    pub joint: String,
    pub half_gap_milli: f64,
    pub ci95_milli: [f64; 2],
    pub significant: bool,
    /// p value of the test that the gap does not vary with position.
    pub varies_p_value: Option<f64>,
    /// TCP error of one half gap at a stated pose, µm.
    pub tcp_um: Option<f64>,
    pub stiction: Option<StictionRow>,
}

#[derive(Debug, Clone, Default)]
pub struct StictionRow {
    pub spike_milli: f64,
    pub ci95_milli: [f64; 2],
    /// Decay and its interval in `decay_unit` (s, deg or mm).
    pub decay: f64,
    pub decay_ci95: [f64; 2],
    pub decay_unit: String,
}

/// A joint of a compensator, for a table.
#[derive(Debug, Clone, Default)]
pub struct CompensatorRow {
    pub joint: String,
    /// Offset moving up and moving down; two ends each where it is scheduled.
    pub positive_milli: Option<[f64; 2]>,
    pub negative_milli: Option<[f64; 2]>,
    /// "constant", "PCHIP, 5 knots", "polynomial of degree 2".
    pub kind: String,
    pub friction_gain_milli: Option<f64>,
    /// "decays over 5.2 s", "equation 17, l = 3, 5 points".
    pub friction_shape: String,
}

/// Something that was not used, and why.
#[derive(Debug, Clone, Default)]
pub struct LeftOut {
    pub what: String,
    pub why: String,
}

/// Places of a program that were changed; a page shows the first of them and the count.
#[derive(Debug, Clone, Default)]
pub struct PlacesView {
    /// How many there are in all.
    pub total: u64,
    pub places: Vec<Place>,
}

#[derive(Debug, Clone, Default)]
pub struct Place {
    /// Line of the program that came in; counts from 1.
    pub line: Option<u64>,
    pub joint: String,
    /// "reversal", "inserted point".
    pub what: String,
    /// Command at the place.
    pub at_deg_mm: f64,
    pub offset_milli: f64,
}

/// A table of words and written numbers, for what has no view of its own.
#[derive(Debug, Clone, Default)]
pub struct TableView {
    /// Headings and whether the column holds numbers (set right).
    pub columns: Vec<(String, bool)>,
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
