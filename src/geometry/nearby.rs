//! Rectangles by place, in an R-tree (A. Guttman, R-trees: a dynamic index structure for spatial searching,
//! SIGMOD 1984).

use super::{Bounds, Point, cross};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, ParentNode, RStarInsertionStrategy, RTree, RTreeNode, RTreeObject, RTreeParams};

type Entry = GeomWithData<Rectangle<[f64; 2]>, usize>;

/// Nodes are larger than usual: the tree is built once, and a query tests a node's children in a row.
#[derive(Clone, Debug)]
struct Wide;

impl RTreeParams for Wide {
    const MIN_SIZE: usize = 6;
    const MAX_SIZE: usize = 12;
    const REINSERTION_COUNT: usize = 3;
    type DefaultInsertionStrategy = RStarInsertionStrategy;
}

/// Rectangles, numbered from 0, that are found by place. Queries visit them in no particular order and do not
/// allocate, except for [`Nearby::meeting`].
#[derive(Clone, Debug)]
pub struct Nearby {
    tree: RTree<Entry, Wide>,
}

impl Nearby {
    /// These rectangles, numbered in their order.
    pub fn new(rectangles: impl IntoIterator<Item = Bounds>) -> Self {
        let entry = |(i, b): (usize, Bounds)| {
            GeomWithData::new(Rectangle::from_corners([b.min.x, b.min.y], [b.max.x, b.max.y]), i)
        };
        Self { tree: RTree::bulk_load_with_params(rectangles.into_iter().enumerate().map(entry).collect()) }
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
        let around = Bounds { min: a.inf(&b), max: a.sup(&b) }.grown(margin);
        let comes_near = |bounds: Bounds| {
            if !(bounds.min <= around.max && around.min <= bounds.max) {
                return false;
            }
            let half = bounds.size() / 2.0;
            let across = cross(along, bounds.min + half - a).abs();
            across <= (half.x + margin) * along.y.abs() + (half.y + margin) * along.x.abs()
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
        let words = self.tree.size().div_ceil(64);
        if found.len() < words {
            found.sort_unstable();
            return found;
        }
        // of so many, a bit for each is quicker
        let mut bits = vec![0_u64; words];
        for i in found.drain(..) {
            bits[i / 64] |= 1 << (i % 64);
        }
        for (word, mut rest) in bits.into_iter().enumerate() {
            while rest != 0 {
                found.push(64 * word + rest.trailing_zeros() as usize);
                rest &= rest - 1;
            }
        }
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
