//! Cartesian targets: frames, tools, displacements, and joints in their place.

use super::*;

#[test]
fn a_robtarget_has_its_frame_and_tool_from_the_text_or_by_name() {
    let p = "CONST robtarget p1:=[[500,-20,300.5],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\nPERS tooldata tGun:=[TRUE,[[0,0,120],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];";
    let pose = |body: &str| match &moves(&program(p, body))[0].goal {
        Goal::Pose(p) => p.clone(),
        other => panic!("{other:?}"),
    };
    let plain = pose("MoveL p1,v100,fine,tool0\\WObj:=wobj0;");
    assert!((plain.position_m - nalgebra::Vector3::new(0.5, -0.02, 0.3005)).norm() < 1e-12);
    assert!(
        (&plain.frame, &plain.tool) == (&Frame::Null, &Frame::Null)
            && plain
                .rotation
                .unwrap()
                .angle_to(&nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(0.0, 0.0, 1.0, 0.0)))
                < 1e-9
    );
    assert_eq!(pose("MoveJ p1,v100,fine,tool0\\WObj:=wTable;").frame, Frame::Named("wTable".into()));
    assert_eq!(pose("MoveJ p1,v100,fine,tOther;").tool, Frame::Named("tOther".into()));
    // elements of an array are others
    let element = pose("MoveJ p1,v100,fine,tList{2}\\WObj:=wList{ 1 };");
    assert_eq!((element.frame, element.tool), (Frame::Named("wList{1}".into()), Frame::Named("tList{2}".into())));
    let gun = nalgebra::Isometry3::translation(0.0, 0.0, 0.12);
    assert_eq!(pose("MoveJ p1,v100,fine,tGun;").tool, Frame::Given(gun));
    let displaced = pose("PDispSet d1;\nMoveJ p1,v100,fine,tool0;").frame;
    assert_eq!(displaced, Frame::Computed("wobj0 displaced by PDispOn or PDispSet".into()));
    let quarters = Configuration::Abb { quarters: [0, 0, 0], cfx: 0 };
    assert_eq!(plain.solution, Solution::Configured(quarters));
}

#[test]
fn a_point_displaced_by_known_numbers_is_edited_beside_its_displacement() {
    let p = "CONST robtarget p1:=[[500,-20,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\nCONST num up:=50;";
    let pose = |body: &str| match &moves(&program(p, body))[0].goal {
        Goal::Pose(p) => p.clone(),
        other => panic!("{other:?}"),
    };
    let offs = pose("MoveL Offs(p1,0,10,up),v100,fine,tool0;");
    assert!((offs.position_m - nalgebra::Vector3::new(0.5, -0.01, 0.35)).norm() < 1e-12 && offs.target.is_some());
    let folded = pose("MoveL Offs(p1,0,2*5,up-(10+2)),v100,fine,tool0;");
    assert!((folded.position_m - nalgebra::Vector3::new(0.5, -0.01, 0.338)).norm() < 1e-12);
    // moves that want it otherwise than others get a clone, and so does what is new; the displacement stays
    let source = program(p, "MoveL p1,v100,fine,tool0;\nMoveL Offs(p1,0,10,up),v100,z10,tool0;");
    let doc = document(&source);
    let (k, m) = moves(&source).into_iter().enumerate().nth(1).unwrap();
    let Goal::Pose(goal) = &m.goal else { panic!() };
    let step = doc.script().moves().nth(k).unwrap().0;
    let mut numbers: Vec<f64> =
        doc.script().targets.get(goal.target.unwrap()).unwrap().values.iter().map(|v| v.unwrap().si).collect();
    numbers[0] += 1e-4;
    let point = NewPoint { q: numbers.clone(), share: 0.5, t_s: None, clearance_m: 0.01, of_way: false, waits: false };
    let edit = Edit { goal: Some(numbers), before: vec![point], ..Edit::default() };
    let edits = Edits { steps: [(step, edit)].into(), pose_digit: [1e-6, 1e-6], ..Edits::default() };
    let bytes = text::apply(&doc.script().texts, &doc.patches(&edits).unwrap()).unwrap();
    let out = String::from_utf8(bytes[0].clone()).unwrap();
    assert!(
        out.contains("MoveL p1,v100,fine,tool0;") && out.contains("MoveL Offs(p1_lm1,0,10,up),v100,z10,tool0;"),
        "{out}"
    );
    assert!(out.contains("MoveL Offs([[500.1") && out.contains("CONST robtarget p1_lm1:=[[500.1"), "{out}");
    // the tool looks down: 50 mm along it are 50 mm down
    let along = pose("MoveL RelTool(p1,0,0,up),v100,fine,tool0;");
    assert!((along.position_m - nalgebra::Vector3::new(0.5, -0.02, 0.25)).norm() < 1e-12);
}

