//! The text of a URDF's file: its encoding, and the recognition of files that are something else.

use crate::bounds;
use std::borrow::Cow;
use std::ops::Range;

/// The beginning of a Git LFS pointer.
const LFS: &str = "version https://git-lfs.github.com/spec/";
/// What to do with a Git LFS pointer.
pub(super) const LFS_POINTER: &str =
    "is a Git LFS pointer, not the file itself; `git lfs pull` in its repository fetches that";
/// The name of each format by its first bytes, and what to do.
const BINARIES: [(&[u8], &str); 4] = [
    (b"PXR-USDC", USD),
    (b"PK\x03\x04", "is a zip archive (or a USDZ), not a URDF; unpack it, and name the .urdf in it"),
    (b"\x1f\x8b", "is compressed (gzip), not a URDF; unpack it with `gunzip`"),
    (b"glTF", "is a mesh (glTF), not a URDF"),
];
const USD: &str = "is a USD, not a URDF; use the URDF that it was made from, or export one from Isaac Sim";
const HTML: &str =
    "is a web page (HTML), not a URDF; fetch the file itself, for example with GitHub's button \"Raw\"";
/// The formats by the name of their first element, and what to do.
const ROOTS: [(&str, &str); 9] = [
    ("html", HTML),
    ("sdf", SDF),
    ("gazebo", SDF),
    ("world", SDF),
    ("mujoco", MJCF),
    ("mujocoinclude", MJCF),
    ("collada", "is a mesh (COLLADA), not a URDF; name the URDF that draws it"),
    ("launch", "is a launch file of ROS, not a URDF; name the URDF or xacro that it loads"),
    ("package", "is a package.xml of ROS, not a URDF; name the URDF in the package"),
];
const SDF: &str = "is an SDF of Gazebo, not a URDF; use the URDF or xacro that it was made from, or convert it (ROS has sdformat_urdf)";
const MJCF: &str = "is an MJCF of MuJoCo, not a URDF; use the URDF that it was made from, or convert it (PyPI has mjcf-urdf-simple-converter)";

/// The text of a file's bytes, in UTF-8 as its declaration then says: of UTF-8, UTF-16 or Latin-1, as its byte
/// order mark or its declaration says. Of any other encoding the characters of ASCII are read; these and bytes
/// that are not of the declared encoding become U+FFFD.
///
/// # Errors
/// What the file is instead, as a sentence without the file.
pub(super) fn decoded(bytes: &[u8]) -> Result<String, String> {
    if let Some((_, what)) = BINARIES.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        return Err((*what).to_owned());
    }
    let text = characters(bytes);
    if text.contains('\0') {
        return Err("is binary, not a URDF".to_owned());
    }
    let (mut text, limit) = (text.into_owned(), bounds::URDF.bytes());
    if text.len() as u64 > limit {
        return Err(format!("is larger than {limit} bytes in UTF-8"));
    }
    if let Some(label) = label(text.as_bytes()) {
        text.replace_range(label, "UTF-8");
    }
    Ok(text)
}

/// The characters of a file, by its byte order mark, or its first character, or the encoding that it declares.
fn characters(bytes: &[u8]) -> Cow<'_, str> {
    match bytes {
        [0xef, 0xbb, 0xbf, rest @ ..] => String::from_utf8_lossy(rest),
        [0xff, 0xfe, rest @ ..] => sixteen(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => sixteen(rest, u16::from_be_bytes),
        [b'<', 0, ..] => sixteen(bytes, u16::from_le_bytes),
        [0, b'<', ..] => sixteen(bytes, u16::from_be_bytes),
        _ => match label(bytes).map(|label| bytes[label].to_ascii_lowercase()).as_deref() {
            // a declaration that can be read is not in UTF-16
            None | Some(b"utf-8" | b"utf8" | b"utf-16" | b"utf16" | b"utf-16le" | b"utf-16be") => {
                String::from_utf8_lossy(bytes)
            }
            Some(b"iso-8859-1" | b"iso8859-1" | b"iso_8859-1" | b"latin1" | b"latin-1" | b"windows-1252") => {
                bytes
                    .iter()
                    .map(|byte| if (0x80..0xa0).contains(byte) { '\u{fffd}' } else { char::from(*byte) })
                    .collect()
            }
            Some(_) => bytes
                .iter()
                .map(|byte| if byte.is_ascii() { char::from(*byte) } else { '\u{fffd}' })
                .collect(),
        },
    }
}

