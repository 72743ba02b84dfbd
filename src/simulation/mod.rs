//! Simulation of the bodies under control: exact kinematics, or dynamics with contacts.

mod convert;
mod kinematic;
mod rapier;

pub use kinematic::KinematicPlant;
pub(crate) use rapier::sample;
pub use rapier::{
    BodyKind, BodyModel, Clearance, Clearances, Contact, ContactGroup, Failure, Forces, GripModel,
    HAND_RADIUS, HumanCommand, HumanSettings, JointModel, Observation, Part, PhysicalPlant, PhysicsSettings,
    PhysicsStep, PlantModel, Sharing, TORSO_AHEAD, TORSO_HEIGHT, TORSO_RADIUS, Wrench, motive_and_internal,
};
