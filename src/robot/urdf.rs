//! A URDF's links, parents before children, with every number checked. Only this file, `urdf_check` and
//! `urdf_shapes` use `urdf_rs`.

use super::hull::{self, Convex};
use super::link::{Coupling, Geometry, Joint, JointKind, Limits, Link, Mimic, Shape};
use super::mesh::{FoundMesh, MAX_MESHES, MeshFinder, MeshFolders};
use super::tree::{self, Edge, Spot};
use super::urdf_check::Check;
use super::urdf_lines::ItemLines;
use super::urdf_mend::{Mended, mended};
use super::urdf_shapes::{ShapeNotes, about_mesh, drawn, has_no_size, mesh_name, with_hulls};
use super::urdf_xml::with_document;
use super::warning::{RobotWarning, WarningKind};
use crate::error::{Error, Place};
use crate::guarded;
use crate::located::Source;
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// The largest total size of the collision meshes of a robot, bytes.
const MAX_MESH_BYTES: u64 = 1 << 30;

/// What is said of a text with bytes that could not be decoded.
const GARBLED: &str = "the URDF has bytes that are not of the encoding that it declares (UTF-8 where it declares none), or declares none of UTF-8, UTF-16 and Latin-1: what could not be read became U+FFFD";

/// The convex shapes of collision meshes, by their names in the URDF.
pub(super) type Hulls = BTreeMap<String, Convex>;

/// A URDF being read: its name in errors, its text, and the folders in which meshes are searched for. Without
/// folders, meshes are not searched for.
#[derive(Clone, Copy)]
pub(super) struct Urdf<'a> {
    pub file: &'a str,
    pub text: &'a str,
    pub folders: Option<&'a MeshFolders>,
    pub hulls: Option<&'a Hulls>,
    /// The lines of its items, once it is parsed.
    pub lines: Option<&'a ItemLines>,
}

/// The links of a URDF with all that was found wrong with single items.
#[derive(Default)]
pub(super) struct Links {
    /// Parents before children, otherwise in the order of their joints.
    pub links: Vec<Link>,
    /// Faults of single items. The links are then incomplete.
    pub faults: Vec<Error>,
    /// Faults of joints, by their links, that matter where the robot uses the joint. Such a joint has no
    /// limits here.
    pub joint_faults: BTreeMap<usize, Error>,
    pub warnings: Vec<RobotWarning>,
    pub lines: ItemLines,
}

impl<'a> Urdf<'a> {
    pub fn place(self, item: String) -> Place {
        let line = self.lines.and_then(|lines| lines.line(&item));
        Place { file: self.file.to_owned(), line, item }
    }

    /// The check that the file is a URDF, by what it looks like, within bounds.
    pub fn check(self) -> Result<(), Error> {
        with_document(self.file, self.text, |_| ())
    }

    /// The parsed URDF, and what was mended before.
    fn parsed(self) -> Result<(urdf_rs::Robot, Mended), Error> {
        let mended = mended(self.file, self.text)?;
        let parsed =
            guarded::on_thread(|| urdf_rs::read_from_string(&mended.text).map_err(|e| e.to_string()));
        let invalid = |why: String| Source { file: self.file, text: self.text }.invalid("URDF", why);
        Ok((parsed.and_then(|parsed| parsed).map_err(invalid)?, mended))
    }

    /// The links of the URDF. The error is a fault of the file or of the tree.
    pub fn links(self) -> Result<Links, Error> {
        let (urdf, mended) = self.parsed()?;
        let links =
            Urdf { lines: Some(&mended.lines), ..self }.links_of(&urdf, mended.warnings, mended.limit_faults);
        links.map(|links| Links { lines: mended.lines, ..links })
    }

