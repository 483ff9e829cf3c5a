//! Orientations that the controller does not take from the point, parts that the robot holds, sensors and conveyors.

use super::*;

const AT: &str = "LIN {X 1.0,Y 2.0,Z 3.0,A 10.0,B 20.0,C 30.0}\n";

/// Of each motion: why its goal stays, and why it takes no point.
fn of(src: &str, dat: &str) -> Vec<(String, String)> {
    let dat = format!("DEFDAT a\n{dat}ENDDAT\n");
    let d = doc(&[format!("DEF a()\n{src}END\n").as_bytes(), dat.as_bytes()]);
    let closed = |m: &Move| m.closed.as_ref().map(ToString::to_string).unwrap_or_default();
    let said = |m: &Move| match &m.goal {
        Goal::Opaque(why) => (why.to_string(), closed(m)),
        _ => (String::new(), closed(m)),
    };
    moves(d.as_ref()).iter().map(|(_, m)| said(m)).collect()
}

#[test]
fn a_motion_of_constant_orientation_stays_and_one_of_the_wrist_takes_no_point() {
    let evenly = of(AT, "").remove(0);
    assert!(evenly.0.is_empty() && !evenly.1.contains("ORI_TYPE"), "{evenly:?}");
    let data = "DECL LDAT LCPDAT1={VEL 2.0,ACC 100.0,ORI_TYP #CONSTANT,CIRC_TYP #BASE}\n\
                DECL LDAT LCPDAT2={VEL 2.0,ACC 100.0,ORI_TYP #JOINT,CIRC_TYP #BASE}\n\
                DECL LDAT LCPDAT3={VEL 2.0,ACC 100.0,ORI_TYP #VAR,CIRC_TYP #BASE}\n";
    let slin = AT.replace("LIN", "SLIN").trim_end().to_string();
    let constant = [
        format!("$ORI_TYPE=#CONSTANT\n{AT}"),
        format!("LDAT_ACT=LCPDAT1\nBAS(#CP_PARAMS,2)\n{AT}"),
        format!("LDAT_ACT={{VEL 2.0,ACC 100.0,ORI_TYP #CONSTANT}}\n{AT}"),
        format!("{slin} WITH $ORI_TYPE=#CONSTANT\n"),
        format!("{slin} WITH $VEL=SVEL_CP(2.0,,LCPDAT1),$ORI_TYPE=SORI_TYP(LCPDAT1)\n"),
        format!("$ORI_TYPE=myType\n{AT}"),
    ];
    for src in constant {
        let said = of(&src, data).remove(0);
        assert!(said.0.contains("ORI_TYPE"), "{src}: {said:?}");
    }
    // motion data come into force with BAS, and again whatever was set since
    for src in [
        format!("$ORI_TYPE=#CONSTANT\nLDAT_ACT=LCPDAT3\n{AT}"),
        format!("LDAT_ACT=LCPDAT1\n$ORI_TYPE=#VAR\nBAS(#CP_PARAMS,2)\n{AT}"),
        format!("LDAT_ACT=LCPDAT1\n$ORI_TYPE=#VAR\nBAS(#CP_DAT)\n{AT}"),
        format!(
            "setup()\n$ORI_TYPE=#VAR\nBAS(#CP_PARAMS,2)\n{AT}END\nDEF setup()\nLDAT_ACT=LCPDAT1\nEND\nDEF last()\n{AT}"
        ),
    ] {
        let said = of(&src, data).remove(0);
        assert!(said.0.contains("ORI_TYPE"), "{src}: {said:?}");
    }
    for src in [
        format!("LDAT_ACT=LCPDAT1\n$ORI_TYPE=#VAR\nBAS(#PTP_PARAMS,50)\n{AT}"),
        format!("$ORI_TYPE=#CONSTANT\nLDAT_ACT=LCPDAT3\nBAS(#CP_PARAMS,2)\n{AT}"),
    ] {
        assert_eq!(of(&src, data).remove(0), evenly, "{src}");
    }
    for src in [format!("$ORI_TYPE=#JOINT\n{AT}"), format!("LDAT_ACT=LCPDAT2\n{AT}")] {
        let said = of(&src, data).remove(0);
        assert!(said.0.is_empty() && said.1.contains("#JOINT"), "{src}: {said:?}");
    }
    for src in [
        format!("$ORI_TYPE=#CONSTANT\nBAS(#INITMOV,0)\n{AT}"),
        format!("LDAT_ACT=LCPDAT1\nBAS(#CP_PARAMS,2)\nLDAT_ACT=LCPDAT3\nBAS(#CP_PARAMS,2)\n{AT}"),
        format!("$ORI_TYPE=#CONSTANT\n{slin} WITH $ORI_TYPE=SORI_TYP(LCPDAT3)\n"),
    ] {
        assert_eq!(of(&src, data).remove(0), evenly, "{src}");
    }
    // a joint motion turns as it does
    let ptp = of("$ORI_TYPE=#CONSTANT\nPTP {A1 5.0}\n", "").remove(0);
    assert!(ptp.0.is_empty(), "{ptp:?}");
}

