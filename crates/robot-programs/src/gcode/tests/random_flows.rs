//! Random programs with subprograms, loops, conditions and cycles, against the machine of these tests.

use super::machine::{HALF, run};
use super::*;
use crate::script::AxisSet;
use std::collections::BTreeSet;

/// A random program with calls, loops, conditions and cycles, in the words of one of two makers.
struct Writing<'a, R> {
    rng: &'a mut R,
    fanuc: bool,
    lines: Vec<String>,
    loops: u32,
}

impl<R: Rng> Writing<'_, R> {
    fn put(&mut self, line: impl Into<String>) {
        self.lines.push(line.into());
    }

    fn number(&mut self) -> String {
        format!("{:.1}", f64::from(self.rng.random_range(-100..100)) * 0.5)
    }

    fn places(&mut self, axes: &str, share: f64) -> String {
        let mut out = String::new();
        for a in axes.chars() {
            if self.rng.random_bool(share) {
                out += &format!(" {a}{}", self.number());
            }
        }
        if out.is_empty() { format!(" X{}", self.number()) } else { out }
    }

    /// `subs`: numbers of what may be called.
    fn body(&mut self, depth: u32, subs: &[u32]) {
        for _ in 0..self.rng.random_range(1..5) {
            match self.rng.random_range(0..12) {
                0 => {
                    let words = self.places("XYZ", 0.4);
                    self.put(format!("G91 G1{words} F100"));
                    if self.rng.random_bool(0.8) {
                        self.put("G90");
                    }
                }
                1 | 2 => {
                    let cycle = ["G81", "G98 G82", "G99 G83", "G85"][self.rng.random_range(0..4)];
                    let words = self.places("XY", 0.7);
                    let (depth, level) = (self.rng.random_range(5..9), self.rng.random_range(1..4));
                    self.put(format!("G90 {cycle}{words} Z-{depth}.0 R{level}.0"));
                    for _ in 0..self.rng.random_range(0..3) {
                        let words = self.places("XY", 0.6);
                        self.put(words.trim());
                    }
                    self.put("G80");
                }
                3 if depth < 2 => self.round(depth, subs),
                4 if depth < 2 && !self.fanuc => {
                    self.loops += 1;
                    let label = format!("o{}", 900 + self.loops);
                    let value = self.rng.random_range(0..2);
                    self.put(format!("{label} if [#9 eq {value}]"));
                    self.body(depth + 1, subs);
                    if self.rng.random_bool(0.5) {
                        self.put(format!("{label} else"));
                        self.body(depth + 1, subs);
                    }
                    self.put(format!("{label} endif"));
                }
                4 => self.put("IF [#9 EQ 1] THEN #8=2"),
                5 | 6 if !subs.is_empty() => {
                    let name = subs[self.rng.random_range(0..subs.len())];
                    let times = if self.rng.random_bool(0.2) { " L2" } else { "" };
                    self.put(if self.fanuc { format!("M98 P{name}{times}") } else { format!("o{name} call") });
                }
                7 if self.rng.random_bool(0.2) => {
                    self.put("G20");
                    let words = self.places("XYZ", 0.5);
                    self.put(format!("G1{words} F100"));
                    self.put("G21");
                }
                _ => {
                    let words = self.places("XYZ", 0.7);
                    let motion = self.rng.random_range(0..2);
                    self.put(format!("G{motion}{words} F100"));
                }
            }
        }
    }

    fn round(&mut self, depth: u32, subs: &[u32]) {
        self.loops += 1;
        let (n, passes) = (self.loops, self.rng.random_range(0..3));
        if !self.fanuc && self.rng.random_bool(0.5) {
            self.put(format!("o{} repeat [{passes}]", 900 + n));
            self.body(depth + 1, subs);
            return self.put(format!("o{} endrepeat", 900 + n));
        }
        let counter = format!("#{}", 20 + n);
        self.put(format!("{counter}=0"));
        let [open, close] = if self.fanuc {
            [format!("WHILE [{counter} LT {passes}] DO{n}"), format!("END{n}")]
        } else {
            [format!("o{} while [{counter} lt {passes}]", 900 + n), format!("o{} endwhile", 900 + n)]
        };
        self.put(open);
        self.body(depth + 1, subs);
        self.put(format!("{counter}={counter}+1"));
        self.put(close);
    }
}

