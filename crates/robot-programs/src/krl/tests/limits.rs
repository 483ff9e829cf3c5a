//! What is refused, and what large and hostile files cost.

use super::*;

#[test]
fn files_that_cannot_be_are_refused_with_their_place() {
    assert!(refusal("DEFDAT a\nDECL E6AXIS XA={A1 5.0}\nENDDAT\n").contains("give the .src"));
    assert!(refusal("PTP {A1 1}\n").contains("no routine"));
    let bad = |line: &str| refusal(&format!("DEF a()\n{line}\nEND\n"));
    assert!(bad("PTP {A1 1.0").contains("p.src:2:5"));
    assert!(bad("PTP {A1 1.0,A1 2.0}").contains("a second `A1`"));
    assert!(bad("PTP {A1 1.0,X 2.0}").contains("`X`"));
    assert!(bad("PTP {A1 1..5}").contains("`1..5`"), "{}", bad("PTP {A1 1..5}"));
    assert!(bad("PTP {5}").contains("the name of a component"));
    assert!(Krl.recognises(LITERALS) && Krl.recognises(LOGIC[1]) && !Krl.recognises(b"def prog():\n movej([1])\nend"));
    assert!(!Krl.recognises(b"A1_deg,A2_deg\n1,2\n"));
}

#[test]
fn the_data_list_is_found_whatever_its_case() {
    let folder = std::env::temp_dir().join(format!("lostmotion-krl-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("Weld.DAT"), "DEFDAT Weld\nENDDAT\n").unwrap();
    assert_eq!(Krl.companions(&folder.join("weld.SRC"), &Files::Disk), [folder.join("Weld.DAT")]);
    assert!(Krl.companions(&folder.join("none.src"), &Files::Disk).is_empty());
    #[cfg(unix)]
    {
        use std::os::unix::ffi::OsStrExt;
        let named = |ending: &[u8]| folder.join(std::ffi::OsStr::from_bytes(&[b"n\xe4", ending].concat()));
        std::fs::write(named(b".dat"), "DEFDAT N\nENDDAT\n").unwrap();
        std::fs::write(named(b"x.dat"), "DEFDAT N\nENDDAT\n").unwrap();
        assert_eq!(Krl.companions(&named(b".src"), &Files::Disk), [named(b".dat")]);
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_large_program_is_read_in_linear_time() {
    let mut src = String::from("DEF big()\n");
    let mut dat = String::from("DEFDAT big\n");
    for n in 0..50_000 {
        src += &format!("PTP XP{} C_PTP\n", n / 2);
        if n % 2 == 0 {
            dat += &format!("DECL E6AXIS XP{}={{A1 {}.5,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}}\n", n / 2, n % 100);
        }
    }
    let start = std::time::Instant::now();
    let d = doc(&[(src + "END\n").as_bytes(), (dat + "ENDDAT\n").as_bytes()]);
    let m = moves(d.as_ref());
    let half: Vec<_> = m.iter().step_by(2).map(|m| (m.0, 0.01)).collect();
    rewrite(d.as_ref(), &edits(d.as_ref(), &half, &[m[5].0]));
    // one point, and every motion wants it elsewhere
    let src = format!("DEF a()\n{}PTP {{A1 1}}\nEND\n", "PTP XA\n".repeat(20_000));
    let d = doc(&[src.as_bytes(), b"DEFDAT a\nDECL E6AXIS XA={A1 5.0}\nENDDAT\n"]);
    let m = moves(d.as_ref());
    let apart: Vec<_> = m[..20_000].iter().enumerate().map(|(i, m)| (m.0, i as f64 * 1e-3)).collect();
    rewrite(d.as_ref(), &edits(d.as_ref(), &apart, &[]));
    assert!(start.elapsed().as_secs() < 60);
}

#[test]
fn a_hostile_megabyte_ends_quickly() {
    let start = std::time::Instant::now();
    for piece in ["{", "(", "X(", "A1 1,", "[", ";", "1.", "\nPTP XA", "\n;FOLD PTP A", "\nXA=", "XA,", "\""] {
        let body = piece.repeat(1_000_000 / piece.len());
        for text in
            [format!("DEF a()\nPTP {{{body}}}\n{body}\nEND\n"), format!("DEF a()\nDECL E6AXIS XA={{{body}}}\nEND\n")]
        {
            let _ = parse(&[text.as_bytes()]);
        }
        let _ = parse(&[format!("DEF a()\nDECL E6AXIS XA\n{body}\nEND\n").as_bytes()]);
    }
    assert!(start.elapsed().as_secs() < 60);
}

#[test]
fn a_line_that_reads_the_place_many_times_is_read_in_time() {
    let began = std::time::Instant::now();
    let sum = vec!["$POS_ACT.X"; 60_000].join("+");
    let text = format!("DEF A( )\nPTP {{A1 0,A2 -90,A3 90,A4 0,A5 0,A6 0}}\nX={sum}\nPTP {{A1 5}}\nEND\n");
    assert_eq!(moves(doc(&[text.as_bytes()]).as_ref()).len(), 2);
    assert!(began.elapsed().as_secs() < 30, "{:?}", began.elapsed());
}
