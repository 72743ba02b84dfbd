//! The figure of cost ratios: a strip for every method, with a mark for every cell of a table.

use super::kit::{
    Axis, Legend, LineStyle, MARGIN, Shape, Sheet, Strips, Text, document, guide, mark, mean_bar, place,
};
use super::{WIDTH, nothing};
use cocarry::Error;
use cocarry::geometry::Point;
use std::collections::BTreeSet;
use svg::node::element::Group;

/// One part of the figure of cost ratios; all parts have the same horizontal axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RatioPanel {
    /// Title above the panel; long ones are shortened.
    pub title: String,
    /// Rows, top to bottom.
    pub rows: Vec<RatioRow>,
}

/// A method of choosing the configuration, with its costs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RatioRow {
    /// Label at the left of the row; long ones are shortened.
    pub label: String,
    /// The environment, from 1, and the cost relative to the baseline there: one pair per cell of the table.
    pub ratios: Vec<(u32, f64)>,
}

/// Ratios that the axis always includes.
const MIN_RANGE: [f64; 2] = [0.2, 1.1];
/// The ratio of the baseline to itself.
const BASELINE: f64 = 1.0;
/// Largest ratio accepted.
const MAX_RATIO: f64 = 1e3;

/// Largest width of row labels, px.
const LABELS_WIDTH: f64 = 220.0;
/// Height of a row, px.
const ROW_HEIGHT: f64 = 52.0;
/// Vertical distance of the marks of consecutive environments, px.
const LANE_DISTANCE: f64 = 10.4;
/// Vertical offsets, px, of nearly equal marks of one environment, in turn: a quarter of [`LANE_DISTANCE`]
/// apart, which separates sixteen equal ratios as far as possible.
const OFFSETS: [f64; 4] = [-1.3, 1.3, -3.9, 3.9];
/// Distance below which marks of one environment are nearly equal, px.
const NEARLY_EQUAL: f64 = 6.5;
/// The shapes of the environments, alternately full and open.
const SHAPES: [Shape; 4] = [Shape::Disc, Shape::Square, Shape::Triangle, Shape::Diamond];

/// Control costs relative to no pose optimisation. Panels are stacked on one axis. Each has a strip for every
/// method, with a mark for every cell and a bar at their mean; the shape of a mark stands for its
/// environment.
///
/// The axis covers 0.2 to 1.1, or more if the ratios need it, in tenths. In a strip, the marks of the first
/// environment are at the top and those of the fourth at the bottom. Nearly equal marks of one environment
/// are moved apart. Shapes repeat after four environments. They also differ in being full or open, for grey
/// print.
///
/// # Errors
/// There is no panel, or a ratio is not a number from 0 to 1000.
pub fn cost_ratios(panels: &[RatioPanel]) -> Result<String, Error> {
    check(panels)?;
    let rows = || panels.iter().flat_map(|p| &p.rows);
    let strips = Strips {
        panels: panels
            .iter()
            .map(|p| (p.title.as_str(), p.rows.iter().map(|r| r.label.as_str()).collect()))
            .collect(),
        labels_width: LABELS_WIDTH,
        row_height: ROW_HEIGHT,
        range: range(panels),
        guide: Some(BASELINE),
        sheet: Sheet::default(),
    };
    let title = Text::new("control cost ").italic("C").plain(" relative to no pose optimisation");
    let (drawn, top) = strips.draw(&title, |[panel, row], axis, middle| {
        marks(&panels[panel].rows[row], axis, middle).set("data-row", row)
    });
    let environments: BTreeSet<u32> = rows().flat_map(|r| &r.ratios).map(|r| r.0).collect();
    let legend = environments.into_iter().fold(Legend::of_marks(), |legend, environment| {
        legend.entry(environment_mark(environment), format!("environment {environment}"))
    });
    let ends = [Point::new(0.0, -0.2 * ROW_HEIGHT), Point::new(0.0, 0.2 * ROW_HEIGHT)];
    let legend = legend.entry(mean_bar(0.4 * ROW_HEIGHT), "mean");
    let legend = legend.entry(Group::new().add(guide(ends)), "no pose optimisation");
    let (legend, bottom) = legend.draw(Point::new(MARGIN, top), WIDTH - 2.0 * MARGIN);
    Ok(document(bottom).add(drawn).add(legend).to_string())
}

fn check(panels: &[RatioPanel]) -> Result<(), Error> {
    if panels.is_empty() {
        return Err(nothing());
    }
    for row in panels.iter().flat_map(|p| &p.rows) {
        if let Some((environment, value)) = row.ratios.iter().find(|r| !(0.0..=MAX_RATIO).contains(&r.1)) {
            let sentence = format!(
                "row `{}`: the ratio {value} in environment {environment} cannot be drawn",
                row.label
            );
            return Err(Error::new(sentence));
        }
    }
    Ok(())
}

/// The range of the axis.
fn range(panels: &[RatioPanel]) -> [f64; 2] {
    let ratios = || panels.iter().flat_map(|p| &p.rows).flat_map(|r| &r.ratios).map(|r| r.1);
    let (least, most) = (ratios().fold(MIN_RANGE[0], f64::min), ratios().fold(MIN_RANGE[1], f64::max));
    // tolerates rounding of ends that are tenths
    [(10.0 * least + 1e-6).floor() / 10.0, (10.0 * most - 1e-6).ceil() / 10.0]
}

