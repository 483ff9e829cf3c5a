//! What a change of the hypothesis does to the observations: its differences, for columns of the fit.

use super::*;
use crate::diagnose::problem::layout::Sensor;
use crate::effects::{Clock, Effect, EffectInstance, Stage, Target};
use crate::machine::{self, parts};

impl Problem {
    /// Adds to `out` what a change of an axis' position (`joint`, and `servo` where it moves the motor too; per row of
    /// `log`) does to the observations of that log.
    pub fn add_joint_change(
        &self,
        state: &State,
        log: usize,
        axis: usize,
        joint: &dyn Fn(usize) -> f64,
        servo: Option<&dyn Fn(usize) -> f64>,
        out: &mut [f64],
    ) {
        for g in self.groups_of(log) {
            match g.sensor {
                Sensor::Reflector(_) | Sensor::Reading | Sensor::Orientation => {
                    for (k, j) in state.logs[log].jacobian.iter().enumerate().filter(|(k, _)| g.sensor.sees(*k)) {
                        self.add_movement(g, k, out, |r| j[axis][r] * joint(r));
                    }
                }
                Sensor::Joint(a) if a == axis => g.add_numbers(out, joint),
                Sensor::Motor(a) if a == axis => {
                    if let Some(servo) = servo {
                        g.add_numbers(out, servo);
                    }
                }
                _ => {}
            }
        }
    }

    /// What replacing the effects `from` of the hypothesis by `to` changes in the prediction, divided by `scale`.
    pub fn difference(
        &self,
        h: &Hypothesis,
        state: &State,
        from: &[EffectInstance],
        to: &[EffectInstance],
        scale: f64,
    ) -> Vec<f64> {
        let mut out = vec![0.0; self.n];
        let per = 1.0 / scale;
        let axes: Vec<usize> = {
            let mut axes: Vec<usize> = from.iter().chain(to).filter_map(EffectInstance::axis).collect();
            axes.sort_unstable();
            axes.dedup();
            axes
        };
        for l in 0..self.logs.len() {
            for &axis in &axes {
                self.joint_difference(h, state, (l, axis), (from, to), per, &mut out);
            }
            self.tcp_difference(h, state, l, (from, to), per, &mut out);
        }
        out
    }

    fn joint_difference(
        &self,
        h: &Hypothesis,
        state: &State,
        (l, axis): (usize, usize),
        (from, to): (&[EffectInstance], &[EffectInstance]),
        per: f64,
        out: &mut [f64],
    ) {
        let log = &self.logs[l];
        let here = |list: &[EffectInstance], stages: &[Stage]| {
            list.iter().any(|p| p.axis() == Some(axis) && stages.contains(&p.effect.stage()))
        };
        let both = |stages: &[Stage]| here(from, stages) || here(to, stages);
        let rows = log.trajectory.rows();
        let mut change = vec![0.0; rows];
        let mut motor: Option<Vec<f64>> = None;
        if both(&[Stage::Servo, Stage::Gear]) {
            let after: Vec<Effect> =
                replaced(h, axis, from, to).into_iter().map(|e| e.in_log(l).unwrap_or_else(|| e.clone())).collect();
            let after: Vec<&Effect> = after.iter().collect();
            let initial_gap_side = self.initial_gap_side[axis];
            let driven = log.is_driven(axis);
            if !driven || both(&[Stage::Gear]) {
                let y = log.gear(axis, &behind_encoder(after.clone(), driven), initial_gap_side);
                for ((c, x), y) in change.iter_mut().zip(state.logs[l].gear[axis].iter()).zip(&y) {
                    *c = (y - x) * per;
                }
            }
            if both(&[Stage::Servo]) && self.groups_of(l).any(|g| g.sensor == Sensor::Motor(axis)) {
                let y = log.servo(axis, &after, initial_gap_side);
                motor = Some(state.logs[l].servo[axis].iter().zip(&y).map(|(x, y)| (y - x) * per).collect());
            }
        }
        if both(&[Stage::Link]) {
            let mut link = vec![0.0; rows];
            for p in from.iter().filter(|p| p.axis() == Some(axis) && p.effect.stage() == Stage::Link) {
                parts::add_link(&log.trajectory, p, &mut link);
            }
            link.iter_mut().for_each(|v| *v = -*v);
            for p in to.iter().filter(|p| p.axis() == Some(axis) && p.effect.stage() == Stage::Link) {
                parts::add_link(&log.trajectory, p, &mut link);
            }
            for (c, v) in change.iter_mut().zip(&link) {
                *c += v * per;
            }
        }
        let servo = motor.as_ref().map(|m| move |r: usize| m[r]);
        let servo = servo.as_ref().map(|f| f as &dyn Fn(usize) -> f64);
        self.add_joint_change(state, l, axis, &|r| change[r], servo, out);
    }

