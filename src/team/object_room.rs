//! Room for the object along a team's path.
//!
//! The object is the chord between two points of the path, so it is on the inside of every bend: where a path
//! bends in a gap between pillars, or close before an opening, the corner cannot be taken wide, and the
//! object would touch what the path keeps off. The path is shifted there: what is too near to the object
//! pushes the points of the path under its ends, until object and bodies have room, or as much of it as there
//! is. Where the object would turn by more than the arm can follow, the corner is pushed inward.

use super::base_room::pursue;
use super::team_path::{BODY_ROOM_M, FreeSpace};
use crate::geometry::{Footprint, Path, Point, Tandem, Vector, direction, wrap_angle};
use crate::options::Crossing;

/// The room (m) that the object is given.
const OBJECT_ROOM_M: f64 = 0.08;
/// The largest angle by which the object turns, rad per metre of path. Beyond it the arm folds up to its
/// limits.
pub(super) const MAX_TURN_RAD_PER_M: f64 = 2.4;
/// The angle is measured over this distance on either side, m.
const TURN_STEP_M: f64 = 0.05;
/// Distance of the points of a shifted path, m.
const STEP_M: f64 = 0.05;
/// A push shifts the points of the path within this distance (m) of it, the farther ones by less.
const PUSH_REACH_M: f64 = 0.5;
/// The length over which shifts grow from 0 where the path must stay (m), and the length that stays at the
/// end.
const RAMP_M: f64 = 0.5;
const KEPT_AT_END_M: f64 = 0.2;
/// Share of what is missing by which a push shifts, and the largest number of pushes.
const PUSH_SHARE: f64 = 0.6;
const MAX_ROUNDS: usize = 80;
/// A push by a body, as a multiple of the room that it lacks, and the weight of that room: a path that lets
/// bodies touch is worse than one with little room for the object.
const BODY_PUSH: f64 = 1.5;
const BODY_WEIGHT: f64 = 3.0;
/// Where the base is when the object's centre is at the beginning of a path, m, at the farthest.
const BASE_BEHIND_M: f64 = 1.5;
/// A push inward (m), and its weight (m), for a turn that is twice as sharp as the sharpest.
const SHARP_PUSH_M: f64 = 0.1;
const SHARP_WEIGHT_M: f64 = 0.05;
/// The room that may be missing at the end, m.
const TOLERANCE_M: f64 = 0.005;

/// An object and the surroundings in which it must have room.
pub(super) struct ObjectRoom<'a> {
    tandem: &'a Tandem,
    outline: Footprint,
    /// Radius of the circle around the outline, m.
    radius: f64,
    free_space: FreeSpace<'a>,
}

/// The points of a path that is being shifted.
struct Band {
    /// Distance of the points along the path before it was shifted, m.
    step: f64,
    /// The share of a push by which each point may shift.
    shares: Vec<f64>,
    points: Vec<Point>,
    /// The distance that each point must keep from obstacles, m.
    rooms: Vec<f64>,
    /// Sums of pushes and of their weights at each point.
    pushes: Vec<(Vector, f64)>,
}

/// An obstacle that is too near to the object.
struct Near {
    /// The room that the object lacks, m.
    lack: f64,
    /// The direction away from the obstacle.
    away: Vector,
    /// The share of a push that the object's front end takes, by the place that the obstacle is nearest to.
    front: f64,
}

impl<'a> ObjectRoom<'a> {
    /// The object of a team, with half its width (m).
    pub fn new(tandem: &'a Tandem, half_width: f64, free_space: FreeSpace<'a>) -> Self {
        let half = tandem.length() / 2.0;
        let corners = [(-half, -half_width), (half, -half_width), (half, half_width), (-half, half_width)];
        let corners = corners.map(|(x, y)| Point::new(x, y));
        let radius = corners[0].coords.norm();
        Self { tandem, outline: Footprint::Polygon(corners.to_vec()), radius, free_space }
    }

