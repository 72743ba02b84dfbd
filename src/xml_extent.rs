//! The extent of an XML text: how deep it is, how many tags it has, and how many attributes a tag has. It is
//! found in one pass and without recursion, before a parser reads the text that recurses for every element or
//! compares all attributes of a tag with each other.

use std::ops::Range;

/// The largest extent of an XML text that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct XmlExtent {
    /// The depth of its elements.
    pub depth: usize,
    /// The number of its tags, comments, and the like.
    pub tags: usize,
    /// The number of attributes of a tag.
    pub attributes: usize,
}

impl XmlExtent {
    /// The check of a text, by the grammar that `roxmltree` parses. Text after a grammar error, where that
    /// parser stops, is not examined.
    ///
    /// # Errors
    /// What exceeds the extent, as a sentence without the file.
    pub fn check(self, text: &str) -> Result<(), String> {
        let bounded = |found: usize, limit: usize, what: &str| match found <= limit {
            true => Ok(()),
            false => Err(format!("{what} = {found}; it must be at most {limit}")),
        };
        let (mut depth, mut tags) = (0_usize, 0);
        for piece in Pieces::of(text) {
            tags += 1;
            bounded(tags, self.tags, "number of its tags")?;
            match piece?.0 {
                Piece::Start(tag) => {
                    bounded(depth + 1, self.depth, "depth of its elements")?;
                    bounded(tag.attributes, self.attributes, "number of a tag's attributes")?;
                    depth += usize::from(!tag.is_empty);
                }
                Piece::End => depth = depth.saturating_sub(1),
                Piece::Text | Piece::NoElement => {}
            }
        }
        Ok(())
    }
}

/// The text with spaces in place of comments, instructions and declarations: the same elements on the same
/// lines. A parser that is strict about these then reads what others do, such as a comment with `--` in it,
/// or a declaration that comes late.
pub fn elements_alone(text: &str) -> String {
    let mut bytes = text.as_bytes().to_vec();
    for (piece, at) in Pieces::of(text).map_while(Result::ok) {
        if let Piece::NoElement = piece {
            bytes[at].iter_mut().filter(|byte| **byte != b'\n').for_each(|byte| *byte = b' ');
        }
    }
    String::from_utf8(bytes).expect("only whole characters became spaces")
}

/// A piece of markup.
enum Piece {
    Start(Tag),
    End,
    /// Characters that are no markup.
    Text,
    /// A comment, an instruction or a declaration.
    NoElement,
}

/// The markup of a text, each piece with its bytes, up to a piece that does not end.
struct Pieces<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Pieces<'a> {
    fn of(text: &'a str) -> Self {
        Self { bytes: text.as_bytes(), at: 0 }
    }
}

impl Iterator for Pieces<'_> {
    type Item = Result<(Piece, Range<usize>), String>;

    fn next(&mut self) -> Option<Self::Item> {
        let from = self.at + self.bytes[self.at..].iter().position(|byte| *byte == b'<')?;
        let found = piece(&self.bytes[from..]).transpose()?;
        self.at = found.as_ref().map_or(self.bytes.len(), |(_, length)| from + length);
        Some(found.map(|(piece, length)| (piece, from..from + length)))
    }
}

/// The piece that begins here, with its length; `None` if it does not end.
///
/// # Errors
/// It is a document type declaration with definitions.
fn piece(bytes: &[u8]) -> Result<Option<(Piece, usize)>, String> {
    let ends = |from: usize, end: &[u8], piece| Some((piece, from + behind(&bytes[from..], end)?));
    Ok(match bytes {
        [b'<', b'!', b'-', b'-', ..] => ends(4, b"-->", Piece::NoElement),
        [b'<', b'!', b'[', b'C', b'D', b'A', b'T', b'A', b'[', ..] => ends(9, b"]]>", Piece::Text),
        [b'<', b'!', within @ ..] => behind_declaration(within)?.map(|length| (Piece::NoElement, 2 + length)),
        [b'<', b'?', ..] => ends(2, b"?>", Piece::NoElement),
        [b'<', b'/', ..] => ends(2, b">", Piece::End),
        [_, within @ ..] => Tag::read(within).map(|tag| {
            let length = 1 + tag.length;
            (Piece::Start(tag), length)
        }),
        [] => None,
    })
}

