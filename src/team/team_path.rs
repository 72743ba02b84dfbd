//! How a team with an object walks a path: where the object and the carriers' bodies are on it, and how the team turns onto another.
//!
//! A team does not turn on the spot: whoever walks ahead goes on from where they are, in an arc onto the new path, and the others follow on
//! the same way. Where there is no room for that, in a doorway say, the team does not turn. Corners that a point would cut closely are
//! walked wide, for the object is on their inside.

use crate::control::RobotObstacles;
use crate::geometry::{Arc, Path, PlanarPose, Point, Tandem, Widening, angle_of, direction, write_turn_onto};
use crate::options::{Crossing, OptionSet};
use crate::world::World;

/// The arcs in which a team turns onto another path: the first with which there is room. The robot follows at some distance, so that its
/// arm has to bend as the way does in between; it cannot bend back. Nobody turns in a loop, by more than 200 degrees.
const ARCS: [Arc; 2] = [Arc { radius: 0.5, most: 1.4 }, Arc { radius: 1.0, most: 3.5 }];
/// Room (m) that the team wants around the points of its way, and around the object's axis.
pub(super) const BODY_ROOM_M: f64 = 0.249;
const OBJECT_ROOM_M: f64 = 0.1;
/// What the team takes off corners by rounding them, m.
const ROUNDING_M: f64 = 0.05;
/// How far ahead of the hand the human walks, m.
pub(super) const WALKS_AHEAD_M: f64 = 0.35;
/// How far (m) the object may come in one step.
const STEP_LIMIT_M: f64 = 0.4;
/// How far (m) the object may be ahead of where it is to be.
const AHEAD_TOLERANCE_M: f64 = 0.05;
/// What is anticipated of a way beyond its end, m.
const ANTICIPATED_BEYOND_M: f64 = 1.0;
/// Steps in which a way is taken over, m.
const STEP_M: f64 = 0.05;
/// In which steps (m) a team looks for where it can turn, and how many places in a row are enough: a step is no longer.
const SEARCH_STEP_M: f64 = 0.1;
const PLACES_IN_A_ROW: u32 = 2;
/// How far it looks ahead for an opening, how far through one its first may be to step back, and how far back it does at most, m.
const SEARCH_AHEAD_M: f64 = 2.0;
const PAST_OPENING_M: f64 = 0.6;
const SEARCH_BEHIND_M: f64 = 1.5;
/// Nobody steps back for a path with a sharper bend than this (rad): between openings close to each other, a point's may double back.
const SHARPEST_BEND_RAD: f64 = 2.0;

/// The way of a team.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub(super) struct TeamPath {
    tandem: Tandem,
    /// Half the object's width, m.
    beside: f64,
    /// How far options' paths keep off obstacles, m.
    clearance: f64,
}

/// Where the team walks.
#[derive(Clone, Copy)]
pub(super) struct Ground<'g> {
    pub obstacles: &'g RobotObstacles,
    pub options: &'g OptionSet,
}

impl Ground<'_> {
    /// Whether a body has room at the end of a step, and the step does not go through an opening: only options' paths do.
    pub fn is_free(&self, from: Point, to: Point) -> bool {
        self.obstacles.is_clear(to, BODY_ROOM_M) && !self.options.goes_through_opening(from, to)
    }
}

/// A path on which a team turns.
#[derive(Clone, Debug)]
pub struct Turned {
    /// What the object's middle walks.
    pub path: Path,
    /// How far along it (m) the team has turned.
    pub until: f64,
}

impl TeamPath {
    /// A team in this world whose object is at `start` with its middle.
    pub fn new(world: &World, start: &PlanarPose) -> Self {
        let [length, width, _] = world.object.size;
        let tandem = Tandem::new(length, start.position, start.yaw);
        Self { tandem, beside: width / 2.0, clearance: world.robot_width / 2.0 }
    }

