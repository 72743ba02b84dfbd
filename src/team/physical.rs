//! The physical plant: robot, object and human as bodies. Both ends of the object follow the path, the
//! robot's end behind.

use super::bodies::{Bodies, Manipulator, Moved, PathAhead};
use super::team_path::{BODY_ROOM_M, FreeSpace, TeamPath, Turned};
use super::tick::{PhysicsTick, on_floor};
use super::{Situation, Step, Travel, Walk};
use crate::control::{BaseInputs, Candidate, Follower, HORIZON, Intent, Reference, reference};
use crate::coordination::Mode;
use crate::error::{Error, ErrorKind, Place};
use crate::geometry::{
    Path, PlanarPose, Point, Pose, Widening, angle_of, direction, left_of, nearest, wrap_angle,
};
use crate::human::Stance;
use crate::options::turned;
use crate::robot::{Configuration, InputVector, pose_difference};
use crate::saved::{NotRestored, Saved};
use crate::simulation::{HumanCommand, Observation, PhysicalPlant, PhysicsSettings};
use crate::world::World;
use serde::{Deserialize, Serialize};

/// The team has arrived when the object's centre is this near (m) to the end of its path.
const ARRIVAL_TOLERANCE_M: f64 = 0.05;
/// Acceleration of the team, m/s^2.
const TEAM_ACCELERATION: f64 = 0.9;
/// The share of the rims' largest acceleration that the base plans with.
const RIM_SHARE: f64 = 0.8;
/// A team slows down where the object has to turn by more than the first angle (rad) beyond what a step
/// allows, and goes at a tenth of its speed at the second.
const TURNING_LAG_RAD: [f64; 2] = [0.1, 0.4];
/// Speed at which position errors are corrected, as a multiple of the walking speed.
const CATCH_UP_FACTOR: f64 = 1.5;
/// The least distance of the grasp beside a differential base's axis that counts, m.
const LEAST_BESIDE_M: f64 = 1e-3;
/// Number of points kept of the path walked, enough to reach back to the base.
const TRAIL_POINTS: u32 = 50;
/// Speed of a reversing team, m/s.
const REVERSING_SPEED: f64 = 0.35;
/// The object turns more slowly where the robot's end is this far (m) from its target, and at a fifth of the
/// rate at the second distance.
const OUT_OF_PLACE_M: [f64; 2] = [0.015, 0.08];
/// The leader slows when the object lags by the first and stops at the second, m.
const LAG_M: [f64; 2] = [0.01, 0.08];
/// A robot that leads slows when the human's grip yields by the first and stops at the second, m: the human
/// resists.
const RESISTANCE_M: [f64; 2] = [0.03, 0.06];
/// A team slows before a bend on which the object would turn faster than this (rad/s), by the square of the
/// ratio, but not below a share of its speed. Behind the object the base has to go round the same bend, and
/// the arm has to make up for both.
const BEND_RATE: f64 = 0.85;
const BEND_LEAST_SHARE: f64 = 0.2;
/// Distance (m) between the places where the object's turning is looked at, and their number.
const BEND_STEP_M: f64 = 0.1;
const BEND_STEPS: u32 = 4;

impl Travel {
    /// Target speed of the team, m/s; negative when reversing.
    fn speed(self, walk: &Walk) -> f64 {
        match self {
            Self::Forward => walk.speed,
            Self::Backward => -REVERSING_SPEED,
        }
    }

    /// The share of its speed that a team keeps before a bend, from the object's pose at distances (m) ahead.
    /// A reversing team is slow enough.
    fn share_on_bend(self, walk: &Walk, pose: impl Fn(f64) -> PlanarPose) -> f64 {
        if self == Self::Backward {
            return 1.0;
        }
        let mut yaw = pose(0.0).yaw;
        let turns = (1..=BEND_STEPS).map(|i| {
            let before = std::mem::replace(&mut yaw, pose(BEND_STEP_M * f64::from(i)).yaw);
            wrap_angle(yaw - before).abs()
        });
        let rate = turns.fold(0.0, f64::max) / BEND_STEP_M * walk.speed;
        let ratio = BEND_RATE / rate;
        (ratio * ratio).clamp(BEND_LEAST_SHARE, 1.0)
    }

