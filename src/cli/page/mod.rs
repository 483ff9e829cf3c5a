//! Results -> report pages: which finding goes into which section. No mathematics, no drawing.
//!
//! Modules:
//! - [`bidirectional`]: positions reached from both sides.
//! - [`circle`]: circles before and after, side by side for any number of runs.
//! - [`gaps`]: what an identification found; joint error traces of a path; [`screw`]: two gaps in series.
//! - [`machine`]: what all logs of a machine gave together.
//! - [`compensator`]: offsets, and what was left out; [`rewrite`]: what was done to a program.
//! - [`diagnose`]: what a model lacks, and how that was found.
//! - [`impact`]: what a gap costs at the TCP; [`simulate`]: what was run on which machine.
//! - [`program`]: a program before and after it was changed.
//! - [`plan`]: the motion that decides, and what it would show.
//! - [`show`]: a log, a program, a machine as they are.
//! - [`learn`]: errors of learned kinematics; [`track`]: a path and what the joints do along it.

pub mod bidirectional;
pub(crate) mod circle;
pub mod compensator;
pub mod diagnose;
pub mod gaps;
pub(crate) mod impact;
pub(crate) mod learn;
pub mod machine;
pub(crate) mod plan;
pub(crate) mod program;
pub(crate) mod rewrite;
pub(crate) mod screw;
pub(crate) mod show;
pub(crate) mod simulate;
pub(crate) mod track;

use crate::effects::EffectInstance;
use crate::io::output::Output;
use crate::model::Model;
use crate::report::{Page, RobotView, TableView};
use crate::robot::{JointKind, Robot};
use anyhow::Result;

/// Errors at the TCP are drawn this many times too large (Zhang (2023), Figure 11).
pub const EXAGGERATION: f64 = 400.0;

/// A page about one robot.
pub fn start(command: &str, title: &str, robot: &Robot) -> Page {
    let mut page = Page::new(command, title);
    page.robot = Some(RobotView { name: robot.name.clone(), sha256: robot.fingerprint() });
    for joint in robot.axis_joints() {
        page.joint(joint.name.clone(), joint.kind);
    }
    page
}

/// A path without its folders.
fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

/// Unit of a thousandth of a joint's unit, as pages show it.
fn milli_unit(kind: JointKind) -> &'static str {
    kind.pick(["mdeg", "µm"])
}

/// Writes the page where one is asked for; it is not in place before its output is committed.
pub fn write(report: &mut Option<Output>, page: impl FnOnce() -> Page) -> Result<()> {
    match report {
        Some(out) => out.put(page().render().as_bytes()).map_err(Into::into),
        None => Ok(()),
    }
}

/// The effects of a machine.
pub fn effects(model: &Model) -> TableView {
    let robot = &model.robot;
    let row = |e: &EffectInstance| {
        vec![e.effect.name().into(), e.target_text(robot), e.effect.brief(&e.site(robot)), e.effect.info().adds.into()]
    };
    TableView::words(&["effect", "target", "parameters", "what it does"], model.effects.iter().map(row))
}

/// A joint value in thousandths of its unit: mdeg or um.
pub fn milli(robot: &Robot, axis: usize, si: f64) -> f64 {
    robot.axis(axis).kind.to_user_unit(si) * 1e3
}

/// Both ends of an interval in thousandths of the joint's unit.
pub fn milli2(robot: &Robot, axis: usize, si: [f64; 2]) -> [f64; 2] {
    si.map(|v| milli(robot, axis, v))
}
