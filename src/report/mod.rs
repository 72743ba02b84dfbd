//! The report of `reproduce all`: the paper's claims, tables and figures, ours beside the paper's.
//!
//! A claim is one file here, with a [`Part`], and one line in [`PARTS`]: its tables, pictures and finding get into the report, its files and
//! `--json` by themselves. The report is Markdown; the page is made from that.

mod adaptation;
mod bodies;
mod choices;
mod cycles;
mod page;
mod pairs;
mod preparation;
mod run;
mod weight;

pub use adaptation::{example_picture, example_table, table_2};
pub use bodies::table_2_with_bodies;
pub use choices::table_1;
pub use preparation::{Compared, ratio_picture, table_3, table_3_ratios};
pub use weight::answers_picture;

use super::fit::FitError;
use crate::drawing::DrawingError;
use crate::episode::Settings;
use crate::options::OptionError;
use crate::paper::BuiltInError;
use crate::paper::{cycles as locked, h2, h3};
use crate::parallel::OnDone;
use crate::robot::Robot;
use crate::table::Table;
use crate::world::WorldError;
use thiserror::Error;

/// The claims, in the order of the report.
pub const PARTS: &[Part] =
    &[choices::PART, weight::PART, adaptation::PART, bodies::PART, cycles::PART, preparation::PART];

/// How much is run.
#[derive(Clone, Debug)]
pub struct Plan<'a> {
    /// The robot of Table III and of the team with bodies.
    pub robot: &'a Robot,
    /// The loop's settings.
    pub settings: Settings,
    /// Random humans in each cell of Table III.
    pub episodes: usize,
    /// Humans in each cell of Table II with bodies.
    pub humans: usize,
    /// Random worlds in which locked cycles are looked for.
    pub worlds: usize,
    /// Seed of everything random.
    pub seed: u64,
}

impl<'a> Plan<'a> {
    /// As much as the paper, and as the commands for the single claims do.
    pub fn new(robot: &'a Robot) -> Self {
        Self {
            robot,
            settings: Settings::default(),
            episodes: h3::EPISODES,
            humans: h2::SAMPLES,
            worlds: locked::WORLDS,
            seed: 0,
        }
    }
}

/// A claim, and how it is looked into.
pub struct Part {
    /// What a progress bar calls it.
    pub name: &'static str,
    /// Episodes that it runs.
    pub episodes: fn(&Plan) -> usize,
    /// Runs them.
    pub run: fn(&Plan, OnDone) -> Result<Section, ReportError>,
}

/// A section of the report.
#[derive(Clone, Debug)]
pub struct Section {
    /// Its heading.
    pub title: String,
    /// What came of the claim.
    pub finding: Finding,
    /// What stands in it.
    pub blocks: Vec<Block>,
}

/// What came of a claim, in words and figures of this run.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// What is claimed.
    pub claim: &'static str,
    /// Whether it holds.
    pub verdict: String,
    /// How well.
    pub figures: String,
}

/// A piece of a section.
#[derive(Clone, Debug)]
pub enum Block {
    /// Paragraphs, as Markdown.
    Text(String),
    /// A table.
    Table(Table),
    /// A picture.
    Figure(Figure),
}

/// A picture with what it shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Name of its file, without an ending.
    pub name: String,
    /// What it shows.
    pub caption: String,
    /// Whether two of the kind stand beside each other, where there is room.
    pub is_half: bool,
    /// The picture, as SVG.
    pub svg: String,
}

/// All of it. Equal plans give equal reports, to the byte, on any number of threads.
#[derive(Clone, Debug)]
pub struct Report {
    /// The claims, in order.
    pub sections: Vec<Section>,
    /// As Markdown; pictures are links to `figures/NAME.svg`, tables to `NAME.csv`.
    pub markdown: String,
}

/// Why there is no report: a fault of the program, as what is reported on is built in.
#[derive(Debug, Error)]
pub enum ReportError {
    /// A built-in world.
    #[error(transparent)]
    BuiltIn(#[from] BuiltInError),
    /// A picture.
    #[error(transparent)]
    Drawing(#[from] DrawingError),
    /// The fit of c_r.
    #[error(transparent)]
    Fit(#[from] FitError),
}

impl From<WorldError> for ReportError {
    fn from(error: WorldError) -> Self {
        Self::BuiltIn(error.into())
    }
}

impl From<OptionError> for ReportError {
    fn from(error: OptionError) -> Self {
        Self::BuiltIn(error.into())
    }
}

impl Report {
    /// Puts the sections of all [`PARTS`] together.
    pub fn new(plan: &Plan, sections: Vec<Section>) -> Self {
        let mut markdown = run::opening(plan, &sections);
        for section in &sections {
            markdown += &format!("## {}\n\n", section.title);
            for block in &section.blocks {
                markdown += &match block {
                    Block::Text(text) => format!("{text}\n\n"),
                    Block::Table(table) => table.markdown(),
                    Block::Figure(Figure { name, caption, .. }) => {
                        format!("![{caption}](figures/{name}.svg)\n\n")
                    }
                };
            }
        }
        markdown += &run::end(plan);
        Self { sections, markdown }
    }

    /// The tables, in order.
    pub fn tables(&self) -> impl Iterator<Item = &Table> {
        self.blocks().filter_map(|block| if let Block::Table(table) = block { Some(table) } else { None })
    }

    /// The pictures, in order.
    pub fn figures(&self) -> impl Iterator<Item = &Figure> {
        self.blocks().filter_map(|block| if let Block::Figure(figure) = block { Some(figure) } else { None })
    }

    /// The report as one HTML page that needs nothing else; `made`, a sentence on how it was made, stands at its end.
    pub fn page(&self, made: &str) -> String {
        let figures: Vec<&Figure> = self.figures().collect();
        page::html(&self.markdown, &figures, made)
    }

    fn blocks(&self) -> impl Iterator<Item = &Block> {
        self.sections.iter().flat_map(|section| &section.blocks)
    }
}

/// `n of m`, in words: whether a claim holds in all of them.
fn holds(n: usize, of: usize, what: &str) -> String {
    match n {
        _ if n == of => "holds".to_owned(),
        0 => "does not hold".to_owned(),
        _ => format!("holds in {n} of {of} {what}"),
    }
}

/// A number with its thousands apart.
fn grouped(n: usize) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_words_for_numbers() {
        assert_eq!([0, 999, 1000, 25600, 1234567].map(grouped), ["0", "999", "1,000", "25,600", "1,234,567"]);
        assert_eq!(holds(16, 16, "cells"), "holds");
        assert_eq!(holds(0, 16, "cells"), "does not hold");
        assert_eq!(holds(3, 16, "cells"), "holds in 3 of 16 cells");
    }
}
