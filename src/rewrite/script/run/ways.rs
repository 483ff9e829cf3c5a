//! A move between two known places: its duration, the points at which joints turn on it, and its goal.

use super::super::approach::Directions;
use super::super::cause::Cause;
use super::stretch::held;
use super::{Cutter, Joints, Reached, Role, ToolAndMiddle, Vertex};
use crate::program::script::{At, Goal, Move, PathKind, Script, Speed, Way};
use crate::rewrite::script::{clock, way};
use crate::robot::Robot;

/// Share of a move at which the point in place stands.
const IN_PLACE: f64 = 1e-7;
/// A move that turns no joint by more leads to where the robot stands: the rounding of a pose's last digits, rad or m.
const NO_MOVE: f64 = 2e-6;
/// How long the robot waits where nothing says it, s.
const START_S: f64 = 1e-3;

impl Cutter<'_> {
    /// A move between two known places: its turning points, its duration and its goal.
    pub(super) fn go(&mut self, script: &Script, step: usize, at: At, m: &Move, from: &[f64], reached: Reached) {
        let (robot, again) = (self.choice.robot, self.again);
        let Reached { q, named, mut editable, solved, tooled, via, .. } = reached;
        let mut t0 = self.run.vertices.last().map_or(0.0, |v| v.t_s);
        let speed = match self.choice.certain_speed_m_s {
            Some(v) if !clock::is_certain(m.speed) => Speed::Tcp(v),
            _ => m.speed,
        };
        // points of an arc that is closed to new ones stay inside it; its turns still say how its end is reached
        let of_pose = matches!(&m.goal, Goal::Pose(goal) if goal.via_m.is_some());
        let arc = m.path == PathKind::Curve && (of_pose || via.is_some());
        let shut = m.closed.is_some() && m.path != PathKind::Linear && !arc;
        if !self.free.is_empty() {
            self.run.elsewhere.insert(step, self.free);
        }
        let ways = if shut { Some(Vec::new()) } else { self.ways(step, m, (from, &q), solved, (tooled, via)) };
        let on_way = |share: f64| {
            let known = (self.choice.on_way)(step, share).map(|q| self.run.standing(step, q, from));
            known.or_else(|| self.run.line(step).filter(|_| arc)?.at(share))
        };
        let otherwise = self.choice.tcp_speed_m_s;
        self.tcp.knows(self.lengths.at(script, step, from, &q));
        let duration = clock::duration_s(robot, from, &q, m.path, speed, otherwise, &on_way, &mut self.tcp);
        if duration.is_none() {
            self.run.untimed.get_or_insert(at);
        }
        let certain = clock::is_certain(speed) && duration.is_some();
        self.run.certain &= clock::is_certain(speed);
        self.run.by_program &= matches!(speed, Speed::Seconds(_));
        let duration = duration.unwrap_or(0.0);
        let ways = ways.unwrap_or_else(|| {
            // as joint moves it would leave its line
            editable &= !solved;
            self.run.unfollowed.insert(step);
            Vec::new()
        });
        let vertex = |role: Role, q: Joints, share: f64, t_s: f64| Vertex {
            step,
            role,
            q,
            share,
            editable,
            t_s,
            certain,
            again,
        };
        let first = ways.first().map_or(&*q, |w| w.q.as_slice());
        let changing = self.run.changing.contains(&step);
        let crossing = self.crossing(m, from, first);
        let crossing = crossing.filter(|_| editable && !changing && !self.run.unfollowed.contains(&step));
        if let Some((q, seconds)) = crossing {
            t0 += seconds;
            self.run.vertices.push(vertex(Role::Crossing, q, IN_PLACE, t0));
        }
        for w in ways {
            let q = self.run.standing(step, w.q, from);
            self.directions.go(robot, &q, self.choice.deadband);
            self.run.vertices.push(vertex(Role::Way, q.into(), w.share, t0 + w.share * duration));
        }
        let mut goal = vertex(Role::Goal, q, 1.0, t0 + duration);
        let posed = matches!(m.goal, Goal::Pose(_));
        if editable && posed {
            self.leave_at_unknown(step, &mut goal);
        }
        if editable
            && !changing
            && !self.run.entered.contains(&step)
            && m.is_open_to_goal()
            && !self.run.unfollowed.contains(&step)
            && self.choice.approach.count(m)
            && !self.choice.approach.goes_without(step)
            && let Some(point) = self.choice.approach.point_of((m, named), robot, &self.run, &self.directions, &goal.q)
        {
            self.keep_first_directions(&goal);
            let last = self.run.vertices.last().map_or(t0, |v| v.t_s);
            self.directions.go(robot, &point, self.choice.deadband);
            self.run.vertices.push(self.choice.approach.vertex(&goal, 0.5 * (last + goal.t_s), point));
        }
        // over a point of approach joints come from known sides
        if editable && !posed {
            self.leave_at_unknown(step, &mut goal);
        }
        self.directions.go(robot, &goal.q, self.choice.deadband);
        self.run.vertices.push(goal);
    }

    /// Where the program starts, its own first movement says from which side joints come to the first point, and not the way to a point
    /// that is to be added after it: the robot waits at the first point until it goes there.
    fn keep_first_directions(&mut self, goal: &Vertex) {
        let [start, way @ ..] = &self.run.vertices[..] else { return };
        let first = start.role == Role::Goal && way.iter().all(|v| v.role == Role::Way && v.step == goal.step);
        if !self.run.entry || !first {
            return;
        }
        let mut own = Directions::default();
        let mut directions: Vec<i8> = vec![0; start.q.len()];
        for v in [start].into_iter().chain(way).chain([goal]) {
            own.go(self.choice.robot, &v.q, self.choice.deadband);
            for (axis, first) in directions.iter_mut().enumerate().filter(|(_, first)| **first == 0) {
                *first = own.of(axis);
            }
        }
        let next = way.first().unwrap_or(goal);
        let waits = held(start, (0.5 * (next.t_s - start.t_s)).clamp(0.0, START_S));
        self.run.first_directions = directions;
        self.run.vertices.insert(1, waits);
    }

    /// A goal to which nothing moves keeps its numbers, where it is not known from which side joints came there.
    fn leave_at_unknown(&mut self, step: usize, goal: &mut Vertex) {
        if self.stays_at_unknown(&goal.q) {
            goal.editable = false;
            self.out.left.entry(step).or_insert(Cause::SideUnknown);
        }
    }

    /// Whether a move leads to where its run begins, and from which side joints came there is not known: it does not move them.
    fn stays_at_unknown(&self, q: &[f64]) -> bool {
        let near = |v: &Vertex| v.q.iter().zip(q).all(|(a, b)| (a - b).abs() <= NO_MOVE);
        !self.run.entry && !self.directions.any() && self.run.vertices.iter().all(near)
    }

    /// Where joints turn back from a place at which the robot stands: that place once more (a little on, so that the turn stays before
    /// it) and the time in which they cross their gaps there. A point further on would leave the TCP off its path until then.
    ///
    /// A time that is written for the whole move cannot be shared with a point in place.
    fn crossing(&self, m: &Move, from: &[f64], to: &[f64]) -> Option<(Joints, f64)> {
        let open = m.closed.is_none() && m.path != PathKind::Curve && !matches!(m.speed, Speed::Seconds(_));
        // the passes of a loop share one text
        if !self.stands || !open || self.choice.crossing_s.is_empty() || self.pass.is_some() {
            return None;
        }
        let gears = self.choice.robot.has_sums().then(|| {
            [from, to].map(|q| {
                let mut gears = q.to_vec();
                self.choice.robot.to_gears(&mut gears);
                gears
            })
        });
        let [here, next] = gears.as_ref().map_or([from, to], |[here, next]| [here, next]);
        let back = |axis: usize| {
            let by = next[axis] - here[axis];
            let moves = by.abs() > self.choice.deadband.get(axis).copied().unwrap_or(0.0);
            moves && by * f64::from(self.directions.of(axis)) < 0.0
        };
        let times = self.choice.crossing_s.iter().enumerate().filter(|(axis, s)| **s > 0.0 && back(*axis));
        let seconds = times.map(|(_, s)| *s).fold(0.0, f64::max);
        (seconds > 0.0).then(|| (from.iter().zip(to).map(|(a, b)| a + IN_PLACE * (b - a)).collect(), seconds))
    }

    /// Points between the start and the goal of a move; `None`: its line cannot be followed closely enough.
    fn ways(
        &mut self,
        step: usize,
        m: &Move,
        (from, to): (&[f64], &[f64]),
        solved: bool,
        (tooled, via): ToolAndMiddle,
    ) -> Option<Vec<Way>> {
        let via = match &m.goal {
            Goal::Pose(goal) => self.run.places.get(&step).and_then(|p| p.via(goal)),
            _ => via,
        };
        if !m.way.is_empty() || m.path != PathKind::Linear && via.is_none() {
            return Some(m.way.to_vec());
        }
        // straight in the joints is straight at the TCP where all joints are prismatic
        if self.is_gantry() {
            return Some(Vec::new());
        }
        let of_pose = || self.run.places.get(&step).map(|p| p.tooled.clone());
        let tooled = tooled.or_else(of_pose).unwrap_or_else(|| self.plain.clone());
        let line = way::Line::between(&tooled, from, to, via)?;
        let mut ways = line.turning_points(self.choice.deadband);
        if let Some(within) = self.choice.solve_within_m.filter(|_| solved) {
            ways.extend(chords(&tooled.robot, &line, within)?);
            ways.sort_by(|a, b| a.share.total_cmp(&b.share));
            ways.dedup_by(|b, a| b.share - a.share < 1e-3);
        }
        // the first move of a loop keeps the way from before it, and has another one from the end of the loop
        match self.again && self.run.entered.contains(&step) {
            true => self.run.lines_again.insert(step, line),
            false => self.run.lines.insert(step, line),
        };
        Some(ways)
    }
}

/// Points on a TCP line between which joint moves stay within `within` metres of it; `None`: so many points are too few.
fn chords(robot: &Robot, line: &way::Line, within: f64) -> Option<Vec<Way>> {
    const MOST: usize = 1024;
    let mut parts = 1;
    loop {
        let points: Option<Vec<Vec<f64>>> = (0..=parts).map(|k| line.at(k as f64 / parts as f64)).collect();
        let points = points?;
        let worst = (0..parts).try_fold(0.0f64, |worst, k| {
            let middle = line.at((k as f64 + 0.5) / parts as f64)?;
            let chord: Vec<f64> = points[k].iter().zip(&points[k + 1]).map(|(x, y)| 0.5 * (x + y)).collect();
            Some(worst.max((robot.tcp_m(&chord) - robot.tcp_m(&middle)).norm()))
        })?;
        // half of what is allowed, as the largest distance need not stand in the middle
        if worst <= 0.5 * within {
            let inner = points.into_iter().enumerate().skip(1).take(parts - 1);
            return Some(inner.map(|(k, q)| Way { share: k as f64 / parts as f64, q }).collect());
        }
        parts *= 2;
        if parts > MOST {
            return None;
        }
    }
}
