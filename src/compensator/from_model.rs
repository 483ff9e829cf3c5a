//! The compensator of a model: the predicted joint error with its sign turned, for every effect that an offset can undo.
//!
//! Backlash becomes the offset of equation 16, stiction the fading offset of equation 17 with the decay of the model. Two
//! plays in series are one play of their sum (exactly, for symmetric play); where one of them varies with position, the sum is
//! joined by PCHIP through 41 positions of the joint's range. Two stictions on one joint are one only if their decay is
//! the same; otherwise the model is refused, because the document holds one friction term a joint.
//!
//! A hysteresis alone on its joint is a gap of its half width whose step builds up over travel: the friction term with the gain
//! `-2 half_width` and the presliding as its travel is its exact inverse after a saturated stroke. Beside a gap or a stiction
//! its half width counts as a gap, and its transition is left. A gap that depends on speed is that of the speed given.
//!
//! What depends on the joint vector alone (scale, transmission error, zero, coupling, gravity) is no state and stands in no compensator
//! document: [`crate::rewrite::statics`] undoes it. What no joint offset can undo is listed by [`not_compensated`].

use super::{BacklashOffset, Compensator, Evidence, FrictionOffset, FrictionShape, JointCompensator, Note};
use crate::effects::{EffectInstance, Family, GapCurve, Stage, Target, UndoContext, curve::Pchip};
use crate::error::{Error, Place, Result};
use crate::model::Model;

/// Intervals of the grid on which two curves are added.
const GRID: usize = 40;

impl Compensator {
    /// Offsets that undo the model's joint effects that depend on where a joint came from; gaps at rest.
    pub fn from_model(model: &Model) -> Result<Self> {
        Self::from_model_at(model, 0.0)
    }

    /// The same at a TCP speed in m/s, for gaps that depend on it.
    pub fn from_model_at(model: &Model, tcp_speed_m_s: f64) -> Result<Self> {
        let robot = &model.robot;
        let mut joints = Vec::new();
        for axis in 0..robot.dof() {
            let name = &robot.axis(axis).name;
            let mut gap: Option<GapCurve> = None;
            let mut friction: Option<FrictionOffset> = None;
            for placed in model.effects.iter().filter(|p| p.target == Target::Joint(axis)) {
                let undo = placed.effect.undo(&context(model, placed, Some(tcp_speed_m_s)));
                if let Some(b) = undo.gap {
                    gap = Some(gap.take().map_or_else(|| b.clone(), |g| sum(&g, &b)));
                }
                let Some((gain, decay)) = undo.friction else { continue };
                let shape = FrictionShape::Decay(decay);
                match &mut friction {
                    None => friction = Some(FrictionOffset { gain, shape }),
                    Some(f) if f.shape == shape => f.gain += gain,
                    Some(_) => {
                        return Err(Error::bad(
                            Place::default(),
                            format!("two stictions with different decays on {name}"),
                            "one stiction per joint, or the same decay for all (one friction offset must compensate them)",
                        ));
                    }
                }
            }
            if gap.is_some() || friction.is_some() {
                let backlash = gap.map(BacklashOffset::symmetric);
                joints.push(JointCompensator { axis, backlash, friction });
            }
        }
        let evidence = Evidence { notes: vec![Note::OfModel], ..Evidence::default() };
        Ok(Self { robot_name: robot.name.clone(), robot_sha256: robot.fingerprint(), joints, evidence })
    }
}

/// What is known where an effect of a model is undone; alone: no other effect with memory is on its axis.
fn context<'a>(model: &'a Model, placed: &EffectInstance, tcp_speed_m_s: Option<f64>) -> UndoContext<'a> {
    let alone = placed.axis().is_some_and(|a| model.effects_on(a).filter(|e| e.has_memory()).count() == 1);
    UndoContext { site: placed.site(&model.robot), tcp_speed_m_s, alone }
}

/// Errors of links and tool that make a calibrated arm: fewer may be known one by one.
const CALIBRATED: usize = 3;

/// Is an effect gravity that stands in the model beside errors of links or tool, or the zero offset of an arm that was calibrated as
/// a whole? It was fitted together with them: alone it would move poses away instead of towards their target.
pub fn part_of_geometry(model: &Model, placed: &EffectInstance) -> bool {
    let beside = model.effects.iter().filter(|e| e.effect.stage() == Stage::Geometry).count();
    let least = match placed.effect.info().family {
        Family::Gravity => 1,
        Family::Geometry => CALIBRATED,
        _ => return false,
    };
    placed.effect.stage() == Stage::Link && beside >= least
}

