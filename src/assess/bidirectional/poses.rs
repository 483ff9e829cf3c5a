//! What each pose shows by itself: repeatability of each direction, backlash, bidirectional repeatability.
//!
//! - `RP = 3 s` of one direction, `s` with `m - 1` (ISO 9283 for one coordinate; Slamani (2012) equation 23).
//! - Backlash `y = mean forward - mean backward` (equations 1 and 25), with Student's interval: from the pairs of a repeat
//!   where every reading has its partner (what drifts between repeats cancels), else Welch's for two unequal samples.
//! - `R = max(3 s_f + 3 s_b + |y|, 6 s_f, 6 s_b)` (equation 24). ISO 230-2 since 1997 takes 2 instead of 3; both are given.
//!
//! Pairs are readings of one repeat; where the names of the repeats match nowhere at a pose, the k-th forward and the k-th
//! backward reading are one pair. Assumption: the readings of a direction are independent and normal. Nothing is thrown out.

use super::readings::{Reading, Readings};
use crate::numerics::student;

/// Positions closer than this (m) are one pose.
const SAME_M: f64 = 1e-9;
/// Coverage factor of Slamani (2012) (ISO 9283).
pub const COVERAGE: f64 = 3.0;
/// Coverage factor of ISO 230-2 since 1997.
pub const COVERAGE_ISO230: f64 = 2.0;

/// Readings of one direction at a pose.
#[derive(Debug, Clone, PartialEq)]
pub struct Way {
    /// In the order of the file, without missing ones.
    pub errors_m: Vec<f64>,
    pub mean_m: f64,
    /// `None`: one reading only.
    pub sd_m: Option<f64>,
}

impl Way {
    fn new(errors_m: Vec<f64>) -> Option<Self> {
        let n = errors_m.len() as f64;
        if errors_m.is_empty() {
            return None;
        }
        let mean_m = errors_m.iter().sum::<f64>() / n;
        let sum: f64 = errors_m.iter().map(|e| (e - mean_m).powi(2)).sum();
        Some(Self { mean_m, sd_m: (n > 1.0).then(|| (sum / (n - 1.0)).sqrt()), errors_m })
    }

    /// Unidirectional repeatability: 3 standard deviations.
    pub fn repeatability_m(&self) -> Option<f64> {
        self.sd_m.map(|s| COVERAGE * s)
    }
}

/// Mean backlash of a pose and its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Backlash {
    pub mean_m: f64,
    pub ci95_m: Option<[f64; 2]>,
}

/// A pose in one state.
#[derive(Debug, Clone)]
pub struct Pose {
    /// Number of its state.
    pub state: usize,
    /// Commanded position on the line, m.
    pub position_m: f64,
    /// Readings that were approached with rising positions.
    pub forward: Option<Way>,
    /// Readings that were approached with falling positions.
    pub backward: Option<Way>,
    /// Backlash of each repeat that has both directions.
    pub pairs_m: Vec<f64>,
    /// Readings without a partner.
    pub unpaired: usize,
    /// Pairs were made by order, not by the name of the repeat.
    pub by_order: bool,
    /// Mean difference of the two directions, with its interval.
    pub backlash: Option<Backlash>,
}

impl Pose {
    fn new(state: usize, position_m: f64, rows: &[&Reading]) -> Self {
        let side = |forward: bool| rows.iter().filter(|r| r.forward == forward).copied().collect::<Vec<_>>();
        let (up, down) = (side(true), side(false));
        let values = |rows: &[&Reading]| Way::new(rows.iter().filter_map(|r| r.error_m).collect());
        let (forward, backward) = (values(&up), values(&down));
        let (pairs_m, by_order) = pairs(&up, &down);
        let count = |w: &Option<Way>| w.as_ref().map_or(0, |w| w.errors_m.len());
        let unpaired = count(&forward) + count(&backward) - 2 * pairs_m.len();
        let backlash = forward.as_ref().zip(backward.as_ref()).map(|(f, b)| {
            let mean_m = f.mean_m - b.mean_m;
            let half = if unpaired == 0 { paired(&pairs_m) } else { welch(f, b) };
            Backlash { mean_m, ci95_m: half.map(|h| [mean_m - h, mean_m + h]) }
        });
        Self { state, position_m, forward, backward, pairs_m, unpaired, by_order, backlash }
    }

