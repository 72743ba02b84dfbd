//! Pictures of an episode as files: filmstrips as SVG and PNG, and animations as GIF.

use super::film::film;
use crate::recording::Playback;
use ::png::{ColorType, PixelDimensions, Unit};
use cocarry::Error;
use cocarry_output::drawing::{Letters, Moment, NARROWEST, Sheet, Stimulus, WIDEST};
use gif::{DisposalMethod, Encoder, Frame, Repeat};
use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{Options, Tree};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::str::FromStr;

/// Resolution of a PNG whose width is given in inches, px per inch.
const RESOLUTION: f64 = 300.0;
/// Width of the layout per inch, px: type is 16.5 px high, which is 7.2 pt.
const LAYOUT_PER_INCH: f64 = 16.5 * 72.0 / 7.2;
/// An animation shows the recording at twice its speed: hundredths of a second for a simulated second.
const SPEED: f64 = 50.0;
/// A moving stimulus shows it in real time.
const REAL_TIME: f64 = 100.0;
/// The time for which the last frame stays, hundredths of a second.
const STAY: u16 = 250;
/// The number of colours of an animation, besides the transparent one.
const COLOURS: usize = 95;
/// The largest number of frames of an animation, and the number of frames that its colours are chosen from.
const MAX_PICTURES: usize = 600;
const SAMPLES: usize = 12;

/// The width of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Width {
    /// In pixels.
    Pixels(u32),
    /// In inches, as printed.
    Inches(f64),
}

impl Width {
    /// The width of the layout, px: within it all type has one size.
    fn layout(self) -> f64 {
        let width = match self {
            Self::Pixels(pixels) => f64::from(pixels),
            Self::Inches(inches) => inches * LAYOUT_PER_INCH,
        };
        width.clamp(NARROWEST, WIDEST)
    }

    /// Value and unit, as SVG writes them.
    fn shown(self) -> (f64, &'static str) {
        match self {
            Self::Pixels(pixels) => (f64::from(pixels), ""),
            Self::Inches(inches) => (inches, "in"),
        }
    }

    /// The sheet of an SVG file of this width, 720 px without one.
    pub fn sheet_or_default(width: Option<Self>) -> Sheet {
        width.map_or_else(Sheet::default, |width| width.sheet(Letters::Text))
    }

    /// The sheet of a picture of this width.
    pub fn sheet(self, letters: Letters) -> Sheet {
        Sheet { width: self.layout(), shown: self.shown(), letters }
    }

    /// The width on paper, pt: as in SVG, 96 pixels are an inch.
    pub(super) fn points(self) -> f64 {
        match self {
            Self::Pixels(pixels) => 0.75 * f64::from(pixels),
            Self::Inches(inches) => 72.0 * inches,
        }
    }

    /// The width of an image, px.
    fn pixels(self) -> f64 {
        match self {
            Self::Pixels(pixels) => f64::from(pixels),
            Self::Inches(inches) => (inches * RESOLUTION).round(),
        }
    }
}

impl FromStr for Width {
    type Err = String;

    /// A number with its unit, as in `3.5in` or `1200px`. The error is a sentence.
    fn from_str(text: &str) -> Result<Self, String> {
        let (number, is_inches) = match (text.strip_suffix("in"), text.strip_suffix("px")) {
            (Some(number), _) => (number, true),
            (None, Some(number)) => (number, false),
            (None, None) => return Err("expected inches or pixels, as in 3.5in or 1200px".to_owned()),
        };
        let value: f64 = number.trim().parse().map_err(|_| format!("`{number}` is not a number"))?;
        match is_inches {
            true if (2.0..=20.0).contains(&value) => Ok(Self::Inches(value)),
            true => Err("must be from 2in to 20in".to_owned()),
            false if (300.0..=6000.0).contains(&value) => Ok(Self::Pixels(value.round() as u32)),
            false => Err("must be from 300px to 6000px".to_owned()),
        }
    }
}

/// The filmstrip as SVG: the team at `instants` times on one map, with phi next to it. Its letters are SVG
/// text.
///
/// # Errors
/// There is nothing to draw, or a number cannot be drawn.
pub fn filmstrip_svg(playback: &Playback, instants: usize, width: Width) -> Result<String, Error> {
    film(playback, Letters::Text).strip(instants, width.layout(), width.shown())
}

