//! What is asked: observations of all logs, the chain evaluated for a hypothesis, and its sensitivities by every value.
//!
//! Read in this order: [`layout`], the long vector of observations; [`recording`], what kind of logs they are; [`reading`], one reading a
//! row of a ballbar or a dial; [`orientation`], the orientation of the tool; [`forward`], the chain evaluated, and what a change of an
//! effect does to the observations; [`fine`], the same between the rows of a thinned log; `nuisance`, the same of frames and zeros;
//! [`normal`], products and bases of long columns; [`residual`], its size; `spacing`, which ripples poses can show; [`synthetic`], a
//! problem of commands alone, for planning an experiment.

pub(crate) mod fine;
pub(crate) mod forward;
pub(crate) mod layout;
pub(crate) mod normal;
mod nuisance;
pub(crate) mod orientation;
pub(crate) mod reading;
pub(crate) mod recording;
pub(crate) mod residual;
mod spacing;
pub mod synthetic;
