//! Arguments of `rewrite`, with their help.
use crate::cli::exit::bad;
use crate::error::Place;
use crate::rewrite::Refine;
use crate::rewrite::equation2::Law;
use std::path::PathBuf;

/// Add reversal points and offsets to a robot program.
///
/// After each reversal of a joint, its command steps across the gap, so that the joint itself keeps moving; a friction
/// offset is added and fades. Only the numbers of motion targets are changed, and points are added; every other byte of the
/// program stays as it is. If a joint limit would be exceeded, nothing is written. Programs can be joint-space CSV, Yaskawa
/// INFORM, ABB RAPID, KUKA KRL, FANUC TP, URScript, ROS trajectories, or G-code.
///
/// Examples:
///   lostmotion rewrite --robot robot.yaml --compensator comp.yaml program.csv --output out.csv
///   lostmotion rewrite --robot robot.yaml --compensator comp.yaml program.csv --dry-run
///   lostmotion rewrite --model machine.yaml program.csv --output out.csv --speed-mm-s 10
///   lostmotion rewrite --robot robot.yaml --compensator comp.yaml cell/ --output-dir done/ --summary summary.jsonl
#[derive(Debug, clap::Args)]
#[command(
    verbatim_doc_comment,
    override_usage = "lostmotion rewrite [OPTIONS] --robot <FILE> --compensator <FILE> --output <FILE> <IN>\n       lostmotion rewrite [OPTIONS] --robot <FILE> --compensator <FILE> --output-dir <FOLDER> <IN_FOLDER>\n       lostmotion rewrite [OPTIONS] --model <FILE> <--output <FILE>|--output-dir <FOLDER>> <IN>\n       lostmotion rewrite [OPTIONS] ... <--check <GOLDEN>|--dry-run> <IN>"
)]
pub struct Args {
    /// Program (joint-space CSV with a1_deg,a2_deg,... and optionally t_s, or a vendor program), `-` for standard input, or
    /// a folder of programs; with --manifest also s3://BUCKET/PREFIX (in builds with the feature `cloud`)
    #[arg(value_name = "IN")]
    pub input: PathBuf,

    /// Robot file (YAML); it must describe the robot for which the compensator was made
    #[arg(long, value_name = "FILE", required_unless_present = "model", requires = "compensator")]
    pub robot: Option<PathBuf>,

    /// Compensator file (YAML) from `fit`
    #[arg(long, value_name = "FILE", required_unless_present = "model", requires = "robot")]
    pub compensator: Option<PathBuf>,

    /// Model file (YAML): compensate every effect in it that joint offsets can undo; instead of --robot and --compensator
    #[arg(long, value_name = "FILE", conflicts_with_all = ["robot", "compensator"])]
    pub model: Option<PathBuf>,

    /// Write the rewritten program to this file; `-` for standard output. The note FILE.lostmotion.json, which `undo` needs,
    /// is written next to it
    #[arg(long, short, value_name = "FILE", conflicts_with = "check", required_unless_present_any = ["dry_run", "check", "output_dir", "list_frames"])]
    pub output: Option<PathBuf>,

    /// Format of the program: csv, inform, rapid, krl, fanuc, urscript, trajectory or gcode [default: recognised from the
    /// file's extension and content]
    #[arg(long, value_name = "NAME")]
    pub format: Option<String>,

    /// How the control reads G-code until the program says otherwise: G90 or G91, G20 or G21, whole-units (a number without a
    /// decimal point is in millimetres or inches, not in increments), diameter or radius (what X of a lathe is), no-rollover
    /// (rotary axes do not take the shorter way), and G61 (moves end exactly at their positions); for example G21,G90 [default:
    /// `control` in the robot file]
    #[arg(long, value_name = "WORD,...")]
    pub assume: Option<String>,

