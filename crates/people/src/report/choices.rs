//! Percentages: Table I's human column with intervals, beside the model.

use super::{MIN_PEOPLE, too_few};
use cocarry::Error;
use cocarry::episode::EpisodeSettings;
use cocarry::preference::ChoiceDistribution;
use cocarry_output::drawing::{IntervalMarks, IntervalPanel, IntervalRow, intervals};
use cocarry_studies::fit::Answers;
use cocarry_studies::paper::ENVIRONMENTS;
use cocarry_studies::paper::h1::{Closeness, closeness};
use cocarry_studies::parallel::OnDone;
use cocarry_studies::report::{Block, Figure};
use cocarry_studies::statistics::bootstrapped;
use cocarry_studies::table::{Cell, Columns};

/// An option's answers.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Choice {
    world: String,
    option: String,
    answers: u64,
    /// Percent.
    mean: f64,
    interval: Option<[f64; 2]>,
    model: f64,
    /// Mean answer of the paper's participants, where the world is the paper's.
    paper: Option<f64>,
}

/// The answers of a group, and how close the model is to them in each world.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Choices {
    pub rows: Vec<Choice>,
    pub worlds: Vec<(String, Closeness)>,
}

impl Choices {
    /// Mean absolute difference of the model over all options, percentage points; `None` without answers.
    pub fn off(&self) -> Option<f64> {
        let off: f64 = self.rows.iter().map(|row| (row.model - row.mean).abs()).sum();
        (!self.rows.is_empty()).then(|| off / self.rows.len() as f64)
    }

    /// Pairs of options with different answers, and those that the model puts in the same order.
    pub fn pairs(&self) -> [usize; 2] {
        let sum = |of: fn(&Closeness) -> usize| self.worlds.iter().map(|(_, c)| of(c)).sum();
        [sum(|c| c.pairs), sum(|c| c.ranked)]
    }
}

/// The answers beside P_o with the default ranges.
pub(super) fn choices(answers: &Answers, resamples: usize, seed: u64, on_done: OnDone) -> Choices {
    let options = |shares: &[Option<Vec<f64>>]| -> Vec<Option<f64>> {
        let worlds = answers.situations.iter().zip(shares);
        let percent = worlds.flat_map(|(situation, shares)| {
            (0..situation.options.len()).map(move |o| shares.as_ref().map(|shares| 100.0 * shares[o]))
        });
        percent.collect()
    };
    let people: Vec<Vec<Option<f64>>> = answers.shares.iter().map(|shares| options(shares)).collect();
    let ends = match people.len() < MIN_PEOPLE {
        true => vec![None; people.first().map_or(0, Vec::len)],
        false => bootstrapped(&people, resamples, seed, on_done),
    };
    let mut predictor = EpisodeSettings::default().predictor;
    let mut choice = ChoiceDistribution::default();
    let (mut rows, mut worlds, mut column) = (Vec::new(), Vec::new(), 0);
    for situation in &answers.situations {
        predictor.predict(&situation.prospects, &mut choice);
        let paper = ENVIRONMENTS.iter().find(|environment| environment.name == situation.world);
        let first = rows.len();
        for (o, option) in situation.options.iter().enumerate() {
            let own: Vec<f64> = people.iter().filter_map(|person| person[column]).collect();
            if !own.is_empty() {
                rows.push(Choice {
                    world: situation.world.clone(),
                    option: option.clone(),
                    answers: own.len() as u64,
                    mean: own.iter().sum::<f64>() / own.len() as f64,
                    interval: ends[column].map(|ends: [f64; 2]| ends.map(|end| end.clamp(0.0, 100.0))),
                    model: 100.0 * choice.probabilities()[o],
                    paper: paper.and_then(|paper| paper.human_percent.get(o).copied()),
                });
            }
            column += 1;
        }
        let own = &rows[first..];
        if !own.is_empty() {
            let of = |of: fn(&Choice) -> f64| own.iter().map(of).collect::<Vec<_>>();
            worlds.push((situation.world.clone(), closeness(&of(|c| c.mean), &of(|c| c.model))));
        }
    }
    Choices { rows, worlds }
}

