//! Readings that were held: a recorder that is faster than the controller or the tracker writes the last reading again until a new one
//! comes.
//!
//! A joint that turns evenly then seems to step and to wait, and the steps look like lost motion many times the gap. Method: rows in which
//! any value of a group (all commands, all encoders, the TCP) is new are its readings. Where they come every so many rows, evenly
//! but for pauses, they are taken as readings with their own clock. Positions of joints are interpolated between them
//! ([`Series`]: no reversal is added, no peak cut); of a repeated TCP the first row counts and the others are lost.
//!
//! Times: each reading was made within the row before the one that shows it first, by an even clock of the controller or with that row,
//! whose own times may jitter. The times with which the speeds of the joints change least from reading to reading are taken: the other
//! ones add their errors. What is left is an offset of the log's clock, which identification knows.
//!
//! How it fails: where a joint turns so slowly and evenly that its last digit changes every few rows, it is interpolated, too, which
//! changes no value by more than that digit.

use super::Log;
use super::note::{Columns, Note};
use crate::numerics::robust::{lower_quantile, median_of};
use crate::numerics::series::Series;
use std::ops::Range;

/// Readings from which it can be seen how they come.
const FEWEST: usize = 20;
/// Rows for which a reading stands, in the mean: from here on it was held.
const LEAST_ROWS: f64 = 1.3;
/// A reading that stays for this many times the usual rows is a pause.
const REST: usize = 3;
/// Share of the other readings that stand for the mean number of rows, give or take one.
const REGULAR: f64 = 0.9;
/// Part of an interval by which a reading may come late.
const UNEVEN: f64 = 0.3;
/// Scatter of readings about an even clock, in rows: with more they have none. And the share of them that may lie outside.
const EVEN_ROWS: f64 = 1.2;
const OUTSIDE: f64 = 0.02;

/// Takes back what holding did; one note for each group of columns.
pub(super) fn undo(log: &mut Log) -> Vec<Note> {
    let mut notes = Vec::new();
    if log.poses {
        return notes;
    }
    let t_s = &log.t_s;
    if let Some(held) = Held::find(t_s, |i| log.cmd.iter().any(|c| c[i] != c[i - 1])) {
        notes.push(held.note(Columns::Commands));
        let lost = held.unknown_end(|from, to| log.cmd.iter().any(|c| c[from] != c[to]));
        log.cmd = held.between(t_s, &log.cmd);
        log.tcp_m.iter_mut().skip(lost).for_each(|p| *p = None);
        log.instruments.singles_mut().for_each(|c| c.iter_mut().skip(lost).for_each(|v| *v = None));
    }
    let groups =
        [(Columns::Encoders, &mut log.enc), (Columns::Screws, &mut log.screw), (Columns::JointSensors, &mut log.meas)];
    for (columns, group) in groups {
        // a sensor that misses rows has no rows in a row
        let mut whole: Vec<&mut Vec<Option<f64>>> =
            group.iter_mut().flatten().filter(|c| c.iter().all(Option::is_some)).collect();
        let Some(held) = Held::find(t_s, |i| whole.iter().any(|c| c[i] != c[i - 1])) else { continue };
        notes.push(held.note(columns));
        let values: Vec<Vec<f64>> = whole.iter().map(|c| c.iter().copied().flatten().collect()).collect();
        for (column, values) in whole.iter_mut().zip(held.between(t_s, &values)) {
            **column = values.into_iter().map(Some).collect();
        }
    }
    if log.tcp_m.len() == t_s.len()
        && let Some(held) = Held::find(t_s, |i| log.tcp_m[i].is_none() || log.tcp_m[i] != log.tcp_m[i - 1])
    {
        notes.push(held.note(Columns::Tcp));
        let mut fresh = vec![false; t_s.len()];
        held.readings.iter().for_each(|i| fresh[*i] = true);
        log.tcp_m.iter_mut().zip(&fresh).filter(|(_, fresh)| !**fresh).for_each(|(p, _)| *p = None);
    }
    notes
}

/// Readings that rows repeat.
struct Held {
    /// Row that shows each reading first.
    readings: Vec<usize>,
    /// Time from a reading to the next where nothing pauses, s; and rows.
    every_s: f64,
    every_rows: f64,
    rows: usize,
}

