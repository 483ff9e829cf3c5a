//! Cost of `identify path`: the bundled circle log (52,358 rows), and the same at five times the rate (261,786 rows).
//!
//! `cargo bench --bench identify`. For the whole process including reading, time
//! `lostmotion identify path --robot R --log L --json` against `pipeline.py fit L --robot R`
//! (numpy, pandas and scipy; `docs/identify-path.md` has the figures).

use lostmotion::identify::path::{Options, identify};
use lostmotion::log::Log;
use lostmotion::robot::Robot;
use nalgebra::Vector3;
use rand::SeedableRng;
use rand_distr::{Distribution, Normal};
use std::path::Path;

fn main() {
    divan::main();
}

fn load() -> (Robot, Log) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let robot = Robot::load(&root.join("configs/kuka-kr120-r2500-pro.yaml")).expect("the bundled robot");
    let log = root.join("samples/circle/circle_uncompensated_table3.csv.gz");
    let log = Log::load(&log, &robot).expect("the bundled log");
    (robot, log)
}

/// The log with four rows between each two: commands linear, positions of the row before plus noise of 11 um. The positions lag by
/// up to four rows; as a load on the program that is as good as any other log.
fn five_times(log: &Log) -> Log {
    let n = (log.len() - 1) * 5 + 1;
    let between = |v: &[f64]| -> Vec<f64> {
        (0..n)
            .map(|i| {
                let (k, u) = (i / 5, (i % 5) as f64 / 5.0);
                v[k] + u * (v.get(k + 1).copied().unwrap_or(v[k]) - v[k])
            })
            .collect()
    };
    let mut out = log.clone();
    out.t_s = between(&log.t_s);
    out.cmd = log.cmd.iter().map(|c| between(c)).collect();
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
    let normal = Normal::new(0.0, 11e-6).expect("a sigma");
    let mut noisy = |p: Vector3<f64>| p + Vector3::from_fn(|_, _| normal.sample(&mut rng));
    out.tcp_m = (0..n).map(|i| log.tcp_m[i / 5].map(&mut noisy)).collect();
    out.line = (0..n as u32).collect();
    out
}

#[divan::bench(sample_count = 10)]
fn circle_52k_rows(bencher: divan::Bencher) {
    let (robot, log) = load();
    let logs = [log];
    bencher.bench_local(|| identify(&robot, &logs, &Options::default()));
}

#[divan::bench(sample_count = 5)]
fn circle_262k_rows(bencher: divan::Bencher) {
    let (robot, log) = load();
    let logs = [five_times(&log)];
    bencher.bench_local(|| identify(&robot, &logs, &Options::default()));
}
