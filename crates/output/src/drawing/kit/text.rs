//! Lines of text with italics, subscripts and measured width.

use super::letters::{Letters, Run, outlines, width};
use super::{INK, px, rounded};
use crate::xml::{escaped, printable};
use cocarry::geometry::Point;
use svg::node::element::Element;
use svg::node::{Blob, Node};

/// The font stack.
pub(super) const FONTS: &str = "Helvetica, Arial, DejaVu Sans, sans-serif";

/// Advance widths of the characters from blank to tilde, em / 1000: the larger of Helvetica's and DejaVu
/// Sans's.
const ADVANCES: [u16; 95] = [
    318, 401, 460, 838, 636, 950, 780, 275, 390, 390, 500, 838, 318, 361, 318, 337, 636, 636, 636, 636, 636,
    636, 636, 636, 636, 636, 337, 337, 838, 838, 838, 556, 1015, 684, 686, 722, 770, 667, 611, 778, 752, 295,
    500, 667, 557, 863, 748, 787, 667, 787, 722, 667, 611, 732, 684, 989, 685, 667, 685, 390, 337, 390, 838,
    556, 500, 613, 635, 550, 635, 615, 352, 635, 634, 278, 278, 579, 278, 974, 634, 612, 635, 635, 411, 521,
    392, 634, 592, 818, 592, 592, 525, 636, 337, 636, 838,
];
/// Width of bold letters relative to regular ones.
const BOLD: f64 = 1.13;
/// Size of a subscript relative to the line, and its drop, em. Lines are 7.2 pt high in a picture 3.5 in
/// wide, and nothing may be below 7 pt.
const SUB_SIZE: f64 = 0.98;
const SUB_DROP: f64 = 0.2;

/// The part of a text at its anchor point.
#[derive(Clone, Copy)]
pub(in super::super) enum Align {
    Left,
    Middle,
    Right,
}

/// A line of text.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Text {
    runs: Vec<(Form, String)>,
    is_bold: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    Plain,
    Italic,
    Sub,
}

impl Text {
    pub fn new(text: impl Into<String>) -> Self {
        Self::default().plain(text)
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

    /// The name of an opening; `xi12` becomes the Greek letter with a subscript.
    pub fn opening(name: &str) -> Self {
        match name.strip_prefix("xi") {
            Some(digits) if !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit()) => {
                Self::default().italic("\u{3be}").sub(digits)
            }
            _ => Self::new(name),
        }
    }

    fn with(mut self, form: Form, text: String) -> Self {
        self.runs.push((form, text));
        self
    }

    pub fn bold(self) -> Self {
        Self { is_bold: true, ..self }
    }

    /// This text and then the other.
    pub fn then(mut self, other: Self) -> Self {
        self.runs.extend(other.runs);
        self
    }

    /// Width in px at font size `size`, in the wider of the fonts.
    pub fn width(&self, size: f64) -> f64 {
        self.runs.iter().flat_map(|(form, text)| text.chars().map(|c| self.advance(*form, c))).sum::<f64>()
            * size
    }

    /// Width of a character, em.
    fn advance(&self, form: Form, c: char) -> f64 {
        let ascii = (c as usize).checked_sub(' ' as usize).and_then(|i| ADVANCES.get(i));
        let em = match (ascii, c) {
            (Some(advance), _) => f64::from(*advance) / 1000.0,
            (None, '\u{2026}') => 1.0,
            // accented Latin, Greek, Cyrillic and signs; other characters count as full width
            (None, c) if (c as u32) < 0x2e80 => 0.84,
            (None, _) => 1.05,
        };
        em * if form == Form::Sub { SUB_SIZE } else { 1.0 } * if self.is_bold { BOLD } else { 1.0 }
    }

