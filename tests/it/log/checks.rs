//! Plausibility checks of measured logs: quiet on good ones, and what they note or refuse of others.

use super::{parse, robot};
use lostmotion::log::{Log, plausibility};
use lostmotion::robot::{JointKind, Robot};
use nalgebra::{Rotation3, Vector3};
use rand::{Rng, SeedableRng};

/// A log of the KUKA in a turned frame: `path(i)` in degrees, noise in m.
fn measured(rows: usize, noise_m: f64, path: impl Fn(f64) -> [f64; 6]) -> Log {
    let robot = robot();
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
    let turn = Rotation3::from_euler_angles(0.1, -0.3, 2.0);
    let mut log = parse(
        "t_s,cmd_A1_deg,cmd_A2_deg,cmd_A3_deg,cmd_A4_deg,cmd_A5_deg,cmd_A6_deg,x_mm,y_mm,z_mm\n0,0,0,0,0,0,0,0,0,0\n",
        &robot,
    );
    log.t_s = (0..rows).map(|i| i as f64 * 0.04).collect();
    log.line = (0..rows as u32).map(|i| i + 2).collect();
    log.cmd = vec![Vec::new(); 6];
    log.tcp_m.clear();
    for i in 0..rows {
        let q = path(i as f64 / rows as f64).map(f64::to_radians);
        for (column, v) in log.cmd.iter_mut().zip(q) {
            column.push(v);
        }
        let jitter = Vector3::from_fn(|_, _| noise_m * (rng.random::<f64>() - 0.5) * 3.46);
        log.tcp_m.push(Some(turn * robot.tcp_m(&q) + Vector3::new(1.0, 2.0, 3.0) + jitter));
    }
    log
}

fn six(s: f64) -> [f64; 6] {
    let w = |k: f64, a: f64| a * (std::f64::consts::TAU * k * s + k).sin();
    [w(1.0, 20.0), -80.0 + w(2.0, 10.0), 85.0 + w(3.0, 12.0), w(2.0, 30.0), 30.0 + w(1.0, 20.0), w(3.0, 60.0)]
}

#[test]
fn hygiene_is_quiet_on_a_good_log() {
    let found = plausibility::check(&measured(2000, 1e-5, six), &robot()).unwrap();
    assert!(found.notes.is_empty(), "{:?}", found.notes);
    assert!(found.misfit_m.unwrap() < 3e-5 && found.spread_m > 0.2);
}

#[test]
fn hygiene_says_nothing_where_the_travel_is_short() {
    // a tenth of a millimetre of travel in noise of 30 um: no scale can be seen in it
    let short = |s: f64| [0.003 * (20.0 * s).sin(), -80.0, 85.0 + 0.002 * (31.0 * s).cos(), 0.0, 0.0, 0.0];
    assert!(plausibility::check(&measured(500, 3e-5, short), &robot()).unwrap().notes.is_empty());
    assert!(plausibility::check(&measured(5, 1e-5, six), &robot()).is_ok());
    assert!(plausibility::check(&measured(500, 1e-5, |_| [0.0; 6]), &robot()).is_ok());
}

/// Zero offsets, a wrong tool, outliers and drift are the business of effects and robust fits, not of plausibility checks.
#[test]
fn hygiene_does_not_mistake_an_effect_for_a_unit() {
    let robot = robot();
    for axis in 0..6 {
        for offset_deg in [0.1_f64, 1.0, 5.0] {
            for (name, path) in [
                ("six axes", six as fn(f64) -> [f64; 6]),
                ("A4 alone", |s| [0.0, -52.0, 58.0, 340.0 * s - 170.0, 0.0, 0.0]),
            ] {
                let mut log = measured(400, 1e-5, path);
                log.cmd[axis].iter_mut().for_each(|v| *v += offset_deg.to_radians());
                plausibility::check(&log, &robot)
                    .unwrap_or_else(|e| panic!("{name}, axis {axis} by {offset_deg} deg: {e}"));
            }
        }
    }
    let mut wild = measured(1000, 1e-5, six);
    wild.tcp_m.iter_mut().step_by(9).for_each(|p| *p = p.map(|p| p + Vector3::new(0.5, -0.4, 0.3)));
    assert!(plausibility::check(&wild, &robot).is_ok());
    let mut other_tool = robot.clone();
    let tool = nalgebra::Isometry3::translation(0.25, -0.1, 0.3);
    other_tool = Robot::new(other_tool.name, other_tool.convention, other_tool.joints, other_tool.base, tool);
    assert!(plausibility::check(&measured(1000, 1e-5, six), &other_tool).is_ok());
}

