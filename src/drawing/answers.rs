//! Participants' percentages and what was fitted to them in; the figure of both, and of the error for every c_r, out.

use super::axis::Scale;
use super::scene::{document, rectangle};
use super::style::{INK, LARGE, Look, SMALL, disc, path_data, stroke};
use super::text::{Align, Words, shorten};
use super::{DrawingError, WIDTH};
use crate::geometry::{Bounds, Point, Vector};
use svg::node::element::{Group, Path};

/// A world of the figure of answers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AnswerPanel {
    /// Stands above; long ones are shortened.
    pub title: String,
    /// Its options, from the top.
    pub rows: Vec<AnswerRow>,
}

/// An option, as answered and as fitted, percent.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AnswerRow {
    /// The option's name; long ones are shortened.
    pub option: String,
    /// What each participant said.
    pub answers: Vec<f64>,
    /// Their mean.
    pub mean: f64,
    /// By likelihood and by least squares.
    pub fits: [f64; 2],
}

/// A fitted c_r, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RiskWeightMark {
    /// Where it is.
    pub at: f64,
    /// Its 95 % interval; none without.
    pub interval: Option<[f64; 2]>,
}

/// Left and right end of the frames, px.
const FRAME: [f64; 2] = [104.0, WIDTH - 22.0];
/// Height of a row, px.
const ROW: f64 = 30.0;
/// Room above a panel for its title, px.
const ABOVE: f64 = 32.0;
/// Height of a line of the caution, px.
const NOTE: f64 = 22.0;
/// Height of the chart of errors, px.
const CHART: f64 = 200.0;
/// What the marks of either fit mean.
const FITS: [&str; 2] = ["likelihood (recommended)", "least squares"];

/// Answers and fits, a panel for every world; below, the rms error for every c_r with the two that were fitted, by likelihood and by least
/// squares, and `caution`, sentence by sentence.
///
/// # Errors
/// [`DrawingError::NoPanels`]; [`DrawingError::Fit`] for what is no percentage or cannot be on the axis of c_r.
pub fn answers(
    panels: &[AnswerPanel],
    curve: &[(f64, f64)],
    marks: &[RiskWeightMark; 2],
    caution: &str,
) -> Result<String, DrawingError> {
    check(panels, curve, marks)?;
    let percent = Scale { range: [0.0, 100.0], ends: [FRAME[0] + 8.0, FRAME[1] - 8.0], is_log: false };
    let mut drawn = Vec::new();
    let mut top = 4.0;
    for (i, panel) in panels.iter().enumerate() {
        let min = Point::new(FRAME[0], top + ABOVE);
        let frame = Bounds { min, max: Point::new(FRAME[1], min.y + panel.rows.len() as f64 * ROW) };
        let mut group = draw(panel, &percent, frame);
        if i + 1 == panels.len() {
            group = group.add(percent.below(frame, Words::new().plain("share of answers (%)")));
        }
        drawn.push(group);
        top = frame.max.y + 6.0;
    }
    let (legend, bottom) = legend(Point::new(FRAME[0] - 84.0, top + 76.0), panels);
    let min = Point::new(FRAME[0], bottom + 16.0);
    let frame = Bounds { min, max: Point::new(FRAME[1], min.y + CHART) };
    let sentences: Vec<&str> = caution.split_inclusive(". ").collect();
    let below = frame.max.y + 74.0;
    let picture = document(below + NOTE * sentences.len() as f64 - 16.0);
    let picture = drawn.into_iter().fold(picture, svg::Document::add);
    let mut notes = Group::new().set("class", "caution");
    for (i, sentence) in sentences.into_iter().enumerate() {
        let words = Words::new().plain(sentence.trim());
        let size = (0.85 * SMALL).min(SMALL * (WIDTH - 40.0) / words.width(SMALL));
        notes = notes.add(words.at(Point::new(20.0, below + NOTE * i as f64), size, Align::Left));
    }
    Ok(picture.add(legend).add(errors(curve, marks, frame)).add(notes).to_string())
}

fn check(
    panels: &[AnswerPanel],
    curve: &[(f64, f64)],
    marks: &[RiskWeightMark; 2],
) -> Result<(), DrawingError> {
    if panels.is_empty() || curve.len() < 2 {
        return Err(DrawingError::NoPanels);
    }
    for row in panels.iter().flat_map(|p| &p.rows) {
        let values = row.answers.iter().chain(&row.fits).chain([&row.mean]);
        if let Some(value) = values.copied().find(|v| !(-1e-9..=100.0 + 1e-9).contains(v)) {
            return Err(DrawingError::Fit { what: format!("option `{}`", row.option), value });
        }
    }
    let numbers = curve.iter().map(|c| c.0).chain(marks.iter().map(|m| m.at));
    match numbers.into_iter().find(|c| !(*c > 0.0 && c.is_finite())) {
        Some(value) => Err(DrawingError::Fit { what: "c_r".to_owned(), value }),
        None => Ok(()),
    }
}

