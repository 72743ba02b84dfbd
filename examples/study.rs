//! A study: every combination of two worlds and two tolerances with the same ten humans, as rows of CSV.
//!
//! ```text
//! cargo run --release --example study > study.csv
//! ```

use cocarry_studies::study::Study;
use std::path::Path;

const STUDY: &str = r#"
worlds = ["environment-1", "environment-4"]
plants = "point"
methods = "mutual"
eta = [5, 15]
seeds = 10
"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let study = Study::parse("study.toml", STUDY, Path::new("."), None)?;
    let rows = study.rows(0..study.episodes());
    print!("{}", String::from_utf8(rows)?);
    eprintln!("{} episodes of study {}", study.episodes(), study.digest());
    Ok(())
}
