//! What is followed along control: whether configurations are watched, and which moves end where the program reads its place.

use super::*;

const POINT: &str = "[[900,0,1000],[0.5,0,0.8660254,0],[0,0,-4,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";

fn joint_move(k: usize) -> String {
    format!("MoveAbsJ [[{k},2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\n")
}

/// A module with `main` and further routines.
fn with_routines(main: &str, routines: &str) -> String {
    format!("MODULE T\nPROC main()\n{main}\nENDPROC\n{routines}\nENDMODULE\n")
}

/// Of each move to a robtarget: `+` its configuration is followed, `-` it is not, `?` it may be.
fn watched(source: &str) -> String {
    let of = |m: Move| match m.goal {
        Goal::Pose(p) => Some(match (p.binding, p.unsure) {
            (true, true) => '?',
            (true, false) => '+',
            (false, _) => '-',
        }),
        _ => None,
    };
    moves(source).into_iter().filter_map(of).collect()
}

#[test]
fn whether_configurations_are_watched_is_followed_through_the_task() {
    let m = format!("MoveJ {POINT},v100,fine,tool0;\n");
    let sub = |name: &str, body: &str| format!("PROC {name}()\n{body}\nENDPROC\n");
    let off = sub("init", "ConfJ\\Off;");
    let on = sub("init", "ConfJ\\On;");
    let cases = [
        ("never switched", with_routines(&m, ""), "+"),
        ("before", with_routines(&format!("{m}ConfJ\\Off;\n{m}ConfJ;\n{m}ConfJ\\On;\n{m}"), ""), "+-++"),
        ("in what is called", with_routines(&format!("init;\n{m}"), &off), "-"),
        ("on again in what is called", with_routines(&format!("ConfJ\\Off;\ninit;\n{m}"), &on), "+"),
        ("in a branch", with_routines(&format!("IF a=1 ConfJ\\Off;\n{m}"), ""), "?"),
        ("in both branches", with_routines(&format!("IF a THEN\nConfJ\\Off;\nELSE\ninit;\nENDIF\n{m}"), &off), "-"),
        ("in a handler", with_routines(&format!("{m}{m}ERROR\nConfJ\\Off;\nTRYNEXT;"), ""), "??"),
        (
            "in a handler of what is called",
            {
                let error = "SetDO d1,1;\nERROR\nConfJ\\Off;\nRETURN;";
                with_routines(&format!("{m}sub;\n{m}ConfJ\\On;\n{m}"), &sub("sub", error))
            },
            "+?+",
        ),
        ("at the end of a loop", with_routines(&format!("WHILE TRUE DO\n{m}ConfJ\\Off;\n{m}ENDWHILE"), ""), "?-"),
        ("at its start", with_routines(&format!("WHILE TRUE DO\nConfJ\\Off;\n{m}ENDWHILE"), ""), "-"),
        ("called twice", with_routines("sub;\nConfJ\\Off;\nsub;\nConfJ\\On;", &sub("sub", &m)), "?"),
        ("called once", with_routines("ConfJ\\Off;\nsub;", &sub("sub", &m)), "-"),
        ("before main runs again", with_routines(&format!("{m}ConfJ\\Off;\n{m}"), ""), "?-"),
        (
            "before ExitCycle",
            with_routines(&format!("{m}sub;\nConfJ\\On;"), &sub("sub", "ConfJ\\Off;\nExitCycle;")),
            "?",
        ),
        ("by a name", with_routines(&format!("%\"init\"%;\n{m}"), &off), "?"),
        ("by another name", with_routines(&format!("%\"other\"+s%;\n{m}"), &off), "+"),
        ("by a number", with_routines(&format!("CallByVar \"in\",n;\n{m}"), &off), "?"),
        ("by a jump", with_routines(&format!("IF a GOTO l1;\nConfJ\\Off;\nl1:\n{m}"), ""), "?"),
        ("in a trap", with_routines(&m, "TRAP t\nConfJ\\Off;\nENDTRAP"), "?"),
        (
            "in what no file has",
            with_routines(&format!("Elsewhere;\n{m}ConfJ\\On;\nElsewhere;\n{m}ConfJ\\Off;"), ""),
            "??",
        ),
        ("in what is never called", with_routines(&m, &off), "+"),
        ("on straight ways alone", with_routines(&format!("ConfL\\Off;\n{m}"), ""), "+"),
        ("in a module without main", format!("MODULE T\n{}{}ENDMODULE\n", sub("a", &m), sub("b", "ConfJ\\Off;")), "?"),
    ];
    for (what, source, expected) in cases {
        assert_eq!(watched(&source), expected, "{what}");
    }
}

