//! Random programs that are run: a computed point that is known is the one to which every run of the program leads.

use super::*;
use crate::script::harness::{count, generator};
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;

/// Points: a constant, two of the data list, one of the routine. Their X and Z count.
const POINTS: [&str; 4] = ["XP1", "XUP", "XFAR", "L"];
/// Numbers: one of the data list, and one of the routine.
const NUMBERS: [&str; 2] = ["H", "U"];
/// Routines that are called; the program starts with the first, and the last runs at any time where it is armed.
const ROUTINES: usize = 4;

const DAT: &str = "DEFDAT p\nDECL E6POS XP1={X 1,Y 2,Z 3,A 0,B 0,C 0,S 2,T 2,E1 0,E2 0,E3 0,E4 0,E5 0,E6 0}\n\
                   DECL E6POS XUP={X 5,Y 2,Z 5,A 0,B 0,C 0}\nDECL E6POS XFAR\nDECL REAL H=7\nENDDAT\n";

#[derive(Debug, Clone)]
enum Term {
    Plain(u8),
    Number(usize),
    Part(usize, bool),
}

#[derive(Debug, Clone)]
enum Statement {
    Number(usize, Vec<(Term, char)>),
    Copy(usize, usize),
    Part(usize, bool, Vec<(Term, char)>),
    Move(usize, usize),
    Call(usize),
    /// It strikes later.
    Trigger,
    /// Its condition may call the function.
    Branch(bool, Vec<Statement>, Option<Vec<Statement>>),
    Cases(Vec<Vec<Statement>>),
    Loop(&'static str, Vec<Statement>),
    /// A jump over it, or back to its start.
    Jump(bool, Vec<Statement>),
    Exit,
    Return,
}

fn terms(rng: &mut ChaCha8Rng) -> Vec<(Term, char)> {
    let one = |rng: &mut ChaCha8Rng| {
        let term = match rng.random_range(0..8) {
            0..4 => Term::Plain(rng.random_range(0..3)),
            4..6 => Term::Number(rng.random_range(0..2)),
            _ => Term::Part(rng.random_range(0..4), rng.random()),
        };
        (term, ['+', '-', '*'][rng.random_range(0..3)])
    };
    (0..rng.random_range(1..3)).map(|_| one(rng)).collect()
}

fn block(rng: &mut ChaCha8Rng, depth: usize, moves: &mut usize) -> Vec<Statement> {
    let one = |rng: &mut ChaCha8Rng, moves: &mut usize| match rng.random_range(0..24) {
        0..3 => Statement::Number(rng.random_range(0..2), terms(rng)),
        3..8 => Statement::Copy(rng.random_range(1..4), if rng.random_bool(0.6) { 0 } else { rng.random_range(0..4) }),
        8..12 => Statement::Part(rng.random_range(1..4), rng.random(), terms(rng)),
        12..17 => {
            *moves += 1;
            Statement::Move(*moves - 1, rng.random_range(1..4))
        }
        17 => Statement::Call(rng.random_range(1..ROUTINES - 1)),
        18 if rng.random_bool(0.2) => Statement::Trigger,
        19 if depth < 3 => {
            let first = block(rng, depth + 1, moves);
            Statement::Branch(rng.random_bool(0.2), first, rng.random_bool(0.5).then(|| block(rng, depth + 1, moves)))
        }
        20 if depth < 3 => {
            Statement::Cases((0..rng.random_range(1..3)).map(|_| block(rng, depth + 1, moves)).collect())
        }
        21 if depth < 3 => Statement::Loop(
            ["LOOP", "WHILE", "FOR", "REPEAT", "CALLING"][rng.random_range(0..5)],
            block(rng, depth + 1, moves),
        ),
        22 if depth < 3 => Statement::Jump(rng.random(), block(rng, depth + 1, moves)),
        23 if depth > 0 => {
            if rng.random() {
                Statement::Exit
            } else {
                Statement::Return
            }
        }
        _ => Statement::Number(1, vec![(Term::Plain(1), '+')]),
    };
    (0..rng.random_range(1..6)).map(|_| one(rng, moves)).collect()
}

fn part(x: bool) -> &'static str {
    if x { "X" } else { "Z" }
}