    /// Write the rewritten programs of a folder to this folder, under the same names. Programs that are already finished
    /// there are skipped. With --manifest also s3://BUCKET/PREFIX (in builds with the feature `cloud`)
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["output", "check"])]
    pub output_dir: Option<PathBuf>,

    /// Write one line of JSON for each program to this file (status, reason, moves, reversals, hashes)
    #[arg(long, value_name = "FILE")]
    pub summary: Option<PathBuf>,

    /// Rewrite only part K of N of a folder, for job arrays; for example 3/16
    #[arg(long, value_name = "K/N", requires = "output_dir", allow_hyphen_values = true)]
    pub shard: Option<String>,

    /// Rewrite only those programs of a folder that this manifest (from `lostmotion manifest`) lists and whose size and
    /// SHA-256 are still as listed. Each line of the summary contains the key of its program
    #[arg(long, value_name = "FILE.jsonl", requires = "output_dir")]
    pub manifest: Option<PathBuf>,

    /// Which programs of a folder set the exit code to 1; the summary lists all of them in any case
    #[arg(long, value_enum, default_value_t = FailOn::Refused)]
    pub fail_on: FailOn,

    /// Also work out the verdict on every rewritten program of a folder, as it is always done for a single program: its path
    /// error before and after on a machine with the compensator's gaps and friction. A program that leaves its path is
    /// refused. Takes longer; always done with --report
    #[arg(long, requires = "output_dir")]
    pub verdict: bool,

    /// Exit with code 3 if no program needed a change
    #[arg(long)]
    pub exit_code: bool,

    /// Minimum share of the moves whose joint targets can be edited, such as 100%. Below it nothing is written and the exit
    /// code is 1
    #[arg(long, value_name = "PERCENT", allow_hyphen_values = true)]
    pub require_coverage: Option<String>,

    /// Replace straight Cartesian moves between joint moves by joint moves that stay within this distance of the line, um
    /// [without a value: 20]
    #[arg(long, value_name = "UM", num_args = 0..=1, require_equals = true, default_missing_value = "20")]
    pub solve_cartesian: Option<f64>,

    /// File of the controller's frames and tools by name (lostmotion/frames/1), or a file of the controller itself, in addition
    /// to those of the robot file. Cartesian targets in other frames stay as they are. Can be given several times
    #[arg(long, value_name = "FILE")]
    pub frames: Vec<PathBuf>,

    /// Print only a template for --frames on standard output: every unknown frame and tool, with the number of moves that
    /// need it
    #[arg(long, conflicts_with_all = ["output", "check", "json"])]
    pub list_frames: bool,

    /// Program, macro or routine that moves nothing and leaves frames and tools as they are, although no file of the program's
    /// folder or project contains it, such as "Clear User Page"; in addition to `no_motion` in the robot file. Can be given
    /// several times
    #[arg(long, value_name = "NAME")]
    pub no_motion: Vec<String>,

    /// Leave Cartesian targets as they are
    #[arg(long)]
    pub leave_cartesian: bool,

    /// Maximum number of points added to a program. If more were needed, steps are spread over whole moves instead
    #[arg(long, value_name = "N")]
    pub max_added: Option<u64>,

    /// Add no points to a move that would gain less than this at the TCP, um. There the step is spread over the whole move (vendor
    /// programs only)
    #[arg(long, value_name = "UM")]
    pub min_gain: Option<f64>,

    /// Add no points while a process (welding, dispensing) is on; the targets of the process are still edited
    #[arg(long)]
    pub leave_process: bool,

    /// Approach every target at which the robot stops from one side: + or - for all joints, or signs for single joints, such
    /// as A1=+,A2=-. A point is added before each target that a joint would reach from the other side, only as far away as
    /// the gap requires (vendor programs only)
    #[arg(long, value_name = "+|-|JOINT=SIGN,...", allow_hyphen_values = true)]
    pub approach_from: Option<String>,

    /// Compensate also the targets at which the robot stops that it may reach from any side: the first one after a call, a label or a
    /// loop. A point is added before each, back along the tool's axis, only as far away as the gaps require (vendor programs
    /// for arms only)
    #[arg(long)]
    pub approach_unknown: bool,

    /// Leave moves as they are while a process (welding, dispensing) is on
    #[arg(long)]
    pub exclude_process: bool,

    /// Joints to leave uncompensated, such as A4,A6
    #[arg(long, value_name = "JOINT,...")]
    pub leave_out: Option<String>,

    /// With --model, compensate only lost motion (gaps and friction), not errors that depend only on the joint position
    #[arg(long, requires = "model")]
    pub lost_motion_only: bool,

    /// Compensate also the joints whose gap is not significant (its 95 % interval contains zero)
    #[arg(long)]
    pub insignificant: bool,

    /// How to find turning points between the points of a joint-space CSV [default: none] (in vendor programs the targets are
    /// the turning points)
    #[arg(long, value_enum)]
    pub refine: Option<RefineArg>,

    /// Law of the offsets: equation 16 of Zhang (2023), or, for comparison, equation 2 of Cursi (2022), which adds no points
    /// and no friction term
    #[arg(long, value_enum, default_value_t = LawArg::SymmetricHalfGap, conflicts_with_all = ["step_fraction", "ramp_deg", "ramp_mm"])]
    pub law: LawArg,

    /// Position of the added point that carries the step, as a share of the segment after the reversal; with 1 the next
    /// point of the program carries the step [default: 0.1, or less if the joint would lag until then]
    #[arg(long, value_name = "0..1")]
    pub step_fraction: Option<f64>,

    /// Spread the step of a revolute joint over this travel after the reversal, deg
    #[arg(long, value_name = "DEG")]
    pub ramp_deg: Option<f64>,

    /// The same for prismatic joints, mm
    #[arg(long, value_name = "MM")]
    pub ramp_mm: Option<f64>,

    /// Directions in which the joints moved before the first point, such as A1=+,A2=- [default: the direction of their first
    /// movement]
    #[arg(long, value_name = "JOINT=SIGN,...", allow_hyphen_values = true)]
    pub initial_direction: Option<String>,

    /// Factor from 0 to 1 by which every offset is multiplied (too much compensation does more harm than too little)
    #[arg(long, value_name = "0..1", default_value_t = 1.0)]
    pub gain: f64,

    /// TCP speed of a program without t_s, or of moves with joint speeds, mm/s; it converts a decay in seconds into points
    /// [default: the speed of the log from which the compensator was made]
    #[arg(long, value_name = "MM_S")]
    pub speed_mm_s: Option<f64>,

    /// With --refine cartesian: largest distance between the path and its chords, um [default: 2]
    #[arg(long, value_name = "UM")]
    pub chord_um: Option<f64>,

    /// Largest movement of a revolute joint that counts as rounding and not as a reversal, deg [default: 1.5 units of the
    /// last digit of its column]
    #[arg(long, value_name = "DEG")]
    pub deadband_deg: Option<f64>,

    /// The same for prismatic joints, mm
    #[arg(long, value_name = "MM")]
    pub deadband_mm: Option<f64>,

    /// Write changed numbers with this many decimals [default: as in the program, or more if the gap needs them]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=12))]
    pub decimals: Option<u8>,

    /// Report what would be done, and write nothing
    #[arg(long, conflicts_with = "check")]
    pub dry_run: bool,

    /// Compare the result with this file instead of writing it; with a folder as IN, compare every program with the file of
    /// the same name in this folder. If they differ, print the first difference and exit with code 1
    #[arg(long, value_name = "GOLDEN")]
    pub check: Option<PathBuf>,

    /// With --check, accept numbers that differ by at most this much, in the unit of the program (deg, mm, pulses); all other
    /// text must be equal [default: every byte must be equal]
    #[arg(long, value_name = "N", requires = "check")]
    pub tolerance: Option<f64>,

    /// Rewrite a program even if it has already been rewritten
    #[arg(long)]
    pub force: bool,

    /// Replace files that stand where results go also if no note shows that `rewrite` wrote them, or if they were changed since
    /// then
    #[arg(long)]
    pub replace: bool,

    /// Print what was done as one JSON document on standard output
    #[arg(long)]
    pub json: bool,

    /// Write a self-contained HTML page with figures and tables to this file
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

