//! The physical plant: the robot as a multibody, the object held at both ends by spring-dampers, a kinematic
//! human, static obstacles.
//!
//! The robot stands behind, the human ahead, the object's x from one to the other, all at the robot's grasp height, so that the object is
//! level. There is no floor: the base moves in its plane, and an object that is let down below 0.2 m counts as dropped. Same inputs
//! and seed, same bits; a plant that was written down and read back goes on with the same bits.

mod articulation;
mod clusters;
mod error;
mod grip;
mod human;
mod motor;
mod observation;
mod parts;
mod ramp;
mod sample;
mod scene;
mod settings;
mod tally;
mod touch;

pub use error::PhysicsError;
pub use human::HumanCommand;
pub use observation::{Clearance, Clearances, Contact, Failure, Forces, Observation, Part, Party, Wrench};
pub use sample::sample_motion;
pub use settings::{HumanSettings, PhysicsSettings};

use super::convert;
use crate::geometry::{PlanarPose, Point, Pose};
use crate::math;
use crate::robot::{InputVector, JointVector, Robot};
use crate::world::World;
use articulation::Articulation;
use grip::Grip;
use human::{Felt, Walker};
use parts::Parts;
use rapier3d::prelude::{PhysicsPipeline, PhysicsWorld, RigidBodyHandle};
use scene::Scene;
use serde::{Deserialize, Serialize};
use tally::Tally;

/// m/s^2.
const GRAVITY: f64 = 9.81;
/// An object whose centre is lower than this (m) is dropped.
const DROPPED: f64 = 0.2;
/// A body that is faster than this (m/s or rad/s) is on its way out of the numbers.
const FASTEST: f64 = 1000.0;
/// How far ahead of the hand the middle of the torso is, m.
const TORSO_AHEAD: f64 = 0.35;
/// Radius of the human's torso, an upright capsule, m.
pub const TORSO_RADIUS: f64 = 0.2;
/// Its height over all, m.
pub const TORSO_HEIGHT: f64 = 1.7;
/// Radius of the human's hand, a ball, m.
pub const HAND_RADIUS: f64 = 0.04;

/// The physical plant. It owns all that it needs, and can be written down with serde between two periods.
#[derive(Serialize, Deserialize)]
pub struct PhysicalPlant {
    world: PhysicsWorld,
    settings: PhysicsSettings,
    parts: Parts,
    robot: Articulation,
    object: RigidBodyHandle,
    object_name: String,
    /// Half the object's length, and the height that it is carried at, m.
    reach: f64,
    height: f64,
    gripper: Grip,
    hand: Grip,
    hand_body: RigidBodyHandle,
    torso_body: RigidBodyHandle,
    human: Walker,
    steps: u64,
    tally: Tally,
    failure: Option<Failure>,
}

impl PhysicalPlant {
    /// A team at rest.
    ///
    /// `team` is the object's centre with the heading of its x axis: the robot stands such that its grasp is at the rear end, with these
    /// `joints`; the human's hand is at the front end. Postures of a [`Robot`] hold the grasp level and ahead, so that this is exact for
    /// them. `seed` is the human's: it settles the gait.
    ///
    /// # Errors
    /// [`PhysicsError`] if a setting is out of its range, or an obstacle stands where the team is to start.
    pub fn new(
        world: &World,
        robot: &Robot,
        joints: &JointVector,
        team: &PlanarPose,
        settings: &PhysicsSettings,
        seed: u64,
    ) -> Result<Self, PhysicsError> {
        settings.check()?;
        let start = PhysicsError::Start { x: team.position.x, y: team.position.y, yaw: team.yaw };
        let is_number =
            [team.position.x, team.position.y, team.yaw].iter().chain(joints).all(|v| v.is_finite());
        if !is_number {
            return Err(start);
        }
        let plant = Scene { world, robot, joints, team, settings, seed }.build().ok_or(start)?;
        plant.check_start(world, team)?;
        Ok(plant)
    }

