//! G-code moves behind which the program waits: they are reached from one side, as exact stops are.

use crate::support::{WorkFolder, bundled};

#[test]
fn a_target_before_a_dwell_is_reached_from_its_side_over_a_point_with_the_same_dwell() {
    let work = WorkFolder::new();
    let robot = bundled("configs/gantry-xyz-ballscrew.yaml");
    let gaps: String =
        ["X", "Y", "Z"].map(|j| format!("  - {{effect: backlash, joint: {j}, half_gap_mm: 0.02}}\n")).concat();
    let model = format!("schema: lostmotion/model/1\nrobot: {}\neffects:\n{gaps}", robot.display());
    std::fs::write(work.join("model.yaml"), model).unwrap();
    let head = "G21 G90 G17 G64\nG0 X10.0 Y10.0 Z-10.0\n";
    let program = format!("{head}G0 X30.0 Y20.0\nG4 P0.5\nG1 Z-20.0 F300\nG4 P0.2\nG0 Z-10.0\nX5.0\nG4 P0.1\nM30\n");
    std::fs::write(work.join("p.nc"), &program).unwrap();
    // X is to go down to its targets and Z up: the first of these and the end of the plunge need a point, the last has none
    work.run("rewrite --model model.yaml p.nc --approach-from X=-,Z=+ --output out.nc").success();
    let out = std::fs::read_to_string(work.join("out.nc")).unwrap();
    let lines: Vec<&str> = out.lines().collect();
    assert_eq!(lines.iter().filter(|l| **l == "G4 P0.5").count(), 2, "{out}");
    assert_eq!(lines.iter().filter(|l| **l == "G4 P0.2").count(), 2, "{out}");
    assert_eq!(lines.iter().filter(|l| **l == "G4 P0.1").count(), 1, "{out}");
    // the point stands before its dwell, and at the bottom Z alone moves
    let bottom = lines.iter().position(|l| *l == "G4 P0.2").unwrap();
    for line in [lines[bottom - 1], lines[bottom + 1]] {
        assert!(line.contains("Z-20.") || line.contains("Z-19."), "{out}");
        assert!(!line.contains('X') && !line.contains('Y'), "{out}");
    }
    // without the option nothing waits twice
    work.run("rewrite --model model.yaml p.nc --output plain.nc").success();
    let plain = std::fs::read_to_string(work.join("plain.nc")).unwrap();
    assert_eq!(plain.matches("G4 ").count(), 3, "{plain}");
}
