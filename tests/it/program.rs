//! The byte contract of joint-space CSV, with stages that stand in for the engine.

use lostmotion::error::{Error, Result};
use lostmotion::program::csv::{Reader, Style};
use lostmotion::rewrite::stream::{Passage, Stage, pass};
use lostmotion::rewrite::{Origin, OutputPoints, Points, RewriteStats};
use lostmotion::robot::Robot;
use proptest::prelude::*;
use std::io::{self, Read};

/// Two axes, one of each kind; limits that are easy to reach.
const ROBOT: &str = "schema: lostmotion/robot/1
name: two
joints:
  - {name: A1, kind: revolute, limits_deg: [-90, 90]}
  - {name: X, kind: prismatic, limits_mm: [0, 1000]}
";

pub fn robot() -> Robot {
    Robot::parse("robot.yaml", ROBOT).unwrap()
}

/// Adds `by` (deg and mm) to every `every`-th point, puts a point after every `insert`-th, and settles points `lag` late.
#[derive(Clone, Default)]
struct Stand {
    by: f64,
    every: usize,
    insert: usize,
    lag: usize,
    seen: Vec<(Vec<f64>, Option<f64>)>,
    settled: usize,
}

impl Stand {
    fn settle(&mut self, upto: usize, out: &mut OutputPoints) {
        for i in self.settled..upto {
            let (mut q, t) = self.seen[i].clone();
            if self.every > 0 && i % self.every == 0 {
                q[0] += self.by.to_radians();
                q[1] += self.by * 1e-3;
            }
            out.q.extend(&q);
            out.t_s.extend(t);
            out.origin.push(Origin::Point(i as u64));
            if self.insert > 0 && i % self.insert == 0 && i + 1 < self.seen.len() {
                let (next, t_next) = self.seen[i + 1].clone();
                out.q.extend(q.iter().zip(&next).map(|(a, b)| a + 0.1 * (b - a)));
                out.t_s.extend(t.zip(t_next).map(|(a, b)| a + 0.1 * (b - a)));
                out.origin.push(Origin::Inserted { after: i as u64, fraction: 0.1 });
            }
        }
        self.settled = upto.max(self.settled);
    }
}

impl Stage for Stand {
    fn push(&mut self, block: &Points, out: &mut OutputPoints) -> Result<()> {
        out.axes = block.axes;
        for i in 0..block.len() {
            self.seen.push((block.row(i).to_vec(), block.t_s.get(i).copied()));
        }
        self.settle(self.seen.len().saturating_sub(self.lag), out);
        Ok(())
    }

    fn finish(mut self, out: &mut OutputPoints) -> Result<RewriteStats> {
        out.axes = 2;
        self.settle(self.seen.len(), out);
        Ok(RewriteStats::default())
    }
}

/// Delivers a few bytes at a time.
struct Drip(io::Cursor<Vec<u8>>, usize);

impl Read for Drip {
    fn read(&mut self, buf: &mut [u8]) -> io::Result<usize> {
        let n = buf.len().min(self.1);
        self.0.read(&mut buf[..n])
    }
}

fn style(forced: Option<u8>) -> Style {
    Style { forced, least: vec![4, 4] }
}

fn take(text: &[u8], stand: Stand, style: Style, threads: bool, drip: usize) -> Result<Vec<u8>> {
    let input = Box::new(Drip(io::Cursor::new(text.to_vec()), drip));
    let robot = robot();
    let reader = Reader::new(input, "p.csv", robot.axes())?;
    let passage = Passage { style, threads, hash: false };
    Ok(pass(&robot, reader, &passage, |_| Ok(stand), Vec::new(), &|_| {})?.sink)
}

fn through(text: &str, stand: Stand) -> String {
    String::from_utf8(take(text.as_bytes(), stand, style(None), false, 1 << 20).unwrap()).unwrap()
}

fn shifted(text: &str, by: f64) -> String {
    through(text, Stand { by, every: 1, ..Stand::default() })
}

fn refusal(text: &[u8]) -> String {
    match take(text, Stand::default(), style(None), false, 1 << 20) {
        Err(e @ Error::BadInput(_)) => e.to_string(),
        other => panic!("{other:?}"),
    }
}

