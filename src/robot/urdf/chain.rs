//! The chain of a URDF as a robot, and how far the two are apart.

use super::{Element, Inertia};
use crate::robot::{Convention, Follow, Joint, JointKind, Link, Robot, dh};
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;

/// Motion of a joint.
fn motion(e: &Element, q: f64) -> Isometry3<f64> {
    match e.kind {
        None => Isometry3::identity(),
        Some(JointKind::Revolute) => {
            Isometry3::from_parts(Translation3::identity(), UnitQuaternion::from_axis_angle(&e.axis, q))
        }
        Some(JointKind::Prismatic) => {
            Isometry3::from_parts(Translation3::from(e.axis.into_inner() * q), UnitQuaternion::identity())
        }
    }
}

/// Position of a joint of the chain where the driving joints stand at `q` (one per moving joint without mimic).
fn positions(chain: &[Element], q: &[f64]) -> Vec<f64> {
    let mut drivers = q.iter();
    let own: Vec<Option<f64>> = chain
        .iter()
        .map(|e| if e.kind.is_some() && e.mimic.is_none() { drivers.next().copied() } else { None })
        .collect();
    let of = |name: &str| chain.iter().position(|e| e.name == name).and_then(|k| own[k]).unwrap_or(0.0);
    (chain.iter().zip(&own))
        .map(|(e, own)| match &e.mimic {
            Some((driver, ratio, offset)) => ratio * of(driver) + offset,
            None => own.unwrap_or(0.0),
        })
        .collect()
}

/// The URDF's own chain.
fn forward(chain: &[Element], q: &[f64]) -> Isometry3<f64> {
    chain.iter().zip(positions(chain, q)).fold(Isometry3::identity(), |t, (e, q)| t * e.origin * motion(e, q))
}

/// A joint follows one that it cannot follow here.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub(super) enum Mimics {
    /// One that does not stand on the chain.
    #[error("joint `{joint}` mimics `{driver}`, which is not on the chain")]
    Elsewhere {
        /// Name of the joint.
        joint: String,
        /// Name of the joint that it follows.
        driver: String,
    },
    /// A sliding joint follows a turning one, or the other way about: a robot file has no ratio in mm per degree.
    #[error("joint `{joint}` mimics `{driver}`, and only one of them turns")]
    OtherKind {
        /// Name of the joint.
        joint: String,
        /// Name of the joint that it follows.
        driver: String,
    },
}

impl Mimics {
    /// What the chain must be like instead.
    pub fn expected(&self) -> &'static str {
        match self {
            Self::Elsewhere { .. } => "a chain of revolute and prismatic joints",
            Self::OtherKind { .. } => {
                "a mimic joint of the same kind as the joint that it follows: a robot file has no others; a tip before it leaves it out"
            }
        }
    }
}

/// The robot of a chain whose link `flange` is the flange, in the world that stands at `world` in the root link.
pub(super) fn build(
    title: &str,
    chain: &[Element],
    masses: &[Option<Inertia>],
    flange: &str,
    world: &Isometry3<f64>,
) -> Result<Robot, Mimics> {
    let moving: Vec<usize> = (0..chain.len()).filter(|&k| chain[k].kind.is_some()).collect();
    // frames at the zero configuration: before each joint's motion (its axis), and after it (its link)
    let at_zero = positions(chain, &vec![0.0; moving.len()]);
    let (mut lines, mut links, mut t) = (Vec::new(), Vec::new(), Isometry3::identity());
    for (e, q) in chain.iter().zip(at_zero) {
        t *= e.origin;
        if e.kind.is_some() {
            lines.push(dh::Line { point: t.translation.vector, direction: t.rotation * e.axis });
        }
        t *= motion(e, q);
        links.push(t);
    }
    let flange = chain.iter().position(|e| e.child == flange).and_then(|k| links.get(k)).unwrap_or(&t);
    let table = dh::of_lines(&lines, flange);
    let mut joints = Vec::with_capacity(moving.len());
    for (row, &k) in table.rows.iter().zip(&moving) {
        let e = &chain[k];
        joints.push(Joint {
            name: e.name.clone(),
            kind: e.kind.unwrap_or(JointKind::Revolute),
            theta_rad: row.theta_rad,
            d_m: without_rounding(row.d_m),
            a_m: without_rounding(row.a_m),
            alpha_rad: row.alpha_rad,
            beta_rad: 0.0,
            direction: 1.0,
            limits: e.limits,
            max_speed: e.max_speed,
            max_accel: None,
            lead_m_per_rev: None,
            pulses: None,
            follows: follows(chain, &moving, e)?,
        });
    }
    let (mut base, tool) = (world.inverse() * table.base, flange.inverse() * t);
    turn_into_first(&mut base, &mut joints);
    let mut robot = Robot::new(title.to_string(), Convention::Standard, joints, base, tool).with_flange(table.tool);
    robot.links = link_masses(chain, &moving, &links, masses, &table.frames);
    Ok(robot)
}

