//! The robot as a rapier multibody that follows commanded rates with limited efforts.
//!
//! The base is a planar joint with dampers as motors: it moves as its drive does, so never sideways if that has
//! two driven sides. The arm's motors are springs and dampers that follow an integrated position reference
//! with the commanded rate. All are part of the multibody's own equations, which are solved exactly;
//! rapier's motor constraints would need hundreds of solver iterations to hold up an object that outweighs
//! the wrist. Links have no weight: gravity compensation is assumed perfect, so the motors carry only the
//! object and the dynamics.

use super::base_motor::BaseMotor;
use super::clusters::{Cluster, clusters, moving};
use super::motor::{Motor, joint_data};
use super::parts::{Group, Parts};
use super::ramp::Ramp;
use super::{BodyKind, PhysicsSettings};
use crate::geometry::{PlanarPose, Point, Pose, Vector, direction, left_of, wrap_angle};
use crate::robot::{
    BaseInput, BaseTwist, Configuration, Drive, DriveKind, InputVector, JointVector, MAX_JOINTS, Robot,
    without_last,
};
use crate::simulation::convert::{self, to_matrix, to_vector};
use rapier3d::prelude::{
    GenericJointBuilder, JointAxesMask, MassProperties, MultibodyJointHandle, PhysicsWorld, RigidBodyBuilder,
    RigidBodyHandle,
};
use serde::{Deserialize, Serialize};

/// The base's motors: the largest force along each axis (N) and torque (Nm), which the wheels' grip on the
/// floor bears.
pub(super) const BASE_FORCE: f64 = 800.0;
pub(super) const BASE_TORQUE: f64 = 400.0;

/// The robot as a multibody of rapier.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Articulation {
    drive: MultibodyJointHandle,
    /// The base's motors along x and y in the world, and about z.
    base_motors: [BaseMotor; 3],
    motors: Vec<Motor>,
    /// The body of every cluster with the name of its first link, for failure messages.
    bodies: Vec<(String, RigidBodyHandle)>,
    /// For every link of the robot, its body and its pose in the body.
    links: Vec<(RigidBodyHandle, Pose)>,
    /// The body that holds the object, and the grasp's pose in it.
    gripper: (RigidBodyHandle, Pose),
    /// Reference positions of the arm's joints.
    reference: JointVector,
    /// Reference rates of base and joints.
    ramp: Ramp,
    #[serde(with = "without_last")]
    rate_limits: InputVector,
    /// Present reference inputs of the base; the wheels' motors change them with limited acceleration.
    #[serde(rename = "rims", with = "without_last")]
    base: BaseInput,
    rim_acceleration: f64,
    track: f64,
    wheel_radius: f64,
    /// See [`Observation::rolled`](super::Observation::rolled).
    #[serde(rename = "wheel_angles", with = "without_last")]
    rolled: BaseInput,
    /// Radius of an omnidirectional base, m; none for a drive with two driven sides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    omnidirectional: Option<f64>,
}

/// What the motors are given for a step, the joints' stops included.
pub(super) struct Given {
    drive: MultibodyJointHandle,
    base: [BaseMotor; 3],
    motors: Vec<(Motor, JointAxesMask)>,
}

impl Given {
    /// Gives the same to another world in the same state.
    pub fn give(&self, world: &mut PhysicsWorld) -> Option<()> {
        self.base.iter().try_for_each(|motor| motor.set(world, self.drive))?;
        self.motors.iter().try_for_each(|(motor, stop)| motor.apply(world, *stop))
    }
}

/// The measured state of a robot.
pub(super) struct Measured {
    pub configuration: Configuration,
    pub base_rates: BaseInput,
    pub joint_rates: JointVector,
    pub joint_efforts: JointVector,
}

