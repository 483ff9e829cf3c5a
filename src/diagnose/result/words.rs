//! Keys, sizes and units of a diagnosis in words, for a terminal and for a page.

use crate::diagnose::result::document::{Diagnosis, Parameter, Round};
use crate::effects::empirical;
use indexmap::IndexMap;

/// The unit in which the gap is given: micrometres at the TCP, or the joints' own unit where only joints were measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GapUnit {
    pub name: &'static str,
    /// From the `_um` figures of the document (SI times 1e6) to this unit.
    pub factor: f64,
    pub decimals: usize,
}

impl GapUnit {
    pub const MICROMETRE: Self = Self { name: "um", factor: 1.0, decimals: 1 };
    pub const DEGREE: Self = Self { name: "deg", factor: 180.0 / std::f64::consts::PI * 1e-6, decimals: 5 };

    /// A figure of the document without its unit.
    pub fn bare(&self, um: f64) -> String {
        format!("{:.*}", self.decimals, um * self.factor)
    }

    /// A figure of the document with its unit.
    pub fn with(&self, um: f64) -> String {
        format!("{} {}", self.bare(um), self.name)
    }
}

/// Name and unit of a parameter's key: "half_gap_deg" is ("half gap", "deg"). `joint_unit` is that of knots, which have
/// none in their key.
pub fn key(key: &str, joint_unit: &'static str) -> (String, &'static str) {
    const UNITS: [(&str, &str); 19] = [
        ("_k_per_m", "K/m"),
        ("_deg_per_nm", "deg/Nm"),
        ("_rad_per_nm", "rad/Nm"),
        ("_mm_per_n", "mm/N"),
        ("_deg_per_mm_s", "deg per mm/s"),
        ("_mm_per_mm_s", "mm per mm/s"),
        ("_deg_per_nm3", "deg/Nm^3"),
        ("_mm_per_n3", "mm/N^3"),
        ("_deg_s", "deg/s"),
        ("_mm_s", "mm/s"),
        ("_nm", "Nm"),
        ("_n", "N"),
        ("_per_rev", "per rev"),
        ("_ppm", "ppm"),
        ("_deg", "deg"),
        ("_mm", "mm"),
        ("_um", "um"),
        ("_hz", "Hz"),
        ("_s", "s"),
    ];
    let (stem, index) = match key.split_once('[') {
        Some((stem, rest)) => (stem, rest.trim_end_matches(']').parse::<usize>().ok()),
        None => (key, None),
    };
    if stem == "knots" {
        return (format!("half gap at knot {}", index.unwrap_or(0) + 1), joint_unit);
    }
    if stem == "per_nm" {
        return ("growth with load".into(), if joint_unit == "mm" { "per N" } else { "per Nm" });
    }
    let found = UNITS.iter().find_map(|(s, unit)| stem.strip_suffix(s).map(|name| (name, *unit)));
    let (name, unit) = found.unwrap_or((stem, ""));
    let axis = index.map_or(String::new(), |k| format!(" {}", ["x", "y", "z"].get(k).unwrap_or(&"?")));
    (format!("{}{axis}", name.replace('_', " ")), unit)
}

/// Decimals with which a value of this uncertainty is written: two digits of the uncertainty.
pub fn decimals(half_width: f64) -> usize {
    if half_width > 0.0 && half_width.is_finite() {
        (1 - half_width.log10().floor() as i32).clamp(0, 9) as usize
    } else {
        4
    }
}

/// A parameter of a round in words.
#[derive(Debug, Clone, PartialEq)]
pub struct Size {
    pub name: String,
    pub value: String,
    /// Ends of its 95 % interval, where it has one.
    pub ci95: Option<[String; 2]>,
    pub unit: &'static str,
}

impl Size {
    /// " (from to to)", or that there is no interval.
    pub fn interval(&self) -> String {
        self.ci95
            .as_ref()
            .map_or_else(|| "no interval: the log does not determine it".into(), |[lo, hi]| format!("{lo} to {hi}"))
    }
}

