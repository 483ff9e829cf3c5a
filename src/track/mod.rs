//! Tracking: a Cartesian path to a joint program, by nominal, diagnosed or learned kinematics (Cursi (2022), section II-B).
//!
//! At each step of the path the joints' move is the bounded quadratic program of equation 1, or the numerical inverse. Equation 1 asks
//! for the path's velocity and integrates what comes out; here the velocity leads from where the kinematics puts the TCP to the next
//! point, so that the error of a step is made up for by the next instead of being summed. On the path itself the two are the
//! same.
//!
//! Joint limits, joint speeds and the range in which a kinematics was learned are bounds of every step; accelerations
//! are checked afterwards, as `rewrite` checks them. What comes out is rounded to the digits it is written with before it is
//! judged. A point that cannot be reached within the tolerance is named with its line and with what holds the robot back.
//!
//! Modules:
//! - [`path`]: the path file; [`plausible`]: a path in metres.
//! - [`kinematics`]: from commands to coordinates, with a Jacobian.
//! - [`quadratic`]: the bounded quadratic program.
//! - [`mod@follow`]: from point to point.
//! - [`mod@write`]: the program; [`document`]: what was done.
//!
//! The program is open-loop and does not include lost motion: `rewrite` puts the compensation in.
//!
//! # Example
//!
//! The TCP of a gantry is where its joints are: a path in mm is its program.
//!
//! ```
//! use lostmotion::io::input::from_bytes;
//! use lostmotion::robot::Robot;
//! use lostmotion::track::{Kinematics, Options, Path, follow};
//!
//! let robot = Robot::load(std::path::Path::new("configs/gantry-xyz-ballscrew.yaml"))?;
//! let rows = b"t_s,x_mm,y_mm,z_mm\n0,100,50,-10\n1,110,60,-20\n2,120,55,-15\n".to_vec();
//! let path = Path::parse(from_bytes("path.csv".into(), rows)?)?;
//! let kinematics = Kinematics::nominal(&robot, &path.coordinates);
//! let tracked = follow(&robot, &kinematics, &path, &[0.0, 1.0, 2.0], &Options::default())?;
//! for (q, point) in tracked.q.iter().zip(&path.points_m) {
//!     assert!(q.iter().zip(point).all(|(q, p)| (q - p).abs() < 1e-8), "{q:?} m for {point:?} m");
//! }
//! # Ok::<(), lostmotion::error::Error>(())
//! ```

#![warn(missing_docs)]

pub mod document;
pub mod follow;
pub mod kinematics;
pub mod path;
pub mod plausible;
pub mod quadratic;
pub mod write;

pub use crate::learn::LETTERS;
pub use document::Origin;
pub use follow::{Method, Options, Tracked, follow};
pub use kinematics::Kinematics;
pub use path::Path;
