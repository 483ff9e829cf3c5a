//! What a user reads about each effect: one table, from which messages, reports and `docs/effects.md` take their words.

use super::Stage;

/// One effect in words.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectInfo {
    /// Name in model files and documents.
    pub name: &'static str,
    pub stage: Stage,
    /// Where it acts: `joint`, `A6<-A5`, `A2.a`, `tool`, `tcp`, `log`.
    pub target: &'static str,
    /// What it adds, in one line.
    pub adds: &'static str,
    /// Its equation.
    pub equation: &'static str,
    /// Keys of its parameters for a revolute joint, with what each means and its bounds.
    pub parameters: &'static [(&'static str, &'static str)],
    /// Effects that a log may not tell from it.
    pub confused_with: &'static [&'static str],
    /// The experiment that decides.
    pub decide_by: &'static str,
    /// What a user does about it.
    pub action: &'static str,
}

/// The card of an effect, or `None` where the catalogue has no such name.
pub fn find(name: &str) -> Option<&'static EffectInfo> {
    CARDS.iter().find(|c| c.name == name)
}

/// The card of an effect of the catalogue, by [`super::Effect::name`].
///
/// # Panics
/// For another name; [`find`] is for names from outside.
pub fn of(name: &str) -> &'static EffectInfo {
    match find(name) {
        Some(card) => card,
        None => unreachable!("the catalogue has a card for each effect, but none for {name}"),
    }
}

