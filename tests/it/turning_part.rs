//! Straight moves on a part that a unit turns: seen from the robot they are none, and from which side its joints arrive is not known.

use crate::support::bundled;
use crate::vendor_rewrite::Desk;

/// A desk with half gaps of 0.01 deg on all joints of a robot.
fn desk(config: &str, joints: &str) -> Desk {
    let desk = Desk::new(0.0);
    std::fs::copy(bundled("configs").join(config), desk.path("robot.yaml")).unwrap();
    let gap = |joint: &str| format!("  - {{effect: backlash, joint: {joint}, half_gap_deg: 0.01}}\n");
    let gaps: String = joints.split(' ').map(gap).collect();
    desk.write("model.yaml", &format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{gaps}"));
    desk
}

/// Lines of moves that stay as they are, of a program that takes no new points.
fn unchanged(desk: &Desk, name: &str, options: &str) -> Vec<usize> {
    desk.run(&format!("rewrite --model model.yaml {name} --max-added 0 --force --output out-{name}{options}"))
        .success();
    let [before, after] = [name.to_string(), format!("out-{name}")].map(|n| String::from_utf8(desk.read(&n)).unwrap());
    assert_eq!(before.lines().count(), after.lines().count(), "{after}");
    let moves = |l: &str| ["LIN", "PTP {E6POS", "MoveL", "C0"].iter().any(|w| l.trim().starts_with(w));
    let same = before.lines().zip(after.lines()).enumerate().filter(|(_, (a, b))| moves(a) && a == b);
    same.map(|(k, _)| k + 1).collect()
}

#[test]
fn a_straight_move_on_a_base_that_an_axis_turns_stays_in_krl() {
    let desk = desk("kuka-kr16-2.yaml", "A1 A2 A3 A4 A5 A6");
    let pose = |x: i32, y: i32, a: i32, e1: i32| format!("LIN {{X {x},Y {y},Z 200,A {a},B 180,C 0,E1 {e1}}}\n");
    let text = format!(
        "DEF p( )\n$TOOL={{X 0,Y 0,Z 100,A 0,B 0,C 0}}\nBAS(#EX_BASE,2)\nPTP {{A1 30,A2 -90,A3 90,A4 0,A5 60,A6 0,E1 0}}\n{}{}{}END\n",
        pose(180, 0, 45, 0),
        pose(180, 0, -45, 90),
        pose(170, 10, -45, 90)
    );
    desk.write("p.src", &text);
    let frames = |turn: i32, y: i32| {
        format!(
            "schema: lostmotion/frames/1\nframes:\n  \"EX_BASE 2\": {{xyz_mm: [900, 0, 700], rpy_deg: [0, 0, -45]}}\n  \
             \"EX_BASE 2 at E1 90\": {{xyz_mm: [900, {y}, 700], rpy_deg: [0, 0, {turn}]}}\n"
        )
    };
    desk.write("turns.yaml", &frames(45, 0));
    assert_eq!(unchanged(&desk, "p.src", " --frames turns.yaml"), [6]);
    // the same in a branch, after which the table stands elsewhere; and coming from another frame of the same orientation
    let [first, turned, last] = [pose(180, 0, 45, 0), pose(180, 0, -45, 90), pose(170, 10, -45, 90)];
    let branch = text.replace(&turned, &format!("IF $IN[1] THEN\n{turned}{last}ENDIF\n"));
    desk.write("p.src", &branch);
    assert!(unchanged(&desk, "p.src", " --frames turns.yaml").contains(&7));
    let other = text
        .replace("BAS(#EX_BASE,2)\n", "$BASE={X 900,Y 0,Z 700,A 45,B 0,C 0}\n")
        .replace(&turned, &format!("BAS(#EX_BASE,2)\n{turned}"));
    assert!(other.contains(&first));
    desk.write("p.src", &other);
    assert!(unchanged(&desk, "p.src", " --frames turns.yaml").contains(&7));
    desk.write("p.src", &text);
    // a linear unit takes the part along, and the way stays straight
    desk.write(
        "p.src",
        &text
            .replace("A -45", "A 45")
            .replace("{X 180,Y 0,Z 200,A 45,B 180,C 0,E1 90", "{X 180,Y 20,Z 200,A 45,B 180,C 0,E1 90"),
    );
    desk.write("slides.yaml", &frames(-45, 90));
    assert_eq!(unchanged(&desk, "p.src", " --frames slides.yaml"), Vec::<usize>::new());
    // an arc on it is none for the robot
    let arc = String::from_utf8(desk.read("p.src")).unwrap();
    let straight = pose(180, 20, 45, 90);
    let turned = "CIRC {X 185,Y 10,Z 200,A 45,B 180,C 0,E1 90},{X 180,Y 20,Z 200,A 45,B 180,C 0,E1 90}\n";
    assert!(arc.contains(&straight));
    desk.write("p.src", &arc.replace(&straight, turned));
    desk.run("rewrite --model model.yaml p.src --max-added 0 --force --output out-p.src --frames slides.yaml")
        .success();
    assert!(String::from_utf8(desk.read("out-p.src")).unwrap().contains(turned));
    desk.write("p.src", &arc);
    // but not where the wrist turns joint by joint
    let slide = String::from_utf8(desk.read("p.src")).unwrap();
    desk.write("p.src", &slide.replace("BAS(#EX", "$ORI_TYPE=#JOINT\nBAS(#EX"));
    assert!(unchanged(&desk, "p.src", " --frames slides.yaml").contains(&7));
}

#[test]
fn a_straight_move_on_a_work_object_that_an_axis_turns_stays_in_rapid() {
    let desk = desk("abb-irb1600-6-145.yaml", "J1 J2 J3 J4 J5 J6");
    let pose = |word: &str, x: i32, y: i32, turn: &str, eax: i32| {
        format!(
            "{word} [[{x},{y},100],[0,{turn},0.92387953,0],[0,0,0,0],[{eax},9E9,9E9,9E9,9E9,9E9]],v100,fine,t1\\WObj:=wst;\n"
        )
    };
    let text = format!(
        "MODULE p\nPERS tooldata t1:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];\n\
         TASK PERS wobjdata wst:=[FALSE,FALSE,\"STN_1\",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\nPROC main()\n\
         MoveAbsJ [[-20,0,0,0,60,0],[0,9E9,9E9,9E9,9E9,9E9]],v100,fine,t1;\n{}{}{}ENDPROC\nENDMODULE\n",
        pose("MoveJ", 180, 0, "0.38268343", 0).replace("[0,0,0,0],[0,9", "[-1,0,0,0],[0,9"),
        pose("MoveL", 180, 0, "-0.38268343", 90),
        pose("MoveL", 170, 10, "-0.38268343", 90)
    );
    desk.write("p.mod", &text);
    desk.write(
        "frames.yaml",
        "schema: lostmotion/frames/1\nframes:\n  \"wst on its mechanical unit\": {xyz_mm: [600, 0, 500], rpy_deg: [0, 0, -45]}\n  \
         \"wst on its mechanical unit at eax_a 90\": {xyz_mm: [600, 0, 500], rpy_deg: [0, 0, 45]}\n",
    );
    assert_eq!(unchanged(&desk, "p.mod", " --frames frames.yaml"), [7]);
}

#[test]
fn a_synchronised_move_whose_station_turns_stays_in_inform() {
    let desk = desk("motoman-ma2010.yaml", "S L U R B T");
    let job = |stations: [i32; 3]| {
        let [a, b, c] = stations;
        format!(
            "/JOB\r\n//NAME P\r\n//POS\r\n///NPOS 3,0,3,0,0,0\r\n///TOOL 0\r\n///POSTYPE ANGLE\r\n///ANGLE\r\n\
             C00000=-10.0000,10.0000,-10.0000,0.0000,-40.0000,5.0000\r\nC00001=-5.0000,10.0000,-10.0000,0.0000,-40.0000,5.0000\r\n\
             C00002=5.0000,10.0000,-10.0000,0.0000,-40.0000,-5.0000\r\nEC00000={a}.0000\r\nEC00001={b}.0000\r\nEC00002={c}.0000\r\n\
             //INST\r\n///DATE 2020/01/01 10:00\r\n///ATTR SC,RW\r\n///GROUP1 RB1\r\n///GROUP2 ST1\r\nNOP\r\n\
             MOVJ C00000 VJ=10.00 +MOVJ EC00000\r\nMOVJ C00001 VJ=10.00 +MOVJ EC00001\r\nSMOVL C00002 V=100.0 +MOVJ EC00002\r\nEND\r\n"
        )
    };
    desk.write("tools.yaml", "schema: lostmotion/frames/1\ntools:\n  \"0\": {xyz_mm: [0, 0, 100]}\n");
    desk.write("P.JBI", &job([0, 0, 90]));
    assert_eq!(unchanged(&desk, "P.JBI", " --frames tools.yaml").len(), 1);
    let still = job([0, 30, 30]);
    desk.write("P.JBI", &still);
    assert_eq!(unchanged(&desk, "P.JBI", " --frames tools.yaml").len(), 0);
    // the station is moved alone, or with the robot, in between
    for between in [
        "MOVJ EC00000 VJ=10.00\r\n",
        "MOVJ C00001 EC00000 VJ=10.00\r\n",
        "MOVJ C00001 VJ=10.00\r\n' a comment\r\n+MOVJ EC00000\r\n",
    ] {
        desk.write("P.JBI", &still.replace("SMOVL", &format!("{between}SMOVL")));
        assert!(unchanged(&desk, "P.JBI", " --frames tools.yaml").contains(&10), "{between}");
    }
}

/// Of a straight way on which the wrist turns joint by joint it is not known from which side joints arrive.
#[test]
fn a_straight_move_on_which_the_wrist_turns_joint_by_joint_stays() {
    let desk = desk("kuka-kr16-2.yaml", "A1 A2 A3 A4 A5 A6");
    let text = |orientation: &str| {
        format!(
            "DEF p( )\n$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\n{orientation}PTP {{A1 1.0000,A2 -80.0000,A3 100.0000,A4 -14.8185,A5 67.9114,A6 -36.7169}}\n\
             PTP {{A1 0.0000,A2 -80.0000,A3 100.0000,A4 -14.8185,A5 67.9114,A6 -36.7169}}\n\
             LIN {{X 996.5611,Y 5.2760,Z 897.0612,A -169.93297,B -12.06335,C -175.37993}}\nEND\n"
        )
    };
    desk.write("p.src", &text(""));
    assert_eq!(unchanged(&desk, "p.src", ""), Vec::<usize>::new());
    desk.write("p.src", &text("$ORI_TYPE=#JOINT\n"));
    assert_eq!(unchanged(&desk, "p.src", ""), [7]);
}
