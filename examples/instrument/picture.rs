//! The four paths as wanted and as run, in the manner of Figure 8: a small SVG by hand, as its panels are squares in mm.

use crate::instrument::{Run, Shape};
use std::fmt::Write;

const SIDE: f64 = 240.0;
/// Half of what a panel shows, mm.
const REACH_MM: f64 = 14.5;

pub fn draw(paths: &[Shape], augmented: &[Run], without: &[Run], nominal: &[Run]) -> String {
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" role=\"img\"><title>Four paths on the simulated instrument</title>\
         <style>rect{{fill:#fff}}text{{font:12px system-ui,sans-serif;fill:#57616c;paint-order:stroke;stroke:#fff;stroke-width:4}}path{{fill:none;stroke-width:1.6}}.wanted{{stroke:#8a949e;stroke-width:4}}\
         .nominal{{stroke:#d55e00;stroke-dasharray:6 3}}.without{{stroke:#0072b2;stroke-dasharray:2 3}}.with{{stroke:#009e73}}.grid{{stroke:#dde2e7;stroke-width:1}}</style>\
         <rect width=\"{}\" height=\"{}\"/>",
        2.0 * SIDE,
        2.0 * SIDE + 44.0,
        2.0 * SIDE,
        2.0 * SIDE + 44.0
    );
    for (k, shape) in paths.iter().enumerate() {
        let (left, top) = (SIDE * (k % 2) as f64, SIDE * (k / 2) as f64);
        let at = |p: [f64; 2]| {
            let px = |v: f64| SIDE / 2.0 * (1.0 + v / REACH_MM);
            format!("{:.1} {:.1}", left + px(p[0]), top + px(-p[1]))
        };
        for g in [-10.0, 0.0, 10.0] {
            let (a, b, c, d) = (at([g, -12.0]), at([g, 12.0]), at([-12.0, g]), at([12.0, g]));
            let _ = write!(svg, "<path class=\"grid\" d=\"M{a}L{b}M{c}L{d}\"/>");
        }
        let from = shape.closed_from;
        let wanted: Vec<[f64; 2]> = shape.path.points_m[from..].iter().map(|p| [p[0] * 1e3, p[1] * 1e3]).collect();
        let runs = [("nominal", &nominal[k]), ("without", &without[k]), ("with", &augmented[k])];
        let lines = std::iter::once(("wanted", &wanted[..])).chain(runs.map(|(c, r)| (c, &r.trace_mm[from..])));
        for (class, points) in lines {
            let d: Vec<String> = points.iter().map(|p| at(*p)).collect();
            let end = if class == "wanted" { "Z" } else { "" };
            let _ = write!(svg, "<path class=\"{class}\" d=\"M{}{end}\"/>", d.join("L"));
        }
        let _ = write!(
            svg,
            "<text x=\"{}\" y=\"{}\">{}, grid 10 mm</text>",
            left + 12.0,
            top + 14.0,
            shape.name.replace('_', " ")
        );
    }
    let words = [
        ("wanted", "wanted"),
        ("nominal", "nominal, compensated"),
        ("without", "augmented, not compensated"),
        ("with", "augmented, compensated"),
    ];
    for (k, (class, name)) in words.iter().enumerate() {
        let (x, y) = (14.0 + 230.0 * (k % 2) as f64, 2.0 * SIDE + 14.0 + 18.0 * (k / 2) as f64);
        let _ = write!(
            svg,
            "<path class=\"{class}\" d=\"M{x} {y}h30\"/><text x=\"{}\" y=\"{}\">{name}</text>",
            x + 38.0,
            y + 4.0
        );
    }
    svg + "</svg>\n"
}
