//! What a form couples, what a point's value is, and what its clone is called.

use super::*;
use crate::krl::Reason;

/// A form to point `p`, with more lines in its fold.
fn form(p: &str, more: &str) -> String {
    format!(
        ";FOLD PTP {p} Vel=100 % PDAT1 Tool[1]:tool Base[1]:test;%{{PE}}%R 8.3.44,%MKUKATPBASIS,%CMOVE,%VPTP,%P 1:PTP, 2:{p}, 3:, 5:100, 7:PDAT1\n\
         $BWDSTART=FALSE\nPDAT_ACT=PPDAT1\nFDAT_ACT=F{p}\nBAS(#PTP_PARAMS,100)\nSET_CD_PARAMS (0)\n{more}PTP X{p}\n;ENDFOLD\n"
    )
}

fn forms_of(points: &[(&str, &str)]) -> Box<dyn Document> {
    let src: String = points.iter().map(|(p, more)| form(p, more)).collect();
    let mut dat = String::from("DEFDAT a\n");
    for p in ["P1", "P2", "TEST"] {
        dat += &format!("DECL E6AXIS X{p}={{A1 1.0,A2 -90.0}}\nDECL FDAT F{p}={{TOOL_NO 1,BASE_NO 1}}\n");
    }
    doc(&[format!("DEF a()\n{src}END\n").as_bytes(), (dat + "ENDDAT\n").as_bytes()])
}

#[test]
fn what_was_typed_into_a_fold_is_never_run_twice() {
    for more in [
        "nCount=nCount+1\n",
        "$OUT[5]=TRUE\n",
        "PULSE($OUT[7],TRUE,0.5)\n",
        "CONTINUE\n",
        "BAS(#VEL_PTP,nSpeed(1))\n",
        "PDAT_ACT.VEL=50\n",
        ";FOLD user\n$OUT[5]=TRUE\n;ENDFOLD\n",
    ] {
        let d = forms_of(&[("P1", ""), ("P2", more)]);
        let m = moves(d.as_ref());
        assert!(m[0].1.closed.is_none(), "{:?}", m[0].1.closed);
        assert!(m[1].1.closed.as_ref().is_some_and(|c| c.to_string().contains("more than this motion")), "{more}");
        assert!(d.patches(&edits(d.as_ref(), &[], &[m[1].0])).is_err());
    }
    let d = forms_of(&[("P1", ""), ("P2", "$H_POS=XP2\n;a remark\nBAS (#VEL_PTP,100 ) ;too\n")]);
    let m = moves(d.as_ref());
    let after = text(rewrite(d.as_ref(), &edits(d.as_ref(), &[], &[m[1].0])).as_ref(), 0);
    assert_eq!((after.matches("$H_POS=XP2\n").count(), after.matches("a remark").count()), (2, 1), "{after}");
}

#[test]
fn a_point_that_is_assigned_once_is_certain_only_where_that_runs_before_every_use() {
    let goals_of = |lines: &str| {
        let src = format!("DEF a()\n{lines}END\nDEF b()\nPTP XS\nEND\n");
        goals(doc(&[src.as_bytes(), b"DEFDAT a\nDECL E6AXIS XL\nDECL E6AXIS XS\nENDDAT\n"]).as_ref())
    };
    let set = "XL={A1 10.0,A2 -90.0}\n";
    assert_eq!(goals_of(&format!("{set}PTP XL\nPTP XL\n")), "jjo");
    assert_eq!(goals_of(&format!("LOOP\n{set}PTP XL\nENDLOOP\n")), "jo");
    assert_eq!(goals_of(&format!("IF n==1 THEN\nPTP {{A1 1.0}}\nENDIF\n{set}PTP XL\n")), "jjo");
    // before its assignment the point holds what an earlier run left
    assert_eq!(goals_of(&format!("PTP XL\n{set}PTP XL\n")), "ojo");
    assert_eq!(goals_of(&format!("n=XL.A1\n{set}PTP XL\n")), "jo");
    for (open, close) in [
        ("IF n==1 THEN", "ENDIF"),
        ("FOR n=1 TO m", "ENDFOR"),
        ("WHILE x", "ENDWHILE"),
        ("SWITCH n\nCASE 1", "ENDSWITCH"),
    ] {
        assert_eq!(goals_of(&format!("{open}\n{set}{close}\nPTP XL\n")), "oo", "{open}");
    }
    assert_eq!(goals_of(&format!("IF n==1 THEN\nGOTO over\nENDIF\n{set}over:\nPTP XL\n")), "oo");
    assert_eq!(goals_of(&format!("LOOP\nEXIT\n{set}ENDLOOP\nPTP XL\n")), "oo");
    // another routine may run first
    assert_eq!(goals_of("XS={A1 10.0,A2 -90.0}\nPTP XS\n"), "jo");
    let src = format!("DEF a()\nIF n==1 THEN\n{set}ENDIF\nPTP XL\nEND\n");
    let d = doc(&[src.as_bytes(), b"DEFDAT a\nDECL E6AXIS XL\nENDDAT\n"]);
    let Goal::Opaque(why) = &moves(d.as_ref())[0].1.goal else { panic!() };
    assert_eq!(*why, Reason::AssignedSometimes { name: "XL".into(), line: 3 }.into());
}

