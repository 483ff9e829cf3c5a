//! What URScript's own functions do: move, wait, or neither.
//!
//! Reference: Universal Robots, The URScript Programming Language (motion, internals, interfaces modules). A function that is
//! in no list here and not defined in the file may move the robot: the lists need not be complete to be safe.

use crate::script::PathKind;

/// A motion function and which of its arguments mean what.
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    pub path: PathKind,
    /// Parameters in order.
    pub parameters: &'static [&'static str],
    /// Default of `v`: rad/s for joint moves, else m/s.
    pub v: Option<f64>,
    pub kind: MotionKind,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionKind {
    Move,
    /// A set point of a stream, with its own time.
    Servo,
    /// By an arc or a process, no points on the way.
    Arc,
    /// Its end is in no argument.
    Velocity,
    /// Speeds and accelerations are shares of the largest.
    Optimised,
}

pub fn motion(name: &str) -> Option<Motion> {
    use MotionKind::*;
    let m = |path, parameters, v, kind| Some(Motion { path, parameters, v, kind });
    match name {
        "movej" => m(PathKind::Joint, &["q", "a", "v", "t", "r"], Some(1.05), Move),
        "movel" => m(PathKind::Linear, &["pose", "a", "v", "t", "r"], Some(0.25), Move),
        "movep" => m(PathKind::Linear, &["pose", "a", "v", "r"], Some(0.25), Move),
        "movec" => m(PathKind::Curve, &["pose_via", "pose_to", "a", "v", "r", "mode"], Some(0.25), Arc),
        "optimovej" => m(PathKind::Joint, &["q", "a", "v", "r"], None, Optimised),
        "optimovel" => m(PathKind::Linear, &["pose", "a", "v", "r"], None, Optimised),
        "servoj" => m(PathKind::Joint, &["q", "a", "v", "t", "lookahead_time", "gain"], None, Servo),
        "servoc" => m(PathKind::Curve, &["pose", "a", "v", "r"], None, Arc),
        "speedj" | "speedl" => m(PathKind::Curve, &["qd", "a", "t"], None, Velocity),
        _ => None,
    }
}

/// Functions that neither move the robot nor change what targets mean, beside those known by their first letters.
const QUIET: &str = "\
    abs acos asin assert atan atan2 binary_list_to_integer ceil configurable_digital_out cos d2r r2d exp \
    enter_critical exit_critical floor get integer_to_binary_list interpolate_pose length list_length log \
    make_list mean norm normalize point_dist pose_add pose_dist pose_inv pose_sub pose_trans pow powerup random \
    request_boolean_from_primary_client request_float_from_primary_client request_integer_from_primary_client \
    request_string_from_primary_client rotvec2rpy round rpy2rotvec sin size sqrt tan textmsg time to_num to_str \
    transpose wrench_trans xyz inv cross dot p not and or xor mod return if elif while run kill join switch case \
    halt popup sleep sync wait stopj stopl steptime conveyor_pulse_decode enable_external_ft_sensor \
    encoder_enable_pulse_decode encoder_enable_set_tick_count encoder_get_tick_count encoder_set_tick_count \
    encoder_unwind_delta_tick_count force force_mode_set_damping force_mode_set_gain_scaling ft_rtde_input_enable \
    pause_on_error_code position_deviation_warning powerdown set_base_acceleration set_conveyor_tick_count tool_contact";

/// Functions of the language after which it is not known where the joints come from, although they are no motion to a target.
const MOVES: [&str; 3] = ["direct_torque", "reset_revolution_counter", "set_pos"];

const QUIET_STARTS: &str = "\
    get_actual_ get_target_ get_joint_ get_tcp_ get_tool_ get_standard_ get_configurable_ get_digital_ get_analog_ \
    get_euromap_ get_inverse_kin get_forward_kin get_conveyor_ get_controller_ get_list_length get_steptime get_flag \
    get_freedrive_status get_jacobian get_mass_matrix get_gravity is_steady is_within_safety_limits \
    read_input_ read_output_ read_port_ write_output_ write_port_ socket_ set_digital set_analog set_standard set_configurable set_tool_digital \
    set_tool_voltage set_tool_analog set_tool_output set_tool_communication set_payload set_target_payload set_gravity set_flag \
    set_input_actions set_runstate set_safety set_target rtde_ modbus_ rpc_ str_ str_at popup zero_ftsensor";

