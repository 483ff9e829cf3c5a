//! `backlash_position`: play whose half gap depends on where the joint stands.
//!
//! The operator is that of [`super::backlash`]; the gap is looked up at the command. Parameters: half gaps of 0 or more at knots of
//! the position, at most 0.1 rad or 10 mm, joined by PCHIP ([`super::curve`]) and constant beyond; a curve that a measurement
//! fits as a polynomial is written as 41 knots. Action: local wear; an offset scheduled over position compensates it.

use super::backlash::play;
use super::common::*;
use super::curve::Pchip;
use super::site::within;
use super::{Backlash, effect};
use serde_yaml::{Mapping, Value};

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "backlash_position",
    heading: "backlash position",
    stage: Stage::Gear,
    family: Family::Gap,
    acts_on: ActsOn::Joint,
    adds: "backlash whose gap depends on the position of the joint",
    equation: "play operator, half gap interpolated over p by PCHIP, constant beyond the knots",
    reference: "Slamani, Nubiola, Bonev (2012), Robotica 30(7), for the polynomial; Fritsch, Carlson (1980) for PCHIP",
    parameters: &[("knots", "[[p_deg, half_gap_deg], ...], positions rising, gaps 0 to 0.1 rad (10 mm)")],
    confused_with: &["backlash"],
    decide_by: "reverse at five or more positions over the range",
    action: "local wear: replace the part, or work elsewhere in the range; an offset scheduled over position compensates it",
    undone: "an offset of half the local gap in the direction of travel",
    special: Special {
        after_reversal: AfterReversal::Step,
        includes: &["backlash"],
        imitates: &["backlash"],
        ..Special::NONE
    },
    example: (
        "{effect: backlash_position, joint: A1, knots: [[-20, 0.001], [0, 0.004], [20, 0.002]]}",
        View::JointOverCommand,
    ),
    read,
    typical,
    candidates,
};

/// Play with a half gap (rad or m, 0 or more) over position.
#[derive(Debug, Clone, PartialEq)]
pub struct BacklashPosition {
    /// Half gap over the position of the joint.
    pub half_gap: GapCurve,
}

/// Knots that stand for a polynomial in a file.
const KNOTS_OF_POLYNOMIAL: usize = 41;

impl BacklashPosition {
    /// A gap over position, or `backlash` where the curve is constant.
    pub fn or_constant(half_gap: GapCurve) -> Effect {
        match half_gap.constant() {
            Some(b) => Backlash::constant(b).into(),
            None => Self { half_gap }.into(),
        }
    }

    /// Knots `[position, half gap]` of the curve; a polynomial is sampled over its range, which PCHIP joins again.
    fn knots(&self) -> Vec<[f64; 2]> {
        match &self.half_gap {
            GapCurve::Pchip(p) => p.knots(),
            GapCurve::Polynomial { range: [lo, hi], .. } => {
                let last = (KNOTS_OF_POLYNOMIAL - 1) as f64;
                let places = (0..KNOTS_OF_POLYNOMIAL).map(|k| lo + (hi - lo) * k as f64 / last);
                places.map(|p| [p, self.half_gap.at(p)]).collect()
            }
            GapCurve::Constant(b) => vec![[0.0, *b], [1.0, *b]],
        }
    }
}

fn read(f: &mut Fields) -> Result<Effect> {
    let si = f.site().si_per_user_unit();
    let knots: Vec<[f64; 2]> = f.pairs("knots", "position, half gap")?.iter().map(|k| k.map(|v| v * si)).collect();
    match Pchip::new(&knots) {
        Some(p) if knots.iter().all(|k| k[1] >= 0.0) => Ok(BacklashPosition { half_gap: GapCurve::Pchip(p) }.into()),
        _ => Err(f.bad(
            "knots",
            "knots that cannot be joined",
            "two or more, positions strictly rising, gaps of 0 or more",
        )),
    }
}

fn typical(size: &TypicalSize) -> Vec<(String, Value)> {
    if size.has("knots") {
        return Vec::new();
    }
    let [lo, hi] = size.window;
    let knot = |p: f64, b: f64| Value::Sequence(vec![p.into(), b.into()]);
    let knots = vec![knot(lo, 0.6 * size.gap), knot(0.5 * (lo + hi), size.gap), knot(hi, 1.4 * size.gap)];
    vec![("knots".into(), Value::Sequence(knots))]
}

/// Counts of knots with which a gap over position is tried.
const KNOTS: &[usize] = &[3, 5, 8];

