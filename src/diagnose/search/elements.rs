//! Several lost motions of one joint as the elements of one: generalized Maxwell slip.
//!
//! A loop that is rounded over more than one travel is found as one hysteresis, then as a second beside it. Elements that slip
//! one after another (Al-Bender, Lampaert, Swevers 2005) are one effect with as many values: a hysteresis gives the element of its
//! half width and presliding, a gap that of its size twice over (a play is one such element). As many, and up to two more spread over
//! the same travels, are refitted; where the best of them explain more than the effects apart, by BIC, they take their place; a further
//! hysteresis in a later round is a further element.

use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::search::Search;
use crate::diagnose::search::doubt::{BETTER, mark};
use crate::diagnose::search::finding::Step;
use crate::diagnose::search::fit::{self, Fit};
use crate::effects::{Backlash, EffectInstance, Hysteresis, MaxwellSlip, Target, hysteresis};
use crate::numerics::parallel::of_each;

/// The elements of a lost motion: half width and presliding travel, rad or m; `None` for any other effect.
fn elements_of(placed: &EffectInstance) -> Option<Vec<[f64; 2]>> {
    let effect = &placed.effect;
    if let Some(several) = effect.get::<MaxwellSlip>() {
        return Some(several.elements.clone());
    }
    if let Some(one) = effect.get::<Hysteresis>() {
        return Some(vec![[one.half_width, one.presliding]]);
    }
    effect.get::<Backlash>().map(|gap| vec![[gap.half_gap, gap.half_gap]])
}

/// Ratio of the preslidings of neighbours at least: closer ones are one element.
const APART: f64 = 1.1;

/// Elements that are tried beyond those that were found: an exponential loop is one of several straight ones.
const MORE: usize = 2;
/// The shortest and the longest presliding of a spread start, in parts of the shortest and the longest that were found.
const SPREAD: [f64; 2] = [0.5, 1.5];

/// What the elements of several may be together: themselves, preslidings rising, and as many and some more spread over their travels.
fn starts(target: Target, mut elements: Vec<[f64; 2]>) -> Vec<EffectInstance> {
    elements.retain(|e| e[0] > 0.0 && e[1] > 0.0);
    elements.sort_by(|a, b| a[1].total_cmp(&b[1]));
    let (Some(first), Some(last)) = (elements.first().map(|e| e[1]), elements.last().map(|e| e[1])) else {
        return Vec::new();
    };
    let width: f64 = elements.iter().map(|e| e[0]).sum();
    let spread = |count: usize| -> Vec<[f64; 2]> {
        let ratio = SPREAD[1] * last / (SPREAD[0] * first);
        let at = |k: usize| SPREAD[0] * first * ratio.powf(k as f64 / (count - 1) as f64);
        (0..count).map(|k| [width / count as f64, at(k)]).collect()
    };
    let found = elements.len();
    let more = (found.max(2)..=found + MORE).map(spread);
    let apart = |e: &Vec<[f64; 2]>| e.windows(2).all(|w| w[1][1] > APART * w[0][1]);
    let several = |e: &Vec<[f64; 2]>| e.len() > 1 && e.len() <= MaxwellSlip::MOST && apart(e);
    let all = std::iter::once(elements).chain(more).filter(several);
    all.map(|elements| EffectInstance::new(target, MaxwellSlip { elements })).collect()
}

