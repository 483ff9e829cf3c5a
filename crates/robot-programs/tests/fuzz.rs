//! Readers on mutated samples: no panic, no number that is none, no patch without an edit; CSV comes out as it went in, however its
//! pieces are parsed. With the stable compiler and a fixed seed; `fuzz/` has the same targets for cargo-fuzz.

use robot_programs::Block;
use robot_programs::axes::{Axes, Axis, JointKind};
use robot_programs::csv::{Piece, Reader};
use robot_programs::formats::FORMATS;
use robot_programs::script::{Edits, Format, Text};
use std::io::Cursor;
use std::path::Path;

/// Marsaglia (2003): the same numbers on every machine.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }
}

/// What readers stumble over.
const WORDS: [&[u8]; 24] = [
    b"\"",
    b"\r",
    b"\r\n",
    b"\n\n",
    b",",
    b";",
    b"-",
    b"1e999",
    b"nan",
    b"-0.0",
    b"99999999999999999999",
    b"\0",
    b"\xff\xfe",
    b"\xc3\x28",
    b"{",
    b"}",
    b"[",
    b"]]",
    b"(",
    b")",
    b"9E9",
    b"#",
    b"1.2.3",
    b"DEF",
];

fn mutated(samples: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let mut bytes = samples[random.below(samples.len())].clone();
    for _ in 0..=random.below(4) {
        let (a, b) = (random.below(bytes.len()), random.below(bytes.len()));
        let (a, b) = (a.min(b), a.max(b).min(a.min(b) + 200));
        match random.below(7) {
            0 if !bytes.is_empty() => bytes[a] = random.next() as u8,
            1 => drop(bytes.drain(a..b)),
            2 => {
                let piece = bytes[a..b].to_vec();
                bytes.splice(b..b, piece);
            }
            3 | 4 => {
                let word = WORDS[random.below(WORDS.len())];
                bytes.splice(a..a, word.iter().copied());
            }
            5 => {
                let other = &samples[random.below(samples.len())];
                let from = random.below(other.len());
                let to = (from + random.below(300)).min(other.len());
                bytes.splice(a..b, other[from..to].iter().copied());
            }
            _ => bytes.truncate(bytes.len() - random.below(bytes.len() / 4 + 1)),
        }
    }
    bytes
}

fn axes(names: &str) -> Axes {
    Axes::new("arm", (1..=6).map(|k| Axis::new(format!("{names}{k}"), JointKind::Revolute)).collect())
}

fn samples(folder: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples/programs").join(folder);
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.sort();
    paths.iter().map(|p| std::fs::read(p).unwrap()).collect()
}

fn one_script(format: &dyn Format, axes: &Axes, bytes: Vec<u8>) -> bool {
    let Ok(document) = format.parse(vec![Text::new("program", bytes)], axes) else { return false };
    let script = document.script();
    for target in script.targets.iter() {
        for value in target.values.iter().flatten() {
            assert!(value.si.is_finite(), "{}: a number that is none", format.name());
            let text = &script.texts[target.at.file].bytes;
            assert!(text.get(value.span()).is_some_and(|t| !t.is_empty()), "{}: a number without text", format.name());
        }
    }
    let patches = document.patches(&Edits::default());
    assert!(patches.is_ok_and(|p| p.is_empty()), "{}: a patch without an edit", format.name());
    true
}

fn scripts(runs: usize) {
    for format in FORMATS {
        let axes = axes(if matches!(format.name(), "krl") { "A" } else { "J" });
        let (seeds, mut random) = (samples(format.name()), Random(0x9e37_79b9_7f4a_7c15));
        let read = (0..runs).filter(|_| one_script(*format, &axes, mutated(&seeds, &mut random))).count();
        println!("{}: {runs} inputs, {read} of them programs", format.name());
    }
}

/// CSV of rows of many kinds.
fn csv_seeds() -> Vec<Vec<u8>> {
    let head = "a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg";
    let plain: String = (0..30).map(|i| format!("{i}.5000,-90.25,1.0,0.0,-0.0,{i}.125\n")).collect();
    let timed: String = (0..30).map(|i| format!("{}.25,{i}.5,1,2,3,4,5,\"seam, {i}\"\r\n", i)).collect();
    vec![
        format!("{head}\n{plain}").into_bytes(),
        format!("# made\r\nt_s,{head},note\r\n{timed}").into_bytes(),
        format!("{head}\r{}", plain.replace('\n', "\r")).into_bytes(),
        format!("{head}\n   1.0, +2.50,003,4e0,  5.,.6\n{plain}").into_bytes(),
    ]
}

fn one_csv(axes: &Axes, bytes: &[u8]) -> bool {
    let reader = || Reader::new(Box::new(Cursor::new(bytes.to_vec())), "p.csv", axes);
    let Ok(mut whole) = reader() else { return false };
    let (mut block, mut text, mut q) = (Block::default(), Vec::new(), Vec::new());
    let told = loop {
        match whole.next(&mut block) {
            Ok(true) => {
                text.extend_from_slice(&block.text);
                q.extend(block.q.iter().map(|v| v.to_bits()));
                assert!(block.q.iter().chain(&block.t_s).all(|v| v.is_finite()), "a number that is none");
            }
            Ok(false) => break None,
            Err(e) => break Some(e.to_string()),
        }
    };
    assert!(told.is_some() || text == bytes, "bytes are lost");
    let (mut source, mut parser, mut placing) = reader().unwrap().split();
    let (mut piece, mut apart) = (Piece::default(), Vec::new());
    let again = loop {
        match source.next(&mut piece) {
            Ok(true) => piece.parse(&mut parser),
            Ok(false) => break placing.end().err(),
            Err(e) => break Some(e),
        }
        if let Err(e) = placing.place(&mut piece) {
            break Some(e);
        }
        apart.extend(piece.block.q.iter().map(|v| v.to_bits()));
    };
    assert_eq!(told, again.map(|e| e.to_string()));
    assert!(told.is_some() || q == apart);
    told.is_none()
}

fn csv(runs: usize) {
    let (seeds, axes, mut random) = (csv_seeds(), axes("A"), Random(0x2545_f491_4f6c_dd1d));
    let read = (0..runs).filter(|_| one_csv(&axes, &mutated(&seeds, &mut random))).count();
    println!("csv: {runs} inputs, {read} of them programs");
    assert!(read > 0 && read < runs);
}

#[test]
fn readers_stand_a_few_hundred_mutated_samples() {
    scripts(300);
    csv(2000);
}

#[test]
#[ignore = "as long as LOSTMOTION_FUZZ_RUNS says"]
fn readers_stand_many_mutated_samples() {
    let runs = std::env::var("LOSTMOTION_FUZZ_RUNS").ok().and_then(|n| n.parse().ok()).unwrap_or(100_000);
    csv(runs);
    scripts(runs);
}