/// First letters of functions that switch an output, read what is outside of the program, or wait for it.
const ACTS_STARTS: &str = "\
    set_ write_ read_ get_ socket_ rpc_ modbus_ rtde_ is_steady is_within request_ popup zero_ configurable_digital_out tool_contact force";

/// Functions that begin like these and compute.
const COMPUTES: &str = "get_inverse_kin get_forward_kin get_list_length get_steptime";

/// Whether it matters when a function is called: an output, a reading, a message.
pub fn acts(name: &str) -> bool {
    ACTS_STARTS.split_ascii_whitespace().any(|start| name.starts_with(start)) && !listed(COMPUTES, name)
}

/// Whether a name stands in a list of names with blanks between them.
fn listed(list: &str, name: &str) -> bool {
    list.split_ascii_whitespace().any(|n| n == name)
}

pub fn is_quiet(name: &str) -> bool {
    listed(QUIET, name) || QUIET_STARTS.split_ascii_whitespace().any(|start| name.starts_with(start))
}

/// Functions from which on forces, a conveyor or an offset move the robot beside its targets (their names), and those that
/// end it (`None`).
pub fn leads(name: &str) -> Option<Option<&'static str>> {
    const ON: [&str; 7] = [
        "force_mode",
        "track_conveyor_linear",
        "track_conveyor_circular",
        "path_offset_enable",
        "freedrive_mode",
        "teach_mode",
        "screw_driving",
    ];
    match name {
        "end_force_mode"
        | "stop_conveyor_tracking"
        | "path_offset_disable"
        | "end_freedrive_mode"
        | "end_teach_mode"
        | "end_screw_driving" => Some(None),
        _ => ON.iter().find(|on| **on == name).map(|on| Some(*on)),
    }
}

/// Whether a function of the language moves the robot, begins or ends to lead it, or makes other joint values of where it stands.
pub fn moves(name: &str) -> bool {
    motion(name).is_some() || leads(name).is_some() || MOVES.contains(&name)
}

/// Functions at which the robot stands and waits.
pub fn is_wait(name: &str) -> bool {
    matches!(name, "sleep" | "sync" | "stopj" | "stopl" | "popup" | "wait") || name.starts_with("request_")
}

pub fn is_reserved(word: &str) -> bool {
    const WORDS: &[&str] = &[
        "and", "break", "case", "continue", "def", "default", "elif", "else", "end", "false", "global", "halt", "if",
        "join", "kill", "local", "mod", "not", "or", "p", "return", "run", "sec", "struct", "switch", "thread", "true",
        "while", "xor",
    ];
    WORDS.contains(&word.to_ascii_lowercase().as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_leads_away_has_its_end() {
        for on in ["force_mode", "freedrive_mode", "teach_mode", "screw_driving"] {
            assert!(leads(on).is_some_and(|by| by == Some(on)) && leads(&format!("end_{on}")) == Some(None), "{on}");
        }
    }

    #[test]
    fn a_name_that_only_begins_like_a_query_is_none() {
        let moving = ["get_part", "is_part_there", "read_place", "write_home"];
        let quiet = ["get_actual_tcp_pose", "get_inverse_kin", "is_steady", "read_input_integer_register"];
        let of_language =
            ["set_base_acceleration", "encoder_enable_pulse_decode", "set_conveyor_tick_count", "tool_contact"];
        assert!(of_language.iter().all(|n| is_quiet(n) && !moves(n)) && is_quiet("set_tool_analog_input_domain"));
        assert!(moves("reset_revolution_counter") && !is_quiet("reset_revolution_counter"));
        assert!(moving.iter().all(|n| !is_quiet(n)) && quiet.iter().all(|n| is_quiet(n)));
    }
}
