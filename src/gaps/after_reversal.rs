//! What a joint loses after a reversal, over time: half gap, wind-up and spikes together, with the interval of their sum.
//!
//! Gap, wind-up and spikes are nearly collinear, so their own intervals are wide where that of their sum is narrow; the covariance of the
//! document gives it. At the joint's usual speed between two reversals of the logs, from a turn after a long stroke. Shown on pages.

use super::estimate::{Estimate, JointEstimate};
use super::{GapPoint, JointGap};
use crate::effects::response::{MOST_SPIKES, MOST_WINDUPS, Response, Spike, State, Windup};
use crate::numerics::robust::median_of;
use crate::robot::Robot;

/// Time that is shown, s, and the number of its steps.
const SHOWN_S: f64 = 4.0;
const STEPS: usize = 100;
/// Step of the logarithm of the presliding for its derivative.
const STEP: f64 = 1e-3;
/// Names of knots hold three decimals of their place, deg or mm.
const ROUNDED: f64 = 1e-2;

/// The curve of one joint; rad or m, s.
#[derive(Debug, Clone)]
pub struct AfterReversal {
    /// Usual speed of the joint between two reversals, rad/s or m/s.
    pub speed: f64,
    /// Times after the reversal.
    pub t_s: Vec<f64>,
    /// How far the joint lags its command.
    pub lost: Vec<f64>,
    /// Standard deviation of that.
    pub sigma: Vec<f64>,
    /// Each single reversal at the end of the time, where it was estimated by itself.
    pub single: Vec<f64>,
}

impl Estimate {
    /// What a joint loses after a reversal; `None` where the logs do not show at which speed it moves.
    pub fn after_reversal(&self, robot: &Robot, gap: &JointGap, points: &[GapPoint]) -> Option<AfterReversal> {
        let joint = self.joints.iter().find(|j| j.axis == gap.axis)?;
        let speed = self.usual_speed(gap.axis)?;
        let t_s: Vec<f64> = (0..=STEPS).map(|i| SHOWN_S * i as f64 / STEPS as f64).collect();
        let states = |r: &Response| along(r, speed, &t_s);
        let (r, longer) = (&joint.response, stretched(&joint.response));
        let back: Vec<f64> = states(r).iter().map(|s| r.back(s)).collect();
        let back_longer: Vec<f64> = states(&longer).iter().map(|s| longer.back(s)).collect();
        let lost: Vec<f64> = back.iter().map(|b| gap.half_gap + b).collect();
        let sigma = match &self.covariance {
            None => vec![0.0; t_s.len()],
            Some((names, matrix)) => {
                let columns = Columns::of(names, robot, joint, points);
                let units = states(&columns.unit);
                let by_presliding = |i: usize| (back_longer[i] - back[i]) / STEP;
                (0..t_s.len()).map(|i| columns.sigma(matrix, &units[i], by_presliding(i))).collect()
            }
        };
        let whole = lost.last().copied().unwrap_or(0.0);
        let single = self.reversals.iter().filter(|r| r.axis == gap.axis).map(|r| r.ratio * whole).collect();
        Some(AfterReversal { speed, t_s, lost, sigma, single })
    }

    /// Median speed of a joint between neighbouring reversals of a log.
    fn usual_speed(&self, axis: usize) -> Option<f64> {
        let own: Vec<_> = self.reversals.iter().filter(|r| r.axis == axis).collect();
        let pairs = own.windows(2).filter(|w| w[0].log == w[1].log && w[1].t_s > w[0].t_s);
        let mut speeds: Vec<f64> = pairs.map(|w| (w[1].at - w[0].at).abs() / (w[1].t_s - w[0].t_s)).collect();
        median_of(&mut speeds).filter(|v| *v > 0.0)
    }
}

/// The response with a presliding that is longer by a share of [`STEP`], in all its parts.
fn stretched(r: &Response) -> Response {
    let mut out = *r;
    out.presliding *= STEP.exp();
    out.windups.iter_mut().for_each(|w| w.presliding *= STEP.exp());
    out
}

