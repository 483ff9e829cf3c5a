//! Points of other modules, elements of arrays, products of frames, and motions that go nowhere.

use super::*;
use crate::files::Folders;
use crate::script::Edit;

const CONFIG: &str = "DEFDAT $CONFIG\nE6AXIS XHOME={A1 0.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}\n\
                      DECL FDAT FHOME={TOOL_NO 0,BASE_NO 0,IPO_FRAME #BASE}\nENDDAT\n";
const SHARED: &str = "DEFDAT shared PUBLIC\nDECL GLOBAL E6AXIS XSAFE={A1 5.0,A2 -80.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}\n\
                      DECL E6AXIS XOWN={A1 7.0,A2 -80.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}\nENDDAT\n";

/// A program with its data list and other modules.
fn project(src: &str, dat: &str, others: &[(&str, &str)]) -> Box<dyn Document> {
    let own = [("p.src", src), ("p.dat", dat)].map(|(n, t)| Text::new(n, t.as_bytes().to_vec()));
    let more = others.iter().map(|(n, t)| Text::of_context(*n, t.as_bytes().to_vec()));
    Krl.parse(own.into_iter().chain(more).collect(), &kr120()).unwrap()
}

fn why(doc: &dyn Document, i: usize) -> String {
    match &moves(doc)[i].1.goal {
        Goal::Opaque(why) => why.to_string(),
        other => format!("{other:?}"),
    }
}

#[test]
fn points_of_the_controller_and_of_public_lists_are_known_and_never_written() {
    let others = [("$config.dat", CONFIG), ("shared.dat", SHARED)];
    let src = "DEF prog( )\nPTP XHOME\nPTP XSAFE C_PTP\nPTP XOWN\nEND\n";
    let d = project(src, "DEFDAT prog\nENDDAT\n", &others);
    assert_eq!(goals(d.as_ref()), "jjo");
    assert!(why(d.as_ref(), 2).contains("XOWN is not declared"), "{}", why(d.as_ref(), 2));
    let m = moves(d.as_ref());
    let after = rewrite(d.as_ref(), &edits(d.as_ref(), &[(m[0].0, 0.01), (m[1].0, 0.02)], &[]));
    let out = text(after.as_ref(), 0);
    assert!(out.contains("PTP {A1 0.0100,A2 -89.9900,"), "{out}");
    assert!(out.contains("PTP {A1 5.0200,A2 -79.9800,A3 90.0200,A4 0.0200,A5 0.0200,A6 0.0200} C_PTP"), "{out}");
    for (file, (_, text_of)) in (2..).zip(others) {
        assert_eq!(text(after.as_ref(), file), text_of);
    }
}

#[test]
fn a_point_of_all_modules_that_one_of_them_assigns_is_not_certain() {
    let src = "DEF prog( )\nPTP XHOME\nPTP XSAFE\nEND\n";
    let of = |teach: &str| {
        let others = [("$config.dat", CONFIG), ("shared.dat", SHARED), ("teach.src", teach)];
        goals(project(src, "DEFDAT prog\nENDDAT\n", &others).as_ref())
    };
    assert_eq!(of("DEF teach( )\nPTP XSAFE\nEND\n"), "jj");
    assert_eq!(of("DEF teach( )\nXSAFE=$AXIS_ACT\nEND\n"), "jo");
    assert_eq!(of("DEF teach( )\nXHOME.A1=5\nEND\n"), "oj");
    assert_eq!(of("DEF teach( )\nMEASURE(XSAFE)\nEND\n"), "jo");
    // a point of its own that has the same name is another one
    assert_eq!(of("DEF teach( )\nDECL E6AXIS XSAFE\nXSAFE=$AXIS_ACT\nEND\n"), "jj");
    let twice = [("shared.dat", SHARED), ("again.dat", SHARED)];
    assert_eq!(goals(project(src, "DEFDAT prog\nENDDAT\n", &twice).as_ref()), "oo");
}

