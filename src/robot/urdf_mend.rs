//! The text of a URDF as `urdf_rs` reads it: what other parsers read and that one refuses, or reads
//! differently, is mended here, and nowhere else. Each mend leaves a note.

use super::urdf_grammar::{
    Attribute, COLOR, Count, Element, FREE_JOINT, GEOMETRY, INERTIAL, INERTIAL_OF_MASS, JOINT, JOINT_TYPES,
    MATERIAL, Missing, ROBOT, STILL_JOINT, Value,
};
use super::urdf_lines::{ItemLines, LineStarts};
use super::urdf_notes::{Notes, short};
use super::urdf_xml::{children, with_document};
use super::warning::RobotWarning;
use super::{MAX_LISTED, solid};
use crate::error::{Error, Place};
use crate::suggestion;
use roxmltree::{Document, Node};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// What stands in the mended text for a shape that is missing: one of no size, which is left out later.
const NO_SHAPE: &str = "<box size=\"0 0 0\"/>";
/// The version of URDF up to which `urdf_rs` gets the version: the next one refuses shapes of no size. Its limits
/// are written out.
const PASSED_VERSION: &str = " version=\"1.1\"";

/// The longest name, bytes: as long as a path may be. Every shape of a link is known by the link's.
const MAX_TEXT: usize = 4096;

/// A mended URDF.
pub(super) struct Mended {
    /// Its text, of the elements in the grammar alone, each as often as it may be there and in one order.
    pub text: String,
    /// Notes about what was mended.
    pub warnings: Vec<RobotWarning>,
    /// Faults of limits, by joint: they matter only where the joint is used.
    pub limit_faults: BTreeMap<String, Error>,
    pub lines: ItemLines,
}

/// Mends a URDF.
///
/// # Errors
/// What cannot be mended, with its line.
pub(super) fn mended(file: &str, text: &str) -> Result<Mended, Error> {
    with_document(file, text, |document| {
        if is_srdf(document.root_element()) {
            let what = "is an SRDF of MoveIt, not a URDF; use the URDF that it belongs to";
            return Err(Error::at(Place::file(file), what));
        }
        let mut mender = Mender::new(file, document);
        mender.element(document.root_element(), &ROBOT, "robot")?;
        let Mender { text, notes, limit_faults, lines, starts, .. } = mender;
        Ok(Mended { text, warnings: notes.warnings(&starts), limit_faults, lines })
    })?
}

/// Whether a robot has groups and the like of MoveIt, and no links.
fn is_srdf(robot: Node) -> bool {
    const ELEMENTS: [&str; 5] =
        ["group", "group_state", "end_effector", "virtual_joint", "disable_collisions"];
    let has = |names: &[&str]| children(robot).any(|child| names.contains(&child.tag_name().name()));
    has(&ELEMENTS) && !has(&["link"])
}

struct Mender<'a> {
    file: &'a str,
    /// Major and minor of the URDF's version.
    version: (u32, u32),
    text: String,
    notes: Notes,
    limit_faults: BTreeMap<String, Error>,
    /// The links and joints so far.
    names: BTreeSet<String>,
    starts: LineStarts,
    lines: ItemLines,
}

impl<'a> Mender<'a> {
    fn new(file: &'a str, document: &Document) -> Self {
        let version = document.root_element().attribute("version").and_then(|version| {
            let (major, minor) = version.trim().split_once('.')?;
            Some((major.parse().ok()?, minor.parse().ok()?))
        });
        Self {
            file,
            version: version.unwrap_or((1, 0)),
            text: String::new(),
            notes: Notes::default(),
            limit_faults: BTreeMap::new(),
            names: BTreeSet::new(),
            starts: LineStarts::new(document.input_text()),
            lines: ItemLines::default(),
        }
    }

    fn place(&self, node: Node, item: &str) -> Place {
        Place {
            file: self.file.to_owned(),
            line: Some(self.starts.line(node.range().start)),
            item: item.to_owned(),
        }
    }

    fn note(&mut self, what: String, node: Node, item: &str) {
        self.notes.add(what.clone(), item, node.range().start, || what);
    }