impl Search<'_> {
    /// Puts one effect of several elements in the place of the lost motions of a joint, where it explains more.
    pub(in crate::diagnose) fn as_elements(&self, fit: Fit, whitening: &Whitening, steps: &mut Vec<Step>) -> Fit {
        let of = |f: &Fit, k: usize| f.hypothesis.effects[f.free[k]].clone();
        let axes = 0..self.problem.robot.dof();
        axes.fold(fit, |fit, axis| {
            let target = Target::Joint(axis);
            let own: Vec<usize> = (0..fit.free.len())
                .filter(|&k| of(&fit, k).target == target && elements_of(&of(&fit, k)).is_some())
                .collect();
            let wound = own.iter().any(|&k| of(&fit, k).effect.get::<Hysteresis>().is_some());
            if own.len() < 2 || !wound {
                return fit;
            }
            let elements = own.iter().filter_map(|&k| elements_of(&of(&fit, k))).flatten().collect();
            let worth = |f: &Fit| f.cost + self.price * values(f) as f64;
            let tried = starts(target, elements);
            let tried: Vec<Fit> = of_each(tried, |one| self.in_place_of_all(&fit, &own, one, whitening));
            let sound = |f: &Fit| f.hypothesis.effects.last().is_some_and(|e| rising(&e.effect));
            let Some(next) = tried.into_iter().filter(sound).min_by(|a, b| worth(a).total_cmp(&worth(b))) else {
                return fit;
            };
            if worth(&next) > worth(&fit) - BETTER {
                return fit;
            }
            let name = (hysteresis::INFO.name, target.text(&self.problem.robot));
            for &k in &own {
                let old = of(&fit, k).effect.name();
                mark(steps, &(old, name.1.clone()), &format!("{} {}, as an element of it", name.0, name.1));
            }
            steps.push(Step::new(name.0, name.1));
            next
        })
    }

    /// A fit with one effect in the place of several; it stands last.
    fn in_place_of_all(&self, fit: &Fit, gone: &[usize], one: EffectInstance, whitening: &Whitening) -> Fit {
        let mut h = fit.hypothesis.clone();
        for &k in gone.iter().rev() {
            h.effects.remove(fit.free[k]);
        }
        h.effects.push(fit::inside(&one, self.problem));
        let free: Vec<usize> = (self.known..h.effects.len()).collect();
        fit::refit(self.problem, &h, &free, whitening)
    }
}

/// Elements that a model file can hold: each of some width, each over a longer travel than the one before.
fn rising(effect: &crate::effects::Effect) -> bool {
    effect.get::<MaxwellSlip>().is_some_and(|m| {
        m.elements.iter().all(|e| e[0] > 0.0) && m.elements.windows(2).all(|w| w[1][1] > w[0][1] * (1.0 + 1e-9))
    })
}

/// Values of the free effects.
fn values(fit: &Fit) -> usize {
    fit.free.iter().map(|&i| fit.hypothesis.effects[i].effect.values().len()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_stand_in_the_order_of_their_travel_and_two_of_one_travel_are_none() {
        let on = |e: crate::effects::Effect| EffectInstance::on_axis(1, e);
        let wide = on(Hysteresis { half_width: 2e-5, presliding: 3e-2 }.into());
        let gap = on(Backlash::constant(4e-5).into());
        let all: Vec<[f64; 2]> = [&wide, &gap].into_iter().filter_map(elements_of).flatten().collect();
        let one = starts(Target::Joint(1), all);
        let elements = &one[0].effect.get::<MaxwellSlip>().unwrap().elements;
        assert_eq!(elements, &[[4e-5, 4e-5], [2e-5, 3e-2]]);
        let counts: Vec<usize> = one.iter().map(|p| p.effect.values().len() / 2).collect();
        assert_eq!(counts, [2, 2, 3, 4]);
        let width =
            |p: &EffectInstance| p.effect.get::<MaxwellSlip>().unwrap().elements.iter().map(|e| e[0]).sum::<f64>();
        assert!(one.iter().all(|p| (width(p) - 6e-5).abs() < 1e-15));
        // preslidings that are one: as they stand they are no start
        let counts = starts(Target::Joint(1), vec![[1e-5, 1e-3], [2e-5, 1.05e-3]]).len();
        assert_eq!(counts, 3);
    }

    #[test]
    fn a_gap_is_an_element_of_its_own_size() {
        let p: Vec<f64> = (0..400).map(|k| (f64::from(k) * 0.05).sin() * 1e-3).collect();
        let t: Vec<f64> = (0..400).map(f64::from).collect();
        let track = crate::effects::Track::new(&t, &p, 0.0);
        let (mut play, mut element) = (p.clone(), p.clone());
        crate::effects::Effect::new(Backlash::constant(3e-4)).apply(&track, &mut play);
        crate::effects::Effect::new(MaxwellSlip { elements: vec![[3e-4, 3e-4]] }).apply(&track, &mut element);
        assert!(play.iter().zip(&element).all(|(a, b)| (a - b).abs() < 1e-15));
    }
}