    /// The path with room for the object, or with as much as there is; it stays as it is up to the position
    /// `kept` (m), at its end, and where there is room. It goes through the same openings.
    pub fn on(&self, path: Path, kept: f64) -> Path {
        let mut least = self.missing(&path, kept);
        if least <= TOLERANCE_M {
            return path;
        }
        let Some(mut band) = Band::new(&path, kept, &self.free_space) else { return path };
        let (mut best, mut shifted) = (path, Path::default());
        let crossed = self.crossed(&best);
        for _ in 0..MAX_ROUNDS {
            band.write(&mut shifted);
            let missing = self.push(&shifted, kept, &mut band);
            if missing < least && self.crossed(&shifted) == crossed {
                least = missing;
                best.clone_from(&shifted);
            }
            if missing <= TOLERANCE_M {
                break;
            }
            band.shift();
        }
        best
    }

    /// How much object and base lack along a path that stays up to `kept` (m), m.
    fn missing(&self, path: &Path, kept: f64) -> f64 {
        let mut base: f64 = 0.0;
        self.near_base(path, kept, |_, lack, _| base = base.max(BODY_WEIGHT * lack));
        positions(path.length()).fold(base, |mut missing: f64, along| {
            self.near(path, along, |near| missing = missing.max(near.lack));
            missing.max(self.too_sharp(path, along).map_or(0.0, |(excess, _)| SHARP_WEIGHT_M * excess))
        })
    }

    /// Calls `on_near` for every obstacle that is too near to the object at a position along the path.
    fn near(&self, path: &Path, along: f64, mut on_near: impl FnMut(Near)) {
        let pose = self.tandem.pose(path, along);
        let (ahead, length) = (direction(pose.yaw), self.tandem.length());
        self.free_space.obstacles.near_outline(&pose, (&self.outline, self.radius), OBJECT_ROOM_M, |near| {
            let front = (0.5 + near.lever.dot(&ahead) / length).clamp(0.0, 1.0);
            on_near(Near { lack: OBJECT_ROOM_M - near.distance, away: near.away, front });
        });
    }

    /// Calls `on_near` for every obstacle that a base on its way along the path would touch beyond the position
    /// `kept` (m): with the position along the path (m), how much room it lacks (m), and the direction away from
    /// the obstacle.
    fn near_base(&self, path: &Path, kept: f64, mut on_near: impl FnMut(f64, f64, Vector)) {
        let to = path.length() - self.tandem.length() / 2.0;
        pursue(
            |along| self.tandem.point(path, along),
            [-BASE_BEHIND_M, to],
            |along, at| {
                if along <= kept {
                    return;
                }
                self.free_space.obstacles.near_point(at, BODY_ROOM_M, |distance, away| {
                    on_near(along, BODY_ROOM_M - distance, away);
                });
            },
        );
    }

    /// Where the object turns too sharply: by how much, as a share, and the direction to the inside of the
    /// bend.
    fn too_sharp(&self, path: &Path, along: f64) -> Option<(f64, Vector)> {
        let [before, after] = [-TURN_STEP_M, TURN_STEP_M].map(|by| self.tandem.pose(path, along + by).yaw);
        let rate = wrap_angle(after - before).abs() / (2.0 * TURN_STEP_M);
        let excess = rate / MAX_TURN_RAD_PER_M - 1.0;
        if excess <= 0.0 {
            return None;
        }
        let inward = self.tandem.pose(path, along).position - self.tandem.point(path, along);
        Some((excess, inward.try_normalize(1e-9).unwrap_or_default()))
    }