#[test]
fn hygiene_refuses_a_path_of_another_robot() {
    let mut other = robot();
    let mut joints = other.joints.clone();
    for (j, d) in joints.iter_mut().zip([0.0, -0.6, 0.4, -0.8, 0.0, 0.0]) {
        j.a_m += d;
        j.alpha_rad += d;
    }
    other = Robot::new(other.name, other.convention, joints, other.base, other.tool);
    let refused = plausibility::check(&measured(1000, 1e-5, six), &other).unwrap_err().to_string();
    assert!(refused.contains("another shape"), "{refused}");
}

#[test]
fn hygiene_sees_clocks_apart() {
    let mut log = measured(2000, 1e-5, six);
    log.tcp_m.rotate_right(5);
    log.tcp_m[..5].fill(None);
    let found = plausibility::check(&log, &robot()).unwrap();
    assert!(found.notes.iter().any(|n| n.to_string().contains("about 0.20 s behind")), "{:?}", found.notes);
    log.tcp_m.rotate_right(45);
    log.tcp_m[..50].fill(None);
    let refused = plausibility::check(&log, &robot()).unwrap_err().to_string();
    assert!(refused.contains("about 2.00 s behind") && refused.contains("one clock"), "{refused}");
}

/// Recordings of one test that were started by hand, one half a minute after the other.
#[test]
fn hygiene_sees_clocks_that_are_far_apart() {
    // A2 goes to places 10 deg apart, up and down again, with a rest of 16 s at each: 50 rests in 800 s
    let tour = |s: f64| {
        let rest = (50.0 * s).floor();
        let way = ((50.0 * s - rest) * 5.0).min(1.0);
        let place = |k: f64| 10.0 * (k % 8.0 - 4.0).abs();
        [0.0, -80.0 + place(rest) + way * (place(rest + 1.0) - place(rest)), 85.0, 10.0, 20.0, 30.0]
    };
    for shift_s in [15.0, 30.0] {
        let mut log = measured(20_000, 1e-5, tour);
        // a sensor behind the gear, half a half gap off its commands
        let late = |rows: usize| -> Vec<Option<f64>> {
            let seen = log.cmd[1].iter().map(|v| v + 1e-4);
            std::iter::repeat_n(None, rows).chain(seen.map(Some)).take(log.len()).collect()
        };
        let sensors = [0, 5, 25].map(late);
        for (column, refused) in sensors.into_iter().zip([false, false, true]) {
            let mut log = log.clone();
            log.tcp_m.fill(None);
            log.meas = vec![None; 6];
            log.meas[1] = Some(column);
            let found = plausibility::check(&log, &robot());
            assert_eq!(found.is_err(), refused, "{found:?}");
            let right = |e: lostmotion::error::Error| e.to_string().contains("`meas_A2_deg` about 1.00 s behind");
            assert!(found.err().is_none_or(right));
        }
        // of a sensor of the wrong sign half a period would be a shift, too
        let mut reversed = log.clone();
        reversed.tcp_m.fill(None);
        reversed.meas = vec![None; 6];
        reversed.meas[1] = Some(log.cmd[1].iter().map(|v| Some(-v)).collect());
        let notes = plausibility::check(&reversed, &robot()).unwrap().notes;
        assert!(notes.iter().any(|n| n.to_string().contains("wrong sign")), "{notes:?}");
        let rows = (shift_s / 0.04) as usize;
        log.tcp_m.rotate_right(rows);
        log.tcp_m[..rows].fill(None);
        let refused = plausibility::check(&log, &robot()).unwrap_err().to_string();
        assert!(refused.contains("ten seconds or more") && refused.contains("one clock"), "{refused}");
    }
}

#[test]
fn hygiene_compares_encoders_with_commands() {
    let good = measured(500, 1e-5, six);
    let with = |factor: f64, offset: f64| {
        let mut log = good.clone();
        log.enc[0] = Some(log.cmd[0].iter().map(|v| Some(v * factor + offset)).collect());
        log
    };
    assert!(plausibility::check(&with(1.0, 1e-5), &robot()).unwrap().notes.is_empty());
    let refused =
        plausibility::check(&with(JointKind::Revolute.si_per_user_unit(), 0.0), &robot()).unwrap_err().to_string();
    assert!(refused.contains("enc_A1_deg") && refused.contains("radians"), "{refused}");
    let against = plausibility::check(&with(-1.0, 0.0), &robot()).unwrap();
    assert!(against.notes.iter().any(|n| n.to_string().contains("wrong sign")), "{:?}", against.notes);
    let apart = plausibility::check(&with(1.0, 0.2), &robot()).unwrap();
    assert!(apart.notes.iter().any(|n| n.to_string().contains("differs from the command")), "{:?}", apart.notes);
}

