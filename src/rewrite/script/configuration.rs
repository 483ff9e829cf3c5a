//! Configurations as makers write them, against joints: which joints a configuration allows.
//!
//! Conventions, from the makers' documents:
//! - KUKA (System Software, Operating and Programming Instructions for System Integrators, status and turn): status bit 0 is set
//!   where the wrist's centre lies behind axis 1 (overhead area), bit 1 where A3 is bent beyond the angle at which wrist, elbow
//!   and shoulder lie on a line, bit 2 where A5 is below zero. Turn bit n is set where axis n + 1 is below zero.
//! - ABB (RAPID Instructions, Functions and Data types, confdata): cf1, cf4, cf6 are the quarters of a turn in which axes 1, 4, 6
//!   stand (0: 0 to 90 deg, -1: -90 to 0 deg). cfx counts 4 for a wrist behind axis 1, 2 for one behind the lower arm, 1 for a
//!   negative axis 5. Controllers of robots without cfx write 0 there, so it decides only between joints in the same quarters.
//!   On linear and circular ways the robot goes to the nearest joints whatever is written (RAPID Reference Manual, Basic characteristics,
//!   robot configuration), and the check of the configuration allows a difference of one in cf1, cf4 and cf6, and none in cfx
//!   (RobotStudio API, `ConfigurationMode.Compliant`).
//! - FANUC (operator's manuals, configuration of a position): T in front of axis 1, B behind; U elbow up, D down; F and N are
//!   the two signs of J5; the turn numbers of J1, J4, J6 are 0 within half a turn, 1 and -1 for the turn beyond. Which sign
//!   is F is a property of the model ([`Flip`]), so that letter chooses only where the joints before do not. For a symmetrical half gap
//!   the pose with its offset is the same with either wrist: J5 changes its sign and its direction at once.
//! - Yaskawa (NX100 instructions, manipulator types): front or rear of the S axis, upper or lower arm, and whether R, T, S stand
//!   beyond half a turn. Flip is where -90 < R <= 90 deg (by whole turns); later controllers and public jobs use the bit
//!   otherwise, so that it chooses as FANUC's letter does.
//!
//! Behind axis 1 makers differ in what an elbow up is: there FANUC's and Yaskawa's elbow does not choose.

use crate::program::script::pose::Configuration;
use crate::robot::{Arm, Flip};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Joints that keep so far from a border are not near it, and joints beyond it by less stand on it, rad: digits of programs.
pub const CLEAR: f64 = 2e-5;

/// Joints against a configuration: `slack` widens its borders (rad, m and sines); negative: the joints must keep clear of them.
pub fn allows(configuration: &Configuration, arm: &Arm, q: &[f64], slack: f64) -> bool {
    stands(configuration, arm, q, slack)
        && q.iter().enumerate().all(|(axis, v)| allows_axis(configuration, axis, *v, slack))
}

/// The signs that several joints make together, or that joint 5 makes by its sine: front, elbow, wrist.
pub fn stands(configuration: &Configuration, arm: &Arm, q: &[f64], slack: f64) -> bool {
    let posture = arm.posture(q);
    let front = |wanted: bool| posture.is_none_or(|p| side(p.front_m, wanted, slack));
    let elbow = |wanted: bool| posture.is_none_or(|p| side(p.elbow, wanted, slack));
    match *configuration {
        Configuration::Kuka { status, .. } => {
            // beyond half a turn the wrist is the other one
            let wrist = |s: u8| q.get(4).is_none_or(|v| side(v.sin(), s & 4 == 0, slack));
            status.is_none_or(|s| front(s & 1 == 0) && elbow(s & 2 == 2) && wrist(s))
        }
        Configuration::Abb { .. } => true,
        Configuration::Fanuc { up, front: in_front, .. } => front(in_front) && (!in_front || elbow(up)),
        Configuration::Yaskawa { lower, rear, .. } => front(!rear) && (rear || elbow(!lower)),
    }
}

