//! New points: their zone, time, process and place in the text.

use super::*;

#[test]
fn a_new_point_is_a_copy_of_the_statement_with_the_finest_zone_that_fits() {
    let source = program("", &format!("    {INLINE} ! away"));
    let out = |clearance_m: f64| rewritten(&source, &inserted(&source, 0, 9.5, 0.5, clearance_m));
    let copy = "    MoveAbsJ [[9.5000,20,30,40,50,60],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,z0,tool0;\n    MoveAbsJ [[10,";
    assert!(out(0.01).contains(copy), "{}", out(0.01));
    assert!(out(0.000_237).contains(",v100,z0\\Z:=0.23,tool0;\n"), "{}", out(0.000_237));
    assert!(out(0.000_001).contains(",v100,fine,tool0;\n"));
}

#[test]
fn a_copy_of_an_exact_stop_stops_and_drops_what_happens_at_its_end() {
    let source = program(
        J,
        "MoveAbsJ \\Conc, j1\\NoEOffs, v100\\V:=50, fine\\Inpos:=inpos20, tool0 \\WObj:=wobj0 \\TLoad:=load0;",
    );
    let out = rewritten(&source, &inserted(&source, 0, 0.5, 0.5, 0.01));
    let copy = "MoveAbsJ [[0.5000,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]]\\NoEOffs, v100\\V:=50, fine, tool0\\WObj:=wobj0\\TLoad:=load0;\n";
    assert!(out.contains(copy), "{out}");
    assert_eq!(moves(&source)[0].speed, Speed::Tcp(0.05));
}

#[test]
fn a_time_is_shared_out_over_the_new_points() {
    let source = program(J, "MoveAbsJ j1, v100\\T:=2, z10, tool0;");
    assert_eq!(moves(&source)[0].speed, Speed::Seconds(2.0));
    let out = rewritten(&source, &inserted(&source, 0, 0.5, 0.25, 0.01));
    assert!(out.contains("v100\\T:=0.5000, z0, tool0;\nMoveAbsJ j1, v100\\T:=1.5000, z10"), "{out}");
    let computed = program(J, "MoveAbsJ j1, v100\\T:=n, z10, tool0;");
    assert!(moves(&computed)[0].closed.as_ref().unwrap().to_string().contains("\\T"));
}

#[test]
fn synchronised_moves_a_lone_statement_of_an_if_and_arcs_take_no_new_points() {
    let cases = [
        (format!("{J}\nPERS tasks t{{2}}:=[[\"A\"],[\"B\"]];"), "MoveAbsJ j1\\ID:=10,v100,fine,tool0;", "synchronised"),
        (J.into(), "SyncMoveOn s1,t;\nMoveAbsJ j1,v100,fine,tool0;\nSyncMoveOff s2;", "synchronised"),
        (J.into(), "IF ok MoveAbsJ j1,v100,fine,tool0;", "IF"),
        (String::new(), "MoveC p1,p2,v100,fine,tool0;", "arc"),
        (String::new(), "TriggL p1,v100,gun,fine,tool0;", "actions"),
    ];
    for (declarations, body, why) in cases {
        let all = moves(&program(&declarations, body));
        assert!(all[0].closed.as_ref().unwrap().to_string().contains(why), "{body}: {:?}", all[0].closed);
    }
    let edits = inserted(&program(J, "IF ok MoveAbsJ j1,v100,fine,tool0;"), 0, 0.5, 0.5, 0.01);
    assert!(document(&program(J, "IF ok MoveAbsJ j1,v100,fine,tool0;")).patches(&edits).is_err());
}

