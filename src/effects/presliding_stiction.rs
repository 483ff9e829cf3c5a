//! `stiction` with a rise: the error after a reversal builds up over presliding, then the servo works it off.
//!
//! The friction that holds the joint turns over as bristles bend (LuGre: Canudas de Wit et al. 1995; Dahl 1968), and a servo with an
//! integrating position loop answers it as a high-pass filter does. With `z` the friction over its level,
//!
//! ```text
//! dz = (dir - z) dr,   de = -(spike_dir / 2) dz - e dd,
//! ```
//!
//! where `dr` is the time or travel that passed over `rise_s` or `rise_deg`, and `dd` the same over `decay_s` or `decay_deg`. Where
//! the rise is short, `e` jumps by `-dir * spike` at a reversal and fades, as in [`super::stiction`]; reversals that follow each
//! other before the error has faded add up. `spike_dir` is the size after a reversal into direction `dir`, times
//! `1 + per_nm * |torque of gravity|`. Nothing before the first reversal.
//!
//! Method: both equations are solved exactly between samples, with time and travel in proportion:
//! `e1 = e0 exp(-b) + (spike/2) (z0 - dir) a (exp(-a) - exp(-b)) / (b - a)` for `a = dr`, `b = dd`.
//!
//! Parameters: spikes 0 or more, at most 0.1 rad (10 mm), and no larger than a rise over travel: else the joint would turn back;
//! rise 1 ms to 10 s, and in a fit no longer than the decay: with another size, both exchanged are the same response.
//! Typical: 0.0005 to 0.005 deg, rise 0.1 to 0.7 s, decay 0.3 to 5 s. `rewrite` undoes the plain spike.

use super::common::*;
use super::stiction;

/// How the catalogue describes this form.
pub static FORM: EffectForm = EffectForm {
    of: &stiction::INFO,
    name: "stiction_rise",
    heading: "that builds up",
    equation: "dz = (dir - z) dr, de = -(spike_dir / 2) dz - e dd, r and d the time or travel over rise and decay",
    reference: "Canudas de Wit, Olsson, Astrom, Lischinsky (1995), IEEE Trans. Automatic Control 40(3); Dahl (1968)",
    typical: "0.0005 to 0.005 deg, rise 0.1 to 0.7 s, decay 0.3 to 5 s",
    example: ("{effect: stiction, joint: A1, spike_deg: 0.003, rise_s: 0.3, decay_s: 2}", View::JointOverTime),
    diagnosis: "tries it where the plain ones leave something, in one size, in one for each direction, and growing with load",
    undone: "the plain spike",
};

/// Spikes after reversals into the positive and into the negative direction, rad or m; what builds up and fades; growth with load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PreslidingStiction {
    /// Spike after a reversal into the positive and into the negative direction, rad or m.
    pub spike: [f64; 2],
    /// One size for both directions.
    pub symmetric: bool,
    /// How the spike builds up.
    pub rise: Decay,
    /// How it decays.
    pub decay: Decay,
    /// Relative growth of the spike per Nm (N) of gravity's torque; `None`: none.
    pub per_nm: Option<f64>,
}

/// Reads the keys beside the spike, the rise and the decay that are known.
pub(super) fn read(f: &mut Fields, rise: Option<Decay>, decay: Decay) -> Result<Effect> {
    let site = f.site();
    let si = site.si_per_user_unit();
    let both = f.number(&site.key("spike"), 0.0)?;
    let each = [f.number(&site.key("spike_positive"), 0.0)?, f.number(&site.key("spike_negative"), 0.0)?];
    let spike = match (both, each) {
        (Some(s), [None, None]) => [s, s],
        (None, [Some(positive), Some(negative)]) => [positive, negative],
        _ => {
            let (one, two) = (site.key("spike"), [site.key("spike_positive"), site.key("spike_negative")]);
            let expected = format!("either `{one}` or both `{}` and `{}`", two[0], two[1]);
            return Err(f.bad("spike", "no size, or too many", &expected));
        }
    };
    let per_nm = f.number("per_nm", 0.0)?;
    let spike = spike.map(|s| s * si);
    // without a rise the joint stands still at first: the error builds up as fast as the command moves
    let rise = rise.unwrap_or(Decay::Travel(spike[0].max(spike[1]).max(f64::MIN_POSITIVE)));
    Ok(PreslidingStiction { spike, symmetric: both.is_some(), rise, decay, per_nm }.into())
}

fn amount(d: &Decay) -> f64 {
    let (Decay::Time(x) | Decay::Travel(x)) = d;
    *x
}

