//! How far apart the points of a program are: the median TCP distance between points that differ.
//!
//! Only for equation 17, which counts points: a program of mixed spacing has no such number, which is refused where the middle
//! half of the distances spreads by more than [`EVEN`].

use crate::error::{Error, Place, Result};
use crate::io::input;
use crate::robot::Robot;
use std::path::Path;

/// Upper over lower quartile of the distances up to which a program counts as evenly spaced.
const EVEN: f64 = 1.5;

/// Median TCP distance between the points of a joint-space CSV (`a1_deg,...` or `cmd_A1_deg,...`), m.
pub fn of_program(path: &Path, robot: &Robot) -> Result<f64> {
    let (text, input) = input::read_text(path)?;
    let name = input.name;
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let bad = |e: csv::Error| {
        let place = Place { file: name.clone(), line: e.position().map(|p| p.line()), column: None };
        Error::bad(place, e.to_string(), "CSV with one row per point")
    };
    let header = reader.headers().map_err(bad)?.clone();
    let mut columns = Vec::new();
    for joint in robot.axis_joints() {
        let want = format!("{}_{}", joint.name, joint.kind.unit()).to_ascii_lowercase();
        let hit = header.iter().position(|h| {
            let h = h.trim().to_ascii_lowercase();
            h == want || h == format!("cmd_{want}")
        });
        columns.push((
            hit.ok_or_else(|| {
                Error::bad(Place::line(&name, 1), format!("no column `{want}`"), "one column per joint")
            })?,
            joint.kind.si(),
        ));
    }
    let mut distances = Vec::new();
    let mut last = None;
    for record in reader.records() {
        let record = record.map_err(bad)?;
        let line = record.position().map_or(0, |p| p.line());
        let mut q = Vec::with_capacity(columns.len());
        for &(c, si) in &columns {
            let cell = record.get(c).unwrap_or("").trim();
            match cell.parse::<f64>() {
                Ok(v) if v.is_finite() => q.push(v * si),
                _ => {
                    let place = Place::field(&name, line, c as u64 + 1);
                    return Err(Error::bad(place, format!("`{cell}`"), "a finite number with a decimal point"));
                }
            }
        }
        let tcp = robot.tcp_m(&q);
        if let Some(before) = last.replace(tcp) {
            let d: f64 = (tcp - before).norm();
            if d > 1e-9 {
                distances.push(d);
            }
        }
    }
    if distances.is_empty() {
        return Err(Error::bad(Place::file(&name), "a program that does not move", "two points or more that differ"));
    }
    distances.sort_by(f64::total_cmp);
    let at = |share: f64| distances[((distances.len() - 1) as f64 * share) as usize];
    if at(0.75) > EVEN * at(0.25) {
        return Err(Error::bad(
            Place::file(&name),
            format!("points {:.2} to {:.2} mm apart (middle half)", at(0.25) * 1e3, at(0.75) * 1e3),
            "points of one spacing: equation 17 counts points; use `--form decay`",
        ));
    }
    Ok(at(0.5))
}
