//! Equations 16 and 17 of Zhang (2023) exactly as printed, to compare with: no hold, no turning points between points.
//!
//! One point is inserted at a share of the segment after each reversal (section 5: a tenth); `k` counts points from there.
//! A friction term that fades faster than the joint moves turns the command back here, as it did in the paper.

use super::{Origin, OutputPoints, Points};
use crate::compensator::{Compensator, FrictionShape};

/// Movements below this are pauses, rad or m.
const STILL: f64 = 1e-11;

/// The program with the printed offsets, held in memory. Friction that is not of the printed form is left out.
pub fn rewrite(points: &Points, compensator: &Compensator, fraction: f64) -> OutputPoints {
    let (n, axes) = (points.len(), points.axes);
    let directions = arrivals(points);
    let mut out = OutputPoints { axes, ..OutputPoints::default() };
    let mut arrive: Vec<&[i8]> = Vec::new();
    for i in 0..n {
        out.q.extend_from_slice(points.row(i));
        out.origin.push(Origin::Point(i as u64));
        arrive.push(&directions[i * axes..(i + 1) * axes]);
        let turns =
            i > 0 && i + 1 < n && (0..axes).any(|a| directions[i * axes + a] * directions[(i + 1) * axes + a] < 0);
        if turns {
            let lerp = points.row(i).iter().zip(points.row(i + 1)).map(|(a, b)| a + fraction * (b - a));
            out.q.extend(lerp);
            out.origin.push(Origin::Inserted { after: i as u64, fraction });
            arrive.push(&directions[(i + 1) * axes..(i + 2) * axes]);
        }
    }
    for joint in &compensator.joints {
        let a = joint.axis;
        let mut since: Option<u32> = None;
        for i in 0..out.len() {
            let dir = arrive[i][a];
            if dir == 0 {
                continue;
            }
            if i > 0 && dir * arrive[i - 1][a] < 0 {
                since = Some(1);
            } else {
                since = since.map(|k| k + 1);
            }
            let p = out.q[i * axes + a];
            let gap =
                joint.backlash.as_ref().map_or(0.0, |b| if dir > 0 { b.positive.at(p) } else { b.negative.at(p) });
            let friction = match (joint.friction.map(|f| (f.gain, f.shape)), since) {
                (Some((g, FrictionShape::Poses { exponent, poses })), Some(k)) if k <= poses && poses > 1 => {
                    g * (1.0 - (1.0 + f64::from(k - 1) / f64::from(poses - 1)).powf(exponent)).exp()
                }
                _ => 0.0,
            };
            out.q[i * axes + a] += f64::from(dir) * (gap + friction);
        }
    }
    out
}

/// Direction of the movement that arrives at each point; the first point takes that of the first movement.
fn arrivals(points: &Points) -> Vec<i8> {
    let (n, axes) = (points.len(), points.axes);
    let mut d = vec![0i8; n * axes];
    for a in 0..axes {
        for i in 1..n {
            let step = points.row(i)[a] - points.row(i - 1)[a];
            d[i * axes + a] = if step > STILL {
                1
            } else if step < -STILL {
                -1
            } else {
                d[(i - 1) * axes + a]
            };
        }
        let first = (0..n).map(|i| d[i * axes + a]).find(|v| *v != 0).unwrap_or(0);
        for i in 0..n {
            if d[i * axes + a] != 0 {
                break;
            }
            d[i * axes + a] = first;
        }
    }
    d
}
