//! Why no motion tells two alternatives apart, and which measurement would.
//!
//! The reason is looked up by the form of the alternatives (the conditions of the effect catalogue); the channels are computed: the
//! same motions with one more channel in the log.

use super::motions::Motion;
use super::question::{Alternative, Set};
use super::separate::{DesignScore, Experiment};
use crate::diagnose::problem::synthetic::Channels;
use crate::effects::{EffectInstance, Nature, Stage, Target};
use crate::model::Model;
use crate::robot::JointKind;
use nalgebra::Vector3;

/// A measurement that could be added to the log.
#[derive(Debug, Clone, Copy)]
pub struct Channel {
    pub name: &'static str,
    pub log: &'static str,
    pub channels: Channels,
}

const NONE: Channels = Channels { frame: false, reflectors: false, motors: false, joints: false };

/// Every further measurement that a log can hold, the cheapest first.
pub const CHANNELS: [Channel; 4] = [
    Channel {
        name: "the base, measured",
        log: "`registration` in the model, from targets on the base",
        channels: Channels { frame: true, ..NONE },
    },
    Channel {
        name: "two more reflectors on the tool",
        log: "x2_mm..., x3_mm..., their places under `tools:`",
        channels: Channels { reflectors: true, ..NONE },
    },
    Channel { name: "the motor encoders", log: "enc_<joint> columns", channels: Channels { motors: true, ..NONE } },
    Channel {
        name: "the joints after their gears",
        log: "meas_<joint> columns: secondary encoder, level or scale",
        channels: Channels { joints: true, ..NONE },
    },
];

/// The model with at least two further reflectors: where it has fewer, 0.1 m off the TCP.
pub fn with_reflectors(model: &Model) -> Model {
    let mut model = model.clone();
    let tcp = model.robot.tool.translation.vector;
    while model.robot.reflectors_m.len() < 2 {
        let k = model.robot.reflectors_m.len();
        model.robot.reflectors_m.push(tcp + Vector3::ith(k, 0.1));
    }
    model
}

/// What a channel makes of one motion.
#[derive(Debug, Clone)]
pub struct With {
    pub channel: Channel,
    pub motion: usize,
    pub worth: DesignScore,
}

/// The best of the motions `few` (indices) for every channel.
pub fn channels(bench: &Experiment, motions: &[Motion], few: &[usize], sets: &[Set]) -> Vec<With> {
    use crate::numerics::parallel::ParMap;
    let wide = with_reflectors(bench.model);
    CHANNELS
        .iter()
        .filter(|c| !(c.channels.frame && bench.model.registration.is_some()))
        .filter_map(|channel| {
            let model = if channel.channels.reflectors { &wide } else { bench.model };
            let with = Experiment { model, channels: channel.channels, ..bench.clone() };
            let all: Vec<(usize, DesignScore)> = few.par_map(|&m| (m, with.worth(&motions[m], sets)));
            let best = all.into_iter().reduce(|a, b| if b.1.evidence > a.1.evidence { b } else { a });
            best.map(|(motion, worth)| With { channel: *channel, motion, worth })
        })
        .collect()
}

/// Why two alternatives look the same in every log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Alike {
    /// Gaps in series.
    #[error(
        "gaps in series act as one gap of their sum. Only a sensor between the two gaps (for example between motor shaft and screw) can distinguish them, and no log of this tool contains one"
    )]
    GapsInSeries,
    /// The zero of the first joint, and the frame.
    #[error(
        "a zero offset of the first joint turns the whole robot about that joint, and so does the frame between base and tracker, which \
         is estimated from the same log"
    )]
    FirstZero,
    /// The frame, or the noise, hides the effect.
    #[error("the estimated frame absorbs the effect, or the effect is too small compared with the noise")]
    Absorbed,
    /// The zero of the last joint, and the tool.
    #[error(
        "a zero offset of the last joint turns the TCP about its axis, and so does a different tool if only one point of it is measured"
    )]
    LastZero,
    /// Lengths along parallel axes.
    #[error(
        "both lengths move the TCP by the same amount in the same direction at every pose: along parallel axes only their sum has an effect"
    )]
    ParallelLengths,
    /// A lag and a clock.
    #[error(
        "a lag of all {joints} joints by the same time and a shifted clock both delay the path; they differ only where a joint accelerates"
    )]
    Delay {
        /// Number of joints.
        joints: usize,
    },
    /// Errors of the geometry over a small travel.
    #[error(
        "both change the path in the same way over the allowed travel; {} may distinguish them",
        if *kind == JointKind::Revolute { "wider angles" } else { "longer strokes" }
    )]
    Geometry {
        /// Kind of the first joint.
        kind: JointKind,
    },
    /// Nothing is known of why.
    #[error(
        "their errors at the TCP are the same on every motion of the library once the frame and the size of the alternative are fitted"
    )]
    AnyMotion,
}

/// Why a recording does not tell two alternatives apart.
pub fn reason(a: &Alternative, b: &Alternative, model: &Model) -> Alike {
    let plays = |r: &Alternative| {
        r.effects.iter().filter(|p| matches!(p.effect.nature(), Nature::Gap | Nature::GapOverPosition)).count()
    };
    let only = |r: &Alternative, f: &dyn Fn(&EffectInstance) -> bool| !r.effects.is_empty() && r.effects.iter().all(f);
    let either = |f: &dyn Fn(&Alternative, &Alternative) -> bool| f(a, b) || f(b, a);
    let same_axis =
        a.effects.iter().chain(&b.effects).all(|p| p.target == a.effects.first().map_or(p.target, |q| q.target));
    let zero =
        |p: &EffectInstance, axis: usize| p.target == Target::Joint(axis) && p.effect.nature() == Nature::ZeroOffset;
    let last = model.robot.dof() - 1;
    let tool = |p: &EffectInstance| p.target == Target::Tool;
    let link_d = |p: &EffectInstance| p.effect.nature() == Nature::Link;
    if same_axis
        && plays(a) + plays(b) == a.effects.len() + b.effects.len()
        && plays(a) != plays(b)
        && plays(a).min(plays(b)) > 0
    {
        return Alike::GapsInSeries;
    }
    let named_nothing = |r: &Alternative| r.effects.is_empty();
    if either(&|x, y| named_nothing(y) && only(x, &|p| zero(p, 0))) && model.registration.is_none() {
        return Alike::FirstZero;
    }
    if either(&|x, y| named_nothing(y) && !x.effects.is_empty()) {
        return Alike::Absorbed;
    }
    if either(&|x, y| only(x, &|p| zero(p, last)) && only(y, &tool)) {
        return Alike::LastZero;
    }
    if only(a, &link_d) && only(b, &link_d) {
        return Alike::ParallelLengths;
    }
    let lag = |p: &EffectInstance| p.effect.nature() == Nature::Lag;
    let clock = |p: &EffectInstance| p.target == Target::Log;
    if either(&|x, y| only(x, &lag) && only(y, &clock)) {
        return Alike::Delay { joints: model.robot.dof() };
    }
    let geometry = |r: &Alternative| only(r, &|p| p.effect.stage() >= Stage::Gear && !p.effect.has_memory());
    if geometry(a) && geometry(b) {
        return Alike::Geometry { kind: model.robot.axis(0).kind };
    }
    Alike::AnyMotion
}
