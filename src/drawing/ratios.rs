//! Control costs relative to a baseline in; the figure of them out: a strip for every method, a mark for every cell of a table.

use super::scene::{document, rectangle};
use super::style::{INK, LARGE, Look, SMALL, disc, path_data, stroke, ticks};
use super::text::{Align, Words, shorten};
use super::{DrawingError, WIDTH};
use crate::geometry::{Bounds, Point, Vector};
use std::collections::BTreeSet;
use svg::node::element::{Group, Path};

/// One part of the figure of cost ratios; all parts have one horizontal axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RatioPanel {
    /// Stands above the panel; long ones are shortened.
    pub title: String,
    /// From the top.
    pub rows: Vec<RatioRow>,
}

/// One way of choosing the configuration, and what it cost.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RatioRow {
    /// Stands on the left of the row; long ones are shortened.
    pub label: String,
    /// Environment, 1 and up, and the cost over the baseline's there: one pair a cell of the table.
    pub ratios: Vec<(u32, f64)>,
}

/// The axis shows these ratios whatever the data are.
const ALWAYS: [f64; 2] = [0.2, 1.1];
/// The ratio of the baseline to itself.
const BASELINE: f64 = 1.0;
/// Ratios above this are refused.
const HIGHEST: f64 = 1e3;

/// Left and right end of what is drawn, px.
const SIDES: [f64; 2] = [20.0, WIDTH - 20.0];
/// The widest that labels of rows get, px.
const LABELS: f64 = 220.0;
/// Height of a row, px.
const ROW: f64 = 52.0;
/// Distance of the lines on which the marks of one environment and of the next lie, px.
const LANE: f64 = 10.4;
/// By how much marks of one environment that are nearly equal are moved down in turn, px: a quarter of [`LANE`] apart, so that sixteen
/// equal ratios are as far apart as they can be.
const MOVED: [f64; 4] = [-1.3, 1.3, -3.9, 3.9];
/// Half of the height of the mark at the mean, px.
const MEAN: f64 = 24.0;
/// Half of the size of a mark, px.
const MARK: f64 = 4.5;
/// Room above a panel for its title, px.
const ABOVE: f64 = 36.0;
/// How many shapes there are.
const SHAPES: usize = 4;

/// Control costs relative to no pose optimisation: one panel under the other on one axis, in each a strip for every method with a mark for
/// every cell, whose shape tells the environment, and a bar at their mean.
///
/// The axis reaches from 0.2 to 1.1, or to the tenths beyond the ratios. The marks of the first environment lie highest in a strip, those
/// of the fourth lowest, and those of one environment that are nearly equal are moved apart; shapes repeat after four environments. Shapes
/// differ in being full or open too, for print in grey.
///
/// # Errors
/// [`DrawingError::NoPanels`]; [`DrawingError::Ratio`] for what is not a number from 0 to 1000.
pub fn cost_ratios(panels: &[RatioPanel]) -> Result<String, DrawingError> {
    check(panels)?;
    let axis = Axis::around(panels);
    let mut top = 8.0;
    let mut drawn = Vec::new();
    for panel in panels {
        let min = Point::new(axis.left, top + ABOVE);
        let frame = Bounds { min, max: Point::new(SIDES[1], min.y + panel.rows.len() as f64 * ROW) };
        drawn.push(draw(panel, &axis, frame));
        top = frame.max.y + 14.0;
    }
    let (labels, bottom) = axis.labels(top - 14.0);
    let (legend, bottom) = legend(Point::new(SIDES[0], bottom + 38.0), panels);
    let picture = drawn.into_iter().fold(document(bottom), svg::Document::add);
    Ok(picture.add(labels).add(legend).to_string())
}

fn check(panels: &[RatioPanel]) -> Result<(), DrawingError> {
    if panels.is_empty() {
        return Err(DrawingError::NoPanels);
    }
    for row in panels.iter().flat_map(|p| &p.rows) {
        if let Some((environment, value)) = row.ratios.iter().find(|r| !(0.0..=HIGHEST).contains(&r.1)) {
            return Err(DrawingError::Ratio {
                row: row.label.clone(),
                environment: *environment,
                value: *value,
            });
        }
    }
    Ok(())
}

/// Where a ratio lies.
struct Axis {
    /// The ratios at the ends.
    range: [f64; 2],
    /// Where the frames begin, px.
    left: f64,
}

