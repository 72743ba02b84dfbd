//! Two obstacles in; the gap between them, measured by parry, and whether it is an opening, out.

use super::obstacle::Obstacle;
use crate::geometry::{Point, Vector, left_of};
use parry3d::query::{ClosestPoints, closest_points};

/// An opening wider than this many robot widths is free passage (Sec. III-A, footnote 1).
pub const FREE_PASSAGE: f64 = 5.0;

/// Outline parts within this distance (m) of the closest ones count as closest too: parallel faces.
const PARALLEL: f64 = 1e-6;

/// A passage between two obstacles.
#[derive(Clone, Debug, PartialEq)]
pub struct Opening {
    /// Name, unique in its world.
    pub name: String,
    /// The two obstacles, as indices into the world's obstacles.
    pub between: [usize; 2],
    /// The gap: from the outline of the first obstacle to that of the second. Where faces are parallel, in their middle.
    pub ends: [Point; 2],
    /// Width w, m: the distance of the two obstacles.
    pub width: f64,
}

impl Opening {
    /// The middle of the gap.
    pub fn center(&self) -> Point {
        nalgebra::center(&self.ends[0], &self.ends[1])
    }

    /// The unit vector perpendicular to the gap, from the opening's side 0 to its side 1.
    pub fn axis(&self) -> Vector {
        left_of((self.ends[1] - self.ends[0]) / self.width)
    }

    /// The risk S_xi = d_r / w of passing (Sec. III-A): 0 where w > 5 d_r, 1 where w <= d_r.
    pub fn risk(&self, robot_width: f64) -> f64 {
        if self.width > FREE_PASSAGE * robot_width { 0.0 } else { (robot_width / self.width).min(1.0) }
    }
}

/// The gap between two obstacles, without a name yet; `None` where they touch.
///
/// The width and the direction come from parry's closest points of the two solids. Both stand on the floor, so these lie at one height.
pub(super) fn measure(obstacles: &[Obstacle], between: [usize; 2]) -> Option<Opening> {
    let [first, second] = between.map(|i| &obstacles[i]);
    let ((pose1, shape1), (pose2, shape2)) = (first.solid(), second.solid());
    let found = closest_points(&pose1, shape1, &pose2, shape2, f64::MAX).ok()?;
    let ClosestPoints::WithinMargin(p1, p2) = found else {
        return None;
    };
    let (p1, p2) = (Point::new(p1.x, p1.y), Point::new(p2.x, p2.y));
    let width = (p2 - p1).norm();
    if width < PARALLEL {
        return None;
    }
    let toward = (p2 - p1) / width;
    let left = left_of(toward);
    let part1 = first.footprint.farthest_part(toward, PARALLEL);
    let part2 = second.footprint.farthest_part(-toward, PARALLEL);
    // the second obstacle's axis points the other way
    let (low, high) = (part1[0].max(-part2[1]), part1[1].min(-part2[0]));
    let shift = if low < high { (low + high) / 2.0 - left.dot(&p1.coords) } else { 0.0 };
    let ends = [p1 + left * shift, p2 + left * shift];
    Some(Opening { name: String::new(), between, ends, width })
}

/// The third obstacle nearest to the middle of a gap, if it is nearer than the gap's own two: then the constriction is elsewhere.
/// Returns its index and distance (m).
pub(super) fn obstructed(obstacles: &[Obstacle], gap: &Opening) -> Option<(usize, f64)> {
    let center = gap.center();
    obstacles
        .iter()
        .enumerate()
        .filter(|(i, _)| !gap.between.contains(i))
        .map(|(i, o)| (i, o.footprint.distance_to_point(center)))
        .filter(|&(_, distance)| distance <= gap.width / 2.0 + PARALLEL)
        .min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Every opening between two of the obstacles: d_r < w <= 5 d_r, and no third obstacle in the disc over the gap.
///
/// DEVIATION (design): a gap counts only if the disc that has it for a diameter is free of other obstacles, which is stronger than a free
/// gap segment. Without it the diagonals between four pillars count as well: the same constriction twice, and gaps that cross.
pub(super) fn detect(obstacles: &[Obstacle], robot_width: f64) -> Vec<Opening> {
    let pairs = (0..obstacles.len()).flat_map(|i| (i + 1..obstacles.len()).map(move |j| [i, j]));
    let widest = FREE_PASSAGE * robot_width;
    pairs
        .filter(|&[i, j]| {
            let near = obstacles[i].footprint.bounds().grown(widest);
            let other = obstacles[j].footprint.bounds();
            near.min <= other.max && other.min <= near.max
        })
        .filter_map(|between| measure(obstacles, between))
        .filter(|gap| gap.width > robot_width && gap.width <= widest)
        .filter(|gap| obstructed(obstacles, gap).is_none())
        .enumerate()
        .map(|(i, gap)| Opening { name: format!("xi{}", i + 1), ..gap })
        .collect()
}
