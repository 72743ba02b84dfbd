//! A team in tandem: both ends of the object follow the path, the human ahead, the robot's end behind.

use super::pace::share;
use super::team_path::{FreeSpace, MAX_PATH_BEND_RAD, TeamPath, Turned};
use super::{ARRIVAL_TOLERANCE_M, Pace, PathAhead, Place, Step, Travel, Walk, Widened};
use crate::control::{Follower, HORIZON, Intent, Reference, reference};
use crate::coordination::Mode;
use crate::geometry::{Path, PlanarPose, Point, Pose, Widening, angle_of, direction, nearest, wrap_angle};
use crate::human::Stance;
use crate::math;
use crate::options::{OptionSet, Passing};
use crate::plant::{HumanMotion, Seen, on_floor};
use crate::saved::{RestoreError, Saved};
use crate::simulation::Observation;
use serde::{Deserialize, Serialize};

/// A team slows down where the object has to turn by more than the first angle (rad) beyond what a step
/// allows, and goes at a tenth of its speed at the second.
const TURNING_LAG_RAD: [f64; 2] = [0.1, 0.4];
/// Number of points of the grasp's way, enough to reach back to the base.
const TRAIL_POINTS: u32 = 50;
/// The object turns more slowly where the robot's end is this far (m) from its target, and at a fifth of the
/// rate at the second distance.
const OUT_OF_PLACE_M: [f64; 2] = [0.015, 0.08];
/// The leader slows when the object lags by the first and stops at the second, m.
const LAG_M: [f64; 2] = [0.01, 0.08];
/// A robot that leads slows when the human's grip yields by the first and stops at the second, m: the human
/// resists.
const RESISTANCE_M: [f64; 2] = [0.03, 0.06];

/// The object's centre must be this near (m) to its place at the end of the path for the team to have
/// arrived: a hand that is steered need not be on the path.
const ARRIVAL_DISTANCE_M: f64 = 0.1;

/// The largest bend (rad) between a turn and a path that ends in an arc.
const MAX_BEND_RAD: f64 = 0.5;

/// Human, object and robot, one behind the other.
#[derive(Clone, Debug)]
pub struct InTandem<'a> {
    free_space: FreeSpace<'a>,
    pace: Pace,
    /// Whether the team stands in line with its first path. Otherwise it begins with a turn.
    faces_path: bool,
    state: TandemState,
}

/// The state that later steps depend on.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct TandemState {
    team_path: TeamPath,
    /// The leader's intended position along the path, m: ahead of the object by the deflection of the grips.
    path_position: f64,
    /// Speed of the intended position, m/s.
    path_speed: f64,
    /// Intended pose of the object.
    goal: PlanarPose,
    /// A leader who does not wait: the position along the path (m) and the speed (m/s).
    #[serde(default)]
    unhindered: [f64; 2],
}

impl<'a> InTandem<'a> {
    /// Round a pillar the object is on the inside of the bend.
    pub(crate) const PASSING: Passing = Passing::Middle;

    pub(super) fn new(
        free_space: FreeSpace<'a>,
        pace: Pace,
        (team_path, goal): (TeamPath, PlanarPose),
        faces_path: bool,
    ) -> Self {
        let state =
            TandemState { team_path, path_position: 0.0, path_speed: 0.0, goal, unhindered: [0.0; 2] };
        Self { free_space, pace, faces_path, state }
    }

