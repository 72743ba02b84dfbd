//! The path of a team with an object: the poses of object and carriers on it, and turns onto another path.
//!
//! A team does not turn on the spot. The carrier in front continues in an arc onto the new path, and the
//! others follow on the same path. Where there is no room for an arc, as in a doorway, the team does not
//! turn. The team takes corners wide, because the object is on their inside.

use super::object_room::ObjectRoom;
use crate::control::RobotObstacles;
use crate::geometry::{Arc, Path, PlanarPose, Point, Tandem, Widening, angle_of, direction, write_turn_onto};
use crate::options::{Crossing, OptionSet};
use crate::world::World;

/// The arcs of turns onto another path; the first that has room is used. The robot follows at a distance, so
/// its arm bends with the path between them, and it cannot bend backward. No turn exceeds 200 degrees.
pub(super) const ARCS: [Arc; 2] = [Arc { radius: 0.5, most: 1.4 }, Arc { radius: 1.0, most: 3.5 }];
/// Clearance (m) around the points of the team's path, and around the object's axis.
pub(super) const BODY_ROOM_M: f64 = 0.249;
const OBJECT_ROOM_M: f64 = 0.1;
/// Distance by which the team cuts corners when rounding them, m.
const ROUNDING_M: f64 = 0.05;
/// Distance of the human's body ahead of the hand, m.
const WALKS_AHEAD_M: f64 = 0.35;
/// Largest motion of the object in one step, m.
const STEP_LIMIT_M: f64 = 0.4;
/// Distance by which the object may be ahead of its target, m.
const AHEAD_TOLERANCE_M: f64 = 0.05;
/// Length of the expected path beyond its end, m.
const ANTICIPATED_BEYOND_M: f64 = 1.0;
/// How far the object's front end may be off a straight path, m.
const STRAIGHT_TOLERANCE_M: f64 = 1e-9;
/// Sampling step of paths, m.
const STEP_M: f64 = 0.05;
/// Step of the search for a place to turn (m), and the number of consecutive places that must allow it.
const SEARCH_STEP_M: f64 = 0.1;
const PLACES_IN_A_ROW: u32 = 2;
/// Search range ahead for an opening, how far the human may be beyond an opening and still reverse through
/// it, and search range for reversing, m.
const SEARCH_AHEAD_M: f64 = 2.0;
const PAST_OPENING_M: f64 = 0.6;
const SEARCH_BEHIND_M: f64 = 1.5;
/// The sharpest bend (rad) of a path for which a team reverses. Between close openings, a path for a point
/// may double back.
pub(super) const MAX_PATH_BEND_RAD: f64 = 2.0;

/// The path of a team.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(super) struct TeamPath {
    tandem: Tandem,
    /// Half the object's width, m.
    #[serde(alias = "beside")]
    half_width: f64,
    /// Distance of the options' paths from obstacles, m.
    clearance: f64,
}

/// The free space of the team.
#[derive(Clone, Copy, Debug)]
pub(super) struct FreeSpace<'g> {
    pub obstacles: &'g RobotObstacles,
    pub options: &'g OptionSet,
    /// Clearance of a body, m.
    pub room: f64,
}

impl<'g> FreeSpace<'g> {
    pub fn new(obstacles: &'g RobotObstacles, options: &'g OptionSet) -> Self {
        Self { obstacles, options, room: BODY_ROOM_M }
    }

    /// Whether a body has room at the end of a step and the step crosses no opening. Only the options' paths
    /// cross openings.
    pub fn is_free(&self, from: Point, to: Point) -> bool {
        self.obstacles.is_clear(to, self.room) && !self.options.goes_through_opening(from, to)
    }
}

/// The path of a turn.
#[derive(Clone, Debug)]
pub struct Turned {
    /// The path of the object's centre.
    pub path: Path,
    /// Position along it (m) at which the turn is complete.
    pub until: f64,
}

