//! `identify path`: against the independent simulator's logs, and on a bench with known faults.
//!
//! Parts:
//! - [`disturbed`]: commands that jitter or lag, clocks that are late or ahead.

mod disturbed;

use crate::path_bench::{Fault, file, kuka, run, table3, waves};
use crate::support::{self, WorkFolder};
use lostmotion::effects::{Decay, GapCurve, curve::Pchip};
use lostmotion::gaps::{Gaps, JointGap};
use lostmotion::identify::path::{Known, Options, PathFound, identify};
use lostmotion::log::Log;
use nalgebra::{Isometry3, Vector3};

fn joint(found: &PathFound, axis: usize) -> &JointGap {
    found.gaps.joints.iter().find(|j| j.axis == axis).unwrap()
}

fn deg(v: f64) -> f64 {
    v.to_degrees()
}

/// 95 % interval widened (about its middle; logarithmic) to 99.9 %.
fn wide(ci: [f64; 2]) -> [f64; 2] {
    let (middle, half) = ((ci[0] * ci[1]).sqrt(), (ci[1] / ci[0]).ln() / 2.0 * 3.29 / 1.96);
    [middle * (-half).exp(), middle * half.exp()]
}

fn circle(name: &str) -> Log {
    Log::load(&file(&format!("samples/circle/{name}")), &kuka()).unwrap()
}

/// Truth from `samples/README.md`: gaps 0.0028, 0.0037, 0.0022 deg; spikes 0.0034 and 0.0017 deg that decay in 5.2 s. On this file
/// both spikes and the gap of A3 lie outside their 95 % intervals (2.1, 2.6 and 2.0 standard errors, `docs/identify-path.md`), so gaps and
/// spikes are held to 99.9 % here; decay and lags are held to 95 %.
#[test]
fn val_the_circle_gives_gaps_within_a_percent_and_no_stiction_of_a2() {
    let found = identify(&kuka(), &[circle("circle_uncompensated_table3.csv.gz")], &Options::default()).unwrap();
    for (axis, truth) in [(0, 0.0028), (1, 0.0037), (2, 0.0022)] {
        let j = joint(&found, axis);
        assert!((deg(j.half_gap) / truth - 1.0).abs() < 0.01, "axis {axis}: {}", deg(j.half_gap));
        let ci = wide(j.ci95).map(deg);
        assert!(ci[0] < truth && truth < ci[1], "axis {axis}: {ci:?}");
        assert!(j.significant && j.schedule.is_none());
    }
    assert!(joint(&found, 1).stiction.is_none());
    for (axis, spike) in [(0, 0.0034f64), (2, 0.0017)] {
        let s = joint(&found, axis).stiction.clone().unwrap();
        let ci = wide(s.ci95).map(deg);
        assert!(ci[0] < spike && spike < ci[1], "axis {axis}: {ci:?}");
        let Decay::Time(_) = s.decay else { panic!("a decay in time") };
        assert!(s.decay_ci95[0] < 5.2 && 5.2 < s.decay_ci95[1], "axis {axis}: {:?}", s.decay_ci95);
        // the lag at its best known time
        let detail = found.details.iter().find(|d| d.axis == axis).unwrap().stiction.unwrap();
        let truth = spike * (-detail.best_s / 5.2).exp();
        assert!(deg(detail.lag_ci95[0]) < truth && truth < deg(detail.lag_ci95[1]), "axis {axis}: {detail:?}");
    }
    let registration = found.gaps.registration.as_ref().unwrap();
    assert!((registration.rms_m * 1e6 - 11.0).abs() < 0.2, "{}", registration.rms_m);
    let off = registration.frame.translation.vector - Vector3::new(2.650, 1.890, -0.640);
    for k in 0..3 {
        assert!(off[k].abs() < 4.0 * registration.sigma_m[k], "{off} against {:?}", registration.sigma_m);
    }
    assert!((found.gaps.tcp_speed_m_s.unwrap() - 1.5e-3).abs() < 1e-5);
    assert_eq!(found.gaps.points.iter().filter(|p| p.axis == 0).count(), 4);
}

