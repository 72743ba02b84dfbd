//! Axes, linear or logarithmic, with round tick values whose labels do not overlap, and frames with two axes.

use super::text::number;
use super::{
    AXIS_ROOM, Align, FRAME_WIDTH, GAP, GRID, INK, Letters, MARGIN, Sheet, TEXT_SIZE, TITLE_SIZE, Text,
    border, level, px, stroke, upright,
};
use cocarry::geometry::{Bounds, Point, Vector};
use cocarry::math;
use svg::node::element::Group;

/// Length of a tick, px.
const TICK: f64 = 6.0;
/// Width (px) above which the numbers of a vertical axis are drawn smaller.
const NUMBERS_WIDTH: f64 = 38.0;
/// Smallest distance of two ticks, px.
const TICK_DISTANCE: f64 = 46.0;

/// The side of its frame on which an axis lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in super::super) enum Side {
    Below,
    Above,
    Left,
}

/// The mapping of values to positions along a side of a frame.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Axis {
    side: Side,
    /// Values at the ends.
    range: [f64; 2],
    /// Positions of the ends, px.
    ends: [f64; 2],
    /// Whether the axis is logarithmic.
    is_log: bool,
    sheet: Sheet,
}

impl Axis {
    /// A linear axis along a side of a frame.
    pub fn linear(side: Side, range: [f64; 2], frame: Bounds) -> Self {
        let ends = match side {
            Side::Left => [frame.max.y, frame.min.y],
            _ => [frame.min.x, frame.max.x],
        };
        Self { side, range, ends, is_log: false, sheet: Sheet::default() }
    }

    /// A logarithmic axis; the range must be positive.
    pub fn log(side: Side, range: [f64; 2], frame: Bounds) -> Self {
        Self { is_log: true, ..Self::linear(side, range, frame) }
    }

    /// The same axis in these letters.
    pub fn with_letters(self, letters: Letters) -> Self {
        self.on(Sheet { letters, ..self.sheet })
    }

    /// The same axis on a sheet.
    pub fn on(self, sheet: Sheet) -> Self {
        Self { sheet, ..self }
    }

    /// The position of a value, px; values beyond the ends are clamped.
    pub fn at(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        let value = value.clamp(low, high);
        let part = match self.is_log {
            true => math::ln(value / low) / math::ln(high / low),
            false => (value - low) / (high - low),
        };
        self.ends[0] + part * (self.ends[1] - self.ends[0])
    }

    /// Round values with their labels, which do not overlap.
    fn ticks(&self) -> Vec<(f64, String)> {
        let all = |apart: f64| match self.is_log {
            true => self.log_ticks(apart),
            false => self.linear_ticks(apart),
        };
        let ticks = all(TICK_DISTANCE);
        let needed = if self.side == Side::Left { 0.0 } else { widest(&ticks) + 1.2 * GAP };
        if needed > TICK_DISTANCE { all(needed) } else { ticks }
    }

    fn linear_ticks(&self, apart: f64) -> Vec<(f64, String)> {
        let [low, high] = self.range;
        let least = apart * (high - low) / (self.ends[1] - self.ends[0]).abs();
        let power = math::pow(10f64, math::log10(least).floor());
        let step =
            [1.0, 2.0, 5.0].map(|m| m * power).into_iter().find(|s| *s >= least).unwrap_or(10.0 * power);
        let decimals = (-(math::log10(step) + 1e-9).floor()).max(0.0) as usize;
        let (first, last) = ((low / step - 1e-9).ceil() as i64, (high / step + 1e-9).floor() as i64);
        (first..=last).map(|i| i as f64 * step).map(|v| (v, number(v, decimals))).collect()
    }

