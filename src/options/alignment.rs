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
        let rest = most - space.free_along(p, across, most);
        space.free_along(p, -across, rest) < rest
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::{BUILT_IN_WORLDS, World};

    fn alignments_of(world: &World) -> Vec<[f64; 2]> {
        let barriers = world.openings.iter().map(|opening| opening.ends).collect();
        let space = Space::new(&world.solids, barriers, world.robot_width / 2.0);
        world.openings.iter().map(|opening| alignments(opening, &space)).collect()
    }

    /// A world with two obstacles on either side of (0, 0) and an opening between them.
    fn between(lower: &str, upper: &str) -> [f64; 2] {
        let obstacle = |name: &str, entry: &str| format!("[[obstacle]]\nname = \"{name}\"\n{entry}\nheight_m = 1\n");
        let text = format!(
            "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [-9, 0]\ntarget_m = [9, 0]\n{}{}",
            obstacle("lower", lower),
            obstacle("upper", upper)
        ) + "[[opening]]\nname = \"gap\"\nbetween = [\"lower\", \"upper\"]\n";
        alignments_of(&World::parse("w", &text).unwrap_or_else(|error| panic!("{error}")))[0]
    }

    /// Boxes of this depth along the way and this breadth, with a gap of 0.6 m.
    fn boxes(depth: f64, breadth: f64) -> [f64; 2] {
        let entry = |y: f64| format!("shape = \"box\"\ncenter_m = [0, {y}]\nsize_m = [{depth}, {breadth}]");
        between(&entry(-0.3 - breadth / 2.0), &entry(0.3 + breadth / 2.0))
    }

    #[test]
    fn closed_form_the_papers_doors_are_straight_for_exactly_one_metre() {
        for built_in in BUILT_IN_WORLDS.iter().filter(|world| world.name.starts_with("environment")) {
            let world = World::parse(built_in.name, built_in.text).unwrap();
            for (opening, alignments) in world.openings.iter().zip(alignments_of(&world)) {
                assert_eq!(alignments, [ALIGNMENT_M; 2], "{}: {}", built_in.name, opening.name);
            }
        }
    }

    #[test]
    fn closed_form_deep_passages_are_straight_until_the_team_is_out_and_pillars_are_not() {
        let is_near = |found: [f64; 2], expected: f64| {
            assert!(found.iter().all(|length| (length - expected).abs() < 1e-6), "{found:?}, not {expected}");
        };
        for thin in [0.02, 0.1, 0.2] {
            assert_eq!(boxes(thin, 3.0), [ALIGNMENT_M; 2]);
        }
        is_near(boxes(0.4, 3.0), 1.1);
        is_near(boxes(2.4, 3.0), 2.1);
        // narrow walls along the way: a corridor
        is_near(boxes(2.4, 0.1), 2.1);
        // posts
        is_near(boxes(0.3, 0.3), 0.15);
        is_near(boxes(0.05, 0.3), SHORTEST_M);
        for radius in [0.2, 0.5, 2.0] {
            let pillar = |y: f64| format!("shape = \"cylinder\"\ncenter_m = [0, {y}]\nradius_m = {radius}");
            let [before, beyond] = between(&pillar(-0.3 - radius), &pillar(0.3 + radius));
            // where the passage is 0.1 m wider: r^2 - x^2 = (r - 0.05)^2
            let depth: f64 = (0.1 * radius - 0.0025_f64).sqrt();
            assert!((before - beyond).abs() < 1e-6, "{before}, {beyond}");
            let is_short = before >= depth - 1e-6 && before <= depth + 1.3 * rising(depth, DEEP_M);
            assert!(is_short, "radius {radius}: {before}, depth {depth}");
        }
    }

    #[test]
    fn property_the_straight_part_is_continuous_in_depth_and_breadth() {
        for (depth, breadth) in [(0.2, 0.1), (0.8, 0.1), (0.8, 1.0)] {
            let lengths = |by: [f64; 2]| -> Vec<f64> {
                (0..80).map(|i| 0.01 * f64::from(i)).map(|s| boxes(depth + by[0] * s, breadth + by[1] * s)[1]).collect()
            };
            for by in [[1.0, 0.0], [0.0, 1.0]] {
                let lengths = lengths(by);
                let steepest = lengths.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
                assert!(steepest < 0.04, "from {depth}, {breadth} m by {by:?}: {lengths:?}");
            }
        }
    }
}
