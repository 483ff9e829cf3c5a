//! A Cartesian path: `x_mm,y_mm,z_mm` and perhaps `t_s`, one point a row.
//!
//! A coordinate whose column is absent is free. Other columns are refused only where they look like joints or another unit:
//! such a file is no path. Without `t_s` the times follow from a TCP speed. `#` lines are comments; `.gz` is read as it is.

use super::LETTERS;
use crate::error::{Error, Place, Result};
use crate::io::input::{self, Input};
use robot_programs::error::in_few_digits;
use std::path::Path as FilePath;

/// Coordinates beyond this (mm) are damage.
const LARGEST_MM: f64 = 1e7;
/// What a path begins with.
const HEADER: &str = "a header with x_mm, y_mm, z_mm (or some of them), and perhaps t_s";
/// Shortest time between two points, s: one interpolation cycle of a common controller.
const SHORTEST_S: f64 = crate::simulate::timing::SHORTEST_S;

/// A path in SI.
#[derive(Debug, Clone)]
pub struct Path {
    /// As messages show it.
    pub name: String,
    /// SHA-256 of the file's bytes, hexadecimal.
    pub sha256: String,
    /// 0, 1, 2 for x, y, z; rising.
    pub coordinates: Vec<usize>,
    /// One value per coordinate, m.
    pub points_m: Vec<Vec<f64>>,
    /// s, strictly increasing; `None`: the file has no times.
    pub t_s: Option<Vec<f64>>,
    /// Line of each point.
    pub line: Vec<u64>,
}

impl Path {
    /// Reads a path (`-`: standard input).
    pub fn load(path: &FilePath) -> Result<Self> {
        Self::parse(input::read(path)?)
    }

    /// Parses the bytes of a path.
    pub fn parse(input: Input) -> Result<Self> {
        let Input { name, bytes, sha256 } = input;
        let text = input::decode(&name, bytes)?;
        input::refuse_no_rows(&name, &text, HEADER)?;
        let mut reader =
            csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(text.as_bytes());
        let broken = |e: csv::Error| {
            let line = e.position().map(|p| p.line());
            Error::bad(Place { file: name.clone(), line, column: None }, e.to_string(), "rows as long as the header")
        };
        let header = reader.headers().map_err(broken)?.clone();
        let columns = Columns::of(&header, &name)?;
        let mut path = Self {
            name: name.clone(),
            sha256,
            coordinates: Vec::new(),
            points_m: Vec::new(),
            t_s: None,
            line: Vec::new(),
        };
        path.coordinates = columns.coordinates.iter().map(|(c, _)| *c).collect();
        path.t_s = columns.time.map(|_| Vec::new());
        for record in reader.records() {
            let record = record.map_err(broken)?;
            let line = record.position().map_or(0, |p| p.line());
            let number = |column: usize| -> Result<f64> {
                let text = record.get(column).unwrap_or_default();
                text.parse().ok().filter(|v: &f64| v.is_finite() && v.abs() <= LARGEST_MM).ok_or_else(|| {
                    let place = Place::field(&name, line, column as u64 + 1);
                    Error::bad(place, format!("`{text}`"), "a number with a decimal point, within 1e7")
                })
            };
            let point: Result<Vec<f64>> = columns.coordinates.iter().map(|(_, k)| Ok(number(*k)? * 1e-3)).collect();
            path.points_m.push(point?);
            path.line.push(line);
            if let (Some(times), Some(k)) = (&mut path.t_s, columns.time) {
                let t = number(k)?;
                if let Some(before) = times.last().filter(|b| t <= **b) {
                    let place = Place::field(&name, line, k as u64 + 1);
                    return Err(Error::bad(
                        place,
                        format!("time {} s after {} s", in_few_digits(t), in_few_digits(*before)),
                        "times that strictly increase",
                    ));
                }
                times.push(t);
            }
        }
        if path.points_m.is_empty() {
            return Err(Error::bad(Place::file(&path.name), "a header and no rows", "one point or more"));
        }
        Ok(path)
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points_m.len()
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.points_m.is_empty()
    }

