//! The listed options of a map in; the block that explains the map, colour bar of risk and table of options, out.

use super::scene::rectangle;
use super::style::{INK, LARGE, Look, SMALL, number, px, risk_colour, stroke, widths_by_probability};
use super::text::{Align, Words, shorten};
use crate::geometry::{Bounds, Point, Vector};
use svg::node::element::{Definitions, Group, LinearGradient, Stop};

/// The least width (px) that the block fits into.
pub(super) const LEAST_WIDTH: f64 = 396.0;

/// Height of a line of the table, px.
const LINE: f64 = 24.0;
/// Length of a sample of a line, px.
const SAMPLE: f64 = 54.0;
/// Widths of the columns of numbers, from the right: P, S, D; px.
const NUMBERS: [f64; 3] = [62.0, 50.0, 67.0];

/// An option in the table.
pub(super) struct Row {
    pub name: String,
    pub openings: Vec<String>,
    /// D_o, m.
    pub length: f64,
    /// S_o.
    pub risk: f64,
    /// P_o.
    pub probability: f64,
}

/// The block with its upper left corner at `at`, and the y at which it ends; `left_out` options, of the probability given, are not listed.
pub(super) fn legend(
    at: Point,
    width: f64,
    rows: &[Row],
    left_out: usize,
    probability_left_out: f64,
    is_cut: bool,
) -> (Group, f64) {
    let names = at.x + SAMPLE + 12.0;
    let name_width = rows.iter().map(|r| name_of(r).width(SMALL)).fold(56.0, f64::max);
    let openings = names + name_width + 14.0;
    let most = at.x + width - NUMBERS.iter().sum::<f64>() - openings;
    let needed = rows.iter().flat_map(|r| wrapped(&r.openings, most)).map(|w| w.width(SMALL));
    let openings_width = needed.fold(most.min(150.0), f64::max).min(most);
    let right = openings + openings_width + NUMBERS.iter().sum::<f64>();
    let columns = [right, right - NUMBERS[0], right - NUMBERS[0] - NUMBERS[1]];
    let (bar, bottom) = risk_bar(at, right - at.x);
    let mut group = Group::new().set("class", "legend").add(bar);
    let mut y = bottom + LINE + 8.0;

    let put = |words: Words, x: f64, y: f64, align| words.at(Point::new(x, y), SMALL, align);
    let head = |letter: &str, unit: &str| Words::new().italic(letter).sub("o").plain(unit);
    group = group
        .add(put(Words::new().plain("option"), names, y, Align::Left))
        .add(put(Words::new().plain("openings"), openings, y, Align::Left))
        .add(put(head("P", " (%)"), columns[0], y, Align::Right))
        .add(put(head("S", ""), columns[1], y, Align::Right))
        .add(put(head("D", " (m)"), columns[2], y, Align::Right))
        .add(stroke(&[Point::new(at.x, y + 8.0), Point::new(right, y + 8.0)], INK, 0.8));
    y += 8.0;

    let sample = |y: f64| [Point::new(at.x, y - 6.0), Point::new(at.x + SAMPLE, y - 6.0)];
    let widths = widths_by_probability(rows.iter().map(|r| r.probability));
    for (i, row) in rows.iter().enumerate() {
        y += LINE;
        let length = if row.length.is_finite() { number(row.length, 2) } else { "no way".to_owned() };
        group = group
            .add(Look::of(i).draw(&sample(y), widths[i]))
            .add(put(name_of(row), names, y, Align::Left))
            .add(put(Words::new().plain(number(100.0 * row.probability, 1)), columns[0], y, Align::Right))
            .add(put(Words::new().plain(number(row.risk, 2)), columns[1], y, Align::Right))
            .add(put(Words::new().plain(length), columns[2], y, Align::Right));
        for (n, line) in wrapped(&row.openings, openings_width).into_iter().enumerate() {
            y += if n > 0 { LINE * 0.85 } else { 0.0 };
            group = group.add(put(line, openings, y, Align::Left));
        }
    }
    if left_out > 0 {
        y += LINE;
        let share = number(100.0 * probability_left_out, 1);
        let what =
            if left_out == 1 { "1 less probable".to_owned() } else { format!("{left_out} less probable") };
        group = group
            .add(stroke(&sample(y), Look::FAINT.colour, 1.1))
            .add(put(Words::new().plain(what), names, y, Align::Left))
            .add(put(Words::new().plain(share), columns[0], y, Align::Right));
    }
    if is_cut {
        y += LINE;
        let note = Words::new().plain("more options exist than were enumerated");
        group = group.add(put(note, at.x, y, Align::Left));
    }
    (group, y + 8.0)
}

fn name_of(row: &Row) -> Words {
    Words::new().plain(shorten(&row.name, 10))
}

/// The openings of an option, in lines of at most `width` px.
fn wrapped(openings: &[String], width: f64) -> Vec<Words> {
    if openings.is_empty() {
        return vec![Words::new().plain("none")];
    }
    let mut lines: Vec<Words> = vec![];
    for (i, name) in openings.iter().enumerate() {
        let comma = if i + 1 < openings.len() { "," } else { "" };
        let word = Words::new().opening(name, 14).plain(comma);
        match lines.last_mut() {
            Some(line) if line.width(SMALL) + word.width(SMALL) + 6.0 <= width => {
                *line = std::mem::take(line).plain(" ").then(word);
            }
            _ => lines.push(word),
        }
    }
    lines
}

/// The colours of risk, and the y at which they end.
fn risk_bar(at: Point, width: f64) -> (Group, f64) {
    let title =
        Words::new().plain("risk ").italic("S").plain(" = ").italic("d").sub("r").plain(" / ").italic("w");
    let title = title.plain(" of an opening");
    let (left, top) = (at.x + 6.0, at.y + 26.0);
    let bar = Bounds { min: Point::new(left, top), max: Point::new(left + width - 16.0, top + 14.0) };
    let stops = (0..=20).fold(LinearGradient::new().set("id", "risk"), |gradient, i| {
        let risk = f64::from(i) / 20.0;
        gradient.add(Stop::new().set("offset", px(risk)).set("stop-color", risk_colour(risk)))
    });
    let mut group = Group::new()
        .add(Definitions::new().add(stops))
        .add(title.at(Point::new(left, at.y + 15.0), LARGE, Align::Left))
        .add(rectangle(bar).set("fill", "url(#risk)").set("stroke", INK).set("stroke-width", 0.8));
    for i in 0..=5 {
        let risk = f64::from(i) / 5.0;
        let foot = Point::new(bar.min.x + risk * bar.size().x, bar.max.y);
        let label = Words::new().plain(number(risk, 1));
        group = group.add(stroke(&[foot, foot + Vector::new(0.0, 4.0)], INK, 1.0)).add(label.at(
            foot + Vector::new(0.0, 20.0),
            SMALL,
            Align::Middle,
        ));
    }
    (group, bar.max.y + 22.0)
}
