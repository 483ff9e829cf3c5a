//! A robot from a URDF file: the chain from the root link to a tip, as Denavit-Hartenberg parameters.
//!
//! Method: every joint's axis is placed at the zero configuration by multiplying the joints' origins; [`super::dh`] finds the
//! frames of Denavit and Hartenberg (1955) on these lines; what remains before the first and after the last frame becomes
//! `base` and `flange`. The result is compared with the URDF's own chain at random joint positions.
//!
//! The links `base` and `tool0` are the controller's world and flange (REP 199): where they exist, `base` and `flange` of the robot
//! file are counted from them, so that poses of programs mean the same here as on the controller. A tip after `tool0` is the tool;
//! joints of a gripper after it are none of the arm's.
//!
//! Numbers of a URDF are often rounded: `1.5708` for a quarter turn. An angle that is a multiple of 45 degrees to its written
//! digits is taken as that multiple, and reported.
//!
//! Refused: joints of kind `floating` and `planar`, a chain that branches without `--tip`, xacro that was not expanded.
//!
//! In this folder: what a reading gives, here; [`reader`] takes the chain out of the XML; [`chain`] makes the robot of it and
//! compares both.

mod chain;
mod reader;

use super::{JointKind, Robot};
use crate::error::{Error, Place, Result};
use nalgebra::{Isometry3, Unit, Vector3};
use reader::Reader;
use roxmltree::Document;

/// A robot from a URDF and what the reader did on the way.
#[derive(Debug)]
pub struct FromUrdf {
    /// The robot.
    pub robot: Robot,
    /// Link at the end of the chain: its frame is the TCP.
    pub tip: String,
    /// Link whose frame is the flange: `tool0`, else the tip.
    pub flange: String,
    /// Link that is the controller's world, where the URDF has one.
    pub world: Option<String>,
    /// Angles that were taken as a multiple of 45 deg: as written.
    pub snapped: Vec<String>,
    /// Largest distance between the URDF's chain and the robot's, m, and between their orientations, rad, at random positions.
    pub largest_error: (f64, f64),
}

/// Mass, kg, and centre of mass in the link's own frame, m.
type Inertia = (f64, Vector3<f64>);

/// One joint of the URDF on the chain.
struct Element {
    name: String,
    kind: Option<JointKind>,
    origin: Isometry3<f64>,
    axis: Unit<Vector3<f64>>,
    limits: Option<[f64; 2]>,
    max_speed: Option<f64>,
    /// Driving joint, ratio, offset.
    mimic: Option<(String, f64, f64)>,
    parent: String,
    child: String,
}

/// Reads a URDF.
///
/// # Errors
/// [`Error::BadInput`] with line and column: not XML, no chain, a joint that cannot be expressed.
pub fn read(name: &str, text: &str, tip: Option<&str>) -> Result<FromUrdf> {
    let doc = Document::parse(text).map_err(|e| {
        let at = e.pos();
        Error::bad(
            Place::field(name, u64::from(at.row), u64::from(at.col)),
            format!("no XML: {e}"),
            "a URDF file (XML; expand xacro files first)",
        )
    })?;
    let mut reader = Reader { name, doc: &doc, snapped: Vec::new() };
    let root = doc.root_element();
    if root.tag_name().name() != "robot" {
        let found = format!("<{}>", root.tag_name().name());
        return Err(reader.bad(root, found, "a <robot> element"));
    }
    let chain = reader.chain(root, tip)?;
    let tip = chain.last().map(|e| e.child.clone()).unwrap_or_default();
    let flange = chain.iter().rev().take_while(|e| e.kind.is_none()).find(|e| e.child.ends_with("tool0"));
    let flange = flange.map_or_else(|| tip.clone(), |e| e.child.clone());
    let world = reader.world(root, &chain)?;
    let masses = reader.masses(root, &chain)?;
    let title = root.attribute("name").unwrap_or("robot");
    let at = world.as_ref().map_or_else(Isometry3::identity, |w| w.1);
    let robot = chain::build(title, &chain, &masses, &flange, &at)
        .map_err(|what| reader.bad(root, what.to_string(), what.expected()))?;
    let largest_error = chain::compare(&robot, &chain, &at);
    let world = world.map(|w| w.0);
    Ok(FromUrdf { robot, tip, flange, world, snapped: reader.snapped, largest_error })
}

