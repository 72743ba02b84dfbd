//! The two plants as the loop sees them: what the robot observes of the human, where the grasp should be, and what a step makes of it.

use super::tick::PhysicsTick;
use super::way::{BODY_ROOM, Ground, Turned, WALKS_AHEAD, Way};
use crate::control::{Follower, HORIZON, Reference, reference};
use crate::coordination::Mode;
use crate::geometry::{Path, PlanarPose, Point, Pose, Widening, angle_of, nearest, wrap_angle};
use crate::options::{nominal_trajectory, turned};
use crate::robot::{Configuration, InputVector, Robot, pose_difference};
use crate::simulation::{HumanCommand, KinematicPlant, Observation, PhysicalPlant, PhysicsError};
use crate::world::World;

/// How the team walks: what the robot knows of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Walk {
    pub period: f64,
    pub speed: f64,
    pub yaw_rate: f64,
}

/// Where a way leads on from where the team is.
#[derive(Clone, Copy)]
pub(super) struct Onward<'s> {
    /// The path under way, and how far along it the team is, m.
    pub path: &'s Path,
    pub along: f64,
    /// How far ahead of that the hand is, m ([`PhysicalTeam::lead`]); nothing on the kinematic plant.
    pub lead: f64,
    /// The path to turn onto; none to go on. On the physical plant, it begins where the human's body is.
    pub turn: Option<&'s Path>,
}

/// What a step came to.
pub(super) struct Moved {
    /// How far along the path under way the team is now, m.
    pub along: f64,
    /// s - x after the step: what separates the grasp from where it should be, m and rad.
    pub error: nalgebra::Vector6<f64>,
    pub physics: Option<PhysicsTick>,
}

/// Which way a team walks along its way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Gait {
    Forward,
    /// It steps back to where there is room to turn. Whoever leads says so: nobody steps back unannounced with somebody at the other end.
    Backward,
}

/// A team on the kinematic plant: the human walks the path exactly, and is the reference.
#[derive(Clone, Debug)]
pub(super) struct KinematicTeam<'a> {
    pub robot: &'a Robot,
    pub plant: KinematicPlant<'a>,
    /// s(k): the human's state, as the pose that the grasp should have.
    pub human: PlanarPose,
}

/// A team on the physical plant: the object's ends ride on the path, the robot's end behind.
#[derive(Clone, serde::Serialize, serde::Deserialize)]
pub(super) struct PhysicalTeam {
    plant: PhysicalPlant,
    way: Way,
    height: f64,
    /// How far along the path who leads means to be, m: ahead of the object by what the grips yield.
    pace: f64,
    /// How fast the pace goes, m/s.
    pub hurry: f64,
    /// Where who leads means the object to be.
    goal: PlanarPose,
    pub seen: Observation,
}

/// How quickly a team comes to its walking speed, m/s^2.
pub(super) const ACCELERATION: f64 = 0.9;
/// A team slows down where the object has to turn farther (rad) than it can in a step, to a tenth at so much more.
const LAG: [f64; 2] = [0.1, 0.4];
/// What is out of place is moved into it at this many times the walking speed.
const CATCH_UP: f64 = 1.5;
/// Points that are kept of the way walked: as far back as a base is.
const WAY_POINTS: u32 = 50;
/// How fast a team steps back, m/s.
const BACKWARD: f64 = 0.35;
/// The object is turned slower where the robot's end is this far (m) from where it is to be, and at a fifth of the rate where it is so much.
const OUT_OF_PLACE: [f64; 2] = [0.02, 0.08];
/// Who leads goes slower where the object is this far (m) behind, and waits where it is so much.
const PATIENCE: [f64; 2] = [0.01, 0.08];

impl Gait {
    /// How fast a team goes in the end, m/s ahead.
    pub fn speed(self, walk: &Walk) -> f64 {
        match self {
            Self::Forward => walk.speed,
            Self::Backward => -BACKWARD,
        }
    }

    /// How fast a team that goes with `speed` goes a period later, no faster than this `share` of what it comes to; m/s ahead.
    pub fn speed_after(self, speed: f64, share: f64, walk: &Walk) -> f64 {
        let change = ACCELERATION * walk.period;
        match self {
            Self::Forward => (speed + change).min(walk.speed * share),
            Self::Backward => (speed - change).max(-BACKWARD * share),
        }
    }
}

impl KinematicTeam<'_> {
    pub fn reference(&self, onward: &Onward, speed: f64, walk: &Walk, grasp: &Pose) -> Reference {
        let (path, along) = onward.turn.map_or((onward.path, onward.along), |path| (path, 0.0));
        let trajectory =
            nominal_trajectory(path, along, self.human.yaw, speed, walk.yaw_rate, walk.period).take(HORIZON);
        reference(trajectory, grasp, self.robot.grasp_height)
    }

    /// Moves the robot, now that the human has walked to where `path` is after `along` (m), at `position`.
    pub fn step(
        &mut self,
        target: &Configuration,
        input: &InputVector,
        (path, along, position): (&Path, f64, Point),
        walk: &Walk,
    ) -> Moved {
        if let Some(tangent) = path.heading_at(along) {
            self.human.yaw = turned(self.human.yaw, tangent, walk.yaw_rate * walk.period);
        }
        self.human.position = position;
        self.plant.step(target, input, walk.period);
        let goal = self.human.at_height(self.robot.grasp_height);
        Moved { along, error: pose_difference(&goal, &self.plant.grasp()), physics: None }
    }
}

