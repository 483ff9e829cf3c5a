//! What a page takes: its head and its sections. Plain data; figures and tables are in [`super::figures`].

use super::bidirectional::*;
use super::diagnosis::*;
use super::figures::*;
use super::method::Method;
use crate::robot::JointKind;

/// A whole page.
#[derive(Debug, Clone, Default)]
pub struct Page {
    /// What the page is about: "Circle of 250 mm before and after compensation".
    pub title: String,
    /// The command: "assess circle".
    pub command: String,
    /// What was done, in one or two sentences.
    pub summary: String,
    /// The answer, in one line.
    pub verdict: Verdict,
    /// What to do next: about what, and what; stands below the verdict.
    pub next: Vec<(String, String)>,
    /// The robot, where the job has one.
    pub robot: Option<RobotView>,
    /// Joints in the robot's order: their order fixes their colours and marks on the whole page.
    pub joints: Vec<JointView>,
    /// Files that were read.
    pub files: Vec<FileView>,
    /// Options and their values, as a reader would type them.
    pub options: Vec<(String, String)>,
    /// Figures that stand at the top.
    pub tiles: Vec<Tile>,
    /// What a reader must know before the rest.
    pub warnings: Vec<String>,
    /// Sections in the order of the page.
    pub sections: Vec<Section>,
}

/// The answer in one sentence.
#[derive(Debug, Clone, Default)]
pub struct Verdict {
    /// Whether the answer is good or bad.
    pub tone: Tone,
    /// The answer in words.
    pub text: String,
}

/// How an answer is meant; drawn as a sign and a colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Tone {
    #[default]
    /// Neither good nor bad.
    Plain,
    /// The answer is yes.
    Good,
    /// The answer is yes with reservations.
    Mixed,
    /// The answer is no.
    Bad,
}

/// The robot of a page.
#[derive(Debug, Clone, Default)]
pub struct RobotView {
    /// Name of the file.
    pub name: String,
    /// SHA-256 of the file, hexadecimal.
    pub sha256: String,
}

/// A joint: its unit is the degree or the millimetre, its errors are in thousandths of that (mdeg, µm).
#[derive(Debug, Clone)]
pub struct JointView {
    /// Name of the joint.
    pub name: String,
    /// Revolute or prismatic.
    pub kind: JointKind,
    /// Its gaps are so large that the page shows them in degrees (a tendon's, not a gear's).
    pub wide_gaps: bool,
}

/// A file that was read or written.
#[derive(Debug, Clone, Default)]
pub struct FileView {
    /// "robot", "log before", "program out", ...
    pub role: String,
    /// Name of the robot.
    pub name: String,
    /// Lower-case hex; shown short, whole on hovering.
    pub sha256: String,
}

/// A key figure.
#[derive(Debug, Clone, Default)]
pub struct Tile {
    /// What the figure is.
    pub label: String,
    /// The figure, as printed.
    pub value: String,
    /// Its unit.
    pub unit: String,
    /// A few words: what it was before, where it stands.
    pub detail: String,
}

/// A section: a finding, how it was measured, and what shows it.
#[derive(Debug, Clone)]
pub struct Section {
    /// The finding, as a sentence; empty: the name of the content stands alone.
    pub title: String,
    /// How it was measured.
    pub caption: String,
    /// What the section shows.
    pub content: Content,
}

/// What a section holds.
#[derive(Debug, Clone)]
pub enum Content {
    /// A path in space with magnified errors.
    Path(PathView),
    /// Deviations over the angle of a circle.
    Polar(PolarView),
    /// Errors of joints over time or position.
    Traces(TracesView),
    /// Traces of logs one below the other.
    Strips(StripsView),
    /// A path whose colour shows a value.
    HeatPath(HeatPathView),
    /// Errors of joints over position, both ways.
    Ways(WaysView),
    /// Sizes of effects by joint and kind.
    Map(MapView),
    /// Half gaps over position.
    Gaps(GapsView),
    /// Errors over position, both ways, by state.
    BothWays(BothWaysView),
    /// Backlash over position, by state.
    BacklashCurves(BacklashCurvesView),
    /// How often values of each size occur.
    Histogram(HistogramView),
    /// Bars that compare runs.
    Bars(BarsView),
    /// What each effect takes off the residual.
    Waterfall(WaterfallView),
    /// Errors at reversals.
    Reversals(ReversalsView),
    /// Half gaps as a table.
    GapTable(Vec<GapRow>),
    /// What a compensator holds, as a table.
    Compensator(Vec<CompensatorRow>),
    /// Places of a program that change.
    Places(PlacesView),
    /// A table of words.
    Table(TableView),
    /// Notes, one line each.
    Notes(Vec<String>),
    /// Methods, with references.
    Method(Vec<Method>),
}

/// The name of a file as a page shows it: without the folders of an absolute path, which are private.
pub fn file_name(name: &str) -> String {
    let path = std::path::Path::new(name);
    let short = path.file_name().filter(|_| path.is_absolute());
    short.map_or_else(|| name.to_string(), |n| n.to_string_lossy().into_owned())
}

