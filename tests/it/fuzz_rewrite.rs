//! Programs of every language, mutated, rewritten and checked as the targets of `fuzz/` check them: no panic, no edit that reads otherwise
//! than it was meant, no joint target that the result does not lead to. With the stable compiler and a fixed seed.

#[path = "../../fuzz/src/lib.rs"]
mod checks;

use super::fuzz_readers::mutated;
use crate::support::bundled;
use checks::{ABB, FANUC, GANTRY, KUKA, MOTOMAN, UR, rewrite_and_check, robot};
use lostmotion::program::formats::FORMATS;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::Path;

/// The samples of a format; of KRL, each `.src` with its `.dat` too.
fn seeds(format: &str) -> Vec<Vec<u8>> {
    let folder = bundled("samples/programs").join(format);
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.sort();
    let read = |p: &Path| std::fs::read(p).unwrap();
    let mut all: Vec<_> = paths.iter().map(|p| read(p)).collect();
    for program in paths.iter().filter(|p| p.extension().is_some_and(|e| e == "src")) {
        let data = ["dat", "DAT"].map(|e| program.with_extension(e)).into_iter().find(|p| p.exists());
        all.extend(data.map(|data| [read(program), vec![checks::NEXT_FILE], read(&data)].concat()));
    }
    all
}

/// A sample with a digit, a line or two changed, so that most of them stay programs; every fourth is damaged at random instead.
fn changed(seeds: &[Vec<u8>], random: &mut ChaCha8Rng) -> Vec<u8> {
    if random.random_range(0..4) == 0 {
        return mutated(seeds, random);
    }
    let seed = &seeds[random.random_range(0..seeds.len())];
    let mut lines: Vec<Vec<u8>> = seed.split_inclusive(|b| *b == b'\n').map(<[u8]>::to_vec).collect();
    for _ in 0..=random.random_range(0..3) {
        let (from, to) = (random.random_range(0..lines.len()), random.random_range(0..lines.len()));
        match random.random_range(0..6) {
            0 => lines.insert(to, lines[from].clone()),
            1 if lines.len() > 1 => drop(lines.remove(from)),
            2 => lines.swap(from, to),
            _ => {
                let digits: Vec<usize> = (0..lines[from].len()).filter(|k| lines[from][*k].is_ascii_digit()).collect();
                if !digits.is_empty() {
                    let at = digits[random.random_range(0..digits.len())];
                    lines[from][at] = b'0' + random.random_range(0..10);
                }
            }
        }
    }
    lines.concat()
}

fn run(runs: usize) {
    for format in FORMATS {
        let robot = robot(match format.name() {
            "krl" | "trajectory" => KUKA,
            "rapid" => ABB,
            "fanuc" => FANUC,
            "inform" => MOTOMAN,
            "urscript" => UR,
            "gcode" => GANTRY,
            other => panic!("{other}: a format without a robot to try it on"),
        });
        let (seeds, mut random) = (seeds(format.name()), ChaCha8Rng::seed_from_u64(0x51ed_270b));
        let of_samples = seeds.iter().filter(|s| rewrite_and_check(*format, &robot, s)).count();
        let mutants = (0..runs).filter(|_| rewrite_and_check(*format, &robot, &changed(&seeds, &mut random))).count();
        println!("{}: {of_samples} of {} samples edited, {mutants} of {runs} inputs", format.name(), seeds.len());
        assert!(of_samples > 0 && mutants > 0, "{}: nothing was edited, so nothing was checked", format.name());
    }
}

#[test]
fn rewritten_mutants_read_as_they_were_meant() {
    run(60);
}

/// `LOSTMOTION_FUZZ_RUNS=100000 cargo test --release --test it fuzz_rewrite -- --ignored --nocapture`
#[test]
#[ignore = "takes as long as LOSTMOTION_FUZZ_RUNS asks for"]
fn many_more_rewritten_mutants() {
    run(std::env::var("LOSTMOTION_FUZZ_RUNS").ok().and_then(|v| v.parse().ok()).unwrap_or(5_000));
}
