//! `transmission_error`: the gear leads and trails periodically: adds `amplitude * sin(cycles * p + phase)`.
//!
//! `cycles` counts periods per turn of the joint, or per turn of the screw of a prismatic joint (its lead). It acts on the
//! signal that arrives. Parameters: amplitude 0 or more, and such that the joint does not turn back (`amplitude * cycles < 1`
//! rad); cycles above 0; phase within half a turn either way. With `fade` the amplitude falls with the speed of the command:
//! `amplitude * exp(-|dp/dt| / fade)`, as a position loop and the inertia behind the gear filter what a slow motion shows (seen on a
//! KR 300: 0.0062 deg below 6 deg/s, 0.0036 deg above 21 deg/s). Where the angles of each recording count from its own start, every
//! recording has its own phase: `phase_deg` is that of the first, `phase_2_deg` of the second, and so on. Action: service the gear (a
//! tooth, the wave generator); an offset of the negative undoes it.

use super::common::*;
use super::site::within;
use crate::robot::{JointKind, Robot};
use std::f64::consts::{PI, TAU};

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: "transmission_error",
    heading: "transmission error",
    stage: Stage::Gear,
    family: Family::Ripple,
    acts_on: ActsOn::Joint,
    adds: "the gear leads and trails periodically over the joint's position",
    equation: "amplitude sin(cycles p + phase), times exp(-|dp/dt|/fade) if fade is given; for a prismatic joint, cycles count turns of its lead screw",
    reference: "kinematic error of harmonic drives: Tuttle, Seering (1996), IEEE Trans. Robotics and Automation 12(3)",
    parameters: &[
        ("amplitude_deg", "0 to 0.1 rad (10 mm), and small enough that the joint does not turn back"),
        ("cycles_per_rev", "periods per turn, 0.05 to 10,000"),
        ("phase_deg", "within half a turn either way"),
        (
            "phase_2_deg",
            "phase of the second recording, and so on, if angles count from the start of each recording; without it, one phase for all recordings",
        ),
        (
            "fade_deg_s",
            "joint speed at which the amplitude has fallen to 1/e, 0.1 to 10,000 deg/s; without it, the amplitude does not depend on speed",
        ),
    ],
    confused_with: &["vibration", "encoder_scale"],
    decide_by: "move the joint at two speeds: a vibration keeps its frequency, a transmission error its period in degrees",
    action: "service the gear (worn tooth, wave generator, eccentric pinion); an offset of opposite sign compensates it",
    undone: "all of it, point by point, unless it fades with speed",
    special: Special::NONE,
    example: (
        "{effect: transmission_error, joint: A1, amplitude_deg: 0.002, cycles_per_rev: 60, phase_deg: 0}",
        View::JointOverCommand,
    ),
    read,
    typical: |size| {
        let cycles = if size.is_revolute() { 37.0 } else { 1.0 };
        // a period of about 10 deg, or of a turn of the lead
        vec![(size.key("amplitude"), (0.5 * size.gap).into()), ("cycles_per_rev".into(), cycles.into())]
    },
    // a spectrum finds the frequencies: [`ripple`]
    candidates: |_, _| {},
};

/// How the catalogue describes the form that fades with speed.
pub static FADING: EffectForm = EffectForm {
    of: &INFO,
    name: "transmission_error_fading",
    heading: "that fades with speed",
    equation: "amplitude exp(-|dp/dt|/fade) sin(cycles p + phase)",
    reference: "a position loop and the inertia behind the gear filter what a slow motion shows; measured on a KR 300 with two encoders",
    typical: "fade 20 to 100 deg/s",
    example: (
        "{effect: transmission_error, joint: A1, amplitude_deg: 0.002, cycles_per_rev: 60, phase_deg: 0, fade_deg_s: 8}",
        View::JointOverCommand,
    ),
    diagnosis: "tries it where the plain ones leave something",
    undone: "nothing: its amplitude depends on the speed of the joint",
};

