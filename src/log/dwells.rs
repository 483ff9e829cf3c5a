//! Dwells: where the robot stands still, which joint brought it there, from which side, and what was measured.
//!
//! Method: a dwell is a stretch of rows in which no command moves by more than the last digits of its column. Where the log
//! has `trigger` (or `cycle`), its rows that are not 0 are the dwells, all of them; else a dwell lasts at least
//! [`DwellOptions::min_s`] and its first seconds are left to the servo: [`DwellOptions::settle_s`], or [`SETTLE_S`] and a third
//! of the dwell at most. Each row of a
//! log without `t_s` is a settled pose and a separate dwell. The joint that made the approach is the one that moved last,
//! alone; its direction is the sign of that movement (a pause keeps it: Zhang (2023), note 2 of equation 16). Positions are
//! means without gross errors ([`point_mean`]); so are joint positions measured after the gear. Where most of those say the same
//! count, what is more than one count away is still moving, or a fault.
//!
//! Assumptions: commands stand exactly still in a dwell, or flicker in the last digit. Fails with an error where a trigger
//! contradicts the commands.
//!
//! Parts: `rows` which rows of the log are a dwell, and which of them are averaged.

mod rows;

use super::Log;
use crate::error::{Error, Place, Result};
use crate::numerics::robust::{PointMean, median_of, point_mean};
use crate::robot::Robot;
use rows::{averaged_rows, stretches, without_edges};
use std::ops::Range;

/// Time in s left to the servo at the start of a dwell that only the commands show: a following error of 50 ms fades to 2 %.
pub const SETTLE_S: f64 = 0.2;
/// Movement within this many units of a column's last digit is flicker.
const FLICKER_DIGITS: f64 = 1.5;
/// A column with fewer decimals than this was written with exact values, not to its last digit.
const LEAST_DECIMALS: u8 = 2;
/// Values of a sensor closer than this (rad or m) differ by rounding alone.
const SAME_COUNT: f64 = 1e-12;
/// Last digit of a tracker's file, m.
const LAST_DIGIT_M: f64 = 1e-7;

/// What counts as a dwell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DwellOptions {
    /// Shortest dwell, s, where no `trigger` or `cycle` marks them.
    pub min_s: f64,
    /// Time left to the servo at the start of such a dwell, s; one that ends before is no dwell.
    pub settle_s: Option<f64>,
}

impl Default for DwellOptions {
    fn default() -> Self {
        Self { min_s: 0.5, settle_s: None }
    }
}

/// How a dwell was reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Approach {
    /// Axis that moved to this dwell.
    pub axis: usize,
    /// +1: from below, -1: from above.
    pub dir: i8,
    /// Distance moved in that direction since the joint last turned, rad or m.
    pub stroke: f64,
    /// Time of the log at which the commands stopped, s.
    pub stopped_s: f64,
    /// Time of the log at which the joint last turned, s; `None`: this was its first movement.
    pub turned_s: Option<f64>,
}

/// A settled place.
#[derive(Debug, Clone)]
pub struct Dwell {
    /// Rows that were averaged.
    pub rows: Range<usize>,
    /// Commands, one per axis, rad or m.
    pub command: Vec<f64>,
    /// Direction of the last movement of each axis; 0 before its first.
    pub dirs: Vec<i8>,
    /// The joint that brought the robot here, where it was one alone.
    pub approach: Option<Approach>,
    /// Number of the repeat, where the log has one; else 0.
    pub cycle: u32,
    /// TCP and further reflectors in the tracker frame; `None` where the tracker saw nothing in this dwell.
    pub points: Vec<Option<PointMean>>,
    /// Position measured after the gear, per axis where logged.
    pub meas: Vec<Option<JointMean>>,
    /// Reading of a distance or along a direction, m.
    pub scalar: Option<JointMean>,
}

impl Dwell {
    /// Whether anything was measured in it.
    fn is_read(&self) -> bool {
        self.points.iter().any(Option::is_some) || self.meas.iter().any(Option::is_some) || self.scalar.is_some()
    }
}

/// Mean of a joint position over a dwell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointMean {
    /// rad or m.
    pub mean: f64,
    /// Variance of the mean from the scatter in the dwell, (rad or m)^2.
    pub variance: f64,
}

/// Movement of an axis that counts, rad or m.
pub fn resolution(log: &Log, robot: &Robot, axis: usize) -> f64 {
    let decimals = i32::from(log.cmd_decimals.get(axis).copied().unwrap_or(0).max(LEAST_DECIMALS));
    FLICKER_DIGITS * 10f64.powi(-decimals) * robot.axis(axis).kind.si_per_user_unit()
}