    fn links_of(
        self,
        urdf: &urdf_rs::Robot,
        warnings: Vec<RobotWarning>,
        mut limit_faults: BTreeMap<String, Error>,
    ) -> Result<Links, Error> {
        if urdf.links.is_empty() {
            return Err(Error::missing(self.place("robot".to_owned()), "links"));
        }
        let colors = colors(urdf);
        let names = urdf.links.iter().map(|l| l.name.as_str()).collect();
        let edges =
            urdf.joints.iter().map(|j| Edge { joint: &j.name, parent: &j.parent.link, child: &j.child.link });
        let is_garbled = self.text.contains(char::REPLACEMENT_CHARACTER);
        let garbled = is_garbled.then(|| RobotWarning::new(GARBLED.to_owned()));
        let mut read = Links { warnings: garbled.into_iter().chain(warnings).collect(), ..Links::default() };
        let (finder, mut notes) = (MeshFinder::new(self.folders), ShapeNotes::default());
        for Spot { link, parent, joint } in tree::order(self, names, &edges.collect::<Vec<_>>())? {
            let link = &urdf.links[link];
            let mut keep = |fault| read.faults.push(fault);
            let check = Check { urdf: self, item: format!("link `{}`", link.name) };
            let joint = joint.and_then(|j| self.joint(&urdf.joints[j]).map_err(&mut keep).ok());
            let joint = joint.map(|(joint, fault)| {
                let fault = limit_faults.remove(&joint.name).or(fault);
                read.joint_faults.extend(fault.map(|fault| (read.links.len(), fault)));
                joint
            });
            let inertial = check.inertial(&link.inertial).map_err(&mut keep).ok();
            let (inertial, about_inertia) = inertial.unwrap_or_default();
            read.warnings.extend(about_inertia);
            let visuals = self.visuals(link, &colors, &finder, &mut notes, &mut keep);
            let collisions = self.collisions(link, &finder, &mut notes, &mut keep);
            read.links.push(Link { name: link.name.clone(), parent, joint, inertial, visuals, collisions });
        }
        read.warnings.extend(notes.warnings());
        Ok(read)
    }

