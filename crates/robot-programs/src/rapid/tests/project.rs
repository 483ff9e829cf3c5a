//! Modules of one task: what another one declares is known, and never written.

use super::*;

const E: &str = "[9E9,9E9,9E9,9E9,9E9,9E9]";

/// A module with others of its task's folder.
fn task(own: &str, others: &[&str]) -> Box<dyn Document> {
    folder("PROGMOD/", own, others)
}

/// A module with others of its folder.
/// In the place of a text: a file that is there and cannot be read.
const UNREAD: &str = "unread";

fn folder(folder: &str, own: &str, others: &[&str]) -> Box<dyn Document> {
    let own = Text::new(format!("{folder}own.mod"), own.as_bytes().to_vec());
    let others = (1..).zip(others).map(|(k, t)| match *t {
        UNREAD => Text::unread(format!("{folder}m{k}.mod")),
        t => Text::of_context(format!("{folder}m{k}.mod"), t.as_bytes().to_vec()),
    });
    Rapid.parse(std::iter::once(own).chain(others).collect(), &robot()).unwrap()
}

fn why(doc: &dyn Document, n: usize) -> String {
    let (_, m) = doc.script().moves().nth(n).unwrap();
    match &m.goal {
        Goal::Opaque(why) => why.to_string(),
        _ => "known".into(),
    }
}

fn module(name: &str, body: &str) -> String {
    format!("MODULE {name}\n{body}\nENDMODULE\n")
}

#[test]
fn a_target_of_another_module_is_known_and_written_in_line() {
    let own = "MODULE own\nPROC work()\nMoveAbsJ jHome,v100,fine,tool0;\nMoveL Offs(p1,0,0,50),v100,fine,tool0;\n\
               MoveAbsJ jLocal,v100,fine,tool0;\nENDPROC\nENDMODULE\n";
    let data = module(
        "data",
        &format!(
            "! first\nCONST jointtarget jHome:=[[1,2,3,4,5,6],{E}];\nLOCAL CONST jointtarget jLocal:=[[1,2,3,4,5,6],{E}];\n\
             PERS robtarget p1:=[[600,0,700],[0,0,1,0],[0,0,0,0],{E}];\nPROC main()\nwork;\nENDPROC"
        ),
    );
    let d = task(own, &[&module("other", "VAR num n;"), &data]);
    assert_eq!((why(d.as_ref(), 0).as_str(), why(d.as_ref(), 1).as_str()), ("known", "known"));
    assert!(why(d.as_ref(), 2).contains("declared in another module"));
    let target = &d.script().targets.get(0).unwrap();
    assert_eq!((target.at.file, target.at.line), (2, 3), "{:?}", target.at);
    let by: Vec<(usize, f64)> = vec![(0, 0.01_f64.to_radians())];
    let edits = harness::shifted(d.script(), &by, 1e-5_f64.to_radians());
    let out = harness::applied(d.as_ref(), &edits).unwrap();
    let text = String::from_utf8(out[0].clone()).unwrap();
    assert!(text.contains(&format!("MoveAbsJ [[1.01000,2,3,4,5,6],{E}],v100")), "{text}");
    assert_eq!(String::from_utf8(out[2].clone()).unwrap(), data);
    assert_eq!(harness::kept(&Rapid, d.as_ref(), &edits, &robot()), Ok(Outcome::Kept));
    // the point within the displacement alone
    let step = d.script().moves().nth(1).unwrap().0;
    let numbers = harness::values(d.script(), step);
    let goal: Vec<f64> = numbers.iter().enumerate().map(|(k, v)| v + if k == 0 { 1e-5 } else { 0.0 }).collect();
    let edit = Edit { goal: Some(goal), ..Edit::default() };
    let edits = Edits { steps: [(step, edit)].into(), pose_digit: [1e-6, 1e-6], ..Edits::default() };
    let out = String::from_utf8(harness::applied(d.as_ref(), &edits).unwrap().swap_remove(0)).unwrap();
    assert!(out.contains(&format!("MoveL Offs([[600.010,0,700],[0,0,1,0],[0,0,0,0],{E}],0,0,50),v100")), "{out}");
}

#[test]
fn what_modules_of_a_task_do_to_shared_data_counts() {
    let own = format!(
        "MODULE own\nPERS jointtarget j1:=[[1,2,3,4,5,6],{E}];\nCONST jointtarget j2:=[[1,2,3,4,5,6],{E}];\n\
         PROC work()\nMoveAbsJ j1,v100,fine,tool0;\nMoveAbsJ j2,v100,fine,tool0;\nENDPROC\nENDMODULE\n"
    );
    let of = |body: &str| why(task(&own, &[&module("boss", &format!("PROC main()\n{body}\nENDPROC"))]).as_ref(), 0);
    assert_eq!(of("work;"), "known");
    assert!(of("j1:=CJointT();").contains("is assigned"));
    assert!(of("teach j1;").contains("may set it"));
    assert!(why(task(&own, &[]).as_ref(), 0).contains("another module may set it"));
    // another module goes there, too: the point must stay for it
    let user = module("boss", "PROC main()\nwork;\nMoveAbsJ j2,v100,fine,tool0;\nENDPROC");
    let d = task(&own, &[&user]);
    let edits = harness::shifted(d.script(), &[(1, 1e-4)], 1e-7);
    let out = String::from_utf8(harness::applied(d.as_ref(), &edits).unwrap().swap_remove(0)).unwrap();
    assert!(out.contains("CONST jointtarget j2:=[[1,") && out.contains("MoveAbsJ j2_lm1,"), "{out}");
}

