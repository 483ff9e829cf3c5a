//! All effects, in the order of the chain: one line each.

use super::*;

/// The catalogue. An effect that is added stands here.
pub static ALL: &[&EffectInfo] = &[
    &servo_lag::INFO,
    &stiction::INFO,
    &encoder_scale::INFO,
    &transmission_error::INFO,
    &backlash::INFO,
    &backlash_position::INFO,
    &backlash_speed::INFO,
    &loaded_play::INFO,
    &hysteresis::INFO,
    &joint_zero_offset::INFO,
    &axis_coupling::INFO,
    &gravity_compliance::INFO,
    &process_force::INFO,
    &torque_windup::INFO,
    &torque_hysteresis::INFO,
    &coupled_play::INFO,
    &bearing_wobble::INFO,
    &empirical::INFO,
    &link_error::INFO,
    &thermal_growth::INFO,
    &tool_error::INFO,
    &base_tilt::INFO,
    &thermal_drift::INFO,
    &vibration::INFO,
    &time_offset::INFO,
    &tracker_scale::INFO,
    &tracker_refraction::INFO,
    &tracker_frame::INFO,
];

/// Forms of effects that have keys and their own equation.
pub static FORMS: &[&EffectForm] =
    &[&presliding_stiction::FORM, &transmission_error::FADING, &maxwell_slip::FORM, &free_mass_gravity::FORM];

/// An effect by its name, or `None` where the catalogue has no such name.
pub fn find(name: &str) -> Option<&'static EffectInfo> {
    ALL.iter().find(|e| e.name == name).copied()
}

/// An effect of the catalogue, by [`Effect::name`].
///
/// # Panics
/// For another name; [`find`] is for names from outside.
pub fn of(name: &str) -> &'static EffectInfo {
    match find(name) {
        Some(info) => info,
        None => unreachable!("the catalogue has every effect that is made, but not {name}"),
    }
}

/// Names of all effects, for messages.
pub fn names() -> String {
    ALL.iter().map(|e| e.name).collect::<Vec<_>>().join(", ")
}
