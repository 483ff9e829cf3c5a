//! The equations as printed, against the twin's own version of the published controller.

use crate::support::root;
use lostmotion::compensator::{BacklashOffset, Compensator, Evidence, FrictionOffset, FrictionShape, JointCompensator};
use lostmotion::effects::GapCurve;
use lostmotion::rewrite::{Points, printed};

fn program(name: &str) -> Points {
    let path = root().join(name);
    let mut reader = csv::Reader::from_path(path).expect("the file is there");
    let mut points = Points { axes: 6, ..Points::default() };
    for record in reader.records() {
        points.q.extend(record.expect("a row").iter().map(|f| f.parse::<f64>().expect("a number").to_radians()));
    }
    points
}

#[test]
fn table_3_of_the_paper_gives_the_program_of_the_twin() {
    let joint = |axis: usize, d: f64, g: f64| {
        let gap = GapCurve::Constant(d.to_radians());
        JointCompensator {
            axis,
            backlash: Some(BacklashOffset { positive: gap.clone(), negative: gap }),
            friction: (g > 0.0).then(|| FrictionOffset {
                gain: g.to_radians(),
                shape: FrictionShape::Poses { exponent: 3.0, poses: 5 },
            }),
        }
    };
    let compensator = Compensator {
        robot_name: String::new(),
        robot_sha256: String::new(),
        joints: vec![joint(0, 0.0028, 0.0034), joint(1, 0.0037, 0.0), joint(2, 0.0022, 0.0017)],
        evidence: Evidence::default(),
    };
    let out = printed::rewrite(&program("samples/circle/circle_program.csv"), &compensator, 0.1);
    let want = program("tests/data/twin/table3_program.csv");
    assert_eq!(out.len(), want.len());
    let worst = out.q.iter().zip(&want.q).map(|(a, b)| (a - b).abs().to_degrees()).fold(0.0, f64::max);
    // both files are rounded to 1e-6 degrees
    assert!(worst <= 1.01e-6, "{worst} deg");
}
