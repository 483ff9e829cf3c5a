//! A static test as legs from rest to rest, for languages whose controllers plan the motion between targets themselves.
//!
//! Method: a leg ends where the joints stand still, where one of them turns, and where another one begins or ends to move. Its time is
//! that of the plan, in which it keeps half of the joints' speeds and accelerations.

/// Joints move by less than this between two rows: they rest. rad or m.
const RESTS: f64 = 1e-9;

/// One leg.
#[derive(Debug, Clone, PartialEq)]
pub struct Leg {
    /// Where it ends, rad or m.
    pub to: Vec<f64>,
    /// How long it takes, s. 0: the place from which the program starts.
    pub time_s: f64,
    /// Largest speed of each axis on the way, rad/s or m/s.
    pub speed: Vec<f64>,
    /// How long the robot stands at its end, s.
    pub stand_s: f64,
}

/// The legs of rows (times in s, joints in rad or m) that are straight from rest to rest. The first is the place of the start.
pub fn legs(rows: &[(f64, Vec<f64>)]) -> Vec<Leg> {
    let mut out: Vec<Leg> = Vec::new();
    let Some((_, first)) = rows.first() else { return out };
    let still = vec![0.0; first.len()];
    out.push(Leg { to: first.clone(), time_s: 0.0, speed: still.clone(), stand_s: 0.0 });
    let mut senses: Vec<i8> = vec![0; first.len()];
    for pair in rows.windows(2) {
        let [(from_s, from), (to_s, to)] = pair else { continue };
        let time_s = to_s - from_s;
        let steps = || to.iter().zip(from).map(|(b, a)| b - a);
        let now: Vec<i8> = steps().map(|d| if d.abs() < RESTS { 0 } else { d.signum() as i8 }).collect();
        let Some(last) = out.last_mut() else { continue };
        if now.iter().all(|s| *s == 0) {
            last.stand_s += time_s;
            continue;
        }
        if out.len() == 1 || now != senses || out.last().is_some_and(|l| l.stand_s > 0.0) {
            out.push(Leg { to: to.clone(), time_s: 0.0, speed: still.clone(), stand_s: 0.0 });
            senses = now;
        }
        let Some(leg) = out.last_mut() else { continue };
        leg.to.clone_from(to);
        leg.time_s += time_s;
        leg.speed.iter_mut().zip(steps()).for_each(|(v, d)| *v = v.max(d.abs() / time_s));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_leg_ends_at_rest_at_a_turn_and_where_another_joint_moves() {
        let rows: Vec<(f64, Vec<f64>)> = [
            (0.0, [0.0, 0.0]),
            (1.0, [0.1, 0.0]),
            (2.0, [0.4, 0.0]),
            (5.0, [0.4, 0.0]),
            (6.0, [0.5, 0.0]),
            (7.0, [0.2, 0.0]),
            (9.0, [0.2, -0.2]),
        ]
        .map(|(t, q)| (t, q.to_vec()))
        .to_vec();
        let found = legs(&rows);
        let ends: Vec<(f64, f64, f64, f64)> = found.iter().map(|l| (l.to[0], l.to[1], l.time_s, l.stand_s)).collect();
        let expected = [
            (0.0, 0.0, 0.0, 0.0),
            (0.4, 0.0, 2.0, 3.0),
            (0.5, 0.0, 1.0, 0.0),
            (0.2, 0.0, 1.0, 0.0),
            (0.2, -0.2, 2.0, 0.0),
        ];
        assert_eq!(ends, expected);
        assert!((found[1].speed[0] - 0.3).abs() < 1e-12 && (found[4].speed[1] - 0.1).abs() < 1e-12);
    }
}