impl Held {
    /// `new(i)`: row `i`, which is not the first, shows another value than the row before.
    fn find(t_s: &[f64], new: impl Fn(usize) -> bool) -> Option<Self> {
        let readings: Vec<usize> = (0..t_s.len()).filter(|&i| i == 0 || new(i)).collect();
        if readings.len() < FEWEST {
            return None;
        }
        let stands: Vec<usize> = readings.windows(2).map(|w| w[1] - w[0]).collect();
        let usual = median_of(&mut stands.iter().map(|n| *n as f64).collect::<Vec<_>>())?;
        let moving = |n: usize| (n as f64) < REST as f64 * usual;
        let short: Vec<f64> = stands.iter().filter(|n| moving(**n)).map(|n| *n as f64).collect();
        let every_rows = short.iter().sum::<f64>() / short.len() as f64;
        let regular = short.iter().filter(|n| (**n - every_rows).abs() <= 1.0).count();
        if short.len() < FEWEST || every_rows < LEAST_ROWS || (regular as f64) < REGULAR * short.len() as f64 {
            return None;
        }
        let seen: Vec<f64> = readings.iter().map(|i| t_s[*i]).collect();
        let steps = seen.windows(2).zip(&stands).filter(|(_, n)| moving(**n)).map(|(w, _)| w[1] - w[0]);
        let every_s = steps.sum::<f64>() / short.len() as f64;
        Some(Self { readings, every_s, every_rows, rows: t_s.len() })
    }

    fn note(&self, columns: Columns) -> Note {
        Note::Held { columns, every_rows: self.every_rows, every_s: self.every_s }
    }

    /// First of the last rows of which it is not known how the joints move on, where `moved` from one row to another.
    fn unknown_end(&self, moved: impl Fn(usize, usize) -> bool) -> usize {
        match self.readings[..] {
            [.., before, last]
                if self.rows - last < (REST as f64 * self.every_rows) as usize && moved(before, last) =>
            {
                last + 1
            }
            _ => self.rows,
        }
    }

    /// When each reading was made, s.
    fn times(&self, t_s: &[f64], columns: &[Vec<f64>]) -> Vec<f64> {
        let seen: Vec<f64> = self.readings.iter().map(|i| t_s[*i]).collect();
        let Some(even) = even(&seen, self.every_s, self.every_s / self.every_rows) else { return seen };
        let rough = |times: &[f64]| -> f64 {
            let speed =
                |c: &[f64], k: usize| (c[self.readings[k + 1]] - c[self.readings[k]]) / (times[k + 1] - times[k]);
            let of = |c: &Vec<f64>| (2..times.len()).map(|k| (speed(c, k - 1) - speed(c, k - 2)).powi(2)).sum::<f64>();
            columns.iter().map(of).sum()
        };
        if rough(&even) < rough(&seen) { even } else { seen }
    }

    /// Columns between the readings, at the times of the rows.
    fn between(&self, t_s: &[f64], columns: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let at_s = self.times(t_s, columns);
        let mut knots: Vec<(f64, usize)> = Vec::with_capacity(self.readings.len());
        for (k, (&row, &at)) in self.readings.iter().zip(&at_s).enumerate() {
            knots.push((at, row));
            // a stationary joint is read again and again: the first and the last of these readings tell when it stops and starts
            let next = at_s.get(k + 1).copied().unwrap_or(t_s[t_s.len() - 1] + self.every_s);
            let intervals = (next - at) / self.every_s;
            if intervals > 2.0 - UNEVEN {
                knots.push((next - self.every_s, row));
            }
            if intervals > 3.0 - UNEVEN {
                knots.push((at + self.every_s, row));
            }
        }
        knots.sort_by(|a, b| a.0.total_cmp(&b.0));
        let times: Vec<f64> = knots.iter().map(|k| k.0).collect();
        let values = columns.iter().map(|c| knots.iter().map(|k| c[k.1]).collect()).collect();
        let series = Series::new(times, values, &vec![0.0; columns.len()]);
        let mut out: Vec<Vec<f64>> = columns.iter().map(|c| Vec::with_capacity(c.len())).collect();
        let (mut at, mut rates) = (vec![0.0; columns.len()], vec![0.0; columns.len()]);
        for (row, t) in t_s.iter().enumerate() {
            let known = series.at(*t, &mut at, &mut rates);
            for (c, out) in out.iter_mut().enumerate() {
                out.push(if known { at[c] } else { columns[c][row] });
            }
        }
        out
    }
}

