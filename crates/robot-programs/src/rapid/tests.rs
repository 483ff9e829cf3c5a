//! Every trap of RAPID programs that we know of.

mod project;

use super::*;
use crate::script::harness::{self, Outcome, opaque, round_trip};
use crate::script::pose::{Configuration, Frame};
use crate::script::{Break, Edit, Goal, Move, NewPoint, Solution, Speed, StepKind, Value, text};

use crate::fixtures::irb1600 as robot;

/// A module with these declarations and this body of `main`.
fn program(declarations: &str, body: &str) -> String {
    format!("MODULE T\n{declarations}\nPROC main()\n{body}\nENDPROC\nENDMODULE\n")
}

fn document(source: &str) -> Box<dyn Document> {
    harness::parse(&Rapid, source.as_bytes(), &robot()).unwrap()
}

fn moves(source: &str) -> Vec<Move> {
    document(source).script().moves().map(|(_, m)| m.clone()).collect()
}

/// Values of the target of move `n`.
fn values(source: &str, n: usize) -> Vec<Option<Value>> {
    let doc = document(source);
    let (_, m) = doc.script().moves().nth(n).unwrap();
    let Goal::Joints(t) = m.goal else { panic!("{:?}", m.goal) };
    doc.script().targets.get(t).unwrap().values.iter().collect()
}

fn degrees(source: &str, n: usize) -> Vec<Option<f64>> {
    let round = |v: f64| (v.to_degrees() * 1e7).round() / 1e7;
    values(source, n).iter().map(|v| v.map(|v| round(v.si))).collect()
}

fn kinds(source: &str) -> Vec<String> {
    harness::kinds(document(source).script())
}

/// Moves axis 0 of the named moves (by number) by degrees.
fn shifted(source: &str, by: &[(usize, f64)]) -> Edits {
    let by: Vec<(usize, f64)> = by.iter().map(|(k, deg)| (*k, deg.to_radians())).collect();
    harness::shifted(document(source).script(), &by, 1e-5_f64.to_radians())
}

fn rewritten(source: &str, edits: &Edits) -> String {
    assert_eq!(round_trip(&Rapid, source.as_bytes(), &robot(), edits), Ok(Outcome::Kept));
    let doc = document(source);
    let bytes = text::apply(&doc.script().texts, &doc.patches(edits).unwrap()).unwrap();
    String::from_utf8(bytes.into_iter().next().unwrap()).unwrap()
}

/// One new point before move `n`, with axis 0 at `deg`.
fn inserted(source: &str, n: usize, deg: f64, share: f64, clearance_m: f64) -> Edits {
    let doc = document(source);
    let (step, m) = doc.script().moves().nth(n).unwrap();
    let mut q = match m.goal {
        Goal::Joints(t) => {
            doc.script().targets.get(t).unwrap().values.iter().map(|v| v.map_or(0.0, |v| v.si)).collect()
        }
        _ => vec![0.0; 6],
    };
    q[0] = f64::to_radians(deg);
    let point = NewPoint { q, share, t_s: None, clearance_m, of_way: false };
    let mut edits = Edits { digit: vec![1e-4_f64.to_radians(); 6], ..Edits::default() };
    edits.steps.insert(step, Edit { before: vec![point], ..Edit::default() });
    edits
}

const J: &str = "CONST jointtarget j1:=[[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]];";
const INLINE: &str = "MoveAbsJ [[10,20,30,40,50,60],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,z10,tool0;";

#[test]
fn an_inline_target_is_read_in_degrees_and_unused_axes_are_left_out() {
    let source =
        program("", "MoveAbsJ [[1.5,-2,+3,.25,5.,9.60894E-05],[9E9,9E+09,1E+10,9e9,0,0]]\\NoEOffs, v1000, z50, tool0;");
    assert_eq!(degrees(&source, 0), [1.5, -2.0, 3.0, 0.25, 5.0, 0.0000961].map(Some));
    let unused = program("", "MoveAbsJ [[1,2,9E9,9E+09,1E+10,6],[9E9,9E9,9E9,9E9,9E9,9E9]],v5,fine,tool0;");
    assert_eq!(degrees(&unused, 0), [Some(1.0), Some(2.0), None, None, None, Some(6.0)]);
}

#[test]
fn a_changed_number_takes_the_digits_it_needs_and_every_other_byte_stays() {
    let source = program(
        "",
        "  MoveAbsJ [[ 10.5 , 20,30,40,50,9.60894E-05],[9E9,9E9,9E9,9E9,9E9,9E9]]\\NoEOffs, v100, z10, tool0; ! caf\u{e9}",
    );
    assert_eq!(rewritten(&source, &shifted(&source, &[(0, 0.00123)])), source.replace("10.5", "10.50123"));
}

