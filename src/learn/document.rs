//! What was learned, as JSON (`lostmotion/learning/1`) and as a table in the manner of Cursi (2022) Table II.

use super::{LETTERS, Note, Rmse, TrainingResult};
use crate::error::Result;
use crate::error::counted;
use crate::gaps::file::{number, value};
use serde::Serialize;
use serde_json::{Map, Value};
use std::fmt::Write;

/// The schema that the document names.
pub const SCHEMA: &str = "lostmotion/learning/1";

/// The document.
#[derive(Serialize, schemars::JsonSchema)]
pub(crate) struct Learning<'a> {
    schema: &'static str,
    robot: Named<'a>,
    kind: &'static str,
    hidden: usize,
    seed: u64,
    rows: TrainAndTest<usize>,
    coordinates: Map<String, Value>,
    #[schemars(with = "Vec<String>")]
    notes: &'a [Note],
}

#[derive(Serialize, schemars::JsonSchema)]
struct Named<'a> {
    name: &'a str,
    sha256: &'a str,
}

#[derive(Serialize, schemars::JsonSchema)]
struct TrainAndTest<T> {
    train: T,
    test: T,
}

#[derive(Serialize, schemars::JsonSchema)]
struct Coordinate {
    train: Option<RmseJson>,
    test: Option<RmseJson>,
    nominal: TrainAndTest<Option<RmseJson>>,
    stop: Option<&'static str>,
    steps: Option<usize>,
}

/// Root mean squares of the errors.
#[derive(Serialize, schemars::JsonSchema)]
struct RmseJson {
    position_mm: Value,
    velocity_mm_s: Option<Value>,
}

impl RmseJson {
    fn of(all: &[Rmse], k: usize) -> Option<Self> {
        let r = all.get(k)?;
        let velocity_mm_s = r.speed_m_s.map(|v| number(v * 1e3));
        Some(Self { position_mm: number(r.position_m * 1e3), velocity_mm_s })
    }
}

impl TrainingResult {
    /// The JSON document; lengths in mm, velocities in mm/s.
    ///
    /// # Errors
    /// Internal, where it cannot be written as JSON.
    pub fn to_json(&self) -> Result<Value> {
        let (l, e) = (&self.learned, &self.learned.evidence);
        let (train, test) = self.nominal.as_ref().map_or((&[][..], &[][..]), |n| (&n.train, &n.test));
        let mut coordinates = Map::new();
        for (k, &c) in l.coordinates.iter().enumerate() {
            let t = self.training.get(k);
            let one = Coordinate {
                train: RmseJson::of(&e.train, k),
                test: RmseJson::of(&e.test, k),
                nominal: TrainAndTest { train: RmseJson::of(train, k), test: RmseJson::of(test, k) },
                stop: t.map(|t| t.reason.text()),
                steps: t.map(|t| t.steps),
            };
            coordinates.insert(LETTERS[c].into(), value(&one)?);
        }
        value(&Learning {
            schema: SCHEMA,
            robot: Named { name: &l.robot_name, sha256: &l.robot_sha256 },
            kind: l.kind.text(),
            hidden: l.networks.first().map_or(0, |n| n.hidden),
            seed: e.seed,
            rows: TrainAndTest { train: e.train_rows, test: e.test_rows },
            coordinates,
            notes: &self.notes,
        })
    }

    /// A table for a terminal.
    pub fn to_text(&self) -> String {
        let l = &self.learned;
        let e = &l.evidence;
        let hidden = l.networks.first().map_or(0, |n| n.hidden);
        let mut text = format!(
            "{} network, {}, seed {}: {} learned from, {} tested on\n\n",
            l.kind.text(),
            counted(hidden, "neuron"),
            e.seed,
            counted(e.train_rows, "row"),
            e.test_rows
        );
        let _ =
            writeln!(text, "{:<10}{:<12}{:>12}{:>12}{:>14}{:>14}", "RMSE", "", "position mm", "", "velocity mm/s", "");
        let _ = writeln!(text, "{:<10}{:<12}{:>12}{:>12}{:>14}{:>14}", "", "", "train", "test", "train", "test");
        for (k, &c) in l.coordinates.iter().enumerate() {
            let mut line = |who: &str, train: &[Rmse], test: &[Rmse]| {
                let p = |all: &[Rmse]| all.get(k).map_or("-".into(), |r| format!("{:.4}", r.position_m * 1e3));
                let v = |all: &[Rmse]| {
                    all.get(k).and_then(|r| r.speed_m_s).map_or("-".into(), |v| format!("{:.4}", v * 1e3))
                };
                let (pt, ps, vt, vs) = (p(train), p(test), v(train), v(test));
                let _ = writeln!(text, "{:<10}{who:<12}{pt:>12}{ps:>12}{vt:>14}{vs:>14}", LETTERS[c]);
            };
            line("learned", &e.train, &e.test);
            if let Some(n) = &self.nominal {
                line("nominal", &n.train, &n.test);
            }
        }
        text
    }
}