#[test]
fn a_cartesian_move_can_be_written_as_joint_moves() {
    let p = "CONST robtarget p1:=[[500,-20,300.5],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];";
    let source = program(p, "MoveL p1, v100, z10, tool0\\WObj:=wobj0;");
    let mut edits = inserted(&source, 0, 9.5, 0.5, 0.01);
    edits.steps.retain(|_, edit| {
        edit.as_joint_moves = true;
        edit.goal = Some(vec![0.1; 6]);
        true
    });
    let doc = document(&source);
    let bytes = text::apply(&doc.script().texts, &doc.patches(&edits).unwrap()).unwrap();
    let out = String::from_utf8(bytes[0].clone()).unwrap();
    assert_eq!(degrees(&out, 0)[0], Some(9.5));
    assert!(out.contains("MoveAbsJ [[5.7296,5.7296,5.7296,5.7296,5.7296,5.7296],[9E9,9E9,9E9,9E9,9E9,9E9]], v100, z10, tool0\\WObj:=wobj0;"), "{out}");
}

#[test]
fn the_tool_of_a_move_with_a_procedure_stands_before_its_name() {
    let p = "[[600,0,600],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    for line in [
        format!("MoveLSync {p},v100,z10,tHand,\"work\";"),
        format!("MoveJSync {p},v100,z10,tHand\\WObj:=wobj0,\"work\";"),
        format!("MoveL {p},v100,z10,tHand;"),
    ] {
        let Goal::Pose(goal) = &moves(&program("", &line))[0].goal else { panic!("{line}") };
        assert_eq!(goal.tool, Frame::Named("tHand".into()), "{line}");
    }
}

#[test]
fn a_move_with_a_signal_has_the_tool_after_its_zone() {
    let target = "[[900,0,900],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    let tools = |line: &str| {
        let tool = "PERS tooldata tGun:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];";
        match &moves(&program(tool, line))[0].goal {
            Goal::Pose(p) => p.tool.clone(),
            other => panic!("{other:?}"),
        }
    };
    let gun = tools(&format!("MoveL {target},v100,fine,tGun;"));
    for line in [
        format!("MoveLDO {target},v100,fine,tGun,doGlue,1;"),
        format!("MoveLDO {target},v100,fine,tGun\\WObj:=wobj0,doGlue,high;"),
        format!("MoveJGO {target},v100,fine,tGun,goPart\\Value:=5;"),
        format!("MoveLAO {target},v100,fine,tGun,aoFlow,0.5;"),
        format!("MoveLSync {target},v100,fine,tGun,sName;"),
        format!("MoveCDO {target},{target},v100,fine,tGun,doGlue,1;"),
        format!("ArcL {target},v100,seam1,weld1,fine,tGun;"),
    ] {
        assert_eq!(tools(&line), gun, "{line}");
    }
}

#[test]
fn a_work_object_that_moves_with_a_belt_or_another_robot_is_at_no_known_place() {
    let frame = |unit: &str, body: &str| {
        let data = format!(
            "TASK PERS wobjdata w:=[FALSE,FALSE,\"{unit}\",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];\nVAR syncident s;\nPERS tasks all{{2}};"
        );
        let pose = "[[50,0,100],[0,0,1,0],[-1,0,-1,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
        match &moves(&program(&data, &format!("{body}MoveL {pose},v100,fine,tool0\\WObj:=w;")))[0].goal {
            Goal::Pose(p) => p.frame.clone(),
            other => panic!("{other:?}"),
        }
    };
    let unknown = |unit: &str, body: &str| matches!(frame(unit, body), Frame::Unknown(why) if why.to_string().contains("carry") || why.to_string().contains("carries"));
    assert!(unknown("CNV1", "WaitWObj w;\n") && unknown("ROB_2", "") && unknown("STN1", "SyncMoveOn s,all;\n"));
    assert!(unknown("STN1", "WaitSyncTask s,all;\n"));
    assert_eq!(frame("STN1", ""), Frame::Named("w on its mechanical unit".into()));
}