    /// Writes an element with what its rule has.
    fn element(&mut self, node: Node, rule: &Element, item: &str) -> Result<(), Error> {
        self.text += &format!("<{}", rule.name);
        if rule.name == ROBOT.name && self.version >= (1, 1) {
            self.text += PASSED_VERSION;
        }
        for attribute in rule.attributes {
            if let Some(value) = self.value(node, rule, attribute, item)? {
                self.write(attribute.name, &value);
            }
        }
        self.text.push('>');
        self.look_for_unknown(node, rule, item);
        match rule.name == GEOMETRY.name {
            true => self.shape(node, rule, item)?,
            false => rule.children.iter().try_for_each(|child| self.all(node, child, item))?,
        }
        self.text += &format!("</{}>", rule.name);
        Ok(())
    }

    /// Writes an attribute.
    fn write(&mut self, name: &str, value: &str) {
        self.text += &format!(" {name}=\"");
        for c in value.chars() {
            match c {
                '&' => self.text += "&amp;",
                '<' => self.text += "&lt;",
                '>' => self.text += "&gt;",
                '"' => self.text += "&quot;",
                // as an attribute's value is read
                c if c < ' ' => self.text.push(' '),
                c => self.text.push(c),
            }
        }
        self.text.push('"');
    }

    /// Writes the children that are read of one kind.
    fn all(&mut self, node: Node, rule: &Element, item: &str) -> Result<(), Error> {
        let found: Vec<Node> = children(node).filter(|child| child.has_tag_name(rule.name)).collect();
        let Some(first) = found.first() else {
            return self.none(node, rule, item);
        };
        if rule.count == Count::All {
            return found.iter().enumerate().try_for_each(|(i, child)| {
                let item = item_of(*child, rule, i, item);
                self.lines.add(&item, self.starts.line(child.range().start));
                self.child(*child, rule, &item)
            });
        }
        if found.len() > 1 {
            self.note(repeated(rule.name), found[1], item);
        }
        self.child(*first, rule, item)
    }

    /// What stands for an element that is not there.
    fn none(&mut self, node: Node, rule: &Element, item: &str) -> Result<(), Error> {
        if rule.name == GEOMETRY.name {
            self.text += &format!("<geometry>{NO_SHAPE}</geometry>");
        }
        match rule.count {
            Count::FirstOfSome => {
                Err(Error::missing(self.place(node, item), format_args!("<{}>", rule.name)))
            }
            Count::All | Count::First => Ok(()),
        }
    }

    /// Writes a child by what its kind needs.
    fn child(&mut self, node: Node, rule: &Element, item: &str) -> Result<(), Error> {
        match rule.name {
            "link" => self.unique(node, item)?,
            "joint" => {
                self.unique(node, item)?;
                let rule = self.joint_rule(node, item)?;
                return self.element(node, rule, item);
            }
            "inertial" => return self.inertial(node, item),
            "color" => return self.color(node, item),
            _ => {}
        }
        self.element(node, rule, item)
    }

    /// The check that no other link or joint has this one's name.
    fn unique(&mut self, node: Node, item: &str) -> Result<(), Error> {
        match self.names.insert(item.to_owned()) {
            true => Ok(()),
            false => Err(Error::duplicate(self.place(node, item), node.tag_name().name())),
        }
    }