/// Whether a joint motion goes to these joints whatever the joints before are: KUKA's where status and turn are both given (PTP: Operating
/// and Programming Instructions, status and turn), the others always.
pub fn determines(configuration: &Configuration) -> bool {
    match *configuration {
        Configuration::Kuka { status, turn } => status.is_some() && turn.is_some(),
        Configuration::Abb { .. } | Configuration::Fanuc { .. } | Configuration::Yaskawa { .. } => true,
    }
}

/// One joint against what a configuration says of it alone: its sign, quarter or turn.
pub fn allows_axis(configuration: &Configuration, axis: usize, v: f64, slack: f64) -> bool {
    let [lo, hi] = range(configuration, axis, v, false);
    (lo - slack..=hi + slack).contains(&v)
}

/// Whether a straight way or an arc may end at joints although their configuration is another one, where the controller checks
/// configurations. ABB's robots go on to the nearest joints on such ways whatever is written, and the check stops the program only where
/// axes 1, 4, 6 are further than a quarter from theirs, or where cfx differs.
pub fn tolerates(configuration: &Configuration, arm: &Arm, q: &[f64], slack: f64) -> bool {
    matches!(configuration, Configuration::Abb { .. })
        && prefers(configuration, arm, q, None)
        && q.iter().enumerate().all(|(axis, v)| tolerates_axis(configuration, axis, *v, slack))
}

/// One joint of [`tolerates`]. `slack` widens its own quarter and narrows those next to it, rad.
pub fn tolerates_axis(configuration: &Configuration, axis: usize, v: f64, slack: f64) -> bool {
    let [lo, hi] = range(configuration, axis, v, true);
    allows_axis(configuration, axis, v, slack) || (lo + slack..=hi - slack).contains(&v)
}

/// Where a joint at `v` may stand by what a configuration says of it alone, rad; of two such ranges the one on its side. `on_way`: at the
/// end of a straight way or an arc, where a joint that stands in a quarter next to that of the configuration is [tolerated](tolerates).
pub fn range(configuration: &Configuration, axis: usize, v: f64, on_way: bool) -> [f64; 2] {
    const ANY: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
    const POSITIVE: [f64; 2] = [0.0, f64::INFINITY];
    const NEGATIVE: [f64; 2] = [f64::NEG_INFINITY, 0.0];
    // axes 1, 4 and 6, in this order
    let of = |list: [usize; 3]| list.iter().position(|a| *a == axis);
    match *configuration {
        Configuration::Kuka { turn, .. } => turn.map_or(ANY, |t| if t >> axis & 1 == 0 { POSITIVE } else { NEGATIVE }),
        Configuration::Abb { quarters, .. } => of([0, 3, 5]).map_or(ANY, |k| {
            let from = f64::from(quarters[k]) * FRAC_PI_2;
            let beyond = v < from - CLEAR || v > from + FRAC_PI_2 + CLEAR;
            let next = if on_way && beyond { FRAC_PI_2 } else { 0.0 };
            [from - next, from + FRAC_PI_2 + next]
        }),
        Configuration::Fanuc { turns, .. } => of([0, 3, 5]).map_or(ANY, |k| {
            let middle = f64::from(turns[k]) * TAU;
            [middle - PI, middle + PI]
        }),
        Configuration::Yaskawa { beyond, .. } => of([3, 5, 0]).map_or(ANY, |k| match beyond[k] {
            false => [-PI, PI],
            true if v < 0.0 => [f64::NEG_INFINITY, -PI],
            true => [PI, f64::INFINITY],
        }),
    }
}

/// On the wanted side of zero.
fn side(value: f64, positive: bool, slack: f64) -> bool {
    if positive { value >= -slack } else { value <= slack }
}

/// What the letter or number of a configuration for the wrist may mean, the most frequent first; empty: it has none, or that is no
/// question.
pub fn flips(configuration: &Configuration) -> &'static [Flip] {
    match configuration {
        Configuration::Fanuc { .. } => &Flip::OF_FANUC,
        Configuration::Yaskawa { .. } => &Flip::OF_YASKAWA,
        Configuration::Kuka { .. } | Configuration::Abb { .. } => &[],
    }
}

