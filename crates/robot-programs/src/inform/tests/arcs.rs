//! Which circular steps are arcs through three positions.

use super::*;
use crate::script::Script;

const LIST: &str = "///TOOL 1\n///POSTYPE PULSE\n///PULSE\nC00000=0,0,0,0,0,0\nC00001=1000,-2000,300,0,-500,622\n\
                    C00002=2000,-1000,300,0,-500,622\nC00003=3000,-2000,300,0,-500,622\nC00004=0,0,300,0,-500,622";

fn read(instructions: &str) -> Script {
    script_of(&Inform, &job("5,0,0,0,0,0", LIST, instructions), &robot())
}

const THREE: [&str; 3] = ["MOVC C00001 V=50.0", "MOVC C00002 V=50.0 PL=3 NWAIT", "MOVC C00003 V=50.0 'end"];

fn between(before: &str, after: &str) -> String {
    format!("MOVJ C00000 VJ=25.00\n{before}{}\n{after}MOVL C00004 V=50.0", THREE.join("\n"))
}

#[test]
fn three_circular_steps_are_an_arc_to_which_the_path_is_straight() {
    let still = "DOUT OT#(1) ON\nARCON\nTIMER T=0.50\n'weld\n";
    let apart = format!("MOVL C00000 V=5.0\n{}\nMOVL C00004 V=50.0", THREE.join(&format!("\n{still}")));
    for text in [between("", ""), between(still, "JUMP *L IF IN#(1)=ON\n*L\n"), apart] {
        let script = read(&text);
        let found = moves(&script);
        let of = |name: usize| found[name].1.goal.target().unwrap();
        for (k, path) in [(1, PathKind::Linear), (2, PathKind::Curve), (3, PathKind::Curve)] {
            let m = &found[k].1;
            assert_eq!((m.path, m.circle.as_deref()), (path, Some(&[of(1), of(2), of(3)][..])), "{text}");
            assert_eq!(m.tool.as_deref(), Some(&Frame::Named("1".into())));
            assert!(m.closed.is_some());
        }
        assert!([0, 4].iter().all(|k| found[*k].1.circle.is_none()), "{text}");
    }
}

#[test]
fn more_than_three_circular_steps_are_arcs_through_all_of_them() {
    let list = format!("{LIST}\nC00005=3500,-2500,300,0,-500,622");
    let text = job("6,0,0,0,0,0", &list, &between("", "").replace("MOVL C00004", "MOVC C00005 V=50.0\nMOVL C00004"));
    let script = script_of(&Inform, &text, &robot());
    let found = moves(&script);
    let targets: Vec<usize> = (1..5).map(|k| found[k].1.goal.target().unwrap()).collect();
    for k in 1..5 {
        assert_eq!(found[k].1.circle.as_deref(), Some(&targets[..]));
        assert_eq!(found[k].1.path, if k == 1 { PathKind::Linear } else { PathKind::Curve });
    }
    assert!(found[5].1.circle.is_none());
}

#[test]
fn what_is_not_plain_about_circular_steps_leaves_their_path_unknown() {
    let [one, two, three] = THREE;
    for group in [
        format!("{one}\n{two}"),
        format!("{one}\n*L\n{two}\n{three}"),
        format!("{one}\nCALL JOB:A\n{two}\n{three}"),
        format!("{one}\nJUMP *L IF IN#(1)=ON\n{two}\n{three}\n*L"),
        format!("{one}\n{two} FPT\n{three}"),
        format!("{one}\n{two}\nMOVC C00003 V=50.0 UNTIL IN#(1)=ON"),
        format!("{one}\n{two}\n{three}\n+MOVJ EC00000 VJ=5.0"),
        format!("{one}\nMOVC C00001 V=50.0\n{three}"),
        format!("WVON WEV#(1)\n{one}\n{two}\n{three}\nWVOF"),
        format!("{one}\nWVON WEV#(1)\n{two}\n{three}\nWVOF"),
        format!("MOVS C00004 V=50.0\n{one}\n{two}\n{three}"),
        format!("*L\n{one}\n{two}\n{three}"),
        format!("{one}\nSMOVC C00002 V=50.0\n{three}"),
        format!("{one}\nMOVC P001 V=50.0\n{three}"),
        format!("{one}\n{two}\n{three}\nCALL JOB:A"),
        format!("{one}\n{two}\n*REMOVE\n{three}"),
        format!("{one}\n{two}\n{three}\nJUMP *L IF IN#(1)=ON\nMOVL C00004 V=50.0\n*L MOVL C00004 V=50.0"),
        format!("{one}\n{two}\n{three}\nJUMP *L IF IN#(1)=ON\nMOVL C00004 V=50.0\n*L\nCALL I001\nMOVL C00004 V=50.0"),
        format!("{one}\n{two}\n{three}\nJUMP *L IF IN#(1)=ON\nMOVL C00004 V=50.0\n*L\nSMOVS C00001 V=50.0"),
        format!("{one}\n{two}\n{three}\nJUMP JOB:A IF IN#(1)=ON"),
        format!("{one}\n{two}\n{three}\nJUMP *L IF IN#(1)=ON\nMOVL C00004 V=50.0\n*L\nMOVC C00001 V=50.0"),
    ] {
        let script = read(&format!("MOVJ C00000 VJ=25.00\n{group}\nMOVL C00004 V=50.0"));
        for (_, m) in moves(&script).into_iter().filter(|m| !matches!(m.1.path, PathKind::Joint)) {
            assert!(m.circle.is_none(), "{group}");
        }
        let curves = moves(&script).iter().filter(|m| m.1.path == PathKind::Curve).count();
        assert_eq!(curves, group.matches("MOVC ").count() + group.matches("MOVS ").count(), "{group}");
    }
}

#[test]
fn an_arc_has_one_tool_and_joint_values() {
    let own = |line: &str| LIST.replace("C00003=", line);
    for list in [
        own("///TOOL 2\nC00003="),
        own("///POSTYPE ROBOT\n///RECTAN\nC00003="),
        own("///POSTYPE ANGLE\n///ANGLE\nC00003="),
    ] {
        let script = script_of(&Inform, &job("5,0,0,0,0,0", &list, &between("", "")), &robot());
        let arcs = moves(&script).iter().filter(|m| m.1.circle.is_some()).count();
        // degrees and pulses are both joint values
        assert_eq!(arcs, if list.contains("///ANGLE") { 3 } else { 0 }, "{list}");
    }
}
