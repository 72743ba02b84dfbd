//! What episodes tell of participants' eta in; the figure of their bounds, estimates and the distribution of all, out.

use super::axis::Scale;
use super::scene::{document, rectangle};
use super::style::{INK, Look, SMALL, disc, path_data, px, stroke};
use super::text::{Align, Words, shorten};
use super::{DrawingError, WIDTH};
use crate::geometry::{Bounds, Point, Vector};
use crate::math;
use svg::node::element::{Group, Path};

/// A participant of the figure of tolerances.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ToleranceRow {
    /// Stands on the left; long ones are shortened.
    pub label: String,
    /// The eta that agree with each episode, as intervals; the upper end is infinite where nobody switched.
    pub bounds: Vec<Vec<[f64; 2]>>,
    /// eta; none without an upper bound.
    pub estimate: Option<f64>,
    /// Where eta lies; none if nothing is known.
    pub interval: Option<[f64; 2]>,
    /// Whether episodes contradict each other.
    pub is_scattered: bool,
}

/// Left and right end of the frame, px.
const FRAME: [f64; 2] = [150.0, WIDTH - 24.0];
/// Height of a row, px, and of one with its episodes one below the other.
const ROW: f64 = 26.0;
const EPISODE: f64 = 5.0;
/// Room for arrows beyond the largest number, as a ratio.
const BEYOND: f64 = 1.35;

/// A row for every participant: thin lines for the bounds of each episode (arrows where nobody switched), a thick one for where eta lies, a
/// disc at the estimate (open where episodes contradict each other); behind them the median of all and one standard deviation of ln(eta).
/// `no_interval` says why there is no interval of that median, if there is none.
///
/// # Errors
/// [`DrawingError::NoPanels`]; [`DrawingError::Fit`] for what cannot be on an axis in ratios.
pub fn tolerances(
    rows: &[ToleranceRow],
    overall: Option<(f64, f64)>,
    no_interval: Option<&str>,
) -> Result<String, DrawingError> {
    if rows.is_empty() {
        return Err(DrawingError::NoPanels);
    }
    let scale = scale(rows, overall)?;
    let heights = rows.iter().map(|row| ROW + EPISODE * row.bounds.len() as f64);
    let frame = Bounds {
        min: Point::new(FRAME[0], 14.0),
        max: Point::new(FRAME[1], 14.0 + heights.clone().sum::<f64>()),
    };
    let mut group = Group::new().set("class", "panel");
    if let Some((median, log_std)) = overall {
        let factor = math::exp(log_std);
        let [low, high] = [median / factor, median * factor].map(|eta| scale.at(eta));
        let band = Bounds { min: Point::new(low, frame.min.y), max: Point::new(high, frame.max.y) };
        let x = scale.at(median);
        let ends = [Point::new(x, frame.min.y), Point::new(x, frame.max.y)];
        group = group
            .add(rectangle(band).set("fill", "#e9e9e9"))
            .add(scale.grid_across(frame))
            .add(stroke(&ends, INK, 1.6).set("stroke-dasharray", "7 5"));
    } else {
        group = group.add(scale.grid_across(frame));
    }
    let mut top = frame.min.y;
    for (row, height) in rows.iter().zip(heights) {
        group = group.add(draw(row, &scale, top, height));
        top += height;
    }
    let title = Words::new().plain("tolerance ").italic("\u{3b7}");
    group = group
        .add(rectangle(frame).set("fill", "none").set("stroke", INK).set("stroke-width", 1.2))
        .add(scale.below(frame, title));
    let (legend, bottom) = legend(Point::new(20.0, frame.max.y + 80.0), rows, overall.is_some());
    let Some(reason) = no_interval else {
        return Ok(document(bottom).add(group).add(legend).to_string());
    };
    let words = Words::new().plain(reason);
    let size = SMALL * ((WIDTH - 40.0) / words.width(SMALL)).min(1.0);
    let note = words.at(Point::new(20.0, bottom + 12.0), size, Align::Left);
    Ok(document(bottom + 28.0).add(group).add(legend).add(note).to_string())
}

fn scale(rows: &[ToleranceRow], overall: Option<(f64, f64)>) -> Result<Scale, DrawingError> {
    let all = |row: &ToleranceRow| -> Vec<f64> {
        let bounds = row.bounds.iter().flatten().chain(&row.interval).flatten().copied();
        bounds.chain(row.estimate).collect()
    };
    for row in rows {
        if let Some(value) = all(row).into_iter().find(|v| v.is_nan() || *v < 0.0) {
            return Err(DrawingError::Fit { what: format!("participant `{}`", row.label), value });
        }
    }
    let around = overall.into_iter().flat_map(|(m, s)| [m / math::exp(s), m * math::exp(s)]);
    let values = rows.iter().flat_map(all).chain(around);
    let values: Vec<f64> = values.filter(|v| *v > 1e-6 && *v < 1e9).collect();
    let low = values.iter().copied().fold(10.0, f64::min);
    let high = values.iter().copied().fold(low * 2.0, f64::max);
    // a lower bound of 0 lies at the left end
    Ok(Scale { range: [low / BEYOND, high * BEYOND], ends: FRAME, is_log: true })
}