impl Axis {
    fn around(panels: &[RatioPanel]) -> Self {
        let rows = || panels.iter().flat_map(|p| &p.rows);
        let ratios = || rows().flat_map(|r| &r.ratios).map(|r| r.1);
        let (least, most) = (ratios().fold(ALWAYS[0], f64::min), ratios().fold(ALWAYS[1], f64::max));
        // ends that are tenths but for rounding stay
        let range = [(10.0 * least + 1e-6).floor() / 10.0, (10.0 * most - 1e-6).ceil() / 10.0];
        let labels = rows().map(|r| label(r).width(SMALL)).fold(0.0, f64::max);
        let left = SIDES[0] + labels.min(LABELS) + 12.0;
        // so that marks at the ends lie inside the frame
        let margin = (range[1] - range[0]) * 2.0 * MARK / (SIDES[1] - left);
        Self { range: [range[0] - margin, range[1] + margin], left }
    }

    fn scale(&self) -> f64 {
        (SIDES[1] - self.left) / (self.range[1] - self.range[0])
    }

    /// px.
    fn x(&self, ratio: f64) -> f64 {
        self.left + (ratio - self.range[0]) * self.scale()
    }

    fn ticks(&self) -> Vec<(f64, String)> {
        ticks(self.range[0], self.range[1], 50.0 / self.scale())
    }

    /// The numbers below a frame that ends at `bottom` and what they mean, and the y at which that ends.
    fn labels(&self, bottom: f64) -> (Group, f64) {
        let numbers = self.ticks().into_iter().map(|(ratio, label)| {
            let at = Point::new(self.x(ratio), bottom + 24.0);
            Words::new().plain(label).at(at, SMALL, Align::Middle)
        });
        let title =
            Words::new().plain("control cost ").italic("C").plain(" relative to no pose optimisation");
        // in the middle of the frame, unless it is too long for that
        let half = title.width(LARGE) / 2.0;
        let middle = ((self.left + SIDES[1]) / 2.0).min(SIDES[1] - half).max(SIDES[0] + half);
        let at = Point::new(middle, bottom + 50.0);
        let group = numbers.fold(Group::new().set("class", "axis"), Group::add);
        (group.add(title.at(at, LARGE, Align::Middle)), at.y)
    }
}

fn label(row: &RatioRow) -> Words {
    Words::new().plain(shorten(&row.label, 24))
}

/// A panel with its title.
fn draw(panel: &RatioPanel, axis: &Axis, frame: Bounds) -> Group {
    let upright = |x: f64| [Point::new(x, frame.min.y), Point::new(x, frame.max.y)];
    let title = Words::new().plain(shorten(&panel.title, 48));
    let title = title.at(Point::new(SIDES[0], frame.min.y - 11.0), LARGE, Align::Left);
    let mut group =
        Group::new().set("class", "panel").add(Group::new().set("font-weight", "bold").add(title));
    let strip = |i: usize| {
        let min = frame.min + Vector::new(0.0, i as f64 * ROW);
        Bounds { min, max: Point::new(frame.max.x, min.y + ROW) }
    };
    for i in (0..panel.rows.len()).step_by(2) {
        group = group.add(rectangle(strip(i)).set("fill", "#f1f1f1"));
    }
    for (ratio, _) in axis.ticks() {
        let x = axis.x(ratio);
        let foot = Point::new(x, frame.max.y);
        group = group.add(stroke(&upright(x), "#d2d2d2", 1.0));
        group = group.add(stroke(&[foot, foot + Vector::new(0.0, 6.0)], INK, 1.2));
    }
    group = group.add(baseline(upright(axis.x(BASELINE))));
    for (i, row) in panel.rows.iter().enumerate() {
        let strip = strip(i);
        let middle = nalgebra::center(&strip.min, &strip.max).y;
        let words = label(row);
        let size = SMALL * (LABELS / words.width(SMALL)).min(1.0);
        let at = Point::new(axis.left - 12.0, middle + 0.35 * size);
        group = group.add(words.at(at, size, Align::Right)).add(marks(row, axis, middle).set("data-row", i));
    }
    group.add(rectangle(frame).set("fill", "none").set("stroke", INK).set("stroke-width", 1.2))
}