    pub(super) fn free_space(&self) -> FreeSpace<'a> {
        self.free_space
    }

    /// The same team among other options.
    pub(super) fn among<'o>(&self, options: &'o OptionSet) -> InTandem<'o>
    where
        'a: 'o,
    {
        let Self { free_space, pace, faces_path, ref state } = *self;
        let free_space = FreeSpace { options, ..free_space };
        InTandem { free_space, pace, faces_path, state: state.clone() }
    }

    /// A path as the team walks it, wide round corners.
    pub(super) fn widened(&self, path: &Path) -> Path {
        let (free_space, mut widened) = (self.free_space(), Path::default());
        let is_free = |from, to| free_space.is_free(from, to);
        self.state.team_path.write_widened(path, is_free, &mut Widening::default(), &mut widened);
        widened
    }

    /// The turn at the position `along` (m) of `path` onto `next`, a path that [ends](Self::ended) so that
    /// the human has room beyond it, in an arc of the length `end` (m).
    ///
    /// A turn may join its path beyond the arc with which that ends. It then ends in another arc, or, where
    /// that would bend too sharply, joins before the arc.
    pub(super) fn turn_at(&self, path: &Path, along: f64, (next, end): (&Path, f64)) -> Option<Turned> {
        let turn = |end: f64| {
            let turned = self.team_path().planned_turn(path, along, (next, end), self.free_space())?;
            self.with_end(turned)
        };
        turn(0.0).or_else(|| if end > 0.0 { turn(end) } else { None })
    }

    /// A turn with room for the human beyond the end of its path. `None` if that would bend too sharply.
    fn with_end(&self, turned: Turned) -> Option<Turned> {
        let Turned { path, until } = turned;
        let mut rest = Path::default();
        rest.push_rest(&path, until);
        let (ended, end) = self.ended(rest);
        if end == 0.0 {
            return Some(Turned { path, until });
        }
        let mut turn = Path::default();
        turn.push_rest(&path.reversed(), path.length() - until);
        let mut way = turn.reversed();
        way.push_rest(&ended, 0.0);
        let is_smooth = way.sharpest_bend() <= path.sharpest_bend().max(MAX_BEND_RAD);
        is_smooth.then_some(Turned { path: way, until })
    }

    /// A turn with room for the object after it.
    fn with_room(&self, turned: Turned) -> Turned {
        Turned { path: self.with_object_room(turned.path), until: turned.until }
    }

    /// A path as the team walks it, with room for the object.
    fn with_object_room(&self, path: Path) -> Path {
        self.state.team_path.with_object_room(path, self.free_space())
    }

    pub(super) fn team_path(&self) -> &TeamPath {
        &self.state.team_path
    }

    /// The pose that the object should have.
    pub(super) fn goal(&self) -> PlanarPose {
        self.state.goal
    }

    /// The object's target position along the present path (m) and its speed (m/s), as the robot knows them:
    /// from its own intention while it leads, else from the hand, which it sees move at `speed` (m/s).
    fn path_position(&self, seen: &Seen, ahead: &PathAhead, speed: f64) -> (f64, f64) {
        match ahead.mode {
            Mode::RobotLed => {
                let TandemState { path_position, path_speed, .. } = self.state;
                let yielding = yielding(seen, ahead.mode);
                (path_position - (1.0 - yielding) * (path_position - ahead.along), path_speed * yielding)
            }
            Mode::HumanLed => (ahead.along + ahead.lead, speed),
        }
    }

    fn pose(&self, ahead: &PathAhead, walked: f64) -> PlanarPose {
        let path = &self.state.team_path;
        match ahead.turn {
            None => path.pose(ahead.path, ahead.along + walked),
            Some(new_path) => path.pose_after_turning(ahead.path, ahead.along, new_path, walked),
        }
    }

    /// The pose that the object would have if its end were at the hand.
    fn held_by_hand(&self, seen: &Seen) -> PlanarPose {
        let hand = PlanarPose { position: seen.hand(), yaw: object(seen).yaw };
        PlanarPose { position: self.state.team_path.end(&hand, -1.0).position, yaw: hand.yaw }
    }

    /// Advances the leader's position on the path by one period, and with it the object's target.
    fn set_goal(&mut self, step: &Step, seen: &Seen) {
        let grasp = seen.bodies.map(|bodies| on_floor(&bodies.grasp));
        let out_of_place = grasp.map_or(0.0, |grasp| (self.grasp_goal(seen).position - grasp).norm());
        let yielding = yielding(seen, step.mode);
        let pace = self.pace;
        let TandemState { team_path, path_position, path_speed, goal, unhindered } = &mut self.state;
        let turn = wrap_angle(team_path.pose(step.path, *path_position).yaw - goal.yaw).abs();
        let turning = share(TURNING_LAG_RAD, turn, 0.1);
        let ahead = match step.travel {
            Travel::Forward => *path_position - step.from,
            Travel::Backward => step.from - *path_position,
        };
        let waiting = share(LAG_M, ahead, 0.0);
        let on_bend = step.travel.share_on_bend(&pace, |s| team_path.pose(step.path, *path_position + s));
        *path_speed = step.travel.speed_after(*path_speed, turning * waiting * yielding * on_bend, &pace);
        // who feels resistance gives up the lead over the object
        let kept = math::pow(yielding, pace.period / pace.step);
        let given_up = (1.0 - kept) * (*path_position - step.from);
        *path_position += *path_speed * pace.period - given_up;
        // who does not wait goes on at the pace of the path
        let [position, speed] = unhindered;
        if step.mode == Mode::RobotLed || step.travel == Travel::Backward {
            (*position, *speed) = (*path_position, *path_speed);
        } else {
            let on_bend = step.travel.share_on_bend(&pace, |s| team_path.pose(step.path, *position + s));
            *speed = step.travel.speed_after(*speed, on_bend, &pace);
            *position = (*position + *speed * pace.period).min(step.path.length().max(*path_position));
        }
        let following = share(OUT_OF_PLACE_M, out_of_place, 0.2);
        let gently = Pace { yaw_rate: pace.yaw_rate * following, ..pace };
        *goal = gently.toward(goal, &team_path.pose(step.path, *path_position));
    }
}

