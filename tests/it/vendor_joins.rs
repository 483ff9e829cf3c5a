//! Branches, labels and the ends of blocks: what follows is edited where every way that leads there comes from the same side.

use crate::support::bundled;
use crate::vendor_loops::{desk, program, rewritten, to};
use crate::vendor_rewrite::Desk;

pub fn all(list: &[i32]) -> String {
    list.iter().map(|deg| to(*deg)).collect()
}

#[test]
fn both_branches_go_on_from_where_the_condition_is_looked_at() {
    let desk = desk();
    // the branches lead to 5 and 15: both come down to 3, but not to 10
    for (last, by_last) in [(3, -1), (10, 0), (30, 1)] {
        let body =
            format!("{}IF di1=1 THEN\n{}ELSE\n{}ENDIF\n{}", all(&[0, 10]), all(&[0, 5]), all(&[20, 15]), to(last));
        let (by, said) = rewritten(&desk, &program(&body));
        assert_eq!(by, [1, 1, -1, 1, 1, -1, by_last], "{last}: {said}");
    }
}

#[test]
fn without_a_branch_for_all_else_the_way_around_the_branches_counts() {
    let desk = desk();
    for (last, by_last) in [(3, -1), (7, 0), (30, 1)] {
        let body = format!("{}IF di1=1 THEN\n{}ENDIF\n{}", all(&[0, 10]), all(&[0, 5]), to(last));
        assert_eq!(rewritten(&desk, &program(&body)).0, [1, 1, -1, 1, by_last], "{last}");
        let body = format!(
            "{}TEST i\nCASE 1:\n{}CASE 2,3:\n{}ENDTEST\n{}",
            all(&[0, 10]),
            all(&[0, 5]),
            all(&[20, 5]),
            to(last)
        );
        assert_eq!(rewritten(&desk, &program(&body)).0, [1, 1, -1, 1, 1, -1, by_last], "{last}");
    }
}

#[test]
fn conditions_that_may_move_the_robot_end_what_is_known() {
    let desk = desk();
    let body = format!("{}IF ask() THEN\n{}ENDIF\n{}", all(&[0, 10]), all(&[0, 5]), to(3));
    let ask = format!("Stop;\nENDPROC\nFUNC bool ask()\n{}RETURN TRUE;\nENDFUNC\nPROC other()\n", to(40));
    let by = rewritten(&desk, &program(&format!("{body}{ask}"))).0;
    assert_eq!(by[..5], [1, 1, 0, 1, 0], "{by:?}");
    // the first branch comes from before the conditions, the second one from what the second condition does
    let body = format!(
        "{}IF di1=1 THEN\n{}ELSEIF ask() THEN\n{}ELSE\n{}ENDIF\n{}",
        all(&[0, 10]),
        all(&[0, 5]),
        all(&[0, 5]),
        all(&[0, 5]),
        to(3)
    );
    let by = rewritten(&desk, &program(&format!("{body}{ask}"))).0;
    assert_eq!(by[..9], [1, 1, -1, 1, 0, 1, 0, 1, 0], "{by:?}");
}

#[test]
fn a_call_before_the_end_of_a_branch_leaves_what_follows() {
    let desk = desk();
    let body = format!("{}IF di1=1 THEN\n{}part;\nENDIF\n{}", all(&[0, 10]), all(&[0, 5]), to(3));
    let by = rewritten(&desk, &program(&format!("{body}Stop;\nENDPROC\nPROC part()\n{}", to(1)))).0;
    assert_eq!(by[..5], [1, 1, -1, 1, 0], "{by:?}");
}

#[test]
fn what_stands_after_a_jump_away_says_nothing_of_what_stands_before_it() {
    let desk = desk();
    for leaves in ["GOTO l1;", "RETURN;"] {
        let body = format!("{}{leaves}\n{}l1:\n{}", to(10), to(20), all(&[5, 7]));
        let by = rewritten(&desk, &program(&body)).0;
        assert_eq!((by[0], by[3]), (0, 1), "{leaves}: {by:?}");
    }
}

#[test]
fn points_of_a_branch_stand_in_the_branch() {
    let desk = desk();
    let body = format!("{}IF di1=1 THEN\n{}ENDIF\n{}", all(&[0, 10]), all(&[0, 5]), to(3));
    desk.write("p.mod", &program(&body));
    desk.run("rewrite --model model.yaml p.mod --output out.mod").success();
    let out = String::from_utf8(desk.read("out.mod")).unwrap();
    let lines: Vec<&str> = out.lines().collect();
    let place = |word: &str| lines.iter().position(|l| l.starts_with(word)).unwrap();
    let (opens, closes) = (place("IF di1"), place("ENDIF"));
    let moves = |range: std::ops::Range<usize>| lines[range].iter().filter(|l| l.starts_with("MoveAbsJ")).count();
    assert!(moves(0..opens) == 2 && moves(opens..closes) > 2 && moves(closes..lines.len()) == 1, "{out}");
    desk.run("rewrite --model model.yaml out.mod --output again.mod").code(2);
    desk.run("undo out.mod --output back.mod").success();
    assert_eq!(desk.read("back.mod"), desk.read("p.mod"));
}