/// Machine with the gap of A2 over its angle (0.0022 at -70 deg to 0.0042 at -110 deg): held from a static test.
#[test]
fn val_a_known_schedule_leaves_no_false_stiction() {
    let knots = [[-110.0f64, 0.0042f64], [-70.0, 0.0022], [-45.0, 0.0038], [-10.0, 0.0050], [10.0, 0.0046]];
    let curve = Pchip::new(&knots.map(|k| k.map(f64::to_radians))).unwrap();
    let known = Known { axis: 1, half_gap: GapCurve::Pchip(curve), ci95: None };
    let log = circle("circle_uncompensated_figure5.csv.gz");
    let found = identify(&kuka(), &[log], &Options { known: vec![known], ..Options::default() }).unwrap();
    assert!(joint(&found, 1).stiction.is_none() && joint(&found, 1).schedule.is_some());
    for (axis, truth) in [(0, 0.0028), (2, 0.0022)] {
        let j = joint(&found, axis);
        assert!((deg(j.half_gap) / truth - 1.0).abs() < 0.01, "axis {axis}: {}", deg(j.half_gap));
        assert!(j.stiction.is_some());
    }
    assert!(found.inflation < 1.5, "{}", found.inflation);
}

fn busy() -> (lostmotion::robot::Robot, Vec<f64>, Vec<Vec<f64>>, Isometry3<f64>) {
    let robot = kuka();
    let moves = [(0, 10.0, 9.0, 2.0, 0.3), (1, -70.0, 7.0, 3.0, 1.0), (2, 100.0, 8.0, 2.5, 2.0)];
    let (t, cmd) = waves(&robot, &[0.0, -70.0, 100.0, 0.0, 30.0, 0.0], 400.0, &moves);
    (robot, t, cmd, Isometry3::new(Vector3::new(20.0, -3.0, 1.0), Vector3::new(2.9, -1.0, 1.6)))
}

#[test]
fn intervals_cover_the_truth_about_as_often_as_they_say() {
    let (robot, t, cmd, frame) = busy();
    let (mut covered, mut asked, mut false_a2) = (0, 0, 0);
    for seed in 0..12 {
        let log = run(&robot, &t, &cmd, &table3(), &frame, 11e-6, seed);
        let found = identify(&robot, &[log], &Options::default()).unwrap();
        for f in table3() {
            let j = joint(&found, f.axis);
            let truth = f.half_gap.constant().unwrap();
            // a lag that may be there costs as much again
            assert!((j.half_gap / truth - 1.0).abs() < 0.02, "seed {seed} axis {}: {}", f.axis, deg(j.half_gap));
            let mut count = |ci: [f64; 2], v: f64| {
                asked += 1;
                covered += i32::from(ci[0] <= v && v <= ci[1]);
            };
            count(j.ci95, truth);
            match &j.stiction {
                Some(s) if f.spike_deg > 0.0 => {
                    count(s.ci95, f.spike_deg.to_radians());
                    count(s.decay_ci95, f.decay_s);
                    assert!((deg(s.spike) / f.spike_deg - 1.0).abs() < 0.25, "seed {seed}: {}", deg(s.spike));
                }
                Some(_) => false_a2 += 1,
                None => assert!(f.spike_deg == 0.0, "seed {seed}: stiction of axis {} missed", f.axis),
            }
        }
    }
    assert_eq!(false_a2, 0);
    // 84 intervals that are correlated in part: 95 % less three standard deviations
    assert!(f64::from(covered) > 0.86 * f64::from(asked), "{covered} of {asked}");
}

#[test]
fn without_noise_what_was_put_in_comes_out() {
    let (robot, t, cmd, frame) = busy();
    let log = run(&robot, &t, &cmd, &table3(), &frame, 0.0, 1);
    let found = identify(&robot, &[log], &Options::default()).unwrap();
    for f in table3() {
        let j = joint(&found, f.axis);
        assert!((j.half_gap / f.half_gap.constant().unwrap() - 1.0).abs() < 1e-3, "axis {}", f.axis);
        if f.spike_deg > 0.0 {
            let s = j.stiction.as_ref().unwrap();
            assert!((deg(s.spike) / f.spike_deg - 1.0).abs() < 0.02, "axis {}: {}", f.axis, deg(s.spike));
        }
    }
}

