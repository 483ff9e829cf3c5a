//! FANUC position registers whose values a listing of the controller tells.

use crate::vendor_calls::{desk, fanuc_positions, j1};
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;

const LISTING: &str = "[*POSREG*]$POSREG  Storage: SHADOW  Access: RW  : ARRAY[1,100] OF Position Reg\r\n    [1,1] =   '@Home'   Group: 1\r\n\
    \x20 J1 =     5.000 deg   J2 =    10.000 deg   J3 =    10.000 deg \r\n  J4 =    10.000 deg   J5 =    10.000 deg   J6 =    10.000 deg \r\n\
    \x20   [1,2] =   '' Uninitialized\r\n";

/// Motions of J1 to 0 and 10 deg, to register 1 (5 deg) and to 8 deg.
fn program(more: &str) -> String {
    let mut text = String::from(
        "/PROG  P\n/ATTR\nLINE_COUNT\t= 5;\n/MN\n   1:J P[1] 10% FINE    ;\n   2:J P[2] 10% FINE    ;\n   3:J PR[1:@Home] 10% FINE    ;\n\
         \x20  4:J P[3] 10% FINE    ;\n",
    );
    text += &format!("   5:{more}    ;\n");
    text + &fanuc_positions(&[0.0, 10.0, 8.0])
}

const REWRITE: &str = "rewrite --model model.yaml cell/P.LS --max-added 0";

#[test]
fn directions_go_on_through_a_register_of_a_listing_unless_a_program_of_the_folder_sets_it() {
    let desk = desk("fanuc-m10ia.yaml", "J1");
    desk.write("cell/P.LS", &program("  R[1]=1"));
    desk.write("POSREG.VA", LISTING);
    // without the listing the motion after the register stays; a register is a whole place, so that the one before it does not
    desk.run(&format!("{REWRITE} --output left.ls")).success();
    assert_eq!(j1(&desk, "left.ls"), [0.01, 10.01, 8.0]);
    let known = desk.run(&format!("{REWRITE} --output known.ls --frames POSREG.VA")).success();
    known.stderr(
        contains("the values of PR[1] are those of the listing: they must hold these values whenever the program runs")
            .and(contains("the value of PR[1] is not in the program, but known by the listing")),
    );
    // 0 to 10 up, 10 to 5 down, 5 to 8 up
    assert_eq!(j1(&desk, "known.ls"), [0.01, 10.01, 8.01]);
    desk.run("undo known.ls --output back.ls").success();
    assert_eq!(desk.read("back.ls"), desk.read("cell/P.LS"));
    // another program of the folder
    desk.write("cell/OTHER.LS", "/PROG  OTHER\n/ATTR\n/MN\n   1:  PR[1]=LPOS    ;\n/POS\n/END\n");
    let set = desk.run(&format!("{REWRITE} --output set.ls --frames POSREG.VA")).success();
    set.stderr(contains("OTHER.LS may set PR[1]").and(contains("must hold these values").not()));
    assert_eq!(j1(&desk, "set.ls"), [0.01, 10.01, 8.0]);
    // the value is one of the listing at its place
    desk.write("bad.VA", &LISTING.replace("5.000 deg", "5.0x0 deg"));
    desk.run(&format!("{REWRITE} --dry-run --frames bad.VA")).code(2).stderr(contains("bad.VA:3:"));
    desk.run(&format!("{REWRITE} --dry-run --frames POSREG.VA --frames POSREG.VA")).code(2);
}
