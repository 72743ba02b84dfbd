//! The physical plant: the robot as a multibody, the object held at both ends by spring-dampers, a kinematic
//! human, and static obstacles.
//!
//! The robot stands behind and the human ahead. The object's x axis points from the robot to the human. Both
//! ends are at the robot's grasp height, so the object is level. There is no floor: the base moves in its
//! plane, and an object below 0.2 m, or below half of the height at which it is held, counts as dropped. The
//! same inputs and seed give the same bits, also after the plant was serialised and read back.

mod accumulator;
mod articulation;
mod base_motor;
mod clusters;
mod dimensions;
mod grip;
mod human;
mod model;
mod motor;
mod noise;
mod observation;
mod parts;
mod past;
mod ramp;
pub(crate) mod sample;
mod scene;
mod settings;
mod sharing;
mod touch;

pub use dimensions::{HAND_RADIUS, TORSO_AHEAD, TORSO_HEIGHT, TORSO_RADIUS};
pub use human::HumanCommand;
pub use model::{BodyModel, ContactGroup, GripModel, JointModel, PhysicsStep, PlantModel};
pub use observation::{BodyKind, Clearance, Clearances, Contact, Failure, Forces, Observation, Part, Wrench};
pub use scene::PhysicalPlant;
pub use settings::{HumanSettings, PhysicsSettings};
pub use sharing::{Sharing, motive_and_internal};

use super::convert;
use crate::error::Error;
use crate::geometry::{PlanarPose, Point, Pose};
use crate::math;
use crate::robot::{InputVector, JointVector, Robot};
use crate::world::World;
use human::SensedObject;
use nalgebra::{Rotation3, Vector3};
use noise::Coefficients;
use past::{Past, SPACING, StepGiven};
use rapier3d::prelude::{PhysicsPipeline, PhysicsWorld, RigidBodyHandle};
use scene::Scene;

/// Height (m) of the object's centre below which the object counts as dropped, and the share of its carrying
/// height where that is lower.
const DROPPED_HEIGHT_M: f64 = 0.2;
const DROPPED_SHARE: f64 = 0.5;
/// Speed (m/s or rad/s) beyond which a body counts as diverging.
const DIVERGING_SPEED: f64 = 1000.0;
/// How often a step is made again at most until all motors keep their limits.
const LIMIT_ROUNDS: usize = 16;
/// Solver iterations of a step that is made again, as a multiple of the usual ones.
const LIMITED_ITERATIONS: usize = 4;

impl PhysicalPlant {
    /// A team at rest.
    ///
    /// `team` is the pose of the object's centre, with the heading of its x axis. The robot stands with these
    /// `joints` such that its grasp is at the rear end; the human's hand is at the front end. Postures of a
    /// [`Robot`] hold the grasp level and ahead, so this is exact for them. `seed` determines the human's
    /// gait.
    ///
    /// # Errors
    /// A setting is out of its range, or an obstacle stands where the team should start: then the error is of
    /// [`ErrorKind::World`](crate::ErrorKind::World).
    pub fn new(
        world: &World,
        robot: &Robot,
        joints: &JointVector,
        team: &PlanarPose,
        settings: &PhysicsSettings,
        seed: u64,
    ) -> Result<Self, Error> {
        settings.check()?;
        let (x, y, yaw) = (team.position.x, team.position.y, team.yaw);
        let is_number = [x, y, yaw].iter().chain(joints).all(|v| v.is_finite());
        let scene = Scene { world, robot, joints, team, settings, seed };
        let plant = is_number.then(|| scene.build()).flatten().ok_or_else(|| {
            Error::new(format!(
                "physics: the team cannot start at ({x}, {y}) heading {yaw} rad with these joint positions"
            ))
        })?;
        plant.check_start(world, team)?;
        Ok(plant)
    }

    /// [Begins](PhysicalPlant::begin) an observation and [advances](PhysicalPlant::advance) by one control
    /// period.
    pub fn step(&mut self, rates: &InputVector, human: &HumanCommand, period: f64) -> Observation {
        self.begin();
        self.advance(rates, human, period)
    }

    /// Begins an observation: forces, contacts, work and jerk are those since then.
    pub fn begin(&mut self) {
        self.accumulator.begin();
    }

    /// Simulates one control period (s, at most a minute) with these mean rates (inputs of the base, joints
    /// rad/s or m/s) and this command of the human. The rates are clamped to the robot's limits and change
    /// smoothly from those of the last period. What is left of a physics step at the end of a period is made up
    /// for in the next. A plant that failed with [`Failure::NonFinite`] no longer changes.
    pub fn advance(&mut self, rates: &InputVector, human: &HumanCommand, period: f64) -> Observation {
        self.advance_observed(rates, human, period, None)
    }

