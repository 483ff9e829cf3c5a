//! `hysteresis` with `elements`: generalized Maxwell slip.
//!
//! Elastic elements in parallel, each of which slips once it is wound up: `-sum half_width_i z_i`, where `z_i` follows the
//! arriving signal at `1/presliding_i` per unit and stops at -1 and +1 (the stop operator). After a reversal element `i` has
//! turned over after a travel of twice its presliding: several give any rounded loop, with the non-local memory that a single
//! Dahl element lacks. Reference: Iwan (1966), J. Applied Mechanics 33(4); Al-Bender, Lampaert, Swevers (2005), IEEE Trans.
//! Automatic Control 50(11).
//!
//! Parameters: 1 to 8 elements `[half_width, presliding]`, widths 0 or more, at most 0.1 rad (10 mm) each, preslidings rising and
//! above 0; typical 2 to 4 elements. Start: `z = 0`, or the initial side of the gap. Exact between samples (the signal is straight
//! there). A play is one element whose presliding is its half width. A diagnosis puts it in the place of several lost motions of one
//! joint ([`crate::diagnose::search`]). An offset of the sum of the widths in the direction of travel undoes most of it.

use super::common::*;
use super::hysteresis;
use serde_yaml::{Mapping, Value};

/// How the catalogue describes this form.
pub static FORM: EffectForm = EffectForm {
    of: &hysteresis::INFO,
    name: "hysteresis_elements",
    heading: "of several elements",
    equation: "-sum half_width_i z_i, dz_i = dp/presliding_i within -1 and +1 (generalized Maxwell slip)",
    reference: "Iwan (1966), J. Applied Mechanics 33(4); Al-Bender, Lampaert, Swevers (2005), IEEE Trans. Automatic Control 50(11)",
    typical: "2 to 4 elements, 0.0005 to 0.005 deg each, presliding 0.01 to 5 deg",
    example: (
        "{effect: hysteresis, joint: A1, elements: [[0.002, 0.3], [0.002, 2], [0.001, 8]]}",
        View::JointOverCommand,
    ),
    diagnosis: "puts it in the place of several lost motions of one joint (hysteresis, gap), where it explains more by BIC; each further hysteresis that a round finds there is a further element",
    undone: "an offset of the sum of the half widths in the direction of travel",
};

/// Elements `[half width, presliding]`, rad or m.
#[derive(Debug, Clone, PartialEq)]
pub struct MaxwellSlip {
    /// Half width and presliding travel of each element, rad or m.
    pub elements: Vec<[f64; 2]>,
}

pub(super) fn read(f: &mut Fields) -> Result<Effect> {
    let si = f.site().si_per_user_unit();
    let elements = f.pairs("elements", "half width, presliding")?;
    let sound = elements.iter().all(|e| e[0] >= 0.0 && e[1] > 0.0 && e.iter().all(|v| v.is_finite()));
    let rising = elements.windows(2).all(|w| w[0][1] < w[1][1]);
    if elements.is_empty() || elements.len() > MaxwellSlip::MOST || !sound || !rising {
        let expected =
            "1 to 8 elements `[half width, presliding]`: widths of 0 or more, preslidings above 0 and rising";
        return Err(f.bad("elements", "elements that are none", expected));
    }
    Ok(MaxwellSlip { elements: elements.iter().map(|e| e.map(|v| v * si)).collect() }.into())
}

impl MaxwellSlip {
    /// Elements at most: more than a log can tell.
    pub const MOST: usize = 8;

    fn sum(&self) -> f64 {
        self.elements.iter().map(|e| e[0]).sum()
    }
}

impl EffectType for MaxwellSlip {
    fn info(&self) -> &'static EffectInfo {
        &hysteresis::INFO
    }

    fn nature(&self) -> Nature {
        Nature::WindUp
    }

    /// Width and presliding of each element, one after the other.
    fn values(&self) -> Vec<f64> {
        self.elements.concat()
    }

    fn with(&self, v: &[f64]) -> Effect {
        Self { elements: v.chunks_exact(2).map(|e| [e[0], e[1]]).collect() }.into()
    }

    /// A presliding stays between its neighbours.
    fn parameters(&self, site: &Site) -> Vec<Parameter> {
        let per_si = 1.0 / site.si_per_user_unit();
        let (shortest, longest) = site.travel_bounds();
        let between = |a: f64, b: f64| (a * b).sqrt();
        let mut all = Vec::new();
        for (k, e) in self.elements.iter().enumerate() {
            let least = if k == 0 { shortest } else { between(self.elements[k - 1][1], e[1]) };
            let most = self.elements.get(k + 1).map_or(longest, |next| between(e[1], next[1]));
            let width = (0.0, site.most_lost());
            all.push(Parameter::new(&format!("elements[{k}][0]"), per_si, width, site.typical(0.002, 0.003)));
            all.push(Parameter::new(&format!("elements[{k}][1]"), per_si, (least, most), e[1]));
        }
        all
    }

    fn write(&self, site: &Site, entry: &mut Mapping) {
        let kind = site.kind();
        let pair = |e: &[f64; 2]| Value::Sequence(e.iter().map(|&v| kind.to_user_unit(v).into()).collect());
        entry.insert("elements".into(), Value::Sequence(self.elements.iter().map(pair).collect()));
    }

    fn apply(&self, track: &Track, signal: &mut [f64]) {
        let Some(&first) = signal.first() else { return };
        let mut z = vec![f64::from(track.initial_gap_side); self.elements.len()];
        let mut before = first;
        for s in signal {
            let step = *s - before;
            before = *s;
            for (z, [width, presliding]) in z.iter_mut().zip(&self.elements) {
                *z = (*z + step / presliding).clamp(-1.0, 1.0);
                *s -= width * *z;
            }
        }
    }

    fn has_memory(&self) -> bool {
        true
    }

    /// A stroke longer than the transition loses as much.
    fn half_gap(&self) -> Option<GapCurve> {
        Some(GapCurve::Constant(self.sum()))
    }

    fn transition(&self) -> Option<f64> {
        self.elements.last().map(|e| 2.0 * e[1])
    }

    fn magnitude(&self) -> f64 {
        self.sum()
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        let left = "the sum of its half widths is compensated, its transition is not";
        Undo { left: Some(left), ..Undo::gap(GapCurve::Constant(self.sum())) }
    }
}