const AWKWARD: &str = "\u{feff}# made by hand\r\n\r\nNote, A1_DEG ,\"x_mm\",t_s\n\
    \"a, \"\"b\"\"\r\nc\", 1.50 ,\"2.0\",0\r\n  # in between\n\n   ,+2.5,3,0.5\rx;y,-.5,  4e0,1e0\r\n\
    \"\",007,1.,2\n\t \n# end\nlast,8,9,3";

#[test]
fn a_program_whose_targets_do_not_change_comes_back_byte_for_byte() {
    assert_eq!(through(AWKWARD, Stand::default()), AWKWARD);
    let crlf = "a1_deg,x_mm\r\n1,2\r\n-0.0,3.25\r\n";
    assert_eq!(through(crlf, Stand::default()), crlf);
}

#[test]
fn bytes_that_are_no_text_pass_through_in_comments_and_other_columns() {
    let text = b"# gr\xfc\xdfe\na1_deg,x_mm,n\n1,2,\xe4\n# \xff\n3,4,\xf6".to_vec();
    assert_eq!(take(&text, Stand::default(), style(None), true, 3).unwrap(), text);
}

#[test]
fn only_the_digits_of_targets_change_and_keep_their_style() {
    let want = "\u{feff}# made by hand\r\n\r\nNote, A1_DEG ,\"x_mm\",t_s\n\
    \"a, \"\"b\"\"\r\nc\", 1.5028 ,\"2.0028\",0\r\n  # in between\n\n   ,+2.5028,3.0028,0.5\rx;y,-.4972, 4.0028e0,1e0\r\n\
    \"\",007.0028,1.0028,2\n\t \n# end\nlast,8.0028,9.0028,3";
    assert_eq!(shifted(AWKWARD, 0.0028), want);
}

#[test]
fn decimals_of_a_number_are_kept_and_lengthened_only_where_the_gap_needs_it() {
    assert_eq!(shifted("a1_deg,x_mm\n10.123456,-5.0000\n", 0.0028), "a1_deg,x_mm\n10.126256,-4.9972\n");
    assert_eq!(shifted("a1_deg,x_mm\n10,-5\n", 0.0028), "a1_deg,x_mm\n10.0028,-4.9972\n");
    let forced =
        take(b"a1_deg,x_mm\n10.25,5\n", Stand { by: 0.0028, every: 1, ..Stand::default() }, style(Some(3)), false, 99);
    assert_eq!(forced.unwrap(), b"a1_deg,x_mm\n10.253,5.003\n");
}

#[test]
fn rounding_of_a_column_with_tokens_of_mixed_length_makes_no_movement_turn_back() {
    // rising by 0.00001 a row, written in the shortest form
    let rows: Vec<String> = (0..3000).map(|i| format!("{},0", f64::from(i) / 1e5)).collect();
    let out = shifted(&format!("a1_deg,x_mm\n{}\n", rows.join("\n")), 0.00283);
    let values: Vec<f64> = out.lines().skip(1).map(|l| l.split(',').next().unwrap().parse().unwrap()).collect();
    assert!(values.windows(2).all(|w| w[1] > w[0]));
}

#[test]
fn rounding_takes_no_value_beyond_a_limit_that_it_kept() {
    // 89.99996 rounds to the limit itself
    let out = shifted("a1_deg,x_mm\n89.9999,999.9999\n", 0.00006);
    assert_eq!(out, "a1_deg,x_mm\n90.0000,1000.0000\n");
    // limits that four decimals cannot hold: -90.000035 and 90.00006 keep them, -90.0000 and 90.0000 too, 90.0001 would not
    let text = "schema: lostmotion/robot/1\njoints:\n  - {name: A1, kind: revolute, limits_deg: [-90.00004, 90.00007]}\n  - {name: X, kind: prismatic}\n";
    let robot = Robot::parse("r", text).unwrap();
    for (value, by, want) in
        [("89.9999", 0.00016, "90.0000"), ("-89.9999", -0.000135, "-90.0000"), ("-90.0001", 0.0, "-90.0001")]
    {
        let text = format!("a1_deg,x_mm\n{value},0\n");
        let reader = Reader::new(Box::new(io::Cursor::new(text)), "p", robot.axes()).unwrap();
        let stand = Stand { by, every: usize::from(by != 0.0), ..Stand::default() };
        let passage = Passage { style: Style { forced: None, least: vec![4, 0] }, threads: false, hash: false };
        let out = pass(&robot, reader, &passage, |_| Ok(stand), Vec::new(), &|_| {}).unwrap().sink;
        let out = String::from_utf8(out).unwrap();
        assert_eq!(out.lines().nth(1).unwrap().split(',').next().unwrap(), want);
    }
}

