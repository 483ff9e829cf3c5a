//! G-code as CAM systems write it: work frames, tool lengths, places of the machine.

use crate::support::{WorkFolder, bundled};

/// A gantry with a half gap of 0.004 mm on each axis, and a program.
fn folder(program: &str) -> WorkFolder {
    let work = WorkFolder::new();
    let robot = bundled("configs/gantry-xyz-ballscrew.yaml");
    let gaps: String =
        ["X", "Y", "Z"].map(|j| format!("  - {{effect: backlash, joint: {j}, half_gap_mm: 0.004}}\n")).concat();
    let model = format!("schema: lostmotion/model/1\nrobot: {}\neffects:\n{gaps}", robot.display());
    std::fs::write(work.join("model.yaml"), model).unwrap();
    std::fs::write(work.join("p.nc"), program).unwrap();
    work
}

const TOOL: &str = "G0 G54 X10.0 Y0.0\nG43 Z5.0 H1\nG1 Z-1.0 F300\nX30.0\nX20.0\nG0 Z5.0\n";

#[test]
fn both_tools_of_a_cam_program_are_edited_and_limits_in_a_work_frame_are_a_note() {
    let program = format!("G21 G90 G17 G40 G49\nT1 M6\n{TOOL}T2 M6\n{}M30\n", TOOL.replace("H1", "H2"));
    let work = folder(&program);
    let done = work.run("rewrite --model model.yaml p.nc --output out.nc").success();
    assert!(done.stderr.contains("limits of X, Y, Z are not checked"), "{}", done.stderr);
    let out = std::fs::read_to_string(work.join("out.nc")).unwrap();
    let (first, second) = out.split_once("T2 M6\n").unwrap();
    for part in [first, second] {
        assert!(part.contains("X30.004") && part.contains("X19.996"), "{out}");
        // from which side an axis comes there is not known
        assert!(part.contains("G0 G54 X10.0 Y0.0\n") && part.contains("G43 Z5.0 H"), "{out}");
    }
    // without a work frame and a tool length the numbers are those of the axes: Z5 is beyond its limit of 0
    let bare = program.replace("G54 ", "").replace("G43 ", "").replace(" H1", "").replace(" H2", "");
    let refused = folder(&bare).run("rewrite --model model.yaml p.nc --output out.nc").ends_with(1);
    assert!(refused.stderr.contains('Z') && refused.stderr.contains("limit"), "{}", refused.stderr);
}

#[test]
fn the_axes_that_g53_does_not_name_go_on_also_on_arcs() {
    let program = "G21 G90 G17 G40\nG0 X10.0 Y100.0 Z-10.0\nG1 X30.0 F300\nG53 G0 Z0\nX20.0\nX40.0\nG3 X60.0 Y100.0 I10.0 J0.0\nG1 X20.0\nM30\n";
    let work = folder(program);
    work.run("rewrite --model model.yaml p.nc --output out.nc").success();
    let out = std::fs::read_to_string(work.join("out.nc")).unwrap();
    let after = out.split_once("G53 G0 Z0\n").unwrap().1;
    assert!(after.contains("X19.996") && after.contains("X40.004"), "{out}");
    assert!(!after.contains('Z'), "{out}");
}

#[test]
fn an_offset_that_depends_on_the_position_needs_to_know_it() {
    let work = folder(
        "G21 G90 G17 G40 G49 G54\nG0 X10.0 Y0.0 Z-5.0\nG1 X30.0 F300\nG55\nG0 X10.0 Y0.0 Z-5.0\nG1 X30.0\nX20.0\nM30\n",
    );
    let model = std::fs::read_to_string(work.join("model.yaml")).unwrap();
    let constant = "effect: backlash, joint: X, half_gap_mm: 0.004";
    let curve = "effect: backlash_position, joint: X, knots: [[0, 0.004], [1000, 0.008]]";
    std::fs::write(work.join("model.yaml"), model.replace(constant, curve)).unwrap();
    let done = work.run("rewrite --model model.yaml p.nc --output out.nc").success();
    assert!(done.stderr.contains("an offset depends on the position"), "{}", done.stderr);
    let out = std::fs::read_to_string(work.join("out.nc")).unwrap();
    assert!(out.ends_with("G55\nG0 X10.0 Y0.0 Z-5.0\nG1 X30.0\nX20.0\nM30\n"), "{out}");
}