fn random_flow(rng: &mut impl Rng) -> String {
    let fanuc = rng.random_bool(0.5);
    let titled = rng.random_bool(0.5);
    let mut writing = Writing { rng, fanuc, lines: Vec::new(), loops: 0 };
    let subs = [100, 200];
    let head = |w: &mut Writing<_>| {
        if titled && fanuc {
            w.put("%");
            w.put("O1");
        }
        w.put("G21 G90 G17");
    };
    head(&mut writing);
    let define = |w: &mut Writing<_>| {
        // the second is defined first, as the first may call it
        for (k, name) in [(1, 200), (0, 100)] {
            w.put(if fanuc { format!("O{name}") } else { format!("o{name} sub") });
            w.body(1, &subs[k + 1..]);
            w.put(if fanuc { "M99".to_string() } else { format!("o{name} endsub") });
        }
    };
    if !fanuc {
        define(&mut writing);
    }
    writing.put("G0 X0.0 Y0.0 Z9.0");
    writing.body(0, &subs);
    writing.body(0, &subs);
    writing.put("M30");
    if fanuc {
        define(&mut writing);
    }
    writing.lines.join("\n") + "\n"
}

/// What a script says that the machine does otherwise; how many joins, goals and holes were compared.
fn compared(text: &str) -> [usize; 3] {
    let script = script_of(&Gcode, text, &robot());
    let ran = run(text);
    let mut counts = [0; 3];
    for (k, m) in script.moves().filter(|(_, m)| matches!(m.goal, Goal::Joints(_))) {
        let line = script.steps[k].at.line as usize - 1;
        for done in ran.done.iter().filter(|d| d.line == line) {
            for (axis, v) in values(&script, k).iter().enumerate().filter(|(_, v)| !v.is_nan()) {
                assert!((v * 1e3 - done.to[axis]).abs() < 1e-6, "line {}, axis {axis}\n{text}", line + 1);
            }
            counts[1] += 1;
            counts[2] += usize::from(done.hole.is_some() && m.closed.is_some());
        }
    }
    let last = |k: usize| match k.checked_sub(1).map(|n| &script.steps[n]) {
        Some(step) if matches!(step.kind, StepKind::Move(_)) => Some(step.at.line as usize - 1),
        _ => None,
    };
    for join in &script.joins {
        let line = script.steps[join.at].at.line as usize - 1;
        // a place before which a break stands says nothing
        let Some(from) = join.from.iter().map(|k| last(*k)).collect::<Option<BTreeSet<usize>>>() else { continue };
        for landing in ran.landings.iter().filter(|l| l.line == line) {
            assert!(landing.last_move.is_some_and(|k| from.contains(&k)), "{landing:?}, but {join:?} {from:?}\n{text}");
            counts[0] += 1;
        }
    }
    for round in &script.rounds {
        let line = script.steps[round.open].at.line as usize - 1;
        assert!(!ran.passed_by.contains(&line), "{round:?}\n{text}");
    }
    if let (Some(entry), Some(first)) = (script.entry, ran.done.first()) {
        let next = script.moves().find(|(k, _)| *k > entry).map(|(k, _)| script.steps[k].at.line as usize - 1);
        assert_eq!(next, Some(first.line), "{text}");
    }
    counts
}

#[test]
fn a_machine_comes_where_the_script_says_in_the_order_that_it_says() {
    let mut all = [0; 3];
    for seed in 0..count("LOSTMOTION_FLOWS", 3000) {
        let found = compared(&random_flow(&mut generator(seed)));
        all.iter_mut().zip(found).for_each(|(a, n)| *a += n);
    }
    println!("{all:?} joins, goals and holes");
    assert!(all.iter().all(|n| *n > 1000), "hardly anything was compared: {all:?}");
}

