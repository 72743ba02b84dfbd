//! Line styles and widths of pictures, in the colours of [`palette`].

use super::{px, stroke};
use crate::palette::{self, PLAIN_OPENING};
use cocarry::geometry::Point;
use svg::node::element::Group;

/// Colours of frames and letters, and of the paper.
pub(in super::super) const INK: &str = "#1a1a1a";
pub(in super::super) const PAPER: &str = "#ffffff";
/// Background greys from light to dark: alternate rows, areas, grids, faint lines and marks.
pub(in super::super) const STRIPE: &str = "#f3f3f3";
pub(in super::super) const BAND: &str = "#e6e6e6";
pub(in super::super) const GRID: &str = "#d6d6d6";
pub(in super::super) const FAINT: &str = "#8a8a8a";
/// Obstacles and their outlines.
pub(in super::super) const OBSTACLE: &str = "#a6a6a6";
pub(in super::super) const OBSTACLE_EDGE: &str = "#595959";
/// These colours on dark paper: attribute, colour, colour there. White edges of coloured lines and marks
/// become light ones, so that dark colours stay visible; the colours of options and of risk stay.
const ON_DARK: [(&str, &str, &str); 13] = [
    ("fill", INK, "#e8e8e6"),
    ("stroke", INK, "#e8e8e6"),
    ("fill", PAPER, "#16181c"),
    ("stroke", PAPER, "#b9bbbe"),
    ("fill", STRIPE, "#1f2227"),
    ("fill", BAND, "#2b2f35"),
    ("stroke", BAND, "#2b2f35"),
    ("stroke", GRID, "#3a3e45"),
    ("fill", FAINT, "#8f949b"),
    ("stroke", FAINT, "#8f949b"),
    ("fill", OBSTACLE, "#5a5f66"),
    ("stroke", OBSTACLE_EDGE, "#8d9299"),
    ("stroke", PLAIN_OPENING, "#35573b"),
];
/// Dark paper.
const DARK_PAPER: [u8; 3] = [0x16, 0x18, 0x1c];
/// Width of faint lines, px.
pub(in super::super) const FAINT_WIDTH: f64 = 1.2;

/// The style that distinguishes one of several lines. An option has the style of its index in every picture.
#[derive(Clone, Copy)]
pub(in super::super) struct LineStyle {
    colour: [u8; 3],
    dash: &'static [f64],
}

impl LineStyle {
    /// The style of this index. Eight styles differ in colour and in dash pattern, 64 in one of the two.
    pub fn of(index: usize) -> Self {
        Self { colour: palette::option_colour(index), dash: palette::option_dash(index) }
    }

    pub fn colour(self) -> String {
        palette::hex(self.colour)
    }

    /// The colour mixed with white, for areas under letters.
    pub fn tint(self) -> String {
        palette::hex(self.colour.map(|c| 255 - (255 - c) / 4))
    }

    /// The tint on dark paper: the colour mixed with that of the paper.
    fn dark_tint(self) -> String {
        let mixed = |i: usize| ((2 * u16::from(DARK_PAPER[i]) + u16::from(self.colour[i])) / 3) as u8;
        palette::hex([0, 1, 2].map(mixed))
    }

    /// A line with a white edge, so that lines below it stay readable.
    pub fn draw(self, points: &[Point], width: f64) -> Group {
        let factor = (width / 4.5).clamp(0.75, 1.5);
        let dash: Vec<String> = self.dash.iter().map(|d| px(d * factor)).collect();
        let lines = [(PAPER.to_owned(), width + 0.8), (self.colour(), width)];
        lines.into_iter().fold(Group::new(), |group, (colour, width)| {
            let line = stroke(points, &colour, width);
            group.add(if dash.is_empty() { line } else { line.set("stroke-dasharray", dash.join(" ")) })
        })
    }
}

/// Width of one of several lines, px. Each is narrower than the previous one, so that coinciding lines remain
/// visible.
pub(in super::super) fn width_by_rank(index: usize, of: usize) -> f64 {
    let narrowed = index as f64 / of.saturating_sub(1).max(3) as f64;
    6.4 - 4.2 * narrowed
}

/// Line widths, px, that grow with probability and all differ.
pub(in super::super) fn widths_by_probability(probabilities: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut widths: Vec<f64> = probabilities.map(|p| 1.4 + 9.0 * p.min(1.0)).collect();
    let mut order: Vec<usize> = (0..widths.len()).collect();
    // of equally wide lines the later one is narrower
    order.sort_by(|&a, &b| widths[a].total_cmp(&widths[b]).then(b.cmp(&a)));
    let step = (8.0 / widths.len().max(1) as f64).min(1.6);
    for pair in order.windows(2) {
        widths[pair[1]] = widths[pair[1]].max(widths[pair[0]] + step);
    }
    widths
}

/// Rules of CSS that show the pictures of a page, by their selector, on dark paper.
pub fn dark_rules(selector: &str) -> String {
    let rule = |attribute: &str, colour: &str, on_dark: &str| {
        format!("{selector} [{attribute}=\"{colour}\"] {{ {attribute}: {on_dark}; }}\n")
    };
    let fixed = ON_DARK.iter().map(|(attribute, colour, on_dark)| rule(attribute, colour, on_dark));
    let styles = (0..palette::option_colours()).map(LineStyle::of);
    let tints = styles.map(|style| rule("fill", &style.tint(), &style.dark_tint()));
    fixed.chain(tints).collect()
}

/// The colour of a risk from 0 (light) to 1 (dark).
pub(in super::super) fn risk_colour(risk: f64) -> String {
    palette::hex(palette::risk_colour(risk))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wider_lines_are_more_probable_and_no_two_are_alike() {
        let widths = widths_by_probability([0.1, 0.5, 0.5, 0.0].into_iter());
        assert!(widths[1] > widths[2] && widths[2] > widths[0] && widths[0] > widths[3], "{widths:?}");
    }
}
