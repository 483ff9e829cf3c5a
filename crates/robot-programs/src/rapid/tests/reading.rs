//! The text as it is: comments, headers, several modules in a file, and what is refused.

use super::*;

#[test]
fn comments_and_strings_are_no_statements() {
    let body = "TPWrite \"Achtung! MoveAbsJ j1,v100,fine,tool0; \"\"x\"\"\";\n! MoveAbsJ j1,v100,fine,tool0;\nMoveAbsJ j1, ! here [[9\n   v100,\n   fine,tool0;";
    let source = program(J, body);
    assert_eq!(moves(&source).len(), 1);
    let out = rewritten(&source, &inserted(&source, 0, 0.5, 0.5, 0.01));
    assert!(
        out.contains(
            "MoveAbsJ [[0.5000,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]], v100, fine, tool0;\nMoveAbsJ j1, ! here [[9\n"
        ),
        "{out}"
    );
}

#[test]
fn several_statements_on_one_line_stay_on_it() {
    let source = program(J, "SetDO d,1; MoveAbsJ j1,v100,fine,tool0; SetDO d,0;");
    let out = rewritten(&source, &inserted(&source, 0, 0.5, 0.5, 0.01));
    assert!(
        out.contains(
            "SetDO d,1; MoveAbsJ [[0.5000,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0; MoveAbsJ j1,v100"
        ),
        "{out}"
    );
}

#[test]
fn headers_line_endings_and_foreign_bytes_pass() {
    let mut source = b"%%%\r\n  VERSION:1\r\n  LANGUAGE:ENGLISH\r\n%%%\r\nMODULE M(SYSMODULE,NOSTEPIN)\r\n".to_vec();
    source.extend_from_slice(b"  ! gr\xFC\xDFe \x80\r\n  PROC p()\r\n    MoveAbsJ [[10,20,30,40,50,60],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\r\n  ENDPROC\r\nENDMODULE");
    let doc = harness::parse(&Rapid, &source, &robot()).unwrap();
    let mut edits = Edits { digit: vec![1e-6; 6], ..Edits::default() };
    let point = NewPoint { q: vec![0.1; 6], share: 0.5, t_s: None, clearance_m: 1.0, of_way: false, waits: false };
    edits.steps.insert(1, Edit { before: vec![point], ..Edit::default() });
    let out = text::apply(&doc.script().texts, &doc.patches(&edits).unwrap()).unwrap().remove(0);
    assert_eq!(out.iter().filter(|&&b| b == b'\n').count(), source.iter().filter(|&&b| b == b'\n').count() + 1);
    assert!(out.windows(2).filter(|w| w[1] == b'\n').all(|w| w[0] == b'\r'));
    assert!(out.windows(4).any(|w| w == b"gr\xFC\xDF"));
}

#[test]
fn a_compact_if_holds_one_statement_and_its_condition_may_be_anything() {
    let body = "IF a=1 AND NOT (b<>2 OR TestDI(x)) MoveAbsJ j1,v100,fine,tool0;\nIF n{2}>-1 Set d;\nIF ok %name%;";
    assert_eq!(kinds(&program(J, body)), ["Start", "Jump", "move", "Jump", "Jump", "Call", "Jump"]);
}

#[test]
fn several_modules_may_stand_in_one_file() {
    let source = format!(
        "MODULE A\n{J}\nLOCAL {}\nENDMODULE\nMODULE B\nPROC main()\nMoveAbsJ j1,v1,fine,tool0;\nMoveAbsJ j2,v1,fine,tool0;\nENDPROC\nENDMODULE",
        J.replace("j1", "j2")
    );
    let all = moves(&source);
    assert!(matches!(all[0].goal, Goal::Joints(_)) && opaque(&all[1]).contains("another module"));
}

