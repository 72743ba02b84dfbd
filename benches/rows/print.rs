//! The table of results as text of 80 columns: a line for what is measured, one for each comparison.

use super::file::Row;

const COLUMNS: usize = 80;

/// Prints rows, bench by bench; `none` if there are none.
pub fn print(rows: &[Row], none: &str) {
    if rows.is_empty() {
        return println!("{none}");
    }
    let mut bench = "";
    for row in rows {
        if row.bench != bench {
            println!("\n{}", row.bench);
            bench = &row.bench;
        }
        line(&format!("  {}", row.name), &row.value.with_unit(&row.unit));
        for other in &row.against {
            let (what, ratio) = other.described(&row.unit);
            line(&format!("      {what}"), &ratio);
        }
    }
    println!();
    let mut printed = Vec::new();
    for row in rows {
        if !printed.contains(&&row.measured) {
            printed.push(&row.measured);
            let measured = rows.iter().filter(|other| other.measured == row.measured);
            let mut benches: Vec<&str> = measured.map(|row| row.bench.as_str()).collect();
            benches.dedup();
            println!("{}: {}", row.measured, benches.join(", "));
        }
    }
}

fn line(left: &str, right: &str) {
    let (long, width) = (left.chars().count(), right.chars().count());
    if long + 2 + width <= COLUMNS {
        println!("{left}{}{right}", " ".repeat(COLUMNS - long - width));
    } else {
        println!("{left}\n{}{right}", " ".repeat(COLUMNS.saturating_sub(width)));
    }
}
