//! What the tests of the vendor formats share: edits at random, the program read again and compared step by step, and damage.
//!
//! One comparison serves all: every new point is there and stands where it was asked for, within half a last digit that is no
//! coarser than asked for or than the format can hold; every other step is as it was (`compare`).

mod compare;

use crate::axes::Axes;
use crate::error::{Error, Result};
use crate::script::{Document, Edit, Edits, Format, Goal, Move, NewPoint, Script, StepKind, Text, Value, text};
pub use compare::difference;
use compare::{Language, compared, replaced};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::Path;

pub fn generator(seed: u64) -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(seed)
}

/// How often a test runs: a variable of the environment raises it.
pub fn count(variable: &str, normally: u64) -> u64 {
    std::env::var(variable).ok().and_then(|n| n.parse().ok()).unwrap_or(normally)
}

/// Reads a program of several texts.
pub fn read(format: &dyn Format, texts: &[Vec<u8>], robot: &Axes) -> Result<Box<dyn Document>> {
    let names = ["job", "data"].into_iter().cycle();
    let texts = names.zip(texts).map(|(name, bytes)| Text::new(name, bytes.clone()));
    format.parse(texts.collect(), robot)
}

/// Reads a program of one text.
pub fn parse(format: &dyn Format, source: &[u8], robot: &Axes) -> Result<Box<dyn Document>> {
    read(format, &[source.to_vec()], robot)
}

/// The script of a text that must be readable.
pub fn script_of(format: &dyn Format, source: &str, robot: &Axes) -> Script {
    match parse(format, source.as_bytes(), robot) {
        Ok(d) => d.script().clone(),
        Err(e) => panic!("{e}\n{source}"),
    }
}

/// The message with which a text is refused.
pub fn refusal(format: &dyn Format, source: &str, robot: &Axes) -> String {
    match parse(format, source.as_bytes(), robot) {
        Ok(_) => panic!("it was read\n{source}"),
        Err(e) => e.to_string(),
    }
}

/// The sample programs of a format, one text each, with their names; those that are there to be refused are left out.
pub fn samples(format: &dyn Format) -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../samples/programs").join(format.name());
    let mut paths: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    paths.retain(|p| p.extension().is_some_and(|e| format.endings().iter().any(|own| e.eq_ignore_ascii_case(own))));
    paths.sort();
    let name = |p: &Path| p.file_name().unwrap().to_string_lossy().into_owned();
    let all = paths.iter().map(|p| (name(p), std::fs::read(p).unwrap()));
    all.filter(|(name, _)| !name.contains("refused")).collect()
}

/// The moves of a script, with their steps.
pub fn moves(script: &Script) -> Vec<(usize, Move)> {
    script.moves().map(|(k, m)| (k, m.clone())).collect()
}

/// Numbers of a move's target, joints or a pose; empty where it has none that can be written.
fn numbers(script: &Script, m: &Move) -> Vec<Option<Value>> {
    m.goal.target().map_or_else(Vec::new, |t| script.targets.get(t).unwrap().values.iter().collect())
}

/// Values of a step's target; NaN where it commands nothing.
pub fn values(script: &Script, step: usize) -> Vec<f64> {
    let StepKind::Move(m) = &script.steps[step].kind else { panic!("no move") };
    numbers(script, m).iter().map(|v| v.map_or(f64::NAN, |v| v.si)).collect()
}

/// Why a move's goal cannot be determined.
pub fn opaque(m: &Move) -> String {
    match &m.goal {
        Goal::Opaque(why) => why.to_string(),
        other => panic!("{other:?} is not opaque"),
    }
}

/// Kinds of steps as words.
pub fn kinds(script: &Script) -> Vec<String> {
    let word = |k: &StepKind| match k {
        StepKind::Move(_) => "move".to_string(),
        StepKind::Dwell(s) => format!("dwell {s:?}"),
        StepKind::Break(b) => format!("{b:?}"),
        StepKind::Sets(name) => format!("sets {name}"),
        StepKind::Process(on) => format!("process {on}"),
        StepKind::Pragma(on) => format!("pragma {on}"),
    };
    script.steps.iter().map(|s| word(&s.kind)).collect()
}