impl Walk for InTandem<'_> {
    fn passing(&self) -> Passing {
        Self::PASSING
    }

    fn walkable(&self, path: Path) -> Path {
        self.with_object_room(self.widened(&self.ended(path).0))
    }

    fn begin(&mut self, path: Path) -> Turned {
        let (path, end) = self.ended(path);
        let turned = if self.faces_path { None } else { self.turn_from_start((&path, end)) };
        match turned {
            Some(turned) => self.with_room(turned),
            None => Turned { path: self.with_object_room(self.widened(&path)), until: 0.0 },
        }
    }

    fn turn(&mut self, path: &Path, along: f64, next: Path) -> Option<Turned> {
        let (next, end) = self.ended(next);
        let turned = self.turn_at(path, along, (&next, end))?;
        let TandemState { team_path, path_position, unhindered, .. } = &mut self.state;
        team_path.leave(path, along);
        *path_position -= along;
        unhindered[0] -= along;
        Some(self.with_room(turned))
    }

    fn place_to_turn(&self, path: &Path, range: [f64; 2], next: &dyn Fn(Point) -> Path) -> Option<f64> {
        let team_path = self.team_path();
        let can_turn = |along: f64| {
            let next = next(team_path.point(path, along));
            if next.sharpest_bend() > MAX_PATH_BEND_RAD {
                return false;
            }
            let (next, end) = self.ended(next);
            self.turn_at(path, along, (&next, end)).is_some()
        };
        team_path.place_to_turn(path, range, &can_turn, self.free_space())
    }

    fn grasp_goal(&self, _: &Seen<'_>) -> PlanarPose {
        self.state.team_path.end(&self.state.goal, -1.0)
    }

    fn intended_grasp(&self, step: &Step<'_>, _: &Seen<'_>) -> PlanarPose {
        let TandemState { team_path, unhindered: [position, _], .. } = &self.state;
        team_path.end(&team_path.pose(step.path, *position), -1.0)
    }

    fn advance(&mut self, step: &Step<'_>, seen: &Seen<'_>) -> HumanMotion {
        let before = self.state.team_path.end(&self.state.goal, 1.0).position;
        self.set_goal(step, seen);
        let TandemState { team_path, path_position, goal, .. } = &self.state;
        let led = team_path.end(goal, 1.0);
        // where the hand will be
        let hand = seen.hand() + (led.position - before);
        let facing = angle_of(team_path.body_on(step.path, *path_position, hand) - hand);
        // a hand that is steered need not be on the path: it turns with the object, and the body walks ahead
        // of it
        let yaw = object(seen).yaw;
        let facing = if step.hand.is_some() { yaw } else { facing };
        let hand = match (step.hand, step.stance, step.mode) {
            (Some(position), _, _) => Some(PlanarPose { position, yaw }),
            (None, _, Mode::HumanLed) => Some(led),
            (None, Stance::Resist, Mode::RobotLed) => seen.bodies.map(|bodies| bodies.hand_planar),
            (None, Stance::Follow | Stance::TakeOver, Mode::RobotLed) => None,
        };
        HumanMotion { hand, facing: Some(facing) }
    }

    fn locate(&self, step: &Step<'_>, seen: &Seen<'_>) -> Place {
        let TandemState { team_path, path_position, path_speed, .. } = &self.state;
        let along = team_path.locate(step.path, seen.position, step.from, *path_position, *path_speed < 0.0);
        let length = step.path.length();
        let is_near =
            || (team_path.pose(step.path, length).position - seen.position).norm() <= ARRIVAL_DISTANCE_M;
        let last = length - ARRIVAL_TOLERANCE_M;
        Place {
            along: match along >= last {
                true if is_near() => length,
                true => last.max(step.from),
                false => along,
            },
            path_lead: *path_position - along,
        }
    }

    fn lead(&self, seen: &Seen<'_>, path: &Path, along: f64) -> f64 {
        const STEP: f64 = 0.02;
        let (team_path, hand) = (&self.state.team_path, seen.hand());
        let distance = |walked: f64| {
            let front = team_path.end(&team_path.pose(path, along + walked), 1.0);
            (front.position - hand).norm_squared()
        };
        let leads = (0..=25).map(|i| STEP * f64::from(i) - 0.1);
        nearest(leads, distance).unwrap_or(0.0)
    }

    /// Observed speed of the hand, m/s; negative when reversing. Before the first observation, the speed at
    /// which the robot led the team.
    fn observed_speed(&self, seen: &Seen<'_>, intent: &Intent, travel: Travel) -> f64 {
        let Some(speed) = intent.speed() else { return self.state.path_speed };
        let ahead = direction(object(seen).yaw);
        match travel {
            Travel::Forward => speed.copysign(intent.moved().dot(&ahead)),
            // before reversing, the team brakes
            Travel::Backward => {
                let moves = intent.moves_soon();
                (moves.norm() / self.pace.step).copysign(moves.dot(&ahead))
            }
        }
    }

    fn expect(&self, path: &Path, along: f64, next: &mut Path, memory: &mut Widened) {
        let Widened { path: widened, widening } = memory;
        // without regard to obstacles
        self.state.team_path.write_widened(next, |_, _| true, widening, widened);
        self.state.team_path.write_expected(path, along, widened, self.free_space(), next);
    }

    fn reference(
        &self,
        seen: &Seen<'_>,
        ahead: &PathAhead<'_>,
        speed: f64,
        grasp: &Pose,
        height: f64,
    ) -> Reference {
        let pace = &self.pace;
        let (position, mut path_speed) = self.path_position(seen, ahead, speed);
        let mut walked = position - ahead.along;
        let yielding = yielding(seen, ahead.mode);
        let mut at = if ahead.mode == Mode::RobotLed { self.state.goal } else { self.held_by_hand(seen) };
        let grasps = (1..=HORIZON).map(|_| {
            let on_bend = ahead.travel.share_on_bend(pace, |s| self.pose(ahead, walked + s));
            path_speed = ahead.travel.speed_after(path_speed, yielding * on_bend, pace);
            walked += path_speed * pace.period;
            at = pace.toward(&at, &self.pose(ahead, walked));
            self.state.team_path.end(&at, -1.0)
        });
        reference(grasps, grasp, height)
    }

    fn grasp_way(
        &self,
        seen: &Seen<'_>,
        ahead: &PathAhead<'_>,
        speed: f64,
        way: &mut Vec<Point>,
    ) -> Option<[f64; 2]> {
        let (pace, team_path) = (&self.pace, &self.state.team_path);
        let (position, speed) = self.path_position(seen, ahead, speed);
        let from_here = |s| self.pose(ahead, position - ahead.along + s);
        let share = yielding(seen, ahead.mode) * ahead.travel.share_on_bend(pace, from_here);
        // from the grasp's position for the object's target, back to beyond the base
        way.clear();
        let behind = (0..TRAIL_POINTS).rev().map(|i| team_path.half() + Follower::STEP * f64::from(i));
        way.extend(behind.map(|behind| team_path.point(ahead.path, position - behind)));
        Some([speed.min(pace.speed), ahead.travel.speed(pace) * share])
    }

    fn save(&self) -> Saved {
        Saved::of(&self.state)
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), RestoreError> {
        self.state = saved.read("walk")?;
        Ok(())
    }
}

/// The object's pose, seen from above.
fn object(seen: &Seen) -> PlanarPose {
    let at = PlanarPose { position: seen.position, yaw: 0.0 };
    seen.bodies.map_or(at, |bodies| PlanarPose::from_above(&bodies.object))
}

/// The share of its speed with which a robot that leads goes on where the human's grip yields: 1 unless the
/// human resists.
fn yielding(seen: &Seen, mode: Mode) -> f64 {
    let deflection = |bodies: &Observation| bodies.hand_grip.deflection;
    match mode {
        Mode::RobotLed => share(RESISTANCE_M, seen.bodies.map_or(0.0, deflection), 0.0),
        Mode::HumanLed => 1.0,
    }
}
