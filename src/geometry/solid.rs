//! Obstacles that touch, as one: the corners of their common outline, and convex parts that cover it.

use super::footprint::{Bounds, Footprint, edges};
use super::outline::{Corner, Outline};
use super::{Nearby, left_of};

/// Obstacles that stand on the floor as one piece.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// Convex parts that cover it.
    pub parts: Vec<Footprint>,
    /// The corners of its outline that point out, where taut strings bend. A disc has none.
    pub corners: Vec<Corner>,
}

impl Solid {
    /// A single convex outline.
    pub fn single(footprint: Footprint) -> Self {
        let corners = match &footprint {
            Footprint::Disc { .. } => Vec::new(),
            Footprint::Polygon(corners) => {
                let n = corners.len();
                let normal = |i: usize| -left_of(corners[(i + 1) % n] - corners[i]).normalize();
                let normals = |i: usize| [normal((i + n - 1) % n), normal(i)];
                (0..n).map(|i| Corner { at: corners[i], normals: normals(i) }).collect()
            }
        };
        Self { parts: vec![footprint], corners }
    }

    /// The area that an outline encloses; `None` where its rings cross.
    pub fn enclosed(outline: &Outline) -> Option<Self> {
        let parts = outline.parts()?.into_iter().map(Footprint::Polygon).collect();
        Some(Self { parts, corners: outline.corners().collect() })
    }

    /// The smallest rectangle around it.
    pub fn bounds(&self) -> Option<Bounds> {
        Bounds::around(self.parts.iter().flat_map(|part| {
            let Bounds { min, max } = part.bounds();
            [min, max]
        }))
    }

    /// These solids, those joined whose polygons are at most `tolerance` (m) apart, each with the solids that
    /// it consists of. A joined one is in the place of its first. Discs stay apart from what they touch.
    pub fn joined(solids: Vec<Self>, tolerance: f64) -> Vec<(Self, Vec<usize>)> {
        let mut joined = Vec::with_capacity(solids.len());
        for group in touching(&solids, tolerance) {
            let members = group.iter().map(|i| &solids[*i]);
            match common(members.clone(), tolerance) {
                Some(solid) => joined.push((solid, group)),
                None => joined.extend(members.cloned().zip(group.iter().map(|i| vec![*i]))),
            }
        }
        joined
    }
}

/// The solids of a group as one; `None` where it has only one.
fn common<'a>(group: impl ExactSizeIterator<Item = &'a Solid>, tolerance: f64) -> Option<Solid> {
    if group.len() < 2 {
        return None;
    }
    let polygons: Vec<_> = group.flat_map(|solid| &solid.parts).filter_map(Footprint::corners).collect();
    Solid::enclosed(&Outline::covering(&polygons, tolerance)?)
}

/// The solids in groups of polygons that touch, each ascending, in the order of their first members.
fn touching(solids: &[Solid], tolerance: f64) -> Vec<Vec<usize>> {
    let parts: Vec<(usize, &Footprint)> =
        solids.iter().enumerate().flat_map(|(i, solid)| solid.parts.iter().map(move |p| (i, p))).collect();
    let near = Nearby::new(parts.iter().map(|(_, part)| part.bounds()));
    let mut links = petgraph::unionfind::UnionFind::new(solids.len());
    for (i, part) in &parts {
        let Some(corners) = part.corners() else { continue };
        near.any_meeting(part.bounds().grown(tolerance), |j| {
            let (j, other) = parts[j];
            if j > *i && !links.equiv(*i, j) && meet(corners, other, tolerance) {
                links.union(*i, j);
            }
            false
        });
    }
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let mut group_of = vec![None; solids.len()];
    for i in 0..solids.len() {
        let root = links.find(i);
        let group = *group_of[root].get_or_insert_with(|| {
            groups.push(Vec::new());
            groups.len() - 1
        });
        groups[group].push(i);
    }
    groups
}

/// Whether two polygons are at most `tolerance` (m) apart.
fn meet(corners: &[super::Point], other: &Footprint, tolerance: f64) -> bool {
    other.corners().is_some() && edges(corners).any(|(a, b)| other.distance_to_segment(a, b) <= tolerance)
}
