//! `encoder_scale`: the joint moves a little more, or less, than it is told, in proportion: adds `scale * p`.
//!
//! Parameter: `scale_ppm`, within 5 %, beyond which a gear ratio is entered wrongly. It acts on the signal that arrives.
//! Action: correct the gear ratio, or the scale of the encoder, in the controller; an offset `-scale * p` undoes it.

/// Relative error of the movement (1e-6 per ppm).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EncoderScale {
    pub scale: f64,
}

impl EncoderScale {
    /// Scales the signal in place.
    pub fn apply(&self, signal: &mut [f64]) {
        for s in signal {
            *s += self.scale * *s;
        }
    }
}