impl TeamPath {
    /// The path of a team in this world whose object's centre is at `start`.
    pub fn new(world: &World, start: &PlanarPose) -> Self {
        let [length, width, _] = world.object.size;
        let tandem = Tandem::new(length, start.position, start.yaw);
        Self { tandem, half_width: width / 2.0, clearance: world.robot_width / 2.0 }
    }

    /// The path of a team in this world that stands `at` the beginning of the path `first`, and the object's
    /// pose. The team has come straight in the direction in which the object points on `first`, so where
    /// `first` bends within the length of the object, the team does not have to turn at once. `is_free` as in
    /// [`TeamPath::write_widened`].
    pub fn starting(
        world: &World,
        at: Point,
        first: &Path,
        is_free: impl Fn(Point, Point) -> bool,
    ) -> (Self, PlanarPose) {
        let start = PlanarPose { position: at, yaw: first.heading_at(0.0).unwrap_or(0.0) };
        let team_path = Self::new(world, &start);
        let mut widened = Path::default();
        team_path.write_widened(first, is_free, &mut Widening::default(), &mut widened);
        let front = team_path.end(&team_path.pose(&widened, 0.0), 1.0).position;
        let straight = team_path.end(&start, 1.0).position;
        if (front - straight).norm() < STRAIGHT_TOLERANCE_M {
            return (team_path, start);
        }
        let start = PlanarPose { yaw: angle_of(front - start.position), ..start };
        let team_path = Self::new(world, &start);
        let pose = team_path.pose(&widened, 0.0);
        (team_path, pose)
    }

    /// Writes into `way` the path that the team walks for `path`, which is planned for a point: wide round
    /// corners, as far as `is_free` allows for its steps.
    pub fn write_widened(
        &self,
        path: &Path,
        is_free: impl Fn(Point, Point) -> bool,
        widening: &mut Widening,
        way: &mut Path,
    ) {
        let radius = |narrow: f64, sweep| {
            let obstacle = (narrow - self.clearance).max(0.0);
            self.tandem.corner_radius(sweep, obstacle + self.half_width + OBJECT_ROOM_M + ROUNDING_M)
        };
        widening.write(path, radius, is_free, way);
    }

    /// The path, with room for the object. It stays as it is up to where the human's body is now.
    pub fn with_object_room(&self, path: Path, free_space: FreeSpace) -> Path {
        ObjectRoom::new(&self.tandem, self.half_width, free_space).on(path, self.body_ahead())
    }

    /// The object's pose when its centre has come `walked` (m) along `path`.
    pub fn pose(&self, path: &Path, walked: f64) -> PlanarPose {
        self.tandem.pose(path, walked)
    }

    /// The object's pose if the team turns onto `new_path` at the position `along` (m). `new_path` begins at
    /// the human's body.
    pub fn pose_after_turning(&self, path: &Path, along: f64, new_path: &Path, walked: f64) -> PlanarPose {
        let body = self.body_ahead();
        self.tandem.pose_after_turning(path, along + body, new_path, walked - body)
    }

    /// The point at distance `walked` (m) from the beginning of `path`.
    pub fn point(&self, path: &Path, walked: f64) -> Point {
        self.tandem.point(path, walked)
    }

    /// The object's end toward the human (`side` 1) or the robot (-1).
    pub fn end(&self, pose: &PlanarPose, side: f64) -> PlanarPose {
        self.tandem.end(pose, side)
    }

    /// Half the object's length, m.
    pub fn half(&self) -> f64 {
        self.tandem.length() / 2.0
    }

    /// How far the human's body is ahead of the object's middle, m.
    pub(super) fn body_ahead(&self) -> f64 {
        self.half() + WALKS_AHEAD_M
    }

    /// Position of the human's body when the object's centre is at `walked` (m) and the hand at `hand`: on
    /// the path, whoever leads, at its distance from the hand.
    pub fn body_on(&self, path: &Path, walked: f64, hand: Point) -> Point {
        const STEP: f64 = 0.02;
        let point = |ahead: f64| self.point(path, walked + self.half() + ahead);
        let mut ahead = (0..50).map(|i| point(STEP * f64::from(i)));
        let far_enough = ahead.find(|point| (point - hand).norm() >= WALKS_AHEAD_M);
        far_enough.unwrap_or_else(|| point(WALKS_AHEAD_M))
    }

