//! The report of `reproduce all`: the paper's claims, tables and figures beside the project's.
//!
//! A claim is one file here, with a [`Part`], and one line in [`PARTS`]. Its tables, pictures and finding are
//! then part of the report, its files and `--json`. The report is Markdown; the HTML page is made from it.

mod adaptation;
mod bodies;
mod choices;
mod contacts;
mod cycles;
mod learning;
mod page;
mod pairs;
mod part;
mod preparation;
mod run;
mod weight;

pub use adaptation::{example_picture, example_table, table_2};
pub use bodies::table_2_with_bodies;
pub use choices::table_1;
pub use contacts::contact_table;
pub use learning::{learning_tables, people_table};
pub use part::{Block, Figure, Finding, Part, Plan, ReportError, Section};
pub use preparation::{Compared, ratio_picture, table_3, table_3_ratios};
pub use weight::answers_picture;

use crate::table::Table;

/// The claims, in the order of the report.
pub const PARTS: &[Part] = &[
    choices::PART,
    weight::PART,
    adaptation::PART,
    bodies::PART,
    contacts::PART,
    cycles::PART,
    cycles::WITH_BODIES,
    preparation::PART,
    learning::PART,
];

/// The whole report. Equal plans give byte-identical reports on any number of threads.
#[derive(Clone, Debug)]
pub struct Report {
    /// The claims, in order.
    pub sections: Vec<Section>,
    /// The report as Markdown. Pictures are links to `figures/NAME.svg`, tables to `NAME.csv`.
    pub markdown: String,
}

impl Report {
    /// Assembles the sections of all [`PARTS`].
    pub fn new(plan: &Plan, sections: Vec<Section>) -> Self {
        let mut markdown = run::opening(plan, PARTS, &sections);
        let mut number = 0;
        for section in &sections {
            markdown += &format!("## {}\n\n", section.title);
            for block in &section.blocks {
                markdown += &match block {
                    Block::Text(text) => format!("{text}\n\n"),
                    Block::Table(table) => table.markdown(),
                    Block::Figure(Figure { name, caption, .. }) => {
                        number += 1;
                        format!("![Figure {number}. {caption}](figures/{name}.svg)\n\n")
                    }
                };
            }
        }
        markdown += &run::end(plan, PARTS);
        let markdown = run::with_contents(&markdown);
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

    /// The report as one self-contained HTML page. `made`, a sentence on how it was made, is at its end.
    pub fn page(&self, made: &str) -> String {
        let figures: Vec<&Figure> = self.figures().collect();
        page::html(&self.markdown, &figures, made)
    }

    fn blocks(&self) -> impl Iterator<Item = &Block> {
        self.sections.iter().flat_map(|section| &section.blocks)
    }
}