#[test]
fn the_home_of_an_inline_form_parts_into_the_programs_own_list() {
    let form = ";FOLD PTP HOME  Vel= 100 % DEFAULT;%{PE}%MKUKATPBASIS,%CMOVE,%VPTP,%P 1:PTP, 2:HOME, 3:, 5:100, 7:DEFAULT\n\
                $BWDSTART=FALSE\nPDAT_ACT=PDEFAULT\nFDAT_ACT=FHOME\nBAS (#PTP_PARAMS,100 )\n$H_POS=XHOME\nPTP  XHOME\n;ENDFOLD\n";
    let src = format!("DEF prog( )\n{form}END\n");
    let d = project(&src, "DEFDAT prog\nDECL INT n=1\nENDDAT\n", &[("$config.dat", CONFIG)]);
    let m = moves(d.as_ref());
    let wish = edits(d.as_ref(), &[(m[0].0, 0.01)], &[]);
    assert!(d.unwritable(&wish).is_empty());
    let after = rewrite(d.as_ref(), &wish);
    let (src, dat) = (text(after.as_ref(), 0), text(after.as_ref(), 1));
    assert!(
        src.contains(";FOLD PTP HOME_2  Vel=") && src.contains("PTP  XHOME_2\n") && src.contains("FDAT_ACT=FHOME_2\n"),
        "{src}"
    );
    assert!(dat.contains("DECL E6AXIS XHOME_2={A1 0.0100,") && dat.contains("DECL FDAT FHOME_2={TOOL_NO 0"), "{dat}");
    assert!(dat.ends_with("\nENDDAT\n"), "{dat}");
    // without a list of its own there is no place for it
    let own = vec![Text::new("p.src", format!("DEF prog( )\n{form}END\n").into_bytes())];
    let all = own.into_iter().chain([Text::of_context("$config.dat", CONFIG.as_bytes().to_vec())]);
    let d = Krl.parse(all.collect(), &kr120()).unwrap();
    let m = moves(d.as_ref());
    assert_eq!(d.unwritable(&edits(d.as_ref(), &[(m[0].0, 0.01)], &[])).len(), 1);
}

#[test]
fn elements_of_an_array_are_points_by_their_plain_index() {
    let dat = "DEFDAT prog\nDECL E6AXIS P[3]\nP[1]={A1 1.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}\n\
               P[2]={A1 2.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}\nENDDAT\n";
    let of = |lines: &str| project(&format!("DEF prog( )\n{lines}END\n"), dat, &[]);
    let d = of("PTP P[1] C_PTP\nPTP P[2]\nPTP P[1]\nPTP P[3]\nPTP P[n]\n");
    // an index that is computed reads every element, so that none is changed where it stands
    assert_eq!(goals(d.as_ref()), "jjjoo");
    let m = moves(d.as_ref());
    let after = rewrite(d.as_ref(), &edits(d.as_ref(), &[(m[0].0, 0.01), (m[1].0, 0.02)], &[]));
    let (src, list) = (text(after.as_ref(), 0), text(after.as_ref(), 1));
    assert!(src.contains("PTP P_2 C_PTP\nPTP P_3\nPTP P[1]\n"), "{src}");
    assert!(list.contains("DECL E6AXIS P_2={A1 1.0100,") && list.contains("P[1]={A1 1.0,"), "{list}");
    let d = of("PTP P[1]\nPTP P[2]\n");
    let m = moves(d.as_ref());
    let after = rewrite(d.as_ref(), &edits(d.as_ref(), &[(m[1].0, 0.02)], &[]));
    assert!(text(after.as_ref(), 1).contains("P[2]={A1 2.0200,"), "{}", text(after.as_ref(), 1));
    for line in ["P[2].A1=5\n", "P[n]=P[1]\n", "FILL(P[])\n", "P[2]=$AXIS_ACT\n"] {
        assert!(why(of(&format!("{line}PTP P[2]\n")).as_ref(), 0).starts_with("P[2]"), "{line}");
    }
    assert_eq!(goals(of("P[2].A1=5\nPTP P[1]\n").as_ref()), "j");
}