/// The number of bytes up to the end of the first `end`.
fn behind(bytes: &[u8], end: &[u8]) -> Option<usize> {
    bytes.windows(end.len()).position(|window| window == end).map(|at| at + end.len())
}

/// The number of bytes of a document type declaration behind its `<!`. One that only names a file, which no
/// parser reads, is passed over; many programs write it into their drawings.
///
/// # Errors
/// It defines entities, or the like.
fn behind_declaration(bytes: &[u8]) -> Result<Option<usize>, String> {
    let mut quote = None;
    for (i, byte) in bytes.iter().enumerate() {
        match (quote, *byte) {
            (Some(open), byte) if byte == open => quote = None,
            (Some(_), _) => {}
            (None, b'"' | b'\'') => quote = Some(*byte),
            (None, b'[') => {
                return Err(
                    "it has a document type declaration with definitions, which are not read".to_owned()
                );
            }
            (None, b'>') => return Ok(Some(i + 1)),
            (None, _) => {}
        }
    }
    Ok(None)
}

/// An opening tag.
struct Tag {
    /// The number of its bytes behind `<`.
    length: usize,
    attributes: usize,
    /// Whether it ends its element.
    is_empty: bool,
}

impl Tag {
    /// The tag behind its `<`; `None` where it does not end, or a value has a `<`.
    fn read(bytes: &[u8]) -> Option<Self> {
        let (mut quote, mut attributes) = (None, 0);
        for (i, byte) in bytes.iter().enumerate() {
            match (quote, *byte) {
                (_, b'<') => return None,
                (Some(open), byte) if byte == open => quote = None,
                (Some(_), _) => {}
                (None, b'"' | b'\'') => {
                    quote = Some(*byte);
                    attributes += 1;
                }
                (None, b'>') => {
                    return Some(Self { length: i + 1, attributes, is_empty: i > 0 && bytes[i - 1] == b'/' });
                }
                (None, _) => {}
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_elements_and_their_lines_are_left() {
        let text =
            "<!-- a -- ü\n<b> -->\n<?xml version='1.0'?><!DOCTYPE a>\n<a x='-->'><![CDATA[<!-- -->]]></a>";
        let alone = elements_alone(text);
        assert_eq!(alone.len(), text.len());
        let lines: Vec<&str> = alone.lines().map(str::trim).collect();
        assert_eq!(lines, ["", "", "", "<a x='-->'><![CDATA[<!-- -->]]></a>"]);
        assert_eq!(elements_alone("<a><!-- "), "<a><!-- ");
    }

    const SMALL: XmlExtent = XmlExtent { depth: 3, tags: 12, attributes: 2 };

    #[test]
    fn closed_form_depth_tags_and_attributes_are_those_of_the_text() {
        for text in [
            "<a><b><c/><c></c></b></a>",
            "<?xml version='1.0'?><a x='>' y=\"/>'\"><b><c/></b></a>",
            "<a><!-- <b><c><d><e> --><![CDATA[<b><c><d><e>]]><b/></a>",
            "<!DOCTYPE a PUBLIC '-//b//>[' \"c><![CDATA[\"><a><b/></a>",
            "no tags",
            "",
            // errors of the grammar
            "<a x='<a><a><a><a>",
            "<a",
            "<!-- <a><a><a><a>",
        ] {
            assert_eq!(SMALL.check(text), Ok(()), "{text}");
        }
        for (text, said) in [
            ("<a><b><c><d/></c></b></a>", "depth of its elements = 4; it must be at most 3"),
            // what looks like an end is a value, or a comment
            ("<a x='/>'><a x='/>'><a x='/>'><a>", "depth of its elements = 4"),
            ("<a><!-- </a></a> --><a><![CDATA[</a>]]><a><?p </a>?><a>", "depth of its elements = 4"),
            ("<!--></a><a>--><a><a><a><a>", "depth of its elements = 4"),
            ("<a x='' y='' z=''/>", "number of a tag's attributes = 3; it must be at most 2"),
            (&"<a/>".repeat(13), "number of its tags = 13; it must be at most 12"),
            // the quoted end is none
            ("<!DOCTYPE a SYSTEM '><![CDATA['><a><a><a><a>", "depth of its elements = 4"),
            ("<!DOCTYPE a [<!ENTITY b \"c\">]><a/>", "a document type declaration"),
        ] {
            let error = SMALL.check(text).unwrap_err();
            assert!(error.contains(said), "{text}: {error}");
        }
    }
}