/// The characters of UTF-16.
fn sixteen(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> Cow<'_, str> {
    let (pairs, _) = bytes.as_chunks::<2>();
    Cow::Owned(String::from_utf16_lossy(&pairs.iter().map(|pair| unit(*pair)).collect::<Vec<_>>()))
}

/// Where the XML declaration names the encoding.
fn label(bytes: &[u8]) -> Option<Range<usize>> {
    /// No declaration is longer, bytes.
    const MAX_DECLARATION: usize = 1000;
    let head = &bytes[..bytes.len().min(MAX_DECLARATION)];
    let find = |from: usize, word: &[u8]| {
        head[from..].windows(word.len()).position(|window| window == word).map(|at| from + at)
    };
    let begin = find(0, b"<?xml")?;
    let word = find(begin, b"encoding").filter(|at| find(begin, b"?>").is_none_or(|end| *at < end))?;
    let open = word + head[word..].iter().position(|byte| matches!(byte, b'"' | b'\''))?;
    let length = head[open + 1..].iter().position(|byte| *byte == head[open])?;
    Some(open + 1..open + 1 + length)
}

/// Whether a file is a Git LFS pointer, by its first bytes.
pub(super) fn is_lfs_pointer(bytes: &[u8]) -> bool {
    bytes.starts_with(LFS.as_bytes())
}

/// The check that a text may be a URDF, by what it begins with.
///
/// # Errors
/// What it is instead and what to do, as a sentence without the file.
pub(super) fn check_kind(text: &str) -> Result<(), String> {
    let text = text.trim_start_matches('\u{feff}');
    let root = root(text).map_err(without_elements)?;
    let name = root.rsplit(':').next().unwrap_or(root).to_lowercase();
    match ROOTS.iter().find(|(other, _)| *other == name) {
        Some((_, what)) => Err((*what).to_owned()),
        None if name == "robot" || root.starts_with("xacro:") => Ok(()),
        None => Err(format!(
            "is not a URDF: its first element is <{}>; expected <robot>",
            root.chars().take(40).collect::<String>()
        )),
    }
}

/// What a text is that has no element but `rest`, which is none.
fn without_elements(rest: &str) -> String {
    let begins = |start: &str| rest.starts_with(start);
    let what = match rest {
        "" => "is empty, not a URDF; fetch or write it again",
        _ if begins(LFS) => LFS_POINTER,
        _ if begins("#usda") => USD,
        _ if begins("404") => {
            "is a server's answer that there is no such file, not a URDF; check its address"
        }
        _ if begins("{") || begins("[") => "is JSON, not a URDF",
        _ if begins("<") => "ends in its first tag: the file was cut; fetch or write it again",
        _ => "is not a URDF: it has no XML element; expected <robot>",
    };
    what.to_owned()
}

