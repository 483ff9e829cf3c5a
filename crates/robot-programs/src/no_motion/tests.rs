//! What the user says to move nothing, in every language with calls: what it settles, and what it does not.

use super::NoMotion;
use crate::axes::Axes;
use crate::fixtures::{irb1600, kr120, m10ia, ma2010, ur10};
use crate::script::harness::kinds;
use crate::script::{Document, Format, Goal, Script, Text};

/// A program with others beside it: name and bytes of each.
fn read(format: &dyn Format, mut robot: Axes, said: &[&str], texts: &[(&str, String)]) -> Box<dyn Document> {
    robot.no_motion = NoMotion::of(said.iter().copied());
    let text = |(k, (name, source)): (usize, &(&str, String))| match k {
        0 => Text::new(*name, source.clone().into_bytes()),
        _ if name.ends_with("p.dat") => Text::new(*name, source.clone().into_bytes()),
        _ => Text::of_context(*name, source.clone().into_bytes()),
    };
    format.parse(texts.iter().enumerate().map(text).collect(), &robot).unwrap()
}

/// Kinds of the steps between the first two moves.
fn between(script: &Script) -> Vec<String> {
    let kinds = kinds(script);
    let moves: Vec<usize> = (0..kinds.len()).filter(|k| kinds[*k] == "move").collect();
    kinds[moves[0] + 1..moves[1]].to_vec()
}

/// Names that unknown calls wait for.
fn asked(script: &Script) -> Vec<&str> {
    script.unknown_calls.values().flatten().map(String::as_str).collect()
}

fn notes(script: &Script) -> String {
    script.notes.iter().map(|n| n.text.as_str()).collect::<Vec<_>>().join("\n")
}

/// Why the goal of the last move cannot be determined.
fn last_goal(script: &Script) -> String {
    match &script.moves().last().unwrap().1.goal {
        Goal::Opaque(why) => why.to_string(),
        _ => "known".into(),
    }
}

fn tp(name: &str, lines: &str) -> String {
    let lines: String = lines.lines().enumerate().map(|(k, l)| format!("{:4}:  {l} ;\n", k + 1)).collect();
    let joints = "\tJ1=    10.000 deg,\tJ2=   -20.000 deg,\tJ3=    30.000 deg,\n\tJ4=     0.000 deg,\tJ5=   -60.000 deg,\tJ6=     0.000 deg\n};\n";
    let position = |n: u32| format!("P[{n}]{{\n   GP1:\n\tUF : 0, UT : 1,\t\n{joints}");
    format!("/PROG  {name}\n/ATTR\n/MN\n{lines}/POS\n{}{}/END\n", position(1), position(2))
}

