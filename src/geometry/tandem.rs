//! The poses of a carried object and of its two carriers along a path.

use super::{Path, PlanarPose, Point, Vector, angle_of, direction};
use crate::math;

/// The length (m) of the path behind the object that is kept: the farthest that the robot's base may be
/// behind.
const TRAIL_LENGTH_M: f64 = 2.0;

/// Carriers round corners: each stands at the mean of the path points within this distance (m) behind and
/// ahead.
const ROUNDING_DISTANCE_M: f64 = 0.4;
const ROUND_POINTS: i32 = 3;

/// A rigid object that two carriers, one at each end, carry along paths.
///
/// The ends lie on the chord between the path points half a length ahead of and behind the object's centre. A
/// corner of the path therefore becomes a gradual turn. Behind the start of a path the earlier path
/// continues; beyond its end it continues straight.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Tandem {
    length: f64,
    /// The path walked before the present one, oldest point first. The last point is where the present path
    /// begins.
    trail: Vec<Point>,
}

impl Tandem {
    /// An object of this length (m) with its centre at `start`, aligned with `heading` (rad), as if it had
    /// come straight from behind.
    pub fn new(length: f64, start: Point, heading: f64) -> Self {
        Self { length, trail: vec![start - direction(heading) * (length + TRAIL_LENGTH_M), start] }
    }

    /// Length of the object, m.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The radius (m) of the arc of a path that turns by `sweep` (rad) round a corner such that the object's
    /// centre stays `distance` (m) away from the corner, apart from the effect of rounding. With l half the
    /// object's length and a half the sweep, the midpoint between the points l ahead and l behind is
    /// R cos(a) - (l - R a) sin(a) from the centre where these points are on the lines before and after the
    /// arc, and R cos(l / R) where they are on the arc.
    pub fn corner_radius(&self, sweep: f64, distance: f64) -> f64 {
        let (half, angle) = (self.length / 2.0, sweep / 2.0);
        let (sin, cos) = math::sin_cos(angle);
        let radius = (distance + half * sin) / (cos + angle * sin);
        if radius > 0.0 && radius * angle <= half {
            return radius;
        }
        // Newton's iteration from above, where it is monotone
        (0..8).fold(math::hypot(half, distance), |radius, _| {
            let (sin, cos) = math::sin_cos(half / radius);
            radius - (radius * cos - distance) / (cos + half / radius * sin)
        })
    }

    /// The point at arc length `walked` (m) of `path`: before its start if negative, beyond its end if more
    /// than its length.
    pub fn point(&self, path: &Path, walked: f64) -> Point {
        let here = self.trail.last().copied().unwrap_or_default();
        if walked >= 0.0 {
            let beyond = walked - path.length();
            let Some(point) = path.point_at(walked) else { return here };
            if beyond <= 0.0 {
                return point;
            }
            return point + direction(path.heading_at(walked).unwrap_or(0.0)) * beyond;
        }
        let mut left = -walked;
        let mut at = here;
        for &before in self.trail.iter().rev().skip(1) {
            let step = (before - at).norm();
            if step >= left && step > 0.0 {
                return at + (before - at) * (left / step);
            }
            left -= step;
            at = before;
        }
        at
    }

    /// The pose of the object's centre when it has come `walked` (m) along `path`.
    pub fn pose(&self, path: &Path, walked: f64) -> PlanarPose {
        self.pose_on(|walked| self.point(path, walked), walked)
    }

    /// The pose when the object leaves `path` at arc length `along` (m), turns onto `onward` and has come
    /// `walked` (m) along that.
    pub fn pose_after_turning(&self, path: &Path, along: f64, onward: &Path, walked: f64) -> PlanarPose {
        let point = |walked: f64| match walked < 0.0 {
            true => self.point(path, along + walked),
            false => self.point(onward, walked),
        };
        self.pose_on(point, walked)
    }

    fn pose_on(&self, point: impl Fn(f64) -> Point, walked: f64) -> PlanarPose {
        let round = |walked: f64| {
            let points = (-ROUND_POINTS..=ROUND_POINTS)
                .map(|i| point(walked + ROUNDING_DISTANCE_M * f64::from(i) / f64::from(ROUND_POINTS)).coords);
            Point::from(points.sum::<Vector>() / f64::from(2 * ROUND_POINTS + 1))
        };
        let behind = round(walked - self.length / 2.0);
        let ahead = round(walked + self.length / 2.0);
        PlanarPose { position: nalgebra::center(&behind, &ahead), yaw: angle_of(ahead - behind) }
    }

    /// The object's leading end (`side` 1) or trailing end (-1), for a pose of its centre.
    pub fn end(&self, pose: &PlanarPose, side: f64) -> PlanarPose {
        let reach = direction(pose.yaw) * (side * self.length / 2.0);
        PlanarPose { position: pose.position + reach, yaw: pose.yaw }
    }

    /// The arc length (m) between `low` and `high` on `path` at which the object's centre is nearest to
    /// `position`.
    pub fn locate(&self, path: &Path, position: Point, [low, high]: [f64; 2]) -> f64 {
        let distance = |walked: f64| (self.pose(path, walked).position - position).norm_squared();
        nearest_between([low, high.min(path.length()).max(low)], distance)
    }

