//! Targets of URScript moves: joint values, poses with their TCP, or why neither can be determined.

use super::arguments::arguments;
use super::constant::isometry;
use super::in_force::{InForce, called_twice, may_differ, reads_place};
use super::lex::Kind;
use super::read::{Item, ItemKind, Span};
use super::reason::Reason;
use super::steps::{Builder, Literal, Owner};
use super::value;
use super::words;
use crate::error::{Result, one_line};
use crate::script::pose::Frame;
use crate::script::reach::FIRST;
use crate::script::{At, Goal, PoseForm, PoseGoal, Shift, Solution, Target};
use nalgebra::{Isometry3, Vector3};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// The list of a pose, and the item that assigns it to a name.
type PosePlace = (Span, Option<usize>);

/// A pose in an expression.
struct Found {
    /// Numbers of the list.
    numbers: [f64; 6],
    place: PosePlace,
    /// The list or its name in the expression.
    inner: Span,
    /// What the expression makes of it.
    shift: Option<Shift>,
}

/// 0.001 mm and 0.0001 rad: what TCPs are rounded to.
fn alike(a: &Isometry3<f64>, b: &Isometry3<f64>) -> bool {
    (a.translation.vector - b.translation.vector).norm() < 1e-6 && a.rotation.angle_to(&b.rotation) < 1e-4
}