/// A FANUC program of joint targets, J1 of `J P[n]` at these degrees, and half gaps of 0.01 deg.
fn fanuc(desk: &Desk, lines: &[&str], deg: &[i32]) -> Vec<i32> {
    std::fs::copy(bundled("configs").join("fanuc-m10ia.yaml"), desk.path("fanuc.yaml")).unwrap();
    let effect = "effects:\n  - {effect: backlash, joint: J1, half_gap_deg: 0.01}\n";
    desk.write("fanuc-model.yaml", &format!("schema: lostmotion/model/1\nrobot: fanuc.yaml\n{effect}"));
    let text = |by: &[i32]| {
        let mut main = String::new();
        for (n, line) in lines.iter().enumerate() {
            main += &format!("{:4}:{line} ;\r\n", n + 1);
        }
        let mut pos = String::new();
        for (n, deg) in by.iter().enumerate() {
            pos += &format!(
                "P[{}]{{\r\n   GP1:\r\n\tUF : 0, UT : 1,\t\r\n\tJ1={:10.3} deg,\tJ2=     0.000 deg,\tJ3=     0.000 deg,\r\n\t\
                 J4=     0.000 deg,\tJ5=   -60.000 deg,\tJ6=     0.000 deg\r\n}};\r\n",
                n + 1,
                f64::from(*deg)
            );
        }
        format!("/PROG  PART\r\n/ATTR\r\nLINE_COUNT\t= {};\r\n/MN\r\n{main}/POS\r\n{pos}/END\r\n", lines.len())
    };
    desk.write("part.LS", &text(deg));
    desk.run("rewrite --model fanuc-model.yaml part.LS --output out.LS --max-added 0 --force").success();
    let out = String::from_utf8(desk.read("out.LS")).unwrap();
    let j1: Vec<f64> =
        out.split("J1=").skip(1).map(|t| t.split_whitespace().next().unwrap().parse().unwrap()).collect();
    assert_eq!(j1.len(), deg.len(), "{out}");
    j1.iter().zip(deg).map(|(a, b)| ((a - f64::from(*b)) * 100.0).round() as i32).collect()
}

#[test]
fn a_label_is_reached_from_before_it_and_from_all_jumps_to_it() {
    let desk = desk();
    let lines = |jump: &'static str| {
        ["J P[1] 9% FINE", "J P[2] 9% FINE", "LBL[1]", "J P[3] 9% FINE", "J P[4] 9% FINE", jump, "J P[5] 9% FINE"]
    };
    let jumps = "IF DI[1]=ON,JMP LBL[1]";
    // to 0 from 10, and from 20: downwards; what follows the jump comes from 20
    assert_eq!(fanuc(&desk, &lines(jumps), &[0, 10, 0, 20, 5]), [1, 1, -1, 1, -1]);
    // to 15 from 10 upwards, and from 20 downwards
    assert_eq!(fanuc(&desk, &lines(jumps), &[0, 10, 15, 20, 5]), [1, 1, 0, 1, -1]);
    // where the jump may come from anywhere, or while the robot moves, nothing is known
    for other in ["JMP LBL[R[1]]", "WAIT DI[1]=ON TIMEOUT,LBL[R[2]]"] {
        assert_eq!(fanuc(&desk, &lines(other), &[0, 10, 0, 20, 5])[..4], [1, 1, 0, 1], "{other}");
    }
    let mut skips = lines(jumps);
    skips[4] = "J P[4] 9% FINE Skip,LBL[1]";
    assert_eq!(fanuc(&desk, &skips, &[0, 10, 0, 20, 5])[..3], [1, 1, 0]);
    // the label of such a motion may stand after it
    let forwards = [
        "J P[1] 9% FINE",
        "J P[2] 9% FINE Skip,LBL[1]",
        "J P[3] 9% FINE",
        "J P[4] 9% FINE",
        "LBL[1]",
        "J P[5] 9% FINE",
    ];
    assert_eq!(fanuc(&desk, &forwards, &[0, 10, 30, 20, 5])[4], 0);
    let mut jumps_on = forwards;
    jumps_on[1] = "J P[2] 9% FINE";
    assert_eq!(fanuc(&desk, &jumps_on, &[0, 10, 30, 20, 5])[4], -1);
    // two labels of one number
    let mut twice = lines(jumps);
    twice[6] = "LBL[1]";
    assert_eq!(fanuc(&desk, &twice, &[0, 10, 0, 20])[..3], [1, 1, 0]);
    // a jump that is always taken: nothing comes to the label from above it
    let lines = [
        "J P[1] 9% FINE",
        "J P[2] 9% FINE",
        "JMP LBL[2]",
        "LBL[1]",
        "J P[3] 9% FINE",
        "LBL[2]",
        "J P[4] 9% FINE",
        "JMP LBL[1]",
    ];
    assert_eq!(fanuc(&desk, &lines, &[0, 10, 0, 20]), [1, 1, -1, 1]);
}

