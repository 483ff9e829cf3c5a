//! Which base and tool are in force at a motion, where a program sets them by other ways than the plain one.

use super::*;

/// Straight to a pose.
const AT: &str = "LIN {X 1.0,Y 2.0,Z 3.0,A 10.0,B 20.0,C 30.0}\n";

/// Base and tool of each Cartesian goal, as text.
fn said(src: &str) -> Vec<[String; 2]> {
    let data = "DEFDAT a\nDECL FDAT FP1={TOOL_NO 2,BASE_NO 1,IPO_FRAME #BASE,POINT2[] \" \"}\n\
                DECL FDAT FP2={TOOL_NO 4,BASE_NO 3,IPO_FRAME #BASE,POINT2[] \" \"}\nENDDAT\n";
    let src = if src.starts_with("DEF ") { src.to_string() } else { format!("DEF a()\n{src}END\n") };
    let d = doc(&[src.as_bytes(), data.as_bytes()]);
    let text = |f: &Frame| match f {
        Frame::Named(name) | Frame::Computed(name) => name.clone(),
        Frame::Unknown(why) => why.to_string(),
        other => format!("{other:?}"),
    };
    let of = |m: &Move| match &m.goal {
        Goal::Pose(p) => [text(&p.frame), text(&p.tool)],
        other => [format!("{other:?}"), String::new()],
    };
    moves(d.as_ref()).iter().map(|(_, m)| of(m)).collect()
}

fn last(src: &str) -> [String; 2] {
    said(src).pop().unwrap()
}

#[test]
fn a_part_that_the_robot_holds_stays_held_when_a_base_is_set() {
    for set in ["$BASE=BASE_DATA[1]\n", "BAS(#BASE,1)\n", "$IN_USE=TRUE\nLOOP\n"] {
        let end = if set.contains("LOOP") { "ENDLOOP\n" } else { "" };
        let [base, _] = last(&format!("$BASE=BASE_DATA[1]\n$IPO_MODE=#TCP\n{set}{AT}{end}"));
        assert!(base.contains("$IPO_MODE is set"), "{set}: {base}");
        assert_eq!(last(&format!("$IPO_MODE=#TCP\n{set}$IPO_MODE=#BASE\n$BASE=BASE_DATA[1]\n{AT}{end}"))[0], "1");
    }
    assert!(last(&format!("$WORLD={{X 1,Y 0,Z 0,A 0,B 0,C 0}}\n$BASE=BASE_DATA[1]\n{AT}"))[0].contains("$WORLD"));
}

#[test]
fn a_motion_has_the_frames_that_stand_behind_its_with() {
    let slin = AT.replace("LIN", "SLIN").trim_end().to_string();
    let with = |with: &str| last(&format!("$BASE=BASE_DATA[7]\n$TOOL=TOOL_DATA[8]\n{slin} {with}\n"));
    let of = |base: &str, tool: &str| [base.to_string(), tool.to_string()];
    assert_eq!(with("WITH $TOOL=STOOL2(FP1), $BASE=SBASE(FP1.BASE_NO) C_SPL"), of("1", "2"));
    assert_eq!(with("WITH $VEL=SVEL_CP(2.0,,LCPDAT1),$TOOL=TOOL_DATA[5]"), of("7", "5"));
    assert_eq!(with("WITH $VEL.CP=0.5"), of("7", "8"));
    assert!(with("WITH $BASE=BASE_DATA[n],$VEL.CP=0.5")[0].contains("BASE_DATA[n]"));
    let two = said(&format!("$TOOL=TOOL_DATA[8]\n{slin} WITH $TOOL=STOOL2(FP2)\n{AT}"));
    assert_eq!([&two[0][1], &two[1][1]], ["4", "8"]);
    let block = said(&format!("$TOOL=TOOL_DATA[8]\nSPLINE WITH $TOOL=STOOL2(FP2)\nSPL{}ENDSPLINE\n{AT}", &AT[3..]));
    assert_eq!([&block[0][1], &block[1][1]], ["4", "8"]);
}

#[test]
fn what_bas_puts_into_force_is_what_it_does() {
    // the base on the flange of an external axis
    assert_eq!(last(&format!("$BASE=BASE_DATA[1]\nBAS(#EX_BASE,2)\n{AT}"))[0], "EX_BASE 2");
    // the frames with which programs begin
    assert_eq!(last(&format!("BAS(#BASE,1)\nBAS(#TOOL,2)\nBAS(#INITMOV,0)\n{AT}")), ["$BASE", "$TOOL"]);
    // those of FDAT_ACT, whatever was set since
    let params = |call: &str| last(&format!("FDAT_ACT=FP1\n{call}BAS(#BASE,5)\nBAS(#TOOL,6)\n{call}{AT}"));
    for call in ["BAS(#CP_PARAMS,0.5)\n", "BAS(#PTP_PARAMS,50)\n", "BAS(#FRAMES)\n"] {
        assert_eq!(params(call), ["1", "2"], "{call}");
    }
    assert_eq!(params("BAS(#VEL_CP,0.5)\n"), ["5", "6"]);
    assert_eq!(last(&format!("BAS(#BASE,5)\nBAS(#CP_PARAMS,0.5)\n{AT}")), ["base of FDAT_ACT", "$TOOL"]);
}

