//! The program as a user runs it, and the worlds that the tests run in.

use cocarry::geometry::{PlanarPose, Point};
use cocarry::options::OptionSet;
use cocarry::robot::{Configuration, JointVector, Robot};
use cocarry::world::World;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::Duration;

/// How long something may take that takes at most `seconds` on a processor of 2 GHz with nothing else to do:
/// with `COCARRY_BOUNDS` set, no longer. Otherwise so long that only what does not end takes it on a busy machine.
pub fn time_for(seconds: u64) -> Duration {
    const BUSY: u64 = 8;
    Duration::from_secs(if std::env::var_os("COCARRY_BOUNDS").is_some() { seconds } else { BUSY * seconds })
}

/// A file of the repository.
pub fn repository(path: &str) -> PathBuf {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    package.ancestors().nth(2).expect("crates/program").join(path)
}

/// Runs the program in the repository's folder.
pub fn cocarry(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cocarry"))
        .args(arguments)
        .env_remove("COLUMNS")
        .current_dir(repository("."))
        .output()
        .expect("the program starts")
}

/// As [`cocarry`], where the C library takes its functions for processors without fused multiplication and
/// addition: their last bits are others. (Where there is no glibc on x86-64, the same as [`cocarry`].)
pub fn cocarry_without_fma(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cocarry"))
        .args(arguments)
        .env("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2")
        .current_dir(repository("."))
        .output()
        .expect("the program starts")
}

pub fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("UTF-8")
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("UTF-8")
}

/// What a command prints, which must succeed.
#[cfg(feature = "people")]
pub fn done(arguments: &[&str]) -> String {
    let output = cocarry(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    stdout(&output)
}

/// A folder with the study of `cocarry study new`, and the study's file.
#[cfg(feature = "people")]
pub fn new_study() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    done(&["study", "new", folder.path().to_str().unwrap()]);
    let file = folder.path().join("study.toml");
    (folder, file)
}

/// The files of a study that `cocarry study collect` writes where nobody carried.
#[cfg(feature = "people")]
pub const COLLECTED: [&str; 6] =
    ["answers.csv", "switches.csv", "participants.csv", "responses.csv", "dictionary.csv", "README.md"];

/// Runs the program, which must end with 0, and reads its JSON.
pub fn json(arguments: &[&str]) -> serde_json::Value {
    let output = cocarry(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", stderr(&output));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

/// All world files of the repository, by name.
pub fn world_files() -> Vec<PathBuf> {
    let folder = std::fs::read_dir(repository("worlds")).expect("the folder of worlds");
    let mut files: Vec<PathBuf> = folder
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .collect();
    files.sort();
    files
}

pub fn load(path: &Path) -> (World, OptionSet) {
    let world = World::load(path).unwrap_or_else(|e| panic!("{e}"));
    let set = OptionSet::new(&world, 10.0).unwrap_or_else(|e| panic!("{e}"));
    (world, set)
}

/// A base anywhere near the origin, and joints within their limits, those without end within half a turn.
pub fn random_configuration(robot: &Robot, rng: &mut ChaCha8Rng) -> Configuration {
    let position = Point::new(rng.random_range(-3.0..3.0), rng.random_range(-3.0..3.0));
    let mut joints = JointVector::zeros();
    for (i, joint) in robot.joints.iter().enumerate() {
        joints[i] = rng.random_range(joint.lower.max(-3.1)..joint.upper.min(3.1));
    }
    Configuration { base: PlanarPose { position, yaw: rng.random_range(-3.1..3.1) }, joints }
}

/// Whether a page has the digest of its sources: those in `src` of this folder, and `others`.
pub fn is_built_of(page: &str, folder: &str, others: &[&str]) -> bool {
    let page = std::fs::read_to_string(repository(page)).unwrap();
    let folder = repository(folder);
    let mut sources: Vec<String> = others.iter().map(|name| (*name).to_owned()).collect();
    let names = std::fs::read_dir(folder.join("src")).expect("src");
    sources.extend(names.map(|entry| format!("src/{}", entry.unwrap().file_name().to_str().unwrap())));
    sources.sort();
    let mut digest = crc32fast::Hasher::new();
    for name in sources {
        digest.update(format!("{name}\n{}", std::fs::read_to_string(folder.join(&name)).unwrap()).as_bytes());
    }
    page.contains(&format!("<meta name=\"sources\" content=\"{:08x}\">", digest.finalize()))
}
