//! An axis run over its samples and more between them: where a lagged joint turns, where a stuck one comes loose.

use super::speed;
use crate::effects::{Between, Effect, Stage, Track, Turn, apply_stage};

/// Runs over the samples of a track and more between them; gives the rows.
pub(super) fn run_wide(track: &Track, between: &[(usize, f64, f64)], effects: &[&Effect], last: Stage) -> Vec<f64> {
    let more = More::new(track, between);
    let wide = more.track(track);
    let mut all = wide.p.to_vec();
    apply_stage(Stage::Servo, &wide, effects.iter().copied(), &mut all);
    if last == Stage::Gear {
        apply_stage(Stage::Gear, &wide, effects.iter().copied(), &mut all);
    }
    match track.rows {
        None => pick(all, Some(&more.place)),
        Some(rows) => rows.iter().map(|&r| all[more.place[r as usize] as usize]).collect(),
    }
}

/// The samples of a track and some more between them.
struct More {
    t_s: Vec<f64>,
    p: Vec<f64>,
    dir: Vec<i8>,
    turns: Vec<Turn>,
    speed: Vec<f64>,
    load: Vec<f64>,
    /// Where each old sample stands.
    place: Vec<u32>,
    /// Where the rows stand that determine the motion between samples.
    rows: Vec<u32>,
}

impl More {
    /// `found`: `(sample before, t, p)`, rising.
    fn new(track: &Track, found: &[(usize, f64, f64)]) -> Self {
        let n = track.len() + found.len();
        let mut m = Self {
            t_s: Vec::with_capacity(n),
            p: Vec::with_capacity(n),
            dir: Vec::with_capacity(n),
            turns: track.turns.to_vec(),
            speed: Vec::new(),
            load: Vec::new(),
            place: Vec::with_capacity(track.len()),
            rows: Vec::new(),
        };
        let mut next = found.iter().peekable();
        for i in 0..track.len() {
            m.place.push(m.t_s.len() as u32);
            m.t_s.push(track.t_s[i]);
            m.p.push(track.p[i]);
            m.dir.push(track.dir[i]);
            while let Some(&&(_, t, p)) = next.peek().filter(|f| f.0 == i) {
                next.next();
                m.t_s.push(t);
                m.p.push(p);
                m.dir.push(track.dir.get(i + 1).copied().unwrap_or(track.dir[i]));
            }
        }
        for turn in &mut m.turns {
            turn.index = m.place[turn.index] as usize;
        }
        let rows: Vec<u32> = match (track.between, track.rows) {
            // the corners of a program are separate samples
            (Between::Straight, _) | (_, None) => m.place.clone(),
            (_, Some(rows)) => rows.iter().map(|&r| m.place[r as usize]).collect(),
        };
        m.rows = rows;
        if !track.tcp_speed_m_s.is_empty() {
            m.speed = speed::between(track.tcp_speed_m_s, &m.place, &m.t_s);
        }
        if !track.load.is_empty() {
            m.load = speed::between(track.load, &m.place, &m.t_s);
        }
        m
    }

    fn track<'a>(&'a self, of: &Track<'a>) -> Track<'a> {
        let mut track =
            Track::known(&self.t_s, &self.p, &self.dir[..], &self.turns[..]).with_initial_gap_side(of.initial_gap_side);
        track.between = of.between;
        track.rows = Some(&self.rows);
        track.tcp_speed_m_s = &self.speed;
        track.load = &self.load;
        // the rows that determine the motion are the same
        track.cubics = of.cubics;
        track.rev = of.rev;
        track
    }
}

/// The rows of a signal, in its own memory.
pub(super) fn pick(mut signal: Vec<f64>, rows: Option<&[u32]>) -> Vec<f64> {
    let Some(rows) = rows else { return signal };
    // a row stands at its own place or after it, but for rows that share the last sample
    if rows.iter().enumerate().any(|(row, &at)| row > at as usize) {
        return rows.iter().map(|&at| signal[at as usize]).collect();
    }
    for (row, &at) in rows.iter().enumerate() {
        signal[row] = signal[at as usize];
    }
    signal.truncate(rows.len());
    signal
}
