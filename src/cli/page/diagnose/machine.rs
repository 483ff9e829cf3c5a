//! What each joint lacks, where everything was fitted together: joint by cause, in micrometres at the TCP.

use crate::diagnose::result::document::{Diagnosis, Round};
use crate::effects::{Family, catalogue};
use crate::report::{MapBlock, MapCell, MapView, Page};
use crate::robot::Robot;

/// Steps of the waterfall: the rounds, of a group the last one under the group's name.
pub(super) fn steps(d: &Diagnosis) -> impl Iterator<Item = (String, &Round)> {
    let together = d.geometry_tcp_um.is_some();
    let last = d.rounds.iter().rposition(|r| r.group.is_some());
    d.rounds.iter().enumerate().filter_map(move |(i, r)| match r.group {
        Some(group) if together => (Some(i) == last).then(|| (group.to_string(), r)),
        _ => Some((format!("{} {}", r.effect, r.target), r)),
    })
}

/// Causes that stand on a joint, in the order of their columns.
const CAUSES: [(Family, &str); 6] = [
    (Family::Lag, "lag"),
    (Family::Gap, "gap"),
    (Family::Friction, "friction"),
    (Family::Gravity, "gravity"),
    (Family::Ripple, "ripple"),
    (Family::Scale, "scale, coupling"),
];

/// The map of joints and causes, coloured by what each does to the TCP.
pub(super) fn causes(page: &mut Page, robot: &Robot, d: &Diagnosis) {
    let Some(geometry_um) = d.geometry_tcp_um else { return };
    let family = |r: &Round| catalogue::find(&r.effect).map(|info| info.family);
    let of_joint = |joint: &str, wanted: Family| {
        let all = d.rounds.iter().filter(|r| r.place.joint.as_deref() == Some(joint) && family(r) == Some(wanted));
        all.filter_map(|r| r.tcp_um).map(|um| um * um).sum::<f64>().sqrt()
    };
    let cell = |um: f64| match um > 0.0 {
        true => MapCell::Size { text: format!("{um:.1}"), colour: um },
        false => MapCell::Absent,
    };
    let joints = robot.axis_joints().map(|j| {
        let cells = CAUSES.iter().map(|(f, _)| cell(of_joint(&j.name, *f))).collect();
        (j.name.clone(), cells)
    });
    let mut blocks = vec![MapBlock {
        corner: "joint".into(),
        columns: CAUSES.iter().map(|(_, name)| (name.to_string(), "µm".to_string())).collect(),
        rows: joints.collect(),
    }];
    let whole = d.rounds.iter().filter(|r| r.place.joint.is_none() && r.group.is_none());
    let mut columns = vec![("geometry".to_string(), "µm".to_string())];
    let mut cells = vec![cell(geometry_um)];
    for r in whole {
        columns.push((r.effect.replace('_', " "), "µm".to_string()));
        cells.push(cell(r.tcp_um.unwrap_or(0.0)));
    }
    blocks.push(MapBlock { corner: "whole machine".into(), columns, rows: vec![(String::new(), cells)] });
    page.section(
        "Effects by joint and by their size at the TCP",
        "Root mean square per coordinate beyond a rigid movement, in the log where it is largest. Repair, recalibrate or compensate the brightest cell first.",
        MapView {
            quantity: "at the TCP, rms".into(),
            unit: "µm".into(),
            hatched: String::new(),
            by_decades: true,
            blocks,
        },
    );
}