    /// Records that the object leaves `path` at arc length `walked` (m), where another path begins.
    pub fn leave(&mut self, path: &Path, walked: f64) {
        const STEP: f64 = 0.02;
        let steps = ((self.length + TRAIL_LENGTH_M) / STEP).ceil() as usize;
        let trail: Vec<_> = (0..=steps).rev().map(|i| self.point(path, walked - STEP * i as f64)).collect();
        self.trail = trail;
    }
}

/// The arc length (m) within a range at which the distance is least.
pub fn nearest_between([least, most]: [f64; 2], distance: impl Fn(f64) -> f64) -> f64 {
    const SAMPLES: usize = 16;
    let (mut low, mut high, mut best) = (least, most, least);
    for _ in 0..3 {
        let step = (high - low) / SAMPLES as f64;
        let samples = (0..=SAMPLES).map(|i| low + step * i as f64);
        best = nearest(samples, &distance).unwrap_or(low);
        (low, high) = ((best - step).max(least), (best + step).min(high));
    }
    best
}

/// The candidate arc length (m) with the least distance; the first of equal ones.
pub fn nearest(ways: impl Iterator<Item = f64>, distance: impl Fn(f64) -> f64) -> Option<f64> {
    let distances = ways.map(|walked| (distance(walked), walked));
    distances.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, walked)| walked)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Piece;
    use std::f64::consts::FRAC_PI_2;

    fn corner() -> Path {
        let mut path = Path::default();
        path.line(Point::new(0.0, 0.0), Point::new(2.0, 0.0));
        path.line(Point::new(2.0, 0.0), Point::new(2.0, 2.0));
        path
    }

    #[test]
    fn closed_form_an_object_turns_gradually_round_a_corner() {
        let (tandem, path) = (Tandem::new(1.2, Point::origin(), 0.0), corner());
        let at_start = tandem.pose(&path, 0.0);
        assert!(at_start.position.coords.norm() < 1e-12 && at_start.yaw.abs() < 1e-12);
        let at_corner = tandem.pose(&path, 2.0);
        assert!((at_corner.position - Point::new(1.7, 0.3)).norm() < 1e-12);
        assert!((at_corner.yaw - std::f64::consts::FRAC_PI_4).abs() < 1e-12);
        let front = tandem.end(&at_corner, 1.0).position;
        assert!((front - tandem.end(&at_corner, -1.0).position).norm() - 1.2 < 1e-12);
        let at_end = tandem.pose(&path, 4.0);
        assert!((at_end.position - Point::new(2.0, 2.0)).norm() < 1e-12);
    }

    #[test]
    fn property_an_object_clears_a_corner_of_the_radius_that_it_needs() {
        let tandem = Tandem::new(1.2, Point::new(-3.0, 0.0), 0.0);
        // the least distance of the centre from the corner, for a path that turns with this radius
        let nearest = |sweep: f64, radius: f64| {
            let center = Point::new(0.0, radius);
            let mut path = Path::default();
            path.line(Point::new(-3.0, 0.0), Point::origin());
            path.push(Piece::Arc { center, radius, from_angle: -FRAC_PI_2, sweep });
            let leave = path.point_at(f64::INFINITY).unwrap();
            path.line(leave, leave + direction(sweep) * 3.0);
            let middles = (0..6000).map(|i| tandem.pose(&path, 1e-3 * f64::from(i)).position);
            middles.map(|middle| (middle - center).norm()).fold(f64::INFINITY, f64::min)
        };
        for sweep in [0.1, 0.7, 1.5, 2.2, 3.0] {
            for distance in [0.1, 0.2, 0.4] {
                let found = nearest(sweep, tandem.corner_radius(sweep, distance));
                assert!(
                    (distance - 0.09..distance + 0.01).contains(&found),
                    "{sweep}: {found} m, not {distance}"
                );
            }
        }
    }

    #[test]
    fn property_a_place_on_the_way_is_found_again() {
        let (tandem, path) = (Tandem::new(1.2, Point::origin(), 0.0), corner());
        for i in 0..40 {
            let walked = 0.1 * f64::from(i);
            let position = tandem.pose(&path, walked).position;
            for range in [[(walked - 0.1).max(0.0), walked + 0.3], [walked - 0.3, walked]] {
                let found = tandem.locate(&path, position, range);
                assert!((found - walked).abs() < 1e-3, "{walked}: {found}");
            }
        }
    }

    #[test]
    fn closed_form_the_way_behind_a_new_path_is_the_one_walked() {
        let (mut tandem, path) = (Tandem::new(1.2, Point::origin(), 0.0), corner());
        let (before, ahead) = (tandem.pose(&path, 2.5), tandem.pose(&path, 2.8));
        tandem.leave(&path, 2.5);
        let mut onward = Path::default();
        onward.line(Point::new(2.0, 0.5), Point::new(2.0, 2.0));
        // the path behind is kept in steps of a few centimetres
        assert!((tandem.pose(&onward, 0.0).position - before.position).norm() < 2e-3);
        assert!((tandem.pose(&onward, 0.3).position - ahead.position).norm() < 2e-3);
        assert_eq!(tandem.trail.len(), 161);
    }
}
