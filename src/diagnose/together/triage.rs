//! Is this a machine on which everything is wrong? Asked before the search for a few effects, of a thinned copy of the logs.
//!
//! Method: lags, gaps, gravity and geometry are fitted together, with the noise of what is left; counted are the lags and gaps
//! that held-out blocks support far beyond chance. The search for a few effects finds no more than four.

use super::super::prepare;
use super::{groups, members};
use crate::effects::Effect;
use crate::log::Log;
use crate::model::Model;

/// Rows of each log that are looked at.
const ROWS: usize = 1500;
/// Supported lags and gaps that make such a machine.
const MANY: usize = 5;
/// Gain on held-out blocks, in 2 ln L, beyond which one counts.
const CLEAR: f64 = 40.0;

/// More effects than the search for a few can find.
pub fn many(model: &Model, logs: &[Log]) -> bool {
    if logs.iter().any(|l| l.poses || l.tcp_m.is_empty()) {
        return false;
    }
    let Ok((mut problem, start)) = prepare::problem_of_at_most(model, logs, ROWS) else { return false };
    let machine = groups(&mut problem, &start).0.settled(&problem);
    let support = members::support(&problem, &machine);
    let fit = &machine.fit;
    let counts = |k: &usize| {
        let effect = &fit.hypothesis.effects[fit.free[*k]].effect;
        matches!(effect, Effect::ServoLag(_) | Effect::Backlash(_)) && support[*k] > CLEAR
    };
    let clear = (0..support.len()).filter(counts).count();
    if std::env::var_os("LM_DEBUG").is_some() {
        for k in 0..support.len() {
            let e = &fit.hypothesis.effects[fit.free[k]];
            eprintln!("{} {} {:?} {:.1}", e.effect.name(), e.target_text(&problem.robot), e.effect.values(), support[k]);
        }
        eprintln!("triage {clear}");
    }
    clear >= MANY
}