#[cfg(test)]
mod tests {
    use super::reader::multiple_of_45_deg;
    use super::*;

    const SCARA: &str = r#"<robot name="scara">
      <link name="base"/><link name="a"><inertial><mass value="2"/><origin xyz="0.1 0 0"/></inertial></link>
      <link name="b"><inertial><mass value="1"/><origin xyz="0.1 0 0"/></inertial></link>
      <link name="quill"><inertial><mass value="0.5"/></inertial></link><link name="tcp"/>
      <joint name="J1" type="revolute"><parent link="base"/><child link="a"/><origin xyz="0 0 0.4"/><axis xyz="0 0 1"/>
        <limit lower="-2" upper="2" velocity="3" effort="1"/></joint>
      <joint name="J2" type="continuous"><parent link="a"/><child link="b"/><origin xyz="0.3 0 0"/><axis xyz="0 0 1"/></joint>
      <joint name="J3" type="prismatic"><parent link="b"/><child link="quill"/><origin xyz="0.25 0 0" rpy="3.1416 0 0"/>
        <axis xyz="0 0 1"/><limit lower="0" upper="0.2" velocity="1" effort="1"/></joint>
      <joint name="flange" type="fixed"><parent link="quill"/><child link="tcp"/><origin xyz="0 0 0.05"/></joint>
    </robot>"#;

    #[test]
    fn a_scara_moves_as_its_urdf_says() {
        let found = read("scara.urdf", SCARA, None).unwrap();
        assert_eq!(found.tip, "tcp");
        assert_eq!(found.snapped, ["3.1416"]);
        assert!(found.largest_error.0 < 1e-12 && found.largest_error.1 < 1e-9, "{:?}", found.largest_error);
        // by hand: at zero the TCP hangs 0.05 m below the quill's origin, at the arm's end
        let tcp = found.robot.tcp_m(&[0.0, 0.0, 0.1]);
        assert!((tcp - Vector3::new(0.55, 0.0, 0.4 - 0.15)).norm() < 1e-12, "{tcp}");
        assert_eq!(found.robot.links.len(), 3);
    }

    #[test]
    fn a_continuous_joint_keeps_its_speed_and_has_no_range() {
        let text = SCARA.replace(
            r#"<origin xyz="0.3 0 0"/><axis xyz="0 0 1"/></joint>"#,
            r#"<origin xyz="0.3 0 0"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="2.5" effort="1"/></joint>"#,
        );
        let robot = read("scara.urdf", &text, None).unwrap().robot;
        assert_eq!((robot.axis(1).limits, robot.axis(1).max_speed), (None, Some(2.5)));
        assert_eq!(robot.axis(0).limits, Some([-2.0, 2.0]));
    }

    /// An arm of one joint as ROS descriptions are built: world and flange of the controller are separate links.
    const DESCRIBED: &str = r#"<robot name="arm"><link name="base_link"/><link name="base"/><link name="link_1"/><link name="flange"/>
      <link name="tool0"/><link name="gun"/>
      <joint name="J1" type="revolute"><parent link="base_link"/><child link="link_1"/><origin xyz="0 0 0.4"/><axis xyz="0 0 1"/>
        <limit lower="-2" upper="2" velocity="3" effort="1"/></joint>
      <joint name="world" type="fixed"><parent link="base_link"/><child link="base"/><origin xyz="0 0 0.3"/></joint>
      <joint name="f" type="fixed"><parent link="link_1"/><child link="flange"/><origin xyz="0.5 0 0"/></joint>
      <joint name="t" type="fixed"><parent link="link_1"/><child link="tool0"/><origin xyz="0.5 0 0" rpy="0 1.5708 0"/></joint>
      <joint name="g" type="fixed"><parent link="tool0"/><child link="gun"/><origin xyz="0 0 0.2"/></joint>
    </robot>"#;

