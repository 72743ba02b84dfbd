//! Planar and spatial geometry: points, poses, outlines, paths.
//!
//! All coordinates are metres in the world frame (x right, y up, angles counter-clockwise in radians).

use crate::math;

mod bend;
mod footprint;
mod nearby;
mod outline;
mod path;
mod separation;
mod solid;
mod spatial;
mod tandem;
mod turning;
mod widening;

pub use bend::Bend;
pub use footprint::{Bounds, Footprint};
pub use nearby::Nearby;
pub use outline::{Corner, Outline, RingFault};
pub use path::{Path, Piece};
pub use separation::{Placed, Witness, convex_hull, with_fewer_corners};
pub use solid::Solid;
pub use spatial::{PlanarPose, Pose, rotation_vector, turn_about_z};
pub use tandem::{Tandem, nearest, nearest_between};
pub use turning::{Arc, write_turn_onto};
pub use widening::Widening;

/// A point of the plane, metres in the world frame.
pub type Point = nalgebra::Point2<f64>;
/// A displacement or direction of the plane, world frame.
pub type Vector = nalgebra::Vector2<f64>;

/// `v` turned a quarter to the left (counter-clockwise).
pub fn left_of(v: Vector) -> Vector {
    Vector::new(-v.y, v.x)
}

/// The unit vector at `angle` (rad).
pub fn direction(angle: f64) -> Vector {
    let (sin, cos) = math::sin_cos(angle);
    Vector::new(cos, sin)
}

/// The angle of `v` in (-pi, pi], rad.
pub fn angle_of(v: Vector) -> f64 {
    math::atan2(v.y, v.x)
}

/// `angle` wrapped into (-pi, pi], rad.
pub fn wrap_angle(angle: f64) -> f64 {
    let wrapped = angle.rem_euclid(std::f64::consts::TAU);
    if wrapped > std::f64::consts::PI { wrapped - std::f64::consts::TAU } else { wrapped }
}

/// The z component of `a x b`: positive where `b` lies to the left of `a`.
pub fn cross(a: Vector, b: Vector) -> f64 {
    a.x * b.y - a.y * b.x
}

/// The point of the segment from `a` to `b` that is nearest to `p`.
pub fn nearest_on_segment(p: Point, a: Point, b: Point) -> Point {
    let ab = b - a;
    let length_squared = ab.norm_squared();
    let t = if length_squared > 0.0 { ((p - a).dot(&ab) / length_squared).clamp(0.0, 1.0) } else { 0.0 };
    a + ab * t
}

/// Squared distance (m^2) from `p` to the segment from `a` to `b`.
pub fn squared_distance_to_segment(p: Point, a: Point, b: Point) -> f64 {
    (p - nearest_on_segment(p, a, b)).norm_squared()
}

/// Whether the segments `a b` and `c d` cross in a point inside both; touching is not crossing.
pub fn segments_cross(a: Point, b: Point, c: Point, d: Point) -> bool {
    let ab = b - a;
    let cd = d - c;
    cross(ab, c - a) * cross(ab, d - a) < 0.0 && cross(cd, a - c) * cross(cd, b - c) < 0.0
}

/// Whether the segments `a b` and `c d` cross or touch. An end within `tolerance` (m) of the line through
/// `c d` counts as on it.
pub fn segments_meet(a: Point, b: Point, c: Point, d: Point, tolerance: f64) -> bool {
    let (ab, cd) = (b - a, d - c);
    let near = tolerance * cd.norm();
    let side = |p: Point| Some(cross(cd, p - c)).filter(|s| s.abs() > near).unwrap_or(0.0);
    side(a) * side(b) <= 0.0 && cross(ab, c - a) * cross(ab, d - a) <= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_angles_wrap_into_the_half_open_turn() {
        use std::f64::consts::PI;
        assert_eq!(wrap_angle(PI), PI);
        assert!((wrap_angle(-PI) - PI).abs() < 1e-15);
        assert!((wrap_angle(5.0 * PI / 2.0) - PI / 2.0).abs() < 1e-15);
    }

    #[test]
    fn closed_form_touching_segments_do_not_cross() {
        let p = Point::new;
        assert!(segments_cross(p(0., -1.), p(0., 1.), p(-1., 0.), p(1., 0.)));
        assert!(!segments_cross(p(0., 0.), p(0., 1.), p(-1., 0.), p(1., 0.)));
        assert!(!segments_cross(p(2., -1.), p(2., 1.), p(-1., 0.), p(1., 0.)));
        assert!(segments_meet(p(0., 0.), p(0., 1.), p(-1., 0.), p(1., 0.), 1e-9));
        assert!(segments_meet(p(0., 1e-10), p(0., 1.), p(-1., 0.), p(1., 0.), 1e-9));
        assert!(!segments_meet(p(2., 0.), p(2., 1.), p(-1., 0.), p(1., 0.), 1e-9));
        assert!(!segments_meet(p(0., 0.1), p(0., 1.), p(-1., 0.), p(1., 0.), 1e-9));
    }
}
