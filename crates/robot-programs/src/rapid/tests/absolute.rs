//! Which goals that cannot be determined are whole places all the same.

use super::*;

/// Whether the goal of the second move, which is not known, is one.
fn is_absolute(declarations: &str, goal: &str) -> bool {
    let source = program(&format!("{J}\n{declarations}"), &format!("MoveAbsJ j1,v100,fine,tool0;\n{goal}"));
    let all = moves(&source);
    assert!(matches!(all[1].goal, Goal::Opaque(_)), "{goal}");
    all[1].absolute
}

#[test]
fn a_goal_that_is_made_of_data_alone_counts_from_nowhere() {
    const P: &str = "VAR robtarget p;\nVAR num h;";
    for goal in [
        "MoveL p,v100,z10,tool0;",
        "MoveL elsewhere,v100,z10,tool0;",
        "MoveJ pa{i+1},v100,z10,tool0;",
        "MoveL Offs(p,0,-h,2*Abs(h)),v100,z10,tool0;",
        "MoveL RelTool(p,0,0,-h\\Rz:=90),v100,z10,tool0;",
        "MoveL [[h,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,z10,tool0;",
        "MoveAbsJ jHome,v100,z10,tool0;",
    ] {
        assert!(is_absolute(P, goal), "{goal}");
    }
    // another routine may read where the robot stands, and so do these; a search ends anywhere; an arc counts from its start
    for goal in [
        "MoveL Offs(CRobT(),0,0,50),v100,z10,tool0;",
        "MoveL Offs(above(p),0,0,50),v100,z10,tool0;",
        "MoveL GetPoint(1),v100,z10,tool0;",
        "MoveAbsJ CJointT(),v100,z10,tool0;",
        "MoveC p,Offs(p,0,0,h),v100,z10,tool0;",
        "SearchL d1,p,Offs(p,0,0,h),v100,tool0;",
        "MoveL p,v100,z10,tool0\\Corr;",
        "MoveAbsJ [[h,0,9E9,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,z10,tool0;",
    ] {
        assert!(!is_absolute(P, goal), "{goal}");
    }
    assert!(!is_absolute(
        "VAR jointtarget q:=[[1,2,3,4,5,9E9],[9E9,9E9,9E9,9E9,9E9,9E9]];",
        "q:=j1;\nMoveAbsJ q,v1,z1,tool0;"
    ));
    // a routine of the program has the name of one of the language
    let own = "FUNC num Abs(num x)\nRETURN x;\nENDFUNC";
    assert!(!is_absolute(&format!("{P}\n{own}"), "MoveL Offs(p,0,0,Abs(h)),v100,z10,tool0;"));
    let led = "SoftAct 1,50;\nMoveL Offs(p,0,0,h),v100,z10,tool0;";
    assert!(!is_absolute(P, led));
}

#[test]
fn an_external_axis_of_the_robot_may_be_left_where_it_is() {
    let robot = crate::fixtures::irb1600_on_a_rail();
    let source = program("VAR robtarget p;", "MoveL Offs(p,0,0,h),v100,z10,tool0;");
    let doc = harness::parse(&Rapid, source.as_bytes(), &robot).unwrap();
    assert!(doc.script().moves().all(|(_, m)| !m.absolute));
}

#[test]
fn the_move_before_a_reading_still_stays() {
    let source = program(
        J,
        "MoveAbsJ j1,v100,fine,tool0;\np:=CRobT();\nMoveL Offs(p,0,0,h),v100,z10,tool0;\nMoveAbsJ j1,v100,fine,tool0;\nMoveL Offs(CRobT(),0,0,5),v100,z10,tool0;",
    );
    let all = moves(&source);
    assert!(all[0].fixed.is_some() && all[1].absolute && all[2].fixed.is_some() && !all[3].absolute);
}