/// A sensor in another unit would make a gap of another size.
#[test]
fn hygiene_refuses_joint_sensors_that_do_not_follow_their_commands_one_to_one() {
    let good = measured(500, 1e-5, six);
    let with = |factor: f64| {
        let mut log = good.clone();
        log.tcp_m.fill(None);
        log.meas = vec![None; 6];
        let zero = log.cmd[1][0];
        log.meas[1] = Some(log.cmd[1].iter().map(|v| Some(zero + (v - zero) * factor)).collect());
        plausibility::check(&log, &robot()).map(|found| found.notes)
    };
    for (factor, says) in [
        (60.0, "`{to: meas_A2_deg, scale: 0.0166667}`"),
        (60.0, "as if they were in minutes of arc"),
        (-60.0, "`{to: meas_A2_deg, sign: -1, scale: 0.0166667}`"),
        (3600.0, "scale: 0.000277778"),
        (1.0 / 360.0, "scale: 360}"),
        (1.12, "scale: 0.892857"),
        (0.85, "move 0.8500 times as far as the commands of A2"),
    ] {
        let refused = with(factor).unwrap_err().to_string();
        assert!(refused.contains(says), "{factor}: {refused}");
    }
    for factor in [0.93, 1.05] {
        let notes = with(factor).unwrap();
        assert!(notes.iter().any(|n| n.to_string().contains("meas_A2 moves")), "{factor}: {notes:?}");
    }
    for factor in [0.98, 1.0, 1.02] {
        assert!(with(factor).unwrap().is_empty(), "{factor}");
    }
    // a motor that also turns for another joint, as in a coupled wrist: no scale mends it
    let mut coupled = good.clone();
    coupled.tcp_m.fill(None);
    coupled.enc = vec![None; 6];
    coupled.cmd[4] = coupled.t_s.iter().map(|t| 0.5 * t.sin()).collect();
    coupled.cmd[5] = coupled.t_s.iter().map(|t| 0.5 * (t.sin() + 0.3 * (3.0 * t).sin())).collect();
    coupled.enc[4] = Some((0..coupled.len()).map(|i| Some(coupled.cmd[4][i] + 0.2 * coupled.cmd[5][i])).collect());
    assert!(plausibility::check(&coupled, &robot()).is_ok());
    // a wrong scale is one under a lag too
    coupled.enc[4] = Some(coupled.t_s.iter().map(|t| Some(0.6 * (t - 0.08).sin())).collect());
    let refused = plausibility::check(&coupled, &robot()).unwrap_err().to_string();
    assert!(refused.contains("`enc_A5_deg` that move 1.19"), "{refused}");
    // behind tendons the ratio is not known
    let mut log = good.clone();
    log.meas = vec![None; 6];
    log.meas[1] = Some(log.cmd[1].iter().map(|v| Some(v * 1.5)).collect());
    assert!(plausibility::check_for(&log, &robot(), plausibility::Kinematics::Unknown).is_ok());
}

#[test]
fn hygiene_notes_speeds_and_limits_that_cannot_be() {
    let mut log = measured(500, 1e-5, six);
    // an eighth of the rows a thousand times closer: noted; all of them: refused
    let mut some = log.clone();
    let mut t = 0.0;
    for i in 1..some.len() {
        t += (log.t_s[i] - log.t_s[i - 1]) * if (100..160).contains(&i) { 1e-3 } else { 1.0 };
        some.t_s[i] = t;
    }
    let fast = plausibility::check(&some, &robot()).unwrap().notes;
    assert!(
        fast.iter().any(|n| n.to_string().contains("A1 moves at") && n.to_string().contains("its limit is 136")),
        "{fast:?}"
    );
    log.t_s.iter_mut().for_each(|t| *t *= 1e-3);
    let refused = plausibility::check(&log, &robot()).unwrap_err().to_string();
    assert!(refused.contains("A1 at more than 3 times its largest speed, 136 deg/s"), "{refused}");
    log.t_s.iter_mut().for_each(|t| *t *= 1e6);
    let step_s = log.t_s[1] - log.t_s[0];
    let slow = match plausibility::check(&log, &robot()) {
        Err(refused) => refused.to_string(),
        Ok(found) => found.notes.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "),
    };
    assert!(slow.contains("milliseconds"), "{step_s}: {slow}");
    // slower rows are refused, faster ones noted
    for (apart_s, refused) in [(40.0, true), (4.0, false)] {
        let mut log = log.clone();
        log.t_s.iter_mut().for_each(|t| *t *= apart_s / step_s);
        assert_eq!(plausibility::check(&log, &robot()).is_err(), refused, "{apart_s}");
    }
    let beyond = measured(500, 1e-5, |s| {
        let mut q = six(s);
        q[1] += 120.0;
        q
    });
    let notes = plausibility::check(&beyond, &robot()).unwrap().notes;
    assert!(
        notes
            .iter()
            .map(ToString::to_string)
            .any(|n| { n.starts_with("line ") && n.contains("A2") && n.contains("outside its limits") }),
        "{notes:?}"
    );
}
