//! The formats of pictures of results, by the extensions of their files.

use super::{Width, pdf, png};
use cocarry::Error;
use cocarry_output::drawing::{Letters, Sheet};
use std::path::Path;

/// The width of a picture that is printed.
const PRINTED: Width = Width::Inches(7.0);

/// The format of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// With letters as text.
    Svg,
    /// Vectors, with letters as outlines.
    Pdf,
    /// Pixels.
    Png,
}

impl PictureFormat {
    /// The formats, by their extensions.
    const ALL: [(&str, Self); 3] = [("svg", Self::Svg), ("pdf", Self::Pdf), ("png", Self::Png)];

    /// The format of a file by its extension, in any case.
    ///
    /// # Errors
    /// A sentence, if the extension is not that of a picture.
    pub fn of(file: &Path) -> Result<Self, String> {
        let found = file.extension().and_then(|extension| {
            Self::ALL.into_iter().find(|(known, _)| extension.eq_ignore_ascii_case(known))
        });
        let known = Self::ALL.map(|(extension, _)| format!(".{extension}")).join(", ");
        found.map(|(_, format)| format).ok_or_else(|| format!("expected one of the extensions {known}"))
    }

    /// The sheet to draw on. Without a width, an SVG has that of a page on a screen, others are 7 inches wide.
    pub fn sheet(self, width: Option<Width>) -> Sheet {
        match self {
            Self::Svg => Width::sheet_or_default(width),
            Self::Pdf | Self::Png => width.unwrap_or(PRINTED).sheet(Letters::Outlines),
        }
    }

    /// The bytes of the file of a picture that was drawn on the [sheet](Self::sheet) of this width.
    ///
    /// # Errors
    /// It is too large.
    pub fn bytes(self, svg: String, width: Option<Width>) -> Result<Vec<u8>, Error> {
        match self {
            Self::Svg => Ok(svg.into_bytes()),
            Self::Pdf => pdf(&svg, width.unwrap_or(PRINTED)),
            Self::Png => png(&svg, width.unwrap_or(PRINTED)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_has_the_format_of_its_extension() {
        assert_eq!(PictureFormat::of(Path::new("a.b.PDF")), Ok(PictureFormat::Pdf));
        for name in ["a", "svg", "a.gif"] {
            let refusal = PictureFormat::of(Path::new(name)).unwrap_err();
            assert_eq!(refusal, "expected one of the extensions .svg, .pdf, .png");
        }
    }

    #[test]
    fn a_width_has_its_unit() {
        assert_eq!("3.5in".parse::<Width>(), Ok(Width::Inches(3.5)));
        assert_eq!("1200px".parse::<Width>(), Ok(Width::Pixels(1200)));
        for (text, said) in [
            ("3.5", "expected inches or pixels, as in 3.5in or 1200px"),
            ("xin", "`x` is not a number"),
            ("1in", "must be from 2in to 20in"),
            ("nanpx", "must be from 300px to 6000px"),
        ] {
            assert_eq!(text.parse::<Width>(), Err(said.to_owned()), "{text}");
        }
    }
}