    /// The rule for a joint of its type.
    fn joint_rule(&self, node: Node, item: &str) -> Result<&'static Element, Error> {
        match node.attribute("type") {
            Some("revolute" | "prismatic") | None => Ok(&JOINT),
            Some("continuous") => Ok(&FREE_JOINT),
            Some(other) if JOINT_TYPES.contains(&other) => Ok(&STILL_JOINT),
            Some(other) => {
                Err(Error::unknown(self.place(node, item), "type", &short(other), JOINT_TYPES, MAX_LISTED))
            }
        }
    }

    /// Writes the first shape of a geometry.
    fn shape(&mut self, node: Node, rule: &Element, item: &str) -> Result<(), Error> {
        let rule_of = |child: &Node| rule.children.iter().find(|rule| child.has_tag_name(rule.name));
        let mut shapes = children(node).filter_map(|child| Some((child, rule_of(&child)?)));
        let Some((first, rule)) = shapes.next() else {
            self.text += NO_SHAPE;
            return Ok(());
        };
        if let Some((second, _)) = shapes.next() {
            self.note("has more than one shape in its <geometry>; the first counts".to_owned(), second, item);
        }
        self.element(first, rule, item)
    }

    /// Writes an inertial: one without a mass is none, and one without an inertia has that of a ball.
    fn inertial(&mut self, node: Node, item: &str) -> Result<(), Error> {
        let child = |name: &str| children(node).find(|child| child.has_tag_name(name));
        let Some(mass) = child("mass").filter(|mass| mass.has_attribute("value")) else {
            self.note("has an <inertial> without a mass, which is left out".to_owned(), node, item);
            return Ok(());
        };
        let is_whole = |inertia: &Node| ["ixx", "iyy", "izz"].iter().all(|key| inertia.has_attribute(*key));
        if child("inertia").is_some_and(|inertia| is_whole(&inertia)) {
            return self.element(node, &INERTIAL, item);
        }
        self.element(node, &INERTIAL_OF_MASS, item)?;
        self.text.truncate(self.text.len() - "</inertial>".len());
        let mass = mass.attribute("value").and_then(|value| value.trim().parse().ok()).unwrap_or(0.0);
        let inertia = solid::ball_inertia(mass);
        let zero = "ixy=\"0\" ixz=\"0\" iyz=\"0\"";
        let _ = write!(
            self.text,
            "<inertia ixx=\"{inertia:?}\" iyy=\"{inertia:?}\" izz=\"{inertia:?}\" {zero}/></inertial>"
        );
        if mass > 0.0 {
            self.note(format!("has a mass without an inertia; {}", solid::BALL), node, item);
        }
        Ok(())
    }

    /// Writes a colour; one that is none is left out, since nothing is computed with it.
    fn color(&mut self, node: Node, item: &str) -> Result<(), Error> {
        let rgba: Vec<_> =
            node.attribute("rgba").unwrap_or_default().split_whitespace().map(str::parse::<f64>).collect();
        let is_one =
            rgba.len() == 4 && rgba.iter().all(|part| matches!(part, Ok(part) if (0.0..=1.0).contains(part)));
        if is_one {
            return self.element(node, &COLOR, item);
        }
        let given = short(node.attribute("rgba").unwrap_or_default());
        let what = format!("has no colour: rgba = {given:?}; it must be 4 numbers from 0 to 1");
        self.note(what, node, item);
        Ok(())
    }

    /// The value of an attribute, as the parser gets it.
    fn value(
        &mut self,
        node: Node,
        rule: &Element,
        attribute: &Attribute,
        item: &str,
    ) -> Result<Option<String>, Error> {
        let Some(value) = node.attribute(attribute.name) else {
            return self.missing(node, rule, attribute, item);
        };
        let count = match attribute.value {
            Value::Text if value.len() > MAX_TEXT => {
                let found = format!("{} {} has {} bytes", rule.name, attribute.name, value.len());
                let place = self.place(node, rule.name);
                return Err(Error::bad(place, found, &format!("at most {MAX_TEXT} bytes long")));
            }
            Value::Text => return Ok(Some(value.to_owned())),
            Value::Numbers(count) => count,
            Value::Scale => 3,
        };
        let numbers: Vec<&str> = value.split_whitespace().collect();
        let are_numbers = numbers.iter().all(|number| number.parse::<f64>().is_ok());
        if let ([one], Value::Scale, true) = (&numbers[..], attribute.value, are_numbers) {
            self.note(
                format!("has a scale of one number, {}, which is taken for all axes", short(one)),
                node,
                item,
            );
            return Ok(Some([*one; 3].join(" ")));
        }
        if are_numbers && numbers.len() == count {
            return Ok(Some(value.trim().to_owned()));
        }
        let fault = self.not_numbers(node, rule, attribute, value, count, item);
        let joint = node.parent().and_then(|joint| joint.attribute("name"));
        if let ("limit", Some(joint)) = (rule.name, joint) {
            self.limit_faults.entry(joint.to_owned()).or_insert(fault);
            return Ok(Some("0".to_owned()));
        }
        Err(fault)
    }

    fn not_numbers(
        &self,
        node: Node,
        rule: &Element,
        attribute: &Attribute,
        value: &str,
        count: usize,
        item: &str,
    ) -> Error {
        let found = format!("{} {} = {:?}", rule.name, attribute.name, short(value));
        let expected = match count {
            1 => "a number".to_owned(),
            count => format!("{count} numbers, separated by spaces"),
        };
        Error::bad(self.place(node, item), found, &expected)
    }

    /// What stands for an attribute that is missing.
    fn missing(
        &self,
        node: Node,
        rule: &Element,
        attribute: &Attribute,
        item: &str,
    ) -> Result<Option<String>, Error> {
        match attribute.missing {
            // a limit that is not given is none
            Missing::Value(_) if rule.name == "limit" && self.version >= (1, 2) => {
                Ok(Some(if attribute.name == "lower" { "-inf" } else { "inf" }.to_owned()))
            }
            Missing::Value(value) => Ok(Some(value.to_owned())),
            Missing::Nothing if rule.name == MATERIAL.name => {
                Ok(Some(format!("at byte {}", node.range().start)))
            }
            Missing::Nothing => Ok(None),
            Missing::Error => {
                let needed = format!("the attribute `{}` of <{}>", attribute.name, rule.name);
                Err(Error::missing(self.place(node, item), needed))
            }
        }
    }

    /// Notes attributes that the rule does not have, and children that may be misspelt.
    fn look_for_unknown(&mut self, node: Node, rule: &Element, item: &str) {
        let known = || rule.attributes.iter().map(|attribute| attribute.name);
        let is_known = |name: &str| rule.passed_over.contains(&name) || known().any(|other| other == name);
        for attribute in node.attributes().filter(|a| a.namespace().is_none() && !is_known(a.name())) {
            let what = format!("has an attribute `{}` of <{}>", short(attribute.name()), rule.name);
            let hint = || suggestion::hint(&short(attribute.name()), known());
            let sentence = || format!("{what}, which a URDF does not have: it does nothing{}", hint());
            self.notes.add(what.clone(), item, node.range().start, sentence);
        }
        let names = || rule.children.iter().map(|child| child.name);
        let is_known = |name: &str| rule.passed_over.contains(&name) || names().any(|other| other == name);
        for child in children(node).filter(|child| !is_known(child.tag_name().name())) {
            let name = short(child.tag_name().name());
            if let Some(near) = suggestion::nearest(&name, names()) {
                let what = format!(
                    "has an element <{name}>, which a URDF does not have: it does nothing; did you mean <{near}>?"
                );
                self.note(what, child, item);
            }
        }
    }
}

/// The note on an element that is repeated.
fn repeated(name: &str) -> String {
    format!("has more than one <{name}>; the first counts, as in other parsers")
}

/// The name of a child in errors and notes.
fn item_of(node: Node, rule: &Element, i: usize, item: &str) -> String {
    match (rule.name, node.attribute("name")) {
        ("link" | "joint" | "material", Some(name)) => format!("{} `{name}`", rule.name),
        ("link" | "joint" | "material", None) => rule.name.to_owned(),
        _ => format!("{item}, {} {}", rule.name, i + 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_keep_their_characters() {
        for name in ["a\u{85}b", "a\u{2028}b", "a\u{7f}b", "<a & \"b\">", "\u{202e}\u{feff}机"] {
            let escaped = name.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
            let text = format!("<robot name=\"r\"><link name=\"{escaped}\"/></robot>");
            let mended = mended("r.urdf", &text).expect("a URDF");
            let robot = urdf_rs::read_from_string(&mended.text).expect("a URDF");
            assert_eq!(robot.links[0].name, name);
        }
    }
}
