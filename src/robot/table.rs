//! A robot from the Denavit-Hartenberg table of a data sheet, as CSV.
//!
//! Method: one row a joint, base to flange, with the keys of the robot file as headings: `name`, `kind`, `theta_deg`, `d_mm`, `a_mm`,
//! `alpha_deg`, `direction`, limits as `min_deg,max_deg` or `min_mm,max_mm`, `max_speed_deg_s`, `max_speed_mm_s`, `max_accel_deg_s2`,
//! `max_accel_mm_s2`. A heading that is not there, or an empty cell, takes the default: a revolute joint, 0, direction 1, no limit.
//! `base`, `flange` and `tool` are not read: add them in the robot file.
//!
//! Refused, with line and column: a heading that is none of these, a cell that is no number, one limit without the other.

use super::{Convention, Joint, JointKind, Robot};
use crate::error::{Error, Place, Result};
use crate::io::input;
use nalgebra::Isometry3;

const HEADINGS: [&str; 15] = [
    "name",
    "kind",
    "theta_deg",
    "d_mm",
    "a_mm",
    "alpha_deg",
    "direction",
    "min_deg",
    "max_deg",
    "min_mm",
    "max_mm",
    "max_speed_deg_s",
    "max_speed_mm_s",
    "max_accel_deg_s2",
    "max_accel_mm_s2",
];

/// A row with its headings.
struct Row<'a> {
    file: &'a str,
    line: u64,
    headings: &'a [String],
    record: &'a csv::StringRecord,
}

impl Row<'_> {
    fn column(&self, heading: &str) -> Option<usize> {
        self.headings.iter().position(|h| h == heading)
    }

    fn text(&self, heading: &str) -> Option<&str> {
        self.record.get(self.column(heading)?).map(str::trim).filter(|t| !t.is_empty())
    }

    fn bad(&self, heading: &str, found: impl Into<String>, expected: impl Into<String>) -> Error {
        let column = self.column(heading).map_or(1, |k| k as u64 + 1);
        Error::bad(Place::field(self.file, self.line, column), found, expected)
    }

    fn number(&self, heading: &str) -> Result<Option<f64>> {
        let Some(text) = self.text(heading) else { return Ok(None) };
        match text.parse::<f64>().ok().filter(|v| v.is_finite()) {
            Some(v) => Ok(Some(v)),
            None => Err(self.bad(heading, format!("`{text}`"), format!("a number, {heading}"))),
        }
    }

    /// The value under `heading` with the unit of the kind: `max_speed_deg_s` of a revolute joint; SI.
    fn of_kind(&self, kind: JointKind, deg: &str, mm: &str) -> Result<Option<f64>> {
        let (own, other) = if kind == JointKind::Revolute { (deg, mm) } else { (mm, deg) };
        if self.text(other).is_some() {
            let what = if kind == JointKind::Revolute { "revolute" } else { "prismatic" };
            return Err(self.bad(other, format!("{other} of a {what} joint"), format!("an empty cell, and {own}")));
        }
        Ok(self.number(own)?.map(|v| v * kind.si_per_user_unit()))
    }

    fn joint(&self, number: usize) -> Result<Joint> {
        let kind = match self.text("kind") {
            None | Some("revolute") => JointKind::Revolute,
            Some("prismatic") => JointKind::Prismatic,
            Some(other) => return Err(self.bad("kind", format!("`{other}`"), "revolute or prismatic")),
        };
        let or_zero = |heading: &str| self.number(heading).map(|v| v.unwrap_or(0.0));
        let limits = match (self.of_kind(kind, "min_deg", "min_mm")?, self.of_kind(kind, "max_deg", "max_mm")?) {
            (Some(lo), Some(hi)) if lo < hi => Some([lo, hi]),
            (None, None) => None,
            _ => {
                let heading = if kind == JointKind::Revolute { "min_deg" } else { "min_mm" };
                return Err(self.bad(heading, "limits that are not a range", "both ends, the lower one first"));
            }
        };
        let direction = match self.number("direction")? {
            None => 1.0,
            Some(v) if v.abs() == 1.0 => v,
            Some(v) => return Err(self.bad("direction", format!("{v}"), "1 or -1")),
        };
        Ok(Joint {
            name: self.text("name").map_or_else(|| format!("J{number}"), str::to_string),
            kind,
            theta_rad: or_zero("theta_deg")?.to_radians(),
            d_m: or_zero("d_mm")? * 1e-3,
            a_m: or_zero("a_mm")? * 1e-3,
            alpha_rad: or_zero("alpha_deg")?.to_radians(),
            beta_rad: 0.0,
            direction,
            limits,
            max_speed: self.of_kind(kind, "max_speed_deg_s", "max_speed_mm_s")?,
            max_accel: self.of_kind(kind, "max_accel_deg_s2", "max_accel_mm_s2")?,
            lead_m_per_rev: None,
            pulses: None,
            follows: None,
        })
    }
}