#[test]
fn a_product_of_frames_is_one_goal_whose_own_numbers_are_edited() {
    let dat = "DEFDAT prog\nDECL FRAME F={X 100.0,Y 0.0,Z 0.0,A 90.0,B 0.0,C 0.0}\nDECL E6POS P={X 500.0,Y 20.0,Z 30.0,A 0.0,B 90.0,C 0.0,S 2,T 3}\nENDDAT\n";
    let lines = "LIN P:{X 0.0,Y 4.0,Z -5.0,A 0.0,B 0.0,C 0.0} C_DIS\nPTP F:P\nPTP P:F\nLIN P:unknown\nLIN F:{X 1}\n";
    let d = project(&format!("DEF prog( )\n{lines}END\n"), dat, &[]);
    assert_eq!(goals(d.as_ref()), "pppoo");
    let m = moves(d.as_ref());
    let pose = |i: usize| match &m[i].1.goal {
        Goal::Pose(p) => p.clone(),
        other => panic!("{other:?}"),
    };
    // B 90 turns the tool's z along the base's x: P, then 4 along y and -5 along the new z
    let at = pose(0).position_m * 1e3;
    assert!((at - nalgebra::Vector3::new(495.0, 24.0, 30.0)).norm() < 1e-9, "{at}");
    // F turns P by 90 deg about z
    let at = pose(1).position_m * 1e3;
    assert!((at - nalgebra::Vector3::new(80.0, 500.0, 30.0)).norm() < 1e-9, "{at}");
    // status and turn are those of the right operand
    assert_ne!(pose(1).solution, Solution::Same);
    assert_eq!(pose(2).solution, Solution::Same);
    // the numbers in the motion are edited, the name stays; a new point keeps the other factor
    let known = lines.split('\n').take(3).fold(String::new(), |all, line| all + line + "\n");
    let d = project(&format!("DEF prog( )\n{known}END\n"), dat, &[]);
    let m = moves(d.as_ref());
    let target = pose(0).target.unwrap();
    let mut numbers: Vec<f64> = d.script().targets.get(target).unwrap().values.iter().map(|v| v.unwrap().si).collect();
    numbers[1] += 1e-5;
    let point = NewPoint { q: numbers.clone(), share: 0.5, t_s: None, clearance_m: 0.01, of_way: false, waits: false };
    let edit = Edit { goal: Some(numbers), before: vec![point], ..Edit::default() };
    let wish = Edits { steps: [(m[0].0, edit)].into(), pose_digit: [1e-6, 1e-6], ..Edits::default() };
    let out = text(rewrite(d.as_ref(), &wish).as_ref(), 0);
    let line = "LIN P:{X 0.0,Y 4.010,Z -5.0,A 0.0,B 0.0,C 0.0} C_DIS\n";
    assert_eq!(out.matches(line).count(), 2, "{out}");
}

#[test]
fn a_motion_to_where_the_robot_stands_is_none() {
    let d = doc(&[b"DEF a()\nPTP $POS_ACT\nPTP {A1 1.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}\nptp $axis_act C_PTP\nLIN $POS_RET\nPTP $POS_ACT:F\nEND\n"]);
    assert_eq!(goals(d.as_ref()), "joo");
}

