//! The kinematic plant, as in the paper's simulations. The human walks the path exactly and is the reference;
//! the robot follows its inputs exactly.

use super::bodies::{Bodies, Manipulator, Moved, PathAhead};
use super::team_path::{FreeSpace, Turned};
use super::{Step, Travel, Walk};
use crate::control::{BaseInputs, Candidate, HORIZON, Intent, Reference, reference};
use crate::geometry::{Path, PlanarPose, Point, Pose};
use crate::options::{nominal_trajectory, turned};
use crate::robot::{Configuration, InputVector, Robot, pose_difference};
use crate::saved::{NotRestored, Saved};
use crate::simulation::{KinematicPlant, Observation};

/// Human and robot without dynamics.
#[derive(Clone, Debug)]
pub(super) struct Kinematic<'a> {
    robot: &'a Robot,
    plant: KinematicPlant<'a>,
    /// s(k): the human's state, as the pose that the grasp should have.
    human: PlanarPose,
}

impl<'a> Kinematic<'a> {
    /// Bodies with the grasp at `start`.
    pub fn new(manipulator: &Manipulator<'a>, start: PlanarPose) -> Self {
        let Manipulator { robot, posture, .. } = *manipulator;
        Self { robot, plant: KinematicPlant::place(robot, &posture, &start), human: start }
    }
}

impl Bodies for Kinematic<'_> {
    fn configuration(&self) -> &Configuration {
        self.plant.configuration()
    }

    fn grasp_goal(&self) -> PlanarPose {
        self.human
    }

    fn body(&self) -> Point {
        self.human.position
    }

    fn hand(&self) -> Point {
        self.human.position
    }

    fn lead(&self, _: &Path, _: f64) -> f64 {
        0.0
    }

    fn observed_speed(&self, intent: &Intent, _: Travel, walk: &Walk) -> f64 {
        intent.speed().unwrap_or(walk.speed)
    }

    fn expect_path(&mut self, _: &super::Situation, _: &mut Path, _: FreeSpace) {}

    fn reference(&self, path_ahead: &PathAhead, speed: f64, walk: &Walk, grasp: &Pose) -> Reference {
        let (path, along) = path_ahead.turn.map_or((path_ahead.path, path_ahead.along), |path| (path, 0.0));
        let trajectory =
            nominal_trajectory(path, along, self.human.yaw, speed, walk.yaw_rate, walk.period).take(HORIZON);
        reference(trajectory, grasp, self.robot.grasp_height)
    }

    fn base_on_path(&mut self, _: &PathAhead, _: f64, _: &Manipulator, _: &Walk) -> Option<BaseInputs> {
        None
    }

    fn walkable(&self, path: Path, _: FreeSpace) -> Path {
        path
    }

    fn turn(&mut self, _: &Path, _: f64, next: Path, _: FreeSpace) -> Option<Turned> {
        Some(Turned { path: next, until: 0.0 })
    }

    fn place_to_turn(&self, _: &Path, _: [f64; 2], _: &dyn Fn(Point) -> Path, _: FreeSpace) -> Option<f64> {
        None
    }

    fn step(&mut self, target: &Candidate, input: &InputVector, step: &Step, walk: &Walk) -> Moved {
        if let Some(tangent) = step.path.heading_at(step.to) {
            self.human.yaw = turned(self.human.yaw, tangent, walk.yaw_rate * walk.period);
        }
        self.human.position = step.position;
        self.plant.step(&target.configuration, input, walk.period);
        let goal = self.human.at_height(self.robot.grasp_height);
        Moved { along: step.to, error: pose_difference(&goal, &self.plant.grasp()), physics: None }
    }

    fn link_poses(&self) -> Vec<Pose> {
        self.robot.link_poses(self.plant.configuration())
    }

    fn observation(&self) -> Option<&Observation> {
        None
    }

    fn human(&self) -> Option<&PlanarPose> {
        Some(&self.human)
    }

    fn save(&self) -> Saved {
        Saved::of(&(self.human, self.plant.configuration()))
    }

    fn restore(&mut self, saved: &Saved) -> Result<(), NotRestored> {
        let (human, configuration): (PlanarPose, Configuration) = saved.read("plant")?;
        self.human = human;
        self.plant = KinematicPlant::at(self.robot, configuration);
        Ok(())
    }
}
