//! Lines that differ in their numbers alone are read once, and must come out as if each were read in full: every program is read as it is,
//! and with words of the same meaning and length in every second line, so that no two lines are alike. Steps, targets and bytes of
//! edits are the same. With a fixed seed.

use robot_programs::axes::{Axes, Axis, JointKind};
use robot_programs::control::Control;
use robot_programs::formats::FORMATS;
use robot_programs::script::{Document, Edit, Edits, Format, Goal, NewPoint, Script, StepKind, Text};

/// Marsaglia (2003): the same numbers on every machine.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % n as u64) as usize
    }

    fn one<'a>(&mut self, of: &[&'a str]) -> &'a str {
        of[self.below(of.len())]
    }

    /// Mostly plain, sometimes written in another way.
    fn number(&mut self) -> String {
        let (whole, part) = (self.below(120), self.below(10_000));
        let sign = self.one(&["", "", "-"]);
        match self.below(24) {
            0 => format!("{sign}{whole}"),
            1 => format!("{sign}{whole}.{}", part % 10),
            2 => format!("+{whole}.5"),
            3 => format!("{sign}.{part:04}"),
            4 => format!("{sign}0{whole}.50"),
            5 => "-0.0000".into(),
            _ => format!("{sign}{whole}.{part:04}"),
        }
    }
}

/// Lines of a program with two ways to write each; what stands before and after them.
struct Language {
    format: &'static str,
    axes: Axes,
    head: &'static str,
    tail: &'static str,
    /// A motion; `{}` are its numbers.
    motions: &'static [&'static str],
    /// Other lines.
    others: &'static [&'static str],
    /// Words, and others of their length that mean the same.
    same: &'static [(&'static str, &'static str)],
}

fn arm(letter: &str) -> Axes {
    Axes::new("arm", (1..=6).map(|k| Axis::new(format!("{letter}{k}"), JointKind::Revolute)).collect())
}

fn gantry() -> Axes {
    let mut axes = Axes::new("gantry", ["X", "Y", "Z"].iter().map(|n| Axis::new(*n, JointKind::Prismatic)).collect());
    axes.control = Control { absolute: Some(true), inch: Some(false), whole_units: true, ..Control::default() };
    axes
}

