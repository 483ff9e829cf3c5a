//! Frames that a motion or a spline block sets for itself, and those that BAS puts into force, where what they are computed from changes.

use super::in_force::{B, breaks, said};

const AXES: &str = "PTP {A1 0,A2 -90,A3 90,A4 10,A5 30,A6 0}\n";
const AT: &str = "SLIN {X 1.0,Y 2.0,Z 3.0,A 10.0,B 20.0,C 30.0}";
const FRAME_DATA: &str = "DECL FDAT FP1={TOOL_NO 1,BASE_NO 1,IPO_FRAME #BASE}\n";

fn bases(src: &str) -> Vec<String> {
    let all = said(&format!("{FRAME_DATA}$TOOL=$NULLFRAME\n{AXES}{src}"));
    all.iter().map(|s| s.split(';').next().unwrap_or_default().to_string()).collect()
}

#[test]
fn a_computed_base_of_one_motion_is_another_one_after_what_it_is_computed_from_has_changed() {
    for (first, base, second, name) in [
        ("N=1", "BASE_DATA[N]", "N=2", "BASE_DATA[N]"),
        ("BASE_DATA[1].X=100", "BASE_DATA[1]", "BASE_DATA[1].X=400", "1 as the program sets it"),
        ("BASE_DATA[1].X=100", "SBASE(FP1.BASE_NO)", "BASE_DATA[1].X=400", "1 as the program sets it"),
        ("F1.X=100", "F1", "F1.X=400", "F1"),
    ] {
        let names = [name.to_string(), format!("{name} (2)")];
        let with = format!("{AT} WITH $BASE={base} C_SPL\n");
        let src = format!("{first}\n{with}{second}\n{with}");
        assert_eq!(bases(&src), names, "{base}");
        // a new run begins where it changes
        assert_eq!(breaks(&format!("DEF a()\n{FRAME_DATA}{src}END\n")), [-3, 4, -5, 6], "{base}");
        let block = format!("SPLINE WITH $BASE={base}\n{AT}\nENDSPLINE\n");
        assert_eq!(bases(&format!("{first}\n{block}{second}\n{block}")), names, "{base}");
        // both names of one frame are one
        let both = format!("$BASE={base}\n").replace("SBASE(FP1.BASE_NO)", "BASE_DATA[1]");
        assert_eq!(bases(&format!("{first}\n{with}{both}{AT}\n")), [name, name], "{base}");
        assert_eq!(bases(&format!("{first}\n{with}{with}")), [name, name], "{base}");
    }
    let round = format!("FOR N=1 TO 2\n{AT} WITH $BASE=BASE_DATA[N]\nENDFOR\nN=3\n{AT} WITH $BASE=BASE_DATA[N]\n");
    assert_eq!(bases(&round)[1], "BASE_DATA[N] (2)");
    // what one motion sets holds for no other
    assert_eq!(bases(&format!("$BASE={B}\nN=1\n{AT} WITH $BASE=BASE_DATA[N]\n{AT}\n")), ["BASE_DATA[N]", "X 100"]);
}

#[test]
fn bas_puts_frame_data_into_force_as_the_lists_are_then() {
    let bas = "BAS(#CP_PARAMS,0.5)\n";
    let form = format!("FDAT_ACT=FP1\n{bas}{AT}\n");
    // the element is another one at each form
    let part = |x: u32| format!("BASE_DATA[1].X={x}\n");
    let set = "1 as the program sets it";
    assert_eq!(bases(&format!("{}{form}{}{form}", part(100), part(400))), [set, "1 as the program sets it (2)"]);
    assert_eq!(bases(&format!("{}{form}{form}", part(100))), [set; 2]);
    assert_eq!(bases(&format!("BASE_DATA[1]=F1\n{form}F1.X=9\nBASE_DATA[1]=F1\n{form}")), ["F1", "F1 (2)"]);
    // it changes between the frame data and BAS; before that it may be as it was left by an earlier run
    let later = bases(&format!("{form}{}{bas}{AT}\n", part(400)));
    assert_eq!(later, [format!("1 or {set}"), format!("{set} (2)")]);
    assert_eq!(bases(&format!("FDAT_ACT=FP1\nBASE_DATA[1]={B}\n{bas}{AT}\n")), ["X 100"]);
    // its number is taken where the frame data are set
    let number = |n: u32| format!("N={n}\nFDAT_ACT.BASE_NO=N\n");
    let src = format!("FDAT_ACT=FP1\n{}{bas}{AT}\n{}{bas}{AT}\n", number(3), number(4));
    assert_eq!(bases(&src), ["BASE_DATA[N]", "BASE_DATA[N] (2)"]);
    let src = format!("FDAT_ACT=FP1\n{}{bas}{AT}\nN=7\n{bas}{AT}\n", number(3));
    assert_eq!(bases(&src), ["BASE_DATA[N]"; 2]);
    // nothing changes
    assert_eq!(bases(&format!("{form}BAS(#BASE,2)\n{AT}\n{bas}{AT}\n")), ["1", "2", "1"]);
}
