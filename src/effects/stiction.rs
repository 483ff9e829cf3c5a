//! `stiction`: a joint stands still after a reversal, then the servo works the error off (Zhang (2023) equations 8 and 9).
//!
//! Adds `-dir * min(|p - p_rev|, spike * decay(...))` after each reversal: the joint does not move until the command has
//! moved that far from its turning point; without the minimum it would leap against its command. Nothing before the first
//! reversal. The spike decays with the time since the reversal, or with the travel.
//!
//! Parameters: spike 0 or more, at most 0.1 rad or 10 mm; decay above 0. Action: friction: grease, preload, integral gain of the
//! servo; a fading offset after each reversal compensates it.

use super::common::*;
pub use super::decay::Decay;
use super::presliding_stiction;
use serde_yaml::Value;

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "stiction",
    heading: "stiction",
    stage: Stage::Servo,
    family: Family::Friction,
    acts_on: ActsOn::Joint,
    adds: "the joint stands still after a reversal until the servo has corrected the error",
    equation: "-dir min(|p - p_rev|, spike exp(-(t - t_rev)/decay)) after each reversal; with a rise de = -(spike/2) dz - e dt/decay, dz = (dir - z) dt/rise (or travel over rise)",
    reference: "Zhang (2023) equations 8 and 9; Armstrong-Helouvry, Dupont, Canudas de Wit (1994), Automatica 30(7); Canudas de Wit et al. (1995), IEEE Trans. Automatic Control 40(3), for the rise",
    parameters: &[
        ("spike_deg", "largest error, 0 to 0.1 rad (10 mm); a larger error means a seized joint"),
        ("decay_s or decay_deg", "time (1 ms to 1000 s) or travel over which the error fades"),
        (
            "rise_s or rise_deg",
            "time (1 ms to 10 s) or travel over which the error builds up; without it, the error builds up as the joint stands still",
        ),
        (
            "spike_positive_deg, spike_negative_deg",
            "instead of spike_deg: largest error after reversals into the positive and the negative direction",
        ),
        ("per_nm", "relative growth of the spike with the torque of gravity, 0 to 1 per Nm"),
    ],
    confused_with: &["hysteresis", "backlash"],
    decide_by: "reverse at two speeds and wait after one reversal: stiction fades, a gap remains",
    action: "grease, check preload and seals, raise the integral gain; a fading offset after each reversal compensates it",
    undone: "a fading offset after each reversal",
    special: Special {
        after_reversal: AfterReversal::Tail,
        needs_motion: true,
        further: presliding_stiction::further,
        ..Special::NONE
    },
    example: ("{effect: stiction, joint: A1, spike_deg: 0.004, decay_s: 1.5}", View::JointOverTime),
    read,
    typical,
    candidates,
};

/// Spike in rad or m, and its decay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stiction {
    /// Lag at the instant of a reversal, rad or m.
    pub spike: f64,
    /// How it decays.
    pub decay: Decay,
}

fn read(f: &mut Fields) -> Result<Effect> {
    let site = f.site();
    let si = site.si_per_user_unit();
    let more = ["rise_s", &site.key("rise"), &site.key("spike_positive"), &site.key("spike_negative"), "per_nm"];
    let general = more.iter().any(|key| f.has(key));
    let rise = (f.number("rise_s", f64::MIN_POSITIVE)?, f.number(&site.key("rise"), f64::MIN_POSITIVE)?);
    let rise = match rise {
        (Some(s), None) => Some(Decay::Time(s)),
        (None, Some(x)) => Some(Decay::Travel(x * si)),
        (None, None) => None,
        _ => return Err(f.bad("rise", "two rises", &format!("either `rise_s` or `{}`", site.key("rise")))),
    };
    let time = f.number("decay_s", f64::MIN_POSITIVE)?;
    let travel = f.number(&site.key("decay"), f64::MIN_POSITIVE)?;
    let decay = match (time, travel) {
        (Some(s), None) => Decay::Time(s),
        (None, Some(x)) => Decay::Travel(x * si),
        _ => {
            let expected = format!("either `decay_s` or `{}`", site.key("decay"));
            return Err(f.bad("decay", "no decay, or two", &expected));
        }
    };
    if general {
        return presliding_stiction::read(f, rise, decay);
    }
    Ok(Stiction { spike: f.length("spike", 0.0)?, decay }.into())
}

fn typical(size: &TypicalSize) -> Vec<(String, Value)> {
    let mut keys = vec![(size.key("spike"), size.gap.into())];
    if !size.has("decay") {
        keys.push(("decay_s".into(), 1.5.into()));
    }
    keys
}

/// Ratio of neighbouring decays that are tried, in time and in travel.
const NEXT_TIME: f64 = 1.9;
const NEXT_TRAVEL: f64 = 2.7;

fn candidates(survey: &Survey, list: &mut Vec<Candidate>) {
    let tried = |axis, decay, form| {
        let make = move |spike| Stiction { spike, decay };
        Candidate::of_size(survey.robot, Target::Joint(axis), candidate::TRIAL, make)
            .positive()
            .with_shape(1)
            .with_form(form)
    };
    for axis in survey.moving() {
        if let Some((step, length)) = survey.clock {
            let mut tau = 0.75 * step.max(0.02);
            while tau < 0.5 * length && tau < 30.0 {
                list.push(tried(axis, Decay::Time(tau), "time"));
                tau *= NEXT_TIME;
            }
        }
        for travel in survey.travels(axis, NEXT_TRAVEL) {
            list.push(tried(axis, Decay::Travel(travel), candidate::OVER_TRAVEL));
        }
    }
}

impl EffectType for Stiction {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn nature(&self) -> Nature {
        Nature::Spike
    }

    fn values(&self) -> Vec<f64> {
        let (Decay::Time(d) | Decay::Travel(d)) = self.decay;
        vec![self.spike, d]
    }

    fn with(&self, v: &[f64]) -> Effect {
        let decay = match self.decay {
            Decay::Time(_) => Decay::Time(v[1]),
            Decay::Travel(_) => Decay::Travel(v[1]),
        };
        Self { spike: v[0], decay }.into()
    }

    fn parameters(&self, site: &Site) -> Vec<Parameter> {
        let decay = match self.decay {
            Decay::Time(_) => Parameter::seconds("decay_s", (1e-3, 1e3), 1.5),
            Decay::Travel(_) => site.length("decay", site.travel_bounds(), site.typical(0.5, 0.5)),
        };
        vec![site.length("spike", (0.0, site.most_lost()), site.typical(0.003, 0.005)), decay]
    }

    fn apply(&self, track: &Track, signal: &mut [f64]) {
        for (turn, samples) in track.strokes() {
            let dir = f64::from(turn.dir);
            for i in samples {
                let travel = (track.p[i] - turn.p).abs();
                let spike = self.spike * self.decay.left(track.t_s[i] - turn.t_s, travel);
                signal[i] -= dir * travel.min(spike);
            }
        }
    }

    fn has_memory(&self) -> bool {
        true
    }

    fn sticks_by(&self) -> f64 {
        self.spike
    }

    fn largest_after_reversal(&self) -> Option<f64> {
        Some(self.spike)
    }

    fn transition(&self) -> Option<f64> {
        match self.decay {
            Decay::Travel(x) => Some(x),
            Decay::Time(_) => Some(2.0 * self.spike),
        }
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo { friction: Some((self.spike, self.decay)), ..Undo::default() }
    }
}