#[test]
fn an_exponent_is_written_plainly_when_it_changes() {
    let source = program("", "MoveAbsJ [[9.60894E-05,20,30,40,50,60],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,z10,tool0;");
    assert_eq!(rewritten(&source, &shifted(&source, &[(0, 0.002)])), source.replace("9.60894E-05", "0.002096"));
}

#[test]
fn numbers_are_written_no_finer_than_single_precision() {
    let source = program("", "MoveAbsJ [[123.4,20,30,40,50,60],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,z10,tool0;");
    let mut edits = shifted(&source, &[(0, 0.001_234_567)]);
    edits.digit = vec![1e-12; 6];
    assert_eq!(rewritten(&source, &edits), source.replace("123.4", "123.4012"));
}

#[test]
fn one_target_of_two_moves_that_want_the_same_is_edited_in_place() {
    let source = program(J, "MoveAbsJ j1,v100,fine,tool0;\nMoveAbsJ j1,v100,fine,tool0;");
    let out = rewritten(&source, &shifted(&source, &[(0, 0.002), (1, 0.002)]));
    assert_eq!(out, source.replace("[[1,2", "[[1.00200,2"));
}

#[test]
fn a_target_with_an_unedited_use_is_cloned_beside_its_declaration() {
    let source = program(&format!("    {J} ! home"), "MoveAbsJ j1,v100,fine,tool0;\nMoveAbsJ j1,v100,fine,tool0;");
    let out = rewritten(&source, &shifted(&source, &[(1, 0.002)]));
    let clone = "! home\n    CONST jointtarget j1_lm1:=[[1.00200,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]];\n";
    assert!(out.contains(clone), "{out}");
    assert!(out.contains("MoveAbsJ j1,v100,fine,tool0;\nMoveAbsJ j1_lm1,v100"), "{out}");
    assert!(out.contains("j1:=[[1,2,"), "{out}");
}

#[test]
fn a_target_whose_value_is_read_elsewhere_is_cloned() {
    let source = program(J, "MoveAbsJ j1,v100,fine,tool0;\nx:=j1.robax.rax_1;");
    let out = rewritten(&source, &shifted(&source, &[(0, 0.002)]));
    assert!(out.contains("j1:=[[1,2,") && out.contains("MoveAbsJ j1_lm1,"), "{out}");
}

#[test]
fn a_global_target_of_a_module_without_main_is_cloned_as_other_modules_may_use_it() {
    let source = format!("MODULE M\n{J}\nPROC p()\nMoveAbsJ j1,v100,fine,tool0;\nENDPROC\nENDMODULE\n");
    let out = rewritten(&source, &shifted(&source, &[(0, 0.002)]));
    assert!(out.contains("j1:=[[1,2,") && out.contains("MoveAbsJ j1_lm1,"), "{out}");
    let local = source.replace("CONST", "LOCAL CONST");
    assert_eq!(rewritten(&local, &shifted(&local, &[(0, 0.002)])), local.replace("[[1,2", "[[1.00200,2"));
}

#[test]
fn a_clone_has_the_storage_class_and_a_fresh_name_of_32_characters_at_most() {
    let name = "jAVeryLongNameOfATargetInThisCel";
    let declarations = format!(
        "LOCAL PERS jointtarget {name}:=[[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]]; VAR num n;\nVAR num jaVeryLongNameOfATargetI_lm1;"
    );
    let source = program(&declarations, &format!("MoveAbsJ {name},v100,fine,tool0;\nMoveAbsJ {name},v100,fine,tool0;"));
    let out = rewritten(&source, &shifted(&source, &[(0, 0.002)]));
    let clone = out.split("LOCAL PERS jointtarget ").nth(2).unwrap().split(":=").next().unwrap();
    assert_eq!(clone, "jAVeryLongNameOfATargetI_lm1".replace("I_lm1", "_lm1"), "{out}");
    assert!(clone.len() <= 32 && out.contains(&format!("; LOCAL PERS jointtarget {clone}:=")), "{out}");
}

#[test]
fn a_clones_name_avoids_every_word_of_the_file() {
    let source =
        program(&format!("{J}\nVAR num J1_LM1;"), "MoveAbsJ j1,v100,fine,tool0;\nMoveAbsJ j1,v100,fine,tool0;");
    assert!(rewritten(&source, &shifted(&source, &[(0, 0.002)])).contains("MoveAbsJ j1_lm2,"));
}

