//! Tracks and a frame on the picture in; the chart of stubbornness out, its axes drawn by plotters.

use super::labels::length_inside;
use super::style::{INK, LARGE, Look, SMALL, number, px, stroke, width_by_rank};
use super::text::{Align, FONTS, Words};
use super::{DrawingError, Track};
use crate::geometry::{Bounds, Point, Vector};
use plotters::prelude::*;
use svg::node::Blob;
use svg::node::element::Group;

/// plotters counts in whole pixels: it draws this much larger, and the result is scaled down.
const FINER: f64 = 10.0;

/// Room around the frame for labels, px: left, above, right, below.
const AROUND: [f64; 4] = [62.0, 58.0, 16.0, 56.0];

/// Stubbornness above this is not shown: it matters up to 1.
const HIGHEST: f64 = 1.6;

/// The chart of phi(k) for every track, with its axes' lines on the sides of `frame` (px).
pub(super) fn chart(tracks: &[Track], period: f64, frame: Bounds) -> Result<Group, DrawingError> {
    let points = || tracks.iter().flat_map(Track::stubbornness_by_step);
    let last = points().map(|p| p.0).fold(1.0, f64::max);
    let top = points().map(|p| p.1).fold(1.0, f64::max).min(HIGHEST) * 1.12;
    let axes = axes(frame, last, top, period)
        .map_err(|reason| DrawingError::Chart { reason: reason.to_string() })?;
    let place = |(k, phi): (f64, f64)| {
        let size = frame.size();
        Point::new(frame.min.x + k / last * size.x, frame.max.y - phi / top * size.y)
    };
    let lines: Vec<Vec<Point>> = tracks
        .iter()
        .map(|track| below(track.stubbornness_by_step(), top).into_iter().map(place).collect())
        .collect();
    let crosses: Vec<Option<Point>> =
        tracks.iter().map(|t| t.transition_point().map(|(k, phi)| place((k, phi.min(top))))).collect();

    let ends = [place((0.0, 1.0)), place((last, 1.0))];
    let dashed = stroke(&ends, INK, 1.4).set("stroke-dasharray", "7 5");
    let words = Words::new().italic("\u{3c6}").plain(" = 1");
    let label = words.at(free_place(&words, ends, &lines, &crosses), SMALL, Align::Left);
    let right = stroke(&[Point::new(frame.max.x, frame.min.y), frame.max], INK, 1.2);
    let mut group = Group::new().set("class", "chart").add(axes).add(right).add(dashed).add(label);
    for (i, line) in lines.iter().enumerate().filter(|(_, line)| line.len() > 1) {
        group = group.add(Look::of(i).draw(line, 0.8 * width_by_rank(i, tracks.len())));
    }
    for (i, at) in crosses.iter().enumerate() {
        group = at.iter().fold(group, |group, at| group.add(Look::of(i).cross(*at)));
    }
    Ok(group)
}

/// Where words on or under the horizontal line between `ends` cover the least: the left end of their baseline, px.
fn free_place(words: &Words, ends: [Point; 2], lines: &[Vec<Point>], crosses: &[Option<Point>]) -> Point {
    let size = Vector::new(words.width(SMALL), SMALL);
    let slack = (ends[1].x - ends[0].x - size.x - 16.0).max(0.0);
    let covered = |at: Point| {
        let area = Bounds { min: at - Vector::new(0.0, size.y), max: at + Vector::new(size.x, 0.2 * size.y) };
        let area = area.grown(4.0);
        let pairs = lines.iter().flat_map(|line| line.windows(2));
        let covered: f64 = pairs.map(|pair| length_inside(area, [pair[0], pair[1]])).sum();
        let near = crosses.iter().flatten().filter(|c| {
            let wide = area.grown(9.0);
            wide.min <= **c && **c <= wide.max
        });
        covered + 100.0 * near.count() as f64
    };
    let places = (0..=12).flat_map(|i| {
        let at = Point::new(ends[0].x + 8.0 + slack * f64::from(i) / 12.0, ends[0].y);
        [at - Vector::new(0.0, 8.0), at + Vector::new(0.0, 8.0 + 0.8 * size.y)]
    });
    places.min_by(|a, b| covered(*a).total_cmp(&covered(*b))).unwrap_or(ends[0])
}

/// The line as far as it stays below `top`, the point at which it reaches `top` included.
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

/// The axes: step k below, time above, phi on the left.
fn axes(frame: Bounds, last: f64, top: f64, period: f64) -> Result<Group, Box<dyn std::error::Error>> {
    let fine = |length: f64| (length * FINER).round() as u32;
    let size = frame.size() + Vector::new(AROUND[0] + AROUND[2], AROUND[1] + AROUND[3]);
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (fine(size.x), fine(size.y))).into_drawing_area();
        // plotters' sizes are 1.24 times those of SVG
        let font = |size: f64| (FONTS, size * FINER * 1.24).into_font();
        let line = BLACK.mix(0.9).stroke_width(fine(1.2));
        let mut chart = ChartBuilder::on(&root)
            .margin_right(fine(AROUND[2]))
            .y_label_area_size(fine(AROUND[0]))
            .top_x_label_area_size(fine(AROUND[1]))
            .x_label_area_size(fine(AROUND[3]))
            .build_cartesian_2d(0.0..last, 0.0..top)?
            .set_secondary_coord(0.0..last * period, 0.0..top);
        let across = (frame.size().x / 60.0) as usize;
        chart
            .configure_mesh()
            .disable_x_mesh()
            .disable_y_mesh()
            .axis_style(line)
            .set_all_tick_mark_size(fine(6.0))
            .label_style(font(SMALL))
            .axis_desc_style(font(LARGE))
            .x_labels(across)
            .y_labels(7)
            .x_label_formatter(&|k| px(*k))
            .y_label_formatter(&|phi| number(*phi, 1))
            .x_desc("step k")
            .y_desc("stubbornness \u{3c6}(k)")
            .draw()?;
        chart
            .configure_secondary_axes()
            .axis_style(line)
            .set_all_tick_mark_size(fine(6.0))
            .label_style(font(SMALL))
            .axis_desc_style(font(LARGE))
            .x_labels(across)
            .x_label_formatter(&|t| px(*t))
            .x_desc("time (s)")
            .draw()?;
        root.present()?;
    }
    let corner = frame.min - Vector::new(AROUND[0], AROUND[1]);
    let transform = format!("translate({} {}) scale({})", px(corner.x), px(corner.y), px(1.0 / FINER));
    Ok(Group::new().set("class", "axes").set("transform", transform).add(Blob::new(text)))
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
