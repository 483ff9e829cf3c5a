//! The machine that a compensator describes: the robot with the compensator's gaps and friction (a measured response, too: stictions that
//! build up, gap, hystereses). On it, a rewritten program shows whether its offsets do what they are meant to do.

use super::{Compensator, FrictionShape, JointCompensator, Response};
use crate::effects::{
    BacklashPosition, Decay, EffectInstance, GapCurve, Hysteresis, PreslidingStiction, Stiction, Target, curve::Pchip,
};
use crate::model::Model;
use crate::robot::Robot;

/// Knots of a gap whose two sides are averaged.
const KNOTS: usize = 41;

impl Compensator {
    /// Whether it rests on measurements: offsets that were typed in describe no machine.
    pub fn is_measured(&self) -> bool {
        !self.evidence.joints.is_empty() || !self.evidence.logs.is_empty()
    }

    /// Whether its friction counts points, as no machine's friction does.
    pub fn counts_points(&self) -> bool {
        let counts = |s: FrictionShape| matches!(s, FrictionShape::Poses { .. });
        self.joints.iter().any(|j| j.friction.is_some_and(|f| counts(f.shape)))
    }

    /// The robot with the gaps and the friction of this compensator; `None` if it describes no machine.
    pub fn machine(&self, robot: &Robot) -> Option<Model> {
        if !self.is_measured() || self.counts_points() || self.is_zero() {
            return None;
        }
        let mut model = Model::ideal(robot.clone());
        self.joints.iter().for_each(|joint| add(joint, &mut model));
        Some(model)
    }
}

/// Adds the effects of one joint.
fn add(joint: &JointCompensator, model: &mut Model) {
    let target = Target::Joint(joint.axis);
    let mut windups = Vec::new();
    if let Some(f) = joint.friction {
        match f.shape {
            FrictionShape::Decay(decay) => {
                let effect = Stiction { spike: f.gain, decay }.into();
                model.effects.push(EffectInstance { target, effect });
            }
            FrictionShape::Response(r) => {
                model.effects.extend(spikes(&r).map(|e| EffectInstance { target, effect: e.into() }));
                windups.extend(wind_up(&r).map(|e| EffectInstance { target, effect: e.into() }));
            }
            FrictionShape::Poses { .. } => {}
        }
    }
    if let Some(b) = &joint.backlash {
        let half_gap = mean(&b.positive, &b.negative, &model.robot, joint.axis);
        model.effects.push(EffectInstance { target, effect: BacklashPosition::or_constant(half_gap) });
    }
    // gear and link wind up over the travel that the play lets through
    model.effects.extend(windups);
}

/// The servo's part of a response: a stiction that builds up over the presliding for each time constant.
fn spikes(r: &Response) -> impl Iterator<Item = PreslidingStiction> {
    let rise = Decay::Travel(r.presliding);
    let of = move |gain: f64, decay_s: f64| PreslidingStiction {
        spike: [2.0 * gain; 2],
        symmetric: true,
        rise,
        decay: Decay::Time(decay_s),
        per_nm: None,
    };
    r.spikes.into_iter().filter(|s| s.gain != 0.0).map(move |s| of(s.gain, s.decay_s))
}

/// Its wind-up: a hysteresis for each part.
fn wind_up(r: &Response) -> impl Iterator<Item = Hysteresis> {
    let used = r.windups.into_iter().filter(|w| w.half != 0.0);
    used.map(|w| Hysteresis { half_width: w.half, presliding: w.presliding })
}

