//! A URDF's links, parents before children, with every number checked. No other file uses `urdf_rs`, or
//! `xml`, its first parser.

use super::arm::bad_limits;
use super::hull::{self, Collision, Convex};
use super::link::{Coupling, Geometry, Inertial, Joint, JointKind, Limits, Link, Mimic, Shape};
use super::mesh::{self, MeshFolders};
use super::tree::{self, Edge, Spot};
use super::warning::{RobotWarning, WarningKind, some_of};
use crate::error::{Error, Place};
use crate::geometry::Pose;
use crate::guarded;
use crate::located::Source;
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// The largest magnitude of a number in a URDF. Larger numbers are errors, and their squares would lose
/// digits.
const MAX_NUMBER: f64 = 1e6;
/// The deepest nesting of elements; the parser recurses once per level.
const MAX_DEPTH: usize = 64;
/// The largest number of attributes of an element; parsers compare each with all others.
const MAX_ATTRIBUTES: usize = 64;
/// The largest number of elements, and of elements, texts and comments.
const MAX_ELEMENTS: usize = 50_000;
const MAX_PIECES: usize = 500_000;
/// The largest total length of namespaces and their prefixes, bytes; the parser copies them into every
/// element after them.
const MAX_NAMESPACES: usize = 4096;
/// The largest total size of the collision meshes of a robot, bytes.
const MAX_MESH_BYTES: u64 = 1 << 30;
/// The largest number of collision meshes of a robot: one takes up to a second.
const MAX_MESHES: usize = 200;
/// The namespace of namespaces.
const XMLNS: &str = "http://www.w3.org/2000/xmlns/";

/// The convex shapes of collision meshes, by their names in the URDF.
pub(super) type Hulls = BTreeMap<String, Convex>;

/// A URDF being read: its name in errors, and the folders in which meshes are searched for. Without folders,
/// meshes are not searched for.
#[derive(Clone, Copy)]
pub(super) struct Urdf<'a> {
    pub file: &'a str,
    pub folders: Option<&'a MeshFolders>,
    pub hulls: Option<&'a Hulls>,
}

/// The links of a URDF with all that was found wrong with single items.
#[derive(Default)]
pub(super) struct Links {
    /// Parents before children, otherwise in the order of their joints.
    pub links: Vec<Link>,
    /// Faults of single items. The links are then incomplete.
    pub faults: Vec<Error>,
    pub warnings: Vec<RobotWarning>,
}

