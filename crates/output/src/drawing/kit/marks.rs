//! Marks of single values, drawn around the origin and moved to their positions by [`place`].

use super::{INK, PAPER, disc, polygon, px, stroke};
use cocarry::geometry::{Point, Vector};
use svg::node::element::Group;

/// Half the size of a mark, px.
const MARK: f64 = 5.0;

/// The shape of a mark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) enum Shape {
    /// A small disc.
    Dot,
    Disc,
    Square,
    Triangle,
    Diamond,
    Cross,
}

/// A mark with a white edge, filled with its colour or open.
pub(in super::super) fn mark(shape: Shape, is_full: bool, colour: &str) -> Group {
    let corners: &[[f64; 2]] = match shape {
        Shape::Dot | Shape::Disc => &[],
        Shape::Square => &[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]],
        Shape::Triangle => &[[0.0, -1.2], [1.2, 0.95], [-1.2, 0.95]],
        Shape::Diamond => &[[0.0, -1.3], [1.3, 0.0], [0.0, 1.3], [-1.3, 0.0]],
        Shape::Cross => return cross(colour),
    };
    let corners: Vec<Point> = corners.iter().map(|[x, y]| Point::from(MARK * Vector::new(*x, *y))).collect();
    let outline = |group: Group| match shape {
        Shape::Dot => group.add(disc(Point::origin(), MARK / 2.0)),
        Shape::Disc => group.add(disc(Point::origin(), MARK)),
        _ => group.add(polygon(&corners)),
    };
    let edge = Group::new().set("stroke", PAPER).set("stroke-width", 2.3).set("fill", "none");
    let ink = Group::new()
        .set("stroke", colour)
        .set("stroke-width", 1.5)
        .set("fill", if is_full { colour } else { PAPER })
        .set("fill-opacity", if is_full { 1.0 } else { 0.6 });
    Group::new().set("class", "mark").add(outline(edge)).add(outline(ink))
}

fn cross(colour: &str) -> Group {
    let bars = |group: Group, reach: f64, colour: &str, width: f64| {
        [reach, -reach].into_iter().fold(group, |group, y| {
            group.add(stroke(&[Point::new(-reach, -y), Point::new(reach, y)], colour, width))
        })
    };
    let edge = bars(Group::new().set("class", "mark"), MARK + 3.5, PAPER, 6.5);
    bars(edge, MARK + 2.0, colour, 3.4)
}

/// The mark of a mean: a vertical bar with a white edge, `height` px high.
pub(in super::super) fn mean_bar(height: f64) -> Group {
    let ends = [Point::new(0.0, -height / 2.0), Point::new(0.0, height / 2.0)];
    Group::new().set("class", "mean").add(stroke(&ends, PAPER, 6.2)).add(stroke(&ends, INK, 3.8))
}

/// Moves a drawing around the origin to `at` (px).
pub(in super::super) fn place(drawn: Group, at: Point) -> Group {
    Group::new().set("transform", format!("translate({} {})", px(at.x), px(at.y))).add(drawn)
}
