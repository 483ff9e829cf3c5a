//! The models as the files of NIST print them.

use super::dual::Number;
use std::f64::consts::{PI, TAU};

/// Value of a problem's model with parameters `b` at predictors `x`.
pub fn model<T: Number>(name: &str, b: &[T], x: &[f64]) -> T {
    let x1 = x[0];
    match name {
        "Bennett5" => b[0] * power(b[1] + x1, -(b[2] / (b[2] * b[2]))),
        "Misra1a" | "BoxBOD" => b[0] * (-(-b[1] * x1).exp() + 1.0),
        "Misra1b" => b[0] * (-reciprocal(square(b[1] * (x1 / 2.0) + 1.0)) + 1.0),
        "Misra1c" => b[0] * (-((b[1] * (2.0 * x1) + 1.0).ln() * -0.5).exp() + 1.0),
        "Misra1d" => b[0] * b[1] * x1 / (b[1] * x1 + 1.0),
        "Chwirut1" | "Chwirut2" => (-b[0] * x1).exp() / (b[1] + b[2] * x1),
        "DanWood" => b[0] * (b[1] * x1.ln()).exp(),
        "ENSO" => {
            let yearly = b[1] * (TAU * x1 / 12.0).cos() + b[2] * (TAU * x1 / 12.0).sin();
            let wave = |period: T, c: T, s: T| {
                let phase = reciprocal(period) * (TAU * x1);
                c * phase.cos() + s * phase.sin()
            };
            b[0] + yearly + wave(b[3], b[4], b[5]) + wave(b[6], b[7], b[8])
        }
        "Eckerle4" => b[0] / b[1] * (square((-b[2] + x1) / b[1]) * -0.5).exp(),
        "Gauss1" | "Gauss2" | "Gauss3" => {
            let bump = |h: T, at: T, width: T| h * (-square((-at + x1) / width)).exp();
            b[0] * (-b[1] * x1).exp() + bump(b[2], b[3], b[4]) + bump(b[5], b[6], b[7])
        }
        "Hahn1" | "Thurber" => polynomial(&b[..4], x1) / (polynomial(&b[4..], x1) * x1 + 1.0),
        "Kirby2" => polynomial(&b[..3], x1) / (polynomial(&b[3..], x1) * x1 + 1.0),
        "Lanczos1" | "Lanczos2" | "Lanczos3" => {
            let decay = |h: T, rate: T| h * (-rate * x1).exp();
            decay(b[0], b[1]) + decay(b[2], b[3]) + decay(b[4], b[5])
        }
        "MGH09" => b[0] * (b[1] * x1 + x1 * x1) / (b[2] * x1 + b[3] + x1 * x1),
        "MGH10" => b[0] * (b[1] / (b[2] + x1)).exp(),
        "MGH17" => b[0] + b[1] * (-b[3] * x1).exp() + b[2] * (-b[4] * x1).exp(),
        "Nelson" => b[0] - b[1] * x1 * (-b[2] * x[1]).exp(),
        "Rat42" => b[0] / ((b[1] - b[2] * x1).exp() + 1.0),
        "Rat43" => b[0] / power((b[1] - b[2] * x1).exp() + 1.0, reciprocal(b[3])),
        "Roszman1" => b[0] - b[1] * x1 - (b[2] / (-b[3] + x1)).atan() * (1.0 / PI),
        other => panic!("no model of {other}"),
    }
}

fn square<T: Number>(v: T) -> T {
    v * v
}

fn reciprocal<T: Number>(v: T) -> T {
    v / (v * v)
}

fn power<T: Number>(base: T, exponent: T) -> T {
    (exponent * base.ln()).exp()
}

/// `c_0 + c_1 x + c_2 x^2 + ...`
fn polynomial<T: Number>(c: &[T], x: f64) -> T {
    c[1..].iter().enumerate().fold(c[0], |sum, (k, c)| sum + *c * x.powi(k as i32 + 1))
}