    #[test]
    fn world_and_flange_are_those_of_the_controller() {
        for (tip, reach_m) in [(None, 0.5), (Some("tool0"), 0.5), (Some("gun"), 0.7)] {
            let found = read("arm.urdf", DESCRIBED, tip).unwrap();
            assert_eq!((found.flange.as_str(), found.world.as_deref()), ("tool0", Some("base")));
            assert!(
                found.largest_error.0 < 1e-12 && found.largest_error.1 < 1e-9,
                "{tip:?}: {:?}",
                found.largest_error
            );
            // by hand: 0.1 m above the controller's origin, z of the flange along x of the world
            let at = found.robot.forward(&[0.0]);
            assert!((at.position - Vector3::new(reach_m, 0.0, 0.1)).norm() < 1e-12, "{tip:?}: {}", at.position);
            assert!((at.rotation * Vector3::z() - Vector3::x()).norm() < 1e-12);
            assert!((found.robot.tool.translation.z - (reach_m - 0.5)).abs() < 1e-12, "{tip:?}");
            // the file has the same
            let again = Robot::parse("r", &found.robot.to_yaml().unwrap()).unwrap();
            assert!((again.forward(&[0.3]).position - found.robot.forward(&[0.3]).position).norm() < 1e-12);
            assert_eq!(again.fingerprint(), found.robot.fingerprint());
        }
    }

    /// Fingers after the flange: two of them end the chain in two places, one of them would be an axis of the arm.
    #[test]
    fn a_gripper_after_the_flange_is_no_part_of_the_arm() {
        let finger = |name: &str| {
            format!(
                r#"<link name="{name}"/><joint name="j{name}" type="prismatic"><parent link="tool0"/><child link="{name}"/>
                   <axis xyz="0 1 0"/><limit lower="0" upper="0.04" velocity="2" effort="1"/></joint></robot>"#
            )
        };
        let one = DESCRIBED.replace("</robot>", &finger("left"));
        for text in [one.replace("</robot>", &finger("right")), one] {
            let found = read("arm.urdf", &text, None).unwrap();
            assert_eq!((found.tip.as_str(), found.flange.as_str(), found.robot.dof()), ("tool0", "tool0", 1));
        }
        // two arms: which one is not known
        let two = one_more_arm();
        assert!(read("arm.urdf", &two, None).unwrap_err().to_string().contains("a chain that ends in 2 places"));
    }

    fn one_more_arm() -> String {
        let other = r#"<link name="l1"/><link name="r_tool0"/><joint name="K1" type="revolute"><parent link="base_link"/><child link="l1"/>
          <axis xyz="0 0 1"/></joint><joint name="k" type="fixed"><parent link="l1"/><child link="r_tool0"/></joint></robot>"#;
        DESCRIBED.replace("tool0", "l_tool0").replace("</robot>", other)
    }

    #[test]
    fn a_slide_that_mimics_a_turning_joint_is_refused() {
        let mimic =
            r#"<limit lower="0" upper="0.2" velocity="1" effort="1"/><mimic joint="J2" multiplier="0.1"/></joint>"#;
        let text = SCARA.replace(r#"<limit lower="0" upper="0.2" velocity="1" effort="1"/></joint>"#, mimic);
        let said = read("scara.urdf", &text, None).unwrap_err().to_string();
        assert!(said.contains("joint `J3` mimics `J2`, and only one of them turns"), "{said}");
    }

    #[test]
    fn an_angle_is_snapped_only_where_it_is_that_angle_to_its_digits() {
        for (word, snaps) in
            [("1.57", true), ("1.5708", true), ("-3.14159", true), ("1.58", false), ("1.5", false), ("0.7853", true)]
        {
            assert_eq!(multiple_of_45_deg(word.parse().unwrap(), word).is_some(), snaps, "{word}");
        }
    }

    #[test]
    fn what_is_no_chain_is_refused_with_its_place() {
        let refusal = |text: &str| read("x.urdf", text, None).unwrap_err().to_string();
        assert!(refusal("<robot").contains("x.urdf:1:"), "{}", refusal("<robot"));
        assert!(refusal("<robot/>").contains("no chain"));
        assert!(refusal(&SCARA.replace("0.3 0 0", "${a2} 0 0")).contains("xacro"));
        assert!(refusal(&SCARA.replace("continuous", "planar")).contains("planar"));
    }
}