/// Amplitude in rad or m, periods per turn, phase in rad.
#[derive(Debug, Clone, PartialEq)]
pub struct TransmissionError {
    /// Amplitude, rad or m.
    pub amplitude: f64,
    /// Periods per revolution of the joint (per m of a prismatic one).
    pub cycles_per_rev: f64,
    /// Phase at position 0, rad.
    pub phase_rad: f64,
    /// Speed over which the amplitude falls to 1/e, rad/s or m/s; `None`: it does not.
    pub fade: Option<f64>,
    /// Phases in the second and further logs, rad, where each log has its own; empty: all share one.
    pub further_phases_rad: Vec<f64>,
}

impl TransmissionError {
    fn at(&self, arriving: f64, rev: f64) -> f64 {
        let wave = self.cycles_per_rev * TAU / rev;
        self.amplitude * (wave * arriving + self.phase_rad).sin()
    }
}

fn fade_key(unit: &str) -> String {
    format!("fade_{unit}_s")
}

fn read(f: &mut Fields) -> Result<Effect> {
    let site = f.site();
    let without_lead = site.axis().is_some_and(|a| site.robot.axis(a).lead_m_per_rev.is_none());
    if site.kind() == JointKind::Prismatic && without_lead {
        let found = format!("no `lead_mm_per_rev` of {} in the robot file", f.named());
        return Err(f.bad("", found, "the lead of the screw: cycles count its turns"));
    }
    Ok(TransmissionError {
        amplitude: f.length("amplitude", 0.0)?,
        cycles_per_rev: f.above_0("cycles_per_rev")?,
        phase_rad: f.phase_rad()?,
        further_phases_rad: further_phases(f)?,
        fade: f.number(&fade_key(site.unit()), f64::MIN_POSITIVE)?.map(|v| v * site.si_per_user_unit()),
    }
    .into())
}

/// Key of the phase in the `log`-th log (the first is 0).
fn phase_key(log: usize) -> String {
    if log == 0 { "phase_deg".into() } else { format!("phase_{}_deg", log + 1) }
}

fn further_phases(f: &mut Fields) -> Result<Vec<f64>> {
    let mut all = Vec::new();
    while let Some(degrees) = f.number(&phase_key(all.len() + 1), f64::NEG_INFINITY)? {
        all.push(degrees.to_radians());
    }
    Ok(all)
}

/// Ripple whose phase is its own in each of `logs` logs, as where angles count from the start of each.
pub fn ripple_by_log(robot: &Robot, axis: usize, cycles_per_rev: f64, logs: usize) -> Candidate {
    let phase = |c: &[f64]| c[1].atan2(c[0]);
    ripple(robot, axis, cycles_per_rev)
        .in_each_log(logs)
        .built_by(Target::Joint(axis), move |c| {
            let each: Vec<&[f64]> = c.chunks_exact(2).collect();
            let amplitude = each.iter().map(|c| c[0].hypot(c[1])).sum::<f64>() / each.len().max(1) as f64;
            let mut phases = each.iter().map(|c| phase(c));
            TransmissionError {
                amplitude,
                cycles_per_rev,
                phase_rad: phases.next().unwrap_or(0.0),
                fade: None,
                further_phases_rad: phases.collect(),
            }
        })
        .with_form("own phases")
}

/// Ripple of an axis at a number of cycles per revolution (of its lead, for a prismatic one).
pub fn ripple(robot: &Robot, axis: usize, cycles_per_rev: f64) -> Candidate {
    Candidate::of_sizes(robot, Target::Joint(axis), &[candidate::TRIAL; 2], move |c| TransmissionError {
        amplitude: c[0].hypot(c[1]),
        cycles_per_rev,
        phase_rad: c[1].atan2(c[0]),
        fade: None,
        further_phases_rad: Vec::new(),
    })
    .with_shape(1)
}

/// Speeds over which a ripple is tried to fade, as shares of the fastest of its joint.
const FADES: [f64; 3] = [0.1, 0.3, 1.0];

/// Forms of a plain ripple of an axis that fade with speed, where the joint moves at up to `fastest` rad/s or m/s.
pub fn fading(robot: &Robot, axis: usize, plain: &Candidate, fastest: f64) -> Vec<Candidate> {
    let ripple = plain.at(&[1.0, 0.0]);
    let Some(ripple) = ripple.first().and_then(|p| p.effect.get::<TransmissionError>()) else { return Vec::new() };
    let cycles_per_rev = ripple.cycles_per_rev;
    let form = move |fade: f64| {
        let make = move |c: &[f64]| TransmissionError {
            amplitude: c[0].hypot(c[1]),
            cycles_per_rev,
            phase_rad: c[1].atan2(c[0]),
            fade: Some(fade),
            further_phases_rad: Vec::new(),
        };
        let one = Candidate::of_sizes(robot, Target::Joint(axis), &[candidate::TRIAL; 2], make);
        one.with_shape(2).with_form("fading")
    };
    FADES.iter().map(|share| share * fastest).filter(|fade| *fade > 0.0).map(form).collect()
}

