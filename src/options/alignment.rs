//! The length of the straight path on either side of an opening.
//!
//! Human, object and robot in tandem are about 2.5 m long and must be aligned until they are out of the passage.
//! Two lengths decide: the *depth* of the passage, over which it stays as narrow as its gap, and the *shoulder*
//! beside its end, around which the team turns. Behind the shoulder of a wall, which is broad, the team is
//! straight for [`BEYOND_END_M`] from the passage's end, and for [`ALIGNMENT_M`] from the middle of a thin wall.
//! A pillar, round or narrow, has no shoulder: there the way is straight only as far as the passage is deep.
//! All these lengths are continuous in the place of obstacles.

use super::roadmap::Space;
use crate::geometry::{Point, Vector, left_of};
use crate::world::Opening;

/// The length of the straight path on either side of a thin wall, m from its middle.
pub const ALIGNMENT_M: f64 = 1.0;
/// The length of the straight path beyond the end of a passage with shoulders, m.
const BEYOND_END_M: f64 = 0.9;
/// A passage ends where it is wider than its gap by this, m.
const WIDENING_M: f64 = 0.1;
/// The largest depth of a passage that is looked at, m from the gap.
const MAX_DEPTH_M: f64 = 5.0;
/// The steps in which the end of a passage is looked for, m.
const DEPTH_STEP_M: f64 = 0.05;
/// Bisections of the step in which the passage ends.
const HALVINGS: u32 = 30;
/// Shoulders up to the first length (m) are none, from the second on they count in full.
const SHOULDER_M: [f64; 2] = [0.4, 0.8];
/// Passages up to the first depth (m) are as good as none, from the second on the team must be straight
/// beyond the end however narrow the obstacles are.
const DEEP_M: [f64; 2] = [0.3, 0.6];
/// The shortest straight path, m: through the middle of the gap.
const SHORTEST_M: f64 = 0.05;
/// The distance (m) from a gap's end to the outline that it is on, at most.
const AT_OUTLINE_M: f64 = 1e-3;

/// The length (m) of the straight path on the opening's sides 0 and 1, where nothing is in its way.
pub(super) fn alignments(opening: &Opening, space: &Space) -> [f64; 2] {
    let axis = opening.axis();
    [-axis, axis].map(|outward| {
        let depth = depth(opening, outward, space);
        let shoulder = shoulder(opening, outward, depth, space);
        let share = rising(shoulder, SHOULDER_M).max(rising(depth, DEEP_M));
        (share * ALIGNMENT_M).max(depth + share * BEYOND_END_M).max(SHORTEST_M)
    })
}

/// How far (m) from its gap the passage is not wider than the gap by more than [`WIDENING_M`].
fn depth(opening: &Opening, outward: Vector, space: &Space) -> f64 {
    let (center, across) = (opening.center(), left_of(outward));
    let most = opening.width + WIDENING_M;
    let is_within = |depth: f64| {
        let p: Point = center + outward * depth;
        let left = space.free_along(p, across, most);
        left + space.free_along(p, -across, most - left) < most
    };
    let mut within = 0.0;
    while within < MAX_DEPTH_M && is_within(within + DEPTH_STEP_M) {
        within += DEPTH_STEP_M;
    }
    let mut beyond = within + DEPTH_STEP_M;
    for _ in 0..HALVINGS {
        let middle = (within + beyond) / 2.0;
        *(if is_within(middle) { &mut within } else { &mut beyond }) = middle;
    }
    within
}

/// The length (m) of the longer one of the shoulders beside the end of a passage: how far an obstacle goes on
/// to the side at the gap, with free space before it at the passage's end.
fn shoulder(opening: &Opening, outward: Vector, depth: f64, space: &Space) -> f64 {
    let [first, second] = opening.ends;
    let aside = (second - first) / opening.width;
    let length = |(end, aside): (Point, Vector)| {
        let most = SHOULDER_M[1];
        let front = end + outward * (depth + WIDENING_M);
        space.filled_along(end, aside, most, AT_OUTLINE_M).min(space.free_along(front, aside, most))
    };
    [(first, -aside), (second, aside)].into_iter().map(length).fold(0.0, f64::max)
}

/// From 0 at the first length and below to 1 at the second and above.
fn rising(length: f64, [from, to]: [f64; 2]) -> f64 {
    ((length - from) / (to - from)).clamp(0.0, 1.0)
}
