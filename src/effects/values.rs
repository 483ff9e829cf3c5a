//! Parameters of an effect as plain numbers, for fitting: one order for values, keys and bounds.

use super::*;
use curve::Pchip;
use nalgebra::Vector3;

impl Effect {
    /// Free parameters, SI, in the order of their struct; the knot values of a PCHIP gap, the coefficients of a polynomial; a vector
    /// as its coordinates; a vibration as the coordinates of amplitude times direction, then frequency and phase.
    pub fn values(&self) -> Vec<f64> {
        match self {
            Self::ServoLag(e) => vec![e.lag_s],
            Self::Stiction(e) => {
                let (Decay::Time(d) | Decay::Travel(d)) = e.decay;
                vec![e.spike, d]
            }
            Self::EncoderScale(e) => vec![e.scale],
            Self::TransmissionError(e) => vec![e.amplitude, e.cycles_per_rev, e.phase_rad],
            Self::Backlash(e) => match &e.half_gap {
                GapCurve::Constant(b) => vec![*b],
                GapCurve::Polynomial { coefficients, .. } => coefficients.clone(),
                GapCurve::Pchip(p) => p.knots().iter().map(|k| k[1]).collect(),
            },
            Self::BacklashSpeed(e) => vec![e.half_gap, e.slope],
            Self::Hysteresis(e) => vec![e.half_width, e.presliding],
            Self::JointZeroOffset(e) => vec![e.offset],
            Self::AxisCoupling(e) => vec![e.ratio],
            Self::GravityCompliance(e) => vec![e.compliance],
            Self::LinkError(e) => vec![e.delta],
            Self::ToolError(e) => e.offset_m.as_slice().to_vec(),
            Self::ThermalDrift(e) => {
                let d = e.amplitude_m;
                vec![d.x, d.y, d.z, e.tau_s]
            }
            Self::Vibration(e) => {
                let a = e.direction * e.amplitude_m;
                vec![a.x, a.y, a.z, e.frequency_hz, e.phase_rad]
            }
            Self::TimeOffset(e) => vec![e.offset_s],
        }
    }

    /// The same effect with other values, as many and in the order of [`Effect::values`]; one that is missing stays.
    pub fn with_values(&self, values: &[f64]) -> Effect {
        let old = self.values();
        let v = |i: usize| values.get(i).or(old.get(i)).copied().unwrap_or(0.0);
        match self {
            Self::ServoLag(_) => Self::ServoLag(ServoLag { lag_s: v(0) }),
            Self::Stiction(e) => {
                let decay = match e.decay {
                    Decay::Time(_) => Decay::Time(v(1)),
                    Decay::Travel(_) => Decay::Travel(v(1)),
                };
                Self::Stiction(Stiction { spike: v(0), decay })
            }
            Self::EncoderScale(_) => Self::EncoderScale(EncoderScale { scale: v(0) }),
            Self::TransmissionError(_) => {
                Self::TransmissionError(TransmissionError { amplitude: v(0), cycles_per_rev: v(1), phase_rad: v(2) })
            }
            Self::Backlash(e) => {
                let half_gap = match &e.half_gap {
                    GapCurve::Constant(_) => GapCurve::Constant(v(0)),
                    GapCurve::Polynomial { coefficients, range } => {
                        GapCurve::Polynomial { coefficients: (0..coefficients.len()).map(v).collect(), range: *range }
                    }
                    GapCurve::Pchip(p) => {
                        let knots: Vec<[f64; 2]> = p.knots().iter().enumerate().map(|(i, k)| [k[0], v(i)]).collect();
                        // the positions stay as they are; only a value that is no number can be refused
                        Pchip::new(&knots).map_or_else(|| e.half_gap.clone(), GapCurve::Pchip)
                    }
                };
                Self::Backlash(Backlash { half_gap })
            }
            Self::BacklashSpeed(_) => Self::BacklashSpeed(BacklashSpeed { half_gap: v(0), slope: v(1) }),
            Self::Hysteresis(_) => Self::Hysteresis(Hysteresis { half_width: v(0), presliding: v(1) }),
            Self::JointZeroOffset(_) => Self::JointZeroOffset(JointZeroOffset { offset: v(0) }),
            Self::AxisCoupling(_) => Self::AxisCoupling(AxisCoupling { ratio: v(0) }),
            Self::GravityCompliance(_) => Self::GravityCompliance(GravityCompliance { compliance: v(0) }),
            Self::LinkError(_) => Self::LinkError(LinkError { delta: v(0) }),
            Self::ToolError(_) => Self::ToolError(ToolError { offset_m: Vector3::new(v(0), v(1), v(2)) }),
            Self::ThermalDrift(_) => {
                Self::ThermalDrift(ThermalDrift { amplitude_m: Vector3::new(v(0), v(1), v(2)), tau_s: v(3) })
            }
            Self::Vibration(e) => {
                let a = Vector3::new(v(0), v(1), v(2));
                let amplitude_m = a.norm();
                let direction = if amplitude_m > 0.0 { a / amplitude_m } else { e.direction };
                Self::Vibration(Vibration { amplitude_m, frequency_hz: v(3), phase_rad: v(4), direction })
            }
            Self::TimeOffset(_) => Self::TimeOffset(TimeOffset { offset_s: v(0) }),
        }
    }
}
