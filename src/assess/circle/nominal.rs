//! The nominal circle: its frame, its last revolution, its chords and its reversals, all from the program.
//!
//! Angles on the circle are seen against the normal whose largest component is positive, and count from the next base
//! axis in cyclic order: a circle in the Y-Z plane counts from Y towards Z, one in X-Y from X towards Y. A *phase* is that
//! angle, unwrapped, with the sign of the travel, so that it rises along the program.

use super::fit::CircleFit;
use crate::effects::Track;
use crate::error::{Error, Place, Result};
use crate::program::Program;
use crate::robot::Robot;
use nalgebra::Vector3;

/// Command movement that is number noise, rad or m; as the rewriter has it.
const DEADBAND: f64 = 1e-8;

/// Parts into which a segment is cut to see its chord error.
const PARTS: usize = 20;

/// Largest distance of the program's points from their circle, as a share of its radius.
const ROUND: f64 = 0.01;

/// An arc below this does not determine its circle, deg.
const SHORTEST_ARC_DEG: f64 = 10.0;

/// Slack when revolutions are counted, deg.
const CLOSED_DEG: f64 = 0.01;

/// A reversal of the program.
#[derive(Debug, Clone, PartialEq)]
pub struct NominalReversal {
    pub axis: usize,
    /// Line of the program on which the joint turns.
    pub line: Option<u64>,
    /// Command there, rad or m, and the direction after it.
    pub command: f64,
    pub direction: i8,
    pub phase_deg: f64,
    /// Angle on the circle, 0 to 360.
    pub at_deg: f64,
}

/// The circle as the program commands it.
#[derive(Debug, Clone)]
pub struct Nominal {
    /// Circle through the commanded points.
    pub circle: CircleFit,
    /// Directions of angle 0 and 90 degrees.
    zero: Vector3<f64>,
    quarter: Vector3<f64>,
    /// +1 where the angle rises along the program, else -1.
    pub sense: f64,
    /// Angle at which the path starts, deg.
    pub start_phase_deg: f64,
    /// Travel of the whole program on the circle.
    pub travel_deg: f64,
    /// Phases that are assessed: the last revolution, or the whole arc.
    pub from_deg: f64,
    /// Phase at which the assessed part ends, deg.
    pub to_deg: f64,
    /// Error of the path itself, its chords, against its own best-fit circle.
    pub chord: Chord,
    /// Reversals of joints along the path, in their order.
    pub reversals: Vec<NominalReversal>,
}

/// Errors of the nominal path over rising phases.
#[derive(Debug, Clone, Default)]
pub struct Chord {
    pub phase_deg: Vec<f64>,
    pub in_plane_m: Vec<f64>,
    pub out_of_plane_m: Vec<f64>,
}

impl Nominal {
    /// Analyses a program; refuses one that is no circle.
    pub fn new(robot: &Robot, program: &Program) -> Result<Self> {
        let mut q = vec![0.0; robot.dof()];
        let points: Vec<Vector3<f64>> = (0..program.len())
            .map(|i| {
                program.point_into(i, &mut q);
                robot.tcp_m(&q)
            })
            .collect();
        let no_circle =
            |place: Place, found: String| Error::bad(place, found, "a program whose points lie on one circle");
        let circle = CircleFit::new(&points, &Vector3::new(1.0, 1e-3, 1e-6))
            .ok_or_else(|| no_circle(Place::file(&program.name), "points that define no circle".into()))?;
        if let Some((i, p)) =
            points.iter().enumerate().find(|(_, p)| circle.error_m(p).iter().any(|e| e.abs() > ROUND * circle.radius_m))
        {
            let [a, b] = circle.error_m(p).map(|e| e * 1e3);
            let place = program.place(i);
            let r = circle.radius_m * 1e3;
            return Err(no_circle(
                place,
                format!(
                    "a point that deviates by {a:.3} mm in plane and {b:.3} mm out of plane from the best circle (radius {r:.3} mm)"
                ),
            ));
        }
        let (zero, quarter, normal) = axes(&circle.normal);
        let circle = CircleFit { normal, ..circle };
        let mut nominal = Self {
            circle,
            zero,
            quarter,
            sense: 1.0,
            start_phase_deg: 0.0,
            travel_deg: 0.0,
            from_deg: 0.0,
            to_deg: 0.0,
            chord: Chord::default(),
            reversals: Vec::new(),
        };
        let angles = nominal.unwrapped(points.iter());
        let (first, last) = (angles[0], angles[angles.len() - 1]);
        nominal.sense = if last >= first { 1.0 } else { -1.0 };
        let phases: Vec<f64> = angles.iter().map(|a| a * nominal.sense).collect();
        nominal.start_phase_deg = phases[0];
        nominal.travel_deg = (last - first).abs();
        nominal.to_deg = phases[phases.len() - 1];
        if nominal.travel_deg < SHORTEST_ARC_DEG {
            let found = format!("an arc of {:.2} deg (radius {:.3} mm)", nominal.travel_deg, circle.radius_m * 1e3);
            return Err(Error::bad(
                Place::file(&program.name),
                found,
                format!("a circle, or an arc of at least {SHORTEST_ARC_DEG} deg"),
            ));
        }
        nominal.from_deg = if nominal.closed() { nominal.to_deg - 360.0 } else { nominal.start_phase_deg };
        nominal.chord = nominal.chords(robot, program, &phases)?;
        nominal.reversals = nominal.find_reversals(program, &phases);
        Ok(nominal)
    }

