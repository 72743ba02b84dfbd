//! The power of studies as tables and pictures.

use super::{Effect, PowerRow, PowerSettings, is_width};
use cocarry::Error;
use cocarry_output::drawing::{Curve, CurvePanel, curves};
use cocarry_studies::report::{Block, Document, Figure};
use cocarry_studies::table::{Columns, Table, escaped};

/// A sentence about the number of participants that is enough.
pub(super) fn verdict(rows: &[PowerRow], settings: &PowerSettings) -> String {
    let wanted = 100.0 * settings.power;
    let enough = |of: fn(&PowerRow) -> f64| {
        let below = rows.iter().rposition(|row| of(row) < settings.power);
        rows.get(below.map_or(0, |at| at + 1)).map(|row| row.participants)
    };
    match (enough(|row| row.power), enough(|row| row.interval[0])) {
        (None, _) => format!("None of these numbers of participants reaches {wanted:.0} %."),
        (Some(number), Some(sure)) if number == sure => {
            format!(
                "{wanted:.0} % of the studies find it from {number} participants on, its Monte-Carlo interval included."
            )
        }
        (Some(number), Some(sure)) => format!(
            "{wanted:.0} % of the studies find it from {number} participants on; with its Monte-Carlo interval, from {sure} on."
        ),
        (Some(number), None) => format!(
            "{wanted:.0} % of the studies find it from {number} participants on; its Monte-Carlo interval reaches below: simulate more studies or try larger numbers."
        ),
    }
}

/// The table of an effect.
fn table(effect: Effect, rows: &[PowerRow], settings: &PowerSettings) -> Table {
    let percent = |share: f64| 100.0 * share;
    let width = |row: &PowerRow, which: usize| row.widths.map(|w| w[which]).filter(|w| is_width(*w));
    let mut columns = Columns::of(rows)
        .count("participants", "participants", |row| row.participants)
        .number("found (%)", "power_percent", 1, move |row| percent(row.power))
        .number("from", "power_low_percent", 1, move |row| percent(row.interval[0]))
        .number("to", "power_high_percent", 1, move |row| percent(row.interval[1]))
        .data("found", |row| row.found)
        .data("studies", |row| row.studies);
    if !matches!(effect, Effect::Difference(_)) {
        columns = columns
            .derived("median width", |row| width(row, 1).map_or("-".to_owned(), |w| format!("{w:.3}")))
            .count("undetermined", "undetermined", |row| row.undetermined as u64)
            .data("width_10_percent", |row| width(row, 0))
            .data("width_median", |row| width(row, 1))
            .data("width_90_percent", |row| width(row, 2));
    }
    columns
        .table(
            &format!("power-{}", effect.name()),
            format!("Share of studies that find {}", effect.words(settings.comparisons)),
        )
        .with_note(verdict(rows, settings))
        .with_note(format!(
            "{} simulated studies, seed {}; from, to: 95 % Monte-Carlo interval (Wilson).",
            settings.studies, settings.seed
        ))
}

fn picture(effect: Effect, rows: &[PowerRow], settings: &PowerSettings) -> Result<Figure, Error> {
    let points = |of: &dyn Fn(&PowerRow) -> Option<f64>| -> Vec<[f64; 2]> {
        rows.iter().filter_map(|row| Some([row.participants as f64, of(row)?])).collect()
    };
    let curve = |label: &str, points| Curve { label: label.to_owned(), points };
    let numbers = || rows.iter().map(|row| row.participants as f64);
    let (least, most) = (numbers().fold(f64::MAX, f64::min), numbers().fold(0.0, f64::max));
    let range = if least < most { [least, most] } else { [0.0, most] };
    let mut panels = vec![CurvePanel {
        title: "studies that find it".to_owned(),
        axes: ["participants".to_owned(), "share".to_owned()],
        ranges: [range, [0.0, 1.0]],
        mark: Some(settings.power),
        curves: vec![
            curve("share", points(&|row| Some(row.power))),
            curve("from, 95 %", points(&|row| Some(row.interval[0]))),
            curve("to, 95 %", points(&|row| Some(row.interval[1]))),
        ],
    }];
    let width =
        |which: usize| points(&move |row: &PowerRow| row.widths.map(|w| w[which]).filter(|w| is_width(*w)));
    let widest = [0, 1, 2].iter().flat_map(|which| width(*which)).map(|point| point[1]).fold(0.0, f64::max);
    if !matches!(effect, Effect::Difference(_)) && widest > 0.0 {
        panels.push(CurvePanel {
            title: "width of the interval".to_owned(),
            axes: ["participants".to_owned(), effect.name().to_owned()],
            ranges: [range, [0.0, 1.05 * widest.max(effect.size())]],
            mark: Some(effect.size()),
            curves: vec![curve("median", width(1)), curve("10 %", width(0)), curve("90 %", width(2))],
        });
    }
    Ok(Figure {
        name: format!("power-{}", effect.name()),
        caption: format!(
            "Share of {} simulated studies that find {}, by the number of participants.",
            settings.studies,
            effect.words(settings.comparisons)
        ),
        is_half: false,
        svg: curves(&panels)?,
    })
}

/// A document with a section for every effect.
///
/// # Errors
/// A number cannot be drawn.
pub fn power_document(
    title: &str,
    effects: &[(Effect, Vec<PowerRow>)],
    settings: &PowerSettings,
) -> Result<Document, Error> {
    let opening = format!(
        "# {}: how many participants\n\nBy simulated studies, without a browser, as `cocarry study simulate` makes them: people of known alpha, gamma and eta answer as the model says, 5 % of the answers say nothing, and each study is evaluated as `cocarry fit` and `cocarry infer` do by default. Differences between methods are drawn from a normal distribution. Real people vary in more ways: take these numbers as the least.\n\n",
        escaped(title)
    );
    let section = |(effect, rows): &(Effect, Vec<PowerRow>)| {
        let blocks = vec![
            Block::Table(table(*effect, rows, settings)),
            Block::Figure(picture(*effect, rows, settings)?),
        ];
        Ok((effect.to_string(), blocks))
    };
    let sections = effects.iter().map(section).collect::<Result<_, Error>>()?;
    Ok(Document::new(&opening, sections))
}
