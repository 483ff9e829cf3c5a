//! A motion instruction as a step: its target, speed, zone and tool, and why no point may be added before it.
//!
//! Grammar (ABB, Technical reference manual, RAPID Instructions, Functions and Data types):
//! `MoveJ [\Conc] ToPoint [\ID] Speed [\V] | [\T] Zone [\Z] [\Inpos] Tool [\WObj]`; `MoveC` has `CirPoint` before `ToPoint`; process
//! instructions (`ArcL`, `SpotL`) have their own arguments between speed and tool.

use super::super::arguments::{Arg, Switch, positional};
use super::super::facts;
use super::super::lex::Kind;
use super::super::read::{Item, Span};
use super::super::reason::Reason;
use super::super::rules::External;
use super::super::value::Node;
use super::super::words::{self, Leads, Motion};
use super::{Builder, plain};
use crate::error::Result;
use crate::rapid::built::{SharedSite, Site, Written};
use crate::script::pose::Frame;
use crate::script::{self, Break, Few, Goal, How, Move, OtherWay, PathKind, Speed, StepKind};
use nalgebra::UnitQuaternion;
use std::collections::BTreeSet;
use std::sync::Arc;

/// Orientations that differ by less are taught as the same, rad.
const SAME_TURN_RAD: f64 = 0.05;

/// Which of the arguments are target, speed, zone and tool, and the byte after the instruction.
struct Places {
    goal: usize,
    speed: Option<usize>,
    zone: Option<usize>,
    tool: Option<usize>,
    end: usize,
}

/// The switch of this name (lower case) of any argument.
fn switch(args: &[Arg], name: &str) -> Option<Switch> {
    args.iter().flat_map(|a| &a.switches).find(|s| s.name == name).cloned()
}

