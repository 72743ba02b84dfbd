//! The fast tests, in one binary.

mod bad_input;
mod closed_loop;
mod command_line;
mod determinism;
mod floors;
mod readme;
mod support;
mod worlds;