/// Axis 0 of the named moves (by number) moved by so many rad.
pub fn shifted(script: &Script, by: &[(usize, f64)], digit: f64) -> Edits {
    let mut edits = Edits { digit: vec![digit; 6], ..Edits::default() };
    for (k, (step, m)) in script.moves().enumerate() {
        let Some((_, rad)) = by.iter().find(|b| b.0 == k) else { continue };
        let mut q: Vec<f64> = numbers(script, m).iter().map(|v| v.map_or(0.0, |v| v.si)).collect();
        q[0] += rad;
        edits.steps.insert(step, Edit { goal: Some(q), ..Edit::default() });
    }
    edits
}

/// Other values and new points for about half of the moves that allow them. Moves to one target want the same more often than not.
pub fn random_edits(script: &Script, robot: &Axes, rng: &mut ChaCha8Rng) -> Edits {
    let digit = [1e-4, 1e-5, 1e-6, 1e-7][rng.random_range(0..4)];
    let pose_digit = [[1e-6, 1e-5], [1e-7, 1e-6]][rng.random_range(0..2)];
    let mut edits = Edits { digit: vec![digit; robot.dof()], pose_digit, ..Edits::default() };
    let shift = |rng: &mut ChaCha8Rng| -> Vec<f64> {
        let by = [2e-4, 1e-2][rng.random_range(0..2)];
        (0..robot.dof().max(7))
            .map(|_| if rng.random_bool(0.3) { 0.0 } else { by * rng.random_range(-1.0..1.0) })
            .collect()
    };
    let common: Vec<Vec<f64>> = script.targets.iter().map(|_| shift(rng)).collect();
    for (k, m) in script.moves() {
        if m.goal.target().is_none() || rng.random_bool(0.4) {
            continue;
        }
        // an axis that the target does not command stands anywhere
        let mut own: Vec<f64> = numbers(script, m).iter().map(|v| v.map_or(0.5, |v| v.si)).collect();
        if matches!(m.goal, Goal::Joints(_)) {
            own.resize(robot.dof(), 0.5);
        }
        let mut edit = Edit::default();
        if let Some(t) = m.goal.target()
            && m.fixed.is_none()
            && rng.random_bool(0.8)
        {
            let by = if rng.random_bool(0.3) { shift(rng) } else { common[t].clone() };
            edit.goal = Some(own.iter().zip(by).map(|(v, by)| v + by).collect());
        }
        if m.closed.is_none() && rng.random_bool(0.5) {
            let mut shares: Vec<f64> = (0..rng.random_range(1..4)).map(|_| rng.random_range(0.0..1.0)).collect();
            shares.sort_by(f64::total_cmp);
            let place = |rng: &mut ChaCha8Rng, v: &f64| match rng.random_bool(0.3) {
                true => *v,
                false => v + rng.random_range(-0.2..0.2),
            };
            let point = |share| NewPoint {
                q: own.iter().map(|v| place(rng, v)).collect(),
                share,
                t_s: None,
                clearance_m: 10f64.powf(rng.random_range(-6.0..-1.0)),
                of_way: false,
                waits: false,
            };
            edit.before = shares.into_iter().map(point).collect();
            if matches!(&m.goal, Goal::Pose(goal) if goal.via_m.is_some()) {
                let last = edit.before.len();
                let mut via = |_| (0..3).map(|_| rng.random_range(-0.5..0.5)).collect();
                edit.vias = (0..=last).map(&mut via).collect();
            }
        }
        // a blend that is not known cannot be shrunk in every format: tested by itself
        if m.blend_m.is_some() && rng.random_bool(0.2) {
            edit.blend_at_most_m = Some(10f64.powf(rng.random_range(-5.0..-1.0)));
        }
        if edit.goal.is_some() || !edit.before.is_empty() || edit.blend_at_most_m.is_some() {
            edits.steps.insert(k, edit);
        }
    }
    edits
}

/// What came of edits.
#[derive(Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The format has no legal way to write them.
    Refused,
    /// They came back as they were asked for.
    Kept,
}