/// Whether the letter of a configuration says that the wrist is flipped.
pub fn says_flipped(configuration: &Configuration) -> Option<bool> {
    match *configuration {
        Configuration::Fanuc { flip, .. } => Some(flip),
        Configuration::Yaskawa { no_flip, .. } => Some(!no_flip),
        Configuration::Kuka { .. } | Configuration::Abb { .. } => None,
    }
}

/// What the letter of a configuration means; `known`: by the robot file or the program.
fn meaning(configuration: &Configuration, known: Option<Flip>) -> Option<Flip> {
    known.or_else(|| flips(configuration).first().copied())
}

/// Whether joints that are [allowed](allows) are those that the rest of the configuration prefers; `flip`: what its letter for the wrist
/// means, where that is known.
pub fn prefers(configuration: &Configuration, arm: &Arm, q: &[f64], flip: Option<Flip>) -> bool {
    let Some(posture) = arm.posture(q) else { return true };
    match *configuration {
        Configuration::Abb { cfx, .. } => {
            let is = 4 * i32::from(posture.front_m < 0.0) + 2 * i32::from(posture.elbow < 0.0);
            is + i32::from(q.get(4).is_some_and(|v| v.sin() < 0.0)) == cfx
        }
        Configuration::Fanuc { .. } | Configuration::Yaskawa { .. } => {
            let is = meaning(configuration, flip).and_then(|f| f.is_flipped(q));
            is.is_none() || is == says_flipped(configuration)
        }
        Configuration::Kuka { .. } => true,
    }
}

/// The configuration of joints, as the maker of `like` writes it; what `like` leaves out is left out. `None`: an arm without a
/// spherical wrist, or axes that the configuration does not know. Where models differ and `flip` does not say it, the letter is that of
/// most.
pub fn of(like: &Configuration, arm: &Arm, q: &[f64], flip: Option<Flip>) -> Option<Configuration> {
    let posture = arm.posture(q)?;
    let &[a1, .., a4, a5, a6] = q else { return None };
    if q.len() != 6 {
        return None;
    }
    let (rear, bent) = (posture.front_m < 0.0, posture.elbow < 0.0);
    let negative_wrist = a5.sin() < 0.0;
    let flipped = meaning(like, flip).and_then(|f| f.is_flipped(q)).unwrap_or_default();
    Some(match *like {
        Configuration::Kuka { status, turn } => {
            let bits = |bits: &[bool]| bits.iter().enumerate().map(|(k, b)| u8::from(*b) << k).sum();
            let signs: Vec<bool> = q.iter().map(|v| *v < 0.0).collect();
            Configuration::Kuka {
                status: status.map(|_| bits(&[rear, !bent, negative_wrist])),
                turn: turn.map(|_| bits(&signs)),
            }
        }
        Configuration::Abb { .. } => {
            let quarter = |v: f64| ((v + ON_BORDER_RAD) / FRAC_PI_2).floor() as i32;
            let cfx = 4 * i32::from(rear) + 2 * i32::from(bent) + i32::from(negative_wrist);
            Configuration::Abb { quarters: [a1, a4, a6].map(quarter), cfx }
        }
        Configuration::Fanuc { .. } => Configuration::Fanuc {
            flip: flipped,
            up: !bent,
            front: !rear,
            turns: [a1, a4, a6].map(|v| (v / TAU).round() as i32),
        },
        Configuration::Yaskawa { .. } => {
            let beyond = [a4, a6, a1].map(|v| v.abs() > PI);
            Configuration::Yaskawa { no_flip: !flipped, lower: bent, rear, beyond }
        }
    })
}

/// Joints that stand on a border of a quarter up to rounding stand beyond it, rad.
const ON_BORDER_RAD: f64 = 1e-6;

