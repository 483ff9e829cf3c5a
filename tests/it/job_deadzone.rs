//! The job of Cursi (2022) through the binary: log of the growing sine -> deadzones -> compensator -> three motions -> what is left.

use crate::support::{WorkFolder, bundled, run_from_root};
use serde_json::Value;
use std::path::Path;
use std::sync::LazyLock;

const ROBOT: &str = "configs/micro-iges-4dof.yaml";
const MODEL: &str = "samples/instrument/instrument.model.yaml";
const LOG: &str = "samples/instrument/growing_sine_log.csv.gz";
const MOTIONS: [&str; 3] = ["growing_sine", "exponential", "random"];

/// Gaps and compensator from the bundled log, and the runs of the three motions without compensation.
static JOB: LazyLock<WorkFolder> = LazyLock::new(|| {
    let work = WorkFolder::new();
    let w = work.path();
    run_from_root(
        w,
        &format!("identify deadzone --robot {ROBOT} --log {LOG} --output {{}}/gaps.yaml --report {{}}/gaps.html"),
    )
    .success();
    run_from_root(w, &format!("fit --robot {ROBOT} --gaps {{}}/gaps.yaml --output {{}}/comp.yaml")).success();
    // written once: tests that run at the same time read it
    let robot = std::fs::canonicalize(bundled(ROBOT)).unwrap();
    let text = format!("schema: lostmotion/model/1\nrobot: {}\neffects: []\n", robot.display());
    std::fs::write(w.join("ideal.yaml"), text).unwrap();
    for m in MOTIONS {
        simulate(w, MODEL, &format!("samples/instrument/{m}.csv"), &format!("{{}}/before_{m}.csv"), 50);
    }
    work
});

fn simulate(w: &Path, model: &str, input: &str, output: &str, noise_um: u32) {
    run_from_root(
        w,
        &format!(
            "simulate --model {model} --input {input} --rate-hz 5 --noise-um {noise_um} --seed 7 --output {output}"
        ),
    )
    .success();
}

/// Mean deadzones without and with a law, and the reduction, joint by joint.
fn reductions(law: &str, motion: &str) -> Vec<f64> {
    let w = JOB.path();
    let program = format!("samples/instrument/{motion}.csv");
    run_from_root(
        w,
        &format!(
            "rewrite --robot {ROBOT} --compensator {{}}/comp.yaml --law {law} {program} --output {{}}/{law}_{motion}.csv"
        ),
    ).success();
    simulate(w, MODEL, &format!("{{}}/{law}_{motion}.csv"), &format!("{{}}/{law}_{motion}_log.csv"), 50);
    let doc: Value = run_from_root(
        w,
        &format!(
            "assess deadzone --robot {ROBOT} --nominal {program} --before {{}}/before_{motion}.csv --after {{}}/{law}_{motion}_log.csv --json"
        ),
    ).success().json();
    assert_eq!(doc["schema"], "lostmotion/deadzone/1");
    doc["joints"].as_array().unwrap().iter().map(|j| j["reduction"].as_f64().unwrap()).collect()
}

/// Root mean square of the tip's distance from a machine without gaps that runs the wanted program, mm; from the second joint's
/// sweep on, when every joint but those still to come has been moved once.
fn tip_rms_mm(program: &str, wanted: &str) -> f64 {
    let w = JOB.path();
    let exact = |model: &str, input: &str| -> Vec<[f64; 3]> {
        let text =
            run_from_root(w, &format!("simulate --model {model} --input {input} --rate-hz 5 --base-frame --output -"))
                .success()
                .text();
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
        reader.records().map(|r| r.unwrap()).map(|r| [5, 6, 7].map(|k| r[k].parse().unwrap())).collect()
    };
    let (is, want) = (exact(MODEL, program), exact("{}/ideal.yaml", wanted));
    let squares: Vec<f64> =
        is.iter().zip(&want).map(|(a, b)| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>()).collect();
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}

#[test]
fn gaps_of_the_published_sizes_are_found_in_the_bundled_log() {
    let w = JOB.path();
    let doc: Value =
        run_from_root(w, &format!("identify deadzone --robot {ROBOT} --log {LOG} --json")).success().json();
    // Table I, growing sine, without compensation; 0.5 deg of a joint for 1 rad of its motor
    for (j, rad) in doc["joints"].as_array().unwrap().iter().zip([7.28, 12.83, 7.28, 8.95]) {
        let mean = j["mean_deadzone_deg"].as_f64().unwrap();
        // small sweeps end inside the gap, so that the mean leans to the outer deadzones
        assert!((mean / (0.5 * rad) - 1.0).abs() < 0.08, "{}: {mean} for {}", j["joint"], 0.5 * rad);
        assert!(j["significant"].as_bool().unwrap() && j["schedule"]["kind"] == "pchip");
    }
    let page = std::fs::read_to_string(w.join("gaps.html")).unwrap();
    assert!(page.contains("Deadzones from growing sweeps") && page.contains("algorithm 1"));
    // half gaps of degrees are shown in degrees
    assert!(page.contains("half gap, deg") && !page.contains("half gap, mdeg"));
    assert!(page.contains("half gap of E1</span><span class=\"value\">1.8"), "not in degrees");
}