    /// As much of the text as fits into `width` px, with an ellipsis if it is cut.
    pub fn within(self, width: f64, size: f64) -> Self {
        if self.width(size) <= width {
            return self;
        }
        let mut room = width / size - self.advance(Form::Plain, '\u{2026}');
        let mut kept = Self { runs: Vec::new(), ..self };
        for (form, text) in &self.runs {
            let fits = |c: &char| {
                room -= kept.advance(*form, *c);
                room >= 0.0
            };
            let part: String = text.chars().take_while(fits).collect();
            let is_cut = part.len() < text.len();
            kept.runs.push((*form, part));
            if is_cut {
                break;
            }
        }
        kept.plain("\u{2026}")
    }

    /// The text with its baseline at `at` (px).
    pub fn at(&self, at: Point, size: f64, align: Align) -> Element {
        self.lettered(Letters::Text, at, size, align)
    }

    /// The same in these letters.
    pub fn lettered(&self, letters: Letters, at: Point, size: f64, align: Align) -> Element {
        match letters {
            Letters::Text => self.as_text(at, size, align),
            Letters::Outlines => self.as_outlines(at, size, align),
        }
    }

    fn as_outlines(&self, at: Point, size: f64, align: Align) -> Element {
        let texts: Vec<String> = self.runs.iter().map(|(_, text)| printable(text)).collect();
        let mut lowered = 0.0;
        let runs = self.runs.iter().zip(&texts).map(|((form, _), text)| {
            let is_sub = *form == Form::Sub;
            let low = if is_sub { size * SUB_DROP } else { 0.0 };
            let dy = rounded(low - lowered);
            lowered = low;
            let size = rounded(if is_sub { size * SUB_SIZE } else { size });
            Run { text, size, dy, is_italic: *form == Form::Italic }
        });
        let runs: Vec<Run> = runs.collect();
        let before = match align {
            Align::Left => 0.0,
            Align::Middle => width(&runs, self.is_bold) / 2.0,
            Align::Right => width(&runs, self.is_bold),
        };
        let mut element = Element::new("path");
        element.assign("fill", INK);
        element.assign("d", outlines(&runs, self.is_bold, [rounded(at.x) - before, rounded(at.y)]));
        element
    }

    fn as_text(&self, at: Point, size: f64, align: Align) -> Element {
        let anchor = match align {
            Align::Left => "start",
            Align::Middle => "middle",
            Align::Right => "end",
        };
        let mut content = String::new();
        let mut lowered = 0.0;
        for (form, text) in &self.runs {
            let low = if *form == Form::Sub { size * SUB_DROP } else { 0.0 };
            let style = match form {
                Form::Plain => String::new(),
                Form::Italic => " font-style=\"italic\"".to_owned(),
                Form::Sub => format!(" font-size=\"{}\"", px(size * SUB_SIZE)),
            };
            // otherwise renderers drop blanks at the ends of a run
            let style = format!("dy=\"{}\"{style} xml:space=\"preserve\"", px(low - lowered));
            content += &format!("<tspan {style}>{}</tspan>", escaped(text));
            lowered = low;
        }
        let mut element = Element::new("text");
        element.assign("x", px(at.x));
        element.assign("y", px(at.y));
        element.assign("font-size", px(size));
        element.assign("text-anchor", anchor);
        element.assign("fill", INK);
        if self.is_bold {
            element.assign("font-weight", "bold");
        }
        element.append(Blob::new(content));
        element
    }
}

/// A plain text in lines of at most `width` px. A longer word is cut.
pub(in super::super) fn wrapped(text: &str, width: f64, size: f64) -> Vec<Text> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let longer = lines.last().map(|line| format!("{line} {word}"));
        match longer.filter(|line| Text::new(line.as_str()).width(size) <= width) {
            Some(line) => {
                lines.pop();
                lines.push(line);
            }
            None => lines.push(word.to_owned()),
        }
    }
    lines.into_iter().map(|line| Text::new(line).within(width, size)).collect()
}

