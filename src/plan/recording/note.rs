//! What a reader of a program to record should know. Code compares the variants; the words are for readers.

use crate::robot::JointKind;
use crate::robot::gap_of::JointsAlone;

/// A remark on a program to record. Values of joints are in rad or m, as `kind` says.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Note {
    /// A gap of a sum of axes counts as one of a joint alone.
    #[error("{0}")]
    JointsAlone(JointsAlone),
    /// The gear of a joint turns by a sum of axes.
    #[error(
        "{joint}: its gear turns by {sum}; where another axis of the sum moves alone in this program, {joint} moves with it so that its gear rests"
    )]
    SumOfAxes {
        /// Name of the joint.
        joint: String,
        /// The sum as the robot file writes it.
        sum: String,
    },
    /// A joint that cannot be tested.
    #[error("{joint}: not tested, because its range leaves no space to move")]
    NoSpace {
        /// Name of the joint.
        joint: String,
    },
    /// The tracker does not see the whole range of a joint.
    #[error(
        "{joint}: {:.1} to {:.1} {}, because the tracker cannot see more",
        kind.to_user_unit(window[0]), kind.to_user_unit(window[1]), kind.unit()
    )]
    Window {
        /// Name of the joint.
        joint: String,
        /// Kind of the joint.
        kind: JointKind,
        /// What it sees, rad or m.
        window: [f64; 2],
    },
    /// The tracker does not see the ranges of all joints together.
    #[error(
        "joints travel {:.0} % of what the tracker would allow each of them alone, so that it sees the whole motion",
        100.0 * share
    )]
    Narrowed {
        /// Share of each range.
        share: f64,
    },
    /// The beam may be interrupted.
    #[error(
        "the beam may be interrupted on {:.1} % of the path (by the arm, or beyond the acceptance angle of the reflector)",
        100.0 * *hidden as f64 / *rows as f64
    )]
    BeamInterrupted {
        /// Rows of the path at which it may be.
        hidden: usize,
        /// All rows.
        rows: usize,
    },
    /// The distance changes by more than a double ballbar reads.
    #[error(
        "the distance from the centre changes from {:.0} to {:.0} mm: this program is for a draw wire or another sensor of that range, \
         not for a double ballbar",
        nearest_m * 1e3, farthest_m * 1e3
    )]
    ForDrawWire {
        /// Smallest distance, m.
        nearest_m: f64,
        /// Largest distance, m.
        farthest_m: f64,
    },
    /// A whole circle about the centre of a ballbar.
    #[error(
        "circle of {:.0} mm about the centre in the horizontal plane: {turns:.0} turns each way from {}, with one orientation of the tool",
        radius_m * 1e3, point(start_m)
    )]
    Circle {
        /// Length of the bar, m.
        radius_m: f64,
        /// Turns each way.
        turns: f64,
        /// Where it starts, m.
        start_m: [f64; 3],
    },
    /// An arc instead of the circle.
    #[error(
        "the whole circle cannot be reached: arc of {swing_deg:.0} deg in the horizontal plane from {}, twice each way",
        point(start_m)
    )]
    Swing {
        /// Length of the arc, deg.
        swing_deg: f64,
        /// Where it starts, m.
        start_m: [f64; 3],
    },
    /// An arc in a vertical plane.
    #[error(
        "arc of {:.0} deg in the vertical plane at {azimuth_deg:.0} deg (from {:.0} to {:.0} deg above the horizontal), twice each way{}",
        (ends_deg[1] - ends_deg[0]).abs(), ends_deg[0].min(ends_deg[1]) + 0.0, ends_deg[0].max(ends_deg[1]) + 0.0,
        if ends_deg[1] < 0.0 { "; the bar hangs below its centre there, whose mount must leave it free" } else { "" }
    )]
    Upright {
        /// Direction of the plane, deg.
        azimuth_deg: f64,
        /// Its ends above the horizontal, deg: the first is the one to which the arc comes last.
        ends_deg: [f64; 2],
    },
    /// No arc in a vertical plane.
    #[error("no arc in the vertical plane at {azimuth_deg:.0} deg can be reached")]
    NotUpright {
        /// Direction of the plane, deg.
        azimuth_deg: f64,
    },
    /// Joints come near the ends of their ranges.
    #[error(
        "{} comes to less than {:.0} % from the end of its range: check that the controller's own limits allow that",
        joints.join(", "), margin * 100.0
    )]
    NearEnds {
        /// Names of the joints.
        joints: Vec<String>,
        /// Part of the range that is usually kept free.
        margin: f64,
    },
    /// Circles that reverse no joint.
    #[error("these circles reverse no joint")]
    NoReversal,
    /// Joints that the circles reverse, and whose gaps they tell.
    #[error("these circles reverse {}; they tell {}", reversed(reversals), gaps_of(told))]
    Reverses {
        /// Names of the joints and how often they reverse.
        reversals: Vec<(String, usize)>,
        /// Names of the joints whose gaps can be determined.
        told: Vec<String>,
    },
    /// Joints whose gaps the circles do not tell.
    #[error(
        "these circles cannot tell the gap of {}: record those joints with another instrument (a dial along their movement, a tracker)",
        joints.join(", ")
    )]
    NotTold {
        /// Names of the joints.
        joints: Vec<String>,
    },
}

