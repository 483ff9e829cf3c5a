//! Frames and tools that a program computes: no point may stand where the value that is given for one would put it.

use crate::support::bundled;
use crate::vendor_rewrite::Desk;
use predicates::str::contains;

const CHANGES: &str =
    "it leads from or to a frame or tool that the program computes, which is not that of the target before it";

/// A desk with half gaps of 0.02 deg on all joints of a robot that may turn them further than that one.
fn desk(config: &str, joints: &str) -> Desk {
    let desk = Desk::new(0.0);
    let robot = std::fs::read_to_string(bundled("configs").join(config)).unwrap();
    let wide: Vec<String> = robot
        .lines()
        .map(|line| match line.split_once("limits_deg: [") {
            Some((head, rest)) if !line.starts_with('#') => {
                let (_, rest) = rest.split_once(']').unwrap_or_default();
                format!("{head}limits_deg: [-720, 720]{rest}")
            }
            _ => line.to_string(),
        })
        .collect();
    desk.write("robot.yaml", &wide.join("\n"));
    let gap = |joint: &str| format!("  - {{effect: backlash, joint: {joint}, half_gap_deg: 0.02}}\n");
    let gaps: String = joints.split(' ').map(gap).collect();
    desk.write("model.yaml", &format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{gaps}"));
    desk
}

/// The lines of a program that begin with one of the words, once it is rewritten.
fn rewritten(desk: &Desk, name: &str, frames: &str, words: &[&str]) -> (Vec<String>, String) {
    desk.write("frames.yaml", &format!("schema: lostmotion/frames/1\n{frames}"));
    let line = format!("rewrite --model model.yaml {name} --output out-{name} --force --frames frames.yaml");
    let done = desk.run(&line).success();
    let said = String::from_utf8_lossy(&done.get_output().stderr).into_owned();
    let out = String::from_utf8(desk.read(&format!("out-{name}"))).unwrap();
    let is = |line: &&str| words.iter().any(|word| line.trim_start().contains(word));
    (out.lines().filter(is).map(str::to_string).collect(), said)
}

const AT_ZERO: &str = "{xyz_mm: [0, 0, 0]}";

const W: &str = "LOCAL PERS wobjdata w:=[FALSE,TRUE,\"\",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];";
const T: &str = "LOCAL PERS tooldata w:=[TRUE,[[0,0,0],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];";
const HOME: &str = "MoveAbsJ [[0,0,0,10,30,10],[9E9,9E9,9E9,9E9,9E9,9E9]]\\NoEOffs,v100,fine,tool0;";
const A: &str =
    "[[836.167,154.711,1036.895],[0.3761638,0.0980259,0.9051266,0.1721555],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
const B: &str =
    "[[822.555,78.376,1107.551],[0.4424950,0.1038873,0.8782231,0.1487609],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
const C: &str =
    "[[565.356,192.927,950.960],[0.2946740,0.1213576,0.9305391,0.1803790],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
const OUT: &str =
    "[[806.292,5.644,1154.494],[0.4896235,0.1186039,0.8556489,0.1186039],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";

fn rapid(data: &str, body: &str, more: &str) -> String {
    format!("MODULE m\n{data}\nPROC main()\n{body}\nStop;\nENDPROC\n{more}\nENDMODULE\n")
}

fn straight(to: &str, place: &str) -> String {
    format!("MoveL {to},v100,fine,{place};")
}

#[test]
fn no_point_stands_on_the_way_out_of_a_work_object_that_the_program_computes_or_into_it() {
    let desk = desk("abb-irb1600-6-145.yaml", "J1 J2 J3 J4 J5 J6");
    let [a, b] = [A, B].map(|to| straight(to, "tool0\\WObj:=w"));
    let frames = format!("frames: {{w: {AT_ZERO}}}\n");
    for (last, word) in [(HOME.to_string(), "MoveAbsJ"), (straight(OUT, "tool0"), "tool0;")] {
        let body = format!("w.oframe.trans.y:=GInput(gVision);\n{HOME}\n{a}\n{b}\n{a}\n{last}");
        desk.write("a.mod", &rapid(W, &body, ""));
        let (moves, said) = rewritten(&desk, "a.mod", &frames, &["Move"]);
        assert!(said.contains(CHANGES), "{said}");
        // from joint values to the first target
        assert!(moves[0].starts_with("MoveAbsJ") && moves[1].starts_with("MoveL [[836."), "{moves:#?}");
        // and from the last one on; between two of them a joint reverses, and the point in place is right wherever they are
        let own: Vec<usize> = (0..moves.len()).filter(|k| moves[*k].ends_with("\\WObj:=w;")).collect();
        assert!(own.len() > 3 && own[own.len() - 1] + 2 == moves.len(), "{moves:#?}");
        assert!(moves[own[own.len() - 1]].starts_with("MoveL [[836.") && moves[moves.len() - 1].contains(word));
        assert!(!moves.iter().any(|m| m == &a || m == &b), "their offsets are written: {moves:#?}");
    }
}

#[test]
fn no_point_repeats_a_target_after_its_work_object_or_tool_is_set() {
    let desk = desk("abb-irb1600-6-145.yaml", "J1 J2 J3 J4 J5 J6");
    let upd = "PROC upd()\nw.uframe.trans.x:=300;\nENDPROC";
    for (data, place, set, more, list) in [
        (W, "tool0\\WObj:=w", "w.uframe.trans.x:=300;", "", "frames"),
        (W, "tool0\\WObj:=w", "upd;", upd, "frames"),
        (T, "w", "w.tframe.trans.z:=300;", "", "tools"),
    ] {
        let [a, b, c] = [A, B, C].map(|to| straight(to, place));
        desk.write("a.mod", &rapid(data, &format!("{HOME}\n{a}\n{b}\n{set}\n{c}\n{a}"), more));
        let list_of = "rewrite --model model.yaml a.mod --list-frames";
        desk.run(list_of).success().stdout(contains("w from assignment 1 on"));
        let frames = format!("{list}: {{w: {AT_ZERO}, \"w from assignment 1 on\": {{xyz_mm: [0, 0, 0]}}}}\n");
        let (lines, _) = rewritten(&desk, "a.mod", &frames, &["Move", ":=300", "upd;"]);
        let at = lines.iter().position(|l| !l.starts_with("Move")).unwrap();
        assert!(lines[at + 1].starts_with("MoveL [[565."), "{set}: {lines:#?}");
        assert!(lines[at - 1].starts_with("MoveL [[822."), "{set}: {lines:#?}");
    }
}

#[test]
fn no_point_stands_between_a_fanuc_target_with_an_offset_and_one_without() {
    let desk = desk("fanuc-m10ia.yaml", "J1 J2 J4 J5 J6");
    let pose = |n: usize, xyz: &str, wpr: &str| {
        let [x, y, z] = xyz.split(' ').collect::<Vec<_>>().try_into().unwrap();
        let [w, p, r] = wpr.split(' ').collect::<Vec<_>>().try_into().unwrap();
        format!(
            "P[{n}]{{\n   GP1:\n\tUF : 1, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',\n\tX = {x}  mm,\tY = {y}  mm,\tZ = {z}  mm,\n\
             \tW = {w} deg,\tP = {p} deg,\tR = {r} deg\n}};\n"
        )
    };
    let text = format!(
        "/PROG  A\n/ATTR\nLINE_COUNT\t= 5;\n/MN\n   1:L P[2] 100mm/sec FINE    ;\n   2:L P[1] 100mm/sec FINE    ;\n\
         \x20  3:L P[2] 100mm/sec FINE Offset,PR[1]    ;\n   4:  PR[1,1]=PR[1,1]+50    ;\n   5:L P[1] 100mm/sec FINE    ;\n/POS\n{}{}/END\n",
        pose(1, "862.275 132.908 768.106", "163.598 -28.091 21.295"),
        pose(2, "849.244 57.387 748.759", "166.101 -29.965 13.215")
    );
    desk.write("A.LS", &text);
    let frames =
        format!("frames: {{\"1\": {AT_ZERO}, \"1 with OFFSET,PR[1]\": {AT_ZERO}}}\ntools: {{\"1\": {AT_ZERO}}}\n");
    let (lines, _) = rewritten(&desk, "A.LS", &frames, &["mm/sec"]);
    let at = lines.iter().position(|l| l.contains("Offset")).unwrap();
    assert_eq!(lines.iter().filter(|l| l.contains("Offset")).count(), 1, "{lines:#?}");
    assert_eq!(lines.len(), at + 2, "{lines:#?}");
}

#[test]
fn no_point_stands_between_pulses_and_a_user_frame_that_an_inform_job_sets() {
    let desk = desk("motoman-ma2010.yaml", "S L U R B T");
    let text = "/JOB\n//NAME A\n//POS\n///NPOS 3,0,0,0,0,0\n///TOOL 0\n///POSTYPE ANGLE\n///ANGLE\n\
        C00000=0.0000,0.0000,0.0000,10.0000,-60.0000,0.0000\n///USER 1\n///POSTYPE USER\n///RECTAN\n///RCONF 0,0,0,0,0,0,0,0\n\
        C00001=1323.407,214.218,868.458,164.6622,-23.1843,20.8340\nC00002=1299.830,96.809,892.550,166.4244,-27.9848,13.0579\n\
        //INST\n///DATE 2020/01/01 00:00\n///ATTR SC,RW\n///GROUP1 RB1\nNOP\nMFRAME UF#(1) PX000 PX001 PX002\n\
        MOVJ C00000 VJ=50.00\nMOVJ C00001 VJ=50.00\nMOVL C00002 V=100.0\nMOVL C00001 V=100.0\nMOVJ C00000 VJ=50.00\nEND\n";
    desk.write("A.JBI", text);
    let frames = format!("frames: {{\"1 as the job sets it\": {AT_ZERO}}}\ntools: {{\"0\": {AT_ZERO}}}\n");
    let (lines, said) = rewritten(&desk, "A.JBI", &frames, &["MOVJ"]);
    // none on joint moves; those between two targets of the frame are straight
    assert_eq!(lines.len(), 3, "{lines:#?}\n{said}");
}

#[test]
fn no_point_stands_between_a_computed_base_of_krl_and_joint_values_or_another_base() {
    let desk = desk("kuka-kr120-r2500-pro.yaml", "A1 A2 A3 A4 A5 A6");
    let home = "PTP {A1 0,A2 -90,A3 90,A4 10,A5 30,A6 0}";
    let a = "{X 1559.8852,Y -299.1032,Z 1465.1874,A -168.4379,B 44.7723,C -157.8942}";
    let b = "{X 1588.6864,Y -367.4209,Z 1312.2775,A -168.0911,B 34.5884,C -157.6233}";
    let text = format!(
        "DEF a()\n$TOOL=$NULLFRAME\n{home}\n$BASE=BASE_DATA[N]\nPTP {a}\nLIN {b}\n{home}\nLIN {a}\n$BASE=$NULLFRAME\n\
         LIN {{X 1536.1955,Y -18.6672,Z 1678.1332,A -163.2604,B 58.5251,C -160.5746}}\nEND\n"
    );
    desk.write("a.src", &text);
    let frames = format!("frames: {{\"BASE_DATA[N]\": {AT_ZERO}}}\n");
    let (lines, said) = rewritten(&desk, "a.src", &frames, &["PTP", "LIN"]);
    assert!(said.contains(CHANGES), "{said}");
    let joints = lines.iter().filter(|l| l.contains("{A1")).count();
    assert_eq!(joints, 2, "{lines:#?}");
    // home, the first target, ..., the last way to the other base
    assert!(lines[1].starts_with("PTP {X 1559."), "{lines:#?}");
    for (line, begin) in lines[lines.len() - 3..].iter().zip(["PTP {A1", "LIN {X 15", "LIN {X 153"]) {
        assert!(line.starts_with(begin), "{lines:#?}");
    }
}