/// The mean and the marks of a row centred at `middle` (px).
fn marks(row: &RatioRow, axis: &Axis, middle: f64) -> Group {
    let environments = row.ratios.iter().map(|r| r.0);
    let mut marks: Vec<(u32, Point)> = environments.zip(places(row, axis, middle)).collect();
    // from the bottom, so that the lower edge of every mark remains visible: a triangle is widest there
    marks.sort_by(|a, b| b.1.y.total_cmp(&a.1.y));
    let mut group = Group::new();
    if !row.ratios.is_empty() {
        let mean = row.ratios.iter().map(|r| r.1).sum::<f64>() / row.ratios.len() as f64;
        group = group.add(place(mean_bar(ROW_HEIGHT - 4.0), Point::new(axis.at(mean), middle)));
    }
    marks
        .into_iter()
        .fold(group, |group, (environment, at)| group.add(place(environment_mark(environment), at)))
}

/// Positions of the marks of a row, px.
fn places(row: &RatioRow, axis: &Axis, middle: f64) -> Vec<Point> {
    // shape, x and index into `OFFSETS` of the previous marks
    let mut before: Vec<(usize, f64, usize)> = Vec::new();
    let mut places = Vec::new();
    for (environment, ratio) in &row.ratios {
        let (shape, x) = (shape_of(*environment), axis.at(*ratio));
        let near = |b: &&(usize, f64, usize)| b.0 == shape && (b.1 - x).abs() < NEARLY_EQUAL;
        let taken: Vec<usize> = before.iter().filter(near).map(|b| b.2).collect();
        let free = (0..OFFSETS.len()).find(|m| !taken.contains(m));
        let moved = free.unwrap_or(taken.len() % OFFSETS.len());
        before.push((shape, x, moved));
        let lane = shape as f64 - (SHAPES.len() - 1) as f64 / 2.0;
        places.push(Point::new(x, middle + lane * LANE_DISTANCE + OFFSETS[moved]));
    }
    places
}

/// Index into [`SHAPES`].
fn shape_of(environment: u32) -> usize {
    (environment as usize % SHAPES.len() + SHAPES.len() - 1) % SHAPES.len()
}

fn environment_mark(environment: u32) -> Group {
    let shape = shape_of(environment);
    mark(SHAPES[shape], shape.is_multiple_of(2), &LineStyle::of(shape).colour())
}

#[cfg(test)]
mod tests {
    use super::super::kit::Side;
    use super::super::tests::{NOTHING, error};
    use super::*;
    use crate::drawing::tests::checked;
    use cocarry::geometry::Bounds;

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
        let picture = checked(|| cost_ratios(&panels()));
        let legend = 4;
        assert_eq!(picture.matches("class=\"mark\"").count(), 2 * 16 + legend);
        assert_eq!(picture.matches("data-row=").count(), 3);
        for words in ["(a) up", "(b) out", "&lt;&amp;&quot;", "none", "second", "environment 4", "mean"] {
            assert!(picture.contains(&format!(">{words}<")), "{words}");
        }
    }

    #[test]
    fn the_axis_reaches_as_far_as_the_ratios() {
        let range = |ratios: &[(u32, f64)]| {
            range(&[RatioPanel { title: String::new(), rows: vec![row("r", ratios)] }])
        };
        assert_eq!(range(&[(1, 0.7)]), [0.2, 1.1]);
        assert_eq!(range(&[]), [0.2, 1.1]);
        assert_eq!(range(&[(1, 0.12), (2, 1.37)]), [0.1, 1.4]);
        assert_eq!(range(&[(1, 0.0), (2, MAX_RATIO)]), [0.0, MAX_RATIO]);
    }

    #[test]
    fn marks_do_not_hide_each_other() {
        let ratios: Vec<(u32, f64)> = (0..16).map(|i| (i / 4 + 1, 0.9)).collect();
        let row = row("equal", &ratios);
        let frame = Bounds { min: Point::origin(), max: Point::new(500.0, ROW_HEIGHT) };
        let places = places(&row, &Axis::linear(Side::Below, range(&[]), frame), 0.0);
        for (i, a) in places.iter().enumerate() {
            assert!(a.y.abs() + 6.5 <= ROW_HEIGHT / 2.0, "{a}");
            assert!(places[..i].iter().all(|b| (a - b).norm() > 2.5), "{places:?}");
        }
        assert_eq!([1, 2, 3, 4, 5, 0, u32::MAX].map(shape_of), [0, 1, 2, 3, 0, 3, 2]);
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.1, 2.0 * MAX_RATIO] {
            let mut panels = panels();
            panels[1].rows[0].ratios[3].1 = value;
            let refused = error(cost_ratios(&panels));
            assert!(refused.contains(&format!("the ratio {value} in environment 1 ")), "{refused}");
        }
        assert_eq!(error(cost_ratios(&[])), NOTHING);
        assert!(cost_ratios(&[RatioPanel::default()]).is_ok());
    }
}