/// A percentage with its interval.
fn shown(mean: f64, interval: Option<[f64; 2]>) -> String {
    match interval {
        Some([low, high]) => format!("{mean:.1} ({low:.1} to {high:.1})"),
        None => format!("{mean:.1}"),
    }
}

pub(super) fn blocks(
    choices: &Choices,
    people: usize,
    resamples: usize,
    seed: u64,
) -> Result<Vec<Block>, Error> {
    let Choices { rows, worlds } = choices;
    let mut columns = Columns::of(rows)
        .text("world", "world", |r| r.world.clone())
        .text("option", "option", |r| r.option.clone())
        .count("answers", "answers", |r| r.answers)
        .column("people (%)", false, &["people_percent", "people_low_percent", "people_high_percent"], |r| {
            Cell {
                shown: shown(r.mean, r.interval),
                values: vec![r.mean.into(), r.interval.map(|i| i[0]).into(), r.interval.map(|i| i[1]).into()],
            }
        })
        .number("P_o (%)", "model_percent", 1, |r| r.model)
        .derived("P_o - people", |r| format!("{:+.1}", r.model - r.mean));
    if rows.iter().any(|r| r.paper.is_some()) {
        columns = columns.column("paper's people (%)", false, &["paper_people_percent"], |r| Cell {
            shown: r.paper.map_or("-".to_owned(), |percent| format!("{percent:.1}")),
            values: vec![r.paper.into()],
        });
    }
    let table = columns
        .table("choices", "How likely people would choose each option, and the model")
        .with_note("P_o: eq. (4) with the default ranges of alpha and gamma, which were not fitted to these answers.");
    let table = table.with_note(match people < MIN_PEOPLE {
        true => too_few(people, "intervals"),
        false => format!(
            "Intervals: 95 %, percentiles of {resamples} bootstrap resamples of the participants, seed {seed}; none where all gave the same percentage."
        ),
    });
    let fits = Columns::of(worlds)
        .text("world", "world", |(world, _)| world.clone())
        .number("P_o", "model_points", 1, |(_, c)| c.off)
        .number("one option for everyone, at best", "fixed_points", 1, |(_, c)| c.fixed)
        .derived("pairs ranked as by people", |(_, c)| format!("{} of {}", c.ranked, c.pairs))
        .data("ranked_pairs", |(_, c)| c.ranked)
        .data("pairs", |(_, c)| c.pairs)
        .table("choices-fit", "Mean absolute difference from people's mean answers, percentage points")
        .with_note("The measures of `cocarry reproduce h1` for Table I. One option for everyone: the least that any single choice by everyone can be off.");
    let picture = Figure {
        name: "choices".to_owned(),
        caption: "Mean answers with 95 % intervals over participants, and P\u{2092} with the default ranges."
            .to_owned(),
        is_half: false,
        svg: intervals(
            &panels(rows),
            false,
            IntervalMarks {
                estimate: if people < MIN_PEOPLE { "mean answer" } else { "mean answer, 95 % interval" },
                reference: "P_o",
                narrow: "",
            },
        )?,
    };
    Ok(vec![Block::Table(table), Block::Table(fits), Block::Figure(picture)])
}

fn panels(rows: &[Choice]) -> Vec<IntervalPanel> {
    let row = |choice: &Choice| IntervalRow {
        label: choice.option.clone(),
        estimate: Some(choice.mean),
        intervals: [None, choice.interval],
        reference: Some(choice.model),
    };
    rows.chunk_by(|a, b| a.world == b.world)
        .map(|rows| IntervalPanel {
            title: rows[0].world.clone(),
            axis: "percent".to_owned(),
            range: Some([0.0, 100.0]),
            guide: None,
            rows: rows.iter().map(row).collect(),
        })
        .collect()
}
