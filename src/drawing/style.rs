//! Numbers and indices in; what the pictures have in common out: colours, dash patterns, strokes and the notation of numbers.

use crate::geometry::Point;
use crate::math;
use plotters::style::colors::colormaps::{ColorMap, ViridisRGB};
use svg::node::element::{Circle, Group, Path};

/// Font sizes, px: names and titles; everything else.
pub(super) const LARGE: f64 = 19.0;
pub(super) const SMALL: f64 = 16.5;

/// Ink of frames and letters.
pub(super) const INK: &str = "#1a1a1a";

/// How one of several lines is told from the others.
#[derive(Clone, Copy)]
pub(super) struct Look {
    pub colour: &'static str,
    /// Lengths drawn and left out in turn, px, for a line of middling width; empty is solid.
    dash: &'static [f64],
}

const COLOURS: [&str; 12] = [
    "#1c5bd0", "#dd4b12", "#a81592", "#e39b00", "#111111", "#43aee6", "#7d4a1e", "#2c8f45", "#f080ab",
    "#27306b", "#8b8c12", "#a30b14",
];

const DASHES: [&[f64]; 12] = [
    &[],
    &[14.0, 6.0],
    &[4.0, 5.0],
    &[17.0, 5.0, 4.0, 5.0],
    &[9.0, 5.0],
    &[17.0, 5.0, 4.0, 5.0, 4.0, 5.0],
    &[26.0, 7.0],
    &[6.0, 3.0],
    &[13.0, 4.0, 6.0, 4.0],
    &[4.0, 9.0],
    &[26.0, 5.0, 4.0, 5.0],
    &[9.0, 4.0, 4.0, 4.0, 4.0, 4.0],
];

impl Look {
    /// The look of the line with this index: twelve differ in colour, every later one at least in colour or dash.
    pub fn of(index: usize) -> Self {
        let n = COLOURS.len();
        Self { colour: COLOURS[index % n], dash: DASHES[(index + index / n) % n] }
    }

    /// A thin line that steps back.
    pub const FAINT: Self = Self { colour: "#8f8f8f", dash: &[] };

    /// A line through `points` (px), edged in white so that what lies below it stays readable.
    pub fn draw(self, points: &[Point], width: f64) -> Group {
        let edge = stroke(points, "#ffffff", width + 0.8);
        let line = stroke(points, self.colour, width);
        let group = Group::new();
        if self.dash.is_empty() {
            return group.add(edge).add(line);
        }
        let factor = (width / 4.5).clamp(0.75, 1.5);
        let dash: Vec<String> = self.dash.iter().map(|d| px(d * factor)).collect();
        let dash = dash.join(" ");
        group.add(edge.set("stroke-dasharray", dash.clone())).add(line.set("stroke-dasharray", dash))
    }

    /// A cross with its middle at `at` (px).
    pub fn cross(self, at: Point) -> Group {
        const ARM: f64 = 7.0;
        let arm = |dx: f64, dy: f64| [Point::new(at.x - dx, at.y - dy), Point::new(at.x + dx, at.y + dy)];
        [("#ffffff", 6.5, ARM + 1.5), (self.colour, 3.4, ARM)].into_iter().fold(
            Group::new(),
            |group, (colour, width, reach)| {
                let bar = |sign: f64| stroke(&arm(reach, sign * reach), colour, width);
                group.add(bar(1.0)).add(bar(-1.0))
            },
        )
    }
}

/// Widths of lines, px, that grow with probability and differ from each other.
pub(super) fn widths_by_probability(probabilities: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut widths: Vec<f64> = probabilities.map(|p| 1.4 + 9.0 * p.min(1.0)).collect();
    let mut order: Vec<usize> = (0..widths.len()).collect();
    // of equally wide lines the later one is the narrower
    order.sort_by(|&a, &b| widths[a].total_cmp(&widths[b]).then(b.cmp(&a)));
    let step = (8.0 / widths.len().max(1) as f64).min(1.6);
    for pair in order.windows(2) {
        widths[pair[1]] = widths[pair[1]].max(widths[pair[0]] + step);
    }
    widths
}

/// Width of one of several lines, px: each is narrower than the one before.
pub(super) fn width_by_rank(index: usize, of: usize) -> f64 {
    let narrowed = index as f64 / of.saturating_sub(1).max(3) as f64;
    6.4 - 4.2 * narrowed
}

/// A plain line through `points` (px).
pub(super) fn stroke(points: &[Point], colour: &str, width: f64) -> Path {
    Path::new()
        .set("d", path_data(points))
        .set("fill", "none")
        .set("stroke", colour)
        .set("stroke-width", px(width))
        .set("stroke-linejoin", "round")
}

/// A disc around `center` (px).
pub(super) fn disc(center: Point, radius: f64) -> Circle {
    Circle::new().set("cx", px(center.x)).set("cy", px(center.y)).set("r", px(radius))
}

/// The `d` attribute of a line through `points` (px), less those too close to be told apart.
pub(super) fn path_data(points: &[Point]) -> String {
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

/// The colour of a risk from 0 (light) to 1 (dark).
pub(super) fn risk_colour(risk: f64) -> String {
    let colour = ViridisRGB.get_color(1.0 - risk.clamp(0.0, 1.0));
    format!("#{:02x}{:02x}{:02x}", colour.0, colour.1, colour.2)
}

/// A coordinate or length of the picture, to a hundredth of a pixel.
pub(super) fn px(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// A number with a true minus sign.
pub(super) fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.bytes().all(|b| b == b'0' || b == b'.') => digits.to_owned(),
        Some(digits) => format!("\u{2212}{digits}"),
        None => text,
    }
}

/// Round numbers from `low` to `high` that are at least `least_step` apart, as (value, label).
pub(super) fn ticks(low: f64, high: f64, least_step: f64) -> Vec<(f64, String)> {
    let power = math::pow(10f64, math::log10(least_step).floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= least_step);
    let step = step.unwrap_or(10.0 * power);
    let decimals = (-(math::log10(step) + 1e-9).floor()).max(0.0) as usize;
    let (first, last) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    (first..=last).map(|i| i as f64 * step).map(|v| (v, number(v, decimals))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let labels = |low, high, step| ticks(low, high, step).into_iter().map(|t| t.1).collect::<Vec<_>>();
        assert_eq!(labels(-4.2, 4.9, 1.3), ["\u{2212}4", "\u{2212}2", "0", "2", "4"]);
        assert_eq!(labels(0.0, 0.11, 0.03), ["0.00", "0.05", "0.10"]);
    }

    #[test]
    fn numbers_have_one_minus_sign_and_no_negative_zero() {
        assert_eq!([number(-0.001, 2), number(-1.5, 1), px(-0.001)], ["0.00", "\u{2212}1.5", "0"]);
    }

    #[test]
    fn wider_lines_are_more_probable_and_no_two_are_alike() {
        let widths = widths_by_probability([0.1, 0.5, 0.5, 0.0].into_iter());
        assert!(widths[1] > widths[2] && widths[2] > widths[0] && widths[0] > widths[3], "{widths:?}");
    }
}