#[test]
fn an_added_row_repeats_the_other_cells_and_the_line_ending_of_the_row_before() {
    let text = "n,a1_deg,x_mm,t_s,note\r\n1,10.0000,5.0,0.00,\"go, on\"\r\n# turn\r\n2,20.0000,6.0,0.10,\n3,30.0000,7.0,0.20,end";
    let want = "n,a1_deg,x_mm,t_s,note\r\n1,10.0000,5.0,0.00,\"go, on\"\r\n1,11.0000,5.1000,0.01,\"go, on\"\r\n# turn\r\n2,20.0000,6.0,0.10,\n2,21.0000,6.1000,0.11,\n3,30.0000,7.0,0.20,end";
    assert_eq!(through(text, Stand { insert: 1, ..Stand::default() }), want);
    let fine = "a1_deg,x_mm,t_s\n0.0000,0.0000,0.0\n1.0000,1.0000,0.1\n2.0000,2.0000,0.125\n";
    let want = "a1_deg,x_mm,t_s\n0.0000,0.0000,0.0\n0.1000,0.1000,0.010\n1.0000,1.0000,0.1\n1.1000,1.1000,0.1025\n2.0000,2.0000,0.125\n";
    assert_eq!(through(fine, Stand { insert: 1, ..Stand::default() }), want);
}

#[test]
fn cells_padded_to_a_width_keep_it_as_far_as_the_spaces_reach() {
    let text = "a1_deg,x_mm\n    9.9999,    1.0000\n   10.0000,    0.0000\n 9.9999, 1.0000\n";
    let want = "a1_deg,x_mm\n   10.0027,    1.0028\n   10.0028,    0.0028\n 10.0027, 1.0028\n";
    assert_eq!(shifted(text, 0.0028), want);
}

#[test]
fn every_refusal_names_file_line_and_column() {
    let cases: &[(&[u8], &str)] = &[
        (b"", "p.csv: found an empty file"),
        (b"# only\n", "p.csv: found no header row"),
        (b"a1_deg,x_mm\n# none\n", "p.csv: found a header and no rows"),
        (b"a1_deg;x_mm\n1;2\n", "p.csv:1:1: found semicolons"),
        (b"1.0,2.0\n", "p.csv:1:1: found `1.0,2.0`"),
        (b"a1_deg\n1\n", "p.csv:1: found no column x_mm"),
        (b"a1_rad,x_mm\n1,2\n", "p.csv:1:1: found column `a1_rad`: the targets of joint A1 are in deg"),
        (b"t_s,cmd_A1_deg,x_mm\n", "p.csv:1:2: found column `cmd_A1_deg`: this is a column of a measurement log"),
        (b"a1_deg,x_mm,A1_deg\n1,2,3\n", "p.csv:1:3: found a second column `A1_deg`"),
        (b"a1_deg,x_mm\n1,2\n\n1,\n", "p.csv:4:2: found an empty cell in column `x_mm`"),
        (b"a1_deg,x_mm\n1,nan\n", "p.csv:2:2: found `nan`"),
        (b"a1_deg,x_mm\n1,1e999\n", "p.csv:2:2: found `1e999`"),
        (b"a1_deg,x_mm\n\"1,5\",2\n", "p.csv:2:1: found a decimal comma, `1,5`"),
        (b"a1_deg,x_mm\n1,5,2,5\n", "p.csv:2: found 4 cells; expected 2 cells, as in the header (commas"),
        (b"a1_deg,x_mm\n1,2\n1\n", "p.csv:3: found 1 cells"),
        (b"a1_deg,x_mm,n\n1,2,\"a\n", "p.csv:2:3: found a quote that is not closed"),
        (b"a1_deg,x_mm,n\n1,2,\"a\"b\n", "p.csv:2:3: found a quote that is not closed, or text after"),
        (b"a1_deg,x_mm,t_s\n1,2,0\n# c\n1,2,0\n", "p.csv:4:3: found time 0 s after 0 s"),
        (b"\x1f\x8b\x08\x00", "p.csv: found a gzip file"),
        (b"\xff\xfea\x00", "p.csv: found UTF-16 text"),
        (b"a1_deg,x_mm\n1,2\x00\n", "p.csv: found bytes of value 0"),
    ];
    for (text, want) in cases {
        let got = refusal(text);
        assert!(got.starts_with(want), "{:?}\n got {got}\nwant {want}", String::from_utf8_lossy(text));
    }
}