fn draw(row: &ToleranceRow, scale: &Scale, top: f64, height: f64) -> Group {
    let middle = top + ROW / 2.0;
    let label = Words::new().plain(shorten(&row.label, 16));
    let size = SMALL * ((FRAME[0] - 30.0) / label.width(SMALL)).min(1.0);
    let at = Point::new(FRAME[0] - 10.0, top + height / 2.0 + 0.35 * size);
    let ends = [Point::new(FRAME[0], top + height), Point::new(FRAME[1], top + height)];
    let mut group = Group::new().set("class", "row").add(label.at(at, size, Align::Right));
    group = group.add(stroke(&ends, "#c8c8c8", 0.8));
    for (i, bounds) in row.bounds.iter().enumerate() {
        let y = top + ROW - 1.0 + EPISODE * i as f64;
        let episode = Group::new().set("class", "episode");
        let spans = bounds.iter().map(|piece| span(*piece, scale, y, 1.6, "#6f6f6f"));
        group = group.add(spans.fold(episode, Group::add));
    }
    if let Some(interval) = row.interval {
        let colour = Look::of(0).colour;
        group = group.add(span(interval, scale, middle, 5.0, colour).set("class", "interval"));
    }
    if let Some(estimate) = row.estimate {
        group = group.add(estimate_mark(Point::new(scale.at(estimate), middle), row.is_scattered));
    }
    group
}

/// A line between two numbers, with an arrow's head if it does not end.
fn span([low, high]: [f64; 2], scale: &Scale, y: f64, width: f64, colour: &str) -> Group {
    let from = scale.at(low);
    let is_open = high.is_infinite();
    // the shortest still shows
    let to = if is_open { FRAME[1] - 8.0 } else { scale.at(high).max(from + 4.0) };
    let line = stroke(&[Point::new(from, y), Point::new(to, y)], colour, width);
    let group = Group::new().add(line);
    if !is_open {
        return group;
    }
    let half = width / 2.0 + 2.5;
    let head = [Point::new(to, y - half), Point::new(to + 7.0, y), Point::new(to, y + half)];
    group.add(Path::new().set("d", path_data(&head) + "Z").set("fill", colour))
}

fn estimate_mark(at: Point, is_open: bool) -> Group {
    let colour = Look::of(0).colour;
    let shape = disc(at, 6.0).set("stroke", colour).set("stroke-width", px(2.0));
    Group::new().set("class", "estimate").add(shape.set("fill", if is_open { "#ffffff" } else { colour }))
}

/// What the marks mean, and the y at which that ends.
fn legend(at: Point, rows: &[ToleranceRow], has_overall: bool) -> (Group, f64) {
    const LINE: f64 = 27.0;
    const SAMPLE: f64 = 44.0;
    let mut group = Group::new().set("class", "legend");
    let mut at = at;
    let mut put = |sample: &dyn Fn(Point) -> Group, words: &str| {
        let words = Words::new().plain(words);
        if at.x + SAMPLE + words.width(SMALL) > FRAME[1] {
            at = Point::new(20.0, at.y + LINE);
        }
        let text = words.at(at + Vector::new(SAMPLE, 0.0), SMALL, Align::Left);
        let sample = sample(at + Vector::new(0.0, -0.35 * SMALL));
        group = std::mem::take(&mut group).add(sample).add(text);
        at.x += SAMPLE + words.width(SMALL) + 16.0;
    };
    let right = Vector::new(36.0, 0.0);
    let line =
        |at: Point, width: f64, colour: &str| Group::new().add(stroke(&[at, at + right], colour, width));
    put(&|at| line(at, 5.0, Look::of(0).colour).add(estimate_mark(at + right / 2.0, false)), "participant");
    if rows.iter().any(|row| row.is_scattered) {
        let colour = Look::of(0).colour;
        put(&|at| line(at, 5.0, colour).add(estimate_mark(at + right / 2.0, true)), "episodes contradict");
    }
    put(&|at| line(at, 1.6, "#6f6f6f"), "episode");
    if has_overall {
        let half = Vector::new(18.0, 10.0);
        put(
            &|at| {
                let middle = at + right / 2.0;
                let band = Bounds { min: middle - half, max: middle + half };
                let upright = [middle - Vector::new(0.0, 10.0), middle + Vector::new(0.0, 10.0)];
                Group::new()
                    .add(rectangle(band).set("fill", "#e9e9e9"))
                    .add(stroke(&upright, INK, 1.6).set("stroke-dasharray", "7 5"))
            },
            "all: median, one standard deviation",
        );
    }
    (group, at.y + 16.0)
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let picture = tolerances(&rows(), Some((6.0, 0.4)), None).unwrap();
        assert_eq!(picture, tolerances(&rows(), Some((6.0, 0.4)), None).unwrap());
        crate::drawing::tests::check_well_formed(&picture);
        assert!(!picture.contains("NaN") && !picture.contains("inf"));
        assert_eq!(picture.matches("class=\"episode\"").count(), 4);
        assert_eq!(picture.matches("class=\"interval\"").count(), 3);
        assert_eq!(picture.matches("class=\"estimate\"").count(), 2 + 1);
        assert!(picture.contains("&lt;p&gt;"));
        let without = tolerances(&rows()[3..], None, Some("1 < 2")).unwrap();
        crate::drawing::tests::check_well_formed(&without);
        assert!(without.contains("1 &lt; 2"));
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        assert!(matches!(tolerances(&[], None, None), Err(DrawingError::NoPanels)));
        let mut spoiled = rows();
        spoiled[0].estimate = Some(f64::NAN);
        assert!(matches!(tolerances(&spoiled, None, None), Err(DrawingError::Fit { .. })));
    }
}
