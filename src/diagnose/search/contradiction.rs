//! What is taken as known put in doubt: one frame for all logs, the model's registration, the sizes of its own effects.
//!
//! Method: after all that was found, would a frame for each log, or another size of a known effect, explain a good part of
//! what is left? And would another registration alone do as much as all found effects? Nothing is changed: the model is its
//! user's.

use crate::diagnose::candidates::structure::Ratio;
use crate::diagnose::noise::whitening::Whitening;
use crate::diagnose::note::{Note, OtherSize};
use crate::diagnose::problem::forward::Problem;
use crate::diagnose::problem::normal::{dot, gram};
use crate::diagnose::problem::normal::{orthonormal, project_off};
use crate::diagnose::problem::residual::rms;
use crate::diagnose::search::fit::{self, Fit};
use crate::numerics::fisher;
use crate::numerics::normal_equations::pseudo_inverse;
use crate::numerics::parallel::ParMap;
use nalgebra::DVector;

/// Another size of a known effect is a contradiction where it leaves less than this part of the gap, rms.
const OTHER_SIZE: f64 = 0.8;
/// Logs are in different frames where separate frames leave less than this part of the gap, rms.
const OWN_FRAMES: f64 = 0.5;
/// Another frame is reported where alone it leaves no more than so many times what the found effects leave.
const AS_GOOD: f64 = 1.5;
/// Or where alone it takes all but this part of the gap.
const NEARLY_ALL: f64 = 0.1;
/// Steps of a frame's fit: its first step leaves a thousandth.
const STEPS: usize = 4;

/// What the logs say against what was taken as known.
#[derive(Debug, Clone)]
pub struct Contradiction {
    /// What it is.
    pub note: Note,
    pub ratio: Ratio,
    /// What it explains of the gap, rms per coordinate, m (rad for joints).
    pub rms: f64,
}

/// Contradictions of logs and model, that of the frames first.
pub(in crate::diagnose) fn find(problem: &Problem, fit: &Fit, known: usize) -> Vec<Contradiction> {
    stations(problem, fit).into_iter().chain(sizes(problem, fit, known)).collect()
}

/// Logs that share a frame and should not: each with its own frame is fitted far better.
fn stations(problem: &Problem, fit: &Fit) -> Option<Contradiction> {
    let measured = |l: &usize| problem.logs[*l].is_tracked();
    let logs: Vec<usize> = (0..problem.logs.len()).filter(measured).collect();
    if logs.len() < 2 || fit.hypothesis.frames.len() > 1 {
        return None;
    }
    let columns: Vec<Vec<f64>> = logs
        .iter()
        .flat_map(|&l| {
            problem.frame_columns(&fit.state, 0).into_iter().map(move |mut c| {
                problem.groups.iter().filter(|g| g.log != l).for_each(|g| c[g.range()].fill(0.0));
                c
            })
        })
        .collect();
    let mut left = fit.state.residual.clone();
    let basis = orthonormal(columns);
    project_off(&basis, &mut left);
    let (shared, own) = (rms(problem, &fit.state.residual), rms(problem, &left));
    if own >= OWN_FRAMES * shared {
        return None;
    }
    // six parameters a log, of which one frame was fitted already
    let dof = basis.len().saturating_sub(6).max(1);
    let (before, after) = (dot(&fit.state.residual, &fit.state.residual), dot(&left, &left));
    let free = problem.n.saturating_sub(basis.len()).max(1) as f64;
    let gain = (before - after) * free / after.max(f64::MIN_POSITIVE);
    let p_value = fisher::tail(gain / dof as f64, dof as f64, free);
    Some(Contradiction {
        note: Note::NotInOneFrame { own_m: own, shared_m: shared },
        ratio: Ratio { axis: None, aspect: None, gain, dof, p_value },
        rms: (shared * shared - own * own).sqrt(),
    })
}

/// The model's registration, where another frame alone explains as much as the effects that were found.
pub(in crate::diagnose) fn registration(problem: &Problem, fit: &Fit, known: usize) -> Option<Note> {
    if problem.frames_free || fit.free.is_empty() || !problem.groups.iter().any(|g| g.dims == 3) {
        return None;
    }
    let mut h = fit.hypothesis.clone();
    h.effects.truncate(known);
    let first = h.frames[0];
    let mut state = problem.evaluate(&h);
    let given = rms(problem, &state.residual);
    for _ in 0..STEPS {
        let columns = problem.frame_columns(&state, 0);
        let right = DVector::from_iterator(6, columns.iter().map(|c| dot(c, &state.residual)));
        let step = pseudo_inverse(&gram(&columns), 1e-9) * right;
        h.move_frame(0, step.as_slice());
        state = problem.evaluate(&h);
    }
    let (other, found) = (rms(problem, &state.residual), rms(problem, &fit.state.residual));
    let moved = first.inverse() * h.frames[0];
    (other < AS_GOOD * found || other < NEARLY_ALL * given).then(|| Note::OtherFrame {
        moved_m: moved.translation.vector.norm(),
        turned_rad: moved.rotation.angle(),
        left_m: other,
        given_m: given,
        found_m: found,
    })
}

/// The known effect whose size fits worst, where another size leaves far less. Noise is taken for white: what lasts would else
/// be taken for slow noise, as the misfit of a gap lasts from turn to turn.
fn sizes(problem: &Problem, fit: &Fit, known: usize) -> Option<Contradiction> {
    let white = Whitening::white(problem, &fit.state.residual);
    let refitted = |i: usize| {
        let free: Vec<usize> = std::iter::once(i).chain(fit.free.iter().copied()).collect();
        fit::refit(problem, &fit.hypothesis, &free, &white)
    };
    let left = |f: &Fit| rms(problem, &f.state.residual);
    let others: Vec<Fit> = (0..known).par_map(refitted);
    let (i, best) = others.iter().enumerate().min_by(|a, b| left(a.1).total_cmp(&left(b.1)))?;
    let (before, after) = (left(fit), left(best));
    if after >= OTHER_SIZE * before {
        return None;
    }
    let (old, new) = (&fit.hypothesis.effects[i], &best.hypothesis.effects[i]);
    let dof = old.effect.values().len();
    let free = problem.n.saturating_sub(best.parameters()).max(1) as f64;
    let gain = (before * before / (after * after) - 1.0) * free;
    let p_value = fisher::tail(gain / dof as f64, dof as f64, free);
    let sizes: Vec<OtherSize> = old
        .keys(&problem.robot)
        .into_iter()
        .zip(old.effect.values().iter().zip(new.effect.values()))
        .map(|((key, factor), (old, new))| OtherSize { key, fitted: new * factor, given: old * factor })
        .collect();
    let note = Note::KnownEffectDiffers {
        effect: old.effect.name(),
        target: old.target_text(&problem.robot),
        sizes,
        left_m: after,
        given_m: before,
    };
    Some(Contradiction {
        note,
        ratio: Ratio { axis: old.axis(), aspect: None, gain, dof, p_value },
        rms: (before * before - after * after).sqrt(),
    })
}
