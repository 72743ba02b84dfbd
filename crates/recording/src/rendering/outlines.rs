//! The letters of a picture as outlines of the embedded font, so that it looks the same on every machine,
//! with or without fonts.

use resvg::usvg::roxmltree::{Document, Node};
use std::fmt::Write;
use ttf_parser::{Face, GlyphId, OutlineBuilder};

const REGULAR: &[u8] = include_bytes!("../../../../assets/fonts/DejaVuSans.ttf");
const BOLD: &[u8] = include_bytes!("../../../../assets/fonts/DejaVuSans-Bold.ttf");
/// The slant of italic letters: x per y.
const SLANT: f64 = 0.2;

/// The same picture with every `text` element as a path. Only the attributes that the drawing kit writes are
/// understood.
pub(super) fn outlined(svg: &str) -> Option<String> {
    let faces = [Face::parse(REGULAR, 0).ok()?, Face::parse(BOLD, 0).ok()?];
    let document = Document::parse(svg).ok()?;
    let mut drawn = String::with_capacity(2 * svg.len());
    let mut end = 0;
    for text in document.descendants().filter(|node| node.has_tag_name("text")) {
        drawn += &svg[end..text.range().start];
        drawn += &path(text, &faces)?;
        end = text.range().end;
    }
    drawn += &svg[end..];
    Some(drawn)
}

fn number(node: &Node, name: &str) -> Option<f64> {
    node.attribute(name)?.parse().ok()
}

fn path(text: Node, [regular, bold]: &[Face; 2]) -> Option<String> {
    let face = if text.attribute("font-weight") == Some("bold") { bold } else { regular };
    let size = number(&text, "font-size")?;
    let runs: Vec<Node> = text.children().filter(Node::is_element).collect();
    let size_of = |run: &Node| number(run, "font-size").unwrap_or(size);
    let words = |run: &Node| run.text().unwrap_or_default().to_owned();
    let total: f64 = runs.iter().map(|run| width(face, &words(run)) * size_of(run)).sum();
    let mut x = number(&text, "x")?
        - match text.attribute("text-anchor") {
            Some("middle") => total / 2.0,
            Some("end") => total,
            _ => 0.0,
        };
    let mut y = number(&text, "y")?;
    let mut outline = Outline { data: String::new(), x, y, scale: 1.0, slant: 0.0 };
    for run in &runs {
        y += number(run, "dy").unwrap_or(0.0);
        let slant = if run.attribute("font-style") == Some("italic") { SLANT } else { 0.0 };
        for c in words(run).chars() {
            let scale = size_of(run) / f64::from(face.units_per_em());
            (outline.x, outline.y, outline.scale, outline.slant) = (x, y, scale, slant);
            let glyph = glyph(face, c);
            face.outline_glyph(glyph, &mut outline);
            x += f64::from(face.glyph_hor_advance(glyph).unwrap_or(0)) * scale;
        }
    }
    let fill = text.attribute("fill").unwrap_or("#000000");
    Some(format!("<path fill=\"{fill}\" d=\"{}\"/>", outline.data))
}

/// The glyph of a character; the font's box where it has none.
fn glyph(face: &Face, c: char) -> GlyphId {
    face.glyph_index(c).unwrap_or(GlyphId(0))
}

/// The width of a text, em.
fn width(face: &Face, words: &str) -> f64 {
    let advance = |c| f64::from(face.glyph_hor_advance(glyph(face, c)).unwrap_or(0));
    words.chars().map(advance).sum::<f64>() / f64::from(face.units_per_em())
}

/// Path data of glyphs, placed in the picture.
struct Outline {
    data: String,
    x: f64,
    y: f64,
    scale: f64,
    slant: f64,
}

impl Outline {
    fn add(&mut self, command: char, points: &[(f32, f32)]) {
        self.data.push(command);
        for (x, y) in points {
            let (x, y) = (f64::from(*x), f64::from(*y));
            let at = (self.x + (x + self.slant * y) * self.scale, self.y - y * self.scale);
            // writing to a text does not fail
            let _ = write!(self.data, "{:.2} {:.2} ", at.0, at.1);
        }
    }
}

impl OutlineBuilder for Outline {
    fn move_to(&mut self, x: f32, y: f32) {
        self.add('M', &[(x, y)]);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.add('L', &[(x, y)]);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        self.add('Q', &[(x1, y1), (x, y)]);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.add('C', &[(x1, y1), (x2, y2), (x, y)]);
    }

    fn close(&mut self) {
        self.data.push('Z');
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_letters_stand_where_the_text_is_anchored() {
        let text = |anchor: &str| {
            let run = "<tspan dy=\"0\">HH</tspan><tspan dy=\"2\" font-size=\"5\">H</tspan>";
            format!(
                "<svg><text x=\"50\" y=\"20\" font-size=\"10\" text-anchor=\"{anchor}\" fill=\"#123456\">{run}</text></svg>"
            )
        };
        let xs = |anchor: &str| -> Vec<f64> {
            let drawn = outlined(&text(anchor)).unwrap();
            assert!(drawn.contains("fill=\"#123456\"") && !drawn.contains("<text"), "{drawn}");
            let (_, data) = drawn.split_once("d=\"").unwrap();
            let numbers = data.split(['M', 'L', 'Z', ' ', '"']).filter_map(|n| n.parse::<f64>().ok());
            numbers.step_by(2).collect()
        };
        // an H is 0.752 em wide
        let total = 0.752 * 25.0;
        for (anchor, left) in [("start", 50.0), ("middle", 50.0 - total / 2.0), ("end", 50.0 - total)] {
            let xs = xs(anchor);
            let (low, high) = xs.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
            assert!(low > left && low < left + 1.2, "{anchor}: {low}");
            assert!(high < left + total && high > left + total - 1.2, "{anchor}: {high}");
        }
    }

    /// The kit places labels by widths in whole thousandths, with one factor for all bold letters.
    #[test]
    fn labels_are_no_wider_than_the_kit_takes_them_to_be() {
        let labels = [
            "Environment 4",
            "stubbornness",
            "time (s)",
            "the human takes the lead",
            "0.0123456789",
            "ABCXYZ",
        ];
        for (data, is_bold) in [(REGULAR, false), (BOLD, true)] {
            let face = Face::parse(data, 0).unwrap();
            for label in labels {
                let taken = cocarry_output::drawing::text_width(label, is_bold);
                assert!(width(&face, label) <= taken * 1.01, "{label} {is_bold}");
            }
        }
    }
}
