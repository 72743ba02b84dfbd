//! A path and a walking speed in; the nominal trajectory s(t), positions with yaw, out.

use crate::geometry::{Path, PlanarPose, wrap_angle};

/// The pose at each of `steps` ticks of `period` (s) after now, walking `path` at `speed` (m/s) from its beginning with heading `yaw` (rad).
///
/// The position is exactly on the path; the yaw turns toward the path's tangent at no more than `yaw_rate` (rad/s), so that corners are turned
/// at a walkable rate. At the path's end the pose stays. An empty path gives nothing.
pub fn nominal_trajectory(
    path: &Path,
    yaw: f64,
    speed: f64,
    yaw_rate: f64,
    period: f64,
    steps: usize,
) -> impl Iterator<Item = PlanarPose> + '_ {
    let most = yaw_rate * period;
    let mut yaw = yaw;
    (1..=steps).map_while(move |t| {
        let walked = speed * period * t as f64;
        let position = path.point_at(walked)?;
        let tangent = path.heading_at(walked)?;
        yaw = wrap_angle(yaw + wrap_angle(tangent - yaw).clamp(-most, most));
        Some(PlanarPose { position, yaw })
    })
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
        let poses: Vec<_> = nominal_trajectory(&path, 0.0, 0.5, 0.8, 0.2, 40).collect();
        assert_eq!(poses.len(), 40);
        assert!((poses[4].position - Point::new(0.5, 0.0)).norm() < 1e-12);
        for pair in poses.windows(2) {
            assert!((pair[1].yaw - pair[0].yaw).abs() <= 0.16 + 1e-12);
            assert!((pair[1].position - pair[0].position).norm() <= 0.1 + 1e-12);
        }
        assert!((poses[25].yaw - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    }
}
