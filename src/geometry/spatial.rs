//! Planar and spatial poses and rotation vectors.

use super::{Point, angle_of};
use crate::math;
use nalgebra::{IsometryMatrix3, Rotation3, UnitQuaternion, Vector3};

/// A pose in space, `target_from_source`: rotation matrix and translation (m).
pub type Pose = IsometryMatrix3<f64>;

/// A position in the plane with a heading.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct PlanarPose {
    /// Position, m, world frame.
    pub position: Point,
    /// Heading, rad, counter-clockwise from the world's x.
    pub yaw: f64,
}

impl PlanarPose {
    /// A pose in space, `world_from_it`, as seen from above: its position, and the heading of its x axis.
    pub fn from_above(world_from_it: &Pose) -> Self {
        let ahead = world_from_it.rotation * Vector3::x();
        Self { position: world_from_it.translation.vector.xy().into(), yaw: angle_of(ahead.xy()) }
    }

    /// The level pose in space at this position, `height` (m) above the floor.
    pub fn at_height(&self, height: f64) -> Pose {
        let translation = Vector3::new(self.position.x, self.position.y, height);
        let mut rotation = Rotation3::identity();
        turn_about_z(&mut rotation, self.yaw);
        Pose::from_parts(translation.into(), rotation)
    }
}

/// Turns a rotation by `angle` (rad) about its own z.
#[inline]
pub fn turn_about_z(rotation: &mut Rotation3<f64>, angle: f64) {
    let (sin, cos) = math::sin_cos(angle);
    let turned = rotation.matrix_mut_unchecked();
    for row in 0..3 {
        let (x, y) = (turned[(row, 0)], turned[(row, 1)]);
        turned[(row, 0)] = x * cos + y * sin;
        turned[(row, 1)] = y * cos - x * sin;
    }
}

/// The rotation vector (axis times angle in [0, pi], rad) of a rotation, which is its logarithm. Exact to
/// rounding for any angle.
pub fn rotation_vector(rotation: &Rotation3<f64>) -> Vector3<f64> {
    let m = rotation.matrix();
    let sine = Vector3::new(m.m32 - m.m23, m.m13 - m.m31, m.m21 - m.m12) / 2.0;
    let (sin, cos) = (sine.norm(), (m.trace() - 1.0) / 2.0);
    // near half a turn `sine` loses the axis; the quaternion still has it
    if cos < -0.9 {
        return UnitQuaternion::from_rotation_matrix(rotation).scaled_axis();
    }
    if sin < 0.03 {
        // the arcsine's series; its next term is below rounding
        let square = sin * sin;
        let series = 15.0 / 336.0 + square * (105.0 / 3456.0);
        return sine * (1.0 + square * (1.0 / 6.0 + square * (3.0 / 40.0 + square * series)));
    }
    sine * (math::atan2(sin, cos) / sin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_the_logarithm_undoes_the_exponential() {
        let axis = Vector3::new(1.0, -2.0, 0.5).normalize();
        for angle in [0.0, 1e-13, 1e-9, 1e-3, 0.4, 1.5, 2.6, 2.7, 3.0, 3.13] {
            let back = rotation_vector(&Rotation3::new(axis * angle));
            assert!((back - axis * angle).norm() < 1e-12, "{angle}: {}", (back - axis * angle).norm());
        }
    }
}
