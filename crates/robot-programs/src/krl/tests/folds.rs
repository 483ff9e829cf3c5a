//! Inline forms in folds and points of the data list: changed, cloned, left.

use super::*;

#[test]
fn a_new_point_stands_before_the_fold_with_the_settings_of_the_form() {
    let d = doc(&FOLDS);
    assert_eq!(goals(d.as_ref()), "ojjjpjjo");
    let m = moves(d.as_ref());
    assert_eq!((m[1].1.speed, m[3].1.speed), (Speed::Share(1.0), Speed::Share(0.5)));
    let after = text(rewrite(d.as_ref(), &edits(d.as_ref(), &[], &[m[3].0])).as_ref(), 0);
    let expected = ";ENDFOLD\r\n$BWDSTART=FALSE\r\nPDAT_ACT=PPDAT2\r\nFDAT_ACT=FP1\r\nBAS(#PTP_PARAMS,50)\r\nSET_CD_PARAMS (0)\r\n\
                    PTP {A1 0.250000,A2 -89.50000,A3 90.00000,A4 0.000000,A5 1.000000,A6 179.9999}\r\n;FOLD PTP P1 Vel=50";
    assert!(after.contains(expected), "{after}");
}

#[test]
fn a_point_of_several_forms_is_cloned_with_its_frame_data_and_the_text_of_the_fold() {
    let d = doc(&FOLDS);
    let m = moves(d.as_ref());
    let after = rewrite(d.as_ref(), &edits(d.as_ref(), &[(m[3].0, 0.05)], &[]));
    let (src, dat) = (text(after.as_ref(), 0), text(after.as_ref(), 1));
    assert!(src.contains(";FOLD PTP P1_2 Vel=50 % PDAT2 Tool[1]:gripper Base[0];%{PE}%R 8.3.38"), "{src}");
    assert!(src.contains("2:P1_2, 3:, 5:50, 7:PDAT2\r\n"), "{src}");
    assert!(
        src.contains("PDAT_ACT=PPDAT2\r\nFDAT_ACT=FP1_2\r\nBAS(#PTP_PARAMS,50)\r\nSET_CD_PARAMS (0)\r\nPTP XP1_2\r\n")
    );
    assert_eq!((src.matches("FP1_2").count(), src.matches("PTP XP1 C_PTP").count()), (1, 2));
    assert!(dat.contains("\r\nDECL E6AXIS XP1_2={A1 -50.65000,A2 -111.5100,"), "{dat}");
    assert!(
        dat.contains(
            "\r\nDECL FDAT FP1_2={TOOL_NO 1,BASE_NO 0,IPO_FRAME #BASE,POINT2[] \" \",TQ_STATE FALSE}\r\nDECL FDAT FP1={"
        ),
        "{dat}"
    );
    assert!(dat.contains("DECL E6AXIS XP1={A1 -50.7000008,"), "the old point stays");
}

#[test]
fn a_point_that_all_its_moves_want_alike_is_changed_in_place() {
    let d = doc(&FOLDS);
    let m = moves(d.as_ref());
    let all: Vec<_> = [1, 3, 5].iter().map(|i| (m[*i].0, 0.05)).collect();
    let after = rewrite(d.as_ref(), &edits(d.as_ref(), &all, &[]));
    assert_eq!(text(after.as_ref(), 0), text(d.as_ref(), 0));
    assert!(
        text(after.as_ref(), 1).contains("XP1={A1 -50.65000,A2 -111.5100,A3 120.0400,"),
        "{}",
        text(after.as_ref(), 1)
    );
}

#[test]
fn without_frame_data_in_the_list_a_form_is_not_cloned() {
    let dat = String::from_utf8_lossy(FOLDS[1]).replace("DECL FDAT FP1=", ";DECL FDAT FP1=");
    let d = doc(&[FOLDS[0], dat.as_bytes()]);
    let m = moves(d.as_ref());
    let error = d.patches(&edits(d.as_ref(), &[(m[3].0, 0.05)], &[])).unwrap_err().to_string();
    assert!(error.contains("FP1") && error.contains("p.src:"), "{error}");
}