/// Reads a table; `name` of the file stands in messages.
pub fn read(name: &str, text: &str, title: &str, convention: Convention) -> Result<Robot> {
    input::refuse_no_rows(name, text, "a heading and one row for each joint")?;
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(text.as_bytes());
    let wrong = |e: csv::Error| {
        let line = e.position().map_or(1, csv::Position::line);
        Error::bad(Place::line(name, line), e.to_string(), "CSV with one row for each joint")
    };
    let headings: Vec<String> = reader.headers().map_err(wrong)?.iter().map(str::to_string).collect();
    if let Some(k) = headings.iter().position(|h| !HEADINGS.contains(&h.as_str())) {
        let place = Place::field(name, 1, k as u64 + 1);
        return Err(Error::bad(place, format!("heading `{}`", headings[k]), format!("one of {}", HEADINGS.join(", "))));
    }
    let mut joints = Vec::new();
    for record in reader.records() {
        let record = record.map_err(wrong)?;
        let line = record.position().map_or(1, csv::Position::line);
        joints.push(Row { file: name, line, headings: &headings, record: &record }.joint(joints.len() + 1)?);
    }
    if joints.is_empty() {
        return Err(Error::bad(Place::file(name), "no joint", "a heading and one row for each joint"));
    }
    let still = Isometry3::identity();
    Ok(Robot::new(title.to_string(), convention, joints, still, still))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_the_robot_of_its_rows() {
        let text = "name,d_mm,a_mm,alpha_deg,min_deg,max_deg,max_speed_deg_s\n# axis 1\nA1,400,100,-90,-170,170,120\nA2,,500,0,,,\n";
        let robot = read("dh.csv", text, "arm", Convention::Standard).unwrap();
        assert_eq!(robot.axis_names(), ["A1", "A2"]);
        // by hand: both links stretched out along x, 400 mm up
        let tcp = robot.tcp_m(&[0.0, 0.0]) * 1e3;
        assert!((tcp - nalgebra::Vector3::new(600.0, 0.0, 400.0)).norm() < 1e-9, "{tcp}");
        // A2 turns about an axis that lies across: a quarter turn points down
        let tcp = robot.tcp_m(&[0.0, std::f64::consts::FRAC_PI_2]) * 1e3;
        assert!((tcp - nalgebra::Vector3::new(100.0, 0.0, -100.0)).norm() < 1e-9, "{tcp}");
        assert_eq!(robot.axis(0).limits.map(|l| l.map(f64::to_degrees)), Some([-170.0, 170.0]));
        let again = Robot::parse("robot.yaml", &robot.to_yaml().unwrap()).unwrap();
        assert_eq!(again.fingerprint(), robot.fingerprint());
    }

    #[test]
    fn what_is_no_table_is_refused_with_line_and_column() {
        for (text, says) in [
            ("", "an empty file"),
            ("a_mm,alfa_deg\n1,2\n", "dh.csv:1:2: found heading `alfa_deg`"),
            ("a_mm,d_mm\n1,x\n", "dh.csv:2:2: found `x`"),
            ("a_mm,min_deg,max_deg\n1,-10,\n", "limits that are not a range"),
            ("kind,max_speed_deg_s\nprismatic,10\n", "max_speed_deg_s of a prismatic joint"),
            ("a_mm,d_mm\n1\n", "dh.csv:2"),
        ] {
            let error = read("dh.csv", text, "arm", Convention::Standard).unwrap_err().to_string();
            assert!(error.contains(says), "{says}: {error}");
        }
    }
}
