//! The bounds of mesh files, checked before `mesh_loader` reads them: it allocates what a file claims, recurses
//! for every element, and copies all vertices for every part.

use crate::xml_extent::XmlExtent;
use roxmltree::{Document, Node, ParsingOptions};

/// The largest number of triangles of a mesh.
pub(super) const MAX_TRIANGLES: usize = 1_500_000;
/// The largest number of corners of an OBJ file's faces, and of its vertices, normals and texture coordinates.
const MAX_CORNERS: usize = 3 * MAX_TRIANGLES;
/// The largest number of a mesh's parts: solids, groups, uses of materials.
const MAX_PARTS: usize = 20_000;
/// The extent of a COLLADA file.
const COLLADA: XmlExtent = XmlExtent { depth: 128, tags: 1_000_000, attributes: 64 };
/// The largest stride of a COLLADA file, of its vertices and of its indices.
const MAX_STRIDE: u64 = 256;
/// The largest number of vertices times parts of a COLLADA file: every part copies them all.
const MAX_COPIED: u64 = 50_000_000;
/// The largest number of polygons with one or two corners, for each of which the parser recurses.
const MAX_FLAT: u64 = 1000;

fn bounded(found: u64, limit: u64, what: &str) -> Result<(), String> {
    match found <= limit {
        true => Ok(()),
        false => Err(format!("{what} = {found}; it must be at most {limit}")),
    }
}

/// UTF-16 would be read as well, with the same bounds only after a conversion.
fn check_encoding(bytes: &[u8]) -> Result<(), String> {
    let is_wide = bytes.starts_with(&[0xfe, 0xff]) || bytes.starts_with(&[0xff, 0xfe]);
    if is_wide { Err("it is UTF-16; expected UTF-8".to_owned()) } else { Ok(()) }
}

/// The check of an STL file.
pub(super) fn check_stl(bytes: &[u8]) -> Result<(), String> {
    bounded(binary_triangles(bytes), MAX_TRIANGLES as u64, "number of its triangles")?;
    let is_text = bytes.trim_ascii_start().starts_with(b"solid");
    let solids = if is_text { bytes.windows(5).filter(|word| *word == b"solid").count() } else { 0 };
    // every solid begins and ends with the word
    bounded(solids as u64, 2 * MAX_PARTS as u64, "number of words `solid`")
}

/// The number of triangles that a binary STL has room for.
fn binary_triangles(bytes: &[u8]) -> u64 {
    (bytes.len().saturating_sub(84) / 50) as u64
}

/// What is odd about the length of a binary STL in which so many triangles were found.
pub(super) fn remark_on_stl(bytes: &[u8], found: usize) -> Option<String> {
    // a text has fewer
    let is_binary = found > 0 && binary_triangles(bytes) == found as u64;
    let claimed = u32::from_le_bytes(bytes.get(80..84)?.try_into().ok()?);
    let is_odd = is_binary && claimed as usize != found;
    is_odd.then(|| format!("it claims to have {claimed} triangles and has {found}"))
}

/// The check of an OBJ file: lines that begin with a key, as the parser has them.
pub(super) fn check_obj(bytes: &[u8]) -> Result<(), String> {
    check_encoding(bytes)?;
    let (mut faces, mut corners, mut vertices, mut parts) = (0, 0, 0, 0);
    for line in bytes.split(|byte| matches!(byte, b'\n' | b'\r')) {
        match line {
            [b'f', words @ ..] => {
                faces += 1;
                let is_space = |byte: &u8| byte.is_ascii_whitespace();
                corners += words.split(is_space).filter(|word| !word.is_empty()).count() as u64;
            }
            [b'v', ..] => vertices += 1,
            [b'g' | b'u', ..] => parts += 1,
            _ => {}
        }
    }
    bounded(faces, MAX_TRIANGLES as u64, "number of its faces")?;
    bounded(corners, MAX_CORNERS as u64, "number of its faces' corners")?;
    // a polygon of n corners is n - 2 triangles
    bounded(corners.saturating_sub(2 * faces), MAX_TRIANGLES as u64, "number of its triangles")?;
    bounded(vertices, MAX_CORNERS as u64, "number of its vertices")?;
    bounded(parts, MAX_PARTS as u64, "number of its groups and materials")
}

