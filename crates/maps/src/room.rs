//! The obstacles of a world file from outlines.

use cocarry::geometry::Point;
use std::fmt::Write;

/// The largest number of corners of all outlines.
pub(crate) const MAX_CORNERS: usize = 20_000;

/// Obstacles as the tables of a world file.
#[derive(Default)]
pub(crate) struct Obstacles {
    pub text: String,
}

impl Obstacles {
    /// Adds an outline. `shape` is `room` where the ring is around the floor, and `polygon` where it is around
    /// what stands on it.
    pub fn add(&mut self, name: &str, shape: &str, ring: &[Point], holes: &[Vec<Point>], height: f64) {
        let name = toml::Value::String(name.to_owned());
        let rings: Vec<String> = holes.iter().map(|hole| corners(hole)).collect();
        let holes = match rings.is_empty() {
            true => String::new(),
            false => format!("holes_m = [{}]\n", rings.join(", ")),
        };
        let text = &mut self.text;
        // writing into a string cannot fail
        let _ = writeln!(
            text,
            "\n[[obstacle]]\nname = {name}\nshape = \"{shape}\"\nheight_m = {height}\nvertices_m = {}\n{holes}",
            corners(ring)
        );
        text.truncate(text.trim_end().len());
        text.push('\n');
    }
}

fn corners(ring: &[Point]) -> String {
    let corners: Vec<String> = ring.iter().map(|p| format!("[{}, {}]", metres(p.x), metres(p.y))).collect();
    format!("[{}]", corners.join(", "))
}

/// A coordinate to a micrometre, without zeros at its end.
pub(crate) fn metres(value: f64) -> String {
    let text = format!("{value:.6}");
    let text = text.trim_end_matches('0');
    let text = if text.ends_with('.') { format!("{text}0") } else { text.to_owned() };
    if text == "-0.0" { "0.0".to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_coordinates_are_written_to_a_micrometre() {
        assert_eq!([1.0, -0.15000000000000036, 2.5e-9, -1e-9].map(metres), ["1.0", "-0.15", "0.0", "0.0"]);
    }
}