/// Dwells of a log in the order visited.
pub fn dwells(log: &Log, robot: &Robot, options: &DwellOptions) -> Result<Vec<Dwell>> {
    let still: Vec<f64> = (0..log.cmd.len()).map(|a| resolution(log, robot, a)).collect();
    let marked = log.trigger.is_some() || log.cycle.is_some();
    let counts: Vec<f64> = log.meas.iter().map(|c| c.as_deref().map_or(0.0, count)).collect();
    let mut walk = Walk::new(log, &still);
    let mut found = Vec::new();
    for rows in without_edges(log, stretches(log, &still), marked) {
        // the step into the first row of a stretch is the end of the approach
        walk.to(rows.start);
        let Some(averaged) = averaged_rows(log, &rows, marked, options) else {
            continue;
        };
        let approach = match marked_pose(log, &still, &walk, rows.start) {
            None => walk.approach(),
            marked => marked,
        };
        refuse_contradiction(log, robot, rows.start, approach.as_ref())?;
        let dwell = Dwell {
            command: log.cmd.iter().map(|c| median_of(&mut c[averaged.clone()].to_vec()).unwrap_or(0.0)).collect(),
            dirs: walk.dir.clone(),
            approach,
            cycle: log.cycle.as_ref().map_or(0, |c| c[rows.start]),
            points: std::iter::once(&log.tcp_m)
                .chain(&log.reflectors_m)
                .map(|track| {
                    let seen: Vec<_> = track.get(averaged.clone())?.iter().flatten().copied().collect();
                    point_mean(&seen, LAST_DIGIT_M)
                })
                .collect(),
            meas: log
                .meas
                .iter()
                .zip(&counts)
                .map(|(column, &count)| {
                    let mut seen: Vec<f64> = column.as_ref()?[averaged.clone()].iter().flatten().copied().collect();
                    trimmed_mean(&mut seen, count)
                })
                .collect(),
            scalar: log.instruments.scalar().and_then(|column| {
                let mut seen: Vec<f64> = column[averaged.clone()].iter().flatten().copied().collect();
                trimmed_mean(&mut seen, LAST_DIGIT_M)
            }),
            rows: averaged,
        };
        // a pose at which nothing was read only shows from where the next one was reached
        if !log.poses || dwell.is_read() {
            found.push(dwell);
        }
    }
    Ok(found)
}

/// Refuses a trigger that says another side than the commands.
fn refuse_contradiction(log: &Log, robot: &Robot, row: usize, approach: Option<&Approach>) -> Result<()> {
    let (Some(trigger), Some(a)) = (&log.trigger, approach) else { return Ok(()) };
    if trigger[row] == 0 || trigger[row].signum() == a.dir {
        return Ok(());
    }
    let joint = &robot.axis(a.axis).name;
    let moved = if a.dir > 0 { "up" } else { "down" };
    Err(Error::bad(
        Place::line(&log.name, u64::from(log.line[row])),
        format!("trigger {} where the command of {joint} moved {moved} last", trigger[row]),
        "trigger 1 in a dwell reached by positive movement of the command, -1 by negative",
    ))
}

/// How a settled pose was reached that says so itself (`trigger`): the turning poses need not be written down then. The joint is the one
/// that moved last, alone, or else the one that moves next.
fn marked_pose(log: &Log, still: &[f64], walk: &Walk, row: usize) -> Option<Approach> {
    let dir = log.trigger.as_ref().filter(|_| log.poses)?.get(row)?.signum();
    if dir == 0 {
        return None;
    }
    let axis = walk.approach().map(|a| a.axis).or_else(|| {
        let moves = |k: usize| -> Vec<usize> {
            (0..log.cmd.len()).filter(|a| (log.cmd[*a][k] - log.cmd[*a][row]).abs() > still[*a]).collect()
        };
        match (row + 1..log.len()).map(moves).find(|m| !m.is_empty())?.as_slice() {
            [axis] => Some(*axis),
            _ => None,
        }
    })?;
    let at = log.t_s[row];
    Some(Approach { axis, dir, stroke: f64::INFINITY, stopped_s: at, turned_s: None })
}

/// Smallest step between the values of a sensor's column: one count of its encoder, or its last digit. 0: it never moved.
pub fn count(column: &[Option<f64>]) -> f64 {
    let mut seen: Vec<f64> = column.iter().flatten().copied().collect();
    seen.sort_by(f64::total_cmp);
    let least = seen.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > SAME_COUNT).fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 0.0 }
}