    /// Bidirectional repeatability with a coverage factor; `None` where a direction has fewer than two readings.
    pub fn bidirectional_m(&self, coverage: f64) -> Option<f64> {
        let (f, b) = (self.forward.as_ref()?.sd_m? * coverage, self.backward.as_ref()?.sd_m? * coverage);
        let y = self.backlash?.mean_m.abs();
        Some((f + b + y).max(2.0 * f).max(2.0 * b))
    }

    /// Mean of the pairs and their sum of squares about it; `None` without pairs.
    pub fn pair_mean(&self) -> Option<(f64, f64)> {
        let way = Way::new(self.pairs_m.clone())?;
        Some((way.mean_m, way.errors_m.iter().map(|y| (y - way.mean_m).powi(2)).sum()))
    }
}

/// Backlash of each repeat, and whether order made the pairs.
fn pairs(up: &[&Reading], down: &[&Reading]) -> (Vec<f64>, bool) {
    let named = up.iter().chain(down).all(|r| r.repeat.is_some());
    let partner = |r: &Reading| down.iter().find(|d| d.repeat == r.repeat);
    let both = |a: &Reading, b: &Reading| Some(a.error_m? - b.error_m?);
    if named && up.iter().any(|r| partner(r).is_some()) {
        return (up.iter().filter_map(|r| both(r, partner(r)?)).collect(), false);
    }
    (up.iter().zip(down).filter_map(|(a, b)| both(a, b)).collect(), !up.is_empty() && !down.is_empty())
}

fn paired(pairs: &[f64]) -> Option<f64> {
    let way = Way::new(pairs.to_vec())?;
    let n = pairs.len() as f64;
    Some(student::factor(0.95, n - 1.0) * way.sd_m? / n.sqrt())
}

fn welch(f: &Way, b: &Way) -> Option<f64> {
    let part = |w: &Way| Some((w.sd_m?.powi(2) / w.errors_m.len() as f64, w.errors_m.len() as f64 - 1.0));
    let ((vf, nf), (vb, nb)) = (part(f)?, part(b)?);
    let variance = vf + vb;
    if variance == 0.0 {
        return Some(0.0);
    }
    let dof = variance.powi(2) / (vf.powi(2) / nf + vb.powi(2) / nb);
    Some(student::factor(0.95, dof) * variance.sqrt())
}

/// All poses: states in the given order, positions rising.
pub fn group(readings: &Readings, order: &[usize]) -> Vec<Pose> {
    let mut poses = Vec::new();
    for &state in order {
        let mut rows: Vec<&Reading> = readings.rows.iter().filter(|r| r.state == state).collect();
        rows.sort_by(|a, b| a.position_m.total_cmp(&b.position_m)); // stable: repeats keep their order
        for same in rows.chunk_by(|a, b| b.position_m - a.position_m <= SAME_M) {
            poses.push(Pose::new(state, same[0].position_m, same));
        }
    }
    poses
}

/// What the poses of a state say together.
#[derive(Debug, Clone)]
pub struct Line {
    /// Number of the state.
    pub state: usize,
    /// Mean of the poses' backlash.
    pub mean_m: f64,
    /// Of the mean, the poses taken for a sample: what differs from pose to pose counts as scatter.
    pub ci95_m: Option<[f64; 2]>,
    /// Student's t of the mean; none without scatter.
    pub t: Option<f64>,
    /// Degrees of freedom of the mean.
    pub dof: f64,
    /// Two-sided p value of the mean; none without scatter.
    pub p_value: Option<f64>,
    /// Largest bidirectional repeatability, with the factors 3 and 2.
    pub bidirectional_m: Option<f64>,
    /// Bidirectional repeatability with the coverage of ISO 230-2, m.
    pub bidirectional_iso230_m: Option<f64>,
    /// Poses whose own interval excludes 0, and poses that have one.
    pub poses_beyond: [usize; 2],
}

