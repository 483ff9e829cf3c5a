//! What a reader of a diagnosis should know, as data. Code compares the variants; the words are for readers.

use crate::effects::Idle;
use crate::robot::JointKind;
use crate::robot::gap_of::JointsAlone;

/// A remark on a diagnosis. Values of joints are in rad or m, as `kind` says.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Note {
    /// The gap of a sum of axes counts as one of a joint alone.
    #[error("{0}")]
    JointsAlone(JointsAlone),
    /// An effect of the model follows columns that no log has.
    #[error("{0}")]
    Idle(Idle),
    /// The orientations are not those of the tool.
    #[error(
        "the orientations qw, qx, qy, qz are not used: they contradict the joints by {:.0} deg; expected: the tool's axes in the frame of x, y, z, of a probe that does not move on the tool",
        by_rad.to_degrees()
    )]
    OrientationContradicts {
        /// Median deviation of the worst log, rad.
        by_rad: f64,
    },
    /// The probe was clamped anew between the logs.
    #[error(
        "the orientations qw, qx, qy, qz are not used: the probe sits otherwise on the tool in {log} than in the log before it, by {:.2} deg; expected: one probe that is not clamped anew between the logs",
        by_rad.to_degrees()
    )]
    ProbeMoved {
        /// Name of the log.
        log: String,
        /// Angle to how it sat before, rad.
        by_rad: f64,
    },
    /// The orientations are used.
    #[error(
        "the orientation of the tool is used; how its probe sits on the tool is fitted, and micrometres are those of the TCP"
    )]
    OrientationUsed,
    /// Zeros of joint sensors are fitted.
    #[error(
        "the zero of each joint sensor is fitted for each log: a joint_zero_offset cannot be distinguished from it"
    )]
    SensorZeros,
    /// A log of single readings.
    #[error(
        "{log}: {instrument}; a reading shows one part of the motion of the TCP: what moves the TCP across it, and geometry errors that it \
         shows as it shows others, cannot be found"
    )]
    SingleReadings {
        /// Name of the log.
        log: String,
        /// What is estimated of its instrument.
        instrument: OfInstrument,
    },
    /// The tracker was moved between the logs.
    #[error("the logs are not in one frame: the tracker was moved, and each log gets its own frame")]
    OwnFrames,
    /// An encoder contradicts the sensor of its joint.
    #[error(
        "{log}: enc of {joint} contradicts its meas, which differs from enc by {} rms and from cmd by {}; cmd is used",
        size(*encoder, *kind), size(*command, *kind)
    )]
    EncoderAgainstSensor {
        /// Name of the log.
        log: String,
        /// Name of the joint.
        joint: String,
        /// Kind of the joint.
        kind: JointKind,
        /// Distance of sensor and encoder, rad or m rms.
        encoder: f64,
        /// Distance of sensor and command, rad or m rms.
        command: f64,
    },
    /// The encoders contradict the measured points.
    #[error(
        "{log}: the enc columns contradict the measured points: with the geometry fitted, the points differ from enc by {:.0} um per coordinate and from cmd by {:.0} um; cmd is used{}",
        encoder_m * 1e6, command_m * 1e6,
        if *settled { " (were the joints read before the arm had settled?)" } else { "" }
    )]
    EncodersAgainstPoints {
        /// Name of the log.
        log: String,
        /// Distance of the points from those by the encoders, m.
        encoder_m: f64,
        /// Distance of the points from those by the commands, m.
        command_m: f64,
        /// The log holds settled poses.
        settled: bool,
    },
    /// Encoders lead the commands.
    #[error(
        "{log}: the motor encoders lead the commands ({}), as with feed-forward: the servo stage is not diagnosed",
        leads.iter().map(Lead::to_string).collect::<Vec<_>>().join("; ")
    )]
    EncodersLead {
        /// Name of the log.
        log: String,
        /// Which of them.
        leads: Vec<Lead>,
    },
    /// More would be named than the limit allows.
    #[error(
        "a diagnosis names at most {most} effects if structure remains; a further round would name {effect} {target}: write the model and diagnose again with it"
    )]
    BeyondLimit {
        /// The limit.
        most: usize,
        /// The effect.
        effect: &'static str,
        /// Where it would stand.
        target: String,
    },
    /// Direction terms of settled poses.
    #[error(
        "direction terms in standard uncertainties, positive as of play: {}",
        terms.iter().map(|(joint, z)| format!("{joint} {z:.1}")).collect::<Vec<_>>().join(", ")
    )]
    DirectionTerms {
        /// Names of the joints and their terms, in standard uncertainties.
        terms: Vec<(String, f64)>,
    },
    /// Direction terms that name no gap.
    #[error(
        "no gap is named: the largest direction-dependent part, on {joint}, is {:.4} deg or mm ({z:.1} standard uncertainties), but terms of the wrong sign, which play never has, reach {wrong_z:.1}{}",
        half_gap / kind.si_per_user_unit(),
        few_poses.map_or(String::new(), |poses| format!("; {poses:.1} poses per parameter of the nuisance are too few"))
    )]
    NoGapNamed {
        /// Name of the joint.
        joint: String,
        /// Kind of the joint.
        kind: JointKind,
        /// Its term as a half gap, rad or m.
        half_gap: f64,
        /// The same in standard uncertainties.
        z: f64,
        /// Largest term of the wrong sign, in standard uncertainties.
        wrong_z: f64,
        /// Poses per parameter of the nuisance, where they are too few.
        few_poses: Option<f64>,
    },
    /// Logs that share a frame and should not.
    #[error(
        "the logs are not in one frame: the residual is {:.1} um with one frame per log, and {:.1} um with one common frame; diagnose the logs one by one, or measure again from one station",
        own_m * 1e6, shared_m * 1e6
    )]
    NotInOneFrame {
        /// Residual with one frame per log, m rms.
        own_m: f64,
        /// Residual with one common frame, m rms.
        shared_m: f64,
    },
    /// Another frame explains as much as the found effects.
    #[error(
        "another frame alone ({:.3} mm and {:.4} deg from the model's registration) would reduce the residual to {:.1} um of {:.1}; the found effects reduce it to {:.1} um: if the registration may be wrong, leave it out of the model, and the frame is estimated",
        moved_m * 1e3, turned_rad.to_degrees(), left_m * 1e6, given_m * 1e6, found_m * 1e6
    )]
    OtherFrame {
        /// Distance of the frame from the registration, m.
        moved_m: f64,
        /// Angle between them, rad.
        turned_rad: f64,
        /// Residual with that frame, m rms.
        left_m: f64,
        /// Residual with the registration, m rms.
        given_m: f64,
        /// Residual with the found effects, m rms.
        found_m: f64,
    },
    /// A known effect has another size.
    #[error(
        "{effect} {target} of the model does not fit this log: with {} an rms of {:.1} um remains, now {:.1} um; remove it from the model, or correct it",
        sizes.iter().map(OtherSize::to_string).collect::<Vec<_>>().join(", "), left_m * 1e6, given_m * 1e6
    )]
    KnownEffectDiffers {
        /// The effect.
        effect: &'static str,
        /// Where it stands.
        target: String,
        /// Its values.
        sizes: Vec<OtherSize>,
        /// Residual with them, m rms.
        left_m: f64,
        /// Residual with those of the model, m rms.
        given_m: f64,
    },
    /// A ripple whose phase is that of its log.
    #[error(
        "{effect} {target} has a different phase in each log, as if angles count from the start of each log: the written model does not contain it"
    )]
    PhaseOfEachLog {
        /// The effect.
        effect: &'static str,
        /// Where it stands.
        target: String,
    },
    /// The tracker's frame jumps.
    #[error(
        "the frame of the tracker jumps by {:.0} um ({when}), as after a lost beam: the log has a frame before it and another one after it; the written model does not contain the step",
        by_m * 1e6
    )]
    FrameJumps {
        /// Size of the jump, m.
        by_m: f64,
        /// From when on, and in which log.
        when: String,
    },
    /// What remains is slower than the instrument scatters.
    #[error(
        "{:.1} um of what remains vary more slowly than the instrument scatters ({:.1} um from one sample to the next): the noise of this diagnosis includes them as wander of arm and air, but they may be structure, most of all with {structure}",
        slow_m * 1e6, instrument_m * 1e6
    )]
    SlowRemainder {
        /// How much, m rms.
        slow_m: f64,
        /// Scatter of the instrument, m.
        instrument_m: f64,
        /// With what it goes.
        structure: String,
    },
    /// Only joints were measured.
    #[error("only joints were measured: in the document, values in `_um` are microradians of a joint")]
    OnlyJoints,
}

