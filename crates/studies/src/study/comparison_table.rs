//! The table of a summary's paired comparisons, and what its reader should know.

use super::row;
use super::summary::{Comparison, OUTCOMES, Summary, SummaryGroup};
use crate::paper::pairs::{KEYS, paired_columns};
use crate::statistics::{Estimate, Paired};
use crate::table::{Cell, Columns, Table};
use cocarry::quantities::{EPISODE, QuantityKind};
use serde_json::Value;

/// Short names of the quantities that are compared most.
const SHORT: [(&str, &str); 3] = [
    ("accumulated_objective_cost_m", "J (m)"),
    ("accumulated_control_cost", "C"),
    ("accumulated_subjective_cost", "J^"),
];

impl Summary {
    /// Means, standard deviations and 95 % intervals of every combination, as a table for programs.
    pub fn group_table(&self) -> Table {
        let always = ["world", "method"].into_iter().filter(|key| !self.varied.iter().any(|v| v == key));
        let keys: Vec<&str> = always.chain(self.varied.iter().map(String::as_str)).collect();
        let mut columns = Columns::of(&self.groups);
        for key in keys {
            columns =
                columns.column("", true, &[key], |group: &SummaryGroup| input(key, group.inputs.get(key)));
        }
        columns = columns.count("n", "n", |group| group.n).count("arrived", "arrived", |group| group.arrived);
        for key in OUTCOMES {
            let of = move |group: &SummaryGroup| group.outcomes.get(key).copied().flatten();
            let end = move |which: usize| {
                move |group: &SummaryGroup| of(group).and_then(|found| found.interval).map(|ends| ends[which])
            };
            columns = columns
                .data(&format!("{key}_mean"), move |group| of(group).map(|found| found.mean))
                .data(&format!("{key}_std"), move |group| of(group).and_then(|found| found.std))
                .data(&format!("{key}_low"), end(0))
                .data(&format!("{key}_high"), end(1));
        }
        columns.table("groups", "Means over humans")
    }

    /// The paired comparisons as a table: for people those that differ at all, or all if `with_equal`.
    pub fn comparison_table(&self, with_equal: bool) -> Table {
        let differs = |c: &&Comparison| {
            let Estimate { mean, std, .. } = c.difference.difference;
            with_equal || mean != 0.0 || std.is_some_and(|std| std > 0.0)
        };
        let shown: Vec<&Comparison> = self.comparisons.iter().filter(differs).collect();
        let has = |key: &&String| shown.iter().any(|c| c.inputs.contains_key(*key));
        let named = self.named();
        let mut columns = Columns::of(&shown);
        for key in self.varied.iter().filter(has) {
            let heading = if named.contains(&key.as_str()) { key } else { "" };
            columns = columns.column(heading, true, &[key], |c| input(key, c.inputs.get(key)));
        }
        columns = columns
            .column("quantity", true, &["quantity"], |c| Cell {
                shown: short(c.cost).to_owned(),
                values: vec![c.cost.into()],
            })
            .column("compared", true, &["first", "second"], |c| Cell {
                shown: format!("{} - {}", c.first, c.second),
                values: vec![c.first.as_str().into(), c.second.as_str().into()],
            })
            .count("pairs", "pairs", |c| c.difference.difference.n);
        let columns = paired_columns(
            columns,
            "difference (95 %)",
            KEYS,
            |c| Some(c.difference),
            |c, paired| difference(c.cost, paired),
        );
        let columns = columns
            .column("lower in", false, &["share_lower"], |c| Cell {
                shown: format!("{:.0} %", 100.0 * c.share_lower),
                values: vec![c.share_lower.into()],
            })
            .data("std", |c| c.difference.difference.std)
            .data("arrived_both", |c| c.arrivals[0])
            .data("arrived_first_only", |c| c.arrivals[1])
            .data("arrived_second_only", |c| c.arrivals[2])
            .data("arrived_none", |c| c.arrivals[3]);
        let mut table = columns.table("comparisons", "Paired by seed");
        for note in self.comparison_notes(shown.len() < self.comparisons.len()) {
            table = table.with_note(note);
        }
        table
    }

    fn comparison_notes(&self, are_left_out: bool) -> Vec<String> {
        let tested = self.comparisons.iter().filter(|c| c.difference.p_value.is_some()).count();
        let test = match tested {
            0 => String::new(),
            1 => "; p: paired t-test".to_owned(),
            _ => {
                format!("; p: paired t-test, corrected by Holm's method for the {tested} comparisons tested")
            }
        };
        let mut notes = vec![format!(
            "First minus second, all other inputs equal, over the seeds with which both arrived. d: mean of the differences over their standard deviation{test}."
        )];
        if self.comparisons.iter().any(|c| c.difference.difference.interval.is_none()) {
            notes[0] += " One outcome: no interval and no test, since all humans make the same choices, and seeds differ by gait noise only.";
        }
        if are_left_out {
            notes.push("Comparisons without any difference are left out.".to_owned());
        }
        let (named, mut arrivals): (_, Vec<String>) = (self.named(), Vec::new());
        for c in self.comparisons.iter().filter(|c| c.arrivals[1..] != [0, 0, 0]) {
            let [both, first, second, none] = c.arrivals;
            let is_told =
                |(key, value): &(&String, &String)| named.contains(&key.as_str()) && !value.is_empty();
            let inputs = c.inputs.iter().filter(is_told);
            let inputs = inputs.map(|(key, value)| format!(", {key} {value}")).collect::<String>();
            let line = format!(
                "Not all arrived: {} - {}{inputs}: both {both}, only the first {first}, only the second {second}, none {none}.",
                c.first, c.second
            );
            if !arrivals.contains(&line) {
                arrivals.push(line);
            }
        }
        notes.extend(arrivals);
        notes
    }
}

/// The cell of an input: a number for programs, if its column has numbers.
fn input(key: &str, text: Option<&String>) -> Cell {
    let shown = text.cloned().unwrap_or_default();
    let kind = row::headings().into_iter().find(|heading| heading.name == key).map(|heading| heading.kind);
    let value = match kind {
        _ if shown.is_empty() => Value::Null,
        Some(QuantityKind::Number(_)) => shown.parse::<f64>().map_or(Value::Null, Value::from),
        Some(QuantityKind::Count) => shown.parse::<u64>().map_or(Value::Null, Value::from),
        Some(QuantityKind::Flag) => shown.parse::<bool>().map_or(Value::Null, Value::from),
        _ => Value::from(shown.as_str()),
    };
    Cell { shown, values: vec![value] }
}

fn short(quantity: &'static str) -> &'static str {
    SHORT.iter().find(|(key, _)| *key == quantity).map_or(quantity, |(_, short)| short)
}

/// The difference with as many decimals as the quantity has.
fn difference(quantity: &str, paired: &Paired) -> String {
    let is_count = EPISODE.iter().any(|q| q.key == quantity && matches!(q.kind, QuantityKind::Count));
    let largest =
        paired.difference.interval.map_or(paired.difference.mean.abs(), |[a, b]| a.abs().max(b.abs()));
    let decimals = match largest {
        _ if is_count => 2,
        large if large >= 100.0 => 1,
        small if small < 1.0 => 4,
        _ => 2,
    };
    crate::paper::pairs::difference(paired, decimals)
}