#[test]
fn text_that_is_no_rapid_is_refused_with_its_place() {
    let cases = [
        ("", "1:1: found no module"),
        ("PROC main()\nENDPROC", "1:1: found `PROC`"),
        (
            "MODULE M\nPROC main()\nMoveAbsJ j1,v100,fine,tool0\nENDPROC\nENDMODULE",
            "4:1: found `ENDPROC`; expected `;`",
        ),
        ("MODULE M\nPROC main()\nTPWrite \"x;\nENDPROC", "3:9: found a string"),
        ("MODULE M\nPROC main()\nSet d;\n", "4:1: found the end of the file"),
        ("%%%\nVERSION:1\nMODULE M", "1:1: found a header"),
        ("MODULE M\n\u{1}\nENDMODULE", "2:1: found the character"),
    ];
    for (source, message) in cases {
        let found = harness::parse(&Rapid, source.as_bytes(), &robot()).err().unwrap().to_string();
        assert!(found.contains(message), "{source:?}: {found}");
    }
}

#[test]
fn a_module_is_recognised_behind_its_header_and_comments_and_modula_is_not() {
    assert!(Rapid.recognises(b"%%%\n VERSION:1\n%%%\n\n! x\nMODULE Main"));
    assert!(Rapid.recognises(b"  module m(SYSMODULE)\n"));
    assert!(!Rapid.recognises(b"MODULE Foo;\n") && !Rapid.recognises(b"a1_deg,a2_deg\n1,2\n"));
}

/// Anything that grows with the square of the length would take hours here.
#[test]
fn deep_nesting_and_long_files_are_read() {
    let deep = program("", &format!("MoveAbsJ {},v1,fine,tool0;", "[".repeat(200_000)));
    assert!(opaque(&moves(&deep)[0]).contains("expression"));
    let ifs = program("", &"IF a THEN WaitTime 1;\n".repeat(100_000));
    assert!(kinds(&ifs).len() > 100_000);
    let long = program(J, &format!("{INLINE}\n").repeat(50_000));
    assert_eq!(document(&long).script().steps.len(), 50_001);
}

#[test]
fn names_that_differ_in_a_letter_of_latin_1_are_different() {
    let target = |j1: &str| format!("[[{j1},0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]]");
    let source = |moves: &str| {
        let declared =
            format!("CONST jointtarget j\u{e4}:={};CONST jointtarget j\u{f6}:={};", target("10"), target("20"));
        let text = program(&declared, moves);
        // as controllers write it: a byte a letter
        text.chars().map(|c| c as u8).collect::<Vec<u8>>()
    };
    let goals = |moves: &str| {
        let doc = harness::parse(&Rapid, &source(moves), &robot()).unwrap();
        let script = doc.script();
        let first = |m: &Move| match m.goal {
            Goal::Joints(t) => script.targets.get(t).unwrap().values.get(0).map(|v| v.si.to_degrees().round()),
            _ => None,
        };
        script.moves().map(|(_, m)| first(m)).collect::<Vec<Option<f64>>>()
    };
    let to = |name: &str| format!("MoveAbsJ {name},v300,fine,tool0;");
    assert_eq!(goals(&(to("j\u{e4}") + &to("j\u{f6}"))), [Some(10.0), Some(20.0)]);
    // in capitals it is the same name; one that nothing declares is none of them
    assert_eq!(goals(&(to("J\u{c4}") + &to("j\u{fc}"))), [Some(10.0), None]);
}

#[test]
fn a_time_may_stand_behind_a_comma_of_its_own() {
    let source = program(J, "MoveAbsJ j1, v100, \\T:=2, z10, tool0;");
    assert_eq!((moves(&source)[0].speed, moves(&source)[0].blend_m), (Speed::Seconds(2.0), Some(0.01)));
    let out = rewritten(&source, &inserted(&source, 0, 0.5, 0.5, 0.01));
    assert!(out.contains("v100, \\T:=1.0000, z0, tool0;\nMoveAbsJ j1, v100, \\T:=1.0000, z10"), "{out}");
}