#[test]
fn files_that_cannot_be_of_one_task_are_not_looked_at() {
    let own = "MODULE own\nPROC work()\nMoveAbsJ jHome,v100,fine,tool0;\nENDPROC\nENDMODULE\n";
    let home = |name: &str, more: &str| module(name, &format!("CONST jointtarget jHome:=[[1,2,3,4,5,6],{E}];\n{more}"));
    let known = |others: &[&str]| why(task(own, others).as_ref(), 0) == "known";
    assert!(known(&[&home("a", "")]));
    // declared by two: which is loaded is not known
    assert!(!known(&[&home("a", ""), &home("b", "")]));
    // a module of the same name, a routine of the same name: another task's
    assert!(!known(&[&home("own", "")]));
    assert!(!known(&[&home("a", "PROC work()\nENDPROC")]));
    // two programs
    let main = "PROC main()\nENDPROC";
    assert!(known(&[&home("a", main), &module("b", "")]));
    assert!(!known(&[&home("a", main), &module("b", main)]));
    // one that cannot be read declares nothing
    assert!(!known(&["MODULE a CONST jointtarget jHome:="]));
}

#[test]
fn modules_of_any_folder_are_one_program_where_they_can_be_loaded_together_and_one_holds_main() {
    let own = "MODULE own\nPROC work()\nMoveAbsJ jHome,v100,fine,tool0;\nENDPROC\nENDMODULE\n";
    let home = |name: &str| module(name, &format!("CONST jointtarget jHome:=[[1,2,3,4,5,6],{E}];"));
    let main = module("boss", "PROC main()\nwork;\nENDPROC");
    let known = |own: &str, others: &[&str]| why(folder("cell/", own, others).as_ref(), 0) == "known";
    assert!(known(own, &[&home("data"), &main]));
    assert!(known(own, &[&home("data"), &main, &module("more", "VAR num n;")]));
    // no main, two of them, one of a module that has nothing to do with it
    assert!(!known(own, &[&home("data")]));
    assert!(!known(own, &[&home("data"), &main, &module("b", "PROC main()\nENDPROC")]));
    assert!(!known(own, &[&home("data"), &module("boss", "PROC main()\nENDPROC")]));
    // two of a name anywhere in the folder, and a file that cannot be read
    let twice = [module("c", "VAR num n;"), module("d", "VAR num n;")];
    assert!(!known(own, &[&home("data"), &main, &twice[0], &twice[1]]));
    assert!(!known(own, &[&home("data"), &main, "MODULE a CONST"]));
    // over a third one
    let through = module("data", &format!("CONST jointtarget jHome:=[[1,2,3,4,5,6],{E}];\nPROC init()\nENDPROC"));
    assert!(known(own, &[&through, &module("boss", "PROC main()\ninit;\nENDPROC")]));
}

#[test]
fn a_tool_of_reltool_is_turned_about_x_then_its_new_y_then_its_new_z() {
    let data = format!("CONST robtarget p1:=[[600,0,700],[0,0,1,0],[0,0,0,0],{E}];");
    let source = program(&data, "MoveL RelTool(Offs(p1,0,0,10),0,0,-50\\Rx:=90\\Rz:=90),v100,fine,tool0;");
    let Goal::Pose(goal) = &moves(&source)[0].goal else { panic!() };
    // half a turn about y: the tool's z points down, so that -50 along it is up
    assert!((goal.position_m * 1e3 - nalgebra::Vector3::new(600.0, 0.0, 760.0)).norm() < 1e-9, "{}", goal.position_m);
    let rotation = goal.rotation.unwrap();
    // the tool's axes before: x = -X, y = Y, z = -Z. About x by 90: y to z, z to -y. About the new z (-Y) by 90: x to the new y (-Z)
    assert!((rotation * nalgebra::Vector3::x() + nalgebra::Vector3::z()).norm() < 1e-9, "{rotation}");
    assert!((rotation * nalgebra::Vector3::z() + nalgebra::Vector3::y()).norm() < 1e-9, "{rotation}");
}

