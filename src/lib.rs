//! cocarry
pub mod cli;
pub mod coordination;
pub mod drawing;
pub mod episode;
pub mod experiments;
pub mod geometry;
pub mod options;
pub mod preference;
pub mod world;
