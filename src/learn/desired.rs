//! Whether the commands of a log are those of the program that is given as desired: they may differ by compensation alone.
//!
//! Method: of each joint the difference of the two is explained by a constant and a step that changes sides with the direction of the
//! program, as offsets of a compensator do; what is left is compared with the joint's own movement. Where a shift in time leaves half of
//! that or less, the log is on another clock. Where much is left, or where the constant is larger than the step, it is another program.
//!
//! Assumptions: linear motion between the points of the program. How it fails: a program that differs in a few moves only is taken for
//! the right one, as are clocks that are apart by less than a row of the log.

use crate::error::{Error, Place, Result};
use crate::log::{Log, clock};
use crate::numerics::robust::median;
use crate::program::Program;
use crate::robot::Robot;

/// Rows of a log that are compared at most, and the fewest that say something.
const ROWS: usize = 1000;
const FEWEST: usize = 20;
/// Share of a joint's movement (standard deviations) that may be left: 0.14 with gaps of a twentieth of the travel.
const OTHER_PROGRAM: f64 = 0.35;
/// Share of what is left that a shift in time leaves where it explains it, and the share from which on it is worth a look.
const LEFT: f64 = 0.5;
const BENIGN: f64 = 0.01;
/// A constant beyond this many steps and this share of the movement is not that of a gap with unequal sides.
const STEPS: f64 = 1.5;
const CONSTANT: f64 = 0.05;
/// Joints that move less than this share of the largest movement are judged by that.
const SMALL: f64 = 0.1;

/// Refuses a log whose commands are not those of the program.
///
/// # Errors
/// Bad input: another clock, with the shift that explains it, or another program.
pub fn check(robot: &Robot, log: &Log, program: &Program) -> Result<()> {
    let Some(both) = Both::new(robot, log, program) else { return Ok(()) };
    let as_read = both.worst(0.0);
    if as_read.left <= BENIGN && as_read.constant <= 0.0 {
        return Ok(());
    }
    let whole_s = log.t_s[log.len() - 1] - log.t_s[0];
    let (shift_s, left) = clock::best(whole_s, |shift| both.worst(shift).left);
    if shift_s.abs() >= both.row_s && left <= (LEFT * as_read.left).min(OTHER_PROGRAM) {
        // known to a part of a row
        let decimals = (-both.row_s.max(1e-3).log10()).ceil().clamp(1.0, 3.0) as usize;
        let side = if shift_s > 0.0 { "ahead of" } else { "behind" };
        let found = format!("commands about {:.decimals$} s {side} those of {}", shift_s.abs(), program.name);
        let expected = format!("a log on the clock of the program: `t_s` {shift_s:+.decimals$} s");
        return Err(Error::bad(Place::file(&log.name), found, expected));
    }
    if as_read.left > OTHER_PROGRAM || as_read.constant > 0.0 {
        let joint = robot.axis(as_read.axis);
        let found = format!(
            "commands of {} that differ from those of {} by {:.3} {} in the median",
            joint.name,
            program.name,
            joint.kind.to_user_unit(as_read.median),
            joint.kind.unit()
        );
        let expected = "the program that the log's commands come from: they may differ by compensation only";
        return Err(Error::bad(Place::file(&log.name), found, expected));
    }
    Ok(())
}

/// What is left of the joint that fits worst.
struct Worst {
    axis: usize,
    /// Root mean square of what compensation does not explain, over the joint's movement.
    left: f64,
    /// How far the constant is beyond what a gap explains, over the joint's movement; 0 or less: not at all.
    constant: f64,
    /// Median distance of the commands, rad or m.
    median: f64,
}

/// Log and program at the same times.
struct Both<'a> {
    log: &'a Log,
    program: &'a Program,
    times: &'a [f64],
    /// Rows of the log that are compared.
    rows: Vec<usize>,
    /// Usual time between two rows, s.
    row_s: f64,
    /// Direction of each joint from a point of the program to the next, the last one where it pauses.
    sides: Vec<Vec<f64>>,
    /// Movement by which each joint is judged, rad or m; 0: it stands still.
    movement: Vec<f64>,
}

impl<'a> Both<'a> {
    fn new(robot: &Robot, log: &'a Log, program: &'a Program) -> Option<Self> {
        let times = program.t_s.as_deref().filter(|t| t.len() > 1)?;
        if log.poses || log.len() < FEWEST {
            return None;
        }
        let rows: Vec<usize> = (0..log.len()).step_by(log.len().div_ceil(ROWS)).collect();
        let sides = program.q.iter().map(|q| sides(q)).collect();
        let own: Vec<f64> = log.cmd.iter().map(|c| spread(rows.iter().map(|r| c[*r]))).collect();
        let kind = |axis: usize| robot.axis(axis).kind;
        let movement = (0..own.len())
            .map(|axis| {
                let alike = (0..own.len()).filter(|other| kind(*other) == kind(axis));
                own[axis].max(SMALL * alike.map(|other| own[other]).fold(0.0, f64::max))
            })
            .collect();
        let steps: Vec<f64> = log.t_s.windows(2).map(|w| w[1] - w[0]).collect();
        Some(Self { log, program, times, rows, row_s: median(&steps), sides, movement })
    }