/// A picture whose letters are outlines as a PNG file. One whose width is in inches has its resolution, too, so
/// that other programs show it in that width.
///
/// # Errors
/// It is too large.
pub fn png(svg: &str, width: Width) -> Result<Vec<u8>, Error> {
    let picture = raster(svg, width.pixels())?;
    let mut file = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut file, picture.width(), picture.height());
    encoder.set_color(ColorType::Rgba);
    if let Width::Inches(_) = width {
        let per_metre = (RESOLUTION / 0.0254).round() as u32;
        encoder.set_pixel_dims(Some(PixelDimensions { xppu: per_metre, yppu: per_metre, unit: Unit::Meter }));
    }
    let mut writer = encoder.write_header().map_err(no_image)?;
    writer.write_image_data(&picture.take_demultiplied()).map_err(no_image)?;
    writer.finish().map_err(no_image)?;
    Ok(file)
}

/// The filmstrip as a PNG file.
///
/// # Errors
/// It cannot be drawn, or is too large.
pub fn filmstrip_png(playback: &Playback, instants: usize, width: Width) -> Result<Vec<u8>, Error> {
    let svg = film(playback, Letters::Outlines).strip(instants, width.layout(), width.shown())?;
    png(&svg, width)
}

/// The team on the map with phi next to it, as an animated GIF at twice the recording's speed. Of a long
/// episode it shows every second step, or every third, and so on.
///
/// # Errors
/// As [`filmstrip_png`].
pub fn moving_gif(playback: &Playback, width: Width) -> Result<Vec<u8>, Error> {
    let film = film(playback, Letters::Outlines);
    let moving = film.moving(width.layout(), None)?;
    gif(&film.moments, SPEED, |at| raster(&moving.picture(at), width.pixels()))
}

/// The picture of a world for participants as a PNG file. `stimulus` has outlines as letters.
///
/// # Errors
/// As [`filmstrip_png`].
pub fn stimulus_png(stimulus: &Stimulus, width: u32) -> Result<Vec<u8>, Error> {
    raster(&stimulus.map(), f64::from(width))?.encode_png().map_err(no_image)
}

/// The team in the picture of a world for participants, as a moving GIF in real time. `stimulus` has outlines
/// as letters.
///
/// # Errors
/// As [`filmstrip_png`].
pub fn stimulus_gif(playback: &Playback, stimulus: &Stimulus, width: u32) -> Result<Vec<u8>, Error> {
    let film = film(playback, Letters::Outlines);
    let picture = |at: usize| stimulus.with_team(film.base, &film.moments[at]);
    gif(&film.moments, REAL_TIME, |at| raster(&picture(at), f64::from(width)))
}

/// A moving GIF of these moments, each of which lasts `speed` hundredths of a second for a second. Of many it
/// shows every second, or every third, and so on.
fn gif(
    moments: &[Moment],
    speed: f64,
    picture: impl Fn(usize) -> Result<Pixmap, Error>,
) -> Result<Vec<u8>, Error> {
    let count = moments.len();
    let mut shown: Vec<usize> = (0..count).step_by(count.div_ceil(MAX_PICTURES).max(1)).collect();
    shown.extend((shown.last() != Some(&(count - 1))).then_some(count - 1));
    let samples = shown.iter().step_by(shown.len().div_ceil(SAMPLES)).map(|&at| picture(at));
    let samples = samples.collect::<Result<Vec<Pixmap>, Error>>()?;
    let mut palette = Palette::of(&samples);
    let (breadth, height) = (samples[0].width(), samples[0].height());
    drop(samples);
    let image = |error: gif::EncodingError| no_image(error);
    let side = |length: u32| u16::try_from(length).map_err(|_| too_large(breadth, height));
    let mut file = Vec::new();
    let mut encoder =
        Encoder::new(&mut file, side(breadth)?, side(height)?, &palette.colours).map_err(image)?;
    encoder.set_repeat(Repeat::Infinite).map_err(image)?;
    let mut before: Option<Vec<u8>> = None;
    let begin = |at: usize| (speed * moments[at].time).round();
    for (i, &at) in shown.iter().enumerate() {
        let now = palette.indexed(&picture(at)?);
        let mut frame = palette.changed(before.as_deref(), &now, breadth as usize);
        frame.delay = shown.get(i + 1).map_or(STAY, |&next| (begin(next) - begin(at)) as u16);
        encoder.write_frame(&frame).map_err(image)?;
        before = Some(now);
    }
    drop(encoder);
    Ok(file)
}

/// A picture as pixels, by rows from the top, each red, green and blue.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pixels {
    /// Pixels of a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Three bytes for each pixel.
    pub colours: Vec<u8>,
}

/// The lines of words in the picture of an episode so far: its size must not change while the episode runs.
const TOLD_LINES: usize = 3;

