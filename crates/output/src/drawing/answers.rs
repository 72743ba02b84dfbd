//! Participants' answers in percent with the fitted model, and the error of the fit over c_r.

use super::kit::{
    AXIS_ROOM, Axis, FAINT, GAP, GRID, INK, Legend, Letters, LineStyle, MARGIN, Plot, Shape, Side,
    TITLE_ROOM, Text, border, document, frame_title, left_of_rows, level, mark, mean_bar, notes, place,
    rectangle, row_label, stroke, upright,
};
use super::{WIDTH, not_drawable, nothing};
use cocarry::Error;
use cocarry::geometry::{Bounds, Point, Vector};
use svg::node::element::Group;

/// A world in the figure of answers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AnswerPanel {
    /// Title above the panel; long ones are shortened.
    pub title: String,
    /// Its options, top to bottom.
    pub rows: Vec<AnswerRow>,
}

/// The answers and fits of an option, percent.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AnswerRow {
    /// The option's name; long ones are shortened.
    pub option: String,
    /// The participants' answers.
    pub answers: Vec<f64>,
    /// Mean answer.
    pub mean: f64,
    /// Fits by likelihood and by least squares.
    pub fits: [f64; 2],
}

/// A fitted c_r, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RiskWeightMark {
    /// Its entry in the legend.
    pub name: &'static str,
    /// Its value.
    pub at: f64,
    /// Its 95 % interval, if there is one.
    pub interval: Option<[f64; 2]>,
}

/// Largest width of option names, px.
const NAMES_WIDTH: f64 = 110.0;
/// Height of a row and of the mean's mark, px.
const ROW_HEIGHT: f64 = 30.0;
const MEAN_HEIGHT: f64 = 22.0;
/// Height of the error chart, px.
const CHART_HEIGHT: f64 = 200.0;

/// Answers and fits, one panel per world. Below, the rms error over c_r with the two fitted values, by
/// likelihood and by least squares, and the sentences of `caution`.
///
/// # Errors
/// There is no panel, a percentage is not valid, or a c_r cannot be on the axis.
pub fn answers(
    panels: &[AnswerPanel],
    curve: &[(f64, f64)],
    marks: &[RiskWeightMark; 2],
    caution: &str,
) -> Result<String, Error> {
    check(panels, curve, marks)?;
    let rows = || panels.iter().flat_map(|p| &p.rows);
    let left = left_of_rows(rows().map(|r| r.option.as_str()), NAMES_WIDTH);
    let frame = |top: f64, height: f64| Bounds {
        min: Point::new(left, top),
        max: Point::new(WIDTH - MARGIN, top + height),
    };
    let mut drawn = Group::new();
    let mut top = 0.0;
    for (i, panel) in panels.iter().enumerate() {
        let frame = frame(top + TITLE_ROOM, panel.rows.len() as f64 * ROW_HEIGHT);
        let percent = Axis::linear(Side::Below, [0.0, 100.0], frame.grown(-GAP));
        drawn = drawn.add(draw(panel, &percent, frame));
        top = frame.max.y;
        if i + 1 == panels.len() {
            drawn = drawn.add(percent.draw(frame, &Text::new("share of answers (%)")));
            top += AXIS_ROOM;
        }
    }
    let has_several = rows().any(|r| r.answers.len() > 1);
    let mut legend = Legend::of_marks();
    if has_several {
        legend = legend.entry(answer_mark(), "answers");
    }
    legend = legend.entry(mean_bar(MEAN_HEIGHT), if has_several { "their mean" } else { "answer" });
    legend =
        marks.iter().enumerate().fold(legend, |legend, (fit, mark)| legend.entry(fit_mark(fit), mark.name));
    let (legend, bottom) = legend.draw(Point::new(MARGIN, top), WIDTH - 2.0 * MARGIN);
    let frame = frame(bottom + GAP, CHART_HEIGHT);
    let (caution, bottom) = notes(caution.split_inclusive(". "), frame.max.y + AXIS_ROOM);
    let picture = document(bottom).add(drawn).add(legend).add(errors(curve, marks, frame));
    Ok(picture.add(caution.set("class", "caution")).to_string())
}

