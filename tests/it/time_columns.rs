//! Columns of times and durations in joint CSV: an added row never shares the time of another.

use crate::support::WorkFolder;
use std::fmt::Write;

const HEADER: &str = "a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg";

/// A desk with a compensator of A1.
fn desk() -> WorkFolder {
    let desk = WorkFolder::new();
    std::fs::copy("configs/kuka-kr120-r2500-pro.yaml", desk.join("robot.yaml")).unwrap();
    let model = "schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n  - {effect: backlash, joint: A1, half_gap_deg: 0.004}\n";
    std::fs::write(desk.join("model.yaml"), model).unwrap();
    desk
}

/// A swing of A1 of 101 rows, 0.1 s apart, whose first column is `name` with what `cell` makes of the time.
fn program(name: &str, cell: impl Fn(f64) -> String) -> String {
    let mut text = format!("{name},{HEADER}\n");
    for k in 0..101 {
        let t_s = 0.1 * f64::from(k);
        let a1 = 5.0 * (1.3 * t_s).sin();
        writeln!(text, "{},{a1:.4},-80.0000,90.0000,0.0000,30.0000,0.0000", cell(t_s)).unwrap();
    }
    text
}

/// The first column of the rewritten program, and its text.
fn rewritten(desk: &WorkFolder, text: &str) -> (Vec<f64>, String) {
    std::fs::write(desk.join("p.csv"), text).unwrap();
    let run = desk.run("rewrite --model model.yaml p.csv --output out.csv --replace --force").success();
    let out = std::fs::read_to_string(desk.join("out.csv")).unwrap();
    assert!(out.lines().count() > text.lines().count(), "no row was added: {}", run.stderr);
    let times = out.lines().skip(1).map(|l| l.split(',').next().unwrap().parse().unwrap()).collect();
    (times, out)
}

#[test]
fn times_of_other_names_and_units_increase_over_added_rows() {
    let desk = desk();
    let milliseconds = |t_s: f64| format!("{:.0}", 1e3 * t_s);
    let seconds = |t_s: f64| format!("{t_s:.3}");
    let nanoseconds = |t_s: f64| format!("{:.0}", 1e9 * t_s);
    let reference = rewritten(&desk, &program("t_s", seconds)).1;
    for (name, per_s, text) in [
        ("t_ms", 1e3, program("t_ms", milliseconds)),
        ("time_s", 1.0, program("time_s", seconds)),
        ("Time [ms]", 1e3, program("Time [ms]", milliseconds)),
        ("timestamp_ns", 1e9, program("timestamp_ns", nanoseconds)),
    ] {
        let (times, out) = rewritten(&desk, &text);
        assert!(times.windows(2).all(|t| t[1] > t[0]), "{name}: {out}");
        // the same rows as with `t_s`, at the same times
        for (line, own) in reference.lines().zip(out.lines()).skip(1) {
            let (t_s, joints) = line.split_once(',').unwrap();
            let (time, own) = own.split_once(',').unwrap();
            assert_eq!(joints, own, "{name}");
            let [t_s, time] = [t_s, time].map(|t| t.parse::<f64>().unwrap());
            assert!((time / per_s - t_s).abs() < 2e-6, "{name}: {time} for {t_s} s");
        }
    }
}

#[test]
fn a_duration_is_split_between_an_added_row_and_the_next() {
    let desk = desk();
    for (name, dt) in [("dt_s", "0.100"), ("dt_ms", "100"), ("duration", "0.1")] {
        let text = program(name, |_| dt.into());
        let (durations, out) = rewritten(&desk, &text);
        let dt: f64 = dt.parse().unwrap();
        assert!(durations.iter().all(|d| *d > 0.0), "{name}: {out}");
        let (sum, before) = (durations.iter().sum::<f64>(), 101.0 * dt);
        assert!((sum - before).abs() < 1e-9 * before, "{name}: {sum} for {before}");
        // rows that no added row stands before keep their bytes
        let kept = out.lines().filter(|l| text.lines().any(|own| own.split(',').next() == l.split(',').next())).count();
        assert!(kept > 90, "{name}: {out}");
    }
}

#[test]
fn a_time_without_a_unit_is_refused_where_it_increases() {
    let desk = desk();
    let dates = |t_s: f64| format!("2024-05-01T10:00:{t_s:06.3}");
    for text in [
        program("timestamp", |t| format!("{t:.3}")),
        program("Time", |t| format!("{t:.3}")),
        program("time_utc", dates),
    ] {
        std::fs::write(desk.join("p.csv"), &text).unwrap();
        let run = desk.run("rewrite --model model.yaml p.csv --output out.csv --replace").ends_with(2);
        assert!(run.stderr.contains("p.csv:1:1") && run.stderr.contains("t_ms"), "{}", run.stderr);
        assert!(!desk.join("out.csv").exists());
    }
    // one that stands still is no time of a row
    rewritten(&desk, &program("timestamp", |_| "0".into()));
    // and a second column of times has no use
    let two = program("t_s,t_ms", |t| format!("{t:.3},{:.0}", 1e3 * t));
    std::fs::write(desk.join("p.csv"), two).unwrap();
    let run = desk.run("rewrite --model model.yaml p.csv --output two.csv").ends_with(2);
    assert!(run.stderr.contains("a second column of times, `t_ms` beside `t_s`"), "{}", run.stderr);
}

#[test]
fn milliseconds_under_t_s_are_noted() {
    let desk = desk();
    std::fs::write(desk.join("p.csv"), program("t_s", |t| format!("{:.0}", 1e3 * t))).unwrap();
    let run = desk.run("rewrite --model model.yaml p.csv --output out.csv").success();
    assert!(run.stderr.contains("the times look like milliseconds"), "{}", run.stderr);
    std::fs::write(desk.join("q.csv"), program("t_s", |t| format!("{t:.3}"))).unwrap();
    let run = desk.run("rewrite --model model.yaml q.csv --output q.out.csv").success();
    assert!(!run.stderr.contains("milliseconds"), "{}", run.stderr);
}
