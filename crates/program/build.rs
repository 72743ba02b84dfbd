//! What the program knows of its build: the commit and the versions of packages, for `cite`; with the feature `page`,
//! the list of the page's files, which `demo` has within.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

/// The built page.
const PAGE: &str = "../../viewer/dist/page";
/// Without these it is not complete.
const NEEDED: [&str; 4] = ["index.html", "page.css", "page.js", "cocarry.wasm"];

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=build.rs");
    set_versions();
    set_commit();
    if env::var_os("CARGO_FEATURE_PAGE").is_none() {
        return Ok(());
    }
    println!("cargo::rerun-if-changed={PAGE}");
    let folder = Path::new(PAGE);
    if let Some(missing) = NEEDED.iter().find(|name| !folder.join(name).is_file()) {
        println!(
            "cargo::error=the feature `page` needs viewer/dist/page/{missing}; build the page first: (cd viewer && npm ci) && crates/web/build"
        );
        return Ok(());
    }
    let mut files: Vec<PathBuf> =
        fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<Result<_, std::io::Error>>()?;
    files.retain(|file| file.is_file());
    files.sort();
    let mut list = String::from("&[\n");
    for file in files {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        list += &format!("    ({name:?}, include_bytes!({:?})),\n", file.canonicalize()?);
    }
    list += "]\n";
    fs::write(Path::new(&env::var("OUT_DIR")?).join("page.rs"), list)?;
    Ok(())
}

/// The lock file of the workspace.
const LOCK: &str = "../../Cargo.lock";
/// The packages that `cite` names, each with the variable for its version.
const CITED: [(&str, &str); 3] =
    [("clarabel", "CLARABEL_VERSION"), ("rapier3d-f64", "RAPIER_VERSION"), ("parry3d-f64", "PARRY_VERSION")];

fn set_versions() {
    println!("cargo::rerun-if-changed={LOCK}");
    let lock = fs::read_to_string(LOCK).unwrap_or_default();
    for (package, variable) in CITED {
        let (_, rest) = lock.split_once(&format!("name = \"{package}\"\nversion = \"")).unwrap_or_default();
        if let Some((version, _)) = rest.split_once('"') {
            println!("cargo::rustc-env={variable}={version}");
        }
    }
}

/// The commit of a release build: that of the clone, or `COCARRY_COMMIT` where there is none. Other builds would be
/// made anew after every commit.
fn set_commit() {
    println!("cargo::rerun-if-env-changed=COCARRY_COMMIT");
    let given = env::var("COCARRY_COMMIT").ok().filter(|commit| !commit.is_empty());
    let is_release = env::var("PROFILE").is_ok_and(|profile| profile == "release");
    if let Some(commit) = given.or_else(|| is_release.then(commit_of_clone).flatten()) {
        println!("cargo::rustc-env=COMMIT_OF_BUILD={commit}");
    }
}

fn commit_of_clone() -> Option<String> {
    // not that of a clone around these sources
    git(&["ls-files", "--error-unmatch", "build.rs"])?;
    let commit = git(&["rev-parse", "HEAD"])?;
    // the commits that were checked out, the last one at the end
    if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"]).filter(|log| Path::new(log).exists()) {
        println!("cargo::rerun-if-changed={log}");
    }
    let is_changed = !git(&["status", "--porcelain", "--untracked-files=no"])?.is_empty();
    Some(if is_changed { format!("{commit} with changes") } else { commit })
}

/// What a command of git prints, if it succeeds.
fn git(arguments: &[&str]) -> Option<String> {
    let output =
        Command::new("git").args(arguments).output().ok().filter(|output| output.status.success())?;
    Some(String::from_utf8(output.stdout).ok()?.trim().to_owned())
}
