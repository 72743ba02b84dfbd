//! Episodes as MCAP recordings, and recordings as pages and pictures that open anywhere.

pub mod recording;
pub mod rendering;
