//! How far the straight lines that leave a circle, or a point, can lead before an obstacle or a closed gap
//! ends them. Lines that would be longer need not be tried.

use super::space::{LOOKUP_MARGIN_M, Space};
use crate::geometry::{Bounds, Footprint, Nearby, Point, Vector, angle_of, wrap_angle};
use crate::math;
use std::f64::consts::{FRAC_PI_2, TAU};

/// The radius (m) around a source within which blocks are first looked for.
const FIRST_RADIUS_M: f64 = 2.0;
/// The factor by which this radius grows until the blocks within it hide all that is farther away.
const RADIUS_GROWTH: f64 = 1.5;
/// The number of blocks within the radius at which the view counts as open.
const MAX_BLOCKS: usize = 600;
/// The number of obstacles up to which all lines are tried at once.
const FEW_OBSTACLES: usize = 50;
/// The part of a block that is closer to a point than this (m) is left out.
const MIN_RADIUS_M: f64 = 1e-6;
/// The angle (rad) between two blocks below which no line passes between them: their ends lie in obstacles.
const NO_GAP_RAD: f64 = 1e-9;
/// The number of sectors of normals for which bounds are kept, and their angle.
const SECTORS: usize = u128::BITS as usize;
const SECTOR_RAD: f64 = TAU / SECTORS as f64;
/// The largest distance (m) from an obstacle to the end of a gap next to it.
const AT_OUTLINE_M: f64 = 1e-3;

/// Segments that no clear line crosses. There are none where obstacles are few.
pub(super) struct Sight {
    blocks: Vec<[Point; 2]>,
    near: Nearby,
}

impl Sight {
    /// The sides of the obstacles, the barriers, and `closed` gaps, which are too narrow. Every gap is
    /// extended into the obstacles next to it, so that no slit is left at its ends.
    pub fn new(space: &Space, closed: &[[Point; 2]]) -> Self {
        if space.obstacles.len() <= FEW_OBSTACLES {
            return Self::open();
        }
        let gaps = || space.barriers.iter().chain(closed);
        let mut blocks: Vec<[Point; 2]> = space.obstacles.iter().flat_map(|(o, _)| sides(o)).collect();
        blocks.extend(gaps());
        for end in gaps().flatten() {
            let within = AT_OUTLINE_M.min(space.clearance / 2.0);
            let near = Bounds { min: *end, max: *end }.grown(within);
            space.near_obstacles.any_meeting(near, |i| {
                let outline = &space.obstacles[i].0;
                if outline.distance_to_point(*end) <= within {
                    blocks.push([*end, inside(outline)]);
                }
                false
            });
        }
        let near = Nearby::new(blocks.iter().map(|[a, b]| Bounds { min: a.inf(b), max: a.sup(b) }));
        Self { blocks, near }
    }

    /// Sight without a block.
    pub fn open() -> Self {
        Self { blocks: Vec::new(), near: Nearby::new([]) }
    }

    /// How far the clear lines lead that leave the circle of this radius (m) around `center`, in each of these
    /// directions of travel around it: counter-clockwise where the turn is 1 and clockwise where it is -1.
    ///
    /// Such a line leaves the circle where the normal has some angle. Every point that is not inside the
    /// circle is on exactly one of these lines. A block ends the lines of all angles between those of its
    /// ends, because the angle changes continuously along it. A point is a circle without radius, whose lines
    /// lead to the left of the normal where the turn is 1.
    pub fn views<const N: usize>(&self, center: Point, radius: f64, turns: [f64; N]) -> [View; N] {
        let mut views = [(); N].map(|()| View::open());
        if self.blocks.is_empty() {
            return views;
        }
        let (mut before, mut within) = (0.0, radius + FIRST_RADIUS_M);
        let mut ended = [(); N].map(|()| EndedLines::default());
        loop {
            let mut count = 0;
            self.near.any_meeting(Bounds { min: center, max: center }.grown(within), |i| {
                count += 1;
                let [a, b] = self.blocks[i].map(|p| p - center);
                let far = a.norm().max(b.norm());
                if before < far && far <= within {
                    for part in outside(a, b, radius.max(MIN_RADIUS_M)).into_iter().flatten() {
                        let ends = part.map(|p| (angle_of(p), math::acos((radius / p.norm()).min(1.0))));
                        for ((view, ended), turn) in views.iter_mut().zip(&mut ended).zip(turns) {
                            if view.farthest.is_infinite() {
                                let angles = angles(ends, turn);
                                view.end(angles, far);
                                ended.add(angles);
                            }
                        }
                    }
                }
                false
            });
            for (view, ended) in views.iter_mut().zip(&mut ended) {
                if view.farthest.is_infinite() && ended.is_all() {
                    let bound = view.sectors.iter().fold(0.0, |most, bound| bound.max(most));
                    view.farthest = f64::from(bound).min(within) + LOOKUP_MARGIN_M;
                }
            }
            let is_done = views.iter().all(|view| view.farthest.is_finite());
            if is_done || count >= MAX_BLOCKS || count == self.blocks.len() {
                return views;
            }
            (before, within) = (within, within * RADIUS_GROWTH);
        }
    }
}