/// The texts with edits.
pub fn applied(doc: &dyn Document, edits: &Edits) -> Result<Vec<Vec<u8>>> {
    text::apply(&doc.script().texts, &doc.patches(edits)?)
}

/// The program with edits, read again with what it was read with.
pub fn rewritten(format: &dyn Format, doc: &dyn Document, edits: &Edits, robot: &Axes) -> Result<Box<dyn Document>> {
    let texts = doc.script().texts.iter().zip(applied(doc, edits)?).map(|(t, bytes)| t.with(bytes));
    format.parse(texts.collect(), robot)
}

/// The text with edits, read again and compared; panics where it is not what was asked for.
pub fn edited(format: &dyn Format, source: &[u8], edits: &Edits, robot: &Axes) -> Result<Vec<u8>> {
    let doc = parse(format, source, robot)?;
    let out = applied(doc.as_ref(), edits)?.remove(0);
    if let Err(e) = kept(format, doc.as_ref(), edits, robot) {
        panic!("{e}");
    }
    Ok(out)
}

/// Writes edits, reads the result, and compares it with what was asked for. `Err`: the format is at fault.
pub fn round_trip(
    format: &dyn Format,
    source: &[u8],
    robot: &Axes,
    edits: &Edits,
) -> std::result::Result<Outcome, String> {
    let doc = parse(format, source, robot).map_err(|e| format!("the program does not parse: {e}"))?;
    kept(format, doc.as_ref(), edits, robot)
}

/// The same for a program that has been read.
pub fn kept(
    format: &dyn Format,
    doc: &dyn Document,
    edits: &Edits,
    robot: &Axes,
) -> std::result::Result<Outcome, String> {
    let patches = match doc.patches(edits) {
        Ok(patches) => patches,
        Err(Error::Refused(_)) => return Ok(Outcome::Refused),
        Err(e) => return Err(format!("an edit is no bad input: {e}")),
    };
    replaced(doc.script(), &patches)?;
    let out = text::apply(&doc.script().texts, &patches).map_err(|e| e.to_string())?;
    let shown = || out.iter().map(|b| String::from_utf8_lossy(b)).collect::<Vec<_>>().join("\n---\n");
    let texts = doc.script().texts.iter().zip(&out).map(|(t, bytes)| t.with(bytes.clone()));
    let again = format
        .parse(texts.collect(), robot)
        .map_err(|e| format!("what was written does not parse: {e}\n{}", shown()))?;
    match compared(doc.script(), again.script(), edits, Language::of(format.name())) {
        Some(what) => Err(format!("{what}\n{}", shown())),
        None => Ok(Outcome::Kept),
    }
}

/// A program with a few bytes changed: flipped, put in, cut out, lines doubled or dropped, cut off.
pub fn mutated(source: &[u8], rng: &mut ChaCha8Rng) -> Vec<u8> {
    const MARKS: &[u8] = b"[](){},;:=.\\\"'!#%$&/*-+0123456789eE \n\r\t<>_AGIJKMNPRXYZapv\xe4\xff\x00";
    let mut bytes = source.to_vec();
    for _ in 0..rng.random_range(1..4) {
        if bytes.is_empty() {
            break;
        }
        let at = rng.random_range(0..bytes.len());
        let len = rng.random_range(1..40).min(bytes.len() - at);
        let mark = MARKS[rng.random_range(0..MARKS.len())];
        let start = bytes[..at].iter().rposition(|&b| b == b'\n').map_or(0, |n| n + 1);
        let end = bytes[at..].iter().position(|&b| b == b'\n').map_or(bytes.len(), |n| at + n + 1);
        match rng.random_range(0..10) {
            0 => bytes[at] ^= 1 << rng.random_range(0..8),
            1 => bytes[at] = mark,
            2 => bytes.insert(at, mark),
            3 => drop(bytes.drain(at..at + len)),
            4 => {
                let piece = bytes[at..at + len].to_vec();
                let to = rng.random_range(0..=bytes.len());
                drop(bytes.splice(to..to, piece));
            }
            5 => {
                let line = bytes[start..end].to_vec();
                drop(bytes.splice(start..start, line));
            }
            6 => drop(bytes.drain(start..end)),
            7 => {
                let other = rng.random_range(0..bytes.len());
                bytes.swap(at, other);
            }
            8 if rng.random_bool(0.3) => bytes.truncate(at),
            _ => bytes[at] = rng.random_range(0..=255),
        }
    }
    bytes
}