impl Urdf<'_> {
    pub fn place(self, item: String) -> Place {
        Place::item(self.file, item)
    }

    /// The links of the URDF. The error is a fault of the file or of the tree.
    pub fn links(self, text: &str) -> Result<Links, Error> {
        self.check_extent(text)?;
        let urdf = parsed(text).map_err(|error| Source { file: self.file, text }.invalid("URDF", error))?;
        if urdf.links.is_empty() {
            return Err(Error::missing(self.place("robot".to_owned()), "links"));
        }
        self.all_differ("link", urdf.links.iter().map(|l| &l.name))?;
        self.all_differ("joint", urdf.joints.iter().map(|j| &j.name))?;
        let colors = colors(&urdf);
        let names = urdf.links.iter().map(|l| l.name.as_str()).collect();
        let edges =
            urdf.joints.iter().map(|j| Edge { joint: &j.name, parent: &j.parent.link, child: &j.child.link });
        let mut read = Links::default();
        let (mut missing, mut with_hulls) = (Vec::new(), Vec::new());
        for Spot { link, parent, joint } in tree::order(self.file, names, &edges.collect::<Vec<_>>())? {
            let link = &urdf.links[link];
            let mut keep = |fault| read.faults.push(fault);
            let check = Check { urdf: self, item: format!("link `{}`", link.name) };
            let shapes = |kind: &str, i: usize| Check {
                urdf: self,
                item: format!("link `{}`, {kind} {}", link.name, i + 1),
            };
            let joint = joint.and_then(|j| self.joint(&urdf.joints[j]).map_err(&mut keep).ok());
            let inertial = check.inertial(&link.inertial).map_err(&mut keep).ok().flatten();
            let mut visuals = Vec::new();
            for (i, v) in link.visual.iter().enumerate() {
                let check = shapes("visual", i);
                let color = v.material.as_ref().and_then(|m| colors.get(&m.name).copied());
                let color = color.map(|c| check.color(c)).transpose().map_err(&mut keep).ok().flatten();
                let mesh = match self.file_of(&v.geometry) {
                    Some(Err(why)) => {
                        missing.extend(mesh_name(&v.geometry).map(|name| (name, why)));
                        continue;
                    }
                    Some(Ok(file)) => Some(file),
                    None => None,
                };
                visuals.extend(check.geometry(&v.origin, &v.geometry, color, mesh).map_err(&mut keep));
            }
            let mut collisions = Vec::new();
            for (i, c) in link.collision.iter().enumerate() {
                // a mesh that is not at hand may still have its hull
                let mesh = self.file_of(&c.geometry);
                let file =
                    mesh.map(|found| found.unwrap_or_else(|_| mesh_name(&c.geometry).unwrap_or("").into()));
                let shape = shapes("collision", i).geometry(&c.origin, &c.geometry, None, file);
                let shape = shape.map_err(&mut keep).ok();
                collisions.extend(shape.into_iter().flat_map(|shape| self.with_hulls(shape, &c.geometry)));
            }
            let has_hull = |c: &Geometry| matches!(&c.shape, Shape::Mesh { hull, .. } if !hull.is_empty());
            if collisions.iter().any(has_hull) && link.collision.iter().any(|c| self.is_one_hull(&c.geometry))
            {
                with_hulls.push(link.name.as_str());
            }
            read.links.push(Link { name: link.name.clone(), parent, joint, inertial, visuals, collisions });
        }
        if let Some((first, why)) = missing.first() {
            let count = missing.len();
            read.warnings.push(RobotWarning::new(format!(
                "{count} meshes to draw are missing, the first of them `{first}`: searched for {why}"
            )));
        }
        if !with_hulls.is_empty() {
            let (count, links) = (with_hulls.len(), some_of(&with_hulls));
            read.warnings.push(RobotWarning::new(format!(
                "collision meshes of {count} links collide as their convex hulls: {links}"
            )));
        }
        Ok(read)
    }

    /// The hulls of all collision meshes that can be found and read, and warnings about the others. Both are
    /// empty for a URDF that is not valid.
    pub fn collision_hulls(self, text: &str) -> (Hulls, Vec<RobotWarning>) {
        let (mut hulls, mut warnings) = (Hulls::new(), Vec::new());
        // why a mesh has no hull, if it has none: every file is read once
        let mut known: BTreeMap<&str, Option<String>> = BTreeMap::new();
        let mut left = MAX_MESH_BYTES;
        let urdf = self.check_extent(text).ok().and_then(|()| parsed(text).ok());
        let links = urdf.iter().flat_map(|urdf| &urdf.links);
        for (link, geometry) in links.flat_map(|l| l.collision.iter().map(move |c| (&l.name, &c.geometry))) {
            let Some(mesh) = mesh_name(geometry) else { continue };
            let why = match known.get(mesh) {
                Some(why) => why.clone(),
                None => {
                    let Some(found) = self.file_of(geometry) else { continue };
                    let is_one_more = known.len() < MAX_MESHES;
                    let found = match is_one_more {
                        true => found,
                        false => Err(format!("no more than {MAX_MESHES} meshes")),
                    };
                    let read = found.map_err(|why| format!("searched for {why}")).and_then(|file| {
                        let of_file = |why| format!("{}: {why}", file.display());
                        let length = std::fs::metadata(&file).map_or(0, |data| data.len());
                        left = left.checked_sub(length).ok_or_else(|| {
                            of_file(format!("it and the meshes before it exceed {MAX_MESH_BYTES} bytes"))
                        })?;
                        hull::collision(&file).map_err(of_file)
                    });
                    let why = read.map(|collision| {
                        warnings.extend(about_mesh(link, mesh, &collision));
                        hulls.insert(mesh.to_owned(), collision.convex);
                    });
                    let why = why.err();
                    known.insert(mesh, why.clone());
                    why
                }
            };
            warnings.extend(why.map(|why| {
                let about = format!("link `{link}`: its collision mesh `{mesh}` has no shape: {why}");
                RobotWarning::of_kind(WarningKind::MissingShape, about)
            }));
        }
        (hulls, warnings)
    }

    /// Whether a mesh collides as a single hull.
    fn is_one_hull(self, geometry: &urdf_rs::Geometry) -> bool {
        let convex = mesh_name(geometry).and_then(|mesh| self.hulls?.get(mesh));
        matches!(convex, Some(Convex::Hull(_)))
    }

    /// A collision shape; a mesh once for each of its hulls, with the hull.
    fn with_hulls(self, shape: Geometry, geometry: &urdf_rs::Geometry) -> Vec<Geometry> {
        let (Shape::Mesh { file, scale, .. }, Some(mesh)) = (&shape.shape, mesh_name(geometry)) else {
            return vec![shape];
        };
        let convex = self.hulls.and_then(|hulls| hulls.get(mesh));
        let scaled = |v: &[f64; 3]| Vector3::from(*v).component_mul(scale);
        let hulls = convex.into_iter().flat_map(Convex::hulls).map(|hull| hull.iter().map(scaled).collect());
        // a scale of 0 makes any mesh flat
        let solid: Vec<Vec<_>> = hulls.filter(|hull: &Vec<_>| hull::is_solid(hull)).collect();
        if solid.is_empty() {
            return vec![shape];
        }
        let with =
            |hull| Geometry { shape: Shape::Mesh { file: file.clone(), scale: *scale, hull }, ..shape };
        solid.into_iter().map(with).collect()
    }

    /// The file of a mesh, or the places searched; `None` for another shape. Without folders, the name as it
    /// is.
    fn file_of(self, geometry: &urdf_rs::Geometry) -> Option<Result<PathBuf, String>> {
        let name = mesh_name(geometry)?;
        Some(self.folders.map_or_else(|| Ok(PathBuf::from(name)), |folders| mesh::find(name, folders)))
    }

    /// The check that the parser's stack and memory stay within bounds, by the events of the parser itself.
    pub fn check_extent(self, text: &str) -> Result<(), Error> {
        let robot = Check { urdf: self, item: "robot".to_owned() };
        let check = |field: &str, found: usize, most: usize| {
            robot.number(field, found as f64, found <= most, &format!("at most {most}"))
        };
        let (mut depth, mut elements, mut namespaces, mut pieces) = (0, 0, 0, 0);
        let mut parser = xml::Parser::new();
        parser.feed_str(text);
        // the parser proper reports errors
        for event in parser.map_while(Result::ok) {
            pieces += 1;
            check("number of its elements, texts and comments", pieces, MAX_PIECES)?;
            match event {
                xml::Event::ElementStart(tag) => {
                    (depth, elements) = (depth + 1, elements + 1);
                    let declared = tag.attributes.iter().filter(|((name, space), _)| {
                        name == "xmlns" || space.as_deref().is_some_and(|space| space == XMLNS)
                    });
                    namespaces += declared.map(|((name, _), value)| name.len() + value.len()).sum::<usize>();
                    check("depth of its elements", depth, MAX_DEPTH)?;
                    check("number of its elements", elements, MAX_ELEMENTS)?;
                    check("length of its namespaces", namespaces, MAX_NAMESPACES)?;
                    check("number of an element's attributes", tag.attributes.len(), MAX_ATTRIBUTES)?;
                }
                xml::Event::ElementEnd(_) if depth <= 1 => break,
                xml::Event::ElementEnd(_) => depth -= 1,
                _ => {}
            }
        }
        Ok(())
    }

    fn all_differ<'n>(self, kind: &str, names: impl Iterator<Item = &'n String>) -> Result<(), Error> {
        let mut seen = BTreeSet::new();
        for name in names {
            if !seen.insert(name) {
                return Err(Error::duplicate(self.place(format!("{kind} `{name}`")), kind));
            }
        }
        Ok(())
    }

    fn joint(self, joint: &urdf_rs::Joint) -> Result<Joint, Error> {
        use urdf_rs::JointType as Kind;
        let check = Check { urdf: self, item: format!("joint `{}`", joint.name) };
        let kind = match joint.joint_type {
            Kind::Fixed => JointKind::Fixed,
            Kind::Revolute => JointKind::Revolute,
            Kind::Continuous => JointKind::Continuous,
            Kind::Prismatic => JointKind::Prismatic,
            Kind::Floating => JointKind::Floating,
            Kind::Planar => JointKind::Planar,
            Kind::Spherical => JointKind::Spherical,
        };
        let axis = match kind {
            JointKind::Revolute | JointKind::Continuous | JointKind::Prismatic => {
                check.axis(&joint.axis.xyz.0)?
            }
            _ => Vector3::x_axis(),
        };
        let mimic = joint.mimic.as_ref().map(|m| {
            let ratio = check.finite("mimic multiplier", m.multiplier.unwrap_or(1.0))?;
            let offset = check.finite("mimic offset", m.offset.unwrap_or(0.0))?;
            Ok::<_, Error>(Mimic { joint: m.joint.clone(), ratio, offset })
        });
        Ok(Joint {
            name: joint.name.clone(),
            kind,
            parent_from_joint: check.pose(&joint.origin)?,
            axis,
            limits: check.limits(kind, &joint.limit)?,
            mimic: mimic.transpose()?,
            coupling: Coupling { joint: None, ratio: 1.0, offset: 0.0 },
        })
    }
}

