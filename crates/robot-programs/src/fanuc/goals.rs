//! Where motions lead: positions of /POS, registers with the values of a listing, offsets; and the step of a motion.

use super::Motion;
use super::instruction;
use super::motion::MotionInstruction;
use super::positions::{self, Position};
use super::read::Reader;
use super::reason::Reason;
use crate::registers::Register;
use crate::script::pose::{Configuration, Shift, Solution};
use crate::script::{self, At, Break, Few, Frame, Goal, How, Move, OtherWay, PathKind, PoseGoal, StepKind};
use nalgebra::{Translation3, UnitQuaternion, Vector3};

/// What makes another frame or tool of one while the program runs.
const SET: &str = "as the program sets it";

impl Reader<'_> {
    /// Where a motion to a register leads, whose value a listing tells.
    fn registered(&mut self, n: u64, line: u64) -> Goal {
        // a register holds values of the other groups, too
        let alone = self.taught.positions.iter().all(|p| p.others.is_empty());
        let places = self.robot.places();
        // the six values of a register are those of the axes in their order
        if !(alone && places.certain && places.external.is_empty() && places.numbers.iter().copied().eq(1..=6)) {
            return Goal::opaque(Reason::Register);
        }
        let goal = match self.registers.value(n) {
            Err(why) => return Goal::opaque(why),
            Ok(Register::Joints(deg)) => Goal::Joints(self.taught.stands(n, line, *deg)),
            Ok(Register::Pose(values, configuration)) => {
                let [Some(frame), Some(tool)] = self.selected else {
                    return Goal::opaque(Reason::RegisterFrame(n));
                };
                let sets = self.uses.sets.has_frame(Some(frame)) || self.uses.sets.has_tool(Some(tool));
                let [frame, tool] = [positions::named(Some(frame), "user frame"), positions::named(Some(tool), "tool")];
                if sets {
                    return Goal::opaque(Reason::RegisterFrameSet(n));
                }
                Goal::pose(listed_pose(values, *configuration, frame, tool))
            }
        };
        self.used.entry(n).or_insert(line);
        goal
    }

    /// The displacement by a register whose value a listing tells: along the axes of the tool, or of the user frame.
    fn displacement(&mut self, said: &MotionInstruction, line: u64) -> Option<Shift> {
        let (of_tool, _) = said.offset.as_ref()?;
        let n = said.offset_by?;
        let Ok(Register::Pose(v, _)) = self.registers.value(n) else { return None };
        // what a rotation turns about depends on the controller's settings
        if v[3..].iter().any(|angle| *angle != 0.0) {
            return None;
        }
        self.used.entry(n).or_insert(line);
        let by = Vector3::new(v[0], v[1], v[2]) * 1e-3;
        Some(if *of_tool { Shift::of_pose(Translation3::from(by).into()) } else { Shift::in_frame(by) })
    }

    /// The tool of a position.
    fn tool(&self, position: &Position) -> Frame {
        let tool = positions::named(position.tool, "tool");
        if self.uses.sets.has_tool(position.tool) { tool.made("0", SET) } else { tool }
    }

    /// The Cartesian target of a position.
    fn pose(&self, position: usize) -> Option<PoseGoal> {
        let mut pose = self.taught.pose(position, self.robot)?;
        let own = self.taught.positions.get(position)?;
        if self.uses.sets.has_frame(own.frame) {
            pose.frame = pose.frame.made("0", SET);
        }
        pose.tool = self.tool(own);
        Some(pose)
    }

    /// The point on the way of an arc, in the frame of its goal, m.
    fn via(&self, index: u64, goal: usize) -> Option<Vector3<f64>> {
        let p = self.taught.by_index.get(&index).copied().filter(|_| self.uses.written(index).is_none())?;
        let positions = &self.taught.positions;
        let same = positions[p].frame == positions[goal].frame && self.uses.written_any.is_none();
        self.pose(p).filter(|_| same).map(|pose| pose.position_m)
    }

    /// Where `P[n]` leads; `position`: its place in /POS; `offset`: a register that moves it.
    fn goal(&mut self, n: u64, position: Option<usize>, said: &MotionInstruction, line: u64) -> Goal {
        let offset = &said.offset;
        let Some(p) = position else { return Goal::opaque(Reason::NotInPos(n)) };
        if let Some(line) = self.uses.written(n).or(self.uses.written_any) {
            return Goal::opaque(Reason::Written { position: n, line });
        }
        match self.taught.joints[p].clone() {
            Ok(_) if offset.is_some() => Goal::opaque(Reason::Offset),
            Ok(t) => Goal::Joints(t),
            Err(why) => match (self.pose(p), self.displacement(said, line)) {
                (None, _) => Goal::Opaque(why),
                (Some(pose), Some(shift)) => Goal::pose(pose.shifted(shift)),
                (Some(pose), None) => Goal::pose(displaced(pose, offset)),
            },
        }
    }

    /// Whether all axes and groups but the robot's stand still on the way to a position.
    fn others_stand(&self, position: Option<usize>) -> bool {
        match (self.before, position) {
            _ if self.taught.idle => true,
            (Some(a), Some(b)) => self.taught.extras[a] == self.taught.extras[b],
            _ => false,
        }
    }

    /// Why no point may come before a motion, whatever its words are.
    fn closed(&self, position: Option<usize>, goal: &Goal, motion: Option<&Motion>) -> Option<script::Reason> {
        let still = self.others_stand(position);
        let further = matches!(goal, Goal::Pose(_)) && !self.robot.places().certain;
        let uncounted = self.uncounted && motion.is_some_and(|m| m.number.is_some());
        let own = match () {
            () if !still => Reason::OthersMove,
            () if further => Reason::UnclearAxes,
            () if motion.is_none() => return Some(script::Reason::NoCopy),
            () if uncounted => Reason::NoLineCount,
            () => return None,
        };
        Some(own.into())
    }

    /// A motion to a position selects its frame and tool, or the controller stops, or it does not check: where others were selected, none
    /// is known.
    fn select_by(&mut self, position: Option<usize>, elsewhere: bool) {
        if let Some(own) = position.and_then(|p| self.taught.positions.get(p)) {
            let own = [own.frame, own.tool];
            for (selected, own) in self.selected.iter_mut().zip(own) {
                *selected = if selected.is_none_or(|s| Some(s) == own) { own } else { None };
            }
        }
        if elsewhere {
            self.selected = [None, None];
        }
    }

    /// Whether a goal that cannot be determined is a separate whole position: a register, or a position that is chosen, written or offset
    /// while the program runs. `besides`: the motion counts from where the robot stands, may end on its way, or is coordinated with another
    /// group.
    fn is_absolute(&self, goal: &Goal, besides: (bool, bool, bool)) -> bool {
        let Goal::Opaque(script::Reason::Fanuc(why)) = goal else { return false };
        let places = self.robot.places();
        // an external axis of which the position says nothing stays where it is
        let alone = places.certain && places.external.is_empty();
        let whole = matches!(
            **why,
            Reason::Register
                | Reason::NotListed(_)
                | Reason::RegisterFrame(_)
                | Reason::RegisterFrameSet(_)
                | Reason::RegisterSet { .. }
                | Reason::RegisterMayBeSet { .. }
                | Reason::Written { .. }
                | Reason::IndexComputed
                | Reason::Offset
        );
        whole && alone && besides == (false, false, false) && !self.tracks && self.led_now == 0
    }

    pub(super) fn motion(&mut self, at: At, said: MotionInstruction) {
        let position = said.goal.as_ref().ok().and_then(|n| self.taught.by_index.get(n).copied());
        let register = said.register.filter(|_| said.offset.is_none() && !self.tracks && self.led_now == 0);
        let register = register.filter(|_| !(said.relative || said.coordinated || said.path == PathKind::Curve));
        let goal = match said.goal.clone() {
            Err(why) if said.is_register(&why) && register.is_some() => {
                register.map_or(Goal::Opaque(why), |n| self.registered(n, at.line))
            }
            Err(why) => Goal::Opaque(why),
            Ok(_) if self.tracks || self.led_now != 0 => {
                let by = instruction::led_by(self.led_now).unwrap_or("a conveyor that the program tracks");
                Goal::opaque(Reason::Led(by))
            }
            Ok(_) if said.coordinated && !self.taught.leader_stands() => Goal::opaque(Reason::LeaderMoves),
            Ok(n) => self.goal(n, position, &said, at.line),
        };
        let goal = match (goal, &said.via[..], position) {
            (Goal::Pose(pose), [via], Some(p)) if said.path == PathKind::Curve => {
                Goal::pose(PoseGoal { via_m: self.via(*via, p), ..*pose })
            }
            (goal, ..) => goal,
        };
        let absolute = self.is_absolute(&goal, (said.relative, said.skips, said.coordinated));
        let closed = said.closed.or_else(|| self.closed(position, &goal, said.motion.as_ref()));
        let fixed = register.filter(|_| position.is_none() && !matches!(goal, Goal::Opaque(_)));
        let fixed = fixed.map(|n| Reason::Listed(n).into());
        let closed = closed.or_else(|| fixed.as_ref().map(|_| Reason::ToRegister.into()));
        // a position that is no part of the program does not tell
        let carried = matches!(goal, Goal::Pose(_)) && position.is_some() && !self.others_stand(position);
        let other_way = said.wrist.then_some(OtherWay::Wrist).or_else(|| carried.then_some(OtherWay::Carried));
        self.before = position;
        self.select_by(position, said.process.is_some() || said.skips || said.calls);
        if let Some(motion) = said.motion {
            self.steps.place(self.steps.next(), motion);
        }
        let straight = said.path == PathKind::Linear && matches!(goal, Goal::Joints(_));
        let tool = position.filter(|_| straight).map(|p| Box::new(self.tool(&self.taught.positions[p])));
        let selected = || Box::new(positions::named(self.selected[1], "tool"));
        let tool = tool.or_else(|| (straight && position.is_none()).then(selected));
        let how = How {
            path: said.path,
            closed,
            speed: said.speed,
            blend_m: said.blend_m,
            tool,
            relative: said.relative,
            absolute,
            fixed,
            other_way,
            end_trigger: said.end_trigger.map(Box::new),
            ..How::default()
        };
        self.push(at, StepKind::Move(Move::new(how, goal, Few::new())));
        if let Some(on) = said.process {
            self.push(at, StepKind::Process(on));
        }
        if said.skips {
            self.push(at, StepKind::Break(Break::Jump));
        }
    }
}

/// The pose of a register.
fn listed_pose(values: &[f64; 6], configuration: Configuration, frame: Frame, tool: Frame) -> PoseGoal {
    let [w, p, r] = [values[3], values[4], values[5]].map(f64::to_radians);
    PoseGoal {
        position_m: Vector3::new(values[0], values[1], values[2]) * 1e-3,
        rotation: Some(UnitQuaternion::from_euler_angles(w, p, r)),
        frame,
        tool,
        solution: Solution::Configured(configuration),
        binding: true,
        ..PoseGoal::default()
    }
}

/// A pose that is moved by a position register: in its own frame, or for its own tool.
fn displaced(mut pose: PoseGoal, offset: &Option<(bool, String)>) -> PoseGoal {
    if let Some((of_tool, text)) = offset {
        let place = if *of_tool { &mut pose.tool } else { &mut pose.frame };
        *place = std::mem::take(place).made("0", &format!("with {text}"));
    }
    pose
}