#[test]
fn on_straight_ways_configurations_are_followed_alike() {
    let m = format!("MoveL {POINT},v100,fine,tool0;\n");
    let of = |main: &str| watched(&with_routines(main, ""));
    assert_eq!(of(&format!("{m}ConfL\\Off;\n{m}")), "?-");
    assert_eq!(of(&format!("ConfL\\On;\n{m}IF a THEN\nConfL\\Off;\nENDIF\n{m}")), "+?");
    assert_eq!(of(&format!("ConfJ\\Off;\n{m}")), "+");
}

/// Numbers of the moves of [`joint_move`] that keep their goals.
fn kept(source: &str) -> Vec<usize> {
    let doc = document(source);
    let script = doc.script();
    let of = |m: &Move| {
        let target = script.targets.get(m.goal.target()?)?;
        let first = target.values.iter().next()??;
        m.fixed.is_some().then(|| first.si.to_degrees().round() as usize)
    };
    script.moves().filter_map(|(_, m)| of(m)).collect()
}

#[test]
fn the_move_before_a_reading_of_the_place_is_found_along_control() {
    let [a, b, c, d] = [1, 2, 3, 4].map(joint_move);
    let read = "ph:=CRobT();\n";
    let rd = "PROC rd()\nph:=CRobT();\nENDPROC\n";
    let cases: [(&str, String, &str, &[usize]); 18] = [
        ("in the text", format!("{a}{b}{read}{c}"), "", &[2]),
        ("in what is called", format!("{a}{b}rd;\n{c}"), rd, &[2]),
        ("two calls deep", format!("{a}{b}s1;\n{c}"), &format!("PROC s1()\nrd;\nENDPROC\n{rd}"), &[2]),
        ("after what is called", format!("{a}sub;\n{read}{b}"), &format!("PROC sub()\n{c}{d}ENDPROC\n"), &[4]),
        ("perhaps called", format!("{a}IF x sub;\n{read}{b}"), &format!("PROC sub()\n{c}{d}ENDPROC\n"), &[1, 4]),
        ("in the next pass", format!("FOR i FROM 1 TO 3 DO\n{read}{a}{b}ENDFOR\n{c}"), "", &[2, 3]),
        ("in the condition of a loop", format!("{a}WHILE CRobT()=p1 DO\n{b}{c}ENDWHILE\n{d}"), "", &[1, 3]),
        ("in a condition", format!("{a}{b}IF CPos()=p1 THEN\n{c}ENDIF\n{d}"), "", &[2]),
        ("after both branches", format!("{a}IF x THEN\n{b}ELSE\n{c}ENDIF\n{read}{d}"), "", &[2, 3]),
        ("after a label", format!("{a}{b}l1:\n{read}{c}{d}GOTO l1;"), "", &[2, 4]),
        ("by a name", format!("{a}{b}%\"rd\"%;\n{c}"), rd, &[2]),
        ("by a number", format!("{a}{b}CallByVar \"r\",1;\n{c}"), rd, &[2]),
        ("given back", format!("{a}{b}ph:=g();\n{c}"), "FUNC robtarget g()\nRETURN CRobT();\nENDFUNC\n", &[2]),
        ("when main runs again", format!("{read}{a}{b}"), "", &[2]),
        ("where an error strikes", format!("{a}{b}ERROR\n{read}{c}TRYNEXT;"), "", &[]),
        ("after a handler", format!("{a}SetDO d1,1;\n{read}{b}ERROR\n{c}TRYNEXT;"), "", &[1, 3]),
        ("in a trap", format!("{a}{b}"), "TRAP t\nph:=CRobT();\nENDTRAP\n", &[]),
        ("into a message", format!("{a}TPWrite \"at\"\\Pos:=CPos();\n{b}"), "", &[]),
    ];
    for (what, main, routines, expected) in cases {
        assert_eq!(kept(&with_routines(&main, routines)), expected, "{what}");
    }
    // where no file has main, what stands at the end of one routine comes before the next one
    let library = |routines: &str| format!("MODULE T\n{routines}ENDMODULE\n");
    assert_eq!(kept(&library(&format!("PROC p1()\n{a}{b}ENDPROC\n{rd}"))), [2]);
}

