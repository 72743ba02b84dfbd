//! The fast tests, in one binary.

mod allocation;
mod bad_input;
mod bad_robots;
mod bad_urdfs;
mod carrying;
mod changes;
mod closed_loop;
mod command_line;
mod determinism;
mod fitting;
mod floors;
mod physical_carrying;
mod physics;
mod readme;
mod recording;
mod reference_recordings;
mod regress;
mod reports;
mod robots;
mod scenarios;
mod snapshots;
mod spoiled_robot;
mod support;
mod sweeps;
mod tutorial;
mod worlds;
