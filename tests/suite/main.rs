//! The fast tests, in one binary.

mod allocation;
mod arithmetic;
mod bad_input;
mod bad_robots;
mod bad_urdfs;
mod book;
mod carrying;
mod changes;
mod closed_loop;
mod command_line;
mod crowded_worlds;
mod detection;
mod determinism;
mod fitting;
mod floors;
mod forged_snapshots;
mod learning;
mod limits;
mod object_lost;
mod outputs;
mod paths;
mod physical_carrying;
mod physics;
mod pictures;
mod quantities;

mod recording;
mod reference_recordings;
mod regress;
mod render;
mod reports;
mod robot_files;
mod robots;
mod scenarios;
mod seams;
mod settings;
mod shared_ways;
mod snapshots;
mod spoiled_robot;
mod starting;
mod suggestions;
mod support;
mod sweeps;
mod terminal;

mod worlds;
