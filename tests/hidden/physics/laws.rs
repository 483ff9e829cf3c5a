//! What servo and gear do to the positions of one joint, step by step: lag, stiction, plays, lost motion.

use super::{LOADS, STEP_S};

/// A step of the command smaller than this is rest (rad or m): a hundredth of what a log resolves.
const REST: f64 = 1e-10;

/// Play whose flank a load above `most` picks; else the movement does.
pub(super) fn loaded_play(q: &mut [f64], load: &[f64], half_gap: f64, most: f64) {
    let mut out = q[0];
    for (k, p) in q.iter_mut().enumerate() {
        let (at, u) = (k / LOADS, (k % LOADS) as f64 / LOADS as f64);
        let load = load[at] + (load[(at + 1).min(load.len() - 1)] - load[at]) * u;
        out = match () {
            () if load > most => *p + half_gap,
            () if load < -most => *p - half_gap,
            () => out.clamp(*p - half_gap, *p + half_gap),
        };
        *p = out;
    }
}

/// First-order lag of a command that is linear within a step; exact for that.
pub(super) fn lag(q: &mut [f64], lag_s: f64) {
    if lag_s == 0.0 {
        return;
    }
    let decay = (-STEP_S / lag_s).exp();
    let (mut out, mut before) = (q[0], q[0]);
    for p in q.iter_mut() {
        let slope = (*p - before) / STEP_S;
        // Steady solution p - lag*slope; the rest decays.
        out = (*p - lag_s * slope) + (out - (before - lag_s * slope)) * decay;
        before = *p;
        *p = out;
    }
}

/// The joint stands still after a reversal until the command has moved as far as the error that the servo has not worked off.
pub(super) fn stiction(q: &mut [f64], spike: f64, decay_s: f64, decay_travel: f64) {
    let (mut dir, mut turned) = (0.0, None);
    let (mut before, mut travel) = (q[0], 0.0);
    for (k, out) in q.iter_mut().enumerate() {
        let p = *out;
        let step = p - before;
        if step.abs() > REST {
            if dir * step < 0.0 {
                turned = Some((before, k as f64 - 1.0));
                travel = 0.0;
            }
            dir = step.signum();
        }
        travel += step.abs();
        before = p;
        if let Some((p_rev, k_rev)) = turned {
            let left = if decay_s > 0.0 {
                (-(k as f64 - k_rev) * STEP_S / decay_s).exp()
            } else {
                (-travel / decay_travel.max(1e-12)).exp()
            };
            *out = p - dir * (spike * left).min((p - p_rev).abs());
        }
    }
}

/// The play operator, starting in the middle of its gap.
pub(super) fn play(q: &mut [f64], half_gap: impl Fn(usize, f64) -> f64) {
    let mut out = q[0];
    for (k, p) in q.iter_mut().enumerate() {
        let b = half_gap(k, *p).max(0.0);
        out = out.clamp(*p - b, *p + b);
        *p = out;
    }
}

/// Dahl's lost motion; exact for a command that is monotone within a step.
pub(super) fn hysteresis(q: &mut [f64], half_width: f64, presliding: f64) {
    let (mut z, mut before) = (0.0f64, q[0]);
    for p in q.iter_mut() {
        let step = *p - before;
        before = *p;
        if step != 0.0 {
            let dir = step.signum();
            z = dir + (z - dir) * (-step.abs() / presliding.max(1e-12)).exp();
        }
        *p -= half_width * z;
    }
}

/// Lost motion of elements (presliding, half width): each follows a play of its presliding and gives its part of the distance to it.
pub(super) fn elements(q: &mut [f64], all: &[[f64; 2]]) {
    let mut outputs = vec![q[0]; all.len()];
    for p in q.iter_mut() {
        let command = *p;
        for (out, [presliding, half_width]) in outputs.iter_mut().zip(all) {
            *out = out.clamp(command - presliding, command + presliding);
            *p -= half_width * (command - *out) / presliding;
        }
    }
}