/// Which of the moving joints an element follows, if any.
fn follows(chain: &[Element], moving: &[usize], e: &Element) -> Result<Option<Follow>, Mimics> {
    let Some((driver, ratio, _)) = &e.mimic else { return Ok(None) };
    let names = || (e.name.clone(), driver.clone());
    let Some(joint) = moving.iter().position(|&m| chain[m].name == *driver && chain[m].mimic.is_none()) else {
        let (joint, driver) = names();
        return Err(Mimics::Elsewhere { joint, driver });
    };
    if chain[moving[joint]].kind != e.kind {
        let (joint, driver) = names();
        return Err(Mimics::OtherKind { joint, driver });
    }
    Ok(Some(Follow { joint, ratio: *ratio }))
}

/// A base that is only turned about the first axis stands still, and the first joint starts from there: controllers that count poses from
/// the arm's base and those that count them from a world mean the same then.
fn turn_into_first(base: &mut Isometry3<f64>, joints: &mut [Joint]) {
    let Some(first) = joints.first_mut().filter(|j| j.kind == JointKind::Revolute) else { return };
    let z = base.rotation * Vector3::z();
    if (z - Vector3::z()).norm() < 1e-12 {
        let x = base.rotation * Vector3::x();
        // half a turn has two names: the positive one
        let turn = x.y.atan2(x.x);
        first.theta_rad += if turn < 1e-12 - PI { -turn } else { turn };
        base.rotation = UnitQuaternion::identity();
    }
}

/// A length without what rounding left of it: 0.61 m, not 0.6099999999999999.
fn without_rounding(m: f64) -> f64 {
    (m * 1e12).round() / 1e12 + 0.0
}

/// Mass and centre of mass of what moves with each joint, in the joint's link frame: zero where no mass is given, and none where
/// no link has one.
fn link_masses(
    chain: &[Element],
    moving: &[usize],
    links: &[Isometry3<f64>],
    masses: &[Option<Inertia>],
    frames: &[Isometry3<f64>],
) -> Vec<Link> {
    let mut out = Vec::with_capacity(moving.len());
    for (i, &k) in moving.iter().enumerate() {
        let last = moving.get(i + 1).copied().unwrap_or(chain.len());
        let (mut mass_kg, mut moment) = (0.0, Vector3::zeros());
        for m in k..last {
            if let Some((kg, com)) = masses[m] {
                mass_kg += kg;
                moment += (links[m] * Point3::from(com)).coords * kg;
            }
        }
        if mass_kg <= 0.0 {
            out.push(Link { mass_kg: 0.0, com_m: Vector3::zeros() });
            continue;
        }
        let com_m = frames[i].inverse_transform_point(&Point3::from(moment / mass_kg)).coords;
        out.push(Link { mass_kg, com_m: com_m.map(without_rounding) });
    }
    let any = out.iter().any(|l| l.mass_kg > 0.0);
    if any { out } else { Vec::new() }
}

/// Largest distance and angle between the two chains at positions within the limits, of a fixed sequence.
pub(super) fn compare(robot: &Robot, chain: &[Element], world: &Isometry3<f64>) -> (f64, f64) {
    const POSITIONS: usize = 200;
    // mobile bases have limits of kilometres, where rounding alone is larger than any error
    const FAR_M: f64 = 10.0;
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (mut distance_m, mut angle_rad) = (0.0f64, 0.0f64);
    for _ in 0..POSITIONS {
        let q: Vec<f64> = robot
            .axis_joints()
            .map(|j| {
                let far = if j.kind == JointKind::Revolute { PI } else { FAR_M };
                let [lo, hi] = j.limits.map_or([-far, far], |[lo, hi]| [lo.max(-far), hi.min(far)]);
                let [lo, hi] = if lo < hi { [lo, hi] } else { [-far, far] };
                rng.random_range(lo..hi)
            })
            .collect();
        let (theirs, ours) = (world.inverse() * forward(chain, &q), robot.forward(&q));
        distance_m = distance_m.max((ours.position - theirs.translation.vector).norm());
        let rotation = theirs.rotation.to_rotation_matrix();
        angle_rad = angle_rad.max((rotation.matrix() - ours.rotation.matrix()).norm());
    }
    (distance_m, angle_rad)
}
