//! cocarry
pub mod geometry;
pub mod world;
pub mod options;