/// The state of friction at each time of a stroke at constant speed, after a turn that follows a long stroke.
fn along(r: &Response, speed: f64, t_s: &[f64]) -> Vec<State> {
    let (mut state, mut last) = (State::TURNED, 0.0);
    let step = |t: &f64| {
        let (dt, travel) = (t - last, speed * (t - last));
        last = *t;
        state = r.advance(&state, travel, travel, dt);
        state
    };
    t_s.iter().map(step).collect()
}

/// Where a joint's parameters stand in the covariance.
struct Columns {
    /// Rad or m per unit of the covariance.
    si: f64,
    /// Column and weight of each knot of the gap.
    gap: Vec<(usize, f64)>,
    /// Column of each spike and wind-up of `unit`.
    spikes: Vec<usize>,
    windups: Vec<usize>,
    presliding: Option<usize>,
    /// The spikes and wind-ups that the covariance names, each of size 1: also those that were not found, as they are as uncertain.
    unit: Response,
}

impl Columns {
    fn of(names: &[String], robot: &Robot, joint: &JointEstimate, points: &[GapPoint]) -> Self {
        let axis = robot.axis(joint.axis);
        let si = axis.kind.si_per_user_unit();
        let presliding = joint.response.presliding;
        let unit = Response { presliding, ..Response::default() };
        let (gap, spikes, windups) = (Vec::new(), Vec::new(), Vec::new());
        let mut columns = Self { si, gap, spikes, windups, presliding: None, unit };
        for (i, name) in names.iter().enumerate() {
            let Some(part) = name.strip_prefix(axis.name.as_str()).and_then(|n| n.strip_prefix('.')) else { continue };
            let number =
                part.split_once('(').and_then(|(_, n)| n.split([' ', ')']).next()).and_then(|n| n.parse::<f64>().ok());
            match (part.split('_').next(), number) {
                (Some("half"), Some(place)) => {
                    let here = points.iter().find(|p| p.axis == joint.axis && (p.at / si - place).abs() < ROUNDED);
                    columns.gap.extend(here.map(|p| (i, p.cycles as f64)));
                }
                (Some("spike"), Some(decay_s)) if columns.spikes.len() < MOST_SPIKES => {
                    columns.unit.spikes[columns.spikes.len()] = Spike { gain: 1.0, decay_s };
                    columns.spikes.push(i);
                }
                (Some("windup"), Some(over)) if columns.windups.len() < MOST_WINDUPS => {
                    columns.unit.windups[columns.windups.len()] = Windup { half: 1.0, presliding: presliding * over };
                    columns.windups.push(i);
                }
                (Some("ln"), _) => columns.presliding = Some(i),
                _ => {}
            }
        }
        let all: f64 = columns.gap.iter().map(|g| g.1).sum();
        columns.gap.iter_mut().for_each(|g| g.1 /= all.max(1.0));
        columns
    }

