//! The kinematics file `lostmotion/kinematics/1` (YAML, degrees or millimetres) to and from [`Learned`].
//!
//! ```yaml
//! schema: lostmotion/kinematics/1
//! robot: {name: ..., sha256: ...}
//! kind: augmented                 # or plain
//! inputs:                         # u = (command - centre) / half_range; the networks are valid within -1..1
//!   E1: {centre_deg: 0.0, half_range_deg: 28.8}
//! networks:                       # x_mm = offset_mm + sum of out_mm / (1 + exp(-(bias + sum of w u)))
//!   x: {offset_mm: 1.5, neurons: [[w_E1, ..., bias, out_mm], ...]}
//! evidence: {seed: 1, ...}
//! ```
//! A file that was taught on another robot is refused by its fingerprint.

use super::kinematics::{Evidence, Input, Kind, LETTERS, Learned, Rmse};
use super::network::Network;
use crate::error::{Error, Result};
use crate::gaps::LogRef;
use crate::io::{input, yaml, yaml::Document};
use crate::robot::Robot;
use indexmap::IndexMap;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The schema that a file of learned kinematics names.
pub const SCHEMA: &str = "lostmotion/kinematics/1";
/// Weights beyond this are damage: a trained one is far below, and sums of larger ones lose their digits.
const LARGEST: f64 = 1e9;
/// Neurons beyond this are damage.
const MOST_NEURONS: usize = 10_000;

#[derive(Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct KinematicsFile {
    schema: String,
    robot: RobotRef,
    kind: String,
    inputs: IndexMap<String, IndexMap<String, f64>>,
    networks: IndexMap<String, NetworkFile>,
    #[serde(default)]
    evidence: EvidenceFile,
}

#[derive(Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct RobotRef {
    #[serde(default)]
    name: String,
    sha256: String,
}

#[derive(Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct NetworkFile {
    offset_mm: f64,
    neurons: Vec<Vec<f64>>,
}

#[derive(Debug, Default, Serialize, Deserialize, schemars::JsonSchema)]
struct EvidenceFile {
    #[serde(default)]
    logs: Vec<FileRef>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    programs: Vec<FileRef>,
    #[serde(default)]
    seed: u64,
    #[serde(default)]
    train_rows: usize,
    #[serde(default)]
    test_rows: usize,
    #[serde(default)]
    rmse: IndexMap<String, IndexMap<String, f64>>,
}

#[derive(Debug, Serialize, Deserialize, schemars::JsonSchema)]
struct FileRef {
    name: String,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    sha256: String,
}

impl Learned {
    /// Reads and checks a kinematics file for `robot`.
    pub fn load(path: &Path, robot: &Robot) -> Result<Self> {
        let (text, input) = input::read_text(path)?;
        let learned = Self::parse(&input.name, &text, robot)?;
        Ok(Self { file: Some(LogRef { name: input.name, sha256: input.sha256 }), ..learned })
    }

    /// Parses and checks the text of a kinematics file; `name` stands in messages.
    pub fn parse(name: &str, text: &str, robot: &Robot) -> Result<Self> {
        let doc = Document { name, text };
        let file: KinematicsFile = doc.parse_schema("a kinematics file", SCHEMA)?;
        doc.require_schema(&file.schema, SCHEMA)?;
        let ours = robot.fingerprint();
        if file.robot.sha256 != ours {
            let short = |s: &str| s.chars().take(12).collect::<String>();
            return Err(Error::bad(
                doc.place(&["sha256"]),
                format!("kinematics of robot `{}` ({})", file.robot.name, short(&file.robot.sha256)),
                format!("those of `{}` ({}): same lengths, angles, base and tool", robot.name, short(&ours)),
            ));
        }
        let kind = match file.kind.as_str() {
            "plain" => Kind::Plain,
            "augmented" => Kind::Augmented,
            other => {
                return Err(Error::bad(doc.place(&["kind"]), format!("kind `{other}`"), "`plain` or `augmented`"));
            }
        };
        let inputs = read_inputs(&file.inputs, robot, &doc)?;
        let mut networks: Vec<(usize, Network)> = Vec::new();
        for (letter, network) in file.networks {
            let Some(c) = LETTERS.iter().position(|l| *l == letter) else {
                let place = doc.place(&["networks"]);
                return Err(Error::bad(place, format!("a network of `{letter}`"), "networks of x, y, z"));
            };
            networks.push((c, network.build(&letter, robot.dof(), &doc)?));
        }
        if networks.is_empty() {
            return Err(Error::bad(doc.place(&["networks"]), "no network", "one or more of x, y, z"));
        }
        networks.sort_by_key(|(c, _)| *c);
        let (coordinates, networks): (Vec<_>, Vec<_>) = networks.into_iter().unzip();
        let evidence = file.evidence.build(&coordinates);
        Ok(Self {
            robot_name: file.robot.name,
            robot_sha256: file.robot.sha256,
            kind,
            coordinates,
            inputs,
            networks,
            evidence,
            file: None,
        })
    }