/// Parses a URDF whose extent was checked, with the third-party parser.
fn parsed(text: &str) -> Result<urdf_rs::Robot, Box<dyn std::error::Error + Send + Sync>> {
    Ok(guarded::on_thread(|| urdf_rs::read_from_string(text))??)
}

/// Warnings about a mesh that has a shape.
fn about_mesh(link: &str, mesh: &str, collision: &Collision) -> Vec<RobotWarning> {
    let about = |sentence: String| {
        RobotWarning::new(format!("link `{link}`: its collision mesh `{mesh}` {sentence}"))
    };
    let remark = collision.remark.as_ref().map(|remark| about(format!("may be damaged: {remark}")));
    let parts = match &collision.convex {
        Convex::Hull(_) => None,
        Convex::Parts(parts) => {
            let (percent, count) = (100.0 * collision.filled.unwrap_or(1.0), parts.len());
            Some(about(format!(
                "fills {percent:.0} % of its convex hull, and collides as {count} convex parts"
            )))
        }
    };
    remark.into_iter().chain(parts).collect()
}

/// The name of a mesh; `None` for another shape.
fn mesh_name(geometry: &urdf_rs::Geometry) -> Option<&str> {
    match geometry {
        urdf_rs::Geometry::Mesh { filename, .. } => Some(filename),
        _ => None,
    }
}