    /// Standard deviation of the sum at one time; `by_presliding` is its derivative by the logarithm of the presliding.
    fn sigma(&self, matrix: &[Vec<f64>], unit: &State, by_presliding: f64) -> f64 {
        let sized = |columns: &[usize], by: &[f64]| -> Vec<(usize, f64)> {
            columns.iter().zip(by).map(|(i, v)| (*i, v * self.si)).collect()
        };
        let mut gradient: Vec<(usize, f64)> = self.gap.iter().map(|(i, w)| (*i, w * self.si)).collect();
        gradient.extend(sized(&self.spikes, &unit.h));
        gradient.extend(sized(&self.windups, &unit.z_joint));
        gradient.extend(self.presliding.map(|i| (i, by_presliding)));
        let entry = |i: usize, k: usize| matrix.get(i).and_then(|row| row.get(k)).copied().unwrap_or(0.0);
        let sum = |(i, a): &(usize, f64)| gradient.iter().map(|(k, b)| a * b * entry(*i, *k)).sum::<f64>();
        gradient.iter().map(sum).sum::<f64>().max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gaps::estimate::{LocalReversal, Trust, Why};
    use crate::robot::JointKind;

    #[test]
    fn the_interval_of_the_sum_is_narrow_where_gap_and_wind_up_cannot_be_told_apart() {
        let robot = Robot::parse("robot", include_str!("../../configs/kuka-kr120-r2500-pro.yaml")).unwrap();
        assert_eq!(robot.axis(0).kind, JointKind::Revolute);
        let si = 1f64.to_radians();
        let mut response = Response { presliding: 1e-3 * si, ..Response::default() };
        response.windups[0] = Windup { half: 1e-3 * si, presliding: 1e-3 * si };
        response.spikes[0] = Spike { gain: 2e-3 * si, decay_s: 0.4 };
        let trust = Trust { compensate: true, before_m: 0.0, after_m: 0.0, reversals: 2, reason: Why::Helps };
        let joint = JointEstimate {
            axis: 0,
            response,
            presliding_ci95: [0.0; 2],
            windup_ci95: [0.0; 2],
            spikes_ci95: Vec::new(),
            scatter: 0.0,
            trust,
            agreement: None,
        };
        let reversal = |t_s: f64, at: f64, ratio: f64| LocalReversal {
            axis: 0,
            log: "circle.csv".into(),
            t_s,
            at: at * si,
            ratio,
            sigma: 0.1,
            outlying: false,
        };
        let name = &robot.axis(0).name;
        let names = ["half_gap_deg(10.000)", "spike_deg(0.4 s)", "windup_deg(1 presliding)"];
        let estimate = Estimate {
            joints: vec![joint],
            reversals: vec![reversal(1.0, 0.0, 0.9), reversal(11.0, 20.0, 1.1)],
            // gap and wind-up each known to 1e-3, their sum exactly
            covariance: Some((
                names.iter().map(|n| format!("{name}.{n}")).collect(),
                vec![vec![1e-6, 0.0, -1e-6], vec![0.0, 0.0, 0.0], vec![-1e-6, 0.0, 1e-6]],
            )),
            ..Estimate::default()
        };
        let gap = JointGap {
            axis: 0,
            half_gap: 3e-3 * si,
            ci95: [0.0; 2],
            significant: true,
            sides: None,
            schedule: None,
            varies_p_value: None,
            stiction: None,
            stiction_p_value: None,
        };
        let points = [GapPoint {
            axis: 0,
            at: 10.0 * si,
            half_gap: 3e-3 * si,
            ci95: [0.0; 2],
            cycles: 2,
            per_cycle: Vec::new(),
        }];
        let found = estimate.after_reversal(&robot, &gap, &points).unwrap();
        assert!((found.speed / si - 2.0).abs() < 1e-12);
        // at the turn the wind-up still pulls the other way, in the end it is built up and the spike is gone
        assert!((found.lost[0] / si - 2e-3).abs() < 1e-9 && (found.lost[STEPS] / si - 4e-3).abs() < 1e-6);
        let most = found.lost.iter().copied().fold(0.0, f64::max);
        assert!(most / si > 6e-3, "the spike: {}", most / si);
        assert!((found.sigma[0] / si - 2e-3).abs() < 1e-9 && found.sigma[STEPS] / si < 1e-6, "{:?}", found.sigma);
        assert!((found.single[1] / si - 4.4e-3).abs() < 1e-6);
        // a spike that was not found, and is not in a document that was read, is as uncertain as one that was
        let mut without = estimate.clone();
        without.joints[0].response.spikes[0] = Spike { gain: 0.0, decay_s: 1.0 };
        let [mut with, mut without] = [estimate, without];
        for e in [&mut with, &mut without] {
            e.covariance.as_mut().unwrap().1[1][1] = 1e-6;
        }
        let [with, without] = [with, without].map(|e| e.after_reversal(&robot, &gap, &points).unwrap());
        assert!(with.sigma[5] / si > 1e-3 && with.sigma == without.sigma, "{:?}", without.sigma);
    }
}