#[test]
fn one_name_in_two_routines_means_two_targets() {
    let source = "MODULE M\nPROC a()\nCONST jointtarget j:=[[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]];\nMoveAbsJ j,v10,fine,tool0;\nENDPROC\nPROC b()\nVAR jointtarget J:=[[7,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]];\nMoveAbsJ j,v10,fine,tool0;\nENDPROC\nENDMODULE\n";
    assert_eq!((degrees(source, 0)[0], degrees(source, 1)[0]), (Some(1.0), Some(7.0)));
    let out = rewritten(source, &shifted(source, &[(1, 0.002)]));
    assert_eq!(out, source.replace("[[7,", "[[7.00200,"));
}

#[test]
fn a_routines_own_target_hides_the_modules() {
    let source =
        program(J, "CONST jointtarget j1:=[[8,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]];\nMoveAbsJ j1,v100,fine,tool0;");
    assert_eq!(degrees(&source, 0)[0], Some(8.0));
}

#[test]
fn a_parameter_hides_a_target_of_the_same_name() {
    let source = format!(
        "MODULE M\n{J}\nPROC p(INOUT jointtarget j1, \\switch slow)\nMoveAbsJ j1,v100,fine,tool0;\nENDPROC\nENDMODULE"
    );
    assert!(opaque(&moves(&source)[0]).contains("parameter"));
}

#[test]
fn an_array_element_with_a_literal_index_is_a_target_and_a_computed_index_is_not() {
    let list = |n: u8| format!("[[{n},2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]]");
    let declarations = format!("CONST jointtarget a{{3}}:=[{},{},\n {}];", list(1), list(2), list(3));
    let source = program(&declarations, "MoveAbsJ a{2},v100,fine,tool0;\nMoveAbsJ a{3},v100,fine,tool0;");
    assert_eq!((degrees(&source, 0)[0], degrees(&source, 1)[0]), (Some(2.0), Some(3.0)));
    assert_eq!(rewritten(&source, &shifted(&source, &[(0, 0.002)])), source.replace("[[2,2", "[[2.00200,2"));
    let computed = program(
        &declarations,
        "MoveAbsJ a{2},v100,fine,tool0;\nFOR i FROM 1 TO 3 DO\nMoveAbsJ a{i},v100,fine,tool0;\nENDFOR",
    );
    assert!(opaque(&moves(&computed)[1]).contains("index"));
    // the loop needs the old value, so the first move gets its own
    let out = rewritten(&computed, &shifted(&computed, &[(0, 0.002)]));
    assert!(out.contains("CONST jointtarget a_2_lm1:=[[2.00200,2") && out.contains("MoveAbsJ a_2_lm1,v100"), "{out}");
}

#[test]
fn a_target_that_is_assigned_anywhere_is_not_certain() {
    let var = J.replace("CONST", "VAR");
    for statement in [
        "j1:=CJointT();",
        "j1.robax.rax_1:=5;",
        "Teach j1;",
        "x:=Measure(j1);",
        "ok:=StrToVal(s,j1.robax);",
        "SetDataVal \"j1\", n;",
    ] {
        let source = program(&var, &format!("MoveAbsJ j1,v100,fine,tool0;\n{statement}"));
        assert!(opaque(&moves(&source)[0]).contains("j1"), "{statement}");
    }
    // what cannot set it leaves it certain
    for statement in
        ["TPWrite \"at \"+ValToStr(j1);", "x:=j1.robax.rax_1;", "p1:=CalcRobT(j1,tool0);", "IF j1=j2 THEN Stop; ENDIF"]
    {
        let source = program(&var, &format!("MoveAbsJ j1,v100,fine,tool0;\n{statement}"));
        assert!(matches!(moves(&source)[0].goal, Goal::Joints(_)), "{statement}");
    }
}

#[test]
fn a_global_pers_is_certain_only_in_the_program_that_holds_main_and_a_note_says_so() {
    let pers = J.replace("CONST", "PERS");
    let source = program(&pers, "MoveAbsJ j1,v100,fine,tool0;");
    assert!(matches!(moves(&source)[0].goal, Goal::Joints(_)));
    assert!(document(&source).script().notes[0].text.contains("global PERS"));
    let elsewhere = source.replace("main", "other");
    assert!(opaque(&moves(&elsewhere)[0]).contains("another module may set it"));
}

#[test]
fn a_target_of_another_module_a_computed_target_and_a_function_are_opaque() {
    let cases = [
        ("MoveAbsJ jHome,v100,fine,tool0;", "declared in another module"),
        ("MoveAbsJ [[a,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;", "no plain number"),
        ("MoveAbsJ [[1+1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;", "no plain number"),
        ("MoveAbsJ CalcJointT(p1,tool0),v100,fine,tool0;", "computes"),
        ("MoveL Offs(p1,0,0,n+1),v100,fine,tool0;", "computes"),
        ("MoveL RelTool(p1,0,0,10\\Rz:=n),v100,fine,tool0;", "computes"),
    ];
    for (statement, why) in cases {
        let all = moves(&program("", statement));
        assert!(opaque(&all[0]).contains(why), "{statement}: {}", opaque(&all[0]));
    }
}

