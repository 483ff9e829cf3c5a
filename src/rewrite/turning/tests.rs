//! Where a machine with the TCP at (X, Y, Z) turns; extremes by hand.

use super::*;
use crate::compensator::{BacklashOffset, JointCompensator};
use crate::effects::GapCurve;

fn machine() -> Robot {
    let yaml = "schema: lostmotion/robot/1\nname: m\nconvention: dh-standard\njoints:\n\
         - {name: X, kind: prismatic, theta_deg: 0, d_mm: 0, a_mm: 0, alpha_deg: 90, direction: 1, limits_mm: [-100000, 50]}\n\
         - {name: Y, kind: prismatic, theta_deg: 90, d_mm: 0, a_mm: 0, alpha_deg: 90, direction: 1}\n\
         - {name: Z, kind: prismatic, theta_deg: 0, d_mm: 0, a_mm: 0, alpha_deg: 0, direction: 1}\n";
    Robot::parse("m.yaml", yaml).unwrap()
}

/// A point that was handed on: joints, time, place, axes that turn with their directions, and where the given path stands.
#[derive(Debug, Clone, PartialEq)]
struct Handed {
    q: Vec<f64>,
    t_s: f64,
    origin: Origin,
    turns: Vec<(usize, i8)>,
    given: Option<Vec<f64>>,
}

/// How points come in.
struct Way<'a> {
    initial: [i8; 3],
    deadband: f64,
    cubic: bool,
    times: Option<&'a [f64]>,
    /// Points that come in together; 0: one by one.
    block: usize,
}

const PLAIN: Way = Way { initial: [0; 3], deadband: 0.0, cubic: false, times: None, block: 0 };

/// Takes points through; axes X and Y are compensated. The first number: points that were handed on before the end.
fn through(way: &Way, rows: &[[f64; 3]]) -> (usize, Vec<Handed>) {
    let robot = machine();
    let gap = GapCurve::Constant(1e-5);
    let backlash = Some(BacklashOffset { positive: gap.clone(), negative: gap });
    let offset = |axis| Some(Offset::new(&JointCompensator { axis, backlash: backlash.clone(), friction: None }));
    let offsets = [offset(0), offset(1), None];
    let mut turning = Turning::new(&robot, &offsets, &[way.deadband; 3], &way.initial, way.cubic);
    let mut path = Path::new(3);
    let time = |i: usize| way.times.map_or(0.0, |t| t[i]);
    if way.block == 0 {
        for (i, row) in rows.iter().enumerate() {
            turning.push(row, time(i), way.times.is_some(), Origin::Point(i as u64));
            turning.hand_on(&mut path, false);
        }
    } else {
        for (k, block) in rows.chunks(way.block).enumerate() {
            let first = k * way.block;
            let times: Vec<f64> = way.times.map_or(Vec::new(), |t| t[first..first + block.len()].to_vec());
            turning.extend(block.as_flattened(), &times, first as u64);
            turning.hand_on(&mut path, false);
        }
    }
    let before = path.end();
    turning.hand_on(&mut path, true);
    let one = |k: usize| Handed {
        q: path.q(k).to_vec(),
        t_s: path.t_s(k),
        origin: path.origin(k),
        turns: (0..3).filter_map(|axis| Some((axis, path.turns(k).of(axis)?))).collect(),
        given: path.given(k).map(<[f64]>::to_vec),
    };
    (before, (0..path.end()).map(one).collect())
}

/// Places and directions of turns.
fn turns(handed: &[Handed]) -> Vec<(usize, usize, i8)> {
    handed.iter().enumerate().flat_map(|(k, h)| h.turns.iter().map(move |&(axis, dir)| (k, axis, dir))).collect()
}

fn along_x(x: &[f64]) -> Vec<[f64; 3]> {
    x.iter().map(|&x| [x, 0.0, 0.0]).collect()
}

