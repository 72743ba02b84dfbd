//! Pictures of a study's results.

use super::compared::Comparing;
use super::results::Results;
use super::summary::{Comparison, Summary, SummaryGroup};
use super::{OUTCOMES, Plane, PlanePart, SweepError};
use cocarry::Error;
use cocarry::quantities::{EPISODE, QuantityKind};
use cocarry_output::drawing::{
    DifferencePanel, DifferenceRow, HeatPanel, MeanPanel, MeanRow, Sheet, differences, heat_maps, means,
};
use std::collections::BTreeMap;

/// What is drawn.
#[derive(Clone, Debug)]
pub enum Drawn {
    /// Means over humans, with 95 % intervals.
    Means,
    /// Differences between what is compared, with 95 % intervals.
    Differences(Comparing),
    /// Means over the humans' alpha and gamma, in a grid of so many intervals of each.
    Map(usize),
}

/// Draws results on a sheet, as SVG, and returns what a reader should know of the rows.
///
/// # Errors
/// [`SweepError`]: the results cannot be read, or do not have what is drawn.
pub fn picture(
    results: &[Results],
    quantity: &str,
    drawn: &Drawn,
    sheet: Sheet,
) -> Result<(String, Vec<String>), SweepError> {
    let names = results.iter().map(Results::name).collect::<Vec<_>>().join(", ");
    let (svg, notes) = match drawn {
        Drawn::Map(cells) => {
            (of_plane(&Plane::load(results, quantity, *cells)?, quantity, sheet), Vec::new())
        }
        Drawn::Means => {
            let summary = Summary::load(results, &Comparing::default())?;
            (of_means(&summary, quantity, sheet), summary.notes)
        }
        Drawn::Differences(comparing) => {
            let summary = Summary::load(results, comparing)?;
            (of_differences(&names, &summary, quantity, sheet)?, summary.notes)
        }
    };
    let refused = |error| Error::new(format!("{names}: `{quantity}` cannot be drawn")).because(error);
    Ok((svg.map_err(refused)?, notes))
}

/// The label of a combination: its values, with the names of numbers.
fn label(inputs: &BTreeMap<String, String>, names: &[&str]) -> String {
    let word = |name: &&str| {
        let value = inputs.get(*name).map(String::as_str).filter(|value| !value.is_empty())?;
        let is_word = value.parse::<f64>().is_err() && !["true", "false"].contains(&value);
        Some(if is_word { value.to_owned() } else { format!("{} {value}", name.replace('_', " ")) })
    };
    names.iter().filter_map(word).collect::<Vec<_>>().join(", ")
}

/// A column as the title of an axis, with its unit.
fn title(column: &str) -> String {
    let unit = EPISODE.iter().find(|quantity| quantity.key == column).map(|quantity| quantity.kind);
    match unit {
        Some(QuantityKind::Number(unit)) if !unit.is_empty() => {
            let words = column.strip_suffix(&format!("_{unit}")).unwrap_or(column);
            format!("{} ({unit})", words.replace('_', " "))
        }
        _ => column.replace('_', " "),
    }
}

