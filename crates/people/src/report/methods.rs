//! The robot's methods, compared within participants.

use super::read::{Carried, MEASURES, Measure};
use super::{MIN_PEOPLE, too_few};
use cocarry::Error;
use cocarry_output::drawing::{IntervalMarks, IntervalPanel, IntervalRow, intervals};
use cocarry_studies::paper::pairs;
use cocarry_studies::report::{Block, Figure};
use cocarry_studies::statistics::{Estimate, Paired, UnitMoments, correct};
use cocarry_studies::table::{Cell, Columns, Table};
use std::collections::{BTreeMap, BTreeSet};

impl Measure {
    /// Its name, with unit, and the decimals that are shown.
    fn shown(&self) -> (String, usize) {
        match self {
            Self::Episode(measure) => (MEASURES[*measure].1.to_owned(), MEASURES[*measure].2),
            Self::Scale(name) => (format!("scale: {name}"), 2),
        }
    }

    /// Its name for programs.
    pub fn key(&self) -> &str {
        match self {
            Self::Episode(measure) => MEASURES[*measure].0,
            Self::Scale(name) => name,
        }
    }
}

/// The comparison of two methods by a measure: first minus second.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Comparison {
    pub measure: Measure,
    pub methods: [String; 2],
    pub paired: Paired,
}

/// A measure of a method.
struct Described {
    measure: Measure,
    method: String,
    estimate: Estimate,
}

/// The values of a measure and a method, by participant and world.
type Values<'a> = BTreeMap<(&'a str, &'a str), f64>;

fn values<'a>(carried: &[&'a Carried]) -> BTreeMap<(&'a Measure, &'a str), Values<'a>> {
    let mut values: BTreeMap<_, Values> = BTreeMap::new();
    for row in carried {
        let own = values.entry((&row.measure, row.method.as_str())).or_default();
        own.insert((row.participant.as_str(), row.world.as_str()), row.value);
    }
    values
}

/// All pairs of methods by all measures, corrected by Holm's method. A participant counts with the mean over
/// the worlds in which they carried with both.
pub(super) fn comparisons(carried: &[&Carried]) -> Vec<Comparison> {
    let values = values(carried);
    let measures: BTreeSet<&Measure> = values.keys().map(|(measure, _)| *measure).collect();
    let mut all = Vec::new();
    for measure in measures {
        let methods: Vec<(&str, &Values)> = values
            .iter()
            .filter(|((other, _), _)| *other == measure)
            .map(|((_, method), values)| (*method, values))
            .collect();
        for (i, (first, ones)) in methods.iter().enumerate() {
            for (second, others) in &methods[i + 1..] {
                let both = ones.iter().filter_map(|(at, one)| {
                    let other = others.get(at)?;
                    Some((at.0, one - other, one.abs().max(other.abs())))
                });
                let units = UnitMoments::of(both);
                let moments = units.moments();
                let is_enough = moments.count() >= MIN_PEOPLE as u64;
                all.extend(Paired::of(moments, is_enough).map(|paired| Comparison {
                    measure: measure.clone(),
                    methods: [(*first).to_owned(), (*second).to_owned()],
                    paired,
                }));
            }
        }
    }
    correct(all.iter_mut().map(|comparison| &mut comparison.paired));
    all
}

/// A mean difference with its interval, or why it has none.
pub(super) fn difference(paired: &Paired, decimals: usize) -> String {
    match paired.difference.n < MIN_PEOPLE as u64 {
        true => format!("{:+.decimals$} (too few)", paired.difference.mean),
        false => pairs::difference(paired, decimals),
    }
}

pub(super) fn blocks(carried: &[&Carried], comparisons: &[Comparison]) -> Result<Vec<Block>, Error> {
    let people: BTreeSet<&str> = carried.iter().map(|row| row.participant.as_str()).collect();
    let mut blocks = vec![Block::Table(described(carried))];
    if comparisons.is_empty() {
        let text = "Nothing to compare: nobody carried with two methods in the same world.";
        blocks.push(Block::Text(text.to_owned()));
        return Ok(blocks);
    }
    blocks.push(Block::Table(compared(comparisons)));
    if people.len() < MIN_PEOPLE {
        blocks.push(Block::Text(too_few(people.len(), "tests, and the picture of differences")));
        return Ok(blocks);
    }
    blocks.push(Block::Figure(picture(comparisons)?));
    Ok(blocks)
}