fn check(panels: &[AnswerPanel], curve: &[(f64, f64)], marks: &[RiskWeightMark; 2]) -> Result<(), Error> {
    if panels.is_empty() || curve.len() < 2 {
        return Err(nothing());
    }
    for row in panels.iter().flat_map(|p| &p.rows) {
        let values = row.answers.iter().chain(&row.fits).chain([&row.mean]);
        if let Some(value) = values.copied().find(|v| !(-1e-9..=100.0 + 1e-9).contains(v)) {
            return Err(not_drawable(format_args!("option `{}`", row.option), value));
        }
    }
    let numbers = curve.iter().map(|c| c.0).chain(marks.iter().map(|m| m.at));
    match numbers.into_iter().find(|c| !(*c > 0.0 && c.is_finite())) {
        Some(value) => Err(not_drawable("c_r", value)),
        None => Ok(()),
    }
}

fn draw(panel: &AnswerPanel, percent: &Axis, frame: Bounds) -> Group {
    let mut group = Group::new().set("class", "panel");
    group = group.add(frame_title(&panel.title, MARGIN, frame)).add(percent.grid(frame));
    for (i, row) in panel.rows.iter().enumerate() {
        let y = frame.min.y + (i as f64 + 0.5) * ROW_HEIGHT;
        let at = |value: f64| Point::new(percent.at(value), y);
        group = group.add(row_label(Letters::Text, &row.option, frame.min.x, y));
        if i > 0 {
            group = group.add(stroke(&level(y - 0.5 * ROW_HEIGHT, frame), GRID, 1.0));
        }
        if row.answers.len() > 1 {
            for (n, answer) in row.answers.iter().enumerate() {
                // on five lines, so that equal answers remain distinguishable
                let lane = (n * 2 % 5) as f64 - 2.0;
                group = group.add(place(answer_mark(), at(*answer) + Vector::new(0.0, 4.2 * lane)));
            }
        }
        group = group.add(place(mean_bar(MEAN_HEIGHT), at(row.mean)));
        for (fit, value) in row.fits.iter().enumerate() {
            group = group.add(place(fit_mark(fit), at(*value)));
        }
    }
    group.add(border(frame))
}

/// A participant's answer: a small grey disc.
fn answer_mark() -> Group {
    mark(Shape::Dot, true, FAINT).set("class", "answer")
}

/// A fit: a full disc or an open diamond.
fn fit_mark(fit: usize) -> Group {
    let shape = [Shape::Disc, Shape::Diamond][fit];
    mark(shape, fit == 0, &LineStyle::of(fit).colour()).set("class", "fit")
}

/// The curve without the plateaus at its ends.
fn without_plateaus(curve: &[(f64, f64)]) -> &[(f64, f64)] {
    const PLATEAU_TOLERANCE: f64 = 0.05;
    let [first, last] = [curve[0].1, curve[curve.len() - 1].1];
    let begin = curve.iter().position(|c| (c.1 - first).abs() > PLATEAU_TOLERANCE).unwrap_or(0);
    let end = curve.iter().rposition(|c| (c.1 - last).abs() > PLATEAU_TOLERANCE).unwrap_or(curve.len() - 1);
    let [begin, end] = [begin.saturating_sub(20), (end + 21).min(curve.len())];
    if begin + 1 < end { &curve[begin..end] } else { curve }
}