/// The parameters of a round.
pub fn sizes(r: &Round) -> Vec<Size> {
    let knots = r.parameters.keys().filter(|k| k.starts_with("knots[")).count();
    if knots > 1 {
        return vec![curve(r, knots)];
    }
    let together = r.with_windup.iter().map(|(k, p)| {
        let size = size(r, k, p);
        Size { name: format!("{} with wind-up", size.name), ..size }
    });
    r.parameters.iter().map(|(k, p)| size(r, k, p)).chain(together).collect()
}

fn size(r: &Round, k: &str, p: &Parameter) -> Size {
    let (name, unit) = key(k, r.joint_unit);
    let d = decimals(p.ci95.map_or(0.0, |[lo, hi]| 0.5 * (hi - lo)));
    Size { name, value: fixed(p.value, d), ci95: p.ci95.map(|ci| ci.map(|v| fixed(v, d))), unit }
}

/// A curve in one piece: its smallest and largest knot, and the ends of their intervals.
fn curve(r: &Round, knots: usize) -> Size {
    let all = || r.parameters.values();
    let least = |f: &dyn Fn(&Parameter) -> f64| all().map(f).fold(f64::INFINITY, f64::min);
    let most = |f: &dyn Fn(&Parameter) -> f64| all().map(f).fold(f64::NEG_INFINITY, f64::max);
    let end = |p: &Parameter, k: usize| p.ci95.map_or(f64::NAN, |ci| ci[k]);
    let d = decimals(least(&|p| 0.5 * (end(p, 1) - end(p, 0))));
    let value = format!("{} to {}", fixed(least(&|p| p.value), d), fixed(most(&|p| p.value), d));
    let ends = [least(&|p| end(p, 0)), most(&|p| end(p, 1))];
    let ci95 = ends.iter().all(|v| v.is_finite()).then(|| ends.map(|v| fixed(v, d)));
    let (what, unit) = match r.effect.as_str() {
        empirical::NAME => ("value", if r.target == "tcp" { "mm" } else { r.joint_unit }),
        _ => ("half gap", r.joint_unit),
    };
    Size { name: format!("{what} at {knots} knots"), value, ci95, unit }
}

/// Fixed decimals; zero has no sign.
fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    if text.bytes().all(|b| matches!(b, b'-' | b'0' | b'.')) { text.trim_start_matches('-').into() } else { text }
}

/// A probability in percent; one that is nearly certain, or nearly excluded, is not rounded to certainty.
pub fn probability(p: f64) -> String {
    match 100.0 * p {
        p if p > 99.5 => "more than 99.5 %".into(),
        p if p < 0.5 => "less than 0.5 %".into(),
        p => format!("{p:.0} %"),
    }
}

/// A detectable size, with two digits.
pub fn rough(value: f64) -> String {
    let digits = if value > 0.0 { (1 - value.log10().floor() as i32).clamp(0, 9) as usize } else { 0 };
    format!("{value:.digits$}")
}

/// Found effects with their targets, each once; of many an effect with all its targets.
pub fn found(d: &Diagnosis) -> Vec<String> {
    if d.geometry_tcp_um.is_some() {
        let mut names: IndexMap<&str, Vec<&str>> = IndexMap::new();
        for r in &d.rounds {
            let targets = names.entry(r.group.unwrap_or(&r.effect)).or_default();
            if !targets.contains(&r.target.as_str()) {
                targets.push(&r.target);
            }
        }
        let all = names.into_iter().map(|(name, targets)| match name {
            "geometry" => format!("geometry ({} parameters)", targets.len()),
            _ => format!("{name} {}", targets.join(" ")),
        });
        return all.collect();
    }
    let mut names: Vec<(String, usize)> = Vec::new();
    for r in &d.rounds {
        let name = format!("{} {}", r.effect, r.target);
        match names.iter_mut().find(|n| n.0 == name) {
            Some(known) => known.1 += 1,
            None => names.push((name, 1)),
        }
    }
    names.into_iter().map(|(n, k)| if k > 1 { format!("{n} ({k} times)") } else { n }).collect()
}

