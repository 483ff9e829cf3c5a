//! The way of a program through the workers: the same bytes, and the same failure, whatever their number.

use crate::support::bundled;
use lostmotion::error::{Error, Result};
use lostmotion::program::csv::{Reader, Style};
use lostmotion::rewrite::sink::Sink;
use lostmotion::rewrite::stream::{Passage, Preview, Stage, pass};
use lostmotion::rewrite::{Origin, OutputPoints, Points, RewriteStats};
use lostmotion::robot::Robot;
use std::fmt::Write;
use std::io::Cursor;

/// Adds the same to every number of A1, a row late, and a point after every hundredth row.
struct Shift {
    by: f64,
    held: Option<Vec<f64>>,
    next: u64,
}

impl Shift {
    fn emit(&mut self, q: &[f64], out: &mut OutputPoints) {
        out.q.extend(q.iter().enumerate().map(|(a, v)| if a == 0 { v + self.by } else { *v }));
        out.origin.push(Origin::Point(self.next));
        if self.next.is_multiple_of(100) {
            out.q.extend(q.iter().map(|_| 0.0));
            out.origin.push(Origin::Inserted { after: self.next, fraction: 0.5 });
        }
        self.next += 1;
    }
}

impl Stage for Shift {
    fn push(&mut self, block: &Points, out: &mut OutputPoints) -> Result<()> {
        out.axes = block.axes;
        for i in 0..block.len() {
            if let Some(held) = self.held.replace(block.row(i).to_vec()) {
                self.emit(&held, out);
            }
        }
        Ok(())
    }

    fn finish(mut self, out: &mut OutputPoints) -> Result<RewriteStats> {
        if let Some(held) = self.held.take() {
            self.emit(&held, out);
        }
        Ok(RewriteStats::default())
    }
}

/// A program of many blocks and what the stage makes of it, by the standard library.
fn program(rows: u32) -> (String, String) {
    let mut text = String::from("a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n");
    let mut want = text.clone();
    for i in 0..rows {
        let a = i % 700;
        let rest = format!("-90.{:04},90.0000,0.0000,{}.5000,0.0000", i % 10_000, i % 60);
        let _ = writeln!(text, "{a}.0000,{rest}");
        let _ = writeln!(want, "{a}.2500,{rest}");
        if i % 100 == 0 {
            want.push_str("0.0000,0.0000,0.0000,0.0000,0.0000,0.0000\n");
        }
        if i % 3000 == 17 {
            text.push_str("# between rows\n\n");
            want.push_str("# between rows\n\n");
        }
    }
    (text, want)
}

fn robot() -> Robot {
    Robot::load(&bundled("configs/kuka-kr120-r2500-pro.yaml")).unwrap()
}

fn through<S: Sink>(text: &str, threads: bool, sink: S) -> Result<S> {
    let robot = robot();
    let reader = Reader::new(Box::new(Cursor::new(text.as_bytes().to_vec())), "p.csv", robot.axes())?;
    let passage = Passage { style: Style { forced: None, least: vec![0; 6] }, threads, hash: true };
    let make = |_: &Preview| Ok(Shift { by: 0.25_f64.to_radians(), held: None, next: 0 });
    let done = pass(&robot, reader, &passage, make, sink, &|_| {})?;
    assert_eq!(done.written, [Some(4); 6]);
    Ok(done.sink)
}

#[test]
fn a_program_comes_out_the_same_whatever_the_number_of_workers() {
    let (text, want) = program(60_000);
    for threads in [false, true] {
        let got = String::from_utf8(through(&text, threads, Vec::new()).unwrap()).unwrap();
        let differs = got.lines().zip(want.lines()).position(|(a, b)| a != b);
        assert!(got == want, "first difference in line {differs:?}");
    }
}

/// Refuses the piece that reaches a size.
struct Full {
    taken: usize,
    most: usize,
}

impl Sink for Full {
    fn take(&mut self, bytes: &[u8]) -> Result<()> {
        self.taken += bytes.len();
        if self.taken > self.most { Err(Error::Refused("the disk is full".into())) } else { Ok(()) }
    }
}

#[test]
fn the_first_failure_in_the_order_of_the_program_is_the_one_that_is_reported() {
    let (mut text, _) = program(60_000);
    let lines = text.lines().count();
    text.push_str("1,2,3\n");
    for threads in [false, true] {
        for _ in 0..5 {
            let error = through(&text, threads, Vec::new()).err().unwrap().to_string();
            assert!(error.contains(&format!("p.csv:{}", lines + 1)), "{error}");
            let full = Full { taken: 0, most: 600_000 };
            let error = through(&text, threads, full).err().unwrap().to_string();
            assert!(error.contains("the disk is full"), "{error}");
        }
    }
}
