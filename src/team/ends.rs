//! Where a team with bodies stands at the ends of its path: in line with it, or turned by as little as the
//! surroundings ask for.

use super::in_tandem::InTandem;
use super::object_room::MAX_TURN_RAD_PER_M;
use super::start::{RING_M, SEARCH_M, places, rounded};
use super::team_path::{ARCS, BODY_ROOM_M, Turned};
use crate::error::{Error, ErrorKind, Place};
use crate::geometry::{Path, PlanarPose, Point, angle_of, direction, wrap_angle, write_turn_onto};
use crate::options::OptionSet;
use crate::world::World;
use std::f64::consts::{PI, TAU};

/// The number of headings that are tried at a start.
const HEADINGS: u32 = 36;
/// The angles (rad) by which a human who turns at the start may face aside of the object.
const FACINGS_RAD: [f64; 7] = [0.0, 0.4, -0.4, 0.8, -0.8, 1.2, -1.2];
/// The length of the beginning and of the end of a path, m, on which the object should not turn too much for
/// the arm.
const GENTLE_M: f64 = 1.6;
const TURN_STEP_M: f64 = 0.1;

/// The distance between the points of a way that are looked at, m.
const LOOK_M: f64 = 0.02;
/// How many other targets are tried at most, times obstacles, back along a path and again beside it, to name
/// one with room: each takes a search of options.
const MAX_TRIED: usize = 1000;

impl<'a> InTandem<'a> {
    /// Whether the object turns slowly enough at the beginning of a path.
    pub(super) fn starts_gently(&self, first: &Path) -> bool {
        self.is_gentle(&self.widened(first), [0.0, GENTLE_M])
    }

    /// Whether the object turns slowly enough for the arm between two positions (m) along a path.
    fn is_gentle(&self, way: &Path, [from, to]: [f64; 2]) -> bool {
        let steps = (to - from.max(0.0)) / TURN_STEP_M;
        let yaw = |i: u32| self.team_path().pose(way, from.max(0.0) + TURN_STEP_M * f64::from(i)).yaw;
        (0..steps as u32).all(|i| wrap_angle(yaw(i + 1) - yaw(i)).abs() <= MAX_TURN_RAD_PER_M * TURN_STEP_M)
    }

    /// Whether robot, object and human have room where they stand, and can turn onto the path `first`, slowly
    /// enough for the arm where `is_gentle` asks for that.
    pub(super) fn check_start(
        &self,
        world: &World,
        base: Point,
        first: &Path,
        is_gentle: bool,
    ) -> Result<(), NoRoom> {
        let PlanarPose { position, yaw } = self.goal();
        let body = position + direction(yaw) * self.team_path().body_ahead();
        check(world, BODY_ROOM_M, [position, base])?;
        check(world, BODY_ROOM_M, [position, body])?;
        let (first, end) = self.ended(first.clone());
        match self.turn_from_start((&first, end)) {
            Some(Turned { path, until }) if !is_gentle || self.is_gentle(&path, [0.0, until + GENTLE_M]) => {
                Ok(())
            }
            // what is nearest to the human is in the way
            _ => Err(nearest(world, BODY_ROOM_M, [position, body])),
        }
    }

    /// The turn from where the team stands onto a path that begins at the object's centre. The human faces as
    /// the object does, or, where there is no room for a turn from there, aside.
    /// `next` ends in an arc of this length, m.
    pub(super) fn turn_from_start(&self, next: (&Path, f64)) -> Option<Turned> {
        let PlanarPose { position, yaw } = self.goal();
        let (team_path, free_space) = (self.team_path(), self.free_space());
        let hand = position + direction(yaw) * team_path.half();
        FACINGS_RAD.into_iter().find_map(|aside| {
            let body = hand + direction(yaw + aside) * (team_path.body_ahead() - team_path.half());
            if aside != 0.0 && !free_space.is_free(hand, body) {
                return None;
            }
            let mut ahead = Path::default();
            if aside != 0.0 {
                ahead.line(position, hand);
                ahead.line(hand, body);
            } else {
                ahead.line(position, position + direction(yaw) * team_path.body_ahead());
            }
            self.turn_at(&ahead, 0.0, next)
        })
    }

