//! Plain lines and areas, with coordinates to a hundredth of a pixel.

use cocarry::geometry::{Bounds, Point};
use svg::node::element::{Circle, Path, Rectangle};

/// A plain line.
pub(in super::super) fn stroke(points: &[Point], colour: &str, width: f64) -> Path {
    Path::new()
        .set("d", path_data(points))
        .set("fill", "none")
        .set("stroke", colour)
        .set("stroke-width", px(width))
        .set("stroke-linejoin", "round")
}

/// A closed outline to be filled.
pub(in super::super) fn polygon(corners: &[Point]) -> Path {
    Path::new().set("d", path_data(corners) + "Z")
}

/// The area between closed outlines, to be filled.
pub(in super::super) fn area(rings: &[Vec<Point>]) -> Path {
    let data: String = rings.iter().map(|ring| path_data(ring) + "Z").collect();
    Path::new().set("d", data).set("fill-rule", "evenodd")
}

pub(in super::super) fn disc(center: Point, radius: f64) -> Circle {
    Circle::new().set("cx", px(center.x)).set("cy", px(center.y)).set("r", px(radius))
}

pub(in super::super) fn rectangle(bounds: Bounds) -> Rectangle {
    Rectangle::new()
        .set("x", px(bounds.min.x))
        .set("y", px(bounds.min.y))
        .set("width", px(bounds.size().x))
        .set("height", px(bounds.size().y))
}

/// The `d` attribute of a line, without points too close to be distinguishable.
pub(in super::super) fn path_data(points: &[Point]) -> String {
    const CLOSE: f64 = 0.1;
    let mut kept: Vec<Point> = Vec::new();
    for (i, p) in points.iter().enumerate() {
        if i + 1 == points.len() || kept.last().is_none_or(|last| (p - last).norm() > CLOSE) {
            kept.push(*p);
        }
    }
    let pairs: Vec<String> = kept.iter().map(|p| format!("{},{}", px(p.x), px(p.y))).collect();
    format!("M{}", pairs.join("L"))
}

/// A coordinate or length of the picture, to a hundredth of a pixel.
pub(in super::super) fn px(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}
