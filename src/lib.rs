//! `lostmotion` takes lost motion out of robot programs before they reach the controller.
//!
//! The modules, and the one direction in which they know each other, are drawn in `docs/architecture.md`. The feature `cli`
//! (on by default) adds the command line and the reports; without it the library needs neither.
//!
//! - [`robot`], [`log`], [`program`], [`model`]: what is read: an arm, a motion as measured, a program, a machine with its faults.
//! - [`effects`]: the catalogue of faults; [`machine`]: from commands to measurements through all of them; [`simulate`]: a predicted log.
//! - [`identify`]: logs to [`gaps`]; [`fit`]: gaps to a [`compensator`]; [`rewrite`]: a program with its offsets.
//! - [`diagnose`]: what a model lacks of its logs; [`plan`]: motions that tell more; [`assess`]: programs, circles and lines before and
//!   after.
//! - [`join`]: two recordings on one clock; [`learn`], [`track`]: kinematics by networks, and paths through them.
//! - [`numerics`], [`io`], [`error`], [`name`], [`schemas`]: fits, files, refusals, file names, schemas of documents.
//!
//! The whole job through the API, with the samples of the repository: a robot, a log of its motion, the gaps of its joints, a
//! compensator, a rewritten program.
//!
//! ```
//! use lostmotion::{fit, identify::path, log::Log, program::Program, rewrite, robot::Robot};
//! use std::path::Path;
//! # fn main() -> Result<(), lostmotion::error::Error> {
//! let robot = Robot::load(Path::new("configs/kuka-kr120-r2500-pro.yaml"))?;
//!
//! // the gap of each joint that reverses, from the measured motion of the TCP
//! let log = Log::load(Path::new("samples/circle/circle_uncompensated_table3.csv.gz"), &robot)?;
//! let found = path::identify(&robot, &[log], &path::Options::default())?;
//! let a1 = found.gaps.joints.iter().find(|j| j.axis == 0).expect("A1 reverses on this path");
//! assert!((a1.half_gap.to_degrees() - 0.0028).abs() < 3e-5);
//!
//! // the offsets that undo the gaps
//! let compensator = fit::fit(&robot, &[found.gaps], fit::Form::Decay)?;
//!
//! // the program with the offsets: its own points, and new ones that carry the steps
//! let program = Program::load(Path::new("samples/circle/circle_program.csv"), &robot)?;
//! let mut points = rewrite::Points { axes: robot.dof(), ..rewrite::Points::default() };
//! let mut q = vec![0.0; robot.dof()];
//! for i in 0..program.len() {
//!     program.point_into(i, &mut q);
//!     points.q.extend(&q);
//! }
//! let mut options = rewrite::Options::new(robot.dof());
//! options.tcp_speed_m_s = Some(1.5e-3);
//! let mut engine = rewrite::Engine::new(&robot, &compensator, options)?;
//! let mut out = rewrite::OutputPoints::default();
//! engine.push(&points, &mut out)?;
//! let stats = engine.finish(&mut out)?;
//! assert!(stats.reversals[0] > 0 && out.len() as u64 == stats.points + stats.inserted);
//! # Ok(())
//! # }
//! ```
#![forbid(unsafe_code)]

pub mod assess;
#[cfg(feature = "cli")]
pub mod cli;
pub mod compensator;
pub mod diagnose;
pub mod effects;
pub mod error;
pub mod fit;
pub mod gaps;
pub mod identify;
pub mod io;
pub mod join;
pub mod learn;
pub mod log;
pub mod machine;
pub mod model;
pub mod name;
pub use lostmotion_numerics as numerics;
pub mod plan;
pub mod program;
#[cfg(feature = "cli")]
pub mod report;
pub mod rewrite;
pub mod robot;
pub mod schemas;
pub mod simulate;
pub mod track;
