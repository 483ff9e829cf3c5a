//! `identify static` on analytic cases: gaps that were put in, and logs that lack something.

use crate::bench::{Bench, Row, kuka, parse, robot};
use lostmotion::effects::GapCurve;
use lostmotion::identify::static_test::{Options, document, identify};
use nalgebra::Vector3;

fn deg(values: &[f64]) -> Vec<f64> {
    values.iter().map(|v| v.to_radians()).collect()
}

fn a3_rows(bench: &mut Bench) -> Vec<Row> {
    let (fixed, places) = (deg(&[10.0, -80.0, 0.0, 0.0, 20.0, 0.0]), deg(&[20.0, 50.0, 80.0, 110.0]));
    bench.rows(2, &fixed, &places, 2f64.to_radians(), 4, |_| 0.003f64.to_radians())
}

#[test]
fn a_gap_is_found_within_its_interval_and_the_frame_too() {
    let mut bench = Bench::new(kuka(), 10e-6);
    let rows = a3_rows(&mut bench);
    let found = identify(&bench.robot, &[bench.log(&rows)], &Options::default()).unwrap();
    let j = &found.gaps.joints[0];
    assert_eq!((found.gaps.joints.len(), j.axis, j.significant), (1, 2, true));
    assert!(j.ci95[0] < 0.003f64.to_radians() && 0.003f64.to_radians() < j.ci95[1], "{:?}", j.ci95);
    let frame = found.gaps.registration.unwrap().frame;
    assert!((frame.translation.vector - bench.frame.translation.vector).norm() < 50e-6);
}

#[test]
fn a_bumped_cycle_is_left_out_and_said() {
    let mut bench = Bench::new(kuka(), 10e-6);
    let mut rows = a3_rows(&mut bench);
    let dwells: Vec<usize> = (0..rows.len()).filter(|&i| rows[i].dwell).collect();
    for &i in &dwells[20..30] {
        rows[i].point = rows[i].point.map(|p| p + Vector3::new(0.0, 2e-3, 2e-3)); // the second cycle's first dwell
    }
    let found = identify(&bench.robot, &[bench.log(&rows)], &Options::default()).unwrap();
    let first = &found.joints[0].summary.angles[0];
    assert_eq!((first.cycles.len(), first.dropped.len()), (3, 1));
    assert!((found.gaps.joints[0].half_gap.to_degrees() - 0.003).abs() < 1e-4);
    assert!(found.gaps.notes.iter().any(|n| n.to_string().contains("gross errors")), "{:?}", found.gaps.notes);
}

#[test]
fn two_cycles_that_disagree_are_kept_and_flagged() {
    let mut bench = Bench::new(kuka(), 10e-6);
    let (fixed, places) = (deg(&[10.0, -80.0, 0.0, 0.0, 20.0, 0.0]), deg(&[20.0, 40.0, 60.0, 80.0, 110.0]));
    let mut rows = bench.rows(2, &fixed, &places, 2f64.to_radians(), 2, |_| 0.003f64.to_radians());
    let dwells: Vec<usize> = (0..rows.len()).filter(|&i| rows[i].dwell).collect();
    for &i in &dwells[0..10] {
        rows[i].point = rows[i].point.map(|p| p + Vector3::new(1e-3, 1e-3, 1e-3));
    }
    let found = identify(&bench.robot, &[bench.log(&rows)], &Options::default()).unwrap();
    let first = &found.joints[0].summary.angles[0];
    assert_eq!((first.cycles.len(), first.flagged), (2, true));
    assert!(found.gaps.notes.iter().any(|n| n.to_string().contains("do not trust this value")));
}

#[test]
fn a_missing_cycle_and_a_lost_reflector_leave_the_rest_standing() {
    let mut bench = Bench::new(kuka(), 10e-6);
    let mut rows = a3_rows(&mut bench);
    let dwells: Vec<usize> = (0..rows.len()).filter(|&i| rows[i].dwell).collect();
    // third place: tracker lost for a whole dwell, and for half of another
    for &i in dwells[160..170].iter().chain(&dwells[182..187]) {
        rows[i].point = None;
    }
    // first place: the last downward dwell was cut out of the log
    let cut: Vec<usize> = dwells[70..80].to_vec();
    let mut i = 0;
    rows.retain(|_| {
        i += 1;
        !cut.contains(&(i - 1))
    });
    let found = identify(&bench.robot, &[bench.log(&rows)], &Options::default()).unwrap();
    let cycles: Vec<usize> = found.joints[0].summary.angles.iter().map(|a| a.cycles.len()).collect();
    assert_eq!(cycles, [3, 4, 3, 4]);
    assert_eq!(found.joints[0].unpaired, 1);
    assert!((found.gaps.joints[0].half_gap.to_degrees() - 0.003).abs() < 1e-4);
    let notes = found.gaps.notes.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n");
    assert!(notes.contains("because they have no reading") && notes.contains("without a partner"), "{notes}");
}

