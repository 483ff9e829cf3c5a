//! What leads the robot away from its points: soft servos, the RSI of KRC2, seams of ArcTech.

use super::*;
use crate::no_motion::NoMotion;

const AXES: &str = "PTP {A1 0,A2 -90,A3 90,A4 10,A5 30,A6 0}\n";

/// Which motions stay, of a program, its data list and other files of its project.
fn left_of(src: &str, dat: &str, others: &[(&str, &str)]) -> Vec<bool> {
    reasons(src, dat, others).iter().map(|why| why.is_some()).collect()
}

fn reasons(src: &str, dat: &str, others: &[(&str, &str)]) -> Vec<Option<String>> {
    let src = if src.starts_with("DEF ") { src.to_string() } else { format!("DEF p()\n{src}END\n") };
    let mut texts = vec![Text::new("p.src", src.into_bytes())];
    texts.push(Text::new("p.dat", format!("DEFDAT p\n{dat}ENDDAT\n").into_bytes()));
    texts.extend(others.iter().map(|(name, bytes)| Text::of_context(*name, bytes.as_bytes().to_vec())));
    // what moves nothing may lead all the same
    let mut robot = kr120();
    robot.no_motion = NoMotion::of(["ARCMAINNG", "SET_TORQUE_LIMITS", "ST_ON"]);
    let declared = Krl.parse(texts.clone(), &robot).unwrap();
    let doc = Krl.parse(texts, &kr120()).unwrap();
    let of = |(_, m): (usize, Move)| match m.goal {
        Goal::Opaque(why) => Some(why.to_string()),
        _ => None,
    };
    let all: Vec<Option<String>> = moves(doc.as_ref()).into_iter().map(of).collect();
    assert_eq!(moves(declared.as_ref()).into_iter().map(of).collect::<Vec<_>>(), all);
    all
}

fn left(src: &str) -> Vec<bool> {
    left_of(src, "", &[])
}

#[test]
fn motions_stay_while_a_soft_servo_is_on() {
    let soft = "a soft servo leads the robot away from its points";
    for (on, off) in [
        ("$TORQUE_AXIS='B010001'", "$TORQUE_AXIS='B000000'"),
        ("$torque_axis=16", "$torque_axis = 0"),
        ("$TORQUE_AXIS=MASK", "$TORQUE_AXIS='H00'"),
        ("$CURR_RED[1,1]=10", "$CURR_RED[1,1]=100"),
        ("$CURR_RED[ 1 , 2 ]=SHARE", "$CURR_RED[1,2]=100.0"),
        ("$CURR_RED[1,1]=50\n$TORQUE_AXIS='B000001'", "$TORQUE_AXIS='B000000'"),
        ("SET_TORQUE_LIMITS(1,{LOWER -500,UPPER 500,MONITOR #OFF})", "RESET_TORQUE_LIMITS(1)"),
        ("SET_TORQUE_LIMITS(AXIS_NR,LIMITS)", "RESET_TORQUE_LIMITS(AXIS_NR)"),
    ] {
        let src = format!("{AXES}{on}\n{AXES}{AXES}{off}\n{AXES}");
        let why = reasons(&src, "", &[]);
        assert_eq!(why, [None, Some(soft.to_string()), Some(soft.to_string()), None], "{on}");
    }
}

#[test]
fn an_axis_that_is_made_stiff_again_ends_nothing_of_another() {
    let torque = "SET_TORQUE_LIMITS(1,L)\nSET_TORQUE_LIMITS(2,L)\n";
    let src = format!("{torque}{AXES}RESET_TORQUE_LIMITS(1)\n{AXES}RESET_TORQUE_LIMITS(2)\n{AXES}");
    assert_eq!(left(&src), [true, true, false]);
    let current = "$CURR_RED[1,1]=10\n$CURR_RED[2,1]=20\n";
    let src = format!("{current}{AXES}$CURR_RED[1,1]=100\n{AXES}$CURR_RED[2,1]=100\n{AXES}");
    assert_eq!(left(&src), [true, true, false]);
    // full currents at the start say nothing of before
    assert_eq!(left(&format!("{AXES}$CURR_RED[1,1]=100\n{AXES}")), [false; 2]);
    // all currents of six axes have ends
    let each =
        |share: u32| (0..12).map(|k| format!("$CURR_RED[{},{}]={share}\n", k / 2 + 1, k % 2 + 1)).collect::<String>();
    assert_eq!(left(&format!("{}{AXES}{}{AXES}", each(30), each(100))), [true, false]);
}