/// An INFORM job of joint targets, S of `MOVJ C0000n` at these degrees, and half gaps of 0.01 deg.
fn inform(desk: &Desk, lines: &[&str], deg: &[i32]) -> Vec<i32> {
    std::fs::copy(bundled("configs").join("motoman-ma2010.yaml"), desk.path("motoman.yaml")).unwrap();
    let effect = "effects:\n  - {effect: backlash, joint: S, half_gap_deg: 0.01}\n";
    desk.write("motoman-model.yaml", &format!("schema: lostmotion/model/1\nrobot: motoman.yaml\n{effect}"));
    let points: String = deg
        .iter()
        .enumerate()
        .map(|(n, deg)| format!("C{n:05}={deg}.0000,0.0000,0.0000,0.0000,30.0000,0.0000\r\n"))
        .collect();
    let head = format!(
        "/JOB\r\n//NAME PART\r\n//POS\r\n///NPOS {},0,0,0,0,0\r\n///TOOL 0\r\n///POSTYPE ANGLE\r\n///ANGLE\r\n",
        deg.len()
    );
    let main = lines.join("\r\n");
    let attributes = "//INST\r\n///DATE 2024/05/06 07:08\r\n///ATTR SC,RW\r\n///GROUP1 RB1\r\n";
    desk.write("part.JBI", &format!("{head}{points}{attributes}NOP\r\n{main}\r\nEND\r\n"));
    desk.run("rewrite --model motoman-model.yaml part.JBI --output out.JBI --max-added 0 --force").success();
    let out = String::from_utf8(desk.read("out.JBI")).unwrap();
    let s: Vec<f64> = (0..deg.len())
        .filter_map(|n| out.split(&format!("C{n:05}=")).nth(1)?.split(',').next()?.parse().ok())
        .collect();
    assert_eq!(s.len(), deg.len(), "{out}");
    s.iter().zip(deg).map(|(a, b)| ((a - f64::from(*b)) * 100.0).round() as i32).collect()
}

#[test]
fn a_label_after_a_jump_that_is_always_taken_is_reached_all_the_same() {
    let desk = desk();
    // around the branch the robot comes down from 10, and up from 5 out of it
    let block = |open, close| {
        vec![
            "J P[1] 9% FINE",
            "J P[2] 9% FINE",
            "JMP LBL[1]",
            "LBL[1]",
            open,
            "J P[3] 9% FINE",
            "J P[4] 9% FINE",
            close,
            "J P[5] 9% FINE",
        ]
    };
    for (open, close) in [("IF (DI[1]) THEN", "ENDIF"), ("FOR R[1]=1 TO R[2]", "ENDFOR")] {
        for (last, by_last) in [(7, 0), (3, -1), (30, 1)] {
            let by = fanuc(&desk, &block(open, close), &[0, 10, 20, 5, last]);
            assert_eq!((by[0], by[4]), (1, by_last), "{open} {last}: {by:?}");
        }
    }
    // a section for an alarm is passed by, but for a jump into it
    let mut alarm = block("IF (DI[1]) THEN", "ENDIF");
    alarm.splice(2..4, ["IF DI[2]=ON,JMP LBL[9]", "JMP LBL[1]", "LBL[9]", "DO[1]=ON", "LBL[1]"]);
    assert_eq!(fanuc(&desk, &alarm, &[0, 10, 20, 5, 7])[4], 0);
    assert_eq!(fanuc(&desk, &alarm, &[0, 10, 20, 5, 3])[4], -1);
    let job = |last| {
        let lines = [
            "MOVJ C00000 VJ=25.00 PL=0",
            "MOVJ C00001 VJ=25.00 PL=0",
            "JUMP *L1",
            "*L1",
            "IFTHENEXP I000=1",
            "MOVJ C00002 VJ=25.00 PL=0",
            "MOVJ C00003 VJ=25.00 PL=0",
            "ENDIF",
            "MOVJ C00004 VJ=25.00 PL=0",
        ];
        inform(&desk, &lines, &[0, 10, 20, 5, last])
    };
    let by = job(7);
    assert_eq!((by[0], by[4]), (1, 0), "{by:?}");
    // a job that waits at a label before its jump goes on from where it stands
    let waits = [
        "MOVJ C00000 VJ=25.00 PL=0",
        "MOVJ C00001 VJ=25.00 PL=0",
        "*L1",
        "JUMP *L1 IF IN#(1)=OFF",
        "MOVJ C00002 VJ=25.00 PL=0",
    ];
    assert_eq!(inform(&desk, &waits, &[0, 10, 3]), [1, 1, -1]);
}