/// The marks of a row whose middle lies at `middle` (px).
fn marks(row: &RatioRow, axis: &Axis, middle: f64) -> Group {
    let environments = row.ratios.iter().map(|r| r.0);
    let mut marks: Vec<(u32, Point)> = environments.zip(places(row, axis, middle)).collect();
    // from the bottom, so that every mark's foot remains visible: a triangle is widest there
    marks.sort_by(|a, b| b.1.y.total_cmp(&a.1.y));
    let group = Group::new().set("class", "row");
    let group = marks.into_iter().fold(group, |group, (environment, at)| group.add(mark(environment, at)));
    if row.ratios.is_empty() {
        return group;
    }
    let mean = row.ratios.iter().map(|r| r.1).sum::<f64>() / row.ratios.len() as f64;
    group.add(mean_bar(Point::new(axis.x(mean), middle), MEAN))
}

/// Where the marks of a row lie, px.
fn places(row: &RatioRow, axis: &Axis, middle: f64) -> Vec<Point> {
    const NEAR: f64 = 1.4 * MARK;
    // shape, x and index into `MOVED` of the marks before
    let mut before: Vec<(usize, f64, usize)> = Vec::new();
    let mut places = Vec::new();
    for (environment, ratio) in &row.ratios {
        let (shape, x) = (shape_of(*environment), axis.x(*ratio));
        let near = |b: &&(usize, f64, usize)| b.0 == shape && (b.1 - x).abs() < NEAR;
        let taken: Vec<usize> = before.iter().filter(near).map(|b| b.2).collect();
        let free = (0..MOVED.len()).find(|m| !taken.contains(m));
        let moved = free.unwrap_or(taken.len() % MOVED.len());
        before.push((shape, x, moved));
        let lane = shape as f64 - (SHAPES - 1) as f64 / 2.0;
        places.push(Point::new(x, middle + lane * LANE + MOVED[moved]));
    }
    places
}

fn baseline(ends: [Point; 2]) -> Path {
    stroke(&ends, INK, 1.6).set("stroke-dasharray", "7 5")
}

/// An upright bar at a mean.
fn mean_bar(at: Point, half: f64) -> Path {
    stroke(&upright(at, half), INK, 3.8)
}

/// The ends of an upright line around `at` (px).
fn upright(at: Point, half: f64) -> [Point; 2] {
    [at - Vector::new(0.0, half), at + Vector::new(0.0, half)]
}

fn shape_of(environment: u32) -> usize {
    (environment as usize % SHAPES + SHAPES - 1) % SHAPES
}

/// The mark of an environment, edged in white: full circle, open square, full triangle or open diamond.
fn mark(environment: u32, at: Point) -> Group {
    let corners: &[[f64; 2]] = match shape_of(environment) {
        0 => &[],
        1 => &[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]],
        2 => &[[0.0, -1.2], [1.2, 0.95], [-1.2, 0.95]],
        _ => &[[0.0, -1.3], [1.3, 0.0], [0.0, 1.3], [-1.3, 0.0]],
    };
    let look = Look::of([0, 1, 2, 7][shape_of(environment)]);
    let corners: Vec<Point> = corners.iter().map(|[x, y]| at + MARK * Vector::new(*x, *y)).collect();
    let shape = |group: Group| match corners.is_empty() {
        true => group.add(disc(at, MARK)),
        false => group.add(Path::new().set("d", path_data(&corners) + "Z")),
    };
    let edge = Group::new().set("stroke", "#ffffff").set("stroke-width", 2.3).set("fill", "none");
    let is_full = shape_of(environment).is_multiple_of(2);
    let ink = Group::new()
        .set("stroke", look.colour)
        .set("stroke-width", 1.5)
        .set("fill", if is_full { look.colour } else { "#ffffff" })
        .set("fill-opacity", if is_full { 1.0 } else { 0.6 });
    Group::new().set("class", "mark").add(shape(edge)).add(shape(ink))
}