/// Times of readings by an even clock, where it has them within a row.
fn even(seen: &[f64], every_s: f64, row_s: f64) -> Option<Vec<f64>> {
    let ticks = ticks(seen, every_s);
    let clock = line(&ticks, seen)?;
    let times: Vec<f64> = ticks.iter().map(|k| clock.at(*k)).collect();
    let late: Vec<f64> = seen.iter().zip(&times).map(|(t, l)| t - l).collect();
    let [low, high] = [OUTSIDE, 1.0 - OUTSIDE].map(|q| lower_quantile(&late, q));
    (high - low <= EVEN_ROWS * row_s).then(|| times.into_iter().map(|t| t + low).collect())
}

/// Intervals of an even clock up to each reading.
///
/// From one reading to the next it is one, but across a pause, whose length in intervals is rounded: by the starts of the strokes before
/// and after it, each the earliest that its readings allow, as a single reading may come late by a row.
fn ticks(seen: &[f64], every_s: f64) -> Vec<f64> {
    let mut strokes: Vec<Range<usize>> = Vec::new();
    for k in 0..seen.len() {
        match strokes.last_mut() {
            Some(stroke) if seen[k] - seen[k - 1] < (2.0 - UNEVEN) * every_s => stroke.end = k + 1,
            _ => strokes.push(k..k + 1),
        }
    }
    // the interval that is the same in all strokes
    let within: Vec<Line> = strokes
        .iter()
        .filter_map(|s| line(&(0..s.len()).map(|k| k as f64).collect::<Vec<_>>(), &seen[s.clone()]))
        .collect();
    let squares: f64 = within.iter().map(|l| l.squares).sum();
    let every_s = within.iter().map(|l| l.every_s * l.squares).sum::<f64>() / squares;
    let mut ticks: Vec<f64> = Vec::with_capacity(seen.len());
    let mut before: Option<(f64, f64)> = None;
    for stroke in strokes {
        let start = |k: usize| seen[k] - every_s * (k - stroke.start) as f64;
        let start_s = stroke.clone().map(start).fold(f64::INFINITY, f64::min);
        let tick = before.map_or(0.0, |(tick, s): (f64, f64)| tick + ((start_s - s) / every_s).round().max(1.0));
        before = Some((tick, start_s));
        ticks.extend((0..stroke.len()).map(|k| tick + k as f64));
    }
    ticks
}

/// A straight line of time over intervals.
struct Line {
    middle: [f64; 2],
    every_s: f64,
    /// Sum of the squares of the intervals about their middle.
    squares: f64,
}

impl Line {
    fn at(&self, tick: f64) -> f64 {
        self.middle[1] + self.every_s * (tick - self.middle[0])
    }
}