/// What to do next: what it is about, and what to do.
pub fn next_steps(d: &Diagnosis) -> Vec<(String, String)> {
    use crate::diagnose::verdict::Verdict;
    let mut steps: Vec<(String, String)> = Vec::new();
    if let Some(u) = &d.unexplained {
        let how = match &u.next {
            _ if d.contradicted => "correct what the first note names, and diagnose again".into(),
            Some(_) => "write the model and diagnose again with it".into(),
            None => format!("record {}", u.record),
        };
        steps.push(("to find the rest".into(), how));
    }
    if d.verdict == Verdict::NotObservable {
        steps.push(("to see anything".into(), "record a path on which every joint moves in both directions".into()));
    }
    let mut told: Vec<&str> = Vec::new();
    for r in &d.rounds {
        // of many effects each action stands once, with the largest
        if d.geometry_tcp_um.is_some() {
            if told.contains(&r.action.as_str()) || r.group.is_some() && told.contains(&"geometry") {
                continue;
            }
            told.push(r.group.unwrap_or(&r.action));
        }
        // beside structure that nothing describes a name is not to be trusted alone
        let about = match d.verdict {
            Verdict::Unknown => format!("if {} {} is confirmed", r.effect, r.target),
            _ => format!("{} {}", r.effect, r.target),
        };
        if !steps.iter().any(|s| s.0 == about) {
            steps.push((about, r.action.clone()));
        }
    }
    for r in d.rounds.iter().filter(|r| r.set.len() > 1) {
        if let Some(by) = &r.decide_by {
            let alternatives: Vec<String> = r.set[1..].iter().map(|m| format!("{} {}", m.effect, m.target)).collect();
            steps.push((format!("to tell {} {} from {}", r.effect, r.target, alternatives.join(", ")), by.clone()));
        }
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::catalogue;

    #[test]
    fn every_key_of_the_catalogue_has_its_unit_apart_from_its_name() {
        let names = catalogue::ALL.iter().flat_map(|e| e.parameters.iter().map(|p| p.0));
        let keys = names.flat_map(|n| n.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')));
        for found in keys.filter(|k| k.contains('_')).chain(["force_n", "cubic_mm_per_n3", "fade_mm_s"]) {
            let (name, _) = key(found, "deg");
            assert!(!name.is_empty() && !name.ends_with("per") && !name.contains(" per "), "{found}: {name}");
        }
        assert_eq!(key("x_rad_per_nm", "deg"), ("x".into(), "rad/Nm"));
        assert_eq!(key("gradient_k_per_m", "deg"), ("gradient".into(), "K/m"));
        assert_eq!(key("fade_deg_s", "deg"), ("fade".into(), "deg/s"));
        assert_eq!(key("torque_nm", "deg"), ("torque".into(), "Nm"));
        assert_eq!(key("per_nm", "mm").1, "per N");
    }

    #[test]
    fn keys_are_split_into_a_name_and_a_unit() {
        assert_eq!(key("half_gap_deg", "deg"), ("half gap".into(), "deg"));
        assert_eq!(key("compliance_deg_per_nm", "deg"), ("compliance".into(), "deg/Nm"));
        assert_eq!(key("slope_mm_per_mm_s", "mm"), ("slope".into(), "mm per mm/s"));
        assert_eq!(key("amplitude_um[2]", "deg"), ("amplitude z".into(), "um"));
        assert_eq!(key("knots[0]", "mm"), ("half gap at knot 1".into(), "mm"));
        assert_eq!(key("ratio", "deg"), ("ratio".into(), ""));
    }

    #[test]
    fn a_value_has_the_digits_that_its_uncertainty_allows() {
        assert_eq!((decimals(1.6e-5), decimals(0.3), decimals(40.0), decimals(0.0)), (6, 2, 0, 4));
        assert_eq!((fixed(-0.001, 1), fixed(-0.5, 1)), ("0.0".into(), "-0.5".into()));
        assert_eq!((rough(0.01234), rough(3.21), rough(0.0)), ("0.012".into(), "3.2".into(), "0".into()));
    }
}