/// How far the clear lines lead that leave a circle in one direction of travel around it.
#[derive(Clone, Debug)]
pub(super) struct View {
    /// A bound of the distance (m) from the circle's centre to the far end of any of them; infinite where the
    /// view is open.
    pub farthest: f64,
    /// Such a bound for the lines that leave where the normal is in each of equal sectors, rounded up; empty
    /// where nothing ends a line.
    sectors: Vec<f32>,
}

impl View {
    fn open() -> Self {
        Self { farthest: f64::INFINITY, sectors: Vec::new() }
    }

    /// That a block, no part of which is farther (m), ends the lines between two angles as of [`angles`].
    fn end(&mut self, [first, last]: [f64; 2], far: f64) {
        let [first, last] =
            [((first + NO_GAP_RAD) / SECTOR_RAD).ceil(), ((last - NO_GAP_RAD) / SECTOR_RAD).floor()];
        if first < last && self.sectors.is_empty() {
            self.sectors = vec![f32::INFINITY; SECTORS];
        }
        for sector in first as usize..last as usize {
            let bound = &mut self.sectors[sector % SECTORS];
            *bound = bound.min((far as f32).next_up());
        }
    }

    /// Whether something ends the line that leaves where the normal has this angle (rad) before a point at this
    /// distance (m) from the centre. Not every such line is found.
    pub fn hides(&self, angle: f64, distance: f64) -> bool {
        let sector = (angle.rem_euclid(TAU) / SECTOR_RAD) as usize % SECTORS;
        self.sectors.get(sector).is_some_and(|bound| distance > f64::from(*bound) + LOOKUP_MARGIN_M)
    }

    /// As [`View::hides`], of the line along this vector from a point whose view this is.
    pub fn hides_along(&self, line: Vector) -> bool {
        !self.sectors.is_empty() && self.hides(angle_of(line) - FRAC_PI_2, line.norm())
    }
}

/// The angles of lines that blocks end.
#[derive(Default)]
struct EndedLines {
    intervals: Vec<[f64; 2]>,
    /// The sectors, by bits, that have some of them.
    sectors: u128,
}

impl EndedLines {
    fn add(&mut self, [first, last]: [f64; 2]) {
        let [from, to] = [first, last].map(|angle| (angle / SECTOR_RAD) as usize);
        for sector in from..=to.min(from + SECTORS) {
            self.sectors |= 1 << (sector % SECTORS);
        }
        self.intervals.push([first, last]);
        self.intervals.push([first - TAU, last - TAU]);
    }

    /// Whether they are all.
    fn is_all(&mut self) -> bool {
        self.sectors == u128::MAX && is_whole_turn(&mut self.intervals)
    }
}

/// The sides of an outline, or of a square in a disc.
fn sides(outline: &Footprint) -> Vec<[Point; 2]> {
    let corners = match outline {
        Footprint::Polygon(corners) => corners.clone(),
        Footprint::Disc { center, radius } => {
            let (x, y) = (Vector::x() * *radius, Vector::y() * *radius);
            vec![center - x, center - y, center + x, center + y]
        }
    };
    (0..corners.len()).map(|i| [corners[i], corners[(i + 1) % corners.len()]]).collect()
}

fn inside(outline: &Footprint) -> Point {
    match outline {
        Footprint::Polygon(corners) => nalgebra::center(&corners[0], &corners[corners.len() / 2]),
        Footprint::Disc { center, .. } => *center,
    }
}

/// The parts of the segment `a b` outside of the circle of this radius (m) around the origin.
fn outside(a: Vector, b: Vector, radius: f64) -> [Option<[Vector; 2]>; 2] {
    let along = b - a;
    let (qa, qb, qc) = (along.norm_squared(), a.dot(&along), a.norm_squared() - radius * radius);
    let discriminant = qb * qb - qa * qc;
    if discriminant <= 0.0 || qa == 0.0 {
        return [(qc >= 0.0).then_some([a, b]), None];
    }
    let root = discriminant.sqrt();
    let [enters, leaves] = [(-qb - root) / qa, (-qb + root) / qa];
    if enters >= 1.0 || leaves <= 0.0 {
        return [Some([a, b]), None];
    }
    [(enters > 0.0).then(|| [a, a + along * enters]), (leaves < 1.0).then(|| [a + along * leaves, b])]
}

/// The angles (rad) of the normals between which the lines from a circle meet a segment, ascending, the first
/// from 0 to a full turn. `ends` has, for each end of the segment, the angle of the direction to it from the
/// centre, and the angle between this direction and the normal of the line that meets it.
fn angles(ends: [(f64, f64); 2], turn: f64) -> [f64; 2] {
    let [(a, ahead_a), (b, ahead_b)] = ends;
    let from = a - turn * ahead_a;
    let by = wrap_angle(b - a) - turn * (ahead_b - ahead_a);
    let first = from.min(from + by).rem_euclid(TAU);
    [first, first + by.abs()]
}

/// Whether these intervals, sorted here, leave no gap between 0 and a full turn.
fn is_whole_turn(intervals: &mut [[f64; 2]]) -> bool {
    intervals.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let mut to = 0.0;
    for [first, last] in intervals {
        if *first > to + NO_GAP_RAD {
            return false;
        }
        to = last.max(to);
    }
    to >= TAU - NO_GAP_RAD
}