impl Page {
    /// A page without sections.
    pub fn new(command: impl Into<String>, title: impl Into<String>) -> Self {
        Self { command: command.into(), title: title.into(), ..Self::default() }
    }

    /// Sets the verdict.
    pub fn verdict(&mut self, tone: Tone, text: impl Into<String>) -> &mut Self {
        self.verdict = Verdict { tone, text: text.into() };
        self
    }

    /// Adds a joint; call in the robot's order.
    pub fn joint(&mut self, name: impl Into<String>, kind: JointKind) -> &mut Self {
        self.joints.push(JointView { name: name.into(), kind, wide_gaps: false });
        self
    }

    /// Adds a file; of an absolute path only the name, as a page is passed on and folders are private.
    pub fn file(&mut self, role: impl Into<String>, name: impl Into<String>, sha256: impl Into<String>) -> &mut Self {
        self.files.push(FileView { role: role.into(), name: file_name(&name.into()), sha256: sha256.into() });
        self
    }

    /// Adds an option.
    pub fn option(&mut self, name: impl Into<String>, value: impl Into<String>) -> &mut Self {
        self.options.push((name.into(), value.into()));
        self
    }

    /// Adds a key figure.
    pub fn tile(&mut self, tile: Tile) -> &mut Self {
        self.tiles.push(tile);
        self
    }

    /// Adds a section: its finding, how it was measured, and what shows it.
    pub fn section(
        &mut self,
        title: impl Into<String>,
        caption: impl Into<String>,
        content: impl Into<Content>,
    ) -> &mut Self {
        self.sections.push(Section { title: title.into(), caption: caption.into(), content: content.into() });
        self
    }

    /// Puts the last section before all others: the figure that shows the answer.
    pub fn last_first(&mut self) {
        self.sections.rotate_right(1);
    }
}

impl Tile {
    /// A number with its unit; what is not finite shows as a dash.
    pub fn number(label: impl Into<String>, value: f64, decimals: usize, unit: impl Into<String>) -> Self {
        Self::text(label, super::number(value, decimals), unit)
    }

    /// A word or a number that is written already.
    pub fn text(label: impl Into<String>, value: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { label: label.into(), value: value.into(), unit: unit.into(), detail: String::new() }
    }

    /// Adds a few words below the figure.
    pub fn with_detail(mut self, detail: impl Into<String>) -> Self {
        self.detail = detail.into();
        self
    }
}

impl Content {
    /// Whether two such sections stand side by side on a wide screen.
    pub(super) fn is_narrow(&self) -> bool {
        use Content::*;
        matches!(self, Histogram(_) | Bars(_) | Waterfall(_) | Places(_) | Notes(_))
    }

    /// What kind of section it is, in a few words.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Path(_) => "Path in space",
            Self::Polar(_) => "Error around the circle",
            Self::Traces(v) if v.y_whole => "Joint positions",
            Self::Traces(_) => "Joint errors",
            Self::Strips(_) => "The gap over time",
            Self::HeatPath(_) => "The gap on the path",
            Self::Ways(_) => "Joint by joint, both ways",
            Self::Map(_) => "Map",
            Self::Gaps(GapsView { over: GapsOver::Position, .. }) => "Gap over position",
            Self::Gaps(_) => "After a reversal",
            Self::BothWays(_) => "Errors in both directions",
            Self::BacklashCurves(_) => "Backlash over position",
            Self::Histogram(_) => "Distribution of the error",
            Self::Bars(_) => "Comparison",
            Self::Waterfall(_) => "What each step takes away",
            Self::Reversals(_) => "Errors at the reversals",
            Self::GapTable(_) => "Gaps and stiction",
            Self::Compensator(_) => "Compensator",
            Self::Places(_) => "Rewritten places",
            Self::Table(_) => "Table",
            Self::Notes(_) => "Notes",
            Self::Method(_) => "Method",
        }
    }
}

macro_rules! content_from {
    ($($from:ty => $variant:ident),* $(,)?) => {
        $(impl From<$from> for Content {
            fn from(view: $from) -> Self {
                Self::$variant(view)
            }
        })*
    };
}

content_from! {
    PathView => Path,
    PolarView => Polar,
    TracesView => Traces,
    StripsView => Strips,
    HeatPathView => HeatPath,
    WaysView => Ways,
    MapView => Map,
    GapsView => Gaps,
    BothWaysView => BothWays,
    BacklashCurvesView => BacklashCurves,
    HistogramView => Histogram,
    BarsView => Bars,
    WaterfallView => Waterfall,
    ReversalsView => Reversals,
    Vec<GapRow> => GapTable,
    Vec<CompensatorRow> => Compensator,
    PlacesView => Places,
    TableView => Table,
    Vec<String> => Notes,
    Vec<Method> => Method,
}