    /// Speed after one period of a team that has the speed `speed`, at most this `share` of the target speed,
    /// m/s; negative when reversing.
    fn speed_after(self, speed: f64, share: f64, walk: &Walk) -> f64 {
        let change = TEAM_ACCELERATION * walk.period;
        match self {
            Self::Forward => (speed + change).min(walk.speed * share),
            Self::Backward => (speed - change).max(-REVERSING_SPEED * share),
        }
    }
}

/// Robot, object and human.
#[derive(Clone)]
pub(super) struct Physical {
    state: State,
    /// Height of the grasp, m.
    height: f64,
    /// Initial distance of the base behind the grasp, m, which the base keeps.
    distance: f64,
    /// Initial angle of the grasp beside straight ahead of the base, rad; 0 on a differential base.
    bearing: f64,
    /// How far a differential base is to the right of the grasp's path, m: as at the start.
    beside: f64,
    /// Acceleration of the rims that the base plans with, m/s^2.
    rim_acceleration: f64,
    /// Buffers: an option's path as the team walks it, and the past path of the grasp.
    widened: Path,
    widening: Widening,
    walked: Vec<Point>,
}

/// The state that later steps depend on.
#[derive(Clone, Serialize, Deserialize)]
struct State {
    plant: PhysicalPlant,
    team_path: TeamPath,
    /// The leader's intended position along the path, m: ahead of the object by the deflection of the grips.
    path_position: f64,
    /// Speed of the intended position, m/s.
    path_speed: f64,
    /// Intended pose of the object.
    goal: PlanarPose,
    seen: Observation,
}

impl Physical {
    /// A team at rest at the beginning of the path `first`, straight, as it was when it came.
    pub fn new(
        manipulator: &Manipulator,
        world: &World,
        physics: &PhysicsSettings,
        seed: u64,
        first: &Path,
        free_space: FreeSpace,
    ) -> Result<Self, Error> {
        let Manipulator { robot, posture, .. } = *manipulator;
        let (team_path, start) = TeamPath::starting(world, first, |from, to| free_space.is_free(from, to));
        let start = &start;
        let plant = PhysicalPlant::new(world, robot, &posture, start, physics, seed)?;
        let at_origin = PlanarPose { position: Point::origin(), yaw: 0.0 };
        let configuration = Configuration { base: at_origin, joints: posture };
        let held = robot.grasp_pose(&configuration).translation.vector.xy();
        let is_free = robot.drive.is_omnidirectional();
        Ok(Self {
            height: robot.grasp_height,
            distance: if is_free { held.norm() } else { held.x },
            bearing: if is_free { angle_of(held) } else { 0.0 },
            beside: if is_free || held.y.abs() < LEAST_BESIDE_M { 0.0 } else { held.y },
            rim_acceleration: RIM_SHARE * physics.rim_acceleration,
            widened: Path::with_capacity(64),
            widening: Widening::default(),
            walked: Vec::with_capacity(64),
            state: State {
                seen: plant.observe(),
                plant,
                team_path,
                path_position: 0.0,
                path_speed: 0.0,
                goal: *start,
            },
        })
    }

