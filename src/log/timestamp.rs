//! ISO 8601 date and time to microseconds since 1970-01-01T00:00Z.
//!
//! Method: `YYYY-MM-DD`, `T` or a blank, `hh:mm:ss` with up to any number of decimals after a point or comma, then `Z`, an
//! offset `+hh:mm`, `+hhmm` or `+hh`, or nothing (a clock without a zone). Days from the civil date by Hinnant's algorithm.
//! Microseconds are whole numbers far below 2^53, so differences are exact; what is finer is cut off.
//!
//! How it fails: `None` for anything else, a month 13 or a minute 60 included. A leap second (`:60`) is the next second.

/// Microseconds since 1970 in UTC.
pub(super) fn microseconds(text: &str) -> Option<f64> {
    let (date, clock) = text.split_once(['T', 't', ' '])?;
    let mut parts = date.splitn(3, '-');
    let (year, month, day) = (digits(parts.next()?, 4)?, digits(parts.next()?, 2)?, digits(parts.next()?, 2)?);
    if !(1..=12).contains(&month) || day < 1 || day > days_in(year, month) {
        return None;
    }
    let (clock, zone_min) = zone(clock)?;
    let mut parts = clock.splitn(3, ':');
    let (hour, minute) = (digits(parts.next()?, 2)?, digits(parts.next()?, 2)?);
    let (second, micro) = match parts.next()?.split_once(['.', ',']) {
        None => (digits(clock.rsplit(':').next()?, 2)?, 0),
        Some((whole, part)) if !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit()) => {
            let six: String = part.chars().chain("000000".chars()).take(6).collect();
            (digits(whole, 2)?, digits(&six, 6)?)
        }
        Some(_) => return None,
    };
    if hour > 23 || minute > 59 || second > 60 {
        return None;
    }
    let seconds = days(year, month, day) * 86_400 + hour * 3600 + (minute - zone_min) * 60 + second;
    Some((seconds * 1_000_000 + micro) as f64)
}

/// Clock without its zone, and the zone in minutes east.
fn zone(clock: &str) -> Option<(&str, i64)> {
    if let Some(rest) = clock.strip_suffix(['Z', 'z']) {
        return Some((rest, 0));
    }
    let Some(at) = clock.find(['+', '-']) else { return Some((clock, 0)) };
    let (rest, offset) = clock.split_at(at);
    let sign = if offset.starts_with('-') { -1 } else { 1 };
    let offset = offset[1..].replace(':', "");
    let (hours, minutes) = match offset.len() {
        2 => (digits(&offset, 2)?, 0),
        4 => (digits(offset.get(..2)?, 2)?, digits(offset.get(2..)?, 2)?),
        _ => return None,
    };
    (hours <= 23 && minutes <= 59).then_some((rest, sign * (60 * hours + minutes)))
}

fn digits(text: &str, count: usize) -> Option<i64> {
    (text.len() == count && text.bytes().all(|b| b.is_ascii_digit())).then(|| text.parse().ok())?
}

fn days_in(year: i64, month: i64) -> i64 {
    let leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
    match month {
        2 => 28 + i64::from(leap),
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

/// Days from 1970-01-01; years begin in March, so that the leap day comes last.
fn days(year: i64, month: i64, day: i64) -> i64 {
    let y = year - i64::from(month <= 2);
    let era = y.div_euclid(400);
    let year_of_era = y.rem_euclid(400);
    let day_of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    era * 146_097 + year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year - 719_468
}

#[cfg(test)]
mod tests {
    use super::microseconds;

    #[test]
    fn a_date_is_counted_from_1970_whatever_its_zone() {
        assert_eq!(microseconds("1970-01-01T00:00:00Z"), Some(0.0));
        assert_eq!(microseconds("2000-03-01T00:00:00Z"), Some(951_868_800e6));
        assert_eq!(microseconds("2025-11-12T10:03:29.555Z"), Some(1_762_941_809_555_000.0));
        for same in ["2025-11-12 11:03:29,555+01:00", "2025-11-12T04:33:29.5550009-0530", "2025-11-12T12:03:29.555+02"]
        {
            assert_eq!(microseconds(same), Some(1_762_941_809_555_000.0), "{same}");
        }
        assert_eq!(microseconds("1969-12-31T23:59:59.5Z"), Some(-500_000.0));
    }

    #[test]
    fn what_is_no_date_and_time_is_refused() {
        for text in [
            "",
            "2025-11-12",
            "2025-13-01T00:00:00",
            "2025-02-29T00:00:00",
            "2025-01-01T24:00:00",
            "2025-01-01T00:60:00",
            "2025-01-01T00:00:00.",
            "2025-01-01T00:00",
            "2025-01-01T00:00:00+1",
            "20250101T000000",
            "12.3",
            "2025-01-01Tä0:00:00",
        ] {
            assert_eq!(microseconds(text), None, "{text}");
        }
    }
}
