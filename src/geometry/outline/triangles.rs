//! Triangles between the lines of outlines, and what is built from them: rings and convex parts.

use super::{STRAIGHT_SINE, without_straight_corners};
use crate::geometry::{Point, cross};
use spade::handles::{DirectedEdgeHandle, FixedVertexHandle};
use spade::{CdtEdge, ConstrainedDelaunayTriangulation, Point2, Triangulation, mitigate_underflow};

pub(super) type Triangles = ConstrainedDelaunayTriangulation<Point2<f64>>;
type Edge<'a> = DirectedEdgeHandle<'a, Point2<f64>, (), CdtEdge<()>, ()>;

/// The largest number of corners of a convex part.
const MAX_CORNERS_OF_PART: usize = 32;

/// The constrained Delaunay triangulation of these points with these lines between them, and the vertex of
/// every point; `None` where lines cross.
pub(super) fn triangles(
    points: &[Point],
    lines: impl Iterator<Item = [usize; 2]>,
) -> Option<(Triangles, Vec<FixedVertexHandle>)> {
    let mut triangles = Triangles::default();
    let vertices: Vec<FixedVertexHandle> = points
        .iter()
        .map(|p| triangles.insert(mitigate_underflow(Point2::new(p.x, p.y))).ok())
        .collect::<Option<_>>()?;
    for [a, b] in lines {
        let (a, b) = (vertices[a], vertices[b]);
        if !triangles.can_add_constraint(a, b) {
            return None;
        }
        triangles.add_constraint(a, b);
    }
    Some((triangles, vertices))
}

pub(super) fn point(p: Point2<f64>) -> Point {
    Point::new(p.x, p.y)
}

/// For every face, by its index, whether it is inside of the constraints: an odd number of them is between it
/// and the outer face.
pub(super) fn enclosed(triangles: &Triangles) -> Vec<bool> {
    let mut is_inside = vec![None; triangles.num_all_faces()];
    is_inside[triangles.outer_face().fix().index()] = Some(false);
    let mut queue = vec![];
    let visit = |edge: Edge, is_inside: &mut Vec<Option<bool>>, queue: &mut Vec<_>| {
        let beyond = edge.rev().face();
        let from = is_inside[edge.face().fix().index()] == Some(true);
        if is_inside[beyond.fix().index()].is_none() {
            is_inside[beyond.fix().index()] = Some(from != edge.is_constraint_edge());
            queue.extend(beyond.as_inner().map(|face| face.fix()));
        }
    };
    triangles.convex_hull().for_each(|edge| {
        let edge = if edge.is_outer_edge() { edge } else { edge.rev() };
        visit(edge, &mut is_inside, &mut queue);
    });
    while let Some(face) = queue.pop() {
        let sides = triangles.face(face).adjacent_edges();
        sides.into_iter().for_each(|edge| visit(edge, &mut is_inside, &mut queue));
    }
    is_inside.into_iter().map(|is_inside| is_inside == Some(true)).collect()
}

/// The borders of the solid faces, which are on their left. Where solid faces meet at a corner only, each
/// has a ring of its own.
pub(super) fn rings(triangles: &Triangles, is_solid: &[bool]) -> Vec<Vec<Point>> {
    let is_solid = |edge: &Edge| is_solid[edge.face().fix().index()];
    let mut seen = vec![false; triangles.num_directed_edges()];
    let mut rings = Vec::new();
    for first in triangles.directed_edges() {
        let mut edge = first;
        let mut ring = Vec::new();
        while is_solid(&edge) && !is_solid(&edge.rev()) && !seen[edge.fix().index()] {
            seen[edge.fix().index()] = true;
            ring.push(point(edge.from().position()));
            // around the corner, through the solid faces next to it
            let mut next = edge.next();
            while is_solid(&next.rev()) {
                next = next.rev().next();
            }
            edge = next;
        }
        if !ring.is_empty() {
            rings.push(ring);
        }
    }
    rings
}

/// The solid triangles, merged over sides within the area as long as the result is convex.
pub(super) fn convex_parts(triangles: &Triangles, is_solid: &[bool]) -> Vec<Vec<Point>> {
    let is_solid = |face: usize| is_solid[face];
    let position = |vertex: usize| point(triangles.vertex(FixedVertexHandle::from_index(vertex)).position());
    // the polygon of every face, or the face that it was merged into
    let mut polygons: Vec<Vec<usize>> = vec![Vec::new(); triangles.num_all_faces()];
    let mut merged: Vec<usize> = (0..triangles.num_all_faces()).collect();
    for face in triangles.inner_faces().filter(|face| is_solid(face.fix().index())) {
        polygons[face.fix().index()] = face.vertices().map(|vertex| vertex.fix().index()).to_vec();
    }
    for edge in triangles.undirected_edges().filter(|edge| !edge.is_constraint_edge()) {
        let edge = edge.as_directed();
        let root = |mut face: usize| {
            while merged[face] != face {
                face = merged[face];
            }
            face
        };
        let [left, right] = [edge, edge.rev()].map(|edge| root(edge.face().fix().index()));
        if left == right || polygons[left].is_empty() || polygons[right].is_empty() {
            continue;
        }
        let [from, to] = [edge.from(), edge.to()].map(|vertex| vertex.fix().index());
        if polygons[left].len() + polygons[right].len() - 2 <= MAX_CORNERS_OF_PART
            && let Some(whole) = joined(&polygons[left], &polygons[right], [from, to])
            && is_convex_at(&whole, from, position)
            && is_convex_at(&whole, to, position)
        {
            merged[right] = left;
            polygons[right] = Vec::new();
            polygons[left] = whole;
        }
    }
    let parts = polygons.into_iter().filter(|polygon| !polygon.is_empty());
    let parts =
        parts.map(|polygon| without_straight_corners(polygon.into_iter().map(position).collect(), 0.0));
    parts.filter(|part| part.len() >= 3).collect()
}

/// Two polygons joined over the side from one corner of the left polygon to the next.
fn joined(left: &[usize], right: &[usize], [from, to]: [usize; 2]) -> Option<Vec<usize>> {
    let after = |polygon: &[usize], corner: usize| {
        let place = polygon.iter().position(|c| *c == corner)?;
        Some((0..polygon.len()).map(|i| polygon[(place + i) % polygon.len()]).collect::<Vec<_>>())
    };
    // left: to ... from, right: from ... to; without the shared side
    let mut whole = after(left, to)?;
    let right = after(right, from)?;
    (whole.last() == Some(&from) && right.last() == Some(&to)).then(|| {
        whole.extend(&right[1..right.len() - 1]);
        whole
    })
}

fn is_convex_at(polygon: &[usize], corner: usize, position: impl Fn(usize) -> Point) -> bool {
    let n = polygon.len();
    let places = (0..n).filter(|i| polygon[*i] == corner);
    places.map(|i| [n - 1, 0, 1].map(|k| position(polygon[(i + k) % n]))).all(|[before, here, after]| {
        let (into, out) = (here - before, after - here);
        cross(into, out) >= -STRAIGHT_SINE * into.norm() * out.norm()
            && into.dot(&out) > -into.norm() * out.norm()
    })
}
