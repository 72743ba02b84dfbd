//! The legend of a map: the colours of risk, and a table of the listed options.

use super::kit::{
    AXIS_ROOM, Align, Axis, FAINT, FAINT_WIDTH, GAP, Legend, LineStyle, RISK_COLOURS, Side, TEXT_SIZE, Text,
    border, level_sample, line_sample, number, px, rectangle, risk_colour,
};
use cocarry::geometry::{Bounds, Point, Vector};
use svg::node::element::{Definitions, Group, LinearGradient, Stop};

/// An option to be drawn.
pub(super) struct Route {
    pub index: usize,
    pub name: String,
    pub openings: Vec<String>,
    /// D_o (m), S_o and P_o.
    pub length: f64,
    pub risk: f64,
    pub probability: f64,
    /// Path, world frame, m; empty where there is no path.
    pub points: Vec<Point>,
}

/// Smallest width of the block, px.
pub(super) const MIN_WIDTH: f64 = 396.0;
/// Largest widths of the name of an option and of an opening, px.
const NAMES_WIDTH: [f64; 2] = [96.0, 140.0];

/// The block with its upper left corner at `at`, at most `width` px wide, and the y at which it ends.
/// `others` are not listed; `notes` are below.
pub(super) fn option_table(
    at: Point,
    width: f64,
    listed: &[Route],
    widths: &[f64],
    others: &[Route],
    notes: &[&str],
) -> (Group, f64) {
    let bare = table(listed, widths, others, |_| Vec::new());
    let room = width - bare.width() + Text::new("openings").width(TEXT_SIZE);
    let table = table(listed, widths, others, |route| wrapped(&route.openings, room));
    let (risks, bottom) = risk_bar(at, table.width().clamp(MIN_WIDTH, width.max(MIN_WIDTH)));
    let (table, mut bottom) = table.draw(Point::new(at.x, bottom), width);
    let mut group = Group::new().add(risks).add(table);
    for note in notes {
        bottom += 1.2 * TEXT_SIZE;
        let note = Text::new(*note);
        group = group.add(note.at(Point::new(at.x, bottom), TEXT_SIZE, Align::Left));
    }
    (group, bottom)
}

/// The table, with the lines of `openings` for each route.
fn table(
    listed: &[Route],
    widths: &[f64],
    others: &[Route],
    openings: impl Fn(&Route) -> Vec<Text>,
) -> Legend {
    let words = |text: &str| (Text::new(text), Align::Left);
    let letter =
        |letter: &str, unit: &str| (Text::default().italic(letter).sub("o").plain(unit), Align::Right);
    let heads =
        [words("option"), words("openings"), letter("D", " (m)"), letter("S", ""), letter("P", " (%)")];
    let percent = |share: f64| vec![Text::new(number(100.0 * share, 1))];
    let mut table = Legend::table(heads.to_vec());
    for (route, width) in listed.iter().zip(widths) {
        let length = if route.length.is_finite() { number(route.length, 2) } else { "no path".to_owned() };
        let name = vec![Text::new(&route.name).within(NAMES_WIDTH[0], TEXT_SIZE)];
        let risk = vec![Text::new(number(route.risk, 2))];
        let cells = vec![name, openings(route), vec![Text::new(length)], risk, percent(route.probability)];
        table = table.row(line_sample(LineStyle::of(route.index), *width), cells);
    }
    if others.is_empty() {
        return table;
    }
    let name = vec![Text::new(format!("{} more", others.len()))];
    let what = vec![Text::new("less probable")];
    let share = percent(others.iter().map(|r| r.probability).sum());
    table.row(level_sample(FAINT, FAINT_WIDTH), vec![name, what, Vec::new(), Vec::new(), share])
}

/// The openings of an option, wrapped into lines of at most `width` px.
fn wrapped(openings: &[String], width: f64) -> Vec<Text> {
    if openings.is_empty() {
        return vec![Text::new("none")];
    }
    let mut lines: Vec<Text> = vec![];
    for (i, name) in openings.iter().enumerate() {
        let comma = if i + 1 < openings.len() { "," } else { "" };
        let name = Text::opening(name).within(NAMES_WIDTH[1].min(width), TEXT_SIZE).plain(comma);
        match lines.last_mut() {
            Some(line) if line.width(TEXT_SIZE) + name.width(TEXT_SIZE) + 6.0 <= width => {
                *line = std::mem::take(line).plain(" ").then(name);
            }
            _ => lines.push(name),
        }
    }
    lines
}

/// The colours of risk on an axis, and the y at which it ends.
fn risk_bar(at: Point, width: f64) -> (Group, f64) {
    let bar = Bounds { min: at + Vector::new(GAP, 0.0), max: at + Vector::new(width - GAP, 14.0) };
    let last = RISK_COLOURS.len() - 1;
    let stops = (0..=last).fold(LinearGradient::new().set("id", "risk"), |gradient, i| {
        let risk = i as f64 / last as f64;
        gradient.add(Stop::new().set("offset", px(risk)).set("stop-color", risk_colour(risk)))
    });
    let title = Text::new("risk ").italic("S").plain(" = ").italic("d").sub("r").plain(" / ").italic("w");
    let group = Group::new()
        .add(Definitions::new().add(stops))
        .add(rectangle(bar).set("fill", "url(#risk)"))
        .add(border(bar))
        .add(Axis::linear(Side::Below, [0.0, 1.0], bar).draw(bar, &title.plain(" of an opening")));
    (group, bar.max.y + AXIS_ROOM)
}