fn expression(all: &[(Term, char)]) -> String {
    let mut out = String::new();
    for (k, (term, sign)) in all.iter().enumerate() {
        if k > 0 {
            out.push(*sign);
        }
        out.push_str(&match term {
            Term::Plain(n) => n.to_string(),
            Term::Number(k) => NUMBERS[*k].into(),
            Term::Part(p, x) => format!("{}.{}", POINTS[*p], part(*x)),
        });
    }
    out
}

/// The lines of a block; `inside`: of a loop.
fn written(all: &[Statement], inside: bool, labels: &mut usize, out: &mut String) {
    for s in all {
        match s {
            Statement::Number(k, e) => out.push_str(&format!("{}={}\n", NUMBERS[*k], expression(e))),
            Statement::Copy(to, from) => out.push_str(&format!("{}={}\n", POINTS[*to], POINTS[*from])),
            Statement::Part(p, x, e) => out.push_str(&format!("{}.{}={}\n", POINTS[*p], part(*x), expression(e))),
            Statement::Move(_, p) => out.push_str(&format!("LIN {}\n", POINTS[*p])),
            Statement::Call(r) => out.push_str(&format!("r{r}()\n")),
            Statement::Trigger => out.push_str("TRIGGER WHEN DISTANCE=0 DELAY=0 DO r3() PRIO=-1\n"),
            Statement::Branch(calls, a, b) => {
                out.push_str(if *calls { "IF fun() THEN\n" } else { "IF $IN[1] THEN\n" });
                written(a, inside, labels, out);
                if let Some(b) = b {
                    out.push_str("ELSE\n");
                    written(b, inside, labels, out);
                }
                out.push_str("ENDIF\n");
            }
            Statement::Cases(all) => {
                out.push_str("SWITCH I\n");
                for (k, one) in all.iter().enumerate() {
                    out.push_str(&format!("CASE {k}\n"));
                    written(one, inside, labels, out);
                }
                out.push_str("ENDSWITCH\n");
            }
            Statement::Loop(word, a) => {
                let (open, close) = match *word {
                    "LOOP" => ("LOOP", "ENDLOOP"),
                    "WHILE" => ("WHILE $IN[2]", "ENDWHILE"),
                    "CALLING" => ("WHILE fun()", "ENDWHILE"),
                    "FOR" => ("FOR I=1 TO J", "ENDFOR"),
                    _ => ("REPEAT", "UNTIL $IN[3]"),
                };
                out.push_str(&format!("{open}\n"));
                written(a, true, labels, out);
                out.push_str(&format!("{close}\n"));
            }
            Statement::Jump(back, a) => {
                *labels += 1;
                let (label, jump) = (format!("L{labels}"), format!("IF $IN[4] THEN\nGOTO L{labels}\nENDIF\n"));
                out.push_str(&if *back { format!("{label}:\n") } else { jump.clone() });
                written(a, inside, labels, out);
                out.push_str(&if *back { jump } else { format!("{label}:\n") });
            }
            Statement::Exit => out.push_str(if inside { "EXIT\n" } else { "RETURN\n" }),
            Statement::Return => out.push_str("RETURN\n"),
        }
    }
}

/// What a routine has of its own.
#[derive(Clone, Copy)]
struct Own {
    point: [f64; 2],
    number: f64,
}

/// A run of the program: what inputs say is random, and so is what stands in variables that nobody has set.
struct Run<'a> {
    rng: &'a mut ChaCha8Rng,
    routines: &'a [Vec<Statement>],
    points: [[f64; 2]; 3],
    number: f64,
    /// The last routine may run at any time.
    armed: bool,
    steps: usize,
    reached: &'a mut BTreeMap<usize, Vec<[f64; 2]>>,
}

