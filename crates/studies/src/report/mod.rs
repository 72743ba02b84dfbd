//! The report of `reproduce all`: the paper's claims, tables and figures next to the project's.
//!
//! A claim is a folder in `paper`, with a [`Part`], and one line in [`PARTS`]. Its tables, pictures and
//! finding are then part of the report, its files and `--json`. The report is Markdown; the HTML page is made
//! from it.

mod document;
mod inferred;
mod page;
mod run;
mod tolerances;

pub use crate::paper::contacts::section::contact_table;
pub use crate::paper::h1::section::table_1;
pub use crate::paper::h1::weight::answers_picture;
pub use crate::paper::h2::bodies::table_2_with_bodies;
pub use crate::paper::h2::section::{example_picture, example_table, table_2};
pub use crate::paper::h3::guide_section::{guide_picture, guide_tables};
pub use crate::paper::h3::section::{Compared, ratio_picture, table_3, table_3_ratios};
pub use crate::paper::h4::section::{learning_tables, people_table};
pub use crate::paper::part::{Block, Figure, Finding, Part, Plan, Section};
pub use crate::paper::slots::section::slot_table;
pub use crate::paper::starts::section::start_table;
pub use document::Document;
pub use inferred::{figure_columns, people_columns, population_table, shown_interval};
pub use tolerances::{no_interval, tolerances_picture};

use crate::paper::{arrivals, contacts, coverage, cycles, h1, h2, h3, h4, slots, starts};
use crate::table::Table;

/// The claims, in the order of the report. A report may have some of them only.
pub const PARTS: &[Part] = &[
    h1::section::PART,
    h1::weight::PART,
    h2::section::PART,
    h2::bodies::PART,
    arrivals::section::PART,
    contacts::section::PART,
    slots::section::PART,
    starts::section::PART,
    cycles::section::PART,
    cycles::section::WITH_ROBOT,
    cycles::section::WITH_BODIES,
    h3::section::PART,
    h3::elsewhere::WITH_BODIES,
    h3::guide_section::PART,
    h3::elsewhere::OMNIDIRECTIONAL,
    h3::elsewhere::CHOICES,
    h4::section::PART,
    coverage::PART,
];

/// The whole report. Equal plans give byte-identical reports on any number of threads.
#[derive(Clone, Debug)]
pub struct Report {
    /// The ids of the parts, in order.
    pub parts: Vec<&'static str>,
    /// Their sections.
    pub sections: Vec<Section>,
    /// The report as Markdown. Pictures are links to `figures/NAME.svg`, tables to `NAME.csv`.
    pub markdown: String,
}

impl Report {
    /// Assembles the sections of these parts.
    pub fn new(plan: &Plan, parts: &[&Part], sections: Vec<Section>) -> Self {
        let contents = sections.iter().map(|section| (section.title.as_str(), section.blocks.as_slice()));
        let opening = run::opening(plan, parts, &sections);
        let markdown = document::markdown(&opening, contents, &run::end(plan, parts));
        let parts = parts.iter().map(|part| part.id).collect();
        Self { parts, sections, markdown }
    }

    /// The tables, in order.
    pub fn tables(&self) -> impl Iterator<Item = &Table> {
        self.blocks().filter_map(Block::table)
    }

    /// The index of the tables, as CSV: part, table, number of rows, and the CRC-32 of its CSV file as eight
    /// hexadecimal digits. Two reports with equal indices have equal tables.
    pub fn index(&self) -> String {
        let mut text = "part,table,rows,crc32\n".to_owned();
        for (part, section) in self.parts.iter().zip(&self.sections) {
            for block in &section.blocks {
                if let Block::Table(table) = block {
                    let crc = crc32fast::hash(&table.csv());
                    text += &format!("{part},{},{},{crc:08x}\n", table.name, table.rows.len());
                }
            }
        }
        text
    }

    /// The pictures, in order.
    pub fn figures(&self) -> impl Iterator<Item = &Figure> {
        self.blocks().filter_map(Block::figure)
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