    /// From the end of `path` to where the human's body stands when the object's centre is there. Where the
    /// path bends shortly before its end, that is farther than elsewhere.
    pub fn beyond_end(&self, path: &Path) -> [Point; 2] {
        let length = path.length();
        let hand = self.end(&self.pose(path, length), 1.0).position;
        [self.point(path, length), self.body_on(path, length, hand)]
    }

    /// The position along `path` (m) of an object with its centre at `position`, which was at `from` a step
    /// ago and should be at `to`. It is at most slightly beyond `to`, as the grips yield. It decreases only
    /// while the team reverses.
    pub fn locate(&self, path: &Path, position: Point, from: f64, to: f64, is_backward: bool) -> f64 {
        let low = if is_backward { (to - AHEAD_TOLERANCE_M).clamp(from - STEP_LIMIT_M, from) } else { from };
        self.tandem.locate(
            path,
            position,
            [low, from + (to + AHEAD_TOLERANCE_M - from).clamp(0.0, STEP_LIMIT_M)],
        )
    }

    /// Position of the human's body and its heading (rad) when the object's centre is at `along` (m).
    fn body(&self, path: &Path, along: f64) -> (Point, f64) {
        let [before, at] = [-0.1, 0.0].map(|ahead| self.point(path, along + self.body_ahead() + ahead));
        (at, angle_of(at - before))
    }

    /// Writes the expected path of the human's body onto `next`, which begins at the object's centre, `along`
    /// (m) on `path`.
    pub fn write_expected(
        &self,
        path: &Path,
        along: f64,
        next: &Path,
        free_space: FreeSpace,
        way: &mut Path,
    ) {
        let (body, heading) = self.body(path, along);
        let is_there = next.length() <= self.body_ahead() + 0.5;
        let is_free = |from, to| free_space.is_free(from, to);
        let turn = |arc: &Arc| write_turn_onto((next, f64::INFINITY), body, heading, *arc, is_free, way);
        if is_there || ARCS.iter().find_map(turn).is_none() {
            // straight on
            way.clear();
            way.line(body, body + direction(heading) * ANTICIPATED_BEYOND_M);
        }
    }

    /// Leaves `path` at the position `along` (m) of the object's centre for a [turn](Self::planned_turn).
    pub fn leave(&mut self, path: &Path, along: f64) {
        self.tandem.leave(path, along);
    }

    /// The turn onto `next`, which begins at the object's centre, `along` (m) on `path`. The path of the turn
    /// leads to the human's body and from there in an arc onto `next`, at least `end` (m) before its end.
    /// `None` if there is no room for the turn.
    pub fn planned_turn(
        &self,
        path: &Path,
        along: f64,
        (next, end): (&Path, f64),
        free_space: FreeSpace,
    ) -> Option<Turned> {
        let (body, heading) = self.body(path, along);
        let is_free = |from, to| free_space.is_free(from, to);
        let (mut next_widened, mut new_path) = (Path::default(), Path::default());
        self.write_widened(next, is_free, &mut Widening::default(), &mut next_widened);
        let latest = if end > 0.0 { next_widened.length() - end } else { f64::INFINITY };
        let turning = ARCS.iter().find_map(|arc| {
            let turning =
                write_turn_onto((&next_widened, latest), body, heading, *arc, is_free, &mut new_path)?;
            self.is_room_for_object(path, along, &new_path, free_space).then_some(turning)
        })?;
        let mut way = Path::default();
        let steps = (self.body_ahead() / STEP_M).ceil();
        let step = self.body_ahead() / steps;
        for i in 0..steps as usize {
            let [from, to] = [i, i + 1].map(|i| self.point(path, along + step * i as f64));
            // where the carrier in front has crossed an opening, the team follows: it does not turn onto a
            // path that avoids the opening
            let is_through = free_space.options.goes_through_opening(from, to);
            if is_through
                && free_space.options.crossing(from, to) != self.first_crossing(next, free_space.options)
            {
                return None;
            }
            way.line(from, to);
        }
        way.push_rest(&new_path, 0.0);
        Some(Turned { path: way, until: self.body_ahead() + turning })
    }