#[derive(PartialEq)]
enum End {
    On,
    Exit,
    Return,
    Stop,
}

impl Run<'_> {
    fn any(&mut self) -> f64 {
        f64::from(self.rng.random_range(100..200))
    }

    fn fresh(&mut self) -> Own {
        Own { point: [self.any(), self.any()], number: self.any() }
    }

    fn point(&self, p: usize, own: &Own) -> [f64; 2] {
        self.points.get(p).copied().unwrap_or(own.point)
    }

    fn value(&self, all: &[(Term, char)], own: &Own) -> f64 {
        let of = |t: &Term| match t {
            Term::Plain(n) => f64::from(*n),
            Term::Number(0) => self.number,
            Term::Number(_) => own.number,
            Term::Part(p, x) => self.point(*p, own)[usize::from(!x)],
        };
        let first = all.first().map_or(0.0, |t| of(&t.0));
        all.iter().skip(1).fold(first, |v, (t, sign)| match sign {
            '+' => v + of(t),
            '-' => v - of(t),
            _ => v * of(t),
        })
    }

    fn set(&mut self, p: usize, to: [f64; 2], own: &mut Own) {
        match self.points.get_mut(p) {
            Some(there) => *there = to,
            None => own.point = to,
        }
    }

    /// What the function assigns.
    fn function(&mut self, called: bool) {
        if called {
            self.points[1][1] = 2.0;
        }
    }

    fn call(&mut self, routine: usize, depth: usize) -> End {
        let mut own = self.fresh();
        let routines = self.routines;
        match self.block(&routines[routine], &mut own, depth + 1, false) {
            End::Stop => End::Stop,
            _ => End::On,
        }
    }

    fn block(&mut self, all: &[Statement], own: &mut Own, depth: usize, inside: bool) -> End {
        for s in all {
            self.steps += 1;
            if self.steps > 300 || depth > 12 {
                return End::Stop;
            }
            if self.armed && depth < 12 && self.rng.random_bool(0.1) {
                self.armed = false;
                let end = self.call(ROUTINES - 1, depth);
                self.armed = true;
                if end == End::Stop {
                    return end;
                }
            }
            let end = self.statement(s, own, depth, inside);
            if end != End::On {
                return end;
            }
        }
        End::On
    }

    fn statement(&mut self, s: &Statement, own: &mut Own, depth: usize, inside: bool) -> End {
        match s {
            Statement::Number(k, e) => {
                let value = self.value(e, own);
                *if *k == 0 { &mut self.number } else { &mut own.number } = value;
            }
            Statement::Copy(to, from) => {
                let value = self.point(*from, own);
                self.set(*to, value, own);
            }
            Statement::Part(p, x, e) => {
                let mut value = self.point(*p, own);
                value[usize::from(!x)] = self.value(e, own);
                self.set(*p, value, own);
            }
            Statement::Move(n, p) => {
                let value = self.point(*p, own);
                self.reached.entry(*n).or_default().push(value);
            }
            Statement::Call(r) => return self.call(*r, depth),
            Statement::Trigger => self.armed = true,
            Statement::Branch(calls, a, b) => {
                self.function(*calls);
                match (self.rng.random(), b) {
                    (true, _) => return self.block(a, own, depth, inside),
                    (false, Some(b)) => return self.block(b, own, depth, inside),
                    _ => {}
                }
            }
            Statement::Cases(all) => {
                if let Some(one) = all.get(self.rng.random_range(0..3)) {
                    return self.block(one, own, depth, inside);
                }
            }
            Statement::Loop(word, a) => return self.looped(word, a, own, depth),
            Statement::Jump(back, a) => loop {
                self.steps += 1;
                let jumps: bool = self.rng.random();
                if !back && jumps || self.steps > 300 {
                    return End::On;
                }
                let end = self.block(a, own, depth, inside);
                if end != End::On || !back || self.rng.random() {
                    return end;
                }
            },
            Statement::Exit if inside => return End::Exit,
            Statement::Exit | Statement::Return => return End::Return,
        }
        End::On
    }

    fn looped(&mut self, word: &str, a: &[Statement], own: &mut Own, depth: usize) -> End {
        let mut first = true;
        loop {
            self.steps += 1;
            if self.steps > 300 {
                return End::Stop;
            }
            self.function(word == "CALLING");
            if word != "LOOP" && !(word == "REPEAT" && first) && self.rng.random_bool(0.4) {
                return End::On;
            }
            first = false;
            match self.block(a, own, depth, true) {
                End::Exit => return End::On,
                End::On => {}
                end => return end,
            }
        }
    }
}