/// The name of the first element behind comments, instructions and declarations, or what is there instead. A
/// declaration of HTML is one too.
fn root(text: &str) -> Result<&str, &str> {
    let begins =
        |rest: &str, word: &str| rest.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word));
    let mut rest = text.trim_start();
    loop {
        let end = match rest {
            _ if rest.starts_with("<!--") => "-->",
            _ if rest.starts_with("<?") => "?>",
            _ if begins(rest, "<!doctype html") => return Ok("html"),
            // its definitions are refused where the text is parsed
            _ if begins(rest, "<!doctype") && rest.split('>').next().is_some_and(|tag| tag.contains('[')) => {
                return Ok("robot");
            }
            _ if begins(rest, "<!doctype") => ">",
            _ => break,
        };
        rest = rest.split_once(end).ok_or(rest)?.1.trim_start();
    }
    let name = rest.strip_prefix('<').ok_or(rest)?;
    let end = name.find(|c: char| c.is_whitespace() || matches!(c, '>' | '/')).ok_or(rest)?;
    Some(&name[..end]).filter(|name| !name.is_empty()).ok_or(rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_decoded_as_it_declares() {
        let wide = |text: &str, big: bool| -> Vec<u8> {
            let units = text.encode_utf16();
            units.flat_map(|unit| if big { unit.to_be_bytes() } else { unit.to_le_bytes() }).collect()
        };
        let sixteen = "<?xml version=\"1.0\" encoding=\"UTF-16\"?><robot name=\"ré\"/>";
        let expected = sixteen.replace("UTF-16", "UTF-8");
        for bytes in [
            wide(sixteen, false),
            wide(sixteen, true),
            [&[0xff, 0xfe][..], &wide(sixteen, false)].concat(),
            [&[0xfe, 0xff][..], &wide(sixteen, true)].concat(),
            // declared wrongly, as by an editor that saved it again
            sixteen.as_bytes().to_vec(),
            [b"\xef\xbb\xbf", sixteen.as_bytes()].concat(),
        ] {
            assert_eq!(decoded(&bytes).as_deref(), Ok(expected.as_str()), "{bytes:?}");
        }
        for (encoding, name, decoded_name) in [
            ("ISO-8859-1", &b"r\xe9"[..], "ré"),
            ("latin1", b"r\xe9", "ré"),
            ("windows-1252", b"\x93r\xe9", "\u{fffd}ré"),
            ("gb2312", b"r\xbb\xfa", "r\u{fffd}\u{fffd}"),
            ("klingon", b"r", "r"),
            ("utf-8", "ré".as_bytes(), "ré"),
            ("utf-8", b"r\xe9", "r\u{fffd}"),
        ] {
            let text = |name: &[u8], encoding: &str| {
                [format!("<?xml version='1.0' encoding='{encoding}'?><robot n='").as_bytes(), name, b"'/>"]
                    .concat()
            };
            let expected = String::from_utf8(text(decoded_name.as_bytes(), "UTF-8")).unwrap();
            assert_eq!(decoded(&text(name, encoding)), Ok(expected), "{encoding}");
        }
        assert_eq!(
            decoded(b"<robot encoding='latin1' name='\xc3\xa9'/>").unwrap(),
            "<robot encoding='latin1' name='é'/>"
        );
    }

    #[test]
    fn what_is_not_a_urdf_is_named() {
        for (text, said) in [
            ("", "is empty"),
            ("\u{feff} \n", "is empty"),
            ("<?xml version='1.0'?>\n<!-- a -->\n", "is empty"),
            ("<?xml version='1.0'?>\n<!-- a", "was cut"),
            ("version https://git-lfs.github.com/spec/v1\noid sha256:0\n", "`git lfs pull`"),
            ("<?xml version='1.0'?><sdf version='1.6'><model/></sdf>", "an SDF of Gazebo"),
            ("<!-- a --><mujoco model='a'>", "an MJCF of MuJoCo"),
            ("<!DOCTYPE html><html>", "a web page"),
            ("<HTML lang='en'>", "a web page"),
            ("#usda 1.0\n(\n", "is a USD"),
            ("404: Not Found", "no such file"),
            ("{\"robot\": 1}", "is JSON"),
            ("<COLLADA xmlns='http://www.collada.org'>", "a mesh (COLLADA)"),
            ("<launch>", "a launch file"),
            ("<rob", "was cut"),
            ("name = \"robot\"", "has no XML element"),
            ("<model name='a'>", "its first element is <model>; expected <robot>"),
        ] {
            let error = check_kind(text).unwrap_err();
            assert!(error.contains(said), "{text}: {error}");
        }
        for (bytes, said) in [
            (&b"PXR-USDC\0\0"[..], "is a USD"),
            (b"PK\x03\x04\0", "a zip archive"),
            (b"\x1f\x8b\x08", "gzip"),
            (b"a\0b", "is binary"),
        ] {
            let error = decoded(bytes).unwrap_err();
            assert!(error.contains(said), "{error}");
        }
        for text in [
            "<robot>",
            "<?xml version='1.0'?>\n<!DOCTYPE robot>\n<robot name='r'/>",
            "<!DOCTYPE r [<!ENTITY b 'c'>]><robot/>",
            "<a:robot/>",
            "<xacro:macro/>",
        ] {
            assert_eq!(check_kind(text), Ok(()), "{text}");
        }
    }
}
