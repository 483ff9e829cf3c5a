//! Damage: bits, cuts, doubled lines, joined files, huge numbers, NUL bytes. Seeded: mutation `k` is always the same.

use super::edits::{self, Outcome};
use super::samples::Sample;
use lostmotion::program::script::Text;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

/// A damaged sample of some kilobytes takes milliseconds; what takes longer than this hangs.
const TOO_LONG: Duration = Duration::from_secs(20);

#[derive(Default)]
pub struct Tally {
    refused: usize,
    read: usize,
    edited: usize,
    edits_refused: usize,
    pub failures: Vec<String>,
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all = self.refused + self.read;
        write!(f, "{all} mutations: {} refused, {} read; of their edits {} ", self.refused, self.read, self.edited)?;
        write!(f, "came back, {} were refused; {} failures", self.edits_refused, self.failures.len())
    }
}

impl Tally {
    fn and(mut self, other: Self) -> Self {
        self.refused += other.refused;
        self.read += other.read;
        self.edited += other.edited;
        self.edits_refused += other.edits_refused;
        self.failures.extend(other.failures);
        self
    }
}

/// Runs mutations of all samples in turn, in parallel.
pub fn run(samples: &[Sample], count: usize) -> Tally {
    let tallies = (0..count).into_par_iter().map(|k| one(samples, k));
    let mut tally = tallies.reduce(Tally::default, Tally::and);
    tally.failures.sort();
    tally.failures.truncate(20);
    tally
}

fn one(samples: &[Sample], k: usize) -> Tally {
    let sample = &samples[k % samples.len()];
    let mut rng = ChaCha8Rng::seed_from_u64(k as u64);
    let other = &samples[rng.random_range(0..samples.len())];
    let mut bytes: Vec<Vec<u8>> = sample.texts.iter().map(|t| t.bytes.to_vec()).collect();
    for _ in 0..rng.random_range(1..=3) {
        let which = rng.random_range(0..bytes.len());
        damage(&mut bytes[which], &other.texts[0].bytes, &mut rng);
    }
    let texts = sample.texts.iter().zip(bytes).map(|(t, b)| Text::new(t.name.as_str(), b)).collect();
    let damaged = sample.with(texts);
    let started = Instant::now();
    let result = catch_unwind(AssertUnwindSafe(|| survive(&damaged, k as u64)));
    let name = sample.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let failed = |what: String| Tally { failures: vec![format!("mutation {k} of {name}: {what}")], ..Tally::default() };
    match result {
        _ if started.elapsed() > TOO_LONG => failed(format!("took {:?}", started.elapsed())),
        Ok(Ok(tally)) => tally,
        Ok(Err(e)) => {
            let text = String::from_utf8_lossy(&damaged.texts[0].bytes).into_owned();
            failed(format!("{e}\nof the damaged program\n{text}"))
        }
        Err(panic) => {
            let words = panic.downcast_ref::<String>().cloned();
            let words = words.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_string()));
            failed(format!("panicked: {}", words.unwrap_or_default()))
        }
    }
}

fn survive(damaged: &Sample, seed: u64) -> Result<Tally, String> {
    let document = match damaged.parse() {
        Ok(d) => d,
        Err(robot_programs::Error::BadInput(_)) => return Ok(Tally { refused: 1, ..Tally::default() }),
        Err(e) => return Err(format!("refused as no bad input: {e}")),
    };
    edits::nothing(damaged, &*document)?;
    let mut tally = Tally { read: 1, ..Tally::default() };
    let wish = edits::random(&*document, &damaged.robot, seed);
    match edits::check(damaged, &*document, &wish)? {
        Outcome::Edited => tally.edited += 1,
        Outcome::Refused(_) => tally.edits_refused += 1,
        Outcome::Nothing => {}
    }
    Ok(tally)
}

/// One piece of damage.
fn damage(bytes: &mut Vec<u8>, other: &[u8], rng: &mut ChaCha8Rng) {
    let place = |len: usize, rng: &mut ChaCha8Rng| if len == 0 { 0 } else { rng.random_range(0..len) };
    let at = place(bytes.len(), rng);
    match rng.random_range(0..11) {
        0 => {
            for _ in 0..rng.random_range(1..=4) {
                let at = place(bytes.len(), rng);
                if let Some(b) = bytes.get_mut(at) {
                    *b ^= 1 << rng.random_range(0..8);
                }
            }
        }
        1 => bytes.truncate(at),
        2 => {
            let end = (at + rng.random_range(1..40)).min(bytes.len());
            bytes.drain(at..end);
        }
        3 => {
            let line = line(bytes, at);
            let copy = bytes[line.clone()].to_vec();
            bytes.splice(line.end..line.end, copy);
        }
        4 => {
            let line = line(bytes, at);
            bytes.drain(line);
        }
        5 => {
            let (a, b) = (line(bytes, at), line(bytes, place(bytes.len(), rng)));
            let moved = bytes[a].to_vec();
            bytes.splice(b.start..b.start, moved);
        }
        6 => {
            let cut = place(other.len(), rng);
            bytes.truncate(at);
            bytes.extend_from_slice(&other[cut..]);
        }
        7 => bytes.extend_from_slice(other),
        8 => {
            // a number becomes another one
            const NUMBERS: [&[u8]; 9] = [
                b"1e308",
                b"-9E9",
                b"99999999999999999999999999",
                b"0",
                b"-0.0",
                b"1e-400",
                b"nan",
                b"00.5",
                b"2147483648",
            ];
            if let Some(start) = bytes.iter().skip(at).position(u8::is_ascii_digit).map(|k| k + at) {
                let digits = bytes[start..].iter().take_while(|b| b.is_ascii_digit() || **b == b'.').count();
                let number = NUMBERS[rng.random_range(0..NUMBERS.len())];
                bytes.splice(start..start + digits, number.iter().copied());
            }
        }
        9 => bytes.insert(at, 0),
        _ => {
            const ODD: &[u8] = b"\r\n\t ;,:=()[]{}\"'#!&*-+.\xFF\xEF/\\<>%";
            bytes.insert(at, ODD[rng.random_range(0..ODD.len())]);
        }
    }
}

fn line(bytes: &[u8], at: usize) -> std::ops::Range<usize> {
    let at = at.min(bytes.len());
    let start = bytes[..at].iter().rposition(|&b| b == b'\n').map_or(0, |k| k + 1);
    let end = bytes[at..].iter().position(|&b| b == b'\n').map_or(bytes.len(), |k| at + k + 1);
    start..end
}
