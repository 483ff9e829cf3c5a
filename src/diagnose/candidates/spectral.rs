//! Candidates whose frequency or time is found in what is left, not tried from a list.

use crate::diagnose::candidates::screen::ScreeningContext;
use crate::diagnose::candidates::{Candidate, spectrum, steps};
use crate::diagnose::problem::forward::Problem;
use crate::effects::vibration::swing as vibration;
use crate::effects::{Inputs, transmission_error};
use crate::numerics::robust::largest_size;

impl ScreeningContext<'_> {
    /// Best ripples (per axis) and vibrations, at the peaks of their spectra, the highest wobbles, and the largest
    /// steps of the tracker.
    pub fn spectral(&self) -> Vec<Candidate> {
        let back = self.back();
        let mut found = spectrum::ripples(self, &back);
        let swing = |hz| vibration(&self.problem.robot, hz);
        found.extend(spectrum::vibrations(self, &back).into_iter().map(swing));
        found.extend(steps::steps(self, &back));
        found.extend(spectrum::wobbles(self, &back));
        found
    }
}

/// A ripple at the frequency of a plain one that fades with the speed of its joint, for a few speeds. A slow wave that fades is any
/// curve over position and speed: not tried.
pub fn fading(problem: &Problem, plain: &Candidate) -> Vec<Candidate> {
    let ripples = plain.form.is_empty() && plain.effect == transmission_error::INFO.name;
    let Some(axis) = plain.axis().filter(|_| ripples) else { return Vec::new() };
    if !plain.at(&[1e-6, 0.0]).iter().all(|ripple| spectrum::identifiable(problem, ripple)) {
        return Vec::new();
    }
    let fastest = largest_size(problem.motions().flat_map(|l| Inputs::speed(&l.trajectory, axis).iter().copied()));
    transmission_error::fading(&problem.robot, axis, plain, fastest)
}