#[test]
fn zones_and_speeds_are_those_of_the_language_or_declared() {
    let declarations = "CONST speeddata vMine:=[250,500,5000,1000];\nPERS zonedata zMine:=[FALSE,2.5,8,8,0.8,8,0.8];\nCONST zonedata zStop:=[TRUE,0,0,0,0,0,0];";
    let cases = [
        ("v5,fine", Speed::Tcp(0.005), Some(0.0)),
        ("v7000,z200", Speed::Tcp(7.0), Some(0.2)),
        ("vmax,z0", Speed::Share(1.0), Some(0.0003)),
        ("vMine,zMine", Speed::Tcp(0.25), Some(0.0025)),
        ("v100\\V:=30,zStop", Speed::Tcp(0.03), Some(0.0)),
        ("[80,1,1,1],z10\\Z:=4", Speed::Tcp(0.08), Some(0.004)),
        ("vOther,zOther", Speed::Unknown, None),
        ("v123,z7", Speed::Unknown, None),
    ];
    for (arguments, speed, blend_m) in cases {
        let m = &moves(&program(&format!("{J}\n{declarations}"), &format!("MoveAbsJ j1,{arguments},tool0;")))[0];
        assert_eq!(m.speed, speed, "{arguments}");
        let close = |a: Option<f64>, b: Option<f64>| a.zip(b).map_or(a == b, |(a, b)| (a - b).abs() < 1e-9);
        assert!(close(m.blend_m, blend_m), "{arguments}: {:?}", m.blend_m);
    }
}

#[test]
fn a_straight_move_is_not_stopped_on_its_way_and_ends_as_it_did() {
    let p = "CONST robtarget p1:=[[500,-20,300.5],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];";
    let source = program(p, "MoveL p1,v100,fine,tool0\\WObj:=wobj0;");
    for (clearance_m, zone) in [(0.01, "z0"), (0.000_128, "z0\\Z:=0.12"), (0.000_001, "fine")] {
        let mut edits = inserted(&source, 0, 9.5, 0.5, clearance_m);
        edits.steps.retain(|_, edit| {
            edit.as_joint_moves = true;
            edit.goal = Some(vec![0.1; 6]);
            true
        });
        let doc = document(&source);
        let out = text::apply(&doc.script().texts, &doc.patches(&edits).unwrap()).unwrap().remove(0);
        let out = String::from_utf8(out).unwrap();
        let lines: Vec<&str> = out.lines().filter(|l| l.contains("MoveAbsJ")).collect();
        assert!(lines[0].contains(&format!(",v100,{zone},tool0")), "{out}");
        assert!(lines[1].contains(",v100,fine,tool0"), "{out}");
    }
    // a joint move that stops exactly has copies that do
    let source = program(J, "MoveAbsJ j1,v100,fine,tool0;");
    assert!(rewritten(&source, &inserted(&source, 0, 9.5, 0.5, 0.01)).matches(",fine,").count() == 2);
}

#[test]
fn a_move_whose_arguments_call_a_foreign_function_is_not_copied() {
    let m = &moves(&program(J, "MoveAbsJ j1,SpeedOf(3),z10,tool0;"))[0];
    assert!(m.closed.as_ref().unwrap().to_string().contains("function"));
    assert_eq!(kinds(&program(J, "MoveAbsJ j1,SpeedOf(3),z10,tool0;"))[1..], ["Call", "move"]);
}

#[test]
fn a_new_point_keeps_the_bytes_of_its_statement() {
    let list = |j1: &str| format!("[[{j1},0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]]");
    let source = program("", &format!("MoveAbsJ {},v\u{e4},fine,tGr\u{e4};", list("10")));
    for bytes in [source.chars().map(|c| c as u8).collect::<Vec<u8>>(), source.clone().into_bytes()] {
        let doc = harness::parse(&Rapid, &bytes, &robot()).unwrap();
        let (k, m) = doc.script().moves().next().map(|(k, m)| (k, m.clone())).unwrap();
        let q: Vec<f64> =
            doc.script().targets.get(m.goal.target().unwrap()).unwrap().values.iter().map(|v| v.unwrap().si).collect();
        let mut edits = Edits { digit: vec![1e-6; 6], ..Edits::default() };
        let point = NewPoint { q, share: 0.5, t_s: None, clearance_m: 0.01, of_way: false, waits: false };
        edits.steps.insert(k, Edit { before: vec![point], ..Edit::default() });
        let out = harness::applied(doc.as_ref(), &edits).unwrap().remove(0);
        let count = |text: &[u8], part: &[u8]| text.windows(part.len()).filter(|w| *w == part).count();
        let old = &bytes[bytes.windows(2).position(|w| w == b",v").unwrap()..];
        let speed_to_end = &old[..old.iter().position(|b| *b == b';').unwrap()];
        assert_eq!(
            (count(&bytes, speed_to_end), count(&out, speed_to_end)),
            (1, 2),
            "{}",
            String::from_utf8_lossy(&out)
        );
    }
}

