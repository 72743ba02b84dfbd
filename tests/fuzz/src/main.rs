//! Bytes in; read by the reader that the environment variable `COCARRY_READER` names: whatever they are,
//! without a panic, in little time and memory. With `COCARRY_SEEDS=FOLDER`, the reader's seeds are written
//! into a folder first.
#![no_main]

mod maps;
mod recordings;
mod results;
mod robots;
mod seeds;
mod texts;

use std::path::PathBuf;
use std::sync::LazyLock;

/// What reads a file's bytes.
type Read = fn(&[u8]);

const READERS: [(&str, Read); 21] = [
    ("answers", results::answers),
    ("baseline", texts::baseline),
    ("columns", results::columns),
    ("dae", |bytes| robots::mesh("mesh.dae", bytes)),
    ("drawing", |bytes| maps::map("map.svg", bytes)),
    ("grid", |bytes| maps::map("map.yaml", bytes)),
    ("image", maps::image),
    ("log", texts::log),
    ("obj", |bytes| robots::mesh("mesh.obj", bytes)),
    ("plan", |bytes| maps::map("map.geojson", bytes)),
    ("playback", recordings::playback),
    ("recording", recordings::recording),
    ("replay", recordings::replayed),
    ("robot", robots::robot),
    ("rows", results::rows),
    ("scenario", texts::scenario),
    ("snapshot", recordings::snapshot),
    ("stl", |bytes| robots::mesh("mesh.stl", bytes)),
    ("study", texts::study),
    ("urdf", robots::urdf),
    ("world", texts::world),
];

fn reader() -> (&'static str, Read) {
    let name = std::env::var("COCARRY_READER").unwrap_or_default();
    let names = || READERS.map(|(name, _)| name).join(", ");
    *READERS.iter().find(|(other, _)| *other == name).unwrap_or_else(|| panic!("COCARRY_READER: one of {}", names()))
}

static READER: LazyLock<Read> = LazyLock::new(|| reader().1);

/// The folder for files of this process.
static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
    let folder = std::env::temp_dir().join(format!("cocarry-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for files");
    folder
});

/// Writes a file, for readers that take its name.
fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let file = FOLDER.join(name);
    std::fs::write(&file, bytes).expect("a place for files");
    file
}

libfuzzer_sys::fuzz_target!(init: {
    if let Some(folder) = std::env::var_os("COCARRY_SEEDS") {
        seeds::write(reader().0, &PathBuf::from(folder));
    }
}, |bytes: &[u8]| {
    READER(bytes);
});