/// Where programs come from that are to be damaged, and the edits that are asked of what still reads.
type Source<'a> = &'a dyn Fn(&mut ChaCha8Rng) -> Vec<Vec<u8>>;
type Wishes<'a> = &'a dyn Fn(&Script, &mut ChaCha8Rng) -> Edits;

/// Damaged programs: never a panic; bad input has a line; where the result reads, no edits are no patches, and edits are refused
/// or come back exactly.
pub fn survives(format: &dyn Format, robot: &Axes, source: Source, wishes: Wishes) {
    let runs = count("LOSTMOTION_MUTATIONS", 2000);
    let (mut parsed, mut refused, mut came_back) = (0u64, 0u64, 0u64);
    let mut failed = Vec::new();
    for seed in 0..runs {
        let mut rng = generator(seed);
        let mut texts = source(&mut rng);
        let which = rng.random_range(0..texts.len());
        texts[which] = mutated(&texts[which], &mut rng);
        let doc = match read(format, &texts, robot) {
            Ok(doc) => doc,
            Err(Error::BadInput(bad)) => {
                assert!(bad.place.line.is_some(), "seed {seed}: {bad}");
                continue;
            }
            Err(other) => panic!("seed {seed}: {other}"),
        };
        parsed += 1;
        let none = doc.patches(&Edits { digit: vec![1e-6; robot.dof()], ..Edits::default() });
        assert!(none.expect("no edits are never refused").is_empty(), "seed {seed}");
        match kept(format, doc.as_ref(), &wishes(doc.script(), &mut rng), robot) {
            Ok(Outcome::Refused) => refused += 1,
            Ok(Outcome::Kept) => came_back += 1,
            Err(e) => failed.push(format!("seed {seed}: {e}")),
        }
    }
    assert!(failed.is_empty(), "{} of {runs} fail: {:#?}", failed.len(), &failed[..failed.len().min(4)]);
    println!("{runs} damaged programs: {parsed} parse, {came_back} come back, {refused} are refused");
    assert!(came_back > runs / 20, "hardly any damaged program parses: {came_back} of {runs}");
}

/// Damage to the samples of a format, with random edits.
pub fn samples_survive(format: &dyn Format, robot: &Axes) {
    let all = samples(format);
    let source = |rng: &mut ChaCha8Rng| vec![all[rng.random_range(0..all.len())].1.clone()];
    survives(format, robot, &source, &|script, rng| random_edits(script, robot, rng));
}

/// Every sample: as many moves as it says, so many of them with joint targets, and random edits come back (`may_refuse`: or are refused).
pub fn samples_have(format: &dyn Format, robot: &Axes, counts: &[(&str, usize, usize)], may_refuse: bool) {
    let all = samples(format);
    for (name, moves, joints) in counts {
        let (_, bytes) = all.iter().find(|s| s.0 == *name).unwrap_or_else(|| panic!("no sample {name}"));
        let doc = parse(format, bytes, robot).unwrap_or_else(|e| panic!("{name}: {e}"));
        let found: Vec<&Move> = doc.script().moves().map(|(_, m)| m).collect();
        let of_joints = found.iter().filter(|m| matches!(m.goal, Goal::Joints(_))).count();
        assert_eq!((found.len(), of_joints), (*moves, *joints), "{name}");
        for seed in 0..20 {
            let edits = random_edits(doc.script(), robot, &mut generator(seed));
            match round_trip(format, bytes, robot, &edits) {
                Ok(Outcome::Kept) => {}
                Ok(Outcome::Refused) if may_refuse => {}
                other => panic!("{name}, seed {seed}: {other:?}"),
            }
        }
    }
}
