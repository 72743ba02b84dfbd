//! A URDF's elements, within bounds, and their lines.

use super::urdf_text::check_kind;
use crate::error::{Error, Place};
use crate::xml_extent::{XmlExtent, elements_alone};
use roxmltree::{Document, Error as Fault, Node, ParsingOptions};

/// The largest extent of a URDF: the parser of the mended text recurses once per level, and parsers compare an
/// attribute of an element with all its others.
const EXTENT: XmlExtent = XmlExtent { depth: 64, tags: 500_000, attributes: 64 };
/// The largest number of elements.
const MAX_ELEMENTS: usize = 50_000;
/// The largest number of namespaces that are declared; the parser copies them into elements within.
const MAX_NAMESPACES: usize = 1000;
/// The largest number of prefixes without a namespace.
const MAX_PREFIXES: usize = 16;
/// The namespace of the prefix `xacro`.
const XACRO: &str = "/xacro";

/// Calls `act` with the elements of a URDF.
///
/// # Errors
/// The text is something else, exceeds a bound, was cut, or is not XML.
pub(super) fn with_document<T>(file: &str, text: &str, act: impl FnOnce(&Document) -> T) -> Result<T, Error> {
    check_kind(text).map_err(|what| Error::at(Place::file(file), what))?;
    let robot = |sentence: String| Error::at(Place::item(file, "robot"), sentence);
    EXTENT.check(text).map_err(robot)?;
    let mut alone = elements_alone(text);
    let namespaces = alone.matches("xmlns").count();
    if namespaces > MAX_NAMESPACES {
        return Err(robot(format!(
            "number of its namespaces = {namespaces}; it must be at most {MAX_NAMESPACES}"
        )));
    }
    for _ in 0..MAX_PREFIXES {
        let Err(Fault::UnknownNamespace(prefix, _)) = parsed(&alone) else { break };
        declare(&mut alone, &prefix);
    }
    let document = parsed(&alone).map_err(|fault| not_xml(file, &alone, fault))?;
    let elements = document.descendants().filter(Node::is_element).count();
    if elements > MAX_ELEMENTS {
        return Err(robot(format!("number of its elements = {elements}; it must be at most {MAX_ELEMENTS}")));
    }
    Ok(act(&document))
}

fn parsed(text: &str) -> Result<Document<'_>, Fault> {
    let options = ParsingOptions { nodes_limit: 3 * EXTENT.tags as u32, ..ParsingOptions::default() };
    Document::parse_with_options(text, options)
}

/// Declares a prefix that has no namespace at the first element, as parsers take it that know no namespaces.
fn declare(text: &mut String, prefix: &str) {
    let Some(start) = text.find('<') else { return };
    let name = &text[start..];
    let end = name.find(|c: char| c.is_whitespace() || matches!(c, '>' | '/')).unwrap_or(name.len());
    text.insert_str(start + end, &format!(" xmlns:{prefix}=\"{prefix}\""));
}

/// The error of a text that is not XML, or ends too soon.
fn not_xml(file: &str, text: &str, fault: Fault) -> Error {
    let is_cut = matches!(fault, Fault::UnclosedRootNode | Fault::UnexpectedEndOfStream)
        || !text.trim_end().ends_with('>');
    let place = |before: &str| {
        let line = 1 + before.matches('\n').count();
        Place::line(file, line as u64, unfinished(before).unwrap_or_default())
    };
    if is_cut {
        let sentence = "the file ends here, before </robot>: it was cut; fetch or write it again";
        return Error::at(place(text.trim_end()), sentence);
    }
    let before =
        text.split('\n').take(fault.pos().row as usize - 1).map(|line| line.len() + 1).sum::<usize>();
    let end = (before + fault.pos().col as usize).min(text.len());
    let end = (0..=end).rev().find(|end| text.is_char_boundary(*end)).unwrap_or(0);
    Error::at(place(&text[..end]), "not a valid URDF").because(fault)
}

/// The link or joint that a text ends in.
fn unfinished(text: &str) -> Option<String> {
    let start = |kind: &str| text.rfind(&format!("<{kind} ")).map(|at| (at, kind.to_owned()));
    let (at, kind) = start("link").max(start("joint"))?;
    let (tag, rest) = text[at..].split_once('>').unwrap_or((&text[at..], ""));
    if tag.ends_with('/') || rest.contains(&format!("</{kind}>")) {
        return None;
    }
    let value = tag.split_once("name=")?.1;
    let quote = value.chars().next()?;
    let name = value[1..].split(quote).next()?;
    Some(format!("{kind} `{}`", super::urdf_notes::short(name)))
}

/// The elements directly in an element, of its namespace.
pub(super) fn children<'a, 'i>(node: Node<'a, 'i>) -> impl Iterator<Item = Node<'a, 'i>> {
    let space = node.document().root_element().tag_name().namespace();
    node.children().filter(move |child| child.is_element() && child.tag_name().namespace() == space)
}

/// Whether a text is a xacro: an element or attribute of its namespace, or an attribute with an expression in
/// it. Comments and texts may have whatever they like, and so may the declaration of the namespace, which
/// xacro leaves in what it expands.
pub(super) fn is_xacro(text: &str) -> bool {
    let is_own = |space: Option<&str>| space.is_some_and(|space| space.ends_with(XACRO) || space == "xacro");
    let has_expression = |value: &str| ["${", "$("].iter().any(|expression| value.contains(expression));
    let found = with_document("", text, |document| {
        document.descendants().filter(Node::is_element).any(|node| {
            is_own(node.tag_name().namespace())
                || node.attributes().any(|a| is_own(a.namespace()) || has_expression(a.value()))
        })
    });
    // such as an expression with a quote in it
    found.unwrap_or_else(|_| elements_alone(text).contains("<xacro:"))
}
