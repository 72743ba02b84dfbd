//! Outputs: files that appear complete or not at all, the colours of all pictures, and maps and curves as SVG.

pub mod drawing;
pub mod output_file;
pub mod palette;
