//! The bounds of a drawing, checked before `usvg` reads it: that copies whatever an element refers to, which
//! refers to more, and compares every rule of a style sheet with every element.

use cocarry::xml_extent::XmlExtent;
use std::collections::HashMap;
use usvg::roxmltree::{Document, Node, NodeId};

/// The extent of a drawing as text.
pub(crate) const DRAWING: XmlExtent = XmlExtent { depth: 128, tags: 200_000, attributes: 128 };
/// The largest number of elements of a drawing, each counted as often as it is referred to.
const MAX_ELEMENTS: u64 = 300_000;
/// The longest chain of references.
const MAX_CHAIN: usize = 32;
/// The largest number of rules of style sheets times elements.
const MAX_MATCHES: usize = 20_000_000;

/// The check of a drawing whose extent as text was checked.
pub(crate) fn check(document: &Document) -> Result<(), String> {
    let elements = document.descendants().filter(Node::is_element);
    let styles = elements.clone().filter(|node| node.has_tag_name("style"));
    let sheets: Vec<&str> =
        styles.flat_map(|style| style.children()).filter_map(|text| text.text()).collect();
    let rules: usize = sheets.iter().map(|sheet| sheet.matches('{').count()).sum();
    let count = elements.clone().count();
    if rules.saturating_mul(count) > MAX_MATCHES {
        return Err(format!(
            "it has {rules} rules of style for {count} elements; their product must be at most {MAX_MATCHES}"
        ));
    }
    let ids = elements.clone().filter_map(|node| Some((node.attribute("id")?, node))).collect();
    let mut sizes = Sizes { ids, known: HashMap::new() };
    let mut size = sizes.of(document.root_element(), 0)?;
    // a rule may hold for every element
    for target in sheets.iter().flat_map(|sheet| references(sheet)) {
        let target = sizes.ids.get(target).copied();
        let of_target = target.map_or(Ok(0), |target| sizes.of(target, 0))?;
        size = size.saturating_add(of_target.saturating_mul(count as u64));
    }
    bounded(size)
}

fn bounded(size: u64) -> Result<(), String> {
    match size <= MAX_ELEMENTS {
        true => Ok(()),
        false => Err(format!("it has more than {MAX_ELEMENTS} elements, with those that others refer to")),
    }
}

/// The numbers of elements below others.
struct Sizes<'a, 'input> {
    ids: HashMap<&'a str, Node<'a, 'input>>,
    known: HashMap<NodeId, u64>,
}

impl<'a, 'input> Sizes<'a, 'input> {
    /// The number of elements that are drawn for an element, itself included, after this many references.
    fn of(&mut self, node: Node<'a, 'input>, chain: usize) -> Result<u64, String> {
        if let Some(size) = self.known.get(&node.id()) {
            return Ok(*size);
        }
        if chain > MAX_CHAIN {
            return Err(format!("its elements refer to others in chains longer than {MAX_CHAIN}"));
        }
        // a circle is drawn once at most
        self.known.insert(node.id(), 0);
        let mut size = 1_u64;
        for attribute in node.attributes() {
            let value = attribute.value();
            let whole = value.trim().strip_prefix('#').filter(|_| attribute.name() == "href");
            for target in references(value).chain(whole) {
                if let Some(target) = self.ids.get(target).copied() {
                    size = size.saturating_add(self.of(target, chain + 1)?);
                }
            }
        }
        // a marker is drawn at every corner
        let is_marked =
            node.attributes().any(|a| a.name().starts_with("marker") || a.value().contains("marker"));
        if is_marked {
            let length = node.attribute("d").or(node.attribute("points")).map_or(0, str::len);
            size = size.saturating_mul(1 + length as u64 / 2);
        }
        for child in node.children().filter(Node::is_element) {
            size = size.saturating_add(self.of(child, chain)?);
        }
        bounded(size)?;
        self.known.insert(node.id(), size);
        Ok(size)
    }
}

/// The names in `url(#name)`.
fn references(text: &str) -> impl Iterator<Item = &str> {
    text.split("url(").skip(1).filter_map(|rest| {
        let name = rest.split_once(')').map_or(rest, |(name, _)| name);
        name.trim_matches(['"', '\'', ' ']).strip_prefix('#')
    })
}