#[test]
fn a_clone_renames_the_point_and_not_a_tool_or_base_of_the_same_name() {
    let d = forms_of(&[("test", ""), ("P2", ""), ("test", "")]);
    let m = moves(d.as_ref());
    let after = rewrite(d.as_ref(), &edits(d.as_ref(), &[(m[2].0, 0.5)], &[]));
    let (src, dat) = (text(after.as_ref(), 0), text(after.as_ref(), 1));
    assert!(src.contains(";FOLD PTP test_2 Vel=100 % PDAT1 Tool[1]:tool Base[1]:test;"), "{src}");
    assert!(src.contains("%P 1:PTP, 2:test_2, 3:, 5:100,") && src.contains("FDAT_ACT=Ftest_2\n"), "{src}");
    assert!(src.contains("PTP Xtest_2\n") && !src.contains("TEST"), "{src}");
    assert!(dat.contains("DECL E6AXIS Xtest_2={A1 1.5") && dat.contains("DECL FDAT Ftest_2={"), "{dat}");
}

#[test]
fn the_goal_of_a_function_or_an_array_is_said_to_be_computed() {
    let d = doc(&[b"DEF a()\nSLIN calcTopPos(P1,2)\nPTP basePos[n]\nLIN far:near C_DIS\nPTP XFAR C_PTP\nEND\n"]);
    let m = moves(d.as_ref());
    let why = |i: usize| if let Goal::Opaque(w) = &m[i].1.goal { w.to_string() } else { String::new() };
    assert!((0..3).all(|i| why(i) == "the goal is computed"), "{}", why(0));
    assert!(why(3).contains("XFAR is not declared"), "{}", why(3));
}

#[test]
fn a_declaration_at_the_end_of_a_file_without_line_end_is_cloned_too() {
    let d = doc(&[b"DEF a()\nPTP XA\nPTP {A1 1}\nPTP XA\nEND", b"DEFDAT a\nDECL E6AXIS XA={A1 5.0}"]);
    let m = moves(d.as_ref());
    let after = text(rewrite(d.as_ref(), &edits(d.as_ref(), &[(m[2].0, 0.5)], &[])).as_ref(), 1);
    assert_eq!(after, "DEFDAT a\nDECL E6AXIS XA={A1 5.0}\nDECL E6AXIS XA_2={A1 5.5000}");
}

/// A list of frames without a status, a project around it, and its home position.
fn frames_in_a_project(own: &str, others: &[(&str, &str)]) -> Option<crate::script::Stance> {
    let src = format!("DEF a()\nPTP F1\nLIN F1\n{own}END\n");
    let dat = "DEFDAT a\nDECL FRAME F1={X 1000.0,Y 0.0,Z 900.0,A 0.0,B 90.0,C 0.0}\nENDDAT\n";
    let texts = [("a.src", src.as_str()), ("a.dat", dat)].map(|(n, t)| Text::new(n, t.as_bytes().to_vec()));
    let context = others.iter().map(|(n, t)| Text::of_context(*n, t.as_bytes().to_vec()));
    let doc = Krl.parse(texts.into_iter().chain(context).collect(), &kr120()).unwrap();
    doc.script().stance.clone()
}

const HOME: &str = "DEFDAT $CONFIG\nE6AXIS XHOME={A1 10.0,A2 -90.0,A3 90.0,A4 0.0,A5 45.0,A6 0.0}\n\
                    E6AXIS $H_POS_TOL={A1 2.0,A2 2.0,A3 2.0,A4 2.0,A5 2.0,A6 2.0}\nENDDAT\n";