#[test]
fn external_axes_may_be_a_name_where_the_robot_has_six_axes() {
    let source = program("", "MoveAbsJ [[1,2,3,4,5,6],extj],v100,z10,tool0;");
    let out = rewritten(&source, &inserted(&source, 0, 0.5, 0.5, 0.01));
    assert!(out.contains("MoveAbsJ [[0.5000,2,3,4,5,6],extj],v100,z0,tool0;"), "{out}");
}

#[test]
fn external_axes_are_the_robots_axes_from_the_seventh_on() {
    let robot = crate::fixtures::irb1600_on_a_rail();
    let source = program("", "MoveAbsJ [[1,2,3,4,5,6],[1234.5,9E9,9E9,9E9,9E9,9E9]],v100,z10,tool0;");
    let doc = harness::parse(&Rapid, source.as_bytes(), &robot).unwrap();
    assert_eq!(doc.script().targets.get(0).unwrap().values.len(), 7);
    assert!((doc.script().targets.get(0).unwrap().values.get(6).unwrap().si - 1.2345).abs() < 1e-12);
}

#[test]
fn a_target_with_five_numbers_is_refused_at_its_place() {
    let source = program("", "MoveAbsJ [[1,2,3,4,5],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;");
    let message = harness::parse(&Rapid, source.as_bytes(), &robot()).err().unwrap().to_string();
    assert!(message.starts_with("job:4:11: found 5 numbers"), "{message}");
}

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
    assert!(moves(&computed)[0].closed.as_ref().unwrap().contains("\\T"));
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
        assert!(all[0].closed.as_ref().unwrap().contains(why), "{body}: {:?}", all[0].closed);
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
    assert_eq!(displaced, Frame::Named("wobj0 displaced by PDispOn or PDispSet".into()));
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
    let point = NewPoint { q: numbers.clone(), share: 0.5, t_s: None, clearance_m: 0.01, of_way: false };
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
    let point = NewPoint { q: vec![0.1; 6], share: 0.5, t_s: None, clearance_m: 1.0, of_way: false };
    edits.steps.insert(1, Edit { before: vec![point], ..Edit::default() });
    let out = text::apply(&doc.script().texts, &doc.patches(&edits).unwrap()).unwrap().remove(0);
    assert_eq!(out.iter().filter(|&&b| b == b'\n').count(), source.iter().filter(|&&b| b == b'\n').count() + 1);
    assert!(out.windows(2).filter(|w| w[1] == b'\n').all(|w| w[0] == b'\r'));
    assert!(out.windows(4).any(|w| w == b"gr\xFC\xDF"));
}

#[test]
fn branches_loops_labels_calls_handlers_and_interrupts_end_what_is_known() {
    let move_ = "MoveAbsJ j1,v100,fine,tool0;";
    let source = program(
        J,
        &format!(
            "IF x=1 THEN\n{move_}\nELSE\n{move_}\nENDIF\nWHILE TRUE DO\n{move_}\nENDWHILE\nTEST n\nCASE 1,2:\n{move_}\nDEFAULT:\n{move_}\nENDTEST\nlab:\nGOTO lab;\nElsewhere;\n%\"proc\"+s%;\nCONNECT i1 WITH tr;\nISignalDI d,1,i1;\nPDispOn p1,tool0;\nERROR\nRETRY;"
        ),
    );
    let expected = [
        "Start",
        "Jump",
        "move",
        "Jump",
        "move",
        "Jump",
        "Loop",
        "move",
        "Loop",
        "Jump",
        "Jump",
        "move",
        "Jump",
        "move",
        "Jump",
        "Jump",
        "Jump",
        "Call",
        "Call",
        "Interrupt",
        "Interrupt",
        "Frame",
        "Start",
        "Jump",
    ];
    assert_eq!(kinds(&source), expected);
}

#[test]
fn a_trap_that_may_move_is_said() {
    let trap = |body: &str| {
        program(J, "CONNECT i1 WITH tr;").replace("ENDMODULE", &format!("TRAP tr\n{body}\nENDTRAP\nENDMODULE"))
    };
    let said = |source: &str| {
        let d = document(source);
        d.script().notes.iter().any(|n| n.text.starts_with("tr may move the robot while the program waits or moves"))
    };
    assert!(said(&trap("MoveAbsJ j1,v10,fine,tool0;")));
    assert!(!said(&trap("Set d1;")));
    assert!(!said(&program(J, "CONNECT i1 WITH elsewhere;")));
}

