//! The document `lostmotion/program-assessment/1`.

use super::{Assessment, AtTargets, Figures, Note, ReversalError};
use crate::error::counted;
use crate::io::keyed::Keyed;
use crate::io::rounded::{round, um};
use crate::program::Moves;
use crate::robot::Robot;
use serde::Serialize;

pub const SCHEMA: &str = "lostmotion/program-assessment/1";

/// A figure of the program before and after the change.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Pair<T> {
    pub before: T,
    pub after: T,
}

/// The figures of a comparison; micrometres are distances of the TCP to the reference path.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct FiguresShown {
    pub rms_um: Pair<f64>,
    pub mean_um: Pair<f64>,
    pub largest_um: Pair<f64>,
    /// Most that the error after a single reversal grew.
    pub worst_reversal_growth_um: f64,
    /// The verdict on the whole way.
    pub verdict_on_the_way: &'static str,
    /// At the targets of a vendor program alone; null where none stands apart from others.
    pub at_targets: Option<AtTargetsShown>,
    pub cycle_time_s: Pair<f64>,
    pub points: Pair<usize>,
    pub stops: Pair<usize>,
}

/// Errors at the targets of a vendor program: distances of the TCP to where it should be.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct AtTargetsShown {
    pub verdict: &'static str,
    pub targets: usize,
    pub rms_um: Pair<f64>,
    pub largest_um: Pair<f64>,
}

/// What `assess program --json` prints.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Document {
    schema: &'static str,
    robot: RobotShown,
    before: String,
    after: String,
    verdict: &'static str,
    path_length_mm: f64,
    reversals: Vec<ReversalShown>,
    /// How much of a vendor program is in the verdict.
    #[serde(skip_serializing_if = "Option::is_none")]
    moves: Option<MovesShown>,
    #[schemars(with = "Vec<String>")]
    notes: Vec<Note>,
    #[serde(flatten)]
    figures: FiguresShown,
}

/// Moves of a vendor program, by what is known of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct MovesShown {
    pub all: usize,
    pub in_verdict: usize,
    pub from_unknown_place: usize,
    pub to_unknown_place: usize,
}

impl MovesShown {
    pub fn of(moves: Moves) -> Self {
        let Moves { all, known, unknown_start, .. } = moves;
        let left = all.saturating_sub(known + unknown_start);
        Self { all, in_verdict: known, from_unknown_place: unknown_start, to_unknown_place: left }
    }

    /// For people.
    pub fn text(&self) -> String {
        let Self { all, in_verdict, from_unknown_place, to_unknown_place } = self;
        format!(
            "of {}, {in_verdict} in the verdict; {from_unknown_place} from an unknown position, {to_unknown_place} to one",
            counted(*all, "move")
        )
    }
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
struct RobotShown {
    name: String,
    sha256: String,
}

#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct ReversalShown {
    joint: String,
    t_s: f64,
    #[serde(flatten)]
    command: Keyed<f64>,
    direction: i8,
    before_um: f64,
    after_um: f64,
}

/// The figures alone, as `rewrite` reports them.
pub fn figures(f: &Figures) -> FiguresShown {
    let pair = |v: [f64; 2]| Pair { before: um(v[0]), after: um(v[1]) };
    let count = |[before, after]: [usize; 2]| Pair { before, after };
    let at_targets = |a: AtTargets| AtTargetsShown {
        verdict: a.verdict().text(),
        targets: a.targets,
        rms_um: pair(a.rms_m),
        largest_um: pair(a.largest_m),
    };
    FiguresShown {
        rms_um: pair(f.rms_m),
        mean_um: pair(f.mean_m),
        largest_um: pair(f.largest_m),
        worst_reversal_growth_um: um(f.worst_reversal_growth_m),
        verdict_on_the_way: f.on_the_way().text(),
        at_targets: f.at_targets.map(at_targets),
        cycle_time_s: Pair { before: round(f.cycle_s[0], 6), after: round(f.cycle_s[1], 6) },
        points: count(f.points),
        stops: count(f.stops),
    }
}

pub fn reversal(r: &ReversalError, robot: &Robot) -> ReversalShown {
    let joint = robot.axis(r.axis);
    ReversalShown {
        joint: joint.name.clone(),
        t_s: round(r.at_s, 4),
        command: Keyed::new("command", joint.kind.unit(), round(joint.kind.to_user_unit(r.command), 6)),
        direction: r.direction,
        before_um: um(r.before_m),
        after_um: um(r.after_m),
    }
}

impl Assessment {
    /// The document; micrometres are distances of the TCP to the reference path.
    pub fn document(&self, robot: &Robot) -> Document {
        Document {
            schema: SCHEMA,
            robot: RobotShown { name: robot.name.clone(), sha256: robot.fingerprint() },
            before: self.before.name.clone(),
            after: self.after.name.clone(),
            verdict: self.verdict.text(),
            path_length_mm: round(self.before.length_m * 1e3, 4),
            reversals: self.reversals.iter().map(|r| reversal(r, robot)).collect(),
            moves: self.moves.map(MovesShown::of),
            notes: self.notes.clone(),
            figures: figures(&self.figures),
        }
    }
}
