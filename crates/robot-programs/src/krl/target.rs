//! Axis values as joint targets; axes that are none of the robot's.

use super::aggregate::{Aggregate, axis_name, axis_value};
use super::motion::{Motion, Word};
use super::reason::Reason;
use crate::axes::{Axes, JointKind};
use crate::error::Result;
use crate::script::blocks::BySteps;
use crate::script::{At, OtherWay, PathKind, Step, StepKind, Target, Text};
use std::collections::HashMap;
use std::sync::Arc;

/// KRL's names of the robot's axes: by the robot file where it uses them, else by their numbers; empty where these are not certain, so
/// that no value is any axis'.
pub(super) fn axis_names(robot: &Axes) -> Vec<String> {
    let own: Vec<String> = robot.axis_names().iter().map(|n| n.to_ascii_uppercase()).collect();
    if own.iter().all(|n| axis_name(n)) {
        return own;
    }
    let places = robot.places();
    let name = |axis: usize| {
        let external = places.external.iter().find(|e| e.1 == axis);
        let of_arm = || places.number(axis).filter(|_| places.numbered).map(|n| format!("A{n}"));
        external.map(|e| format!("E{}", e.0)).or_else(of_arm).filter(|_| places.certain).unwrap_or_default()
    };
    (0..robot.dof()).map(name).collect()
}

/// Where one of the other axes moves with the robot, a point on the way would bring it to its goal too early.
pub(super) fn external_axes(steps: &mut [Step], sites: &BySteps<Site>, others: &[Others]) {
    let idle = others.iter().all(Option::is_some) && {
        let mut seen: HashMap<&str, &[u8]> = HashMap::new();
        others
            .iter()
            .flatten()
            .flat_map(|all| all.iter())
            .all(|(n, v)| *seen.entry(n).or_insert(v) == v.as_slice() && v != b"?")
    };
    if idle {
        return;
    }
    let mut before: Option<&Others> = None;
    for (k, step) in steps.iter_mut().enumerate() {
        match &mut step.kind {
            StepKind::Move(m) => {
                let here = match sites.get(k) {
                    Some(site) if site.others == STAY => before,
                    site => site.and_then(|site| others.get(site.others as usize)),
                };
                let still = matches!((before, here), (Some(Some(a)), Some(Some(b))) if a == b && !b.iter().any(|o| o.1 == b"?"));
                if !still {
                    m.other_way.get_or_insert(OtherWay::Carried);
                    m.closed.get_or_insert_with(|| Reason::ExternalAxis.into());
                }
                before = here;
            }
            StepKind::Break(_) => before = None,
            _ => {}
        }
    }
}

/// Values of axes that are none of the robot's; `None`: not known.
pub(super) type Others = Option<Arc<[(String, Vec<u8>)]>>;

/// Where a motion stands, and the axes that are none of the robot's.
#[derive(Default)]
pub(super) struct Site {
    pub(super) motion: Option<Motion>,
    /// Index into the [`Others`] of the program's motions, or [`STAY`].
    pub(super) others: u32,
}

/// They stay where they are.
pub(super) const STAY: u32 = u32::MAX;

/// Axis values of an aggregate; why they are no joint target.
pub(super) fn target(
    axes: &[(String, JointKind)],
    text: &Text,
    a: &Aggregate,
    name: Option<String>,
    at: At,
    word: Word,
) -> Result<std::result::Result<Target, Reason>> {
    if word.path != PathKind::Joint {
        return Ok(Err(Reason::AxesForPose));
    }
    if let Some(c) = a.components().find(|c| !axis_name(c.name.as_str())) {
        let expected = "A1 to A6 and E1 to E6 in an aggregate of axis values";
        return Err(text.bad(a.span.start(), format!("`{}`", c.name.as_str()), expected));
    }
    let mut values = Vec::with_capacity(axes.len());
    for (axis, kind) in axes {
        let Some(c) = a.component(axis) else {
            values.push(None);
            continue;
        };
        let Some((span, value, style)) = c.value else { return Ok(Err(Reason::AxisComputed(c.name.as_str().into()))) };
        values.push(Some(axis_value(*kind, *value, *style, span.range())));
    }
    if values.iter().all(Option::is_none) {
        let unclear = axes.iter().any(|(name, _)| name.is_empty());
        return Ok(Err(if unclear { Reason::UnclearAxes } else { Reason::OtherAxes }));
    }
    Ok(Ok(Target { name, at, values, pose: None }))
}
