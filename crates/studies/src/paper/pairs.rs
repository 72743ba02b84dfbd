//! Columns of a paired comparison, the same in every table, with notes that explain them.

use crate::statistics::Paired;
use crate::table::{Cell, Columns, Table};
use serde_json::Value;

/// The significance level of corrected p-values.
pub const SIGNIFICANCE_LEVEL: f64 = 0.05;

/// Whether a comparison is significant after Holm's correction.
pub fn is_significant(paired: &Paired) -> bool {
    paired.p_holm.is_some_and(|p| p < SIGNIFICANCE_LEVEL)
}

/// A p-value in words; a dash where nothing is tested.
pub fn rounded(p_value: Option<f64>) -> String {
    match p_value {
        None => "-".to_owned(),
        Some(p) if p >= 1e-3 => format!("{p:.3}"),
        Some(p) if p < 1e-300 => "< 1e-300".to_owned(),
        Some(p) => format!("{p:.0e}"),
    }
}

/// A mean difference with its interval, or with the remark that there is only one outcome.
pub fn difference(paired: &Paired, decimals: usize) -> String {
    let mean = format!("{:+.decimals$}", paired.difference.mean);
    match paired.difference.interval {
        Some([lower, upper]) => format!("{mean} ({lower:+.decimals$} to {upper:+.decimals$})"),
        None => format!("{mean} (one outcome)"),
    }
}

/// The keys of a paired comparison's figures: mean difference, both ends of its interval, effect size, p-value,
/// corrected p-value.
pub const KEYS: [&str; 6] =
    ["difference", "difference_low", "difference_high", "effect_size", "p_value", "p_holm"];

/// Three columns: difference with interval, effect size, corrected p-value. `keys` are in the order of
/// [`KEYS`]; `shown` is the text of the difference.
pub fn paired_columns<'a, R>(
    columns: Columns<'a, R>,
    heading: &str,
    keys: [&str; 6],
    of: impl Fn(&R) -> Option<Paired>,
    shown: impl Fn(&R, &Paired) -> String,
) -> Columns<'a, R> {
    let dash = |cell: Option<String>| cell.unwrap_or_else(|| "-".to_owned());
    columns
        .column(heading, false, &keys[..3], |row| {
            let paired = of(row);
            let interval = paired.and_then(|p| p.difference.interval);
            Cell {
                shown: dash(paired.map(|p| shown(row, &p))),
                values: vec![
                    paired.map(|p| p.difference.mean).into(),
                    interval.map(|i| i[0]).into(),
                    interval.map(|i| i[1]).into(),
                ],
            }
        })
        .column("d", false, &keys[3..4], |row| {
            let effect = of(row).and_then(|p| p.effect_size);
            Cell { shown: dash(effect.map(|d| format!("{d:+.2}"))), values: vec![effect.into()] }
        })
        .column("p (Holm)", false, &keys[4..], |row| {
            let paired = of(row);
            let [raw, holm]: [Option<f64>; 2] =
                [paired.and_then(|p| p.p_value), paired.and_then(|p| p.p_holm)];
            Cell { shown: rounded(holm), values: vec![Value::from(raw), holm.into()] }
        })
}

/// The same, with the number of pairs for programs. Keys begin with `prefix`; keys of lengths end with `unit`.
pub fn compared<'a, R>(
    columns: Columns<'a, R>,
    heading: &str,
    [prefix, unit]: [&str; 2],
    of: impl Fn(&R) -> Option<Paired>,
) -> Columns<'a, R> {
    let keys = [
        format!("{prefix}_difference{unit}"),
        format!("{prefix}_difference_lower{unit}"),
        format!("{prefix}_difference_upper{unit}"),
        format!("{prefix}_effect_size"),
        format!("{prefix}_p_value"),
        format!("{prefix}_p_holm"),
    ];
    let pairs = |row: &R| of(row).map(|paired| paired.difference.n);
    let columns = columns.data(&format!("{prefix}_pairs"), pairs);
    paired_columns(columns, heading, keys.each_ref().map(String::as_str), &of, |_, p| difference(p, 0))
}

/// The table with a note on its comparisons, of which `tested` are tested.
pub fn explained(table: Table, tested: usize, family: &str) -> Table {
    table
        .with_note(format!(
            "Difference: mean over the humans, with its 95 % interval (Student's t); d: mean over standard deviation of the differences; p: two-sided paired t-test, corrected \
             by Holm's method for the {tested} comparisons {family} that are tested."
        ))
        .with_note(
            "One outcome: all these humans make the same choices, so nothing is tested.",
        )
}