/// What is estimated of an instrument with one reading a row.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum OfInstrument {
    /// A ballbar.
    #[error(
        "centre (near {:.1}, {:.1}, {:.1} mm) and length of the ballbar are estimated as far as its path tells them",
        centre_m[0] * 1e3, centre_m[1] * 1e3, centre_m[2] * 1e3
    )]
    Ballbar {
        /// Where its centre was looked for, m.
        centre_m: [f64; 3],
    },
    /// A dial gauge.
    #[error("zero and tilt of the dial are estimated")]
    Dial,
}

/// An encoder that leads its command.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{joint} by {:.1} ms, rms {}", by_s * 1e3, size(*rms, *kind))]
pub struct Lead {
    /// Name of the joint.
    pub joint: String,
    /// Kind of the joint.
    pub kind: JointKind,
    /// By how much, s.
    pub by_s: f64,
    /// Encoder minus command, rad or m rms about its mean.
    pub rms: f64,
}

/// A value of an effect that the logs contradict, in the unit of its key.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{key} {fitted:.5} instead of {given:.5}")]
pub struct OtherSize {
    /// Key of the value in a model file.
    pub key: String,
    /// What fits the logs.
    pub fitted: f64,
    /// What the model says.
    pub given: f64,
}

/// An rms of a joint in its unit.
fn size(rms: f64, kind: JointKind) -> String {
    format!("{:.4} {}", rms / kind.si_per_user_unit(), kind.unit())
}

crate::io::in_words!(Note);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_are_shown_in_their_own_units() {
        let lead = |kind, rms| Lead { joint: "A1".into(), kind, by_s: 0.002, rms };
        let leads = vec![lead(JointKind::Revolute, 0.5_f64.to_radians()), lead(JointKind::Prismatic, 2e-5)];
        let note = Note::EncodersLead { log: "log.csv".into(), leads };
        assert_eq!(
            note.to_string(),
            "log.csv: the motor encoders lead the commands (A1 by 2.0 ms, rms 0.5000 deg; A1 by 2.0 ms, rms 0.0200 mm), as with \
             feed-forward: the servo stage is not diagnosed"
        );
    }
}
