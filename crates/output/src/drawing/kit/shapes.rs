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

/// The number that [`px`] writes: the nearest hundredth, and of two equally near ones the even one.
pub(in super::super) fn rounded(value: f64) -> f64 {
    let hundredths = 100.0 * value;
    let below = hundredths.floor();
    // half a hundredth may be a product that was rounded: its error decides
    let error = value.mul_add(100.0, -hundredths);
    let is_above = match hundredths - below {
        0.5 => error > 0.0 || (error == 0.0 && below % 2.0 != 0.0),
        part => part > 0.5,
    };
    (if is_above { below + 1.0 } else { below }) / 100.0
}

/// A coordinate or length of the picture, to a hundredth of a pixel.
pub(in super::super) fn px(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_as_they_are_written() {
        let near_ties =
            (0..4000).flat_map(|i| [0.005, 0.35 * 16.5, 0.36 * 19.0].map(|by| f64::from(i) / 8.0 + by));
        for value in near_ties.flat_map(|value| [value, -value]) {
            assert_eq!(px(value).parse(), Ok(rounded(value) + 0.0), "{value}");
        }
    }
}