fn of_form(form: &Decay, x: f64) -> Decay {
    match form {
        Decay::Time(_) => Decay::Time(x),
        Decay::Travel(_) => Decay::Travel(x),
    }
}

/// How much of a rise or a decay passes in a time and a travel.
fn passed(d: &Decay, seconds: f64, travel: f64) -> f64 {
    match d {
        Decay::Time(s) => seconds / s,
        Decay::Travel(x) => travel / x,
    }
}

/// `a (exp(-a) - exp(-b)) / (b - a)`, also where the two are equal.
fn built_up(a: f64, b: f64) -> f64 {
    if (b - a).abs() < 1e-6 * (1.0 + a) {
        // the limit, to second order in the difference
        return a * (-0.5 * (a + b)).exp();
    }
    a * ((-a).exp() - (-b).exp()) / (b - a)
}

/// Ratio of neighbouring rises over travel and decays that are tried.
const NEXT_RISE: f64 = 3.0;
const NEXT_DECAY: f64 = 2.5;
/// Number of rises over travel, and rises over time, s, that are tried with each decay.
const RISES: usize = 4;
const RISES_S: [f64; 3] = [0.1, 0.3, 0.9];
/// Relative growths of a spike from no load to the largest that are tried.
const GROWTHS: [f64; 2] = [0.5, 2.5];

pub(super) fn further(survey: &Survey, list: &mut Vec<Candidate>) {
    let Some((step, length)) = survey.clock else { return };
    for axis in survey.moving() {
        let over_travel = survey.travels(axis, NEXT_RISE).into_iter().take(RISES).map(Decay::Travel);
        let over_time = RISES_S.iter().filter(|s| **s > step).map(|s| Decay::Time(*s));
        let rises: Vec<Decay> = over_travel.chain(over_time).collect();
        let decays = std::iter::successors(Some(step.max(0.1)), |d| Some(d * NEXT_DECAY));
        for decay in decays.take_while(|d| *d < (0.5 * length).min(20.0)).map(Decay::Time) {
            for &rise in rises.iter().filter(|rise| is_shorter(rise, &decay)) {
                push_forms(survey, axis, (rise, decay), list);
            }
        }
    }
}

/// Is a rise shorter than a decay of its kind? The two exchanged, with another size, are the same response.
fn is_shorter(rise: &Decay, decay: &Decay) -> bool {
    std::mem::discriminant(rise) != std::mem::discriminant(decay) || amount(rise) < amount(decay)
}

/// One size, one that grows with load, and one for each direction, with this rise and decay.
fn push_forms(survey: &Survey, axis: usize, (rise, decay): (Decay, Decay), list: &mut Vec<Candidate>) {
    let (robot, target) = (survey.robot, Target::Joint(axis));
    let of = move |spike: [f64; 2], symmetric, per_nm| PreslidingStiction { spike, symmetric, rise, decay, per_nm };
    let [plain, loaded, sided] = match rise {
        Decay::Travel(_) => ["rise", "rise, with load", "rise, both ways"],
        Decay::Time(_) => ["rise over time", "rise over time, with load", "rise over time, both ways"],
    };
    let sized = |per_nm: Option<f64>| {
        let one = move |s: f64| of([s, s], true, per_nm);
        Candidate::of_size(robot, target, candidate::TRIAL, one).positive()
    };
    list.push(sized(None).with_shape(2).with_form(plain));
    if survey.axes[axis].loaded {
        let grown = GROWTHS.iter().map(|g| sized(Some(g / survey.axes[axis].load)));
        list.extend(grown.map(|c| c.with_shape(3).with_form(loaded)));
    }
    let each = move |s: &[f64]| of([s[0].max(0.0), s[1].max(0.0)], false, None);
    let each = Candidate::of_sizes(robot, target, &[candidate::TRIAL; 2], each).positive();
    list.push(each.with_shape(2).with_form(sided));
}

impl PreslidingStiction {
    fn size(&self, dir: i8, load: f64) -> f64 {
        let spike = if dir > 0 { self.spike[0] } else { self.spike[1] };
        spike * (1.0 + self.per_nm.unwrap_or(0.0) * load.abs())
    }
}

