//! Which column of a readings file is what, and how its numbers become SI.
//!
//! Names are the contract's: `position_mm`, `direction`, `repeat`, `error_um`; lengths may stand in another unit (`error_mm`,
//! `position_m`), and `reading_mm`, the measured position, may stand instead of the error. Other names, units and signs come
//! through a column map. Every further column is a state (speed, payload); a choice of them may be named.

use crate::error::{Error, Place, Result};
use crate::log::ColumnMap;
use crate::log::columns::{Mapped, listed, unit_named};

/// Meaning of a column that is used.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Role {
    Position,
    Direction,
    Repeat,
    /// Measured minus commanded.
    Error,
    /// Measured position.
    Reading,
    State(String),
}

/// A column that is used.
pub(super) struct Column<'a> {
    /// Field number from 0.
    pub index: usize,
    pub name: String,
    pub role: Role,
    /// Metres per unit as written; 1 for what is no length.
    pub si: f64,
    pub map: Option<Mapped<'a>>,
}

/// Columns of a log that say nothing about a state.
const NO_STATES: &[&str] = &["t_s", "index", "temp_c", "trigger", "line"];

/// Role and metres per unit of one of our names; `None`: not one of them.
fn role(name: &str) -> Option<(Role, f64)> {
    let name = name.trim().to_ascii_lowercase();
    match name.as_str() {
        "direction" | "dir" => return Some((Role::Direction, 1.0)),
        "repeat" | "repetition" | "cycle" | "run" => return Some((Role::Repeat, 1.0)),
        _ => {}
    }
    let (base, unit) = name.rsplit_once('_')?;
    let ('l', si) = unit_named(unit)? else { return None };
    match base {
        "position" => Some((Role::Position, si)),
        "error" => Some((Role::Error, si)),
        "reading" => Some((Role::Reading, si)),
        _ => None,
    }
}

/// The columns that are used, in the order of the file; `states` chooses the state columns.
pub(super) fn resolve<'a>(
    header: &[String],
    map: Option<&'a ColumnMap>,
    states: Option<&[String]>,
    at: &Place,
) -> Result<Vec<Column<'a>>> {
    let mut used: Vec<Column> = Vec::new();
    for (index, theirs) in header.iter().enumerate() {
        let place = Place { column: Some(index as u64 + 1), ..at.clone() };
        let mapped = map.and_then(|m| m.of(theirs));
        let ours = match &mapped {
            Some(m) => match m.to {
                Some(to) => to,
                None => continue,
            },
            None => theirs.as_str(),
        };
        let (role, si) = match role(ours) {
            Some(known) => known,
            None => {
                let chosen = states.map_or(!NO_STATES.contains(&ours.to_ascii_lowercase().as_str()), |names| {
                    names.iter().any(|n| n.eq_ignore_ascii_case(ours))
                });
                if !chosen {
                    continue;
                }
                if ours.trim().is_empty() {
                    return Err(Error::bad(place, "a column without a name", "a name for every column"));
                }
                (Role::State(ours.to_string()), 1.0)
            }
        };
        let si = match mapped.as_ref().and_then(|m| Some((m, m.unit?))) {
            None => si,
            Some((_, unit)) => match (&role, unit_named(unit)) {
                (Role::Position | Role::Error | Role::Reading, Some(('l', theirs))) => theirs,
                _ => {
                    let expected = "a unit of length for a position, an error or a reading, and none for others";
                    return Err(Error::bad(place, format!("unit `{unit}` for `{ours}`"), expected));
                }
            },
        };
        if let Some(before) = used.iter().find(|c| c.role == role) {
            return Err(Error::bad(
                place,
                format!("a second column for `{ours}` (the first is column {})", before.index + 1),
                "one column of each kind",
            ));
        }
        used.push(Column { index, name: theirs.clone(), role, si, map: mapped });
    }
    check(&used, header, map, states, at)?;
    Ok(used)
}

/// What must be there is there, and what the user named is in the file.
fn check(
    used: &[Column],
    header: &[String],
    map: Option<&ColumnMap>,
    states: Option<&[String]>,
    at: &Place,
) -> Result<()> {
    let has = |role: &Role| used.iter().any(|c| c.role == *role);
    if let Some(map) = map
        && let Some(missing) = map.names().find(|n| !header.iter().any(|h| h == n))
    {
        let found = format!("no column `{missing}`, which {} names", map.file());
        return Err(Error::bad(at.clone(), found, format!("a column of that name among {}", listed(header))));
    }
    for name in states.unwrap_or_default() {
        if !used.iter().any(|c| matches!(&c.role, Role::State(s) if s.eq_ignore_ascii_case(name))) {
            let found = format!("no column `{name}`, which is named as a state");
            return Err(Error::bad(at.clone(), found, format!("a column of that name among {}", listed(header))));
        }
    }
    let missing = if !has(&Role::Position) {
        "no column `position_mm`"
    } else if !has(&Role::Direction) {
        "no column `direction`"
    } else if !has(&Role::Error) && !has(&Role::Reading) {
        "no column `error_um`"
    } else if has(&Role::Error) && has(&Role::Reading) {
        "both an error and a reading"
    } else {
        return Ok(());
    };
    Err(Error::bad(
        at.clone(),
        format!("{missing} (columns: {})", listed(header)),
        "position_mm, direction, repeat and error_um (or error_mm, or reading_mm: the measured position), or a column map \
         that names them",
    ))
}