/// Effects of a model that `rewrite` leaves, each with the reason, as lines; `tcp_speed_m_s` is the speed of the program where it
/// is known.
pub fn not_compensated(model: &Model, tcp_speed_m_s: Option<f64>) -> Vec<String> {
    let left = model.effects.iter().filter_map(|placed| {
        if part_of_geometry(model, placed) {
            let reason = "it is part of a geometry error: correct all of it in the kinematics";
            return Some(format!("{} of {}: {reason}", placed.effect.name(), placed.target_text(&model.robot)));
        }
        let reason = placed.effect.undo(&context(model, placed, tcp_speed_m_s)).left?;
        Some(format!("{} of {}: {reason}", placed.effect.name(), placed.target_text(&model.robot)))
    });
    left.collect()
}

impl BacklashOffset {
    /// The same offset in both directions.
    pub fn symmetric(half_gap: GapCurve) -> Self {
        Self { positive: half_gap.clone(), negative: half_gap }
    }
}

/// Sum of two gaps over position.
fn sum(a: &GapCurve, b: &GapCurve) -> GapCurve {
    if let (Some(x), Some(y)) = (a.constant(), b.constant()) {
        return GapCurve::Constant(x + y);
    }
    let mut places: Vec<f64> = Vec::new();
    for curve in [a, b] {
        match curve {
            GapCurve::Constant(_) => {}
            GapCurve::Polynomial { range: [lo, hi], .. } => {
                places.extend((0..=GRID).map(|k| lo + (hi - lo) * k as f64 / GRID as f64));
            }
            GapCurve::Pchip(p) => {
                for w in p.knots().windows(2) {
                    places.extend((0..=4).map(|k| w[0][0] + (w[1][0] - w[0][0]) * f64::from(k) / 4.0));
                }
            }
        }
    }
    places.sort_by(f64::total_cmp);
    places.dedup_by(|x, y| (*x - *y).abs() < 1e-9);
    let knots: Vec<[f64; 2]> = places.iter().map(|&p| [p, a.at(p) + b.at(p)]).collect();
    match Pchip::new(&knots) {
        Some(p) => GapCurve::Pchip(p),
        None => GapCurve::Constant(a.largest() + b.largest()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{Backlash, Decay, Effect, Hysteresis, ServoLag, Stiction};
    use crate::robot::Robot;

    fn model(effects: Vec<Effect>) -> Model {
        let text = "schema: lostmotion/robot/1\njoints:\n  - {name: A1, kind: revolute, a_mm: 500}\n";
        let mut model = Model::ideal(Robot::parse("robot.yaml", text).unwrap());
        model.effects = effects.into_iter().map(|e| EffectInstance::on_axis(0, e)).collect();
        model
    }

    #[test]
    fn two_plays_in_series_are_undone_by_the_sum_of_their_gaps() {
        let play = |b| Effect::new(Backlash::constant(b));
        let c = Compensator::from_model(&model(vec![play(1e-4), play(2e-4)])).unwrap();
        let b = c.joints[0].backlash.as_ref().unwrap();
        assert!((b.positive.constant().unwrap() - 3e-4).abs() < 1e-18);
        assert_eq!(b.positive, b.negative);
    }

    #[test]
    fn a_hysteresis_is_a_gap_that_builds_up() {
        let h = Effect::new(Hysteresis { half_width: 1e-4, presliding: 1e-3 });
        let alone = Compensator::from_model(&model(vec![h.clone()])).unwrap();
        assert_eq!(alone.joints[0].friction.unwrap().gain, -2e-4);
        let beside = model(vec![h, Effect::new(Backlash::constant(2e-4))]);
        let c = Compensator::from_model(&beside).unwrap();
        assert!(c.joints[0].friction.is_none());
        assert!((c.joints[0].backlash.as_ref().unwrap().positive.largest() - 3e-4).abs() < 1e-18);
        assert!(not_compensated(&beside, None)[0].contains("transition"));
    }

    #[test]
    fn says_what_no_offset_can_undo() {
        let lag = model(vec![Effect::new(ServoLag { lag_s: 0.01 })]);
        assert!(not_compensated(&lag, None)[0].starts_with("servo_lag of A1"));
    }

    #[test]
    fn refuses_two_stictions_that_fade_differently() {
        let stick = |s| Effect::new(Stiction { spike: 1e-4, decay: Decay::Time(s) });
        let e = Compensator::from_model(&model(vec![stick(1.0), stick(2.0)])).unwrap_err();
        assert!(e.to_string().contains("two stictions"), "{e}");
    }
}
