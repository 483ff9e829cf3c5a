//! Whether a joint is worth its offsets in a run where its steps are spread over a travel.
//!
//! While a step is spread the joint first stands by the whole gap, which is twice what it is off without compensation, and catches up
//! along the ramp. Method: the gap of the joint as a play (Krasnosel'skii and Pokrovskii 1989), once under the commands that come out and
//! once under those of the program; mean square of the distance to the program's own positions over time. Assumption: straight lines
//! between the points, and no friction.

use super::run::Run;
use super::task::Task;
use crate::rewrite::OutputPoints;
use crate::rewrite::offset::Offset;
use crate::rewrite::points::Origin;

/// Parts of a line between two points at which the joint is looked at.
const PARTS: u32 = 8;

/// Mean square distance of the joint from the program's positions with what came out, over that with the program itself. `None`: not known.
pub(super) fn left(task: &Task, run: &Run, out: &OutputPoints, axis: usize) -> Option<f64> {
    let offset = Offset::new(task.compensator.on(axis).filter(|_| !task.robot.has_sums())?);
    let own: Vec<f64> = out.origin.iter().map(|origin| own(run, *origin, axis)).collect::<Option<_>>()?;
    let commands: Vec<f64> = (0..out.len()).map(|i| out.row(i)[axis]).collect();
    let before = error(&offset, &own, &own, &out.t_s);
    (before > 0.0).then(|| error(&offset, &commands, &own, &out.t_s) / before)
}

/// Position of the program itself at a point that comes out, rad or m.
fn own(run: &Run, origin: Origin, axis: usize) -> Option<f64> {
    let at = |n: u64| run.vertices.get(usize::try_from(n).ok()?)?.q.get(axis).copied();
    match origin {
        Origin::Point(n) => at(n),
        Origin::Inserted { after, fraction } => {
            let (from, to) = (at(after)?, at(after + 1)?);
            Some(from + fraction * (to - from))
        }
    }
}

/// Integral of the squared distance of a joint behind its gap from where it should be, over time, or over the points without times.
fn error(offset: &Offset, commands: &[f64], wanted: &[f64], t_s: &[f64]) -> f64 {
    let Some(&first) = wanted.first() else { return 0.0 };
    let (mut stands, mut sum) = (first, 0.0);
    for i in 1..commands.len().min(wanted.len()) {
        let weight = if t_s.is_empty() { 1.0 } else { t_s[i] - t_s[i - 1] };
        for part in 1..=PARTS {
            let share = f64::from(part) / f64::from(PARTS);
            let between = |v: &[f64]| v[i - 1] + share * (v[i] - v[i - 1]);
            let (c, p) = (between(commands), between(wanted));
            // moving up it is dragged from above the gap, moving down from below
            let (low, high) = (c - offset.gap(1, p), c + offset.gap(-1, p));
            stands = stands.max(low).min(high.max(low));
            sum += weight * (stands - p).powi(2);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compensator::{BacklashOffset, JointCompensator};
    use crate::effects::GapCurve;

    #[test]
    fn a_ramp_as_long_as_the_stroke_is_worse_than_no_offset_and_a_short_one_is_better() {
        let backlash = Some(BacklashOffset::symmetric(GapCurve::Constant(1.0)));
        let offset = Offset::new(&JointCompensator { axis: 0, backlash, friction: None });
        let stroke = 100.0;
        // up and down, over and over; the offset goes from one side to the other along the ramp
        let (mut wanted, mut steep, mut slow) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..800 {
            let (turns, travel) = (k / 100, f64::from(k % 100));
            let (sense, from) = if turns % 2 == 0 { (1.0, 0.0) } else { (-1.0, stroke) };
            let p = from + sense * travel;
            let ramped = |ramp: f64| p + sense * (2.0 * (travel / ramp).min(1.0) - 1.0);
            wanted.push(p);
            steep.push(ramped(5.0));
            slow.push(ramped(stroke));
        }
        let [none, steep, slow] = [&wanted, &steep, &slow].map(|c| error(&offset, c, &wanted, &[]));
        assert!(steep < 0.2 * none && slow > none, "{steep} {none} {slow}");
    }
}
