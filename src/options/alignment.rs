//! The length of the straight path on either side of an opening.
//!
//! Human, object and robot in tandem are about 2.5 m long and must be aligned until they are out of the
//! passage. Two lengths decide: the *depth* of the passage, over which it stays as narrow as its gap, and the
//! *shoulder* next to its end, around which the team turns. Behind the shoulder of a wall, which is broad, the
//! team is straight for [`BEYOND_END_M`] from the passage's end, and for [`ALIGNMENT_M`] from the middle of a
//! thin wall. A pillar, round or narrow, has no shoulder: where neither side of a gap has one, paths need not
//! be straight, nor go through the middle. In between, both rules are continuous in the place of obstacles.

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
/// Shoulders up to the first length (m) do not count: paths need not go through the middle. At the second
/// length, they do; from the third on, they are straight in full.
const SHOULDER_M: [f64; 3] = [0.5, 0.65, 0.8];
/// Likewise for the depth of the passage (m): in a deep one the team must be straight however narrow the
/// obstacles are.
const DEEP_M: [f64; 3] = [0.4, 0.55, 0.7];
/// The largest number of openings of a world in which paths may be off the middle: it takes three times the
/// sites.
const MAX_OPENINGS_WITH_LANES: usize = 200;
/// The distance (m) from a gap's end to the outline that it is on, at most.
const AT_OUTLINE_M: f64 = 1e-3;

/// How paths go through an opening, where nothing else is in their way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Alignment {
    /// The length (m) of the straight path on the opening's sides 0 and 1.
    pub straight: [f64; 2],
    /// How far paths may be off the middle, as a share (0 to 1) of the room for that. It is 0 unless both
    /// straight parts are.
    pub off_middle: f64,
}

impl Alignment {
    /// The alignment of an opening among this number of openings. Where there are more than
    /// [`MAX_OPENINGS_WITH_LANES`], paths go through the middle.
    pub fn new(opening: &Opening, space: &Space, openings: usize) -> Self {
        let axis = opening.axis();
        let sides = [-axis, axis].map(|outward| {
            let depth = depth(opening, outward, space);
            (depth, shoulder(opening, outward, depth, space))
        });
        let straight = sides.map(|(depth, shoulder)| {
            let share =
                rising(shoulder, [SHOULDER_M[1], SHOULDER_M[2]]).max(rising(depth, [DEEP_M[1], DEEP_M[2]]));
            share * ALIGNMENT_M.max(depth + BEYOND_END_M)
        });
        let free = sides.map(|(depth, shoulder)| {
            1.0 - rising(shoulder, [SHOULDER_M[0], SHOULDER_M[1]]).max(rising(depth, [DEEP_M[0], DEEP_M[1]]))
        });
        let off_middle = if openings > MAX_OPENINGS_WITH_LANES { 0.0 } else { free[0].min(free[1]) };
        Self { straight, off_middle }
    }
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

/// The length (m) of the longer one of the shoulders next to the end of a passage: how far an obstacle goes
/// on to the side at the gap, with free space before it at the passage's end.
fn shoulder(opening: &Opening, outward: Vector, depth: f64, space: &Space) -> f64 {
    let [first, second] = opening.ends;
    let aside = (second - first) / opening.width;
    let length = |(end, aside): (Point, Vector)| {
        let most = SHOULDER_M[2];
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

    fn alignments_of(world: &World) -> Vec<Alignment> {
        let barriers = world.openings.iter().map(|opening| opening.ends).collect();
        let space = Space::new(&world.solids, barriers, world.robot_width / 2.0);
        world.openings.iter().map(|opening| Alignment::new(opening, &space, world.openings.len())).collect()
    }

    /// A world with two obstacles on either side of (0, 0) and an opening between them.
    fn between(lower: &str, upper: &str) -> Alignment {
        let obstacle =
            |name: &str, entry: &str| format!("[[obstacle]]\nname = \"{name}\"\n{entry}\nheight_m = 1\n");
        let text = format!(
            "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [-9, 0]\ntarget_m = [9, 0]\n{}{}",
            obstacle("lower", lower),
            obstacle("upper", upper)
        ) + "[[opening]]\nname = \"gap\"\nbetween = [\"lower\", \"upper\"]\n";
        alignments_of(&World::parse("w", &text).unwrap_or_else(|error| panic!("{error}")))[0]
    }

    /// Boxes of this depth along the way and this breadth, with a gap of 0.6 m.
    fn boxes(depth: f64, breadth: f64) -> Alignment {
        let entry = |y: f64| format!("shape = \"box\"\ncenter_m = [0, {y}]\nsize_m = [{depth}, {breadth}]");
        between(&entry(-0.3 - breadth / 2.0), &entry(0.3 + breadth / 2.0))
    }

    #[test]
    fn closed_form_the_papers_doors_are_straight_for_exactly_one_metre() {
        for built_in in BUILT_IN_WORLDS.iter().filter(|world| world.name.starts_with("environment")) {
            let world = World::parse(built_in.name, built_in.text).unwrap();
            for (opening, alignment) in world.openings.iter().zip(alignments_of(&world)) {
                let expected = Alignment { straight: [ALIGNMENT_M; 2], off_middle: 0.0 };
                assert_eq!(alignment, expected, "{}: {}", built_in.name, opening.name);
            }
        }
    }

    #[test]
    fn closed_form_deep_passages_are_straight_until_the_team_is_out_and_pillars_are_not() {
        let is_straight = |found: Alignment, expected: f64| {
            let is_near = found.straight.iter().all(|length| (length - expected).abs() < 1e-6);
            assert!(is_near && found.off_middle < 1e-9, "{found:?}, not {expected}");
        };
        for thin in [0.02, 0.1, 0.2] {
            is_straight(boxes(thin, 3.0), ALIGNMENT_M);
        }
        is_straight(boxes(0.4, 3.0), 1.1);
        is_straight(boxes(2.4, 3.0), 2.1);
        // narrow walls along the way: a corridor
        is_straight(boxes(2.4, 0.1), 2.1);
        is_straight(boxes(0.1, 0.725), 0.5);
        is_straight(boxes(0.1, 0.65), 0.0);
        let free = Alignment { straight: [0.0; 2], off_middle: 1.0 };
        assert_eq!(boxes(0.4, 0.4), free);
        assert!((boxes(0.1, 0.575).off_middle - 0.5).abs() < 1e-6);
        for radius in [0.2, 0.5, 0.9] {
            let pillar = |y: f64| format!("shape = \"cylinder\"\ncenter_m = [0, {y}]\nradius_m = {radius}");
            assert_eq!(between(&pillar(-0.3 - radius), &pillar(0.3 + radius)), free, "radius {radius}");
        }
    }

    #[test]
    fn property_the_way_through_is_continuous_in_depth_and_breadth() {
        for (depth, breadth) in [(0.2, 0.1), (0.8, 0.1), (0.8, 1.0)] {
            for by in [[1.0, 0.0], [0.0, 1.0]] {
                let steps = (0..100).map(|i| 0.01 * f64::from(i));
                let ways = steps.map(|s| boxes(depth + by[0] * s, breadth + by[1] * s));
                let ways: Vec<[f64; 2]> = ways.map(|way| [way.straight[1], way.off_middle]).collect();
                let largest =
                    |i: usize| ways.windows(2).map(|w| (w[1][i] - w[0][i]).abs()).fold(0.0, f64::max);
                let steepest = [largest(0), largest(1)];
                assert!(steepest.iter().all(|by| *by < 0.1), "from {depth}, {breadth} m by {by:?}: {ways:?}");
            }
        }
    }
}
