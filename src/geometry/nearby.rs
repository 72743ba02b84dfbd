//! Rectangles by place, in an R-tree (A. Guttman, R-trees: a dynamic index structure for spatial searching,
//! SIGMOD 1984).

use super::{Bounds, Point, cross};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, ParentNode, RTree, RTreeNode, RTreeObject};

type Entry = GeomWithData<Rectangle<[f64; 2]>, usize>;

/// Rectangles, numbered from 0, that are found by place. Queries visit them in no particular order and do not
/// allocate, except for [`Nearby::meeting`].
#[derive(Clone, Debug)]
pub struct Nearby {
    tree: RTree<Entry>,
}

impl Nearby {
    /// These rectangles, numbered in their order.
    pub fn new(rectangles: impl IntoIterator<Item = Bounds>) -> Self {
        let entry = |(i, b): (usize, Bounds)| {
            GeomWithData::new(Rectangle::from_corners([b.min.x, b.min.y], [b.max.x, b.max.y]), i)
        };
        Self { tree: RTree::bulk_load(rectangles.into_iter().enumerate().map(entry).collect()) }
    }

    /// Whether `holds` for the number of any rectangle that meets `bounds`.
    pub fn any_meeting(&self, bounds: Bounds, mut holds: impl FnMut(usize) -> bool) -> bool {
        let meets = |b: Bounds| b.min <= bounds.max && bounds.min <= b.max;
        any(self.tree.root(), &meets, &mut holds)
    }

    /// Whether `holds` for the number of any rectangle to which the segment `a b` comes within `margin` (m).
    /// It is also asked for some that the segment passes a little farther away.
    pub fn any_along(&self, a: Point, b: Point, margin: f64, mut holds: impl FnMut(usize) -> bool) -> bool {
        let along = b - a;
        let comes_near = |bounds: Bounds| {
            let near = bounds.grown(margin);
            let half = near.size() / 2.0;
            let across = cross(along, near.min + half - a).abs();
            !near.misses_segment(a, b) && across <= half.x * along.y.abs() + half.y * along.x.abs()
        };
        any(self.tree.root(), &comes_near, &mut holds)
    }

    /// The numbers of the rectangles that meet `bounds`, ascending.
    pub fn meeting(&self, bounds: Bounds) -> Vec<usize> {
        let mut found = Vec::new();
        self.any_meeting(bounds, |i| {
            found.push(i);
            false
        });
        found.sort_unstable();
        found
    }
}

fn any(
    node: &ParentNode<Entry>,
    is_near: &impl Fn(Bounds) -> bool,
    holds: &mut impl FnMut(usize) -> bool,
) -> bool {
    node.children().iter().any(|child| match child {
        RTreeNode::Leaf(entry) => is_near(bounds_of(&entry.envelope())) && holds(entry.data),
        RTreeNode::Parent(parent) => is_near(bounds_of(&parent.envelope())) && any(parent, is_near, holds),
    })
}

fn bounds_of(envelope: &AABB<[f64; 2]>) -> Bounds {
    Bounds { min: envelope.lower().into(), max: envelope.upper().into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::squared_distance_to_segment;
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    #[test]
    fn property_what_is_near_is_what_a_search_through_all_finds() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut point = || Point::new(rng.random_range(0.0..10.0), rng.random_range(0.0..10.0));
        let points: Vec<Point> = (0..300).map(|_| point()).collect();
        let nearby = Nearby::new(points.iter().map(|&p| Bounds { min: p, max: p }));
        for _ in 0..100 {
            let (a, b) = (point(), point());
            let square = Bounds { min: a, max: a }.grown(1.5);
            let within: Vec<usize> = (0..300).filter(|&i| square.contains(points[i])).collect();
            assert_eq!(nearby.meeting(square), within);
            let mut along = Vec::new();
            assert!(!nearby.any_along(a, b, 0.5, |i| {
                along.push(i);
                false
            }));
            let is_near = |&i: &usize| squared_distance_to_segment(points[i], a, b) <= 0.25;
            assert!((0..300).filter(is_near).all(|i| along.contains(&i)));
            assert!(along.iter().all(|&i| squared_distance_to_segment(points[i], a, b) <= 0.5 + 1e-9));
        }
        let none = Nearby::new([]);
        assert!(!none.any_meeting(Bounds { min: points[0], max: points[1] }, |_| true));
    }
}