/// Mean of both sides of a gap: the play; the rest of an asymmetric gap is an offset that does not depend on direction.
fn mean(positive: &GapCurve, negative: &GapCurve, robot: &Robot, axis: usize) -> GapCurve {
    if positive == negative {
        return positive.clone();
    }
    if let (Some(a), Some(b)) = (positive.constant(), negative.constant()) {
        return GapCurve::Constant(0.5 * (a + b));
    }
    let range = robot.axis(axis).limits.unwrap_or([-std::f64::consts::PI, std::f64::consts::PI]);
    let knots: Vec<[f64; 2]> = (0..KNOTS)
        .map(|k| {
            let p = range[0] + (range[1] - range[0]) * k as f64 / (KNOTS - 1) as f64;
            [p, 0.5 * (positive.at(p) + negative.at(p))]
        })
        .collect();
    Pchip::new(&knots).map_or_else(|| positive.clone(), GapCurve::Pchip)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compensator::{BacklashOffset, Evidence, FrictionOffset, Spike, Windup};
    use crate::effects::{Effect, Track, joint_output};
    use crate::gaps::LogRef;
    use crate::identify::machine::law::{JointLaw, JointRows, OVER, TAUS_S};
    use crate::identify::machine::spline::Spline;

    /// What `identify` fits and what the verdict runs on are two programs of one law.
    #[test]
    fn a_measured_response_moves_as_the_law_that_was_fitted() {
        let text = "schema: lostmotion/robot/1\njoints:\n  - {name: A1, kind: revolute, a_mm: 500}\n";
        let robot = Robot::parse("robot.yaml", text).unwrap();
        let law = JointLaw {
            gap: vec![4e-5; 3],
            spikes: [1e-5, 2e-5, 0.5e-5],
            windups: [0.3e-5, 0.2e-5, 0.4e-5],
            presliding: 3e-5,
        };
        let spike = |k: usize| Spike { gain: law.spikes[k], decay_s: TAUS_S[k] };
        let windup = |k: usize| Windup { half: law.windups[k], presliding: law.presliding * OVER[k] };
        let response = Response {
            presliding: law.presliding,
            spikes: std::array::from_fn(spike),
            windups: std::array::from_fn(windup),
        };
        let joint = JointCompensator {
            axis: 0,
            backlash: Some(BacklashOffset::symmetric(GapCurve::Constant(4e-5))),
            friction: Some(FrictionOffset::of_response(response)),
        };
        let log = LogRef { name: "run.csv".into(), sha256: "0".into() };
        let compensator = Compensator {
            robot_name: robot.name.clone(),
            robot_sha256: robot.fingerprint(),
            joints: vec![joint],
            evidence: Evidence { logs: vec![log], ..Evidence::default() },
        };
        let model = compensator.machine(&robot).unwrap();
        let t: Vec<f64> = (0..6000).map(|i| 0.005 * f64::from(i)).collect();
        let x: Vec<f64> = t.iter().map(|t| 0.02 * (0.7 * t).sin()).collect();
        let effects: Vec<&Effect> = model.effects.iter().map(|e| &e.effect).collect();
        let is = joint_output(&Track::new(&t, &x, 0.0), effects);
        let want = JointRows::new(&t, &x, &Spline::new(-0.02, 0.02, 3)).respond(&law, false).error;
        // both start somewhere; after two reversals they know where friction stands
        let settled = t.iter().position(|t| *t > 7.5).unwrap();
        let off = (settled..t.len()).map(|i| (is[i] - x[i] - want[i]).abs()).fold(0.0, f64::max);
        let size = want[settled..].iter().fold(0.0, |m: f64, e| m.max(e.abs()));
        assert!(size > 6e-5 && off < 0.02 * size, "{off} of {size}");
    }

    #[test]
    fn friction_that_counts_points_is_no_machine() {
        let text = "schema: lostmotion/robot/1\njoints:\n  - {name: A1, kind: revolute, a_mm: 500}\n";
        let robot = Robot::parse("robot.yaml", text).unwrap();
        let shape = FrictionShape::Poses { exponent: 1.0, poses: 5 };
        let friction = Some(FrictionOffset { gain: 1e-5, shape });
        let mut compensator = Compensator {
            robot_name: robot.name.clone(),
            robot_sha256: robot.fingerprint(),
            joints: vec![JointCompensator { axis: 0, backlash: None, friction }],
            evidence: Evidence::default(),
        };
        assert!(compensator.machine(&robot).is_none());
        compensator.evidence.logs.push(LogRef { name: "run.csv".into(), sha256: "0".into() });
        assert!(compensator.is_measured() && compensator.counts_points() && compensator.machine(&robot).is_none());
    }
}
