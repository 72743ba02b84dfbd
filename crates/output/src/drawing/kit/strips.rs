//! Panels of labelled rows, stacked on one horizontal axis.

use super::{
    AXIS_ROOM, Axis, GAP, MARGIN, STRIPE, Sheet, Side, TITLE_ROOM, Text, border, guide, left_of_rows,
    lettered_title, rectangle, row_label, upright,
};
use cocarry::geometry::{Bounds, Point, Vector};
use svg::node::element::Group;

/// Panels of labelled rows, every second one shaded, with the axis below the last.
pub(in crate::drawing) struct Strips<'t> {
    /// For every panel its title and the labels of its rows; long ones are shortened.
    pub panels: Vec<(&'t str, Vec<&'t str>)>,
    /// Largest width of row labels, px.
    pub labels_width: f64,
    /// Height of a row, px.
    pub row_height: f64,
    /// Range of the axis.
    pub range: [f64; 2],
    /// A value with a line through all rows.
    pub guide: Option<f64>,
    /// What they are drawn on.
    pub sheet: Sheet,
}

impl Strips<'_> {
    /// The panels, and the y (px) at which they end. `marks` draws the row (panel, row) around a height (px).
    pub fn draw(&self, axis_title: &Text, marks: impl Fn([usize; 2], &Axis, f64) -> Group) -> (Group, f64) {
        let letters = self.sheet.letters;
        let labels = self.panels.iter().flat_map(|(_, labels)| labels.iter().copied());
        let left = left_of_rows(labels, self.labels_width);
        let mut drawn = Group::new();
        let mut top = 0.0;
        for (i, (title, labels)) in self.panels.iter().enumerate() {
            let min = Point::new(left, top + TITLE_ROOM);
            let bottom = min.y + labels.len() as f64 * self.row_height;
            let frame = Bounds { min, max: Point::new(self.sheet.width - MARGIN, bottom) };
            // keeps marks at the ends inside the frame
            let axis = Axis::linear(Side::Below, self.range, frame.grown(-GAP)).on(self.sheet);
            let title = lettered_title(letters, title, MARGIN, frame);
            let mut panel = Group::new().set("class", "panel").add(title);
            let strip = |row: usize| {
                let min = frame.min + Vector::new(0.0, row as f64 * self.row_height);
                Bounds { min, max: Point::new(frame.max.x, min.y + self.row_height) }
            };
            for row in (0..labels.len()).step_by(2) {
                panel = panel.add(rectangle(strip(row)).set("fill", STRIPE));
            }
            panel = panel.add(axis.grid(frame)).add(axis.marks(frame));
            if let Some(value) = self.guide {
                panel = panel.add(guide(upright(axis.at(value), frame)));
            }
            for (row, label) in labels.iter().enumerate() {
                let middle = nalgebra::center(&strip(row).min, &strip(row).max).y;
                let marks = marks([i, row], &axis, middle).set("class", "row");
                panel = panel.add(row_label(letters, label, frame.min.x, middle)).add(marks);
            }
            drawn = drawn.add(panel.add(border(frame)));
            top = frame.max.y;
            if i + 1 == self.panels.len() {
                drawn = drawn.add(axis.draw(frame, axis_title));
                top += AXIS_ROOM;
            }
        }
        (drawn, top)
    }
}
