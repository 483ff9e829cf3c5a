//! The diagnosis on a terminal: the story round by round, the verdict in one sentence, what to do next, where it is blind.

use crate::diagnose::result::document::{Diagnosis, Round, Unseen, of_motion};
use crate::diagnose::result::words::{self, GapUnit};
use crate::diagnose::verdict::Verdict;
use crate::effects::backlash;
use crate::error::counted;
use std::fmt::Write;

/// Columns of a line.
const WIDTH: usize = 100;

/// The whole story.
pub fn story(d: &Diagnosis) -> String {
    let unit = d.unit;
    let mut out = String::new();
    paragraph(
        &mut out,
        "",
        &format!(
            "{} samples, noise {} ({}; correlation {:.2} from one sample to the next)",
            d.samples,
            unit.with(d.noise.sigma_um),
            d.noise.source,
            d.noise.ar1
        ),
    );
    if d.outliers > 0 {
        let _ = writeln!(out, "{} left out, in disagreement with the neighbours", counted(d.outliers, "sample"));
    }
    for note in &d.notes {
        paragraph(&mut out, "", &note.to_string());
    }
    let frame = if unit == GapUnit::MICROMETRE {
        format!(", {} with the frame fitted", unit.with(d.gap.nuisance_only_rms_um))
    } else {
        String::new()
    };
    let most = unit.with(d.gap.initial_max_um);
    let _ = writeln!(out, "gap {} rms before the diagnosis{frame}; at most {most}", unit.with(d.gap.initial_rms_um));
    if d.geometry_tcp_um.is_some() {
        machine(&mut out, d);
    } else {
        for (i, r) in d.rounds.iter().enumerate() {
            round(&mut out, i + 1, r, unit);
        }
    }
    if let Some(aside) = put_aside(d) {
        paragraph(&mut out, "   ", &aside);
    }
    out.push('\n');
    paragraph(&mut out, "", &sentence(d));
    for (about, what) in words::next_steps(d) {
        paragraph(&mut out, "  ", &format!("{about}: {what}"));
    }
    if let Some(blind) = blind(d) {
        paragraph(&mut out, "", &format!("Blind to: {blind}"));
    }
    out
}

/// Effects that were fitted together, a line each, by what they do to the TCP; geometry is one.
fn machine(out: &mut String, d: &Diagnosis) {
    let unit = d.unit;
    out.push_str(
        "what each effect changes at the TCP, and the gap that remains with all effects so far (on parts that were not fitted):\n",
    );
    let geometry = d.rounds.iter().filter(|r| r.group.is_some()).count();
    let last = d.rounds.iter().rposition(|r| r.group.is_some());
    for (i, r) in d.rounds.iter().enumerate() {
        let (size, what) = match r.group {
            Some(_) if Some(i) != last => continue,
            Some(name) => (d.geometry_tcp_um.unwrap_or(0.0), format!("{name}: {geometry} parameters")),
            None => (r.tcp_um.unwrap_or(0.0), format!("{} {}: {}", r.effect, r.target, sizes(r))),
        };
        let left = format!("{} ({})", unit.with(r.rms_after_um), unit.bare(r.validation.rms_after_um));
        paragraph(out, "  ", &format!("{}  {what}; {left}", unit.with(size)));
    }
}

fn sizes(r: &Round) -> String {
    let one = |s: words::Size| {
        let interval =
            s.ci95.as_ref().map_or_else(|| format!("({})", s.interval()), |[lo, hi]| format!("[{lo}, {hi}]"));
        format!("{} {} {}{}{interval}", s.name, s.value, s.unit, if s.unit.is_empty() { "" } else { " " })
    };
    words::sizes(r).into_iter().map(one).collect::<Vec<_>>().join(", ")
}