/// Whether a text is a xacro: an element or attribute of its namespace, or an attribute with an expression in
/// it. Comments and texts may have whatever they like, and so may the declaration of the namespace, which
/// xacro leaves in what it expands.
pub(super) fn is_xacro(text: &str) -> bool {
    let mut parser = xml::Parser::new();
    parser.feed_str(text);
    for event in parser {
        match event {
            Ok(xml::Event::ElementStart(tag)) => {
                let is_own = |space: &Option<String>| space.as_deref().is_some_and(|s| s.ends_with("/xacro"));
                let has_expression = |value: &String| ["${", "$("].iter().any(|e| value.contains(e));
                let mut attributes = tag.attributes.iter();
                if tag.prefix.as_deref() == Some("xacro")
                    || is_own(&tag.ns)
                    || attributes.any(|((_, space), value)| is_own(space) || has_expression(value))
                {
                    return true;
                }
            }
            Ok(_) => {}
            // such as the prefix of xacro without its namespace
            Err(_) => {
                let outside =
                    text.split("<!--").map(|part| part.split_once("-->").map_or(part, |(_, rest)| rest));
                return outside.into_iter().any(|part| part.contains("<xacro:"));
            }
        }
    }
    false
}

/// The colours of materials. A colour given anywhere holds everywhere.
fn colors(urdf: &urdf_rs::Robot) -> BTreeMap<String, [f64; 4]> {
    let on_links = urdf.links.iter().flat_map(|l| &l.visual).filter_map(|v| v.material.as_ref());
    let all = on_links.chain(&urdf.materials);
    all.filter_map(|m| m.color.as_ref().map(|c| (m.name.clone(), c.rgba.0))).collect()
}

/// Checks for the numbers of one item.
struct Check<'a> {
    urdf: Urdf<'a>,
    item: String,
}