#[test]
fn the_program_starts_with_the_frames_that_are_in_force_then() {
    let all = said(&format!("{AT}BAS(#BASE,2)\n{AT}"));
    assert_eq!([&all[0][0], &all[1][0]], ["$BASE", "2"]);
    // it may come back from further down
    let round = said(&format!("LOOP\n{AT}BAS(#BASE,2)\n{AT}ENDLOOP\n"));
    assert!(round[0][0].contains("$BASE") && round[0][0].contains("\"2\"") && round[1][0] == "2", "{round:?}");
    // a routine may have set it
    assert_eq!(last(&format!("DEF a()\ninit()\n{AT}END\nDEF init()\nBAS(#BASE,2)\nEND\n"))[0], "2");
}

#[test]
fn a_list_of_the_controller_that_is_set_in_a_branch_in_part_or_by_an_index_is_not_certain() {
    let at = |set: &str| last(&format!("{set}BAS(#BASE,1)\n{AT}"))[0].clone();
    let frame = "{X 0,Y 0,Z 0,A 90,B 0,C 0}";
    assert!(at(&format!("BASE_DATA[1]={frame}\n")).starts_with("Given"));
    let branch = at(&format!("IF $IN[1] THEN\nBASE_DATA[1]={frame}\nENDIF\n"));
    assert!(branch.starts_with("Any") && branch.contains("Named(\"1\")") && branch.contains("Given"), "{branch}");
    let other = at(&format!("IF $IN[1] THEN\nn=1\nELSE\nBASE_DATA[1]={frame}\nENDIF\n"));
    assert_eq!(other, branch);
    for set in ["BASE_DATA[1].A=90\n", "BASE_DATA[n]={X 0,Y 0,Z 0,A 90,B 0,C 0}\n"] {
        assert_eq!(at(set), "1 as the program sets it", "{set}");
    }
    // past it, before it in the next round, in a routine that is called
    for lines in [
        format!("IF $IN[1] THEN\nGOTO L1\nENDIF\nBASE_DATA[1]={frame}\nL1:\nBAS(#BASE,1)\n{AT}"),
        format!("LOOP\nBAS(#BASE,1)\n{AT}BASE_DATA[1]={frame}\nENDLOOP\n"),
        format!("init()\nBAS(#BASE,1)\n{AT}END\nDEF init()\nBASE_DATA[1]={frame}\n"),
        format!("init()\nBAS(#BASE,1)\nIF $IN[1] THEN\n{AT}ENDIF\nEND\nDEF init()\nBASE_DATA[1]={frame}\n"),
    ] {
        let base = &said(&lines)[0][0];
        assert!(base.starts_with("Any") && base.contains("Named(\"1\")") && base.contains("Given"), "{lines}: {base}");
    }
    // whichever way it came, it has been set
    assert!(at(&format!("BASE_DATA[1]={frame}\nmay_move()\n")).starts_with("Given"));
    assert_eq!(last(&format!("BASE_DATA[1].A=90\nFDAT_ACT=FP1\n{AT}"))[0], "1 as the program sets it");
    assert_eq!(last(&format!("FP1.BASE_NO=3\nFDAT_ACT=FP1\n{AT}"))[0], "base of FP1");
}

#[test]
fn a_routine_that_is_given_the_base_itself_may_set_it() {
    for call in ["SETB($BASE)\n", "SETB(1,$base)\n", "N=SETB($BASE,2)\n"] {
        assert_eq!(last(&format!("$BASE=BASE_DATA[1]\n{call}{AT}"))[0], "$BASE as a routine sets it", "{call}");
    }
    assert_eq!(last(&format!("$TOOL=TOOL_DATA[1]\nN=SETT($TOOL)\n{AT}"))[1], "$TOOL as a routine sets it");
    // a part of it is a number, and what is set after the call is known
    assert_eq!(last(&format!("$BASE=BASE_DATA[1]\nN=ABS($BASE.X)\n{AT}"))[0], "1");
    assert_eq!(last(&format!("SETB($BASE)\n$BASE=BASE_DATA[1]\n{AT}"))[0], "1");
}

