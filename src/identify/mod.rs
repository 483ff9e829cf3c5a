//! Lost motion from logs: [`path`] from reversals in continuous motion.

pub mod path;