#[test]
fn a_turn_stands_at_the_last_point_of_its_extreme_and_starts_count_as_turns() {
    let rows = along_x(&[0.0, 0.0, 1.0, 2.0, 2.0, 1.0, 0.0, 0.5]);
    let (_, handed) = through(&PLAIN, &rows);
    assert_eq!(turns(&handed), [(1, 0, 1), (4, 0, -1), (6, 0, 1)]);
    assert_eq!(handed.iter().map(|h| h.q[0]).collect::<Vec<_>>(), [0.0, 0.0, 1.0, 2.0, 2.0, 1.0, 0.0, 0.5]);
    // a known direction: only a movement against it turns
    let (_, handed) = through(&Way { initial: [1, 0, 0], ..PLAIN }, &rows);
    assert_eq!(turns(&handed), [(4, 0, -1), (6, 0, 1)]);
    let (_, handed) = through(&Way { initial: [-1, 0, 0], ..PLAIN }, &rows);
    assert_eq!(turns(&handed), [(1, 0, 1), (4, 0, -1), (6, 0, 1)]);
    // noise within the dead band is none
    let noisy = along_x(&[0.0, 1.0, 0.999, 1.0, 2.0, 1.0]);
    assert_eq!(turns(&through(&Way { deadband: 0.01, ..PLAIN }, &noisy).1), [(0, 0, 1), (4, 0, -1)]);
    // an axis without an offset may turn as it likes
    let z: Vec<[f64; 3]> = [0.0, 1.0, 0.0, 1.0].iter().map(|&z| [0.0, 0.0, z]).collect();
    assert_eq!(turns(&through(&PLAIN, &z).1), []);
}

#[test]
fn a_joint_whose_turn_stays_at_its_point_does_not_go_beyond_it_at_the_extreme_of_another() {
    // both turn between the rows 4 and 5; only Y is smooth enough there for its own extreme
    let x = [39.3183, 32.3902, 32.7295, 40.0122, 47.2832, 47.5987, 40.6575, 33.0883, 32.1198];
    let y = [32.1993, 32.0347, 36.5360, 43.0665, 47.8007, 47.9653, 43.4640, 36.9335, 32.1993];
    let rows: Vec<[f64; 3]> = x.iter().zip(y).map(|(&x, y)| [x * 1e-3, y * 1e-3, 0.0]).collect();
    let times: Vec<f64> = (0..rows.len()).map(|i| i as f64 * 2.5).collect();
    let (_, handed) = through(&Way { cubic: true, times: Some(&times), ..PLAIN }, &rows);
    assert!(handed.iter().any(|h| h.origin != Origin::Point(h.origin.point()) && h.turns == [(1, -1)]), "{handed:?}");
    for axis in 0..2 {
        // between two turns the joint only goes on
        let mut dir = 0;
        for w in handed.windows(2) {
            dir = w[0].turns.iter().find(|t| t.0 == axis).map_or(dir, |t| t.1);
            assert!(f64::from(dir) * (w[1].q[axis] - w[0].q[axis]) >= 0.0, "axis {axis}: {:?} -> {:?}", w[0].q, w[1].q);
        }
    }
}