    fn tcp_difference(
        &self,
        h: &Hypothesis,
        state: &State,
        l: usize,
        (from, to): (&[EffectInstance], &[EffectInstance]),
        per: f64,
        out: &mut [f64],
    ) {
        let log = &self.logs[l];
        let has = |stage: Stage| from.iter().chain(to).any(|p| p.effect.stage() == stage);
        let s = &state.logs[l];
        if has(Stage::Geometry) {
            // `from` is part of the geometry now: `to` in its place
            let mut effects: Vec<EffectInstance> = Vec::new();
            effects.extend(to.iter().cloned());
            effects.extend(from.iter().map(negated));
            let other = machine::geometry(&state.geometry, &effects);
            for (k, chain) in self.chains(&other, log).iter().enumerate() {
                let (x, y) = (&s.chain_m[k], along(chain, &s.joint, log.trajectory.rows()));
                for g in self.groups_of(l).filter(|g| g.sensor.sees(k)) {
                    self.add_movement(g, k, out, |r| (y[r] - x[r]) * per);
                }
            }
        }
        if from.iter().chain(to).any(|p| p.effect.displaces()) {
            let columns: Vec<&[f64]> = s.joint.iter().map(|j| j.as_slice()).collect();
            let here = |list: &[EffectInstance]| -> Vec<EffectInstance> { list.iter().map(|p| in_log(p, l)).collect() };
            let (from, to) = (here(from), here(to));
            for (k, chain) in self.chains(&state.geometry, log).iter().enumerate() {
                let scene = self.scene(h, log, chain, &columns, Clock::default());
                let x = parts::displacements_m(&scene, &from, &s.points_m[k]);
                let y = parts::displacements_m(&scene, &to, &s.points_m[k]);
                for g in self.groups_of(l).filter(|g| g.sensor.sees(k)) {
                    self.add_movement(g, k, out, |r| (y[r] - x[r]) * per);
                }
            }
        }
        if has(Stage::Measurement) {
            let by = parts::clock(to).minus(&parts::clock(from));
            for g in self.groups_of(l) {
                match g.sensor {
                    Sensor::Reflector(_) | Sensor::Reading | Sensor::Orientation => {
                        // the state holds `from` already
                        for (k, x) in s.points_m.iter().enumerate().filter(|(k, _)| g.sensor.sees(*k)) {
                            let mut y = x.as_ref().clone();
                            parts::shift_in_time(&log.trajectory, by, &mut y);
                            self.add_movement(g, k, out, |r| (y[r] - x[r]) * per);
                        }
                    }
                    Sensor::Joint(a) => {
                        let x = &s.joint[a];
                        let y = parts::number_in_time(&log.trajectory, by, x);
                        g.add_numbers(out, |r| (y[r] - x[r]) * per);
                    }
                    Sensor::Motor(_) => {}
                }
            }
        }
    }
}

/// The effect that undoes a geometry or clock effect, to first order and beyond, as both are additive.
fn negated(p: &EffectInstance) -> EffectInstance {
    let values: Vec<f64> = p.effect.values().iter().map(|v| -v).collect();
    EffectInstance { target: p.target, effect: p.effect.with_values(&values) }
}

/// Effects of one joint where `from[k]` gives way to `to[k]`; what `to` has more stands after.
fn replaced<'a>(h: &'a Hypothesis, axis: usize, from: &[EffectInstance], to: &'a [EffectInstance]) -> Vec<&'a Effect> {
    let mut list = Vec::new();
    let mut done = vec![false; from.len()];
    for p in &h.effects {
        match (0..from.len()).find(|&k| !done[k] && from[k] == *p) {
            Some(k) => {
                done[k] = true;
                list.extend(to.get(k));
            }
            None => list.push(p),
        }
    }
    list.extend(to.iter().skip(from.len()));
    list.into_iter().filter(|p| p.target == Target::Joint(axis)).map(|p| &p.effect).collect()
}
