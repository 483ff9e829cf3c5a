//! Measurement noise: white plus first-order autoregressive, outliers, lost rows; and its whitening.

use nalgebra::{DMatrix, DVector, Vector3};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde_json::{Value, json};

/// What `truth.json` calls `noise`.
#[derive(Clone, Debug)]
pub struct Noise {
    pub sigma_um: f64,
    pub ar1: f64,
    /// Share of the variance that is autoregressive.
    pub ar_share: f64,
    pub outlier_share: f64,
    pub dropout_share: f64,
    pub missing_rows: usize,
    pub round_um: f64,
}

/// Rows that are outliers and by how much (m), rows with empty cells, rows that are missing.
pub struct Spoiled {
    pub outliers: Vec<(usize, Vector3<f64>)>,
    pub empty: Vec<bool>,
    pub missing: Vec<bool>,
}

impl Noise {
    pub fn draw(rng: &mut ChaCha8Rng) -> Noise {
        let cut = |v: f64| format!("{v:.3e}").parse().unwrap_or(v);
        Noise {
            sigma_um: cut(rng.random_range(5.0..15.0)),
            ar1: if rng.random_bool(0.15) { 0.0 } else { cut(rng.random_range(0.2..0.75)) },
            ar_share: cut(rng.random_range(0.2..0.85)),
            outlier_share: if rng.random_bool(0.3) { cut(rng.random_range(0.001..0.01)) } else { 0.0 },
            dropout_share: if rng.random_bool(0.4) { cut(rng.random_range(0.005..0.02)) } else { 0.0 },
            missing_rows: if rng.random_bool(0.25) { rng.random_range(2..7) } else { 0 },
            round_um: if rng.random_bool(0.2) { 1.0 } else { 0.0 },
        }
    }

    /// One course of noise per coordinate (m), without outliers.
    pub fn course(&self, rows: usize, rng: &mut ChaCha8Rng) -> Vec<Vector3<f64>> {
        let sigma = self.sigma_um * 1e-6;
        let (white, slow) = (sigma * (1.0 - self.ar_share).sqrt(), sigma * self.ar_share.sqrt());
        let innovation = slow * (1.0 - self.ar1 * self.ar1).sqrt();
        let mut normal = || Vector3::from_fn(|_, _| rng.sample::<f64, _>(StandardNormal));
        let mut x = normal() * slow;
        (0..rows)
            .map(|k| {
                if k > 0 {
                    x = x * self.ar1 + normal() * innovation;
                }
                x + normal() * white
            })
            .collect()
    }

    /// Draws what is wrong with the rows.
    pub fn spoil(&self, rows: usize, rng: &mut ChaCha8Rng) -> Spoiled {
        let mut outliers = Vec::new();
        for k in 0..rows {
            if rng.random_bool(self.outlier_share) {
                let size = self.sigma_um * 1e-6 * rng.random_range(8.0..40.0);
                let d = Vector3::from_fn(|_, _| rng.sample::<f64, _>(StandardNormal)).normalize();
                outliers.push((k, d * size));
            }
        }
        let (mut empty, mut missing) = (vec![false; rows], vec![false; rows]);
        let mut left = (self.dropout_share * rows as f64) as usize;
        while left > 0 {
            let (k, n) = (rng.random_range(1..rows), rng.random_range(1..=left.min(12)));
            empty[k..(k + n).min(rows)].fill(true);
            left -= n;
        }
        for _ in 0..self.missing_rows {
            missing[rng.random_range(1..rows - 1)] = true;
        }
        Spoiled { outliers, empty, missing }
    }

    pub fn json(&self) -> Value {
        json!({"sigma_um": self.sigma_um, "ar1": self.ar1, "ar_share": self.ar_share, "outlier_share": self.outlier_share,
               "dropout_share": self.dropout_share, "round_um": self.round_um})
    }

    pub fn parse(v: &Value) -> Noise {
        let get = |key: &str| v.get(key).and_then(Value::as_f64).unwrap_or(0.0);
        Noise {
            sigma_um: get("sigma_um"),
            ar1: get("ar1"),
            ar_share: get("ar_share"),
            outlier_share: get("outlier_share"),
            dropout_share: get("dropout_share"),
            missing_rows: 0,
            round_um: get("round_um"),
        }
    }
}

/// Whitening by the Kalman filter of the noise (exact for it), and projection off the frame where that is unknown.
pub struct Metric {
    /// Per row: transition since the row before, gain, and one over the standard deviation of the innovation.
    gains: Vec<(f64, f64, f64)>,
    frame: Option<DMatrix<f64>>,
}

impl Metric {
    /// For rows at the integer times `ticks` (periods), of places `at` (m) that are there to learn the frame from.
    pub fn new(noise: &Noise, ticks: &[usize], at: &[Vector3<f64>], frame_known: bool) -> Metric {
        let variance = (noise.sigma_um * 1e-6).powi(2);
        let rounding = ((noise.round_um.max(0.1)) * 1e-6).powi(2) / 12.0;
        let (r, stationary) = (variance * (1.0 - noise.ar_share) + rounding, variance * noise.ar_share);
        let mut p = stationary;
        let mut gains = Vec::with_capacity(ticks.len());
        for k in 0..ticks.len() {
            let lag = if k == 0 { 0 } else { (ticks[k] - ticks[k - 1]).min(10_000) };
            let phi = if lag == 0 { 1.0 } else { noise.ar1.powi(lag as i32) };
            p = phi * phi * p + (1.0 - phi * phi) * stationary;
            let s = p + r;
            gains.push((phi, p / s, 1.0 / s.sqrt()));
            p *= 1.0 - p / s;
        }
        let mut metric = Metric { gains, frame: None };
        if !frame_known {
            let centre: Vector3<f64> = at.iter().sum::<Vector3<f64>>() / at.len() as f64;
            let columns: Vec<DVector<f64>> = (0..6)
                .map(|c| {
                    let e = Vector3::ith(c % 3, 1.0);
                    let course: Vec<_> = at.iter().map(|p| if c < 3 { e } else { e.cross(&(p - centre)) }).collect();
                    metric.white(&course)
                })
                .collect();
            metric.frame = Some(DMatrix::from_columns(&columns).qr().q());
        }
        metric
    }

    fn white(&self, course: &[Vector3<f64>]) -> DVector<f64> {
        let mut x = Vector3::zeros();
        let mut out = DVector::zeros(course.len() * 3);
        for (k, (y, (phi, gain, weight))) in course.iter().zip(&self.gains).enumerate() {
            x *= *phi;
            let innovation = y - x;
            x += innovation * *gain;
            out.fixed_rows_mut::<3>(3 * k).copy_from(&(innovation * *weight));
        }
        out
    }

    /// A course of differences (m) as independent unit normals, off the frame.
    pub fn whiten(&self, course: &[Vector3<f64>]) -> DVector<f64> {
        let w = self.white(course);
        match &self.frame {
            Some(q) => &w - q * (q.transpose() * &w),
            None => w,
        }
    }
}

/// Non-centrality of one minimal detectable bias, square root: alpha 0.001, power 0.8 (Baarda 1968).
pub const MDB: f64 = 4.13;