/// Why little or nothing can be determined of a joint.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Reason {
    /// The instrument hardly sees the joint.
    #[error(
        "it {} by {:.2} {}: its gap cannot be determined",
        if *tcp { "moves this TCP" } else { "changes this reading" }, sensitivity_m * 1e3,
        if *kind == JointKind::Revolute { "mm per radian" } else { "um per mm" }
    )]
    HardlySeen {
        /// Kind of the joint.
        kind: JointKind,
        /// A tracker sees the TCP; else a single reading.
        tcp: bool,
        /// Mean sensitivity, m per rad or m per m.
        sensitivity_m: f64,
    },
    /// The joint does not reverse.
    #[error("it does not reverse")]
    NoReversal,
    /// Small gaps are not seen.
    #[error(
        "a half gap below {:.4} {} cannot be distinguished from zero",
        kind.to_user_unit(*half_gap), kind.unit()
    )]
    SmallGaps {
        /// Kind of the joint.
        kind: JointKind,
        /// Smallest half gap that is seen, rad or m.
        half_gap: f64,
    },
    /// Other joints change the reading in the same way.
    #[error(
        "it changes this reading as other joints do: the standard deviation of its half gap would be {:.4} {}",
        kind.to_user_unit(*sigma), kind.unit()
    )]
    AsOthers {
        /// Kind of the joint.
        kind: JointKind,
        /// Standard deviation of its half gap, rad or m.
        sigma: f64,
    },
}

fn point(at_m: &[f64; 3]) -> String {
    let [x, y, z] = at_m.map(|v| v * 1e3);
    format!("{x:.1}, {y:.1}, {z:.1} mm")
}

fn reversed(reversals: &[(String, usize)]) -> String {
    reversals.iter().map(|(joint, n)| format!("{joint} ({n} times)")).collect::<Vec<_>>().join(", ")
}

fn gaps_of(told: &[String]) -> String {
    if told.is_empty() { "no gap".into() } else { format!("the gaps of {}", told.join(", ")) }
}

crate::io::in_words!(Note, Reason);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_through_the_nadir_says_that_the_bar_hangs_there() {
        let note = |ends_deg| Note::Upright { azimuth_deg: 30.0, ends_deg }.to_string();
        let over = note([-20.0, 200.0]);
        assert!(over.starts_with("arc of 220 deg in the vertical plane at 30 deg (from -20 to 200 deg"), "{over}");
        let under = note([0.0, -90.0]);
        assert!(under.contains("(from -90 to 0 deg") && under.ends_with("whose mount must leave it free"), "{under}");
    }
}
