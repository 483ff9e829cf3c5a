//! Dates and times of day to microseconds.
//!
//! Method: a date (`YYYY-MM-DD`, `DD.MM.YYYY`, `MM/DD/YYYY`), `T` or blanks, `hh:mm:ss` with up to any number of decimals after a point or
//! comma, `AM` or `PM`, then `Z`, an offset `+hh:mm`, `+hhmm` or `+hh`, or nothing (a clock without a zone). Days from the civil
//! date by Hinnant's algorithm. Microseconds are whole numbers far below 2^53, so differences are exact; what is finer is cut off.
//!
//! A time of day that falls by more than half a day from one row to the next has passed midnight ([`Stamp::since_first`]).
//!
//! How it fails: `None` for anything else, a month 13 or a minute 60 included. A leap second (`:60`) is the next second.

/// How a column writes its times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stamp {
    /// Date with the year first, and time.
    YearFirst,
    /// Time of day alone.
    TimeOfDay,
    /// Date with the day first, and time.
    DayFirst,
    /// Date with the month first, and time.
    MonthFirst,
}

const DAY_US: f64 = 86_400e6;

impl Stamp {
    /// Every way, with its unit in a column map.
    pub const ALL: [(Self, &'static str); 4] = [
        (Self::YearFirst, "iso8601"),
        (Self::TimeOfDay, "hms"),
        (Self::DayFirst, "dmy_hms"),
        (Self::MonthFirst, "mdy_hms"),
    ];

    /// By the unit in a column map.
    pub fn named(unit: &str) -> Option<Self> {
        Self::ALL.iter().find(|s| s.1 == unit).map(|s| s.0)
    }

    /// The unit in a column map.
    pub fn unit(self) -> &'static str {
        Self::ALL.iter().find(|s| s.0 == self).map_or("", |s| s.1)
    }

    /// What a cell looks like, for messages.
    pub fn expected(self) -> &'static str {
        match self {
            Self::YearFirst => "a date and time, e.g. 2025-11-12T10:03:29.555Z",
            Self::TimeOfDay => "a time of day, e.g. 10:03:29.555",
            Self::DayFirst => "a date and time, e.g. 12.11.2025 10:03:29.555",
            Self::MonthFirst => "a date and time, e.g. 11/12/2025 10:03:29.555",
        }
    }

    /// Microseconds since 1970 in UTC, or since midnight.
    pub fn microseconds(self, text: &str) -> Option<f64> {
        if self == Self::TimeOfDay {
            return clock_us(text.trim(), true).map(|us| us as f64);
        }
        let (date, clock) = text.trim().split_once(['T', 't', ' '])?;
        let mut parts = date.split(['-', '.', '/']);
        let (a, b, c) = (parts.next()?, parts.next()?, parts.next()?);
        let (year, month, day) = match self {
            Self::DayFirst => (digits(c, 4)?, few_digits(b)?, few_digits(a)?),
            Self::MonthFirst => (digits(c, 4)?, few_digits(a)?, few_digits(b)?),
            _ => (digits(a, 4)?, digits(b, 2)?, digits(c, 2)?),
        };
        if parts.next().is_some() || !(1..=12).contains(&month) || day < 1 || day > days_in(year, month) {
            return None;
        }
        let (clock, zone_min) = zone(clock.trim_start())?;
        let of_day = clock_us(clock, self != Self::YearFirst)?;
        Some(((days(year, month, day) * 86_400 - zone_min * 60) * 1_000_000 + of_day) as f64)
    }

    /// Turns the microseconds of a column's rows into those since its first.
    pub fn since_first(self, values: &mut [f64]) {
        let first = values.first().copied().unwrap_or(0.0);
        let (mut before, mut midnights) = (first, 0.0);
        for v in values {
            if self == Self::TimeOfDay && before - *v > 0.5 * DAY_US {
                midnights += DAY_US;
            }
            before = *v;
            *v += midnights - first;
        }
    }

    /// The ways that read every one of these cells.
    pub fn reading<'a>(cells: impl Iterator<Item = &'a str> + Clone) -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().map(|s| s.0).filter(move |s| {
            let mut read = cells.clone().map(|cell| s.microseconds(cell)).peekable();
            read.peek().is_some() && read.all(|us| us.is_some())
        })
    }
}

