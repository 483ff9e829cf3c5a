//! The entry of one joint in a robot file, checked: kind, limits, pulses, the joint that it follows.

use super::*;
use crate::error::{Error, Place, Result};
use crate::io::yaml::Document;
use crate::robot::{Follow, Joint, JointKind};

pub(super) fn finite(doc: &Document, near: &str, key: &str, values: &[f64]) -> Result<()> {
    match values.iter().find(|v| !v.is_finite()) {
        None => Ok(()),
        Some(v) => Err(Error::bad(doc.place(&[near, key]), format!("{key} {v}"), "a finite number")),
    }
}

pub(super) fn build_joint(j: &JointFile, all: &[JointFile], doc: &Document) -> Result<Joint> {
    let near = |key: &str| -> Place { doc.place(&[&j.name, key]) };
    if j.name.trim().is_empty() || j.name.contains(|c: char| c.is_control() || c == ',') {
        return Err(Error::bad(doc.place(&["joints"]), format!("joint name `{}`", j.name), "a name without commas"));
    }
    let kind = match j.kind.as_str() {
        "revolute" => JointKind::Revolute,
        "prismatic" => JointKind::Prismatic,
        other => return Err(Error::bad(near("kind"), format!("kind `{other}`"), "`revolute` or `prismatic`")),
    };
    for (key, v) in [
        ("theta_deg", j.theta_deg),
        ("d_mm", j.d_mm),
        ("a_mm", j.a_mm),
        ("alpha_deg", j.alpha_deg),
        ("beta_deg", j.beta_deg),
    ] {
        finite(doc, &j.name, key, &[v])?;
    }
    if j.direction != 1.0 && j.direction != -1.0 {
        return Err(Error::bad(near("direction"), format!("direction {} of {}", j.direction, j.name), "1 or -1"));
    }
    let limits = Limits::of(j, kind, &near)?;
    let si = kind.si_per_user_unit();
    Ok(Joint {
        name: j.name.clone(),
        kind,
        theta_rad: j.theta_deg.to_radians(),
        d_m: j.d_mm * 1e-3,
        a_m: j.a_mm * 1e-3,
        alpha_rad: j.alpha_deg.to_radians(),
        beta_rad: j.beta_deg.to_radians(),
        direction: j.direction,
        limits: limits.range.map(|l| l.map(|v| v * si)),
        max_speed: limits.max_speed.map(|v| v * si),
        max_accel: limits.max_accel.map(|v| v * si),
        lead_m_per_rev: j.lead_mm_per_rev.map(|v| v * 1e-3),
        pulses: pulses(j, kind, &near)?.map(|p| p / si),
        follows: j.follows.as_ref().map(|f| follows(j, f, all, &near)).transpose()?,
    })
}

/// The limits of a joint in the unit of its kind, deg or mm.
struct Limits {
    range: Option<[f64; 2]>,
    max_speed: Option<f64>,
    max_accel: Option<f64>,
}

/// The value whose key has the unit of the joint's kind, and whether the other key is there.
fn of_kind<T>(kind: JointKind, deg: Option<T>, mm: Option<T>) -> (Option<T>, bool) {
    match kind {
        JointKind::Revolute => (deg, mm.is_some()),
        JointKind::Prismatic => (mm, deg.is_some()),
    }
}

impl Limits {
    /// Reads and checks; `near` finds the place of a key.
    fn of(j: &JointFile, kind: JointKind, near: &dyn Fn(&str) -> Place) -> Result<Self> {
        let (range, wrong_range) = of_kind(kind, j.limits_deg, j.limits_mm);
        let (max_speed, wrong_speed) = of_kind(kind, j.max_speed_deg_s, j.max_speed_mm_s);
        let (max_accel, wrong_accel) = of_kind(kind, j.max_accel_deg_s2, j.max_accel_mm_s2);
        if wrong_range || wrong_speed || wrong_accel {
            return Err(Error::bad(
                near(if wrong_range { "limits" } else { "max_" }),
                format!("a limit of {} joint {} in the wrong unit", j.kind, j.name),
                format!("keys in {}", kind.unit()),
            ));
        }
        if let Some([lo, hi]) = range
            && !(lo.is_finite() && hi.is_finite() && lo < hi)
        {
            let found = format!("limits [{lo}, {hi}] of {}", j.name);
            return Err(Error::bad(near("limits"), found, "[lower, upper] with lower < upper"));
        }
        for (key, v) in [("max_speed", max_speed), ("max_accel", max_accel), ("lead_mm_per_rev", j.lead_mm_per_rev)] {
            if let Some(v) = v
                && !(v.is_finite() && v > 0.0)
            {
                return Err(Error::bad(near(key), format!("{key} {v} of {}", j.name), "a number above 0"));
            }
        }
        Ok(Self { range, max_speed, max_accel })
    }
}

/// Pulses of the controller per deg or mm.
fn pulses(j: &JointFile, kind: JointKind, near: &dyn Fn(&str) -> Place) -> Result<Option<f64>> {
    let (pulses, wrong) = of_kind(kind, j.pulses_per_deg, j.pulses_per_mm);
    if wrong || pulses.is_some_and(|p| !p.is_finite() || p == 0.0) {
        return Err(Error::bad(
            near("pulses_per"),
            format!("pulses of {} joint {}", j.kind, j.name),
            format!("pulses_per_{}, not 0 (negative where they count the other way)", kind.unit()),
        ));
    }
    Ok(pulses)
}

/// The joint that this one follows: of the same kind, with its own command.
fn follows(j: &JointFile, f: &FollowFile, all: &[JointFile], near: &dyn Fn(&str) -> Place) -> Result<Follow> {
    match all.iter().position(|k| k.name.eq_ignore_ascii_case(&f.joint)) {
        Some(d) if all[d].follows.is_none() && f.ratio.is_finite() && all[d].kind == j.kind => {
            Ok(Follow { joint: d, ratio: f.ratio })
        }
        _ => Err(Error::bad(
            near("follows"),
            format!("{} follows `{}` with ratio {}", j.name, f.joint, f.ratio),
            "a joint of the same kind that has its own command, and a finite ratio",
        )),
    }
}
