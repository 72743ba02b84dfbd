//! A grip: a six-dimensional spring-damper between two bodies, and the wrench that it exerts.

use super::Wrench;
use super::dimensions::GRAVITY;
use crate::geometry::Pose;
use crate::simulation::convert::{self, to_rapier};
use nalgebra::{Rotation3, Vector3};
use rapier3d::prelude::{
    GenericJointBuilder, ImpulseJointHandle, JointAxesMask, JointAxis, MotorModel, PhysicsWorld,
    RigidBodyHandle,
};
use serde::{Deserialize, Serialize};

const LINEAR: [JointAxis; 3] = [JointAxis::LinX, JointAxis::LinY, JointAxis::LinZ];
const ANGULAR: [JointAxis; 3] = [JointAxis::AngX, JointAxis::AngY, JointAxis::AngZ];

/// Stiffness of a grip.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stiffness {
    /// Linear stiffness, N/m.
    pub linear: f64,
    /// rapier's coefficient of the angular springs, Nm/rad: their stiffness, and twice that at a link of a
    /// multibody, where its springs follow the sine of half the angle.
    pub angular: f64,
    /// Largest force, N, and torque, Nm.
    pub most: [f64; 2],
}

impl Stiffness {
    /// Linear (Ns/m) and angular (Nms/rad) damping that is critical for a `load` (kg) at one end.
    pub fn damping(&self, load: f64) -> [f64; 2] {
        let linear = 2.0 * (self.linear * load).sqrt();
        [linear, linear * self.angular / self.linear]
    }

    /// Rest position of the upward spring, m, such that a `load` (kg) does not sag.
    pub fn rest(&self, load: f64) -> f64 {
        load * GRAVITY / self.linear
    }

    /// The robot's gripper, of a linear stiffness. It holds a link: its angular stiffness is half of the
    /// coefficient, 500 Nm/rad by default.
    pub fn of_gripper(linear: f64) -> Self {
        Self { linear, angular: 1000.0 * (linear / 20_000.0), most: [2000.0, 400.0] }
    }

    /// The human's hand, of a linear stiffness.
    pub fn of_hand(linear: f64) -> Self {
        Self { linear, angular: 10.0 * (linear / 1200.0), most: [500.0, 100.0] }
    }
}

/// A grip on the object.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Grip {
    joint: ImpulseJointHandle,
    holder: RigidBodyHandle,
    object: RigidBodyHandle,
    holder_from_grip: Pose,
    object_from_grip: Pose,
}

/// A sample of the wrench and the motion at a grip.
pub(super) struct WrenchSample {
    /// Wrench on the object, in world axes.
    pub wrench: Wrench,
    /// Velocity of the object at the grip.
    pub velocity: Vector3<f64>,
    /// Angular velocity of the object.
    pub turning: Vector3<f64>,
    /// Distance between the two points joined, m.
    pub deflection: f64,
}

impl WrenchSample {
    /// Work done on the object in a step of `dt` seconds, J.
    pub fn work(&self, dt: f64) -> f64 {
        (self.wrench.force.dot(&self.velocity) + self.wrench.torque.dot(&self.turning)) * dt
    }
}

impl Grip {
    /// A grip whose springs are preloaded by the weight of `load` (kg), so that the object does not sag.
    pub fn new(
        world: &mut PhysicsWorld,
        (holder, holder_from_grip): (RigidBodyHandle, Pose),
        (object, object_from_grip): (RigidBodyHandle, Pose),
        stiffness: Stiffness,
        load: f64,
    ) -> Self {
        let Stiffness { linear, angular, most } = stiffness;
        let [damping, angular_damping] = stiffness.damping(load);
        let mut joint = GenericJointBuilder::new(JointAxesMask::empty())
            .contacts_enabled(false)
            .local_frame1(to_rapier(&holder_from_grip))
            .local_frame2(to_rapier(&object_from_grip));
        for axis in LINEAR {
            let rest = if axis == JointAxis::LinZ { stiffness.rest(load) } else { 0.0 };
            joint = joint
                .motor_model(axis, MotorModel::ForceBased)
                .motor_position(axis, rest, linear, damping)
                .motor_max_force(axis, most[0]);
        }
        for axis in ANGULAR {
            joint = joint
                .motor_model(axis, MotorModel::ForceBased)
                .motor_position(axis, 0.0, angular, angular_damping)
                .motor_max_force(axis, most[1]);
        }
        let joint = world.impulse_joints.insert(holder, object, joint.build(), true);
        Self { joint, holder, object, holder_from_grip, object_from_grip }
    }

    /// The axes for the next step: the holder's, in the world. `None` if the holder no longer exists.
    pub fn axes(&self, world: &PhysicsWorld) -> Option<Rotation3<f64>> {
        let holder = world.bodies.get(self.holder)?;
        Some((convert::pose(holder.position()) * self.holder_from_grip).rotation)
    }

    /// The sample of the last step, of `dt` seconds, which began with these axes. `None` if the bodies no
    /// longer exist.
    pub fn sample(&self, world: &PhysicsWorld, axes: &Rotation3<f64>, dt: f64) -> Option<WrenchSample> {
        let joint = world.impulse_joints.get(self.joint)?;
        let holder = world.bodies.get(self.holder)?;
        let object = world.bodies.get(self.object)?;
        let world_from_grip = convert::pose(holder.position()) * self.holder_from_grip;
        let at = convert::pose(object.position()) * self.object_from_grip;
        // rapier assigns the impulse to the first body; springs are motors
        let impulse = |i: usize| -(joint.impulses[i] + joint.data.motors[i].impulse) / dt;
        let angular = |i: usize| -joint.data.motors[3 + i].impulse / dt;
        Some(WrenchSample {
            wrench: Wrench {
                force: axes * Vector3::new(impulse(0), impulse(1), impulse(2)),
                torque: axes * Vector3::new(angular(0), angular(1), angular(2)),
            },
            velocity: convert::vector(object.velocity_at_point(convert::to_vector(&at.translation.vector))),
            turning: convert::vector(object.angvel()),
            deflection: (at.translation.vector - world_from_grip.translation.vector).norm(),
        })
    }
}
