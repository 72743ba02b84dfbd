//! The figure of means with their intervals: one row per combination, one mark per series.

use super::kit::{
    Axis, Legend, LineStyle, MARGIN, Shape, Sheet, Strips, Text, document_on, level_sample, mark, place,
    stroke,
};
use super::{not_drawable, nothing};
use cocarry::Error;
use cocarry::geometry::Point;
use svg::node::element::Group;

/// One part of the figure; all parts have the same horizontal axis and the same series.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeanPanel {
    /// Title above the panel; long ones are shortened.
    pub title: String,
    /// Rows, top to bottom.
    pub rows: Vec<MeanRow>,
}

/// The means of one combination.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeanRow {
    /// Label at the left of the row; long ones are shortened.
    pub label: String,
    /// For every series the mean and its interval, in the unit of the axis.
    pub means: Vec<Option<(f64, Option<[f64; 2]>)>>,
}

/// Largest width of row labels, px.
const LABELS_WIDTH: f64 = 240.0;
/// Height of a series in a row, and of the row beyond its series, px.
const SERIES_HEIGHT: f64 = 15.0;
const ROW_ROOM: f64 = 16.0;
/// Width of the line of an interval, px.
const INTERVAL_LINE: f64 = 3.0;
/// Largest mean accepted.
const MAX_VALUE: f64 = 1e12;
/// The marks of the series, in turn.
const SHAPES: [Shape; 4] = [Shape::Disc, Shape::Square, Shape::Triangle, Shape::Diamond];

/// Means with intervals: for every row and series a mark at the mean and a line for its interval. Panels are
/// stacked on one axis, which has the range of the values.
///
/// # Errors
/// There is no mean, or a value is not a number.
pub fn means(
    panels: &[MeanPanel],
    series: &[String],
    axis_title: &str,
    sheet: Sheet,
) -> Result<String, Error> {
    let rows = || panels.iter().flat_map(|panel| &panel.rows);
    for row in rows() {
        if let Some(value) = values(row).find(|value| value.is_nan() || value.abs() > MAX_VALUE) {
            return Err(not_drawable(format_args!("row `{}`", row.label), value));
        }
    }
    let all = || rows().flat_map(values);
    let (least, most) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
    if least > most {
        return Err(nothing());
    }
    // a single value has an axis, too
    let margin = (0.04 * (most - least)).max(1e-3 * most.abs()).max(1e-6);
    let strips = Strips {
        panels: panels
            .iter()
            .map(|p| (p.title.as_str(), p.rows.iter().map(|r| r.label.as_str()).collect()))
            .collect(),
        labels_width: LABELS_WIDTH,
        row_height: ROW_ROOM + SERIES_HEIGHT * series.len() as f64,
        range: [least - margin, most + margin],
        guide: None,
        sheet,
    };
    let (drawn, top) = strips.draw(&Text::new(axis_title), |[panel, row], axis, middle| {
        marks(&panels[panel].rows[row], series.len(), axis, middle)
    });
    let entry = |legend: Legend, (i, name): (usize, &String)| {
        legend.entry(level_sample(&colour(i), INTERVAL_LINE).add(series_mark(i)), name)
    };
    let legend = series.iter().enumerate().fold(Legend::of_lines(), entry);
    let (legend, bottom) =
        legend.with_letters(sheet.letters).draw(Point::new(MARGIN, top), sheet.width - 2.0 * MARGIN);
    Ok(document_on(sheet, bottom).add(drawn).add(legend).to_string())
}

fn values(row: &MeanRow) -> impl Iterator<Item = f64> {
    let of =
        |(mean, interval): (f64, Option<[f64; 2]>)| [mean].into_iter().chain(interval.into_iter().flatten());
    row.means.iter().copied().flatten().flat_map(of)
}

/// The marks of a row of `count` series centred at `middle` (px).
fn marks(row: &MeanRow, count: usize, axis: &Axis, middle: f64) -> Group {
    let mut marks = Group::new();
    for (series, (mean, interval)) in row.means.iter().enumerate().filter_map(|(s, m)| Some((s, (*m)?))) {
        let y = middle + SERIES_HEIGHT * (series as f64 - (count as f64 - 1.0) / 2.0);
        let at = |value: f64| Point::new(axis.at(value), y);
        if let Some(ends) = interval {
            let line = stroke(&ends.map(at), &colour(series), INTERVAL_LINE);
            marks = marks.add(line.set("class", "interval"));
        }
        marks = marks.add(place(series_mark(series), at(mean)));
    }
    marks
}

fn colour(series: usize) -> String {
    LineStyle::of(series).colour()
}

/// The mark of a series. The second four are open.
fn series_mark(series: usize) -> Group {
    mark(SHAPES[series % SHAPES.len()], (series / SHAPES.len()).is_multiple_of(2), &colour(series))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{NOTHING, error};
    use super::*;
    use crate::drawing::tests::checked;

    #[test]
    fn every_mean_has_a_mark_and_its_interval() {
        let row = |label: &str| MeanRow {
            label: label.to_owned(),
            means: vec![Some((1840.0, Some([1800.0, 1880.0]))), Some((1900.0, None)), None],
        };
        let panel =
            |title: &str| MeanPanel { title: title.to_owned(), rows: vec![row("eta 5"), row("eta 15")] };
        let series = ["mutual", "robot-led", "human-led"].map(str::to_owned);
        let svg = checked(|| {
            means(&[panel("Environment 1"), panel("Environment 4")], &series, "J (m)", Sheet::default())
        });
        assert_eq!(svg.matches("class=\"interval\"").count(), 4);
        // and three in the legend
        assert_eq!(svg.matches("class=\"mark\"").count(), 8 + 3);
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        assert_eq!(error(means(&[MeanPanel::default()], &[], "", Sheet::default())), NOTHING);
        let rows = vec![MeanRow { label: String::new(), means: vec![Some((f64::NAN, None))] }];
        let panel = MeanPanel { rows, ..MeanPanel::default() };
        assert!(
            error(means(&[panel], &[String::new()], "", Sheet::default())).ends_with(": NaN cannot be drawn")
        );
    }
}