    /// A path that ends so that the human has room beyond it: where there is none straight on, the team comes
    /// to the end in an arc, turned by the least multiple of 10 degrees. With the length of the arc and its
    /// tangent, m; 0 for a path that stays as it is.
    pub(super) fn ended(&self, path: Path) -> (Path, f64) {
        let is_free = |from, to| self.free_space().is_free(from, to);
        let has_room = |path: &Path| {
            let [from, to] = self.team_path().beyond_end(&self.widened(path));
            let steps = ((to - from).norm() / LOOK_M).ceil();
            let point = |i: usize| from + (to - from) * (i as f64 / steps);
            (0..=steps as usize).all(|i| self.free_space().obstacles.is_clear(point(i), BODY_ROOM_M))
        };
        if path.length() == 0.0 || has_room(&path) {
            return (path, 0.0);
        }
        let back = path.reversed();
        let (Some(end), Some(heading)) = (back.point_at(0.0), back.heading_at(0.0)) else {
            return (path, 0.0);
        };
        let ended = |is_right: &dyn Fn(&Path) -> bool| {
            turns().find_map(|turn| {
                let heading = wrap_angle(heading + turn);
                ARCS.iter().find_map(|arc| {
                    let mut way = Path::default();
                    write_turn_onto((&back, f64::INFINITY), end, heading, *arc, is_free, &mut way)?;
                    let arc = way.length_of(2);
                    let way = way.reversed();
                    (has_room(&way) && is_right(&way)).then_some((way, arc))
                })
            })
        };
        let is_gentle = |way: &Path| {
            let way = self.widened(way);
            self.is_gentle(&way, [way.length() - GENTLE_M, way.length()])
        };
        let found = ended(&is_gentle).or_else(|| ended(&|_| true));
        found.unwrap_or((path, 0.0))
    }

    /// Refuses a world in which the human has no room beyond the end of an option, and names a target near by
    /// with room: one back on that option's path, or else one beside it. `risk_weight` (m) makes the cheapest
    /// options there.
    ///
    /// # Errors
    /// [`ErrorKind::World`].
    pub fn check_targets(&self, world: &World, risk_weight: f64) -> Result<(), Error> {
        self.targets_have_room(world).map_err(|(option, path, room)| {
            let ahead = angle_of(Point::new(room.x, room.y) - world.target);
            let has_room_at = |place: Point, heading: f64| {
                let beyond = place + direction(heading) * self.team_path().body_ahead();
                check(world, BODY_ROOM_M, [place, beyond]).is_ok()
            };
            let may_have_room = |place: &Point| {
                let mut turns = [0.0].into_iter().chain(turns().take_while(|turn| turn.abs() < PI / 2.0));
                // within sight of the target that was given
                check(world, world.robot_width / 2.0, [world.target, *place]).is_ok()
                    && turns.any(|turn| has_room_at(*place, ahead + turn))
            };
            let has_room = |place: &Point| {
                let mut there = world.clone();
                there.target = *place;
                OptionSet::new(&there, risk_weight)
                    .is_ok_and(|options| self.among(&options).targets_have_room(&there).is_ok())
            };
            let tries = MAX_TRIED / (1 + world.obstacles.len());
            let on_path = places_back(&path).filter(|(place, heading)| has_room_at(*place, *heading));
            let beside = places(world.target).filter(may_have_room);
            let instead =
                on_path.map(|(place, _)| place).take(tries).chain(beside.take(tries)).find(has_room);
            room.at_target(world, &option, instead)
        })
    }

    /// Whether the human has room beyond the end of every option; if not, the name of an option, its path, and
    /// the room.
    fn targets_have_room(&self, world: &World) -> Result<(), (String, Path, NoRoom)> {
        let options = self.free_space().options;
        options.options().iter().enumerate().try_for_each(|(o, option)| {
            let path = options.path_passing(&options.begin(), o, Self::PASSING).unwrap_or_default();
            let beyond = self.team_path().beyond_end(&self.widened(&self.ended(path.clone()).0));
            check(world, BODY_ROOM_M, beyond).map_err(|room| (option.name.clone(), path, room))
        })
    }
}

/// Places on a path, the nearest to its end first, rounded as in messages, with the path's heading there (rad).
fn places_back(path: &Path) -> impl Iterator<Item = (Point, f64)> {
    let steps = (SEARCH_M / RING_M).round() as u32;
    let along =
        (1..=steps).map(move |i| path.length() - RING_M * f64::from(i)).take_while(|along| *along > 0.0);
    along.map_while(move |along| Some((rounded(path.point_at(along)?), path.heading_at(along)?)))
}