/// Offsets against lost motion, as far as a script says from which side each axis comes.
fn against_lost_motion(script: &Script) -> Edits {
    let mut edits = Edits { digit: vec![1e-9; 3], ..Edits::default() };
    let (mut at, mut side, mut offset) = ([None::<f64>; 3], [0.0; 3], [0.0; 3]);
    let lose = |axes: AxisSet, at: &mut [Option<f64>; 3], side: &mut [f64; 3]| {
        axes.axes().for_each(|a| (at[a], side[a]) = (None, 0.0));
    };
    let all: AxisSet = (0..3).collect();
    for (k, step) in script.steps.iter().enumerate() {
        let m = match &step.kind {
            StepKind::Move(m) => m,
            StepKind::Break(Break::Axes(axes)) => {
                lose(*axes, &mut at, &mut side);
                continue;
            }
            StepKind::Break(_) => {
                lose(all, &mut at, &mut side);
                continue;
            }
            _ => continue,
        };
        let Goal::Joints(_) = m.goal else {
            lose(m.moves_alone.unwrap_or(all), &mut at, &mut side);
            continue;
        };
        for (a, v) in values(script, k).into_iter().enumerate().filter(|(_, v)| !v.is_nan()) {
            let by = at[a].map_or(0.0, |from| v - from);
            if by.abs() > 1e-9 {
                side[a] = by.signum();
            }
            at[a] = Some(v);
            offset[a] = if m.fixed.is_some() { 0.0 } else { side[a] * HALF * 1e-3 };
        }
        if m.fixed.is_none() {
            let goal = (0..3).map(|a| at[a].unwrap_or(0.0) + offset[a]).collect();
            edits.steps.insert(k, Edit { goal: Some(goal), ..Edit::default() });
        }
    }
    edits
}

/// A random program of moves and holes in one line of events.
fn random_holes(rng: &mut impl Rng) -> String {
    let mut writing = Writing { rng, fanuc: true, lines: Vec::new(), loops: 0 };
    writing.put("G21 G90 G17");
    writing.put("G0 X0.0 Y0.0 Z9.0");
    for _ in 0..4 {
        writing.body(2, &[]);
    }
    writing.put("M30");
    writing.lines.join("\n") + "\n"
}

#[test]
fn the_error_at_no_hole_grows_and_no_hole_gets_deeper() {
    let robot = robot();
    let (mut before, mut after, mut holes) = (0.0, 0.0, 0);
    for seed in 0..count("LOSTMOTION_FLOWS", 3000) {
        let text = random_holes(&mut generator(seed));
        if text.contains("IF ") {
            continue;
        }
        let edits = against_lost_motion(&script_of(&Gcode, &text, &robot));
        let out = match edited(&Gcode, text.as_bytes(), &edits, &robot) {
            Ok(out) => String::from_utf8(out).unwrap(),
            Err(Error::Refused(why)) => panic!("seed {seed}: {why}\n{text}"),
            Err(e) => panic!("seed {seed}: {e}\n{text}"),
        };
        let (old, new) = (run(&text).done, run(&out).done);
        assert_eq!(old.len(), new.len(), "{text}\n{out}");
        for (old, new) in old.iter().zip(&new) {
            let error = |stands: &[f64; 3], a: usize| (stands[a] - old.to[a]).abs();
            for a in 0..2 {
                let [was, is] = [error(&old.stands, a), error(&new.stands, a)];
                assert!(is < was + 1e-6, "seed {seed}, line {}, axis {a}: {was} {is}\n{text}\n{out}", old.line + 1);
                if old.hole.is_some() {
                    (before, after, holes) = (before + was, after + is, holes + 1);
                }
            }
            match (old.hole, new.hole) {
                (Some(x), Some(y)) => assert!((x[0] - y[0]).abs() < 1e-9 && x[1] == y[1], "seed {seed}\n{text}\n{out}"),
                (x, y) => assert!(x.is_none() && y.is_none()),
            }
        }
    }
    println!("{holes} places of holes: {before:.1} mm before, {after:.1} mm after");
    assert!(holes > 1000 && after < 0.5 * before, "{holes} {before} {after}");
}