#[test]
fn an_approach_from_one_side_gives_no_gap_and_says_so() {
    let mut bench = Bench::new(kuka(), 10e-6);
    let good = a3_rows(&mut bench);
    let fixed = deg(&[0.0, -80.0, 60.0, 0.0, 20.0, 0.0]);
    let one_sided: Vec<Row> = (0..6)
        .flat_map(|k| {
            let mut q = fixed.clone();
            q[0] = (10.0 * f64::from(k)).to_radians();
            (0..10).map(|_| bench.row(&q, 0, 0.0, true)).collect::<Vec<_>>()
        })
        .collect();
    let logs = [bench.log(&good), bench.log(&one_sided)];
    let found = identify(&bench.robot, &logs, &Options::default()).unwrap();
    assert_eq!(found.gaps.joints.len(), 1);
    assert!(
        found.gaps.notes.iter().any(|n| n.to_string().starts_with("A1:") && n.to_string().contains("one side only")),
        "{:?}",
        found.gaps.notes
    );
    let alone = identify(&bench.robot, &logs[1..], &Options::default()).unwrap();
    assert!(alone.gaps.joints.is_empty() && alone.gaps.registration.is_none());
}

#[test]
fn a_gantry_has_gaps_in_millimetres_even_from_one_axis_alone() {
    let mut bench = Bench::new(robot("gantry-xyz-ballscrew.yaml"), 2e-6);
    let places: Vec<f64> = (1..9).map(|k| 0.1 * f64::from(k)).collect();
    let rows = bench.rows(0, &[0.0, 0.4, -0.2], &places, 5e-3, 4, |_| 50e-6);
    let log = bench.log(&rows);
    let found = identify(&bench.robot, std::slice::from_ref(&log), &Options::default()).unwrap();
    assert!((found.gaps.joints[0].half_gap - 50e-6).abs() < 0.5e-6, "{}", found.gaps.joints[0].half_gap);
    assert!(
        found.gaps.notes.iter().any(|n| n.to_string().contains("one line")),
        "the frame is not determined about the axis, and a note reports it"
    );
    let doc = document::document(&found, &bench.robot);
    let gap = doc["joints"][0]["half_gap_mm"].as_f64().unwrap();
    assert!((gap - 0.05).abs() < 0.0005);
    assert!(doc["points"][0]["at_mm"].is_number() && doc["joints"][0].get("half_gap_deg").is_none());
}

#[test]
fn other_robots_are_served_alike() {
    for (name, axis, fixed, gap_deg) in [
        ("abb-irb1600-6-145.yaml", 1, vec![20.0, 0.0, 10.0, 30.0, 40.0, 0.0], 0.004),
        ("micro-iges-4dof.yaml", 2, vec![5.0, 10.0, 0.0, -8.0], 0.4),
    ] {
        let mut bench = Bench::new(robot(name), 3e-6);
        let places = deg(&[-20.0, -10.0, 0.0, 10.0, 20.0]);
        let gap = gap_deg.to_owned() * 1f64.to_radians();
        let rows = bench.rows(axis, &deg(&fixed), &places, 3f64.to_radians(), 5, |_| gap);
        let found = identify(&bench.robot, &[bench.log(&rows)], &Options::default()).unwrap();
        let j = &found.gaps.joints[0];
        assert_eq!(j.axis, axis, "{name}");
        assert!((j.half_gap / gap - 1.0).abs() < 0.01, "{name}: {}", j.half_gap.to_degrees());
        assert!(j.schedule.is_none());
    }
}

#[test]
fn a_log_without_noise_gives_the_gap_and_does_not_take_rounding_for_a_shape() {
    let mut bench = Bench::new(kuka(), 0.0);
    let rows = a3_rows(&mut bench);
    let found = identify(&bench.robot, &[bench.log(&rows)], &Options::default()).unwrap();
    let j = &found.gaps.joints[0];
    assert!((j.half_gap.to_degrees() - 0.003).abs() < 1e-5 && j.schedule.is_none());
    assert!(found.gaps.notes.iter().any(|n| n.to_string().contains("last digit")));
}

#[test]
fn a_secondary_encoder_needs_no_tracker() {
    let mut bench = Bench::new(kuka(), 0.0);
    let rows = a3_rows(&mut bench);
    let text = bench.text(&rows, Some(2));
    let found = identify(&bench.robot, &[parse(&text, &bench.robot)], &Options::default()).unwrap();
    assert!(found.frame.is_none() && found.joints[0].measured);
    assert!((found.gaps.joints[0].half_gap.to_degrees() - 0.003).abs() < 1e-7);
}

#[test]
fn several_logs_of_one_joint_are_pooled() {
    let mut bench = Bench::new(kuka(), 10e-6);
    let logs = [0, 1].map(|_| {
        let rows = a3_rows(&mut bench);
        bench.log(&rows)
    });
    let found = identify(&bench.robot, &logs, &Options::default()).unwrap();
    assert_eq!(found.gaps.joints.len(), 1);
    assert!(found.joints[0].summary.angles.iter().all(|a| a.cycles.len() == 8));
}

