//! Tables II and III of Cursi (2022) on the simulated instrument, beside the published ones: `cargo run --release --example instrument [SEED]`.
//!
//! With `write` as its argument it writes the programs and paths of `samples/instrument` and the picture of `docs/track.md` in place
//! of the tables' text only.

mod instrument;
mod picture;

use flate2::{Compression, write::GzEncoder};
use instrument::{Instrument, NOISE_M, Run, shapes};
use lostmotion::learn::{Kind, TrainingResult};
use std::io::Write;
use std::time::Instant;

pub const SAMPLES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/samples/instrument");
const PICTURE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/track.svg");

/// Kinematics, with compensation; Table II: position train x, y, test x, y, velocity train x, y, test x, y, mm and mm per unit of time.
const TABLE_2: [(Kind, bool, [f64; 8]); 4] = [
    (Kind::Augmented, true, [3.59, 2.31, 3.55, 2.18, 1.03, 0.73, 1.04, 0.65]),
    (Kind::Augmented, false, [3.21, 2.01, 3.40, 2.06, 1.20, 0.86, 1.22, 0.84]),
    (Kind::Plain, true, [3.12, 1.77, 3.26, 1.91, 1.38, 1.24, 1.23, 1.25]),
    (Kind::Plain, false, [2.67, 1.72, 2.60, 1.84, 1.46, 1.16, 1.31, 1.16]),
];

/// Tables IIIa (mm) and IIIb (%), in the order of [`TABLE_2`], then the nominal model with and without compensation.
const TABLE_3: [([f64; 4], [f64; 4]); 6] = [
    ([2.58, 3.27, 3.56, 5.58], [82.0, 84.0, 89.0, 87.0]),
    ([4.96, 5.26, 5.05, 5.26], [25.0, 21.0, 27.0, 29.0]),
    ([6.53, 8.58, 3.41, 4.99], [86.0, 87.0, 89.0, 57.0]),
    ([6.54, 5.54, 6.02, 5.04], [14.0, 17.0, 33.0, 29.0]),
    ([4.55, 6.01, 5.52, 5.49], [14.0, 38.0, 20.0, 34.0]),
    ([6.04, 6.33, 6.45, 6.58], [2.0, 8.0, 2.0, 6.0]),
];

fn main() -> std::io::Result<()> {
    let argument = std::env::args().nth(1);
    let write = argument.as_deref() == Some("write");
    let seed = argument.and_then(|a| a.parse().ok()).unwrap_or(1);
    let instrument = Instrument::load();
    if write {
        let desired = instrument.program("excitation.csv", instrument.excitation());
        let compensated = instrument.compensated(&desired);
        packed("excitation.csv.gz", instrument.excitation().as_bytes())?;
        packed("excitation.log.csv.gz", &instrument.log_text(&desired, NOISE_M))?;
        packed("excitation_compensated.log.csv.gz", &instrument.log_text(&compensated, NOISE_M))?;
        for shape in shapes() {
            std::fs::write(format!("{SAMPLES}/{}.csv", shape.name), shape.text)?;
        }
    }
    let all = tables(&instrument, seed);
    if write {
        std::fs::write(PICTURE, picture::draw(&shapes(), &all[0], &all[1], &all[4]))?;
    }
    println!("\nThe same, homed by hand before each run, deadzones reduced as in Table I for random motions\n");
    tables(&Instrument::by_hand(), seed);
    Ok(())
}

/// Writes a sample, gzipped without a date.
fn packed(name: &str, bytes: &[u8]) -> std::io::Result<()> {
    let mut out = GzEncoder::new(Vec::new(), Compression::best());
    out.write_all(bytes)?;
    std::fs::write(format!("{SAMPLES}/{name}"), out.finish()?)
}

/// Prints both tables; what each model of Table III ran.
fn tables(instrument: &Instrument, seed: u64) -> Vec<Vec<Run>> {
    println!("Table II, RMSE: x, y of training, then of test; ours / published\n");
    let mut models: Vec<(String, bool, Option<TrainingResult>)> = Vec::new();
    for (kind, compensation, published) in TABLE_2 {
        let start = Instant::now();
        let lesson = instrument.learn(kind, compensation, seed);
        let seconds = start.elapsed().as_secs_f64();
        let e = &lesson.learned.evidence;
        let position = e.train.iter().chain(&e.test).map(|r| r.position_m * 1e3);
        let speed = e.train.iter().chain(&e.test).map(|r| r.speed_m_s.unwrap_or(f64::NAN) * 1e3);
        let line = |ours: Vec<f64>, theirs: &[f64]| {
            ours.iter().zip(theirs).map(|(o, p)| format!("{o:8.2} / {p:.2}")).collect::<String>()
        };
        println!("{:<10}{}", kind.text(), words(compensation));
        println!("  position, mm   {}", line(position.collect(), &published[..4]));
        println!("  velocity, mm/s {}   ({seconds:.1} s)", line(speed.collect(), &published[4..]));
        models.push((kind.text().into(), compensation, Some(lesson)));
    }
    models.extend([("nominal".into(), true, None), ("nominal".into(), false, None)]);
    println!(
        "\nTable III, mean error in mm and area in %: ellipse 12-20, 20-12, rectangle 12-20, 20-12, mean; ours / published\n"
    );
    let paths = shapes();
    let mut all: Vec<Vec<Run>> = Vec::new();
    for ((name, compensation, lesson), (error, area)) in models.iter().zip(TABLE_3) {
        let learned = lesson.as_ref().map(|l| &l.learned);
        let runs: Vec<Run> =
            paths.iter().map(|s| instrument.measure(s, &instrument.track(s, learned), *compensation)).collect();
        let mean = |v: &dyn Fn(&Run) -> f64| runs.iter().map(v).sum::<f64>() / 4.0;
        let line = |v: &dyn Fn(&Run) -> f64, theirs: [f64; 4], digits: usize| {
            let each = runs.iter().zip(theirs).map(|(r, p)| format!("{:8.digits$} / {p:.digits$}", v(r)));
            let published = theirs.iter().sum::<f64>() / 4.0;
            each.collect::<String>() + &format!("{:8.digits$} / {published:.digits$}", mean(v))
        };
        println!("{name:<10}{}", words(*compensation));
        println!("  error, mm {}", line(&|r| r.mean_error_mm, error, 2));
        println!("  area, %   {}", line(&|r| r.area_ratio * 100.0, area, 0));
        all.push(runs);
    }
    all
}

fn words(compensation: bool) -> &'static str {
    if compensation { "with compensation" } else { "without compensation" }
}