impl Builder<'_> {
    /// Adds the steps of a motion instruction; `alone`: it is the one statement of an IF.
    ///
    /// `motion = word argument {"," argument} ";"`
    ///
    /// # Errors
    /// Bad input where it has no target, or a target that is none.
    pub(super) fn motion(&mut self, item: &Item, motion: Motion, args: Vec<Arg>, alone: bool) -> Result<()> {
        let p = self.f.p;
        let token = item.span.start;
        let calls = facts::called(p, item).any(|name| words::motion(name).is_none() && self.f.may_move(name));
        if calls {
            self.push(token, StepKind::Break(Break::Call));
        }
        if motion.leads == Leads::External && self.robot.places().external.is_empty() {
            self.external = Some(Arc::default());
            self.push(token, StepKind::Dwell(None));
            return Ok(());
        }
        let at = self.places(item, &motion, &args)?;
        let mut site = Site {
            bytes: (p.tokens[token].start()..at.end).into(),
            word: (p.tokens[token].start()..p.tokens[token].end()).into(),
            goal: at.goal as u16,
            point: args[at.goal].bytes.clone().into(),
            zone: at.zone.map(|k| k as u16),
            via: self.via_of_splittable(item, at.goal, &args).map(|k| k as u16),
            ..Site::default()
        };
        let synchronised = switch(&args, "id").is_some() || self.synchronised;
        let mut closed = closed(&motion, alone, calls, synchronised, site.via.is_some());
        let (speed, blend_m) = self.pace(item, &args, &at, &mut site, &mut closed);
        let mut external_axes = Arc::default();
        let goal = self.goal(item, &motion, &args, &at, (&mut site, &mut external_axes))?;
        let led = self.going.led.is_some() || self.led_by_switch(&args).is_some();
        let absolute = !led && self.is_absolute(&motion, &goal, &args[at.goal].span, item);
        let other_way = self.leave_way(&motion, &goal, &site, external_axes, &mut closed);
        let goal = self.on_arc(goal, item, &motion, &args, at.goal, &mut closed);
        self.keep_points_of(&goal, &args[at.goal].span, item);
        let switched_on =
            switch(&args, "on").map(|_| true).or(switch(&args, "off").filter(|s| !s.conditional).map(|_| false));
        site.args = args.into_iter().map(Written::from).collect();
        let how = How { path: motion.path, closed, speed, blend_m, absolute, other_way, ..How::default() };
        let k = self.push(token, StepKind::Move(Move::new(how, goal, Few::new())));
        self.steps.place(k, SharedSite::of(site));
        self.after_motion(token, &motion, switched_on);
        Ok(())
    }

    /// Which argument is what.
    ///
    /// `arguments = [via ","] target "," speed "," ... zone "," ... tool ...`; each by its name (`ToPoint:=`) or by its place
    fn places(&mut self, item: &Item, motion: &Motion, args: &[Arg]) -> Result<Places> {
        let p = self.f.p;
        let token = item.span.start;
        let goal = named(args, &["topoint", "tojointpos"]).or_else(|| positional(args, motion.target));
        let (Some(goal), Some(semicolon)) = (goal, p.tokens.get(item.span.end)) else {
            let word = self.f.text.slice(p.tokens[token].start()..p.tokens[token].end());
            let found = format!("`{}` without a target", String::from_utf8_lossy(word));
            return Err(self.f.text.bad(p.tokens[token].start(), found, "its arguments: target, speed, zone, tool"));
        };
        // process moves have it last, whatever stands before
        let text = |k: usize| p.tokens.get(args[k].span.start).map(|t| t.kind) == Some(Kind::String);
        let last = || (0..args.len()).rev().find(|&k| k > goal + 2 && !args[k].span.is_empty() && !text(k));
        Ok(Places {
            goal,
            speed: named(args, &["speed"]).or_else(|| positional(args, motion.target + 1)),
            zone: self.zone_at(item, motion, args),
            tool: named(args, &["tool"])
                .or_else(|| if motion.tool_third { positional(args, motion.target + 3) } else { last() }),
            end: semicolon.end(),
        })
    }

    /// Speed and radius of the zone, m; the time of `\T` goes into the site.
    ///
    /// `pace = "\" "T" ":=" seconds | "\" "V" ":=" number | speeddata`,
    /// `corner = "\" "Z" ":=" number | zonedata`
    fn pace(
        &mut self,
        item: &Item,
        args: &[Arg],
        at: &Places,
        site: &mut Site,
        closed: &mut Option<script::Reason>,
    ) -> (Speed, Option<f64>) {
        let time = switch(args, "t").map(|s| s.value.and_then(|v| plain(self.f.text, self.f.p, &v)));
        site.time = time
            .as_ref()
            .and_then(|t| t.as_ref())
            .filter(|t| t.0 > 0.0)
            .map(|(s, st, b)| Box::new((b.clone(), *s, *st)));
        if time.is_some() && site.time.is_none() {
            closed.get_or_insert_with(|| Reason::TimeComputed.into());
        }
        let [v, z] = ["v", "z"].map(|name| switch(args, name).map(|s| if s.conditional { None } else { s.value }));
        let speed = match (site.time.as_deref(), v) {
            (Some((_, s, _)), _) => Speed::Seconds(*s),
            (None, _) if time.is_some() => Speed::Unknown,
            (None, Some(None)) => Speed::Unknown,
            (None, Some(Some(v))) => self.number(&v, item).map_or(Speed::Unknown, |v| Speed::Tcp(v * 1e-3)),
            (None, None) => at.speed.map_or(Speed::Unknown, |k| self.speed(&args[k].span.clone(), item)),
        };
        let blend_m = match z {
            Some(None) => None,
            Some(Some(z)) => self.number(&z, item).map(|z| z * 1e-3),
            None => at.zone.and_then(|k| self.zone(&args[k], item)),
        };
        (speed, blend_m)
    }

    /// Where the motion leads.
    ///
    /// `goal = target ["\" "WObj" ":=" wobjdata] ["\" ("Corr" | "Track" | "Weave") ...]`
    fn goal(
        &mut self,
        item: &Item,
        motion: &Motion,
        args: &[Arg],
        at: &Places,
        into: (&mut Site, &mut Arc<External>),
    ) -> Result<Goal> {
        let span = args[at.goal].span.clone();
        let goal = match motion.leads {
            Leads::Joints => self.joint_goal(&span, item)?,
            Leads::Pose => {
                let tool = at.tool.map(|k| args[k].clone());
                self.pose_goal(&span, tool, switch(args, "wobj"), item, motion.path, into)
            }
            Leads::Search => Goal::opaque(Reason::Search),
            Leads::External => Goal::opaque(Reason::ExternalAlone),
        };
        Ok(self.led_away(goal, self.led_by_switch(args)))
    }

    /// The switch of a motion that leads it off its path.
    fn led_by_switch(&self, args: &[Arg]) -> Option<&'static str> {
        ["corr", "track", "weave"].into_iter().find(|name| switch(args, name).is_some())
    }

    /// Why no point may be added on the way to this goal, and why it is another one than its path says.
    fn leave_way(
        &mut self,
        motion: &Motion,
        goal: &Goal,
        site: &Site,
        external_axes: Arc<External>,
        closed: &mut Option<script::Reason>,
    ) -> Option<OtherWay> {
        if self.going.wrist && motion.path != PathKind::Joint {
            closed.get_or_insert_with(|| Reason::SingArea.into());
        }
        if let Leads::Pose | Leads::Search = motion.leads
            && site.external.is_none()
            && matches!(goal, Goal::Pose(_))
        {
            closed.get_or_insert_with(|| Reason::ExternalComputed.into());
        }
        if motion.path == PathKind::Curve && !matches!(goal, Goal::Pose(_)) {
            closed.get_or_insert_with(|| Reason::Arc.into());
        }
        let carried = self.external_axes_move(goal, external_axes);
        if carried {
            closed.get_or_insert_with(|| Reason::ExternalMove.into());
        }
        let arc = motion.path == PathKind::Curve;
        match () {
            () if motion.path == PathKind::Joint => None,
            () if self.going.wrist => Some(OtherWay::Wrist),
            () if arc && self.arcs_turn_otherwise() => Some(OtherWay::Orientation),
            () if carried => Some(OtherWay::Carried),
            () => None,
        }
    }

    /// The goal of an arc, with the point on its way: the argument before the goal's.
    fn on_arc(
        &mut self,
        goal: Goal,
        item: &Item,
        motion: &Motion,
        args: &[Arg],
        goal_at: usize,
        closed: &mut Option<script::Reason>,
    ) -> Goal {
        match goal {
            Goal::Pose(mut pose) if motion.path == PathKind::Curve && goal_at > 0 => {
                let via = self.via(&args[goal_at - 1].span.clone(), item);
                pose.via_m = via.map(|v| v.0);
                // a point of another orientation may turn the tool on its way
                let turns = |r: UnitQuaternion<f64>| pose.rotation.is_none_or(|own| own.angle_to(&r) > SAME_TURN_RAD);
                if via.is_none_or(|v| v.1.is_none_or(turns)) || pose.target.is_none() {
                    closed.get_or_insert_with(|| Reason::Arc.into());
                }
                Goal::Pose(pose)
            }
            other => other,
        }
    }

    /// The goal of a motion that something leads off its path: an instruction before it, or its own switch.
    fn led_away(&self, goal: Goal, switch: Option<&'static str>) -> Goal {
        match (self.going.led, switch) {
            (Some(by), _) => Goal::opaque(Reason::Led(by)),
            (None, Some(name)) => Goal::opaque(Reason::LedBySwitch(name)),
            (None, None) => goal,
        }
    }

    /// Whether orientations on arcs may go otherwise than straight from start to end, by any module of the task.
    ///
    /// `setting = "CirPathMode" ["\\" ("PathFrame" | "ObjectFrame" | "CirPointOri" | "Wrist45" | "Wrist46" | "Wrist56")]`; without a switch
    /// it is the first
    fn arcs_turn_otherwise(&self) -> bool {
        let said = |word: &str| self.f.p.words.different().any(|w| w == word);
        said("cirpathmode") && ["cirpointori", "wrist45", "wrist46", "wrist56"].into_iter().any(said)
    }

    /// Which argument is the point on the way of a MoveC that several may replace: nothing in the program may steer the
    /// orientation on arcs.
    fn via_of_splittable(&self, item: &Item, goal_at: usize, args: &[Arg]) -> Option<usize> {
        let at = goal_at.checked_sub(1)?;
        // the words of all modules of the task
        let said = |word: &str| self.f.p.words.different().any(|w| w == word);
        let steered = said("cirpathmode") || said("singarea") && said("wrist");
        let own = |k: usize| args.get(k).is_some_and(|a| a.name.is_empty() && a.switches.is_empty());
        (self.f.word(item.span.start) == "movec" && !steered && own(at) && own(goal_at)).then_some(at)
    }

    /// Place of the zone among the arguments.
    fn zone_at(&mut self, item: &Item, motion: &Motion, args: &[Arg]) -> Option<usize> {
        named(args, &["zone"]).or_else(|| {
            let after = positional(args, motion.target + 2)?;
            if motion.tool_third {
                return Some(after);
            }
            (after..args.len()).find(|&k| self.zone(&args[k], item).is_some())
        })
    }

    /// A process that the motion switches, and work at its end.
    fn after_motion(&mut self, token: usize, motion: &Motion, switched_on: Option<bool>) {
        if let Some(on) = motion.process.or(switched_on.filter(|_| !motion.plain)) {
            self.push(token, StepKind::Process(on));
        }
        if motion.works {
            self.push(token, StepKind::Dwell(None));
        }
    }

    /// The speed of speed data.
    ///
    /// `speeddata = "[" number ... "]" | name`
    fn speed(&mut self, span: &Span, item: &Item) -> Speed {
        if let Some(node) = self.node(span, item) {
            return node.get(0).and_then(Node::number).map_or(Speed::Unknown, |v| Speed::Tcp(v * 1e-3));
        }
        match self.predefined(span, item).and_then(words::speed_mm_s) {
            Some(v) if v.is_finite() => Speed::Tcp(v * 1e-3),
            Some(_) => Speed::Share(1.0),
            None => Speed::Unknown,
        }
    }

    /// Radius of a zone, m.
    ///
    /// `zonedata = "[" ("TRUE" | "FALSE") "," number ... "]" | name`
    fn zone(&mut self, arg: &Arg, item: &Item) -> Option<f64> {
        if let Some(node) = self.node(&arg.span, item) {
            // [finep, pzone_tcp, ...]
            let items = node.list().filter(|l| l.len() == 7)?;
            let Node::Other(b) = &items[0] else { return None };
            return match self.f.text.slice(b.clone()).to_ascii_lowercase().as_slice() {
                b"true" => Some(0.0),
                b"false" => items[1].number().map(|mm| mm * 1e-3),
                _ => None,
            };
        }
        self.predefined(&arg.span, item).and_then(words::zone_mm).map(|mm| mm * 1e-3)
    }

    /// Says from where on a tool or a work object is asked for by another name, where a move asks for it.
    pub(super) fn note_assignments(&mut self) {
        let goals = (0..self.steps.next()).filter_map(|k| match &self.steps.get(k)?.kind {
            StepKind::Move(Move { goal: Goal::Pose(pose), .. }) => Some([&pose.frame, &pose.tool]),
            _ => None,
        });
        let computed = |frame: &Frame| if let Frame::Computed(name) = frame { Some(name.to_lowercase()) } else { None };
        let asked: BTreeSet<String> = goals.flatten().filter_map(computed).collect();
        let all: Vec<(usize, String)> = self.settings.assignments(&asked).collect();
        for (token, name) in all {
            self.note(token, format!("asked for after this line as `{name}`"));
        }
    }
}

/// Place of an argument by its name.
fn named(args: &[Arg], names: &[&str]) -> Option<usize> {
    args.iter().position(|a| names.contains(&a.name.as_str()))
}

/// Why no point can be added before a motion.
fn closed(motion: &Motion, alone: bool, calls: bool, synchronised: bool, splittable: bool) -> Option<script::Reason> {
    let own = match motion.path {
        _ if alone => Reason::InIf,
        _ if calls => return Some(script::Reason::CallInArguments),
        PathKind::Curve if !splittable => Reason::Arc,
        PathKind::Curve if synchronised => Reason::Synchronised,
        PathKind::Curve => return None,
        _ if !motion.plain => Reason::Actions,
        _ if synchronised => Reason::Synchronised,
        _ => return None,
    };
    Some(own.into())
}