impl Articulation {
    /// Adds a robot to a world.
    pub fn new(
        world: &mut PhysicsWorld,
        parts: &mut Parts,
        robot: &Robot,
        start: &Configuration,
        settings: &PhysicsSettings,
    ) -> Option<Self> {
        let anchor = world.insert_body(RigidBodyBuilder::fixed());
        let clusters = clusters(robot);
        let mut motors = Vec::new();
        let mut handles: Vec<RigidBodyHandle> = Vec::with_capacity(clusters.len());
        let mut drive = None;
        for cluster in &clusters {
            let body = insert(world, parts, robot, cluster);
            match (cluster.parent, moving(robot, cluster.link)) {
                (Some((parent, frame)), Some((joint, driver))) => {
                    let data = joint_data(joint, &robot.joints[driver], frame);
                    let handle = world.multibody_joints.insert(handles[parent], body, data, true)?;
                    motors.push(Motor::new(handle, joint, (driver, start.joints[driver]), robot));
                }
                _ => {
                    let planar = JointAxesMask::LIN_Z | JointAxesMask::ANG_X | JointAxesMask::ANG_Y;
                    let data = GenericJointBuilder::new(planar).contacts_enabled(false).build();
                    drive = Some(world.multibody_joints.insert(anchor, body, data, true)?);
                }
            }
            handles.push(body);
        }
        let drive = drive?;
        let mut links = vec![(handles[0], Pose::identity()); robot.links.len()];
        for (cluster, handle) in clusters.iter().zip(&handles) {
            for (link, at) in &cluster.links {
                links[*link] = (*handle, *at);
            }
        }
        let (mass, inertia) = moved(robot, start);
        let articulation = Self {
            drive,
            base_motors: [
                BaseMotor::new((0, 0), BASE_FORCE, mass),
                BaseMotor::new((1, 1), BASE_FORCE, mass),
                BaseMotor::new((5, 2), BASE_TORQUE, inertia),
            ],
            motors,
            bodies: clusters
                .iter()
                .zip(&handles)
                .map(|(c, handle)| (robot.links[c.link].name.clone(), *handle))
                .collect(),
            gripper: links[robot.grasp_link],
            links,
            reference: start.joints,
            ramp: Ramp::new(),
            rate_limits: robot.input_limits(),
            base: BaseInput::zeros(),
            rim_acceleration: settings.rim_acceleration,
            track: robot.drive.track,
            wheel_radius: robot.drive.wheel_radius,
            rolled: BaseInput::zeros(),
            omnidirectional: robot.drive.is_omnidirectional().then_some(robot.drive.base_radius),
        };
        articulation.settle(world, start)?;
        Some(articulation)
    }

    /// Moves the multibody to its initial configuration.
    fn settle(&self, world: &mut PhysicsWorld, start: &Configuration) -> Option<()> {
        let ids = |handle: MultibodyJointHandle| world.multibody_joints.get(handle).map(|(_, id)| id);
        let drive = ids(self.drive)?;
        let ids_of_motors: Vec<usize> = self.motors.iter().map(|m| ids(m.handle)).collect::<Option<_>>()?;
        let (body, _) = world.multibody_joints.get_mut(self.drive)?;
        body.set_self_contacts_enabled(false);
        // this sets the type of the root before degrees of freedom are counted
        body.forward_kinematics(&world.bodies, true);
        let mut positions = vec![0.0; body.ndofs()];
        let first = body.link(drive)?.assembly_id();
        let PlanarPose { position, yaw } = start.base;
        positions.get_mut(first..first + 3)?.copy_from_slice(&[position.x, position.y, yaw]);
        for (motor, id) in self.motors.iter().zip(&ids_of_motors) {
            *positions.get_mut(body.link(*id)?.assembly_id())? =
                motor.ratio * start.joints[motor.joint] + motor.offset;
        }
        body.apply_displacements(&positions);
        body.forward_kinematics(&world.bodies, false);
        body.update_rigid_bodies(&mut world.bodies, true);
        // by default rapier adds 0.1 Nms/rad to every joint
        body.damping_mut().fill(0.0);
        body.damping_mut().rows_mut(first, 3).fill(BaseMotor::DAMPING);
        for (motor, id) in self.motors.iter().zip(ids_of_motors) {
            let first = body.link(id)?.assembly_id();
            *body.damping_mut().get_mut(first)? = motor.damping;
        }
        Some(())
    }

    /// Sets the mean rates of a control period of `steps` physics steps, clamped to the robot's limits.
    pub fn command(&mut self, rates: &InputVector, steps: u64) {
        let rates = rates.zip_map(&self.rate_limits, |rate, limit| rate.clamp(-limit, limit));
        self.ramp.begin(&rates, &self.rate_limits, steps);
    }