#[test]
fn a_project_says_where_its_arm_works_for_frames_without_a_status() {
    let more = "DEFDAT b\nDECL E6POS XP1={X 1,Y 2,Z 3,A 4,B 5,C 6,S 18,T 2}\nDECL E6POS XP2={X 1,Y 2,Z 3,A 4,B 5,C 6,S 'B110',T 2}\n\
                DECL E6AXIS XQ={A1 999.0,A2 999.0,A3 999.0,A4 999.0,A5 999.0,A6 999.0}\nENDDAT\n";
    let used =
        "DEF b()\nPTP_REL {A1 1,A2 1,A3 -1,A4 1,A5 1,A6 1}\nPTP {A1 20.0,A2 -80.0,A3 80.0,A4 0,A5 30,A6 0}\nEND\n";
    let stance = frames_in_a_project("", &[("$config.dat", HOME), ("b.dat", more), ("b.src", used)]).unwrap();
    assert!((stance.home[0].to_degrees() - 10.0).abs() < 1e-9 && stance.home.len() == 6);
    // the home position itself is one of them, what is not taught, tolerances and increments are not
    assert_eq!(stance.others.len(), 2);
    let status = |c: &Configuration| c.posture();
    assert_eq!(stance.configurations.iter().filter_map(status).collect::<Vec<_>>(), [2, 6]);
}

#[test]
fn a_home_position_that_is_not_certain_says_nothing() {
    let assigns = "DEF c()\nXHOME=$AXIS_ACT\nEND\n";
    assert!(frames_in_a_project("", &[]).is_none());
    assert!(frames_in_a_project("", &[("$config.dat", HOME), ("c.src", assigns)]).is_none());
    assert!(frames_in_a_project("XHOME.A1=5\n", &[("$config.dat", HOME)]).is_none());
    let part = HOME.replace(",A6 0.0}", "}");
    assert!(frames_in_a_project("", &[("$config.dat", &part)]).is_none());
    // a program that names joints tells its configuration itself
    let own = "PTP {A1 20.0,A2 -80.0,A3 80.0,A4 0,A5 30,A6 0}\n";
    assert!(frames_in_a_project(own, &[("$config.dat", HOME)]).is_none());
}

#[test]
fn a_data_list_ends_at_its_first_enddat_and_copies_of_points_stand_before_it() {
    let point = "DECL E6AXIS XP={A1 10.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}\n";
    let form = form("P", "");
    let src = format!("DEF a()\n{form}{form}END\n");
    let list = format!("DEFDAT a\n{point}DECL FDAT FP={{TOOL_NO 1,BASE_NO 1}}\nENDDAT\n");
    let behind = format!("\n;a remark\n{point}ENDDAT\n");
    let d = doc(&[src.as_bytes(), format!("{list}{behind}").as_bytes()]);
    assert_eq!(goals(d.as_ref()), "jj");
    let said = |d: &dyn Document| {
        d.script().notes.iter().filter(|n| n.text.contains("ENDDAT")).map(|n| n.place).collect::<Vec<_>>()
    };
    assert_eq!(said(d.as_ref()), [crate::script::At { file: 1, line: 7 }]);
    let m = moves(d.as_ref());
    let after = text(rewrite(d.as_ref(), &edits(d.as_ref(), &[(m[0].0, 0.01), (m[1].0, 0.02)], &[])).as_ref(), 1);
    assert!(after.ends_with(&format!("ENDDAT\n{behind}")) && after.contains("XP_2="), "{after}");
    assert!(said(doc(&[src.as_bytes(), format!("{list}\n;a remark\n").as_bytes()]).as_ref()).is_empty());
}

#[test]
fn a_number_takes_the_place_of_an_expression_of_numbers() {
    let src = "DEF a()\nPTP {A1 10+1.5,A2 -90.0,A3 2*(40+5),A4 0.0,A5 -(20-5),A6 0.0}\nLIN XP\nEND\n";
    let list = "DEFDAT a\nDECL E6POS XP={X 800+94.851,Y 0.0,Z 1000-50*2,A 0.0,B 90.0,C 0.0}\nENDDAT\n";
    let d = doc(&[src.as_bytes(), list.as_bytes()]);
    let m = moves(d.as_ref());
    let of_arm = deg(d.as_ref(), &m[0].1).into_iter().flatten().map(|v| (v * 1e9).round() / 1e9).collect::<Vec<_>>();
    assert_eq!(of_arm, [11.5, -90.0, 90.0, 0.0, -15.0, 0.0]);
    let Goal::Pose(pose) = &m[1].1.goal else { panic!("{:?}", m[1].1.goal) };
    assert!((pose.position_m.x - 0.894_851).abs() < 1e-12 && (pose.position_m.z - 0.9).abs() < 1e-12);
    let after = text(rewrite(d.as_ref(), &edits(d.as_ref(), &[(m[0].0, 0.002)], &[])).as_ref(), 0);
    assert!(after.contains("PTP {A1 11.502"), "{after}");
    // a quotient may be one of whole numbers, and a name may have any value
    for value in ["7/2", "n+1", "f(1)", "10-", "2 3"] {
        let src = format!("DEF a()\nPTP {{A1 {value},A2 -90.0,A3 90.0,A4 0.0,A5 5.0,A6 0.0}}\nEND\n");
        assert_eq!(goals(doc(&[src.as_bytes()]).as_ref()), "o", "{value}");
    }
}
