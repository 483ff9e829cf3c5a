//! What is left: structure by joint and aspect, and the noise that it was tested against.

use super::super::milli;
use super::scale::GapScale;
use crate::cli::page::milli_unit;
use crate::diagnose::Outcome;
use crate::diagnose::candidates::basis::Aspect;
use crate::diagnose::result::document::Diagnosis;
use crate::diagnose::result::words;
use crate::error::counted;
use crate::report::number::significant;
use crate::report::{MapBlock, MapCell, MapView, Page, TableView, number};

const ASPECTS: [(Aspect, &str); 6] = [
    (Aspect::Position, "position"),
    (Aspect::Direction, "direction"),
    (Aspect::Speed, "speed"),
    (Aspect::Acceleration, "acceleration"),
    (Aspect::SinceReversal, "since its reversals"),
    (Aspect::Torque, "torque"),
];

/// What is left, by joint and aspect: the test without the catalogue.
pub(super) fn structure(page: &mut Page, outcome: &Outcome, d: &Diagnosis, scale: &GapScale) {
    let groups = &outcome.structure.groups;
    if groups.is_empty() {
        return;
    }
    let noise = d.gap.final_rms_um * scale.um;
    let n = outcome.problem.n as f64;
    let chance = 1e-3 / groups.len() as f64;
    let cell = |axis: Option<usize>, aspect: Aspect| match groups
        .iter()
        .find(|b| b.axis == axis && b.aspect == Some(aspect))
    {
        None => MapCell::Absent,
        Some(b) if b.p_value > chance => MapCell::Word("–".into()),
        Some(b) => {
            let size = noise * ((b.gain - b.dof as f64).max(0.0) / n).sqrt();
            MapCell::Size { text: words::rough(size), colour: size }
        }
    };
    let robot = &outcome.problem.robot;
    // of joints that are held alone
    let torque = groups.iter().any(|b| b.aspect == Some(Aspect::Torque));
    let aspects = if torque { &ASPECTS[..] } else { &ASPECTS[..ASPECTS.len() - 1] };
    let rows = (0..robot.dof())
        .filter(|&a| groups.iter().any(|b| b.axis == Some(a)))
        .map(|a| (robot.axis(a).name.clone(), aspects.iter().map(|(aspect, _)| cell(Some(a), *aspect)).collect()));
    let named =
        |list: &[(Aspect, &str)]| list.iter().map(|(_, name)| (name.to_string(), scale.unit.to_string())).collect();
    let whole = [(Aspect::Time, "time"), (Aspect::Geometry, "pose")];
    let mut blocks = vec![MapBlock { corner: "joint".into(), columns: named(aspects), rows: rows.collect() }];
    if groups.iter().any(|b| b.axis.is_none()) {
        blocks.push(MapBlock {
            corner: "whole machine".into(),
            columns: named(&whole),
            rows: vec![(String::new(), whole.iter().map(|(aspect, _)| cell(None, *aspect)).collect())],
        });
    }
    let (title, nearest) = match &d.unexplained {
        Some(u) => {
            let nearest = u.nearest.as_ref().map_or(String::new(), |c| {
                format!(
                    " The nearest effect of the catalogue is {} {}, with a gain of {:.0} in 2 ln L.",
                    c.effect, c.target, c.gain_2lnl
                )
            });
            (format!("The remaining structure depends on {}", u.goes_with), nearest)
        }
        None => ("Test without the catalogue".to_string(), String::new()),
    };
    page.section(
        title,
        format!(
            "Splines and powers per joint, over time and over the pose, tested on the residual against correlated noise; the size of \
             the structure in {}, rms. A dash means no more than chance. One structure may appear in several cells.{nearest}",
            scale.unit
        ),
        MapView { quantity: "structure, rms".into(), unit: scale.unit.into(), hatched: String::new(), by_decades: false, blocks },
    );
}

pub(super) fn noise(page: &mut Page, outcome: &Outcome, d: &Diagnosis, scale: &GapScale) {
    use crate::diagnose::problem::layout::Sensor;
    let robot = &outcome.problem.robot;
    let rows = outcome.problem.groups.iter().zip(&outcome.whitening.noise).map(|(g, noise)| {
        let (sensor, axis) = match g.sensor {
            Sensor::Reflector(0) => ("TCP".to_string(), None),
            Sensor::Reflector(k) => (format!("reflector {}", k + 1), None),
            Sensor::Reading => ("reading of the TCP".to_string(), None),
            Sensor::Orientation => ("orientation of the tool".to_string(), None),
            Sensor::Motor(a) => (format!("motor of {}", robot.axis(a).name), Some(a)),
            Sensor::Joint(a) => (format!("joint {}", robot.axis(a).name), Some(a)),
        };
        let (sigma, unit) = match axis {
            None if g.sensor == Sensor::Orientation => (noise.sigma * 1e6, "µrad"),
            None => (noise.sigma * 1e6, "µm"),
            Some(a) => (milli(robot, a, noise.sigma), milli_unit(robot.axis(a).kind)),
        };
        vec![
            crate::report::views::file_name(&outcome.problem.logs[g.log].log.name),
            sensor,
            crate::report::number::count(g.rows.len() as u64),
            format!("{} {unit}", significant(sigma)),
            number(noise.lag_one(), 2),
            number(noise.phi, 2),
            crate::report::number::percent(noise.share),
        ]
    });
    let headings = [
        ("log", false),
        ("sensor", false),
        ("samples", true),
        ("noise", true),
        ("from sample to sample", true),
        ("coloured part", true),
        ("share", true),
    ];
    let left = if d.outliers == 0 {
        "No sample was left out.".to_string()
    } else {
        format!("Left out, in disagreement with the neighbours: {}.", counted(d.outliers, "sample"))
    };
    let blocks = outcome.problem.logs.iter().map(|l| l.block).max().unwrap_or(1);
    let means = if blocks > 1 {
        format!(" Up to {blocks} rows are averaged into one value; the noise is that of the averages.")
    } else {
        String::new()
    };
    page.section(
        format!("Noise of {} {}", significant(d.noise.sigma_um * scale.um), scale.unit),
        format!(
            "White noise and a first-order autoregressive part, estimated by maximum likelihood ({}). Autocorrelation of the whole from one \
             sample to the next, that of the coloured part, and its share of the variance. {left}{means}",
            d.noise.source
        ),
        TableView::new(&headings, rows),
    );
}