    /// One control period (s, at most a minute) with these mean rates (rims m/s, joints rad/s or m/s, both cut to the robot's limits; they change
    /// smoothly from the last period's), the human doing as commanded. A plant that has failed with [`Failure::NonFinite`] stays as it is.
    pub fn step(&mut self, rates: &InputVector, human: &HumanCommand, period: f64) -> Observation {
        let goal = match human {
            HumanCommand::Walk { hand } => [hand.position.x, hand.position.y, hand.yaw],
            HumanCommand::Follow => [0.0; 3],
        };
        let dt = self.settings.step();
        if !(rates.iter().chain(&goal).all(|v| v.is_finite()) && (dt / 2.0..=60.0).contains(&period)) {
            self.failure = Some(Failure::NonFinite { body: "command".to_owned() });
        }
        self.tally.begin();
        if matches!(self.failure, Some(Failure::NonFinite { .. })) {
            return self.observe();
        }
        if self.check().is_none() {
            return self.observe();
        }
        let steps = (period * self.settings.rate_hz).round() as u64;
        self.robot.command(rates, steps);
        self.human.begin(human, steps as f64 * dt);
        for _ in 0..steps {
            if self.substep(dt).is_none() {
                break;
            }
        }
        self.observe()
    }

    /// From here on the human's body turns to face that way (rad) and walks ahead of the hand there: one looks where one goes. With `None`,
    /// the way that the hand heads.
    pub fn face(&mut self, yaw: Option<f64>) {
        self.human.face(yaw.filter(|yaw| yaw.is_finite()));
    }

    /// What there is to see now; forces, contacts, work and jerk are those of the last period.
    pub fn observe(&self) -> Observation {
        let measured = self.robot.measure(&self.world);
        let body = |handle| self.world.bodies.get(handle);
        let pose = |handle| body(handle).map_or(Pose::identity(), |b| convert::pose(b.position()));
        let [linear, angular] = body(self.object)
            .map_or(Default::default(), |b| [convert::vector(b.linvel()), convert::vector(b.angvel())]);
        Observation {
            time: self.steps as f64 * self.settings.step(),
            configuration: measured.configuration,
            rim_speeds: measured.rim_speeds,
            joint_rates: measured.joint_rates,
            joint_efforts: measured.joint_efforts,
            effort_share: self.tally.effort_share(),
            wheel_angles: self.robot.wheel_angles(),
            grasp: self.robot.grasp(&self.world),
            object: pose(self.object),
            object_twist: [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z],
            hand: pose(self.hand_body),
            hand_planar: self.human.planar(),
            torso: pose(self.torso_body),
            grip: self.tally.gripper(),
            hand_grip: self.tally.hand(),
            squared_jerk: self.tally.squared_jerk(),
            contacts: self.tally.touches.contacts(&self.parts),
            clearances: touch::clearances(&self.world, &self.parts),
            failure: self.failure.clone(),
        }
    }

    /// Links of the robot that touch with meshes: physics leaves these out.
    pub fn left_out(&self) -> &[String] {
        self.parts.left_out()
    }

    /// `world_from_link` of every link as physics has it, in the order of [`Robot::links`]; wheels as if they had not turned.
    pub fn link_poses(&self) -> Vec<Pose> {
        self.robot.link_poses(&self.world)
    }

    /// One physics step of a sound state. `None` if what it comes to is not.
    fn substep(&mut self, dt: f64) -> Option<()> {
        let felt = self.felt()?;
        self.human.step(&felt, dt);
        let hand = self.human.hand(self.height);
        let torso = self.human.torso(TORSO_AHEAD, TORSO_HEIGHT / 2.0);
        for (handle, pose) in [(self.hand_body, hand), (self.torso_body, torso)] {
            let body = self.world.bodies.get_mut(handle)?;
            body.set_next_kinematic_position(convert::to_rapier_from(body.position(), &pose));
        }
        self.robot.drive(&mut self.world, dt)?;
        let [gripper, hand] = [self.gripper.axes(&self.world)?, self.hand.axes(&self.world)?];
        self.world.step();
        self.steps += 1;
        self.check()?;
        self.robot.roll(&self.world, dt);
        self.tally.add_effort(self.robot.effort_share(&self.world));
        let holds = [self.gripper.hold(&self.world, &gripper, dt)?, self.hand.hold(&self.world, &hand, dt)?];
        let velocity = convert::vector(self.world.bodies.get(self.object)?.linvel());
        self.tally.add(&holds, velocity, dt);
        self.tally.touches.add(&self.world, dt);
        Some(())
    }