/// Least squares; `None` of a single point.
fn line(ticks: &[f64], t_s: &[f64]) -> Option<Line> {
    let n = ticks.len() as f64;
    let middle = [ticks, t_s].map(|v| v.iter().sum::<f64>() / n);
    let squares: f64 = ticks.iter().map(|k| (k - middle[0]).powi(2)).sum();
    let products: f64 = ticks.iter().zip(t_s).map(|(k, t)| (k - middle[0]) * (t - middle[1])).sum();
    (squares > 0.0).then(|| Line { middle, every_s: products / squares, squares })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::input::Input;
    use crate::robot::Robot;
    use std::f64::consts::PI;

    const ROBOT: &str = "schema: lostmotion/robot/1\njoints:\n  - {name: A1, kind: revolute, a_mm: 500}\n  - {name: A2, kind: revolute, a_mm: 400}\n";

    /// Commands in deg at a time: a pause, a stroke there and back, a pause.
    fn commands(t: f64) -> [f64; 2] {
        let x = (t - 2.0).clamp(0.0, 20.0);
        [5.0 - 5.0 * (0.1 * PI * x).cos(), 3.0 - 3.0 * (0.2 * PI * x).cos()]
    }

    /// A log at `rate` Hz of a controller with `controller` new readings a second, a tracker `tracker` times.
    fn log(rate: f64, controller: f64, tracker: f64) -> Log {
        let mut text = String::from("t_s,cmd_A1_deg,cmd_A2_deg,x_mm,y_mm,z_mm\n");
        let last = |t: f64, hz: f64| ((t * hz + 1e-9).floor()) / hz;
        for i in 0..(24.0 * rate) as usize {
            let t = i as f64 / rate;
            let [a, b] = commands(last(t, controller));
            let x = 900.0 + 3.0 * last(t, tracker);
            text += &format!("{t:.6},{a:.6},{b:.6},{x:.4},{:.4},0\n", 2.0 * x);
        }
        let robot = Robot::parse("robot.yaml", ROBOT).unwrap();
        Log::parse(Input { name: "log.csv".into(), bytes: text.into(), sha256: String::new() }, &robot).unwrap()
    }

    /// Largest difference to the commands at the times of the rows, deg, rows up to `until` s.
    fn off(log: &Log, until: f64, late_s: f64) -> f64 {
        let rows = (0..log.len()).filter(|i| log.t_s[*i] < until);
        rows.map(|i| {
            let want = commands(log.t_s[i] - late_s);
            (0..2).map(|a| (log.cmd[a][i].to_degrees() - want[a]).abs()).fold(0.0, f64::max)
        })
        .fold(0.0, f64::max)
    }

    #[test]
    fn joints_between_readings_are_where_they_were_whatever_the_two_rates() {
        for (rate, controller) in [(20.0, 5.0), (50.0, 20.0), (125.0, 50.0), (30.0, 20.0), (100.0, 8.0)] {
            let mut held = log(rate, controller, rate);
            let before = off(&held, 21.0, 0.0);
            let notes = undo(&mut held);
            assert_eq!(notes.len(), 1, "{rate} {controller}: {notes:?}");
            // the clock of the readings starts within the first row
            let after = (0..=20).map(|k| off(&held, 21.0, f64::from(k) * 0.05 / rate)).fold(f64::INFINITY, f64::min);
            assert!(after < 0.02 * before, "{rate} {controller}: {before} -> {after}");
            assert_eq!(held.tcp_m.iter().flatten().count(), held.len());
        }
    }

    #[test]
    fn rests_stay_rests_and_no_reversal_is_added() {
        let mut held = log(50.0, 10.0, 50.0);
        undo(&mut held);
        let turns = |c: &[f64]| {
            let steps: Vec<f64> = c.windows(2).map(|w| w[1] - w[0]).filter(|d| d.abs() > 1e-12).collect();
            steps.windows(2).filter(|w| w[0] * w[1] < 0.0).count()
        };
        let given: Vec<Vec<f64>> =
            (0..2).map(|a| (0..1200).map(|i| commands(f64::from(i) * 0.02)[a]).collect()).collect();
        assert_eq!([turns(&held.cmd[0]), turns(&held.cmd[1])], [turns(&given[0]), turns(&given[1])]);
        let still = (0..95).all(|i| held.cmd[0][i] == held.cmd[0][0]);
        assert!(still, "the first rest lasts 2 s");
    }

    #[test]
    fn a_tcp_that_repeats_counts_once() {
        let mut held = log(50.0, 50.0, 10.0);
        let notes = undo(&mut held);
        let [note] = &notes[..] else { panic!("{notes:?}") };
        assert!(note.to_string().starts_with("TCP positions change only every 5.0 rows (0.100 s)"), "{note}");
        assert_eq!(held.tcp_m.iter().flatten().count(), 240);
        assert!(off(&held, 24.0, 0.0) < 1e-6);
    }

    #[test]
    fn rows_of_their_own_stay_as_they_are() {
        let given = log(50.0, 50.0, 50.0);
        let mut same = given.clone();
        assert!(undo(&mut same).is_empty());
        assert_eq!((&same.cmd, &same.tcp_m), (&given.cmd, &given.tcp_m));
    }

    #[test]
    fn what_is_rounded_so_that_it_changes_now_and_then_is_not_held() {
        let mut rounded = log(50.0, 50.0, 50.0);
        for (i, v) in rounded.cmd[0].iter_mut().enumerate() {
            *v = ((0.002 * i as f64 + 0.8 * (i as f64 * 0.05).sin()).round() * 1e-3).to_radians();
        }
        rounded.cmd[1].fill(0.0);
        let given = rounded.clone();
        assert!(undo(&mut rounded).is_empty());
        assert_eq!(rounded.cmd, given.cmd);
    }
}