    /// As [`PhysicalPlant::advance`]; an observer sees every physics step.
    pub fn advance_observed(
        &mut self,
        rates: &InputVector,
        human: &HumanCommand,
        period: f64,
        observer: Option<&mut dyn FnMut(&PhysicsStep)>,
    ) -> Observation {
        self.advance_copying(rates, human, period, observer, Past::new(SPACING))
    }

    /// As [`PhysicalPlant::advance_observed`], with the world's past kept as told.
    fn advance_copying(
        &mut self,
        rates: &InputVector,
        human: &HumanCommand,
        period: f64,
        mut observer: Option<&mut dyn FnMut(&PhysicsStep)>,
        mut past: Past,
    ) -> Observation {
        let goal = match human {
            HumanCommand::Walk { hand } => [hand.position.x, hand.position.y, hand.yaw],
            HumanCommand::Follow => [0.0; 3],
        };
        let dt = self.settings.step();
        if !(rates.iter().chain(&goal).all(|v| v.is_finite()) && (dt / 2.0..=60.0).contains(&period)) {
            self.failure = Some(Failure::NonFinite { body: "command".to_owned() });
        }
        if matches!(self.failure, Some(Failure::NonFinite { .. })) {
            return self.observe();
        }
        if self.check().is_none() {
            return self.observe();
        }
        self.owed += period * self.settings.rate_hz;
        let steps = self.owed.round().max(1.0);
        self.owed -= steps;
        let steps = steps as u64;
        self.robot.command(rates, steps);
        self.human.begin(human, steps as f64 * dt);
        let noise = Coefficients::new(dt);
        for _ in 0..steps {
            if self.substep(dt, &noise, &mut past, &mut observer).is_none() {
                break;
            }
        }
        self.observe()
    }

    /// Sets the heading (rad) that the human's body turns to; the body walks ahead of the hand in this
    /// direction. `None`: the hand's heading.
    pub fn face(&mut self, yaw: Option<f64>) {
        self.human.face(yaw.filter(|yaw| yaw.is_finite()));
    }

    /// The observation of the present state. Forces, contacts, work and jerk are those since it was begun.
    pub fn observe(&self) -> Observation {
        let measured = self.robot.measure(&self.world);
        let body = |handle| self.world.bodies.get(handle);
        let pose = |handle| body(handle).map_or(Pose::identity(), |b| convert::pose(b.position()));
        let [linear, angular] = body(self.object)
            .map_or(Default::default(), |b| [convert::vector(b.linvel()), convert::vector(b.angvel())]);
        Observation {
            time: self.steps as f64 * self.settings.step(),
            configuration: measured.configuration,
            base_rates: measured.base_rates,
            joint_rates: measured.joint_rates,
            joint_efforts: measured.joint_efforts,
            effort_share: self.accumulator.effort_share(),
            time_at_limit: self.accumulator.time_at_limit(),
            rolled: self.robot.rolled(),
            grasp: self.robot.grasp(&self.world),
            object: pose(self.object),
            object_twist: [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z],
            hand: pose(self.hand_body),
            hand_planar: self.human.planar(),
            torso: pose(self.torso_body),
            grip: self.accumulator.gripper(),
            hand_grip: self.accumulator.hand(),
            sharing: self.accumulator.sharing(),
            squared_jerk: self.accumulator.squared_jerk(),
            contacts: self.accumulator.touches.contacts(&self.parts),
            clearances: touch::clearances(&self.world, &self.parts),
            failure: self.failure.clone(),
        }
    }

    /// Links of the robot with collision meshes, which the physics ignores.
    pub fn left_out(&self) -> &[String] {
        self.parts.left_out()
    }

    /// `world_from_link` of every link as simulated, in the order of [`Robot::links`], with the wheels
    /// unturned.
    pub fn link_poses(&self) -> Vec<Pose> {
        self.robot.link_poses(&self.world)
    }