#[test]
fn an_argument_that_the_caller_may_give_is_not_known() {
    let data = "CONST robtarget p1:=[[500,-20,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];";
    let of = |line: &str| {
        let sub = format!("PROC go(\\PERS wobjdata WObj,\\num rx,\\num V,\\num T,\\num Z,\\switch c)\n{line}\nENDPROC");
        let source = program(data, "go;\ngo\\WObj:=w1;").replace("ENDMODULE", &format!("{sub}\nENDMODULE"));
        moves(&source)[0].clone()
    };
    let frame = |line: &str| match of(line).goal {
        Goal::Pose(p) => p.frame,
        other => panic!("{line}: {other:?}"),
    };
    for word in ["MoveL p1,v100", "MoveJ p1,v100", "ArcL p1,v100,sm1,wd1", "MoveC p1,p1,v100"] {
        let computed = Frame::Computed("WObj".into());
        assert_eq!(frame(&format!("{word},z10,tool0\\WObj?WObj;")), computed, "{word}");
        assert_eq!(frame(&format!("{word},z10,tool0\\Conc?c\\WObj ? WObj;")), computed, "{word}");
        assert_eq!(frame(&format!("{word},z10,tool0;")), Frame::Null, "{word}");
    }
    // one whose parameter nothing declares, and one that is displaced
    assert_eq!(frame("MoveL p1,v100,z10,tool0\\WObj?wOther;"), Frame::Computed("wOther".into()));
    let displaced = frame("PDispSet d1;\nMoveL p1,v100,z10,tool0\\WObj?WObj;");
    assert_eq!(displaced, Frame::Computed("WObj displaced by PDispOn or PDispSet".into()));
    assert!(matches!(of("MoveL RelTool(p1,0,0,9\\Rx?rx),v100,z10,tool0;").goal, Goal::Opaque(_)));
    assert!(matches!(of("MoveL p1,v100,z10,tool0\\Corr?c;").goal, Goal::Opaque(_)));
    // speed, time and zone of one call are none of the next
    assert_eq!(of("MoveL p1,v100\\V?V,z10,tool0;").speed, Speed::Unknown);
    assert_eq!(
        (of("MoveL p1,v100,z10,tool0;").speed, of("MoveL p1,v100,z10,tool0;").blend_m),
        (Speed::Tcp(0.1), Some(0.01))
    );
    let timed = of("MoveL p1,v100\\T?T,z10,tool0;");
    assert!(timed.speed == Speed::Unknown && timed.closed.is_some());
    assert_eq!(of("MoveL p1,v100,fine\\Z?Z,tool0;").blend_m, None);
    assert!(of("MoveL p1\\ID?Z,v100,fine,tool0;").closed.is_some());
}

#[test]
fn a_switch_of_a_setting_that_the_caller_may_give_may_be_there() {
    let pose = "[[500,-20,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    let of = |line: &str| {
        let sub = format!("PROC go(\\switch On|switch Off)\n{line}\nMoveJ {pose},v100,fine,tool0;\nENDPROC");
        let source = program("", "go\\Off;").replace("ENDMODULE", &format!("{sub}\nENDMODULE"));
        moves(&source)[0].clone()
    };
    let watched = |line: &str| match of(line).goal {
        Goal::Pose(p) => (p.binding, p.unsure),
        other => panic!("{line}: {other:?}"),
    };
    assert_eq!([watched("ConfJ\\Off;"), watched("ConfJ\\On?On\\Off?Off;")], [(false, false), (true, true)]);
    let is_led = |line: &str| matches!(of(line).goal, Goal::Opaque(_));
    assert!(is_led("SyncToSensor S\\On?On\\Off?Off;") && !is_led("SyncToSensor S\\Off;"));
}