#[test]
fn two_logs_in_different_frames_are_fitted_together() {
    let (robot, t, cmd, frame) = busy();
    let other = Isometry3::new(Vector3::new(-1.0, 2.0, 0.5), Vector3::new(0.1, 0.2, -2.0));
    let one = run(&robot, &t, &cmd, &table3(), &frame, 11e-6, 5);
    let two = run(&robot, &t, &cmd, &table3(), &other, 30e-6, 6);
    let single = identify(&robot, std::slice::from_ref(&one), &Options::default()).unwrap();
    let both = identify(&robot, &[one, two], &Options::default()).unwrap();
    for f in table3() {
        let (s, b) = (joint(&single, f.axis), joint(&both, f.axis));
        assert!((b.half_gap / f.half_gap.constant().unwrap() - 1.0).abs() < 0.01);
        assert!(b.ci95[1] - b.ci95[0] < 1.05 * (s.ci95[1] - s.ci95[0]), "a second log does no harm");
    }
    assert!(both.gaps.notes.iter().any(|n| n.to_string().contains("2 logs")));
}

#[test]
fn a_joint_that_never_reverses_is_named_and_the_others_are_found() {
    let robot = kuka();
    let still = [0.0, -70.0, 100.0, 0.0, 30.0, 0.0];
    let (t, mut cmd) = waves(&robot, &still, 300.0, &[(1, -70.0, 8.0, 2.0, 0.5), (2, 100.0, 10.0, 3.0, 1.0)]);
    for (c, t) in cmd[0].iter_mut().zip(&t) {
        *c = (t * 0.1 - 15.0).to_radians();
    }
    let log = run(&robot, &t, &cmd, &table3(), &Isometry3::identity(), 11e-6, 3);
    let found = identify(&robot, &[log], &Options::default()).unwrap();
    assert!(found.gaps.notes.iter().any(|n| n.to_string().contains("A1 never reverses")), "{:?}", found.gaps.notes);
    assert_eq!(found.gaps.joints.iter().map(|j| j.axis).collect::<Vec<_>>(), [1, 2]);
    assert!((deg(joint(&found, 1).half_gap) / 0.0037 - 1.0).abs() < 0.01);
}

#[test]
fn a_joint_whose_axis_passes_through_the_tcp_gets_no_gap() {
    let robot = kuka();
    let axial = robot.with_geometry(robot.joints.clone(), Isometry3::translation(0.0, 0.0, 0.1));
    let still = [0.0, -70.0, 100.0, 0.0, 30.0, 0.0];
    let (t, cmd) = waves(&axial, &still, 300.0, &[(1, -70.0, 8.0, 2.0, 0.5), (5, 0.0, 30.0, 3.0, 1.0)]);
    let log = run(&axial, &t, &cmd, &table3(), &Isometry3::identity(), 11e-6, 3);
    let found = identify(&axial, std::slice::from_ref(&log), &Options::default()).unwrap();
    assert_eq!(found.gaps.joints.iter().map(|j| j.axis).collect::<Vec<_>>(), [1]);
    assert!(found.gaps.notes.iter().any(|n| n.to_string().contains("A6 is left out")), "{:?}", found.gaps.notes);
    assert!((deg(joint(&found, 1).half_gap) / 0.0037 - 1.0).abs() < 0.01);
    let alone = Options { free: vec![5], ..Options::default() };
    let message = identify(&axial, &[log], &alone).unwrap_err().to_string();
    assert!(message.contains("moves the TCP"), "{message}");
}

#[test]
fn a_log_without_a_reversal_is_refused() {
    let robot = kuka();
    let (t, mut cmd) = waves(&robot, &[0.0, -70.0, 100.0, 0.0, 30.0, 0.0], 60.0, &[]);
    for (c, t) in cmd[0].iter_mut().zip(&t) {
        *c = (t * 0.1).to_radians();
    }
    let log = run(&robot, &t, &cmd, &table3(), &Isometry3::identity(), 11e-6, 3);
    let message = identify(&robot, &[log], &Options::default()).unwrap_err().to_string();
    assert!(message.contains("no joint that reverses"), "{message}");
}

