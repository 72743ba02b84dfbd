//! Prints the results of all benches that are kept in `benches/results.json`, and measures nothing. `cargo
//! bench` runs it last.

#[path = "rows/file.rs"]
mod file;
#[path = "rows/print.rs"]
mod print;

fn main() {
    let repository = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    print::print(&file::Results::read(&repository).rows, "no results are kept: run `cargo bench`");
}
