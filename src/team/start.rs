//! The start of a team with bodies: in line with its first path, or turned by as little as the surroundings ask
//! for.

use super::Pace;
use super::ends::{NoRoom, check, turns};
use super::in_tandem::InTandem;
use super::team_path::{BODY_ROOM_M, FreeSpace, TeamPath};
use crate::control::RobotObstacles;
use crate::error::Error;
use crate::geometry::{Path, PlanarPose, Point, direction, wrap_angle};
use crate::options::OptionSet;
use crate::world::World;
use std::f64::consts::TAU;

/// The largest angle (rad) between the object and the path ahead at which a team starts without an arc.
const BENT_RAD: f64 = 0.7;
/// Headings closer than this (rad) are the same.
const SAME_HEADING_RAD: f64 = 1e-9;
/// How far from A or B another one is looked for (m), in rings of this width and with this many places each.
pub(super) const SEARCH_M: f64 = 3.0;
pub(super) const RING_M: f64 = 0.1;
const PLACES: u32 = 24;
const PLACE_STEP_M: f64 = 0.01;
/// The accuracy of the missing room in messages, m.
const MISSING_STEP_M: f64 = 0.01;

/// The conditions that decide where a team starts.
#[derive(Clone, Copy)]
pub struct Surroundings<'a, 'b> {
    /// The world.
    pub world: &'b World,
    /// Its options.
    pub options: &'a OptionSet,
    /// Its obstacles.
    pub obstacles: &'a RobotObstacles,
    /// The position of the robot's base for a pose of the object.
    pub base: &'b dyn Fn(&PlanarPose) -> Point,
}

impl<'a> InTandem<'a> {
    /// A team at rest at the start of the path `first`, straight, as it was when it came, and the pose of the
    /// object. The team is in line with the path; where there is no room for that, it is turned by the least
    /// multiple of 10 degrees from which it can turn onto the path. A world may give the heading.
    ///
    /// # Errors
    /// [`ErrorKind::World`](crate::error::ErrorKind::World): the robot or the human has no room at any heading.
    pub fn starting(
        surroundings: Surroundings<'a, '_>,
        first: &Path,
        pace: Pace,
    ) -> Result<(Self, PlanarPose), Error> {
        let Surroundings { world, options, obstacles, .. } = surroundings;
        let start = Start {
            surroundings,
            free_space: FreeSpace::new(obstacles, options),
            pace,
            at: world.start,
            first,
        };
        start.stand(&[true, false]).map_err(|mut room| {
            let is_there = |place: &Point| {
                let mut progress = options.begin();
                options.advance(&mut progress, *place);
                let has_room_aside = obstacles.is_clear(*place, world.robot_width / 2.0)
                    && !options.goes_through_opening(world.start, *place);
                let path = |o| options.path_passing(&progress, o, Self::PASSING);
                // whichever the robot prefers there
                let mut paths = (0..options.options().len()).filter_map(path).peekable();
                has_room_aside
                    && paths.peek().is_some()
                    && paths.all(|path| Start { at: *place, first: &path, ..start }.stand(&[false]).is_ok())
            };
            let can_turn = |missing: &f64| {
                let free_space = FreeSpace { room: BODY_ROOM_M - missing, ..start.free_space };
                Start { free_space, ..start }.stand(&[false]).is_ok()
            };
            if room.is_for_turn() {
                room.to_turn = less_room().find(can_turn);
            }
            let nearest = if start.is_given_ahead() { None } else { places(world.start).find(is_there) };
            room.at_start(world, nearest)
        })
    }
}

/// A team that is to stand at a place, from which it walks along a path.
#[derive(Clone, Copy)]
struct Start<'a, 'b> {
    surroundings: Surroundings<'a, 'b>,
    free_space: FreeSpace<'a>,
    pace: Pace,
    at: Point,
    first: &'b Path,
}