/// The check of a COLLADA file: every number by which memory is allocated, and the time that it asks for.
pub(super) fn check_collada(bytes: &[u8]) -> Result<(), String> {
    check_encoding(bytes)?;
    let text = std::str::from_utf8(bytes).map_err(|_| "it is not UTF-8".to_owned())?;
    COLLADA.check(text)?;
    let options = ParsingOptions { nodes_limit: 3 * COLLADA.tags as u32, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| error.to_string())?;
    let longest = text.len() as u64;
    let (mut counts, mut triangles, mut parts) = (0_u64, 0_u64, 0_u64);
    let (mut positions, mut parameters, mut flat) = (0_u64, 0_u64, 0_u64);
    for node in document.descendants().filter(Node::is_element) {
        let name = node.tag_name().name();
        let count = number(node, "count");
        match name {
            "float_array" => counts = counts.saturating_add(count),
            "accessor" => {
                bounded(number(node, "stride"), MAX_STRIDE, "stride")?;
                positions = positions.max(count);
                parameters = parameters.max(node.children().count() as u64);
            }
            // the parser does not end with one
            "Name_array" | "IDREF_array" if node.ancestors().any(|node| node.has_tag_name("mesh")) => {
                return Err(format!("it has a {name} in a mesh; expected a float_array"));
            }
            "lines" | "linestrips" | "triangles" | "trifans" | "tristrips" | "polygons" | "polylist" => {
                counts = counts.saturating_add(count);
                parts += 1;
                let part = Part::new(node, count)?;
                bounded(part.indices, longest, "number of a part's indices")?;
                triangles = triangles.saturating_add(part.triangles);
                flat += part.flat;
            }
            _ => {}
        }
    }
    bounded(counts, longest, "sum of its counts")?;
    bounded(triangles, MAX_TRIANGLES as u64, "number of its triangles")?;
    bounded(parts, MAX_PARTS as u64, "number of its parts")?;
    bounded(parts.saturating_mul(positions), MAX_COPIED, "number of its vertices times that of its parts")?;
    bounded(parts.saturating_mul(parameters), MAX_COPIED, "number of an accessor's parameters")?;
    bounded(flat, MAX_FLAT, "number of its polygons of one or two corners")
}

/// An attribute that is a whole number; 0 without one, which the parser refuses where it needs it.
fn number(node: Node, key: &str) -> u64 {
    node.attribute(key).and_then(|text| text.parse().ok()).unwrap_or(0)
}

/// A part of a COLLADA mesh.
#[derive(Default)]
struct Part {
    /// The numbers that it claims to have, or has.
    indices: u64,
    triangles: u64,
    /// Polygons of one or two corners.
    flat: u64,
}

impl Part {
    fn new(node: Node, count: u64) -> Result<Self, String> {
        let named = |name: &'static str| node.children().filter(move |child| child.has_tag_name(name));
        let offsets = named("input").map(|input| number(input, "offset"));
        let stride = offsets.max().unwrap_or(0).saturating_add(1);
        bounded(stride, MAX_STRIDE, "offset of an input, and one,")?;
        let words = |node: Node| node.text().map_or(0, |text| text.split_ascii_whitespace().count() as u64);
        let listed: u64 = named("p").map(words).sum();
        let claims = |corners: u64| corners.saturating_mul(stride).max(listed);
        Ok(match node.tag_name().name() {
            "triangles" => {
                Self { indices: claims(count.saturating_mul(3)), triangles: count, ..Self::default() }
            }
            "lines" => Self { indices: claims(count.saturating_mul(2)), ..Self::default() },
            "polylist" => {
                let mut part = Self::default();
                for word in
                    named("vcount").filter_map(|node| node.text()).flat_map(str::split_ascii_whitespace)
                {
                    let corners: u64 =
                        word.parse().map_err(|_| format!("vcount = {word:?}; it must be a whole number"))?;
                    part.indices = part.indices.saturating_add(corners);
                    part.triangles = part.triangles.saturating_add(corners.saturating_sub(2));
                    part.flat += u64::from(corners < 3);
                }
                part.indices = claims(part.indices);
                part
            }
            "polygons" => {
                let flat = named("p").filter(|p| words(*p) < 3 * stride).count() as u64;
                Self { indices: listed, triangles: listed / stride, flat }
            }
            _ => Self { indices: listed, triangles: listed / stride, ..Self::default() },
        })
    }
}
