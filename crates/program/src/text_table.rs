//! Tables as text that fit a width: text wraps at words, numbers never; columns without room go below.

use comfy_table::{CellAlignment, ColumnConstraint, ContentArrangement, LineStyle, Table, TableStyle, Width};
use std::ops::Range;

/// Three rules: above the headings, below them, and at the end.
const STYLE: TableStyle = TableStyle::new()
    .top_border(LineStyle::none().fill('─'))
    .header_separator(LineStyle::none().fill('═'))
    .bottom_border(LineStyle::none().fill('─'));
/// Spaces on either side of the contents of a column.
const PADDING: usize = 2;

/// A table of texts.
pub(super) struct TextTable {
    headings: Vec<String>,
    is_text: Vec<bool>,
    rows: Vec<Vec<String>>,
}

impl TextTable {
    /// An empty table. Columns of text are aligned left, the others right.
    pub fn new(
        headings: impl IntoIterator<Item = impl Into<String>>,
        is_text: impl Fn(usize) -> bool,
    ) -> Self {
        // a unit does not leave its number
        let whole = |heading: String| heading.replace(" %", "\u{a0}%");
        let headings: Vec<String> = headings.into_iter().map(Into::into).map(whole).collect();
        let is_text = (0..headings.len()).map(is_text).collect();
        Self { headings, is_text, rows: Vec::new() }
    }

    /// Adds a row with a cell for each column.
    pub fn add_row(&mut self, cells: impl IntoIterator<Item = impl Into<String>>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
    }

    /// The table as text, at most `width` characters wide, if that is given and possible.
    pub fn text(&self, width: Option<usize>) -> String {
        let all: Vec<usize> = (0..self.headings.len()).collect();
        let widest: Vec<usize> = all.iter().map(|&column| self.width(column, false)).collect();
        let Some(width) = width.filter(|width| total(&widest) > *width) else {
            return self.part(&all, &widest);
        };
        let least: Vec<usize> = all.iter().map(|&column| self.width(column, true)).collect();
        let sets = self.columns_by_part(&least, width).into_iter().map(|columns| {
            let mut widths: Vec<usize> = columns.iter().map(|&column| least[column]).collect();
            // the rest goes to the columns in their order
            for (at, &column) in columns.iter().enumerate() {
                let room = width.saturating_sub(total(&widths));
                widths[at] += room.min(widest[column] - least[column]);
            }
            self.part(&columns, &widths)
        });
        sets.collect::<Vec<_>>().join("\n")
    }

    /// The columns of each part: the first ones, which say what a row is, and as many others as have room.
    fn columns_by_part(&self, least: &[usize], width: usize) -> Vec<Vec<usize>> {
        let keys: Range<usize> = 0..self.is_text.iter().take_while(|is_text| **is_text).count().max(1);
        let mut parts = vec![keys.clone().collect::<Vec<_>>()];
        for column in keys.end..self.headings.len() {
            let part = &parts[parts.len() - 1];
            let widths: Vec<usize> = part.iter().chain([&column]).map(|&column| least[column]).collect();
            if total(&widths) > width && part.len() > keys.len() {
                parts.push(keys.clone().collect());
            }
            parts.last_mut().into_iter().for_each(|part| part.push(column));
        }
        parts
    }

    /// The width of a column's contents; of the longest word, if text and headings may wrap.
    fn width(&self, column: usize, may_wrap: bool) -> usize {
        let of = |text: &str, may_wrap: bool| match may_wrap {
            true => text.split(' ').map(textwrap::core::display_width).max().unwrap_or(0),
            false => textwrap::core::display_width(text),
        };
        let cells = self.rows.iter().map(|row| of(&row[column], may_wrap && self.is_text[column]));
        cells.chain([of(&self.headings[column], may_wrap)]).max().unwrap_or(0)
    }

    /// Some columns, with the widths of their contents.
    fn part(&self, columns: &[usize], widths: &[usize]) -> String {
        let pick = |row: &[String]| columns.iter().map(|&column| row[column].clone()).collect::<Vec<_>>();
        let mut table = Table::new();
        table.load_style(STYLE).set_content_arrangement(ContentArrangement::Dynamic);
        table.set_header(pick(&self.headings));
        self.rows.iter().for_each(|row| {
            table.add_row(pick(row));
        });
        for ((column, &at), &width) in table.column_iter_mut().zip(columns).zip(widths) {
            let width = u16::try_from(width + PADDING).unwrap_or(u16::MAX);
            column.set_constraint(ColumnConstraint::Absolute(Width::Fixed(width)));
            if !self.is_text[at] {
                column.set_cell_alignment(CellAlignment::Right);
            }
        }
        let rule = |sign: char| std::iter::repeat_n(sign, total(widths)).collect::<String>();
        let line = |line: &str| match line.chars().next() {
            Some(sign @ ('─' | '═')) => rule(sign) + "\n",
            _ => line.trim_end().replace('\u{a0}', " ") + "\n",
        };
        table.to_string().lines().map(line).collect()
    }
}

fn total(widths: &[usize]) -> usize {
    widths.iter().map(|width| width + PADDING).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> TextTable {
        let mut table = TextTable::new(["world", "openings", "D (m)", "95 %"], |column| column < 2);
        table.add_row(["environment-1", "north gate, south gate", "7.5", "10.25 to 12.50"]);
        table.add_row(["kitchen", "", "-10.25", "-"]);
        table
    }

    #[test]
    fn golden_a_table_with_enough_room() {
        let text = example().text(None);
        assert_eq!(
            text,
            "───────────────────────────────────────────────────────────────\n \
              world          openings                 D (m)            95 %\n\
             ═══════════════════════════════════════════════════════════════\n \
              environment-1  north gate, south gate     7.5  10.25 to 12.50\n \
              kitchen                                -10.25               -\n\
             ───────────────────────────────────────────────────────────────\n"
        );
        assert_eq!(example().text(Some(200)), text);
    }

    #[test]
    fn a_table_fits_any_width_without_splitting_a_word_or_a_number() {
        for width in 44..90 {
            let text = example().text(Some(width));
            let widest = text.lines().map(textwrap::core::display_width).max().unwrap();
            assert!(widest <= width, "{widest} of {width}:\n{text}");
            for whole in ["environment-1", "north", "gate,", "-10.25", "10.25 to 12.50", "kitchen"] {
                assert!(text.contains(whole), "{whole} at {width}:\n{text}");
            }
        }
        // columns without room go below, with the names of the rows
        let narrow = example().text(Some(45));
        assert_eq!(narrow.matches("kitchen").count(), 2, "{narrow}");
    }
}