#[test]
fn a_point_of_all_modules_that_the_program_itself_assigns_is_not_certain() {
    let config = "DEFDAT $CONFIG\nE6AXIS XG={A1 1.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}\nE6AXIS YG[2]\n\
                  YG[1]={A1 1.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}\nENDDAT\n";
    let of = |src: &str, dat: &str| {
        goals(project(src, &format!("DEFDAT prog\n{dat}ENDDAT\n"), &[("$config.dat", config)]).as_ref())
    };
    assert_eq!(of("DEF prog( )\nPTP XG\nPTP YG[1]\nEND\n", ""), "jj");
    for line in ["XG.A1=42.0", "XG={A1 3.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}", "CHANGE(XG)"] {
        assert_eq!(of(&format!("DEF prog( )\n{line}\nPTP XG\nEND\n"), ""), "o", "{line}");
    }
    assert_eq!(of("DEF prog( )\nPTP XG\nEND\nDEF q( )\nxg.a1=5\nEND\n", ""), "o");
    assert_eq!(of("DEF prog( )\nYG[1].A1=33.0\nPTP YG[1]\nPTP XG\nEND\n", ""), "oj");
    assert_eq!(of("DEF prog( )\nYG[n].A1=33.0\nPTP YG[1]\nEND\n", ""), "o");
    assert_eq!(of("DEF prog( )\nPTP XG\nEND\n", "XG={A1 3.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}\n"), "o");
}

/// Goals of motions to XHOME, XSAFE and the own points XP and XG, beside other modules.
fn beside(own: &str, others: &[(&str, &str)]) -> String {
    let dat = "DEFDAT prog PUBLIC\nDECL E6AXIS XP={A1 1.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}\n\
               DECL GLOBAL E6AXIS XG={A1 2.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}\nENDDAT\n";
    let src = format!("DEF prog( )\n{own}PTP XHOME\nPTP XSAFE\nPTP XP\nPTP XG\nEND\n");
    goals(project(&src, dat, others).as_ref())
}

#[test]
fn an_assignment_behind_do_counts() {
    let all = |teach| [("$config.dat", CONFIG), ("shared.dat", SHARED), ("teach.src", teach)];
    assert_eq!(beside("", &all("DEF teach( )\nEND\n")), "jjjj");
    let trigger = "TRIGGER WHEN DISTANCE=1 DELAY=0 DO XP.A1=33.0\n";
    assert_eq!(beside(trigger, &all("")), "jjoj");
    assert_eq!(beside("INTERRUPT DECL 3 WHEN $IN[1] DO XG=XP\n", &all("")), "jjjo");
    assert_eq!(beside("", &all("DEF teach( )\nTRIGGER WHEN DISTANCE=0 DELAY=0 DO XSAFE.A1=42.0\nEND\n")), "jojj");
    assert_eq!(beside("", &all("DEF teach( )\nGLOBAL INTERRUPT DECL 3 WHEN $IN[1] DO T(XG)\nEND\n")), "jjjo");
}

#[test]
fn a_name_of_one_routine_hides_nothing_in_the_next() {
    let all = |teach| [("$config.dat", CONFIG), ("shared.dat", SHARED), ("teach.src", teach)];
    let local = "DEF a( )\nDECL E6AXIS XSAFE\nXSAFE={A1 1,A2 0}\nEND\n";
    assert_eq!(beside("", &all(local)), "jjjj");
    let two = format!("{local}DEF b( )\nXSAFE={{A1 42.0}}\nEND\n");
    assert_eq!(beside("", &all(&two)), "jojj");
    assert_eq!(beside("", &all("DEF a( )\nDECL E6AXIS Q=XSAFE\nXSAFE.A1=3\nEND\n")), "jojj");
}

#[test]
fn without_a_whole_project_no_point_of_all_modules_is_certain() {
    assert_eq!(beside("", &[("shared.dat", SHARED)]), "oojo");
    let d = project("DEF prog( )\nPTP XSAFE\nEND\n", "DEFDAT prog\nENDDAT\n", &[("b/shared.dat", SHARED)]);
    assert!(why(d.as_ref(), 0).contains("b/shared.dat:2"), "{}", why(d.as_ref(), 0));
    let d = project("DEF prog( )\nPTP XHOME\nEND\n", "DEFDAT prog\nENDDAT\n", &[("R1/$config.dat", CONFIG)]);
    assert!(d.script().notes.iter().any(|n| n.text.contains("R1/$config.dat:2")));
}