#[test]
fn no_point_is_added_on_a_straight_way_on_which_singarea_turns_the_wrist() {
    let body = |area: &str| {
        format!("{area}MoveL [[900,0,1000],[0.5,0,0.8660254,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;")
    };
    let closed = |area: &str| moves(&program("", &body(area)))[0].closed.is_some();
    assert!(closed("SingArea\\Wrist;\n") && closed("SingArea \\LockAxis4;\n"));
    assert!(!closed("") && !closed("SingArea\\Off;\n") && !closed("SingArea\\Wrist;\nSingArea\\Off;\n"));
    let way = |area: &str| moves(&program("", &body(area)))[0].other_way;
    assert_eq!((way("SingArea\\Wrist;\n"), way("")), (Some(OtherWay::Wrist), None));
    assert_eq!(way("SingArea\\Wrist;\nSingArea\\Off;\n"), None);
}

#[test]
fn arcs_whose_orientation_goes_by_the_point_on_their_way_are_said_to_go_otherwise() {
    let body = |mode: &str| {
        let pose = |x: i32| format!("[[{x},0,1000],[0.5,0,0.8660254,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]");
        format!("{mode}MoveC {},{},v100,fine,tool0;\nMoveL {},v100,fine,tool0;", pose(900), pose(950), pose(800))
    };
    let ways = |mode: &str| moves(&program("", &body(mode))).iter().map(|m| m.other_way).collect::<Vec<_>>();
    for mode in ["CirPathMode \\CirPointOri;\n", "CirPathMode\\Wrist45;\n"] {
        assert_eq!(ways(mode), [Some(OtherWay::Orientation), None], "{mode}");
    }
    for mode in ["", "CirPathMode \\PathFrame;\n", "CirPathMode;\n"] {
        assert_eq!(ways(mode), [None, None], "{mode}");
    }
}