impl PhysicalTeam {
    /// A team at rest, its object's middle at `team`.
    pub fn new(plant: PhysicalPlant, world: &World, height: f64, team: &PlanarPose) -> Self {
        let seen = plant.observe();
        let way = Way::new(world, team);
        Self { plant, way, height, pace: 0.0, hurry: 0.0, goal: *team, seen }
    }

    /// Where physics has the robot's links.
    pub fn link_poses(&self) -> Vec<Pose> {
        self.plant.link_poses()
    }

    /// Where the grasp should be for the human where they are, as a pose on the floor.
    pub fn human(&self) -> PlanarPose {
        self.way.end(&self.goal, -1.0)
    }

    /// How far the hand is ahead of where it would be with the object's middle `along` (m) on `path`, m: what the robot sees of the pace.
    pub fn lead(&self, path: &Path, along: f64) -> f64 {
        const STEP: f64 = 0.02;
        let hand = on_floor(&self.seen.hand);
        let distance = |walked: f64| {
            let front = self.way.end(&self.way.pose(path, along + walked), 1.0);
            (front.position - hand).norm_squared()
        };
        let leads = (0..=25).map(|i| STEP * f64::from(i) - 0.1);
        nearest(leads, distance).unwrap_or(0.0)
    }

    /// How far along the path under way (m) the object is to be now, and how fast that goes (m/s), as the robot knows it: from what it means to
    /// do while it leads, else from the hand, which is `hand` (m) along and which it sees move at `speed` (m/s).
    pub fn pace(&self, mode: Mode, hand: f64, speed: f64) -> (f64, f64) {
        match mode {
            Mode::RobotLed => (self.pace, self.hurry),
            Mode::HumanLed => (hand, speed),
        }
    }

    /// The way of the grasp so far, from where it is to be when the object has come to `pace` back to where the base surely is, m.
    pub fn write_way_walked(&self, path: &Path, pace: f64, way: &mut Vec<Point>) {
        way.clear();
        let behind = (0..WAY_POINTS).rev().map(|i| self.way.half() + Follower::STEP * f64::from(i));
        way.extend(behind.map(|behind| self.way.point(path, pace - behind)));
    }

    fn pose(&self, onward: &Onward, walked: f64) -> PlanarPose {
        match onward.turn {
            None => self.way.pose(onward.path, onward.along + walked),
            Some(onto) => self.way.pose_after_turning(onward.path, onward.along, onto, walked),
        }
    }

    /// s(1..H) of the grasp along a way: from the pace while the robot leads, from where the hand is seen while the human does.
    pub fn reference(
        &self,
        onward: &Onward,
        speed: f64,
        (mode, gait): (Mode, Gait),
        walk: &Walk,
        grasp: &Pose,
    ) -> Reference {
        let (pace, mut hurry) = self.pace(mode, onward.along + onward.lead, speed);
        let mut ahead = pace - onward.along;
        let mut at = if mode == Mode::RobotLed { self.goal } else { self.held_by_hand() };
        let grasps = (1..=HORIZON).map(|_| {
            hurry = gait.speed_after(hurry, 1.0, walk);
            ahead += hurry * walk.period;
            at = brought_to(&at, &self.pose(onward, ahead), walk);
            self.way.end(&at, -1.0)
        });
        reference(grasps, grasp, self.height)
    }

    /// Where the object would be if it were where the hand is.
    fn held_by_hand(&self) -> PlanarPose {
        let yaw = object_on_floor(&self.seen.object).yaw;
        let hand = PlanarPose { position: on_floor(&self.seen.hand), yaw };
        PlanarPose { position: self.way.end(&hand, -1.0).position, yaw }
    }

    /// Moves robot, object and human by one period.
    pub fn step(
        &mut self,
        rates: &InputVector,
        (mode, gait): (Mode, Gait),
        (path, along): (&Path, f64),
        walk: &Walk,
    ) -> Moved {
        let lag = wrap_angle(self.way.pose(path, self.pace).yaw - self.goal.yaw).abs();
        let share = |[slower, least]: [f64; 2], value: f64| (least - value) / (least - slower);
        let turning = share(LAG, lag).clamp(0.1, 1.0);
        let ahead = match gait {
            Gait::Forward => self.pace - along,
            Gait::Backward => along - self.pace,
        };
        let waiting = share(PATIENCE, ahead).clamp(0.0, 1.0);
        self.hurry = gait.speed_after(self.hurry, turning * waiting, walk);
        self.pace += self.hurry * walk.period;
        let out_of_place = (self.human().position - on_floor(&self.seen.grasp)).norm();
        let following = share(OUT_OF_PLACE, out_of_place).clamp(0.2, 1.0);
        let gently = Walk { yaw_rate: walk.yaw_rate * following, ..*walk };
        self.goal = brought_to(&self.goal, &self.way.pose(path, self.pace), &gently);
        let goal = self.goal;
        let hand = self.way.end(&goal, 1.0);
        self.plant.face(Some(angle_of(self.body(path, hand.position) - hand.position)));
        let command = match mode {
            Mode::RobotLed => HumanCommand::Follow,
            Mode::HumanLed => HumanCommand::Walk { hand },
        };
        self.seen = self.plant.step(rates, &command, walk.period);
        let object = object_on_floor(&self.seen.object);
        let along = self.way.locate(path, object.position, along, self.pace, self.hurry < 0.0);
        let grasp = self.way.end(&goal, -1.0).at_height(self.height);
        Moved {
            along,
            error: pose_difference(&grasp, &self.seen.grasp),
            physics: Some(PhysicsTick::of(&self.seen, self.pace - along)),
        }
    }