#[test]
fn the_basis_counts_but_for_the_homes_and_so_does_another_name() {
    let all = |bas| [("$config.dat", CONFIG), ("shared.dat", SHARED), ("R1/bas.src", bas)];
    assert_eq!(beside("", &all("DEF bas( )\nXHOME.A1=4\nEND\n")), "jjjj");
    assert_eq!(beside("", &all("DEF bas( )\nXSAFE.A1=4\nEND\n")), "jojj");
    let import = "DEFDAT other\nIMPORT E6AXIS XQ IS /R1/Program/prog..XP\nENDDAT\n";
    assert_eq!(beside("", &[("$config.dat", CONFIG), ("shared.dat", SHARED), ("other.dat", import)]), "jjoj");
}

#[test]
fn the_whole_tree_of_a_project_is_searched_or_none_of_it() {
    let root = std::env::temp_dir().join(format!("krl-tree-{}", std::process::id()));
    for (file, content) in [
        ("System/$config.dat", CONFIG),
        ("cell.src", "DEF cell( )\nEND\n"),
        ("Folgen/prog.src", "DEF prog( )\nEND\n"),
        ("Folgen/other.src", "DEF other( )\nEND\n"),
    ] {
        let path = root.join(file);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, content).unwrap();
    }
    let program = root.join("Folgen/prog.src");
    let found = crate::krl::project::files(&program, |_| None, &Folders::default());
    let more = (0..401).map(|k| root.join(format!("f{k}.src")));
    more.for_each(|p| std::fs::write(p, "").unwrap());
    let too_many = crate::krl::project::files(&program, |_| None, &Folders::default());
    std::fs::remove_dir_all(&root).unwrap();
    let wanted = ["Folgen/other.src", "System/$config.dat", "cell.src"].map(|f| root.join(f));
    assert_eq!(found, wanted);
    assert!(too_many.is_empty());
}

#[test]
fn a_point_of_an_own_public_list_is_not_certain_beside_a_file_that_cannot_be_read() {
    let of = |list: &str, other: Text| {
        let data = format!("DEFDAT prog{list}\nDECL E6AXIS XP={{A1 1,A2 -90,A3 90,A4 0,A5 10,A6 0}}\nENDDAT\n");
        let own = [("p.src", "DEF prog( )\nPTP XP\nEND\n"), ("p.dat", data.as_str())];
        let own = own.map(|(n, t)| Text::new(n, t.as_bytes().to_vec())).into_iter();
        let config = Text::of_context("$config.dat", CONFIG.as_bytes().to_vec());
        goals(Krl.parse(own.chain([config, other]).collect(), &kr120()).unwrap().as_ref())
    };
    let readable = || Text::of_context("b.src", b"DEF b( )\nEND\n".to_vec());
    assert_eq!(of(" PUBLIC", readable()), "j");
    assert_eq!(of(" PUBLIC", Text::unread("b.src")), "o");
    // no other module can give a point of a private list a name
    assert_eq!(of("", Text::unread("b.src")), "j");
}

#[test]
fn a_point_of_all_modules_is_not_certain_beside_a_file_that_cannot_be_read() {
    let of = |other: Text| {
        let own = [("p.src", "DEF prog( )\nPTP XHOME\nEND\n"), ("p.dat", "DEFDAT prog\nENDDAT\n")];
        let own = own.map(|(n, t)| Text::new(n, t.as_bytes().to_vec())).into_iter();
        let config = Text::of_context("$config.dat", CONFIG.as_bytes().to_vec());
        let doc = Krl.parse(own.chain([config, other]).collect(), &kr120()).unwrap();
        (goals(doc.as_ref()), why(doc.as_ref(), 0))
    };
    assert_eq!(of(Text::of_context("b.src", b"DEF b( )\nEND\n".to_vec())).0, "j");
    let wide: Vec<u8> = "DEF b( )\nXHOME.A1=5\nEND\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    for other in [Text::unread("b.src"), Text::of_context("b.src", wide)] {
        let (found, why) = of(other);
        assert_eq!(found, "o");
        assert!(why.contains("b.src cannot be read"), "{why}");
    }
}