    /// The joint that fits worst, with the program read `shift_s` later.
    fn worst(&self, shift_s: f64) -> Worst {
        let mut worst = Worst { axis: 0, left: 0.0, constant: 0.0, median: 0.0 };
        for (axis, (q, command)) in self.program.q.iter().zip(&self.log.cmd).enumerate() {
            let movement = self.movement[axis];
            if movement <= 0.0 {
                continue;
            }
            let pairs: Vec<(f64, f64)> =
                self.rows.iter().filter_map(|r| self.pair(axis, q, command[*r], *r, shift_s)).collect();
            let (constant, step, left) = line(&pairs);
            let beyond = constant.abs() / movement - CONSTANT - STEPS * step.abs() / movement;
            let left = left / movement;
            if left > worst.left || beyond > worst.constant {
                let apart: Vec<f64> = pairs.iter().map(|p| p.1.abs()).collect();
                worst.axis = axis;
                worst.median = median(&apart);
            }
            worst.left = worst.left.max(left);
            worst.constant = worst.constant.max(beyond);
        }
        worst
    }

    /// Side of the program, and how far the command is from it.
    fn pair(&self, axis: usize, q: &[f64], command: f64, row: usize, shift_s: f64) -> Option<(f64, f64)> {
        let t = self.log.t_s[row] + shift_s;
        // at a point of the program the joint has arrived and does not move on yet
        let segment = self.times.partition_point(|v| *v < t).clamp(1, self.times.len() - 1) - 1;
        let side = *self.sides.get(axis)?.get(segment)?;
        Some((side, command - clock::at(self.times, q, t)?))
    }
}

/// Direction of each step of a joint, the last one where it pauses.
fn sides(q: &[f64]) -> Vec<f64> {
    let mut last = 0.0;
    let steps = q.windows(2).map(|w| w[1] - w[0]);
    steps
        .map(|step| {
            if step != 0.0 {
                last = step.signum();
            }
            last
        })
        .collect()
}

/// Constant and factor of `d` over the side, and the root mean square of what is left.
fn line(pairs: &[(f64, f64)]) -> (f64, f64, f64) {
    let n = pairs.len().max(1) as f64;
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / n;
    let (side, d) = (mean(&|p| p.0), mean(&|p| p.1));
    let (ss, sd) = (mean(&|p| (p.0 - side).powi(2)), mean(&|p| (p.0 - side) * (p.1 - d)));
    let step = if ss > 0.0 { sd / ss } else { 0.0 };
    let constant = d - step * side;
    (constant, step, mean(&|p| (p.1 - constant - step * p.0).powi(2)).sqrt())
}

/// Standard deviation.
fn spread(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let n = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / n;
    (values.map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::input::from_bytes;

    const ROBOT: &str = "schema: lostmotion/robot/1\njoints:\n  - {name: A1, kind: revolute, a_mm: 500}\n  - {name: A2, kind: revolute, a_mm: 400}\n";

    /// Desired positions, deg: no period of the one is one of the other.
    fn desired(t: f64, phase: f64) -> [f64; 2] {
        [
            20.0 * (0.2 * t + phase).sin() + 7.0 * (0.31 * t).sin(),
            10.0 * (0.13 * t - phase).cos() + 5.0 * (0.37 * t).cos(),
        ]
    }

    fn program(phase: f64) -> String {
        let row = |t: f64| format!("{t:.2},{:.6},{:.6}\n", desired(t, phase)[0], desired(t, phase)[1]);
        "t_s,a1_deg,a2_deg\n".to_string() + &(0..1000).map(|k| row(f64::from(k) * 0.2)).collect::<String>()
    }

    /// A run of the program with offsets of 0.8 and 0.3 deg, `late` on the log's clock, from the 50th row to the 50th last.
    fn run(late: f64, constant: f64) -> String {
        let row = |k: i32| {
            let t = f64::from(k) * 0.2;
            let (before, now, after) = (desired(t - 0.01, 0.0), desired(t, 0.0), desired(t + 0.01, 0.0));
            let offset = |j: usize, b: f64| now[j] + b * (after[j] - before[j]).signum() + constant;
            format!("{:.2},{:.6},{:.6},0,0,{k}\n", t + late, offset(0, 0.8), offset(1, 0.3))
        };
        "t_s,cmd_A1_deg,cmd_A2_deg,x_mm,y_mm,z_mm\n".to_string() + &(50..950).map(row).collect::<String>()
    }

    fn checked(log: &str, program: &str) -> Result<()> {
        let robot = Robot::parse("robot.yaml", ROBOT)?;
        let log = Log::parse(from_bytes("log.csv".into(), log.into())?, &robot)?;
        let program = Program::parse(from_bytes("p.csv".into(), program.into())?, &robot)?;
        check(&robot, &log, &program)
    }

    #[test]
    fn commands_that_differ_by_compensation_alone_are_taken() {
        checked(&run(0.0, 0.0), &program(0.0)).unwrap();
        checked(&run(0.0, 0.2), &program(0.0)).unwrap();
    }

    #[test]
    fn another_clock_is_refused_with_the_shift_that_explains_it() {
        for late in [0.4, 2.0, 5.0, -2.0] {
            let said = checked(&run(late, 0.0), &program(0.0)).unwrap_err().to_string();
            let by = format!(
                "about {:.1} s {} those of p.csv",
                f64::abs(late),
                if late > 0.0 { "behind" } else { "ahead of" }
            );
            assert!(said.contains(&by) && said.contains(&format!("`t_s` {:+.1} s", -late)), "{late}: {said}");
        }
    }

    #[test]
    fn another_program_is_refused() {
        let said = checked(&run(0.0, 0.0), &program(1.5)).unwrap_err().to_string();
        assert!(said.contains("differ from those of p.csv by") && said.contains("compensation only"), "{said}");
        let said = checked(&run(0.0, 5.0), &program(0.0)).unwrap_err().to_string();
        assert!(said.contains("compensation only"), "{said}");
    }
}