fn candidates(survey: &Survey, list: &mut Vec<Candidate>) {
    const SIZE: f64 = candidate::TRIAL;
    for axis in survey.moving() {
        let target = Target::Joint(axis);
        let [lo, hi] = survey.axes[axis].range;
        for &n in KNOTS {
            let places: Vec<f64> = (0..n).map(|k| lo + (hi - lo) * k as f64 / (n - 1) as f64).collect();
            let curve = move |gaps: &[f64]| -> Effect {
                let knots: Vec<[f64; 2]> = places.iter().zip(gaps).map(|(&p, &b)| [p, b.max(0.0)]).collect();
                match Pchip::new(&knots) {
                    Some(p) => BacklashPosition { half_gap: GapCurve::Pchip(p) }.into(),
                    // positions that cannot be distinguished
                    None => Backlash::constant(gaps.first().map_or(0.0, |b| b.max(0.0))).into(),
                }
            };
            let placed = |gaps: &[f64]| vec![EffectInstance::new(target, curve(gaps))];
            let raised = |k: usize| (0..n).map(|i| if i == k { 1.5 * SIZE } else { SIZE }).collect::<Vec<f64>>();
            let base = placed(&vec![SIZE; n]);
            if base.iter().any(|b| b.effect.nature() != Nature::GapOverPosition) {
                continue;
            }
            let trial = (0..n).map(|k| (placed(&raised(k)), 0.5 * SIZE)).collect();
            list.push(Candidate::of_sizes(survey.robot, target, &vec![SIZE; n], curve).beside(base, trial));
        }
    }
}

impl EffectType for BacklashPosition {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn nature(&self) -> Nature {
        Nature::GapOverPosition
    }

    fn values(&self) -> Vec<f64> {
        match &self.half_gap {
            GapCurve::Constant(b) => vec![*b],
            GapCurve::Polynomial { coefficients, .. } => coefficients.clone(),
            GapCurve::Pchip(p) => p.knots().iter().map(|k| k[1]).collect(),
        }
    }

    fn with(&self, v: &[f64]) -> Effect {
        let half_gap = match &self.half_gap {
            GapCurve::Constant(_) => GapCurve::Constant(v[0]),
            GapCurve::Polynomial { range, .. } => GapCurve::Polynomial { coefficients: v.to_vec(), range: *range },
            GapCurve::Pchip(p) => {
                let knots: Vec<[f64; 2]> = p.knots().iter().zip(v).map(|(k, b)| [k[0], *b]).collect();
                // the positions stay as they are; only a value that is no number can be refused
                Pchip::new(&knots).map_or_else(|| self.half_gap.clone(), GapCurve::Pchip)
            }
        };
        Self { half_gap }.into()
    }

    fn parameters(&self, site: &Site) -> Vec<Parameter> {
        let (si, typical) = (site.si_per_user_unit(), site.typical(0.003, 0.005));
        let gap = |key: String| Parameter::new(&key, 1.0 / si, (0.0, site.most_lost()), typical);
        match &self.half_gap {
            GapCurve::Constant(_) => vec![gap(site.key("half_gap"))],
            GapCurve::Polynomial { coefficients, .. } => (0..coefficients.len())
                .map(|k| {
                    let per_si = si.powi(k as i32) / si;
                    Parameter::new(&format!("coefficients[{k}]"), per_si, within(f64::MAX), typical)
                })
                .collect(),
            GapCurve::Pchip(p) => (0..p.knots().len()).map(|k| gap(format!("knots[{k}]"))).collect(),
        }
    }

    fn write(&self, site: &Site, entry: &mut Mapping) {
        let kind = site.kind();
        let knots = self.knots();
        let pair = |k: &[f64; 2]| Value::Sequence(k.iter().map(|&v| kind.to_user_unit(v).into()).collect());
        entry.insert("knots".into(), Value::Sequence(knots.iter().map(pair).collect()));
    }

    fn brief(&self, site: &Site) -> String {
        let largest = site.kind().to_user_unit(self.half_gap.largest());
        format!("largest half gap {} {}", effect::short(largest), site.unit())
    }

    fn apply(&self, track: &Track, signal: &mut [f64]) {
        play(track, signal, |i| self.half_gap.at(track.p[i]));
    }

    fn has_memory(&self) -> bool {
        true
    }

    fn is_play(&self) -> bool {
        true
    }

    fn half_gap(&self) -> Option<GapCurve> {
        Some(self.half_gap.clone())
    }

    /// Of a gap over position its change along the range.
    fn magnitude(&self) -> f64 {
        0.3 * self.half_gap.largest()
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        Undo::gap(self.half_gap.clone())
    }
}
