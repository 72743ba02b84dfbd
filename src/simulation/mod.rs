//! Simulation of the bodies under control: exact kinematics, or dynamics with contacts.

mod convert;
mod kinematic;
mod rapier;

pub use kinematic::KinematicPlant;
pub(crate) use rapier::sample;
pub use rapier::{
    BodyKind, Clearance, Clearances, Contact, Failure, Forces, HAND_RADIUS, HumanCommand, HumanSettings,
    Observation, Part, PhysicalPlant, PhysicsSettings, TORSO_AHEAD, TORSO_HEIGHT, TORSO_RADIUS, Wrench,
};