    /// Sets all motors for a step of `dt` seconds. Returns the rates that the base's motors shall keep: along x
    /// and y of the world, m/s, and about z, rad/s. `None` if the bodies are gone.
    pub fn drive(&mut self, world: &mut PhysicsWorld, dt: f64) -> Option<[f64; 3]> {
        let wanted = self.ramp.next();
        let drive = self.of_drive();
        let most = drive.accelerations(self.rim_acceleration) * dt;
        for (i, rate) in self.base.iter_mut().enumerate().take(drive.inputs()) {
            *rate += (wanted[i] - *rate).clamp(-most[i], most[i]);
        }
        let BaseTwist { velocity, turn } = drive.twist(&self.base);
        let first = drive.inputs();
        let (body, id) = world.multibody_joints.get(self.drive)?;
        let heading = body.link(id)?.joint().coords()[5];
        // the heading at the middle of the step
        let ahead = direction(heading + turn * dt / 2.0);
        let mut in_world = ahead * velocity.x;
        if self.omnidirectional.is_some() {
            in_world += left_of(ahead) * velocity.y;
        }
        let base_rates = [in_world.x, in_world.y, turn];
        for (motor, rate) in self.base_motors.iter_mut().zip(base_rates) {
            motor.drive(world, self.drive, rate, dt)?;
        }

        let rates = wanted.fixed_rows::<MAX_JOINTS>(first).into_owned();
        self.reference += rates * dt;
        let geared = self.geared(world);
        let mut states = [[0.0; 2]; MAX_JOINTS];
        for motor in self.motors.iter_mut().filter(|m| m.is_own) {
            let j = motor.joint;
            states[j] = motor.state(world)?.into();
            motor.drive(world, &mut self.reference[j], rates[j], geared[j], dt)?;
        }
        for gear in self.motors.iter_mut().filter(|m| !m.is_own) {
            gear.follow(world, states[gear.joint], dt)?;
        }
        Some(base_rates)
    }

    /// The rest positions of the arm's motors in the last step, rad or m.
    pub fn rests(&self) -> JointVector {
        let mut rests = JointVector::zeros();
        for motor in self.motors.iter().filter(|m| m.is_own) {
            rests[motor.joint] = motor.rest;
        }
        rests
    }

    /// Whether the step that has been made, after which the world is `after`, has to be made again: a motor
    /// exceeded its limit in it.
    pub fn exceeds(&mut self, after: &PhysicsWorld) -> Option<bool> {
        let geared = self.geared(after);
        let mut is_again = false;
        for motor in self.motors.iter_mut().filter(|m| m.is_own) {
            is_again |= motor.limit(motor.state(after)?, geared[motor.joint]);
        }
        Some(is_again)
    }

    /// Sets the motors for a step that has to be made again from `before`.
    pub fn limit(&self, before: &mut PhysicsWorld) -> Option<()> {
        self.motors.iter().try_for_each(|motor| motor.set(before))
    }

    /// What the motors were given for the step that this world is about to make.
    pub fn given(&self, world: &PhysicsWorld) -> Option<Given> {
        let motors = self.motors.iter().map(|motor| Some((*motor, motor.stop(world)?)));
        Some(Given { drive: self.drive, base: self.base_motors, motors: motors.collect::<Option<_>>()? })
    }

    /// The load of every motor by the gears of mimicking joints in the last step, Nm or N.
    fn geared(&self, world: &PhysicsWorld) -> JointVector {
        let mut geared = JointVector::zeros();
        for gear in self.motors.iter().filter(|m| !m.is_own) {
            let effort = gear.state(world).map_or(0.0, |(at, rate)| gear.effort(at, rate));
            geared[gear.joint] += gear.ratio * effort;
        }
        geared
    }

    /// Turns the wheels after a step of `dt` seconds.
    pub fn roll(&mut self, world: &PhysicsWorld, dt: f64) {
        let rates = self.base_rates(world);
        // as one expression, for the bits of earlier recordings
        let per = if self.omnidirectional.is_some() { 1.0 } else { self.wheel_radius };
        self.rolled = self.rolled.zip_map(&rates, |rolled, rate| rolled + rate * dt / per);
    }

    /// See [`Observation::rolled`](super::Observation::rolled).
    pub fn rolled(&self) -> BaseInput {
        self.rolled
    }

    /// The drive, as far as its motion depends on it.
    fn of_drive(&self) -> Drive {
        let kind = match self.omnidirectional {
            Some(_) => DriveKind::Omnidirectional,
            None => DriveKind::Differential,
        };
        let (track, wheel_radius) = (self.track, self.wheel_radius);
        let base_radius = self.omnidirectional.unwrap_or(1.0);
        Drive { kind, track, wheel_radius, rim_speed_limit: 0.0, turn_rate_limit: 0.0, base_radius }
    }

