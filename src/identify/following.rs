//! How a joint follows its command in time, to first order: speeds of commands, and the priors of lag, response to acceleration and
//! clock, for every identification that fits them beside lost motion.
//!
//! A servo that lags by `tau` gives `-tau v + tau^2 a`; a clock that is late by `t` gives `-t v` at all joints alike. At one constant
//! speed either looks like a gap; a lag grows with the speed, and a gap stays as large as it is while the joint moves on. The
//! priors are several times what servos and clocks show: they decide nothing that a log knows, and keep apart what it cannot tell apart.

/// Standard deviation of a lag, s.
pub(crate) const LAG_S: f64 = 2e-2;
/// Standard deviation of the response to acceleration, s^2: that of a lag of 30 ms.
pub(crate) const ACCELERATION_S2: f64 = 1e-3;
/// Standard deviation of the difference of the clocks of commands and measurements, s.
pub(crate) const CLOCK_S: f64 = 2e-2;

/// Speed and acceleration of a command (rad or m, over s) by central differences; zero at both ends.
pub(crate) fn rates(t_s: &[f64], x: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let n = x.len();
    let mut speed = vec![0.0; n];
    let mut acceleration = vec![0.0; n];
    for i in 1..n.saturating_sub(1) {
        let (h0, h1) = (t_s[i] - t_s[i - 1], t_s[i + 1] - t_s[i]);
        let (d0, d1) = ((x[i] - x[i - 1]) / h0, (x[i + 1] - x[i]) / h1);
        speed[i] = (d0 * h1 + d1 * h0) / (h0 + h1);
        acceleration[i] = 2.0 * (d1 - d0) / (h0 + h1);
    }
    (speed, acceleration)
}
