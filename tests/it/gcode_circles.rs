//! Arcs of G-code: full circles in the verdict, and arcs that turn shortly before their end and take no point.

use crate::support::{WorkFolder, bundled};

/// Half gap of X and Y, mm.
const HALF_GAP_MM: f64 = 0.1;

/// A gantry with gaps in X and Y, and a program.
fn folder(program: &str) -> WorkFolder {
    let work = WorkFolder::new();
    std::fs::copy(bundled("configs/gantry-xyz-ballscrew.yaml"), work.join("robot.yaml")).unwrap();
    let gaps =
        ["X", "Y"].map(|j| format!("  - {{effect: backlash, joint: {j}, half_gap_mm: {HALF_GAP_MM}}}\n")).concat();
    let model = format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n{gaps}");
    std::fs::write(work.join("model.yaml"), model).unwrap();
    std::fs::write(work.join("p.nc"), program).unwrap();
    work
}

#[test]
fn a_full_circle_is_part_of_the_path_that_is_judged() {
    for circle in ["G2 I15. J0.", "G3 X30. Y20. I15. J0."] {
        let program =
            format!("G21 G90 G17 G94 G40 G91.1\nG0 X0. Y0. Z0.\nG1 X30. Y20. F600.\n{circle}\nG1 X60. Y50.\nM30\n");
        let work = folder(&program);
        let done: serde_json::Value =
            work.run("rewrite --model model.yaml p.nc --output out.nc --json").success().json();
        let rms = |side: &str| done["path_error"]["rms_um"][side].as_f64().unwrap();
        assert!(rms("after") < 0.5 * rms("before"), "{circle}: {:#}", done["path_error"]);
        let sim = work.run("simulate --model model.yaml --input p.nc --rate-hz 20 --output sim.csv").success();
        let table = std::fs::read_to_string(work.join("sim.csv")).unwrap();
        let mut lines = table.lines().filter(|l| !l.starts_with('#'));
        let x = lines.next().unwrap().split(',').position(|c| c == "cmd_X_mm").unwrap();
        let values = lines.map(|l| l.split(',').nth(x).unwrap().parse::<f64>().unwrap());
        // the circle goes out to its other side
        let farthest = values.take_while(|v| *v < 59.0).fold(0.0, f64::max);
        assert!(farthest > 58.0, "{circle}: {farthest} {}", sim.stderr);
    }
}

/// Where X stands after it was led to each of `places`, from below: the play operator.
fn stands(places: impl IntoIterator<Item = f64>) -> f64 {
    places.into_iter().fold(f64::NEG_INFINITY, |x, c| x.clamp(c - HALF_GAP_MM, c + HALF_GAP_MM))
}

/// X along the clockwise arc of less than half a turn from `from` to `to`.
fn arc(from: [f64; 2], to: [f64; 2], radius: f64) -> impl Iterator<Item = f64> {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let chord = dx.hypot(dy);
    let height = (radius * radius - chord * chord / 4.0).max(0.0).sqrt();
    let centre = [from[0] + dx / 2.0 + height * dy / chord, from[1] + dy / 2.0 - height * dx / chord];
    let angle = move |p: [f64; 2]| (p[1] - centre[1]).atan2(p[0] - centre[0]);
    let sweep = (angle(from) - angle(to)).rem_euclid(std::f64::consts::TAU);
    (0..=4000).map(move |k| centre[0] + radius * (angle(from) - sweep * f64::from(k) / 4000.0).cos())
}

/// A word of a line.
fn word(line: &str, letter: char) -> f64 {
    line.split_whitespace().find_map(|w| w.strip_prefix(letter)).unwrap().parse().unwrap()
}

#[test]
fn an_arc_that_turns_shortly_before_its_end_and_takes_no_point_ends_with_the_offset_that_leaves_less() {
    // X goes from 10 to 7.056 and back to 7.072: by less than the gap
    let program = |process: &str| {
        format!(
            "G21 G90 G17 G94 G40\nG0 X0. Y0. Z0.\nG1 X10. Y0. F300.\n{process}G2 X7.072 Y5.156 R5.2925\nG1 X20. Y20.\nM30\n"
        )
    };
    for (process, options) in [("", "--max-added 0"), ("M3\n", "--leave-process")] {
        let work = folder(&program(process));
        work.run(&format!("rewrite --model model.yaml p.nc --output out.nc {options}")).success();
        let out = std::fs::read_to_string(work.join("out.nc")).unwrap();
        let line = |start: &str| out.lines().find(|l| l.starts_with(start)).unwrap();
        let (start, end) = (line("G1 X1"), line("G2 "));
        let (from, to) = ([word(start, 'X'), word(start, 'Y')], [word(end, 'X'), word(end, 'Y')]);
        let places = [0.0].into_iter().chain(arc(from, to, word(end, 'R')));
        let error = (stands(places) - 7.072).abs();
        let before = (stands([0.0].into_iter().chain(arc([10.0, 0.0], [7.072, 5.156], 5.2925))) - 7.072).abs();
        assert!(error < 0.3 * before, "{options}: {error} after {before} mm\n{out}");
    }
}

#[test]
fn an_arc_on_which_an_axis_goes_back_by_less_than_its_gap_ends_where_it_shall() {
    // X goes from 10 to 7.056 and back by 0.05 to 0.15; its gap is 0.2
    for to in [[7.106, 5.469], [7.146, 5.715], [7.176, 5.864], [7.206, 5.994]] {
        let program = format!(
            "G21 G90 G17 G94 G40\nG0 X0. Y0. Z0.\nG1 X10. Y0. F300.\nG2 X{} Y{} R5.2925\nG1 X20. Y20.\nM30\n",
            to[0], to[1]
        );
        let work = folder(&program);
        work.run("rewrite --model model.yaml p.nc --output out.nc --max-added 0").success();
        let out = std::fs::read_to_string(work.join("out.nc")).unwrap();
        let line = |start: &str| out.lines().find(|l| l.starts_with(start)).unwrap();
        let (start, end) = (line("G1 X1"), line("G2 "));
        let (from, at) = ([word(start, 'X'), word(start, 'Y')], [word(end, 'X'), word(end, 'Y')]);
        let error = (stands([0.0].into_iter().chain(arc(from, at, word(end, 'R')))) - to[0]).abs();
        assert!(error < 0.12 * HALF_GAP_MM, "{to:?}: {error} mm\n{out}");
    }
}