    /// Pushes the band's points, whose path is `path` and stays up to `kept` (m). Returns what is missing, m.
    fn push(&self, path: &Path, kept: f64, band: &mut Band) -> f64 {
        let mut missing: f64 = 0.0;
        for i in 0..band.points.len() {
            let (at, room) = (band.points[i], band.rooms[i]);
            self.free_space.obstacles.near_point(at, room, |distance, away| {
                missing = missing.max(BODY_WEIGHT * (room - distance));
                band.push_at(i as f64, away * (BODY_PUSH * (room - distance)));
            });
        }
        self.near_base(path, kept, |along, lack, away| {
            missing = missing.max(BODY_WEIGHT * lack);
            band.push_at(band.index(path, along), away * (BODY_PUSH * lack));
        });
        let half = self.tandem.length() / 2.0;
        for along in positions(path.length()) {
            self.near(path, along, |Near { lack, away, front }| {
                missing = missing.max(lack);
                let back = 1.0 - front;
                for (share, end) in [(front, half), (back, -half)] {
                    let by = away * (lack * share / (front * front + back * back));
                    band.push_at(band.index(path, along + end), by);
                }
            });
            if let Some((excess, inward)) = self.too_sharp(path, along) {
                missing = missing.max(SHARP_WEIGHT_M * excess);
                band.push_at(band.index(path, along), inward * (SHARP_PUSH_M * excess));
            }
        }
        missing
    }

    /// The openings that a path crosses, in order.
    fn crossed(&self, path: &Path) -> Vec<Crossing> {
        let points: Vec<Point> = positions(path.length()).filter_map(|along| path.point_at(along)).collect();
        points.windows(2).flat_map(|pair| self.free_space.options.crossings(pair[0], pair[1])).collect()
    }
}

impl Band {
    /// The points of `path`; `None` for a path that must stay as it is.
    fn new(path: &Path, kept: f64, free_space: &FreeSpace) -> Option<Self> {
        let length = path.length();
        let points: Vec<Point> = positions(length).filter_map(|along| path.point_at(along)).collect();
        let ramp = |way: f64| (way / RAMP_M).clamp(0.0, 1.0);
        let share = |along: f64| ramp(along - kept).min(ramp(length - along - KEPT_AT_END_M));
        let shares: Vec<f64> = positions(length).map(share).collect();
        if shares.iter().all(|share| *share == 0.0) {
            return None;
        }
        let room = |p: &Point| {
            let mut room = BODY_ROOM_M;
            free_space.obstacles.near_point(*p, room, |distance, _| room = room.min(distance));
            room.max(0.0)
        };
        let rooms = points.iter().map(room).collect();
        let pushes = vec![(Vector::zeros(), 0.0); points.len()];
        Some(Self { step: length / (points.len() - 1) as f64, shares, points, rooms, pushes })
    }

    /// Writes the path through the points.
    fn write(&self, path: &mut Path) {
        path.clear();
        self.points.windows(2).for_each(|pair| path.line(pair[0], pair[1]));
    }

    /// The index of the point at a position along the path.
    fn index(&self, path: &Path, along: f64) -> f64 {
        along / path.length() * (self.points.len() - 1) as f64
    }

    /// Adds a push of the points around an index.
    fn push_at(&mut self, index: f64, by: Vector) {
        let (reach, last) = (PUSH_REACH_M / self.step, (self.points.len() - 1) as f64);
        let [from, to] = [index - reach, index + reach].map(|i| i.clamp(0.0, last) as usize);
        for (i, (sum, weights)) in self.pushes.iter_mut().enumerate().take(to + 1).skip(from) {
            let off = (i as f64 - index) / reach;
            let weight = (1.0 - off * off).max(0.0);
            let weight = weight * weight;
            *sum += by * weight;
            *weights += weight;
        }
    }

    /// Shifts the points by the means of their pushes.
    fn shift(&mut self) {
        for ((point, share), push) in self.points.iter_mut().zip(&self.shares).zip(&mut self.pushes) {
            let (sum, weights) = std::mem::take(push);
            *point += sum * (PUSH_SHARE * share / weights.max(1.0));
        }
    }
}