    /// Writes `path`, made for a point, as the team walks it into `way`: wide round corners, as far as `is_free` says of steps.
    pub fn write_wide(
        &self,
        path: &Path,
        is_free: impl Fn(Point, Point) -> bool,
        widening: &mut Widening,
        way: &mut Path,
    ) {
        let radius = |narrow: f64, sweep| {
            let obstacle = (narrow - self.clearance).max(0.0);
            self.tandem.corner_radius(sweep, obstacle + self.beside + OBJECT_ROOM_M + ROUNDING_M)
        };
        widening.write(path, radius, is_free, way);
    }

    /// The object when its middle has come `walked` (m) along `path`.
    pub fn pose(&self, path: &Path, walked: f64) -> PlanarPose {
        self.tandem.pose(path, walked)
    }

    /// The same if the team turns onto `onto` when it has come `along` (m); `onto` begins where the human's body is then.
    pub fn pose_after_turning(&self, path: &Path, along: f64, onto: &Path, walked: f64) -> PlanarPose {
        let body = self.body_ahead();
        self.tandem.pose_after_turning(path, along + body, onto, walked - body)
    }

    /// The point of the way that is `walked` (m) from the beginning of `path`.
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
    fn body_ahead(&self) -> f64 {
        self.half() + WALKS_AHEAD_M
    }

    /// Where the human's body walks on to while the object comes to the end of `path`: from there straight ahead.
    pub fn beyond_end(&self, path: &Path) -> [Point; 2] {
        [0.0, self.body_ahead()].map(|beyond| self.point(path, path.length() + beyond))
    }

    /// How far along `path` (m) an object is whose middle is at `position`, if it was at `from` a step ago and is to be at `to`. It is no
    /// farther than that, but for a little that the grips yield; it comes back only with a team that steps back.
    pub fn locate(&self, path: &Path, position: Point, from: f64, to: f64, is_backward: bool) -> f64 {
        let low = if is_backward { (to - AHEAD_TOLERANCE_M).clamp(from - STEP_LIMIT_M, from) } else { from };
        self.tandem.locate(
            path,
            position,
            [low, from + (to + AHEAD_TOLERANCE_M - from).clamp(0.0, STEP_LIMIT_M)],
        )
    }

    /// Where the human's body is when the object's middle has come `along` (m), and where it heads, rad.
    fn body(&self, path: &Path, along: f64) -> (Point, f64) {
        let [before, at] = [-0.1, 0.0].map(|ahead| self.point(path, along + self.body_ahead() + ahead));
        (at, angle_of(at - before))
    }

    /// Writes the way from where the human's body is, when the object's middle has come `along` (m) on `path`, onto `next`, which begins at the
    /// middle: what somebody would expect.
    pub fn write_onto(&self, path: &Path, along: f64, next: &Path, ground: Ground, way: &mut Path) {
        let (body, heading) = self.body(path, along);
        let is_there = next.length() <= self.body_ahead() + 0.5;
        let is_free = |from, to| ground.is_free(from, to);
        let turn = |arc: &Arc| write_turn_onto(next, body, heading, *arc, is_free, way);
        if is_there || ARCS.iter().find_map(turn).is_none() {
            // straight on
            way.clear();
            way.line(body, body + direction(heading) * ANTICIPATED_BEYOND_M);
        }
    }

    /// The team, its object's middle `along` (m) on `path`, leaves it for a [turn](Self::planned_turn).
    pub fn leave(&mut self, path: &Path, along: f64) {
        self.tandem.leave(path, along);
    }

