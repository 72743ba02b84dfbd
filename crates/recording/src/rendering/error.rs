//! The reasons why a recording could not be rendered.

use cocarry_output::drawing::DrawingError;
use std::path::PathBuf;
use thiserror::Error;

/// The reason why a recording could not be rendered.
#[derive(Debug, Error)]
pub enum RenderError {
    /// A picture cannot be drawn.
    #[error(transparent)]
    Drawing(#[from] DrawingError),
    /// An image cannot be created.
    #[error("the image cannot be created: {0}")]
    Image(String),
    /// The given robot is another one than the recording's.
    #[error("{file}: is not the robot of the recording: its {what} differs from the recorded one")]
    OtherRobot {
        /// The robot file.
        file: String,
        /// The text that differs: `robot file` or `URDF`.
        what: &'static str,
    },
    /// A mesh cannot be read.
    #[error("{}: cannot be read", file.display())]
    Mesh {
        /// The mesh.
        file: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A mesh has a format that is not known.
    #[error("{}: a mesh of an unknown format; expected .stl, .obj or .dae", file.display())]
    MeshFormat {
        /// The mesh.
        file: PathBuf,
    },
}