impl Check<'_> {
    fn number(&self, field: &str, value: f64, is_good: bool, expected: &str) -> Result<f64, Error> {
        match is_good {
            true => Ok(value),
            false => Err(Error::number(self.urdf.place(self.item.clone()), field, value, expected)),
        }
    }

    fn finite(&self, field: &str, value: f64) -> Result<f64, Error> {
        self.number(field, value, value.abs() <= MAX_NUMBER, "a number from -1000000 to 1000000")
    }

    fn positive(&self, field: &str, value: f64) -> Result<f64, Error> {
        self.number(field, value, value > 0.0 && value <= MAX_NUMBER, "greater than 0, at most 1000000")
    }

    fn vector(&self, field: &str, values: &[f64; 3]) -> Result<Vector3<f64>, Error> {
        for (name, value) in ["[0]", "[1]", "[2]"].iter().zip(values) {
            self.finite(&format!("{field}{name}"), *value)?;
        }
        Ok(Vector3::from(*values))
    }

    fn axis(&self, values: &[f64; 3]) -> Result<Unit<Vector3<f64>>, Error> {
        let axis = self.vector("axis xyz", values)?;
        let (norm, expected) = (axis.norm(), "greater than 0, to give the direction of motion");
        let bad = || Error::number(self.urdf.place(self.item.clone()), "length of axis xyz", norm, expected);
        Unit::try_new(axis, 1e-9).ok_or_else(bad)
    }

    fn pose(&self, origin: &urdf_rs::Pose) -> Result<Pose, Error> {
        let xyz = self.vector("origin xyz", &origin.xyz.0)?;
        let rpy = self.vector("origin rpy", &origin.rpy.0)?;
        Ok(Pose::from_parts(xyz.into(), Rotation3::from_euler_angles(rpy.x, rpy.y, rpy.z)))
    }

    fn limits(&self, kind: JointKind, limit: &urdf_rs::JointLimit) -> Result<Limits, Error> {
        let (lower, upper) = match kind {
            JointKind::Revolute | JointKind::Prismatic => {
                let lower = self.finite("limit lower", limit.lower)?;
                (lower, self.finite("limit upper", limit.upper)?)
            }
            JointKind::Continuous => (f64::NEG_INFINITY, f64::INFINITY),
            _ => (0.0, 0.0),
        };
        if lower > upper {
            return Err(bad_limits(self.urdf.place(self.item.clone()), lower, upper));
        }
        let at_least_0 = |field, value: f64| self.number(field, value, value >= 0.0, "at least 0");
        let rate = at_least_0("limit velocity", limit.velocity)?;
        let effort = at_least_0("limit effort", limit.effort)?;
        Ok(Limits { lower, upper, rate, effort: if effort > 0.0 { effort } else { f64::INFINITY } })
    }

    fn inertial(&self, inertial: &urdf_rs::Inertial) -> Result<Option<Inertial>, Error> {
        let mass = inertial.mass.value;
        self.number("mass", mass, (0.0..=MAX_NUMBER).contains(&mass), "from 0 to 1000000 kg")?;
        let i = &inertial.inertia;
        for (field, value) in
            [("ixx", i.ixx), ("ixy", i.ixy), ("ixz", i.ixz), ("iyy", i.iyy), ("iyz", i.iyz), ("izz", i.izz)]
        {
            self.finite(field, value)?;
        }
        let inertia = Matrix3::new(i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz);
        let center = self.pose(&inertial.origin)?;
        let has_body = mass > 0.0 || inertia.amax() > 0.0;
        Ok(has_body.then_some(Inertial { mass, center, inertia }))
    }

    fn color(&self, rgba: [f64; 4]) -> Result<[f32; 4], Error> {
        for value in rgba {
            self.number("color rgba", value, (0.0..=1.0).contains(&value), "from 0 to 1")?;
        }
        Ok(rgba.map(|c| c as f32))
    }

    fn geometry(
        &self,
        origin: &urdf_rs::Pose,
        geometry: &urdf_rs::Geometry,
        color: Option<[f32; 4]>,
        mesh: Option<PathBuf>,
    ) -> Result<Geometry, Error> {
        use urdf_rs::Geometry as G;
        let round = |radius: &f64, length: &f64| {
            Ok::<_, Error>((self.positive("radius", *radius)?, self.positive("length", *length)?))
        };
        let shape = match geometry {
            G::Box { size } => {
                size.iter().try_for_each(|s| self.positive("box size", *s).map(drop))?;
                Shape::Box { size: Vector3::from(size.0) }
            }
            G::Cylinder { radius, length } => {
                let (radius, length) = round(radius, length)?;
                Shape::Cylinder { radius, length }
            }
            G::Capsule { radius, length } => {
                let (radius, length) = round(radius, length)?;
                Shape::Capsule { radius, length }
            }
            G::Sphere { radius } => Shape::Sphere { radius: self.positive("radius", *radius)? },
            G::Mesh { scale, .. } => {
                let scale = self.vector("mesh scale", &scale.map_or([1.0; 3], |s| s.0))?;
                Shape::Mesh {
                    file: mesh.expect("a mesh was found before its shape is read"),
                    scale,
                    hull: Vec::new(),
                }
            }
        };
        Ok(Geometry { link_from_shape: self.pose(origin)?, shape, color })
    }
}