/// A KRL program whose A1 goes to these degrees (`0`, or what else stands in a line), and half gaps of 0.01 deg.
pub fn krl(desk: &Desk, lines: &[&str]) -> Vec<i32> {
    krl_with(desk, lines, "--max-added 0")
}

/// With these options, which add no points to this program.
pub fn krl_with(desk: &Desk, lines: &[&str], options: &str) -> Vec<i32> {
    std::fs::copy(bundled("configs").join("kuka-kr120-r2500-pro.yaml"), desk.path("kuka.yaml")).unwrap();
    let effect = "effects:\n  - {effect: backlash, joint: A1, half_gap_deg: 0.01}\n";
    desk.write("kuka-model.yaml", &format!("schema: lostmotion/model/1\nrobot: kuka.yaml\n{effect}"));
    let line = |l: &&str| match l.parse::<i32>() {
        Ok(deg) => format!("PTP {{A1 {deg},A2 -90,A3 90,A4 0,A5 30,A6 0}}\n"),
        Err(_) => format!("{l}\n"),
    };
    let text = format!("DEF p( )\n{}END\n", lines.iter().map(line).collect::<String>());
    desk.write("p.src", &text);
    desk.run(&format!("rewrite --model kuka-model.yaml p.src --output o.src --force {options}")).success();
    let out = String::from_utf8(desk.read("o.src")).unwrap();
    let a1 = |text: &str| -> Vec<f64> {
        text.lines().filter_map(|l| l.strip_prefix("PTP {A1 ")?.split(',').next()?.parse().ok()).collect()
    };
    let (before, after) = (a1(&text), a1(&out));
    assert_eq!(before.len(), after.len(), "{out}");
    before.iter().zip(&after).map(|(a, b)| ((b - a) * 100.0).round() as i32).collect()
}

#[test]
fn blocks_and_labels_of_krl_are_followed() {
    let desk = desk();
    let lines = ["0", "10", "IF $IN[1]==TRUE THEN", "0", "5", "ELSE", "20", "15", "ENDIF", "3"];
    assert_eq!(krl(&desk, &lines), [1, 1, -1, 1, 1, -1, -1]);
    let lines = ["0", "10", "SWITCH n", "CASE 1", "0", "5", "DEFAULT", "20", "15", "ENDSWITCH", "12"];
    assert_eq!(krl(&desk, &lines), [1, 1, -1, 1, 1, -1, 0]);
    // a jump back, and a way around
    let lines = ["0", "10", "again:", "0", "20", "IF $IN[1] THEN", "GOTO again", "ENDIF", "5"];
    assert_eq!(krl(&desk, &lines), [1, 1, -1, 1, -1]);
    // certain loops, and those that are left
    assert_eq!(krl(&desk, &["0", "10", "FOR i=1 TO 3", "0", "20", "ENDFOR", "5"]), [1, 1, -1, 1, -1]);
    let lines = ["0", "10", "LOOP", "0", "20", "IF $IN[1] THEN", "EXIT", "ENDIF", "ENDLOOP", "5"];
    assert_eq!(krl(&desk, &lines), [1, 1, -1, 1, 0]);
    // what a condition calls may move
    let lines = ["0", "10", "IF ask() THEN", "0", "ENDIF", "3"];
    assert_eq!(krl(&desk, &lines)[..3], [1, 1, 0]);
}

#[test]
fn the_verdict_takes_a_branch_as_reached_from_the_side_that_its_offsets_are_for() {
    let desk = desk();
    let body = format!("{}IF di1=1 THEN\n{}ELSE\n{}ENDIF\n{}", all(&[0, 10]), all(&[0, 5]), all(&[20, 15]), to(3));
    desk.write("p.mod", &program(&body));
    let run = desk.run("rewrite --model model.yaml p.mod --output out.mod --json").success();
    let doc: serde_json::Value = serde_json::from_slice(&run.get_output().stdout).unwrap();
    assert_eq!((doc["left"].as_u64(), doc["path_error"]["verdict"].as_str()), (Some(0), Some("better")), "{doc}");
    let at_targets = &doc["path_error"]["at_targets"]["largest_um"];
    assert!(at_targets["after"].as_f64().unwrap() < 0.2 * at_targets["before"].as_f64().unwrap(), "{at_targets}");
}
