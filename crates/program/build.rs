//! With the feature `page`, the list of the page's files, which `demo` has within.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::{env, fs};

/// The built page.
const PAGE: &str = "../../viewer/dist/page";
/// Without these it is not complete.
const NEEDED: [&str; 4] = ["index.html", "page.css", "page.js", "cocarry.wasm"];

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=build.rs");
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
