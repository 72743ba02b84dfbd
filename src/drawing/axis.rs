//! A range of numbers and a place on the picture in; an axis, even or in equal ratios, with its numbers and grid, out.

use super::style::{INK, LARGE, SMALL, number, px, stroke, ticks};
use super::text::{Align, Words};
use crate::geometry::{Bounds, Point, Vector};
use crate::math;
use svg::node::element::Group;

/// Where numbers lie along a side of a frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    /// The numbers at the ends.
    pub range: [f64; 2],
    /// Where the ends lie, px.
    pub ends: [f64; 2],
    /// Whether equal lengths are equal ratios.
    pub is_log: bool,
}

impl Scale {
    /// px; numbers beyond the ends lie at the ends.
    pub fn at(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        let value = value.clamp(low, high);
        let part = match self.is_log {
            true => math::ln(value / low) / math::ln(high / low),
            false => (value - low) / (high - low),
        };
        self.ends[0] + part * (self.ends[1] - self.ends[0])
    }

    /// Round numbers at least `apart` (px) from each other, as (value, label).
    fn ticks(&self, apart: f64) -> Vec<(f64, String)> {
        let [low, high] = self.range;
        if !self.is_log {
            let per_px = (high - low) / (self.ends[1] - self.ends[0]).abs();
            return ticks(low, high, apart * per_px);
        }
        let decades = (math::log10(low).floor() as i32)..=(math::log10(high).ceil() as i32);
        let round = |steps: &[f64]| -> Vec<f64> {
            let all =
                decades.clone().flat_map(|d| steps.iter().map(move |s| s * math::pow(10f64, f64::from(d))));
            all.filter(|v| *v >= low * (1.0 - 1e-9) && *v <= high * (1.0 + 1e-9)).collect()
        };
        let fits = |values: &[f64]| {
            values.windows(2).all(|pair| (self.at(pair[1]) - self.at(pair[0])).abs() >= apart)
        };
        let steps: [&[f64]; 5] = [
            &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0],
            &[1.0, 2.0, 3.0, 5.0, 7.0],
            &[1.0, 2.0, 5.0],
            &[1.0, 3.0],
            &[1.0],
        ];
        let values = steps.iter().map(|s| round(s)).find(|values| fits(values)).unwrap_or_default();
        let decimals = |v: f64| if v >= 10.0 { 0 } else { (1.0 - math::log10(v).floor()).max(0.0) as usize };
        values.into_iter().map(|v| (v, trimmed(v, decimals(v)))).collect()
    }

    /// The grid of an axis below `frame`, behind everything else.
    pub fn grid_across(&self, frame: Bounds) -> Group {
        self.ticks(58.0).into_iter().fold(Group::new().set("class", "grid"), |group, (value, _)| {
            let x = self.at(value);
            group.add(stroke(&[Point::new(x, frame.min.y), Point::new(x, frame.max.y)], "#d9d9d9", 1.0))
        })
    }

    /// The numbers below `frame`, and what they are.
    pub fn below(&self, frame: Bounds, title: Words) -> Group {
        let mut group = Group::new().set("class", "axis");
        for (value, label) in self.ticks(58.0) {
            let foot = Point::new(self.at(value), frame.max.y);
            let words = Words::new().plain(label);
            group = group.add(stroke(&[foot, foot + Vector::new(0.0, 6.0)], INK, 1.2)).add(words.at(
                foot + Vector::new(0.0, 23.0),
                SMALL,
                Align::Middle,
            ));
        }
        let middle = Point::new((frame.min.x + frame.max.x) / 2.0, frame.max.y + 47.0);
        group.add(title.at(middle, LARGE, Align::Middle))
    }

    /// The numbers on the left of `frame`, and what they are.
    pub fn beside(&self, frame: Bounds, title: Words) -> Group {
        let mut group = Group::new().set("class", "axis");
        for (value, label) in self.ticks(34.0) {
            let foot = Point::new(frame.min.x, self.at(value));
            let words = Words::new().plain(label);
            group = group.add(stroke(&[foot - Vector::new(6.0, 0.0), foot], INK, 1.2)).add(words.at(
                foot + Vector::new(-10.0, 0.35 * SMALL),
                SMALL,
                Align::Right,
            ));
        }
        let at = Point::new(frame.min.x - 52.0, (frame.min.y + frame.max.y) / 2.0);
        let turned = Group::new().set("transform", format!("rotate(-90 {} {})", px(at.x), px(at.y)));
        group.add(turned.add(title.at(at, LARGE, Align::Middle)))
    }
}

/// Without zeros at the end.
fn trimmed(value: f64, decimals: usize) -> String {
    let text = number(value, decimals);
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_in_ratios_has_round_numbers_inside() {
        let labels = |range, width| {
            let scale = Scale { range, ends: [0.0, width], is_log: true };
            scale.ticks(58.0).into_iter().map(|t| t.1).collect::<Vec<_>>()
        };
        assert_eq!(labels([0.1, 1000.0], 400.0), ["0.1", "1", "10", "100", "1000"]);
        assert_eq!(labels([4.0, 20.0], 400.0), ["5", "7", "10", "20"]);
        assert_eq!(labels([4.0, 20.0], 900.0), ["4", "5", "7", "10", "15", "20"]);
    }

    #[test]
    fn closed_form_numbers_lie_where_they_belong() {
        let scale = Scale { range: [1.0, 100.0], ends: [0.0, 10.0], is_log: true };
        assert_eq!([1.0, 10.0, 100.0, 1e9].map(|v| scale.at(v).round()), [0.0, 5.0, 10.0, 10.0]);
    }
}
