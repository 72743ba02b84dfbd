//! The motor of one degree of freedom of the base: a damper toward a wanted rate with a limited force.
//!
//! It is part of the multibody's own equations, as the arm's motors are. Motor constraints in its place
//! take longer, and couple with the grip only as well as the solver converges.

use rapier3d::prelude::{MultibodyJointHandle, PhysicsWorld};
use serde::{Deserialize, Serialize};

/// Damping per unit of velocity, Ns/m or Nms/rad.
const DAMPING: f64 = 100_000.0;
/// Stiffness of the spring whose rest position runs ahead, so that it is a damper, N/m or Nm/rad.
const STIFFNESS: f64 = 100_000.0;

/// A motor of the base.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct BaseMotor {
    /// Index of its position in rapier's coordinates, and of its rate among those of the joint.
    coordinate: usize,
    dof: usize,
    /// Largest force, N, or torque, Nm.
    most: f64,
    /// The inertia that it moves, kg or kg m^2.
    inertia: f64,
    /// Rest position of the spring and rate of the base, as in the last step.
    rest: Option<f64>,
    rate: f64,
}

impl BaseMotor {
    /// Damping of the degree of freedom, Ns/m or Nms/rad.
    pub const DAMPING: f64 = DAMPING;

    /// Force per difference between the wanted rate and that at the end of a step of `dt` seconds, Ns/m or
    /// Nms/rad.
    pub fn gain(dt: f64) -> f64 {
        DAMPING + STIFFNESS * dt
    }

    /// A motor at rest.
    pub fn new((coordinate, dof): (usize, usize), most: f64, inertia: f64) -> Self {
        Self { coordinate, dof, most, inertia, rest: None, rate: 0.0 }
    }

    /// Sets the motor for a step of `dt` seconds toward a rate. Its force follows from the rate at the end of
    /// the step; it is limited as if everything else pushes as in the last step. `None` if the body is gone.
    pub fn drive(
        &mut self,
        world: &mut PhysicsWorld,
        handle: MultibodyJointHandle,
        wanted: f64,
        dt: f64,
    ) -> Option<()> {
        let (body, id) = world.multibody_joints.get(handle)?;
        let link = body.link(id)?;
        let position = link.joint().coords()[self.coordinate];
        let rate = *body.joint_velocity(link).get(self.dof)?;
        let last = self.rest.map_or(0.0, |rest| STIFFNESS * (rest - position) - DAMPING * rate);
        let load = self.inertia * (rate - self.rate) / dt - last;
        let target = self.limited(wanted, rate, load, dt);
        let rest = position + target * (dt + DAMPING / STIFFNESS);
        (self.rest, self.rate) = (Some(rest), rate);
        self.set(world, handle)
    }

    /// Gives the spring to rapier.
    pub fn set(&self, world: &mut PhysicsWorld, handle: MultibodyJointHandle) -> Option<()> {
        let (body, id) = world.multibody_joints.get_mut(handle)?;
        body.link_mut(id)?.joint.set_spring(self.coordinate, STIFFNESS, self.rest?);
        Some(())
    }

    /// The rate to aim at, such that the force stays within its limit: `wanted`, unless that takes more.
    fn limited(&self, wanted: f64, rate: f64, load: f64, dt: f64) -> f64 {
        let (damping, gain) = (Self::gain(dt), dt / self.inertia);
        // force = damping (wanted - next), next = rate + gain (force + load)
        let force = damping * (wanted - rate - gain * load) / (1.0 + damping * gain);
        let within = force.clamp(-self.most, self.most);
        if within == force { wanted } else { rate + gain * (within + load) + within / damping }
    }
}