impl EffectType for TransmissionError {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn nature(&self) -> Nature {
        Nature::Ripple
    }

    fn values(&self) -> Vec<f64> {
        let first = [self.amplitude, self.cycles_per_rev, self.phase_rad].into_iter();
        first.chain(self.fade).chain(self.further_phases_rad.iter().copied()).collect()
    }

    fn with(&self, v: &[f64]) -> Effect {
        let further = 3 + usize::from(self.fade.is_some());
        Self {
            amplitude: v[0],
            cycles_per_rev: v[1],
            phase_rad: v[2],
            fade: self.fade.map(|_| v[3]),
            further_phases_rad: v[further..].to_vec(),
        }
        .into()
    }

    fn parameters(&self, site: &Site) -> Vec<Parameter> {
        let wave = self.cycles_per_rev.max(1e-3) / if site.is_revolute() { 1.0 } else { site.rev() / TAU };
        let mut all = vec![
            site.length("amplitude", (0.0, site.most_lost().min(1.0 / wave)), site.typical(0.003, 0.003)),
            Parameter::new("cycles_per_rev", 1.0, (0.05, 1e4), 100.0),
            Parameter::degrees("phase_deg", within(PI), PI),
        ];
        let (slow, fast) = (site.typical(0.1, 0.1), site.typical(1e4, 1e4));
        all.extend(self.fade.map(|_| {
            Parameter::new(
                &fade_key(site.unit()),
                1.0 / site.si_per_user_unit(),
                (slow, fast),
                site.typical(40.0, 50.0),
            )
        }));
        let phases = 1..=self.further_phases_rad.len();
        all.extend(phases.map(|log| Parameter::degrees(&phase_key(log), within(PI), PI)));
        all
    }

    fn apply(&self, track: &Track, signal: &mut [f64]) {
        let Some(fade) = self.fade else {
            signal.iter_mut().for_each(|s| *s += self.at(*s, track.rev));
            return;
        };
        // what settles stands still
        let speed = |i: usize| if track.between == Between::Settled { 0.0 } else { track.speed_at(i) };
        for (i, s) in signal.iter_mut().enumerate() {
            *s += self.at(*s, track.rev) * (-speed(i).abs() / fade).exp();
        }
    }

    fn position_error(&self, arriving: f64, rev: f64) -> Option<f64> {
        self.fade.is_none().then(|| self.at(arriving, rev))
    }

    fn phase(&self) -> Option<usize> {
        Some(2)
    }

    fn is_phase(&self, value: usize) -> bool {
        value == 2 || value >= 3 + usize::from(self.fade.is_some())
    }

    fn is_wider(&self) -> bool {
        self.fade.is_some()
    }

    fn plainer(&self) -> Option<Effect> {
        self.fade.map(|_| Self { fade: None, ..self.clone() }.into())
    }

    fn action(&self) -> &'static str {
        match self.fade {
            None => INFO.action,
            Some(_) => {
                "service the gear (worn tooth, wave generator, eccentric pinion); an offset cannot compensate it, because its amplitude depends on the speed"
            }
        }
    }

    fn in_log(&self, log: usize) -> Option<Effect> {
        let phase_rad = *self.further_phases_rad.get(log.checked_sub(1)?)?;
        Some(Self { phase_rad, further_phases_rad: Vec::new(), ..self.clone() }.into())
    }

    fn of_its_logs_alone(&self) -> bool {
        !self.further_phases_rad.is_empty()
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        if self.of_its_logs_alone() {
            return Undo::nothing("its phase is another in each recording");
        }
        match self.fade {
            None => Undo::point_by_point(),
            Some(_) => Undo::nothing("its amplitude depends on the speed of the joint"),
        }
    }
}
