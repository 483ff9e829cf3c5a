//! A trajectory through the stages of one axis: after its servo, after its gear.

use super::*;
use crate::effects::servo_lag::{command_between, cubics};
use crate::effects::{Between, Effect, Stage, Track, apply_stage};
use crate::machine::wide::{pick, run_wide};

impl CommandTrajectory {
    /// Motor side of an axis, row by row: what the servo makes of the command. Effects of other stages are ignored.
    pub fn servo(&self, axis: usize, effects: &[&Effect], initial_gap_side: i8) -> Vec<f64> {
        self.run(axis, effects, initial_gap_side, Stage::Servo)
    }

    /// After the gear of an axis, row by row. Effects of later stages are ignored.
    pub fn gear(&self, axis: usize, effects: &[&Effect], initial_gap_side: i8) -> Vec<f64> {
        self.run(axis, effects, initial_gap_side, Stage::Gear)
    }

    fn run(&self, axis: usize, effects: &[&Effect], initial_gap_side: i8, last: Stage) -> Vec<f64> {
        let mut track = self.track(axis).with_initial_gap_side(initial_gap_side);
        if effects.iter().any(|e| e.uses_tcp_speed()) {
            track.tcp_speed_m_s = self.sample_speed(axis);
        }
        if self.between == Between::Smooth && !self.is_stationary(axis) && effects.iter().any(|e| e.filters_in_time()) {
            track.cubics = self.axes[axis].cubics.get_or_init(|| cubics(&track));
        }
        let loaded = last == Stage::Gear && effects.iter().any(|e| e.uses_load());
        let still;
        if loaded {
            if self.is_stationary(axis) {
                // the load may change while the joint is stationary
                still = vec![0i8; self.rows()];
                track = Track::known(self.clock(), &self.cmd[axis], &still[..], &[][..])
                    .with_initial_gap_side(initial_gap_side);
                track.between = self.between;
                track.rev = self.axes[axis].rev;
            }
            track.load = self.sample_load(axis);
        }
        if let Some(between) = self.between_samples(&track, effects, last) {
            return run_wide(&track, &between, effects, last);
        }
        let mut signal = track.p.to_vec();
        apply_stage(Stage::Servo, &track, effects.iter().copied(), &mut signal);
        if last == Stage::Gear {
            apply_stage(Stage::Gear, &track, effects.iter().copied(), &mut signal);
        }
        if self.is_stationary(axis) && !loaded {
            signal.resize(self.rows(), signal.first().copied().unwrap_or(0.0));
            return signal;
        }
        let rows = self.samples(axis).2;
        pick(signal, rows)
    }

    /// Further samples that a servo lag needs: where the lagged joint turns, if its gear remembers turning points; and many after
    /// each turn of the command, if the lag filters a stiction, whose way out of the stick no row shows.
    fn between_samples(&self, track: &Track, effects: &[&Effect], last: Stage) -> Option<Vec<(usize, f64, f64)>> {
        let at = effects.iter().position(|e| e.filters_in_time())?;
        if self.settled() || track.len() < 2 {
            return None;
        }
        let spike = effects[..at].iter().map(|e| e.sticks_by()).fold(0.0, f64::max);
        let turns_matter = last == Stage::Gear && effects.iter().any(|e| e.stage() == Stage::Gear && e.has_memory());
        if spike <= 0.0 && !turns_matter {
            return None;
        }
        let mut found = if turns_matter { effects[at].turning_points(track) } else { Vec::new() };
        if spike > 0.0 {
            for (turn, samples) in track.strokes() {
                for j in samples.take(MOST_STUCK) {
                    let (t0, t1) = (track.t_s[j - 1], track.t_s[j]);
                    for k in 1..SUBSAMPLES {
                        let t = t0 + (t1 - t0) * f64::from(k) / f64::from(SUBSAMPLES);
                        found.push((j - 1, t, command_between(track, j - 1, t)));
                    }
                    if (track.p[j] - turn.p).abs() > spike {
                        break;
                    }
                }
            }
            found.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
            found.dedup_by(|a, b| a.1 == b.1);
        }
        Some(found)
    }
}