/// All effects in the order of the chain.
pub static CARDS: &[EffectInfo] = &[
    EffectInfo {
        name: "servo_lag",
        stage: Stage::Servo,
        target: "joint",
        adds: "the joint trails its command by lag times speed",
        equation: "lag dq/dt + q = p, starting at rest",
        parameters: &[("lag_s", "time constant, 0 to 1 s: a slower position loop is no servo")],
        confused_with: &["time_offset"],
        decide_by: "log the encoders; or move one joint at a time, at two speeds: a time offset is the same for all joints",
        action: "enable or tune velocity feed-forward, or run slower; offsets in a program cannot undo it",
    },
    EffectInfo {
        name: "stiction",
        stage: Stage::Servo,
        target: "joint",
        adds: "the joint stands still behind a reversal until the servo has worked the error off",
        equation: "-dir min(|p - p_rev|, spike exp(-(t - t_rev)/decay)) behind each reversal",
        parameters: &[
            ("spike_deg", "largest error, 0 to 0.1 rad (10 mm): more is a seized joint"),
            ("decay_s or decay_deg", "time (1 ms to 1000 s) or travel over which the error fades"),
        ],
        confused_with: &["hysteresis", "backlash"],
        decide_by: "reverse at two speeds and wait behind one reversal: stiction fades, a gap stays",
        action: "grease, check preload and seals, raise the integral gain; a fading offset behind each reversal undoes it",
    },
    EffectInfo {
        name: "encoder_scale",
        stage: Stage::Gear,
        target: "joint",
        adds: "the joint moves more, or less, than told, in proportion",
        equation: "scale p",
        parameters: &[("scale_ppm", "either sign, within 50,000 ppm: more is a wrong gear ratio")],
        confused_with: &["transmission_error", "link_error", "joint_zero_offset"],
        decide_by: "move the joint through its whole range",
        action: "correct the gear ratio or encoder scale in the controller",
    },
    EffectInfo {
        name: "transmission_error",
        stage: Stage::Gear,
        target: "joint",
        adds: "the gear runs ahead and behind periodically over the joint's position",
        equation: "amplitude sin(cycles p + phase); cycles of a prismatic joint count turns of its lead",
        parameters: &[
            ("amplitude_deg", "0 to 0.1 rad (10 mm), and small enough that the joint does not turn back"),
            ("cycles_per_rev", "periods per turn, 0.05 to 10,000"),
            ("phase_deg", "within half a turn either way"),
        ],
        confused_with: &["vibration", "encoder_scale"],
        decide_by: "move the joint at two speeds: a vibration keeps its frequency, a transmission error its period in degrees",
        action: "service the gear (worn tooth, wave generator, eccentric pinion); an offset of the negative undoes it",
    },
    EffectInfo {
        name: "backlash",
        stage: Stage::Gear,
        target: "joint",
        adds: "the joint follows its motor at half the gap and stands still while the gap is crossed",
        equation: "play operator: the output stays within half_gap of its input and moves only when pushed",
        parameters: &[("half_gap_deg", "half of the gap, 0 to 0.1 rad (10 mm): more is a broken joint")],
        confused_with: &["hysteresis", "backlash_position", "backlash_speed", "stiction"],
        decide_by: "reverse slowly, with rows inside the gap, at several positions and two speeds",
        action: "take the gap up (preload, shim, new nut or pinion); an offset of half a gap in the direction of travel undoes it",
    },
    EffectInfo {
        name: "backlash_position",
        stage: Stage::Gear,
        target: "joint",
        adds: "backlash whose gap depends on where the joint stands",
        equation: "play operator, half gap joined by PCHIP over p, constant beyond the knots",
        parameters: &[("knots", "[[p_deg, half_gap_deg], ...], positions rising, gaps 0 to 0.1 rad (10 mm)")],
        confused_with: &["backlash"],
        decide_by: "reverse at five or more positions over the range",
        action: "local wear: replace the part, or work elsewhere in the range; a scheduled offset undoes it",
    },
    EffectInfo {
        name: "backlash_speed",
        stage: Stage::Gear,
        target: "joint",
        adds: "backlash whose gap depends on the TCP speed",
        equation: "play operator, b = half_gap + slope * commanded TCP speed, 0 or more",
        parameters: &[
            ("half_gap_deg", "at rest, 0 to 0.1 rad (10 mm)"),
            ("slope_deg_per_mm_s", "either sign, within 0.1 rad (10 mm) per m/s"),
        ],
        confused_with: &["backlash", "servo_lag"],
        decide_by: "reverse at three or more speeds",
        action: "identify and compensate at the working speed; check lubrication and preload",
    },
    EffectInfo {
        name: "hysteresis",
        stage: Stage::Gear,
        target: "joint",
        adds: "lost motion that builds up smoothly behind a reversal",
        equation: "-half_width z, dz/dp = (1 - z dir)/presliding (Dahl)",
        parameters: &[
            ("half_width_deg", "half of the loop, 0 to 0.1 rad (10 mm)"),
            ("presliding_deg", "travel over which 63 % of the turn-over builds up, above 0"),
        ],
        confused_with: &["backlash", "stiction"],
        decide_by: "reverse slowly, with ten or more rows inside the transition",
        action: "wind-up of belt, cable or wave gear: stiffen or preload; an offset of half a width in the direction of travel undoes most",
    },
    EffectInfo {
        name: "joint_zero_offset",
        stage: Stage::Link,
        target: "joint",
        adds: "the joint stands a constant off its command",
        equation: "offset",
        parameters: &[("offset_deg", "either sign, within 0.2 rad (50 mm)")],
        confused_with: &["tool_error", "link_error"],
        decide_by: "fix the registration by measuring the base (first joint); measure two reflectors on the tool (last joint)",
        action: "master the joint again, or enter the offset in the controller",
    },
    EffectInfo {
        name: "axis_coupling",
        stage: Stage::Link,
        target: "A6<-A5",
        adds: "a joint is turned along by another one",
        equation: "ratio * p of the other joint",
        parameters: &[("from", "the other joint"), ("ratio", "either sign, within 0.5")],
        confused_with: &["link_error", "encoder_scale"],
        decide_by: "move the other joint alone",
        action: "correct the coupling ratio in the controller",
    },
    EffectInfo {
        name: "gravity_compliance",
        stage: Stage::Link,
        target: "joint",
        adds: "the joint yields to gravity",
        equation: "compliance * gravity torque about the joint (positive turns it positive), from links and payload_kg",
        parameters: &[("compliance_deg_per_nm", "0 to 1e-3 rad/Nm (1e-4 m/N): a spring gives way along its load")],
        confused_with: &["joint_zero_offset", "link_error"],
        decide_by: "repeat the poses with another payload",
        action: "enter load data, use the controller's elasto-static correction, check the counterbalance",
    },
    EffectInfo {
        name: "link_error",
        stage: Stage::Geometry,
        target: "A2.a",
        adds: "a DH parameter differs from the robot file",
        equation: "a, d or alpha of a joint plus delta",
        parameters: &[("delta_mm or delta_deg", "either sign, within 50 mm or 0.1 rad")],
        confused_with: &["joint_zero_offset", "tool_error", "encoder_scale"],
        decide_by: "poses over the whole workspace, each joint through its range; parallel axes share their d",
        action: "enter the calibrated parameter, or correct poses with the calibrated kinematics",
    },
    EffectInfo {
        name: "tool_error",
        stage: Stage::Geometry,
        target: "tool",
        adds: "the TCP stands elsewhere in the flange frame",
        equation: "tool plus (x, y, z)",
        parameters: &[("x_mm, y_mm, z_mm", "either sign, within 200 mm")],
        confused_with: &["joint_zero_offset", "link_error"],
        decide_by: "turn the wrist about the TCP in three or more orientations; measure a second reflector",
        action: "measure the tool again and enter it",
    },
    EffectInfo {
        name: "thermal_drift",
        stage: Stage::Tcp,
        target: "tcp",
        adds: "the TCP creeps to another place",
        equation: "D (1 - exp(-t/tau)) in the base frame, t from the first row",
        parameters: &[("x_mm, y_mm, z_mm", "where it ends, within 10 mm"), ("tau_s", "1 s to 1e6 s")],
        confused_with: &["joint_zero_offset"],
        decide_by: "come back to one pose again and again over the whole log",
        action: "warm up before work, measure again when warm",
    },
    EffectInfo {
        name: "vibration",
        stage: Stage::Tcp,
        target: "tcp",
        adds: "the TCP swings along a direction",
        equation: "A sin(2 pi f t + phase), t from the first row",
        parameters: &[
            ("amplitude_um", "0 to 5,000 um"),
            ("frequency_hz", "0.01 to 1,000 Hz"),
            ("phase_deg", "within half a turn either way"),
            ("direction", "[x, y, z] in the base frame"),
        ],
        confused_with: &["transmission_error"],
        decide_by: "log while the robot stands; or move at two speeds",
        action: "find the source (fan, pump, resonance) and damp it; keep its frequency out of the motion",
    },
    EffectInfo {
        name: "time_offset",
        stage: Stage::Measurement,
        target: "log",
        adds: "the measurement shows the robot a moment earlier or later",
        equation: "measured(t) = robot(t + offset)",
        parameters: &[("offset_s", "either sign, within 10 s")],
        confused_with: &["servo_lag"],
        decide_by: "log the encoders; or move one joint at a time, at two speeds",
        action: "trigger tracker and controller from one signal; shift the times of the log",
    },
];