#[test]
fn outliers_bursts_and_lost_rows_do_no_harm() {
    let (robot, t, cmd, frame) = busy();
    let mut log = run(&robot, &t, &cmd, &table3(), &frame, 11e-6, 8);
    for k in 0..120 {
        let row = 37 + k * 83;
        log.tcp_m[row] = log.tcp_m[row].map(|p| p + Vector3::new(0.0003 * k as f64, -0.002, 0.4));
    }
    log.tcp_m[4000..4009].iter_mut().for_each(|p| *p = p.map(|p| p + Vector3::new(0.0, 0.0008, 0.0)));
    log.tcp_m[6000..6500].fill(None);
    let found = identify(&robot, &[log], &Options::default()).unwrap();
    for f in table3() {
        let gap = joint(&found, f.axis).half_gap;
        assert!((gap / f.half_gap.constant().unwrap() - 1.0).abs() < 0.01, "axis {}: {}", f.axis, deg(gap));
    }
    let lost = found.gaps.notes.iter().map(|n| n.to_string()).find(|n| n.contains("outliers")).unwrap();
    assert!(lost.contains("500 of"), "{lost}");
}

#[test]
fn a_gap_that_varies_gets_a_schedule() {
    let (robot, t, cmd, frame) = busy();
    let slope = Fault {
        axis: 1,
        half_gap: GapCurve::Polynomial {
            coefficients: vec![0.0100f64.to_radians(), 0.0100f64.to_radians() / 110f64.to_radians()],
            range: [-2.0, 0.0],
        },
        spike_deg: 0.0,
        decay_s: 1.0,
    };
    let log = run(&robot, &t, &cmd, std::slice::from_ref(&slope), &frame, 11e-6, 4);
    let found = identify(&robot, &[log], &Options::default()).unwrap();
    let curve = joint(&found, 1).schedule.clone().unwrap();
    for p in [-76.0f64, -70.0, -64.0] {
        let (got, want) = (curve.at(p.to_radians()), slope.half_gap.at(p.to_radians()));
        assert!((got / want - 1.0).abs() < 0.02, "{p}: {} {}", deg(got), deg(want));
    }
    assert!(joint(&found, 1).varies_p_value.unwrap() < 1e-6 && joint(&found, 1).stiction.is_none());
}

#[test]
fn refuses_poses_a_log_without_positions_and_a_log_that_stands() {
    let (robot, t, cmd, frame) = busy();
    let log = run(&robot, &t, &cmd, &table3(), &frame, 11e-6, 4);
    let refusal = |l: Log| identify(&robot, &[l], &Options::default()).unwrap_err().to_string();
    assert!(refusal(Log { poses: true, ..log.clone() }).contains("settled poses"));
    assert!(refusal(Log { tcp_m: Vec::new(), ..log.clone() }).contains("no columns `x_mm,y_mm,z_mm`"));
    let still = cmd.iter().map(|c| vec![c[0]; c.len()]).collect();
    assert!(refusal(Log { cmd: still, ..log.clone() }).contains("no joint"));
    let only = Options { free: vec![5], ..Options::default() };
    let message = identify(&robot, &[log], &only).unwrap_err().to_string();
    assert!(message.contains("expected movement of A6"), "{message}");
}

#[test]
fn traces_show_the_error_and_its_reversals() {
    let (robot, t, cmd, frame) = busy();
    let log = run(&robot, &t, &cmd, &table3(), &frame, 11e-6, 4);
    let found = identify(&robot, &[log], &Options::default()).unwrap();
    assert_eq!(found.traces.len(), 3);
    for trace in &found.traces {
        assert!(trace.t_s.len() <= 4000 && trace.error.len() == trace.t_s.len() && !trace.reversals_s.is_empty());
        let rms = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
        let left = rms(&mut trace.error.iter().zip(&trace.fitted).map(|(a, b)| a - b));
        assert!(left < 0.5 * rms(&mut trace.error.iter().copied()), "axis {}", trace.axis);
    }
}

