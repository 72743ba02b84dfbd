//! Charts of curves, two in a row, each with its own legend.

use super::kit::{
    AXIS_ROOM, GAP, LEFT_ROOM, Legend, LineStyle, Plot, Text, frame_title, guide, in_two_columns, level,
    line_sample, width_by_rank,
};
use super::{not_drawable, nothing};
use cocarry::Error;
use cocarry::geometry::{Bounds, Point};
use svg::node::element::Group;

/// A chart of curves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurvePanel {
    /// Title above the chart; long ones are shortened.
    pub title: String,
    /// Titles of the horizontal and the vertical axis.
    pub axes: [String; 2],
    /// Ranges of both axes.
    pub ranges: [[f64; 2]; 2],
    /// A value of the vertical axis marked by a horizontal line.
    pub mark: Option<f64>,
    /// The curves.
    pub curves: Vec<Curve>,
}

/// One curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// Label in the legend.
    pub label: String,
    /// Points; values beyond the axes are clipped to their ends.
    pub points: Vec<[f64; 2]>,
}

/// Height of a chart's frame, px.
const HEIGHT: f64 = 236.0;

/// The charts, two in a row.
///
/// # Errors
/// There is no panel, or a point or an end of an axis is not a number.
pub fn curves(panels: &[CurvePanel]) -> Result<String, Error> {
    if panels.is_empty() {
        return Err(nothing());
    }
    panels.iter().try_for_each(check)?;
    Ok(in_two_columns(panels, HEIGHT, draw))
}

fn check(panel: &CurvePanel) -> Result<(), Error> {
    let ends = panel.ranges.iter().flatten().chain(&panel.mark);
    let points = panel.curves.iter().flat_map(|c| c.points.iter().flatten());
    match ends.chain(points).find(|v| !v.is_finite()) {
        Some(value) => Err(not_drawable(&panel.title, *value)),
        None => Ok(()),
    }
}

/// A chart with its legend, and the y at which the legend ends.
fn draw(panel: &CurvePanel, frame: Bounds) -> (Group, f64) {
    let plot = Plot::linear(frame, panel.ranges);
    let mut group = Group::new()
        .add(frame_title(&panel.title, frame.min.x, frame))
        .add(plot.x.grid(frame))
        .add(plot.y.grid(frame));
    if let Some(mark) = panel.mark {
        group = group.add(guide(level(plot.y.at(mark), frame)));
    }
    let mut legend = Legend::of_lines();
    for (i, curve) in panel.curves.iter().enumerate() {
        let (style, width) = (LineStyle::of(i), 0.7 * width_by_rank(i, panel.curves.len()));
        let points: Vec<Point> = curve.points.iter().map(|[x, y]| plot.at(*x, *y)).collect();
        if points.len() > 1 {
            group = group.add(style.draw(&points, width).set("class", "curve"));
        }
        legend = legend.entry(line_sample(style, width), curve.label.as_str());
    }
    let [x, y] = panel.axes.each_ref().map(Text::new);
    let below = Point::new(frame.min.x - LEFT_ROOM / 2.0, frame.max.y + AXIS_ROOM);
    let (legend, bottom) = legend.draw(below, frame.max.x - below.x);
    (group.add(plot.axes(&x, &y)).add(legend), bottom + GAP)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{NOTHING, error};
    use super::*;
    use crate::drawing::tests::checked;

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
        let picture = checked(|| curves(&panels));
        assert!(picture.contains("a &lt;chart&gt;"));
        assert_eq!(picture.matches("class=\"curve\"").count(), 6);
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        assert_eq!(error(curves(&[])), NOTHING);
        let mut spoiled = panel();
        spoiled.curves[1].points[0][1] = f64::INFINITY;
        assert!(error(curves(&[spoiled])).ends_with(": inf cannot be drawn"));
    }
}
