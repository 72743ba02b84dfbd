//! Commands in; the state of the world one period later out. A plant is what the controller acts on.

mod kinematic;

pub use kinematic::KinematicPlant;