#[test]
fn the_command_writes_a_document_that_is_read_back() {
    let out = WorkFolder::new();
    let target = out.join("gaps.yaml");
    let run = |threads: &str| {
        support::command()
            .env("RAYON_NUM_THREADS", threads)
            .args(["identify", "path", "--json", "--robot"])
            .arg(file("configs/kuka-kr120-r2500-pro.yaml"))
            .arg("--log")
            .arg(file("samples/circle/circle_uncompensated_table3.csv.gz"))
            .arg("--output")
            .arg(&target)
            .output()
            .unwrap()
    };
    let (one, two) = (run("1"), run("2"));
    assert!(one.status.success(), "{}", String::from_utf8_lossy(&one.stderr));
    assert_eq!(one.stdout, two.stdout, "the number of threads shows");
    let json: serde_json::Value = serde_json::from_slice(&one.stdout).unwrap();
    assert_eq!(json["schema"], "lostmotion/gaps/1");
    let gaps = Gaps::load(&target, &kuka()).unwrap();
    assert_eq!(gaps.joints.len(), 3);
    assert!((json["joints"][0]["half_gap_deg"].as_f64().unwrap() - deg(gaps.joints[0].half_gap)).abs() < 1e-9);
}

#[test]
fn joints_that_are_not_asked_for_are_fitted_all_the_same() {
    let (robot, t, cmd, frame) = busy();
    let log = run(&robot, &t, &cmd, &table3(), &frame, 11e-6, 4);
    let all = identify(&robot, std::slice::from_ref(&log), &Options::default()).unwrap();
    let only = identify(&robot, &[log], &Options { free: vec![0], ..Options::default() }).unwrap();
    assert_eq!(only.gaps.joints.len(), 1);
    assert!(only.details.iter().all(|d| d.axis == 0) && only.details.len() == 1);
    assert!(only.gaps.points.iter().all(|p| p.axis == 0) && !only.gaps.points.is_empty());
    assert!(only.traces.iter().all(|t| t.axis == 0) && only.traces.len() == 1);
    let (a, b) = (joint(&all, 0), joint(&only, 0));
    let spike = |j: &JointGap| j.stiction.as_ref().unwrap().spike;
    for (x, y) in [(a.half_gap, b.half_gap), (a.ci95[0], b.ci95[0]), (a.ci95[1], b.ci95[1]), (spike(a), spike(b))] {
        assert!((x - y).abs() < 1e-9, "{x} {y}");
    }
}

#[test]
fn a_log_or_a_gaps_file_given_twice_is_refused() {
    let (robot, t, cmd, frame) = busy();
    let mut log = run(&robot, &t, &cmd, &table3(), &frame, 11e-6, 4);
    log.sha256 = "ab".into();
    let found = identify(&robot, std::slice::from_ref(&log), &Options::default()).unwrap();
    let message = identify(&robot, &[log.clone(), log], &Options::default()).unwrap_err().to_string();
    assert!(message.contains("same SHA-256") && message.contains("its reversals would count twice"), "{message}");
    let dir = WorkFolder::new();
    let text = lostmotion::gaps::file::to_yaml(&lostmotion::gaps::file::document(&found.gaps, &robot)).unwrap();
    let fit = |names: &[&str]| {
        let mut command = support::command();
        command.args(["fit", "--json", "--robot"]).arg(file("configs/kuka-kr120-r2500-pro.yaml"));
        for name in names {
            std::fs::write(dir.join(name), &text).unwrap();
            command.arg("--gaps").arg(dir.join(name));
        }
        command.output().unwrap()
    };
    assert!(fit(&["a.yaml"]).status.success());
    let twice = fit(&["a.yaml", "copy.yaml"]);
    let message = String::from_utf8_lossy(&twice.stderr).into_owned();
    assert!(twice.status.code() == Some(2) && message.contains("copy.yaml"), "{message}");
}

#[test]
fn val_swapped_or_negated_axes_are_refused() {
    let good = circle("circle_uncompensated_table3.csv.gz");
    let changes: [fn(Vector3<f64>) -> Vector3<f64>; 2] =
        [|p| Vector3::new(p.y, p.x, p.z), |p| Vector3::new(p.x, p.y, -p.z)];
    for change in changes {
        let mut log = good.clone();
        log.tcp_m.iter_mut().for_each(|p| *p = p.map(change));
        let refused = identify(&kuka(), &[log], &Options::default()).map(|f| (f.inflation, f.sigma_m, f.gaps.joints));
        let message = refused.unwrap_err().to_string();
        assert!(message.contains("mirrored frame"), "{message}");
    }
}
