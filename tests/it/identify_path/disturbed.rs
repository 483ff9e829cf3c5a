//! Logs whose commands jitter, lag, or come with a clock that is late or ahead.

use super::{busy, circle, deg, joint};
use crate::path_bench::{Fault, kuka, run, table3};
use lostmotion::identify::path::{Options, identify};
use lostmotion::log::Log;
use rand::SeedableRng;
use rand_distr::Distribution;

/// The circle with commands that jitter by `noise_deg` and are written with `decimals` decimals.
fn disturbed_circle(noise_deg: f64, decimals: u8) -> Log {
    let mut log = circle("circle_uncompensated_table3.csv.gz");
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(77);
    let scale = 10f64.powi(i32::from(decimals));
    for axis in 0..3 {
        for v in &mut log.cmd[axis] {
            let jitter: f64 = rand_distr::StandardNormal.sample(&mut rng);
            *v = (((v.to_degrees() + noise_deg * jitter) * scale).round() / scale).to_radians();
        }
        log.cmd_decimals[axis] = decimals;
    }
    log
}

#[test]
fn commands_that_jitter_a_little_are_smoothed_and_the_intervals_hold_the_truth() {
    let found = identify(&kuka(), &[disturbed_circle(0.0002, 6)], &Options::default()).unwrap();
    assert!(found.gaps.distrust.is_none(), "{:?}", found.gaps.distrust);
    for (axis, truth) in [(0, 0.0028), (1, 0.0037), (2, 0.0022)] {
        let j = joint(&found, axis);
        assert!(deg(j.ci95[0]) < truth && truth < deg(j.ci95[1]), "axis {axis}: {:?}", j.ci95.map(deg));
        assert!((deg(j.half_gap) / truth - 1.0).abs() < 0.05 && j.significant, "axis {axis}: {}", deg(j.half_gap));
    }
    let spike = joint(&found, 0).stiction.clone().unwrap();
    assert!(deg(spike.ci95[0]) < 0.0034 && 0.0034 < deg(spike.ci95[1]), "{:?}", spike.ci95.map(deg));
    assert!(found.gaps.notes.iter().any(|n| n.to_string().contains("jitter")), "{:?}", found.gaps.notes);
}

#[test]
fn gaps_that_are_several_times_the_jitter_are_told_without_friction() {
    let found = identify(&kuka(), &[disturbed_circle(0.001, 6)], &Options::default()).unwrap();
    assert!(found.gaps.distrust.is_none(), "{:?}", found.gaps.distrust);
    for (axis, truth) in [(0, 0.0028), (1, 0.0037), (2, 0.0022)] {
        let j = joint(&found, axis);
        assert!((deg(j.half_gap) / truth - 1.0).abs() < 0.1 && j.significant, "axis {axis}: {}", deg(j.half_gap));
        assert!(deg(j.ci95[0]) < truth && truth < deg(j.ci95[1]) && j.stiction.is_none(), "axis {axis}");
    }
}

#[test]
fn commands_that_jitter_or_are_coarse_against_the_gap_are_not_trusted() {
    for (noise_deg, decimals, says) in [(0.003, 6, "log the commanded positions"), (0.0, 2, "more decimals")] {
        let found = identify(&kuka(), &[disturbed_circle(noise_deg, decimals)], &Options::default()).unwrap();
        let why = found.gaps.distrust.as_ref().map_or(String::new(), ToString::to_string);
        assert!(why.contains(says), "{noise_deg} {decimals}: {why}");
        for (axis, truth) in [(0, 0.0028), (1, 0.0037), (2, 0.0022)] {
            let j = joint(&found, axis);
            assert!(
                deg(j.ci95[0]) < truth && truth < deg(j.ci95[1]),
                "{noise_deg}, axis {axis}: {:?}",
                j.ci95.map(deg)
            );
        }
    }
}

/// The log of the busy motion on a machine that follows its commands `late_s` later, one time for each axis.
fn late(late_s: [f64; 3], faults: &[Fault], seed: u64) -> Log {
    let (robot, t, cmd, frame) = busy();
    let mut followed = cmd.clone();
    for (axis, late_s) in late_s.into_iter().enumerate() {
        let rows = late_s * 25.0;
        let (whole, share) = (rows.floor() as isize, rows - rows.floor());
        let at = |i: isize| cmd[axis][i.clamp(0, t.len() as isize - 1) as usize];
        for (i, v) in followed[axis].iter_mut().enumerate() {
            let i = i as isize - whole;
            *v = at(i) + share * (at(i - 1) - at(i));
        }
    }
    Log { cmd, ..run(&robot, &t, &followed, faults, &frame, 11e-6, seed) }
}

/// At the speeds of this motion 10 ms are as much as the gaps.
#[test]
fn a_lag_or_a_late_clock_is_no_gap() {
    for (late_s, seed) in [([0.01; 3], 21), ([0.002, 0.004, 0.001], 22), ([0.02, 0.005, 0.03], 23)] {
        let found = identify(&kuka(), &[late(late_s, &[], seed)], &Options::default()).unwrap();
        for j in &found.gaps.joints {
            assert!(deg(j.half_gap) < 1e-4, "axis {}: {} deg of a lag of {late_s:?} s", j.axis, deg(j.half_gap));
        }
    }
}

#[test]
fn gaps_are_found_beside_a_lag_or_a_clock_that_is_ahead() {
    for (late_s, seed) in [([-0.01; 3], 24), ([0.01; 3], 25), ([0.002, 0.004, 0.001], 26), ([0.02, 0.005, 0.03], 27)] {
        let found = identify(&kuka(), &[late(late_s, &table3(), seed)], &Options::default()).unwrap();
        for f in table3() {
            let (j, truth) = (joint(&found, f.axis), f.half_gap.constant().unwrap());
            assert!((j.half_gap / truth - 1.0).abs() < 0.02, "{late_s:?} axis {}: {}", f.axis, deg(j.half_gap));
            let wide = 1.7 * (j.ci95[1] - j.half_gap);
            assert!((j.half_gap - truth).abs() < wide, "{late_s:?} axis {}: {:?}", f.axis, j.ci95.map(deg));
        }
    }
}
