//! The nominal trajectory s(t): poses along a path at a walking speed.

use crate::geometry::{Path, PlanarPose, wrap_angle};

/// The pose at each future tick of `period` (s) for a walker on `path` at `speed` (m/s), from arc length
/// `walked` (m) and heading `yaw` (rad).
///
/// The position is exactly on the path. The yaw turns toward the path's tangent at no more than `yaw_rate`
/// (rad/s), so that corners can be walked. At the path's end the walker stands still. An empty path gives no
/// poses.
pub fn nominal_trajectory(
    path: &Path,
    walked: f64,
    yaw: f64,
    speed: f64,
    yaw_rate: f64,
    period: f64,
) -> impl Iterator<Item = PlanarPose> + '_ {
    let mut yaw = yaw;
    (1..).map_while(move |t| {
        let walked = walked + speed * period * f64::from(t);
        let position = path.point_at(walked)?;
        yaw = turned(yaw, path.heading_at(walked)?, yaw_rate * period);
        Some(PlanarPose { position, yaw })
    })
}

/// The heading `yaw` (rad) turned toward `tangent` (rad) by at most `most` (rad).
pub fn turned(yaw: f64, tangent: f64, most: f64) -> f64 {
    wrap_angle(yaw + wrap_angle(tangent - yaw).clamp(-most, most))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    #[test]
    fn closed_form_a_corner_is_turned_at_the_yaw_rate() {
        let mut path = Path::default();
        path.line(Point::new(0.0, 0.0), Point::new(1.0, 0.0));
        path.line(Point::new(1.0, 0.0), Point::new(1.0, 5.0));
        let poses: Vec<_> = nominal_trajectory(&path, 0.0, 0.0, 0.5, 0.8, 0.2).take(40).collect();
        assert_eq!(poses.len(), 40);
        assert!((poses[4].position - Point::new(0.5, 0.0)).norm() < 1e-12);
        for pair in poses.windows(2) {
            assert!((pair[1].yaw - pair[0].yaw).abs() <= 0.16 + 1e-12);
            assert!((pair[1].position - pair[0].position).norm() <= 0.1 + 1e-12);
        }
        assert!((poses[25].yaw - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    }
}
