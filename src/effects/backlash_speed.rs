//! `backlash_speed`: play whose half gap grows, or shrinks, with the TCP speed: `b = half_gap + slope * speed`.
//!
//! The speed is that of the commanded TCP (Gantry (2015) finds such a dependence). The operator is that of [`super::backlash`] with
//! a gap that varies along the way; a value below 0 is no gap. Parameters: half gap 0 or more, at most 0.1 rad or 10 mm (more is
//! a broken joint); slope of either sign, at most 0.1 rad or 10 mm per m/s. Action: as for backlash; compensate at the speed at
//! which the program runs.

use super::backlash::play;
use super::common::*;
use super::site::within;
use serde_yaml::Value;

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "backlash_speed",
    heading: "backlash speed",
    stage: Stage::Gear,
    family: Family::Gap,
    acts_on: ActsOn::Joint,
    adds: "backlash whose gap depends on the TCP speed",
    equation: "play operator, b = half_gap + slope * commanded TCP speed, 0 or more",
    reference: "Gantry (2015); Slamani, Nubiola, Bonev (2012), Robotica 30(7), for the dependence on the TCP speed",
    parameters: &[
        ("half_gap_deg", "at rest, 0 to 0.1 rad (10 mm)"),
        ("slope_deg_per_mm_s", "either sign, within 0.1 rad (10 mm) per m/s"),
    ],
    confused_with: &["backlash", "servo_lag"],
    decide_by: "reverse at three or more speeds",
    action: "identify and compensate at the working speed; check lubrication and preload",
    undone: "an offset of half the gap at the TCP speed of the program if you give it, otherwise of half the gap at rest",
    special: Special {
        after_reversal: AfterReversal::Step,
        includes: &["backlash"],
        imitates: &["backlash"],
        ..Special::NONE
    },
    example: (
        "{effect: backlash_speed, joint: A1, half_gap_deg: 0.001, slope_deg_per_mm_s: 1.0e-5}",
        View::JointWhileSlowing,
    ),
    read: |f| {
        let site = f.site();
        Ok(BacklashSpeed {
            half_gap: f.length("half_gap", 0.0)?,
            slope: f.any(&slope_key(&site))? * site.si_per_user_unit() * 1e3,
        }
        .into())
    },
    typical,
    candidates,
};

/// Half gap at rest (rad or m), and its slope (rad or m per m/s).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BacklashSpeed {
    /// Half gap at rest, rad or m.
    pub half_gap: f64,
    /// Its growth with the TCP speed, rad or m per m/s.
    pub slope: f64,
}

impl BacklashSpeed {
    /// Half gap at a TCP speed in m/s.
    #[inline]
    pub fn half_gap_at(&self, speed_m_s: f64) -> f64 {
        (self.half_gap + self.slope * speed_m_s).max(0.0)
    }
}

fn slope_key(site: &Site) -> String {
    format!("slope_{}_per_mm_s", site.unit())
}

fn typical(size: &TypicalSize) -> Vec<(String, Value)> {
    let slope = format!("slope_{}_per_mm_s", size.kind.unit());
    vec![(size.key("half_gap"), (0.5 * size.gap).into()), (slope, (0.5 * size.gap / size.tcp_speed_mm_s).into())]
}

fn candidates(survey: &Survey, list: &mut Vec<Candidate>) {
    let fastest = survey.fastest_m_s;
    for axis in survey.moving() {
        let target = Target::Joint(axis);
        let trials = [candidate::TRIAL, candidate::TRIAL / fastest];
        let make = |c: &[f64]| BacklashSpeed { half_gap: c[0], slope: c[1] };
        let build = move |c: &[f64]| {
            // a gap is nowhere negative: start inside
            let least = c[0].min(c[0] + c[1] * fastest);
            let lift = if least < 0.0 { -least } else { 0.0 };
            BacklashSpeed { half_gap: c[0] + lift, slope: c[1] }
        };
        // its size is its slope
        list.push(Candidate::of_sizes(survey.robot, target, &trials, make).built_by(target, build).sized_from(1));
    }
}

impl EffectType for BacklashSpeed {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn values(&self) -> Vec<f64> {
        vec![self.half_gap, self.slope]
    }

    fn with(&self, v: &[f64]) -> Effect {
        Self { half_gap: v[0], slope: v[1] }.into()
    }

    fn parameters(&self, site: &Site) -> Vec<Parameter> {
        let lost = site.most_lost();
        let typical = site.typical(0.003, 0.005);
        let per_mm_s = 1.0 / site.si_per_user_unit() * 1e-3;
        vec![
            site.length("half_gap", (0.0, lost), typical),
            Parameter::new(&slope_key(site), per_mm_s, within(lost), 10.0 * typical),
        ]
    }

    fn apply(&self, track: &Track, signal: &mut [f64]) {
        play(track, signal, |i| self.half_gap_at(track.tcp_speed_m_s.get(i).copied().unwrap_or(0.0)));
    }

    fn has_memory(&self) -> bool {
        true
    }

    fn is_play(&self) -> bool {
        true
    }

    fn uses_tcp_speed(&self) -> bool {
        true
    }

    fn half_gap(&self) -> Option<GapCurve> {
        Some(GapCurve::Constant(self.half_gap))
    }

    fn magnitude(&self) -> f64 {
        self.slope.abs()
    }

    fn undo(&self, context: &UndoContext) -> Undo {
        let gap = GapCurve::Constant(self.half_gap_at(context.tcp_speed_m_s.unwrap_or(0.0)));
        let left = context.tcp_speed_m_s.is_none().then_some("without a TCP speed only its gap at rest is compensated");
        Undo { left, ..Undo::gap(gap) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gap_is_that_of_the_speed() {
        let p = [0.0, 1.0, 2.0, 1.0, 0.0];
        let t = [0.0, 1.0, 2.0, 3.0, 4.0];
        let speed = [0.0, 1.0, 1.0, 2.0, 2.0];
        let mut track = Track::new(&t, &p, 0.0);
        track.tcp_speed_m_s = &speed;
        let mut s = p.to_vec();
        BacklashSpeed { half_gap: 0.1, slope: 0.05 }.apply(&track, &mut s);
        let want = [0.0, 0.85, 1.85, 1.2, 0.2];
        assert!(s.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-12), "{s:?}");
    }
}