#[test]
fn several_points_of_one_declaration_are_cloned_one_by_one() {
    let d = doc(&LOGIC);
    let m = moves(d.as_ref());
    let after = rewrite(d.as_ref(), &edits(d.as_ref(), &[(m[0].0, 0.1), (m[1].0, 0.1), (m[8].0, 0.1)], &[]));
    let (src, dat) = (text(after.as_ref(), 0), text(after.as_ref(), 1));
    assert!(src.contains("PTP XA_2\nPTP XB_2 C_PTP\nLOOP\n  PTP XA C_PTP"), "{src}");
    assert!(dat.contains("DECL E6AXIS XA_2={A1 0.1000,A2 -89.9000,A3 90.1000,"), "{dat}");
    assert!(dat.contains("DECL E6AXIS XB_2={A1 30.1000,A2 -70.4000,"), "{dat}");
    // a point of the routine itself, used once: in its assignment
    assert!(src.contains("XLOC={A1 5.1000,A2 -79.9000,"), "{src}");
}

#[test]
fn a_point_of_the_routine_that_must_part_is_written_in_line() {
    let src = "DEF a()\nDECL E6AXIS XL\nXL={A1 1.0,A2 -90.0}\nPTP XL\nPTP {A1 5}\nPTP XL C_PTP\nEND\n";
    let d = doc(&[src.as_bytes()]);
    let m = moves(d.as_ref());
    let after = text(rewrite(d.as_ref(), &edits(d.as_ref(), &[(m[2].0, 0.5)], &[])).as_ref(), 0);
    assert!(after.contains("PTP XL\nPTP {A1 5}\nPTP {A1 1.5000,A2 -89.5000} C_PTP\n"), "{after}");
}

#[test]
fn a_form_with_with_is_copied_whole_and_a_moving_external_axis_allows_no_point() {
    let d = doc(&SPLINE);
    assert_eq!(goals(d.as_ref()), "jjjjj");
    let m = moves(d.as_ref());
    let closed: Vec<bool> = m.iter().map(|m| m.1.closed.is_some()).collect();
    assert_eq!(closed, [true, false, false, true, false]);
    let after = rewrite(d.as_ref(), &edits(d.as_ref(), &[(m[2].0, 0.05)], &[m[1].0]));
    let src = text(after.as_ref(), 0);
    assert!(src.contains("SPTP {A1 0.2500,A2 -89.5000,A3 90.0000,A4 0.0000,A5 1.0000,A6 179.9999} WITH $VEL_AXIS[1] = SVEL_JOINT(100.0), $TOOL = STOOL2(FP2)"), "{src}");
    assert!(src.contains(";FOLD SPTP P1_2 Vel=100") && src.contains("Kuka.PointName=P1_2;"), "{src}");
    assert!(src.contains("SPTP XP1_2 WITH") && src.contains("SBASE(FP1_2.BASE_NO)"), "{src}");
    assert!(
        text(after.as_ref(), 1).contains("DECL E6AXIS XP1_2={A1 0.0500")
            && text(after.as_ref(), 1).contains("FDAT FP1_2=")
    );
}

#[test]
fn a_program_without_its_data_list_keeps_what_it_says_itself() {
    let d = doc(&[LONELY]);
    assert_eq!(goals(d.as_ref()), "ojjo");
    let m = moves(d.as_ref());
    assert!(matches!(&m[0].1.goal, Goal::Opaque(w) if w.to_string().contains("XP1 is not declared")));
}

#[test]
fn names_stay_within_twenty_four_characters_and_are_free() {
    let long = "XABCDEFGHIJKLMNOPQRSTUVW";
    let src = format!("DEF a()\nPTP {long}\nPTP {{A1 1}}\nPTP {long}\nEND\n");
    let dat = format!("DEFDAT a\nDECL E6AXIS {long}={{A1 5.0}}\nDECL INT XABCDEFGHIJKLMNOPQRSTU_2\nENDDAT");
    let d = doc(&[src.as_bytes(), dat.as_bytes()]);
    let m = moves(d.as_ref());
    let after = text(rewrite(d.as_ref(), &edits(d.as_ref(), &[(m[0].0, 0.5)], &[])).as_ref(), 1);
    assert!(after.contains("DECL E6AXIS XABCDEFGHIJKLMNOPQRSTU_3={A1 5.5000}\n"), "{after}");
}