#[test]
fn frame_data_say_that_the_robot_holds_the_part() {
    let data = "DECL FDAT FP1={TOOL_NO 1,BASE_NO 2,IPO_FRAME #TCP,POINT2[] \" \"}\n\
                DECL FDAT FP2={TOOL_NO 1,BASE_NO 2,IPO_FRAME #BASE,POINT2[] \" \"}\n";
    let frame = |form: &str| {
        let d = doc(&[format!("DEF a()\n{form}{AT}END\n").as_bytes(), format!("DEFDAT a\n{data}ENDDAT\n").as_bytes()]);
        match &moves(d.as_ref())[0].1.goal {
            Goal::Pose(p) => p.frame.unknown().map_or(format!("{:?}", p.frame), ToString::to_string),
            other => format!("{other:?}"),
        }
    };
    for form in ["FDAT_ACT=FP1\nBAS(#FRAMES)\n", "FDAT_ACT={TOOL_NO 1,BASE_NO 2,IPO_FRAME #TCP}\n"] {
        assert!(frame(form).contains("holds the part"), "{}", frame(form));
    }
    assert!(frame("FDAT_ACT=FP1\nFDAT_ACT=FP2\n").contains("Named"), "{}", frame("FDAT_ACT=FP2\n"));
    let slin = AT.replace("LIN", "SLIN").trim_end().to_string();
    let with =
        |p: &str| of(&format!("{slin} WITH $BASE=SBASE(F{p}.BASE_NO),$IPO_MODE=SIPO_MODE(F{p}.IPO_FRAME)\n"), data);
    assert!(with("P1")[0].0.contains("holds the part") && !with("P2")[0].0.contains("holds the part"));
}

#[test]
fn motions_under_a_sensor_or_on_a_conveyor_stay() {
    let left = |src: &str| of(src, "").iter().map(|m| !m.0.is_empty()).collect::<Vec<bool>>();
    let j = "PTP {A1 5.0}\n";
    assert_eq!(left(&format!("{j}ret=RSI_ON(#RELATIVE)\n{j}{AT}ret=RSI_OFF()\n{j}")), [false, true, true, false]);
    assert_eq!(left(&format!("{j}IF (RSI_ON() <> RSIOK) THEN\nHALT\nENDIF\n{j}RSI_OFF()\n{j}")), [false, true, false]);
    assert_eq!(left(&format!("{j}CONVEYOR.FOLLOW(#C1,1,1)\n{j}CONVEYOR.QUIT()\n{j}")), [false, true, false]);
    // a function generator, which weaves
    let generator = format!("{j}$TECH[1].MODE=#CYCLE\n{j}$TECH[1].CLASS=#PATH\n{AT}$TECH[1].MODE=#OFF\n{j}");
    assert_eq!(left(&generator), [false, true, true, false]);
    // of the next round, of another way to the label, of whoever called
    assert_eq!(left(&format!("LOOP\n{j}ret=RSI_ON(#RELATIVE)\n{j}ENDLOOP\nret=RSI_OFF()\n{j}")), [true, true, false]);
    let past =
        format!("ret=RSI_ON(#RELATIVE)\nIF $IN[1] THEN\nGOTO L1\nENDIF\nret=RSI_OFF()\n{j}L1:\n{j}ret=RSI_OFF()\n");
    assert_eq!(left(&past), [false, true]);
    assert_eq!(left(&format!("{j}ret=RSI_OFF()\n{j}")), [true, false]);
    // offsets of the joints, in all routines
    for set in ["$JOINT_OFFSET[1]=0.2\n", "$joint_offset[1] = x\n"] {
        assert_eq!(left(&format!("{j}{set}{j}")), [true, true], "{set}");
    }
}

#[test]
fn what_holds_after_a_branch_or_a_call_is_what_any_of_them_may_have_set() {
    let constant = |src: &str| of(src, "").last().unwrap().0.contains("ORI_TYPE");
    assert!(constant(&format!("IF $IN[1] THEN\n$ORI_TYPE=#CONSTANT\nELSE\n$ORI_TYPE=#VAR\nENDIF\n{AT}")));
    assert!(constant(&format!("setup()\n{AT}END\nDEF setup()\n$ORI_TYPE=#CONSTANT\n")));
    assert!(!constant(&format!("setup()\n$ORI_TYPE=#VAR\n{AT}END\nDEF setup()\n$ORI_TYPE=#CONSTANT\n")));
    assert!(!constant(&format!("IF $IN[1] THEN\n$ORI_TYPE=#VAR\nENDIF\n{AT}")));
    let led = |src: &str| of(src, "").last().unwrap().0.contains("leads the robot away");
    assert!(led(&format!("setup()\n{AT}END\nDEF setup()\nret=RSI_ON(#RELATIVE)\n")));
    assert!(led(&format!("IF $IN[1] THEN\nret=RSI_ON(#RELATIVE)\nELSE\nret=RSI_OFF()\nENDIF\n{AT}")));
    assert!(led(&format!("ret=RSI_ON(#RELATIVE)\nIF $IN[1] THEN\nret=RSI_OFF()\nENDIF\n{AT}")));
    assert!(!led(&format!(
        "seam()\n{AT}END\nDEF seam()\nret=RSI_ON(#RELATIVE)\n{AT}ret=RSI_OFF()\nEND\nDEF last()\n{AT}"
    )));
}
