//! Where a move leads, by the positions that it names and the headers in force there.
//!
//! Fails where a position has too few numbers, or holds pulses of a joint of which the robot file does not say how many make a degree.

use super::job::{ANGLE_DECIMALS, Kind, LENGTH_DECIMALS, Meaning, Number, Numbers, Position, Reference};
use super::read::Reader;
use super::reason::Reason;
use crate::error::Result;
use crate::script::pose::{Configuration, Frame};
use crate::script::{self, At, Goal, Move, Note, PoseForm, PoseGoal, Solution, Span, Target, Value, number};
use nalgebra::{UnitQuaternion, Vector3};

impl Reader<'_> {
    /// Why a copy of a position at the end of its kind would mean something else.
    pub(super) fn no_copy(&self, position: usize) -> Option<Reason> {
        let p = &self.list.positions[position];
        let header = p.section.lacks(self.ends.get(&p.kind)?)?;
        Some(Reason::NoHeaderToCopy(header))
    }

    /// Where a move leads; also says whether it is fixed or closed by what its positions are.
    ///
    /// `goal = (C_position | P_position) [BC_position | BP_position] [EC_position | EX_position]`
    pub(super) fn goal(&mut self, k: usize, references: &[Reference], m: &mut Move) -> Result<Goal> {
        let list = self.list;
        if let [alone] = references
            && let Some(goal) = self.joints_alone(alone.position())?
        {
            return Ok(goal);
        }
        let mut key: Vec<usize> = references.iter().map(Reference::position).collect();
        key.sort_by_key(|&p| list.positions[p].kind);
        let Some(first) = key.first().map(|&p| &list.positions[p]).filter(|p| matches!(p.kind, Kind::C | Kind::P))
        else {
            return Ok(Goal::opaque(Reason::NoPosition));
        };
        if key.windows(2).any(|w| list.positions[w[0]].kind == list.positions[w[1]].kind) {
            return Ok(Goal::opaque(Reason::TwoPositions));
        }
        if first.kind == Kind::P {
            if self.assigned.contains(&first.number) {
                return Ok(Goal::opaque(Reason::VariableSet(first.number)));
            }
            // from a place that may be another one no direction is known
            if let Some(why) = self.shared.uncertain(first.number) {
                return Ok(Goal::opaque(Reason::VariableUncertain { number: first.number, why: Box::new(why) }));
            }
            if !self.has_noted {
                self.has_noted = true;
                let text = "position variables are taken and edited as the list of the job gives them: another job that sets or loads them \
                            undoes that";
                self.script.notes.push(Note { place: At::of_line(k), text: text.into() });
            }
            m.closed.get_or_insert_with(|| Reason::ToVariable.into());
        }
        match first.section.meaning {
            Meaning::Pulse | Meaning::Angle => self.joints(k, key, m),
            Meaning::Unknown => Ok(Goal::opaque(Reason::NoHeader("///POSTYPE"))),
            meaning => {
                let stations: Vec<f64> = key[1..]
                    .iter()
                    .flat_map(|&p| list.positions.numbers(p))
                    .filter_map(|r| number::read(self.text.slice(*r)))
                    .map(|n| n.0)
                    .collect();
                if !stations.is_empty() {
                    if self.still.as_ref() != Some(&stations) {
                        m.closed.get_or_insert_with(|| Reason::OthersMove.into());
                    }
                    self.still = Some(stations);
                }
                Ok(self.pose(key, meaning))
            }
        }
    }

    /// The number of the header on a line.
    fn header(&self, line: Option<u32>) -> Option<u32> {
        line.and_then(|k| header_number(self.text.line(k as usize)))
    }

    /// The user frame (`tool`: the tool) of the header on a line: `MFRAME UF#(1) ...` in the job makes it one that is known only while the
    /// job runs.
    fn as_set(&self, frame: Frame, line: Option<u32>, tool: bool) -> Frame {
        match self.header(line) {
            Some(n) if self.frames_set.has(tool, n) => frame.made("0", "as the job sets it"),
            _ => frame,
        }
    }

    /// The tool of a position.
    pub(super) fn tool(&self, position: &Position) -> Frame {
        let tool = match self.header(position.section.tool) {
            Some(n) => Frame::Named(n.to_string()),
            None => Frame::unclear(Reason::NoHeader("///TOOL")),
        };
        self.as_set(tool, position.section.tool, true)
    }

    /// A Cartesian target: X, Y, Z, Rx, Ry, Rz of the C line under the headers in force there.
    ///
    /// `position = name "=" x "," y "," z "," rx "," ry "," rz ["," ...]`
    fn pose(&mut self, key: Vec<usize>, meaning: Meaning) -> Goal {
        let list = self.list;
        let position = &list.positions[key[0]];
        let form = PoseForm::FixedXyz;
        let value = |(n, span): (usize, &Span)| {
            let (v, style) = number::read(self.text.slice(*span))?;
            let (unit, weight) = (form.unit(n), number::last_digit);
            let most = style.decimals.max(if n < 3 { LENGTH_DECIMALS } else { ANGLE_DECIMALS });
            let (digit, finest) = (weight(style.decimals) * unit, weight(most) * unit);
            Some(Value { si: v * unit, start: span.start(), end: span.end(), style, digit, finest })
        };
        let values: Option<Vec<Value>> = list.positions.numbers(key[0]).iter().take(6).enumerate().map(value).collect();
        let Some(values) = values.filter(|v| v.len() == 6) else {
            return Goal::opaque(Reason::FewNumbers);
        };
        let n: Vec<f64> = values.iter().map(|v| v.si).collect();
        let carried = key.iter().any(|&p| list.positions[p].kind == Kind::Bc) || self.base_axes;
        let header = |line: Option<u32>| self.header(line);
        let frame = match meaning {
            _ if carried => Frame::unclear(Reason::OnBase),
            Meaning::Robot | Meaning::Base => Frame::Null,
            Meaning::User if self.led_elsewhere => Frame::unclear(Reason::RelativeJob),
            Meaning::User => match header(position.section.user) {
                Some(n) => Frame::Named(n.to_string()),
                None => Frame::unclear(Reason::NoHeader("///USER")),
            },
            _ => Frame::unclear(Reason::OtherFrame),
        };
        let of_user = position.section.user.filter(|_| meaning == Meaning::User);
        let (frame, tool) = (self.as_set(frame, of_user, false), self.tool(position));
        let solution = position.section.rconf.and_then(|k| configuration(self.text.line(k as usize)));
        let target = match self.targets.get(&key) {
            Some(t) => t,
            None => {
                let t = self.script.targets.len();
                self.script.targets.push(Target {
                    pose: Some(form),
                    name: Some(position.name()),
                    at: At::of_line(position.line()),
                    values: values.into_iter().map(Some).collect(),
                });
                self.numbers.push(Numbers::of_line(key[0], 6));
                self.targets.insert(key, t);
                t
            }
        };
        Goal::pose(PoseGoal {
            target: Some(target),
            position_m: Vector3::new(n[0], n[1], n[2]),
            rotation: Some(UnitQuaternion::from_euler_angles(n[3], n[4], n[5])),
            frame,
            tool,
            solution: solution.map_or(Solution::Same, Solution::Configured),
            binding: true,
            ..PoseGoal::default()
        })
    }

    /// A joint target: numbers of the C line are axes first, then those of BC and EC.
    ///
    /// `position = name "=" axis {"," axis}`
    fn joints(&mut self, k: usize, key: Vec<usize>, m: &mut Move) -> Result<Goal> {
        let (text, robot, list) = (self.text, self.robot, self.list);
        let all: Vec<Number> =
            key.iter().flat_map(|&p| (0..list.positions.numbers(p).len()).map(move |n| (p as u32, n as u32))).collect();
        let lead = &list.positions[key[0]];
        if all.len() < robot.dof() {
            let found = format!("{} numbers for the move on line {}", all.len(), k + 1);
            let expected = format!("{}, one for each axis of {}", robot.dof(), robot.name);
            return Err(text.bad(text.line_span(lead.line()).start, found, expected));
        }
        let (axes, rest) = match self.of_axes(&key, &all) {
            Ok(found) => found,
            Err(why) => return Ok(Goal::Opaque(why)),
        };
        let (axes, rest) = (axes.as_slice(), rest.as_slice());
        let span = |n: &Number| list.positions.numbers(n.0 as usize)[n.1 as usize].range();
        let read = |n: &Number| number::read(text.slice(span(n))).map(|v| v.0);
        if !rest.is_empty() {
            let rest: Vec<f64> = rest.iter().filter_map(read).collect();
            if self.still.as_ref() != Some(&rest) {
                m.closed.get_or_insert_with(|| Reason::OthersMove.into());
            }
            self.still = Some(rest);
        }
        if let Some(p) = axes
            .iter()
            .map(|n| &list.positions[n.0 as usize])
            .find(|p| !matches!(p.section.meaning, Meaning::Pulse | Meaning::Angle))
        {
            return Ok(Goal::opaque(Reason::NoJointValues { kind: p.kind.word(), number: p.number }));
        }
        if let Some(t) = self.targets.get(&key) {
            return Ok(Goal::Joints(t));
        }
        let mut values = Vec::with_capacity(axes.len());
        for (axis, n) in axes.iter().enumerate() {
            values.push(Some(self.value(axis, *n)?));
        }
        let t = self.script.targets.len();
        self.script.targets.push(Target { pose: None, name: Some(lead.name()), at: At::of_line(lead.line()), values });
        self.numbers.push(Numbers::of(axes));
        self.targets.insert(key, t);
        Ok(Goal::Joints(t))
    }

    /// The same of a move to one position of the list that has a number for each axis and no other: nearly all are such.
    fn joints_alone(&mut self, position: usize) -> Result<Option<Goal>> {
        let (text, list, dof) = (self.text, self.list, self.robot.dof());
        let Some(p) = list.positions.get(position) else { return Ok(None) };
        let in_joints = matches!(p.section.meaning, Meaning::Pulse | Meaning::Angle);
        if !(self.in_order && p.kind == Kind::C && in_joints && list.positions.numbers(position).len() == dof) {
            return Ok(None);
        }
        if let Some(t) = self.targets.get(&[position]) {
            return Ok(Some(Goal::Joints(t)));
        }
        let mut values = std::mem::take(&mut self.room);
        values.clear();
        for axis in 0..dof {
            values.push(Some(self.value(axis, (position as u32, axis as u32))?));
        }
        let t = self.script.targets.len();
        let at = At::of_line(p.line());
        // as it stands there, unless that is in lower case
        let line = text.line(p.line());
        let written =
            line.get(..line.iter().position(|b| *b == b'=').unwrap_or_default()).unwrap_or_default().trim_ascii();
        let plain = written.iter().all(|b| b.is_ascii_uppercase() || b.is_ascii_digit());
        match std::str::from_utf8(written).ok().filter(|_| plain) {
            Some(name) => self.script.targets.push_numbers(None, Some(name), at, values.drain(..)),
            None => self.script.targets.push_numbers(None, Some(&p.name()), at, values.drain(..)),
        }
        self.room = values;
        self.numbers.push(Numbers::of_line(position, dof as u16));
        self.targets.insert_one(position, t);
        Ok(Some(Goal::Joints(t)))
    }

    /// The numbers of a move's positions by the robot's axes, and those that are none of its: the C line has the joints of the arm, BC
    /// those of a base that carries it, EC those of stations.
    ///
    /// # Errors
    /// Why it is not certain which number is which axis'.
    fn of_axes(
        &self,
        key: &[usize],
        all: &[Number],
    ) -> std::result::Result<(Vec<Number>, Vec<Number>), script::Reason> {
        let (robot, list, order) = (self.robot, self.list, &self.order);
        if !order.certain {
            return Err(script::Reason::unclear_axes(&robot.axis_names()));
        }
        let lead = key.first().map(|&k| list.positions.numbers(k).len()).unwrap_or_default();
        let on_line = order.on_line(lead);
        // listed after the arm they follow it in a position, too
        if order.is_plain() && (order.numbered || on_line.is_some()) {
            let (axes, rest) = all.split_at(robot.dof());
            return Ok((axes.to_vec(), rest.to_vec()));
        }
        let Some((of_arm, taken)) = on_line else {
            return Err(script::Reason::unclear_numbers(&robot.axis_names()));
        };
        let kind = |n: &Number| list.positions[n.0 as usize].kind;
        let base: Vec<Number> = all.iter().filter(|n| matches!(kind(n), Kind::Bc | Kind::Bp)).copied().collect();
        let arm_from = order.arm.iter().map(|a| a.0).min().unwrap_or_default();
        let carrying = order.external.iter().filter(|e| **e < arm_from).count();
        // further numbers of the C line are further axes of the group
        let beyond = lead.saturating_sub(taken);
        if carrying != base.len() || carrying + taken > all.len() || carrying > 0 && beyond > 0 {
            return Err(Reason::OtherBaseAxes.into());
        }
        let mut after = all.iter().skip(taken).filter(|n| !matches!(kind(n), Kind::Bc | Kind::Bp)).copied();
        let mut base = base.into_iter();
        let mut of_axis = vec![None; robot.dof()];
        for (axis, place) in &of_arm {
            of_axis[*axis] = all.get(*place).copied();
        }
        for &axis in &order.external {
            of_axis[axis] = if axis < arm_from { base.next() } else { after.next() };
        }
        let axes: Option<Vec<Number>> = of_axis.into_iter().collect();
        let axes = axes.ok_or(Reason::FewExternalAxes)?;
        let without_joint = (0..taken).filter(|k| of_arm.iter().all(|a| a.1 != *k)).filter_map(|k| all.get(k).copied());
        Ok((axes, without_joint.chain(after).chain(base).collect()))
    }

    fn value(&self, axis: usize, n: Number) -> Result<Value> {
        let position = &self.list.positions[n.0 as usize];
        let span = self.list.positions.numbers(n.0 as usize)[n.1 as usize].range();
        let joint = self.robot.axis(axis);
        let (v, style) = number::read(self.text.slice(span.clone())).unwrap_or_default();
        if position.section.meaning == Meaning::Pulse {
            let Some(pulses) = joint.pulses else {
                let key = format!("pulses_per_{}", joint.kind.unit());
                return Err(self.text.bad(
                    span.start,
                    format!("pulses, and no `{key}` of joint {} in the file of {}", joint.name, self.robot.name),
                    format!(
                        "`{key}` of joint {} in the robot file (the controller's pulses per {})",
                        joint.name,
                        joint.kind.unit()
                    ),
                ));
            };
            let digit = 1.0 / pulses.abs();
            return Ok(Value { si: v / pulses, start: span.start, end: span.end, style, digit, finest: digit });
        }
        let unit = joint.kind.si_per_user_unit();
        let weight = |d: u8| unit * number::last_digit(d);
        let finest = weight(style.decimals.max(ANGLE_DECIMALS));
        Ok(Value { si: v * unit, start: span.start, end: span.end, style, digit: weight(style.decimals), finest })
    }
}

/// The number of a header: `///TOOL 3`, `///USER 1`.
///
/// `header = word number ["," ...]`
fn header_number(line: &[u8]) -> Option<u32> {
    let words = String::from_utf8_lossy(line).into_owned();
    words.split_ascii_whitespace().nth(1)?.split(',').next()?.parse().ok()
}

/// `///RCONF 0,0,0,0,0,0,...`; the first six are known.
///
/// `rconf = "///RCONF" bit "," bit "," bit "," bit "," bit "," bit ["," ...]`
fn configuration(line: &[u8]) -> Option<Configuration> {
    let words = String::from_utf8_lossy(line).into_owned();
    let (_, list) = words.trim().split_once(|c: char| c.is_ascii_whitespace())?;
    let bits =
        list.split(',').take(6).map(|v| Some(v.trim().parse::<u8>().ok()? != 0)).collect::<Option<Vec<bool>>>()?;
    let [no_flip, lower, rear, r, t, s] = bits[..] else { return None };
    Some(Configuration::Yaskawa { no_flip, lower, rear, beyond: [r, t, s] })
}