    /// Where the human's body walks: on the way, whoever leads, since it sees where that goes; as far from the hand as it is.
    fn body(&self, path: &Path, hand: Point) -> Point {
        const STEP: f64 = 0.02;
        let point = |ahead: f64| self.way.point(path, self.pace + self.way.half() + ahead);
        let mut ahead = (0..50).map(|i| point(STEP * f64::from(i)));
        let far_enough = ahead.find(|point| (point - hand).norm() >= WALKS_AHEAD);
        far_enough.unwrap_or_else(|| point(WALKS_AHEAD))
    }

    /// Writes `path`, made for a point, as somebody expects the team to walk it into `way`: as if there were room.
    pub fn write_wide(&self, path: &Path, widening: &mut Widening, way: &mut Path) {
        self.way.write_wide(path, |_, _| true, widening, way);
    }

    /// `path`, made for a point, as the team walks it.
    pub fn wide(&self, path: &Path, ground: Ground) -> Path {
        let mut way = Path::default();
        self.way.write_wide(path, |from, to| ground.is_free(from, to), &mut Widening::default(), &mut way);
        way
    }

    /// Refuses an option, by the path that a point walks on it, where the human has no room to walk on beyond its end: as far as the human is ahead
    /// of the object's middle.
    pub fn check_end(
        &self,
        path: &Path,
        option: &str,
        world: &World,
        ground: Ground,
    ) -> Result<(), PhysicsError> {
        let [end, human] = self.way.beyond_end(&self.wide(path, ground));
        let distances = world.obstacles.iter().map(|o| (o.footprint.distance_to_segment(end, human), o));
        match distances.min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((distance, obstacle)) if distance < BODY_ROOM => Err(PhysicsError::NoRoomAtTarget {
                file: world.file.clone(),
                option: option.to_owned(),
                x: human.x,
                y: human.y,
                obstacle: obstacle.name.clone(),
                distance,
                needed: BODY_ROOM,
                ahead: (human - end).norm() + BODY_ROOM,
            }),
            _ => Ok(()),
        }
    }

    /// Writes the way on which whoever walks ahead would turn onto `next`, from `along` (m) on `path`.
    pub fn write_way_onto(&self, path: &Path, along: f64, next: &Path, ground: Ground, way: &mut Path) {
        self.way.write_onto(path, along, next, ground, way);
    }

    /// Where the team had better step back to, to turn there ([`Way::place_behind`]).
    pub fn place_behind(
        &self,
        path: &Path,
        from: [f64; 2],
        next: impl Fn(Point) -> Path,
        ground: Ground,
    ) -> Option<f64> {
        self.way.place_behind(path, from, next, ground)
    }

    /// The path under way is left `along` (m) on it for `next`. Returns what the object's middle walks; `None` if there is no room.
    pub fn turn(&mut self, path: &Path, along: f64, next: &Path, ground: Ground) -> Option<Turned> {
        let turned = self.way.planned_turn(path, along, next, ground)?;
        self.way.leave(path, along);
        self.pace -= along;
        Some(turned)
    }
}

impl std::fmt::Debug for PhysicalTeam {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("PhysicalTeam")
            .field("pace", &self.pace)
            .field("seen", &self.seen)
            .finish_non_exhaustive()
    }
}

/// A step from where the object is toward where it is to be: no faster than it can be carried there.
fn brought_to(at: &PlanarPose, goal: &PlanarPose, walk: &Walk) -> PlanarPose {
    let way = goal.position - at.position;
    let most = CATCH_UP * walk.speed * walk.period;
    let share = if way.norm() > most { most / way.norm() } else { 1.0 };
    PlanarPose {
        position: at.position + way * share,
        yaw: turned(at.yaw, goal.yaw, walk.yaw_rate * walk.period),
    }
}

/// Where something is, seen from above, m.
pub(super) fn on_floor(world_from_it: &Pose) -> Point {
    world_from_it.translation.vector.xy().into()
}

/// Where the object's middle is and where it heads, seen from above.
pub(super) fn object_on_floor(world_from_object: &Pose) -> PlanarPose {
    let ahead = world_from_object.rotation * nalgebra::Vector3::x();
    PlanarPose { position: on_floor(world_from_object), yaw: angle_of(ahead.xy()) }
}
