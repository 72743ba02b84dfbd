//! The legend of every picture: samples of lines and marks with their meanings, in columns or as a table with
//! headings.

use super::{Align, GAP, INK, Letters, LineStyle, TEXT_SIZE, Text, place, stroke};
use cocarry::geometry::{Point, Vector};
use svg::node::element::Group;

/// Length of a sample, px.
pub(in super::super) const SAMPLE: f64 = 46.0;
const SAMPLE_ENDS: [[f64; 2]; 2] = [[-SAMPLE / 2.0, 0.0], [SAMPLE / 2.0, 0.0]];
/// Height of a line, px.
const LINE: f64 = 25.0;
/// Room below the last line, px.
const BELOW: f64 = 14.0;
/// Distance of columns, px.
const COLUMN_GAP: f64 = 14.0;

/// Samples with their meanings.
pub(in super::super) struct Legend {
    /// Room for a sample, px.
    sample: f64,
    heads: Vec<(Text, Align)>,
    entries: Vec<Entry>,
    letters: Letters,
}

struct Entry {
    /// Drawn around the origin.
    sample: Group,
    /// The lines of every cell; only tables have more than one.
    cells: Vec<Vec<Text>>,
}

impl Legend {
    pub fn of_lines() -> Self {
        Self::table(Vec::new())
    }

    pub fn of_marks() -> Self {
        Self { sample: SAMPLE / 2.0, ..Self::of_lines() }
    }

    /// A legend in the form of a table, with a heading and an alignment for every column.
    pub fn table(heads: Vec<(Text, Align)>) -> Self {
        Self { sample: SAMPLE, heads, entries: Vec::new(), letters: Letters::Text }
    }

    /// The same legend in these letters.
    pub fn with_letters(self, letters: Letters) -> Self {
        Self { letters, ..self }
    }

    /// Adds a sample, drawn around the origin, with its meaning.
    pub fn entry(self, sample: Group, text: impl Into<String>) -> Self {
        self.row(sample, vec![vec![Text::new(text)]])
    }

    /// Adds a row of a table: the sample and the lines of every cell.
    pub fn row(mut self, sample: Group, cells: Vec<Vec<Text>>) -> Self {
        self.entries.push(Entry { sample, cells });
        self
    }

    /// Width of a sample with its cells, px.
    pub fn width(&self) -> f64 {
        self.sample + self.column_widths().iter().map(|width| COLUMN_GAP + width).sum::<f64>()
    }

    fn column_widths(&self) -> Vec<f64> {
        let columns = self.entries.iter().map(|e| e.cells.len()).fold(self.heads.len(), usize::max);
        let width = |column: usize| {
            let cells = self.entries.iter().filter_map(|e| e.cells.get(column)).flatten();
            cells.chain(self.heads.get(column).map(|h| &h.0)).map(|t| t.width(TEXT_SIZE)).fold(0.0, f64::max)
        };
        (0..columns).map(width).collect()
    }

    /// The legend with its upper left corner at `at`, in as many columns as fit into `width` px, and the y at
    /// which it ends.
    pub fn draw(&self, at: Point, width: f64) -> (Group, f64) {
        let widths = self.column_widths();
        let aligns = || self.heads.iter().map(|h| h.1).chain(std::iter::repeat(Align::Left));
        // cells side by side, from `from` on the first baseline
        let cells = |group: Group, from: Point, cells: &[Vec<Text>]| {
            let mut left = from.x + self.sample;
            let mut group = group;
            for ((lines, width), align) in cells.iter().zip(&widths).zip(aligns()) {
                left += COLUMN_GAP;
                let x = if matches!(align, Align::Right) { left + width } else { left };
                for (i, line) in lines.iter().enumerate() {
                    let at = Point::new(x, from.y + i as f64 * LINE);
                    group = group.add(line.lettered(self.letters, at, TEXT_SIZE, align));
                }
                left += width;
            }
            group
        };
        let mut group = Group::new().set("class", "legend");
        let mut y = at.y;
        let mut across = 1;
        if self.heads.is_empty() {
            across = (((width + COLUMN_GAP) / (self.width() + COLUMN_GAP)) as usize).max(1);
        } else {
            y += LINE;
            let heads: Vec<Vec<Text>> = self.heads.iter().map(|h| vec![h.0.clone()]).collect();
            group = cells(group, Point::new(at.x, y), &heads);
            y += GAP;
            group = group.add(stroke(&[Point::new(at.x, y), Point::new(at.x + self.width(), y)], INK, 0.8));
        }
        for row in self.entries.chunks(across) {
            y += LINE;
            for (column, entry) in row.iter().enumerate() {
                let from = Point::new(at.x + column as f64 * (self.width() + COLUMN_GAP), y);
                let middle = from + Vector::new(self.sample / 2.0, -0.35 * TEXT_SIZE);
                group = cells(group.add(place(entry.sample.clone(), middle)), from, &entry.cells);
            }
            let lines = row.iter().flat_map(|e| &e.cells).map(Vec::len).fold(1, usize::max);
            y += (lines - 1) as f64 * LINE;
        }
        (group, y + BELOW)
    }
}

/// The sample of a plain line.
pub(in super::super) fn level_sample(colour: &str, width: f64) -> Group {
    Group::new().add(stroke(&SAMPLE_ENDS.map(Point::from), colour, width))
}

/// The sample of a line with a style.
pub(in super::super) fn line_sample(style: LineStyle, width: f64) -> Group {
    style.draw(&SAMPLE_ENDS.map(Point::from), width)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_stand_in_as_many_columns_as_fit() {
        let entry =
            |legend: Legend, i: usize| legend.entry(line_sample(LineStyle::of(i), 3.0), format!("entry {i}"));
        let legend = (0..5).fold(Legend::of_lines(), entry);
        let height =
            |columns: f64| legend.draw(Point::origin(), columns * (legend.width() + COLUMN_GAP)).1 - BELOW;
        assert_eq!(
            [1.0, 2.0, 3.5, 5.0, 0.1].map(height),
            [5.0, 3.0, 2.0, 1.0, 5.0].map(|lines| lines * LINE)
        );
    }

    #[test]
    fn a_table_leaves_room_for_cells_of_several_lines() {
        let head = |name: &str, align| (Text::new(name), align);
        let rows = |lines: usize| {
            let cells = vec![vec![Text::new("wide enough"); lines], vec![Text::new("1")]];
            let legend = Legend::table(vec![head("a", Align::Left), head("b", Align::Right)]);
            legend.row(Group::new(), cells.clone()).row(Group::new(), cells).draw(Point::origin(), 0.0).1
        };
        assert_eq!(rows(3) - rows(1), 4.0 * LINE);
    }
}