#[test]
fn what_does_not_move_ends_nothing() {
    let body = "MoveAbsJ j1,v100,fine,tool0;\nSet d1;\nWaitTime 0.5;\nWaitTime \\InPos, n;\nWaitDI d,1;\nIF d=1 THEN\n  SetDO e,0;\nELSEIF f\n  THEN Reset e;\nENDIF\nWHILE d=0 DO\nWaitTime 0.1;\nENDWHILE\nIF e GOTO lab2;\nx:=Sin(y)+n{2};\nConfL\\Off;\nGrip 5;";
    let source = program(J, body).replace(
        "ENDMODULE",
        "PROC Grip(num n)\nSetDO g,n;\nOpen2;\nENDPROC\nPROC Open2()\nWaitDI g,1;\nENDPROC\nENDMODULE",
    );
    let steps = kinds(&source);
    assert_eq!(
        steps[..7],
        ["Start", "move", "dwell Some(0.5)", "dwell None", "dwell None", "dwell Some(0.1)", "Start"],
        "{steps:?}"
    );
}

#[test]
fn a_routine_that_moves_through_another_one_is_a_call() {
    let source = program(J, "Grip 5;").replace(
        "ENDMODULE",
        "PROC Grip(num n)\nOpen2;\nENDPROC\nPROC Open2()\nMoveAbsJ j1,v10,fine,tool0;\nENDPROC\nENDMODULE",
    );
    assert_eq!(kinds(&source)[..2], ["Start", "Call"]);
    let function = program(J, "x:=Foreign(5);");
    assert_eq!(kinds(&function), ["Start", "Call"]);
}

#[test]
fn processes_are_noted() {
    let body = "ArcLStart p1,v100,s1,w1,fine,tool0;\nArcL p2,v100,s1,w1,z1,tool0;\nArcLEnd p3,v100,s1,w1,fine,tool0;\nDispL \\On,p1,v100,b1,z5,tool0;\nDispL \\Off,p1,v100,b1,z5,tool0;\nSpotL p4,v500,sp1,gun1,tool0;";
    let expected = [
        "Start",
        "move",
        "process true",
        "move",
        "move",
        "process false",
        "move",
        "process true",
        "move",
        "process false",
        "move",
        "dwell None",
    ];
    assert_eq!(kinds(&program("", body)), expected);
}

