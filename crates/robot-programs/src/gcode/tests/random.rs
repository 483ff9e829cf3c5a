//! Random programs with random edits, damaged programs, large ones, and the samples.

use super::*;

#[test]
fn ten_megabytes_are_read_and_written_in_linear_time() {
    let n = 400_000;
    let text: String = HEAD.to_string()
        + "G1 F100\n"
        + &(0..n).map(|k| format!("X{}.125 Y{}.5\n", k % 900, k % 700)).collect::<String>();
    let begun = std::time::Instant::now();
    let robot = robot();
    let document = Gcode.parse(vec![Text::new("job", text.into_bytes())], &robot).unwrap();
    assert_eq!(document.script().moves().count(), n + 1);
    let mut edits = Edits { digit: vec![1e-7; 3], ..Edits::default() };
    for (k, _) in document.script().moves().skip(1) {
        let goal = values(document.script(), k).iter().map(|v| if v.is_nan() { 0.0 } else { v + 5e-5 }).collect();
        edits.steps.insert(k, Edit { goal: Some(goal), ..Edit::default() });
    }
    assert_eq!(document.patches(&edits).unwrap().len(), 2 * n);
    assert!(begun.elapsed().as_secs() < 60, "quadratic");
}

/// A random program: absolute and relative words, arcs in three forms, shifts, labels.
fn random_program(rng: &mut impl Rng) -> String {
    let mut text = String::from(if rng.random_bool(0.8) { "G21 G90 G17\n" } else { "G20 G90\n" });
    let inch = text.starts_with("G20");
    let scale = if inch { 0.04 } else { 1.0 };
    let decimals = rng.random_range(1..5);
    let f = |v: f64| format!("{v:.decimals$}");
    text.push_str("G0 X0.0 Y0.0 Z0.0\n");
    let (mut at, mut absolute) = ([0.0f64; 3], true);
    let mut known = true;
    for n in 0..rng.random_range(1..14) {
        let number = if rng.random_bool(0.3) { format!("N{} ", 10 * n) } else { String::new() };
        match rng.random_range(0..12) {
            0 => {
                absolute = !absolute;
                text.push_str(if absolute { "G90\n" } else { "G91\n" });
            }
            1 => text.push_str("(comment X1)\n"),
            2 => text.push_str("G4 P0.5\n"),
            3 => text.push_str("G92 X1.0\nG92.1\n"),
            4 if known => {
                // an arc about a centre that is written exactly
                let r = f(rng.random_range(2.0..20.0) * scale).parse::<f64>().unwrap();
                let ccw = rng.random_bool(0.5);
                let code = if ccw { 3 } else { 2 };
                let quarter = rng.random_range(1..5);
                // from the right of the centre by quarters
                let angle = f64::from(quarter) * std::f64::consts::FRAC_PI_2 * if ccw { 1.0 } else { -1.0 };
                let by = [r * (angle.cos() - 1.0), r * angle.sin()];
                let start = at;
                let word = |k: usize| if absolute { f(start[k] + by[k]) } else { f(by[k]) };
                let centre = match rng.random_range(0..2) {
                    0 if quarter < 4 => format!("R{}", f(if quarter > 2 { -r } else { r })),
                    _ => format!("I{} J0.0", f(-r)),
                };
                let helix = if rng.random_bool(0.3) {
                    format!(" Z{}", f(if absolute { at[2] - scale } else { -scale }))
                } else {
                    String::new()
                };
                if !helix.is_empty() {
                    at[2] -= scale;
                }
                text.push_str(&format!("{number}G{code} X{} Y{}{helix} {centre} F100\n", word(0), word(1)));
                at[0] += by[0];
                at[1] += by[1];
            }
            5 if rng.random_bool(0.3) => {
                text.push_str("M98 P1\nG90 G17 G40 G54\n");
                text.push_str(if inch { "G20\n" } else { "G21\n" });
                (absolute, known) = (true, false);
                text.push_str("G0 X0.0 Y0.0 Z0.0\n");
                at = [0.0; 3];
                known |= true;
            }
            _ => {
                let mut line = format!("{number}G{}", rng.random_range(0..2));
                for (k, l) in ["X", "Y", "Z"].iter().enumerate() {
                    if rng.random_bool(0.5) {
                        let to = f(rng.random_range(-50.0..50.0) * scale).parse::<f64>().unwrap();
                        line.push_str(&format!(
                            "{}{l}{}",
                            if rng.random_bool(0.5) { " " } else { "" },
                            f(if absolute { to } else { to - at[k] })
                        ));
                        at[k] = to;
                    }
                }
                text.push_str(&line);
                text.push('\n');
            }
        }
    }
    if rng.random_bool(0.3) { text.replace('\n', "\r\n") } else { text }
}

