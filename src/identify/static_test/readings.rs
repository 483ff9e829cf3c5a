//! Dwells of all logs, the joint that each one tests, and pairs of approaches from both sides.
//!
//! Method: commands are grouped within their last digits. A setting is a log, a tested joint, the commands of all joints and the
//! directions from which the others came; within it, each approach from below is paired with one from above: neighbours in
//! time first, the k-th with the k-th of what is left. With a `cycle` column only approaches of one cycle meet. What
//! the other joints' gaps do is the same on both sides of a pair and cancels.

use crate::error::{Error, Place, Result, counted};
use crate::gaps::note::static_test::{Note, Remark};
use crate::log::Log;
use crate::log::dwells::{Dwell, DwellOptions, dwells, resolution};
use crate::numerics::parallel::ParMap;
use crate::robot::Robot;
use std::collections::BTreeMap;

/// Commands closer than this many deg or mm are one angle, whatever the decimals of their columns.
const SAME_PLACE: f64 = 1e-4;

/// Dwells and pairs of all logs.
#[derive(Debug, Clone)]
pub struct Readings {
    /// Per log, in the order visited.
    pub dwells: Vec<Vec<Dwell>>,
    pub pairs: Vec<Pair>,
    /// Approaches that found no partner although their place was reached from both sides, per axis.
    pub unpaired: Vec<usize>,
    pub notes: Vec<Note>,
}

/// One place reached from both sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    pub log: usize,
    pub axis: usize,
    /// Tested place of this axis, counted upwards.
    pub place: usize,
    /// Number of the setting, for averages over its cycles.
    pub setting: usize,
    /// Dwells of this log.
    pub up: usize,
    pub down: usize,
}

/// A setting: log, axis, groups of all commands, directions of the other joints.
type Key = (usize, usize, Vec<usize>, Vec<i8>);

/// Finds dwells and pairs.
pub fn collect(robot: &Robot, logs: &[Log], options: &DwellOptions) -> Result<Readings> {
    if let Some(log) = logs
        .iter()
        .find(|log| log.tcp_m.is_empty() && log.meas.iter().all(Option::is_none) && !log.instruments.has_scalar())
    {
        return Err(Error::bad(
            Place::line(&log.name, 1),
            "no measurement column",
            "`x_mm,y_mm,z_mm` of the TCP, `meas_<joint>` of a joint, `r_mm`, `r_um` or `dial_um`",
        ));
    }
    let all: Vec<Vec<Dwell>> = logs.par_map(|l| dwells(l, robot, options)).into_iter().collect::<Result<_>>()?;
    if let Some((log, _)) = logs.iter().zip(&all).find(|(_, found)| found.is_empty()) {
        return Err(Error::bad(
            Place::file(&log.name),
            format!("no dwell of {} s or more", options.min_s),
            "a static test: the robot stands still at each tested angle (or a `trigger` column that is not 0 there)",
        ));
    }
    let (settings, together) = settings(robot, logs, &all);
    let joints = pair_all(robot.dof(), &settings, &all);
    if !joints.tested.contains(&true) {
        let name = logs.first().map_or("", |l| l.name.as_str());
        return Err(Error::bad(
            Place::file(name),
            format!("{}, none of them reached by one joint alone", counted(all.iter().map(Vec::len).sum(), "dwell")),
            "a static test: one joint moves at a time, and reaches each place from below and from above",
        ));
    }
    let mut notes = joints.notes(robot);
    if together > 0 {
        notes.push(Note::NotAlone { dwells: together });
    }
    Ok(Readings { dwells: all, pairs: joints.pairs, unpaired: joints.unpaired, notes })
}

/// Dwells in one setting: one log, one moved joint, all joints at one place, the others come from one side. Second: dwells that
/// no joint reached alone.
fn settings(robot: &Robot, logs: &[Log], all: &[Vec<Dwell>]) -> (BTreeMap<Key, Vec<usize>>, usize) {
    let groups: Vec<Vec<Vec<usize>>> = (0..robot.dof()).map(|axis| group(robot, logs, all, axis)).collect();
    let mut settings: BTreeMap<Key, Vec<usize>> = BTreeMap::new();
    let mut together = 0usize;
    for (l, found) in all.iter().enumerate() {
        for (d, dwell) in found.iter().enumerate() {
            let Some(approach) = dwell.approach else {
                together += usize::from(d > 0);
                continue;
            };
            let places = groups.iter().map(|g| g[l][d]).collect();
            let mut others = dwell.dirs.clone();
            others[approach.axis] = 0;
            if logs[l].meas[approach.axis].is_some() {
                others.fill(0); // the sensor after this gear knows nothing of the others' gaps
            }
            settings.entry((l, approach.axis, places, others)).or_default().push(d);
        }
    }
    (settings, together)
}