    /// How the team, its object's middle `along` (m) on `path`, would turn onto `next`, which begins there: what the middle walks instead
    /// of `next`, on to where the human's body is, and in an arc onto `next`. `None` if there is no room for that there.
    pub fn planned_turn(&self, path: &Path, along: f64, next: &Path, ground: Ground) -> Option<Turned> {
        let (body, heading) = self.body(path, along);
        let is_free = |from, to| ground.is_free(from, to);
        let (mut next_wide, mut onto) = (Path::default(), Path::default());
        self.write_wide(next, is_free, &mut Widening::default(), &mut next_wide);
        let turning = ARCS.iter().find_map(|arc| {
            let turning = write_turn_onto(&next_wide, body, heading, *arc, is_free, &mut onto)?;
            self.is_room_for_object(path, along, &onto, ground).then_some(turning)
        })?;
        let mut way = Path::default();
        let steps = (self.body_ahead() / STEP_M).ceil();
        let step = self.body_ahead() / steps;
        for i in 0..steps as usize {
            let [from, to] = [i, i + 1].map(|i| self.point(path, along + step * i as f64));
            // whoever walks ahead is through, and so is the team: it does not turn onto a way that does not go through as well
            let is_through = ground.options.goes_through_opening(from, to);
            if is_through && ground.options.crossing(from, to) != self.first_crossing(next, ground.options) {
                return None;
            }
            way.line(from, to);
        }
        way.push_rest(&onto, 0.0);
        Some(Turned { path: way, until: self.body_ahead() + turning })
    }

    /// Where along `path` (m), no farther back than `least`, a team whose object's middle is `along` it had better step back to, to turn there:
    /// `None` if there is no such place, or the team comes to one before whoever walks ahead is through the next opening. `next` is the path to
    /// turn onto, from where it is told that the middle is.
    pub fn place_to_turn(
        &self,
        path: &Path,
        [least, along]: [f64; 2],
        next: &dyn Fn(Point) -> Path,
        ground: Ground,
    ) -> Option<f64> {
        let can_turn = |along: f64| {
            let next = next(self.point(path, along));
            next.sharpest_bend() <= SHARPEST_BEND_RAD
                && self.planned_turn(path, along, &next, ground).is_some()
        };
        let body = |ahead: f64| self.point(path, along + self.body_ahead() + ahead);
        let is_through =
            |ahead: f64| ground.options.goes_through_opening(body(ahead), body(ahead + SEARCH_STEP_M));
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

    /// The crossing that a path makes before whoever walks ahead is far from here.
    fn first_crossing(&self, path: &Path, options: &OptionSet) -> Option<Crossing> {
        let steps = ((self.body_ahead() + PAST_OPENING_M) / STEP_M).ceil() as usize;
        let point = |i: usize| path.point_at(STEP_M * i as f64);
        (0..steps).find_map(|i| options.crossing(point(i)?, point(i + 1)?))
    }

    /// Whether the object, whose axis cuts corners, touches nothing while it turns.
    fn is_room_for_object(&self, path: &Path, along: f64, onto: &Path, ground: Ground) -> bool {
        (0..70).map(|i| 0.08 * f64::from(i)).all(|walked| {
            let pose = self.pose_after_turning(path, along, onto, walked);
            (-2..=2).all(|i| {
                let point = pose.position + direction(pose.yaw) * (self.half() * f64::from(i) / 2.0);
                ground.obstacles.is_clear(point, OBJECT_ROOM_M)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nobody is expected to walk through walls, which are the shorter way.
    #[test]
    fn who_goes_on_is_expected_to_keep_off_walls() {
        let world = World::parse("w.toml", include_str!("../../worlds/environment-2.toml")).unwrap();
        let options = OptionSet::new(&world, 10.0).unwrap();
        let obstacles = RobotObstacles::new(&world);
        let ground = Ground { obstacles: &obstacles, options: &options };
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
                way.write_onto(&path, along, &next, ground, &mut expected);
                for ahead in (0..20).map(|i| 0.1 * f64::from(i)) {
                    let at = expected.point_at(ahead).unwrap();
                    assert!(obstacles.is_clear(at, 0.2), "option {option}, {along} m, {ahead} m ahead: {at}");
                }
            }
        }
    }
}
