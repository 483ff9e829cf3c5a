//! Drawings against geometry that is known.

use super::*;

#[test]
fn a_constant_error_is_a_circle_and_a_known_value_stands_at_its_tick() {
    let angle: Vec<f64> = (0..=72).map(|k| 5.0 * f64::from(k)).collect();
    let html = one(PolarView {
        runs: vec![PolarRun {
            run: run(Role::After),
            angle_deg: angle.clone(),
            total_um: vec![100.0; 73],
            in_plane_um: vec![-30.0; 73],
            out_of_plane_um: vec![0.0; 73],
        }],
        marks: vec![],
    });
    with_elements(&html, |all| {
        let lines: Vec<_> = named(all, "path").into_iter().filter(|n| class_of(n).starts_with("line")).collect();
        assert_eq!(lines.len(), 3);
        for l in &lines {
            let p = points(l.attribute("d").expect("data"));
            let middle = [0.5 * (p[0][0] + p[36][0]), 0.5 * (p[18][1] + p[54][1])];
            let radius = p[0][0] - middle[0];
            assert!(p.iter().all(|q| ((q[0] - middle[0]).hypot(q[1] - middle[1]) - radius).abs() < 0.15), "{p:?}");
            assert!(p[18][1] < middle[1], "90 degrees are up: anticlockwise");
        }
        // zero out of plane lies on the ring of zero
        let zero = named(all, "circle").into_iter().rfind(|c| class_of(c).contains("zero")).expect("a ring of zero");
        let p = points(lines[2].attribute("d").expect("data"));
        let r: f64 = zero.attribute("r").and_then(|r| r.parse().ok()).expect("a radius");
        let cx: f64 = zero.attribute("cx").and_then(|r| r.parse().ok()).expect("a centre");
        assert!((p[0][0] - cx - r).abs() < 0.15);
    });
    let html = one(TracesView {
        x_name: "time".into(),
        x_unit: "s".into(),
        y_name: String::new(),
        y_whole: false,
        joints: vec![JointTraces {
            joint: "Z".into(),
            panels: vec![TracePanel {
                runs: vec![TraceRun { model_x: vec![0.0, 10.0], model_milli: vec![4.0, -4.0], ..TraceRun::default() }],
                ..TracePanel::default()
            }],
        }],
    });
    assert!(html.contains("error, µm"), "a prismatic joint's error is in micrometres");
    with_elements(&html, |all| {
        let tick =
            named(all, "text").into_iter().find(|t| class_of(t) == "tick" && text_of(t) == "4").expect("a tick at 4");
        let y: f64 = tick.attribute("y").and_then(|y| y.parse().ok()).expect("its place");
        let line = named(all, "path").into_iter().find(|n| class_of(n).starts_with("model")).expect("the line");
        let p = points(line.attribute("d").expect("data"));
        assert!((p[0][1] - (y - 4.0)).abs() < 0.11, "{p:?} {y}");
    });
}

#[test]
fn the_view_in_space_is_isometric_and_errors_are_exaggerated_along_their_direction() {
    let html = one(PathView {
        is_arm: false,
        exaggeration: 400.0,
        nominal_mm: vec![[0.0, -100.0, 0.0], [0.0, 100.0, 0.0]],
        runs: vec![PathRun {
            run: run(Role::After),
            reference_mm: vec![[0.0; 3], [0.0; 3]],
            error_um: vec![[0.0; 3], [0.0, 0.0, 100.0]],
        }],
        marks: vec![],
    });
    with_elements(&html, |all| {
        let get = |n: &Node, a: &str| n.attribute(a).and_then(|v| v.parse::<f64>().ok()).expect("a number");
        let axes: Vec<[f64; 2]> = named(all, "line")
            .iter()
            .filter(|l| l.parent().is_some_and(|p| class_of(&p) == "triad"))
            .map(|l| [get(l, "x2") - get(l, "x1"), get(l, "y2") - get(l, "y1")])
            .collect();
        let lengths: Vec<f64> = axes.iter().map(|a| a[0].hypot(a[1])).collect();
        assert!(lengths.iter().all(|l| (l - lengths[0]).abs() < 0.15), "equally foreshortened: {lengths:?}");
        assert!(axes[2][0].abs() < 0.1 && axes[2][1] < 0.0, "z is up");
        let cosine = (axes[0][0] * axes[1][0] + axes[0][1] * axes[1][1]) / (lengths[0] * lengths[1]);
        assert!((cosine + 0.5).abs() < 0.01, "120 degrees apart");
        let d = |class: &str| {
            points(
                named(all, "path").iter().find(|p| class_of(p) == class).and_then(|p| p.attribute("d")).expect("data"),
            )
        };
        let (nominal, line) = (d("nominal"), d("line after"));
        // 100 um times 400 is 40 mm along z; the nominal path is 200 mm along y, equally foreshortened
        let (error, length) =
            (line[0][1] - line[1][1], (nominal[1][0] - nominal[0][0]).hypot(nominal[1][1] - nominal[0][1]));
        assert!((error / length - 0.2).abs() < 0.002, "{error} {length}");
    });
}