    /// The measured state.
    pub fn measure(&self, world: &PhysicsWorld) -> Measured {
        let mut joints = JointVector::zeros();
        let mut joint_rates = JointVector::zeros();
        let mut joint_efforts = self.geared(world);
        for motor in self.motors.iter().filter(|m| m.is_own) {
            let Some((position, rate)) = motor.state(world) else { continue };
            let j = motor.joint;
            (joints[j], joint_rates[j]) = (position, rate);
            joint_efforts[j] += motor.effort(position, rate);
        }
        let configuration = Configuration { base: self.base(world), joints };
        Measured { configuration, base_rates: self.base_rates(world), joint_rates, joint_efforts }
    }

    /// The efforts of the joints' motors in the last step as shares of their limits.
    pub fn effort_shares(&self, world: &PhysicsWorld) -> JointVector {
        let geared = self.geared(world);
        let mut shares = JointVector::zeros();
        for motor in self.motors.iter().filter(|m| m.is_own) {
            let Some((at, rate)) = motor.state(world) else { continue };
            shares[motor.joint] = motor.share(motor.effort(at, rate) + geared[motor.joint]);
        }
        shares
    }

    /// `world_from_grasp`.
    pub fn grasp(&self, world: &PhysicsWorld) -> Pose {
        let (body, at) = self.gripper;
        world.bodies.get(body).map_or(Pose::identity(), |b| convert::pose(b.position()) * at)
    }

    /// `world_from_link` of every link, in the order of the robot's links.
    pub fn link_poses(&self, world: &PhysicsWorld) -> Vec<Pose> {
        let pose =
            |handle| world.bodies.get(handle).map_or(Pose::identity(), |b| convert::pose(b.position()));
        self.links.iter().map(|(handle, at)| pose(*handle) * at).collect()
    }

    /// The body that holds the object, and the grasp's pose in it.
    pub fn gripper(&self) -> (RigidBodyHandle, Pose) {
        self.gripper
    }

    /// The bodies with the names of their first links.
    pub fn bodies(&self) -> &[(String, RigidBodyHandle)] {
        &self.bodies
    }

    fn base(&self, world: &PhysicsWorld) -> PlanarPose {
        let at = world.multibody_joints.get(self.drive).and_then(|(body, id)| body.link(id));
        let coords = at.map_or([0.0; 6], |link| link.joint().coords());
        PlanarPose { position: Point::new(coords[0], coords[1]), yaw: wrap_angle(coords[5]) }
    }

    fn base_rates(&self, world: &PhysicsWorld) -> BaseInput {
        let Some((body, id)) = world.multibody_joints.get(self.drive) else { return BaseInput::zeros() };
        let Some(link) = body.link(id) else { return BaseInput::zeros() };
        let rates = body.joint_velocity(link);
        let (in_world, ahead) = (Vector::new(rates[0], rates[1]), direction(link.joint().coords()[5]));
        let velocity = Vector::new(in_world.dot(&ahead), in_world.dot(&left_of(ahead)));
        self.of_drive().input(&BaseTwist { velocity, turn: rates[2] })
    }
}

/// Adds the body of a cluster with the shapes of its links.
fn insert(world: &mut PhysicsWorld, parts: &mut Parts, robot: &Robot, cluster: &Cluster) -> RigidBodyHandle {
    let mass = MassProperties::with_inertia_matrix(
        to_vector(&cluster.center),
        cluster.mass,
        to_matrix(&cluster.inertia),
    );
    let body =
        RigidBodyBuilder::dynamic().additional_mass_properties(mass).gravity_scale(0.0).can_sleep(false);
    let body = world.insert_body(body);
    let group = if cluster.parent.is_none() { Group::Base } else { Group::Arm };
    for (link, cluster_from_link) in &cluster.links {
        let link = &robot.links[*link];
        parts.add_link(world, body, link, cluster_from_link, (BodyKind::Robot, group));
    }
    body
}

/// Mass (kg) of a robot, and its inertia (kg m^2) about the base's upright axis in a configuration.
fn moved(robot: &Robot, start: &Configuration) -> (f64, f64) {
    let at = PlanarPose { position: Point::origin(), yaw: 0.0 };
    let poses = robot.link_poses(&Configuration { base: at, joints: start.joints });
    clusters(robot).iter().fold((0.0, 0.0), |(mass, inertia), cluster| {
        let pose = if cluster.parent.is_none() { Pose::identity() } else { poses[cluster.link] };
        let away = (pose * nalgebra::Point3::from(cluster.center)).xy().coords.norm_squared();
        let turned = pose.rotation.matrix() * cluster.inertia * pose.rotation.matrix().transpose();
        (mass + cluster.mass, inertia + turned[(2, 2)] + cluster.mass * away)
    })
}