fn round(out: &mut String, number: usize, r: &Round, unit: GapUnit) {
    let _ = writeln!(
        out,
        "{number}. {} -> {} {} -> {} (predicted {}; held out {} -> {})",
        unit.with(r.rms_before_um),
        r.effect,
        r.target,
        unit.with(r.rms_after_um),
        unit.bare(r.rms_after_predicted_um),
        unit.bare(r.validation.rms_before_um),
        unit.bare(r.validation.rms_after_um)
    );
    paragraph(out, "   ", &format!("{}; {}", sizes(r), r.place.description));
    if r.set.len() > 1 {
        let names: Vec<String> = r.set.iter().map(member).collect();
        paragraph(out, "   ", &format!("this log cannot distinguish: {}", names.join(", ")));
    }
}

fn member(m: &crate::diagnose::verdict::Member) -> String {
    format!("{} {} ({})", m.effect, m.target, words::probability(m.probability))
}

/// Effects that gave way to others, in one line.
fn put_aside(d: &Diagnosis) -> Option<String> {
    let mut list: Vec<String> =
        d.put_aside.iter().map(|p| format!("{} {} (now {})", p.effect, p.target, p.replaced_by)).collect();
    list.dedup();
    (!list.is_empty()).then(|| format!("put aside: {}", list.join(", ")))
}

/// The verdict in one sentence.
pub fn sentence(d: &Diagnosis) -> String {
    let found = words::found(d).join(", ");
    match d.verdict {
        Verdict::None => "Nothing is missing: the gap is at the noise floor.".into(),
        Verdict::Named => match &d.unexplained {
            Some(u) => format!(
                "Missing: {found}. Beyond them {} of structure remains; it depends on {}.",
                d.unit.with(u.rms_um),
                u.goes_with
            ),
            None if d.further.is_some() => format!("Missing: {found}, and more: see the note on a further round."),
            None => match &d.remainder {
                Some(u) => format!(
                    "Missing: {found}. What remains counts as noise, but {} of it varies more slowly than the instrument scatters: see the notes.",
                    d.unit.with(u.rms_um)
                ),
                None => format!("Missing: {found}. What remains is noise."),
            },
        },
        Verdict::NamedSet => {
            let open: Vec<String> =
                d.rounds.iter().filter(|r| r.set.len() > 1).map(|r| format!("{} {}", r.effect, r.target)).collect();
            format!("Missing: {found}. This log cannot distinguish {} from an alternative.", open.join(" and "))
        }
        Verdict::Unknown if d.contradicted => {
            "Unknown: the log contradicts what is assumed to be known; the first note explains it.".into()
        }
        Verdict::Unknown => match &d.unexplained {
            Some(u) if u.next.is_some() => format!(
                "Unknown: more effects than one diagnosis can name: {} of structure remains beyond {found}; it depends on {}.",
                d.unit.with(u.rms_um),
                u.goes_with
            ),
            Some(u) => {
                let beyond = if found.is_empty() { String::new() } else { format!(" beyond {found}") };
                let size = d.unit.with(u.rms_um);
                format!(
                    "Unknown: {size} of structure remains{beyond} that no effect of the catalogue describes; it depends on {}.",
                    u.goes_with
                )
            }
            None => "Unknown: structure remains that no effect of the catalogue describes.".into(),
        },
        Verdict::NotObservable => "Not observable: no joint moves in this log.".into(),
        Verdict::BadData => "Bad data.".into(),
    }
}

/// Joints on which nothing that shows in motion could be seen, each with the reason.
fn unseen_joints(d: &Diagnosis) -> Vec<(String, Option<Unseen>)> {
    let unseen = |effect: &str, target: &str| {
        d.blind_spots.iter().any(|s| s.effect == effect && s.target == target && s.detectable_from.is_none())
    };
    let of_motion = of_motion();
    let mut targets: Vec<(&str, Option<Unseen>)> = Vec::new();
    for spot in d.blind_spots.iter().filter(|s| of_motion.contains(&s.effect)) {
        match targets.iter_mut().find(|t| t.0 == spot.target) {
            Some(known) => known.1 = known.1.or(spot.reason),
            None => targets.push((&spot.target, spot.reason)),
        }
    }
    let all = targets.into_iter().filter(|t| of_motion.iter().all(|e| unseen(e, t.0)));
    all.map(|(target, why)| (target.to_string(), why)).collect()
}