fn described(carried: &[&Carried]) -> Table {
    let rows: Vec<Described> = values(carried)
        .into_iter()
        .filter_map(|((measure, method), values)| {
            let units = UnitMoments::of(values.iter().map(|(at, value)| (at.0, *value, value.abs())));
            let moments = units.moments();
            let estimate = moments.estimate(moments.count() >= MIN_PEOPLE as u64)?;
            Some(Described { measure: measure.clone(), method: method.to_owned(), estimate })
        })
        .collect();
    let shown = |row: &Described, value: Option<f64>| {
        let decimals = row.measure.shown().1;
        value.map_or("-".to_owned(), |value| format!("{value:.decimals$}"))
    };
    Columns::of(&rows)
        .column("measure", true, &["measure"], |row| Cell {
            shown: row.measure.shown().0,
            values: vec![row.measure.key().into()],
        })
        .text("method", "method", |row| row.method.clone())
        .count("participants", "participants", |row| row.estimate.n)
        .column("mean", false, &["mean"], |row| Cell {
            shown: shown(row, Some(row.estimate.mean)),
            values: vec![row.estimate.mean.into()],
        })
        .column("std", false, &["std"], |row| Cell {
            shown: shown(row, row.estimate.std),
            values: vec![row.estimate.std.into()],
        })
        .data("mean_low", |row| row.estimate.interval.map(|ends| ends[0]))
        .data("mean_high", |row| row.estimate.interval.map(|ends| ends[1]))
        .table("methods", "What was measured with each method")
        .with_note("Mean and standard deviation over participants, of each one's mean over worlds. Forces are simulated ones, on a simulated hand: nobody felt them.")
}

fn compared(comparisons: &[Comparison]) -> Table {
    let tested = comparisons.iter().filter(|c| c.paired.p_holm.is_some()).count();
    let columns = Columns::of(comparisons)
        .column("measure", true, &["measure"], |c| Cell {
            shown: c.measure.shown().0,
            values: vec![c.measure.key().into()],
        })
        .text("first", "first", |c| c.methods[0].clone())
        .text("second", "second", |c| c.methods[1].clone())
        .count("pairs", "pairs", |c| c.paired.difference.n);
    let shown = |c: &Comparison, paired: &Paired| difference(paired, c.measure.shown().1);
    pairs::paired_columns(columns, "first - second", pairs::KEYS, |c| Some(c.paired), shown)
        .table("methods-compared", "Methods compared within participants")
        .with_note(format!(
            "Each participant counts once, with the mean over the worlds in which they carried with both methods. Difference: with its 95 % interval (Student's t); d: mean over standard deviation of the differences; p: two-sided paired t-test, corrected by Holm's method for the {tested} comparisons that are tested."
        ))
        .with_note(format!(
            "One outcome: the differences of all participants are equal, so nothing is tested. Too few: fewer than {MIN_PEOPLE} pairs."
        ))
}

fn picture(comparisons: &[Comparison]) -> Result<Figure, Error> {
    let row = |c: &Comparison| IntervalRow {
        label: c.methods.join(" - "),
        estimate: Some(c.paired.difference.mean),
        intervals: [None, c.paired.difference.interval],
        reference: None,
    };
    let panels: Vec<IntervalPanel> = comparisons
        .chunk_by(|a, b| a.measure == b.measure)
        .map(|own| IntervalPanel {
            title: own[0].measure.shown().0,
            axis: "difference".to_owned(),
            guide: Some(0.0),
            rows: own.iter().map(row).collect(),
            ..IntervalPanel::default()
        })
        .collect();
    let marks = IntervalMarks { estimate: "mean difference, 95 % interval", narrow: "", reference: "" };
    Ok(Figure {
        name: "methods".to_owned(),
        caption: "Differences between methods within participants, with 95 % intervals; none where all participants differ equally.".to_owned(),
        is_half: false,
        svg: intervals(&panels, false, marks)?,
    })
}
