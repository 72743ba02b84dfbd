//! The figure of differences between costs, with their intervals.

use super::kit::{
    Axis, Legend, LineStyle, MARGIN, Shape, Sheet, Strips, Text, document_on, level_sample, mark, place,
    stroke,
};
use super::{not_drawable, nothing};
use cocarry::Error;
use cocarry::geometry::Point;
use svg::node::element::Group;

/// One part of the figure; all parts have the same horizontal axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DifferencePanel {
    /// Title above the panel; long ones are shortened.
    pub title: String,
    /// Rows, top to bottom.
    pub rows: Vec<DifferenceRow>,
}

/// Differences between two costs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DifferenceRow {
    /// Label at the left of the row; long ones are shortened.
    pub label: String,
    /// The mean over a sample, m.
    pub mean: f64,
    /// The interval of that mean, m.
    pub interval: Option<[f64; 2]>,
    /// The expectation over all humans, m.
    pub expected: Option<f64>,
    /// The paper's value, m.
    pub paper: Option<f64>,
}

/// Largest width of row labels, px.
const LABELS_WIDTH: f64 = 220.0;
/// Height of a row, px.
const ROW_HEIGHT: f64 = 34.0;
/// Width of the line of an interval, px.
const INTERVAL_LINE: f64 = 4.0;
/// Largest difference accepted, m.
const MAX_VALUE: f64 = 1e9;

/// Differences between costs: for every row a disc at the sample's mean, a line for its interval, a square at
/// the expectation and a diamond at the paper's value. Panels are stacked on one axis, which includes 0.
///
/// # Errors
/// There is no row, or a value is not a number.
pub fn differences(panels: &[DifferencePanel], axis_title: &str, sheet: Sheet) -> Result<String, Error> {
    let rows = || panels.iter().flat_map(|panel| &panel.rows);
    if rows().next().is_none() {
        return Err(nothing());
    }
    for row in rows() {
        if let Some(value) = values(row).find(|value| value.is_nan() || value.abs() > MAX_VALUE) {
            return Err(not_drawable(format_args!("row `{}`", row.label), value));
        }
    }
    let all = || rows().flat_map(values);
    let (least, most) = (all().fold(0.0, f64::min), all().fold(0.0, f64::max));
    let margin = 0.04 * (most - least).max(1.0);
    let strips = Strips {
        panels: panels
            .iter()
            .map(|p| (p.title.as_str(), p.rows.iter().map(|r| r.label.as_str()).collect()))
            .collect(),
        labels_width: LABELS_WIDTH,
        row_height: ROW_HEIGHT,
        range: [least - margin, most + margin],
        guide: Some(0.0),
        sheet,
    };
    let (drawn, top) = strips.draw(&Text::new(axis_title), |[panel, row], axis, middle| {
        marks(&panels[panel].rows[row], axis, middle)
    });
    let sample = level_sample(&colour(0), INTERVAL_LINE).add(sample_mark());
    let mut legend = Legend::of_lines().entry(sample, "mean of the sample, 95 % interval");
    if rows().any(|row| row.expected.is_some()) {
        legend = legend.entry(expected_mark(), "expectation over all humans");
    }
    if rows().any(|row| row.paper.is_some()) {
        legend = legend.entry(paper_mark(), "paper");
    }
    let (legend, bottom) =
        legend.with_letters(sheet.letters).draw(Point::new(MARGIN, top), sheet.width - 2.0 * MARGIN);
    Ok(document_on(sheet, bottom).add(drawn).add(legend).to_string())
}

fn values(row: &DifferenceRow) -> impl Iterator<Item = f64> {
    let interval = row.interval.into_iter().flatten();
    [row.mean].into_iter().chain(interval).chain(row.expected).chain(row.paper)
}

/// The marks of a row centred at `middle` (px).
fn marks(row: &DifferenceRow, axis: &Axis, middle: f64) -> Group {
    let at = |value: f64| Point::new(axis.at(value), middle);
    let mut marks = Group::new();
    if let Some(ends) = row.interval {
        marks = marks.add(stroke(&ends.map(at), &colour(0), INTERVAL_LINE).set("class", "interval"));
    }
    marks = marks.add(place(sample_mark(), at(row.mean)));
    marks = row.expected.into_iter().fold(marks, |marks, value| marks.add(place(expected_mark(), at(value))));
    row.paper.into_iter().fold(marks, |marks, value| marks.add(place(paper_mark(), at(value))))
}

fn colour(style: usize) -> String {
    LineStyle::of(style).colour()
}

fn sample_mark() -> Group {
    mark(Shape::Disc, true, &colour(0))
}

fn expected_mark() -> Group {
    mark(Shape::Square, false, &colour(1))
}

fn paper_mark() -> Group {
    mark(Shape::Diamond, false, &colour(2))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{NOTHING, error};
    use super::*;
    use crate::drawing::tests::checked;

    #[test]
    fn every_row_has_its_marks_and_its_interval() {
        let row = |label: &str, interval| DifferenceRow {
            label: label.to_owned(),
            mean: -120.0,
            interval,
            expected: Some(-110.0),
            paper: Some(-90.0),
        };
        let rows = vec![row("eta 5", Some([-200.0, -40.0])), row("eta 15", None)];
        let panel = DifferencePanel { title: "Environment 1".to_owned(), rows };
        let svg =
            checked(|| differences(&[panel.clone(), panel.clone()], "difference (m)", Sheet::default()));
        assert_eq!(svg.matches("class=\"interval\"").count(), 2);
        assert_eq!(svg.matches("class=\"row\"").count(), 4);
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        assert_eq!(error(differences(&[], "", Sheet::default())), NOTHING);
        let rows = vec![DifferenceRow { mean: f64::NAN, ..DifferenceRow::default() }];
        let panel = DifferencePanel { rows, ..DifferencePanel::default() };
        assert!(error(differences(&[panel], "", Sheet::default())).ends_with(": NaN cannot be drawn"));
    }
}
