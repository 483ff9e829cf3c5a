//! All integration tests in one binary, a module per room.

mod bad_input;
mod log;
mod robot;
