//! Public measured logs are read through their maps, and plausibility checks neither refuses nor doubts them for rough tool points.

use crate::real_data::read;
use lostmotion::log::{Log, plausibility};
use lostmotion::robot::Robot;
use nalgebra::{Isometry3, Vector3};

fn seen(track: &[Option<Vector3<f64>>]) -> usize {
    track.iter().flatten().count()
}

/// Plausibility passes with the rough tool of the robot file and with none at all.
fn passes(robot: &Robot, log: &Log) -> plausibility::Plausibility {
    let bare =
        Robot::new(robot.name.clone(), robot.convention, robot.joints.clone(), robot.base, Isometry3::identity());
    plausibility::check(log, &bare).unwrap();
    plausibility::check(log, robot).unwrap()
}

#[test]
fn the_robot_files_and_maps_of_the_measured_sets_are_in_order() {
    use crate::real_data::ours;
    use lostmotion::{log::ColumnMap, model::Model};
    let (mut robots, mut maps) = (0, 0);
    for set in std::fs::read_dir(ours("")).unwrap().flatten().filter(|e| e.path().is_dir()) {
        for file in std::fs::read_dir(set.path()).unwrap().flatten().map(|e| e.path()) {
            let name = file.file_name().unwrap().to_string_lossy().into_owned();
            if name.starts_with("map") {
                ColumnMap::load(&file).unwrap();
                maps += 1;
            } else if name == "model.yaml" {
                assert!(Model::load(&file).unwrap().effects.is_empty());
                robots += 1;
            }
        }
    }
    assert_eq!((robots, maps), (8, 8));
}

#[test]
#[cfg_attr(not(real_data), ignore = "the measured sets are absent: LOSTMOTION_REAL_DATA names their folder")]
fn a_log_with_two_encoders_a_joint_is_read_whole() {
    for file in ["trajectory_A.csv", "trajectory_B.csv"] {
        let (robot, log) = read("kuka-kr300-dual-encoder", "map.yaml", file);
        assert_eq!((log.len(), log.poses, log.tcp_m.len()), (2501, false, 0));
        assert!((log.t_s[2500] - 10.0).abs() < 1e-9);
        assert!(log.enc.iter().all(Option::is_some));
        assert_eq!(log.meas.iter().map(Option::is_some).collect::<Vec<_>>(), [true, true, true, false, false, false]);
        let notes = plausibility::check(&log, &robot).unwrap().notes;
        // the wrist motors of this robot do not follow the references within degrees (README of the set)
        assert!(notes.iter().all(|n| n.to_string().starts_with("enc_A5 differs")), "{notes:?}");
        // the sensor behind the gear stands 0.145 deg from the motor's at the start of A3
        let first = |c: &Option<Vec<Option<f64>>>| c.as_ref().and_then(|c| c[0]).unwrap().to_degrees();
        assert!((first(&log.meas[2]) - first(&log.enc[2]) - 0.145).abs() < 0.002);
    }
}

#[test]
#[cfg_attr(not(real_data), ignore = "the measured sets are absent: LOSTMOTION_REAL_DATA names their folder")]
fn tracker_poses_with_three_reflectors_pass_hygiene_with_rough_tool_points() {
    let (robot, log) = read("abb-irb120-laser-tracker", "map-read.yaml", "poses_0000_0599.csv");
    assert_eq!((log.len(), log.poses, log.reflectors_m.len()), (600, true, 2));
    assert_eq!((seen(&log.tcp_m), seen(&log.reflectors_m[0]), seen(&log.reflectors_m[1])), (600, 600, 600));
    let apart = log.tcp_m.iter().zip(&log.reflectors_m[0]).map(|(a, b)| (a.unwrap() - b.unwrap()).norm());
    let off = apart.fold(0.0, |worst: f64, d| worst.max((d - 0.150_345).abs()));
    assert!(off < 5e-4, "one rigid tool, found {off} m");
    let found = passes(&robot, &log);
    assert!(found.notes.is_empty(), "{:?}", found.notes);
    assert!(found.misfit_m.unwrap() < 0.003, "{:?}", found.misfit_m);
}

#[test]
#[cfg_attr(not(real_data), ignore = "the measured sets are absent: LOSTMOTION_REAL_DATA names their folder")]
fn a_file_with_semicolons_and_decimal_commas_is_read_and_passes_hygiene() {
    for (file, rows) in [
        ("Series_A_measurements_grid_rows_00001_04000.csv", 4000),
        ("Series_C_measurements_random_poses.csv", 2773),
        ("Series_D_measurements_iso_cubes.csv", 632),
    ] {
        let (robot, log) = read("ur10-leica-tmac", "map.yaml", file);
        assert_eq!((log.len(), log.poses, seen(&log.tcp_m)), (rows, true, rows), "{file}");
        let warm = log.temp_c.as_ref().unwrap().iter().flatten().fold(0.0, |m: f64, t| m.max(*t));
        assert!((20.0..25.0).contains(&warm), "{warm}");
        let misfit_m = passes(&robot, &log).misfit_m.unwrap();
        assert!(misfit_m < 0.06, "{file}: {misfit_m}");
    }
}

#[test]
#[cfg_attr(not(real_data), ignore = "the measured sets are absent: LOSTMOTION_REAL_DATA names their folder")]
fn poses_without_a_reading_are_lost_and_the_rest_pass_hygiene() {
    let (robot, log) = read("motoman-dual-arm-leica", "map.yaml", "right_arm_216_poses.csv");
    assert_eq!((log.len(), log.poses, seen(&log.tcp_m)), (216, true, 212));
    let found = passes(&robot, &log);
    assert!(found.misfit_m.unwrap() < 0.01, "{:?}", found.misfit_m);
}

#[test]
#[cfg_attr(not(real_data), ignore = "the measured sets are absent: LOSTMOTION_REAL_DATA names their folder")]
fn stamps_and_counts_of_servos_become_seconds_and_degrees() {
    for (file, map, rows, lost) in [
        ("motor_telemetry_single.csv", "map-single-5.yaml", 273, 0),
        ("motor_telemetry_nocomp2.csv", "map-1.yaml", 274, 1),
        ("motor_telemetry_comp2.csv", "map-2.yaml", 402, 1),
        ("motor_telemetry_pgain_zero_db.csv", "map-2.yaml", 318, 1),
    ] {
        let (robot, log) = read("uart-servo-reversals", map, file);
        assert_eq!((log.len(), log.t_s[0]), (rows, 0.0), "{file}");
        assert!((log.t_s[1] - 0.101).abs() < 1e-3 && log.t_s[rows - 1] < 42.0, "{}", log.t_s[rows - 1]);
        let meas = log.meas[0].as_ref().unwrap();
        assert_eq!(meas.iter().filter(|v| v.is_none()).count(), lost, "{file}");
        assert!((log.travel(0).to_degrees() - 200.0 * 360.0 / 4096.0).abs() < 1e-9);
        plausibility::check(&log, &robot).unwrap();
    }
}