fn languages() -> Vec<Language> {
    vec![
        Language {
            format: "krl",
            axes: arm("A"),
            head: "DEF big( )\nPTP {A1 0,A2 -90,A3 90,A4 0,A5 0,A6 0}\n",
            tail: "END\n",
            motions: &[
                "PTP {A1 {},A2 {},A3 {},A4 {},A5 {},A6 {}}",
                "PTP {A1 {},A2 {},A3 {},A4 {},A5 {},A6 {}} C_PTP",
                "  PTP {E6AXIS: A1 {},A3 {},A2 {},A4 {},A5 {},A6 {},E1 0.0,E2 7.5}",
                "PTP {A1 {},A2 {}}",
                "LIN {X {},Y {},Z {},A {},B {},C {}}",
                "PTP {A1 {},A2 {},A3 {},A4 {},A5 {},A6 {}} ; near the part",
            ],
            others: &[
                "TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[1]=TRUE",
                "WAIT SEC 0.5",
                "; lostmotion: off",
                "; lostmotion: on",
                "$VEL_AXIS[1]=50",
                "",
                "LABEL:",
                ";FOLD PTP P1;%{PE}",
                ";ENDFOLD",
                "IF $IN[1] THEN",
                "ENDIF",
                "SPLINE",
                "ENDSPLINE",
                "other( )",
            ],
            same: &[("PTP", "Ptp"), ("LIN", "Lin")],
        },
        Language {
            format: "rapid",
            axes: arm("J"),
            head: "MODULE big\nPERS jointtarget home:=[[0,0,0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\nPROC main()\n",
            tail: "ENDPROC\nENDMODULE\n",
            motions: &[
                "  MoveAbsJ [[{},{},{},{},{},{}],[9E9,9E9,9E9,9E9,9E9,9E9]],v500,z10,tool0;",
                "  MoveAbsJ [[{},{},{},{},{},{}],[0,9E9,9E9,9E9,9E9,9E9]],v500,fine,tool0;",
                "MoveAbsJ [[{}, {}, {}, {}, {}, {}],[1,9E9,9E9,9E9,9E9,9E9]]\\NoEOffs,v50\\T:=2,z1,tool0\\WObj:=wobj0;",
                "  MoveAbsJ [[{},{},{},{},{},{}],[9E9,9E9,9E9,9E9,9E9,9E9]],v500,z10,tool0; ! lostmotion: off",
                "  MoveAbsJ [[{},{},{},{},{},{}],[9E9,9E9,9E9,9E9,9E9,9E9]],v500,z10,tool0; ! lostmotion: on",
                "  MoveAbsJ [[{},{},{},{},{},{}],[9E9,9E9,9E9,9E9,9E9,9E9]],speed(),z10,tool0;",
            ],
            others: &[
                "  WaitTime 0.5;",
                "  MoveAbsJ home,v500,z10,tool0;",
                "  SetDO do1,1;",
                "  IF di1=1",
                "  other;",
                "",
                "  CorrCon id;",
                "  SyncMoveOn s,t;",
                "  again:",
                "  ! a word",
            ],
            same: &[("MoveAbsJ", "moveabsj")],
        },
        Language {
            format: "urscript",
            axes: arm("J"),
            head: "def big():\n  q1 = [0, 0, 0, 0, 0, 0]\n",
            tail: "end\n",
            motions: &[
                "  movej([{}, {}, {}, {}, {}, {}], a=1.4, v=1.05)",
                "  movej([{}, {}, {}, {}, {}, {}], a=1.4, v=1.05, r=0.01)",
                "  movej([{}, {}, {}, {}, {}, {}], t=2.5)",
                "  servoj([{}, {}, {}, {}, {}, {}], t=0.1)",
                "  movel([{}, {}, {}, {}, {}, {}], a=1.4, v=0.25)",
                "  movej([{}, {}, {}, {}, {}, {}], a=1.4, v=speed())",
                "  movej([{}, {}, {}, {}, {}, {}], a=(1.4)\n  , v=(1.05))",
            ],
            others: &[
                "  sleep(0.5)",
                "  movej(q1, a=1.4, v=1.05)",
                "  # lostmotion: off",
                "  # lostmotion: on",
                "  set_tcp(p[0, 0, 0.1, 0, 0, 0])",
                "  force_mode_set_damping(0.5)",
                "  conveyor_pulse_decode(1, 0, 0)",
                "  other()",
                "",
                "  if True: movej(q1) end",
            ],
            same: &[("], ", "] ,")],
        },
        Language {
            format: "gcode",
            axes: gantry(),
            head: "%\nO1001\nG21 G90 G17 G94\nG54\n",
            tail: "M30\n%\n",
            motions: &[
                "G1 X{} Y{} Z{} F3000",
                "G1 X{} Y{} Z{}",
                "X{}Y{}",
                "N10 G0 X{} Z{}",
                "G1 X{} Y{} (lostmotion: off)",
                "G1 X{} Y{} (lostmotion: on)",
                "G2 X{} Y{} I1.5 J0.5",
                "G1 Z{} X{} M3",
            ],
            others: &[
                "G4 X0.5", "G91", "G90", "G20", "G21", "M8", "M6 T1", "F500", "", "#1=5", "G92 X0", "G55", "G61",
                "G64", "M98 P5", "(a word)",
            ],
            same: &[("G1", "g1"), ("G0", "g0"), ("X", "x"), ("Z", "z")],
        },
    ]
}

impl Language {
    /// A program of some lines of each kind, as it is and with every second line in its other words.
    fn program(&self, random: &mut Random) -> [Vec<u8>; 2] {
        let mut both = [self.head.to_string(), self.head.to_string()];
        let mut k = 0;
        for _ in 0..1 + random.below(5) {
            let motion = random.one(self.motions);
            for _ in 0..1 + random.below(12) {
                let mut line = String::new();
                for (n, piece) in motion.split("{}").enumerate() {
                    let number = if n > 0 { random.number() } else { String::new() };
                    line.push_str(&number);
                    line.push_str(piece);
                }
                let other = self.same.iter().fold(line.clone(), |line, (a, b)| line.replace(a, b));
                assert_eq!(line.len(), other.len());
                both[1] += if k % 2 == 0 { &line } else { &other };
                both[0] += &line;
                both.iter_mut().for_each(|text| text.push('\n'));
                k += 1;
            }
            if random.below(2) == 0 {
                let line = random.one(self.others);
                both.iter_mut().for_each(|text| *text += &format!("{line}\n"));
            }
        }
        let end = random.one(&["\n", "\r\n"]);
        both.map(|text| (text + self.tail).replace('\n', end).into_bytes())
    }
}