    /// The position along `path` (m), no farther back than `least`, to which a team with the object's centre
    /// at `along` should reverse to turn. `None` if there is no such place, or if the team reaches one before
    /// the human crosses the next opening. `can_turn` tells whether the team can turn at a position (m) along
    /// the path.
    pub fn place_to_turn(
        &self,
        path: &Path,
        [least, along]: [f64; 2],
        can_turn: &dyn Fn(f64) -> bool,
        free_space: FreeSpace,
    ) -> Option<f64> {
        let body = |ahead: f64| self.point(path, along + self.body_ahead() + ahead);
        let is_through =
            |ahead: f64| free_space.options.goes_through_opening(body(ahead), body(ahead + SEARCH_STEP_M));
        let steps = |from: f64, to: f64| {
            let n = ((to - from) / SEARCH_STEP_M).round() as usize;
            (0..n).map(move |i| from + SEARCH_STEP_M * i as f64)
        };
        let opening = steps(-PAST_OPENING_M, SEARCH_AHEAD_M).find(|ahead| is_through(*ahead))?;
        if steps(SEARCH_STEP_M, opening).any(|ahead| can_turn(along + ahead)) {
            return None;
        }
        let mut room = 0;
        steps(SEARCH_STEP_M, SEARCH_BEHIND_M)
            .map(|back| along - back)
            .take_while(|place| *place >= least)
            .find(|place| {
                room = if can_turn(*place) { room + 1 } else { 0 };
                room == PLACES_IN_A_ROW
            })
    }

    /// The first crossing on a path, within the distance of the human's body and a little beyond.
    fn first_crossing(&self, path: &Path, options: &OptionSet) -> Option<Crossing> {
        let steps = ((self.body_ahead() + PAST_OPENING_M) / STEP_M).ceil() as usize;
        let point = |i: usize| path.point_at(STEP_M * i as f64);
        (0..steps).find_map(|i| options.crossing(point(i)?, point(i + 1)?))
    }

    /// Whether the object, whose axis cuts corners, touches no obstacle during the turn.
    fn is_room_for_object(&self, path: &Path, along: f64, new_path: &Path, free_space: FreeSpace) -> bool {
        (0..70).map(|i| 0.08 * f64::from(i)).all(|walked| {
            let pose = self.pose_after_turning(path, along, new_path, walked);
            (-2..=2).all(|i| {
                let point = pose.position + direction(pose.yaw) * (self.half() * f64::from(i) / 2.0);
                free_space.obstacles.is_clear(point, OBJECT_ROOM_M)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The expected path of the human does not lead through walls, although that would be shorter.
    #[test]
    fn the_expected_path_keeps_off_walls() {
        let world = World::parse("w.toml", include_str!("../../worlds/environment-2.toml")).unwrap();
        let options = OptionSet::new(&world, 10.0).unwrap();
        let obstacles = RobotObstacles::new(&world);
        let free_space = FreeSpace::new(&obstacles, &options);
        for option in 0..options.options().len() {
            let mut progress = options.begin();
            let path = options.path(&progress, option).unwrap();
            let start =
                PlanarPose { position: path.point_at(0.0).unwrap(), yaw: path.heading_at(0.0).unwrap() };
            let way = TeamPath::new(&world, &start);
            let mut expected = Path::default();
            for step in 0..30 {
                let along = 0.1 * f64::from(step);
                options.advance(&mut progress, path.point_at(along).unwrap());
                let next = options.path(&progress, option).unwrap();
                way.write_expected(&path, along, &next, free_space, &mut expected);
                for ahead in (0..20).map(|i| 0.1 * f64::from(i)) {
                    let at = expected.point_at(ahead).unwrap();
                    assert!(obstacles.is_clear(at, 0.2), "option {option}, {along} m, {ahead} m ahead: {at}");
                }
            }
        }
    }
}
