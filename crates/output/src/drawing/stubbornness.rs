//! The chart of stubbornness over steps and time, with a curve for every track.

use super::Track;
use super::kit::{
    Align, Axis, Clutter, GAP, LineStyle, Plot, Shape, Side, TEXT_SIZE, Text, guide, level, mark, place,
    width_by_rank,
};
use cocarry::geometry::{Bounds, Point, Vector};
use svg::node::element::Group;

/// Largest stubbornness shown; values up to 1 matter.
const MAX_SHOWN: f64 = 1.6;

/// The chart of phi(k) for every track in `frame`. Steps of `period` (s) give the time axis above.
pub(super) fn stubbornness(tracks: &[Track], period: f64, frame: Bounds) -> Group {
    let points = || tracks.iter().flat_map(Track::stubbornness_by_step);
    let last = points().map(|p| p.0).fold(1.0, f64::max);
    let top = points().map(|p| p.1).fold(1.0, f64::max).min(MAX_SHOWN) * 1.12;
    let plot = Plot::linear(frame, [[0.0, last], [0.0, top]]);
    let time = Axis::linear(Side::Above, [0.0, last * period], frame);

    let mut clutter = Clutter::new(frame);
    let mut lines = Group::new();
    let mut crosses = Group::new();
    for (i, track) in tracks.iter().enumerate() {
        let points = below(track.stubbornness_by_step(), top);
        let points: Vec<Point> = points.into_iter().map(|(k, phi)| plot.at(k, phi)).collect();
        let width = width_by_rank(i, tracks.len());
        if points.len() > 1 {
            clutter.add(&points, width, 1.0);
            lines = lines.add(LineStyle::of(i).draw(&points, width));
        }
        if let Some(at) = track.transition_point().map(|(k, phi)| plot.at(k, phi)) {
            clutter.take(Bounds { min: at, max: at }.grown(GAP));
            crosses = crosses.add(place(mark(Shape::Cross, true, &LineStyle::of(i).colour()), at));
        }
    }
    let one = plot.y.at(1.0);
    let words = Text::default().italic("\u{3c6}").plain(" = 1");
    let label = words.at(free_place(&words, one, frame, &clutter), TEXT_SIZE, Align::Left);
    let phi = Text::new("stubbornness ").italic("\u{3c6}").plain("(").italic("k").plain(")");
    Group::new()
        .set("class", "chart")
        .add(plot.axes(&Text::new("step ").italic("k"), &phi))
        .add(time.draw(frame, &Text::new("time (s)")))
        .add(guide(level(one, frame)))
        .add(label)
        .add(lines)
        .add(crosses)
}

/// The position for words on or under the horizontal line at `y` where they cover the least: the left end of
/// their baseline, px.
fn free_place(words: &Text, y: f64, frame: Bounds, clutter: &Clutter) -> Point {
    let size = Vector::new(words.width(TEXT_SIZE), TEXT_SIZE);
    let slack = (frame.size().x - size.x - 2.0 * GAP).max(0.0);
    let places = (0..=12).flat_map(|i| {
        let x = frame.min.x + GAP + slack * f64::from(i) / 12.0;
        [Point::new(x, y - 8.0), Point::new(x, y + 8.0 + 0.8 * size.y)]
    });
    let cost = |at: &Point| {
        let area = Bounds { min: at - Vector::new(0.0, size.y), max: at + Vector::new(size.x, 0.2 * size.y) };
        clutter.cost(area.grown(4.0))
    };
    places.min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or(frame.min)
}

/// The part of the line up to `top`, including the point at which it reaches `top`.
fn below(points: impl Iterator<Item = (f64, f64)>, top: f64) -> Vec<(f64, f64)> {
    let mut line: Vec<(f64, f64)> = Vec::new();
    for (k, phi) in points {
        if phi > top {
            let (k0, phi0) = line.last().copied().unwrap_or((k, top));
            let part = if phi > phi0 { (top - phi0) / (phi - phi0) } else { 0.0 };
            line.push((k0 + (k - k0) * part, top));
            break;
        }
        line.push((k, phi));
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_a_line_ends_where_it_leaves_the_chart() {
        let line = below([(0.0, 0.5), (1.0, 1.5), (2.0, 9.0)].into_iter(), 1.0);
        assert_eq!(line, [(0.0, 0.5), (0.5, 1.0)]);
        assert_eq!(below([(0.0, 4.0)].into_iter(), 1.0), [(0.0, 1.0)]);
    }
}