#[test]
fn a_soft_servo_of_a_branch_a_routine_or_a_trigger_may_be_on_after_it() {
    let on = "$TORQUE_AXIS='B1'";
    let off = "$TORQUE_AXIS='B0'";
    let branch = format!("IF $IN[1] THEN\n{on}\nENDIF\n{AXES}{off}\n{AXES}");
    assert_eq!(left(&branch), [true, false]);
    let passed = format!("{on}\nIF $IN[1] THEN\n{off}\nENDIF\n{AXES}");
    assert_eq!(left(&passed), [true]);
    let trigger = format!("TRIGGER WHEN DISTANCE=0 DELAY=0 DO {on}\n{AXES}{off}\n{AXES}");
    assert_eq!(left(&trigger), [true, false]);
    // until the TRIGGER strikes it is on
    let ends = format!("{on}\n{AXES}TRIGGER WHEN DISTANCE=0 DELAY=0 DO {off}\n{AXES}");
    assert_eq!(left(&ends), [true, true]);
    let own = format!("DEF p()\nSOFT()\n{AXES}STIFF()\n{AXES}END\nDEF SOFT()\n{on}\nEND\nDEF STIFF()\n{off}\nEND\n");
    // what one routine leaves on may be on in all
    assert_eq!(left(&own), [true, true]);
    let elsewhere = format!("DEF SOFT()\n{on}\nEND\n");
    let src = format!("{AXES}SOFT()\n{AXES}{off}\n{AXES}");
    // what the file ends without having begun it may be on from its start
    assert_eq!(left_of(&src, "", &[("soft.src", &elsewhere)]), [true, true, false]);
    let both = format!("{elsewhere}DEF STIFF()\n{off}\nEND\n");
    let src = format!("{AXES}SOFT()\n{AXES}STIFF()\n{AXES}");
    assert_eq!(left_of(&src, "", &[("soft.src", &both)]), [false, true, false]);
    // the routine itself, and variables of other names
    let named = format!("DEF p()\n{AXES}$TORQUE_AXIS_MAX[1]=5\n{AXES}END\nDEF SET_TORQUE_LIMITS(N:IN,L:IN)\nEND\n");
    assert_eq!(left(&named), [false; 2]);
}

#[test]
fn motions_stay_between_st_on_and_st_off() {
    for on in ["err=ST_ON()", "ERR=ST_ON1(#BASE,1)", "ST_ON()", "IF ST_ON()<>#RSIOK THEN\nHALT\nENDIF"] {
        for off in ["err=ST_OFF()", "ST_OFF()", "IF ST_OFF()<>#RSIOK THEN\nHALT\nENDIF"] {
            let src = format!("{AXES}LOOP\n{on}\n{AXES}{AXES}{off}\n{AXES}ENDLOOP\n");
            assert_eq!(left(&src), [false, true, true, false], "{on} {off}");
        }
    }
    let why = reasons(&format!("err=ST_ON()\n{AXES}"), "", &[]).remove(0).unwrap_or_default();
    assert!(why.starts_with("a sensor"), "{why}");
    assert_eq!(left(&format!("LAST_ONE=1\nST_ON_TIME=2\n{AXES}")), [false]);
}

const LIN: &str = "LIN {X 1,Y 2,Z 3,A 0,B 0,C 0} C_DIS\n";
const PLAIN: &str = "Weave {Pattern #None,Length 4.0,Amplitude 2.0},Advanced {SlopeOption #None}";
const WOVEN: &str = "Weave {Pattern #Triangle,Length 3.5,Amplitude 2.0}";
const TRACKED: &str = "Weave {Pattern #None},Track {IsArcSenseEnabled TRUE,ControlEnabled TRUE}";

fn weld_data(name: &str, parts: &str) -> String {
    format!("DECL stArcDat_T {name}={{WdatId[] \"{name}\",Strike {{JobModeId[] \"Job, a\",StartTime 0.0}},{parts}}}\n")
}

/// An inline form of ArcTech: `On`, `Swi` or `Off`.
fn form(kind: &str, data: &str) -> String {
    format!(
        "TRIGGER WHEN DISTANCE=1 DELAY=0 DO ArcMainNG(#PreDefinition,{data},WP1) PRIO=-1\n\
         ArcMainNG(#Arc{kind}BeforeMoveStd,{data},WP1)\n{LIN}ArcMainNG(#Arc{kind}AfterMoveStd,{data},WP1)\n"
    )
}

fn seam(first: &str, second: &str, end: &str) -> String {
    format!("{LIN}{}{LIN}{}{LIN}{}{LIN}", form("On", first), form("Swi", second), form("Off", end))
}