    fn log_ticks(&self, apart: f64) -> Vec<(f64, String)> {
        const STEPS: [&[f64]; 5] = [
            &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0],
            &[1.0, 2.0, 3.0, 5.0, 7.0],
            &[1.0, 2.0, 5.0],
            &[1.0, 3.0],
            &[1.0],
        ];
        let [low, high] = self.range;
        let decades = (math::log10(low).floor() as i32)..=(math::log10(high).ceil() as i32);
        let round = |steps: &[f64]| -> Vec<f64> {
            let all =
                decades.clone().flat_map(|d| steps.iter().map(move |s| s * math::pow(10f64, f64::from(d))));
            all.filter(|v| *v >= low * (1.0 - 1e-9) && *v <= high * (1.0 + 1e-9)).collect()
        };
        let fits = |values: &[f64]| {
            values.windows(2).all(|pair| (self.at(pair[1]) - self.at(pair[0])).abs() >= apart)
        };
        let values = STEPS.iter().map(|s| round(s)).find(|values| fits(values)).unwrap_or_default();
        let label = |v: f64| {
            let text = number(v, (1.0 - math::log10(v).floor()).max(0.0) as usize);
            match text.contains('.') {
                true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
                false => text,
            }
        };
        values.into_iter().map(|v| (v, label(v))).collect()
    }

    /// Grid lines across `frame` at the ticks, to be drawn first.
    pub fn grid(&self, frame: Bounds) -> Group {
        self.ticks().into_iter().fold(Group::new().set("class", "grid"), |group, (value, _)| {
            let line = if self.side == Side::Left { level } else { upright };
            group.add(stroke(&line(self.at(value), frame), GRID, 1.0))
        })
    }

    /// The ticks at `frame`, without numbers.
    pub fn marks(&self, frame: Bounds) -> Group {
        self.ticks().into_iter().fold(Group::new().set("class", "ticks"), |group, (value, _)| {
            let (foot, out) = self.foot(value, frame);
            group.add(stroke(&[foot, foot + TICK * out], INK, FRAME_WIDTH))
        })
    }

    /// The inner end of a value's tick, and the direction away from the frame.
    fn foot(&self, value: f64, frame: Bounds) -> (Point, Vector) {
        let at = self.at(value);
        match self.side {
            Side::Below => (Point::new(at, frame.max.y), Vector::new(0.0, 1.0)),
            Side::Above => (Point::new(at, frame.min.y), Vector::new(0.0, -1.0)),
            Side::Left => (Point::new(frame.min.x, at), Vector::new(-1.0, 0.0)),
        }
    }

    /// The ticks with their numbers at `frame`, and the title.
    pub fn draw(&self, frame: Bounds, title: &Text) -> Group {
        let ticks = self.ticks();
        let widest = widest(&ticks);
        // centred on the frame, but inside the picture; frames beyond the usual width are in wider ones
        let right = frame.max.x.max(self.sheet.width - MARGIN);
        let half = title.width(TITLE_SIZE) / 2.0;
        let middle = nalgebra::center(&frame.min, &frame.max);
        let x = middle.x.min(right - half).max(MARGIN + half);
        let size = TEXT_SIZE * if self.side == Side::Left { (NUMBERS_WIDTH / widest).min(1.0) } else { 1.0 };
        let (offset, align, at, angle) = match self.side {
            Side::Below => ([0.0, 23.0], Align::Middle, Point::new(x, frame.max.y + AXIS_ROOM - GAP), 0),
            Side::Above => ([0.0, -12.0], Align::Middle, Point::new(x, frame.min.y - 38.0), 0),
            Side::Left => {
                let at = Point::new(frame.min.x - 2.2 * GAP - widest.min(NUMBERS_WIDTH), middle.y);
                ([-GAP, 0.35 * size], Align::Right, at, -90)
            }
        };
        let group = ticks.into_iter().fold(Group::new().set("class", "axis"), |group, (value, label)| {
            let place = self.foot(value, frame).0 + Vector::from(offset);
            group.add(Text::new(label).lettered(self.sheet.letters, place, size, align))
        });
        let turned = Group::new().set("transform", format!("rotate({angle} {} {})", px(at.x), px(at.y)));
        group.add(self.marks(frame)).add(turned.add(title.lettered(
            self.sheet.letters,
            at,
            TITLE_SIZE,
            Align::Middle,
        )))
    }
}

/// Width of the widest label, px.
fn widest(ticks: &[(f64, String)]) -> f64 {
    ticks.iter().map(|(_, label)| Text::new(label).width(TEXT_SIZE)).fold(0.0, f64::max)
}

/// A frame with an axis below and one on the left.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Plot {
    pub frame: Bounds,
    pub x: Axis,
    pub y: Axis,
}

impl Plot {
    /// Linear axes with these ranges.
    pub fn linear(frame: Bounds, [x, y]: [[f64; 2]; 2]) -> Self {
        Self { frame, x: Axis::linear(Side::Below, x, frame), y: Axis::linear(Side::Left, y, frame) }
    }

    /// The same plot in these letters.
    pub fn with_letters(self, letters: Letters) -> Self {
        Self { x: self.x.with_letters(letters), y: self.y.with_letters(letters), ..self }
    }

    /// The same plot on a sheet.
    pub fn on(self, sheet: Sheet) -> Self {
        Self { x: self.x.on(sheet), y: self.y.on(sheet), ..self }
    }

    pub fn at(&self, x: f64, y: f64) -> Point {
        Point::new(self.x.at(x), self.y.at(y))
    }

    /// The border, ticks, numbers and titles.
    pub fn axes(&self, x_title: &Text, y_title: &Text) -> Group {
        let axes = [self.x.draw(self.frame, x_title), self.y.draw(self.frame, y_title)];
        axes.into_iter().fold(Group::new().set("class", "axes").add(border(self.frame)), Group::add)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(width: f64) -> Bounds {
        Bounds { min: Point::origin(), max: Point::new(width, 200.0) }
    }

    fn labels(axis: Axis) -> Vec<String> {
        axis.ticks().into_iter().map(|t| t.1).collect()
    }

    #[test]
    fn ticks_are_round_inside_and_apart() {
        let below = |range, width| labels(Axis::linear(Side::Below, range, frame(width)));
        assert_eq!(below([-4.2, 4.9], 330.0), ["\u{2212}4", "\u{2212}2", "0", "2", "4"]);
        assert_eq!(below([0.0, 0.1], 170.0), ["0.00", "0.05", "0.10"]);
        // wide numbers need more distance
        assert_eq!(below([0.0, 1e6], 300.0), ["0", "500000", "1000000"]);
        assert_eq!(labels(Axis::linear(Side::Left, [0.0, 1.0], frame(9.0))), ["0.0", "0.5", "1.0"]);
    }

    #[test]
    fn an_axis_in_ratios_has_round_numbers_inside() {
        let labels = |range, width| labels(Axis::log(Side::Below, range, frame(width)));
        assert_eq!(labels([0.1, 1000.0], 400.0), ["0.1", "1", "10", "100", "1000"]);
        assert_eq!(labels([4.0, 20.0], 330.0), ["5", "7", "10", "20"]);
        assert_eq!(labels([4.0, 20.0], 900.0), ["4", "5", "7", "10", "15", "20"]);
    }

    #[test]
    fn closed_form_numbers_lie_where_they_belong() {
        let axis = Axis::log(Side::Below, [1.0, 100.0], frame(10.0));
        assert_eq!([1.0, 10.0, 100.0, 1e9].map(|v| axis.at(v).round()), [0.0, 5.0, 10.0, 10.0]);
    }
}