#[test]
fn few_places_of_a_gap_that_varies_are_joined_and_not_smoothed() {
    let mut bench = Bench::new(kuka(), 5e-6);
    let (fixed, places) = (deg(&[10.0, -80.0, 0.0, 0.0, 20.0, 0.0]), deg(&[20.0, 50.0, 80.0]));
    let rows = bench.rows(2, &fixed, &places, 2f64.to_radians(), 4, |p| 0.002f64.to_radians() * p);
    let found = identify(&bench.robot, &[bench.log(&rows)], &Options::default()).unwrap();
    let Some(GapCurve::Pchip(curve)) = &found.gaps.joints[0].schedule else { panic!("no schedule") };
    assert_eq!(curve.knots().len(), 3);
    assert!(found.gaps.notes.iter().any(|n| n.to_string().contains("too few to smooth")));
}

#[test]
fn a_registration_that_is_known_is_taken() {
    let mut bench = Bench::new(kuka(), 10e-6);
    let rows = a3_rows(&mut bench);
    let options = Options { registration: Some(bench.frame), ..Options::default() };
    let found = identify(&bench.robot, &[bench.log(&rows)], &options).unwrap();
    assert!(found.frame.unwrap().given);
    assert!((found.gaps.joints[0].half_gap.to_degrees() - 0.003).abs() < 1e-4);
}

#[test]
fn refuses_commands_that_do_not_explain_the_points() {
    let mut bench = Bench::new(kuka(), 10e-6);
    let rows = a3_rows(&mut bench);
    let mut log = bench.log(&rows);
    log.cmd.iter_mut().for_each(|c| c.iter_mut().for_each(|v| *v = v.to_radians()));
    let error = identify(&bench.robot, &[log], &Options::default()).unwrap_err().to_string();
    assert!(error.contains("units"), "{error}");
}

#[test]
fn refuses_the_same_log_twice_and_a_log_without_dwells() {
    let mut bench = Bench::new(kuka(), 10e-6);
    let rows = a3_rows(&mut bench);
    let log = bench.log(&rows);
    let twice = identify(&bench.robot, &[log.clone(), log], &Options::default()).unwrap_err().to_string();
    assert!(twice.contains("given before"), "{twice}");
    let moving: Vec<Row> =
        (0..50).map(|k| bench.row(&deg(&[f64::from(k), -90.0, 90.0, 0.0, 0.0, 0.0]), 0, 0.0, false)).collect();
    let none = identify(&bench.robot, &[bench.log(&moving)], &Options::default()).unwrap_err().to_string();
    assert!(none.contains("no dwell"), "{none}");
}

#[test]
fn a_gap_of_degrees_is_not_shortened_to_its_sine() {
    let mut bench = Bench::new(robot("micro-iges-4dof.yaml"), 0.1e-6);
    let gap = 6f64.to_radians();
    let rows =
        bench.rows(2, &deg(&[5.0, 10.0, 0.0, -8.0]), &deg(&[-20.0, 0.0, 10.0, 20.0]), 20f64.to_radians(), 4, |_| gap);
    let found = identify(&bench.robot, &[bench.log(&rows)], &Options::default()).unwrap();
    let off = found.gaps.joints[0].half_gap / gap - 1.0;
    assert!(off.abs() < 2e-4, "{off}: one projection alone would be 0.0018 short");
}

#[test]
fn both_approaches_from_below_before_both_from_above_make_two_cycles() {
    let mut bench = Bench::new(kuka(), 10e-6);
    let (mut rows, b) = (Vec::new(), 0.003f64.to_radians());
    for p in deg(&[20.0, 50.0, 80.0]) {
        for side in [-1.0, -1.0, 1.0, 1.0] {
            let at = |p: f64| [0.2, -1.4, p, 0.0, 0.3, 0.0];
            rows.push(bench.row(&at(p + side * 0.03), 2, 0.0, false));
            rows.extend((0..10).map(|_| bench.row(&at(p), 2, side * b, true)).collect::<Vec<_>>());
        }
    }
    let found = identify(&bench.robot, &[bench.log(&rows)], &Options::default()).unwrap();
    assert!(found.joints[0].summary.angles.iter().all(|a| a.cycles.len() == 2));
    assert!((found.gaps.joints[0].half_gap - b).abs() < 2e-6);
}

#[test]
fn the_servo_settling_into_a_dwell_does_not_count() {
    let mut bench = Bench::new(kuka(), 1e-6);
    let mut rows = a3_rows(&mut bench);
    let first: Vec<usize> = (1..rows.len()).filter(|&i| rows[i].dwell && !rows[i - 1].dwell).collect();
    for (n, i) in first.into_iter().enumerate() {
        // following error in the first 0.2 s, 0.1 mm against the approach, which alternates
        let lag = if n % 2 == 0 { 1e-4 } else { -1e-4 };
        for row in &mut rows[i..i + 2] {
            row.point = row.point.map(|p| p + Vector3::repeat(lag));
        }
    }
    let found = identify(&bench.robot, &[bench.log(&rows)], &Options::default()).unwrap();
    assert!((found.gaps.joints[0].half_gap.to_degrees() - 0.003).abs() < 1e-5);
}
