//! The chart kit under every picture: text with measured widths, one palette, axes, marks, legends and shared
//! sizes.
//!
//! The kit is the project's own and writes through the `svg` crate. Most pictures here are maps, hatched
//! regions and strips of marks, which no charting crate draws, so a charting crate would add a second axis
//! engine. The candidate, plotters, also guesses SVG text widths without a system font library, rounds to
//! whole pixels, and has no subscripts and no legend outside the frame.

mod axis;
mod clutter;
mod legend;
mod letters;
mod marks;
mod palette;
mod shapes;
mod sheet;
mod strips;
mod text;

pub(super) use crate::palette::RISK_COLOURS;
pub(super) use axis::{Axis, Plot, Side};
pub(super) use clutter::{Clutter, around, nearest, overlap};
pub(super) use legend::{Legend, SAMPLE, level_sample, line_sample};
pub use letters::Letters;
pub(super) use marks::{Shape, mark, mean_bar, place};
pub use palette::dark_rules;
pub(super) use palette::{
    BAND, FAINT, FAINT_WIDTH, GRID, INK, LineStyle, OBSTACLE, OBSTACLE_EDGE, PAPER, STRIPE, risk_colour,
    width_by_rank, widths_by_probability,
};
pub(super) use shapes::{area, disc, path_data, polygon, px, rectangle, rounded, stroke};
pub use sheet::Sheet;
pub(super) use strips::Strips;
pub(super) use text::{Align, Text, number, wrapped};

use super::WIDTH;
use cocarry::geometry::{Bounds, Point, Vector};
use svg::Document;
use svg::node::element::{Element, Group, Path, Rectangle};

/// Font sizes, px: of titles, and of all other text.
pub(super) const TITLE_SIZE: f64 = 19.0;
pub(super) const TEXT_SIZE: f64 = 16.5;

/// Room at the sides of a picture, px.
pub(super) const MARGIN: f64 = 20.0;
/// Room left of a frame for the numbers and the title of its vertical axis, px.
pub(super) const LEFT_ROOM: f64 = 78.0;
/// Room above a frame for its title, and below it for the numbers and the title of its horizontal axis, px.
pub(super) const TITLE_ROOM: f64 = 38.0;
pub(super) const AXIS_ROOM: f64 = 58.0;
/// Distance between neighbouring elements, px.
pub(super) const GAP: f64 = 10.0;

/// Width of frames and ticks, and of lines that mark a value, px.
const FRAME_WIDTH: f64 = 1.2;
const GUIDE_WIDTH: f64 = 1.6;

/// An empty white picture.
pub(super) fn document(height: f64) -> Document {
    document_of(WIDTH, height)
}

/// An empty white picture on a sheet.
pub(super) fn document_on(sheet: Sheet, height: f64) -> Document {
    let (shown, unit) = sheet.shown;
    let size = |length: f64| match unit {
        "" => px(length * shown / sheet.width),
        _ => format!("{:.3}{unit}", length * shown / sheet.width),
    };
    document_of(sheet.width, height).set("width", size(sheet.width)).set("height", size(height))
}

/// An empty white picture of another width.
pub(super) fn document_of(width: f64, height: f64) -> Document {
    let paper = Bounds { min: Point::origin(), max: Point::new(width, height) };
    Document::new()
        .set("width", px(width))
        .set("height", px(height))
        .set("viewBox", format!("0 0 {} {}", px(width), px(height)))
        .set("font-family", text::FONTS)
        .add(rectangle(paper).set("fill", PAPER))
}

/// A picture of panels, two in a row. `draw` receives the frame and returns the y at which the panel ends.
pub(super) fn in_two_columns<P>(
    panels: &[P],
    frame_height: f64,
    draw: impl Fn(&P, Bounds) -> (Group, f64),
) -> String {
    const PITCH: f64 = WIDTH / 2.0;
    let mut drawn = Vec::new();
    let mut top: f64 = 0.0;
    for row in panels.chunks(2) {
        let mut lowest = top;
        for (column, panel) in row.iter().enumerate() {
            let min = Point::new(LEFT_ROOM + column as f64 * PITCH, top + TITLE_ROOM);
            let size = Vector::new(PITCH - LEFT_ROOM - MARGIN, frame_height);
            let (group, bottom) = draw(panel, Bounds { min, max: min + size });
            drawn.push(group.set("class", "panel"));
            lowest = lowest.max(bottom);
        }
        top = lowest + GAP;
    }
    drawn.into_iter().fold(document(top), Document::add).to_string()
}

/// A bold title above a frame, at most from `left` to the frame's right side.
pub(super) fn frame_title(text: &str, left: f64, frame: Bounds) -> Element {
    lettered_title(Letters::Text, text, left, frame)
}

/// The same in these letters.
pub(super) fn lettered_title(letters: Letters, text: &str, left: f64, frame: Bounds) -> Element {
    let at = Point::new(left, frame.min.y - 1.2 * GAP);
    let title = Text::new(text).bold().within(frame.max.x - left, TITLE_SIZE);
    title.lettered(letters, at, TITLE_SIZE, Align::Left)
}

/// The left side of a frame whose rows have these labels, of which each is at most `most` px wide.
pub(super) fn left_of_rows<'a>(labels: impl Iterator<Item = &'a str>, most: f64) -> f64 {
    let widest = labels.map(|label| Text::new(label).width(TEXT_SIZE)).fold(0.0, f64::max);
    (MARGIN + GAP + widest.min(most)).max(LEFT_ROOM)
}

/// A row's label to the left of the frame that begins at `left`, shortened to fit the picture.
pub(super) fn row_label(letters: Letters, text: &str, left: f64, middle: f64) -> Element {
    let at = Point::new(left - GAP, middle + 0.35 * TEXT_SIZE);
    Text::new(text).within(left - MARGIN - GAP, TEXT_SIZE).lettered(letters, at, TEXT_SIZE, Align::Right)
}

/// Sentences below a picture from `top` (px) on, one per line, in a font size that fits the width; and the y
/// at which they end.
pub(super) fn notes<'a>(sentences: impl IntoIterator<Item = &'a str>, top: f64) -> (Group, f64) {
    let mut bottom = top;
    let mut group = Group::new();
    for sentence in sentences {
        let text = Text::new(sentence.trim());
        let size = (0.85 * TEXT_SIZE).min(TEXT_SIZE * (WIDTH - 2.0 * MARGIN) / text.width(TEXT_SIZE));
        bottom += 22.0;
        group = group.add(text.at(Point::new(MARGIN, bottom - 6.0), size, Align::Left));
    }
    (group, bottom)
}

/// The outline of a frame.
pub(super) fn border(frame: Bounds) -> Rectangle {
    rectangle(frame).set("fill", "none").set("stroke", INK).set("stroke-width", FRAME_WIDTH)
}

/// A dashed line that marks a value.
pub(super) fn guide(ends: [Point; 2]) -> Path {
    stroke(&ends, INK, GUIDE_WIDTH).set("stroke-dasharray", "7 5")
}

/// The ends of a vertical line from the top to the bottom of a frame.
pub(super) fn upright(x: f64, frame: Bounds) -> [Point; 2] {
    [Point::new(x, frame.min.y), Point::new(x, frame.max.y)]
}

/// The ends of a horizontal line from the left to the right of a frame.
pub(super) fn level(y: f64, frame: Bounds) -> [Point; 2] {
    [Point::new(frame.min.x, y), Point::new(frame.max.x, y)]
}