#[test]
fn a_displacement_by_where_the_robot_stands_reads_its_place() {
    let [a, b, c] = [1, 2, 3].map(joint_move);
    let of = |line: &str| kept(&with_routines(&format!("{a}{b}{line}\n{c}"), "PROC s()\nPDispOn p1,tool0;\nENDPROC"));
    for line in ["PDispOn p1,tool0;", "PDispOn\\Rot,p1,tool0\\WObj:=w1;", "EOffsOn p1;", "s;", "%\"s\"%;"] {
        assert_eq!(of(line), [2], "{line}");
    }
    for line in ["PDispOn\\ExeP:=p2,p1,tool0;", "EOffsOn\\ExeP:=p2,p1;", "PDispSet pose1;", "PDispOff;", "EOffsOff;"] {
        assert!(of(line).is_empty(), "{line}");
    }
}

#[test]
fn of_lines_that_differ_in_their_numbers_alone_the_last_one_is_read() {
    let lines: String = (1..=9).map(joint_move).collect();
    assert_eq!(kept(&with_routines(&format!("{lines}ph:=CRobT();\n{}", joint_move(10)), "")), [9]);
}

/// Of each move to a robtarget: whether it waits for a frame that a program displacement makes.
fn displaced(source: &str) -> String {
    let of = |m: Move| match m.goal {
        Goal::Pose(p) => Some(if p.frame == Frame::Null { '-' } else { 'd' }),
        _ => None,
    };
    moves(source).into_iter().filter_map(of).collect()
}

#[test]
fn a_program_displacement_is_followed_through_the_task() {
    let m = format!("MoveL {POINT},v100,fine,tool0;\n");
    let sub = |name: &str, body: &str| format!("PROC {name}()\n{body}\nENDPROC\n");
    let on = "PDispSet d1;\n";
    let off = "PDispOff;\n";
    let cases = [
        ("a pair", with_routines(&format!("{off}{m}{on}{m}{off}{m}"), ""), "-d-"),
        ("by where the robot stands", with_routines(&format!("{m}PDispOn\\Rot,p1,tool0;\n{m}{off}{m}"), ""), "-d-"),
        ("never off", with_routines(&format!("{m}{on}{m}"), ""), "dd"),
        ("in a branch", with_routines(&format!("IF a {on}{m}{off}{m}"), ""), "d-"),
        ("off in a branch", with_routines(&format!("{on}IF a {off}{m}{off}"), ""), "d"),
        ("in what is called", with_routines(&format!("{m}s;\n{m}{off}{m}"), &sub("s", on)), "-d-"),
        ("around a call", with_routines(&format!("{m}{on}s;\n{off}{m}"), &sub("s", &m)), "--d"),
        ("around one of two calls", with_routines(&format!("s;\n{on}s;\n{off}"), &sub("s", &m)), "d"),
        ("in a loop", with_routines(&format!("WHILE a DO\n{m}{on}{m}ENDWHILE\n{off}{m}"), ""), "dd-"),
        ("by a jump", with_routines(&format!("{on}IF a GOTO l1;\n{off}l1:\n{m}{off}{m}"), ""), "d-"),
        ("in a trap", with_routines(&format!("{off}{m}"), &format!("TRAP t\n{on}ENDTRAP\n")), "d"),
        ("in a handler", with_routines(&format!("{m}{m}ERROR\n{on}TRYNEXT;\n"), ""), "dd"),
        ("in what is loaded", with_routines(&format!("{m}%s%;\n{m}{off}{m}"), &sub("x", on)), "-d-"),
        ("in a module without main", format!("MODULE T\n{}{}ENDMODULE\n", sub("a", &m), sub("b", on)), "d"),
        (
            "in one, in pairs",
            format!("MODULE T\n{}{}ENDMODULE\n", sub("a", &m), sub("b", &format!("{on}{m}{off}"))),
            "-d",
        ),
    ];
    for (what, source, expected) in cases {
        assert_eq!(displaced(&source), expected, "{what}");
    }
}
