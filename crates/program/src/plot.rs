//! `cocarry plot`: pictures of a study's results.

use super::output::{Failure, OverwriteArguments, examples, input, print, svg_file, write_file};
use anyhow::{Context, anyhow};
use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};
use cocarry::quantities::{EPISODE, Kind};
use cocarry_output::drawing::{
    DifferencePanel, DifferenceRow, HeatPanel, MeanPanel, MeanRow, differences, heat_maps, means,
};
use cocarry_studies::study::{Comparison, Group, OUTCOMES, Plane, PlanePart, Summary};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Draw the results of a study: means with intervals, paired differences, or a map over alpha and gamma
#[derive(Args, Debug)]
#[command(after_help = examples(&[
    ("cocarry plot study.csv -o means.svg", "the costs of every combination, with 95 % intervals"),
    ("cocarry plot study.csv -o differences.svg --kind differences", "what the methods differ by, paired by seed"),
    ("cocarry plot study.csv -o map.svg --kind map --quantity final_discomfort", "which humans it is hard on"),
]))]
pub(super) struct PlotArguments {
    /// Results of `cocarry sweep` (CSV)
    results: PathBuf,
    /// Picture to write (SVG)
    #[arg(short, long, value_name = "FILE", value_parser = svg_file)]
    output: PathBuf,
    /// What to draw
    #[arg(long, value_enum, default_value_t = Picture::Means)]
    kind: Picture,
    /// Quantity to draw; differences are of costs
    #[arg(long, value_name = "COLUMN", default_value = OUTCOMES[0], value_parser = PossibleValuesParser::new(OUTCOMES))]
    quantity: String,
    /// Intervals of alpha and of gamma in a map
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u16).range(2..=60))]
    cells: u16,
    #[command(flatten)]
    overwrite: OverwriteArguments,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Picture {
    /// Means over humans, with 95 % intervals
    Means,
    /// Differences between methods or poses with the same seeds, with 95 % intervals
    Differences,
    /// Means over the humans' alpha and gamma
    Map,
}

pub(super) fn run_plot(arguments: &PlotArguments) -> Result<ExitCode, Failure> {
    let PlotArguments { results, output, kind, quantity, cells, overwrite } = arguments;
    let outputs = overwrite.outputs([results.as_path()], [output])?;
    let drawn = match kind {
        Picture::Means => picture_of_means(results, quantity)?,
        Picture::Differences => picture_of_differences(results, quantity)?,
        Picture::Map => picture_of_plane(results, quantity, usize::from(*cells))?,
    };
    write_file(&outputs, output, &drawn)?;
    print(&format!("wrote {}\n", output.display()))?;
    Ok(ExitCode::SUCCESS)
}

/// The inputs that rows and panels are named by: those that vary, but not those that repeat a name.
fn named(varied: &[String]) -> Vec<&str> {
    const REPEATED: [&str; 4] = ["humans_alpha", "humans_gamma", "belief_alpha", "belief_gamma"];
    varied.iter().map(String::as_str).filter(|name| !REPEATED.contains(name)).collect()
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
        Some(Kind::Number(unit)) if !unit.is_empty() => {
            let words = column.strip_suffix(&format!("_{unit}")).unwrap_or(column);
            format!("{} ({unit})", words.replace('_', " "))
        }
        _ => column.replace('_', " "),
    }
}

/// Panels by world, rows by all other inputs but the method, a series for every method.
fn picture_of_means(file: &Path, quantity: &str) -> Result<String, Failure> {
    let summary = Summary::load(file).map_err(input)?;
    let names: Vec<&str> =
        named(&summary.varied).into_iter().filter(|name| !["world", "method"].contains(name)).collect();
    let mut series: Vec<String> = Vec::new();
    let mut panels: Vec<MeanPanel> = Vec::new();
    let mut rows: BTreeMap<(usize, String), usize> = BTreeMap::new();
    for group in &summary.groups {
        let of = |name: &str| group.inputs.get(name).cloned().unwrap_or_default();
        let method = of("method");
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
    draw(file, means(&panels, &series, &title(quantity)), quantity)
}

fn mean(group: &Group, quantity: &str) -> Option<(f64, Option<[f64; 2]>)> {
    group.outcomes.get(quantity).copied().flatten().map(|estimate| (estimate.mean, estimate.interval))
}

/// Panels by world and by what is compared, a row for every two combinations.
fn picture_of_differences(file: &Path, quantity: &str) -> Result<String, Failure> {
    let summary = Summary::load(file).map_err(input)?;
    let names: Vec<&str> = named(&summary.varied).into_iter().filter(|name| *name != "world").collect();
    let compared: Vec<&Comparison> = summary.comparisons.iter().filter(|c| c.cost == quantity).collect();
    if compared.is_empty() {
        let costs: Vec<_> = summary.comparisons.iter().map(|c| c.cost).collect();
        let known = OUTCOMES.iter().filter(|known| costs.contains(known)).copied().collect::<Vec<_>>();
        let known = if known.is_empty() {
            "its combinations differ neither in the method nor in the pose alone".to_owned()
        } else {
            format!("it has those of {}", known.join(" and "))
        };
        let file = file.display();
        return Err(input(anyhow!("{file}: no differences of `{quantity}` between combinations; {known}")));
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
    draw(file, differences(&panels, &axis), quantity)
}

/// A map for every combination.
fn picture_of_plane(file: &Path, quantity: &str, cells: usize) -> Result<String, Failure> {
    let plane = Plane::load(file, quantity, cells).map_err(input)?;
    let first = &plane.parts[0].inputs;
    let varies = |name: &&String| plane.parts.iter().any(|part| part.inputs.get(*name) != first.get(*name));
    let varied: Vec<String> = first.keys().filter(varies).cloned().collect();
    let names: Vec<&str> = named(&varied).into_iter().filter(|name| *name != "world").collect();
    let names = if names.is_empty() { vec!["method"] } else { names };
    let panel = |part: &PlanePart| HeatPanel {
        title: label(&part.inputs, &["world"]),
        subtitle: label(&part.inputs, &names),
        values: part.means.clone(),
    };
    let panels: Vec<HeatPanel> = plane.parts.iter().map(panel).collect();
    draw(file, heat_maps(&panels, plane.ranges, &title(quantity)), quantity)
}

fn draw(file: &Path, drawn: Result<String, cocarry::Error>, quantity: &str) -> Result<String, Failure> {
    drawn.with_context(|| format!("{}: `{quantity}` cannot be drawn", file.display())).map_err(Failure::Input)
}
