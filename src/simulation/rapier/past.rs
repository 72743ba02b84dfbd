//! The world as it was before a step that has to be made again.
//!
//! To copy a world takes a sixth of what a step takes, and hardly any step is made again. So a copy is kept of
//! a world some steps ago, with what the steps since then were given; they are made again on it when it matters.
//! A copy goes on with the same bits, so this is the world that a copy in every step would have kept.

use super::articulation::Given;
use super::copy_of;
use rapier3d::math::Pose;
use rapier3d::prelude::{PhysicsWorld, RigidBodyHandle};

/// Number of steps after which the world is copied again.
pub(super) const SPACING: usize = 10;

/// The recent past of a world within a control period.
pub(super) struct Past {
    /// Number of steps after which the world is copied again.
    spacing: usize,
    /// The world before a step, with all that it was given.
    copy: Option<PhysicsWorld>,
    /// What the steps after that one were given.
    since: Vec<StepGiven>,
}

/// What a step is given: the poses at its end of the bodies that are moved, and the robot's motors.
pub(super) struct StepGiven {
    pub poses: [(RigidBodyHandle, Pose); 2],
    pub motors: Given,
}

impl StepGiven {
    /// Gives the same to another world in the same state.
    pub fn give(&self, world: &mut PhysicsWorld) -> Option<()> {
        for (body, pose) in self.poses {
            world.bodies.get_mut(body)?.set_next_kinematic_position(pose);
        }
        self.motors.give(world)
    }
}

impl Past {
    pub fn new(spacing: usize) -> Self {
        Self { spacing, copy: None, since: Vec::new() }
    }

    /// Keeps what is needed to come back to a world that is about to be stepped, and was given this for it.
    pub fn keep(&mut self, world: &PhysicsWorld, given: impl FnOnce() -> Option<StepGiven>) -> Option<()> {
        if self.copy.is_none() || self.since.len() + 1 >= self.spacing {
            self.copy = Some(copy_of(world));
            self.since.clear();
        } else {
            self.since.push(given()?);
        }
        Some(())
    }

    /// The world that was kept last, before its step. From now on every step is kept as a copy: where a motor
    /// is at its limit, it often stays there.
    pub fn before_step(&mut self) -> Option<PhysicsWorld> {
        let mut world = self.copy.take()?;
        for given in self.since.drain(..) {
            world.step();
            given.give(&mut world)?;
        }
        self.spacing = 1;
        Some(world)
    }
}
