//! `lostmotion assess`.

use crate::error::{Error, Result};

/// Arguments of `assess`.
#[derive(Debug, clap::Args)]
pub struct Args {}

/// Runs the command.
pub fn run(_args: Args) -> Result<()> {
    Err(Error::Refused("not built yet".into()))
}
