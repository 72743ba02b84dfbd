//! The solids that a mass and an inertia stand for.

use crate::math;
use nalgebra::Matrix3;
use std::f64::consts::PI;

/// Density of the ball in place of an inertia that is missing or impossible, kg/m^3: that of water.
const DENSITY: f64 = 1000.0;
/// What is said about it.
pub(super) const BALL: &str = "a ball of 1000 kg/m^3 stands in for it";
/// The largest radius of gyration of a link, m. Its mass would be as far from its middle.
pub(super) const MAX_GYRATION_M: f64 = 10.0;

/// Inertia of a ball of the density of water, kg m^2.
pub(super) fn ball_inertia(mass: f64) -> f64 {
    let radius = math::pow(3.0 * mass / (4.0 * PI * DENSITY), 1.0 / 3.0);
    0.4 * mass * radius * radius
}

/// The radius of gyration for the largest entry of an inertia, m; infinite without a mass.
pub(super) fn gyration(mass: f64, inertia: &Matrix3<f64>) -> f64 {
    if inertia.amax() == 0.0 { 0.0 } else { (inertia.amax() / mass).sqrt() }
}

/// The density of the ball of a mass and a radius of gyration, kg/m^3.
pub(super) fn ball_density(mass: f64, gyration: f64) -> f64 {
    let squared = 2.5 * gyration * gyration;
    3.0 * mass / (4.0 * PI * squared * squared.sqrt())
}

/// The largest principal moment of an inertia and the sum of the two others, where a body's mass would have to
/// be negative somewhere for it: the largest exceeds the sum by more than rounding in a file does.
pub(super) fn impossible(inertia: &Matrix3<f64>) -> Option<[f64; 2]> {
    const ROUNDING: f64 = 0.01;
    let moments = inertia.symmetric_eigenvalues();
    let largest = moments.max();
    let others = moments.sum() - largest;
    (largest > others + ROUNDING * largest.abs()).then_some([largest, others])
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn closed_form_a_ball_of_water() {
        // 4.18879 kg of water are a ball of 10 cm radius
        let mass = 4.0 / 3.0 * PI * 1e-3 * DENSITY;
        assert!((ball_inertia(mass) - 0.4 * mass * 0.01).abs() < 1e-12);
        let gyration = gyration(mass, &Matrix3::from_diagonal_element(ball_inertia(mass)));
        assert!((ball_density(mass, gyration) - DENSITY).abs() < 1e-9);
        assert_eq!(ball_inertia(0.0), 0.0);
    }

    #[test]
    fn closed_form_no_moment_exceeds_the_sum_of_the_others() {
        let of = |moments: [f64; 3]| impossible(&Matrix3::from_diagonal(&Vector3::from(moments)));
        assert_eq!(of([1.0, 1.0, 2.0]), None, "a thin plate");
        assert_eq!(of([1.0, 1.0, 2.01]), None, "a rounded plate");
        assert_eq!(of([0.0; 3]), None);
        assert_eq!(of([1.0, 3.0, 1.0]), Some([3.0, 2.0]));
    }
}
