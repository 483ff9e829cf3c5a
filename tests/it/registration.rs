//! Registration against scipy (`tests/oracle/registration.py`), with gross errors, and on geometry that leaves it open.

use lostmotion::log::registration::{Pair, register, register_line};
use nalgebra::{Isometry3, Matrix3, Point3, Vector3};
use serde_json::Value;

fn vector(v: &Value) -> Vector3<f64> {
    Vector3::from_iterator((0..3).map(|k| v[k].as_f64().unwrap()))
}

fn cases() -> Vec<Value> {
    serde_json::from_str(include_str!("../oracle/registration.json")).unwrap()
}

fn pairs(case: &Value) -> Vec<Pair> {
    let (base, tracker) = (case["base_m"].as_array().unwrap(), case["tracker_m"].as_array().unwrap());
    base.iter().zip(tracker).map(|(b, t)| Pair { base_m: vector(b), tracker_m: vector(t) }).collect()
}

#[test]
fn val_frame_and_uncertainty_agree_with_scipy() {
    for case in cases() {
        let found = register(&pairs(&case)).unwrap();
        assert!(found.dropped.is_empty());
        let want = Matrix3::from_fn(|i, j| case["rotation"][i][j].as_f64().unwrap());
        let rotation = found.found.frame.rotation.to_rotation_matrix();
        assert!((rotation.matrix() - want).norm() < 1e-9, "{}", (rotation.matrix() - want).norm());
        assert!((found.found.frame.translation.vector - vector(&case["translation_m"])).norm() < 2e-9);
        let rms = case["rms_m"].as_f64().unwrap();
        assert!((found.found.rms_m / rms - 1.0).abs() < 1e-3, "{} against {rms}", found.found.rms_m);
        for k in 0..3 {
            let want = case["sigma_rad"][k].as_f64().unwrap();
            let ratio = found.found.sigma_rad[k] / want;
            assert!((ratio - 1.0).abs() < 0.01, "sigma {k}: {} against {want}", found.found.sigma_rad[k]);
        }
    }
}

#[test]
fn a_third_of_gross_errors_is_found_and_does_not_turn_the_frame() {
    let case = &cases()[1];
    let clean = register(&pairs(case)).unwrap();
    let mut with = pairs(case);
    let wrong: Vec<usize> = (0..with.len()).filter(|i| i % 3 == 0).collect();
    for (n, &i) in wrong.iter().enumerate() {
        with[i].tracker_m += Vector3::new(0.3, -0.002 * n as f64, 0.05);
    }
    let found = register(&with).unwrap();
    assert_eq!(found.dropped, wrong);
    let moved = found.found.frame.translation.vector - clean.found.frame.translation.vector;
    assert!(moved.norm() < 20e-6, "{moved}");
    assert!(found.found.rms_m < 15e-6);
}

#[test]
fn the_reported_uncertainty_is_the_scatter_of_repeated_registrations() {
    use rand::SeedableRng;
    use rand_distr::{Distribution, Normal};
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
    let noise = Normal::new(0.0, 11e-6).unwrap();
    let frame = Isometry3::new(Vector3::new(2.0, -1.0, 0.5), Vector3::new(0.3, -0.2, 1.9));
    let base: Vec<Vector3<f64>> = (0..30)
        .map(|i| f64::from(i) * 0.7)
        .map(|a| Vector3::new(1.5 + 0.4 * a.cos(), 0.3 * a.sin(), 1.0 + 0.1 * (2.0 * a).cos()))
        .collect();
    let mut off = Vec::new();
    let mut sigma = Vector3::zeros();
    for _ in 0..400 {
        let pairs: Vec<Pair> = base
            .iter()
            .map(|b| Pair {
                base_m: *b,
                tracker_m: (frame * Point3::from(*b)).coords + Vector3::from_fn(|_, _| noise.sample(&mut rng)),
            })
            .collect();
        let found = register(&pairs).unwrap().found;
        off.push(found.frame.translation.vector - frame.translation.vector);
        sigma += Vector3::from(found.sigma_m) / 400.0;
    }
    for k in 0..3 {
        let scatter = (off.iter().map(|d| d[k] * d[k]).sum::<f64>() / 400.0).sqrt();
        assert!((sigma[k] / scatter - 1.0).abs() < 0.12, "coordinate {k}: said {}, is {scatter}", sigma[k]);
    }
}

#[test]
fn refuses_too_few_points_one_pose_and_one_line() {
    let pair = |x: f64, y: f64| Pair { base_m: Vector3::new(x, y, 0.0), tracker_m: Vector3::new(x, y, 1.0) };
    let message = |pairs: &[Pair]| register(pairs).unwrap_err().to_string();
    assert!(message(&[pair(0.0, 0.0), pair(1.0, 0.0)]).contains("2 points"));
    assert!(message(&[pair(0.5, 0.5); 5]).contains("one pose"));
    let line: Vec<Pair> = (0..6).map(|i| pair(f64::from(i), 2.0 * f64::from(i))).collect();
    assert!(message(&line).contains("one line"));
    let mut infinite = line.clone();
    infinite[0].tracker_m.x = f64::NAN;
    assert!(message(&infinite).contains("not finite"));
}

#[test]
fn a_line_gives_a_frame_that_is_right_along_it_and_names_the_open_axis() {
    let frame = Isometry3::new(Vector3::new(1.0, 2.0, 3.0), Vector3::new(0.4, 0.1, -2.5));
    let pairs: Vec<Pair> = (0..8)
        .map(|i| Vector3::new(0.1 * f64::from(i), 0.3, -0.2))
        .map(|b| Pair { base_m: b, tracker_m: (frame * Point3::from(b)).coords })
        .collect();
    let found = register_line(&pairs).unwrap();
    let along = frame.rotation * Vector3::x();
    assert!(found.open_axis.unwrap().cross(&along).norm() < 1e-9);
    assert!((found.found.frame.rotation * Vector3::x() - along).norm() < 1e-9);
    assert!(found.found.rms_m < 1e-12);
    assert!(found.found.sigma_rad.iter().any(|s| *s > 1.0), "nothing is known about the open axis");
}

#[test]
fn points_of_a_plane_are_not_mirrored() {
    let frame = Isometry3::new(Vector3::new(0.0, 1.0, 0.0), Vector3::new(3.0, 0.3, 0.2));
    let pairs: Vec<Pair> = [[0.0, 0.0], [1.0, 0.0], [0.0, 0.5], [0.7, 0.9]]
        .iter()
        .map(|p| Vector3::new(p[0], p[1], 0.0))
        .map(|b| Pair { base_m: b, tracker_m: (frame * Point3::from(b)).coords })
        .collect();
    let found = register(&pairs).unwrap().found;
    assert!((found.frame.rotation.to_rotation_matrix().matrix().determinant() - 1.0).abs() < 1e-12);
    assert!(found.rms_m < 1e-12);
}
