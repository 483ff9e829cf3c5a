//! In which configuration of its arm a project works, by all the points that it declares: for programs that name no joints themselves.
//!
//! A `FRAME` has no status, and a motion to it keeps the one before (KUKA System Software, Operating and Programming Instructions for
//! System Integrators, status and turn). Read are the values in braces of every file of the project: axes that are all given, and status.
//! Left out are names of the controller (`$H_POS_TOL`), relative motions, values beyond a turn (`A1 999`: not taught) and zeros.

use super::aggregate::{Aggregate, aggregate};
use super::data::Data;
use super::lex::{Kind, Token, tokens};
use super::name::Holds;
use super::statement::declaration;
use crate::axes::JointKind;
use crate::script::pose::Configuration;
use crate::script::{Stance, Text};

/// The home position of all modules.
const HOME: &str = "XHOME";
/// Aggregates of a line that are read.
const MOST: usize = 16;

/// What one file says.
#[derive(Default)]
struct FileFacts {
    /// Values by the name of the axis, in the user's units.
    points: Vec<Vec<(String, f64)>>,
    status: Vec<u8>,
}

/// Of a program and its project; `None`: no home position of the project is certain.
pub(super) fn stance(texts: &[Text], data: &Data, axes: &[(String, JointKind)]) -> Option<Stance> {
    let home = data.names.get(data.known(None, HOME)?).filter(|n| n.context && n.holds == Holds::Axes)?;
    let home = home.value().ok().and_then(|a| joints(&values(a), axes))?;
    let said: Vec<_> = texts.iter().map(|t| t.known(of_text)).collect();
    let others = said.iter().flat_map(|s| &s.points).filter_map(|p| joints(p, axes)).collect();
    let status = said.iter().flat_map(|s| &s.status);
    let configurations = status.map(|s| Configuration::Kuka { status: Some(*s), turn: None }).collect();
    Some(Stance { home, others, configurations })
}

/// Joints of all axes, rad or m; `None`: an axis is not given.
fn joints(point: &[(String, f64)], axes: &[(String, JointKind)]) -> Option<Vec<f64>> {
    let of =
        |(name, kind): &(String, JointKind)| point.iter().find(|v| v.0 == *name).map(|v| v.1 * kind.si_per_user_unit());
    axes.iter().map(of).collect()
}

/// Values of an aggregate by their names.
fn values(a: &Aggregate) -> Vec<(String, f64)> {
    a.components().filter_map(|c| Some((c.name.as_str().to_string(), c.value?.1))).collect()
}

/// What the aggregates of a text say.
///
/// `line = {any} aggregate {any}`
fn of_text(text: &Text) -> FileFacts {
    let (mut said, mut line) = (FileFacts::default(), Vec::new());
    for k in text.lines_with(b"{") {
        tokens(text, k, &mut line);
        line.retain(|t| t.kind != Kind::Comment);
        let first = line.first().map_or(&[][..], |t| text.slice(t.span()));
        let relative = first.to_ascii_uppercase().ends_with(b"_REL");
        if !relative && !is_of_controller(text, &line) {
            aggregates(text, &line, &mut said);
        }
    }
    said
}

/// Whether a line declares or sets a variable of the controller.
///
/// `line = [type] "$" ...`
fn is_of_controller(text: &Text, line: &[Token]) -> bool {
    let name = declaration(text, line).map_or(0, |at| at + 1);
    line.get(name).is_some_and(|t| text.slice(t.span()).starts_with(b"$"))
}

/// Adds the aggregates of a line.
fn aggregates(text: &Text, line: &[Token], said: &mut FileFacts) {
    let open = line.iter().enumerate().filter(|(_, t)| t.is(b'{')).map(|(k, _)| k).take(MOST);
    for a in open.filter_map(|k| aggregate(text, 0, line, k).ok()).map(|(a, _)| a) {
        if !a.has_axes() {
            let status = a.component("S").and_then(|c| c.value).map(|v| v.1);
            // bits beyond the third are of no arm
            said.status.extend(status.filter(|s| (0.0..65536.0).contains(s)).map(|s| (s as u32 & 7) as u8));
            continue;
        }
        let point = values(&a);
        let taught = point.iter().all(|v| v.1.abs() <= 360.0) && point.iter().any(|v| v.1 != 0.0);
        if taught {
            said.points.push(point);
        }
    }
    said.status.sort_unstable();
    said.status.dedup();
}