    /// Angle of a point on the circle, -180 to 180 degrees.
    pub fn angle_deg(&self, p: &Vector3<f64>) -> f64 {
        let from = p - self.circle.centre_m;
        from.dot(&self.quarter).atan2(from.dot(&self.zero)).to_degrees()
    }

    /// Angles of consecutive points without jumps.
    fn unwrapped<'a>(&self, points: impl Iterator<Item = &'a Vector3<f64>>) -> Vec<f64> {
        let mut before: Option<f64> = None;
        points
            .map(|p| {
                let a = self.angle_deg(p);
                let a = before.map_or(a, |b| a - 360.0 * ((a - b) / 360.0).round());
                before = Some(a);
                a
            })
            .collect()
    }

    /// Phases of a log's commanded points; the first lies within half a turn of the program's start.
    pub fn phases_deg(&self, points: &[Vector3<f64>]) -> Vec<f64> {
        let mut phases = self.unwrapped(points.iter());
        let Some(&first) = phases.first() else { return phases };
        let shift = 360.0 * ((first * self.sense - self.start_phase_deg) / 360.0).round();
        for p in &mut phases {
            *p = *p * self.sense - shift;
        }
        phases
    }

    /// The program runs at least once around.
    pub fn closed(&self) -> bool {
        self.travel_deg >= 360.0 - CLOSED_DEG
    }

    /// Revolutions of the program.
    pub fn revolutions(&self) -> f64 {
        self.travel_deg / 360.0
    }

    fn chords(&self, robot: &Robot, program: &Program, phases: &[f64]) -> Result<Chord> {
        let mut points = Vec::new();
        let (mut a, mut b) = (vec![0.0; robot.dof()], vec![0.0; robot.dof()]);
        for i in 0..program.len() - 1 {
            // a segment belongs to the revolution in which its middle lies
            let middle = 0.5 * (phases[i] + phases[i + 1]);
            if middle < self.from_deg || middle > self.to_deg {
                continue;
            }
            program.point_into(i, &mut a);
            program.point_into(i + 1, &mut b);
            for k in 0..PARTS {
                let f = k as f64 / PARTS as f64;
                let q: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a + f * (b - a)).collect();
                points.push(robot.tcp_m(&q));
            }
        }
        let fit = CircleFit::new(&points, &self.circle.normal).ok_or_else(|| {
            Error::bad(Place::file(&program.name), "a last revolution without a circle", "a program along a circle")
        })?;
        let mut phase_deg: Vec<f64> = self.unwrapped(points.iter()).iter().map(|a| a * self.sense).collect();
        let shift = phase_deg.first().map_or(0.0, |p| 360.0 * ((p - self.from_deg) / 360.0).round());
        let mut top = f64::NEG_INFINITY;
        for p in &mut phase_deg {
            // a path that turns back for a moment keeps its place, so that phases never fall
            top = top.max(*p - shift);
            *p = top;
        }
        let (in_plane_m, out_of_plane_m) = points.iter().map(|p| fit.error_m(p)).map(|[a, b]| (a, b)).unzip();
        Ok(Chord { phase_deg, in_plane_m, out_of_plane_m })
    }

    fn find_reversals(&self, program: &Program, phases: &[f64]) -> Vec<NominalReversal> {
        let index: Vec<f64> = (0..program.len()).map(|i| i as f64).collect();
        let mut found = Vec::new();
        for (axis, q) in program.q.iter().enumerate() {
            for turn in Track::new(&index, q, DEADBAND).turns.iter() {
                let phase = phases[turn.index];
                if phase >= self.from_deg - 1e-6 && phase <= self.to_deg {
                    found.push(NominalReversal {
                        axis,
                        line: program.line(turn.index),
                        command: turn.p,
                        direction: turn.dir,
                        phase_deg: phase,
                        at_deg: (phase * self.sense).rem_euclid(360.0),
                    });
                }
            }
        }
        found
    }
}

impl Chord {
    /// In-plane and out-of-plane error at a phase, linear between points, constant beyond them.
    pub fn at(&self, phase_deg: f64) -> [f64; 2] {
        let n = self.phase_deg.len();
        if n == 0 {
            return [0.0; 2];
        }
        let i = self.phase_deg.partition_point(|&p| p <= phase_deg);
        if i == 0 || i == n {
            let k = if i == 0 { 0 } else { n - 1 };
            return [self.in_plane_m[k], self.out_of_plane_m[k]];
        }
        let (p0, p1) = (self.phase_deg[i - 1], self.phase_deg[i]);
        let f = (phase_deg - p0) / (p1 - p0);
        [&self.in_plane_m, &self.out_of_plane_m].map(|e| e[i - 1] + f * (e[i] - e[i - 1]))
    }
}

/// Directions of 0 and 90 degrees, and the normal turned so that its largest component is positive.
fn axes(normal: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>, Vector3<f64>) {
    let largest = normal.iamax();
    let n = *normal * normal[largest].signum();
    let mut next = Vector3::zeros();
    next[(largest + 1) % 3] = 1.0;
    let zero = (next - n * n.dot(&next)).normalize();
    (zero, n.cross(&zero), n)
}
