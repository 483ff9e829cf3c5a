//! A log as what the gears turn by, where gears turn by sums of axes.
//!
//! An encoder or sensor is taken as the controller shows its joint; where the other joint of the sum has none, its command counts.

use super::Log;
use crate::robot::Robot;

impl Log {
    /// The same log with commands, encoders and sensors as what the gears of `robot` turn by ([`crate::robot::gap_of`]).
    pub fn by_gears(&self, robot: &Robot) -> Self {
        let log = self;
        let mut out = log.clone();
        for gear in &robot.gap_of {
            for &(other, sign) in &gear.others {
                let (Some(own), Some(addend)) = (out.cmd.get_mut(gear.axis), log.cmd.get(other)) else { continue };
                own.iter_mut().zip(addend).for_each(|(v, a)| *v += sign * a);
                let decimals = log.cmd_decimals.get(other).copied().unwrap_or(0);
                if let Some(d) = out.cmd_decimals.get_mut(gear.axis) {
                    *d = (*d).max(decimals);
                }
                for (column, from) in
                    [(&mut out.enc, &log.enc), (&mut out.meas, &log.meas), (&mut out.screw, &log.screw)]
                {
                    let Some(Some(own)) = column.get_mut(gear.axis) else { continue };
                    let measured = from.get(other).and_then(Option::as_ref);
                    for (row, v) in own.iter_mut().enumerate() {
                        let a = measured.map_or(Some(addend[row]), |m| m[row]);
                        *v = v.zip(a).map(|(v, a)| v + sign * a);
                    }
                }
            }
        }
        out
    }
}
