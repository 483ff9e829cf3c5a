//! One binary for all integration tests; a module per room.

mod program;
mod rewrite_stream;
