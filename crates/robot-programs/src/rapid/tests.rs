//! Every trap of RAPID programs that we know of.

mod absolute;
mod added;
mod clones;
mod fewer;
mod flow;
mod folds;
mod in_force;
mod led;
mod poses;
mod project;
mod reading;
mod settings;

use super::*;
use crate::script::harness::{self, Outcome, opaque, round_trip};
use crate::script::pose::{Configuration, Frame};
use crate::script::{Break, Edit, Goal, Move, NewPoint, OtherWay, Solution, Speed, StepKind, Value, text};

use crate::axes::Axis;
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
    let point = NewPoint { q, share, t_s: None, clearance_m, of_way: false, waits: false };
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