/// The paper: 88 to 94 % on the growing sine, 6 to 44 % and 12 to 43 % on the others. This instrument keeps to the assumption
/// that deadzones depend on position alone, the real one does not.
#[test]
fn equation_16_takes_the_deadzones_out_of_all_three_motions() {
    for motion in MOTIONS {
        for r in reductions("equation-16", motion) {
            assert!((0.9..1.06).contains(&r), "{motion}: {r}");
        }
        let program = format!("samples/instrument/{motion}.csv");
        let (before, after) =
            (tip_rms_mm(&program, &program), tip_rms_mm(&format!("{{}}/equation-16_{motion}.csv"), &program));
        assert!(before > 1.5 && after < 0.08 * before, "{motion}: {before} -> {after} mm rms at the tip");
    }
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn equation_2_as_printed_changes_nothing_and_held_leaves_the_tip_farther_off_than_before() {
    let motion = "growing_sine";
    let program = format!("samples/instrument/{motion}.csv");
    // the jump of one sample also upsets the sizes that are found again: the tip below is what counts
    for r in reductions("equation-2", motion) {
        assert!((-0.2..0.6).contains(&r), "the offset lasts one sample: {r}");
    }
    for r in reductions("equation-2-held", motion) {
        assert!(r > 0.85, "{r}");
    }
    let before = tip_rms_mm(&program, &program);
    let printed = tip_rms_mm(&format!("{{}}/equation-2_{motion}.csv"), &program);
    let held = tip_rms_mm(&format!("{{}}/equation-2-held_{motion}.csv"), &program);
    assert!((printed / before - 1.0).abs() < 0.1, "{before} -> {printed}");
    assert!(held > 1.5 * before, "half a gap, and what varying gaps add up to: {before} -> {held}");
}

#[test]
fn a_friction_that_the_map_does_not_know_leaves_part_of_the_deadzones() {
    let w = JOB.path();
    let model = "samples/instrument/friction.model.yaml";
    simulate(w, model, "samples/instrument/growing_sine.csv", "{}/f_sweep.csv", 50);
    run_from_root(w, &format!("identify deadzone --robot {ROBOT} --log {{}}/f_sweep.csv --output {{}}/f_gaps.yaml"))
        .success();
    run_from_root(w, &format!("fit --robot {ROBOT} --gaps {{}}/f_gaps.yaml --output {{}}/f_comp.yaml")).success();
    let program = "samples/instrument/random.csv";
    run_from_root(
        w,
        &format!("rewrite --robot {ROBOT} --compensator {{}}/f_comp.yaml {program} --output {{}}/f_out.csv"),
    )
    .success();
    simulate(w, model, program, "{}/f_before.csv", 50);
    simulate(w, model, "{}/f_out.csv", "{}/f_after.csv", 50);
    let doc: Value = run_from_root(
        w,
        &format!(
            "assess deadzone --robot {ROBOT} --nominal {program} --before {{}}/f_before.csv --after {{}}/f_after.csv --json"
        ),
    ).success().json();
    for j in doc["joints"].as_array().unwrap() {
        let r = j["reduction"].as_f64().unwrap();
        assert!((0.6..0.9).contains(&r), "{}: {r}", j["joint"]);
    }
}

#[test]
fn the_command_refuses_what_it_cannot_use() {
    let w = JOB.path();
    let says = |line: &str| {
        let out = run_from_root(w, line);
        assert_eq!(out.code, Some(2), "{line}");
        out.stderr
    };
    let circle = "--robot configs/kuka-kr120-r2500-pro.yaml --log samples/circle/circle_uncompensated_table3.csv.gz";
    assert!(says(&format!("identify deadzone {circle}")).contains("together"));
    assert!(says(&format!("identify deadzone --robot {ROBOT} --log {LOG} --joint A9")).contains("E1, E2, PITCH, YAW"));
    assert!(says(&format!("identify deadzone --robot {ROBOT} --log {LOG} --rest-um 0")).contains("--rest-um"));
    assert!(
        says(&format!("identify deadzone --robot {ROBOT} --log {LOG} --eps-tip-mm-s 1")).contains("--eps-motor-deg-s")
    );
    assert!(says(&format!("identify deadzone --robot {ROBOT} --log {LOG} --log {LOG}")).contains("once"));
    let law = format!(
        "rewrite --robot {ROBOT} --compensator {{}}/comp.yaml samples/instrument/random.csv --output {{}}/x.csv"
    );
    assert!(says(&format!("{law} --law equation-2 --refine cubic")).contains("--refine"));
    assert!(!w.join("x.csv").exists());
    let no_times = w.join("no_times.csv");
    std::fs::write(&no_times, "e1_deg,e2_deg,pitch_deg,yaw_deg\n0,0,0,0\n1,0,0,0\n").unwrap();
    let nominal = format!("assess deadzone --robot {ROBOT} --nominal {{}}/no_times.csv --before {LOG}");
    assert!(says(&nominal).contains("t_s"));
}

#[test]
fn one_joint_can_be_asked_for_and_the_printed_algorithm_stands_beside() {
    let w = JOB.path();
    let line = format!(
        "identify deadzone --robot {ROBOT} --log {LOG} --joint PITCH --eps-motor-deg-s 0.05 --eps-tip-mm-s 0.6 --json"
    );
    let doc: Value = run_from_root(w, &line).success().json();
    let joints = doc["joints"].as_array().unwrap();
    assert_eq!(joints.len(), 1);
    assert_eq!(joints[0]["joint"], "PITCH");
    let (ours, printed) = (&joints[0]["deadzones"], &joints[0]["as_printed"]["deadzones"]);
    assert!(2 * printed.as_u64().unwrap() > 3 * ours.as_u64().unwrap(), "{printed} as printed, {ours} ours");
}