#[test]
fn points_are_handed_on_when_their_turns_are_known_and_all_of_them_at_the_end() {
    // a joint that moves on: two points are held back
    let on = along_x(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    let y: Vec<[f64; 3]> = on.iter().map(|r| [r[0], r[0], 0.0]).collect();
    assert_eq!(through(&PLAIN, &y).0, 4);
    // a joint that has not left its extreme holds back all from there on
    let back: Vec<[f64; 3]> =
        y.iter().enumerate().map(|(k, r)| [r[0], if k < 2 { r[1] } else { 0.9999 }, 0.0]).collect();
    let (before, handed) = through(&Way { deadband: 0.01, ..PLAIN }, &back);
    assert_eq!((before, handed.len()), (1, 6));
}

#[test]
fn a_pause_with_noise_that_does_not_end_is_settled_at_its_latest_point() {
    let mut rows = vec![[0.0, 0.0, 0.0], [1.0, 1.0, 0.0]];
    rows.extend((0..5000).map(|k| [1.0 - 1e-4 * f64::from(k % 2 + 1), 2.0 + f64::from(k), 0.0]));
    rows.push([0.0, 9999.0, 0.0]);
    let (_, handed) = through(&Way { deadband: 0.01, ..PLAIN }, &rows);
    let of_x: Vec<_> = turns(&handed).into_iter().filter(|t| t.1 == 0).collect();
    // point 4098 is the first that lies more than 4096 points after the extreme at point 1
    assert_eq!(of_x, [(0, 0, 1), (4097, 0, -1)]);
    assert_eq!(handed.len(), rows.len());
}

#[test]
fn where_the_given_path_stands_stays_with_its_point() {
    let robot = machine();
    let gap = GapCurve::Constant(1e-5);
    let backlash = Some(BacklashOffset { positive: gap.clone(), negative: gap });
    let offsets = [Some(Offset::new(&JointCompensator { axis: 0, backlash, friction: None })), None, None];
    let mut turning = Turning::new(&robot, &offsets, &[0.0; 3], &[0; 3], false);
    let mut path = Path::new(3);
    // up and down every three points, so that points come alone and in runs
    let x = |i: usize| [0.0, 1.0, 2.0, 3.0, 2.0, 1.0][i % 6];
    let given = |i: usize| (i % 2 == 1).then(|| vec![i as f64; 3]);
    for i in 0..40 {
        turning.push(&[x(i), 0.0, 0.0], 0.0, false, Origin::Point(i as u64));
        given(i).into_iter().for_each(|at| turning.set_given(at));
        turning.hand_on(&mut path, false);
    }
    turning.hand_on(&mut path, true);
    assert_eq!(path.end(), 40);
    for i in 0..40 {
        assert_eq!(path.given(i).map(<[f64]>::to_vec), given(i), "{i}");
    }
}

#[test]
fn blocks_of_any_size_turn_as_points_one_by_one() {
    // numbers that go on for long and turn at odd places, by their own generator
    let (mut seed, mut rows, mut at, mut up) = (7u64, Vec::new(), [0.0f64; 3], [1.0f64, -1.0, 1.0]);
    let mut random = || {
        seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (seed >> 33) as f64 / f64::from(1u32 << 31)
    };
    for _ in 0..3000 {
        for axis in 0..3 {
            up[axis] = if random() < 0.03 { -up[axis] } else { up[axis] };
            at[axis] += if random() < 0.1 { 0.0 } else { up[axis] * random() };
        }
        rows.push(at);
    }
    let times: Vec<f64> = (0..rows.len()).map(|i| i as f64).collect();
    for (times, cubic) in [(None, false), (Some(&times[..]), true)] {
        let of = |block| through(&Way { block, times, cubic, deadband: 0.05, ..PLAIN }, &rows).1;
        let one_by_one = of(0);
        assert!(turns(&one_by_one).len() > 80 && turns(&one_by_one).iter().all(|t| t.1 < 2));
        for block in [1, 7, 8, 9, 64, 3000] {
            assert_eq!(of(block), one_by_one, "{block}");
        }
    }
}

/// X on a parabola with its top at `top`, Y and Z along; times 0, 1, 2, ...
fn parabola(top: f64, n: usize) -> (Vec<[f64; 3]>, Vec<f64>) {
    let row = |i: usize| [-0.001 * (i as f64 - top).powi(2), 0.1 * i as f64, 0.01 * (i as f64).powi(2)];
    ((0..n).map(row).collect(), (0..n).map(|i| i as f64).collect())
}

/// The points that were put in.
fn inserted(handed: &[Handed]) -> Vec<&Handed> {
    handed.iter().filter(|h| matches!(h.origin, Origin::Inserted { .. })).collect()
}

#[test]
fn the_extreme_of_a_parabola_is_put_in_with_all_joints_on_their_curves() {
    for (top, leg, n) in [(3.3, 3, 8), (2.8, 2, 8), (3.03, 3, 8), (3.97, 3, 8), (5.3, 5, 9), (6.8, 6, 10)] {
        let (rows, steps) = parabola(top, n);
        let times: Vec<f64> = steps.iter().map(|t| 0.25 * t).collect();
        let (_, handed) = through(&Way { cubic: true, times: Some(&times), ..PLAIN }, &rows);
        let found = inserted(&handed);
        assert_eq!(found.len(), 1, "{top}");
        let (new, share) = (found[0], top - leg as f64);
        assert!(
            matches!(new.origin, Origin::Inserted { after, fraction } if after == leg && (fraction - share).abs() < 1e-9)
        );
        let want = [0.0, 0.1 * top, 0.01 * top * top];
        assert!(new.q.iter().zip(want).all(|(q, w)| (q - w).abs() < 1e-12), "{:?}", new.q);
        assert!((new.t_s - 0.25 * top).abs() < 1e-9);
        // the given path goes straight
        let (a, b) = (rows[leg as usize], rows[leg as usize + 1]);
        let straight = a.iter().zip(b).map(|(a, b)| a + share * (b - a));
        assert!(new.given.as_ref().unwrap().iter().zip(straight).all(|(g, s)| (g - s).abs() < 1e-12));
        assert_eq!(turns(&handed), [(0, 0, 1), (0, 1, 1), (leg as usize + 1, 0, -1)]);
        assert_eq!(handed.len(), n + 1);
    }
}

#[test]
fn a_block_whose_first_point_alone_goes_back_turns_twice() {
    // eight rows at a time: up to 7, back to 6.5, and up again
    let x: Vec<f64> = (0..8).map(f64::from).chain((0..8).map(|k| 6.5 + f64::from(k))).collect();
    let rows: Vec<[f64; 3]> = x.iter().enumerate().map(|(k, x)| [*x, k as f64, 0.0]).collect();
    for block in [8, 16] {
        let (_, handed) = through(&Way { block, deadband: 0.05, ..PLAIN }, &rows);
        assert_eq!(turns(&handed), [(0, 0, 1), (0, 1, 1), (7, 0, -1), (8, 0, 1)], "{block}");
    }
}

#[test]
fn an_extreme_at_a_point_near_an_end_or_beyond_a_limit_is_the_point_itself() {
    // within two hundredths of a leg
    for (top, n) in [(3.01, 8), (2.99, 8), (3.0, 8), (1.3, 8), (5.7, 8), (3.3, 5)] {
        let (rows, times) = parabola(top, n);
        let (_, handed) = through(&Way { cubic: true, times: Some(&times), ..PLAIN }, &rows);
        let r = top.round() as usize;
        assert_eq!((handed.len(), turns(&handed).last()), (n, Some(&(r, 0, -1))), "{top}");
    }
    // X may go to 50 mm: its points stay below, the top between them does not
    for (height, count) in [(0.0499, 1), (0.0501, 0)] {
        let (mut rows, times) = parabola(3.4, 8);
        rows.iter_mut().for_each(|r| r[0] += height);
        assert_eq!(inserted(&through(&Way { cubic: true, times: Some(&times), ..PLAIN }, &rows).1).len(), count);
    }
    // without times and along the TCP's way it is put in, too; where straight lines are asked for, or points coincide, it is not
    let (rows, _) = parabola(3.3, 8);
    let even: Vec<[f64; 3]> = rows.iter().map(|r| [r[0], r[1], 0.0]).collect();
    let found = through(&Way { cubic: true, ..PLAIN }, &even).1;
    assert!((inserted(&found)[0].q[1] - 0.33).abs() < 1e-4 && inserted(&found)[0].q[0].abs() < 1e-5);
    assert!(inserted(&through(&PLAIN, &even).1).is_empty());
    let pause: Vec<[f64; 3]> = even[..4].iter().chain(&even[3..]).copied().collect();
    assert!(inserted(&through(&Way { cubic: true, ..PLAIN }, &pause).1).is_empty());
}

#[test]
fn steps_that_differ_too_much_and_corners_are_not_smooth() {
    let of = |times: &[f64]| {
        let rows: Vec<[f64; 3]> = times.iter().map(|t| [-0.001 * (t - 3.3).powi(2), 0.1 * t, 0.0]).collect();
        inserted(&through(&Way { cubic: true, times: Some(times), ..PLAIN }, &rows).1).len()
    };
    assert_eq!(of(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), 1);
    assert_eq!(of(&[0.0, 1.0, 2.0, 3.0, 4.0, 4.334, 6.0]), 1);
    assert_eq!(of(&[0.0, 1.0, 2.0, 3.0, 4.0, 4.332, 6.0]), 0);
    // second differences agree within a factor of four: three points of a parabola, and a bend further out
    let bent = |bend: f64| {
        let (mut rows, times) = parabola(3.3, 8);
        // of -0.002 at each point; at point 4 (1 + bend) times as much
        rows[5][0] -= 0.002 * bend;
        inserted(&through(&Way { cubic: true, times: Some(&times), ..PLAIN }, &rows).1).len()
    };
    assert_eq!([bent(0.0), bent(-0.74), bent(-0.76), bent(9.0)], [1, 1, 0, 1]);
}
