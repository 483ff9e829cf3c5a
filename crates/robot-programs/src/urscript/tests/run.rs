//! Random programs that are run: a target that is known is the one to which every run of the program leads.

use super::*;
use crate::script::harness::{count, generator};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;

/// Names: three numbers, of which the last is that of the function, and a pose.
const NAMES: [&str; 4] = ["g0", "g1", "own", "h[0]"];
/// Functions that are called as statements; the program starts with the first.
const FUNCTIONS: usize = 3;

#[derive(Debug, Clone)]
enum Term {
    Number(u8),
    Name(usize),
    /// Assigns the second name and returns a number.
    Calls,
}

#[derive(Debug, Clone)]
enum Statement {
    Assign(usize, Vec<Term>),
    /// Of the pose, whole or an element.
    Pose(bool, Vec<Term>),
    Move(usize, Vec<Term>),
    Call(usize),
    Branch(Vec<Statement>, Option<Vec<Statement>>),
    Loop(bool, Vec<Statement>),
    Leave(&'static str),
}

fn terms(rng: &mut ChaCha8Rng) -> Vec<Term> {
    let one = |rng: &mut ChaCha8Rng| match rng.random_range(0..12) {
        0..5 => Term::Number(rng.random_range(0..3)),
        5..11 => Term::Name(rng.random_range(0..NAMES.len())),
        _ => Term::Calls,
    };
    (0..rng.random_range(1..3)).map(|_| one(rng)).collect()
}

fn block(rng: &mut ChaCha8Rng, depth: usize, moves: &mut usize) -> Vec<Statement> {
    let one = |rng: &mut ChaCha8Rng, moves: &mut usize| match rng.random_range(0..14) {
        0..4 => Statement::Assign(rng.random_range(0..3), terms(rng)),
        4 => Statement::Pose(rng.random_bool(0.5), terms(rng)),
        5..9 => {
            *moves += 1;
            Statement::Move(*moves, terms(rng))
        }
        9 => Statement::Call(rng.random_range(1..FUNCTIONS)),
        10 | 11 if depth < 3 => {
            let other = rng.random_bool(0.5).then(|| block(rng, depth + 1, moves));
            Statement::Branch(block(rng, depth + 1, moves), other)
        }
        12 if depth < 3 => Statement::Loop(rng.random_bool(0.5), block(rng, depth + 1, moves)),
        13 if depth > 0 => Statement::Leave(["break", "continue", "return"][rng.random_range(0..3)]),
        _ => Statement::Assign(0, vec![Term::Number(1)]),
    };
    (0..rng.random_range(1..5)).map(|_| one(rng, moves)).collect()
}

fn expression(all: &[Term]) -> String {
    let text = |t: &Term| match t {
        Term::Number(n) => n.to_string(),
        Term::Name(k) => NAMES[*k].into(),
        Term::Calls => "val()".into(),
    };
    all.iter().map(text).collect::<Vec<_>>().join(" + ")
}

fn written(all: &[Statement], inside: bool, out: &mut String) {
    for s in all {
        match s {
            Statement::Assign(k, e) => {
                let qualifier = if *k < 2 { "global " } else { "" };
                out.push_str(&format!("{qualifier}{} = {}\n", NAMES[*k], expression(e)));
            }
            Statement::Pose(true, e) => out.push_str(&format!("global h = p[{}, 0, 0, 0, 0, 0]\n", expression(e))),
            Statement::Pose(false, e) => out.push_str(&format!("h[0] = {}\n", expression(e))),
            Statement::Move(n, e) => out.push_str(&format!("movel(p[{}, {n}, 0, 0, 0, 0])\n", expression(e))),
            Statement::Call(f) => out.push_str(&format!("f{f}()\n")),
            Statement::Branch(a, b) => {
                out.push_str("if get_digital_in(1):\n");
                written(a, inside, out);
                if let Some(b) = b {
                    out.push_str("else:\n");
                    written(b, inside, out);
                }
                out.push_str("end\n");
            }
            Statement::Loop(endless, a) => {
                out.push_str(if *endless { "while True:\n" } else { "while get_digital_in(2):\n" });
                written(a, true, out);
                out.push_str("end\n");
            }
            Statement::Leave(word) => out.push_str(&format!("{}\n", if inside { word } else { "return" })),
        }
    }
}

/// A run of the program: what the inputs say is random.
struct Run<'a> {
    rng: &'a mut ChaCha8Rng,
    functions: &'a [Vec<Statement>],
    globals: [f64; 4],
    steps: usize,
    reached: &'a mut BTreeMap<usize, Vec<f64>>,
}