/// A number with a typographic minus sign.
pub(in super::super) fn number(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(digits) if digits.bytes().all(|b| b == b'0' || b == b'.') => digits.to_owned(),
        Some(digits) => format!("\u{2212}{digits}"),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_escaped_and_openings_become_symbols() {
        let at = |text: Text| text.at(Point::origin(), 10.0, Align::Left).to_string();
        assert!(at(Text::opening("a<&\"\u{1}")).contains(">a&lt;&amp;&quot;\u{fffd}<"));
        let symbol = at(Text::opening("xi12"));
        assert!(symbol.contains("\u{3be}</tspan>") && symbol.contains(">12</tspan>"), "{symbol}");
        assert!(at(Text::opening("xi1b")).contains(">xi1b<"));
    }

    #[test]
    fn closed_form_outlines_stand_where_the_text_is_anchored() {
        let text = Text::new("HH").sub("H");
        let xs = |align| -> Vec<f64> {
            let drawn = text.lettered(Letters::Outlines, Point::new(50.0, 20.0), 10.0, align).to_string();
            assert!(drawn.starts_with("<path ") && drawn.contains(INK), "{drawn}");
            let (_, data) = drawn.split_once(" d=\"").unwrap();
            let numbers = data.split(['M', 'L', 'Z', ' ', '"']).filter_map(|n| n.parse::<f64>().ok());
            numbers.step_by(2).collect()
        };
        // an H is 0.752 em wide
        let total = 0.752 * (20.0 + 10.0 * SUB_SIZE);
        for (align, left) in
            [(Align::Left, 50.0), (Align::Middle, 50.0 - total / 2.0), (Align::Right, 50.0 - total)]
        {
            let (low, high) = xs(align).iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
            assert!(low > left && low < left + 1.2, "{low}");
            assert!(high < left + total && high > left + total - 1.2, "{high}");
        }
    }

    /// Labels are placed by widths in whole thousandths, with one factor for all bold letters.
    #[test]
    fn outlines_are_no_wider_than_the_room_that_is_left_for_them() {
        let labels = [
            "Environment 4",
            "stubbornness",
            "time (s)",
            "the human takes the lead",
            "0.0123456789",
            "ABCXYZ",
        ];
        for text in labels {
            for label in [Text::new(text), Text::new(text).bold()] {
                let run = Run { text, size: 1.0, dy: 0.0, is_italic: false };
                assert!(width(&[run], label.is_bold) <= label.width(1.0) * 1.01, "{label:?}");
            }
        }
    }

    #[test]
    fn text_is_cut_to_its_room() {
        let text = || Text::new("A longer name of ").italic("something").sub("12").bold();
        let whole = text().width(10.0);
        assert!((Text::new("AV").width(10.0) - 13.68).abs() < 1e-9);
        assert_eq!(text().within(whole, 10.0).width(10.0), whole);
        for width in [15.0, 40.0, 90.0, whole - 0.1] {
            let cut = text().within(width, 10.0);
            assert!(cut.width(10.0) <= width && cut.runs.last().unwrap().1 == "\u{2026}", "{cut:?}");
        }
    }

    #[test]
    fn long_sentences_wrap_at_blanks_and_lose_nothing() {
        let words = "the human leads from option 4 to option 3; extraordinarily";
        let lines = wrapped(words, 150.0, 10.0);
        assert!(lines.len() > 1 && lines.iter().all(|line| line.width(10.0) <= 150.0), "{lines:?}");
        let joined: Vec<&str> = lines.iter().map(|line| line.runs[0].1.as_str()).collect();
        assert_eq!(joined.join(" "), words);
        assert_eq!(wrapped("", 150.0, 10.0).len(), 0);
    }

    #[test]
    fn numbers_have_one_minus_sign_and_no_negative_zero() {
        assert_eq!([number(-0.001, 2), number(-1.5, 1), px(-0.001)], ["0.00", "\u{2212}1.5", "0"]);
    }
}
