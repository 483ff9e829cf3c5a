//! Half gaps of measured joints, from dwells and a joint sensor alone.

use crate::real_data::read;
use lostmotion::identify::static_test::{Options, identify};
use lostmotion::log::dwells::DwellOptions;

/// One count of a servo's sensor, degrees.
const COUNT_DEG: f64 = 360.0 / 4096.0;

#[test]
#[cfg_attr(not(real_data), ignore = "the measured sets are absent: LOSTMOTION_REAL_DATA names their folder")]
fn half_gaps_of_servos_agree_with_the_figures_of_their_set_within_a_tenth_of_a_count() {
    // file, map, half gap in counts: mean of the approaches from above minus from below, halved (the set's README)
    for (file, map, counts) in [
        ("motor_telemetry_single.csv", "map-single-5.yaml", 5.5),
        ("motor_telemetry_nocomp2.csv", "map-1.yaml", 2.0),
        ("motor_telemetry_nocomp2.csv", "map-2.yaml", 2.5),
        ("motor_telemetry_comp2.csv", "map-1.yaml", 1.333),
        ("motor_telemetry_comp2.csv", "map-2.yaml", 1.0),
        ("motor_telemetry_pgain_zero_db.csv", "map-1.yaml", 0.5),
        ("motor_telemetry_pgain_zero_db.csv", "map-2.yaml", 0.0),
    ] {
        let (robot, log) = read("uart-servo-reversals", map, file);
        let options =
            Options { dwell: DwellOptions { settle_s: Some(0.6), ..Default::default() }, ..Default::default() };
        let found = identify(&robot, &[log], &options).unwrap();
        let [joint] = found.gaps.joints.as_slice() else { panic!("{file}: one joint was tested") };
        assert_eq!(joint.axis, 0);
        let [lo, hi] = joint.ci95.map(f64::to_degrees);
        let found_deg = joint.half_gap.to_degrees();
        assert!((found_deg - counts * COUNT_DEG).abs() < 0.1 * COUNT_DEG, "{file} {map}: {found_deg}");
        assert!(lo <= counts * COUNT_DEG && counts * COUNT_DEG <= hi, "{file} {map}: {lo} to {hi}");
        assert!(hi - lo < 1.5 * COUNT_DEG, "{file} {map}: {lo} to {hi}");
        assert_eq!(joint.significant, lo > 0.0, "{file} {map}: {lo} to {hi}");
        assert!(joint.significant || counts < 1.0, "{file} {map}: {lo} to {hi}");
    }
}