/// Whether any of the statements assigns the number of the data list, or the point.
fn assigns(all: &[Statement], number: bool) -> bool {
    all.iter().any(|s| match s {
        Statement::Number(0, _) => number,
        Statement::Branch(_, a, b) => assigns(a, number) || b.as_ref().is_some_and(|b| assigns(b, number)),
        Statement::Cases(all) => all.iter().any(|a| assigns(a, number)),
        Statement::Loop(_, a) | Statement::Jump(_, a) => assigns(a, number),
        _ => false,
    })
}

#[test]
fn a_computed_point_that_is_known_is_that_of_every_run() {
    let (mut known, mut checked) = (0, 0);
    let runs = count("KRL_RUNS", 400);
    for seed in 0..runs {
        let mut rng = generator(seed);
        let mut moves = 0;
        let routines: Vec<Vec<Statement>> = (0..ROUTINES).map(|_| block(&mut rng, 0, &mut moves)).collect();
        let interrupt = rng.random_bool(0.15);
        let (mut source, mut labels) = (String::new(), 0);
        for (k, all) in routines.iter().enumerate() {
            source.push_str(&format!("DEF r{k}()\nDECL E6POS L\nDECL REAL U\nDECL INT I,J\n"));
            if interrupt && k == 0 {
                source.push_str("INTERRUPT DECL 3 WHEN $IN[5]==TRUE DO r3()\nINTERRUPT ON 3\n");
            }
            written(all, false, &mut labels, &mut source);
            source.push_str("END\n");
        }
        source.push_str("DEFFCT BOOL fun()\nXUP.Z=2\nRETURN $IN[6]\nENDFCT\n");
        let mut reached = BTreeMap::new();
        let set = |number: bool| routines.iter().any(|r| assigns(r, number));
        // the function assigns the point
        let (sets_number, sets_point) = (set(true), true);
        for _ in 0..60 {
            let rng = &mut rng;
            let mut run = Run {
                rng,
                routines: &routines,
                points: [[1.0, 3.0], [5.0, 5.0], [0.0; 2]],
                number: 7.0,
                armed: interrupt,
                steps: 0,
                reached: &mut reached,
            };
            // lists keep what the run before has left
            if sets_number {
                run.number = run.any();
            }
            if sets_point {
                run.points[1] = [run.any(), run.any()];
            }
            run.points[2] = [run.any(), run.any()];
            run.call(0, 0);
        }
        let d = doc(&[source.as_bytes(), DAT.as_bytes()]);
        for (n, (_, m)) in super::moves(d.as_ref()).iter().enumerate() {
            let Goal::Pose(pose) = &m.goal else { continue };
            known += 1;
            for v in reached.get(&n).into_iter().flatten() {
                checked += 1;
                let at = [pose.position_m[0] * 1e3, pose.position_m[2] * 1e3];
                assert!((0..2).all(|k| (at[k] - v[k]).abs() < 1e-6), "{v:?} {at:?} move {n} of seed {seed}\n{source}");
            }
        }
    }
    assert!(known > runs / 2 && checked > 5 * runs, "{known} {checked}");
}