#[test]
fn pragmas_are_steps() {
    let body = "! lostmotion: off\nMoveAbsJ j1,v100,fine,tool0; ! lostmotion: on\nMoveAbsJ j1,v100,fine,tool0;";
    assert_eq!(kinds(&program(J, body)), ["Start", "pragma false", "move", "pragma true", "move"]);
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
fn a_search_ends_anywhere_and_external_axes_alone_are_a_pause() {
    let body = "SearchL \\Stop,di1,psearch,p1,v50,tool0;\nMoveExtJ j1,vrot10,fine;";
    assert_eq!(kinds(&program(J, body)), ["Start", "move", "dwell None"]);
    assert!(opaque(&moves(&program(J, body))[0]).contains("search"));
}

#[test]
fn a_search_sets_the_point_that_it_finds_and_no_other() {
    let data = "[[500,0,400],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    let declared = format!("LOCAL PERS robtarget pseam:={data};\nLOCAL PERS robtarget pend:={data};");
    let body = "SearchL \\Stop,di1,pseam,pend,v50,tool0;\nMoveL pseam,v100,fine,tool0;\nMoveL pend,v100,fine,tool0;";
    let all = moves(&program(&declared, body));
    assert!(opaque(&all[1]).contains("`SearchL`, which may set it"));
    assert!(matches!(all[2].goal, Goal::Pose(_)));
}

#[test]
fn a_calibration_takes_joints_and_sets_its_tool_and_another_routine_of_its_name_may_set_all() {
    let joints = "[[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    let declared: String = (1..=6).map(|k| format!("LOCAL PERS jointtarget q{k}:={joints};\n")).collect();
    let move_all: String = (1..=6).map(|k| format!("MoveAbsJ q{k},v100,fine,tool0;\n")).collect();
    let of = |more: &str, calls: &str| -> String {
        let source = program(&format!("{declared}{more}"), &format!("{move_all}{calls}"));
        moves(&source).iter().map(|m| if matches!(m.goal, Goal::Joints(_)) { 'j' } else { 'o' }).collect()
    };
    let calls = "MToolTCPCalib q1,q2,q3,q4,tGun,nMax,nMean;\nMToolRotCalib q4,q5\\XPos:=q6,tGun;";
    assert_eq!(of("", calls), "jjjjjj");
    assert_eq!(of("", "MToolTCPCalib q1,q2,q3,q4,tGun,q5,q6;"), "jjjjoo");
    assert_eq!(of("", "OwnCalib q1,q2,q3,q4,tGun,q5,q6;"), "oooooo");
    let own = "PROC MToolTCPCalib(INOUT jointtarget a)\na.robax.rax_1:=0;\nENDPROC\n";
    let source = program(
        &declared,
        &format!("{move_all}MToolTCPCalib q1;\nENDPROC\n{}", own.trim_end().trim_end_matches("ENDPROC")),
    );
    assert!(opaque(&moves(&source)[0]).contains("which may set it"));
    // what it reads stays: the motion gets a clone
    let point = "[[500,0,400],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    let points: String = (1..=3).map(|k| format!("LOCAL PERS robtarget p{k}:={point};\n")).collect();
    let body = "Search_1D peResult,p1,p2,v100,tool0;\nMoveL p1,v100,fine,tool0;\nMoveL p2,v100,fine,tool0;\nSearch_1D \\NotOff,p3,p1,p2,v100,tool0;\nMoveL p3,v100,fine,tool0;";
    let all = moves(&program(&points, body));
    assert!(matches!(all[0].goal, Goal::Pose(_)) && matches!(all[1].goal, Goal::Pose(_)), "{all:?}");
    assert!(opaque(&all[2]).contains("which may set it"));
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
fn start_of_a_routine_is_a_break_and_at_its_line() {
    let doc = document(&program(J, INLINE));
    let step = &doc.script().steps[0];
    assert!(matches!(step.kind, StepKind::Break(Break::Start)) && step.at.line == 3);
}

#[test]
fn a_move_whose_arguments_call_a_foreign_function_is_not_copied() {
    let m = &moves(&program(J, "MoveAbsJ j1,SpeedOf(3),z10,tool0;"))[0];
    assert!(m.closed.as_ref().unwrap().contains("function"));
    assert_eq!(kinds(&program(J, "MoveAbsJ j1,SpeedOf(3),z10,tool0;"))[1..], ["Call", "move"]);
}

#[test]
fn a_time_may_stand_behind_a_comma_of_its_own() {
    let source = program(J, "MoveAbsJ j1, v100, \\T:=2, z10, tool0;");
    assert_eq!((moves(&source)[0].speed, moves(&source)[0].blend_m), (Speed::Seconds(2.0), Some(0.01)));
    let out = rewritten(&source, &inserted(&source, 0, 0.5, 0.5, 0.01));
    assert!(out.contains("v100, \\T:=1.0000, z0, tool0;\nMoveAbsJ j1, v100, \\T:=1.0000, z10"), "{out}");
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
fn a_procedure_whose_name_begins_with_wait_may_move() {
    let of = |line: &str| {
        kinds(&program(
            "",
            &format!(
                "MoveAbsJ [[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\n{line}\nMoveAbsJ [[2,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;"
            ),
        ))
    };
    let quiet = of("WaitDI d,1;");
    for line in ["WaitHome;", "WaitPartAndMove 5;", "WaitWObj wobjcnv1\\RelDist:=10;", "DropWObj wobjcnv1;"] {
        let now = of(line);
        assert!(
            now.iter().any(|k| k == "Call" || k == "Frame") && !quiet.iter().any(|k| k == "Call"),
            "{line}: {now:?}"
        );
    }
}

/// A module with a procedure that picks, and what `main` does.
fn picking(main: &str, more: &str, head: &str, body: &str) -> String {
    let at = |x: u32| format!("[[{x},0,1000],[0.5,0,0.8660254,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]");
    format!(
        "MODULE M\nCONST robtarget p1:={};\nCONST robtarget p2:={};\nVAR robtarget v1:={};\n{more}PROC main()\n{main}\nENDPROC\n\
         {head}\n{body}ENDPROC\nENDMODULE\n",
        at(900),
        at(910),
        at(920)
    )
}

#[test]
fn a_parameter_to_which_all_calls_pass_one_constant_is_that_constant() {
    const HEAD: &str = "PROC pick(num n,robtarget p)";
    const BODY: &str = "MoveJ Offs(p,0,0,40),v100,z10,tool0;\nMoveL p,v100,fine,tool0;\n";
    let known = |source: &str| moves(source).iter().map(|m| matches!(m.goal, Goal::Pose(_))).collect::<Vec<bool>>();
    let of = |main: &str| known(&picking(main, "", HEAD, BODY));
    assert_eq!(of("pick 1,p1;\npick 2,p1;"), [true, true]);
    assert_eq!(of("pick 1,p1;\nIF a pick 2,p1;"), [true, true]);
    // another point, a variable, a computed one, a call by a computed name, none at all
    for main in ["pick 1,p1;\npick 2,p2;", "pick 1,v1;", "pick 1,Offs(p1,0,0,1);", "pick 1,p1;\n%s%;", "WaitTime 1;"] {
        assert_eq!(of(main), [false, false], "{main}");
    }
    // the procedure changes it, or has a parameter that may be left out; another module may call it; a constant of one routine
    let changed = BODY.replacen("MoveL", "p.trans.z:=1;\nMoveL", 1);
    assert_eq!(known(&picking("pick 1,p1;", "", HEAD, &changed)), [false, false]);
    assert_eq!(known(&picking("pick 1,p1;", "", "PROC pick(num n,robtarget p\\switch s)", BODY)), [false, false]);
    assert_eq!(known(&picking("pick 1,p1;", "", HEAD, BODY).replace("main", "other")), [false, false]);
    let local = picking(
        "CONST robtarget p3:=[[900,0,1000],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\npick 1,p3;",
        "",
        HEAD,
        BODY,
    );
    assert_eq!(known(&local), [false, false]);
    // the move gets a copy, and the call stays
    let go = format!(
        "MODULE M\n{J}\nPROC main()\ngo j1;\nENDPROC\nPROC go(jointtarget q)\nMoveAbsJ q,v100,fine,tool0;\nENDPROC\nENDMODULE\n"
    );
    let out = rewritten(&go, &shifted(&go, &[(0, 0.002)]));
    assert!(
        out.contains("\ngo j1;\n") && out.contains("MoveAbsJ j1_lm1,v100") && out.contains("j1_lm1:=[[1.00200,2"),
        "{out}"
    );
    // a name of the procedure itself hides it
    assert_eq!(known(&picking("pick 1,p1;", "", HEAD, &format!("VAR robtarget p;\n{BODY}"))), [false, false]);
}

#[test]
fn an_axis_of_softness_zero_goes_to_its_targets() {
    let j = |v: f64| format!("MoveAbsJ [[{v},2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\n");
    let left = |source: &str| moves(source).iter().map(|m| matches!(m.goal, Goal::Opaque(_))).collect::<Vec<bool>>();
    let of = |before: &str, after: &str| left(&program("", &format!("{before}\n{}{after}\n{}", j(1.0), j(2.0))));
    assert_eq!(of("SoftAct 4,0;", ""), [false, false]);
    assert_eq!(of("SoftAct 4,50\\Ramp:=200;", "SoftAct 4,0;"), [true, false]);
    assert_eq!(of("SoftAct 4,50;\nSoftAct 3,20;", "SoftAct 4,0;"), [true, true]);
    assert_eq!(of("SoftAct 4,50;\nSoftAct 3,20;", "SoftAct 4,0;\nSoftAct 3,0;"), [true, false]);
    // of an axis that is not known, or of another unit, nothing is
    for on in ["SoftAct n,50;", "SoftAct \\MechUnit:=orbit1,4,50;", "SoftAct 4,s;"] {
        assert!(of(on, "SoftAct 4,0;")[0], "{on}");
    }
    for off in ["SoftAct n,0;", "SoftAct 4,s;", "SoftAct \\MechUnit:=orbit1,4,0;", "IF a SoftAct 4,0;"] {
        assert_eq!(of("SoftAct 4,50;", off), [true, true], "{off}");
    }
    for branch in ["IF a THEN\nSoftAct 4,0;\nENDIF", "FOR i FROM 1 TO n DO\nSoftAct 4,0;\nENDFOR"] {
        assert_eq!(of("SoftAct 4,50;", branch), [true, true], "{branch}");
    }
    // what a branch may have left soft is not made stiff by another axis
    assert_eq!(of("SoftAct 3,50;\nIF a THEN\nSoftDeact;\nENDIF", "SoftAct 4,0;"), [true, true]);
    assert_eq!(of("IF a THEN\nSoftAct 3,50;\nELSE\nSoftAct 3,0;\nENDIF", "SoftAct 4,0;"), [true, true]);
    // what another routine leaves soft may be soft in all
    let two = |body: &str| {
        format!("MODULE T\nPROC main()\nSoftAct 4,0;\n{}ENDPROC\nPROC soft()\n{body}\nENDPROC\nENDMODULE\n", j(1.0))
    };
    assert_eq!(left(&two("SoftAct 3,50;")), [true]);
    assert_eq!(left(&two("SoftAct 4,50;\nIF a RETURN;\nSoftAct 4,0;")), [false]);
    assert_eq!(left(&two("SoftAct 3,50;\nIF a RETURN;\nSoftAct 3,0;")), [true]);
}

#[test]
fn moves_that_a_sensor_or_a_soft_arm_leads_away_stay() {
    let j = |v: f64| format!("MoveAbsJ [[{v},2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\n");
    let left = |source: &str| moves(source).iter().map(|m| matches!(m.goal, Goal::Opaque(_))).collect::<Vec<bool>>();
    for (on, off) in
        [("SoftAct 1,50;", "SoftDeact;"), ("SyncToSensor s\\On;", "SyncToSensor s\\Off;"), ("FCAct tool0;", "FCDeact;")]
    {
        let body = format!("{}{on}\n{}{}{off}\n{}", j(1.0), j(2.0), j(3.0), j(4.0));
        assert_eq!(left(&program("", &body)), [false, true, true, false], "{on}");
        // a branch may be passed by
        for branch in [format!("{on}\nIF a THEN\n{off}\nENDIF\n"), format!("IF a THEN\n{on}\nELSE\n{off}\nENDIF\n")] {
            assert_eq!(left(&program("", &format!("{branch}{}{off}\n{}", j(1.0), j(2.0)))), [true, false], "{branch}");
        }
        // one routine switches it on, another off
        let two = format!("MODULE T\nPROC main()\nsoft;\n{}ENDPROC\nPROC soft()\n{on}\nENDPROC\nENDMODULE\n", j(1.0));
        assert_eq!(left(&two), [true], "{on}");
    }
    let at = "[[900,0,1000],[0.5,0,0.8660254,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]";
    for line in [
        format!("MoveL {at},v100,fine,tool0\\Corr;"),
        format!("ArcL {at},v100,sm1,wd1\\Weave:=wv1,fine,tool0\\Track:=tr1;"),
        format!("ArcL {at},v100,sm1,wd1\\Weave:=wv1,fine,tool0;"),
    ] {
        assert_eq!(left(&program("", &line)), [true], "{line}");
    }
    assert_eq!(left(&program("", &format!("ArcL {at},v100,sm1,wd1,fine,tool0;"))), [false]);
}

#[test]
fn no_point_is_added_on_a_straight_way_on_which_singarea_turns_the_wrist() {
    let body = |area: &str| {
        format!("{area}MoveL [[900,0,1000],[0.5,0,0.8660254,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;")
    };
    let closed = |area: &str| moves(&program("", &body(area)))[0].closed.is_some();
    assert!(closed("SingArea\\Wrist;\n") && closed("SingArea \\LockAxis4;\n"));
    assert!(!closed("") && !closed("SingArea\\Off;\n") && !closed("SingArea\\Wrist;\nSingArea\\Off;\n"));
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
        NewPoint { q, share, t_s: None, clearance_m: 0.01, of_way: false }
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

#[test]
fn a_move_after_which_the_program_reads_its_place_keeps_its_goal() {
    let j = |v: f64| format!("MoveAbsJ [[{v},2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\n");
    for (line, kept) in [
        ("p1:=CRobT(\\Tool:=tool0);\n", true),
        ("p1:=Offs(CRobT(),0,0,10);\n", true),
        ("jx:=CJointT();\nWaitTime 1;\n", true),
        ("n:=CalcRobT(jx,tool0);\n", false),
        ("MoveL RelTool(CRobT(\\Tool:=tool0),0,0,-50),v100,fine,tool0;\n", true),
        ("TPWrite \"at\"\\Pos:=CPos();\n", false),
    ] {
        let source = program("", &format!("{}{}{line}{}", j(1.0), j(2.0), j(3.0)));
        let fixed: Vec<bool> = moves(&source).iter().map(|m| m.fixed.is_some()).collect();
        assert_eq!((fixed[0], fixed[1], fixed.last()), (false, kept, Some(&false)), "{line}");
    }
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
fn a_new_point_keeps_the_bytes_of_its_statement() {
    let list = |j1: &str| format!("[[{j1},0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]]");
    let source = program("", &format!("MoveAbsJ {},v\u{e4},fine,tGr\u{e4};", list("10")));
    for bytes in [source.chars().map(|c| c as u8).collect::<Vec<u8>>(), source.clone().into_bytes()] {
        let doc = harness::parse(&Rapid, &bytes, &robot()).unwrap();
        let (k, m) = doc.script().moves().next().map(|(k, m)| (k, m.clone())).unwrap();
        let q: Vec<f64> =
            doc.script().targets.get(m.goal.target().unwrap()).unwrap().values.iter().map(|v| v.unwrap().si).collect();
        let mut edits = Edits { digit: vec![1e-6; 6], ..Edits::default() };
        let point = NewPoint { q, share: 0.5, t_s: None, clearance_m: 0.01, of_way: false };
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
