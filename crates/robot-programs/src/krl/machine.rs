//! What `$machine.dat` says of where the robot stands and how far its axes go.
//!
//! `$ROBROOT` is the place of the robot's foot in the world. Bases are given in the world, so a base means nothing to the arm without it.
//! `$SOFTN_END[n]` and `$SOFTP_END[n]` are the lowest and highest values of A1 to A6 (n from 1) and E1 to E6 (from 7), in deg or mm; both
//! are 0 where there is no such axis.

use crate::axes::Axes;
use crate::script::{At, Installed, Text};
use nalgebra::{Isometry3, Translation3, UnitQuaternion};

/// Axes of a list of the controller: six of the arm, six external ones.
const AXES: usize = 12;

/// What a file says; numbers as it gives them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Machine {
    /// The place of the robot's foot in the world, with its line, from 1; `None`: its numbers cannot be read.
    pub root: Option<(u64, Option<Isometry3<f64>>)>,
    /// Lowest and highest value of each axis, deg or mm; `None`: not given, or no such axis.
    pub ends: [Option<[f64; 2]>; AXES],
}

impl Machine {
    /// Reads a data list.
    ///
    /// `list = {["FRAME"] "$ROBROOT" "=" "{" [type ":"] component {"," component} "}" | end "[" number "]" "=" number}`,
    /// `end = "$SOFTN_END" | "$SOFTP_END"`
    pub fn of(text: &str) -> Self {
        let mut found = Self::default();
        let (mut low, mut high) = ([None; AXES], [None; AXES]);
        for (k, line) in text.lines().enumerate() {
            let line = line.split(';').next().unwrap_or_default().trim().to_ascii_uppercase();
            let Some((name, value)) = line.split_once('=') else { continue };
            let name = name.split_ascii_whitespace().last().unwrap_or_default();
            if name == "$ROBROOT" {
                found.root = Some((k as u64 + 1, frame(value)));
                continue;
            }
            for (list, head) in [(&mut low, "$SOFTN_END["), (&mut high, "$SOFTP_END[")] {
                let index = name.strip_prefix(head).and_then(|n| n.strip_suffix(']')?.trim().parse::<usize>().ok());
                if let Some(end) = index.and_then(|n| list.get_mut(n.checked_sub(1)?)) {
                    *end = value.trim().parse::<f64>().ok().filter(|v| v.is_finite());
                }
            }
        }
        for (ends, both) in found.ends.iter_mut().zip(low.iter().zip(high)) {
            *ends = both.0.zip(both.1).filter(|(low, high)| low < high).map(|(low, high)| [low, high]);
        }
        found
    }

    /// Lowest and highest value of each axis of the robot, rad or m.
    pub fn limits(&self, robot: &Axes) -> Vec<Option<[f64; 2]>> {
        let places = robot.places();
        let number = |axis: usize| {
            let of_arm = places.number(axis).map(|n| n - 1);
            of_arm.or_else(|| Some(places.external.iter().find(|e| e.1 == axis)?.0 + 5))
        };
        let of = |(axis, joint): (usize, &crate::axes::Axis)| {
            let ends = *self.ends.get(number(axis).filter(|_| places.certain && places.numbered)?)?;
            ends.map(|ends| ends.map(|v| v * joint.kind.si_per_user_unit()))
        };
        robot.axis_joints().enumerate().map(of).collect()
    }
}

/// `{X 0.0,Y 0.0,Z 0.0,A 0.0,B 0.0,C 0.0}`, m and rad inside.
fn frame(value: &str) -> Option<Isometry3<f64>> {
    let inside = value.split_once('{')?.1.split_once('}')?.0;
    let inside = inside.split_once(':').map_or(inside, |(_, values)| values);
    let of = |key: &str| {
        let part = inside.split(',').find_map(|p| p.trim().strip_prefix(key)?.strip_prefix(' '));
        part.and_then(|p| p.trim().parse::<f64>().ok()).filter(|v| v.is_finite())
    };
    let (x, y, z) = (of("X")?, of("Y")?, of("Z")?);
    let [a, b, c] = [of("A")?, of("B")?, of("C")?].map(f64::to_radians);
    let turn = UnitQuaternion::from_euler_angles(c, b, a);
    Some(Isometry3::from_parts(Translation3::new(x * 1e-3, y * 1e-3, z * 1e-3), turn))
}

/// Whether a text is a `$machine.dat`.
fn is_machine(text: &Text) -> bool {
    let name = text.name.rsplit(['/', '\\']).next().unwrap_or_default();
    name.eq_ignore_ascii_case("$machine.dat")
}

/// What the `$machine.dat` of the project say.
pub(super) fn installed(texts: &[Text], robot: &Axes) -> Vec<Installed> {
    let mut all = Vec::new();
    for (file, text) in texts.iter().enumerate().filter(|(_, t)| t.context && !t.unread && is_machine(t)) {
        let machine = text.known(|t| Machine::of(&String::from_utf8_lossy(&t.bytes)));
        let limits = machine.limits(robot);
        if machine.root.is_some() || limits.iter().any(Option::is_some) {
            let line = machine.root.map_or(1, |r| r.0);
            all.push(Installed { at: At { file, line }, root: machine.root.map(|r| r.1), limits });
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixtures::kr120;

    #[test]
    fn the_foot_of_the_robot_and_the_ends_of_its_axes_are_read() {
        let text = "DEFDAT $MACHINE PUBLIC\r\nFRAME $ROBROOT={X 100.0,Y 0.0,Z 500.0,A 90.0,B 0.0,C 0.0} ;ROBOTER\r\n\
                    REAL $SOFTN_END[12]\r\n$SOFTN_END[1]=-170.0\r\n$SOFTP_END[1]=170.0\r\n$SOFTN_END[2]=5.0 ;low\r\n\
                    $SOFTN_END[7]=0.0\r\n$SOFTP_END[7]=0.0\r\n$SOFTP_END[13]=1.0\r\nENDDAT\r\n";
        let machine = Machine::of(text);
        let (line, root) = machine.root.unwrap();
        let root = root.unwrap();
        assert_eq!((line, root.translation.vector.z), (2, 0.5));
        assert!((root * nalgebra::Vector3::x() - nalgebra::Vector3::y()).norm() < 1e-12);
        assert_eq!(machine.ends[0], Some([-170.0, 170.0]));
        assert!(machine.ends[1..].iter().all(Option::is_none));
        let limits = machine.limits(&kr120());
        assert!((limits[0].unwrap()[1] - 170f64.to_radians()).abs() < 1e-12 && limits[1].is_none());
        assert_eq!(Machine::of("FRAME $ROBROOT={X 1.0,Y n}\n").root, Some((1, None)));
        assert_eq!(Machine::of("FRAME $ROBROOT\nINT n=1\n"), Machine::default());
    }
}