fn draw(panel: &AnswerPanel, percent: &Scale, frame: Bounds) -> Group {
    let title = Words::new().plain(shorten(&panel.title, 60));
    let title = title.at(Point::new(20.0, frame.min.y - 9.0), LARGE, Align::Left);
    let mut group =
        Group::new().set("class", "panel").add(Group::new().set("font-weight", "bold").add(title));
    group = group.add(percent.grid_across(frame));
    for (i, row) in panel.rows.iter().enumerate() {
        let y = frame.min.y + (i as f64 + 0.5) * ROW;
        let at = |value: f64| Point::new(percent.at(value), y);
        let words = Words::new().plain(shorten(&row.option, 12));
        let size = SMALL * (78.0 / words.width(SMALL)).min(1.0);
        group = group.add(words.at(Point::new(frame.min.x - 10.0, y + 0.35 * size), size, Align::Right));
        if i > 0 {
            let y = frame.min.y + i as f64 * ROW;
            let ends = [Point::new(frame.min.x, y), Point::new(frame.max.x, y)];
            group = group.add(stroke(&ends, "#d9d9d9", 1.0));
        }
        if row.answers.len() > 1 {
            for (n, answer) in row.answers.iter().enumerate() {
                // on five lines, so that equal answers are told apart
                let lane = (n * 2 % 5) as f64 - 2.0;
                group = group.add(answer_mark(at(*answer) + Vector::new(0.0, 4.2 * lane)));
            }
        }
        group = group.add(mean_mark(at(row.mean)));
        for (fit, value) in row.fits.iter().enumerate() {
            group = group.add(fit_mark(fit, at(*value)));
        }
    }
    group.add(rectangle(frame).set("fill", "none").set("stroke", INK).set("stroke-width", 1.2))
}

/// A participant's answer: a small grey disc.
fn answer_mark(at: Point) -> Group {
    Group::new().set("class", "answer").add(disc(at, 2.6).set("fill", "#9a9a9a"))
}

/// The mean: a thick upright bar.
fn mean_mark(at: Point) -> Group {
    let half = Vector::new(0.0, 11.0);
    Group::new().set("class", "mean").add(stroke(&[at - half, at + half], "#ffffff", 7.0)).add(stroke(
        &[at - half, at + half],
        INK,
        4.2,
    ))
}

/// A fit: full circle, or open diamond.
fn fit_mark(fit: usize, at: Point) -> Group {
    let colour = Look::of(fit).colour;
    let group = Group::new().set("class", "fit").set("stroke", colour).set("stroke-width", 1.8);
    match fit {
        0 => group.add(disc(at, 5.2).set("fill", colour)),
        _ => {
            let corners = [[0.0, -8.5], [8.5, 0.0], [0.0, 8.5], [-8.5, 0.0]];
            let corners = corners.map(|[x, y]| at + Vector::new(x, y));
            group.add(Path::new().set("d", path_data(&corners) + "Z").set("fill", "none"))
        }
    }
}

/// What the marks mean, and the y at which that ends.
fn legend(at: Point, panels: &[AnswerPanel]) -> (Group, f64) {
    const SAMPLE: f64 = 24.0;
    let mut group = Group::new().set("class", "legend");
    let mut x = at.x;
    let mut put = |sample: &dyn Fn(Point) -> Group, words: &str| {
        let words = Words::new().plain(words);
        let text = words.at(Point::new(x + SAMPLE, at.y), SMALL, Align::Left);
        let sample = sample(Point::new(x + 0.45 * SAMPLE, at.y - 0.35 * SMALL));
        group = std::mem::take(&mut group).add(sample).add(text);
        x += SAMPLE + words.width(SMALL) + 12.0;
    };
    let has_several = panels.iter().flat_map(|p| &p.rows).any(|r| r.answers.len() > 1);
    if has_several {
        put(&answer_mark, "answers");
    }
    put(&mean_mark, if has_several { "their mean" } else { "answer" });
    for (fit, name) in FITS.iter().enumerate() {
        put(&|at| fit_mark(fit, at), name);
    }
    (group, at.y + 10.0)
}

