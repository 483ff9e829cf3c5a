//! One target of several moves: edited in place, cloned, or not certain.

use super::*;

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

/// Modules of a task are written one by one, and must not get the same global name.
#[test]
fn names_of_which_a_clone_holds_a_part_alone_give_other_names_in_each_module() {
    let clone = |head: &str, name: &str, at: &str| {
        let one = "[[1,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]]";
        let value = if name.contains('{') { format!("[{one},{one},{one}]") } else { one.to_string() };
        let declared = format!("{head} jointtarget {name}:={value};");
        let source = program(&declared, &format!("MoveAbsJ {at},v100,fine,tool0;\nMoveAbsJ {at},v100,fine,tool0;"));
        let out = rewritten(&source, &shifted(&source, &[(0, 0.002)]));
        let name = out.split(&format!("{head} jointtarget ")).nth(2).unwrap().split(":=").next().unwrap().to_string();
        assert!(name.len() <= 32 && out.contains(&format!("MoveAbsJ {name},v100")), "{out}");
        name
    };
    let long = |k: u32| format!("pStationAlphaConveyorPick000000{k}");
    let [a, b] = [1, 2].map(|k| clone("CONST", &long(k), &long(k)));
    assert!(a != b && a.starts_with("pStationAlphaC_") && a.ends_with("_lm1"), "{a} {b}");
    let [c, d, e] = [("ja{3}", "ja{3}"), ("ja_3", "ja_3"), ("ja_", "ja_")].map(|(name, at)| clone("PERS", name, at));
    assert!(c != d && e != "ja_lm1" && d == "ja_3_lm1", "{c} {d} {e}");
    // one that no other module sees keeps its short name
    assert_eq!(clone("LOCAL CONST", &long(1), &long(1)), "pStationAlphaConveyorPi_lm1");
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
    let clone = out.split("CONST jointtarget ").nth(2).unwrap().split(":=").next().unwrap();
    assert!(clone.starts_with("a_2_") && clone.ends_with("_lm1"), "{out}");
    assert!(out.contains(&format!("CONST jointtarget {clone}:=[[2.00200,2")), "{out}");
    assert!(out.contains(&format!("MoveAbsJ {clone},v100")), "{out}");
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
        ("MoveAbsJ [[1+a,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;", "no plain number"),
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
fn a_point_that_a_move_names_which_is_left_keeps_its_value() {
    let point = "CONST robtarget p1:=[[600,0,700],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];";
    for left in
        ["MoveL Offs(p1,0,0,AInput(ai1)),v100,fine,tool0;", "MoveL RelTool(p1,0,0,AInput(ai1)),v100,fine,tool0;"]
    {
        for lines in [format!("MoveL p1,v100,fine,tool0;\n{left}"), format!("{left}\nMoveL p1,v100,fine,tool0;")] {
            let source = program(point, &lines);
            let doc = document(&source);
            let step = doc.script().moves().find(|(_, m)| matches!(m.goal, Goal::Pose(_))).unwrap().0;
            let mut goal = harness::values(doc.script(), step);
            goal[2] += 1e-4;
            let edit = Edit { goal: Some(goal), ..Edit::default() };
            let edits = Edits { steps: [(step, edit)].into(), pose_digit: [1e-6, 1e-6], ..Edits::default() };
            let out = rewritten(&source, &edits);
            assert!(out.contains(point) && out.contains(left) && out.contains("MoveL p1_lm1,"), "{out}");
        }
    }
}