/// Positions along a path of this length, at most [`STEP_M`] apart, m.
fn positions(length: f64) -> impl Iterator<Item = f64> {
    let steps = (length / STEP_M).ceil().max(1.0);
    (0..=steps as usize).map(move |i| length * i as f64 / steps)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::RobotObstacles;
    use crate::options::OptionSet;
    use crate::world::World;

    /// A path that goes through the gap between two pillars and turns by so much (rad) in it, with its world.
    fn round_a_pillar(turn: f64) -> (World, Path) {
        let text = "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [-4, 0]\ntarget_m = [4, 0.2]\n\
                    [[obstacle]]\nname = \"a\"\nshape = \"cylinder\"\ncenter_m = [0, 0.6]\nradius_m = 0.2\nheight_m = 1\n\
                    [[obstacle]]\nname = \"b\"\nshape = \"cylinder\"\ncenter_m = [0, -0.6]\nradius_m = 0.2\nheight_m = 1\n";
        let mut path = Path::default();
        path.line(Point::new(-4.0, 0.0), Point::origin());
        path.line(Point::origin(), Point::from(direction(turn) * 4.0));
        (World::parse("w.toml", text).unwrap(), path)
    }

    fn rooms(turn: f64, width: f64) -> (Path, Path, [f64; 2]) {
        let (world, path) = round_a_pillar(turn);
        let (options, obstacles) = (OptionSet::new(&world, 10.0).unwrap(), RobotObstacles::new(&world));
        let tandem = Tandem::new(1.2, Point::new(-4.0, 0.0), 0.0);
        let free_space = FreeSpace::new(&obstacles, &options);
        let room = ObjectRoom::new(&tandem, width / 2.0, free_space);
        let shifted = room.on(path.clone(), 1.0);
        let missing = [&path, &shifted].map(|path| room.missing(path, 1.0));
        assert_eq!(room.crossed(&path), room.crossed(&shifted));
        assert_eq!(room.crossed(&path).len(), 1);
        (path, shifted, missing)
    }

    #[test]
    fn a_path_with_room_stays_as_it_is() {
        for turn in [0.0, 0.2] {
            let (path, shifted, _) = rooms(turn, 0.1);
            assert_eq!(path, shifted, "turn {turn}");
        }
    }

    #[test]
    fn round_a_pillar_the_path_makes_room_for_the_object_and_keeps_its_ends() {
        for turn in [0.9, -0.9] {
            let (path, shifted, [before, after]) = rooms(turn, 0.14);
            assert!(before > OBJECT_ROOM_M, "turn {turn}: the object touches: {before}");
            assert!(after <= TOLERANCE_M, "turn {turn}: {after} m of {before} m are missing");
            for along in [0.0, 0.5, 1.0] {
                let [a, b] = [&path, &shifted].map(|path| path.point_at(along).unwrap());
                assert!((a - b).norm() < 1e-12, "turn {turn}: {a} {b}");
            }
            let [a, b] = [&path, &shifted].map(|path| path.point_at(f64::INFINITY).unwrap());
            assert!((a - b).norm() < 1e-12, "turn {turn}: {a} {b}");
        }
    }

    #[test]
    fn a_corner_that_is_too_sharp_for_the_arm_is_rounded() {
        let (world, _) = round_a_pillar(0.0);
        let (options, obstacles) = (OptionSet::new(&world, 10.0).unwrap(), RobotObstacles::new(&world));
        let tandem = Tandem::new(1.2, Point::new(-8.0, 5.0), 0.0);
        let room = ObjectRoom::new(&tandem, 0.05, FreeSpace::new(&obstacles, &options));
        let mut path = Path::default();
        path.line(Point::new(-8.0, 5.0), Point::new(-4.0, 5.0));
        path.line(Point::new(-4.0, 5.0), Point::new(-4.0, 5.0) + direction(2.2) * 4.0);
        let shifted = room.on(path.clone(), 1.0);
        let [before, after] = [&path, &shifted].map(|path| room.missing(path, 1.0));
        assert!(before > 0.01 && after <= TOLERANCE_M, "{before} {after}");
        assert!(shifted.length() < path.length());
    }
}
