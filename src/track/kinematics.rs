//! The kinematics that a path is tracked with: nominal, of a model file, or learned.
//!
//! Of a model file only what moves the geometry counts here (`link_error`, `tool_error`): `rewrite --model` undoes its joint
//! errors, static ones and lost motion, so that program and machine meet exactly once. A learned kinematics holds everything
//! that is a function of the commands, in the frame of its logs.

use super::LETTERS;
use crate::error::{Error, Place, Result};
use crate::learn::Learned;
use crate::machine::geometry;
use crate::model::Model;
use crate::robot::{Chain, Robot};
use nalgebra::{DMatrix, DVector, Vector3};

/// From commands to some coordinates of the TCP.
#[derive(Debug, Clone)]
pub struct Kinematics {
    source: Source,
    /// 0, 1, 2 for x, y, z; rising.
    pub coordinates: Vec<usize>,
    /// Range of each axis in which the kinematics holds, rad or m.
    pub range: Vec<[f64; 2]>,
}

#[derive(Debug, Clone)]
enum Source {
    Chain(Box<Chain>),
    /// And the network of each coordinate.
    Learned(Box<Learned>, Vec<usize>),
}

const EVERYWHERE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

impl Kinematics {
    /// Of the robot file.
    pub fn nominal(robot: &Robot, coordinates: &[usize]) -> Self {
        Self {
            source: Source::Chain(Box::new(robot.chain().clone())),
            coordinates: coordinates.to_vec(),
            range: vec![EVERYWHERE; robot.dof()],
        }
    }

    /// Of a model file: its robot with its geometry effects, in the robot's base frame.
    pub fn of_model(model: &Model, coordinates: &[usize]) -> Self {
        Self::nominal(&geometry(&model.robot, &model.effects), coordinates)
    }

    /// As learned; `file` stands in the refusal of a coordinate that was not.
    pub fn learned(learned: Learned, coordinates: &[usize], file: &str) -> Result<Self> {
        let network = |c: &usize| learned.coordinates.iter().position(|k| k == c);
        let networks: Option<Vec<usize>> = coordinates.iter().map(network).collect();
        let Some(networks) = networks else {
            let letters = |all: &[usize]| all.iter().map(|&c| LETTERS[c]).collect::<Vec<_>>().join(", ");
            let found = format!("kinematics of {}", letters(&learned.coordinates));
            let expected = format!("{}, the coordinates of the path", letters(coordinates));
            return Err(Error::bad(Place::file(file), found, expected));
        };
        let range = learned.inputs.iter().map(|i| i.range()).collect();
        Ok(Self { source: Source::Learned(Box::new(learned), networks), coordinates: coordinates.to_vec(), range })
    }

    /// Coordinates at `q` (rad or m), m.
    pub fn position_m(&self, q: &[f64]) -> DVector<f64> {
        match &self.source {
            Source::Chain(chain) => self.pick(&chain.position(q)),
            Source::Learned(l, networks) => {
                let u = l.scaled(q);
                DVector::from_iterator(networks.len(), networks.iter().map(|&k| l.networks[k].value(&u)))
            }
        }
    }

    /// The same with the Jacobian, one row a coordinate, m/rad or m/m.
    pub fn position_and_jacobian(&self, q: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let mut jacobian = DMatrix::zeros(self.coordinates.len(), q.len());
        match &self.source {
            Source::Chain(chain) => {
                let mut columns = vec![Vector3::zeros(); q.len()];
                let p = chain.position_and_jacobian(q, &mut columns);
                for (k, &c) in self.coordinates.iter().enumerate() {
                    for (a, column) in columns.iter().enumerate() {
                        jacobian[(k, a)] = column[c];
                    }
                }
                (self.pick(&p), jacobian)
            }
            Source::Learned(l, networks) => {
                let (position, slopes) = l.position_and_jacobian(q);
                for (k, &n) in networks.iter().enumerate() {
                    jacobian.row_mut(k).iter_mut().zip(&slopes[n]).for_each(|(j, s)| *j = *s);
                }
                (DVector::from_iterator(networks.len(), networks.iter().map(|&n| position[n])), jacobian)
            }
        }
    }

    fn pick(&self, p: &Vector3<f64>) -> DVector<f64> {
        DVector::from_iterator(self.coordinates.len(), self.coordinates.iter().map(|&c| p[c]))
    }
}
