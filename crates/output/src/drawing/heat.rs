//! The figure of a quantity over the (alpha, gamma) plane, as a map of coloured cells.

use super::kit::{
    AXIS_ROOM, Align, Axis, FAINT, GAP, LEFT_ROOM, MARGIN, PAPER, Plot, Sheet, Side, TEXT_SIZE, TITLE_ROOM,
    Text, border, disc, document_on, lettered_title, rectangle, risk_colour,
};
use super::{WIDTH, not_drawable, nothing};
use cocarry::Error;
use cocarry::geometry::{Bounds, Point, Vector};
use svg::node::element::Group;

/// The map of one combination.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeatPanel {
    /// Title above the panel, and a line below it; long ones are shortened.
    pub title: String,
    /// See `title`.
    pub subtitle: String,
    /// The values of the cells: for every interval of gamma, from the least, those for the intervals of
    /// alpha, from the least. `None` where there is no value.
    pub values: Vec<Vec<Option<f64>>>,
}

/// Height of a panel's frame, px.
const HEIGHT: f64 = 250.0;
/// Room for the second line of a title, px.
const SUBTITLE_ROOM: f64 = 22.0;
/// Height of the scale of colours, px, and the number of its steps.
const SCALE_HEIGHT: f64 = 16.0;
const SCALE_STEPS: usize = 60;

/// Maps of a quantity over the plane of alpha and gamma, in `ranges`, two in a row where the sheet is wide enough,
/// and their common scale of colours, light to dark. A cell without a value is white with a dot.
///
/// # Errors
/// There is no value, or one that is not finite.
pub fn heat_maps(
    panels: &[HeatPanel],
    ranges: [[f64; 2]; 2],
    title: &str,
    sheet: Sheet,
) -> Result<String, Error> {
    let values = || panels.iter().flat_map(|panel| panel.values.iter().flatten()).copied().flatten();
    if let Some(value) = values().chain(ranges.into_iter().flatten()).find(|value| !value.is_finite()) {
        return Err(not_drawable("a cell", value));
    }
    let (least, most) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    if least > most {
        return Err(nothing());
    }
    // equal values have a scale, too
    let scale = if most > least { [least, most] } else { [least - 0.5, most + 0.5] };
    let share = |value: f64| (value - scale[0]) / (scale[1] - scale[0]);
    let mut drawn = Group::new();
    let mut top = 0.0;
    let across = if sheet.width < WIDTH { 1 } else { 2 };
    for row in panels.chunks(across) {
        for (column, panel) in row.iter().enumerate() {
            let pitch = sheet.width / across as f64;
            let min = Point::new(LEFT_ROOM + column as f64 * pitch, top + TITLE_ROOM + SUBTITLE_ROOM);
            let size = Vector::new(pitch - LEFT_ROOM - MARGIN, HEIGHT);
            drawn = drawn.add(draw(panel, ranges, Bounds { min, max: min + size }, sheet, share));
        }
        top += TITLE_ROOM + SUBTITLE_ROOM + HEIGHT + AXIS_ROOM + GAP;
    }
    let min = Point::new(LEFT_ROOM, top + GAP);
    let bar = Bounds { min, max: Point::new(sheet.width - LEFT_ROOM, min.y + SCALE_HEIGHT) };
    for step in 0..SCALE_STEPS {
        let width = bar.size().x / SCALE_STEPS as f64;
        let from = bar.min + Vector::new(step as f64 * width, 0.0);
        // over the next one, so that no gap is seen
        let end = Point::new((from.x + width + 0.5).min(bar.max.x), bar.max.y);
        let colour = risk_colour((step as f64 + 0.5) / SCALE_STEPS as f64);
        drawn = drawn.add(rectangle(Bounds { min: from, max: end }).set("fill", colour));
    }
    let axis = Axis::linear(Side::Below, scale, bar).on(sheet);
    drawn = drawn.add(border(bar)).add(axis.draw(bar, &Text::new(title)));
    Ok(document_on(sheet, bar.max.y + AXIS_ROOM + GAP).add(drawn).to_string())
}

/// A panel with its title and axes.
fn draw(
    panel: &HeatPanel,
    ranges: [[f64; 2]; 2],
    frame: Bounds,
    sheet: Sheet,
    share: impl Fn(f64) -> f64,
) -> Group {
    let plot = Plot::linear(frame, ranges).on(sheet);
    let left = frame.min.x - LEFT_ROOM + MARGIN;
    let above = Bounds { min: frame.min - Vector::new(0.0, SUBTITLE_ROOM), ..frame };
    let subtitle = Text::new(&panel.subtitle).within(frame.max.x - left, TEXT_SIZE);
    let mut group =
        Group::new().set("class", "panel").add(lettered_title(sheet.letters, &panel.title, left, above));
    group = group.add(subtitle.lettered(
        sheet.letters,
        Point::new(left, frame.min.y - GAP),
        TEXT_SIZE,
        Align::Left,
    ));
    let height = frame.size().y / panel.values.len().max(1) as f64;
    for (row, values) in panel.values.iter().enumerate() {
        let width = frame.size().x / values.len().max(1) as f64;
        for (column, value) in values.iter().enumerate() {
            let min =
                Point::new(frame.min.x + column as f64 * width, frame.max.y - (row + 1) as f64 * height);
            let cell = Bounds { min, max: min + Vector::new(width, height) };
            group = match value {
                Some(value) => {
                    let colour = risk_colour(share(*value));
                    let drawn = rectangle(cell).set("fill", colour.as_str()).set("stroke", colour);
                    group.add(drawn.set("stroke-width", 0.5).set("class", "cell"))
                }
                None => {
                    let middle = nalgebra::center(&cell.min, &cell.max);
                    group.add(rectangle(cell).set("fill", PAPER)).add(disc(middle, 1.2).set("fill", FAINT))
                }
            };
        }
    }
    let title = |what: &str, letter: &str| Text::new(what).italic(letter);
    group.add(plot.axes(&title("distance perception ", "\u{3b1}"), &title("risk perception ", "\u{3b3}")))
}

#[cfg(test)]
mod tests {
    use super::super::tests::{NOTHING, error};
    use super::*;
    use crate::drawing::tests::checked;

    #[test]
    fn every_value_has_a_cell() {
        let panel = HeatPanel {
            title: "mutual".to_owned(),
            subtitle: "eta 5".to_owned(),
            values: vec![vec![Some(1.0), None, Some(3.0)], vec![Some(2.0), Some(2.5), Some(1.5)]],
        };
        let svg = checked(|| {
            heat_maps(&[panel.clone(), panel.clone()], [[0.5, 1.0], [0.5, 1.1]], "J (m)", Sheet::default())
        });
        assert_eq!(svg.matches("class=\"cell\"").count(), 10);
        // the least is light, the largest dark
        for share in [0.0, 1.0] {
            assert!(svg.contains(&format!("fill=\"{}\"", risk_colour(share))));
        }
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        let ranges = [[0.0, 1.0]; 2];
        let panel = |value| HeatPanel { values: vec![vec![value]], ..HeatPanel::default() };
        assert_eq!(error(heat_maps(&[], ranges, "", Sheet::default())), NOTHING);
        assert_eq!(error(heat_maps(&[panel(None)], ranges, "", Sheet::default())), NOTHING);
        assert!(
            error(heat_maps(&[panel(Some(f64::NAN))], ranges, "", Sheet::default()))
                .ends_with(": NaN cannot be drawn")
        );
    }
}
