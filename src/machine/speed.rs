//! Speed of the commanded TCP.
//!
//! Method: derivative of the TCP's path by differences of second order over neighbouring samples (one-sided at the ends), then
//! its length.

use crate::numerics::parallel;
use crate::robot::Chain;
use nalgebra::Vector3;

/// Samples that one thread takes at a time.
const BLOCK: usize = 4096;

/// Speed at each sample, m/s; `q(axis, i)` is the command in rad or m.
pub fn along(chain: &Chain, t_s: &[f64], q: impl Fn(usize, usize) -> f64 + Sync) -> Vec<f64> {
    let n = t_s.len();
    let blocks = parallel::map_awaited(n.div_ceil(BLOCK), |b| -> Vec<Vector3<f64>> {
        let mut joints = vec![0.0; chain.dof()];
        let at = |i: usize| {
            for (axis, v) in joints.iter_mut().enumerate() {
                *v = q(axis, i);
            }
            chain.position(&joints)
        };
        (b * BLOCK..((b + 1) * BLOCK).min(n)).map(at).collect()
    });
    let path: Vec<Vector3<f64>> = blocks.concat();
    let step = |i: usize| {
        let h = t_s[i + 1] - t_s[i];
        if h > 0.0 { (path[i + 1] - path[i]) / h } else { Vector3::zeros() }
    };
    (0..n)
        .map(|i| {
            if n < 2 {
                return 0.0;
            }
            if i == 0 || i + 1 == n {
                return step(i.min(n - 2)).norm();
            }
            let (h0, h1) = (t_s[i] - t_s[i - 1], t_s[i + 1] - t_s[i]);
            if h0 + h1 > 0.0 { ((step(i - 1) * h1 + step(i) * h0) / (h0 + h1)).norm() } else { 0.0 }
        })
        .collect()
}

/// Speeds at the samples `t_s`, of which `places` have those of `known`; straight in time between them.
pub fn between(known: &[f64], places: &[u32], t_s: &[f64]) -> Vec<f64> {
    let mut all = Vec::with_capacity(t_s.len());
    let mut k = 0;
    for (i, &t) in t_s.iter().enumerate() {
        while k + 1 < places.len() && places[k + 1] as usize <= i {
            k += 1;
        }
        let (Some(&v), Some(&at)) = (known.get(k), places.get(k)) else {
            all.push(0.0);
            continue;
        };
        match (known.get(k + 1), places.get(k + 1)) {
            (Some(&next), Some(&to)) if i > at as usize => {
                let (t0, t1) = (t_s[at as usize], t_s[to as usize]);
                all.push(if t1 > t0 { v + (next - v) * ((t - t0) / (t1 - t0)) } else { v });
            }
            _ => all.push(v),
        }
    }
    all
}
