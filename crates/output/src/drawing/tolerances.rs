//! The figure of participants' eta: bounds, intervals and estimates in one row per participant, and the
//! distribution of all.

use super::kit::{
    AXIS_ROOM, Axis, BAND, FAINT, GRID, Legend, Letters, LineStyle, MARGIN, SAMPLE, Shape, Side, Text,
    border, document, guide, left_of_rows, level, level_sample, mark, notes, place, polygon, rectangle,
    row_label, stroke, upright,
};
use super::{WIDTH, not_drawable, nothing};
use cocarry::Error;
use cocarry::geometry::{Bounds, Point, Vector};
use cocarry::math;
use svg::node::element::Group;

/// A participant in the figure of tolerances.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ToleranceRow {
    /// Label at the left; long ones are shortened.
    pub label: String,
    /// The eta that agree with each episode, as intervals. The upper end is infinite where the participant
    /// did not switch.
    pub bounds: Vec<Vec<[f64; 2]>>,
    /// Estimated eta; none without an upper bound.
    pub estimate: Option<f64>,
    /// Interval of eta; none if nothing is known.
    pub interval: Option<[f64; 2]>,
    /// Whether the episodes contradict each other.
    pub is_scattered: bool,
}

/// Largest width of row labels, px.
const LABELS_WIDTH: f64 = 130.0;
/// Height of a row and of one of its episodes, px.
const ROW_HEIGHT: f64 = 26.0;
const EPISODE_HEIGHT: f64 = 5.0;
/// Line widths of an interval and of an episode, px.
const INTERVAL_LINE: f64 = 5.0;
const EPISODE_LINE: f64 = 1.8;
/// Room for arrows beyond the largest value, as a ratio.
const BEYOND: f64 = 1.35;

/// A row for every participant, with thin lines for the bounds of each episode (arrows where the participant
/// did not switch), a thick line for the interval of eta, and a disc at the estimate (open where episodes
/// contradict each other). Behind them are the median of all participants and one standard deviation of
/// ln(eta). `no_interval` gives the reason if that median has no interval.
///
/// # Errors
/// There is no row, or a value cannot be on a logarithmic axis.
pub fn tolerances(
    rows: &[ToleranceRow],
    overall: Option<(f64, f64)>,
    no_interval: Option<&str>,
) -> Result<String, Error> {
    if rows.is_empty() {
        return Err(nothing());
    }
    let height = |row: &ToleranceRow| ROW_HEIGHT + EPISODE_HEIGHT * row.bounds.len() as f64;
    let min = Point::new(left_of_rows(rows.iter().map(|r| r.label.as_str()), LABELS_WIDTH), MARGIN);
    let max = Point::new(WIDTH - MARGIN, min.y + rows.iter().map(height).sum::<f64>());
    let frame = Bounds { min, max };
    let axis = axis(rows, overall, frame)?;
    let mut group = Group::new().set("class", "panel");
    if let Some((median, log_std)) = overall {
        let factor = math::exp(log_std);
        let [low, high] = [median / factor, median * factor].map(|eta| axis.at(eta));
        let band = Bounds { min: Point::new(low, frame.min.y), max: Point::new(high, frame.max.y) };
        group = group.add(rectangle(band).set("fill", BAND)).add(axis.grid(frame));
        group = group.add(guide(upright(axis.at(median), frame)));
    } else {
        group = group.add(axis.grid(frame));
    }
    let mut top = frame.min.y;
    for row in rows {
        let bottom = top + height(row);
        group = group.add(row_label(Letters::Text, &row.label, frame.min.x, (top + bottom) / 2.0));
        group = group.add(stroke(&level(bottom, frame), GRID, 1.0)).add(draw(row, &axis, top, frame));
        top = bottom;
    }
    group = group.add(border(frame)).add(axis.draw(frame, &Text::new("tolerance ").italic("\u{3b7}")));
    let legend = legend(rows, overall.is_some());
    let (legend, bottom) = legend.draw(Point::new(MARGIN, frame.max.y + AXIS_ROOM), WIDTH - 2.0 * MARGIN);
    let (reason, bottom) = notes(no_interval, bottom);
    Ok(document(bottom).add(group).add(legend).add(reason).to_string())
}

fn axis(rows: &[ToleranceRow], overall: Option<(f64, f64)>, frame: Bounds) -> Result<Axis, Error> {
    let all = |row: &ToleranceRow| -> Vec<f64> {
        let bounds = row.bounds.iter().flatten().chain(&row.interval).flatten().copied();
        bounds.chain(row.estimate).collect()
    };
    for row in rows {
        if let Some(value) = all(row).into_iter().find(|v| v.is_nan() || *v < 0.0) {
            return Err(not_drawable(format_args!("participant `{}`", row.label), value));
        }
    }
    let around = overall.into_iter().flat_map(|(m, s)| [m / math::exp(s), m * math::exp(s)]);
    let values = rows.iter().flat_map(all).chain(around);
    let values: Vec<f64> = values.filter(|v| *v > 1e-6 && *v < 1e9).collect();
    let low = values.iter().copied().fold(10.0, f64::min);
    let high = values.iter().copied().fold(low * 2.0, f64::max);
    // a lower bound of 0 is drawn at the left end
    Ok(Axis::log(Side::Below, [low / BEYOND, high * BEYOND], frame))
}

