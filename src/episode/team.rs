//! The two plants as the loop sees them: what the robot observes of the human, where the grasp should be, and what a step makes of it.

use super::tick::PhysicsTick;
use crate::control::{HORIZON, Reference, reference};
use crate::coordination::Mode;
use crate::geometry::{Path, PlanarPose, Point, Pose, Tandem, Vector, angle_of, direction};
use crate::options::{nominal_trajectory, turned};
use crate::robot::{Configuration, InputVector, Robot, pose_difference};
use crate::simulation::{HumanCommand, KinematicPlant, Observation, PhysicalPlant};

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
    /// The path to turn onto here; none to go on.
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

/// A team on the kinematic plant: the human walks the path exactly, and is the reference.
#[derive(Clone, Debug)]
pub(super) struct KinematicTeam<'a> {
    pub robot: &'a Robot,
    pub plant: KinematicPlant<'a>,
    /// s(k): the human's state, as the pose that the grasp should have.
    pub human: PlanarPose,
}

/// A team on the physical plant: the object's ends ride on the path, the robot's end behind.
#[derive(Clone)]
pub(super) struct PhysicalTeam {
    plant: PhysicalPlant,
    tandem: Tandem,
    height: f64,
    /// How far along the path who leads means to be, m: ahead of the object by what the grips yield.
    pace: f64,
    pub seen: Observation,
}

/// Who leads waits for the object when it is this far (m) behind.
const PATIENCE: f64 = 0.15;
/// How far ahead of the hand the human walks, m.
const WALKS_AHEAD: f64 = 0.35;
/// How far (m) the object may come in one step.
const REACH: f64 = 0.4;

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
    pub fn new(plant: PhysicalPlant, object_length: f64, height: f64, team: &PlanarPose) -> Self {
        let seen = plant.observe();
        let tandem = Tandem::new(object_length, team.position, team.yaw);
        Self { plant, tandem, height, pace: 0.0, seen }
    }

    /// Where physics has the robot's links.
    pub fn link_poses(&self) -> Vec<Pose> {
        self.plant.link_poses()
    }

    /// Where the grasp should be for the human where they are, as a pose on the floor.
    pub fn human(&self, path: &Path) -> PlanarPose {
        self.tandem.end(&self.tandem.pose(path, self.pace), -1.0)
    }

    /// How far the hand is ahead of the object's front end, along the object, m: what the robot sees of the pace.
    fn lead(&self) -> f64 {
        let object = object_on_floor(&self.seen.object);
        let front = self.tandem.end(&object, 1.0).position;
        let hand: Point = self.seen.hand.translation.vector.xy().into();
        (hand - front).dot(&direction(object.yaw)).clamp(-PATIENCE, PATIENCE)
    }

    fn pose(&self, onward: &Onward, walked: f64) -> PlanarPose {
        match onward.turn {
            None => self.tandem.pose(onward.path, onward.along + walked),
            Some(turn) => self.tandem.pose_after_turning(onward.path, onward.along, turn, walked),
        }
    }

    /// s(1..H) of the grasp along a way: from the pace while the robot leads, from where the hand is seen while the human does.
    pub fn reference(&self, onward: &Onward, speed: f64, mode: Mode, walk: &Walk, grasp: &Pose) -> Reference {
        let ahead = match mode {
            Mode::RobotLed => self.pace - onward.along,
            Mode::HumanLed => self.lead(),
        };
        let grasps = (1..=HORIZON).map(|t| {
            let walked = ahead + speed * walk.period * t as f64;
            self.tandem.end(&self.pose(onward, walked), -1.0)
        });
        reference(grasps, grasp, self.height)
    }

    /// Where the hand would go in one step along a way.
    pub fn hand_step(&self, onward: &Onward, step: f64) -> Vector {
        let ahead = self.lead();
        let hand = |walked: f64| self.tandem.end(&self.pose(onward, walked), 1.0).position;
        hand(ahead + step) - hand(ahead)
    }

    /// Moves robot, object and human by one period.
    pub fn step(
        &mut self,
        rates: &InputVector,
        mode: Mode,
        (path, along): (&Path, f64),
        walk: &Walk,
    ) -> Moved {
        if self.pace - along < PATIENCE {
            self.pace = (self.pace + walk.speed * walk.period).min(path.length());
        }
        let goal = self.tandem.pose(path, self.pace);
        let hand = self.tandem.end(&goal, 1.0);
        self.plant.face(Some(angle_of(self.body(path, hand.position) - hand.position)));
        let command = match mode {
            Mode::RobotLed => HumanCommand::Follow,
            Mode::HumanLed => HumanCommand::Walk { hand },
        };
        self.seen = self.plant.step(rates, &command, walk.period);
        let object = object_on_floor(&self.seen.object);
        let along = self.tandem.locate(path, object.position, along, REACH);
        let grasp = self.tandem.end(&goal, -1.0).at_height(self.height);
        Moved {
            along,
            error: pose_difference(&grasp, &self.seen.grasp),
            physics: Some(PhysicsTick::of(&self.seen, self.pace - along)),
        }
    }

    /// Where the human's body walks: on the way, whoever leads, since it sees where that goes; as far from the hand as it is.
    fn body(&self, path: &Path, hand: Point) -> Point {
        const STEP: f64 = 0.02;
        let front = self.pace + self.tandem.length() / 2.0;
        let mut ahead = (0..50).map(|i| self.tandem.point(path, front + STEP * f64::from(i)));
        let far_enough = ahead.find(|point| (point - hand).norm() >= WALKS_AHEAD);
        far_enough.unwrap_or_else(|| self.tandem.point(path, front + WALKS_AHEAD))
    }

    /// The path under way is left `along` (m) on it for another that begins there.
    pub fn turn(&mut self, path: &Path, along: f64) {
        self.tandem.leave(path, along);
        self.pace -= along;
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

/// Where the object's middle is and where it heads, seen from above.
pub(super) fn object_on_floor(world_from_object: &Pose) -> PlanarPose {
    let ahead = world_from_object.rotation * nalgebra::Vector3::x();
    PlanarPose { position: world_from_object.translation.vector.xy().into(), yaw: angle_of(ahead.xy()) }
}
