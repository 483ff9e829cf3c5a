//! A machine that runs simple programs word by word, written apart from the reader: loops, conditions and calls are run, and each axis has
//! lost motion. Errors of programs are panics: the programs here have none.

use std::collections::BTreeMap;

/// Where control lands on a line, and from where.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Landing {
    pub line: usize,
    /// The line of the last move that was done.
    pub last_move: Option<usize>,
}

/// A move that was done; mm.
#[derive(Debug, Clone)]
pub(super) struct Done {
    pub line: usize,
    pub to: [f64; 3],
    /// Where the axes stand with their lost motion.
    pub stands: [f64; 3],
    /// Depth of the hole made there, with its lost motion, and its level R.
    pub hole: Option<[f64; 2]>,
}

/// What was run.
#[derive(Debug, Default)]
pub(super) struct Ran {
    pub done: Vec<Done>,
    pub landings: Vec<Landing>,
    /// Loops that were passed by, by their first lines.
    pub passed_by: Vec<usize>,
}

/// Half of the lost motion of each axis, mm.
pub(super) const HALF: f64 = 0.02;

struct Machine {
    lines: Vec<String>,
    variables: BTreeMap<String, f64>,
    at: [f64; 3],
    side: [f64; 3],
    absolute: bool,
    inch: bool,
    /// 0, 1, or 81 to 89.
    motion: u32,
    depth: f64,
    level: f64,
    initial: f64,
    to_initial: bool,
    ran: Ran,
}

/// Runs a program of lines.
pub(super) fn run(text: &str) -> Ran {
    let lines = text.lines().map(|l| l.trim().to_uppercase()).collect();
    let (absolute, inch, to_initial) = (true, false, true);
    let (at, side, variables, ran) = ([0.0; 3], [0.0; 3], BTreeMap::new(), Ran::default());
    let (motion, depth, level, initial) = (0, 0.0, 0.0, 0.0);
    let mut machine =
        Machine { lines, variables, at, side, absolute, inch, motion, depth, level, initial, to_initial, ran };
    machine.from(0);
    machine.ran
}

impl Machine {
    fn land(&mut self, line: usize) {
        let last_move = self.ran.done.last().map(|d| d.line);
        self.ran.landings.push(Landing { line, last_move });
    }

    fn find(&self, from: usize, is: impl Fn(&str) -> bool) -> usize {
        (from..self.lines.len()).find(|k| is(&self.lines[*k])).expect("a line that ends what was begun")
    }

    fn value(&self, text: &str) -> f64 {
        let text = text.trim_matches(['[', ']']);
        match text.strip_prefix('#') {
            Some(name) => self.variables.get(name).copied().unwrap_or(0.0),
            None => text.parse().unwrap_or_else(|_| panic!("the number {text}")),
        }
    }

    fn holds(&self, condition: &str) -> bool {
        let words: Vec<&str> = condition.trim_matches(['[', ']']).split_whitespace().collect();
        let [left, how, right] = words[..] else { panic!("the condition {condition}") };
        let (left, right) = (self.value(left), self.value(right));
        match how {
            "LT" => left < right,
            "LE" => left <= right,
            "EQ" => left == right,
            _ => panic!("the comparison {how}"),
        }
    }

    fn assign(&mut self, text: &str) {
        let (name, value) = text.split_once('=').expect("an assignment");
        let value = match value.split_once('+') {
            Some((own, more)) => self.value(own) + self.value(more),
            None => self.value(value),
        };
        self.variables.insert(name.trim_start_matches('#').into(), value);
    }

