//! `hysteresis`: lost motion that builds up smoothly after a reversal: adds `-half_width * z`, `dz/dp = (1 - z dir)/presliding`.
//!
//! Dahl's model (P. Dahl, A solid friction model, 1968) over the signal that arrives. Parameters: half width 0 or more, at most
//! 0.1 rad or 10 mm (as a gap); presliding, the travel over which 63 % of the change builds up, above 0. Action: look
//! for wind-up (belt, harmonic drive, cable) rather than for a gap; stiffen, or preload.
//!
//! Method: `z = dir + (z0 - dir) exp(-travel/presliding)` on each monotone piece, exact between samples. Start: `z = 0`, or the
//! initial side of the gap.

use super::common::*;
use super::maxwell_slip;

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "hysteresis",
    heading: "hysteresis",
    stage: Stage::Gear,
    family: Family::Gap,
    acts_on: ActsOn::Joint,
    adds: "lost motion that builds up smoothly after a reversal",
    equation: "-half_width z, dz/dp = (1 - z dir)/presliding (Dahl); with elements -sum half_width_i z_i, dz_i = dp/presliding_i within -1 and +1",
    reference: "Dahl (1968), A Solid Friction Model, Aerospace Corporation TOR-0158(3107-18)-1; Al-Bender, Lampaert, Swevers (2005), IEEE Trans. Automatic Control 50(11), for the elements",
    parameters: &[
        ("half_width_deg", "half of the loop, 0 to 0.1 rad (10 mm)"),
        ("presliding_deg", "travel over which 63 % of the change builds up, above 0"),
        ("elements", "instead of both: [[half_width_deg, presliding_deg], ...], 1 to 8 elements that slip (Maxwell)"),
    ],
    confused_with: &["backlash", "stiction"],
    decide_by: "reverse slowly, with ten or more rows inside the transition",
    action: "wind-up of belt, cable or wave gear: stiffen or preload; an offset of half a width in the direction of travel compensates most of it",
    undone: "if it is the only such effect of its joint, an offset that builds up as it does; otherwise half a width in the direction of travel",
    special: Special {
        after_reversal: AfterReversal::Step,
        imitates: &["backlash"],
        needs_motion: true,
        ..Special::NONE
    },
    example: ("{effect: hysteresis, joint: A1, half_width_deg: 0.003, presliding_deg: 4}", View::JointOverCommand),
    read: |f| {
        let site = f.site();
        if f.has("elements") {
            return maxwell_slip::read(f);
        }
        Ok(Hysteresis {
            half_width: f.length("half_width", 0.0)?,
            presliding: f.above_0(&site.key("presliding"))? * site.si_per_user_unit(),
        }
        .into())
    },
    typical: |size| vec![(size.key("half_width"), size.gap.into()), (size.key("presliding"), (5.0 * size.gap).into())],
    candidates: |survey, list| {
        for axis in survey.moving() {
            for presliding in survey.travels(axis, 2.7) {
                let make = move |half_width| Hysteresis { half_width, presliding };
                let one = Candidate::of_size(survey.robot, Target::Joint(axis), candidate::TRIAL, make);
                list.push(one.positive().with_shape(1));
            }
        }
    },
};

/// Half width in rad or m, and presliding travel in rad or m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hysteresis {
    /// Half the width of the loop, rad or m.
    pub half_width: f64,
    /// Travel over which the loop is crossed to a share of 1/e, rad or m.
    pub presliding: f64,
}

impl EffectType for Hysteresis {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn nature(&self) -> Nature {
        Nature::WindUp
    }

    fn values(&self) -> Vec<f64> {
        vec![self.half_width, self.presliding]
    }

    fn with(&self, v: &[f64]) -> Effect {
        Self { half_width: v[0], presliding: v[1] }.into()
    }

    fn parameters(&self, site: &Site) -> Vec<Parameter> {
        vec![
            site.length("half_width", (0.0, site.most_lost()), site.typical(0.003, 0.005)),
            site.length("presliding", site.travel_bounds(), site.typical(0.1, 0.1)),
        ]
    }

    fn apply(&self, track: &Track, signal: &mut [f64]) {
        let Some(&first) = signal.first() else { return };
        let mut z = f64::from(track.initial_gap_side);
        let mut before = first;
        for s in signal {
            let step = *s - before;
            before = *s;
            if step != 0.0 {
                let side = step.signum();
                z = side + (z - side) * (-step.abs() / self.presliding).exp();
            }
            *s -= self.half_width * z;
        }
    }

    fn has_memory(&self) -> bool {
        true
    }

    /// A stroke longer than the transition loses as much.
    fn half_gap(&self) -> Option<GapCurve> {
        Some(GapCurve::Constant(self.half_width))
    }

    fn transition(&self) -> Option<f64> {
        Some(self.presliding)
    }

    fn undo(&self, context: &UndoContext) -> Undo {
        let gap = Undo::gap(GapCurve::Constant(self.half_width));
        let slow = 2.0 * self.half_width < self.presliding;
        match (context.alone, slow) {
            (true, true) => Undo { friction: Some((-2.0 * self.half_width, Decay::Travel(self.presliding))), ..gap },
            (false, _) => Undo {
                left: Some("beside another gap or stiction its half width is compensated, its transition is not"),
                ..gap
            },
            (true, false) => Undo {
                left: Some(
                    "it turns over faster than the joint moves: its half width is compensated, its transition is not",
                ),
                ..gap
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_stroke_saturates_and_a_reversal_turns_over_smoothly() {
        let t: Vec<f64> = (0..2001).map(f64::from).collect();
        let p: Vec<f64> = t.iter().map(|&t| if t <= 1000.0 { t * 1e-3 } else { 2.0 - t * 1e-3 }).collect();
        let track = Track::new(&t, &p, 0.0);
        let mut s = p.clone();
        Hysteresis { half_width: 0.01, presliding: 0.05 }.apply(&track, &mut s);
        assert!((s[1000] - (1.0 - 0.01)).abs() < 1e-9);
        // 0.05 after the turn: z = -1 + 2/e
        let z = -1.0 + 2.0 * (-1.0f64).exp();
        assert!((s[1050] - (0.95 - 0.01 * z)).abs() < 1e-9);
        assert!((s[2000] - 0.01).abs() < 1e-9);
    }

    #[test]
    fn fewer_samples_of_a_monotone_piece_give_the_same() {
        let run = |p: &[f64]| {
            let t: Vec<f64> = (0..p.len()).map(|i| i as f64).collect();
            let mut s = p.to_vec();
            Hysteresis { half_width: 0.01, presliding: 0.05 }.apply(&Track::new(&t, p, 0.0), &mut s);
            *s.last().unwrap()
        };
        assert!((run(&[0.0, 0.1, 0.07]) - run(&[0.0, 0.02, 0.09, 0.1, 0.085, 0.07])).abs() < 1e-15);
    }
}