/// The worst blind spots in one line: what this log cannot show at all, then the weakest joint for lost motion.
pub fn blind(d: &Diagnosis) -> Option<String> {
    const NAMED: usize = 6;
    let unseen = unseen_joints(d);
    let mut hidden: Vec<(&str, Vec<String>)> = Vec::new();
    let mut weakest: Option<(f64, String)> = None;
    for spot in &d.blind_spots {
        let (effect, target) = (spot.effect, spot.target.clone());
        match &spot.detectable_from {
            None if unseen.iter().any(|u| u.0 == target) && of_motion().contains(&effect) => {}
            None => match hidden.iter_mut().find(|h| h.0 == effect) {
                Some(h) => h.1.push(target),
                None => hidden.push((effect, vec![target])),
            },
            Some(sizes) if effect == backlash::INFO.name => {
                let size = sizes.first().map(|(k, v)| (words::key(k, "deg").1, *v));
                if let Some((unit, v)) = size.filter(|s| weakest.as_ref().is_none_or(|w| s.1 > w.0)) {
                    weakest = Some((v, format!("{effect} {target} below {} {unit}", words::rough(v))));
                }
            }
            Some(_) => {}
        }
    }
    for (why, named) in [
        (Some(Unseen::DoesNotMoveTcp), "lost motion and lag of joints that do not move the TCP here:"),
        (Some(Unseen::Rests), "lost motion and lag of resting"),
        (None, "lost motion and lag of"),
    ] {
        let joints: Vec<String> = unseen.iter().filter(|u| u.1 == why).map(|u| u.0.clone()).collect();
        if !joints.is_empty() {
            hidden.insert(0, (named, joints));
        }
    }
    let mut parts: Vec<String> = hidden
        .into_iter()
        .map(|(effect, targets)| {
            let more = targets.len().saturating_sub(NAMED);
            let shown = targets.into_iter().take(NAMED).collect::<Vec<_>>().join(", ");
            if more > 0 { format!("{effect} {shown} and {more} more") } else { format!("{effect} {shown}") }
        })
        .collect();
    parts.extend(weakest.map(|w| w.1));
    (!parts.is_empty()).then(|| parts.join("; "))
}

/// Words in lines of [`WIDTH`] columns; lines after the first are set in by two more.
fn paragraph(out: &mut String, indent: &str, text: &str) {
    let mut line = String::from(indent);
    let mut empty = true;
    for word in text.split_whitespace() {
        if !empty && line.chars().count() + 1 + word.chars().count() > WIDTH {
            out.push_str(&line);
            out.push('\n');
            line = format!("{indent}  ");
            empty = true;
        }
        if !empty {
            line.push(' ');
        }
        line.push_str(word);
        empty = false;
    }
    out.push_str(&line);
    out.push('\n');
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_alternative_of_a_nearly_certain_effect_is_not_impossible() {
        let text = |probability| {
            member(&crate::diagnose::verdict::Member { effect: "backlash".into(), target: "A2".into(), probability })
        };
        assert_eq!(text(0.999), "backlash A2 (more than 99.5 %)");
        assert_eq!(text(0.001), "backlash A2 (less than 0.5 %)");
        assert_eq!(text(0.62), "backlash A2 (62 %)");
    }

    #[test]
    fn a_long_line_is_broken_between_words_and_set_in() {
        let mut out = String::new();
        paragraph(&mut out, "  ", &"word ".repeat(50));
        assert!(
            out.lines().all(|l| l.chars().count() <= WIDTH && l.starts_with("  word") || l.starts_with("    word"))
        );
        assert_eq!(out.split_whitespace().count(), 50);
    }
}
