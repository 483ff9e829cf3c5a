//! `loaded_play`: play whose flank follows the load, not the movement.
//!
//! Where the torque of gravity about the joint is beyond `torque_nm`, the load holds the gear on one flank: the joint stands half a
//! gap towards the load, whichever way it moves. Within, the direction of movement picks the flank as in [`super::backlash`].
//! Reference: Armstrong-Helouvry, Dupont, Canudas de Wit (1994), Automatica 30(7), for loaded gears; Ruderman, Hoffmann, Bertram
//! (2009), IEEE Trans. Industrial Electronics 56(10).
//!
//! The torque is that of `links` and payload (the log's measured torque holds friction, which turns over at a reversal). Parameters:
//! half gap 0 or more, at most 0.1 rad (10 mm); torque 0 or more. Without `links` it is plain play. A program's offset cannot
//! follow the load: `rewrite` leaves it.

use super::backlash::play;
use super::common::*;
use serde_yaml::Value;

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "loaded_play",
    heading: "loaded play",
    stage: Stage::Gear,
    family: Family::Gap,
    acts_on: ActsOn::Joint,
    adds: "play whose flank follows the load if the load is large, and the movement if it is small",
    equation: "q = s + half_gap sign(torque) where |torque| > torque_nm, else the play operator; torque of gravity",
    reference: "Ruderman, Hoffmann, Bertram (2009), IEEE Trans. Industrial Electronics 56(10)",
    parameters: &[
        ("half_gap_deg", "half of the gap, 0 to 0.1 rad (10 mm)"),
        ("torque_nm", "load above which the load decides the flank, 0 or more (N for a prismatic joint: force_n)"),
    ],
    confused_with: &["backlash", "gravity_compliance"],
    decide_by: "reverse at positions where gravity loads the joint in one direction, in the other, and not at all; change the payload",
    action: "remove the gap; or work where the load keeps its sign: the gap has no effect there",
    undone: "nothing: the flank follows the load",
    special: Special {
        after_reversal: AfterReversal::Step,
        imitates: &["backlash"],
        further: |survey, list| {
            for axis in survey.moving().filter(|&a| survey.axes[a].loaded) {
                let largest = survey.axes[axis].load;
                for share in SHARES {
                    let make = move |b: f64| LoadedPlay { half_gap: b.max(0.0), torque: share * largest };
                    let one = Candidate::of_size(survey.robot, Target::Joint(axis), candidate::TRIAL, make);
                    list.push(one.positive().with_shape(1));
                }
            }
        },
        ..Special::NONE
    },
    example: ("{effect: loaded_play, joint: A1, half_gap_deg: 0.003, torque_nm: 900}", View::JointOverCommand),
    read: |f| {
        let key = torque_key(f.site().is_revolute());
        Ok(LoadedPlay { half_gap: f.length("half_gap", 0.0)?, torque: f.needed(key, 0.0)? }.into())
    },
    typical: |size| {
        vec![(size.key("half_gap"), size.gap.into()), (torque_key(size.is_revolute()).into(), Value::from(50.0))]
    },
    candidates: |_, _| {},
};

/// Torques that are tried, as shares of the largest: the likelihood has steps, so that a refit does not find the torque.
const SHARES: [f64; 12] = [0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7, 0.85];

/// Half gap in rad or m, and the torque (Nm or N) beyond which the load picks the flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadedPlay {
    /// Half gap, rad or m.
    pub half_gap: f64,
    /// Torque beyond which the load presses the gear against one flank, Nm or N.
    pub torque: f64,
}

fn torque_key(revolute: bool) -> &'static str {
    if revolute { "torque_nm" } else { "force_n" }
}

impl EffectType for LoadedPlay {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn values(&self) -> Vec<f64> {
        vec![self.half_gap, self.torque]
    }

    fn with(&self, v: &[f64]) -> Effect {
        Self { half_gap: v[0], torque: v[1] }.into()
    }

    fn parameters(&self, site: &Site) -> Vec<Parameter> {
        vec![
            site.length("half_gap", (0.0, site.most_lost()), site.typical(0.003, 0.005)),
            Parameter::new(torque_key(site.is_revolute()), 1.0, (0.0, 1e5), 50.0),
        ]
    }

    fn apply(&self, track: &Track, signal: &mut [f64]) {
        if track.load.is_empty() {
            play(track, signal, |_| self.half_gap);
            return;
        }
        let Some(&first) = signal.first() else { return };
        let b = self.half_gap;
        let mut out = first - f64::from(track.initial_gap_side) * b;
        for (i, s) in signal.iter_mut().enumerate() {
            let load = track.load_at(i);
            out = if load > self.torque {
                *s + b
            } else if load < -self.torque {
                *s - b
            } else {
                out.clamp(*s - b, *s + b)
            };
            *s = out;
        }
    }

    fn is_wider(&self) -> bool {
        true
    }

    fn is_threshold(&self, value: usize) -> bool {
        value == 1
    }

    fn has_memory(&self) -> bool {
        true
    }

    fn is_play(&self) -> bool {
        true
    }

    fn uses_load(&self) -> bool {
        true
    }

    fn half_gap(&self) -> Option<GapCurve> {
        Some(GapCurve::Constant(self.half_gap))
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::nothing("its flank follows the load, which a program does not hold")
    }
}
