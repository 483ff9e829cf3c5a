//! Random jobs with random edits, damaged jobs, large ones, and the samples.

use super::*;

#[test]
fn ten_megabytes_are_read_in_linear_time() {
    let n = 120_000;
    let list: String = (0..n).map(|k| format!("C{k:06}={k},0,0,0,0,0\n")).collect();
    let moves: String = (0..n).map(|k| format!("MOVL C{k:06} V=50.0 PL=0\n")).collect();
    let text = job(&format!("{n},0,0,0,0,0"), &format!("///POSTYPE PULSE\n///PULSE\n{list}"), &moves);
    let begun = std::time::Instant::now();
    let script = script_of(&Inform, &text.replace("\r\n\r\n", "\r\n"), &robot());
    assert_eq!(script.moves().count(), n);
    assert!(begun.elapsed().as_secs() < 60, "quadratic");
}

/// A random job: lists with switches of type and tool, moves with everything around them.
fn random_job(rng: &mut impl Rng) -> String {
    let n = rng.random_range(1..8);
    let mut list = String::from("///TOOL 0\n///POSTYPE PULSE\n///PULSE\n");
    for k in 0..n {
        match rng.random_range(0..6) {
            0 => list.push_str(&format!("///TOOL {}\n", rng.random_range(0..3))),
            1 => list.push_str("///POSTYPE ANGLE\n///ANGLE\n"),
            2 => list.push_str("///USER 1\n///POSTYPE USER\n///RECTAN\n///RCONF 1,0,0,0,0,0\n"),
            _ => list.push_str("///POSTYPE PULSE\n///PULSE\n"),
        }
        let pulse = list.rfind("///PULSE").unwrap_or(0)
            > list.rfind("///ANGLE").unwrap_or(0).max(list.rfind("///RECTAN").unwrap_or(0));
        let numbers: Vec<String> = (0..6)
            .map(|_| {
                if pulse {
                    format!("{}", rng.random_range(-90_000..90_000))
                } else {
                    format!("{:.4}", rng.random_range(-99.0..99.0))
                }
            })
            .collect();
        list.push_str(&format!("C{k:05}={}\n", numbers.join(",")));
    }
    let stations = rng.random_bool(0.5);
    if stations {
        list.push_str("///POSTYPE PULSE\n///PULSE\nEC00000=5,7\n");
    }
    list.push_str("P00003=1,2,3,4,5,6");
    let mut steps = String::new();
    for _ in 0..rng.random_range(1..12) {
        let c = rng.random_range(0..n);
        let ec = if stations && rng.random_bool(0.5) { " EC00000" } else { "" };
        let move_ = match rng.random_range(0..9) {
            0 => "TIMER T=0.25".into(),
            1 => "*LABEL".into(),
            2 => "'a comment MOVJ C00000".into(),
            3 => format!("MOVC C{c:05} V=12.5"),
            4 => format!("MOVJ C{c:05} VJ=25.00 +MOVJ EC00000"),
            5 => "MOVJ P003 VJ=10.00".into(),
            6 => format!("MOVJ C{c:05}{ec} VJ=25.00 PL={}", rng.random_range(0..5)),
            _ => format!("  MOVL C{c:05}{ec} V=50.0 NWAIT"),
        };
        if move_.contains("+MOVJ") && !stations {
            continue;
        }
        steps.push_str(&move_);
        steps.push('\n');
    }
    let text = job(&format!("{n},0,{},1,0,0", u8::from(stations)), &list, steps.trim_end());
    if rng.random_bool(0.3) { text.replace('\r', "") } else { text }
}

#[test]
fn damaged_jobs_are_refused_or_come_back() {
    let source = |rng: &mut ChaCha8Rng| vec![random_job(rng).into_bytes()];
    harness::survives(&Inform, &robot(), &source, &|script, rng| random_edits(script, &robot(), rng));
}

#[test]
fn the_samples_are_read_and_their_edits_come_back() {
    let robot = robot();
    let samples = harness::samples(&Inform);
    for (name, bytes) in &samples {
        assert!(Inform.recognises(bytes), "{name}");
        let doc = harness::parse(&Inform, bytes, &robot).unwrap();
        edited(&Inform, bytes, &random_edits(doc.script(), &robot, &mut generator(3)), &robot).unwrap();
    }
    assert!(samples.len() >= 6, "{} samples", samples.len());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: u32::try_from(count("PROPTEST_CASES", 256)).unwrap(), ..ProptestConfig::default() })]
    #[test]
    fn edits_come_back_when_the_job_is_read_again(seed in any::<u64>()) {
        let robot = robot();
        let mut rng = generator(seed);
        let text = random_job(&mut rng);
        let script = script_of(&Inform, &text, &robot);
        let mut edits = random_edits(&script, &robot, &mut rng);
        // a caller leaves what a variable of several moves cannot say
        for (step, _) in harness::parse(&Inform, text.as_bytes(), &robot).unwrap().unwritable(&edits) {
            edits.steps.remove(step);
        }
        let out = edited(&Inform, text.as_bytes(), &edits, &robot).unwrap();
        // all lines that no edit is about are there, in order
        let new: Vec<&[u8]> = out.split(|&b| b == b'\n').collect();
        let mut at = 0;
        for line in text.as_bytes().split(|&b| b == b'\n').filter(|l| !l.starts_with(b"C") && !l.starts_with(b"P0") && !l.contains(&b'M') && !l.starts_with(b"///NPOS")) {
            let found = new[at..].iter().position(|l| *l == line);
            prop_assert!(found.is_some(), "{:?} is gone", String::from_utf8_lossy(line));
            at += found.unwrap() + 1;
        }
    }
}