/// How a block ends; an error ends the program.
#[derive(PartialEq)]
enum End {
    On,
    Break,
    Continue,
    Return,
    Error,
}

impl Run<'_> {
    fn value(&mut self, all: &[Term], own: Option<f64>) -> Option<f64> {
        all.iter().try_fold(0.0, |sum, t| {
            Some(
                sum + match t {
                    Term::Number(n) => f64::from(*n),
                    Term::Name(2) => own?,
                    Term::Name(k) => self.globals[*k],
                    Term::Calls => {
                        self.globals[1] += 1.0;
                        2.0
                    }
                },
            )
        })
    }

    fn block(&mut self, all: &[Statement], own: &mut Option<f64>, depth: usize, inside: bool) -> End {
        for s in all {
            self.steps += 1;
            if self.steps > 300 || depth > 12 {
                return End::Error;
            }
            let end = match s {
                Statement::Assign(k, e) => match self.value(e, *own) {
                    Some(v) if *k == 2 => {
                        *own = Some(v);
                        End::On
                    }
                    Some(v) => {
                        self.globals[*k] = v;
                        End::On
                    }
                    None => End::Error,
                },
                Statement::Pose(_, e) => self.value(e, *own).map_or(End::Error, |v| {
                    self.globals[3] = v;
                    End::On
                }),
                Statement::Move(n, e) => self.value(e, *own).map_or(End::Error, |v| {
                    self.reached.entry(*n).or_default().push(v);
                    End::On
                }),
                Statement::Call(f) => {
                    let all = &self.functions[*f];
                    match self.block(all, &mut None, depth + 1, false) {
                        End::Error => End::Error,
                        _ => End::On,
                    }
                }
                Statement::Branch(a, b) => match (self.rng.random_bool(0.5), b) {
                    (true, _) => self.block(a, own, depth, inside),
                    (false, Some(b)) => self.block(b, own, depth, inside),
                    _ => End::On,
                },
                Statement::Loop(endless, a) => loop {
                    self.steps += 1;
                    if self.steps > 300 {
                        break End::Error;
                    }
                    if !endless && self.rng.random_bool(0.4) {
                        break End::On;
                    }
                    match self.block(a, own, depth, true) {
                        End::Break => break End::On,
                        end @ (End::Return | End::Error) => break end,
                        _ => {}
                    }
                },
                Statement::Leave("break") if inside => End::Break,
                Statement::Leave("continue") if inside => End::Continue,
                Statement::Leave(_) => End::Return,
            };
            if end != End::On {
                return end;
            }
        }
        End::On
    }
}

#[test]
fn a_target_that_is_known_is_that_of_every_run() {
    let (mut known, mut checked) = (0, 0);
    let runs = count("URSCRIPT_RUNS", 400);
    for seed in 0..runs {
        let mut rng = generator(seed);
        let mut moves = 0;
        let functions: Vec<Vec<Statement>> = (0..FUNCTIONS).map(|_| block(&mut rng, 0, &mut moves)).collect();
        let mut source = String::from("global g0 = 0\nglobal g1 = 0\nglobal h = p[0, 0, 0, 0, 0, 0]\n");
        source.push_str("def val():\nglobal g1 = g1 + 1\nreturn 2\nend\n");
        for (k, f) in functions.iter().enumerate() {
            source.push_str(&format!("def f{k}():\n"));
            written(f, false, &mut source);
            source.push_str("end\n");
        }
        source.push_str("f0()\n");
        let mut reached = BTreeMap::new();
        for _ in 0..60 {
            let rng = &mut rng;
            let mut run = Run { rng, functions: &functions, globals: [0.0; 4], steps: 0, reached: &mut reached };
            run.block(&functions[0], &mut None, 0, false);
        }
        let doc = document(&source);
        for (_, m) in doc.script().moves() {
            let Some(target) = m.goal.target().and_then(|t| doc.script().targets.get(t)) else { continue };
            let values: Vec<f64> = target.values.iter().map(|v| v.unwrap().si).collect();
            known += 1;
            for v in reached.get(&(values[1] as usize)).into_iter().flatten() {
                checked += 1;
                assert_eq!(*v, values[0], "move {} of seed {seed}\n{source}", values[1]);
            }
        }
    }
    assert!(known > 5 * runs / 4 && checked > 5 * runs, "{known} {checked}");
}
