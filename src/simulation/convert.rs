//! Poses and vectors of nalgebra in; those of rapier and parry (glam) out, and back. The only file that converts between the two.

use crate::geometry::Pose;
use nalgebra::{Isometry3, IsometryMatrix3, Matrix3, Translation3, UnitQuaternion, Vector3};
use rapier3d::math;

/// A pose for rapier.
pub(super) fn to_rapier(pose: &Pose) -> math::Pose {
    let rotation = UnitQuaternion::from_rotation_matrix(&pose.rotation);
    Isometry3::from_parts(pose.translation, rotation).into()
}

/// A pose of rapier's.
pub(super) fn pose(pose: &math::Pose) -> Pose {
    let rotation: UnitQuaternion<f64> = pose.rotation.into();
    IsometryMatrix3::from_parts(Translation3::from(vector(pose.translation)), rotation.to_rotation_matrix())
}

/// A vector for rapier.
pub(super) fn to_vector(vector: &Vector3<f64>) -> math::Vector {
    math::Vector::new(vector.x, vector.y, vector.z)
}

/// A vector of rapier's.
pub(super) fn vector(vector: math::Vector) -> Vector3<f64> {
    Vector3::new(vector.x, vector.y, vector.z)
}

/// A matrix for rapier.
pub(super) fn to_matrix(matrix: &Matrix3<f64>) -> math::Matrix {
    let column = |i: usize| to_vector(&matrix.column(i).into_owned());
    math::Matrix::from_cols(column(0), column(1), column(2))
}
