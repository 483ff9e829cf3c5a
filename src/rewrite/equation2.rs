//! Equation 2 of Cursi (2022), to compare with equation 16 of Zhang (2023): a whole deadzone at each change of direction.
//!
//! `theta_comp(t) = theta(t) -+ delta(theta(t))` where the direction changes at `t`, else `theta(t)`; `delta` is the whole deadzone, both half
//! gaps. As printed the offset lasts one sample ([`Law::Equation2`]): the motor jumps across its deadzone and back, so that the
//! joint still waits for the whole way. The words around it ("adding or removing the deadzone size") allow another reading: the offset
//! stays, and each change of direction adds the next ([`Law::Equation2Held`]). Then the steps are those of equation 16, but
//! - the joint stands half a gap beside its command all the time: equation 16 shares the step between both directions;
//! - each step has the size of the gap at its turn: where the gap varies, or a turn is missed, the steps do not
//!   cancel and the command drifts;
//! - between turns the offset does not follow the gap.
//!
//! No point is added and none is sought between points, as in the paper: a step takes as long as a point. Friction is none of its
//! business. A pause keeps the direction; movement up to the dead band is none.

use super::offset::Offset;
use super::stats::RewriteStats;
use crate::numerics::reversal::{Movement, ReversalDetector};
use crate::robot::Robot;
use nalgebra::Vector3;

/// Which offsets a reversal gets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Law {
    /// Half a gap either way, for as long as the direction lasts (Zhang (2023), equation 16), with what a reversal needs to be followed.
    #[default]
    SymmetricHalfGap,
    /// The whole deadzone at the sample where the direction changes, as Cursi (2022) prints it.
    Equation2,
    /// The whole deadzone from there on.
    Equation2Held,
}

/// State of one axis.
#[derive(Debug, Clone, Copy)]
struct Axis {
    direction: ReversalDetector,
    shift: f64,
}

/// Takes points one by one.
pub struct Equation2 {
    held: bool,
    axes: Vec<Axis>,
    points: usize,
}

impl Equation2 {
    /// `deadband` and `initial_direction` have one value per axis.
    pub fn new(held: bool, deadband: &[f64], initial_direction: &[i8]) -> Self {
        let axis = |(&dir, &band): (&i8, &f64)| Axis { direction: ReversalDetector::new(band, dir), shift: 0.0 };
        Self { held, axes: initial_direction.iter().zip(deadband).map(axis).collect(), points: 0 }
    }

    /// The command for the next point `q`, into `out`.
    pub fn apply(
        &mut self,
        robot: &Robot,
        offsets: &[Option<Offset>],
        q: &[f64],
        out: &mut Vec<f64>,
        stats: &mut RewriteStats,
    ) {
        self.points += 1;
        let from = out.len();
        out.extend_from_slice(q);
        let mut columns = Vec::new();
        for (a, (state, offset)) in self.axes.iter_mut().zip(offsets).enumerate() {
            let (p, Some(offset)) = (q[a], offset) else { continue };
            let mut now = 0.0;
            if let Movement::Reversed { .. } = state.direction.take(self.points, p) {
                now = f64::from(state.direction.direction()) * (offset.gap(1, p) + offset.gap(-1, p));
                stats.reversals[a] += 1;
                if columns.is_empty() {
                    columns = vec![Vector3::zeros(); q.len()];
                    robot.chain().position_and_jacobian(q, &mut columns);
                }
                stats.largest_change_m = stats.largest_change_m.max(columns[a].norm() * now.abs());
            }
            state.shift = if self.held { state.shift + now } else { now };
            out[from + a] += state.shift;
            stats.largest_offset[a] = stats.largest_offset[a].max(state.shift.abs());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compensator::{BacklashOffset, JointCompensator};
    use crate::effects::{BacklashPosition, EffectType, GapCurve, Track};
    use crate::robot::{Convention, Joint, JointKind};
    use nalgebra::Isometry3;

    fn arm() -> Robot {
        let joint = Joint {
            name: "J".into(),
            kind: JointKind::Revolute,
            theta_rad: 0.0,
            d_m: 0.0,
            a_m: 0.5,
            alpha_rad: 0.0,
            beta_rad: 0.0,
            direction: 1.0,
            limits: None,
            max_speed: None,
            max_accel: None,
            lead_m_per_rev: None,
            pulses: None,
            follows: None,
        };
        Robot::new("arm".into(), Convention::Standard, vec![joint], Isometry3::identity(), Isometry3::identity())
    }

    fn commands(held: bool, p: &[f64], gap: &GapCurve) -> (Vec<f64>, RewriteStats) {
        let backlash = Some(BacklashOffset { positive: gap.clone(), negative: gap.clone() });
        let offsets = [Some(Offset::new(&JointCompensator { axis: 0, backlash, friction: None }))];
        let mut stats = RewriteStats { reversals: vec![0], largest_offset: vec![0.0], ..RewriteStats::default() };
        let mut law = Equation2::new(held, &[1e-9], &[0]);
        let (robot, mut out) = (arm(), Vec::new());
        p.iter().for_each(|&q| law.apply(&robot, &offsets, &[q], &mut out, &mut stats));
        (out, stats)
    }

    /// Where the joint goes, from the middle of its gap.
    fn joint(commands: &[f64], gap: &GapCurve) -> Vec<f64> {
        let t: Vec<f64> = (0..commands.len()).map(|i| i as f64).collect();
        let mut signal = commands.to_vec();
        BacklashPosition { half_gap: gap.clone() }.apply(&Track::new(&t, commands, 0.0), &mut signal);
        signal
    }

    const P: [f64; 9] = [0.0, 0.4, 0.8, 0.6, 0.2, -0.2, 0.1, 0.5, 0.9];

    #[test]
    fn as_printed_the_offset_lasts_one_sample_and_the_joint_still_waits() {
        let gap = GapCurve::Constant(0.05);
        let (c, stats) = commands(false, &P, &gap);
        let want = [0.0, 0.4, 0.8, 0.5, 0.2, -0.2, 0.2, 0.5, 0.9];
        assert!(c.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-12), "{c:?}");
        assert_eq!(stats.reversals, [2]);
        assert!((stats.largest_change_m - 0.05).abs() < 1e-12);
        // one sample later the joint is where it would be without: half a gap after on either side
        assert!((joint(&c, &gap)[4] - 0.25).abs() < 1e-12 && (joint(&c, &gap)[8] - 0.85).abs() < 1e-12);
    }

    #[test]
    fn held_the_joint_follows_at_once_but_half_a_gap_beside_its_command() {
        let gap = GapCurve::Constant(0.05);
        let (c, _) = commands(true, &P, &gap);
        let y = joint(&c, &gap);
        assert!(y.iter().zip(P).skip(1).all(|(y, p)| (y - (p - 0.05)).abs() < 1e-12), "{y:?}");
    }

    #[test]
    fn held_offsets_drift_where_the_gap_varies() {
        let gap = GapCurve::Polynomial { coefficients: vec![0.05, 0.02], range: [-1.0, 1.0] };
        let p: Vec<f64> = (0..81).map(|i| (f64::from(i) * std::f64::consts::FRAC_PI_4).sin()).collect();
        let (c, stats) = commands(true, &p, &gap);
        // ten turns of either kind, at 0.71 and -0.71: 2 * 0.02 * 1.41 each pair
        assert!(stats.reversals[0] >= 18);
        let drift = c[80] - p[80];
        assert!(drift < -0.4, "{drift}");
    }
}
