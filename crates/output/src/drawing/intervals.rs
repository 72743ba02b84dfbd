//! The figure of estimates with their intervals: panels that have an axis each.

use super::kit::{
    AXIS_ROOM, Axis, GAP, Legend, Letters, LineStyle, MARGIN, STRIPE, Shape, Side, TITLE_ROOM, Text, border,
    document, frame_title, guide, left_of_rows, level_sample, mark, place, rectangle, row_label, stroke,
    upright,
};
use super::{WIDTH, not_drawable, nothing};
use cocarry::Error;
use cocarry::geometry::{Bounds, Point};
use svg::node::element::Group;

/// A part of the figure, with an axis of its own.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IntervalPanel {
    /// Title above the panel; long ones are shortened.
    pub title: String,
    /// Title of the axis.
    pub axis: String,
    /// Range of the axis; by default that of the values.
    pub range: Option<[f64; 2]>,
    /// A value with a line through all rows.
    pub guide: Option<f64>,
    /// Rows, top to bottom.
    pub rows: Vec<IntervalRow>,
}

/// An estimate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IntervalRow {
    /// Label at the left of the row; long ones are shortened.
    pub label: String,
    /// The estimate; none where there is nothing to draw.
    pub estimate: Option<f64>,
    /// The narrow and the wide interval around it.
    pub intervals: [Option<[f64; 2]>; 2],
    /// Another value to compare with.
    pub reference: Option<f64>,
}

/// What the marks are called in the legend; none is drawn for an empty name.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IntervalMarks<'a> {
    /// The estimate with its wide interval.
    pub estimate: &'a str,
    /// The narrow interval.
    pub narrow: &'a str,
    /// The other value.
    pub reference: &'a str,
}

/// Largest width of row labels, px.
const LABELS_WIDTH: f64 = 240.0;
/// Height of a row, px, and the number of rows from which on they are lower.
const ROW_HEIGHT: f64 = 28.0;
const LOW_ROW_HEIGHT: f64 = 20.0;
const MANY_ROWS: usize = 12;
/// Widths of the lines of the narrow and of the wide interval, px.
const LINES: [f64; 2] = [6.0, 2.4];
/// Largest value accepted.
const MAX_VALUE: f64 = 1e12;

/// Estimates with intervals. Panels are stacked, or, `side_by_side`, share the labels of the first one.
///
/// # Errors
/// There is no value, or one is not a number.
pub fn intervals(
    panels: &[IntervalPanel],
    side_by_side: bool,
    marks: IntervalMarks,
) -> Result<String, Error> {
    let rows = || panels.iter().flat_map(|panel| &panel.rows);
    for row in rows() {
        if let Some(value) = values(row).find(|value| value.is_nan() || value.abs() > MAX_VALUE) {
            return Err(not_drawable(format_args!("row `{}`", row.label), value));
        }
    }
    if rows().all(|row| row.estimate.is_none()) {
        return Err(nothing());
    }
    let left = left_of_rows(rows().map(|row| row.label.as_str()), LABELS_WIDTH);
    let across = if side_by_side { panels.len() } else { 1 };
    let pitch = (WIDTH - MARGIN - left + GAP) / across as f64;
    let mut drawn = Group::new();
    let mut top = 0.0;
    for line in panels.chunks(across) {
        let mut bottom: f64 = top;
        for (column, panel) in line.iter().enumerate() {
            let height = if panel.rows.len() < MANY_ROWS { ROW_HEIGHT } else { LOW_ROW_HEIGHT };
            let min = Point::new(left + column as f64 * pitch, top + TITLE_ROOM);
            let max = Point::new(min.x + pitch - GAP, min.y + height * panel.rows.len() as f64);
            drawn = drawn.add(draw(panel, Bounds { min, max }, column == 0));
            bottom = bottom.max(max.y);
        }
        top = bottom + AXIS_ROOM;
    }
    let (legend, bottom) = legend(marks).draw(Point::new(MARGIN, top), WIDTH - 2.0 * MARGIN);
    Ok(document(bottom).add(drawn).add(legend).to_string())
}

fn values(row: &IntervalRow) -> impl Iterator<Item = f64> {
    let ends = row.intervals.into_iter().flatten().flatten();
    row.estimate.into_iter().chain(ends).chain(row.reference)
}

