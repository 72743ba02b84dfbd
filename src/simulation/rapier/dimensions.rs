//! Gravity, and the size of the human's body.

pub(super) use crate::robot::GRAVITY;

/// Distance of the middle of the torso ahead of the hand, m.
pub const TORSO_AHEAD: f64 = 0.35;
/// Radius of the human's torso, an upright capsule, m.
pub const TORSO_RADIUS: f64 = 0.2;
/// Total height of the human's torso, m.
pub const TORSO_HEIGHT: f64 = 1.7;
/// Radius of the human's hand, a ball, m.
pub const HAND_RADIUS: f64 = 0.04;