/// A straight way of a carrier that comes too close to an obstacle.
pub(super) struct NoRoom {
    /// The end of the way, x, m.
    x: f64,
    /// The end of the way, y, m.
    y: f64,
    /// The obstacle.
    obstacle: String,
    /// Distance between the way and the obstacle, m.
    pub distance: f64,
    /// Distance needed, m.
    needed: f64,
    /// How far from `start_m` or `target_m` an obstacle may be in the way, m.
    length: f64,
    /// The room on either side that is missing to turn onto the path, m; `None` if the team could not turn
    /// even without any room.
    pub to_turn: Option<f64>,
}

impl NoRoom {
    /// Whether the team fits, and cannot turn.
    pub fn is_for_turn(&self) -> bool {
        self.distance >= self.needed
    }

    /// The room that is missing at the start, and where to start instead.
    pub fn at_start(&self, world: &World, nearest: Option<Point>) -> Error {
        let Self { x, y, distance, obstacle, needed, length, to_turn } = self;
        let fault = match (needed - distance, to_turn) {
            (missing, _) if missing > 0.0 => format!(
                "the robot comes from ({x:.3}, {y:.3}) and passes within {distance:.3} m of obstacle `{obstacle}`; leave {needed} m on either side, up to {length:.2} m behind start_m ({missing:.3} m are missing)"
            ),
            (_, Some(missing)) => format!(
                "the team fits, but cannot turn onto its path: obstacle `{obstacle}` is too near ({missing:.2} m are missing on either side)"
            ),
            (_, None) => {
                format!("the team fits, but cannot turn onto its path: obstacle `{obstacle}` is too near")
            }
        };
        let instead = instead("the nearest start", nearest);
        refused(world, format_args!("no room at the start: {fault}{instead}"))
    }

    /// The room that is missing at the end of an option, and which target to take instead.
    fn at_target(&self, world: &World, option: &str, place: Option<Point>) -> Error {
        let Self { x, y, distance, obstacle, needed, length, to_turn: _ } = self;
        let (missing, instead) = (needed - distance, instead("a target", place));
        refused(
            world,
            format_args!(
                "no room at the target: at the end of option `{option}`, the human walks on to ({x:.3}, {y:.3}) and comes within {distance:.3} m of obstacle `{obstacle}`; leave {needed} m on either side, up to {length:.2} m beyond target_m ({missing:.3} m are missing){instead}"
            ),
        )
    }
}

/// The end of a refusal: where there is room.
fn instead(end: &str, place: Option<Point>) -> String {
    place.map_or(String::new(), |p| format!("; {end} with room is ({:.2}, {:.2})", p.x, p.y))
}

fn refused(world: &World, sentence: std::fmt::Arguments) -> Error {
    Error::at(Place::file(&world.file), sentence).of_kind(ErrorKind::World)
}

/// Turns away from straight ahead, the smallest first, to the left and to the right.
pub(super) fn turns() -> impl Iterator<Item = f64> {
    let step = TAU / f64::from(HEADINGS);
    (1..=HEADINGS / 2)
        .flat_map(move |i| [step * f64::from(i), -step * f64::from(i)])
        .take(HEADINGS as usize - 1)
}

/// Whether a straight way keeps this distance (m) from every obstacle.
pub(super) fn check(world: &World, needed: f64, ends: [Point; 2]) -> Result<(), NoRoom> {
    let room = nearest(world, needed, ends);
    if room.distance < needed { Err(room) } else { Ok(()) }
}

/// The obstacle that is nearest to a straight way.
fn nearest(world: &World, needed: f64, ends: [Point; 2]) -> NoRoom {
    let distances = world.obstacles.iter().map(|o| (o.distance_to_segment(ends[0], ends[1]), o));
    let nearest = distances.min_by(|a, b| a.0.total_cmp(&b.0));
    NoRoom {
        x: ends[1].x,
        y: ends[1].y,
        obstacle: nearest.map_or(String::new(), |(_, obstacle)| obstacle.name.clone()),
        distance: nearest.map_or(f64::INFINITY, |(distance, _)| distance),
        needed,
        length: (ends[1] - ends[0]).norm() + needed,
        to_turn: None,
    }
}