    /// Times of the points at a TCP speed, m/s, to the microsecond; a step lasts one interpolation cycle at least.
    pub fn times_at(&self, speed_m_s: f64) -> Vec<f64> {
        let mut t = 0.0;
        let mut times = vec![0.0];
        for w in self.points_m.windows(2) {
            t += (distance(&w[0], &w[1]) / speed_m_s).max(SHORTEST_S);
            times.push((t * 1e6).round() / 1e6);
        }
        times
    }
}

struct Columns {
    /// Coordinate and column, coordinates rising.
    coordinates: Vec<(usize, usize)>,
    time: Option<usize>,
}

impl Columns {
    fn of(header: &csv::StringRecord, name: &str) -> Result<Self> {
        let names: Vec<String> = header.iter().map(|n| n.trim_start_matches('\u{feff}').to_ascii_lowercase()).collect();
        let mut columns = Self { coordinates: Vec::new(), time: None };
        for (k, n) in names.iter().enumerate() {
            let bad = |found: String| Err(Error::bad(Place::field(name, 1, k as u64 + 1), found, HEADER));
            if n == "t_s" {
                if columns.time.replace(k).is_some() {
                    return bad("a second column t_s".into());
                }
            } else if let Some(c) = LETTERS.iter().position(|l| *n == format!("{l}_mm")) {
                if columns.coordinates.iter().any(|(other, _)| *other == c) {
                    return bad(format!("a second column {n}"));
                }
                columns.coordinates.push((c, k));
            } else if n.ends_with("_deg") || LETTERS.iter().any(|l| n == l || n.starts_with(&format!("{l}_"))) {
                return bad(format!("column `{n}`"));
            }
        }
        columns.coordinates.sort_unstable();
        if columns.coordinates.is_empty() {
            return Err(Error::bad(Place::line(name, 1), format!("the columns {}", names.join(", ")), HEADER));
        }
        Ok(columns)
    }
}

/// Distance of two points with as many coordinates.
fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Path> {
        Path::parse(input::from_bytes("path.csv".into(), text.into())?)
    }

    #[test]
    fn a_path_may_leave_coordinates_free_and_have_times() {
        let p = parse("# a comment\nt_s,y_mm,x_mm\n0,2,1\n0.5,4,3\n").unwrap();
        assert_eq!(p.coordinates, [0, 1]);
        assert_eq!(p.points_m, [[1e-3, 2e-3], [3e-3, 4e-3]]);
        assert_eq!((p.t_s.clone(), p.line.clone()), (Some(vec![0.0, 0.5]), vec![3, 4]));
        assert_eq!(p.times_at(1e-3)[1], 2.828427, "the root of 8, to the microsecond");
    }

    #[test]
    fn what_is_no_path_is_refused_with_its_place() {
        for (text, says) in [
            ("x_mm,y_mm\n1,a\n", "path.csv:2:2: found `a`"),
            ("x_mm,y_mm\n1,nan\n", "path.csv:2:2"),
            ("x_mm,y_mm\n1\n", "path.csv:2"),
            ("x_mm,x_mm\n1,2\n", "a second column x_mm"),
            ("a1_deg,a2_deg\n1,2\n", "column `a1_deg`"),
            ("x_m,y_m\n1,2\n", "column `x_m`"),
            ("time\n1\n", "the columns time"),
            ("", "path.csv: found an empty file; expected a header with x_mm"),
            ("\n  \n", "an empty file"),
            ("# only\n", "only comments"),
            ("x_mm,t_s\n1,1\n2,1\n", "path.csv:3:2: found time 1 s after 1 s"),
            ("x_mm,y_mm\n", "no rows"),
            ("x_mm,y_mm\n1e9,1\n", "`1e9`"),
        ] {
            let e = parse(text).unwrap_err().to_string();
            assert!(e.contains(says), "{text}: {e}");
        }
    }
}
