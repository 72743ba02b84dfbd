//! Curves in; a figure of charts with even axes out, two in a row, each with a legend of its own.

use super::DrawingError;
use super::axis::Scale;
use super::scene::{document, rectangle};
use super::style::{INK, LARGE, Look, SMALL, stroke, width_by_rank};
use super::text::{Align, Words, shorten};
use crate::geometry::{Bounds, Point, Vector};
use svg::node::element::Group;

/// A chart of curves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurvePanel {
    /// Stands above the chart; long ones are shortened.
    pub title: String,
    /// What lies along the horizontal and the vertical axis.
    pub axes: [String; 2],
    /// The ends of both axes.
    pub ranges: [[f64; 2]; 2],
    /// A value of the vertical axis to be marked by a line across.
    pub mark: Option<f64>,
    /// The curves.
    pub curves: Vec<Curve>,
}

/// One curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// What the legend calls it.
    pub label: String,
    /// Its points; what lies beyond the axes is cut off at their ends.
    pub points: Vec<[f64; 2]>,
}

/// Charts in a row.
const ACROSS: usize = 2;
/// Size of a chart's frame, px.
const SIZE: Vector = Vector::new(262.0, 236.0);
/// Left side of the first column, and the distance from one to the next, px.
const LEFT: f64 = 78.0;
const PITCH: f64 = 360.0;
/// Room above a chart, and below it up to the legend, px.
const ABOVE: f64 = 38.0;
const BELOW: f64 = 74.0;
/// Length of a sample of a line, and height of a line of the legend, px.
const SAMPLE: f64 = 44.0;
const LINE: f64 = 24.0;

/// The charts, two in a row.
///
/// # Errors
/// [`DrawingError::NoPanels`]; [`DrawingError::Fit`] for a point or an end of an axis that is not a number.
pub fn curves(panels: &[CurvePanel]) -> Result<String, DrawingError> {
    if panels.is_empty() {
        return Err(DrawingError::NoPanels);
    }
    panels.iter().try_for_each(check)?;
    let mut drawn = Vec::new();
    let mut top = 0.0;
    for row in panels.chunks(ACROSS) {
        let mut lowest: f64 = top;
        for (column, panel) in row.iter().enumerate() {
            let min = Point::new(LEFT + column as f64 * PITCH, top + ABOVE);
            let (group, bottom) = draw(panel, Bounds { min, max: min + SIZE });
            drawn.push(group);
            lowest = lowest.max(bottom);
        }
        top = lowest;
    }
    Ok(drawn.into_iter().fold(document(top), svg::Document::add).to_string())
}

fn check(panel: &CurvePanel) -> Result<(), DrawingError> {
    let ends = panel.ranges.iter().flatten().chain(&panel.mark);
    let points = panel.curves.iter().flat_map(|c| c.points.iter().flatten());
    match ends.chain(points).find(|v| !v.is_finite()) {
        Some(value) => Err(DrawingError::Fit { what: panel.title.clone(), value: *value }),
        None => Ok(()),
    }
}

/// A chart with its legend, and the y at which that ends.
fn draw(panel: &CurvePanel, frame: Bounds) -> (Group, f64) {
    let across = Scale { range: panel.ranges[0], ends: [frame.min.x, frame.max.x], is_log: false };
    let up = Scale { range: panel.ranges[1], ends: [frame.max.y, frame.min.y], is_log: false };
    let title = Words::new().plain(shorten(&panel.title, 34));
    let title = title.at(frame.min - Vector::new(0.0, 12.0), LARGE, Align::Left);
    let mut group = Group::new()
        .set("class", "panel")
        .add(Group::new().set("font-weight", "bold").add(title))
        .add(across.grid_across(frame));
    if let Some(mark) = panel.mark {
        let ends = [frame.min.x, frame.max.x].map(|x| Point::new(x, up.at(mark)));
        group = group.add(stroke(&ends, INK, 1.4).set("stroke-dasharray", "7 5"));
    }
    for (i, curve) in panel.curves.iter().enumerate() {
        let points: Vec<Point> =
            curve.points.iter().map(|[x, y]| Point::new(across.at(*x), up.at(*y))).collect();
        if points.len() > 1 {
            let line = Group::new().set("class", "curve").add(Look::of(i).draw(&points, width(i, panel)));
            group = group.add(line);
        }
    }
    group = group
        .add(rectangle(frame).set("fill", "none").set("stroke", INK).set("stroke-width", 1.2))
        .add(across.below(frame, Words::new().plain(panel.axes[0].as_str())))
        .add(up.beside(frame, Words::new().plain(panel.axes[1].as_str())));
    let widest = panel.curves.iter().map(|c| words(c).width(SMALL)).fold(0.0, f64::max);
    let pitch = SAMPLE + 8.0 + widest + 14.0;
    let columns = (((SIZE.x + 40.0) / pitch) as usize).clamp(1, 2);
    let lines = panel.curves.len().div_ceil(columns);
    for (i, curve) in panel.curves.iter().enumerate() {
        let (column, line) = ((i / lines) as f64, (i % lines) as f64);
        let from = Point::new(frame.min.x + column * pitch, frame.max.y + BELOW + line * LINE);
        let to = from + Vector::new(SAMPLE, 0.0);
        group = group.add(Look::of(i).draw(&[from, to], width(i, panel))).add(words(curve).at(
            to + Vector::new(8.0, 0.35 * SMALL),
            SMALL,
            Align::Left,
        ));
    }
    (group, frame.max.y + BELOW + lines as f64 * LINE)
}

/// Width of a curve, px: each is narrower than the one before, so that those which coincide remain visible.
fn width(index: usize, panel: &CurvePanel) -> f64 {
    0.7 * width_by_rank(index, panel.curves.len())
}

fn words(curve: &Curve) -> Words {
    Words::new().plain(shorten(&curve.label, 28))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel() -> CurvePanel {
        CurvePanel {
            title: "a <chart>".to_owned(),
            axes: ["x (m)".to_owned(), "y".to_owned()],
            ranges: [[0.0, 1.0], [0.0, 2.0]],
            mark: Some(1.0),
            curves: (0..3)
                .map(|i| Curve { label: format!("c {i}"), points: vec![[0.0, 0.0], [1.0, f64::from(i)]] })
                .collect(),
        }
    }

    #[test]
    fn the_figure_is_well_formed_and_shows_every_curve() {
        let panels = [panel(), panel(), CurvePanel { curves: Vec::new(), ..panel() }];
        let picture = curves(&panels).unwrap();
        assert_eq!(picture, curves(&panels).unwrap());
        crate::drawing::tests::check_well_formed(&picture);
        assert!(!picture.contains("NaN") && picture.contains("a &lt;chart&gt;"));
        assert_eq!(picture.matches("class=\"curve\"").count(), 6);
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        assert!(matches!(curves(&[]), Err(DrawingError::NoPanels)));
        let mut spoiled = panel();
        spoiled.curves[1].points[0][1] = f64::INFINITY;
        assert!(matches!(curves(&[spoiled]), Err(DrawingError::Fit { .. })));
    }
}