    /// The document.
    pub fn to_yaml(&self, robot: &Robot) -> Result<String> {
        let input = |(joint, input): (&crate::robot::Joint, &Input)| {
            let unit = joint.kind.unit();
            let values = [("centre", input.centre), ("half_range", input.half_range)];
            let entry = values.map(|(key, v)| (format!("{key}_{unit}"), joint.kind.to_user_unit(v)));
            (joint.name.clone(), IndexMap::from(entry))
        };
        let network = |(&c, n): (&usize, &Network)| {
            let neuron = |(w, b, v): (&[f64], f64, f64)| w.iter().copied().chain([b, v * 1e3]).collect();
            let file = NetworkFile { offset_mm: n.offset() * 1e3, neurons: n.parts().map(neuron).collect() };
            (LETTERS[c].to_string(), file)
        };
        yaml::to_text(&KinematicsFile {
            schema: SCHEMA.into(),
            robot: RobotRef { name: self.robot_name.clone(), sha256: self.robot_sha256.clone() },
            kind: self.kind.text().into(),
            inputs: robot.axis_joints().zip(&self.inputs).map(input).collect(),
            networks: self.coordinates.iter().zip(&self.networks).map(network).collect(),
            evidence: EvidenceFile::of(&self.evidence, &self.coordinates),
        })
    }
}

fn read_inputs(file: &IndexMap<String, IndexMap<String, f64>>, robot: &Robot, doc: &Document) -> Result<Vec<Input>> {
    if let Some(name) = file.keys().find(|n| robot.axis_named(n).is_none()) {
        let expected = format!("the joints {}", robot.axis_names().join(", "));
        return Err(Error::bad(doc.place(&["inputs"]), format!("an input of `{name}`"), expected));
    }
    let mut inputs = Vec::with_capacity(robot.dof());
    for joint in robot.axis_joints() {
        let unit = joint.kind.unit();
        let keys = [format!("centre_{unit}"), format!("half_range_{unit}")];
        let entry = file.iter().find(|(n, _)| n.eq_ignore_ascii_case(&joint.name)).map(|(_, e)| e);
        let values = keys.each_ref().map(|k| entry.and_then(|e| e.get(k)).copied().filter(|v| v.is_finite()));
        match values {
            [Some(centre), Some(half)] if half >= 0.0 && entry.is_some_and(|e| e.len() == 2) => {
                inputs.push(Input {
                    centre: centre * joint.kind.si_per_user_unit(),
                    half_range: half * joint.kind.si_per_user_unit(),
                });
            }
            _ => {
                let expected = format!("`{}: {{{}: number, {}: number of 0 or more}}`", joint.name, keys[0], keys[1]);
                let found = format!("no such input of {}", joint.name);
                return Err(Error::bad(doc.place(&[&joint.name]), found, expected));
            }
        }
    }
    Ok(inputs)
}

impl NetworkFile {
    fn build(self, letter: &str, inputs: usize, doc: &Document) -> Result<Network> {
        let place = || doc.place(&["networks"]);
        let numbers = inputs + 2;
        if self.neurons.is_empty() || self.neurons.len() > MOST_NEURONS {
            let found = format!("{} neurons of {letter}", self.neurons.len());
            return Err(Error::bad(place(), found, format!("1 to {MOST_NEURONS}")));
        }
        if let Some(i) = self.neurons.iter().position(|n| n.len() != numbers) {
            let found = format!("neuron {} of {letter} with {} numbers", i + 1, self.neurons[i].len());
            let expected = format!("{numbers}: a weight for each of {inputs} joints, bias, out_mm");
            return Err(Error::bad(place(), found, expected));
        }
        let hidden = self.neurons.len();
        let mut weights = Vec::with_capacity(Network::count(inputs, hidden));
        for neuron in &self.neurons {
            weights.extend(&neuron[..numbers - 1]);
            weights.push(neuron[numbers - 1] * 1e-3);
        }
        weights.push(self.offset_mm * 1e-3);
        match weights.iter().find(|w| !w.is_finite() || w.abs() > LARGEST) {
            Some(w) => Err(Error::bad(place(), format!("the number {w} in the network of {letter}"), "weights")),
            None => Ok(Network { inputs, hidden, weights }),
        }
    }
}