/// Mean of what lies within six deviations of the median, or within one count: as [`point_mean`] for one coordinate.
fn trimmed_mean(values: &mut [f64], count: f64) -> Option<JointMean> {
    let middle = median_of(values)?;
    let mut off: Vec<f64> = values.iter().map(|v| (v - middle).abs()).collect();
    let limit = (6.0 * crate::numerics::robust::SIGMA_PER_MAD * median_of(&mut off)?).max(1.001 * count);
    let kept: Vec<f64> = values.iter().copied().filter(|v| values.len() < 4 || (v - middle).abs() <= limit).collect();
    let n = kept.len().max(1) as f64;
    let mean = kept.iter().sum::<f64>() / n;
    let scatter: f64 = kept.iter().map(|v| (v - mean).powi(2)).sum();
    Some(JointMean { mean, variance: scatter / (n - 1.0).max(1.0) / n })
}

/// Walks the commands and knows the last movement of each axis.
struct Walk<'a> {
    log: &'a Log,
    still: &'a [f64],
    row: usize,
    /// Last direction, extreme of the present stroke, where the stroke began.
    dir: Vec<i8>,
    extreme: Vec<f64>,
    began: Vec<f64>,
    /// Row from which the joint moves in its present direction, where it turned there.
    turned: Vec<Option<usize>>,
    /// Row of the last movement beyond flicker, and the command there.
    moved: Vec<usize>,
    anchor: Vec<f64>,
}

impl<'a> Walk<'a> {
    fn new(log: &'a Log, still: &'a [f64]) -> Self {
        let start: Vec<f64> = log.cmd.iter().map(|c| c[0]).collect();
        let n = start.len();
        Self {
            log,
            still,
            row: 0,
            dir: vec![0; n],
            extreme: start.clone(),
            began: start.clone(),
            turned: vec![None; n],
            moved: vec![0; n],
            anchor: start,
        }
    }

    fn to(&mut self, row: usize) {
        while self.row < row {
            self.row += 1;
            for (axis, column) in self.log.cmd.iter().enumerate() {
                let step = column[self.row] - self.extreme[axis];
                if step * f64::from(self.dir[axis]) > 0.0 {
                    self.extreme[axis] = column[self.row];
                } else if step.abs() > self.still[axis] {
                    // a turn, or the first movement
                    self.began[axis] = self.extreme[axis];
                    self.turned[axis] = (self.dir[axis] != 0).then_some(self.row - 1);
                    self.dir[axis] = if step > 0.0 { 1 } else { -1 };
                    self.extreme[axis] = column[self.row];
                }
                if (column[self.row] - self.anchor[axis]).abs() > self.still[axis] {
                    self.anchor[axis] = column[self.row];
                    self.moved[axis] = self.row;
                }
            }
        }
    }

