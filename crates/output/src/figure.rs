//! The measures of the human figure of the scene and of the 3-D player, m. The body is as tall as the torso of
//! the simulation, 1.7 m.

use crate::palette;
use serde_json::{Value, json};

/// Height of the hips.
pub const HIP: f64 = 0.85;
/// Half the distance of the hips from each other.
pub const HIP_HALF: f64 = 0.095;
/// Length of a thigh.
pub const THIGH: f64 = 0.43;
/// Length of a shin.
pub const SHIN: f64 = 0.42;
/// Height of an ankle on the floor.
pub const ANKLE: f64 = 0.075;
/// The left shoulder, from the floor below the torso.
pub const SHOULDER: [f64; 3] = [-0.06, 0.175, 1.36];
/// Length of an upper arm.
pub const UPPER_ARM: f64 = 0.36;
/// Length of a forearm.
pub const FOREARM: f64 = 0.38;
/// A stride is two steps.
pub const STRIDE: f64 = 0.96;
/// A foot is on the floor for this part of a stride.
pub const STANCE: f64 = 0.62;
/// The largest distance of a hand from the middle of the object's end.
pub const REACH: f64 = 0.28;
/// The distance of a hand from the surface of the object.
pub const GRIP: f64 = 0.012;
/// The limbs of a side that move: name, radius at either end, length, colour.
pub const LIMBS: [(&str, [f64; 2], f64, [u8; 3]); 4] = [
    ("thigh", [0.088, 0.064], THIGH, palette::TROUSERS),
    ("shin", [0.062, 0.047], SHIN, palette::TROUSERS),
    ("upper_arm", [0.066, 0.052], UPPER_ARM, palette::HUMAN),
    ("forearm", [0.043, 0.035], FOREARM, palette::SKIN),
];

/// The measures of the figure, for the 3-D player: hip and shoulder of the left side from the floor below the
/// torso, the stride and the share of it in which a foot is on the floor, and every limb. The player's gait
/// differs: it knows the whole way, and plants the feet on it.
pub fn measures() -> Value {
    let mut measures = json!({
        "hip_m": [0.0, HIP_HALF, HIP],
        "shoulder_m": SHOULDER,
        "ankle_m": ANKLE,
        "stride_m": STRIDE,
        "stance_share": STANCE,
        "reach_m": REACH,
        "grip_m": GRIP,
    });
    for (name, radii, length, _) in LIMBS {
        measures[name] = json!({ "radii_m": radii, "length_m": length });
    }
    measures
}