fn fanuc(line: &str, said: &[&str], beside: &[(&'static str, &str)]) -> Script {
    let own = ("p.ls", tp("P", &format!("J P[1] 100% FINE\n{line}\nJ P[2] 100% FINE")));
    let others = beside.iter().map(|(name, lines)| (*name, tp(name.trim_end_matches(".LS"), lines)));
    let texts: Vec<_> = std::iter::once(own).chain(others).collect();
    read(&crate::fanuc::Fanuc, m10ia(), said, &texts).script().clone()
}

#[test]
fn a_macro_and_a_program_of_fanuc_that_are_declared_end_nothing() {
    for (line, name) in [
        ("Clear User Page", "CLEAR USER PAGE"),
        ("CALL GRIP_KL(1,R[2])", "GRIP_KL"),
        ("IF R[1]=1,CALL GRIP_KL", "GRIP_KL"),
        ("OPEN HAND(2)", "OPEN HAND"),
        ("WAIT HOME", "WAIT HOME"),
    ] {
        let unknown = fanuc(line, &[], &[]);
        assert_eq!((between(&unknown), asked(&unknown)), (vec!["Call".to_string()], vec![name]), "{line}");
        let known = fanuc(line, &[&name.to_lowercase()], &[]);
        assert!(between(&known).iter().all(|k| k == "dwell None") && asked(&known).is_empty(), "{line}");
        assert!(notes(&known).contains(&format!("{name} moves nothing and leaves frames")), "{}", notes(&known));
        // another name, and `_` for a blank
        let other = name.replace(' ', "_") + "2";
        assert_eq!(between(&fanuc(line, &[&other], &[])), ["Call"], "{line}");
    }
    assert_eq!(between(&fanuc("OPEN HAND", &["OPEN_HAND"], &[])), ["Call"]);
}

#[test]
fn a_declared_name_that_is_a_label_a_register_or_part_of_a_line_settles_nothing() {
    for (line, said) in [
        ("CALL SR[1]", "SR"),
        ("RUN GRIP", "GRIP"),
        ("UFRAME[1:GRIP]=PR[1]", "GRIP"),
        ("CALL MOVER ! GRIP", "GRIP"),
        ("OPEN HAND GRIP", "GRIP"),
        ("Arc Start[1:GRIP]", "GRIP"),
        ("Touch Offset PR[1:GRIP]", "GRIP"),
    ] {
        assert_eq!(between(&fanuc(line, &[said], &[])), between(&fanuc(line, &[], &[])), "{line}");
    }
}

#[test]
fn a_file_goes_before_what_is_said_of_its_name() {
    let moves = ("GRIP.LS", "J P[1] 100% FINE");
    for (line, said) in [("CALL GRIP", "GRIP"), ("GRIP", "grip"), ("GRIP(1)", "GRIP")] {
        let script = fanuc(line, &[said], &[moves]);
        assert_eq!(between(&script), ["Call"], "{line}");
        assert!(notes(&script).contains("GRIP is declared to move nothing"), "{line}: {}", notes(&script));
        assert!(asked(&script).is_empty(), "{line}");
    }
    // a macro of several words runs a program of one, and a file may hold a program of another name
    assert_eq!(between(&fanuc("Open Hand", &["Open Hand"], &[("OPEN_HAND.LS", "J P[1] 100% FINE")])), ["Call"]);
    let texts = [
        ("p.ls", tp("P", "J P[1] 100% FINE\nCALL GRIP\nJ P[2] 100% FINE")),
        ("GRIP.LS", tp("OTHER", "J P[1] 100% FINE")),
    ];
    let script = read(&crate::fanuc::Fanuc, m10ia(), &["GRIP"], &texts).script().clone();
    assert_eq!(between(&script), ["Call"]);
    // one whose text calls what is declared moves nothing, and without that asks for it
    let through = [("TEXT.LS", "Clear User Page\nDO[1]=ON")];
    assert_eq!(asked(&fanuc("CALL TEXT", &[], &through)), ["CLEAR USER PAGE"]);
    let known = fanuc("CALL TEXT", &["clear user page"], &through);
    assert_eq!(between(&known), ["dwell None"]);
    assert!(notes(&known).contains("CLEAR USER PAGE moves nothing") && notes(&known).contains("the program TEXT"));
    // it moves whatever that does
    let both = [("TEXT.LS", "Clear User Page\nJ P[1] 100% FINE")];
    let still = fanuc("CALL TEXT", &["clear user page"], &both);
    assert!(between(&still) == ["Call"] && asked(&fanuc("CALL TEXT", &[], &both)).is_empty());
}

#[test]
fn the_file_of_a_macro_is_looked_up_as_that_of_a_call_is() {
    let folder = std::env::temp_dir().join(format!("lostmotion-macro-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    for (name, lines) in [("MAIN.LS", "Open Hand(1)"), ("OPEN_HAND.LS", "J P[1] 100% FINE"), ("HAND.LS", "R[1]=1")] {
        std::fs::write(folder.join(name), tp("X", lines)).unwrap();
    }
    let found = crate::fanuc::Fanuc.context(&folder.join("MAIN.LS"), &crate::files::Folders::default(), &m10ia());
    assert_eq!(found, [folder.join("OPEN_HAND.LS")]);
    let job = |line: &str| format!("/JOB\r\n//NAME X\r\n//INST\r\nNOP\r\n{line}\r\nEND\r\n");
    std::fs::write(folder.join("MAIN.JBI"), job("VACUUM ARGF1")).unwrap();
    std::fs::write(folder.join("VACUUM.JBI"), job("NOP")).unwrap();
    let found = crate::inform::Inform.context(&folder.join("MAIN.JBI"), &crate::files::Folders::default(), &m10ia());
    assert_eq!(found, [folder.join("VACUUM.JBI")]);
    std::fs::remove_dir_all(&folder).unwrap();
}

fn krl(lines: &str, more: &str, said: &[&str], beside: &[(&'static str, &str)]) -> Script {
    let at = "PTP {A1 1.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}\n";
    let own = format!("DEF p( )\n{at}{lines}\nPTP XP1\nEND\n{more}");
    let list = "DEFDAT p\nDECL E6AXIS XP1={A1 2.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}\nENDDAT\n";
    let texts = [("p.src", own), ("p.dat", list.to_string())];
    let others = beside.iter().map(|(n, t)| (*n, (*t).to_string()));
    read(&crate::krl::Krl, kr120(), said, &texts.into_iter().chain(others).collect::<Vec<_>>()).script().clone()
}

#[test]
fn a_routine_of_krl_that_is_declared_ends_nothing_and_may_still_change_what_it_is_given() {
    for line in ["GRIP_SET(1,TRUE)", "IF GRIP_SET(1) THEN\nn=1\nENDIF", "n=GRIP_SET(2)"] {
        let unknown = krl(line, "", &[], &[]);
        assert!(between(&unknown).contains(&"Call".to_string()), "{line}");
        assert!(asked(&unknown).iter().all(|n| *n == "GRIP_SET") && !asked(&unknown).is_empty(), "{line}");
        let known = krl(line, "", &["grip_set"], &[]);
        assert!(between(&known).iter().all(|k| k == "dwell None"), "{line}: {:?}", between(&known));
        assert!(notes(&known).contains("GRIP_SET moves nothing and leaves frames"), "{}", notes(&known));
    }
    assert_eq!(last_goal(&krl("GRIP_SET(1)", "", &["GRIP_SET"], &[])), "known");
    // passed on, the point may be another one
    let passed = krl("GRIP_SET(XP1)", "", &["GRIP_SET"], &[]);
    assert!(last_goal(&passed).contains("GRIP_SET"), "{}", last_goal(&passed));
    // a routine of the program, or of another module, counts
    let mover = "DEF GRIP_SET(n:IN)\nINT n\nPTP {A1 5}\nEND\n";
    for script in
        [krl("GRIP_SET(1)", mover, &["GRIP_SET"], &[]), krl("GRIP_SET(1)", "", &["GRIP_SET"], &[("g.src", mover)])]
    {
        assert_eq!(between(&script), ["Call"]);
        assert!(notes(&script).contains("GRIP_SET is declared to move nothing"), "{}", notes(&script));
    }
    // a label or variable of that name is no call
    for line in ["GRIP_SET:", "IF n>1 THEN\nGRIP_SET:\nENDIF"] {
        assert_eq!(between(&krl(line, "", &["GRIP_SET"], &[])), between(&krl(line, "", &[], &[])), "{line}");
    }
    // through a routine of the program
    let helper = "DEF helper( )\nGRIP_SET(1)\nEND\n";
    assert_eq!(asked(&krl("helper()", helper, &[], &[]))[..1], ["GRIP_SET"]);
    assert_eq!(between(&krl("helper()", helper, &["GRIP_SET"], &[])), ["dwell None"]);
}

fn rapid(lines: &str, more: &str, said: &[&str], beside: &[(&'static str, &str)]) -> Script {
    let joints = "[[10,20,30,40,50,60],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    let own = format!(
        "MODULE T\nCONST jointtarget j1:={joints};\nPERS jointtarget j2:={joints};\nPROC main()\nMoveAbsJ j1,v100,fine,tool0;\n{lines}\n\
         MoveAbsJ j2,v100,fine,tool0;\nENDPROC\n{more}\nENDMODULE\n"
    );
    let others = beside.iter().map(|(n, t)| (*n, (*t).to_string()));
    let texts: Vec<_> = std::iter::once(("own.mod", own)).chain(others).collect();
    read(&crate::rapid::Rapid, irb1600(), said, &texts).script().clone()
}

#[test]
fn a_routine_of_rapid_that_is_declared_ends_nothing_and_may_still_change_what_it_is_given() {
    for line in ["GripSet 1;", "IF GripSet(1) THEN\nx:=1;\nENDIF", "x:=GripSet(2);", "IF a=1 GripSet 2;"] {
        let unknown = rapid(line, "", &[], &[]);
        assert!(between(&unknown).contains(&"Call".to_string()), "{line}: {:?}", between(&unknown));
        assert_eq!(asked(&unknown), ["gripset"], "{line}");
        let known = rapid(line, "", &["GRIPSET"], &[]);
        assert!(between(&known).iter().all(|k| k == "dwell None"), "{line}: {:?}", between(&known));
        assert!(notes(&known).contains("gripset moves nothing and leaves frames"), "{}", notes(&known));
    }
    assert_eq!(last_goal(&rapid("GripSet 1;", "", &["gripset"], &[])), "known");
    let passed = rapid("GripSet j2;", "", &["gripset"], &[]);
    assert!(last_goal(&passed).contains("GripSet"), "{}", last_goal(&passed));
    let mover = "PROC GripSet(num n)\nMoveAbsJ j1,v10,fine,tool0;\nENDPROC";
    let own = rapid("GripSet 1;", mover, &["gripset"], &[]);
    assert!(between(&own) == ["Call"] && notes(&own).contains("gripset is declared to move nothing"));
    // a file beside it that is of no certain task
    let beside = format!("MODULE G\nPROC main()\nENDPROC\n{mover}\nENDMODULE\n");
    let left_out = rapid("GripSet 1;", "", &["gripset"], &[("g.mod", &beside)]);
    assert!(between(&left_out) == ["Call"] && notes(&left_out).contains("gripset is declared"), "{}", notes(&left_out));
    // instructions of the language are what they are
    assert!(between(&rapid("PDispOff;", "", &["pdispoff"], &[])).contains(&"Frame".to_string()));
    assert_eq!(between(&rapid("gripset:", "", &["gripset"], &[])), ["Jump"]);
    assert_eq!(between(&rapid("%name%;", "", &["name"], &[])), ["Call"]);
    let helper = "PROC helper()\nGripSet 1;\nENDPROC";
    assert_eq!(asked(&rapid("helper;", helper, &[], &[]))[..1], ["gripset"]);
    assert!(!between(&rapid("helper;", helper, &["gripset"], &[])).contains(&"Call".to_string()));
}

fn inform(line: &str, said: &[&str], beside: &[(&'static str, &str)]) -> Script {
    let list = "///NPOS 1,0,0,1,0,0\r\n///TOOL 0\r\n///POSTYPE PULSE\r\n///PULSE\r\nC00000=0,0,0,0,0,0\r\nP00001=1000,0,0,0,0,0\r\n";
    let own = format!(
        "/JOB\r\n//NAME TEST\r\n//POS\r\n{list}//INST\r\n///GROUP1 RB1\r\nNOP\r\nMOVJ C00000 VJ=5.00\r\n{line}\r\nMOVJ P001 VJ=5.00\r\nEND\r\n"
    );
    let job = |name: &str, lines: &str| {
        format!("/JOB\r\n//NAME {name}\r\n//POS\r\n///NPOS 0,0,0,0,0,0\r\n//INST\r\nNOP\r\n{lines}\r\nEND\r\n")
    };
    let others = beside.iter().map(|(name, lines)| (*name, job(name.trim_end_matches(".JBI"), lines)));
    let texts: Vec<_> = std::iter::once(("TEST.JBI", own)).chain(others).collect();
    read(&crate::inform::Inform, ma2010(None), said, &texts).script().clone()
}

#[test]
fn a_job_and_a_macro_of_inform_that_are_declared_end_nothing_and_leave_position_variables_uncertain() {
    for (line, name) in
        [("CALL JOB:VACUUM", "VACUUM"), ("VACUUM ARGF1", "VACUUM"), ("CALL JOB:VACUUM IF B000=1", "VACUUM")]
    {
        let unknown = inform(line, &[], &[]);
        assert_eq!((between(&unknown), asked(&unknown)), (vec!["Call".to_string()], vec![name]), "{line}");
        let known = inform(line, &["vacuum"], &[]);
        assert_eq!(between(&known), ["dwell None"], "{line}");
        assert!(notes(&known).contains("VACUUM moves nothing and leaves frames"), "{}", notes(&known));
        // it may set the variable
        assert!(last_goal(&known).contains("may be changed at run time"), "{line}: {}", last_goal(&known));
        let moves = [("VACUUM.JBI", "MOVJ C00000 VJ=5.00")];
        let counts = inform(line, &["VACUUM"], &moves);
        assert_eq!(between(&counts), ["Call"], "{line}");
        assert!(notes(&counts).contains("VACUUM is declared to move nothing"), "{}", notes(&counts));
    }
    for (line, said) in [("*VACUUM", "VACUUM"), ("SETTOOL TL#(1) P001", "SETTOOL"), ("FOO UF#(1) P001", "FOO")] {
        assert_eq!(between(&inform(line, &[said], &[])), between(&inform(line, &[], &[])), "{line}");
    }
}

fn urscript(lines: &str, more: &str, said: &[&str]) -> Script {
    let q = "[0.1, -1.5, 1.2, -2, .5, 3.]";
    let source = format!("{more}def p():\n movej({q})\n{lines}\n movej({q})\nend\n");
    read(&crate::urscript::UrScript, ur10(), said, &[("p.script", source)]).script().clone()
}

#[test]
fn a_function_of_urscript_that_is_declared_ends_nothing() {
    for line in [" rg_grip(50, 40)", " x = rg_grip(1)", " if rg_grip(1):\n  textmsg(\"a\")\n end"] {
        let unknown = urscript(line, "", &[]);
        assert!(between(&unknown).contains(&"Call".to_string()), "{line}");
        assert_eq!(asked(&unknown), ["rg_grip"], "{line}");
        let known = urscript(line, "", &["rg_grip"]);
        assert!(between(&known).iter().all(|k| k == "dwell None"), "{line}: {:?}", between(&known));
        assert!(notes(&known).contains("rg_grip moves nothing and leaves frames"), "{}", notes(&known));
        // case counts in this language
        assert!(between(&urscript(line, "", &["RG_GRIP"])).contains(&"Call".to_string()), "{line}");
    }
    let own = urscript(" rg_grip(1)", "def rg_grip(n):\n movej([0,0,0,0,0,n])\nend\n", &["rg_grip"]);
    assert!(notes(&own).contains("rg_grip is declared to move nothing"), "{}", notes(&own));
    let run = between(&urscript(" t = run rg_grip()", "", &["rg_grip"]));
    assert!(run.contains(&"Interrupt".to_string()), "{run:?}");
    for (line, said) in [(" force_mode(1)", "force_mode"), (" set_tcp(x)", "set_tcp")] {
        assert_eq!(between(&urscript(line, "", &[said])), between(&urscript(line, "", &[])), "{line}");
    }
}
