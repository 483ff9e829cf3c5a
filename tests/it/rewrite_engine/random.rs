//! Random smooth programs: what holds for each of them.

use super::{DEG, kuka, on_axis, one_axis, run};
use lostmotion::compensator::FrictionShape;
use lostmotion::effects::{Backlash, Decay, Effect, Stiction, Track, joint_output};
use lostmotion::rewrite::{Options, Origin, Points, Refine};
use proptest::prelude::*;

fn smooth_program(amplitudes: &[f64], phases: &[f64], n: usize, dt: f64) -> Points {
    let value = |t: f64| -> f64 {
        amplitudes.iter().zip(phases).enumerate().map(|(k, (a, f))| a * ((k as f64 + 1.0) * 0.21 * t + f).sin()).sum()
    };
    let mut points = one_axis(&(0..n).map(|i| value(i as f64 * dt)).collect::<Vec<_>>());
    points.t_s = (0..n).map(|i| i as f64 * dt).collect();
    points
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn block_sizes_do_not_change_a_bit(
        amplitudes in prop::collection::vec(0.0..3.0f64, 3), phases in prop::collection::vec(0.0..6.0f64, 3),
        refine in prop_oneof![Just(Refine::None), Just(Refine::Cubic), Just(Refine::Cartesian)], block in 1usize..90, timed: bool,
    ) {
        let robot = kuka();
        let mut points = smooth_program(&amplitudes, &phases, 240, 0.5);
        if !timed {
            points.t_s.clear();
        }
        let compensator = on_axis(0, 0.004, Some((0.003, FrictionShape::Decay(Decay::Time(3.0)))));
        let options = Options { refine, tcp_speed_m_s: Some(5e-3), ..Options::new(6) };
        let (whole, a) = run(&robot, &compensator, options.clone(), &points, 1000);
        let (parts, b) = run(&robot, &compensator, options, &points, block);
        prop_assert_eq!(&whole.q, &parts.q);
        prop_assert_eq!(&whole.t_s, &parts.t_s);
        prop_assert_eq!(&whole.origin, &parts.origin);
        prop_assert_eq!(a.reversals, b.reversals);
        let own: Vec<u64> = whole.origin.iter().filter_map(|o| if let Origin::Point(i) = o { Some(*i) } else { None }).collect();
        prop_assert!(own.iter().copied().eq(0..240));
    }

    /// The catalogue is the machine: what it makes of the rewritten command is the program, but for what the statistics
    /// announces.
    #[test]
    fn the_machine_follows_the_program_within_the_announced_error(
        amplitudes in prop::collection::vec(0.2..3.0f64, 3), phases in prop::collection::vec(0.0..6.0f64, 3),
        gap in 0.0005..0.006f64, gain in 0.0005..0.006f64, decay in 0.3..6.0f64,
    ) {
        let robot = kuka();
        let points = smooth_program(&amplitudes, &phases, 1200, 0.1);
        let compensator = on_axis(0, gap, Some((gain, FrictionShape::Decay(Decay::Time(decay)))));
        let options = Options { shape_m: 1e-7, ..Options::new(6) };
        let (out, stats) = run(&robot, &compensator, options, &points, 128);
        // a fine clock, so that the machine sees the command between its points
        let (mut t, mut c, mut want) = (Vec::new(), Vec::new(), Vec::new());
        let nominal = |u: f64| {
            let i = (u.floor() as usize).min(points.len() - 2);
            points.row(i)[0] + (u - i as f64) * (points.row(i + 1)[0] - points.row(i)[0])
        };
        for i in 0..out.len() - 1 {
            let (t0, t1) = (out.t_s[i], out.t_s[i + 1]);
            let parts = ((t1 - t0) / 0.002).ceil().max(1.0);
            for k in 0..parts as usize {
                let s = k as f64 / parts;
                t.push(t0 + s * (t1 - t0));
                c.push(out.row(i)[0] + s * (out.row(i + 1)[0] - out.row(i)[0]));
                want.push(nominal((t0 + s * (t1 - t0)) / 0.1));
            }
        }
        let track = Track::new(&t, &c, 1e-12);
        // as many reversals as the program has: the offsets made none
        prop_assert_eq!(track.turns.len() as u64, stats.reversals[0]);
        let effects = [
            Effect::new(Stiction { spike: gain * DEG, decay: Decay::Time(decay) }),
            Effect::new(Backlash::constant(gap * DEG)),
        ];
        let got = joint_output(&track, &effects);
        let Some(first) = track.turns.first().map(|t| t.index) else { return Ok(()) };
        // the step takes a few milliseconds of the program, in which the joint lags
        let speed = points.q.chunks(6).map(|r| r[0]).collect::<Vec<_>>().windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max) / 0.1;
        let worst = got.iter().zip(&want).skip(first).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        prop_assert!(worst <= stats.largest_left[0] + speed * 0.02 + 2e-6 * DEG, "{} deg, announced {}", worst / DEG, stats.largest_left[0] / DEG);
        // and the offsets help
        let raw: Vec<f64> = points.q.chunks(6).map(|r| r[0]).collect();
        let plain = Track::new(&points.t_s, &raw, 1e-12);
        let before = joint_output(&plain, &effects).iter().zip(&raw).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        prop_assert!(worst < before, "{} deg without, {} with", before / DEG, worst / DEG);
    }
}