/// The last frame of [`moving_gif`].
///
/// # Errors
/// As [`filmstrip_png`].
pub fn last_picture(playback: &Playback, width: Width) -> Result<Pixels, Error> {
    let film = film(playback, Letters::Outlines);
    let last = film.moments.len().saturating_sub(1);
    let picture = raster(&film.moving(width.layout(), Some(TOLD_LINES))?.picture(last), width.pixels())?;
    let colours = colours(&picture).flatten().collect();
    Ok(Pixels { width: picture.width(), height: picture.height(), colours })
}

/// The error of an image that the encoder refuses.
fn no_image(why: impl Display) -> Error {
    Error::new(format!("the image cannot be created: {why}"))
}

fn too_large(width: u32, height: u32) -> Error {
    no_image(format_args!("{width} x {height} pixels are too many"))
}

/// A picture without text as pixels.
fn raster(svg: &str, width: f64) -> Result<Pixmap, Error> {
    let tree = Tree::from_str(svg, &Options::default());
    let tree = tree.map_err(no_image)?;
    let scale = width / f64::from(tree.size().width());
    let height = (f64::from(tree.size().height()) * scale).round();
    let mut pixels =
        Pixmap::new(width as u32, height as u32).ok_or_else(|| too_large(width as u32, height as u32))?;
    let scale = scale as f32;
    // the last row may be covered in part
    pixels.fill(Color::WHITE);
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixels.as_mut());
    Ok(pixels)
}

/// The colours of a GIF; the last one is transparent.
struct Palette {
    colours: Vec<u8>,
    index: BTreeMap<[u8; 3], u8>,
}

fn colours(picture: &Pixmap) -> impl Iterator<Item = [u8; 3]> + '_ {
    // pictures are opaque, so premultiplied colours are the colours
    picture.pixels().iter().map(|p| [p.red(), p.green(), p.blue()])
}

impl Palette {
    /// The colours that are most frequent in these pictures; others take the nearest of them.
    fn of(pictures: &[Pixmap]) -> Self {
        let mut counts: BTreeMap<[u8; 3], u64> = BTreeMap::new();
        for picture in pictures {
            colours(picture).for_each(|colour| *counts.entry(colour).or_default() += 1);
        }
        let mut kept: Vec<([u8; 3], u64)> = counts.into_iter().collect();
        kept.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(&b.0)));
        kept.truncate(COLOURS);
        let colours = kept.iter().flat_map(|(colour, _)| *colour).chain([0; 3]).collect();
        Self { colours, index: BTreeMap::new() }
    }

    fn transparent(&self) -> u8 {
        (self.colours.len() / 3 - 1) as u8
    }

    fn indexed(&mut self, picture: &Pixmap) -> Vec<u8> {
        let known = &self.colours[..self.colours.len() - 3];
        let distance = |a: &[u8], b: &[u8; 3]| -> i32 {
            a.iter()
                .zip(b)
                .map(|(a, b)| (i32::from(*a) - i32::from(*b)) * (i32::from(*a) - i32::from(*b)))
                .sum()
        };
        let nearest = |colour: &[u8; 3]| {
            let all = known.chunks_exact(3).enumerate();
            all.min_by_key(|(_, known)| distance(known, colour)).map_or(0, |(i, _)| i as u8)
        };
        let index = &mut self.index;
        // most pixels have the colour of the one before
        let mut last = ([0; 3], nearest(&[0; 3]));
        let indexed = colours(picture).map(|colour| {
            if colour != last.0 {
                last = (colour, *index.entry(colour).or_insert_with(|| nearest(&colour)));
            }
            last.1
        });
        indexed.collect()
    }

    /// The part of a picture that differs from the one before, transparent where it does not.
    fn changed(&self, before: Option<&[u8]>, now: &[u8], width: usize) -> Frame<'static> {
        let differs = |at: usize| before.is_none_or(|before| before[at] != now[at]);
        let [mut left, mut top, mut right, mut bottom] = [usize::MAX, usize::MAX, 0, 0];
        for at in (0..now.len()).filter(|&at| differs(at)) {
            let (x, y) = (at % width, at / width);
            (left, right) = (left.min(x), right.max(x));
            (top, bottom) = (top.min(y), bottom.max(y));
        }
        // a picture without changes is one transparent pixel
        (left, top) = (left.min(right), top.min(bottom));
        let cells = (top..=bottom).flat_map(|y| (left..=right).map(move |x| y * width + x));
        let buffer: Vec<u8> =
            cells.map(|at| if differs(at) { now[at] } else { self.transparent() }).collect();
        Frame {
            left: left as u16,
            top: top as u16,
            width: (right - left + 1) as u16,
            height: (bottom - top + 1) as u16,
            transparent: Some(self.transparent()),
            dispose: DisposalMethod::Keep,
            buffer: Cow::Owned(buffer),
            ..Frame::default()
        }
    }
}