/// The pairs, and per joint what found no partner.
struct Paired {
    pairs: Vec<Pair>,
    /// Dwells without a partner.
    unpaired: Vec<usize>,
    /// Settings that were reached from one side only.
    one_sided: Vec<usize>,
    tested: Vec<bool>,
}

fn pair_all(dof: usize, settings: &BTreeMap<Key, Vec<usize>>, all: &[Vec<Dwell>]) -> Paired {
    let mut out =
        Paired { pairs: Vec::new(), unpaired: vec![0; dof], one_sided: vec![0; dof], tested: vec![false; dof] };
    for (setting, ((log, axis, places, _), members)) in settings.iter().enumerate() {
        out.tested[*axis] = true;
        let matched = matches(&all[*log], *axis, members);
        if matched.is_empty() {
            out.one_sided[*axis] += 1;
            continue;
        }
        out.unpaired[*axis] += members.len() - 2 * matched.len();
        let place = places[*axis];
        let pair = |(up, down)| Pair { log: *log, axis: *axis, place, setting, up, down };
        out.pairs.extend(matched.into_iter().map(pair));
    }
    out.pairs.sort_by_key(|p: &Pair| (p.axis, p.place, p.log, p.up.min(p.down)));
    out
}

impl Paired {
    fn notes(&self, robot: &Robot) -> Vec<Note> {
        let mut notes = Vec::new();
        for axis in 0..robot.dof() {
            let mut note = |remark| notes.push(Note::Joint { joint: robot.axis(axis).name.clone(), remark });
            let (one_sided, unpaired) = (self.one_sided[axis], self.unpaired[axis]);
            if self.tested[axis] && !self.pairs.iter().any(|p| p.axis == axis) {
                note(Remark::AllOneSided { positions: one_sided });
            } else if one_sided > 0 {
                note(Remark::OneSided { positions: one_sided });
            }
            if unpaired > 0 {
                note(Remark::WithoutPartner { dwells: unpaired });
            }
        }
        notes
    }
}

/// Group of each dwell's command of an axis, counted upwards over all logs: `[log][dwell]`.
fn group(robot: &Robot, logs: &[Log], all: &[Vec<Dwell>], axis: usize) -> Vec<Vec<usize>> {
    let si = robot.axis(axis).kind.si_per_user_unit();
    let apart = logs.iter().map(|l| resolution(l, robot, axis)).fold(SAME_PLACE * si, f64::max);
    let mut order: Vec<(f64, usize, usize)> = Vec::new();
    for (l, found) in all.iter().enumerate() {
        order.extend(found.iter().enumerate().map(|(d, dwell)| (dwell.command[axis], l, d)));
    }
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut groups: Vec<Vec<usize>> = all.iter().map(|found| vec![0; found.len()]).collect();
    let mut now = 0;
    for (i, &(value, l, d)) in order.iter().enumerate() {
        if i > 0 && value - order[i - 1].0 > apart {
            now += 1;
        }
        groups[l][d] = now;
    }
    groups
}

/// Pairs (up, down) among the dwells of one setting, in the order of their first dwell.
fn matches(found: &[Dwell], axis: usize, members: &[usize]) -> Vec<(usize, usize)> {
    let dir = |d: usize| found[d].approach.filter(|a| a.axis == axis).map_or(0, |a| a.dir);
    let ordered = |a: usize, b: usize| if dir(a) > 0 { (a, b) } else { (b, a) };
    let mut pairs = Vec::new();
    let mut cycles: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for &d in members {
        cycles.entry(found[d].cycle).or_default().push(d);
    }
    for cycle in cycles.values() {
        let mut left = Vec::new();
        let mut i = 0;
        while i < cycle.len() {
            if i + 1 < cycle.len() && dir(cycle[i]) != dir(cycle[i + 1]) {
                pairs.push(ordered(cycle[i], cycle[i + 1]));
                i += 2;
            } else {
                left.push(cycle[i]);
                i += 1;
            }
        }
        let (up, down): (Vec<usize>, Vec<usize>) = left.iter().partition(|&&d| dir(d) > 0);
        pairs.extend(up.into_iter().zip(down));
    }
    pairs.sort_by_key(|&(a, b)| a.min(b));
    pairs
}
