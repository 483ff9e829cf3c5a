//! What is estimated beside the effects: frames, places of the further reflectors, how a probe sits on the tool, zeros of joint sensors,
//! own quantities of ballbars and dials.

use crate::diagnose::problem::forward::{Hypothesis, Problem, State};
use crate::diagnose::problem::layout::Sensor;
use crate::diagnose::problem::orientation;
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

impl Problem {
    /// Sensitivities of all nuisance: frames, places of the further reflectors, zeros of joint sensors, own quantities of ballbars and
    /// dials.
    pub fn nuisance_columns(&self, h: &Hypothesis, state: &State) -> Vec<Vec<f64>> {
        let mut columns = Vec::new();
        if self.frames_free {
            for f in 0..h.frames.len() {
                columns.extend(self.frame_columns(state, f));
            }
        }
        if self.is_turned() {
            columns.extend((0..3).map(|k| self.probe_column(k)));
        } else if self.points_free {
            for k in 0..h.points_m.len() {
                columns.extend((0..3).map(|c| self.point_column(state, k, c)));
            }
        }
        for g in &self.groups {
            for k in 0..self.unknowns(g) {
                let mut out = vec![0.0; self.n];
                match (&self.logs[g.log].reading, g.sensor) {
                    (Some(reading), Sensor::Reading) => g.add_numbers(&mut out, |r| reading.own(k, r)),
                    _ => g.add_numbers(&mut out, |_| 1.0),
                }
                columns.push(out);
            }
        }
        columns
    }

    /// Sensitivity to a turn of the probe on the tool about one of its axes.
    fn probe_column(&self, k: usize) -> Vec<f64> {
        let mut out = vec![0.0; self.n];
        for g in self.groups.iter().filter(|g| g.sensor == Sensor::Orientation) {
            if let Some(turned) = &self.logs[g.log].orientation {
                g.add_points(&mut out, |r| turned.own(k, r));
            }
        }
        out
    }

    /// Sensitivity to a coordinate of a further reflector in the flange.
    fn point_column(&self, state: &State, k: usize, c: usize) -> Vec<f64> {
        let mut out = vec![0.0; self.n];
        let place = state.geometry.reflectors_m[k];
        let (here, there) = (state.geometry.chain_to(&place), state.geometry.chain_to(&(place + Vector3::ith(c, 1.0))));
        for g in self.groups.iter().filter(|g| g.sensor == Sensor::Reflector(k + 1)) {
            let joint = &state.logs[g.log].joint;
            g.add_points(&mut out, |r| {
                let q: Vec<f64> = joint.iter().map(|j| j[r]).collect();
                there.position(&q) - here.position(&q)
            });
        }
        out
    }

    /// Sensitivities of a frame's three translations (m) and three rotations (rad), in the base frame.
    pub(in crate::diagnose) fn frame_columns(&self, state: &State, frame: usize) -> Vec<Vec<f64>> {
        (0..6)
            .map(|k| {
                let mut out = vec![0.0; self.n];
                let e = Vector3::ith(k % 3, 1.0);
                for g in &self.groups {
                    if self.logs[g.log].frame != frame {
                        continue;
                    }
                    match g.sensor {
                        Sensor::Reflector(reflector) => {
                            let points = &state.logs[g.log].points_m[reflector];
                            g.add_points(&mut out, |r| if k < 3 { e } else { e.cross(&points[r]) });
                        }
                        Sensor::Orientation if k >= 3 => g.add_points(&mut out, |_| e),
                        _ => {}
                    }
                }
                out
            })
            .collect()
    }
}

impl Hypothesis {
    /// Moves the nuisance by changes found with [`Problem::nuisance_columns`].
    pub fn move_nuisance(&mut self, problem: &Problem, change: &[f64]) {
        let mut change = change;
        let mut take = |n: usize| {
            let (head, rest) = change.split_at(n.min(change.len()));
            change = rest;
            head
        };
        if problem.frames_free {
            for f in 0..self.frames.len() {
                self.move_frame(f, take(6));
            }
        }
        if problem.is_turned() {
            let places: Vec<Vector3<f64>> =
                problem.robot.reflectors_m.iter().zip(&self.points_m).map(|(p, d)| p + d).collect();
            let moved = orientation::turned(&places, take(3));
            for ((d, p), new) in self.points_m.iter_mut().zip(&places).zip(&moved) {
                *d += new - p;
            }
        } else if problem.points_free {
            for p in &mut self.points_m {
                *p += Vector3::from_row_slice(take(3));
            }
        }
        for z in &mut self.zeros {
            *z += take(1)[0];
        }
    }

    /// Moves a frame by a small change.
    pub(in crate::diagnose) fn move_frame(&mut self, frame: usize, change: &[f64]) {
        let (t, w) = (Vector3::new(change[0], change[1], change[2]), Vector3::new(change[3], change[4], change[5]));
        let small = Isometry3::from_parts(Translation3::from(t), UnitQuaternion::from_scaled_axis(w));
        self.frames[frame] *= small;
    }
}