    /// Refuses a world in which the robot has no room on its way to the start, or the human beyond the end of
    /// an option. The room needed is the distance of the carrier from the object's centre.
    pub fn check_room(&self, world: &World, free_space: FreeSpace) -> Result<(), Error> {
        let check = |[from, to]: [Point; 2], walk: &str, comes: &str, behind: &str| {
            let distances = world.obstacles.iter().map(|o| (o.footprint.distance_to_segment(from, to), o));
            match distances.min_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((distance, obstacle)) if distance < BODY_ROOM_M => {
                    let sentence = format!(
                        "no room at {walk} ({:.3}, {:.3}) and {comes} within {distance:.3} m of obstacle `{}`; leave {BODY_ROOM_M} m on either side, up to {:.2} m {behind}",
                        to.x,
                        to.y,
                        obstacle.name,
                        (to - from).norm() + BODY_ROOM_M
                    );
                    Err(Error::at(Place::file(&world.file), sentence).of_kind(ErrorKind::World))
                }
                _ => Ok(()),
            }
        };
        let behind = [world.start, self.state.seen.configuration.base.position];
        check(behind, "the start: the robot comes from", "passes", "behind start_m")?;
        let options = free_space.options;
        for (o, option) in options.options().iter().enumerate() {
            let path = options.path(&options.begin(), o).unwrap_or_default();
            let beyond = self.state.team_path.beyond_end(&self.walkable(path, free_space));
            let walk = format!("the target: at the end of option `{}`, the human walks on to", option.name);
            check(beyond, &walk, "comes", "beyond target_m")?;
        }
        Ok(())
    }

    /// The object's target position along the present path (m) and its speed (m/s), as the robot knows them:
    /// from its own intention while it leads, else from the hand, which it sees move at `speed` (m/s).
    fn path_position(&self, path_ahead: &PathAhead, speed: f64) -> (f64, f64) {
        match path_ahead.mode {
            Mode::RobotLed => {
                let State { path_position, path_speed, .. } = self.state;
                let yielding = self.yielding(path_ahead.mode);
                (path_position - (1.0 - yielding) * (path_position - path_ahead.along), path_speed * yielding)
            }
            Mode::HumanLed => (path_ahead.along + path_ahead.lead, speed),
        }
    }

    /// The share of its speed with which a robot that leads goes on where the human's grip yields: 1 unless the
    /// human resists.
    fn yielding(&self, mode: Mode) -> f64 {
        match mode {
            Mode::RobotLed => share(RESISTANCE_M, self.state.seen.hand_grip.deflection, 0.0),
            Mode::HumanLed => 1.0,
        }
    }

    fn pose(&self, path_ahead: &PathAhead, walked: f64) -> PlanarPose {
        let path = &self.state.team_path;
        match path_ahead.turn {
            None => path.pose(path_ahead.path, path_ahead.along + walked),
            Some(new_path) => path.pose_after_turning(path_ahead.path, path_ahead.along, new_path, walked),
        }
    }

    /// The pose that the object would have if its end were at the hand.
    fn held_by_hand(&self) -> PlanarPose {
        let yaw = PlanarPose::from_above(&self.state.seen.object).yaw;
        let hand = PlanarPose { position: self.hand(), yaw };
        PlanarPose { position: self.state.team_path.end(&hand, -1.0).position, yaw }
    }

    /// Advances the leader's position on the path by one period, and with it the object's target.
    fn set_goal(&mut self, step: &Step, walk: &Walk) {
        let out_of_place = (self.grasp_goal().position - on_floor(&self.state.seen.grasp)).norm();
        let yielding = self.yielding(step.mode);
        let State { team_path, path_position, path_speed, goal, .. } = &mut self.state;
        let turn = wrap_angle(team_path.pose(step.path, *path_position).yaw - goal.yaw).abs();
        let turning = share(TURNING_LAG_RAD, turn, 0.1);
        let ahead = match step.travel {
            Travel::Forward => *path_position - step.from,
            Travel::Backward => step.from - *path_position,
        };
        let waiting = share(LAG_M, ahead, 0.0);
        let on_bend = step.travel.share_on_bend(walk, |s| team_path.pose(step.path, *path_position + s));
        *path_speed = step.travel.speed_after(*path_speed, turning * waiting * yielding * on_bend, walk);
        // who feels resistance gives up the lead over the object
        let given_up = (1.0 - yielding) * (*path_position - step.from);
        *path_position += *path_speed * walk.period - given_up;
        let following = share(OUT_OF_PLACE_M, out_of_place, 0.2);
        let gently = Walk { yaw_rate: walk.yaw_rate * following, ..*walk };
        *goal = moved_toward(goal, &team_path.pose(step.path, *path_position), &gently);
    }

    /// The command of the human's hand: to follow the object, or to walk.
    fn command(&self, step: &Step) -> HumanCommand {
        let led = self.state.team_path.end(&self.state.goal, 1.0);
        match (step.human.hand, step.human.stance, step.mode) {
            (Some(position), _, _) => HumanCommand::Walk { hand: PlanarPose { position, ..led } },
            (None, _, Mode::HumanLed) => HumanCommand::Walk { hand: led },
            (None, Stance::Resist, Mode::RobotLed) => {
                HumanCommand::Walk { hand: self.state.seen.hand_planar }
            }
            (None, Stance::Follow | Stance::TakeOver, Mode::RobotLed) => HumanCommand::Follow,
        }
    }
}