/// All that a script says, but for the words in which it says it.
fn told(script: &Script) -> Vec<String> {
    let steps = script.steps.iter().map(|step| match &step.kind {
        StepKind::Move(m) => format!("{:?} {:?} {:?} {:?}", step.at, **m, m.goal, m.way),
        other => format!("{:?} {other:?}", step.at),
    });
    let targets = script
        .targets
        .iter()
        .map(|t| format!("{:?} {:?} {:?} {:?}", t.pose, t.name, t.at, t.values.iter().collect::<Vec<_>>()));
    let notes = script.notes.iter().map(|n| format!("{n:?}"));
    steps.chain(targets).chain(notes).chain([format!("{:?} {:?}", script.entry, script.missing)]).collect()
}

/// Other joint values for all moves that take them, and a new point before some.
fn edits(script: &Script, axes: usize) -> Edits {
    let edit = |(k, m): (usize, &robot_programs::script::Move)| {
        let Goal::Joints(t) = m.goal else { return None };
        let q: Vec<f64> =
            script.targets.get(t)?.values.si_or_nan().map(|v| if v.is_nan() { 0.0 } else { v + 1e-3 }).collect();
        let new = NewPoint { q: q.clone(), share: 0.5, t_s: None, clearance_m: 0.1, of_way: false, waits: false };
        let before = if m.closed.is_none() && k % 3 == 0 { vec![new] } else { Vec::new() };
        Some((k, Edit { goal: Some(q).filter(|_| m.fixed.is_none()), before, ..Edit::default() }))
    };
    let steps = script.moves().filter_map(edit).collect();
    Edits { steps, digit: vec![1e-6; axes], ..Edits::default() }
}

fn written(document: &dyn Document, axes: usize) -> Result<Vec<(usize, usize, usize, String)>, String> {
    let edits = edits(document.script(), axes);
    let patches = document.patches(&edits).map_err(|e| e.to_string())?;
    let plain = |bytes: &[u8]| String::from_utf8_lossy(bytes).to_ascii_lowercase().replace(' ', "");
    Ok(patches.iter().map(|p| (p.file, p.span.start, p.span.end, plain(p.bytes))).collect())
}

#[test]
fn lines_that_are_alike_are_read_as_if_each_were_read_in_full() {
    for language in languages() {
        let format: &dyn Format = *FORMATS.iter().find(|f| f.name() == language.format).unwrap();
        let mut random = Random(0x9e37_79b9_7f4a_7c15);
        let (mut read, mut moves, mut edited) = (0, 0, 0);
        for _ in 0..600 {
            let programs = language.program(&mut random);
            let parsed = programs.clone().map(|text| format.parse(vec![Text::new("program", text)], &language.axes));
            let shown = String::from_utf8_lossy(&programs[0]).into_owned();
            match parsed {
                [Ok(alike), Ok(full)] => {
                    let (a, b) = (told(alike.script()), told(full.script()));
                    assert_eq!(a.len(), b.len(), "{shown}");
                    a.iter().zip(&b).for_each(|(a, b)| assert_eq!(a, b, "{shown}"));
                    let (a, b) = (written(&*alike, language.axes.dof()), written(&*full, language.axes.dof()));
                    assert_eq!(a, b, "{shown}");
                    edited += usize::from(a.is_ok_and(|patches| !patches.is_empty()));
                    moves += alike.script().moves().count();
                    read += 1;
                }
                [Err(a), Err(b)] => assert_eq!(a.to_string().to_lowercase(), b.to_string().to_lowercase(), "{shown}"),
                [a, b] => panic!("{:?} {:?}\n{shown}", a.err(), b.err()),
            }
        }
        println!("{}: {read} programs, {moves} moves, {edited} with edits", language.format);
        assert!(read > 200 && edited > 100, "{}: {read} programs were read, {edited} edited", language.format);
    }
}