/// The curve without the plains at its ends.
fn without_plains(curve: &[(f64, f64)]) -> &[(f64, f64)] {
    const LEVEL: f64 = 0.05;
    let [first, last] = [curve[0].1, curve[curve.len() - 1].1];
    let begin = curve.iter().position(|c| (c.1 - first).abs() > LEVEL).unwrap_or(0);
    let end = curve.iter().rposition(|c| (c.1 - last).abs() > LEVEL).unwrap_or(curve.len() - 1);
    let [begin, end] = [begin.saturating_sub(20), (end + 21).min(curve.len())];
    if begin + 1 < end { &curve[begin..end] } else { curve }
}

/// The rms error for every c_r; what lies on the plains at its ends is left out.
fn errors(curve: &[(f64, f64)], marks: &[RiskWeightMark; 2], frame: Bounds) -> Group {
    let curve = without_plains(curve);
    let top = curve.iter().map(|c| c.1).fold(1.0, f64::max) * 1.06;
    let [first, last] = [curve[0].0, curve[curve.len() - 1].0];
    let x = Scale { range: [first, last], ends: [frame.min.x, frame.max.x], is_log: true };
    let y = Scale { range: [0.0, top], ends: [frame.max.y, frame.min.y], is_log: false };
    let line: Vec<Point> = curve.iter().map(|(c, rms)| Point::new(x.at(*c), y.at(*rms))).collect();
    let mut group = Group::new().set("class", "chart").add(x.grid_across(frame));
    for (fit, mark) in marks.iter().enumerate() {
        if let Some([low, high]) = mark.interval {
            // one band in the upper half, the other in the lower
            let middle = (frame.min.y + frame.max.y) / 2.0;
            let [from, to] = [[frame.min.y, middle], [middle, frame.max.y]][fit];
            let band = Bounds { min: Point::new(x.at(low), from), max: Point::new(x.at(high), to) };
            let colour = Look::of(fit).colour;
            group = group.add(rectangle(band).set("fill", colour).set("fill-opacity", 0.22));
        }
    }
    group = group.add(stroke(&line, INK, 2.2));
    for (fit, mark) in marks.iter().enumerate() {
        let foot = [Point::new(x.at(mark.at), frame.min.y), Point::new(x.at(mark.at), frame.max.y)];
        group = group.add(Look::of(fit).draw(&foot, 2.0));
        group = group.add(fit_mark(fit, Point::new(x.at(mark.at), frame.min.y + 14.0 + 22.0 * fit as f64)));
    }
    let title = Words::new().plain("risk weight ").italic("c").sub("r").plain(" (m)");
    group
        .add(rectangle(frame).set("fill", "none").set("stroke", INK).set("stroke-width", 1.2))
        .add(x.below(frame, title))
        .add(y.beside(frame, Words::new().plain("rms error (%)")))
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let marks = [8.0, 9.0].map(|at| RiskWeightMark { at, interval: Some([7.0, 11.0]) });
        let picture = answers(&panels(), &curve, &marks, "One <. Two").unwrap();
        assert_eq!(picture, answers(&panels(), &curve, &marks, "One <. Two").unwrap());
        crate::drawing::tests::check_well_formed(&picture);
        assert!(!picture.contains("NaN") && !picture.contains("inf"));
        let (legend, chart) = (1, 2);
        assert_eq!(picture.matches("class=\"answer\"").count(), 4 + legend);
        assert_eq!(picture.matches("class=\"mean\"").count(), 2 + legend);
        assert_eq!(picture.matches("class=\"fit\"").count(), 4 + 2 * legend + chart);
        assert!(picture.contains("One &lt;.") && picture.contains("Two"));
        assert!(picture.contains("a &amp; b") && picture.contains("&lt;1&gt;"));
    }

    #[test]
    fn plains_are_left_out() {
        let height = |i: i32| if (100..200).contains(&i) { 3.0 } else { 30.0 };
        let curve: Vec<(f64, f64)> = (0..400).map(|i| (f64::from(i), height(i))).collect();
        let shown = without_plains(&curve);
        assert_eq!((shown[0].0, shown[shown.len() - 1].0), (80.0, 219.0));
        assert_eq!(without_plains(&curve[..50]).len(), 50);
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        let marks = [RiskWeightMark { at: 8.0, interval: None }; 2];
        let curve = [(0.1, 30.0), (10.0, 5.0)];
        assert!(matches!(answers(&[], &curve, &marks, ""), Err(DrawingError::NoPanels)));
        let mut spoiled = panels();
        spoiled[0].rows[1].mean = f64::NAN;
        assert!(matches!(answers(&spoiled, &curve, &marks, ""), Err(DrawingError::Fit { .. })));
    }
}