    /// The shapes of a link to draw.
    fn visuals<'u>(
        self,
        link: &'u urdf_rs::Link,
        colors: &BTreeMap<String, [f64; 4]>,
        finder: &MeshFinder,
        notes: &mut ShapeNotes<'u>,
        keep: &mut impl FnMut(Error),
    ) -> Vec<Geometry> {
        let mut visuals = Vec::new();
        for (i, v) in link.visual.iter().enumerate() {
            let check = self.shape_check(link, "visual", i);
            if has_no_size(&v.geometry) {
                notes.left_out.push(check.item);
                continue;
            }
            let color = v.material.as_ref().and_then(|m| colors.get(&m.name)).map(|c| c.map(|c| c as f32));
            let mut file = None;
            if let Some(name) = mesh_name(&v.geometry) {
                match finder.find(name).and_then(drawn) {
                    Ok(found) => file = Some(notes.found(name, found)),
                    Err(why) => {
                        notes.missing.push((name, why));
                        continue;
                    }
                }
            }
            if let Ok(shape) = check.geometry(&v.origin, &v.geometry, color, file).map_err(&mut *keep) {
                notes.look_at_scale(link, &v.geometry, &shape, None);
                visuals.push(shape);
            }
        }
        visuals
    }

    /// The shapes of a link that collide.
    fn collisions<'u>(
        self,
        link: &'u urdf_rs::Link,
        finder: &MeshFinder,
        notes: &mut ShapeNotes<'u>,
        keep: &mut impl FnMut(Error),
    ) -> Vec<Geometry> {
        let mut collisions = Vec::new();
        for (i, c) in link.collision.iter().enumerate() {
            let check = self.shape_check(link, "collision", i);
            if has_no_size(&c.geometry) {
                notes.left_out.push(check.item);
                continue;
            }
            // a mesh that is not at hand may still have its hull
            let file = mesh_name(&c.geometry)
                .map(|name| finder.find(name).map_or_else(|_| name.into(), |found| notes.found(name, found)));
            let Ok(shape) = check.geometry(&c.origin, &c.geometry, None, file).map_err(&mut *keep) else {
                continue;
            };
            let convex = mesh_name(&c.geometry).and_then(|mesh| self.hulls?.get(mesh));
            notes.look_at_scale(link, &c.geometry, &shape, convex);
            collisions.extend(with_hulls(shape, convex));
        }
        let has_hull = |c: &Geometry| matches!(&c.shape, Shape::Mesh { hull, .. } if !hull.is_empty());
        if collisions.iter().any(has_hull) && link.collision.iter().any(|c| self.is_one_hull(&c.geometry)) {
            notes.with_hulls.push(link.name.as_str());
        }
        collisions
    }

    fn shape_check(self, link: &urdf_rs::Link, kind: &str, i: usize) -> Check<'a> {
        Check { urdf: self, item: format!("link `{}`, {kind} {}", link.name, i + 1) }
    }

    /// The hulls of all collision meshes that can be found and read, and warnings about the others. Both are
    /// empty for a URDF that is not valid.
    pub fn collision_hulls(self) -> (Hulls, Vec<RobotWarning>) {
        let (mut hulls, mut warnings) = (Hulls::new(), Vec::new());
        // why a mesh has no hull, if it has none: every file is read once
        let mut known: BTreeMap<&str, Option<String>> = BTreeMap::new();
        let mut left = MAX_MESH_BYTES;
        let finder = MeshFinder::new(self.folders);
        let urdf = self.parsed().ok().map(|(urdf, _)| urdf);
        let links = urdf.iter().flat_map(|urdf| &urdf.links);
        for (link, geometry) in links.flat_map(|l| l.collision.iter().map(move |c| (&l.name, &c.geometry))) {
            let Some(mesh) = mesh_name(geometry) else { continue };
            let why = match known.get(mesh) {
                Some(why) => why.clone(),
                None => {
                    let is_one_more = known.len() < MAX_MESHES;
                    let found = match is_one_more {
                        true => finder.find(mesh),
                        false => Err(format!("searched for no more than {MAX_MESHES} meshes")),
                    };
                    let read = found.and_then(|FoundMesh { file, .. }| {
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

    /// A joint; and the fault of it that matters where it is used.
    fn joint(self, joint: &urdf_rs::Joint) -> Result<(Joint, Option<Error>), Error> {
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
        let mut fault = None;
        let mut later = |found: Error| {
            fault.get_or_insert(found);
        };
        let axis = match kind {
            JointKind::Revolute | JointKind::Continuous | JointKind::Prismatic => {
                check.axis(&joint.axis.xyz.0).map_err(&mut later).unwrap_or(Vector3::x_axis())
            }
            _ => Vector3::x_axis(),
        };
        let limits = check.limits(kind, &joint.limit).map_err(&mut later);
        let no_limits = Limits { lower: 0.0, upper: 0.0, rate: 0.0, effort: f64::INFINITY };
        let mimic = joint.mimic.as_ref().map(|m| {
            let ratio = check.finite("mimic multiplier", m.multiplier.unwrap_or(1.0))?;
            let offset = check.finite("mimic offset", m.offset.unwrap_or(0.0))?;
            Ok::<_, Error>(Mimic { joint: m.joint.clone(), ratio, offset })
        });
        let joint = Joint {
            name: joint.name.clone(),
            kind,
            parent_from_joint: check.pose(&joint.origin)?,
            axis,
            limits: limits.unwrap_or(no_limits),
            mimic: mimic.transpose()?,
            coupling: Coupling { joint: None, ratio: 1.0, offset: 0.0 },
        };
        Ok((joint, fault))
    }
}

/// The colours of materials. A colour given anywhere holds everywhere.
fn colors(urdf: &urdf_rs::Robot) -> BTreeMap<String, [f64; 4]> {
    let on_links = urdf.links.iter().flat_map(|l| &l.visual).filter_map(|v| v.material.as_ref());
    let all = on_links.chain(&urdf.materials);
    all.filter_map(|m| m.color.as_ref().map(|c| (m.name.clone(), c.rgba.0))).collect()
}