    /// Where the object's front end is, and how the gripper moves it.
    fn felt(&self) -> Option<Felt> {
        let world_from_object = convert::pose(self.world.bodies.get(self.object)?.position());
        let end = world_from_object * nalgebra::Point3::new(self.reach, 0.0, 0.0);
        let ahead = world_from_object.rotation * nalgebra::Vector3::x();
        let gripper = self.world.bodies.get(self.robot.gripper().0)?;
        let velocity = convert::vector(gripper.velocity_at_point(convert::to_vector(&end.coords)));
        Some(Felt {
            end: PlanarPose { position: Point::new(end.x, end.y), yaw: math::atan2(ahead.y, ahead.x) },
            velocity: velocity.xy(),
            yaw_rate: gripper.angvel().z,
        })
    }

    /// Notices a state that is not a number, or about to become so, and an object that lies low. `None` in the first case: rapier panics
    /// where a body of a multibody is not a number, and so must not see one.
    fn check(&mut self) -> Option<()> {
        let is_sound = |handle: RigidBodyHandle| {
            self.world.bodies.get(handle).is_some_and(|b| {
                // what is not a number is not below the limit
                let is_slow = b.linvel().length() < FASTEST && b.angvel().length() < FASTEST;
                is_slow && b.translation().is_finite() && b.is_enabled()
            })
        };
        let lost = self.robot.bodies().iter().find(|(_, handle)| !is_sound(*handle));
        let lost = lost.map(|(name, _)| name).or((!is_sound(self.object)).then_some(&self.object_name));
        if let Some(body) = lost {
            self.failure = Some(Failure::NonFinite { body: body.clone() });
            return None;
        }
        let low = self.world.bodies.get(self.object)?.translation().z < DROPPED;
        if low && self.failure.is_none() {
            self.failure = Some(Failure::Dropped);
        }
        Some(())
    }
}

impl Clone for PhysicalPlant {
    /// A copy that goes on independently and with the same bits. The workspaces of rapier's pipelines are made anew, as they are when a
    /// plant is read back.
    fn clone(&self) -> Self {
        let world = &self.world;
        let world = PhysicsWorld {
            gravity: world.gravity,
            integration_parameters: world.integration_parameters,
            physics_pipeline: PhysicsPipeline::new(),
            collision_pipeline: Default::default(),
            islands: world.islands.clone(),
            broad_phase: world.broad_phase.clone(),
            narrow_phase: world.narrow_phase.clone(),
            bodies: world.bodies.clone(),
            colliders: world.colliders.clone(),
            impulse_joints: world.impulse_joints.clone(),
            multibody_joints: world.multibody_joints.clone(),
            soft_bodies: world.soft_bodies.clone(),
            ccd_solver: Default::default(),
        };
        Self {
            world,
            parts: self.parts.clone(),
            robot: self.robot.clone(),
            object_name: self.object_name.clone(),
            human: self.human.clone(),
            tally: self.tally.clone(),
            failure: self.failure.clone(),
            ..*self
        }
    }
}

impl std::fmt::Debug for PhysicalPlant {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.debug_struct("PhysicalPlant").field("steps", &self.steps).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rapier3d::math::Vector;

    fn plant() -> PhysicalPlant {
        let text = "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [9, 0]\n";
        let world = World::parse("w.toml", text).unwrap();
        let robot = Robot::built_in().unwrap();
        let team = PlanarPose { position: world.start, yaw: 0.0 };
        let settings = PhysicsSettings::default();
        PhysicalPlant::new(&world, &robot, &robot.postures[0].joints, &team, &settings, 1).unwrap()
    }

    #[test]
    fn a_body_that_is_no_longer_anywhere_is_named_and_stops_the_plant() {
        let mut plant = plant();
        plant.world.bodies[plant.object].set_linvel(Vector::new(f64::NAN, 0.0, 0.0), true);
        let seen = plant.step(&InputVector::zeros(), &HumanCommand::Follow, 0.2);
        let Some(Failure::NonFinite { body }) = seen.failure else { panic!("{:?}", seen.failure) };
        assert_eq!(body, "beam");
        assert_eq!(plant.step(&InputVector::zeros(), &HumanCommand::Follow, 0.2).time, seen.time);
    }

    #[test]
    fn an_object_on_the_floor_is_dropped() {
        let mut plant = plant();
        plant.world.bodies[plant.object].set_translation(Vector::new(0.0, 0.0, 0.1), true);
        let seen = plant.step(&InputVector::zeros(), &HumanCommand::Follow, 0.2);
        assert_eq!(seen.failure, Some(Failure::Dropped));
    }
}
