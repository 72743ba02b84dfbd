//! Words in; escaped SVG text with italics and subscripts, and an estimate of its width, out.

use super::style::{INK, px};
use crate::geometry::Point;
use svg::node::Blob;
use svg::node::Node;
use svg::node::element::Element;

/// The fonts asked for; widths are estimated for the widest.
pub(super) const FONTS: &str = "Helvetica, Arial, DejaVu Sans, sans-serif";

/// Where a text stands relative to its point.
#[derive(Clone, Copy)]
pub(super) enum Align {
    Left,
    Middle,
    Right,
}

/// A line of text.
#[derive(Clone, Debug, Default)]
pub(super) struct Words(Vec<(Form, String)>);

#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    Plain,
    Italic,
    Sub,
}

/// Width of a blank, em.
const BLANK: f64 = 0.32;
/// How large a subscript is beside the line's own size.
const SUB_SIZE: f64 = 0.72;

impl Words {
    /// An empty line, to add to.
    pub fn new() -> Self {
        Self::default()
    }

    pub fn plain(self, text: impl Into<String>) -> Self {
        self.with(Form::Plain, text.into())
    }

    pub fn italic(self, text: impl Into<String>) -> Self {
        self.with(Form::Italic, text.into())
    }

    pub fn sub(self, text: impl Into<String>) -> Self {
        self.with(Form::Sub, text.into())
    }

    /// An opening's name, at most `most` characters of it; `xi12` becomes the Greek letter with a subscript.
    pub fn opening(self, name: &str, most: usize) -> Self {
        match name.strip_prefix("xi") {
            Some(digits) if !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()) => {
                self.italic("\u{3be}").sub(shorten(digits, most))
            }
            _ => self.plain(shorten(name, most)),
        }
    }

    fn with(mut self, form: Form, text: String) -> Self {
        self.0.push((form, text));
        self
    }

    /// One line after the other.
    pub fn then(mut self, other: Self) -> Self {
        self.0.extend(other.0);
        self
    }

    /// Estimated width, px, at font size `size`.
    pub fn width(&self, size: f64) -> f64 {
        let run = |(form, text): &(Form, String)| {
            let em = if *form == Form::Sub { size * SUB_SIZE } else { size };
            text.chars().map(|c| em * advance(c)).sum::<f64>()
        };
        self.0.iter().map(run).sum()
    }

    /// The text with its baseline at `at` (px).
    pub fn at(&self, at: Point, size: f64, align: Align) -> Element {
        let anchor = match align {
            Align::Left => "start",
            Align::Middle => "middle",
            Align::Right => "end",
        };
        let mut content = String::new();
        let mut lowered = 0.0;
        // renderers drop blanks at the ends of a run, so these become shifts
        let mut shift = 0.0;
        for (form, text) in &self.0 {
            let low = if *form == Form::Sub { size * 0.24 } else { 0.0 };
            let style = match form {
                Form::Plain => String::new(),
                Form::Italic => " font-style=\"italic\"".to_owned(),
                Form::Sub => format!(" font-size=\"{}\"", px(size * SUB_SIZE)),
            };
            let inner = text.trim_matches(' ');
            if inner.is_empty() {
                shift += size * BLANK * text.len() as f64;
                continue;
            }
            shift += size * BLANK * (text.len() - text.trim_start_matches(' ').len()) as f64;
            let (dx, dy) = (px(shift), px(low - lowered));
            content += &format!("<tspan dx=\"{dx}\" dy=\"{dy}\"{style}>{}</tspan>", escape(inner));
            shift = size * BLANK * (text.len() - text.trim_end_matches(' ').len()) as f64;
            lowered = low;
        }
        let mut element = Element::new("text");
        element.assign("x", px(at.x));
        element.assign("y", px(at.y));
        element.assign("font-size", px(size));
        element.assign("text-anchor", anchor);
        element.assign("fill", INK);
        element.append(Blob::new(content));
        element
    }
}

/// The first `most` characters of `text`; an ellipsis says that more follow.
pub(super) fn shorten(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most.saturating_sub(1)).chain(['\u{2026}']).collect()
}

/// `text` without the characters that XML cannot hold; line breaks become blanks.
pub(super) fn printable(text: &str) -> String {
    let fit = |c: char| match c {
        c if c.is_whitespace() => ' ',
        '\u{fffe}' | '\u{ffff}' => '\u{fffd}',
        c if c.is_control() => '\u{fffd}',
        c => c,
    };
    text.chars().map(fit).collect()
}

/// `text` for the inside of an XML element.
fn escape(text: &str) -> String {
    printable(text).replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Width of a character in em, on the generous side.
fn advance(c: char) -> f64 {
    match c {
        'i' | 'j' | 'l' | 'I' | '.' | ',' | ':' | ';' | '\'' | '|' | ' ' => 0.33,
        'f' | 'r' | 't' | '(' | ')' | '[' | ']' | '/' | '-' => 0.42,
        'm' | 'w' | 'M' | 'W' | '@' | '%' => 0.98,
        c if c.is_ascii_uppercase() => 0.74,
        c if c.is_ascii() => 0.64,
        '\u{3be}' => 0.56,
        c if (c as u32) < 0x2e80 => 0.74,
        _ => 1.05,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_escaped_and_openings_become_symbols() {
        let at = |words: Words| words.at(Point::origin(), 10.0, Align::Left).to_string();
        assert!(at(Words::new().opening("a<&\"\u{1}", 9)).contains(">a&lt;&amp;&quot;\u{fffd}<"));
        let symbol = at(Words::new().opening("xi12", 9));
        assert!(symbol.contains("\u{3be}</tspan>") && symbol.contains(">12</tspan>"), "{symbol}");
        assert!(at(Words::new().opening("xi1b", 9)).contains(">xi1b<"));
        assert_eq!(shorten("abcdef", 4), "abc\u{2026}");
    }
}
