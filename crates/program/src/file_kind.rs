//! Files given where another kind belongs: a folder of `cocarry new` instead of a file in it, a robot instead
//! of a world, results instead of their study.

use super::output::{Failure, input};
use anyhow::{Error, anyhow};
use cocarry::suggestion::shell_word;
use cocarry::{bounds, located};
use cocarry_studies::fit::EvidenceKind;
use cocarry_studies::study;
use std::io::Read;
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
            Self::Robot => {
                "this is a robot file; give it as --robot to `cocarry run`, list it under `robots` in a study, or check it with `cocarry robot check`"
            }
            Self::Study => "this is a study; run it with `cocarry sweep`",
        }
    }
}

/// The number of first bytes that tell what a file is that is no TOML.
const HEAD: u64 = 16 << 10;
/// The first bytes of a recording.
const MCAP: &[u8] = b"\x89MCAP";
/// The first bytes of a Parquet file.
const PARQUET: &[u8] = b"PAR1";

/// The file of this kind in `path`, if that is a folder with one; otherwise `path` itself.
pub(super) fn within(path: &Path, kind: FileKind) -> PathBuf {
    let inside = path.join(kind.file_name());
    if path.is_dir() && inside.is_file() { inside } else { path.to_owned() }
}

/// The failure to read `path` as this kind of file: if it is of another kind, the error says which and where
/// it belongs.
pub(super) fn refused(path: &Path, kind: FileKind, error: Error) -> Failure {
    input(match other_kind(path, kind) {
        Some(advice) => anyhow!("{}: {advice}", path.display()),
        None => error,
    })
}

/// What the file at `path` is, and where it belongs; `None` if it may be of this kind.
pub(super) fn other_kind(path: &Path, kind: FileKind) -> Option<String> {
    let text = located::read(&bounds::WORLD, path).ok();
    let Some(table) = text.and_then(|text| text.parse::<toml::Table>().ok()) else {
        return by_first_bytes(path, kind);
    };
    let is = |other: &FileKind| *other != kind && table.contains_key(other.key());
    FileKind::ALL.into_iter().find(is).map(|other| other.advice().to_owned())
}

/// The same of a file that is no TOML.
fn by_first_bytes(path: &Path, kind: FileKind) -> Option<String> {
    let mut head = Vec::new();
    located::open(path).ok()?.take(HEAD).read_to_end(&mut head).ok()?;
    let file = shell_word(&path.display().to_string());
    if head.starts_with(MCAP) {
        return Some(format!(
            "this is a recording; see `cocarry inspect {file}`, `cocarry render {file} -o episode.html` and `cocarry replay {file}`"
        ));
    }
    if head.starts_with(PARQUET) {
        return Some(format!(
            "this is a Parquet file, as a sweep writes its results; `cocarry sweep --summary {file}` prints their tables"
        ));
    }
    let text = String::from_utf8_lossy(&head);
    let text = text.trim_start_matches('\u{feff}').trim_start();
    if text.starts_with('<') {
        // a robot is given by its URDF, too
        let is_urdf = kind != FileKind::Robot && text.contains("<robot");
        return is_urdf.then(|| {
            format!(
                "this is the URDF of a robot; `cocarry robot init {file}` drafts its robot file, which `cocarry run` takes as --robot and a study under `robots`"
            )
        });
    }
    let header = text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'))?;
    let columns: Vec<&str> =
        header.split([',', ';', '\t']).map(|name| name.trim().trim_matches('"')).collect();
    let results: Vec<&str> = study::columns().iter().take(3).map(|heading| heading.name).collect();
    if columns.starts_with(&results) {
        return Some(format!(
            "these are the results of a sweep; `cocarry sweep --summary {file}` prints their tables, `cocarry compare {file}` compares its methods"
        ));
    }
    match columns.contains(&"participant").then(|| EvidenceKind::of(path).ok()).flatten() {
        Some(EvidenceKind::Answers) => Some(format!(
            "these are answers of participants; give them to `cocarry fit risk-weight {file}` or `cocarry infer {file}`"
        )),
        Some(EvidenceKind::Switches) => Some(format!(
            "these are switches of participants; give them to `cocarry fit eta {file}` or `cocarry infer {file}`"
        )),
        None => None,
    }
}