/// How far joints are from a configuration that only tells how a point was taught: angles by which they leave its quarters, and
/// [`LETTER_RAD`] for each other posture; `None`: not a measure for this maker.
pub fn misfit(configuration: &Configuration, arm: &Arm, q: &[f64]) -> Option<f64> {
    let Configuration::Abb { quarters, cfx } = *configuration else { return None };
    let outside = |(quarter, axis): (i32, usize)| {
        let (from, v) = (f64::from(quarter) * FRAC_PI_2, q.get(axis)?);
        Some((from - v).max(v - from - FRAC_PI_2).max(0.0))
    };
    let angles: f64 = quarters.into_iter().zip([0, 3, 5]).map(outside).sum::<Option<f64>>()?;
    let posture = arm.posture(q)?;
    let is = [posture.front_m < 0.0, posture.elbow < 0.0, q.get(4)?.sin() < 0.0];
    let other = is.iter().zip([4, 2, 1]).filter(|(is, bit)| **is != (cfx & bit != 0)).count();
    Some(angles + LETTER_RAD * other as f64)
}

/// See [`misfit`].
const LETTER_RAD: f64 = 1.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::Robot;

    fn arm(text: &str) -> (Robot, Arm) {
        let robot = Robot::parse("r", text).unwrap();
        let arm = Arm::of(&robot).unwrap();
        (robot, arm)
    }

    fn deg(q: [f64; 6]) -> Vec<f64> {
        q.iter().map(|v| v.to_radians()).collect()
    }

    /// KUKA's home position and the same point over the head; S and T as controllers write them ("S 2, T 2" at A2 < 0 < A3, A5).
    #[test]
    fn kuka_s_status_and_turn_name_overhead_elbow_wrist_and_signs() {
        let (_, arm) = arm(include_str!("../../../configs/kuka-kr120-r2500-pro.yaml"));
        let kuka = |status, turn| Configuration::Kuka { status: Some(status), turn: Some(turn) };
        let home = deg([5.0, -90.0, 90.0, 10.0, 45.0, 10.0]);
        assert!(allows(&kuka(2, 2), &arm, &home, 0.0));
        for (s, t) in [(3, 2), (0, 2), (6, 2), (2, 3), (2, 0), (2, 34)] {
            assert!(!allows(&kuka(s, t), &arm, &home, 0.0), "S {s}, T {t}");
        }
        // A1 turned by half a turn and the arm thrown back over the head
        let over = deg([-175.0, -150.0, -60.0, 10.0, -45.0, 10.0]);
        assert!(arm.posture(&over).unwrap().front_m < 0.0);
        assert!(allows(&kuka(0b101, 0b010111), &arm, &over, 0.0));
    }

    /// The configuration named for joints is one that the same joints are allowed and preferred in, for every maker.
    #[test]
    fn the_configuration_of_joints_allows_them() {
        let (_, arm) = arm(include_str!("../../../configs/kuka-kr120-r2500-pro.yaml"));
        let makers = [
            Configuration::Kuka { status: Some(0), turn: Some(0) },
            Configuration::Abb { quarters: [0; 3], cfx: 0 },
            Configuration::Fanuc { flip: false, up: true, front: true, turns: [0; 3] },
            Configuration::Yaskawa { no_flip: false, lower: false, rear: false, beyond: [false; 3] },
        ];
        for k in 0..200u32 {
            let at = |joint: u32| f64::from((k * 37 + joint * 101 + k * joint * 13) % 347) - 173.0;
            let q = deg([at(0), 0.5 * at(1) - 45.0, 0.8 * at(2), 1.9 * at(3), 0.7 * at(4), 1.9 * at(5)]);
            for like in &makers {
                let own = of(like, &arm, &q, None).unwrap();
                assert!(allows(&own, &arm, &q, 1e-5) && prefers(&own, &arm, &q, None), "{own} of {q:?}");
            }
        }
    }

    /// ABB's own example of quarters, and KUKA's home position: the words of the languages.
    #[test]
    fn configurations_are_written_as_in_their_languages() {
        let (_, arm) = arm(include_str!("../../../configs/kuka-kr120-r2500-pro.yaml"));
        let home = deg([5.0, -90.0, 90.0, 10.0, 45.0, -100.0]);
        let text = |like: Configuration| of(&like, &arm, &home, None).unwrap().to_string();
        assert_eq!(text(Configuration::Kuka { status: Some(0), turn: Some(0) }), "S 2, T 34");
        assert_eq!(text(Configuration::Abb { quarters: [0; 3], cfx: 0 }), "[0,0,-2,0]");
        assert_eq!(
            text(Configuration::Fanuc { flip: false, up: false, front: false, turns: [1; 3] }),
            "'F U T, 0, 0, 0'"
        );
        let yaskawa = Configuration::Yaskawa { no_flip: true, lower: true, rear: true, beyond: [true; 3] };
        assert_eq!(text(yaskawa), "RCONF 0,0,0,0,0,0");
    }

    /// Files made from robot descriptions often begin in a frame that stands on its head, and arms may hang from a ceiling: what a
    /// configuration names are the joints, whatever `base` says. Home poses with the forearm level in front, elbow up.
    #[test]
    fn the_elbow_of_every_bundled_arm_is_up_at_home_wherever_its_base_is() {
        let home = |name: &str| match name.split('-').next() {
            Some("kuka") => Some([5.0, -90.0, 90.0, 10.0, 45.0, 10.0]),
            Some("abb" | "fanuc" | "motoman") => Some([5.0, 0.0, 0.0, 10.0, -45.0, 10.0]),
            Some("staubli") => Some([5.0, 0.0, 90.0, 10.0, 45.0, 10.0]),
            _ => None,
        };
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
        let mut seen = 0;
        for file in std::fs::read_dir(folder).unwrap().map(|f| f.unwrap()) {
            let name = file.file_name().into_string().unwrap();
            let Some(q) = home(&name).filter(|_| name.ends_with(".yaml")).map(deg) else { continue };
            let text = std::fs::read_to_string(file.path()).unwrap();
            let Ok(mut robot) = Robot::parse(&name, &text) else { continue };
            for turn in [0.0, 180.0, 100.0] {
                let by = nalgebra::UnitQuaternion::from_euler_angles(f64::to_radians(turn), 0.3, 0.2);
                robot.base = nalgebra::Isometry3::from_parts(robot.base.translation, by * robot.base.rotation);
                let robot = robot.with_geometry(robot.joints.clone(), robot.tool);
                let Some(arm) = Arm::of(&robot).filter(|a| a.posture(&q).is_some()) else { continue };
                let p = arm.posture(&q).unwrap();
                assert!(p.front_m > 0.1 && p.elbow > 0.5, "{name} at {turn} deg: {p:?}");
                seen += 1;
                let kuka = Configuration::Kuka { status: Some(2), turn: Some(2) };
                assert!(!name.starts_with("kuka") || allows(&kuka, &arm, &q, 0.0), "{name}");
            }
        }
        assert!(seen > 60, "{seen}");
    }

    /// ABB: [0, -1, 1, 0] is axis 1 in its first quarter, axis 4 just below zero, axis 6 in the second quarter, all in front.
    #[test]
    fn abb_s_configuration_names_quarters_then_postures() {
        let (_, arm) = arm(include_str!("../../../configs/abb-irb1600-6-145.yaml"));
        let conf = |cf1, cf4, cf6, cfx| Configuration::Abb { quarters: [cf1, cf4, cf6], cfx };
        let q = deg([30.0, 10.0, 5.0, -20.0, 40.0, 100.0]);
        assert!(allows(&conf(0, -1, 1, 0), &arm, &q, 0.0) && prefers(&conf(0, -1, 1, 0), &arm, &q, None));
        assert!(!allows(&conf(0, 0, 1, 0), &arm, &q, 0.0) && !allows(&conf(-1, -1, 1, 0), &arm, &q, 0.0));
        assert!(!prefers(&conf(0, -1, 1, 1), &arm, &q, None) && !prefers(&conf(0, -1, 1, 4), &arm, &q, None));
        // the wrist turned over: axis 5 negative
        assert!(prefers(&conf(0, 1, -1, 1), &arm, &deg([30.0, 10.0, 5.0, 160.0, -40.0, -80.0]), None));
    }

    #[test]
    fn straight_ways_of_abb_may_end_a_quarter_off_and_not_in_another_posture() {
        let (_, arm) = arm(include_str!("../../../configs/abb-irb1600-6-145.yaml"));
        let conf = |cf1, cf4, cf6, cfx| Configuration::Abb { quarters: [cf1, cf4, cf6], cfx };
        let q = deg([30.0, 10.0, 5.0, -20.0, 40.0, 100.0]);
        let tolerated = |c: Configuration| tolerates(&c, &arm, &q, 2e-3);
        assert!(tolerated(conf(0, -1, 1, 0)) && tolerated(conf(-1, 0, 2, 0)) && tolerated(conf(1, -2, 0, 0)));
        assert!(!tolerated(conf(2, -1, 1, 0)) && !tolerated(conf(0, 1, 1, 0)) && !tolerated(conf(0, -1, -1, 0)));
        assert!(!tolerated(conf(0, 0, 1, 1)) && !tolerated(conf(0, 0, 1, 4)));
        // on the far border of the quarter next to its own
        assert!(!tolerates(&conf(1, -1, 1, 0), &arm, &deg([0.01, 10.0, 5.0, -20.0, 40.0, 100.0]), 2e-3));
        // other makers check nothing of the kind, or say nothing of it
        for own in [
            Configuration::Kuka { status: None, turn: Some(0b001000) },
            Configuration::Fanuc { flip: true, up: true, front: true, turns: [0; 3] },
            Configuration::Yaskawa { no_flip: false, lower: false, rear: false, beyond: [false; 3] },
        ] {
            assert!(allows(&own, &arm, &q, 1e-5) && !tolerates(&own, &arm, &q, 2e-3), "{own}");
        }
    }

    /// FANUC: a pendant's (0, 0, 0, 0, -90, 0) reads 'N U T, 0, 0, 0'.
    #[test]
    fn fanuc_s_letters_name_wrist_elbow_and_front_and_its_numbers_turns() {
        let (_, arm) = arm(include_str!("../../../configs/fanuc-m10ia.yaml"));
        let conf = |flip, up, front, turns| Configuration::Fanuc { flip, up, front, turns };
        let home = deg([0.0, 0.0, 0.0, 0.0, -90.0, 0.0]);
        assert!(allows(&conf(false, true, true, [0; 3]), &arm, &home, 0.0));
        assert!(prefers(&conf(false, true, true, [0; 3]), &arm, &home, None));
        assert!(!prefers(&conf(true, true, true, [0; 3]), &arm, &home, None));
        assert!(!allows(&conf(false, false, true, [0; 3]), &arm, &home, 0.0));
        assert!(!allows(&conf(false, true, false, [0; 3]), &arm, &home, 0.0));
        let wound = deg([0.0, 0.0, 0.0, 0.0, -90.0, 200.0]);
        assert!(allows(&conf(false, true, true, [0, 0, 1]), &arm, &wound, 0.0));
        assert!(!allows(&conf(false, true, true, [0; 3]), &arm, &wound, 0.0));
    }

    /// Yaskawa: at home R is at 0, so the wrist is "flip" (0), the arm upper (0) and front (0).
    #[test]
    fn yaskawa_s_type_names_r_axis_arm_and_turns() {
        let (_, arm) = arm(include_str!("../../../configs/motoman-ma2010.yaml"));
        let conf = |no_flip, lower, rear, beyond| Configuration::Yaskawa { no_flip, lower, rear, beyond };
        let home = deg([0.0, 0.0, 0.0, 0.0, -90.0, 0.0]);
        assert!(allows(&conf(false, false, false, [false; 3]), &arm, &home, 0.0));
        assert!(prefers(&conf(false, false, false, [false; 3]), &arm, &home, None));
        assert!(!prefers(&conf(true, false, false, [false; 3]), &arm, &home, None));
        assert!(!allows(&conf(false, true, false, [false; 3]), &arm, &home, 0.0));
        assert!(!allows(&conf(false, false, true, [false; 3]), &arm, &home, 0.0));
        let turned = deg([0.0, 0.0, 0.0, 120.0, 40.0, 190.0]);
        assert!(allows(&conf(true, false, false, [false, true, false]), &arm, &turned, 0.0));
    }
}