impl<'a> Start<'a, '_> {
    fn team(&self, (path, pose): (TeamPath, PlanarPose), faces_path: bool) -> InTandem<'a> {
        InTandem::new(self.free_space, self.pace, (path, pose), faces_path)
    }

    /// In line with the path.
    fn in_line(&self) -> InTandem<'a> {
        let is_free = |from, to| self.free_space.is_free(from, to);
        self.team(TeamPath::starting(self.surroundings.world, self.at, self.first, is_free), true)
    }

    /// The turn away from straight ahead that the world gives, rad.
    fn given(&self, ahead: &PlanarPose) -> Option<f64> {
        self.surroundings.world.start_heading.map(|heading| wrap_angle(heading - ahead.yaw))
    }

    fn is_given_ahead(&self) -> bool {
        self.given(&self.in_line().goal()).is_some_and(|turn| turn.abs() < SAME_HEADING_RAD)
    }

    fn starts_gently(&self, team: &InTandem) -> bool {
        self.surroundings.world.start_heading.is_some() || team.starts_gently(self.first)
    }

    /// The team in line or, where there is no room for that, turned, and the pose of the object. `tries` has
    /// whether a turn has to be slow enough for the arm, in order.
    fn stand(&self, tries: &[bool]) -> Result<(InTandem<'a>, PlanarPose), NoRoom> {
        let Surroundings { world, base, .. } = self.surroundings;
        let in_line = self.in_line();
        let ahead = in_line.goal();
        let given = self.given(&ahead);
        let room = check(world, BODY_ROOM_M, [ahead.position, base(&ahead)]);
        if given.is_none_or(|turn| turn.abs() < SAME_HEADING_RAD) && self.starts_gently(&in_line) {
            match room {
                Ok(()) => return Ok((in_line, ahead)),
                Err(room) if given.is_some() => return Err(room),
                Err(_) => {}
            }
        }
        let found = match given {
            Some(turn) => self.turned(&ahead, turn, false),
            None => self.turned_least(&ahead, tries),
        };
        if found.is_err() && given.is_none() && room.is_ok() { Ok((in_line, ahead)) } else { found }
    }

    /// The team turned by the least angle at which there is room.
    fn turned_least(&self, ahead: &PlanarPose, tries: &[bool]) -> Result<(InTandem<'a>, PlanarPose), NoRoom> {
        // rather from farther round than in a turn that is too sharp for the arm
        let mut turns = tries.iter().flat_map(|gentle| turns().map(move |by| (by, *gentle)));
        let mut refusal: Option<NoRoom> = None;
        let found = turns.find_map(|(turn, is_gentle)| match self.turned(ahead, turn, is_gentle) {
            Ok(team) => Some(team),
            Err(room) => {
                if refusal.as_ref().is_none_or(|before| room.distance > before.distance) {
                    refusal = Some(room);
                }
                None
            }
        });
        found.ok_or_else(|| refusal.expect("headings are tried"))
    }

    /// The team turned by this angle (rad) from straight ahead.
    fn turned(
        &self,
        ahead: &PlanarPose,
        turn: f64,
        is_gentle: bool,
    ) -> Result<(InTandem<'a>, PlanarPose), NoRoom> {
        let Surroundings { world, base, .. } = self.surroundings;
        let at = ahead.position;
        let pose = PlanarPose { position: at, yaw: wrap_angle(ahead.yaw + turn) };
        if turn.abs() <= BENT_RAD {
            // the human on the path, the robot on a way that bends at A
            let way = PlanarPose { yaw: wrap_angle(ahead.yaw + 2.0 * turn), ..pose };
            let bent = self.team((TeamPath::new(world, &way), pose), true);
            let pose = bent.team_path().pose(&bent.widened(self.first), 0.0);
            let behind = at - direction(way.yaw) * (at - base(&pose)).norm();
            let has_room = |to: Point| check(world, BODY_ROOM_M, [at, to]).is_ok();
            if self.starts_gently(&bent) && has_room(base(&pose)) && has_room(behind) {
                return Ok((self.team((bent.team_path().clone(), pose), true), pose));
            }
        }
        let team = self.team((TeamPath::new(world, &pose), pose), false);
        team.check_start(world, base(&pose), self.first, is_gentle).map(|()| (team, pose))
    }
}

/// By how much less room a turn is tried to name what is missing, m.
fn less_room() -> impl Iterator<Item = f64> {
    let steps = (BODY_ROOM_M / MISSING_STEP_M) as u32;
    (1..=steps).map(|i| MISSING_STEP_M * f64::from(i))
}

/// Places around a point, the nearest first, rounded as in messages.
pub(super) fn places(around: Point) -> impl Iterator<Item = Point> {
    let rings = (SEARCH_M / RING_M).round() as u32;
    (1..=rings).flat_map(move |ring| {
        let angle = |i: u32| TAU * f64::from(i) / f64::from(PLACES);
        (0..PLACES).map(move |i| rounded(around + direction(angle(i)) * (RING_M * f64::from(ring))))
    })
}

/// A place as messages give it.
pub(super) fn rounded(place: Point) -> Point {
    place.map(|x| (x / PLACE_STEP_M).round() * PLACE_STEP_M)
}