/// What the marks mean, and the y at which that ends.
fn legend(at: Point, panels: &[RatioPanel]) -> (Group, f64) {
    const LINE: f64 = 28.0;
    const SAMPLE: f64 = 20.0;
    let rows = panels.iter().flat_map(|p| &p.rows);
    let environments: BTreeSet<u32> = rows.flat_map(|r| &r.ratios).map(|r| r.0).collect();
    let mut group = Group::new().set("class", "legend");
    let mut at = at - Vector::new(SAMPLE, 0.0);
    let mut put = |sample: &dyn Fn(Point) -> Group, words: &str| {
        let words = Words::new().plain(words);
        if at.x + SAMPLE + words.width(SMALL) > SIDES[1] {
            at = Point::new(SIDES[0], at.y + LINE);
        }
        let text = words.at(at + Vector::new(SAMPLE, 0.0), SMALL, Align::Left);
        let sample = sample(at + Vector::new(0.45 * SAMPLE, -0.35 * SMALL));
        group = std::mem::take(&mut group).add(sample).add(text);
        at.x += SAMPLE + words.width(SMALL) + 16.0;
    };
    put(&|_| Group::new(), "environment");
    for environment in environments {
        put(&|at| mark(environment, at), &environment.to_string());
    }
    put(&|at| Group::new().add(mean_bar(at, 9.0)), "mean");
    put(&|at| Group::new().add(baseline(upright(at, 13.0))), "no pose optimisation");
    (group, at.y + 18.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(label: &str, ratios: &[(u32, f64)]) -> RatioRow {
        RatioRow { label: label.to_owned(), ratios: ratios.to_vec() }
    }

    fn panels() -> Vec<RatioPanel> {
        let ratios: Vec<(u32, f64)> = (0..16).map(|i| (i / 4 + 1, 0.3 + 0.05 * f64::from(i))).collect();
        vec![
            RatioPanel { title: "(a) up".to_owned(), rows: vec![row("<&\"", &ratios), row("none", &[])] },
            RatioPanel { title: "(b) out".to_owned(), rows: vec![row("second", &ratios)] },
            RatioPanel::default(),
        ]
    }

    #[test]
    fn the_figure_is_well_formed_deterministic_and_shows_every_ratio() {
        let picture = cost_ratios(&panels()).unwrap();
        assert_eq!(picture, cost_ratios(&panels()).unwrap());
        crate::drawing::tests::check_well_formed(&picture);
        assert!(!picture.contains("NaN") && !picture.contains("inf"));
        let legend = 4;
        assert_eq!(picture.matches("class=\"mark\"").count(), 2 * 16 + legend);
        assert_eq!(picture.matches("data-row=").count(), 3);
        for words in ["(a) up", "(b) out", "&lt;&amp;&quot;", "none", "second", "4", "mean"] {
            assert!(picture.contains(&format!(">{words}<")), "{words}");
        }
    }

    #[test]
    fn the_axis_reaches_as_far_as_the_ratios() {
        let range = |ratios: &[(u32, f64)]| {
            let axis = Axis::around(&[RatioPanel { title: String::new(), rows: vec![row("r", ratios)] }]);
            let ends = [axis.left + 2.0 * MARK, SIDES[1] - 2.0 * MARK];
            (axis.ticks(), ends.map(|x| axis.range[0] + (x - axis.left) / axis.scale()))
        };
        let near = |a: [f64; 2], b: [f64; 2]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 0.02);
        assert!(near(range(&[(1, 0.7)]).1, [0.2, 1.1]));
        assert!(near(range(&[]).1, [0.2, 1.1]));
        assert!(near(range(&[(1, 0.12), (2, 1.37)]).1, [0.1, 1.4]));
        assert!(range(&[(1, 0.0), (2, HIGHEST)]).0.len() > 2);
    }

    #[test]
    fn marks_do_not_hide_each_other() {
        let ratios: Vec<(u32, f64)> = (0..16).map(|i| (i / 4 + 1, 0.9)).collect();
        let row = row("equal", &ratios);
        let places = places(&row, &Axis::around(&[]), 0.0);
        for (i, a) in places.iter().enumerate() {
            assert!(a.y.abs() + 1.3 * MARK <= ROW / 2.0, "{a}");
            assert!(places[..i].iter().all(|b| (a - b).norm() > 2.5), "{places:?}");
        }
        assert_eq!([1, 2, 3, 4, 5, 0, u32::MAX].map(shape_of), [0, 1, 2, 3, 0, 3, 2]);
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.1, 2.0 * HIGHEST] {
            let mut panels = panels();
            panels[1].rows[0].ratios[3].1 = value;
            let refused = cost_ratios(&panels);
            assert!(matches!(refused, Err(DrawingError::Ratio { environment: 1, .. })), "{value}");
        }
        assert!(matches!(cost_ratios(&[]), Err(DrawingError::NoPanels)));
        assert!(cost_ratios(&[RatioPanel::default()]).is_ok());
    }
}
