//! G-code of lathes: X words are diameters or not.

use crate::support::{WorkFolder, bundled};

/// A gantry with a half gap of 0.05 mm on each axis, and a program.
fn folder(program: &str) -> WorkFolder {
    let work = WorkFolder::new();
    let robot = std::fs::read_to_string(bundled("configs/gantry-xyz-ballscrew.yaml")).unwrap();
    std::fs::write(work.join("robot.yaml"), robot).unwrap();
    let gaps: String =
        ["X", "Y", "Z"].map(|j| format!("  - {{effect: backlash, joint: {j}, half_gap_mm: 0.05}}\n")).concat();
    let model = format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{gaps}");
    std::fs::write(work.join("model.yaml"), model).unwrap();
    std::fs::write(work.join("p.nc"), program).unwrap();
    work
}

const LATHE: &str = "G21 G18 G90 G95 G40\nG97 S900 M3\nG0 X60. Z-5.\nG1 Z-10. F.2\nX80.\nG3 X72. Z-50. R27.\nG1 Z-65.\nZ-60.\nX100.\nM30\n";

fn rewritten(work: &WorkFolder, options: &str) -> (String, String) {
    let done = work.run(&format!("rewrite --model model.yaml p.nc --output out.nc {options}")).success();
    let out = std::fs::read_to_string(work.join("out.nc")).unwrap();
    work.run("undo out.nc --output back.nc").success();
    let back = std::fs::read(work.join("back.nc")).unwrap();
    assert_eq!(back, std::fs::read(work.join("p.nc")).unwrap());
    (out, done.stderr)
}

#[test]
fn x_of_a_lathe_stays_until_it_is_known_to_be_a_diameter_and_then_moves_by_half_of_its_word() {
    let work = folder(LATHE);
    let (out, told) = rewritten(&work, "");
    assert!(told.contains("assume diameter or radius"), "{told}");
    for line in ["G0 X60. Z-5.", "X80.", "G3 X72. Z-50. R27.", "X100."] {
        assert!(out.lines().any(|l| l == line), "{line}: {out}");
    }
    // a reversal of Z alone
    assert!(out.contains("Z-59.950"), "{out}");
    let (out, told) = rewritten(&work, "--assume diameter");
    assert!(!told.contains("diameter"), "{told}");
    // half of the gap, 0.05 mm of the axis, is 0.1 mm of X and 0.05 mm of Z; the arc turns at twice the distance of its centre and radius
    for line in ["X80.100", "G1 Z-65.050", "Z-59.950", "X100.100"] {
        assert!(out.lines().any(|l| l == line), "{line}: {out}");
    }
    assert!(out.contains("G3 X94.223 Z-28.256 R26.99"), "{out}");
    let robot = std::fs::read_to_string(work.join("robot.yaml")).unwrap() + "control: [diameter]\n";
    std::fs::write(work.join("robot.yaml"), robot).unwrap();
    assert_eq!(rewritten(&work, "").0, out);
}

#[test]
fn a_step_of_x_is_doubled_in_a_diameter() {
    let program = "G21 G18 G90 G95 G40\nG0 X40.0 Z-5.0\nG1 X50.0 F0.2\nX20.0\nX60.0\nM30\n";
    let work = folder(program);
    let of = |words: &str| rewritten(&work, &format!("--assume {words}")).0;
    let (diameter, radius) = (of("diameter"), of("radius"));
    assert!(diameter.contains("X19.900\n") && diameter.contains("X60.100\n"), "{diameter}");
    assert!(radius.contains("X19.950\n") && radius.contains("X60.050\n"), "{radius}");
}

/// A rotary axis by half a turn, more or less by what offsets add: the result is read again as it was meant, and no way becomes longer than
/// half a turn.
#[test]
fn ways_of_about_half_a_turn_stay_and_what_follows_them_is_written() {
    let axis = "  - {name: A, kind: revolute, theta_deg: 0, d_mm: 0, a_mm: 0, alpha_deg: 0, direction: 1, limits_deg: [-9999, 9999], max_speed_deg_s: 100, max_accel_deg_s2: 500}\n";
    for (to, next) in [(270.0, 0.0), (269.98, 0.0), (268.99, 0.0), (269.02, 180.0)] {
        let work = folder(&format!(
            "G21 G90 G94\nG0 X10. Y10. Z-10. A0.\nG1 X20. F500.\nG1 A90.\nG1 X10.\nG1 A{to:.3}\nG1 X20.\nG1 A{next:.3}\nG1 X15.\nM30\n"
        ));
        let robot = std::fs::read_to_string(work.join("robot.yaml")).unwrap();
        let (joints, rest) = robot.split_once("base:").unwrap();
        std::fs::write(work.join("robot.yaml"), format!("{joints}{axis}base:{rest}")).unwrap();
        let model = std::fs::read_to_string(work.join("model.yaml")).unwrap();
        std::fs::write(work.join("model.yaml"), model + "  - {effect: backlash, joint: A, half_gap_deg: 0.05}\n")
            .unwrap();
        let (out, told) = rewritten(&work, "");
        assert!(out.contains(&format!("G1 A{to:.3}\n")) || to < 269.0, "{out}{told}");
        assert!(out.contains("G1 A90.050"), "{out}");
    }
}