impl EvidenceFile {
    fn of(e: &Evidence, coordinates: &[usize]) -> Self {
        let reference = |r: &LogRef| FileRef { name: r.name.clone(), sha256: r.sha256.clone() };
        let mut rmse = IndexMap::new();
        for (k, &c) in coordinates.iter().enumerate() {
            let mut of = IndexMap::new();
            for (part, all) in [("train", &e.train), ("test", &e.test)] {
                let Some(r) = all.get(k) else { continue };
                of.insert(format!("position_{part}_mm"), r.position_m * 1e3);
                if let Some(v) = r.speed_m_s {
                    of.insert(format!("velocity_{part}_mm_s"), v * 1e3);
                }
            }
            rmse.insert(LETTERS[c].to_string(), of);
        }
        Self {
            logs: e.logs.iter().map(reference).collect(),
            programs: e.programs.iter().map(reference).collect(),
            seed: e.seed,
            train_rows: e.train_rows,
            test_rows: e.test_rows,
            rmse,
        }
    }

    fn build(self, coordinates: &[usize]) -> Evidence {
        let part = |part: &str| -> Vec<Rmse> {
            let of = |&c: &usize| {
                let of = self.rmse.get(LETTERS[c])?;
                let position_m = of.get(&format!("position_{part}_mm"))? * 1e-3;
                Some(Rmse { position_m, speed_m_s: of.get(&format!("velocity_{part}_mm_s")).map(|v| v * 1e-3) })
            };
            coordinates.iter().map(of).collect::<Option<_>>().unwrap_or_default()
        };
        let (train, test) = (part("train"), part("test"));
        let refs = |all: Vec<FileRef>| all.into_iter().map(|r| LogRef { name: r.name, sha256: r.sha256 }).collect();
        Evidence {
            logs: refs(self.logs),
            programs: refs(self.programs),
            seed: self.seed,
            train_rows: self.train_rows,
            test_rows: self.test_rows,
            train,
            test,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    fn robot() -> Robot {
        let text = "schema: lostmotion/robot/1\njoints:\n  - {name: A1, kind: revolute, a_mm: 500}\n  - {name: Z, kind: prismatic}\n";
        Robot::parse("robot.yaml", text).unwrap()
    }

    fn learned() -> Learned {
        let mut generator = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let robot = robot();
        Learned {
            robot_name: robot.name.clone(),
            robot_sha256: robot.fingerprint(),
            kind: Kind::Augmented,
            coordinates: vec![0, 2],
            inputs: vec![Input { centre: 0.1, half_range: 0.5 }, Input { centre: 0.02, half_range: 0.01 }],
            networks: (0..2).map(|_| Network::random(2, 3, 0.1, 0.2, &mut generator)).collect(),
            evidence: Evidence { seed: 7, ..Evidence::default() },
            file: None,
        }
    }

    #[test]
    fn a_file_that_is_read_again_gives_the_same_kinematics() {
        let (robot, ours) = (robot(), learned());
        let text = ours.to_yaml(&robot).unwrap();
        let again = Learned::parse("k.yaml", &text, &robot).unwrap();
        for q in [[0.0, 0.02], [0.5, 0.013], [-0.4, 0.03]] {
            let (a, b) = (ours.position_m(&q), again.position_m(&q));
            assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-14), "{a:?} {b:?}");
        }
        assert_eq!(again.coordinates, [0, 2]);
        assert_eq!(again.evidence.seed, 7);
    }

    #[test]
    fn the_jacobian_is_that_of_finite_differences() {
        let ours = learned();
        let q = [0.2, 0.017];
        let (_, jac) = ours.position_and_jacobian(&q);
        for a in 0..2 {
            let h = 1e-6;
            let at = |d: f64| {
                let mut x = q;
                x[a] += d;
                ours.position_m(&x)
            };
            let (up, down) = (at(h), at(-h));
            for k in 0..2 {
                assert!(((up[k] - down[k]) / (2.0 * h) - jac[k][a]).abs() < 1e-6 * jac[k][a].abs().max(1.0));
            }
        }
    }

    #[test]
    fn damaged_files_are_refused_with_their_place() {
        let robot = robot();
        let good = learned().to_yaml(&robot).unwrap();
        for (from, to, says) in [
            ("kind: augmented", "kind: deep", "kind `deep`"),
            ("lostmotion/kinematics/1", "lostmotion/robot/1", "schema"),
            ("centre_deg", "center_deg", "input of A1"),
            ("half_range_mm: 10.0", "half_range_mm: .nan", "input of Z"),
            ("  z:", "  w:", "network of `w`"),
            ("offset_mm: 100.0", "offset_mm: 1e300", "1e300"),
            (&robot.fingerprint(), "0000", "kinematics of robot"),
        ] {
            let bad = good.replacen(from, to, 1);
            assert_ne!(bad, good, "{from} is not in the file");
            let e = Learned::parse("k.yaml", &bad, &robot).unwrap_err().to_string();
            let numbers = e.contains(says) || says == "1e300" && e.contains("1000000");
            assert!(e.starts_with("k.yaml") && numbers, "{from}: {e}");
        }
    }
}