impl Bodies for Physical {
    fn configuration(&self) -> &Configuration {
        &self.state.seen.configuration
    }

    fn grasp_goal(&self) -> PlanarPose {
        self.state.team_path.end(&self.state.goal, -1.0)
    }

    fn body(&self) -> Point {
        on_floor(&self.state.seen.torso)
    }

    fn hand(&self) -> Point {
        on_floor(&self.state.seen.hand)
    }

    fn lead(&self, path: &Path, along: f64) -> f64 {
        const STEP: f64 = 0.02;
        let (team_path, hand) = (&self.state.team_path, self.hand());
        let distance = |walked: f64| {
            let front = team_path.end(&team_path.pose(path, along + walked), 1.0);
            (front.position - hand).norm_squared()
        };
        let leads = (0..=25).map(|i| STEP * f64::from(i) - 0.1);
        nearest(leads, distance).unwrap_or(0.0)
    }

    /// Observed speed of the hand, m/s; negative when reversing. Before the first observation, the speed at
    /// which the robot led the team.
    fn observed_speed(&self, intent: &Intent, travel: Travel, walk: &Walk) -> f64 {
        let Some(speed) = intent.speed() else { return self.state.path_speed };
        let ahead = direction(PlanarPose::from_above(&self.state.seen.object).yaw);
        match travel {
            Travel::Forward => speed.copysign(intent.moved().dot(&ahead)),
            // before reversing, the team brakes
            Travel::Backward => {
                let moves = intent.moves_soon();
                (moves.norm() / walk.period).copysign(moves.dot(&ahead))
            }
        }
    }

    fn expect_path(&mut self, situation: &Situation, path: &mut Path, free_space: FreeSpace) {
        let team_path = &self.state.team_path;
        // without regard to obstacles
        team_path.write_widened(path, |_, _| true, &mut self.widening, &mut self.widened);
        team_path.write_expected(situation.path, situation.along, &self.widened, free_space, path);
    }

    fn reference(&self, path_ahead: &PathAhead, speed: f64, walk: &Walk, grasp: &Pose) -> Reference {
        let (position, mut path_speed) = self.path_position(path_ahead, speed);
        let mut ahead = position - path_ahead.along;
        let yielding = self.yielding(path_ahead.mode);
        let mut at = if path_ahead.mode == Mode::RobotLed { self.state.goal } else { self.held_by_hand() };
        let grasps = (1..=HORIZON).map(|_| {
            let on_bend = path_ahead.travel.share_on_bend(walk, |s| self.pose(path_ahead, ahead + s));
            path_speed = path_ahead.travel.speed_after(path_speed, yielding * on_bend, walk);
            ahead += path_speed * walk.period;
            at = moved_toward(&at, &self.pose(path_ahead, ahead), walk);
            self.state.team_path.end(&at, -1.0)
        });
        reference(grasps, grasp, self.height)
    }

    fn base_on_path(
        &mut self,
        path_ahead: &PathAhead,
        speed: f64,
        manipulator: &Manipulator,
        walk: &Walk,
    ) -> Option<BaseInputs> {
        let Manipulator { robot, obstacles, .. } = *manipulator;
        let yielding = self.yielding(path_ahead.mode);
        let (position, speed) = self.path_position(path_ahead, speed);
        let from_here = |s| self.pose(path_ahead, position - path_ahead.along + s);
        let share = yielding * path_ahead.travel.share_on_bend(walk, from_here);
        let State { team_path, seen, .. } = &self.state;
        // from the grasp's position for the object's target, back to beyond the base
        self.walked.clear();
        let behind = (0..TRAIL_POINTS).rev().map(|i| team_path.half() + Follower::STEP * f64::from(i));
        self.walked.extend(behind.map(|behind| team_path.point(path_ahead.path, position - behind)));
        shift_right(&mut self.walked, self.beside);
        let follower = Follower {
            way: &self.walked,
            speeds: [speed.min(walk.speed), path_ahead.travel.speed(walk) * share],
            acceleration: TEAM_ACCELERATION,
            rim_acceleration: self.rim_acceleration,
            distance: self.distance,
            bearing: self.bearing,
            footprint: &robot.footprint,
            obstacles,
        };
        Some(follower.inputs(&robot.drive, &seen.configuration.base, seen.base_rates, walk.period))
    }