#[test]
fn a_movec_is_split_into_arcs() {
    let list = |x: f64| format!("[[{x:.1},0,700],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]");
    let arc = "MoveC pVia, Offs(pEnd,0,0,10), v100, z10, tool0\\WObj:=wobj0;";
    let source = |arc: &str| {
        let declared = format!("CONST robtarget pVia:={};\nCONST robtarget pEnd:={};", list(1.0), list(500.0));
        program(&declared, &format!("MoveL {},v100,z1,tool0;\n{arc}", list(400.0)))
    };
    let text_of = source(arc);
    let doc = document(&text_of);
    let (step, m) = doc.script().moves().nth(1).unwrap();
    assert_eq!(m.closed, None);
    let Goal::Pose(goal) = &m.goal else { panic!() };
    let own: Vec<f64> =
        doc.script().targets.get(goal.target.unwrap()).unwrap().values.iter().map(|v| v.unwrap().si).collect();
    let point = |x: f64, share| {
        let q = std::iter::once(x).chain(own[1..].iter().copied()).collect();
        NewPoint { q, share, t_s: None, clearance_m: 0.01, of_way: false, waits: false }
    };
    let vias = vec![vec![0.4, 0.05, 0.71], vec![0.411, 0.002, 0.71], vec![0.45, 0.0051, 0.71]];
    let edit = Edit { before: vec![point(0.41, 0.5), point(0.4115, 0.52)], vias, ..Edit::default() };
    let edits = Edits { steps: [(step, edit.clone())].into(), pose_digit: [1e-7, 1e-6], ..Edits::default() };
    let bytes = text::apply(&doc.script().texts, &doc.patches(&edits).unwrap()).unwrap();
    let out = String::from_utf8(bytes[0].clone()).unwrap();
    let at = |xyz: &str| format!("[[{xyz}],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]");
    let first = format!(
        "MoveC {}, Offs({},0,0,10), v100, z0, tool0\\WObj:=wobj0;",
        at("400.0000,50.0000,710.0000"),
        at("410.0000,0,700")
    );
    let short = format!(
        "MoveC {}, Offs({},0,0,10), v100, z0, tool0\\WObj:=wobj0;",
        at("411.0000,2.0000,710.0000"),
        at("411.5000,0,700")
    );
    let last = format!("MoveC {}, Offs(pEnd,0,0,10), v100, z10, tool0\\WObj:=wobj0;", at("450.0000,5.1000,710.0000"));
    for line in [first, short, last] {
        assert!(out.contains(&line), "{line}\n{out}");
    }
    let whole = Edits { steps: [(step, Edit { vias: Vec::new(), ..edit })].into(), ..edits.clone() };
    assert!(doc.patches(&whole).is_err());
    // the point on the way alone
    let moved = Edit { vias: vec![vec![0.45, 0.0051, 0.71]], ..Edit::default() };
    let moved = Edits { steps: [(step, moved)].into(), ..edits };
    let bytes = text::apply(&doc.script().texts, &doc.patches(&moved).unwrap()).unwrap();
    let via = at("450.0000,5.1000,710.0000");
    assert_eq!(String::from_utf8(bytes[0].clone()).unwrap(), text_of.replace("MoveC pVia", &format!("MoveC {via}")));
    for other in [
        arc.replace("pVia", "[[1,0,700],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"),
        arc.replace("pVia", "pElse"),
        format!("CirPathMode\\ObjectFrame;\n{arc}"),
        arc.replace("MoveC", "MoveCDO").replace(";", ",do1,1;"),
        arc.replace("Offs(pEnd,0,0,10)", "Offs(pEnd,0,0,10)\\ID:=5"),
    ] {
        let source = source(&other);
        assert!(document(&source).script().moves().nth(1).unwrap().1.closed.is_some(), "{other}");
    }
}

/// A track under the robot comes before its joints in the robot file, and after them in a target.
#[test]
fn a_new_point_of_a_robot_on_a_track_has_two_lists() {
    let track = Axis::new("eax_a", JointKind::Prismatic);
    let joints = (1..=6).map(|k| Axis::new(format!("J{k}"), JointKind::Revolute));
    let robot = Axes::new("arm on a track", std::iter::once(track).chain(joints).collect());
    let list = "[[10,20,30,40,50,60],[1000,9E9,9E9,9E9,9E9,9E9]]";
    let declared = program(&format!("CONST jointtarget j1:={list};"), "MoveAbsJ j1,v100,fine,tool0;");
    for source in [program("", &format!("MoveAbsJ {list},v100,fine,tool0;")), declared] {
        let doc = harness::parse(&Rapid, source.as_bytes(), &robot).unwrap();
        let (step, m) = doc.script().moves().next().unwrap();
        let target = doc.script().targets.get(m.goal.target().unwrap()).unwrap();
        let mut q: Vec<f64> = target.values.iter().map(|v| v.unwrap().si).collect();
        assert_eq!(q.len(), 7);
        (q[0], q[1]) = (0.9, 9.5_f64.to_radians());
        let point = NewPoint { q, share: 0.5, t_s: None, clearance_m: 0.01, of_way: false, waits: false };
        let mut edits = Edits { digit: vec![1e-4_f64.to_radians(); 7], ..Edits::default() };
        edits.steps.insert(step, Edit { before: vec![point], ..Edit::default() });
        assert_eq!(round_trip(&Rapid, source.as_bytes(), &robot, &edits), Ok(Outcome::Kept));
        let out = text::apply(&doc.script().texts, &doc.patches(&edits).unwrap()).unwrap();
        let out = String::from_utf8(out.into_iter().next().unwrap()).unwrap();
        let new = "MoveAbsJ [[9.5000,20,30,40,50,60],[900.000,9E9,9E9,9E9,9E9,9E9]],v100,";
        assert!(out.contains(new), "{out}");
    }
}