/// The rms error over c_r, without the plateaus at its ends.
fn errors(curve: &[(f64, f64)], marks: &[RiskWeightMark; 2], frame: Bounds) -> Group {
    let curve = without_plateaus(curve);
    let top = curve.iter().map(|c| c.1).fold(1.0, f64::max) * 1.06;
    let x = Axis::log(Side::Below, [curve[0].0, curve[curve.len() - 1].0], frame);
    let plot = Plot { frame, x, y: Axis::linear(Side::Left, [0.0, top], frame) };
    let line: Vec<Point> = curve.iter().map(|(c, rms)| plot.at(*c, *rms)).collect();
    let mut group = Group::new().set("class", "chart").add(plot.x.grid(frame)).add(plot.y.grid(frame));
    for (fit, mark) in marks.iter().enumerate() {
        if let Some([low, high]) = mark.interval {
            // one band in the upper half, the other in the lower
            let middle = (frame.min.y + frame.max.y) / 2.0;
            let [from, to] = [[frame.min.y, middle], [middle, frame.max.y]][fit];
            let band = Bounds { min: Point::new(x.at(low), from), max: Point::new(x.at(high), to) };
            let colour = LineStyle::of(fit).colour();
            group = group.add(rectangle(band).set("fill", colour).set("fill-opacity", 0.22));
        }
    }
    group = group.add(stroke(&line, INK, 2.2));
    for (fit, mark) in marks.iter().enumerate() {
        let at = Point::new(x.at(mark.at), frame.min.y + (1.5 + 2.2 * fit as f64) * GAP);
        group = group.add(LineStyle::of(fit).draw(&upright(at.x, frame), 2.0)).add(place(fit_mark(fit), at));
    }
    let title = Text::new("risk weight ").italic("c").sub("r").plain(" (m)");
    group.add(plot.axes(&title, &Text::new("rms error (%)")))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{NOTHING, error};
    use super::*;
    use crate::drawing::tests::checked;

    fn panels() -> Vec<AnswerPanel> {
        let row = |option: &str, answers: &[f64]| AnswerRow {
            option: option.to_owned(),
            answers: answers.to_vec(),
            mean: 40.0,
            fits: [35.0, 30.0],
        };
        let rows = vec![row("<1>", &[20.0, 60.0]), row("2", &[80.0, 40.0])];
        vec![AnswerPanel { title: "a & b".to_owned(), rows }]
    }

    #[test]
    fn the_figure_is_well_formed_and_shows_every_answer() {
        let curve = [(0.1, 30.0), (10.0, 5.0), (1000.0, 20.0)];
        let marks = [8.0, 9.0].map(|at| RiskWeightMark { name: "fit", at, interval: Some([7.0, 11.0]) });
        let picture = checked(|| answers(&panels(), &curve, &marks, "One <. Two"));
        let (legend, chart) = (1, 2);
        assert_eq!(picture.matches("class=\"answer\"").count(), 4 + legend);
        assert_eq!(picture.matches("class=\"mean\"").count(), 2 + legend);
        assert_eq!(picture.matches("class=\"fit\"").count(), 4 + 2 * legend + chart);
        assert!(picture.contains("One &lt;.") && picture.contains("Two"));
        assert!(picture.contains("a &amp; b") && picture.contains("&lt;1&gt;"));
    }

    #[test]
    fn plateaus_are_left_out() {
        let height = |i: i32| if (100..200).contains(&i) { 3.0 } else { 30.0 };
        let curve: Vec<(f64, f64)> = (0..400).map(|i| (f64::from(i), height(i))).collect();
        let shown = without_plateaus(&curve);
        assert_eq!((shown[0].0, shown[shown.len() - 1].0), (80.0, 219.0));
        assert_eq!(without_plateaus(&curve[..50]).len(), 50);
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        let marks = [RiskWeightMark { name: "fit", at: 8.0, interval: None }; 2];
        let curve = [(0.1, 30.0), (10.0, 5.0)];
        assert_eq!(error(answers(&[], &curve, &marks, "")), NOTHING);
        let mut spoiled = panels();
        spoiled[0].rows[1].mean = f64::NAN;
        assert!(error(answers(&spoiled, &curve, &marks, "")).ends_with(": NaN cannot be drawn"));
    }
}
