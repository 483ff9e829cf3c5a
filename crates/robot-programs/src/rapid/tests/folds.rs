//! Constants that are expressions.

use super::*;

/// A target at `x`, as it is declared.
fn point(x: &str) -> String {
    format!("[[{x},0,1000],[0.5,0,0.8660254,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]")
}

/// Position of the goal of the first move, mm.
fn position(declarations: &str, goal: &str) -> Option<[f64; 3]> {
    let source = program(declarations, &format!("MoveL {goal},v100,fine,tool0;"));
    match &moves(&source)[0].goal {
        Goal::Pose(pose) => Some((pose.position_m * 1e3).map(|v| (v * 1e6).round() / 1e6).into()),
        _ => None,
    }
}

#[test]
fn numbers_that_are_declared_by_expressions_fold() {
    let p = format!("CONST robtarget p1:={};\n", point("900"));
    let at = |numbers: &str| position(&format!("{p}{numbers}"), "Offs(p1,0,0,h+1)");
    assert_eq!(at("CONST num h:=2*50;"), Some([900.0, 0.0, 1101.0]));
    assert_eq!(at("CONST num g:=50;\nCONST num h:=2*g-(g/10);"), Some([900.0, 0.0, 1096.0]));
    assert_eq!(at("LOCAL VAR num h:=-g;\nCONST num g:=5;"), Some([900.0, 0.0, 996.0]));
    for numbers in [
        "CONST num h:=2*g;\nVAR num g:=GInput(gi1);",
        "CONST num h:=h;",
        "CONST num h:=7 DIV 2;",
        "CONST num h:=g;\nCONST num g:=h;",
    ] {
        assert_eq!(at(numbers), None, "{numbers}");
    }
    // the routine has a number of the same name
    let source = program(
        &format!("{p}CONST num g:=50;\nCONST num h:=2*g;"),
        "VAR num g:=1;\nMoveL Offs(p1,0,0,h),v100,fine,tool0;",
    );
    let Goal::Pose(pose) = &moves(&source)[0].goal else { panic!() };
    assert!((pose.position_m.z - 1.1).abs() < 1e-9);
}

#[test]
fn a_number_takes_the_place_of_an_expression_in_a_list() {
    let source =
        program("CONST jointtarget j1:=[[1+1.5,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]];", "MoveAbsJ j1,v100,fine,tool0;");
    assert_eq!(degrees(&source, 0)[0], Some(2.5));
    assert_eq!(rewritten(&source, &shifted(&source, &[(0, 0.002)])), source.replace("1+1.5", "2.50200"));
    assert_eq!(
        position(&format!("CONST robtarget p1:={};", point("800+30.267-2*5")), "p1"),
        Some([820.267, 0.0, 1000.0])
    );
    assert_eq!(position(&format!("CONST robtarget p1:={};", point("800+h")), "p1"), None);
}

#[test]
fn a_point_that_is_declared_by_a_displacement_is_known_and_not_written() {
    let p = format!("CONST robtarget p1:={};\nCONST num h:=2*50;\n", point("900"));
    let two = "CONST robtarget p2:=Offs(p1,0,0,h);\nCONST robtarget p3:=Offs(p2,5,0,0);";
    assert_eq!(position(&format!("{p}{two}"), "p3"), Some([905.0, 0.0, 1100.0]));
    assert_eq!(position(&format!("{p}{two}"), "Offs(p2,0,5,0)"), Some([900.0, 5.0, 1100.0]));
    let source = program(&format!("{p}{two}"), "MoveL p3,v100,fine,tool0;");
    let Goal::Pose(pose) = &moves(&source)[0].goal else { panic!() };
    assert_eq!(pose.target, None);
    // a routine has its own point of that name; points that are declared by each other
    let source =
        program(&format!("{p}{two}"), &format!("VAR robtarget p1:={};\nMoveL p2,v100,fine,tool0;", point("1")));
    assert!(matches!(moves(&source)[0].goal, Goal::Opaque(_)));
    assert_eq!(position("CONST robtarget p1:=Offs(p2,0,0,1);\nCONST robtarget p2:=Offs(p1,0,0,1);", "p1"), None);
}
