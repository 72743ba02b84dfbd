//! Outputs: files that appear complete or not at all, the colours of all pictures, maps and curves as SVG, and what the 3-D
//! player draws.

pub mod bodies;
pub mod drawing;
pub mod figure;
pub mod html;
pub mod mjcf;
pub mod output_file;
pub mod palette;
pub mod player;
mod xml;