    /// One physics step of a sound state. `None` if the result is not sound.
    fn substep(
        &mut self,
        dt: f64,
        noise: &Coefficients,
        past: &mut Past,
        observer: &mut Option<&mut dyn FnMut(&PhysicsStep)>,
    ) -> Option<()> {
        let sensed = self.sensed_object()?;
        self.human.step(&sensed, dt);
        let hand = self.human.hand(self.height);
        let torso = self.human.torso(TORSO_AHEAD, TORSO_HEIGHT / 2.0);
        let mut poses = [(self.hand_body, hand), (self.torso_body, torso)].map(|(handle, pose)| {
            let body = self.world.bodies.get_mut(handle)?;
            let pose = convert::to_rapier_from(body.position(), &pose);
            body.set_next_kinematic_position(pose);
            Some((handle, pose))
        });
        let poses = [poses[0].take()?, poses[1].take()?];
        let base_rates = self.robot.drive(&mut self.world, dt)?;
        past.keep(&self.world, || Some(StepGiven { poses, motors: self.robot.given(&self.world)? }))?;
        let [gripper, hand] = [self.gripper.axes(&self.world)?, self.hand.axes(&self.world)?];
        self.step_within_limits(past)?;
        self.steps += 1;
        self.robot.roll(&self.world, dt);
        self.accumulator.add_efforts(&self.robot.effort_shares(&self.world), dt);
        let samples =
            [self.gripper.sample(&self.world, &gripper, dt)?, self.hand.sample(&self.world, &hand, dt)?];
        let object = self.world.bodies.get(self.object)?;
        let ahead = convert::pose(object.position()).rotation * Vector3::x();
        self.accumulator.add(&samples, (ahead, convert::vector(object.linvel())), (dt, noise));
        self.accumulator.touches.add(&self.world, dt);
        if let Some(observer) = observer {
            observer(&self.step_made(base_rates, samples.map(|sample| sample.wrench), dt)?);
        }
        Some(())
    }

    /// The last physics step, of `dt` seconds, for an observer. `None` if the bodies are gone.
    fn step_made(&self, base_rates: [f64; 3], grips: [Wrench; 2], dt: f64) -> Option<PhysicsStep> {
        let pose = |handle| self.world.bodies.get(handle).map(|body| convert::pose(body.position()));
        let (hand, body) = (pose(self.hand_body)?, self.world.bodies.get(self.hand_body)?);
        let [linear, angular] = [body.linvel(), body.angvel()].map(convert::vector);
        // the hand is level, and turns about z alone
        let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), -angular.z * dt / 2.0) * hand.rotation;
        Some(PhysicsStep {
            time: self.steps as f64 * dt,
            base_rates,
            rests: self.robot.rests(),
            hand,
            hand_velocity: [linear, angular].map(|vector| turned.inverse() * vector),
            torso: pose(self.torso_body)?,
            object: pose(self.object)?,
            grips,
        })
    }

    /// Steps the world such that the arm's motors keep their limits: where one exceeds its own, the step is
    /// made again with this effort. `None` if the result is not sound.
    fn step_within_limits(&mut self, past: &mut Past) -> Option<()> {
        self.world.step();
        self.check()?;
        let iterations = self.world.integration_parameters.num_internal_pgs_iterations;
        let mut before = None;
        for _ in 0..LIMIT_ROUNDS {
            if !self.robot.exceeds(&self.world)? {
                break;
            }
            if before.is_none() {
                before = past.before_step();
            }
            let before = before.as_mut()?;
            // a joint at its limit gives way, and forces take longer to settle
            before.integration_parameters.num_internal_pgs_iterations = LIMITED_ITERATIONS * iterations;
            self.robot.limit(before)?;
            let mut again = copy_of(before);
            // its workspaces are as large as they have to be
            std::mem::swap(&mut again.physics_pipeline, &mut self.world.physics_pipeline);
            self.world = again;
            self.world.step();
            self.check()?;
        }
        self.world.integration_parameters.num_internal_pgs_iterations = iterations;
        Some(())
    }

    /// The pose of the object's front end, and the velocity that the gripper gives it.
    fn sensed_object(&self) -> Option<SensedObject> {
        let world_from_object = convert::pose(self.world.bodies.get(self.object)?.position());
        let end = world_from_object * nalgebra::Point3::new(self.reach, 0.0, 0.0);
        let ahead = world_from_object.rotation * nalgebra::Vector3::x();
        let gripper = self.world.bodies.get(self.robot.gripper().0)?;
        let velocity = convert::vector(gripper.velocity_at_point(convert::to_vector(&end.coords)));
        Some(SensedObject {
            end: PlanarPose { position: Point::new(end.x, end.y), yaw: math::atan2(ahead.y, ahead.x) },
            velocity: velocity.xy(),
            yaw_rate: gripper.angvel().z,
        })
    }

    /// Detects a state that is not finite or diverging, and a dropped object. `None` in the first case:
    /// rapier panics on a multibody with a body that is NaN, and so must not step it.
    fn check(&mut self) -> Option<()> {
        let is_sound = |handle: RigidBodyHandle| {
            self.world.bodies.get(handle).is_some_and(|b| {
                // a NaN is not below the limit
                let is_slow = b.linvel().length() < DIVERGING_SPEED && b.angvel().length() < DIVERGING_SPEED;
                is_slow && b.translation().is_finite() && b.is_enabled()
            })
        };
        let lost = self.robot.bodies().iter().find(|(_, handle)| !is_sound(*handle));
        let lost = lost.map(|(name, _)| name).or((!is_sound(self.object)).then_some(&self.object_name));
        if let Some(body) = lost {
            self.failure = Some(Failure::NonFinite { body: body.clone() });
            return None;
        }
        let lowest = DROPPED_HEIGHT_M.min(DROPPED_SHARE * self.height);
        let low = self.world.bodies.get(self.object)?.translation().z < lowest;
        if low && self.failure.is_none() {
            self.failure = Some(Failure::Dropped);
        }
        Some(())
    }
}