/// Panels by world, rows by all other inputs but the method, a series for every method.
fn of_means(summary: &Summary, quantity: &str, sheet: Sheet) -> Result<String, Error> {
    let series_of = ["method", "policy_code"];
    let named = summary.named();
    let names: Vec<&str> =
        named.iter().copied().filter(|name| *name != "world" && !series_of.contains(name)).collect();
    let series_of: Vec<&str> =
        series_of.into_iter().filter(|name| *name == "method" || named.contains(name)).collect();
    let mut series: Vec<String> = Vec::new();
    let mut panels: Vec<MeanPanel> = Vec::new();
    let mut rows: BTreeMap<(usize, String), usize> = BTreeMap::new();
    for group in &summary.groups {
        let of = |name: &str| group.inputs.get(name).cloned().unwrap_or_default();
        let method = label(&group.inputs, &series_of);
        let which = series.iter().position(|known| *known == method).unwrap_or_else(|| {
            series.push(method);
            series.len() - 1
        });
        let world = of("world");
        let panel = panels.iter().position(|panel| panel.title == world).unwrap_or_else(|| {
            panels.push(MeanPanel { title: world, rows: Vec::new() });
            panels.len() - 1
        });
        let label = label(&group.inputs, &names);
        let list = &mut panels[panel].rows;
        let row = *rows.entry((panel, label.clone())).or_insert_with(|| {
            list.push(MeanRow { label, means: Vec::new() });
            list.len() - 1
        });
        let list = &mut list[row].means;
        list.resize(list.len().max(which + 1), None);
        list[which] = mean(group, quantity);
    }
    means(&panels, &series, &title(quantity), sheet)
}

fn mean(group: &SummaryGroup, quantity: &str) -> Option<(f64, Option<[f64; 2]>)> {
    group.outcomes.get(quantity).copied().flatten().map(|estimate| (estimate.mean, estimate.interval))
}

/// Panels by world and by what is compared, a row for every two combinations.
fn of_differences(
    file: &str,
    summary: &Summary,
    quantity: &str,
    sheet: Sheet,
) -> Result<Result<String, Error>, SweepError> {
    let names: Vec<&str> = summary.named().into_iter().filter(|name| *name != "world").collect();
    let compared: Vec<&Comparison> = summary.comparisons.iter().filter(|c| c.cost == quantity).collect();
    if compared.is_empty() {
        let costs: Vec<_> = summary.comparisons.iter().map(|c| c.cost).collect();
        let known = OUTCOMES.iter().filter(|known| costs.contains(known)).copied().collect::<Vec<_>>();
        let known = if known.is_empty() {
            "no two combinations differ in what is compared alone".to_owned()
        } else {
            format!("it has those of {}", known.join(" and "))
        };
        let error =
            Error::new(format!("{file}: no differences of `{quantity}` between combinations; {known}"));
        return Err(SweepError::File(error));
    }
    let mut panels: Vec<DifferencePanel> = Vec::new();
    for comparison in compared {
        let world = comparison.inputs.get("world").or_else(|| summary.groups[0].inputs.get("world"));
        let Comparison { first, second, inputs, difference, .. } = comparison;
        let title = format!("{}: {first} - {second}", world.map_or("", String::as_str));
        let row = DifferenceRow {
            label: label(inputs, &names),
            mean: difference.difference.mean,
            interval: difference.difference.interval,
            ..DifferenceRow::default()
        };
        match panels.iter_mut().find(|panel| panel.title == title) {
            Some(panel) => panel.rows.push(row),
            None => panels.push(DifferencePanel { title, rows: vec![row] }),
        }
    }
    let axis = format!("difference of {}", title(quantity));
    Ok(differences(&panels, &axis, sheet))
}

/// A map for every combination.
fn of_plane(plane: &Plane, quantity: &str, sheet: Sheet) -> Result<String, Error> {
    let first = &plane.parts[0].inputs;
    let varies = |name: &&String| plane.parts.iter().any(|part| part.inputs.get(*name) != first.get(*name));
    const REPEATED: [&str; 5] = ["world", "humans_alpha", "humans_gamma", "belief_alpha", "belief_gamma"];
    let varied = first.keys().filter(varies).map(String::as_str);
    let names: Vec<&str> = varied.filter(|name| !REPEATED.contains(name)).collect();
    let names = if names.is_empty() { vec!["method"] } else { names };
    let panel = |part: &PlanePart| HeatPanel {
        title: label(&part.inputs, &["world"]),
        subtitle: label(&part.inputs, &names),
        values: part.means.clone(),
    };
    let panels: Vec<HeatPanel> = plane.parts.iter().map(panel).collect();
    heat_maps(&panels, plane.ranges, &title(quantity), sheet)
}
