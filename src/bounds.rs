//! The bounds of every kind of input file: its length, and the memory and time that reading it takes.
//!
//! Every reader takes its limit from here, the book's page about untrusted files shows the list, and a test
//! for each kind reads its worst file within its memory and time, and checks that a longer file is refused.

/// How long a file of a kind may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Length {
    /// The largest number of bytes of a file that is read into memory as a whole.
    AtMost(u64),
    /// The number of bytes for which memory and time are stated, of a file that is read piece by piece at any
    /// length.
    For(u64),
}

impl Length {
    /// The number of bytes.
    pub const fn bytes(self) -> u64 {
        match self {
            Self::AtMost(bytes) | Self::For(bytes) => bytes,
        }
    }
}

/// The bounds of a kind of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FileBounds {
    /// The kind, as users call it.
    pub kind: &'static str,
    /// The longest file.
    pub length: Length,
    /// The address space in which the program reads any of them, MiB.
    pub memory: u64,
    /// The longest time that reading or refusing one takes, s.
    pub seconds: u64,
}

impl FileBounds {
    const fn new(kind: &'static str, length: Length, memory: u64, seconds: u64) -> Self {
        Self { kind, length, memory, seconds }
    }

    /// The length of the longest file, bytes.
    pub const fn bytes(&self) -> u64 {
        self.length.bytes()
    }
}

use Length::{AtMost, For};

/// A world.
pub const WORLD: FileBounds = FileBounds::new("world (TOML)", AtMost(4 << 20), 1500, 600);
/// A file of settings.
pub const SETTINGS: FileBounds =
    FileBounds::new("robot file, study, baseline (TOML)", AtMost(1 << 20), 1000, 60);
/// A URDF, also what a xacro expands to.
pub const URDF: FileBounds = FileBounds::new("URDF", AtMost(16 << 20), 1500, 60);
/// A xacro while the program `xacro` expands it; the length is that of the program's output.
pub const XACRO: FileBounds = FileBounds::new("xacro, expanded with `--xacro`", AtMost(16 << 20), 2048, 30);
/// A mesh.
pub const MESH: FileBounds = FileBounds::new("mesh (STL, OBJ, COLLADA)", AtMost(64 << 20), 2000, 60);
/// The description of an occupancy grid.
pub const GRID: FileBounds = FileBounds::new("map (YAML)", AtMost(64 << 10), 400, 10);
/// The image of an occupancy grid.
pub const IMAGE: FileBounds = FileBounds::new("image of a map (PGM, PNG)", AtMost(256 << 20), 4000, 120);
/// A floor plan of areas.
pub const PLAN: FileBounds = FileBounds::new("floor plan (GeoJSON)", AtMost(16 << 20), 2000, 120);
/// A drawn floor plan.
pub const DRAWING: FileBounds = FileBounds::new("floor plan (SVG)", AtMost(16 << 20), 2000, 60);
/// A table of participants or samples.
pub const TABLE: FileBounds =
    FileBounds::new("answers, switches, samples (CSV)", AtMost(16 << 20), 2000, 120);
/// A recording.
pub const RECORDING: FileBounds = FileBounds::new("recording (MCAP)", For(16 << 20), 600, 60);
/// The text of the scenario in a recording.
pub const SCENARIO: FileBounds =
    FileBounds::new("scenario in a recording (TOML)", AtMost(24 << 20), 3000, 60);
/// The decisions of custom partners in a recording.
pub const DECISIONS: FileBounds =
    FileBounds::new("decisions in a recording (JSON)", AtMost(16 << 20), 2000, 60);
/// A snapshot.
pub const SNAPSHOT: FileBounds = FileBounds::new("snapshot", AtMost(32 << 20), 4000, 120);
/// Results of studies as text.
pub const ROWS: FileBounds = FileBounds::new("results (CSV)", For(16 << 20), 2000, 120);
/// Results of studies in columns.
pub const COLUMNS: FileBounds = FileBounds::new("results (Parquet)", For(16 << 20), 2000, 120);

/// All kinds.
pub const ALL: [FileBounds; 16] = [
    WORLD, SETTINGS, URDF, XACRO, MESH, GRID, IMAGE, PLAN, DRAWING, TABLE, RECORDING, SCENARIO, DECISIONS,
    SNAPSHOT, ROWS, COLUMNS,
];
