//! The elements and attributes of a URDF that are read, as a table: what stands here once is what the program
//! checks, mends, and suggests for a misspelt name.

/// How a value is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Value {
    Text,
    /// So many numbers, separated by spaces.
    Numbers(usize),
    /// Three numbers, or one for all three.
    Scale,
}

/// What stands for an attribute that is missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Missing {
    /// Nothing: it is an error.
    Error,
    /// Nothing: it may be missing.
    Nothing,
    /// A value.
    Value(&'static str),
}

/// An attribute.
pub(super) struct Attribute {
    pub name: &'static str,
    pub value: Value,
    pub missing: Missing,
}

/// How many elements of a name are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Count {
    All,
    /// The first, if there is one, as other parsers do.
    First,
    /// The first, which must be there.
    FirstOfSome,
}

/// An element.
pub(super) struct Element {
    pub name: &'static str,
    pub count: Count,
    pub attributes: &'static [Attribute],
    /// In the order in which the parser gets them.
    pub children: &'static [&'static Element],
    /// Attributes and children that mean something to other programs.
    pub passed_over: &'static [&'static str],
}

const fn text(name: &'static str, missing: Missing) -> Attribute {
    Attribute { name, value: Value::Text, missing }
}

const fn number(name: &'static str, missing: Missing) -> Attribute {
    numbers(name, 1, missing)
}

const fn numbers(name: &'static str, count: usize, missing: Missing) -> Attribute {
    Attribute { name, value: Value::Numbers(count), missing }
}

const fn leaf(name: &'static str, count: Count, attributes: &'static [Attribute]) -> Element {
    Element { name, count, attributes, children: &[], passed_over: &[] }
}

use Count::{All, First, FirstOfSome};
use Missing::{Error, Nothing};

const ZERO: Missing = Missing::Value("0");

const ORIGIN: Element = leaf(
    "origin",
    First,
    &[numbers("xyz", 3, Nothing), numbers("rpy", 3, Nothing), numbers("quat_xyzw", 4, Nothing)],
);

const BOX: Element = leaf("box", First, &[numbers("size", 3, Error)]);
const CYLINDER: Element = leaf("cylinder", First, &[number("radius", Error), number("length", Error)]);
const CAPSULE: Element = leaf("capsule", First, &[number("radius", Error), number("length", Error)]);
const SPHERE: Element = leaf("sphere", First, &[number("radius", Error)]);
const SCALE: Attribute = Attribute { name: "scale", value: Value::Scale, missing: Nothing };
const MESH: Element = leaf("mesh", First, &[text("filename", Error), SCALE]);

/// Its first shape alone is read.
pub(super) const GEOMETRY: Element = Element {
    name: "geometry",
    count: First,
    attributes: &[],
    children: &[&BOX, &CYLINDER, &CAPSULE, &SPHERE, &MESH],
    passed_over: &[],
};

pub(super) const COLOR: Element = leaf("color", First, &[numbers("rgba", 4, Error)]);
pub(super) const MATERIAL: Element = Element {
    name: "material",
    count: First,
    attributes: &[text("name", Nothing)],
    children: &[&COLOR],
    passed_over: &["texture"],
};
const MATERIALS: Element = Element { count: All, ..MATERIAL };

const VISUAL: Element = Element {
    name: "visual",
    count: All,
    attributes: &[],
    children: &[&ORIGIN, &GEOMETRY, &MATERIAL],
    passed_over: &["name", "cast_shadows", "meta"],
};
const COLLISION: Element = Element {
    name: "collision",
    count: All,
    attributes: &[],
    children: &[&ORIGIN, &GEOMETRY],
    passed_over: &["name", "group", "verbose", "material", "contact", "surface"],
};

const MASS: Element = leaf("mass", FirstOfSome, &[number("value", Error)]);
const INERTIA: Element = leaf(
    "inertia",
    FirstOfSome,
    &[
        number("ixx", Error),
        number("ixy", ZERO),
        number("ixz", ZERO),
        number("iyy", Error),
        number("iyz", ZERO),
        number("izz", Error),
    ],
);
pub(super) const INERTIAL: Element = Element {
    name: "inertial",
    count: First,
    attributes: &[],
    children: &[&ORIGIN, &MASS, &INERTIA],
    passed_over: &[],
};
/// An inertial without its inertia.
pub(super) const INERTIAL_OF_MASS: Element = Element { children: &[&ORIGIN, &MASS], ..INERTIAL };

const LINK: Element = Element {
    name: "link",
    count: All,
    attributes: &[text("name", Error)],
    children: &[&INERTIAL, &VISUAL, &COLLISION],
    passed_over: &["type", "sensor", "contact", "contacts", "self_collision_checking", "origin"],
};

const PARENT: Element = leaf("parent", FirstOfSome, &[text("link", Error)]);
const CHILD: Element = leaf("child", FirstOfSome, &[text("link", Error)]);
const AXIS: Element = leaf("axis", First, &[numbers("xyz", 3, Missing::Value("1 0 0"))]);
const MIMIC: Element =
    leaf("mimic", First, &[text("joint", Error), number("multiplier", Nothing), number("offset", Nothing)]);
const LIMIT: Element = Element {
    name: "limit",
    count: First,
    attributes: &[
        number("lower", ZERO),
        number("upper", ZERO),
        number("effort", ZERO),
        number("velocity", ZERO),
    ],
    children: &[],
    passed_over: &["acceleration", "deceleration", "jerk"],
};
/// A limit of a joint that turns without end.
const FREE_LIMIT: Element = Element {
    attributes: &[number("effort", ZERO), number("velocity", ZERO)],
    passed_over: &["lower", "upper", "acceleration", "deceleration", "jerk"],
    ..LIMIT
};

/// A joint with limits: revolute or prismatic.
pub(super) const JOINT: Element = Element {
    name: "joint",
    count: All,
    attributes: &[text("name", Error), text("type", Error)],
    children: &[&ORIGIN, &PARENT, &CHILD, &AXIS, &LIMIT, &MIMIC],
    passed_over: &["dynamics", "calibration", "safety_controller", "hardwareInterface"],
};
/// A continuous joint.
pub(super) const FREE_JOINT: Element =
    Element { children: &[&ORIGIN, &PARENT, &CHILD, &AXIS, &FREE_LIMIT, &MIMIC], ..JOINT };
/// A joint whose axis and limits nobody uses.
pub(super) const STILL_JOINT: Element = Element {
    children: &[&ORIGIN, &PARENT, &CHILD, &MIMIC],
    passed_over: &["axis", "limit", "dynamics", "calibration", "safety_controller", "hardwareInterface"],
    ..JOINT
};

/// The whole.
pub(super) const ROBOT: Element = Element {
    name: "robot",
    count: First,
    attributes: &[text("name", Missing::Value("robot"))],
    children: &[&LINK, &JOINT, &MATERIALS],
    passed_over: &["version", "gazebo", "transmission", "sensor", "ros2_control", "loop_joint"],
};

/// The kinds of joints that a URDF has.
pub(super) const JOINT_TYPES: [&str; 7] =
    ["fixed", "revolute", "continuous", "prismatic", "floating", "planar", "spherical"];
