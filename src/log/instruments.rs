//! Further channels of a log: what instruments other than a tracker read, orientation, torque, force.
//!
//! Distance to a fixed point: `r_mm` (the whole distance), or `r_um` (what a ballbar shows: the difference to its nominal length).
//! Reading along a direction: `dial_um`. Orientation of the tool in the frame of x, y, z: `qw,qx,qy,qz`. Joint torque:
//! `torque_<joint>_nm`. Force on the tool: `fx_n, fy_n, fz_n`. What each of them means for the robot is [`crate::machine::measurement`].

use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};

/// Largest difference of a quaternion's length from 1 that rounding explains.
pub const UNIT_TOLERANCE: f64 = 1e-3;

/// Readings in SI; empty or `None` where the log has no such columns, `None` in a row where the cell is empty.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Instruments {
    /// Distance from a fixed point to the TCP, m.
    pub distance_m: Option<Vec<Option<f64>>>,
    /// Difference of that distance from a nominal length, m.
    pub distance_off_m: Option<Vec<Option<f64>>>,
    /// Displacement along a direction, m.
    pub dial_m: Option<Vec<Option<f64>>>,
    /// Orientation of the tool in the frame of x, y, z.
    pub orientation: Vec<Option<UnitQuaternion<f64>>>,
    /// Torque of each axis (Nm, or N of a prismatic joint), per axis where logged; empty: no such column.
    pub torque_nm: Vec<Option<Vec<Option<f64>>>>,
    /// Force of the process on the tool at the TCP, N, in the axes of the robot's world frame.
    pub force_n: Option<Vec<Option<Vector3<f64>>>>,
    /// Fixed point from which distances were measured, where the user knows it; robot's world frame, m.
    pub centre_m: Option<Vector3<f64>>,
    /// Direction in that frame in which the dial's reading increases, where the user gave it.
    pub direction: Option<Unit<Vector3<f64>>>,
}

impl Instruments {
    /// Readings of a scalar instrument and whether they are whole distances: distance, difference or dial, whichever is there.
    pub fn scalar(&self) -> Option<&[Option<f64>]> {
        [&self.distance_m, &self.distance_off_m, &self.dial_m].into_iter().find_map(|c| c.as_deref())
    }

    /// The same to change, all that there are.
    pub(super) fn singles_mut(&mut self) -> impl Iterator<Item = &mut Vec<Option<f64>>> {
        [&mut self.distance_m, &mut self.distance_off_m, &mut self.dial_m].into_iter().flatten()
    }

    /// Any reading of the TCP other than its position.
    pub fn has_scalar(&self) -> bool {
        self.scalar().is_some()
    }
}

/// Orientations of four columns; the first row whose numbers are no unit quaternion, with their length.
pub(super) fn orientations(parts: [&[f64]; 4]) -> Result<Vec<Option<UnitQuaternion<f64>>>, (usize, f64)> {
    let [w, x, y, z] = parts;
    (0..w.len())
        .map(|row| {
            let q = Quaternion::new(w[row], x[row], y[row], z[row]);
            let norm = q.norm();
            if norm.is_nan() {
                return Ok(None);
            }
            if (norm - 1.0).abs() > UNIT_TOLERANCE {
                return Err((row, norm));
            }
            Ok(Some(UnitQuaternion::from_quaternion(q)))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use crate::io::input::Input;
    use crate::log::Log;
    use crate::robot::Robot;

    fn log(text: &str) -> crate::error::Result<Log> {
        let robot = Robot::parse(
            "robot.yaml",
            "schema: lostmotion/robot/1\njoints:\n  - {name: A, kind: revolute, a_mm: 500}\n  - {name: B, kind: revolute, a_mm: 300}\n",
        )
        .unwrap();
        Log::parse(Input { name: "log.csv".into(), bytes: text.into(), sha256: String::new() }, &robot)
    }

    #[test]
    fn a_ballbar_a_dial_and_torques_are_read_in_their_units() {
        let log = log("t_s,cmd_A_deg,cmd_B_deg,r_um,dial_um,torque_B_nm\n0,0,0,12.5,-3,41.5\n1,1,0,,2,\n").unwrap();
        let i = &log.instruments;
        assert_eq!(i.distance_off_m.as_deref().unwrap()[1], None);
        assert!((i.distance_off_m.as_deref().unwrap()[0].unwrap() - 12.5e-6).abs() < 1e-18);
        assert!((i.dial_m.as_deref().unwrap()[1].unwrap() - 2e-6).abs() < 1e-18);
        assert_eq!(i.torque_nm[1].as_deref().unwrap(), &[Some(41.5), None]);
        assert!(i.torque_nm[0].is_none() && i.distance_m.is_none());
    }

    #[test]
    fn a_quaternion_is_refused_where_it_has_no_unit_length_or_lacks_a_part() {
        let head = "t_s,cmd_A_deg,cmd_B_deg,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,0,0,800,0,0,";
        let good = log(&format!("{head}0.70711,0,0,0.70711\n")).unwrap();
        assert!((good.instruments.orientation[0].unwrap().angle() - std::f64::consts::FRAC_PI_2).abs() < 1e-4);
        let error = log(&format!("{head}2,0,0,0\n")).unwrap_err().to_string();
        assert!(error.contains("log.csv:2") && error.contains("unit"), "{error}");
        let error = log("t_s,cmd_A_deg,cmd_B_deg,qw,qx\n0,0,0,1,0\n").unwrap_err().to_string();
        assert!(error.contains("qy"), "{error}");
    }
}
