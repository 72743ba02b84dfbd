//! How a picture has its letters: as text, or as outlines of the embedded font, which look the same on every
//! machine, with or without fonts.

use std::fmt::Write;
use std::sync::LazyLock;
use ttf_parser::{Face, GlyphId, OutlineBuilder};

/// How a picture has its letters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Letters {
    /// As text, in a font of the reader.
    #[default]
    Text,
    /// As outlines of the embedded font.
    Outlines,
}

const REGULAR: &[u8] = include_bytes!("../../../../../assets/fonts/DejaVuSans.ttf");
const BOLD: &[u8] = include_bytes!("../../../../../assets/fonts/DejaVuSans-Bold.ttf");
/// The slant of italic letters: x per y.
const SLANT: f64 = 0.2;

/// The embedded font, regular and bold.
static FACES: LazyLock<[Face<'static>; 2]> =
    LazyLock::new(|| [REGULAR, BOLD].map(|data| Face::parse(data, 0).expect("the embedded font is valid")));

/// A part of a line of text in one style.
pub(super) struct Run<'t> {
    pub text: &'t str,
    /// Size of the font, px.
    pub size: f64,
    /// Distance of the baseline below the baseline of the run before, px.
    pub dy: f64,
    pub is_italic: bool,
}

/// The width of runs of text in the embedded font, px.
pub(super) fn width(runs: &[Run], is_bold: bool) -> f64 {
    let face = &FACES[usize::from(is_bold)];
    let em = |run: &Run| run.text.chars().map(|c| advance(face, c)).sum::<f64>() / units(face);
    runs.iter().map(|run| em(run) * run.size).sum()
}

/// The `d` attribute of the outlines of runs of text, from `[x, y]` (px) on the baseline.
pub(super) fn outlines(runs: &[Run], is_bold: bool, [mut x, mut y]: [f64; 2]) -> String {
    let face = &FACES[usize::from(is_bold)];
    let mut outline = Outline { data: String::new(), x, y, scale: 1.0, slant: 0.0 };
    for run in runs {
        y += run.dy;
        outline.scale = run.size / units(face);
        outline.slant = if run.is_italic { SLANT } else { 0.0 };
        for c in run.text.chars() {
            (outline.x, outline.y) = (x, y);
            face.outline_glyph(glyph(face, c), &mut outline);
            x += advance(face, c) * outline.scale;
        }
    }
    outline.data
}

/// The glyph of a character; the font's box where it has none.
fn glyph(face: &Face, c: char) -> GlyphId {
    face.glyph_index(c).unwrap_or(GlyphId(0))
}

/// The width of a character, in units of the font.
fn advance(face: &Face, c: char) -> f64 {
    f64::from(face.glyph_hor_advance(glyph(face, c)).unwrap_or(0))
}

/// The units of the font in an em.
fn units(face: &Face) -> f64 {
    f64::from(face.units_per_em())
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
            write!(self.data, "{:.2} {:.2} ", at.0, at.1).expect("writing to a text does not fail");
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