impl Builder<'_> {
    /// The TCPs that the file sets, into `tcps`, and where they and what leads the robot may be in force; into `read` the items whose moves
    /// may come last before the place of the robot is read. A TCP that is computed is asked for by what computes it, and by a number where
    /// the same words may give another one.
    ///
    /// `tool = "set_tcp" "(" (pose | name | expression) ["," ...] ")"`
    pub fn find_in_force(&mut self) -> Option<InForce> {
        let p = self.p;
        let mut atoms: HashMap<usize, u32> = HashMap::new();
        let (mut asked, twice) = (HashMap::new(), called_twice(p));
        for (k, item) in p.items.iter().enumerate() {
            let Some(at) = item.span.clone().find(|i| p.words.at(*i) == "set_tcp") else { continue };
            let args = arguments(p, at + 2, p.tokens.len()).map(|a| a.0).unwrap_or_default();
            let tool = match args.first().map(|a| (self.pose(&a.span, item), a)) {
                Some((Some((pose, _)), _)) => Frame::Given(isometry(pose)),
                Some((None, a)) => self.asked_tcp(&a.span, item, &twice, &mut asked),
                None => Frame::unclear(Reason::TcpComputed),
            };
            let same = |other: &Frame| match (other, &tool) {
                (Frame::Given(a), Frame::Given(b)) => alike(a, b),
                (a, b) => a == b,
            };
            let known = self.tcps.iter().position(same).unwrap_or_else(|| {
                self.tcps.push(tool.clone());
                self.tcps.len() - 1
            });
            atoms.insert(k, FIRST + known as u32);
        }
        let leads = p.items.iter().flat_map(|item| p.called(item)).any(|name| words::leads(name).is_some());
        let readings: Vec<usize> = (0..p.items.len()).filter(|k| reads_place(p, &p.items[*k])).collect();
        let acting: Vec<usize> = (0..p.items.len()).filter(|k| p.called(&p.items[*k]).any(words::acts)).collect();
        let any = leads || !atoms.is_empty();
        if !any && readings.is_empty() && acting.is_empty() {
            return None;
        }
        let mut asked = [&readings[..], &acting].concat();
        asked.sort_unstable();
        let found = InForce::of(self.text, p, self.entry_def, &|k| atoms.get(&k).copied(), &asked);
        self.read = found.last_before(p, &readings);
        self.acted_on = found.last_before(p, &acting);
        any.then_some(found)
    }

    /// A TCP that is computed.
    fn asked_tcp(&self, value: &Span, item: &Item, twice: &HashSet<&str>, asked: &mut HashMap<String, usize>) -> Frame {
        let name = format!("set_tcp {}", self.shown(value));
        if !may_differ(self.p, item.def, value.clone()) {
            return Frame::Computed(name);
        }
        if item.def.and_then(|def| self.p.defs.get(def)).is_some_and(|(name, _)| twice.contains(name.as_str())) {
            return Frame::unclear(Reason::TcpDiffers);
        }
        // numbers of lines would change with each point that is added
        let number = asked.entry(name.clone()).or_default();
        *number += 1;
        Frame::Computed(if *number == 1 { name } else { format!("{name} ({number})") })
    }

    /// An expression as it is written.
    fn shown(&self, span: &Span) -> String {
        one_line(&String::from_utf8_lossy(self.text.slice(self.bytes(span))))
    }

    /// The pose that an expression is: `p[..]`, or a name that is assigned one; where its list stands, and the item that assigns it.
    fn pose(&self, span: &Span, item: &Item) -> Option<([f64; 6], PosePlace)> {
        let read = |s: &Span| value::pose(self.text, &self.p.tokens, &self.p.words, s);
        if let Some(pose) = read(span) {
            return Some((pose, (span.clone(), None)));
        }
        if span.len() != 1 {
            return None; // an expression
        }
        let (value, n) = self.assigned(span, item).ok()?;
        Some((read(&value)?, (value, Some(n))))
    }

    /// A pose, or one that `pose_trans` or `pose_add` displaces by another; `None`: neither is certain.
    ///
    /// `goal = pose | name | ("pose_trans" | "pose_add") "(" place "," place ")", place = pose | name`
    fn displaced(&self, span: &Span, item: &Item) -> Option<Found> {
        if let Some((numbers, place)) = self.pose(span, item) {
            return Some(Found { numbers, place, inner: span.clone(), shift: None });
        }
        let p = self.p;
        let adds = match p.words.at(span.start) {
            "pose_trans" => false,
            "pose_add" => true,
            _ => return None,
        };
        let (args, _) = arguments(p, span.start + 2, span.end).filter(|a| a.1 + 1 == span.end)?;
        let [first, second] = args.as_slice() else { return None };
        let (a, b) = (self.pose(&first.span, item)?, self.pose(&second.span, item)?);
        if !adds {
            // the second stands in the frame of the first
            let shift = Shift { before: isometry(a.0), after: Isometry3::identity() };
            return Some(Found { numbers: b.0, place: b.1, inner: second.span.clone(), shift: Some(shift) });
        }
        // how turns are added differs by the controller's version
        let by = b.0.get(..3).filter(|_| b.0[3..].iter().all(|v| *v == 0.0))?;
        let shift = Shift::in_frame(Vector3::new(by[0], by[1], by[2]));
        Some(Found { numbers: a.0, place: a.1, inner: first.span.clone(), shift: Some(shift) })
    }

    /// The joints that the editor keeps beside a waypoint: `Waypoint_1_q` of `Waypoint_1_p`.
    fn taught(&self, inner: &Span, item: &Item) -> Option<Solution> {
        let name = self.p.words.at(inner.start).strip_suffix("_p").filter(|_| inner.len() == 1)?;
        let key = self.p.key(item.def, &format!("{name}_q"))?;
        let variable = &self.p.variables[&key];
        let [n] = variable.assigned[..] else { return None };
        let ItemKind::Assign { value, whole: true, .. } = self.p.items[n].kind else { return None };
        self.joints_of(&(value..self.p.items[n].span.end)).filter(|_| variable.changed.is_none())
    }

    fn joints_of(&self, list: &Span) -> Option<Solution> {
        if list.is_empty() {
            return None;
        }
        // a list of other length is one that cannot be determined
        let found = value::joints(self.text, &self.p.tokens, &self.p.words, list, self.robot).ok()?.ok()?;
        found.0.into_iter().map(|v| v.map(|v| v.si)).collect::<Option<Vec<f64>>>().map(Solution::Near)
    }

    /// The TCP in force at the item at hand. What no line sets has the controller's name: the TCP of the installation.
    pub fn tcp(&self) -> Frame {
        let installed = || Frame::Named("tcp".into());
        let Some(in_force) = &self.in_force else { return installed() };
        let of = |atom: u32| {
            let set = atom.checked_sub(FIRST).and_then(|k| self.tcps.get(k as usize));
            set.cloned().unwrap_or_else(installed)
        };
        let mut all: Vec<Frame> = in_force.tcps(self.def, self.place).map(of).collect();
        match all.len() {
            0 => installed(),
            1 => all.remove(0),
            _ => Frame::Any(all),
        }
    }

    fn pose_goal(&mut self, found: Found, item: &Item) -> Goal {
        let Found { numbers, place, inner, shift } = found;
        let tool = self.tcp();
        // what a waypoint was taught with is nothing that the controller looks at
        let solution = self.taught(&inner, item).unwrap_or_default();
        let target = self.pose_target(place, &inner, item);
        let at = isometry(numbers);
        self.inner = Some(inner);
        let goal = PoseGoal {
            target,
            position_m: at.translation.vector,
            rotation: Some(at.rotation),
            frame: Frame::Base,
            tool,
            solution,
            ..PoseGoal::default()
        };
        Goal::pose(match shift {
            Some(shift) => goal.shifted(shift),
            None => goal,
        })
    }

    /// Index of the target of a pose that is written in numbers.
    fn pose_target(&mut self, (list, assigned): PosePlace, span: &Span, item: &Item) -> Option<usize> {
        let (p, text) = (self.p, self.text);
        let name = p.words.at(span.start).to_string();
        let key = assigned.and_then(|_| p.key(item.def, &name));
        if let Some(&t) = key.as_ref().and_then(|key| self.known.get(key)) {
            return Some(t);
        }
        let values = value::pose_values(text, &p.tokens, &p.words, &list)?;
        let owner = match (assigned, &key) {
            (Some(n), Some(key)) => {
                let statement = p.items[n].span.clone();
                let word = p.words.at(statement.start);
                let qualifier = if matches!(word, "global" | "local") { format!("{word} ") } else { String::new() };
                let keep = p.variables[key].read;
                Some(Owner { bytes: self.bytes(&statement), qualifier, name: name.clone(), keep })
            }
            (Some(_), None) => return None,
            (None, _) => None,
        };
        let at = At { file: 0, line: self.line(list.start) };
        let name = owner.as_ref().map(|o| o.name.clone());
        self.targets.push(Target { name, at, values, pose: Some(PoseForm::RotationVector) });
        let units = self.units(&[1.0; 6]);
        self.literals.push(Literal {
            bytes: self.bytes(&list).into(),
            units,
            owner: owner.map(Box::new),
            folded: None,
        });
        let t = self.targets.len() - 1;
        if let Some(key) = key {
            self.known.insert(key, t);
        }
        Some(t)
    }

    /// Units in the memory of those of the target before, where they are the same: most are.
    pub fn units(&self, units: &[f64]) -> Arc<[f64]> {
        let before = self.literals.last().map(|l| &l.units).filter(|before| ***before == *units);
        before.map_or_else(|| units.into(), Arc::clone)
    }

    pub fn pose_or_opaque(&mut self, span: &Span, item: &Item) -> Goal {
        if let Some(found) = self.displaced(span, item) {
            return self.pose_goal(found, item);
        }
        self.folded_pose_goal(span)
            .unwrap_or_else(|| Goal::Opaque(self.assigned(span, item).err().unwrap_or_else(|| Reason::NoPose.into())))
    }

    /// The solution that `qnear` chooses; `None`: it cannot be determined.
    ///
    /// `qnear = "get_actual_joint_positions" ... | "get_target_joint_positions" ... | list | name`
    fn near(&self, span: &Span, item: &Item) -> Option<Solution> {
        let p = self.p;
        // where the robot stands
        if matches!(p.words.at(span.start), "get_actual_joint_positions" | "get_target_joint_positions") {
            return Some(Solution::Same);
        }
        let value = match self.assigned(span, item) {
            _ if p.tokens[span.start].kind == Kind::Mark(b'[') => span.clone(),
            Ok((value, _)) if !value.is_empty() => value,
            _ => return None,
        };
        self.joints_of(&value)
    }

    /// Position of the point on the way of an arc, m.
    pub fn via(&self, span: &Span, item: &Item) -> Option<Vector3<f64>> {
        let Some(found) = self.displaced(span, item) else {
            return self.folded_pose(span).map(|pose| isometry(pose).translation.vector);
        };
        let at = isometry(found.numbers);
        Some(found.shift.map_or(at, |s| s.before * at * s.after).translation.vector)
    }

    /// `get_inverse_kin(pose, qnear)`: the list of qnear only chooses the solution; the pose is where the robot goes.
    ///
    /// `goal = "get_inverse_kin" "(" place ["," qnear] ")"`
    fn inverse_goal(&mut self, span: &Span, item: &Item) -> Goal {
        let args = arguments(self.p, span.start + 2, span.end).map(|a| a.0).unwrap_or_default();
        let first = args.first().filter(|_| args.len() <= 2).map(|a| a.span.clone());
        let pose = first.as_ref().and_then(|s| self.displaced(s, item));
        let mut goal = match (pose, first) {
            (Some(pose), _) => self.pose_goal(pose, item),
            (None, first) => match first.and_then(|first| self.folded_pose_goal(&first)) {
                Some(goal) => goal,
                None => return Goal::opaque(Reason::InverseKinematics),
            },
        };
        if let (Some(near), Goal::Pose(goal)) = (args.get(1), &mut goal) {
            match self.near(&near.span, item) {
                Some(solution) => {
                    goal.binding = matches!(solution, Solution::Near(_));
                    goal.solution = solution;
                }
                None => return Goal::opaque(Reason::NearComputed),
            }
        }
        goal
    }

    /// Where a target leads: as it is written, or as it is computed from constants.
    ///
    /// # Errors
    /// Where a list of plain numbers has not one for every axis.
    pub fn goal(&mut self, span: &Span, item: &Item) -> Result<Goal> {
        let written = self.written_goal(span, item)?;
        let computed = match &written {
            Goal::Opaque(_) => true,
            Goal::Pose(pose) => pose.target.is_none(),
            Goal::Joints(_) => false,
        };
        let folded = if computed { self.folded_goal(span) } else { None };
        Ok(folded.unwrap_or(written))
    }

    /// `goal = place | "get_inverse_kin" "(" ... ")" | list | name`
    fn written_goal(&mut self, span: &Span, item: &Item) -> Result<Goal> {
        let (p, text, robot) = (self.p, self.text, self.robot);
        if let Some(found) = self.displaced(span, item) {
            return Ok(self.pose_goal(found, item));
        }
        if p.words.at(span.start) == "get_inverse_kin" && span.len() > 3 {
            return Ok(self.inverse_goal(span, item));
        }
        let at = At { file: 0, line: self.line(span.start) };
        if p.tokens[span.start].kind == Kind::Mark(b'[') {
            return Ok(match value::joints(text, &p.tokens, &p.words, span, robot)? {
                Ok((values, units)) => {
                    self.targets.push(Target { name: None, at, values, pose: None });
                    let units = self.units(&units);
                    self.literals.push(Literal { bytes: self.bytes(span).into(), units, owner: None, folded: None });
                    let t = self.targets.len() - 1;
                    self.keep_numbers(t, span);
                    Goal::Joints(t)
                }
                Err(why) => Goal::Opaque(why),
            });
        }
        let (value, n) = match self.assigned(span, item) {
            Ok(found) => found,
            Err(why) => return Ok(Goal::Opaque(why)),
        };
        let name = p.words.at(span.start).to_string();
        let Some(key) = p.key(item.def, &name) else { return Ok(Goal::opaque(Reason::NotAssigned(name.into()))) };
        if let Some(&t) = self.known.get(&key) {
            return Ok(Goal::Joints(t));
        }
        if value.is_empty() {
            return Ok(Goal::opaque(Reason::AssignedNothing(name.into())));
        }
        let (values, units) = match value::joints(text, &p.tokens, &p.words, &value, robot)? {
            Ok(found) => found,
            Err(why) => return Ok(Goal::Opaque(why.of_declared(&name))),
        };
        let statement = p.items[n].span.clone();
        let qualifier = p.words.at(statement.start);
        let qualifier = if matches!(qualifier, "global" | "local") { format!("{qualifier} ") } else { String::new() };
        let owner =
            Owner { bytes: self.bytes(&statement), qualifier, name: name.clone(), keep: p.variables[&key].read };
        let line = self.line(value.start);
        self.targets.push(Target { name: Some(name), at: At { file: 0, line }, values, pose: None });
        let units = self.units(&units);
        self.literals.push(Literal {
            bytes: self.bytes(&value).into(),
            units,
            owner: Some(Box::new(owner)),
            folded: None,
        });
        let t = self.targets.len() - 1;
        self.keep_numbers(t, &value);
        self.known.insert(key, t);
        Ok(Goal::Joints(t))
    }

    /// Keeps the numbers of a list for which the robot file has no joint.
    fn keep_numbers(&mut self, target: usize, list: &Span) {
        if let Some(without) = &mut self.without_joint {
            let numbers = value::in_order(self.text, &self.p.tokens, &self.p.words, list);
            without.keep(target, numbers.unwrap_or_default().into_iter().map(Some));
        }
    }
}
