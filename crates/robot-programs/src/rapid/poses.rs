//! Cartesian targets of RAPID moves: poses with their frame and tool, displaced or not.

use super::arguments::{Arg, Switch, arguments};
use super::built::{Literal, Site};
use super::lex::Kind;
use super::read::{Item, Span};
use super::reason::{Elsewhere, Reason};
use super::rules::{External, Watched, own_external};
use super::steps::Builder;
use super::value::{self, Node};
use crate::axes::JointKind;
use crate::script::pose::{Configuration, Frame, OfAxis};
use crate::script::{At, Goal, PathKind, PoseForm, PoseGoal, Shift, Solution, Target};
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use std::collections::BTreeMap;
use std::sync::Arc;

/// What follows the name of a work object that a mechanical unit carries.
const ON_UNIT: &str = " on its mechanical unit";

impl Builder<'_> {
    /// `Offs(p1,0,0,100)`, `RelTool(p1,0,0,-50\Rz:=90)` with numbers that are known: the point, the displacement, and whether it
    /// counts along the tool. RelTool turns about the x, y and z of the tool, in this order, after it has moved.
    ///
    /// `displacement = ("Offs" | "RelTool") "(" point "," number "," number "," number {turn} ")"`,
    /// `turn = "\" ("Rx" | "Ry" | "Rz") ":=" number`; one that the caller may give (`\Rx?rx`) is not known
    fn displacement(&mut self, span: &Span, item: &Item) -> Option<(Span, Isometry3<f64>, bool)> {
        let p = self.f.p;
        let of_tool = match self.f.word(span.start) {
            "offs" => false,
            "reltool" => true,
            _ => return None,
        };
        let mark = |k: usize, b: u8| p.tokens.get(k).is_some_and(|t| t.kind == Kind::Mark(b));
        if span.len() < 4 || !mark(span.start + 1, b'(') || !mark(span.end - 1, b')') {
            return None;
        }
        let args = arguments(p, span.start + 2..span.end - 1);
        let [point, x, y, z] = args.as_slice() else { return None };
        let mut turn = UnitQuaternion::identity();
        let switches: Vec<Switch> = args.iter().flat_map(|a| a.switches.clone()).collect();
        for name in ["rx", "ry", "rz"] {
            let Some(s) = switches.iter().find(|s| s.name == name) else { continue };
            let angle = self.number(&s.value.clone()?, item)?.to_radians();
            let axis = match name {
                "rx" => Vector3::x_axis(),
                "ry" => Vector3::y_axis(),
                _ => Vector3::z_axis(),
            };
            turn *= UnitQuaternion::from_axis_angle(&axis, angle);
        }
        if switches.iter().any(|s| !of_tool || s.conditional || !matches!(s.name.as_str(), "rx" | "ry" | "rz")) {
            return None;
        }
        let [x, y, z] = [x, y, z].map(|a| self.number(&a.span, item));
        let by = Translation3::from(Vector3::new(x?, y?, z?) * 1e-3);
        Some((point.span.clone(), Isometry3::from_parts(by, turn), of_tool))
    }

    /// The configuration that a target of a six-axis arm orders: its third part.
    ///
    /// `confdata = "[" cf1 "," cf4 "," cf6 "," cfx "]"`
    fn configuration(&self, node: &Node) -> Solution {
        let arm = &self.robot.places().arm;
        let six = arm.len() == 6 && arm.iter().all(|a| self.robot.axis(*a).kind == JointKind::Revolute);
        let whole = |v: f64| v.fract() == 0.0 && v.abs() < 16.0;
        let conf = node.get(2).and_then(|n| n.numbers::<4>()).filter(|c| six && c.iter().all(|v| whole(*v)));
        conf.map_or(Solution::Same, |c| {
            let [cf1, cf4, cf6, cfx] = c.map(|v| v as i32);
            Solution::Configured(Configuration::Abb { quarters: [cf1, cf4, cf6], cfx })
        })
    }

    /// The pose of a move: written in it, declared, or displaced from one of these.
    ///
    /// `goal = displacement | robtarget | name ["{" index {"," index} "}"]`,
    /// `robtarget = "[" trans "," rot "," confdata "," extax "]"`
    pub fn pose_goal(
        &mut self,
        span: &Span,
        tool: Option<Arg>,
        wobj: Option<Switch>,
        item: &Item,
        path: PathKind,
        (site, external_axes): (&mut Site, &mut Arc<External>),
    ) -> Goal {
        let p = self.f.p;
        if let Some((base, by, of_tool)) = self.displacement(span, item) {
            site.point = (p.tokens[base.start].start()..p.tokens[base.end - 1].end()).into();
            let goal = self.pose_goal(&base, tool, wobj, item, path, (site, external_axes));
            let Goal::Pose(goal) = goal else { return goal };
            let shift = if of_tool { Shift::of_pose(by) } else { Shift::in_frame(by.translation.vector) };
            return Goal::pose(goal.shifted(shift));
        }
        let inline = p.tokens[span.start].kind == Kind::Mark(b'[');
        let declared = if inline { Ok(None) } else { self.name_of(span, item).map(Some) };
        let declared = match declared {
            Ok(declared) => declared,
            Err(why) => return Goal::Opaque(why),
        };
        if let Some(value) = declared.as_ref().and_then(|(d, indices)| self.declared_displaced(*d, indices, item)) {
            let point = site.point;
            let goal = self.pose_goal(&value, tool, wobj, item, path, (site, external_axes));
            site.point = point;
            // its numbers are those of another point
            let Goal::Pose(goal) = goal else { return goal };
            return Goal::pose(PoseGoal { target: None, ..*goal });
        }
        let node = match &declared {
            None => value::aggregate(self.f.text, &p.tokens, span.clone()),
            Some((d, indices)) => self.element(*d, indices),
        };
        let parts = node.as_ref().and_then(|n| Some((n.get(0)?.numbers::<3>()?, n.get(1)?.numbers::<4>()?, n.get(3)?)));
        let (Some((xyz, [w, x, y, z], external)), Some(node)) = (parts, node.as_ref()) else {
            return Goal::Opaque(self.opaque(span));
        };
        let Some(rotation) = unit(w, x, y, z) else {
            return Goal::opaque(Reason::NoQuaternion);
        };
        *external_axes = self.like_before(External::of(self.f.text, Some(external)));
        if matches!(**external_axes, External::Numbers(_)) {
            site.external = Some(String::from_utf8_lossy(self.f.text.slice(external.bytes())).into());
        }
        let frame = self.carried_frame(wobj, item, external_axes);
        let watched = if path == PathKind::Joint { self.configured.joint } else { self.configured.linear };
        let solution = self.configuration(node);
        let at = self.at(span.start);
        let target = self.pose_target(declared, node, at, external_axes);
        let tool = self.tool(tool, item);
        let position_m = Vector3::from(xyz) * 1e-3;
        let placed = value::placed(Some(external), self.robot).unwrap_or_default();
        let placed: Box<[OfAxis]> = placed.into_iter().map(|(axis, v)| OfAxis { axis, si: v.si }).collect();
        Goal::pose(PoseGoal {
            target,
            position_m,
            rotation: Some(rotation),
            frame,
            tool,
            solution,
            binding: watched != Watched::Off,
            unsure: watched == Watched::Perhaps,
            external: Some(placed).filter(|all| !all.is_empty()),
            ..PoseGoal::default()
        })
    }

    /// `CONST robtarget p2:=Offs(p1,0,0,100);`: the displacement with which a point is declared, where its names mean the same at an item.
    fn declared_displaced(&self, d: usize, indices: &[usize], item: &Item) -> Option<Span> {
        let decl = self.f.p.decls.get(d).filter(|_| indices.is_empty())?;
        let value = decl.value.clone()?;
        let same = |i: usize| {
            let word = self.f.word(i);
            let here = self.f.resolve(word, Some(item.routine), item.module);
            word.is_empty() || here == self.f.resolve(word, decl.routine, decl.module)
        };
        (value.clone().all(same) && self.is_displacement(&value, decl.module, &mut BTreeMap::from([(d, false)])))
            .then_some(value)
    }

    /// Whether a value is a displacement of points that are declared without one in the end: not of each other. `seen`: points on the way
    /// there, and whether they have been followed to the end.
    fn is_displacement(&self, value: &Span, module: usize, seen: &mut BTreeMap<usize, bool>) -> bool {
        /// Points that are declared by other points.
        const MOST: usize = 16;
        let displaced = |value: &Span| matches!(self.f.word(value.start), "offs" | "reltool");
        let mut ends = |i: usize| {
            let d = self.f.resolve(self.f.word(i), None, module);
            let decl = d.and_then(|d| self.f.p.decls.get(d));
            let further = decl.and_then(|decl| Some((d?, decl.value.clone().filter(displaced)?, decl.module)));
            let Some((d, value, module)) = further else { return true };
            if let Some(ended) = seen.get(&d) {
                return *ended;
            }
            seen.insert(d, false);
            let ended = seen.len() <= MOST && self.is_displacement(&value, module, seen);
            seen.insert(d, ended);
            ended
        };
        displaced(value) && value.clone().all(&mut ends)
    }

    /// Position of the point on the way of an arc, m, and its orientation where it is known.
    ///
    /// `via = displacement | robtarget | name ["{" index {"," index} "}"]`
    #[allow(clippy::type_complexity)]
    pub fn via(&mut self, span: &Span, item: &Item) -> Option<(Vector3<f64>, Option<UnitQuaternion<f64>>)> {
        if let Some((base, by, of_tool)) = self.displacement(span, item) {
            let via = self.via(&base, item).filter(|_| !of_tool);
            return via.map(|(at, turn)| (at + by.translation.vector, turn));
        }
        let p = self.f.p;
        let node = match p.tokens[span.start].kind {
            Kind::Mark(b'[') => value::aggregate(self.f.text, &p.tokens, span.clone()),
            _ => self.name_of(span, item).ok().and_then(|(d, indices)| self.element(d, &indices)),
        };
        let node = node?;
        let at = Vector3::from(node.get(0)?.numbers::<3>()?) * 1e-3;
        let turn = node.get(1).and_then(|n| n.numbers::<4>()).filter(|q| q.iter().any(|v| *v != 0.0));
        let turn = turn.map(|[w, x, y, z]| UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)));
        Some((at, turn))
    }

    /// The frame of a goal. A track carries the base, a positioner may carry the work object.
    fn carried_frame(&mut self, wobj: Option<Switch>, item: &Item, external_axes: &External) -> Frame {
        let own = wobj.as_ref().and_then(|w| w.value.as_ref()).map_or("wobj0".to_string(), |v| self.written(v));
        let frame = self.frame(wobj, item);
        let frame = match frame {
            // the targets do not tell where it stands
            Frame::Named(name)
                if name.ends_with(ON_UNIT) && !external_axes.used_beside([false; 6]) && self.waits_for_tasks() =>
            {
                Frame::unclear(Reason::OnOtherTask(name.trim_end_matches(ON_UNIT).into()))
            }
            frame => frame,
        };
        match external_axes.standing(own_external(self.robot)) {
            Some(axes) => frame.carried(&own, &axes),
            None => Frame::unclear(Reason::CarrierComputed),
        }
    }

    /// The numbers of a pose as a target that can be written; `declared`: where it has a name.
    fn pose_target(
        &mut self,
        declared: Option<(usize, Vec<usize>)>,
        node: &Node,
        at: At,
        external_axes: &Arc<External>,
    ) -> Option<usize> {
        let mut values = value::pose(node)?;
        values.extend(value::placed(node.get(3), self.robot)?.into_iter().map(|(_, v)| Some(v)));
        // a list with a call in it cannot be written into the instruction: the call would happen once more
        if self.f.text.slice(node.bytes()).contains(&b'(') {
            return None;
        }
        if let Some(key) = declared {
            return Some(match self.known.get(&key) {
                Some(&t) => t,
                None => self.declared_target(key.0, key.1, node, values, Some(PoseForm::Quaternion)),
            });
        }
        self.targets.push(Target { name: None, at, values, pose: Some(PoseForm::Quaternion) });
        self.externals.push(Arc::clone(external_axes));
        self.literals.push(Literal { bytes: node.bytes().into(), owner: None, foreign: None });
        Some(self.targets.len() - 1)
    }

    /// Frame of a robtarget: `wobj0`, work object data in the text, else by its name. One that the caller may give (`\WObj?WObj`) is
    /// `wobj0` in one call and another one in the next.
    ///
    /// `wobjdata = "[" robhold "," ufprog "," ufmec "," pose "," pose "]"`
    fn frame(&mut self, wobj: Option<Switch>, item: &Item) -> Frame {
        if self.displaced {
            self.displaced = false;
            let frame = self.frame(wobj, item);
            self.displaced = true;
            return frame.made("wobj0", "displaced by PDispOn or PDispSet");
        }
        let given = wobj.as_ref().is_some_and(|w| w.conditional);
        let Some(value) = wobj.and_then(|w| w.value) else { return Frame::Null };
        if given {
            return match self.named(self.written(&value), &value, item) {
                Frame::Named(name) => Frame::Computed(name),
                frame => frame,
            };
        }
        if self.predefined(&value, item) == Some("wobj0") {
            return Frame::Null;
        }
        let name = self.written(&value);
        if self.is_on_conveyor(&name) {
            return Frame::unclear(Reason::OnConveyor(name.into()));
        }
        let Some(node) = self.known_data(&value, item) else { return self.named(name, &value, item) };
        // [robhold, ufprog, ufmec, [user frame], [object frame]]
        let flag = |k: usize| match node.get(k) {
            Some(Node::Other(b)) => Some(self.f.text.slice(b.clone()).eq_ignore_ascii_case(b"true")),
            _ => None,
        };
        match (flag(0), flag(1)) {
            (Some(true), _) => Frame::unclear(Reason::RobotHolds(name.into())),
            (_, Some(false)) => self.on_unit(&name, node.get(2)),
            _ => match (node.get(3).and_then(frame_of), node.get(4).and_then(frame_of)) {
                (Some(user), Some(object)) => Frame::Given(user * object),
                _ => Frame::Named(name),
            },
        }
    }

    /// A tool or a work object that is asked for: the controller's, or one that the program sets.
    fn named(&self, name: String, span: &Span, item: &Item) -> Frame {
        let p = self.f.p;
        if self.settings.is_set_in_trap(p, span) {
            return Frame::unclear(Reason::SetInTrap(name.into()));
        }
        if self.settings.has(p, span) {
            return Frame::Computed(format!("{name}{}", self.settings.since(p, span, item)));
        }
        let declared = self.f.resolve(self.f.word(span.start), Some(item.routine), item.module);
        match declared.map(|d| self.f.certain(d)) {
            Some(Err(
                Reason::Parameter(_)
                | Reason::SetDataVal(_)
                | Reason::SetByName { .. }
                | Reason::SetElsewhere { by: Elsewhere::Sets(_), .. },
            )) => Frame::Computed(name),
            _ => Frame::Named(name),
        }
    }

    /// Whether the program moves together with other tasks, or waits for them to move.
    ///
    /// `together = "SyncMoveOn" ... | "WaitSyncTask" ...`
    fn waits_for_tasks(&self) -> bool {
        self.f.p.words.different().any(|w| matches!(w, "syncmoveon" | "waitsynctask"))
    }

    /// Whether the program waits for a work object to come along on a conveyor.
    ///
    /// `wait = "WaitWObj" wobj ["\\" "RelDist" ":=" number]`
    fn is_on_conveyor(&self, name: &str) -> bool {
        let p = self.f.p;
        if !p.words.different().any(|w| w == "waitwobj") {
            return false;
        }
        let name = name.to_lowercase();
        let waits = |item: &Item| p.words.at(item.span.start) == "waitwobj";
        p.items.iter().filter(|item| waits(item)).any(|item| p.words.within(item.span.clone()).any(|w| w == name))
    }

    /// Frame of a work object that a mechanical unit carries: known for each place of the unit, unless the targets do not tell where it
    /// stands.
    ///
    /// `ufmec = string`
    fn on_unit(&self, name: &str, unit: Option<&Node>) -> Frame {
        let unit = match unit {
            Some(Node::Other(b)) => self.f.text.slice(b.clone()).to_ascii_uppercase(),
            _ => Vec::new(),
        };
        match unit.trim_ascii_start().starts_with(b"\"ROB_") {
            true => Frame::unclear(Reason::OnOtherRobot(name.into())),
            false => Frame::Named(format!("{name}{ON_UNIT}")),
        }
    }

    /// Tool of a robtarget: `tool0`, tool data in the text, else by its name.
    ///
    /// `tooldata = "[" robhold "," pose "," loaddata "]"`
    fn tool(&mut self, tool: Option<Arg>, item: &Item) -> Frame {
        let Some(arg) = tool else { return Frame::unclear(Reason::NoTool) };
        if self.predefined(&arg.span, item) == Some("tool0") {
            return Frame::Null;
        }
        let name = self.written(&arg.span);
        // [robhold, [[x,y,z],[q1..q4]], load]
        let Some(node) = self.known_data(&arg.span, item) else { return self.named(name, &arg.span, item) };
        let held = match node.get(0) {
            Some(Node::Other(b)) => self.f.text.slice(b.clone()).eq_ignore_ascii_case(b"true"),
            _ => return Frame::Named(name),
        };
        match node.get(1).and_then(frame_of) {
            _ if !held => Frame::unclear(Reason::StandingTool(name.into())),
            Some(frame) => Frame::Given(frame),
            None => Frame::Named(name),
        }
    }
}

/// A frame of tool or work object data.
///
/// `pose = "[" trans "," rot "]"`, `trans = "[" three numbers "]"`, `rot = "[" four numbers "]"`
fn frame_of(node: &Node) -> Option<Isometry3<f64>> {
    let (xyz, [w, x, y, z]) = (node.get(0)?.numbers::<3>()?, node.get(1)?.numbers::<4>()?);
    Some(Isometry3::from_parts(Translation3::from(Vector3::from(xyz) * 1e-3), unit(w, x, y, z)?))
}

fn unit(w: f64, x: f64, y: f64, z: f64) -> Option<UnitQuaternion<f64>> {
    UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 0.1).filter(|q| q.coords.iter().all(|c| c.is_finite()))
}