/// Microseconds since midnight of `hh:mm:ss.fff`; `AM` and `PM`, and an hour of one digit, where `freely`.
fn clock_us(clock: &str, freely: bool) -> Option<i64> {
    let lower = clock.to_ascii_lowercase();
    let half = ["am", "pm"].into_iter().find_map(|half| Some((lower.strip_suffix(half)?.trim_end(), half)));
    let (clock, half) = half.filter(|_| freely).map_or((clock, None), |(clock, half)| (clock, Some(half)));
    let mut parts = clock.splitn(3, ':');
    let (hour, minute) = (parts.next()?, digits(parts.next()?, 2)?);
    let hour = if freely { few_digits(hour)? } else { digits(hour, 2)? };
    let (second, micro) = match parts.next()?.split_once(['.', ',']) {
        None => (digits(clock.rsplit(':').next()?, 2)?, 0),
        Some((whole, part)) if !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit()) => {
            let six: String = part.chars().chain("000000".chars()).take(6).collect();
            (digits(whole, 2)?, digits(&six, 6)?)
        }
        Some(_) => return None,
    };
    let hour = match half {
        None if hour <= 23 => hour,
        Some(half) if (1..=12).contains(&hour) => hour % 12 + if half == "pm" { 12 } else { 0 },
        _ => return None,
    };
    (minute <= 59 && second <= 60).then_some(((hour * 60 + minute) * 60 + second) * 1_000_000 + micro)
}

/// One or two digits.
fn few_digits(text: &str) -> Option<i64> {
    digits(text, if text.len() == 1 { 1 } else { 2 })
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
    use super::Stamp;

    fn microseconds(text: &str) -> Option<f64> {
        Stamp::YearFirst.microseconds(text)
    }

    #[test]
    fn a_time_of_day_is_counted_over_midnight() {
        let stamp = Stamp::TimeOfDay;
        let cells = ["23:59:59,500", "23:59:59.750000", "00:00:00,25", "0:00:01"];
        let mut us: Vec<f64> = cells.iter().map(|c| stamp.microseconds(c).unwrap()).collect();
        stamp.since_first(&mut us);
        assert_eq!(us, [0.0, 250_000.0, 750_000.0, 1_500_000.0]);
        assert_eq!(stamp.microseconds("12:00:00 AM"), Some(0.0));
        assert_eq!(stamp.microseconds("1:02:03 pm"), Some(46_923e6));
        for text in ["24:00:00", "13:00:00 PM", "10:00", "2025-01-01 10:00:00", "1.5"] {
            assert_eq!(stamp.microseconds(text), None, "{text}");
        }
    }

    #[test]
    fn dates_of_other_countries_are_read_by_their_order() {
        let want = Some(1_762_941_809_555_000.0);
        for same in ["12.11.2025 10:03:29,555", "12/11/2025 10:03:29.555", "12-11-2025  10:03:29.555"] {
            assert_eq!(Stamp::DayFirst.microseconds(same), want, "{same}");
        }
        assert_eq!(Stamp::MonthFirst.microseconds("11/12/2025 10:03:29.555 AM"), want);
        assert_eq!(Stamp::MonthFirst.microseconds("13/12/2025 10:03:29"), None);
        assert_eq!(Stamp::DayFirst.microseconds("12.11.25 10:03:29"), None);
        let ways = |cells: &'static [&str]| Stamp::reading(cells.iter().copied()).collect::<Vec<_>>();
        assert_eq!(ways(&["11/12/2025 10:00:00", "11/13/2025 10:00:00"]), [Stamp::MonthFirst]);
        assert_eq!(ways(&["10:00:00,000"]), [Stamp::TimeOfDay]);
        assert_eq!(ways(&["1.5"]), []);
        assert_eq!(ways(&[]), []);
    }

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
