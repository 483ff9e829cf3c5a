//! Robots for the tests: the axes of the templates in the repository's `configs/`.

use crate::axes::{Axes, Axis, JointKind};
use nalgebra::Isometry3;

/// Axes of one kind with these names and limits in deg or mm.
fn table(kind: JointKind, joints: &[(&str, [f64; 2])]) -> Vec<Axis> {
    let axis = |(name, limits): &(&str, [f64; 2])| {
        let mut axis = Axis::new(*name, kind);
        axis.limits = Some(limits.map(|v| v * kind.si_per_user_unit()));
        axis
    };
    joints.iter().map(axis).collect()
}

fn arm(name: &str, joints: &[(&str, [f64; 2])]) -> Axes {
    Axes::new(name, table(JointKind::Revolute, joints))
}

pub fn kr120() -> Axes {
    let mut axes = arm(
        "KUKA KR 120 R2500 PRO",
        &[
            ("A1", [-185.0, 185.0]),
            ("A2", [-155.0, 35.0]),
            ("A3", [-130.0, 154.0]),
            ("A4", [-350.0, 350.0]),
            ("A5", [-130.0, 130.0]),
            ("A6", [-350.0, 350.0]),
        ],
    );
    axes.tool = Isometry3::translation(0.156, 0.0, 0.063);
    axes
}

/// J23 keeps the forearm level while J2 moves: a joint that follows another one.
pub fn m10ia() -> Axes {
    let name = "FANUC M-10iA";
    let limits = [
        ("J1", [-180.0, 180.0]),
        ("J2", [-90.0, 160.0]),
        ("J3", [-180.0, 264.5]),
        ("J4", [-190.0, 190.0]),
        ("J5", [-190.0, 190.0]),
        ("J6", [-360.0, 360.0]),
    ];
    let mut joints = table(JointKind::Revolute, &limits);
    let mut wheel = Axis::new("J23", JointKind::Revolute);
    wheel.follows = Some("J2".into());
    joints.insert(2, wheel);
    let mut axes = Axes::new(name, joints);
    axes.base = Isometry3::translation(0.0, 0.0, -0.45);
    axes
}

pub fn irb1600() -> Axes {
    Axes::new("ABB IRB 1600-6/1.45", irb1600_joints())
}

/// The same arm on a rail of 4 m as its seventh axis.
pub fn irb1600_on_a_rail() -> Axes {
    let name = "ABB IRB 1600-6/1.45";
    let mut joints = irb1600_joints();
    joints.extend(table(JointKind::Prismatic, &[("E1", [0.0, 4000.0])]));
    Axes::new(name, joints)
}

fn irb1600_joints() -> Vec<Axis> {
    let limits = [
        ("J1", [-180.0, 180.0]),
        ("J2", [-90.0, 120.0]),
        ("J3", [-245.0, 65.0]),
        ("J4", [-200.0, 200.0]),
        ("J5", [-115.0, 115.0]),
        ("J6", [-400.0, 400.0]),
    ];
    table(JointKind::Revolute, &limits)
}

pub fn ur10() -> Axes {
    let names = ["base", "shoulder", "elbow", "wrist1", "wrist2", "wrist3"];
    arm("Universal Robots UR10", &names.map(|n| (n, [-360.0, 360.0])))
}

pub fn gantry() -> Axes {
    let name = "Gantry XYZ with ball screws";
    let mut axes = Axes::new(
        name,
        table(JointKind::Prismatic, &[("X", [0.0, 1000.0]), ("Y", [0.0, 800.0]), ("Z", [-400.0, 0.0])]),
    );
    let quarter = std::f64::consts::FRAC_PI_2;
    axes.base = Isometry3::from_parts(
        nalgebra::Translation3::identity(),
        nalgebra::UnitQuaternion::from_euler_angles(2.0 * quarter, -quarter, 0.0),
    );
    // the tests write whole numbers of millimetres
    axes.control.whole_units = true;
    axes
}

/// The pulses of a widespread post-processor; `without`: a joint whose pulses the robot file does not give.
pub fn ma2010(without: Option<&str>) -> Axes {
    Axes::new("Motoman MA2010", ma2010_joints(without))
}

/// The same arm on a rail as its seventh axis, -100 pulses a millimetre.
pub fn ma2010_on_a_rail() -> Axes {
    let mut joints = ma2010_joints(None);
    let mut rail = table(JointKind::Prismatic, &[("E", [-9000.0, 9000.0])]);
    rail[0].pulses = Some(-100.0 / JointKind::Prismatic.si_per_user_unit());
    joints.extend(rail);
    Axes::new("Motoman MA2010", joints)
}

fn ma2010_joints(without: Option<&str>) -> Vec<Axis> {
    let limits = [
        ("S", [-180.0, 180.0]),
        ("L", [-105.0, 155.0]),
        ("U", [-86.0, 160.0]),
        ("R", [-150.0, 150.0]),
        ("B", [-135.0, 90.0]),
        ("T", [-210.0, 210.0]),
    ];
    let pulses_per_deg = [1341.4, 1341.4, 1341.4, 1000.0, 1000.0, 622.0];
    let mut joints = table(JointKind::Revolute, &limits);
    for (joint, per_deg) in joints.iter_mut().zip(pulses_per_deg) {
        joint.pulses = (without != Some(joint.name.as_str())).then(|| per_deg / joint.kind.si_per_user_unit());
    }
    joints
}