    /// The axis that moved last, if no other moved up to the same row.
    fn approach(&self) -> Option<Approach> {
        let latest = self.moved.iter().copied().max().filter(|&r| r > 0)?;
        let mut last = (0..self.moved.len()).filter(|&a| self.moved[a] == latest);
        let (axis, None) = (last.next()?, last.next()) else { return None };
        Some(Approach {
            axis,
            dir: self.dir[axis],
            stroke: (self.extreme[axis] - self.began[axis]).abs(),
            stopped_s: self.log.t_s[latest],
            turned_s: self.turned[axis].map(|row| self.log.t_s[row]),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::input::Input;

    fn robot() -> Robot {
        Robot::parse(
            "robot.yaml",
            "schema: lostmotion/robot/1\njoints:\n  - {name: A, kind: revolute, a_mm: 500}\n  - {name: B, kind: revolute, a_mm: 300}\n",
        )
        .unwrap()
    }

    fn log(text: &str) -> Log {
        Log::parse(Input { name: "log.csv".into(), bytes: text.into(), sha256: String::new() }, &robot()).unwrap()
    }

    #[test]
    fn each_row_without_time_is_a_pose_and_a_joint_that_moves_alone_made_the_approach() {
        let log = log("cmd_A_deg,cmd_B_deg,x_mm,y_mm,z_mm\n0,0,800,0,0\n2,0,799,30,0\n1,0,799,15,0\n2,1,1,2,3\n");
        let found = dwells(&log, &robot(), &DwellOptions::default()).unwrap();
        assert_eq!(found.len(), 4);
        assert_eq!(found[0].approach, None);
        let a = found[1].approach.unwrap();
        assert_eq!((a.axis, a.dir), (0, 1));
        assert_eq!(found[2].approach.unwrap().dir, -1);
        assert!((found[2].approach.unwrap().stroke - 1f64.to_radians()).abs() < 1e-12);
        assert_eq!(found[3].approach, None, "two joints arrived together");
    }

    #[test]
    fn a_stop_shorter_than_the_minimum_is_no_dwell_and_a_pause_keeps_the_direction() {
        let mut text = String::from("t_s,cmd_A_deg,cmd_B_deg,x_mm,y_mm,z_mm\n");
        let mut t = 0.0;
        let mut rows = |p: f64, n: usize| {
            for _ in 0..n {
                text += &format!("{t:.2},{p:.3},0,800,0,0\n");
                t += 0.05;
            }
        };
        rows(0.0, 1);
        rows(1.0, 5);
        rows(2.0, 21);
        rows(2.001, 1);
        rows(2.0, 21);
        let log = log(&text);
        let found = dwells(&log, &robot(), &DwellOptions::default()).unwrap();
        assert_eq!(found.len(), 1, "0.2 s is no dwell, and a flicker of the last digit ends none");
        assert_eq!(found[0].approach.unwrap().dir, 1);
        let first = log.t_s[found[0].rows.start] - 0.3;
        assert!((first - SETTLE_S).abs() < 1e-9, "the first {SETTLE_S} s are left to the servo, here {first}");
    }

    #[test]
    fn rows_at_the_edge_of_a_marked_dwell_in_which_the_command_moves_are_no_dwell() {
        let mut text = String::from("t_s,cmd_A_deg,cmd_B_deg,x_mm,y_mm,z_mm,trigger\n0,0,0,800,0,0,0\n");
        for i in 1..=8 {
            // the last row under the mark is on its way down already
            let p = if i == 8 { 1.9 } else { 2.0 };
            text += &format!("{i},{p},0,800,0,0,1\n");
        }
        text += "9,1,0,800,0,0,0\n10,1.5,0,800,0,0,1\n";
        let found = dwells(&log(&text), &robot(), &DwellOptions::default()).unwrap();
        assert_eq!(found.len(), 2, "the edge is none, a dwell of one row of its own is");
        assert_eq!((found[0].rows.clone(), found[0].approach.unwrap().dir), (1..8, 1));
        let second = found[1].approach.unwrap();
        assert_eq!((second.stopped_s, second.turned_s), (10.0, Some(9.0)));
    }

    #[test]
    fn poses_that_say_from_which_side_they_were_reached_need_no_turning_poses() {
        let rows = "10,0,800,0,0,1\n10,0,799,0,0,-1\n20,0,800,0,0,1\n20,0,799,0,0,-1\n0,5,800,0,0,-1\n0,15,800,0,0,1\n";
        let text = format!("cmd_A_deg,cmd_B_deg,x_mm,y_mm,z_mm,trigger\n{rows}");
        let found = dwells(&log(&text), &robot(), &DwellOptions::default()).unwrap();
        let reached: Vec<(usize, i8)> = found.iter().map(|d| d.approach.map(|a| (a.axis, a.dir)).unwrap()).collect();
        assert_eq!(reached, [(0, 1), (0, -1), (0, 1), (0, -1), (1, -1), (1, 1)]);
    }

    #[test]
    fn a_turning_pose_without_a_reading_is_no_dwell() {
        let text = "cmd_A_deg,cmd_B_deg,x_mm,y_mm,z_mm\n8,0,,,\n10,0,800,0,0\n12,0,,,\n10,0,799,0,0\n";
        let found = dwells(&log(text), &robot(), &DwellOptions::default()).unwrap();
        assert_eq!(found.iter().map(|d| d.approach.unwrap().dir).collect::<Vec<_>>(), [1, -1]);
    }

    #[test]
    fn a_trigger_against_the_commands_is_refused_with_its_line() {
        let text =
            "t_s,cmd_A_deg,cmd_B_deg,x_mm,y_mm,z_mm,trigger\n0,0,0,800,0,0,0\n1,2,0,799,0,0,-1\n2,2,0,799,0,0,-1\n";
        let error = dwells(&log(text), &robot(), &DwellOptions::default()).unwrap_err().to_string();
        assert!(error.contains("log.csv:3") && error.contains("trigger -1"), "{error}");
    }
}