#[test]
fn a_seam_that_arctech_weaves_or_tracks_stays_and_a_plain_one_does_not() {
    let dat = [("P", PLAIN), ("W", WOVEN), ("T", TRACKED), ("C", "Crater {CraterTime 0.0}")];
    let dat: String = dat.iter().map(|(name, parts)| weld_data(name, parts)).collect();
    let of = |first: &str, second: &str| reasons(&seam(first, second, "C"), &dat, &[]);
    let all = |why: Option<&str>| -> Vec<Option<String>> {
        let inner = std::iter::repeat_n(why.map(|w| format!("{w} leads the robot away from its points")), 5);
        std::iter::once(None).chain(inner).chain([None]).collect()
    };
    assert_eq!(of("P", "P"), all(None));
    assert_eq!(of("W", "W"), all(Some("weaving")));
    assert_eq!(of("T", "T"), all(Some("seam tracking")));
    // it goes on in another way from the point of the form on
    let on = |why: Vec<Option<String>>| why.iter().map(|w| w.is_some()).collect::<Vec<bool>>();
    assert_eq!(on(of("W", "P")), [false, true, true, true, false, false, false]);
    assert_eq!(on(of("P", "W")), [false, false, false, true, true, true, false]);
    // a plain seam after a woven one, and the other way round
    let two = |first: &str, second: &str| format!("{}{}", seam(first, first, "C"), seam(second, second, "C"));
    let inner = |is: bool| [false, is, is, is, is, is, false];
    assert_eq!(left_of(&two("W", "P"), &dat, &[]), [inner(true), inner(false)].concat());
    assert_eq!(left_of(&two("P", "W"), &dat, &[]), [inner(false), inner(true)].concat());
    // the end of a seam that another routine begins
    assert_eq!(left_of(&format!("{LIN}{}", form("Off", "C")), &dat, &[]), [false; 2]);
}

#[test]
fn a_seam_whose_weld_data_are_not_certain_stays_and_the_reason_names_them() {
    let why =
        |name: &str| format!("{name} is not certain in the files given: on this seam the robot may weave or track");
    let first = |src: &str, dat: &str, others: &[(&str, &str)]| reasons(src, dat, others).swap_remove(2);
    let src = seam("WDAT1", "WDAT1", "WDAT1");
    assert_eq!(first(&src, "", &[]), Some(why("WDAT1")));
    assert_eq!(first(&src, "DECL stArcDat_T WDAT1\n", &[]), Some(why("WDAT1")));
    assert_eq!(first(&src, &weld_data("WDAT1", PLAIN), &[]), None);
    let several = seam("WDAT1", "WDAT2", "WDAT2");
    let named: Vec<bool> = reasons(&several, "", &[]).iter().flatten().map(|w| *w == why("WDAT2")).collect();
    assert_eq!(named, [false, false, true, true, true]);
    // those of another module, and of all modules
    let list = |text: String| format!("DEFDAT q PUBLIC\n{text}ENDDAT\n");
    assert_eq!(first(&src, "", &[("q.dat", &list(weld_data("WDAT1", PLAIN)))]), Some(why("WDAT1")));
    let global = weld_data("WDAT1", PLAIN).replace("DECL", "DECL GLOBAL");
    assert_eq!(first(&src, "", &[("q.dat", &list(global))]), None);
    assert_eq!(first(&src, "", &[("$config.dat", &list(weld_data("WDAT1", PLAIN)))]), None);
    // what the program changes
    let plain = weld_data("WDAT1", PLAIN);
    assert_eq!(first(&format!("WDAT1.Weave.Pattern=#Spiral\n{src}"), &plain, &[]), Some(why("WDAT1")));
    assert_eq!(first(&format!("WDAT1.Weld.Velocity=0.006\n{src}"), &plain, &[]), None);
    assert_eq!(first(&format!("WDAT1=WDAT2\n{src}"), &plain, &[]), Some(why("WDAT1")));
    assert_eq!(first(&seam("WDAT[2]", "WDAT1", "WDAT1"), &plain, &[]), Some(why("WDAT[2]")));
}

#[test]
fn the_weld_data_of_plain_calls_count_where_they_are_named() {
    let dat = format!("{}{}", weld_data("WDAT1", PLAIN), weld_data("SEAM2", WOVEN));
    let of = |on: &str, off: &str| left_of(&format!("{LIN}{on}\n{LIN}{off}\n{LIN}"), &dat, &[]);
    for (on, off) in [("ARC_ON(SEAM2)", "ARC_OFF()"), ("ARCON WDAT3 LIN P1 Vel=1", "ARCOFF WDAT3 LIN P2")] {
        assert_eq!(of(on, off), [false, true, false], "{on}");
    }
    for (on, off) in [("ARC_ON(WDAT1)", "ARC_OFF()"), ("ARC_ON()", "ARC_OFF()"), ("ARC_STRT(1)", "ARCOF()")] {
        assert_eq!(of(on, off), [false; 3], "{on}");
    }
}