    /// Runs from a line up to the end of what was called, or of the program (`true`).
    fn from(&mut self, start: usize) -> bool {
        // loops that are open: first line, passes left of a repeat
        let mut open: Vec<(usize, Option<u32>)> = Vec::new();
        let mut k = start;
        while k < self.lines.len() {
            let line = self.lines[k].clone();
            let bracket = line.find('[').map_or("", |at| &line[at..=line.rfind(']').expect("its end")]).to_string();
            let words: Vec<&str> = line.split_whitespace().collect();
            let second = words.get(1).copied().unwrap_or_default().to_string();
            match words.first().copied().unwrap_or_default() {
                "" | "%" => {}
                "M30" | "M2" => return true,
                "M99" => return false,
                "M98" => {
                    let mut times = 1;
                    let mut name = String::new();
                    for w in &words[1..] {
                        match w.split_at(1) {
                            ("P", n) => name = format!("O{n}"),
                            ("L", n) => times = n.parse().expect("a count"),
                            _ => panic!("{line}"),
                        }
                    }
                    let sub = self.find(0, |l| l == name);
                    for _ in 0..times {
                        self.land(sub);
                        assert!(!self.from(sub + 1), "the program ends in a subprogram");
                    }
                    self.land(k);
                }
                "WHILE" => {
                    let number = line.rsplit("DO").next().expect("a number").to_string();
                    if self.holds(&bracket) {
                        self.land(k);
                        if open.last().is_none_or(|o| o.0 != k) {
                            open.push((k, None));
                        }
                    } else {
                        let end = self.find(k, |l| l == format!("END{number}"));
                        match open.pop_if(|o| o.0 == k) {
                            Some(_) => {}
                            None => self.ran.passed_by.push(k),
                        }
                        self.land(end);
                        k = end;
                    }
                }
                w if w.starts_with("END") => k = open.last().expect("a loop").0 - 1,
                "IF" => {
                    if self.holds(&bracket) {
                        self.assign(line.rsplit("THEN ").next().expect("an assignment"));
                    }
                    self.land(k);
                }
                label if label.starts_with('O') => match second.as_str() {
                    // another program: only a call leads there
                    "" if k > 0 && self.lines[..k].iter().any(|l| l.starts_with('G')) => return true,
                    "" => self.land(k),
                    "SUB" => {
                        k = self.find(k, |l| l == format!("{label} ENDSUB"));
                        self.land(k);
                    }
                    "ENDSUB" => return false,
                    "CALL" => {
                        let sub = self.find(0, |l| l == format!("{label} SUB"));
                        self.land(sub);
                        assert!(!self.from(sub + 1), "the program ends in a subprogram");
                        self.land(k);
                    }
                    "REPEAT" => {
                        let passes = self.value(&bracket) as u32;
                        match open.last_mut().filter(|o| o.0 == k) {
                            Some((_, left)) => *left = left.map(|n| n - 1),
                            None => open.push((k, Some(passes))),
                        }
                        if open.last().is_some_and(|o| o.1 == Some(0)) {
                            open.pop();
                            if passes == 0 {
                                self.ran.passed_by.push(k);
                            }
                            k = self.find(k, |l| l == format!("{label} ENDREPEAT"));
                            self.land(k);
                        } else {
                            self.land(k);
                        }
                    }
                    "WHILE" => {
                        if self.holds(&bracket) {
                            self.land(k);
                            if open.last().is_none_or(|o| o.0 != k) {
                                open.push((k, None));
                            }
                        } else {
                            if open.pop_if(|o| o.0 == k).is_none() {
                                self.ran.passed_by.push(k);
                            }
                            k = self.find(k, |l| l == format!("{label} ENDWHILE"));
                            self.land(k);
                        }
                    }
                    "ENDREPEAT" | "ENDWHILE" => k = open.last().expect("a loop").0 - 1,
                    "IF" => {
                        if self.holds(&bracket) {
                            self.land(k);
                        } else {
                            k = self.find(k, |l| l == format!("{label} ELSE") || l == format!("{label} ENDIF"));
                            self.land(k);
                        }
                    }
                    "ELSE" => {
                        k = self.find(k, |l| l == format!("{label} ENDIF"));
                        self.land(k);
                    }
                    "ENDIF" => self.land(k),
                    other => panic!("{other}"),
                },
                w if w.starts_with('#') => self.assign(&line),
                _ => self.block(k, &words),
            }
            k += 1;
        }
        true
    }

    /// A block of modes and places, words apart by blanks.
    fn block(&mut self, k: usize, words: &[&str]) {
        let mut named: [Option<f64>; 3] = [None; 3];
        let mut places = false;
        for w in words {
            let (letter, number) = w.split_at(1);
            let value = || self.value(number);
            match letter {
                "N" | "F" => {}
                "G" => match value() as u32 {
                    90 => self.absolute = true,
                    91 => self.absolute = false,
                    20 => self.inch = true,
                    21 => self.inch = false,
                    80 => self.motion = 0,
                    98 => self.to_initial = true,
                    99 => self.to_initial = false,
                    17 | 40 | 54 | 94 => {}
                    g => {
                        if g > 80 && self.motion < 80 {
                            self.initial = self.at[2];
                        }
                        self.motion = g;
                    }
                },
                "R" => {
                    self.level = value() * self.unit();
                    places = true;
                }
                _ => {
                    named["XYZ".find(letter).expect("an axis")] = Some(value() * self.unit());
                    places = true;
                }
            }
        }
        if !places {
            return;
        }
        let hole = self.motion > 80;
        let mut to = self.at;
        for a in (0..3).filter(|a| !hole || *a < 2) {
            to[a] = named[a].map_or(to[a], |v| if self.absolute { v } else { to[a] + v });
        }
        self.go(to);
        let (target, mut stands) = (to, self.stands());
        let mut made = None;
        if hole {
            assert!(self.absolute, "holes in relative words are not run here");
            self.depth = named[2].unwrap_or(self.depth);
            self.go([to[0], to[1], self.level]);
            self.go([to[0], to[1], self.depth]);
            stands = self.stands();
            made = Some([stands[2], self.level]);
            let level = if self.to_initial { self.initial.max(self.level) } else { self.level };
            self.go([to[0], to[1], level]);
        }
        self.ran.done.push(Done { line: k, to: target, stands, hole: made });
    }

    fn unit(&self) -> f64 {
        if self.inch { 25.4 } else { 1.0 }
    }

    fn go(&mut self, to: [f64; 3]) {
        for a in 0..3 {
            let by = to[a] - self.at[a];
            if by.abs() > 1e-9 {
                self.side[a] = by.signum();
            }
        }
        self.at = to;
    }

    fn stands(&self) -> [f64; 3] {
        [0, 1, 2].map(|a| self.at[a] - self.side[a] * HALF)
    }
}
