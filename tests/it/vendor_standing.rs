//! Joint moves to the place at which the robot stands.

use crate::vendor_rewrite::Desk;

/// From which side the robot comes to the first target is not known, and the second moves nothing: both stay.
#[test]
fn a_joint_move_that_moves_nothing_after_a_target_of_unknown_side_stays() {
    let desk = Desk::new(0.003);
    let [there, on] = [
        "PTP {A1 20.0000,A2 -80.0000,A3 95.0000,A4 0.0,A5 10.0,A6 0.0}\n",
        "PTP {A1 25.0000,A2 -85.0000,A3 90.0000,A4 0.0,A5 10.0,A6 0.0}\n",
    ];
    desk.write("part.src", &format!("DEF part( )\nGRIP( )\n{there}{there}{on}END\n"));
    desk.run("rewrite --model model.yaml part.src --output out.src").success();
    let out = String::from_utf8(desk.read("out.src")).unwrap();
    assert_eq!(out.matches(there).count(), 2, "{out}");
    assert!(!out.contains(on) && out.contains("A1 25.0030"), "{out}");
}
