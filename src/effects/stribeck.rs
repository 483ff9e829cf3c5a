//! Friction that is larger at low speed: `F(v) = 1 + excess exp(-(v/speed)^2)`, as a multiple of friction at high speed.
//!
//! A lubricated contact builds up its film as it moves, so friction falls with speed from its value at standstill (Stribeck 1902). The form
//! is that of Tustin (1947) and Bo and Pavelescu (1982) with the exponent 2 that Armstrong-Helouvry, Dupont and Canudas de Wit (1994,
//! Automatica 30(7), equation 3) and Canudas de Wit, Olsson, Astrom and Lischinsky (1995, IEEE Trans. Automatic Control 40(3)) use.
//!
//! What builds up over travel after a reversal then moves towards `F` instead of 1. Friction that grows with speed (viscous) is left out.

use super::{Fields, Parameter, Site};
use crate::error::Result;

/// Growth of friction at low speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stribeck {
    /// Friction at standstill over that at high speed, less 1; 0 or more.
    pub excess: f64,
    /// Speed at which 1/e of the excess is left, rad/s or m/s; above 0.
    pub speed: f64,
}

impl Stribeck {
    /// The keys of an effect that is larger at low speed: `low_speed_excess` and `low_speed_deg_s`, both or neither.
    pub(super) fn read(f: &mut Fields) -> Result<Option<Self>> {
        let si = f.site().si_per_user_unit();
        let key = format!("{}_s", f.site().key("low_speed"));
        match (f.number("low_speed_excess", 0.0)?, f.number(&key, f64::MIN_POSITIVE)?) {
            (Some(excess), Some(speed)) => Ok(Some(Self { excess, speed: speed * si })),
            (None, None) => Ok(None),
            _ => {
                Err(f.bad("low_speed", "one parameter of two", &format!("`low_speed_excess` and `{key}`, or neither")))
            }
        }
    }

    pub(super) fn values(&self) -> [f64; 2] {
        [self.excess, self.speed]
    }

    pub(super) fn of(values: &[f64]) -> Self {
        Self { excess: values[0], speed: values[1] }
    }

    pub(super) fn parameters(site: &Site) -> [Parameter; 2] {
        let speed =
            site.length("low_speed", (site.most_lost() * 1e-5, site.most_lost() * 100.0), site.typical(1.0, 1.0));
        let speed = Parameter { key: format!("{}_s", speed.key), ..speed };
        [Parameter::new("low_speed_excess", 1.0, (0.0, 10.0), 0.3), speed]
    }

    /// What is left of the excess at a speed (rad/s or m/s), as a share of it.
    #[inline]
    pub fn share(&self, speed: f64) -> f64 {
        let x = speed / self.speed;
        (-x * x).exp()
    }

    /// Friction at a speed as a multiple of that at high speed.
    #[inline]
    pub fn level(&self, speed: f64) -> f64 {
        1.0 + self.excess * self.share(speed)
    }

    /// Speed of a movement of `by` (rad or m) in `dt_s`: without limit where it takes no time.
    #[inline]
    pub fn speed_of(by: f64, dt_s: f64) -> f64 {
        if by == 0.0 { 0.0 } else { by.abs() / dt_s.max(0.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_falls_from_standstill_to_high_speed() {
        let s = Stribeck { excess: 0.3, speed: 2e-3 };
        assert_eq!(s.level(0.0), 1.3);
        assert!((s.level(-2e-3) - (1.0 + 0.3 / std::f64::consts::E)).abs() < 1e-15);
        assert!((s.level(1.0) - 1.0).abs() < 1e-15);
        assert_eq!(Stribeck::speed_of(-1e-3, 0.5), 2e-3);
        assert_eq!(Stribeck::speed_of(0.0, 0.0), 0.0);
        assert_eq!(s.level(Stribeck::speed_of(1e-3, 0.0)), 1.0);
    }
}
