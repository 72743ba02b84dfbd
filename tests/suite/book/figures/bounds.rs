//! The bounds of the files that are read, which come from the program and not from a report.

use super::Figure;
use cocarry::bounds::{self, FileBounds, Length};

pub const FIGURES: &[Figure] =
    &[("untrusted.bounds", |_| TITLES.to_owned() + &bounds::ALL.iter().map(row).collect::<String>())];

const TITLES: &str = "| file | longest | memory | time |\n| :-- | :-- | --: | --: |\n";

fn row(bounds: &FileBounds) -> String {
    let FileBounds { kind, length, memory, seconds } = bounds;
    let length = match length {
        Length::AtMost(bytes) => binary(*bytes),
        Length::For(bytes) => format!("any; memory and time are for {}", binary(*bytes)),
    };
    format!("| {kind} | {length} | {memory} MiB | {seconds} s |\n")
}

fn binary(bytes: u64) -> String {
    if bytes.is_multiple_of(1 << 20) {
        format!("{} MiB", bytes >> 20)
    } else {
        format!("{} KiB", bytes >> 10)
    }
}
