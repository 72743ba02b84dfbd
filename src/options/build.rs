//! The parts that an option set is built from: free space, passages and straight parts of a world; and why
//! a world has no options.

use super::ALIGNMENT_M;
use super::alignment::Alignment;
use super::passage::Passage;
use super::roadmap::{Space, Straight};
use crate::error::{Error, ErrorKind, Place};
use crate::geometry::{Bounds, Nearby, Point};
use crate::world::{Opening, World};

/// Gaps narrower than this (m) are not named where a target cannot be reached: obstacles meet there.
const MIN_NAMED_M: f64 = 0.001;

/// The free space of a world in which these openings are barriers, and the gaps that are too narrow.
pub(super) fn space(world: &World, openings: &[Opening]) -> (Space, Vec<[Point; 2]>) {
    let closed = world.closed_gaps();
    let exactly = closed.iter().filter(|gap| gap.is_exactly_closed(world.robot_width));
    let barriers = openings.iter().chain(exactly).map(|gap| gap.ends).collect();
    let space = Space::new(&world.solids, barriers, world.robot_width / 2.0);
    (space, closed.iter().map(|gap| gap.ends).collect())
}

/// The straight parts of all sites.
pub(super) fn straights(ends: [Point; 2], passages: &[Passage]) -> Vec<Straight> {
    let of_passages = passages.iter().enumerate().flat_map(|(i, passage)| passage.straights(i));
    ends.map(Straight::from).into_iter().chain(of_passages).collect()
}

/// The passages of all openings.
pub(super) fn passages(world: &World, space: &Space) -> Vec<Passage> {
    let bounds = |o: &Opening| Bounds { min: o.ends[0].inf(&o.ends[1]), max: o.ends[0].sup(&o.ends[1]) };
    let nearby = Nearby::new(world.openings.iter().map(bounds));
    world
        .openings
        .iter()
        .enumerate()
        .map(|(i, opening)| {
            let alignment = Alignment::new(opening, space, world.openings.len());
            // half of the distance to another opening is left for the straight part
            let farthest = 3.0 * alignment.straight.into_iter().fold(ALIGNMENT_M, f64::max);
            let near = Bounds { min: opening.center(), max: opening.center() }.grown(farthest);
            let others = nearby.meeting(near).into_iter().filter(|j| *j != i);
            let others: Vec<[Point; 2]> = others.map(|j| world.openings[j].ends).collect();
            Passage::new(opening, &others, space, world.robot_width, alignment)
        })
        .collect()
}

/// The error that no path leads to the target, with the reason.
pub(super) fn unreachable(world: &World) -> Error {
    let widest = world.impassable_gaps().into_iter().next();
    let reason = match widest.filter(|gap| gap.width >= MIN_NAMED_M) {
        None => "obstacles enclose it".to_owned(),
        Some(Opening { between, width, .. }) => {
            let [first, second] = between.map(|i| &world.obstacles[i].name);
            let robot_width = world.robot_width;
            format!(
                "no opening leads there; the widest gap that is too narrow for the robot ({robot_width} m) is {width:.4} m wide, between `{first}` and `{second}`"
            )
        }
    };
    let ([sx, sy], [tx, ty]) = ([world.start.x, world.start.y], [world.target.x, world.target.y]);
    refused(
        Place::file(&world.file),
        format_args!("the target ({tx}, {ty}) cannot be reached from the start ({sx}, {sy}): {reason}"),
    )
}

/// An error of the world.
pub(super) fn refused(place: Place, sentence: std::fmt::Arguments) -> Error {
    Error::at(place, sentence).of_kind(ErrorKind::World)
}
