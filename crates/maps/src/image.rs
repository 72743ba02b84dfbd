//! Images of occupancy grids: PGM (plain and raw) and PNG, as shades of grey.

use cocarry::error::{Error, Place};
use cocarry::{bounds, guarded, located};
use std::io::Cursor;
use std::path::Path;

/// The largest number of cells of a map.
const MAX_CELLS: usize = 1 << 26;

/// An image, row by row from the top.
pub(crate) struct Image {
    pub width: usize,
    pub height: usize,
    /// The shade of every pixel, 0 (black) to 255 (white); `None` where it is transparent.
    pub shades: Vec<Option<u8>>,
}

impl Image {
    pub fn read(path: &Path) -> Result<Self, Error> {
        let file = path.display().to_string();
        let read = located::read_bytes(&bounds::IMAGE, path);
        let bytes = read.map_err(|error| located::unreadable(&file, error))?;
        let decoded = guarded::on_thread(|| Self::decode(&bytes));
        let decoded = decoded.unwrap_or_else(|panic| Err(format!("cannot be decoded: {panic}")));
        decoded.map_err(|fault| Error::at(Place::file(file), fault))
    }

    fn decode(bytes: &[u8]) -> Result<Self, String> {
        match bytes {
            [b'P', b'2' | b'5', ..] => pgm(bytes),
            [0x89, b'P', b'N', b'G', ..] => png(bytes),
            _ if bytes.starts_with(b"version https://git-lfs") => {
                Err("is a Git LFS pointer, not the image: fetch it with `git lfs pull`".to_owned())
            }
            _ => {
                Err("is neither a PGM (P2 or P5) nor a PNG image; convert the map into one of them"
                    .to_owned())
            }
        }
    }

    fn check_size(width: usize, height: usize) -> Result<usize, String> {
        let cells = width.checked_mul(height).filter(|cells| (1..=MAX_CELLS).contains(cells));
        cells.ok_or_else(|| {
            format!("has {width} x {height} pixels; a map has at most {MAX_CELLS}, and at least one")
        })
    }
}

/// A portable graymap.
fn pgm(bytes: &[u8]) -> Result<Image, String> {
    let mut reader = Pgm { bytes, at: 2 };
    let mut header = |what| reader.number().ok_or_else(|| format!("its header has no {what}"));
    let (width, height, largest) = (header("width")?, header("height")?, header("largest value")?);
    let cells = Image::check_size(width, height)?;
    if !(1..=65535).contains(&largest) {
        return Err(format!("its largest value is {largest}; it must be from 1 to 65535"));
    }
    let shade = |value: usize| Some((value.min(largest) * 255 / largest) as u8);
    let shades: Vec<Option<u8>> = if bytes[1] == b'2' {
        (0..cells).map_while(|_| reader.number()).map(shade).collect()
    } else {
        // a single white space ends the header
        let data = &bytes[(reader.at + 1).min(bytes.len())..];
        match largest {
            ..=255 => data.iter().take(cells).map(|byte| shade(usize::from(*byte))).collect(),
            _ => {
                let value = |pair: &[u8]| usize::from(u16::from_be_bytes([pair[0], pair[1]]));
                data.chunks_exact(2).take(cells).map(|pair| shade(value(pair))).collect()
            }
        }
    };
    match shades.len() == cells {
        true => Ok(Image { width, height, shades }),
        false => Err(format!("is cut short: {} of {width} x {height} pixels", shades.len())),
    }
}

/// The numbers of a PGM file, between white space and comments.
struct Pgm<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Pgm<'_> {
    fn number(&mut self) -> Option<usize> {
        loop {
            match self.bytes.get(self.at)? {
                b'#' => self.at += self.bytes[self.at..].iter().position(|b| *b == b'\n')?,
                byte if byte.is_ascii_whitespace() => self.at += 1,
                _ => break,
            }
        }
        let rest = &self.bytes[self.at..];
        let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
        self.at += digits;
        std::str::from_utf8(&rest[..digits]).ok()?.parse().ok()
    }
}

fn png(bytes: &[u8]) -> Result<Image, String> {
    let fault = |error: png::DecodingError| format!("is not a valid PNG image: {error}");
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_ignore_text_chunk(true);
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(fault)?;
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    Image::check_size(width, height)?;
    let size = reader.output_buffer_size().ok_or("is too large")?;
    let mut data = vec![0; size];
    let frame = reader.next_frame(&mut data).map_err(fault)?;
    let channels = frame.color_type.samples();
    let has_alpha = channels == 2 || channels == 4;
    let shade = |pixel: &[u8]| {
        let colours = &pixel[..channels - usize::from(has_alpha)];
        let sum: usize = colours.iter().map(|c| usize::from(*c)).sum();
        (!has_alpha || pixel[channels - 1] > 0).then_some((sum / colours.len()) as u8)
    };
    let shades = data[..frame.buffer_size()].chunks_exact(channels).map(shade).collect();
    Ok(Image { width, height, shades })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shades(bytes: &[u8]) -> Vec<u8> {
        Image::decode(bytes).unwrap().shades.into_iter().map(Option::unwrap).collect()
    }

    #[test]
    fn closed_form_plain_and_raw_graymaps_with_comments() {
        assert_eq!(shades(b"P2\n# by hand\n3 1\n# largest\n255 0 205\n254\n"), [0, 205, 254]);
        assert_eq!(shades(b"P5 # raw\n3 1 255\n\x00\xcd\xfe"), [0, 205, 254]);
        // a raw value may look like white space; a larger range is scaled
        assert_eq!(shades(b"P5\n1 2\n255\n \n"), [32, 10]);
        assert_eq!(shades(b"P5\n2 1\n65535\n\xff\xff\x80\x00"), [255, 127]);
        assert_eq!(shades(b"P2 2 1 1 0 1"), [0, 255]);
    }

    #[test]
    fn closed_form_portable_network_graphics_of_several_colours() {
        for (colour, data, expected) in [
            (png::ColorType::Grayscale, vec![0, 205], [Some(0), Some(205)]),
            (png::ColorType::Rgb, vec![30, 60, 90, 255, 255, 255], [Some(60), Some(255)]),
            (png::ColorType::GrayscaleAlpha, vec![9, 255, 9, 0], [Some(9), None]),
            (png::ColorType::Rgba, vec![3, 3, 3, 255, 0, 0, 0, 0], [Some(3), None]),
        ] {
            let mut bytes = Vec::new();
            let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
            encoder.set_color(colour);
            encoder.write_header().unwrap().write_image_data(&data).unwrap();
            assert_eq!(Image::decode(&bytes).unwrap().shades, expected);
            assert!(Image::decode(&bytes[..bytes.len() / 2]).is_err());
        }
    }

    #[test]
    fn damaged_images_are_refused_by_name_of_the_fault() {
        for (bytes, said) in [
            (&b"P5\n2 2\n255\n\x00"[..], "cut short: 1 of 2 x 2"),
            (b"P5\n", "no width"),
            (b"P2 2 2 0 1", "largest value is 0"),
            (b"P5 99999 99999 255\n", "at most"),
            (b"P6 1 1 255\n\x00\x00\x00", "neither a PGM"),
            (b"version https://git-lfs.github.com/spec/v1", "git lfs pull"),
        ] {
            let Err(fault) = Image::decode(bytes) else { panic!("{said}: read") };
            assert!(fault.contains(said), "{fault}");
        }
    }
}
