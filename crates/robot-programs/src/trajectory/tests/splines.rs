//! New points against the plan, by an evaluation of splines that shares nothing with the writer's.

use super::*;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value as Json;

/// Half gap, rad or m.
const GAP: f64 = 3.5e-5;

/// A point of a message: time, and by joint position, velocity and acceleration.
type Knot = (f64, Vec<[f64; 3]>);

fn knots(json: &str) -> Vec<Knot> {
    let message: Json = serde_json::from_str(json).unwrap();
    let one = |p: &Json| {
        let list = |key: &str| -> Vec<f64> {
            p[key].as_array().map(|l| l.iter().map(|v| v.as_f64().unwrap()).collect()).unwrap_or_default()
        };
        let (q, v, a) = (list("positions"), list("velocities"), list("accelerations"));
        let joint = |k: usize| [q[k], v[k], a.get(k).copied().unwrap_or(f64::NAN)];
        (p["time_from_start"].as_f64().unwrap(), (0..q.len()).map(joint).collect())
    };
    message["points"].as_array().unwrap().iter().map(one).collect()
}

/// By the Bernstein form of the polynomial and de Casteljau's scheme.
fn position(knots: &[Knot], joint: usize, t: f64) -> f64 {
    let k = knots.windows(2).position(|w| t <= w[1].0).unwrap_or(knots.len() - 2);
    let (h, [p0, v0, a0], [p1, v1, a1]) = (knots[k + 1].0 - knots[k].0, knots[k].1[joint], knots[k + 1].1[joint]);
    let mut b = if a0.is_nan() {
        vec![p0, p0 + h * v0 / 3.0, p1 - h * v1 / 3.0, p1]
    } else {
        let (i, j) = (p0 + h * v0 / 5.0, p1 - h * v1 / 5.0);
        vec![p0, i, 2.0 * i - p0 + h * h * a0 / 20.0, 2.0 * j - p1 + h * h * a1 / 20.0, j, p1]
    };
    let x = (t - knots[k].0) / h;
    while b.len() > 1 {
        b = b.windows(2).map(|w| w[0] + x * (w[1] - w[0])).collect();
    }
    b[0]
}

fn plan(knots: &[Knot]) -> String {
    let of = |(t, joints): &Knot| {
        let list = |d: usize| joints.iter().map(|j| format!("{:.9}", j[d])).collect::<Vec<_>>().join(", ");
        let a = if joints[0][2].is_nan() { String::new() } else { format!("\"accelerations\": [{}], ", list(2)) };
        format!("{{\"positions\": [{}], \"velocities\": [{}], {a}\"time_from_start\": {t:.6}}}", list(0), list(1))
    };
    let points: Vec<String> = knots.iter().map(of).collect();
    format!("{{\"joint_names\": [\"J1\", \"J2\", \"X\"], \"points\": [\n{}\n]}}\n", points.join(",\n"))
}

fn random_plan(rng: &mut ChaCha8Rng, spacing_s: f64, quintic: bool) -> String {
    let mut q = [0.0; 3];
    let all: Vec<Knot> = (0..5)
        .map(|k| {
            let mut joint = |d: usize| {
                q[d] += rng.random_range(-0.4..0.4) * spacing_s;
                let ends = k == 0 || k == 4 || rng.random_bool(0.2);
                let v = if ends { 0.0 } else { rng.random_range(-0.6..0.6) };
                let a = if ends { 0.0 } else { rng.random_range(-1.0..1.0) / spacing_s };
                [q[d], v, if quintic { a } else { f64::NAN }]
            };
            (f64::from(k) * spacing_s, vec![joint(0), joint(1), joint(2)])
        })
        .collect();
    plan(&all)
}

/// What a rewrite asks for: after every turn of a joint its offset is on the other side, over a fifth of the way to the next turn.
fn compensated(text: &str) -> String {
    let d = parse(text);
    let mut side = [0.0; 3];
    let mut edits = Edits { digit: vec![1e-10; 3], ..Edits::default() };
    let mut before: Option<Vec<f64>> = None;
    for (step, m) in d.script().moves() {
        let Goal::Joints(t) = m.goal else { panic!() };
        let goal: Vec<f64> = d.script().targets.get(t).unwrap().values.iter().map(|v| v.unwrap().si).collect();
        let Some(from) = before.replace(goal.clone()) else { continue };
        let ways = m.way.iter().map(|w| (w.share, w.q.clone())).chain([(1.0, goal.clone())]);
        let (mut edit, mut start) = (Edit::default(), (0.0, from));
        for (share, q) in ways {
            let moves = |a: usize| q[a] - start.1[a];
            let turned: Vec<usize> =
                (0..3).filter(|&a| moves(a).abs() > 2.0 * GAP && moves(a) * side[a] <= 0.0).collect();
            if !turned.is_empty() {
                turned.iter().for_each(|&a| side[a] = moves(a).signum());
                let at = start.0 + 0.2 * (share - start.0);
                let own = d.on_way(step, at).unwrap();
                edit.before.push(point(&[0, 1, 2].map(|a| own[a] + GAP * side[a]), at));
            }
            let here = [0, 1, 2].map(|a| q[a] + GAP * side[a]);
            if share < 1.0 {
                edit.before.push(NewPoint { of_way: true, ..point(&here, share) });
            } else {
                edit.goal = Some(here.to_vec());
            }
            start = (share, q);
        }
        edits.steps.insert(step, edit);
    }
    edited(text, &edits)
}