/// `--law`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum LawArg {
    /// Half a gap in the direction of movement
    #[value(name = "equation-16")]
    SymmetricHalfGap,
    /// The whole deadzone at the sample where the direction changes, as printed
    #[value(name = "equation-2")]
    Equation2,
    /// The whole deadzone from that sample on
    #[value(name = "equation-2-held")]
    Equation2Held,
}

impl From<LawArg> for Law {
    fn from(l: LawArg) -> Self {
        match l {
            LawArg::SymmetricHalfGap => Self::SymmetricHalfGap,
            LawArg::Equation2 => Self::Equation2,
            LawArg::Equation2Held => Self::Equation2Held,
        }
    }
}

/// `--refine`.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
pub enum RefineArg {
    /// Use only the points of the program
    None,
    /// Find turning points on a local cubic through the joint values
    Cubic,
    /// Find turning points on arcs through the TCP path, and add points until the chords follow the arcs
    Cartesian,
}

impl From<RefineArg> for Refine {
    fn from(r: RefineArg) -> Self {
        match r {
            RefineArg::None => Self::None,
            RefineArg::Cubic => Self::Cubic,
            RefineArg::Cartesian => Self::Cartesian,
        }
    }
}

/// Which programs of a folder make the exit code 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum FailOn {
    /// Programs that were refused or that failed
    Refused,
    /// Only programs that failed
    Failed,
    /// No program
    None,
}

impl Args {
    /// The result goes over points of approach.
    pub(super) fn goes_aside(&self) -> bool {
        self.approach_from.is_some() || self.approach_unknown
    }
}

/// A wrong use of the options.
pub(super) fn usage(found: &str, expected: &str) -> anyhow::Error {
    bad(Place::file("command line"), found, expected)
}