#[test]
fn a_folder_that_nothing_tells_to_be_of_one_task_gives_no_targets() {
    let own = "MODULE own\nPROC main()\nMoveAbsJ jHome,v100,fine,tool0;\nENDPROC\nENDMODULE\n";
    let data = module("data", &format!("CONST jointtarget jHome:=[[1,2,3,4,5,6],{E}];"));
    let found = task(own, &[&data]);
    assert_eq!(why(found.as_ref(), 0), "known");
    assert!(found.script().notes.iter().any(|n| n.text.contains("taken from this file")), "{:?}", found.script().notes);
    let routine = own.replace("main", "work");
    assert!(why(folder("", &routine, &[&data]).as_ref(), 0).contains("declared in another module"));
    // a list of modules tells it
    let with_list = |list: &str| {
        let texts = vec![
            Text::new("own.mod", own.as_bytes().to_vec()),
            Text::of_context("data.mod", data.clone().into_bytes()),
            Text::of_context("p.pgf", list.as_bytes().to_vec()),
        ];
        why(Rapid.parse(texts, &robot()).unwrap().as_ref(), 0)
    };
    assert_eq!(with_list("<Program><Module>own.mod</Module><Module>data.mod</Module></Program>"), "known");
    assert!(with_list("<Program><Module>own.mod</Module></Program>").contains("another module"));
}

#[test]
fn a_file_that_is_left_out_may_set_what_it_names() {
    let own = |storage: &str| {
        format!(
            "MODULE own\n{storage} jointtarget jG:=[[1,2,3,4,5,6],{E}];\nVAR num n;\nPROC main()\n\
             MoveAbsJ jG,v100,fine,tool0;\nENDPROC\nENDMODULE\n"
        )
    };
    let pers = format!("PERS jointtarget jG:=[[1,2,3,4,5,6],{E}];\nPROC work()\njG:=CJointT();\nENDPROC");
    let main = "PROC main()\nSetDataVal \"jP{2}\",n;\nENDPROC";
    for other in [
        module("task2", &pers),
        module("two", "VAR num n;\nPROC set()\njG:=CJointT();\nENDPROC"),
        "MODULE broken\nPROC set(\njG := CJointT();\n".to_string(),
        module("three", main),
        UNREAD.to_string(),
    ] {
        for place in ["", "PROGMOD/"] {
            for storage in ["PERS", "VAR"] {
                let d = folder(place, &own(storage), &[&other]);
                assert_ne!(why(d.as_ref(), 0), "known", "{storage} {place} {other}");
            }
        }
        assert_eq!(why(folder("", &own("CONST"), &[&other]).as_ref(), 0), "known");
    }
    // too many for one task: each may set it
    let setter = |k: usize| module(&format!("m{k}"), &format!("PROC set{k}()\njG:=CJointT();\nENDPROC"));
    let many: Vec<String> = (0..70).map(setter).collect();
    let many: Vec<&str> = many.iter().map(String::as_str).collect();
    assert_ne!(why(task(&own("VAR"), &many).as_ref(), 0), "known");
    // data of the same name of another program are others
    let other =
        module("other", &format!("VAR jointtarget jG:=[[1,2,3,4,5,6],{E}];\nPROC main()\njG:=CJointT();\nENDPROC"));
    assert_eq!(why(folder("", &own("VAR"), &[&other]).as_ref(), 0), "known");
}

#[test]
fn a_copy_of_the_program_beside_it_takes_no_frame_away() {
    let data = "PERS tooldata tT:=[TRUE,[[60,0,40],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];\n\
                PERS wobjdata wF:=[FALSE,TRUE,\"\",[[0,0,100],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];";
    let own = |main: &str, data: &str| {
        format!(
            "MODULE own\n{data}\nCONST robtarget p1:=[[600,0,700],[0,0,1,0],[0,0,0,0],{E}];\nPROC {main}()\n\
             MoveL p1,v100,fine,tT\\WObj:=wF;\nENDPROC\nENDMODULE\n"
        )
    };
    let known = |others: &[&str]| {
        let d = folder("", &own("main", data), others);
        let Some(StepKind::Move(m)) = d.script().steps.iter().map(|s| &s.kind).find(|k| matches!(k, StepKind::Move(_)))
        else {
            panic!()
        };
        let Goal::Pose(goal) = &m.goal else { panic!() };
        let given = |f: &Frame| matches!(f, Frame::Given(_));
        let why = d.script().notes.iter().map(|n| n.text.clone()).collect::<Vec<_>>().join("; ");
        (given(&goal.tool) && given(&goal.frame), why)
    };
    assert!(known(&[]).0);
    assert!(known(&[&own("main", data), &own("work", data)]).0, "a copy, and a module with the same data");
    let other = own("work", &data.replace("[60,0,40]", "[60,0,41]"));
    let (is_known, why) = known(&[&other]);
    assert!(
        !is_known && why.contains("`tT` is global and not constant: m1.mod declares it with another value"),
        "{why}"
    );
    for set in ["tT:=tool0;", "tT.tframe.trans.x:=5;", "adjust tT;", "x:=f(tT);", "PDispOn Pose(tT),p1,tool0;"] {
        let sets = own("work", data).replace("MoveL", &format!("{set}\nMoveL"));
        assert!(!known(&[&sets]).0, "{set}");
    }
    // a routine that only goes there
    let goes = own("work", "").replace("p1", "p2");
    assert!(known(&[&goes]).0);
}
