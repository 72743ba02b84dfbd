//! The shapes of a URDF's links: which are drawn, which collide as what, and what is told about many at once.

use super::hull::{self, Collision, Convex};
use super::link::{Geometry, Shape};
use super::mesh::FoundMesh;
use super::plausible;
use super::warning::{RobotWarning, first_few, some_of};
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// The formats of meshes that are drawn.
const DRAWN: [&str; 3] = ["stl", "obj", "dae"];

/// What is told about many shapes at once.
#[derive(Default)]
pub(super) struct ShapeNotes<'u> {
    /// Meshes that are not drawn, and why.
    pub missing: Vec<(&'u str, String)>,
    /// Meshes with the files under whose other names they were found.
    renamed: BTreeMap<&'u str, PathBuf>,
    /// Links whose meshes collide as their hulls.
    pub with_hulls: Vec<&'u str>,
    /// Shapes of no size.
    pub left_out: Vec<String>,
    /// A remark on the scale of each mesh, and its link.
    scales: BTreeMap<&'u str, (String, &'u str)>,
}

impl<'u> ShapeNotes<'u> {
    /// The file of a mesh, noted if its name is another one.
    pub fn found(&mut self, name: &'u str, found: FoundMesh) -> PathBuf {
        if found.is_renamed {
            self.renamed.insert(name, found.file.clone());
        }
        found.file
    }

    pub fn look_at_scale(
        &mut self,
        link: &'u urdf_rs::Link,
        geometry: &'u urdf_rs::Geometry,
        shape: &Geometry,
        convex: Option<&Convex>,
    ) {
        let (Some(mesh), Shape::Mesh { scale, .. }) = (mesh_name(geometry), &shape.shape) else { return };
        let vertices =
            |convex: &Convex| plausible::extent(convex.hulls().iter().flatten().map(|v| Vector3::from(*v)));
        if let Some(remark) = plausible::about_scale(convex.map(vertices), scale) {
            self.scales.insert(mesh, (remark, &link.name));
        }
    }

    pub fn warnings(&self) -> Vec<RobotWarning> {
        let mut said = Vec::new();
        if let Some((first, why)) = self.missing.first() {
            let count = self.missing.len();
            let are = if count == 1 { "mesh to draw is" } else { "meshes to draw are" };
            said.push(format!("{count} {are} missing, the first of them `{first}`: {why}"));
        }
        if let Some((first, file)) = self.renamed.iter().next() {
            let more = match self.renamed.len() - 1 {
                0 => String::new(),
                more => format!("; {more} more meshes have other names than in the URDF, too"),
            };
            said.push(format!("the mesh `{first}` is read from {}{more}", file.display()));
        }
        const MAX_NAMED: usize = 6;
        let scale = |(mesh, (remark, link)): (&&str, &(String, &str))| {
            format!("link `{link}`: its mesh `{mesh}` {remark}")
        };
        said.extend(self.scales.iter().take(MAX_NAMED).map(scale));
        if !self.left_out.is_empty() {
            said.push(format!("shapes without a size are left out: {}", first_few(&self.left_out)));
        }
        if !self.with_hulls.is_empty() {
            let (count, links) = (self.with_hulls.len(), some_of(&self.with_hulls));
            said.push(format!("collision meshes of {count} links collide as their convex hulls: {links}"));
        }
        said.into_iter().map(RobotWarning::new).collect()
    }
}

/// The mesh, if it can be drawn.
pub(super) fn drawn(found: FoundMesh) -> Result<FoundMesh, String> {
    let format = found.file.extension().and_then(|e| e.to_str()).unwrap_or_default().to_lowercase();
    match DRAWN.contains(&format.as_str()) {
        true => Ok(found),
        false => {
            Err(format!("expected STL, OBJ or COLLADA (.stl, .obj, .dae), found {}", found.file.display()))
        }
    }
}

/// Whether a shape has no size along an axis, and so is none.
pub(super) fn has_no_size(geometry: &urdf_rs::Geometry) -> bool {
    use urdf_rs::Geometry as G;
    match geometry {
        G::Box { size } => size.contains(&0.0),
        G::Cylinder { radius, length } | G::Capsule { radius, length } => *radius == 0.0 || *length == 0.0,
        G::Sphere { radius } => *radius == 0.0,
        G::Mesh { .. } => false,
    }
}

/// A collision shape; a mesh once for each of its hulls, with the hull.
pub(super) fn with_hulls(shape: Geometry, convex: Option<&Convex>) -> Vec<Geometry> {
    let Shape::Mesh { file, scale, .. } = &shape.shape else {
        return vec![shape];
    };
    let scaled = |v: &[f64; 3]| Vector3::from(*v).component_mul(scale);
    let hulls = convex.into_iter().flat_map(Convex::hulls).map(|hull| hull.iter().map(scaled).collect());
    // a scale of 0 makes any mesh flat
    let solid: Vec<Vec<_>> = hulls.filter(|hull: &Vec<_>| hull::is_solid(hull)).collect();
    if solid.is_empty() {
        return vec![shape];
    }
    let with = |hull| Geometry { shape: Shape::Mesh { file: file.clone(), scale: *scale, hull }, ..shape };
    solid.into_iter().map(with).collect()
}

/// Warnings about a mesh that has a shape.
pub(super) fn about_mesh(link: &str, mesh: &str, collision: &Collision) -> Vec<RobotWarning> {
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
pub(super) fn mesh_name(geometry: &urdf_rs::Geometry) -> Option<&str> {
    match geometry {
        urdf_rs::Geometry::Mesh { filename, .. } => Some(filename),
        _ => None,
    }
}