/// Summarises the poses of a state; `None` where none was measured in both directions.
pub fn line(poses: &[Pose], state: usize) -> Option<Line> {
    let here = || poses.iter().filter(move |p| p.state == state);
    let means: Vec<f64> = here().filter_map(|p| Some(p.backlash?.mean_m)).collect();
    let way = Way::new(means)?;
    let n = way.errors_m.len() as f64;
    let se = way.sd_m.map(|s| s / n.sqrt());
    let t = se.filter(|s| *s > 0.0).map(|s| way.mean_m / s);
    let half = se.map(|s| student::factor(0.95, n - 1.0) * s);
    let most = |k: f64| here().filter_map(|p| p.bidirectional_m(k)).reduce(f64::max);
    let intervals: Vec<[f64; 2]> = here().filter_map(|p| p.backlash?.ci95_m).collect();
    Some(Line {
        state,
        mean_m: way.mean_m,
        ci95_m: half.map(|h| [way.mean_m - h, way.mean_m + h]),
        t,
        dof: n - 1.0,
        p_value: t.map(|t| student::two_sided_p(t, n - 1.0)),
        bidirectional_m: most(COVERAGE),
        bidirectional_iso230_m: most(COVERAGE_ISO230),
        poses_beyond: [intervals.iter().filter(|c| c[0] > 0.0 || c[1] < 0.0).count(), intervals.len()],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reading(forward: bool, repeat: &str, error_um: Option<f64>) -> Reading {
        let repeat = (!repeat.is_empty()).then(|| repeat.to_string());
        Reading { line: 0, position_m: 0.0, forward, repeat, error_m: error_um.map(|e| e * 1e-6), state: 0 }
    }

    fn pose(rows: &[Reading]) -> Pose {
        Pose::new(0, 0.0, &rows.iter().collect::<Vec<_>>())
    }

    #[test]
    fn equation_24_takes_the_largest_of_its_three_parts() {
        let rows = |b: [f64; 3]| -> Vec<Reading> {
            let up = [1.0, 2.0, 3.0].iter().enumerate().map(|(i, e)| reading(true, &i.to_string(), Some(*e)));
            up.chain(b.iter().enumerate().map(|(i, e)| reading(false, &i.to_string(), Some(*e)))).collect()
        };
        let um = |rows: &[Reading]| pose(rows).bidirectional_m(3.0).unwrap() * 1e6;
        assert!((um(&rows([-9.0, -8.0, -7.0])) - (3.0 + 3.0 + 10.0)).abs() < 1e-9);
        assert!((um(&rows([-8.0, 2.0, 12.0])) - 60.0).abs() < 1e-9, "6 s of the wide direction");
    }

    #[test]
    fn pairs_take_away_what_drifts_between_repeats() {
        let rows: Vec<Reading> = (0..5)
            .flat_map(|i| {
                let drift = 20.0 * f64::from(i);
                [reading(true, &i.to_string(), Some(drift)), reading(false, &i.to_string(), Some(drift + 10.0))]
            })
            .collect();
        let b = pose(&rows).backlash.unwrap();
        let [lo, hi] = b.ci95_m.unwrap();
        assert!((b.mean_m + 10e-6).abs() < 1e-12 && hi - lo < 1e-12, "{b:?}");
    }

    #[test]
    fn repeats_whose_names_match_nowhere_are_paired_by_order_and_a_lost_reading_takes_its_partner_along() {
        let rows = [
            reading(true, "1", Some(1.0)),
            reading(false, "2", Some(5.0)),
            reading(true, "3", None),
            reading(false, "4", Some(9.0)),
            reading(true, "5", Some(3.0)),
            reading(false, "6", Some(4.0)),
        ];
        let p = pose(&rows);
        assert!(p.by_order);
        let um: Vec<f64> = p.pairs_m.iter().map(|y| (y * 1e6).round()).collect();
        assert_eq!((um, p.unpaired), (vec![-4.0, -1.0], 1));
        assert!((p.backlash.unwrap().mean_m * 1e6 - (2.0 - 6.0)).abs() < 1e-9, "means of all readings, equation 25");
    }

    #[test]
    fn welchs_interval_is_the_textbook_one() {
        // Welch's t interval of [1, 2, 3, 4] against [2, 4, 9]: 2.39 degrees of freedom, by scipy.stats.ttest_ind(equal_var=False)
        let w = |v: &[f64]| Way::new(v.to_vec()).unwrap();
        let half = welch(&w(&[1.0, 2.0, 3.0, 4.0]), &w(&[2.0, 4.0, 9.0])).unwrap();
        assert!((half - 8.057_543_515_568_682).abs() < 1e-6, "{half}");
    }

    #[test]
    fn one_direction_has_its_repeatability_and_no_backlash() {
        let p = pose(&[reading(true, "1", Some(1.0)), reading(true, "2", Some(2.0))]);
        assert!(p.backlash.is_none() && p.bidirectional_m(3.0).is_none() && p.pairs_m.is_empty());
        assert!(p.forward.unwrap().repeatability_m().is_some());
    }
}
