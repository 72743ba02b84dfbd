//! The table of `cocarry::bounds`: for every kind of file, the real program reads its longest and worst files
//! within the memory and the time that are stated, and refuses one that is longer.

mod maps;
mod meshes;
mod recordings;
mod results;
mod texts;

use crate::limits::within;
use crate::support::{repository, stderr, time_for};
use cocarry::bounds::{self, FileBounds};
use std::path::{Path, PathBuf};
use std::process::Output;
use std::time::Instant;

/// Defines a test for each kind of file, and one that no kind is left out.
macro_rules! kinds {
    ($($(#[$attribute:meta])* $test:ident: $kind:ident by $check:path,)*) => {
        $(#[test]
        $(#[$attribute])*
        fn $test() {
            $check(Bench::new(&bounds::$kind));
        })*

        #[test]
        fn every_kind_of_file_has_its_test() {
            let tested = [$(bounds::$kind.kind),*];
            assert!(bounds::ALL.iter().map(|bounds| bounds.kind).eq(tested));
        }
    };
}

kinds! {
    #[ignore = "nightly: reads the longest files for a minute or more"]
    worlds_are_read_within_their_bounds: WORLD by texts::worlds,
    settings_are_read_within_their_bounds: SETTINGS by texts::settings,
    urdfs_are_read_within_their_bounds: URDF by texts::urdfs,
    xacros_are_expanded_within_their_bounds: XACRO by texts::xacros,
    meshes_are_read_within_their_bounds: MESH by meshes::meshes,
    descriptions_of_maps_are_read_within_their_bounds: GRID by maps::grids,
    #[ignore = "nightly: reads the longest files for a minute or more"]
    images_are_read_within_their_bounds: IMAGE by maps::images,
    plans_are_read_within_their_bounds: PLAN by maps::plans,
    drawings_are_read_within_their_bounds: DRAWING by maps::drawings,
    tables_are_read_within_their_bounds: TABLE by texts::tables,
    #[ignore = "nightly: reads the longest files for a minute or more"]
    recordings_are_read_within_their_bounds: RECORDING by recordings::recordings,
    scenarios_are_read_within_their_bounds: SCENARIO by recordings::scenarios,
    decisions_are_read_within_their_bounds: DECISIONS by recordings::decisions,
    #[ignore = "nightly: reads the longest files for a minute or more"]
    snapshots_are_read_within_their_bounds: SNAPSHOT by recordings::snapshots,
    rows_are_read_within_their_bounds: ROWS by results::rows,
    #[cfg_attr(feature = "parquet", ignore = "nightly: reads the longest files for a minute or more")]
    columns_are_read_within_their_bounds: COLUMNS by results::columns,
}

/// A folder for files of a kind.
struct Bench {
    bounds: &'static FileBounds,
    folder: tempfile::TempDir,
}

impl Bench {
    fn new(bounds: &'static FileBounds) -> Self {
        Self { bounds, folder: tempfile::tempdir().unwrap() }
    }

    fn folder(&self) -> &Path {
        self.folder.path()
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder().join(name)
    }

    fn write(&self, name: &str, contents: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), contents).unwrap();
    }

    /// The length of the longest file.
    fn longest(&self) -> usize {
        self.bounds.bytes() as usize
    }

    /// A text of the longest length: what is missing is added to its end, in pieces.
    fn filled(&self, text: &str, piece: &str) -> String {
        let left = self.longest() - text.len();
        let mut text = text.to_owned();
        (0..left / piece.len()).for_each(|_| text += piece);
        text + &" ".repeat(left % piece.len())
    }

    /// Runs the program within the memory, for the time at most.
    fn run(&self, line: &str) -> Output {
        let begun = Instant::now();
        let output = within(self.bounds.memory, self.folder(), line);
        let (taken, limit) = (begun.elapsed(), time_for(self.bounds.seconds));
        assert!(taken < limit, "{}: {line} takes {taken:?}", self.bounds.kind);
        if std::env::var_os("COCARRY_BOUNDS").is_some() {
            eprintln!("{}: {line}: {taken:?}, {}", self.bounds.kind, output.status);
        }
        output
    }

    /// A file is read: the command succeeds.
    #[track_caller]
    fn reads(&self, line: &str) -> Output {
        let output = self.run(line);
        let said: String = stderr(&output).chars().take(1000).collect();
        assert!(output.status.success(), "{}: {line}: {} {said}", self.bounds.kind, output.status);
        output
    }

    /// A file is refused, with these words.
    #[track_caller]
    fn refuses(&self, line: &str, words: &str) {
        let output = self.run(line);
        let said = stderr(&output);
        let begin: String = said.chars().take(1000).collect();
        assert_eq!(output.status.code(), Some(2), "{}: {line}: {begin}", self.bounds.kind);
        assert!(said.starts_with("error: ") && said.contains(words), "{line}: {begin}");
        assert!(said.len() < 10_000, "{line}: {begin}");
    }

    /// What is said of a file that is too long by a byte.
    fn too_long(&self) -> String {
        format!("cannot be read: larger than {} bytes", self.longest())
    }
}

fn environment_4() -> String {
    std::fs::read_to_string(repository("worlds/environment-4.toml")).unwrap()
}

/// Also of the kinds whose longest files are read in the nightly set.
#[test]
fn a_world_an_image_and_a_snapshot_that_are_too_long_are_refused_at_once() {
    for (bounds, name, line) in [
        (&bounds::WORLD, "w.toml", "world w.toml"),
        (&bounds::IMAGE, "grid.pgm", &maps::line("m.yaml")),
        (&bounds::SNAPSHOT, "s", "run --resume s"),
    ] {
        let bench = Bench::new(bounds);
        bench.write("m.yaml", maps::YAML);
        let file = std::fs::File::create(bench.path(name)).unwrap();
        file.set_len(bench.longest() as u64 + 1).unwrap();
        bench.refuses(line, &format!("larger than {} bytes", bench.longest()));
    }
}
