//! Lines tangent to circles, each circle passed on a given side.

use super::{Point, Vector, left_of};

/// A circle that a path bends around: counter-clockwise where the radius is positive, clockwise where it is
/// negative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bend {
    /// Its centre.
    pub center: Point,
    /// Its radius, m, with the sign of the turn.
    pub radius: f64,
}

impl Bend {
    /// The point where a line from `p` touches the circle such that the path continues in the circle's
    /// direction, and the line's length, m. From inside the circle the line leads radially outward.
    pub fn touch_from(&self, p: Point) -> (Point, f64) {
        let v = self.center - p;
        let squared = v.norm_squared();
        let line = squared - self.radius * self.radius;
        if line <= 0.0 {
            let distance = squared.sqrt();
            let out = if distance > 0.0 { -v / distance } else { Vector::x() };
            return (self.center + out * self.radius.abs(), self.radius.abs() - distance);
        }
        let line = line.sqrt();
        let along = (v * line - left_of(v) * self.radius) / squared;
        (p + along * line, line)
    }

    /// The point where a line to `p` leaves the circle.
    pub fn leave_to(&self, p: Point) -> Point {
        Self { radius: -self.radius, ..*self }.touch_from(p).0
    }

    /// The end points of the line that leaves this circle and touches the other. `None` where one circle
    /// covers the other.
    ///
    /// With v from centre to centre and k the difference of the radii, the unit direction u of the line
    /// satisfies v = L u + k left(u).
    pub fn line_to(&self, other: &Self) -> Option<[Point; 2]> {
        let v = other.center - self.center;
        let k = other.radius - self.radius;
        let squared = v.norm_squared();
        let line = squared - k * k;
        if line <= 0.0 || squared == 0.0 {
            return None;
        }
        let along = (v * line.sqrt() - left_of(v) * k) / squared;
        let left = left_of(along);
        Some([self, other].map(|bend| bend.center - left * bend.radius))
    }
}