/// Offsets as a compensation makes them: each axis has one, that changes at some blocks.
fn random_edits(rng: &mut impl Rng, script: &Script) -> Edits {
    let mut edits = Edits { digit: vec![1e-8; 3], ..Edits::default() };
    let mut offset = [0.0f64; 3];
    let mut at = [None; 3];
    for (k, step) in script.steps.iter().enumerate() {
        let m = match &step.kind {
            StepKind::Move(m) => m,
            StepKind::Break(_) => {
                (offset, at) = ([0.0; 3], [None; 3]);
                continue;
            }
            _ => continue,
        };
        let Goal::Joints(t) = m.goal else {
            (offset, at) = ([0.0; 3], [None; 3]);
            continue;
        };
        let from = at;
        for (a, v) in script.targets.get(t).unwrap().values.iter().enumerate() {
            at[a] = v.map(|v| v.si).or(at[a]);
        }
        if m.fixed.is_some() {
            offset = [0.0; 3];
            continue;
        }
        let mut before = Vec::new();
        let open = m.closed.is_none() && from.iter().zip(&at).all(|(a, b)| a.is_some() == b.is_some());
        for w in m.way.iter().filter(|_| open) {
            before.push(NewPoint {
                q: (0..3).map(|a| w.q[a] + offset[a]).collect(),
                share: w.share,
                t_s: None,
                clearance_m: 0.0,
                of_way: true,
                waits: false,
            });
            if rng.random_bool(0.7) {
                offset[rng.random_range(0..2)] += rng.random_range(-1e-4..1e-4);
                before.push(NewPoint {
                    q: (0..3).map(|a| w.q[a] + offset[a]).collect(),
                    share: w.share,
                    t_s: None,
                    clearance_m: 0.0,
                    of_way: false,
                    waits: false,
                });
            }
        }
        if m.way.is_empty() && m.path == PathKind::Joint {
            offset[rng.random_range(0..3)] += rng.random_range(-1e-4..1e-4);
            if open && rng.random_bool(0.4) {
                let share = rng.random_range(0.1..0.9);
                let q =
                    (0..3).map(|a| from[a].zip(at[a]).map_or(0.0, |(x, y)| x + share * (y - x)) + offset[a]).collect();
                before.push(NewPoint { q, share, t_s: None, clearance_m: 0.0, of_way: false, waits: false });
            }
        }
        // what a driver does not know of an axis is zero
        let goal = (0..3).map(|a| at[a].map_or(0.0, |v| v + offset[a])).collect();
        edits.steps.insert(k, Edit { before, goal: Some(goal), ..Edit::default() });
    }
    edits
}

/// Whether two programs end every arc and line at the same places but for offsets: checked by the harness; here, that bytes
/// outside of numbers stay.
fn letters(text: &[u8]) -> Vec<String> {
    let text = String::from_utf8_lossy(text).into_owned();
    text.lines()
        .filter(|l| l.starts_with('(') || l.starts_with('N') || l.starts_with("G9") || l.starts_with('M'))
        .map(|l| l.chars().filter(char::is_ascii_alphabetic).collect())
        .collect()
}

#[test]
fn damaged_programs_are_refused_or_come_back() {
    let source = |rng: &mut ChaCha8Rng| vec![random_program(rng).into_bytes()];
    harness::survives(&Gcode, &robot(), &source, &|script, rng| random_edits(rng, script));
}

#[test]
fn other_formats_are_not_taken_for_gcode() {
    for text in [
        "/JOB\n//NAME A\n//POS\n",
        "a1_deg,a2_deg\n1,2\n",
        "MODULE M\n  PROC main()\n",
        "&ACCESS RVP\nDEF A()\n",
        "def f():\n  movej([0,1])\n",
        "/PROG A\n/ATTR\n",
    ] {
        assert!(!Gcode.recognises(text.as_bytes()), "{text}");
    }
    for text in ["%\nO1000\nG21\n", "; comment\nG0X1Y2\n", "(a)\nN10 G90 G21\n"] {
        assert!(Gcode.recognises(text.as_bytes()), "{text}");
    }
}

#[test]
fn the_samples_are_read_and_their_edits_come_back() {
    let robot = robot();
    let samples = harness::samples(&Gcode);
    for (name, bytes) in &samples {
        assert!(Gcode.recognises(bytes), "{name}");
        let doc = harness::parse(&Gcode, bytes, &robot).unwrap();
        assert!(doc.script().moves().any(|(_, m)| matches!(m.goal, Goal::Joints(_))), "{name}");
        match edited(&Gcode, bytes, &random_edits(&mut generator(3), doc.script()), &robot) {
            Ok(_) => {}
            Err(e) => assert!(matches!(e, Error::Refused(_)), "{name}: {e}"),
        }
    }
    assert!(samples.len() >= 9, "{} samples", samples.len());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: u32::try_from(count("PROPTEST_CASES", 256)).unwrap(), ..ProptestConfig::default() })]
    #[test]
    fn edits_come_back_when_the_program_is_read_again(seed in any::<u64>()) {
        let robot = robot();
        let mut rng = generator(seed);
        let text = random_program(&mut rng);
        let script = script_of(&Gcode, &text, &robot);
        let edits = random_edits(&mut rng, &script);
        match edited(&Gcode, text.as_bytes(), &edits, &robot) {
            Ok(out) => {
                let (old, new) = (letters(text.as_bytes()), letters(&out));
                prop_assert!(old.len() <= new.len(), "{text}\n{}", String::from_utf8_lossy(&out));
            }
            // a whole circle, or what no digits hold: said, not done
            Err(Error::Refused(why)) => prop_assert!(why.contains("circle") || why.contains("no arc") || why.contains("very end"), "{why}\n{text}"),
            Err(e) => prop_assert!(false, "{e}\n{text}"),
        }
    }
}
