//! Joint-space programs whose rows are a control cycle apart, at which a step may end.

use crate::support::bundled;
use crate::vendor_rewrite::Desk;

/// Times of the rows of a program, s.
fn times(text: &str) -> Vec<f64> {
    text.lines().skip(1).map(|row| row.split(',').next().unwrap().parse().unwrap()).collect()
}

#[test]
fn a_step_that_takes_a_whole_cycle_ends_at_the_next_row() {
    let desk = Desk::new(0.0);
    std::fs::copy(bundled("configs/motoman-gp25.yaml"), desk.path("robot.yaml")).unwrap();
    let model = "schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n  - {effect: backlash, joint: S, half_gap_deg: 0.05}\n";
    desk.write("model.yaml", model);
    for cycle_ms in [1, 2, 4, 5, 8] {
        let turn = |k: i32| f64::from(if k % 20 < 10 { k % 20 } else { 20 - k % 20 });
        let row = |k: i32| {
            format!(
                "{:.3},{:.4},0,0,0,10,0\n",
                f64::from(6 * cycle_ms + k * cycle_ms) / 1e3,
                0.025 * f64::from(cycle_ms) * turn(k)
            )
        };
        let rows: String = (0..120).map(row).collect();
        desk.write("p.csv", &format!("t_s,S_deg,L_deg,U_deg,R_deg,B_deg,T_deg\n{rows}"));
        desk.run("rewrite --model model.yaml p.csv --output out.csv --force").success();
        let out = String::from_utf8(desk.read("out.csv")).unwrap();
        let apart = times(&out).windows(2).map(|t| t[1] - t[0]).fold(f64::INFINITY, f64::min);
        assert!(apart > 1.5e-6, "{cycle_ms} ms: {apart} s\n{out}");
    }
}