/// The panel in its frame, with the labels of its rows if `has_labels`.
fn draw(panel: &IntervalPanel, frame: Bounds, has_labels: bool) -> Group {
    let axis = Axis::linear(Side::Below, range(panel), frame.grown(-GAP));
    let left = if has_labels { MARGIN } else { frame.min.x };
    let mut group = Group::new().set("class", "panel").add(frame_title(&panel.title, left, frame));
    let height = (frame.max.y - frame.min.y) / panel.rows.len().max(1) as f64;
    let top = |row: usize| frame.min.y + height * row as f64;
    for row in (0..panel.rows.len()).step_by(2) {
        let min = Point::new(frame.min.x, top(row));
        let max = Point::new(frame.max.x, top(row) + height);
        group = group.add(rectangle(Bounds { min, max }).set("fill", STRIPE));
    }
    group = group.add(axis.grid(frame));
    if let Some(value) = panel.guide {
        group = group.add(guide(upright(axis.at(value), frame)));
    }
    for (i, row) in panel.rows.iter().enumerate() {
        let middle = top(i) + height / 2.0;
        if has_labels {
            group = group.add(row_label(Letters::Text, &row.label, frame.min.x, middle));
        }
        group = group.add(of_row(row, &axis, middle));
    }
    group.add(border(frame)).add(axis.draw(frame, &Text::new(panel.axis.as_str())))
}

/// The range of a panel's axis.
fn range(panel: &IntervalPanel) -> [f64; 2] {
    panel.range.unwrap_or_else(|| {
        let all = || panel.rows.iter().flat_map(values).chain(panel.guide);
        let (least, most) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
        if least > most {
            return [0.0, 1.0];
        }
        let margin = (0.04 * (most - least)).max(1e-3 * most.abs()).max(1e-6);
        [least - margin, most + margin]
    })
}

/// The marks of a row centred at `middle` (px).
fn of_row(row: &IntervalRow, axis: &Axis, middle: f64) -> Group {
    let at = |value: f64| Point::new(axis.at(value), middle);
    let mut group = Group::new().set("class", "row");
    let lines = row.intervals.iter().zip(LINES).rev();
    for (ends, width) in lines.filter_map(|(ends, width)| Some(((*ends)?, width))) {
        group = group.add(stroke(&ends.map(at), &colour(0), width).set("class", "interval"));
    }
    if let Some(value) = row.reference {
        group = group.add(place(reference_mark(), at(value)));
    }
    match row.estimate {
        Some(value) => group.add(place(estimate_mark(), at(value))),
        None => group,
    }
}

fn legend(marks: IntervalMarks) -> Legend {
    let estimate = level_sample(&colour(0), LINES[1]).add(estimate_mark());
    let mut legend = Legend::of_lines().entry(estimate, marks.estimate);
    if !marks.narrow.is_empty() {
        legend = legend.entry(level_sample(&colour(0), LINES[0]), marks.narrow);
    }
    if !marks.reference.is_empty() {
        legend = legend.entry(reference_mark(), marks.reference);
    }
    legend
}

fn colour(style: usize) -> String {
    LineStyle::of(style).colour()
}

fn estimate_mark() -> Group {
    mark(Shape::Disc, true, &colour(0))
}

fn reference_mark() -> Group {
    mark(Shape::Diamond, false, &colour(1))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{NOTHING, error};
    use super::*;
    use crate::drawing::tests::checked;

    fn panel(title: &str) -> IntervalPanel {
        let row = |label: &str, estimate| IntervalRow {
            label: label.to_owned(),
            estimate,
            intervals: [Some([1.0, 2.0]), Some([0.0, 4.0])],
            reference: Some(3.0),
        };
        IntervalPanel {
            title: title.to_owned(),
            axis: "x (m)".to_owned(),
            guide: Some(0.0),
            rows: vec![row("<one>", Some(1.5)), row("two", None)],
            ..IntervalPanel::default()
        }
    }

    #[test]
    fn every_row_has_its_marks_and_intervals() {
        let marks = IntervalMarks { estimate: "median, 95 %", narrow: "50 %", reference: "model" };
        for side_by_side in [false, true] {
            let svg = checked(|| intervals(&[panel("a"), panel("b")], side_by_side, marks));
            assert_eq!(svg.matches("class=\"interval\"").count(), 8);
            // one estimate and two references in each panel, and two in the legend
            assert_eq!(svg.matches("class=\"mark\"").count(), 2 * 3 + 2);
            assert_eq!(svg.matches("&lt;one&gt;").count(), if side_by_side { 1 } else { 2 });
        }
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        assert_eq!(error(intervals(&[], false, IntervalMarks::default())), NOTHING);
        let mut spoiled = panel("a");
        spoiled.rows[0].reference = Some(f64::NAN);
        assert!(
            error(intervals(&[spoiled], false, IntervalMarks::default())).ends_with(": NaN cannot be drawn")
        );
    }
}