#[test]
fn what_a_routine_of_another_file_leaves_behind_holds_after_its_call() {
    let line = "LIN {X 1.0,Y 2.0,Z 3.0,A 10.0,B 20.0,C 30.0}\n";
    // base and tool of the motions, or why they stay
    let of = |body: &str, others: &[(&str, &str)]| {
        let d =
            project(&format!("DEF prog( )\nBAS(#BASE,1)\nBAS(#TOOL,2)\n{body}END\n"), "DEFDAT prog\nENDDAT\n", others);
        let said = |m: &Move| match &m.goal {
            Goal::Pose(p) => p.unknown().map_or(format!("{:?} {:?}", p.frame, p.tool), ToString::to_string),
            Goal::Opaque(why) => why.to_string(),
            other => format!("{other:?}"),
        };
        moves(d.as_ref()).iter().map(|(_, m)| said(m)).collect::<Vec<String>>()
    };
    let calls = format!("{line}sub()\n{line}");
    let [before, quiet] = of(&calls, &[("sub.src", "DEF sub( )\nLIN {X 1}\nEND\n")]).try_into().unwrap();
    assert_eq!(before, quiet);
    for (does, word) in [
        ("$BASE=BASE_DATA[3]", "$BASE as a routine sets it"),
        ("BAS(#TOOL,5)", "$TOOL as a routine sets it"),
        ("FDAT_ACT=FP7\nBAS(#PTP_PARAMS,100)", "$BASE as a routine sets it"),
        ("BASE_DATA[1]={X 1,Y 2,Z 3,A 0,B 0,C 0}", "1 as the program sets it"),
        ("$IPO_MODE=#TCP", "$IPO_MODE is set"),
        ("$WORLD=$NULLFRAME", "$WORLD is set"),
        ("$ORI_TYPE=#CONSTANT", "$ORI_TYPE"),
        ("ret=RSI_ON(#RELATIVE)", "a sensor"),
        ("$TECH[1].MODE=#CYCLE", "a function generator"),
        ("CONVEYOR.FOLLOW(#C1,1,1)", "a conveyor"),
    ] {
        let sub = format!("DEF sub( )\n{does}\nEND\n");
        let through = format!("DEF sub( )\nIF $IN[1] THEN\ndeep()\nENDIF\nEND\nGLOBAL DEF deep( )\n{does}\nEND\n");
        for file in [&sub, &through] {
            let found = of(&calls, &[("sub.src", file)]);
            // frames are set anew before the first motion; the rest may be left from an earlier run
            assert!(found[0] == before || !word.contains("as a routine"), "{file}: {}", found[0]);
            assert!(found[1].contains(word), "{file}: {}", found[1]);
        }
        // another routine than the one that is called; one of its own with the same name
        let other = [("other.src", format!("DEF other( )\n{does}\nEND\n"))].map(|(n, t)| (n, t.clone()));
        assert_eq!(of(&calls, &[(other[0].0, &other[0].1)]), [before.clone(), quiet.clone()], "{does}");
        let own = format!("{calls}END\nDEF sub( )\nLIN {{X 1}}\n");
        assert_eq!(of(&own, &[("sub.src", &sub)])[..2], [before.clone(), quiet.clone()], "{does}");
    }
    let on_and_off = "DEF sub( )\nret=RSI_ON(#RELATIVE)\nLIN {X 1}\nret=RSI_OFF()\nEND\n";
    assert_eq!(of(&calls, &[("sub.src", on_and_off)]), [before, quiet]);
}