/// Largest distance of the new spline from the plan outside of what its offsets at the ends of each piece span, in half gaps.
fn bent(text: &str, out: &str) -> f64 {
    let (plan, new) = (knots(text), knots(out));
    let mut most: f64 = 0.0;
    for ends in new.windows(2) {
        for joint in 0..3 {
            let off = |t: f64| position(&new, joint, t) - position(&plan, joint, t);
            let [a, b] = [off(ends[0].0), off(ends[1].0)];
            for k in 1..40 {
                let o = off(ends[0].0 + f64::from(k) / 40.0 * (ends[1].0 - ends[0].0));
                most = most.max((a.min(b) - o).max(o - a.max(b)) / GAP);
            }
        }
    }
    most
}

#[test]
fn splines_on_both_sides_of_new_points_leave_the_plan_by_the_offset_alone() {
    for quintic in [false, true] {
        for spacing_s in [0.1, 1.0] {
            let mut rng = ChaCha8Rng::seed_from_u64(7);
            for n in 0..60 {
                let text = random_plan(&mut rng, spacing_s, quintic);
                let out = compensated(&text);
                let most = bent(&text, &out);
                assert!(most < 0.05, "{n}: {most} half gaps, quintic {quintic}, {spacing_s} s\n{text}\n{out}");
            }
        }
    }
}

#[test]
fn a_new_turning_point_keeps_the_acceleration_of_its_spline() {
    // the velocity at a turn is zero but for rounding, on whichever side
    for quarter in 1..40 {
        let v = 0.1 + 0.01 * f64::from(quarter);
        let at = |t: f64, p: f64, v: f64, a: f64| (t, vec![[p, v, a], [0.0; 3], [0.0; 3]]);
        let text =
            plan(&[at(0.0, 0.0, 0.0, 0.0), at(1.0, 0.3, v, -0.2), at(2.0, 0.25, -0.3, 0.4), at(3.0, 0.0, 0.0, 0.0)]);
        let out = compensated(&text);
        assert!(bent(&text, &out) < 0.05, "{v}\n{out}");
        let new = knots(&out);
        let turning = new.iter().filter(|k| k.1[0][1].abs() < 1e-9 && k.0 > 1.0 && k.0 < 2.0).collect::<Vec<_>>();
        assert!(turning.len() == 1 && turning[0].1[0][2] < -0.1, "{v}\n{out}");
    }
}

#[test]
fn joints_that_do_not_turn_stay_on_their_spline_at_a_new_point() {
    // J2 comes from rest and goes to rest, J1 and X do not: no joint is on the chord
    let at = |t: f64, q: [f64; 3], v: [f64; 3]| (t, (0..3).map(|k| [q[k], v[k], f64::NAN]).collect());
    let text = plan(&[at(0.0, [0.0; 3], [0.3, 0.0, 0.1]), at(1.0, [0.4, -0.1, 0.2], [0.5, 0.0, 0.3])]);
    let d = parse(&text);
    let own = d.on_way(2, 0.3).unwrap();
    let out = edited(&text, &Edits { digit: vec![1e-10; 3], ..before(2, &own, 0.3) });
    let (plan, new) = (knots(&text), knots(&out));
    assert_eq!(new.len(), 3);
    for joint in 0..3 {
        let wanted = position(&plan, joint, new[1].0);
        assert!((new[1].1[joint][0] - wanted).abs() < 1e-9, "{joint}: {out}");
    }
    assert!(bent(&text, &out) * GAP < 2e-9);
    // the point stands where the joint that goes furthest has gone the share
    assert!((own[0] - 0.12).abs() < 1e-8, "{own:?}");
}

#[test]
fn those_who_follow_a_plan_get_its_splines_at_their_times() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    for quintic in [false, true] {
        let text = random_plan(&mut rng, 1.0, quintic);
        let (d, plan) = (parse(&text), knots(&text));
        let path = crate::joint_path::of_document(d.as_ref(), &robot(), None).unwrap();
        let t_s = path.t_s.unwrap();
        assert_eq!(path.goals.len(), 5);
        for (k, t) in t_s.windows(2).enumerate() {
            for joint in 0..3 {
                let middle = position(&plan, joint, f64::midpoint(t[0], t[1]));
                let chord = f64::midpoint(path.q[joint][k], path.q[joint][k + 1]);
                assert!((middle - chord).abs() < 1.5e-7, "{joint} at {t:?}");
            }
        }
    }
}

/// A plan of more points than are worth following so closely has fewer between its own.
#[test]
fn a_long_plan_is_followed_in_a_bounded_number_of_points() {
    let at = |k: u32| (f64::from(k), vec![[f64::from(k % 2), 0.0, f64::NAN]; 3]);
    let text = plan(&(0..2000).map(at).collect::<Vec<_>>());
    let points: usize = parse(&text).passed().values().map(Vec::len).sum();
    assert!((90_000..110_000).contains(&points), "{points}");
}