impl EffectType for PreslidingStiction {
    fn info(&self) -> &'static EffectInfo {
        &stiction::INFO
    }

    fn nature(&self) -> Nature {
        Nature::Presliding
    }

    /// Spike or spikes, rise, decay, growth with load.
    fn values(&self) -> Vec<f64> {
        let spikes = if self.symmetric { &self.spike[..1] } else { &self.spike[..] };
        spikes.iter().copied().chain([amount(&self.rise), amount(&self.decay)]).chain(self.per_nm).collect()
    }

    fn with(&self, v: &[f64]) -> Effect {
        let (spike, rest) = if self.symmetric { ([v[0], v[0]], &v[1..]) } else { ([v[0], v[1]], &v[2..]) };
        let per_nm = self.per_nm.map(|_| rest[2]);
        let (rise, decay) = (of_form(&self.rise, rest[0]), of_form(&self.decay, rest[1]));
        Self { spike, rise, decay, per_nm, ..*self }.into()
    }

    fn parameters(&self, site: &Site) -> Vec<Parameter> {
        let most = match self.rise {
            Decay::Travel(x) => site.most_lost().min(x),
            Decay::Time(_) => site.most_lost(),
        };
        let spike = |name: &str| site.length(name, (0.0, most), site.typical(0.003, 0.005));
        let mut all = match self.symmetric {
            true => vec![spike("spike")],
            false => vec![spike("spike_positive"), spike("spike_negative")],
        };
        let largest = self.spike[0].max(self.spike[1]);
        all.push(match self.rise {
            Decay::Time(_) => {
                // beyond the decay it would be the same response with both exchanged
                let most = if let Decay::Time(decay) = self.decay { decay.clamp(1e-3, 10.0) } else { 10.0 };
                Parameter::seconds("rise_s", (1e-3, most), 0.3)
            }
            Decay::Travel(_) => {
                let (least, most) = site.travel_bounds();
                site.length("rise", (least.max(largest), most), site.typical(0.02, 0.02))
            }
        });
        all.push(match self.decay {
            Decay::Time(_) => Parameter::seconds("decay_s", (1e-3, 1e3), 1.5),
            Decay::Travel(_) => site.length("decay", site.travel_bounds(), site.typical(0.5, 0.5)),
        });
        all.extend(self.per_nm.map(|_| Parameter::new("per_nm", 1.0, (0.0, 1.0), 1e-3)));
        all
    }

    fn apply(&self, track: &Track, signal: &mut [f64]) {
        let Some(first) = track.turns.first() else { return };
        // the friction is turned over before the first reversal
        let mut z = -f64::from(first.dir);
        let mut e = 0.0;
        for i in first.index + 1..track.len() {
            let dir = track.dir[i];
            let seconds = track.t_s[i] - track.t_s[i - 1];
            let travel = (track.p[i] - track.p[i - 1]).abs();
            let (a, b) = (passed(&self.rise, seconds, travel), passed(&self.decay, seconds, travel));
            let spike = self.size(dir, track.load_at(i));
            let side = f64::from(dir);
            e = e * (-b).exp() + 0.5 * spike * (z - side) * built_up(a, b);
            z = side + (z - side) * (-a).exp();
            signal[i] += e;
        }
    }

    fn has_memory(&self) -> bool {
        true
    }

    fn is_wider(&self) -> bool {
        true
    }

    fn is_sampled(&self, step_s: f64) -> bool {
        match (self.rise, self.decay) {
            (Decay::Time(rise), Decay::Time(decay)) => rise > 0.5 * step_s && rise < 0.99 * decay,
            (Decay::Time(rise), Decay::Travel(_)) => rise > 0.5 * step_s,
            // the shortest travel is that over which the joint stands still
            (Decay::Travel(_), _) => true,
        }
    }

    fn plainer(&self) -> Option<Effect> {
        if self.per_nm.is_some() {
            return Some(Self { per_nm: None, ..*self }.into());
        }
        let spike = 0.5 * (self.spike[0] + self.spike[1]);
        (!self.symmetric).then(|| Self { spike: [spike; 2], symmetric: true, ..*self }.into())
    }

    fn uses_load(&self) -> bool {
        self.per_nm.is_some()
    }

    fn largest_after_reversal(&self) -> Option<f64> {
        Some(self.spike[0].max(self.spike[1]))
    }

    fn transition(&self) -> Option<f64> {
        match (self.rise, self.decay) {
            (Decay::Travel(x), _) | (_, Decay::Travel(x)) => Some(x),
            _ => self.largest_after_reversal().map(|b| 2.0 * b),
        }
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        let spike = 0.5 * (self.spike[0] + self.spike[1]);
        let left = "its mean spike is compensated as if it stood there at once: its rise, direction and load are not";
        Undo { friction: Some((spike, self.decay)), left: Some(left), ..Undo::default() }
    }
}