    fn walkable(&self, path: Path, free_space: FreeSpace) -> Path {
        let mut widened = Path::default();
        let is_free = |from, to| free_space.is_free(from, to);
        self.state.team_path.write_widened(&path, is_free, &mut Widening::default(), &mut widened);
        widened
    }

    fn turn(&mut self, path: &Path, along: f64, next: Path, free_space: FreeSpace) -> Option<Turned> {
        let State { team_path, path_position, .. } = &mut self.state;
        let turned = team_path.planned_turn(path, along, &next, free_space)?;
        team_path.leave(path, along);
        *path_position -= along;
        Some(turned)
    }

    fn place_to_turn(
        &self,
        path: &Path,
        range: [f64; 2],
        next: &dyn Fn(Point) -> Path,
        free_space: FreeSpace,
    ) -> Option<f64> {
        self.state.team_path.place_to_turn(path, range, next, free_space)
    }

    fn step(&mut self, target: &Candidate, input: &InputVector, step: &Step, walk: &Walk) -> Moved {
        let before = self.state.team_path.end(&self.state.goal, 1.0).position;
        self.set_goal(step, walk);
        let State { team_path, path_position, goal, .. } = &self.state;
        // where the hand will be
        let hand = self.hand() + (team_path.end(goal, 1.0).position - before);
        let facing = angle_of(team_path.body_on(step.path, *path_position, hand) - hand);
        let command = self.command(step);
        let State { plant, team_path, path_position, path_speed, goal, seen } = &mut self.state;
        plant.face(Some(facing));
        *seen = plant.step(&(target.rates + input), &command, walk.period);
        let object = PlanarPose::from_above(&seen.object);
        let along =
            team_path.locate(step.path, object.position, step.from, *path_position, *path_speed < 0.0);
        let grasp = team_path.end(goal, -1.0).at_height(self.height);
        let length = step.path.length();
        Moved {
            along: if along >= length - ARRIVAL_TOLERANCE_M { length } else { along },
            error: pose_difference(&grasp, &seen.grasp),
            physics: Some(PhysicsTick::of(seen, *path_position - along)),
        }
    }

    fn link_poses(&self) -> Vec<Pose> {
        self.state.plant.link_poses()
    }

    fn observation(&self) -> Option<&Observation> {
        Some(&self.state.seen)
    }

    fn save(&self) -> Saved {
        Saved::of(&self.state)
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), NotRestored> {
        self.state = saved.read("plant")?;
        Ok(())
    }
}

impl std::fmt::Debug for Physical {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let State { path_position, seen, .. } = &self.state;
        f.debug_struct("Physical")
            .field("path_position", path_position)
            .field("seen", seen)
            .finish_non_exhaustive()
    }
}

/// Shifts the points of a way to the right of its direction by `by` (m; negative: to the left).
fn shift_right(way: &mut [Point], by: f64) {
    if by == 0.0 {
        return;
    }
    let mut before = way.first().copied().unwrap_or_default();
    for i in 0..way.len() {
        let (here, next) = (way[i], way[(i + 1).min(way.len() - 1)]);
        let ahead = (next - before).try_normalize(1e-9).unwrap_or_default();
        before = here;
        way[i] = here - left_of(ahead) * by;
    }
}

/// The share of a speed that remains at a value: 1 up to the first limit, 0 at the second, but no less than
/// `least`.
fn share([slower, stop]: [f64; 2], value: f64, least: f64) -> f64 {
    ((stop - value) / (stop - slower)).clamp(least, 1.0)
}

/// One step of the object's pose from `at` toward `goal`, as fast as it can be carried there.
fn moved_toward(at: &PlanarPose, goal: &PlanarPose, walk: &Walk) -> PlanarPose {
    let way = goal.position - at.position;
    let most = CATCH_UP_FACTOR * walk.speed * walk.period;
    let share = if way.norm() > most { most / way.norm() } else { 1.0 };
    PlanarPose {
        position: at.position + way * share,
        yaw: turned(at.yaw, goal.yaw, walk.yaw_rate * walk.period),
    }
}
