//! A document of sections with tables and pictures: Markdown, and the HTML page that is made from it.

use super::page;
use crate::paper::part::{Block, Figure};
use crate::table::Table;

/// A document. Equal blocks give equal bytes.
#[derive(Clone, Debug)]
pub struct Document {
    /// The sections: titles, and what is in them.
    pub sections: Vec<(String, Vec<Block>)>,
    /// The document as Markdown. Pictures are links to `figures/NAME.svg`, tables to `NAME.csv`.
    pub markdown: String,
}

impl Document {
    /// A document that begins with `opening`, a heading and paragraphs in Markdown.
    pub fn new(opening: &str, sections: Vec<(String, Vec<Block>)>) -> Self {
        let contents = sections.iter().map(|(title, blocks)| (title.as_str(), blocks.as_slice()));
        let markdown = markdown(opening, contents, "");
        Self { sections, markdown }
    }

    /// The tables, in order.
    pub fn tables(&self) -> impl Iterator<Item = &Table> {
        self.blocks().filter_map(Block::table)
    }

    /// The pictures, in order.
    pub fn figures(&self) -> impl Iterator<Item = &Figure> {
        self.blocks().filter_map(Block::figure)
    }

    /// The document as one self-contained HTML page. `made`, a sentence on how it was made, is at its end.
    pub fn page(&self, made: &str) -> String {
        page::html(&self.markdown, &self.figures().collect::<Vec<_>>(), made)
    }

    fn blocks(&self) -> impl Iterator<Item = &Block> {
        self.sections.iter().flat_map(|(_, blocks)| blocks)
    }
}

/// Opening, sections and end, with a list of all sections before the first of them.
pub(super) fn markdown<'a>(
    opening: &str,
    sections: impl Iterator<Item = (&'a str, &'a [Block])>,
    end: &str,
) -> String {
    let mut markdown = opening.to_owned();
    let mut number = 0;
    for (title, blocks) in sections {
        markdown += &format!("## {title}\n\n");
        for block in blocks {
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
    with_contents(&(markdown + end))
}

/// The text with a table of its sections before the first of them.
fn with_contents(markdown: &str) -> String {
    let titles = markdown.lines().filter_map(|line| line.strip_prefix("## "));
    let contents: String = titles.map(|title| format!("- [{title}](#{})\n", anchor(title))).collect();
    markdown.replacen("\n## ", &format!("\n{contents}\n## "), 1)
}

/// The anchor of a heading, as forges make it: small letters, digits and hyphens.
pub(super) fn anchor(title: &str) -> String {
    let kept = title.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
    kept.flat_map(char::to_lowercase).map(|c| if c == ' ' { '-' } else { c }).collect()
}
