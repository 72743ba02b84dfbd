//! Conversions between nalgebra and the types of rapier and parry (glam). No other file converts between the
//! two.

use crate::geometry::Pose;
use nalgebra::{Isometry3, IsometryMatrix3, Matrix3, Translation3, UnitQuaternion, Vector3};
use rapier3d::math;

/// A pose as rapier's type.
pub(super) fn to_rapier(pose: &Pose) -> math::Pose {
    let rotation = UnitQuaternion::from_rotation_matrix(&pose.rotation);
    Isometry3::from_parts(pose.translation, rotation).into()
}

/// The next pose of a kinematic body at `at`. Two quaternions represent the same rotation; this is the nearer
/// one. Rapier takes the difference of quaternions for a rotation, so the farther one would be a full turn in
/// a single step.
pub(super) fn to_rapier_from(at: &math::Pose, pose: &Pose) -> math::Pose {
    let mut next = to_rapier(pose);
    if next.rotation.dot(at.rotation) < 0.0 {
        next.rotation = -next.rotation;
    }
    next
}

/// A pose from rapier's type.
pub(super) fn pose(pose: &math::Pose) -> Pose {
    let rotation: UnitQuaternion<f64> = pose.rotation.into();
    IsometryMatrix3::from_parts(Translation3::from(vector(pose.translation)), rotation.to_rotation_matrix())
}

/// A vector as rapier's type.
pub(super) fn to_vector(vector: &Vector3<f64>) -> math::Vector {
    math::Vector::new(vector.x, vector.y, vector.z)
}

/// A vector from rapier's type.
pub(super) fn vector(vector: math::Vector) -> Vector3<f64> {
    Vector3::new(vector.x, vector.y, vector.z)
}

/// A matrix as rapier's type.
pub(super) fn to_matrix(matrix: &Matrix3<f64>) -> math::Matrix {
    let column = |i: usize| to_vector(&matrix.column(i).into_owned());
    math::Matrix::from_cols(column(0), column(1), column(2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{PlanarPose, Point};

    #[test]
    fn a_full_turn_never_happens_in_one_step() {
        let turned = |degrees: i32| {
            let yaw = crate::geometry::wrap_angle(f64::from(degrees).to_radians());
            PlanarPose { position: Point::origin(), yaw }.at_height(0.7)
        };
        for direction in [1, -1] {
            let mut at = to_rapier(&turned(0));
            for degrees in 1..=1080 {
                let next = to_rapier_from(&at, &turned(direction * degrees));
                assert!(next.rotation.dot(at.rotation) > 0.9999, "{degrees}");
                at = next;
            }
        }
    }
}