/// The lines and the mark of a row.
fn draw(row: &ToleranceRow, axis: &Axis, top: f64, frame: Bounds) -> Group {
    let middle = top + ROW_HEIGHT / 2.0;
    let mut group = Group::new().set("class", "row");
    for (i, bounds) in row.bounds.iter().enumerate() {
        let y = top + ROW_HEIGHT - 1.0 + EPISODE_HEIGHT * i as f64;
        let episode = Group::new().set("class", "episode");
        let spans = bounds.iter().map(|piece| span(*piece, axis, y, EPISODE_LINE, FAINT, frame));
        group = group.add(spans.fold(episode, Group::add));
    }
    if let Some(interval) = row.interval {
        let colour = LineStyle::of(0).colour();
        group =
            group.add(span(interval, axis, middle, INTERVAL_LINE, &colour, frame).set("class", "interval"));
    }
    if let Some(estimate) = row.estimate {
        group = group.add(place(estimate_mark(row.is_scattered), Point::new(axis.at(estimate), middle)));
    }
    group
}

/// A line between two values, with an arrowhead if it has no upper end.
fn span([low, high]: [f64; 2], axis: &Axis, y: f64, width: f64, colour: &str, frame: Bounds) -> Group {
    let from = axis.at(low);
    let is_open = high.is_infinite();
    // even the shortest line remains visible
    let to = if is_open { frame.max.x - 8.0 } else { axis.at(high).max(from + 4.0) };
    let group = Group::new().add(stroke(&[Point::new(from, y), Point::new(to, y)], colour, width));
    if !is_open {
        return group;
    }
    let half = width / 2.0 + 2.5;
    let head = [Point::new(to, y - half), Point::new(to + 7.0, y), Point::new(to, y + half)];
    group.add(polygon(&head).set("fill", colour))
}

/// The mark of an estimate: a disc, open where episodes contradict each other.
fn estimate_mark(is_scattered: bool) -> Group {
    mark(Shape::Disc, !is_scattered, &LineStyle::of(0).colour()).set("class", "estimate")
}

fn legend(rows: &[ToleranceRow], has_overall: bool) -> Legend {
    let participant = |is_scattered| {
        level_sample(&LineStyle::of(0).colour(), INTERVAL_LINE).add(estimate_mark(is_scattered))
    };
    let mut legend = Legend::of_lines().entry(participant(false), "participant");
    if rows.iter().any(|row| row.is_scattered) {
        legend = legend.entry(participant(true), "episodes contradict");
    }
    legend = legend.entry(level_sample(FAINT, EPISODE_LINE), "episode");
    if has_overall {
        let corner = Vector::new(SAMPLE / 2.0, 8.0);
        let band = Bounds { min: Point::from(-corner), max: Point::from(corner) };
        let sample = Group::new().add(rectangle(band).set("fill", BAND)).add(guide(upright(0.0, band)));
        legend = legend.entry(sample, "all: median \u{b1} std of ln \u{3b7}");
    }
    legend
}

#[cfg(test)]
mod tests {
    use super::super::tests::{NOTHING, error};
    use super::*;
    use crate::drawing::tests::checked;

    fn rows() -> Vec<ToleranceRow> {
        let row = |label: &str, bounds: &[[f64; 2]], estimate, interval| ToleranceRow {
            label: label.to_owned(),
            bounds: bounds.iter().map(|piece| vec![*piece]).collect(),
            estimate,
            interval,
            is_scattered: false,
        };
        vec![
            row("<p>", &[[4.0, 5.0], [4.5, f64::INFINITY]], Some(4.75), Some([4.5, 5.0])),
            row("never", &[[20.0, f64::INFINITY]], None, Some([20.0, f64::INFINITY])),
            row("at once", &[[0.0, 0.5]], Some(0.25), Some([0.0, 0.5])),
            row("nothing", &[], None, None),
        ]
    }

    #[test]
    fn the_figure_is_well_formed_and_shows_every_episode() {
        let picture = checked(|| tolerances(&rows(), Some((6.0, 0.4)), None));
        assert_eq!(picture.matches("class=\"episode\"").count(), 4);
        assert_eq!(picture.matches("class=\"interval\"").count(), 3);
        assert_eq!(picture.matches("class=\"estimate\"").count(), 2 + 1);
        assert!(picture.contains("&lt;p&gt;"));
        let without = checked(|| tolerances(&rows()[3..], None, Some("1 < 2")));
        assert!(without.contains("1 &lt; 2"));
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        assert_eq!(error(tolerances(&[], None, None)), NOTHING);
        let mut spoiled = rows();
        spoiled[0].estimate = Some(f64::NAN);
        assert!(error(tolerances(&spoiled, None, None)).ends_with(": NaN cannot be drawn"));
    }
}
