//! Files given where another kind belongs: a folder of `cocarry new` instead of a file in it, a robot instead
//! of a world.

use super::output::{Failure, input};
use anyhow::{Error, anyhow};
use cocarry::{bounds, located};
use std::path::{Path, PathBuf};

/// A kind of TOML file that commands take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FileKind {
    World,
    Robot,
    Study,
}

impl FileKind {
    const ALL: [Self; 3] = [Self::World, Self::Robot, Self::Study];

    /// Its name in a folder of `cocarry new`.
    fn file_name(self) -> &'static str {
        match self {
            Self::World => "world.toml",
            Self::Robot => "robot.toml",
            Self::Study => "study.toml",
        }
    }

    /// A key that files of this kind have, and no others.
    fn key(self) -> &'static str {
        match self {
            Self::World => "start_m",
            Self::Robot => "urdf",
            Self::Study => "worlds",
        }
    }

    /// The kind, and where such a file belongs.
    fn advice(self) -> &'static str {
        match self {
            Self::World => {
                "this is a world file; give it to `cocarry run` or `cocarry world`, or list it under `worlds` in a study"
            }
            Self::Robot => "this is a robot file; give it as --robot",
            Self::Study => "this is a study; run it with `cocarry sweep`",
        }
    }
}

/// The file of this kind in `path`, if that is a folder with one; otherwise `path` itself.
pub(super) fn within(path: &Path, kind: FileKind) -> PathBuf {
    let inside = path.join(kind.file_name());
    if path.is_dir() && inside.is_file() { inside } else { path.to_owned() }
}

/// The failure to read `path` as this kind of file: if it is of another kind, the error says which and where
/// it belongs.
pub(super) fn refused(path: &Path, kind: FileKind, error: Error) -> Failure {
    let table = located::read(&bounds::WORLD, path).ok().and_then(|text| text.parse::<toml::Table>().ok());
    let is = |other: &FileKind| *other != kind && table.as_ref().is_some_and(|t| t.contains_key(other.key()));
    input(match FileKind::ALL.into_iter().find(is) {
        Some(other) => anyhow!("{}: {}", path.display(), other.advice()),
        None => error,
    })
}