/// A copy of a world that goes on with the same bits. The workspaces of rapier's pipelines are created anew,
/// as when it is read back.
fn copy_of(world: &PhysicsWorld) -> PhysicsWorld {
    PhysicsWorld {
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
    }
}

impl Clone for PhysicalPlant {
    /// A copy that continues independently with the same bits.
    fn clone(&self) -> Self {
        Self {
            world: copy_of(&self.world),
            parts: self.parts.clone(),
            robot: self.robot.clone(),
            object_name: self.object_name.clone(),
            human: self.human.clone(),
            accumulator: self.accumulator.clone(),
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
    fn a_body_that_is_not_finite_is_named_and_stops_the_plant() {
        let mut plant = plant();
        plant.world.bodies[plant.object].set_linvel(Vector::new(f64::NAN, 0.0, 0.0), true);
        let seen = plant.step(&InputVector::zeros(), &HumanCommand::Follow, 0.2);
        let Some(Failure::NonFinite { body }) = seen.failure else { panic!("{:?}", seen.failure) };
        assert_eq!(body, "beam");
        assert_eq!(plant.step(&InputVector::zeros(), &HumanCommand::Follow, 0.2).time, seen.time);
    }

    /// A robot with weak motors, which are at their limits in some steps of a period, or in all, or in none.
    #[test]
    fn a_copy_of_the_world_some_steps_ago_is_as_good_as_one_of_every_step() {
        let text = "name = \"w\"\nrobot_width_m = 0.5\nstart_m = [0, 0]\ntarget_m = [9, 0]\n";
        let world = World::parse("w.toml", text).unwrap();
        let mut robot = Robot::built_in().unwrap();
        for i in 0..robot.joint_count() {
            robot.joints[i].effort_limit *= 0.6;
            let name = robot.joints[i].name.clone();
            let mut joints = robot.links.iter_mut().filter_map(|link| link.joint.as_mut());
            joints.find(|joint| joint.name == name).expect("its joint").limits.effort *= 0.6;
        }
        let team = PlanarPose { position: world.start, yaw: 0.3 };
        let settings = PhysicsSettings::default();
        let start =
            PhysicalPlant::new(&world, &robot, &robot.postures[0].joints, &team, &settings, 1).unwrap();
        let run = |spacing| {
            let mut plant = start.clone();
            let period = |tick: u32| {
                let phase = 0.2 * f64::from(tick);
                let mut rates = InputVector::zeros();
                (rates[0], rates[1]) = (0.5 * math::sin(phase), 0.4 * math::sin(phase));
                for i in 0..robot.joint_count() {
                    rates[2 + i] = 0.4 * math::cos(2.0 * phase + i as f64);
                }
                plant.begin();
                let past = Past::new(spacing);
                let seen = plant.advance_copying(&rates, &HumanCommand::Follow, 0.2, None, past);
                let numbers = seen.object.translation.vector.iter().chain(&seen.joint_efforts);
                (numbers.map(|x| x.to_bits()).collect::<Vec<_>>(), seen.time_at_limit.max())
            };
            (0..40).map(period).collect::<Vec<_>>()
        };
        let every = run(1);
        let limited = |range: std::ops::Range<f64>| every.iter().filter(|(_, s)| range.contains(s)).count();
        let counts = [limited(0.0..0.005), limited(0.005..0.195), limited(0.195..1.0)];
        assert!(counts.iter().all(|count| *count > 0), "{counts:?}");
        for spacing in [SPACING, 7, 100] {
            assert!(run(spacing) == every, "{spacing}");
        }
    }

    #[test]
    fn an_object_on_the_floor_is_dropped() {
        let mut plant = plant();
        plant.world.bodies[plant.object].set_translation(Vector::new(0.0, 0.0, 0.1), true);
        let seen = plant.step(&InputVector::zeros(), &HumanCommand::Follow, 0.2);
        assert_eq!(seen.failure, Some(Failure::Dropped));
    }
}