#[test]
fn a_plain_motion_with_settings_of_its_own_gets_no_copy_without_them() {
    let closed = |line: &str| {
        let d = doc(&[format!("DEF a()\n$BASE=BASE_DATA[1]\n{line}END\n").as_bytes()]);
        moves(d.as_ref())[0].1.closed.is_some()
    };
    let of = AT.trim_end();
    assert!(closed(&format!("{of} WITH $BASE={{X 50.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0}}\n")));
    assert!(closed("PTP {A1 5} WITH $VEL_AXIS[1]=10\n"));
    assert!(!closed(AT) && !closed(&format!("{of} ;WITH $BASE\n")));
    assert!(!closed(&format!("S{of} WITH $BASE=BASE_DATA[2]\n")));
}

/// `$config.dat`: base 1 on a table, base 3 on another robot.
const CARRIED: &str = "DEFDAT $CONFIG PUBLIC\nMACHINE_DEF[2]={NAME[] \"DKP\",COOP_KRC_INDEX 1,ROOT {X 1.0},MECH_TYPE #EASYS}\n\
    MACHINE_DEF[3]={NAME[] \"R2\",COOP_KRC_INDEX 2,MECH_TYPE #ROBOT}\nMACHINE_FRAME_DAT[1]={MACH_DEF_INDEX 2,PARENT[] \"DKP\"}\n\
    MACHINE_FRAME_DAT[3]={MACH_DEF_INDEX 3}\nMACHINE_FRAME_DAT[5]={MACH_DEF_INDEX 0}\nENDDAT\n";

/// The bases of the Cartesian goals, where the project has a [`CARRIED`] list, or (`given`) the user gives it.
fn bases(src: &str, given: bool) -> Vec<String> {
    let data = "DEFDAT a\nDECL FDAT FP1={TOOL_NO 2,BASE_NO 1,IPO_FRAME #BASE}\nDECL FDAT FP3={TOOL_NO 4,BASE_NO 3,IPO_FRAME #BASE}\nENDDAT\n";
    let src = format!("DEF a()\n{src}END\n");
    let mut texts: Vec<Text> = [("a.src", src.as_str()), ("a.dat", data)].map(|(n, t)| Text::new(n, t.into())).into();
    let mut robot = kr120();
    if given {
        robot.carried_bases = crate::bases::CarriedBases::of_list(CARRIED);
    } else {
        texts.push(Text::of_context("R1/System/$config.dat", CARRIED.into()));
    }
    let d = Krl.parse(texts, &robot).unwrap();
    let base = |m: &Move| match &m.goal {
        Goal::Pose(p) => match &p.frame {
            Frame::Named(name) => name.clone(),
            Frame::Computed(name) => format!("computed {name}"),
            other => other.unknown().map_or_else(|| format!("{other:?}"), |why| why.to_string()),
        },
        other => format!("{other:?}"),
    };
    moves(d.as_ref()).iter().map(|(_, m)| base(m)).collect()
}

#[test]
fn frame_data_on_an_external_axis_are_another_base_than_that_in_the_world() {
    for given in [false, true] {
        for set in ["FDAT_ACT=FP1\nBAS(#PTP_PARAMS,100)\n", "FDAT_ACT={TOOL_NO 1,BASE_NO 1}\nBAS(#FRAMES)\n"] {
            assert_eq!(bases(&format!("{set}{AT}"), given), ["1 on MACHINE_DEF[2]"], "{set}");
        }
        let number = format!("FDAT_ACT=FP3\nFDAT_ACT.BASE_NO=1\nBAS(#CP_PARAMS,1)\n{AT}");
        assert_eq!(bases(&number, given), ["1 on MACHINE_DEF[2]"]);
        let own = format!("BASE_DATA[1]={{X 1,Y 2,Z 3,A 0,B 0,C 0}}\nFDAT_ACT=FP1\nBAS(#FRAMES)\n{AT}");
        assert_eq!(bases(&own, given), ["computed 1 as the program sets it on MACHINE_DEF[2]"]);
        let other = bases(&format!("FDAT_ACT=FP3\nBAS(#CP_PARAMS,1)\n{AT}"), given);
        assert!(other[0].contains("base 3 counts from MACHINE_DEF[3]"), "{other:?}");
        // these put BASE_DATA[1] itself into force, or a base that the list leaves in the world
        for (set, is) in [("BAS(#BASE,1)", "1"), ("$BASE=BASE_DATA[1]", "1"), ("FDAT_ACT={TOOL_NO 1,BASE_NO 5}", "5")] {
            assert_eq!(bases(&format!("{set}\n{AT}"), given), [is], "{set}");
        }
    }
}