#[test]
fn the_line_of_a_point_counts_comments_blank_lines_and_breaks_in_cells() {
    let robot = robot();
    let text = "# c\na1_deg,x_mm,n\n1,2,\n\n1,2,\"a\nb\"\n1,2,\n";
    let mut reader = Reader::new(Box::new(io::Cursor::new(text)), "p", robot.axes()).unwrap();
    let mut block = lostmotion::program::Block::default();
    while reader.next(&mut block).unwrap() {}
    let lines = reader.into_lines();
    assert_eq!([0, 1, 2].map(|p| lines.line(p)), [Some(3), Some(5), Some(7)]);
}

/// Rows of every kind, enough of them to fill several blocks.
fn large() -> Vec<u8> {
    let mut text = String::from("a1_deg,x_mm,note,t_s\r\n");
    for i in 0..40_000 {
        let a = f64::from(i % 7919) / 100.0 - 40.0;
        match i % 97 {
            0 => text.push_str("# a comment, \"with a quote\n"),
            1 => text.push_str("\r\n"),
            2 => text.push_str(&format!(" {a:.3} ,\"{i}e-2\",\"a\r\n,b\",{i}\r")),
            _ => {}
        }
        if i % 97 != 2 {
            text.push_str(&format!("{a:.4},{:.2},n{i},{i}\n", f64::from(i % 1000)));
        }
    }
    text.into_bytes()
}

#[test]
fn the_output_depends_neither_on_threads_nor_on_how_the_input_arrives() {
    let text = large();
    let stand = Stand { by: 0.0028, every: 3, insert: 50, lag: 700, ..Stand::default() };
    let want = take(&text, stand.clone(), style(None), false, 1 << 20).unwrap();
    assert!(want.len() > text.len() && text.len() > 3 * (256 << 10));
    for (threads, drip) in [(true, 1 << 20), (true, 1013), (false, 4099)] {
        assert!(take(&text, stand.clone(), style(None), threads, drip).unwrap() == want, "{threads} {drip}");
    }
    assert!(take(&text, Stand { lag: 30_000, ..Stand::default() }, style(None), true, 5000).unwrap() == text);
}

#[test]
fn an_error_far_into_a_program_is_the_same_with_and_without_threads() {
    let mut text = large();
    text.extend_from_slice(b"1,oops,n,99999\n");
    let of = |threads| take(&text, Stand::default(), style(None), threads, 1 << 20).unwrap_err().to_string();
    assert!(of(false).contains("found `oops` in column `x_mm`"), "{}", of(false));
    assert_eq!(of(false), of(true));
}

proptest! {
    #[test]
    fn whatever_the_bytes_reading_ends_with_a_program_or_a_refusal(bytes: Vec<u8>) {
        let text = [b"a1_deg,x_mm\n1,2\n".as_slice(), &bytes].concat();
        if let Ok(out) = take(&text, Stand::default(), style(None), false, 7) {
            prop_assert_eq!(out, text);
        }
    }

    #[test]
    fn whatever_the_cells_a_program_comes_back(
        rows in prop::collection::vec(("[-+]?[0-9]{1,9}(\\.[0-9]{0,9})?", "[ ]?[0-9]{0,3}\\.[0-9]{1,8}(e-?[0-9])?", "[a-z,\"]{0,4}", "\n|\r\n|\r|\n\n|\n# c\r\n"), 1..40)
    ) {
        let mut text = String::from("a1_deg,x_mm,n\n");
        for (a, x, n, end) in &rows {
            text += &format!("{a},{x},\"{}\"{end}", n.replace('"', "\"\""));
        }
        prop_assert_eq!(through(&text, Stand::default()), text);
    }
}
